/* SPDX-License-Identifier: MIT */
/*
 * The sandbox of a worker process. An attacker who takes over the solver by a request has a process
 * with one socket, no files, no rights to be gained, and a kernel that answers EPERM to all but
 * what solving takes: memory, threads, clocks, the socket's two directions. What is refused fails
 * instead of killing, because the C library tries some calls for convenience and goes on without
 * them.
 */
#ifndef SERVER_WORK_SANDBOX_H
#define SERVER_WORK_SANDBOX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/* Sanitizers reserve terabytes of address space, open /proc to report, trace the process at its end
 * and write to standard error: builds with them keep that, and are as closed as the others for
 * sockets and programs. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { SANDBOX_SANITIZED = 1 };
#else
enum { SANDBOX_SANITIZED = 0 };
#endif

/* Locks the calling process, which must have one thread, in for good: closes all descriptors but
 * `socket`; no core dumps, no files, no new privileges; not to be traced; and the filter of system
 * calls. It may have as many `files` at a time as come over the socket, and write to those; with 0
 * to none. False when the kernel does not provide it: then no job must be taken. */
bool sandbox_enter(int socket, int files) __attribute__((warn_unused_result));

/* What every child does before it reads anything: no life without the daemon, no signals that a
 * broken pipe or a full file would end it with, and `sandbox_enter`. What it frees stays with the
 * process up to `kept` bytes: to ask the system for it again, page by page, costs a sixth of a
 * drape's time. */
bool sandbox_begin(int socket, int files, size_t kept) __attribute__((warn_unused_result));

/* Bounds a resource (RLIMIT_AS, ...) of such a process, from outside: it has no system call to
 * raise the bound again. The hard limit is left alone, because to raise that takes a right that the
 * daemon does not have. False, with errno, when the system refuses. */
bool sandbox_bound(pid_t pid, int resource, uint64_t value) __attribute__((warn_unused_result));

/* Sets the hard limit, up to which `sandbox_bound` may go; it is never raised again. */
bool sandbox_bound_for_good(pid_t pid, int resource, uint64_t value)
    __attribute__((warn_unused_result));

/* What a process has used of processors so far, in microseconds; -1 when it has gone. */
int64_t sandbox_processor_us(pid_t pid);

/* Bounds its processor time from now on, all threads together; beyond it the kernel ends the
 * process (SIGXCPU). */
bool sandbox_bound_processor(pid_t pid, uint64_t seconds) __attribute__((warn_unused_result));

#endif
