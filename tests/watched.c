/* SPDX-License-Identifier: MIT */
/*
 * Preloaded into a daemon that is watched, by the counters of coverage or by valgrind. Both say
 * what they saw when a process ends, but a worker is in a sandbox without files and ends by
 * SIGKILL. So the filter of system calls and the limits of files are left out, the worker is
 * started by its own name, with the daemon's environment, and instead of being killed it ends.
 */
#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdbool.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { END = 40, PATH_SIZE = 4096 }; /* a real-time signal that nothing else uses */

extern void __gcov_dump(void) __attribute__((weak)); /* only in programs that count */

static bool is_daemon; /* or its worker: what else is preloaded is not changed */

static void end(int number) {
    (void)number;
    if (__gcov_dump)
        __gcov_dump();
    _exit(0);
}

__attribute__((constructor)) static void begin(void) {
    is_daemon = !strcmp(program_invocation_short_name, "draped");
    if (is_daemon)
        signal(END, end);
}

/* A stopped process has to go on to end. */
int kill(pid_t pid, int number) {
    if (!is_daemon || number != SIGKILL)
        return (int)syscall(SYS_kill, pid, number);
    return (int)(syscall(SYS_kill, pid, END) | syscall(SYS_kill, pid, SIGCONT));
}

int posix_spawn(pid_t *pid, const char *path, const posix_spawn_file_actions_t *files,
                const posix_spawnattr_t *attributes, char *const arguments[],
                char *const environment[]) {
    char own[PATH_SIZE] = "";
    if (!is_daemon)
        return posix_spawnp(pid, path, files, attributes, arguments, environment);
    if (readlink(path, own, sizeof own - 1) < 0)
        return errno;
    return posix_spawnp(pid, own, files, attributes, arguments, environ);
}

int setrlimit(__rlimit_resource_t resource, const struct rlimit *limit) {
    if (is_daemon && (resource == RLIMIT_FSIZE || resource == RLIMIT_NOFILE))
        return 0;
    return (int)syscall(SYS_prlimit64, 0, resource, limit, NULL);
}

int seccomp_load(void *filter) {
    (void)filter;
    return 0;
}
