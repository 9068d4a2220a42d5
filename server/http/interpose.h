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
 * Replies of our own are queued by `interpose_queue`, which is the library's function.
 */
#ifndef SERVER_HTTP_INTERPOSE_H
#define SERVER_HTTP_INTERPOSE_H

#include <stdbool.h>

struct MHD_Connection;
struct MHD_Response;

/* Called on the connection's thread when the library is about to answer by itself. */
typedef void interpose_page(struct MHD_Connection *connection, unsigned status);

/* Before the library's daemon is started. False when its functions are not found. */
bool interpose_init(interpose_page *page);

/* The library's own MHD_queue_response: false when the reply cannot be queued. */
bool interpose_queue(struct MHD_Connection *connection, unsigned status,
                     struct MHD_Response *response);

#endif
