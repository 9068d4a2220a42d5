/* SPDX-License-Identifier: MIT */
#include "child.h"
#include "fork_server.h"
#include "sandbox.h"
#include "server/log.h"
#include "worker.h"
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum {
    REAP_MS = 500, /* a process whose socket closed is nearly dead */
    REAP_STEP_MS = 2,
    WAIT_MAX_MS = 60000 /* poll takes no more than an int of milliseconds */
};

/* Sanitizers report on stderr and are configured by the environment; a release worker has
 * neither, since its output would get into the daemon's log unescaped. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { KEEP_STDERR = 1 };
#else
enum { KEEP_STDERR = 0 };
#endif

void child_beside(const char *program, char path[CHILD_PATH_SIZE]) {
    ssize_t length = readlink("/proc/self/exe", path, CHILD_PATH_SIZE);
    char *slash = length > 0 ? memrchr(path, '/', (size_t)length) : NULL;
    size_t folder = slash ? (size_t)(slash - path) + 1 : 0;
    snprintf(path + folder, CHILD_PATH_SIZE - folder, "%s", program);
}

/* Starts it as a program. 0 or an errno. */
static int spawn(const char *program, int socket, const char *argument, pid_t *pid) {
    static char name[] = "draped";
    char *const arguments[] = {name, strdupa(argument), NULL};
    char *const empty[] = {NULL};
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t all, none;
    sigfillset(&all);
    sigemptyset(&none);
    int code = posix_spawn_file_actions_init(&files);
    if (code != 0)
        return code;
    code = posix_spawn_file_actions_adddup2(&files, socket, WORKER_FD);
    for (int fd = 0; fd <= (KEEP_STDERR ? 1 : 2) && code == 0; fd++)
        code = posix_spawn_file_actions_addopen(&files, fd, "/dev/null", O_RDWR, 0);
    if (code == 0)
        code = posix_spawn_file_actions_addclosefrom_np(&files, WORKER_FD + 1);
    if (code == 0 && (code = posix_spawnattr_init(&attributes)) == 0) {
        /* these fail for bad values alone */
        (void)posix_spawnattr_setsigdefault(&attributes, &all);
        (void)posix_spawnattr_setsigmask(&attributes, &none);
        (void)posix_spawnattr_setpgroup(&attributes, 0);
        (void)posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK |
                                                        POSIX_SPAWN_SETPGROUP);
        code = posix_spawn(pid, program ? program : "/proc/self/exe", &files, &attributes,
                           arguments, KEEP_STDERR ? environ : empty);
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&files);
    return code;
}

bool child_start(struct child *child, const char *program, const char *argument) {
    int pair[2];
    int code = socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) == 0 ? 0 : errno;
    if (code == 0) {
        bool copied = !program && fork_server_fork(argument, pair[1], &child->pid);
        code = copied ? 0 : spawn(program, pair[1], argument, &child->pid);
        close(pair[1]);
        child->socket = pair[0];
        child->inbox.have = 0;
        if (code == 0)
            return true;
        close(pair[0]);
    }
    log_error(log_event("worker_start_failed"), log_text("detail", strerror(code)));
    child->pid = 0;
    child->socket = -1;
    return false;
}

bool child_running(const struct child *child) {
    return child->pid != 0;
}

bool child_wait(const struct child *child, short events, int wake, int64_t ms) {
    struct pollfd files[2] = {{.fd = child->socket, .events = events},
                              {.fd = wake, .events = POLLIN}};
    uint64_t count = 0;
    int wait = ms < 0 ? 0 : ms < WAIT_MAX_MS ? (int)ms : WAIT_MAX_MS;
    return poll(files, 2, wait) > 0 && files[1].revents &&
           read(wake, &count, sizeof count) == (ssize_t)sizeof count;
}

bool child_bound(const struct child *child, int resource, uint64_t value) {
    bool good = sandbox_bound(child->pid, resource, value);
    if (!good)
        log_error(log_event("child_not_bounded"), log_text("detail", strerror(errno)));
    return good;
}

void child_lower(const struct child *child, int steps) {
    setpriority(PRIO_PROCESS, (id_t)child->pid, getpriority(PRIO_PROCESS, 0) + steps);
}

/* After its end. */
static void forget_child(struct child *child) {
    close(child->socket);
    child->pid = 0;
    child->socket = -1;
}

void child_kill(struct child *child) {
    if (!child_running(child))
        return;
    kill(child->pid, SIGKILL);
    (void)TEMP_FAILURE_RETRY(waitpid(child->pid, NULL, 0));
    forget_child(child);
}

void child_reap(struct child *child, char why[CHILD_WHY_SIZE]) {
    static const struct timespec step = {.tv_nsec = REAP_STEP_MS * 1000000L};
    int status = 0;
    pid_t ended = 0;
    for (int waited = 0; ended == 0 && waited < REAP_MS; waited += REAP_STEP_MS) {
        ended = waitpid(child->pid, &status, WNOHANG);
        if (ended == 0)
            nanosleep(&step, NULL);
    }
    if (ended == 0) {
        kill(child->pid, SIGKILL);
        (void)TEMP_FAILURE_RETRY(waitpid(child->pid, &status, 0));
    }
    int number = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    if (number)
        snprintf(why, CHILD_WHY_SIZE, "signal %d (%s)", number,
                 sigdescr_np(number) ? sigdescr_np(number) : "unknown");
    else
        snprintf(why, CHILD_WHY_SIZE, "exit with code %d", WEXITSTATUS(status));
    forget_child(child);
    if (number && number != SIGKILL)
        fork_server_renew();
}
