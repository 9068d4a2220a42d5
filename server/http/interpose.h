/* SPDX-License-Identifier: MIT */
/*
 * Three functions that libmicrohttpd calls through the dynamic linker, which finds ours first
 * (ld.so(8): the program comes before its libraries). libmicrohttpd has no option for what they do.
 *
 * `MHD_queue_response`: the library answers what it cannot parse, or has no memory for, with HTML
 * pages of its own. It queues them by this public function, so that ours sees the status before the
 * page is sent and answers with a problem. The call has to go through to the library all the same:
 * when it fails, the library frees the request and then goes on to parse it.
 *
 * `recv`: the bytes of a connection are checked here, in place, before the library parses them. A
 * short count makes it wait for more; -1 with ECONNRESET makes it close the connection. Other ways
 * cost a system call for every read (MSG_PEEK), or two and the peer's address (a socket pair handed
 * over by MHD_add_connection).
 *
 * `epoll_ctl`: when the front stops to listen, the library takes its listening socket out of the
 * set of each thread, and so does a thread that wakes in that moment, without a lock between them
 * (MHD_quiesce_daemon and MHD_epoll); whoever comes second would end the program. Here it is no
 * fault.
 *
 * Checked with 0.9.75 (Debian 12). A version that does not call them through the linker
 * (-Bsymbolic, an internal alias, io_uring, readv) would show at the first request, because the
 * front answers none whose head was not checked; tests/faults/test_framing.py has a case for every
 * status that the library makes by itself. The linker exports the functions because a shared
 * library refers to them.
 */
#ifndef SERVER_HTTP_INTERPOSE_H
#define SERVER_HTTP_INTERPOSE_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

struct MHD_Connection;
struct MHD_Response;

struct interpose_hooks {
    /* Called on the connection's thread when the library is about to answer by itself. */
    void (*page)(struct MHD_Connection *connection, unsigned status);

    /* Called for bytes that were read from a watched socket: how many of them the library gets; -1
     * with errno for none and the end of the connection. */
    ssize_t (*received)(void *context, const char *bytes, size_t length);
};

/* Before the library's daemon is started, once, with the number of descriptors that the process may
 * have. False when the library's functions are not found, or without memory. */
bool interpose_init(const struct interpose_hooks *hooks, size_t descriptors);

/* From now on what is read from the socket is checked with this context; NULL: no more. False for a
 * descriptor that is too large. On the connection's thread. */
bool interpose_watch(int socket, void *context);

/* The library's own MHD_queue_response: false when the reply cannot be queued. */
bool interpose_queue(struct MHD_Connection *connection, unsigned status,
                     struct MHD_Response *response);

#endif
