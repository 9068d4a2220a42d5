/* SPDX-License-Identifier: MIT */
/*
 * What each owner holds of what the front has for all: connections, places to wait, bytes of
 * bodies. Of each kind there is a limit, of which an owner may have as much as is left
 * (`server/share.h`), and no more than a bound of its own. An owner is there as long as it holds
 * something. Any thread.
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

/* That much of each kind for all. NULL without memory. */
struct shares *shares_new(const int64_t limits[SHARES_KINDS]);
/* Nobody may hold anything. NULL is allowed. */
void shares_free(struct shares *shares);

/* Whether the owner may have `amount` > 0 besides: it has no more than `most` of that kind then,
 * and no more than is left. */
bool shares_fit(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount,
                int64_t most);

/* Takes it if it fits. False: nothing was taken, for that reason or without memory. */
bool shares_take(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount,
                 int64_t most);

/* Takes more for the owner's only piece, which is `held` now and may have any size, but that beside
 * others' a part of the limit is kept for small ones. False as above, or when the owner has others.
 */
enum { SHARES_KEPT = 16 };
bool shares_grow(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount,
                 int64_t held);

/* Takes it whether it fits or not. False without memory. */
bool shares_add(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount);

/* Gives back what was taken. */
void shares_give(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount);

/* What the owner holds now. */
int64_t shares_of(struct shares *shares, const char *owner, enum shares_kind kind);

/* What is left of the limit; below zero when more was added. */
int64_t shares_left(struct shares *shares, enum shares_kind kind);

#endif
