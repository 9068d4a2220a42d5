/* SPDX-License-Identifier: MIT */
#include "shares.h"
#include "request.h"
#include "server/share.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BUCKETS = 1024 };

struct share {
    char owner[REQUEST_CALLER_SIZE];
    int64_t held[SHARES_KINDS];
    struct share *next;
};

struct shares {
    int64_t limits[SHARES_KINDS];
    pthread_mutex_t lock; /* what is below */
    int64_t taken[SHARES_KINDS];
    struct share *buckets[BUCKETS];
};

struct shares *shares_new(const int64_t limits[SHARES_KINDS]) {
    struct shares *shares = calloc(1, sizeof *shares);
    if (!shares)
        return NULL;
    memcpy(shares->limits, limits, sizeof shares->limits);
    pthread_mutex_init(&shares->lock, NULL);
    return shares;
}

void shares_free(struct shares *shares) {
    if (!shares)
        return;
    pthread_mutex_destroy(&shares->lock);
    free(shares);
}

/* FNV-1a. Who chooses names to collide has that many addresses anyway. */
static struct share **bucket_of(struct shares *shares, const char *owner) {
    uint32_t hash = 2166136261u;
    for (; *owner; owner++)
        hash = (hash ^ (unsigned char)*owner) * 16777619u;
    return &shares->buckets[hash % BUCKETS];
}

/* Where the owner's entry is or would be. With the lock. */
static struct share **find(struct shares *shares, const char *owner) {
    struct share **at = bucket_of(shares, owner);
    while (*at && strcmp((*at)->owner, owner) != 0)
        at = &(*at)->next;
    return at;
}

static struct share *add(struct share **at, const char *owner) {
    struct share *share = calloc(1, sizeof *share);
    if (share)
        snprintf(share->owner, sizeof share->owner, "%s", owner);
    return *at = share;
}

static int64_t held_at(struct share *const *at, enum shares_kind kind) {
    return *at ? (*at)->held[kind] : 0;
}

/* With the lock, like the next ones. */
static bool fits(const struct shares *shares, struct share *const *at, enum shares_kind kind,
                 int64_t amount, int64_t most) {
    int64_t held = held_at(at, kind);
    return held + amount <= most &&
           share_fits(held, shares->taken[kind], shares->limits[kind], amount);
}

static bool grows(const struct shares *shares, struct share *const *at, enum shares_kind kind,
                  int64_t amount, int64_t held) {
    int64_t taken = shares->taken[kind], limit = shares->limits[kind];
    int64_t kept = taken == held ? 0 : limit / SHARES_KEPT;
    return held_at(at, kind) == held && taken + amount <= limit - kept;
}

/* False without memory. */
static bool take(struct shares *shares, struct share **at, const char *owner, enum shares_kind kind,
                 int64_t amount) {
    struct share *share = *at ? *at : add(at, owner);
    if (!share)
        return false;
    share->held[kind] += amount;
    shares->taken[kind] += amount;
    return true;
}

bool shares_fit(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount,
                int64_t most) {
    pthread_mutex_lock(&shares->lock);
    bool good = fits(shares, find(shares, owner), kind, amount, most);
    pthread_mutex_unlock(&shares->lock);
    return good;
}

bool shares_take(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount,
                 int64_t most) {
    pthread_mutex_lock(&shares->lock);
    struct share **at = find(shares, owner);
    bool good = fits(shares, at, kind, amount, most) && take(shares, at, owner, kind, amount);
    pthread_mutex_unlock(&shares->lock);
    return good;
}

bool shares_grow(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount,
                 int64_t held) {
    pthread_mutex_lock(&shares->lock);
    struct share **at = find(shares, owner);
    bool good = grows(shares, at, kind, amount, held) && take(shares, at, owner, kind, amount);
    pthread_mutex_unlock(&shares->lock);
    return good;
}

bool shares_add(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount) {
    pthread_mutex_lock(&shares->lock);
    bool good = take(shares, find(shares, owner), owner, kind, amount);
    pthread_mutex_unlock(&shares->lock);
    return good;
}

void shares_give(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount) {
    pthread_mutex_lock(&shares->lock);
    struct share **at = find(shares, owner), *share = *at;
    bool left = false;
    share->held[kind] -= amount;
    shares->taken[kind] -= amount;
    for (int k = 0; k < SHARES_KINDS; k++)
        left = left || share->held[k] > 0;
    if (!left) {
        *at = share->next;
        free(share);
    }
    pthread_mutex_unlock(&shares->lock);
}

int64_t shares_of(struct shares *shares, const char *owner, enum shares_kind kind) {
    pthread_mutex_lock(&shares->lock);
    int64_t held = held_at(find(shares, owner), kind);
    pthread_mutex_unlock(&shares->lock);
    return held;
}

int64_t shares_left(struct shares *shares, enum shares_kind kind) {
    pthread_mutex_lock(&shares->lock);
    int64_t left = shares->limits[kind] - shares->taken[kind];
    pthread_mutex_unlock(&shares->lock);
    return left;
}
