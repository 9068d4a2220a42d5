/* SPDX-License-Identifier: MIT */
/*
 * A child process as its owner sees it: start it, wait for it, bound it, end it. What is said on
 * its socket is `frame.h`. The child is the running binary itself, with a socket on WORKER_FD,
 * nothing on its other descriptors, no environment, default signals and a process group of its own
 * (so that Ctrl-C is the daemon's to handle). It is a copy of the fork server (`fork_server.h`) and
 * lives as long as that is open at the most. Without a fork server it is started as a program and
 * dies with the thread that started it, which must live as long as it.
 */
#ifndef SERVER_WORK_CHILD_H
#define SERVER_WORK_CHILD_H

#include "frame.h"
#include <sys/types.h>

enum { CHILD_WHY_SIZE = 96, CHILD_PATH_SIZE = 4096 };

/* Zero-initialised: not running. One thread's. */
struct child {
    pid_t pid; /* 0: not running */
    int socket;
    struct frame_inbox inbox;
};

/* The path of a program beside the running one. */
void child_beside(const char *program, char path[CHILD_PATH_SIZE]);

/* Starts `program`, or a child as above where that is NULL, as `draped ARGUMENT`; it must not be
 * running. False with a line in the log. */
bool child_start(struct child *child, const char *program, const char *argument);

bool child_running(const struct child *child);

/* Waits until its socket is ready for `events` (poll(2)), something is written to `wake` (an
 * eventfd, non-blocking, which is emptied; -1: none) or `ms` are over. Whether `wake` was written
 * to. */
bool child_wait(const struct child *child, short events, int wake, int64_t ms);

/* As `sandbox_bound`; what the system refuses is said in the log. */
bool child_bound(const struct child *child, int resource, uint64_t value);

/* Lets it have a processor only after what is so much less nice, this process included: its
 * niceness is `steps` above this one's. */
void child_lower(const struct child *child, int steps);

/* Kills it and waits for its end. Harmless when it is not running. */
void child_kill(struct child *child);

/* After its socket closed: waits for its end (killing it if that does not come soon) and says how
 * it went, such as "signal 11 (Segmentation fault)". */
void child_reap(struct child *child, char why[CHILD_WHY_SIZE]);

#endif
