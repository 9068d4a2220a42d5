/* SPDX-License-Identifier: MIT */
/*
 * Lets go of a connection whose client is still sending, without losing the answer. Closing at once
 * would make the kernel answer the unread bytes with a reset, and a client that meets the reset
 * while it still writes never looks at the answer. So the sending side is closed, what arrives is
 * thrown away for a short while, and then all is closed (RFC 9112, section 9.6).
 */
#ifndef SERVER_HTTP_LINGERING_CLOSE_H
#define SERVER_HTTP_LINGERING_CLOSE_H

struct lingering_close;

/* Starts the thread that reads. NULL when it cannot. */
struct lingering_close *lingering_close_start(void);

/* Takes a duplicate of the socket, which the caller goes on to close as usual. Any thread. When
 * many are lingering already, nothing happens. */
void lingering_close_add(struct lingering_close *pool, int socket);

/* Closes what is left. NULL is allowed. */
void lingering_close_stop(struct lingering_close *pool);

#endif
