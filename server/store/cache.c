/* SPDX-License-Identifier: MIT */
#include "cache.h"
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* 4 MiB of full chunks in sets of eight: large enough that two or three readers which go through
 * all the columns of a result side by side find each chunk once, small enough to search, and that
 * sending a result of any size costs less than 8 MiB. */
enum { SETS = 8, WAYS = 8 };

struct entry {
    int64_t number, index; /* number 0: empty */
    uint64_t used;         /* when, counted in uses of the set */
    unsigned char *bytes;
    size_t length;
};

struct set {
    pthread_mutex_t lock;
    uint64_t uses;
    struct entry entries[WAYS];
};

struct store_cache {
    struct set sets[SETS];
};

/* Consecutive chunks and consecutive results lie in different sets. */
static struct set *set_of(struct store_cache *cache, int64_t number, int64_t index) {
    return &cache->sets[((uint64_t)number * 7 + (uint64_t)index) % SETS];
}

struct store_cache *store_cache_new(void) {
    struct store_cache *cache = calloc(1, sizeof *cache);
    for (size_t k = 0; cache && k < SETS; k++)
        pthread_mutex_init(&cache->sets[k].lock, NULL);
    return cache;
}

void store_cache_free(struct store_cache *cache) {
    if (!cache)
        return;
    for (size_t k = 0; k < SETS; k++) {
        for (size_t way = 0; way < WAYS; way++)
            free(cache->sets[k].entries[way].bytes);
        pthread_mutex_destroy(&cache->sets[k].lock);
    }
    free(cache);
}

static struct entry *find_chunk(struct set *set, int64_t number, int64_t index) {
    for (size_t way = 0; way < WAYS; way++)
        if (set->entries[way].number == number && set->entries[way].index == index)
            return &set->entries[way];
    return NULL;
}

bool store_cache_read(struct store_cache *cache, int64_t number, int64_t index, size_t offset,
                      void *bytes, size_t length) {
    struct set *set = set_of(cache, number, index);
    pthread_mutex_lock(&set->lock);
    struct entry *entry = find_chunk(set, number, index);
    bool here = entry && offset <= entry->length && length <= entry->length - offset;
    if (here) {
        memcpy(bytes, entry->bytes + offset, length);
        entry->used = ++set->uses;
    }
    pthread_mutex_unlock(&set->lock);
    return here;
}

void store_cache_put(struct store_cache *cache, int64_t number, int64_t index, void *bytes,
                     size_t length) {
    struct set *set = set_of(cache, number, index);
    pthread_mutex_lock(&set->lock);
    struct entry *entry = find_chunk(set, number, index);
    if (!entry) { /* in place of what was used longest ago */
        entry = &set->entries[0];
        for (size_t way = 1; way < WAYS; way++)
            if (set->entries[way].used < entry->used)
                entry = &set->entries[way];
    }
    unsigned char *old = entry->bytes;
    *entry = (struct entry){number, index, ++set->uses, bytes, length};
    pthread_mutex_unlock(&set->lock);
    free(old);
}
