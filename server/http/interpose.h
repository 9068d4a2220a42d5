/* SPDX-License-Identifier: MIT */
/*
 * What libmicrohttpd has no option for: the functions of the C library and of its own that it calls
 * through the dynamic linker, which finds ours first because the program comes before its libraries
 * in the order of symbol look-up (ld.so(8)).
 *
 * `MHD_queue_response`. The library answers what it cannot parse, or has no memory for, with HTML
 * pages of its own; there is no option to replace them. It queues them by its public function, so
 * that the one defined here sees the status before the page is sent. What hangs on the version:
 *
 *   0.9.75 (Debian 12, the one tested)  src/microhttpd/connection.c, transmit_error_response_len:
 *       calls MHD_queue_response through the PLT. The call must go through to the library even when
 *       the answer was written to the socket already: when it fails, the library frees the request
 *       and then goes on to parse it.
 *   a version linked with -Bsymbolic, or that calls an internal alias
 *       would never call ours, and send its HTML page. tests/faults/framing.cases has a case for
 *       every status that the library makes by itself, and expects a problem document.
 *
 * `recv`. The library reads sockets with it, and so the bytes of a connection pass through ours on
 * their way into the library's memory: checked in place, without a copy or a further system call.
 * (The alternatives: MSG_PEEK, one more system call for every read; a socket pair with a thread of
 * ours in front, two more of each and no peer address; a parser of ours in place of the library.)
 *
 *   0.9.75  src/microhttpd/mhd_send.c and connection.c, recv_param_adapter: calls recv through the
 *       PLT, on the thread of the connection, for plain TCP only. A short count makes it wait for
 *       the socket to become readable again; -1 with ECONNRESET makes it close the connection.
 *   a version that reads by other functions (io_uring, readv)
 *       would pass the check by. The front answers no request whose head was not checked, so that
 *       this is seen at the first request.
 *
 * `epoll_ctl`. A file that is taken out of a set and is not in it is no fault. When the front stops
 * to listen, the library takes its listening socket out of the set of each of its threads, and so
 * does a thread that wakes in that moment; whoever comes second would end the program.
 *
 *   0.9.75  src/microhttpd/daemon.c, MHD_quiesce_daemon and MHD_epoll: no lock between them.
 *
 * All need the functions here to be in the dynamic symbol table of the program; the linker exports
 * them by itself because a shared library that is linked refers to them.
 * tests/faults/test_framing.py fails without.
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
