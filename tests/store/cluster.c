/* SPDX-License-Identifier: MIT */
#include "cluster.h"
#include "scratch.h"
#include "server/clock.h"
#include <fcntl.h>
#include <glob.h>
#include <grp.h>
#include <pwd.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

enum { START_MS = 60000 };

/* Debian keeps each major version in a folder; the last is the newest. */
static void find_program(const char *name, char path[128]) {
    glob_t found;
    snprintf(path, 128, name[0] == '/' ? "%s" : "/usr/lib/postgresql/*/bin/%s", name);
    if (glob(path, 0, NULL, &found) != 0)
        fail_msg("there is no %s: deploy/setup.sh test installs it", path);
    snprintf(path, 128, "%s", found.gl_pathv[found.gl_pathc - 1]);
    globfree(&found);
}

/* The server refuses to run as root. */
static void become_postgres(void) {
    const struct passwd *user = geteuid() == 0 ? getpwnam("postgres") : NULL;
    if (user && (setgroups(0, NULL) != 0 || setgid(user->pw_gid) != 0 || setuid(user->pw_uid) != 0))
        _exit(126);
}

pid_t cluster_spawn(const struct cluster *cluster, const char *name, const char *const *arguments) {
    char path[128];
    char log[128];
    find_program(name, path);
    snprintf(log, sizeof log, "%s/log", cluster->folder);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid > 0)
        return pid;
    become_postgres();
    prctl(PR_SET_PDEATHSIG, SIGINT);
    int file = open(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    if (file < 0 || dup2(file, 1) < 0 || dup2(file, 2) < 0 || chdir(cluster->folder) != 0)
        _exit(126);
    setenv("LC_ALL", "C.UTF-8", 1);
    execv(path, (char *const *)(uintptr_t)arguments);
    _exit(127);
}

void cluster_run(const struct cluster *cluster, const char *name, const char *const *arguments) {
    int status = 0;
    pid_t pid = cluster_spawn(cluster, name, arguments);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    if (status != 0)
        fail_msg("%s ended with status %d", name, status);
}

void cluster_url(const struct cluster *cluster, const char *user, const char *password,
                 const char *database, char url[CLUSTER_URL_SIZE]) {
    snprintf(url, CLUSTER_URL_SIZE, "postgresql://%s:%s@/%s?host=%s", user, password, database,
             cluster->folder);
}

/* Waits until it can be talked to, by its own means. */
void cluster_resume(struct cluster *cluster) {
    const char *const serve[] = {
        "postgres",          "-D", "data",      "-k", cluster->folder,       "-c",
        "listen_addresses=", "-c", "fsync=off", "-c", "max_connections=100", NULL};
    const char *const ask[] = {"pg_isready", "-q", "-h", cluster->folder, "-d", "postgres", NULL};
    int64_t until = clock_ms() + START_MS;
    int status = 1;
    cluster->pid = cluster_spawn(cluster, "postgres", serve);
    while (status != 0 && clock_ms() < until) {
        scratch_sleep(20);
        pid_t pid = cluster_spawn(cluster, "pg_isready", ask);
        assert_int_equal(waitpid(pid, &status, 0), pid);
    }
    assert_int_equal(status, 0);
}

static void set_password(const struct cluster *cluster) {
    char path[128];
    snprintf(path, sizeof path, "%s/password", cluster->folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(CLUSTER_PASSWORD, file);
    fclose(file);
}

void cluster_own(const struct cluster *cluster, const char *name) {
    char path[128];
    const struct passwd *user = getpwnam("postgres");
    snprintf(path, sizeof path, "%s/%s", cluster->folder, name);
    if (geteuid() == 0 && user)
        assert_int_equal(chown(path, user->pw_uid, user->pw_gid), 0);
}

void cluster_start(struct cluster *cluster) {
    const char *const make[] = {"initdb", "-D", "data",          "-U",
                                "draped", "-A", "scram-sha-256", "--pwfile=password",
                                "-N",     "-E", "UTF8",          NULL};
    memset(cluster, 0, sizeof *cluster);
    snprintf(cluster->folder, sizeof cluster->folder, "/tmp/draped-cluster-XXXXXX");
    assert_non_null(mkdtemp(cluster->folder));
    set_password(cluster);
    cluster_own(cluster, "password");
    cluster_own(cluster, "");
    cluster_run(cluster, "initdb", make);
    cluster_resume(cluster);
    setenv("PGPASSWORD", CLUSTER_PASSWORD, 1);
    const char *const create[] = {"createdb", "-h", cluster->folder, "-U", "draped",
                                  "draped",   NULL};
    cluster_run(cluster, "createdb", create);
    unsetenv("PGPASSWORD");
    cluster_url(cluster, "draped", "se%2Fcr%40t%251", "draped", cluster->url);
}

void cluster_halt(struct cluster *cluster, int hard) {
    if (!cluster->pid)
        return;
    kill(cluster->pid, hard ? SIGQUIT : SIGINT);
    waitpid(cluster->pid, NULL, 0);
    cluster->pid = 0;
}

void cluster_remove(struct cluster *cluster) {
    char command[128];
    cluster_halt(cluster, 0);
    snprintf(command, sizeof command, "rm -rf %s", cluster->folder);
    assert_int_equal(system(command), 0);
}
