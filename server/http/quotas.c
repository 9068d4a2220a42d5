/* SPDX-License-Identifier: MIT */
#include "quotas.h"
#include "request.h"
#include "server/share.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BUCKETS = 1024 };

struct share {
    char owner[REQUEST_CALLER_SIZE];
    int64_t held[QUOTAS_KINDS];
    struct share *next;
};

struct quotas {
    int64_t limits[QUOTAS_KINDS];
    pthread_mutex_t lock; /* what is below */
    int64_t taken[QUOTAS_KINDS];
    struct share *buckets[BUCKETS];
};

struct quotas *quotas_new(const int64_t limits[QUOTAS_KINDS]) {
    struct quotas *quotas = calloc(1, sizeof *quotas);
    if (!quotas)
        return NULL;
    memcpy(quotas->limits, limits, sizeof quotas->limits);
    pthread_mutex_init(&quotas->lock, NULL);
    return quotas;
}

void quotas_free(struct quotas *quotas) {
    if (!quotas)
        return;
    pthread_mutex_destroy(&quotas->lock);
    free(quotas);
}

/* Where the owner's entry is or would be. With the lock. */
static struct share **find_share(struct quotas *quotas, const char *owner) {
    struct share **at = &quotas->buckets[id_hash(owner) % BUCKETS];
    while (*at && strcmp((*at)->owner, owner) != 0)
        at = &(*at)->next;
    return at;
}

static int64_t held_at(struct share *const *at, enum quotas_kind kind) {
    return *at ? (*at)->held[kind] : 0;
}

/* With the lock, like the next ones. */
static bool share_has_room(const struct quotas *quotas, struct share *const *at,
                           enum quotas_kind kind, int64_t amount, int64_t most) {
    int64_t held = held_at(at, kind);
    return held + amount <= most &&
           share_fits(held, quotas->taken[kind], quotas->limits[kind], amount);
}

/* False without memory. */
static bool take_amount(struct quotas *quotas, struct share **at, const char *owner,
                        enum quotas_kind kind, int64_t amount) {
    if (!*at) {
        *at = calloc(1, sizeof **at);
        if (!*at)
            return false;
        snprintf((*at)->owner, sizeof(*at)->owner, "%s", owner);
    }
    (*at)->held[kind] += amount;
    quotas->taken[kind] += amount;
    return true;
}

bool quotas_fit(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount,
                int64_t most) {
    pthread_mutex_lock(&quotas->lock);
    bool good = share_has_room(quotas, find_share(quotas, owner), kind, amount, most);
    pthread_mutex_unlock(&quotas->lock);
    return good;
}

bool quotas_take(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount,
                 int64_t most) {
    pthread_mutex_lock(&quotas->lock);
    struct share **at = find_share(quotas, owner);
    bool good = share_has_room(quotas, at, kind, amount, most) &&
                take_amount(quotas, at, owner, kind, amount);
    pthread_mutex_unlock(&quotas->lock);
    return good;
}

bool quotas_grow(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount,
                 int64_t held) {
    pthread_mutex_lock(&quotas->lock);
    struct share **at = find_share(quotas, owner);
    int64_t taken = quotas->taken[kind], limit = quotas->limits[kind];
    int64_t kept = taken == held ? 0 : limit / QUOTAS_KEPT;
    bool good = held_at(at, kind) == held && taken + amount <= limit - kept &&
                take_amount(quotas, at, owner, kind, amount);
    pthread_mutex_unlock(&quotas->lock);
    return good;
}

bool quotas_add(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount) {
    pthread_mutex_lock(&quotas->lock);
    bool good = take_amount(quotas, find_share(quotas, owner), owner, kind, amount);
    pthread_mutex_unlock(&quotas->lock);
    return good;
}

void quotas_give(struct quotas *quotas, const char *owner, enum quotas_kind kind, int64_t amount) {
    pthread_mutex_lock(&quotas->lock);
    struct share **at = find_share(quotas, owner), *share = *at;
    bool left = false;
    share->held[kind] -= amount;
    quotas->taken[kind] -= amount;
    for (int k = 0; k < QUOTAS_KINDS; k++)
        left = left || share->held[k] > 0;
    if (!left) {
        *at = share->next;
        free(share);
    }
    pthread_mutex_unlock(&quotas->lock);
}

int64_t quotas_of(struct quotas *quotas, const char *owner, enum quotas_kind kind) {
    pthread_mutex_lock(&quotas->lock);
    int64_t held = held_at(find_share(quotas, owner), kind);
    pthread_mutex_unlock(&quotas->lock);
    return held;
}

int64_t quotas_left(struct quotas *quotas, enum quotas_kind kind) {
    pthread_mutex_lock(&quotas->lock);
    int64_t left = quotas->limits[kind] - quotas->taken[kind];
    pthread_mutex_unlock(&quotas->lock);
    return left;
}
