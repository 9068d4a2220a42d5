/* SPDX-License-Identifier: MIT */
#include "shares.h"
#include "request.h"
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
    pthread_mutex_t lock;
    struct share *buckets[BUCKETS];
};

struct shares *shares_new(void) {
    struct shares *shares = calloc(1, sizeof *shares);
    if (shares)
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

bool shares_take(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount,
                 int64_t most) {
    pthread_mutex_lock(&shares->lock);
    struct share **at = find(shares, owner);
    int64_t held = *at ? (*at)->held[kind] : 0;
    struct share *share = held + amount > most ? NULL : *at ? *at : add(at, owner);
    if (share)
        share->held[kind] += amount;
    pthread_mutex_unlock(&shares->lock);
    return share != NULL;
}

void shares_give(struct shares *shares, const char *owner, enum shares_kind kind, int64_t amount) {
    pthread_mutex_lock(&shares->lock);
    struct share **at = find(shares, owner), *share = *at;
    bool left = false;
    share->held[kind] -= amount;
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
    struct share *share = *find(shares, owner);
    int64_t held = share ? share->held[kind] : 0;
    pthread_mutex_unlock(&shares->lock);
    return held;
}
