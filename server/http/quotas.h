/* SPDX-License-Identifier: MIT */
/*
 * What each owner holds of what the front has for all: connections, waiting calls, bytes of bodies.
 * Each kind has a limit, of which an owner may have as much as is left (`server/share.h`), and no
 * more than a bound of its own. An owner is known as long as it holds something. Any thread.
 */
#ifndef SERVER_HTTP_QUOTAS_H
#define SERVER_HTTP_QUOTAS_H

#include <stdbool.h>
#include <stdint.h>

enum quotas_kind {
    QUOTAS_CONNECTIONS,
    QUOTAS_STREAMS, /* event streams, and calls that wait for a drape */
    QUOTAS_BODIES,  /* bytes of bodies that are being received or read */
    QUOTAS_KINDS
};

struct quotas;

/* That much of each kind for all. NULL without memory. */
struct quotas *quotas_new(const int64_t limits[QUOTAS_KINDS]);
/* Nobody may hold anything. NULL is allowed. */
void quotas_free(struct quotas *quotas);

/* Whether the owner may have `amount` > 0 besides: it has no more than `most` of that kind then,
 * and no more than is left. */
bool quotas_fit(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount,
                int64_t most);

/* Takes it if it fits. False: nothing was taken, for that reason or without memory. */
bool quotas_take(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount,
                 int64_t most);

/* Takes more for the owner's only piece, which is `held` now and may have any size, but that beside
 * others' a part of the limit is kept for small ones. False as above, or when the owner has others.
 */
enum { QUOTAS_KEPT = 16 };
bool quotas_grow(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount,
                 int64_t held);

/* Takes it whether it fits or not. False without memory. */
bool quotas_add(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount);

/* Gives back what was taken. */
void quotas_give(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount);

/* What the owner holds now. */
int64_t quotas_of(struct quotas *quotas, const char *owner, enum quotas_kind kind);

/* What is left of the limit; below zero when more was added. */
int64_t quotas_left(struct quotas *quotas, enum quotas_kind kind);

#endif
