/* SPDX-License-Identifier: MIT */
/*
 * Where children come from. To start a program costs some 10 ms of a processor, nearly all of it
 * for finding the functions of three dozen libraries; workers are replaced with every change of
 * owner. So one process, the fork server, is started that way, `draped fork-server`, and every
 * child is a copy of it (fork), made in some 0.3 ms. The fork server reads nothing but orders of
 * the daemon, so that a copy has nothing of any caller. Its copies are children of the daemon
 * itself (CLONE_PARENT), which waits for them and knows their ends.
 *
 * Copies have the same addresses and stack protector, of which one that crashes may tell somebody
 * who tries again and again: after a crash another fork server takes its place
 * (`fork_server_renew`).
 *
 * One a process. Without it, as in builds with sanitizers, children are started as programs.
 */
#ifndef SERVER_WORK_FORK_SERVER_H
#define SERVER_WORK_FORK_SERVER_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#define FORK_SERVER_ARGUMENT "fork-server"

/* What a copy does: `main` is what the program would do if it were started with the argument, which
 * is no longer than FORK_SERVER_ARGUMENT. */
struct fork_server_role {
    const char *argument;
    int (*main)(void);
};

/* Starts the fork server, and a thread that lives until `fork_server_close`: as long as that the
 * copies do. False, with a line in the log, when it cannot be had. */
bool fork_server_open(void);

/* Ends it; there must be no copy left. Harmless when it is not open. */
void fork_server_close(void);

/* Makes a copy with that role and the socket as its WORKER_FD, in a process group of its own. False
 * when there is no fork server, or it has gone. Any thread. */
bool fork_server_fork(const char *argument, int socket, pid_t *pid);

/* A copy has crashed. Any thread. */
void fork_server_renew(void);

/* What `draped fork-server` does; `argv` is of `main`. Returns the exit code when the daemon is
 * gone.
 */
int fork_server_serve(char **argv, const struct fork_server_role *roles, size_t count);

#endif
