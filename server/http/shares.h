/* SPDX-License-Identifier: MIT */
/*
 * What each owner holds of what the front has for all: connections, places to wait, bytes of
 * bodies. An owner is there as long as it holds something. Any thread.
 */
#ifndef SERVER_HTTP_SHARES_H
#define SERVER_HTTP_SHARES_H

#include <stdbool.h>
#include <stdint.h>

enum shares_kind {
    SHARES_CONNECTIONS,
    SHARES_STREAMS, /* event streams, and calls that wait for a drape */
    SHARES_BODIES,  /* bytes of bodies that are being received or read */
    SHARES_KINDS
};

struct shares;

/* NULL without memory. */
struct shares *shares_new(void);
/* Nobody may hold anything. NULL is allowed. */
void shares_free(struct shares *shares);

/* Takes `amount` > 0 for the owner if it has no more than `most` of that kind then. False: nothing
 * was taken, for that reason or without memory. */
bool shares_take(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount,
                 int64_t most);

/* Gives back what was taken. */
void shares_give(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount);

/* What the owner holds now. */
int64_t shares_of(struct shares *shares, const char *owner, enum shares_kind kind);

#endif
