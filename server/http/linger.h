/* SPDX-License-Identifier: MIT */
/*
 * Lets go of a connection whose client is still sending, without losing the answer. Closing at once
 * would make the kernel answer the unread bytes with a reset, and a client that meets the reset
 * while it still writes never looks at the answer. So the sending side is closed, what arrives is
 * thrown away for a short while, and then all is closed (RFC 9112, section 9.6).
 */
#ifndef SERVER_HTTP_LINGER_H
#define SERVER_HTTP_LINGER_H

struct linger_pool;

/* Starts the thread that reads. NULL when it cannot. */
struct linger_pool *linger_start(void);

/* Takes a duplicate of the socket, which the caller goes on to close as usual. Any thread. When
 * many are lingering already, nothing happens. */
void linger_add(struct linger_pool *pool, int socket);

/* Closes what is left. NULL is allowed. */
void linger_stop(struct linger_pool *pool);

#endif
