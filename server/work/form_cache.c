/* SPDX-License-Identifier: MIT */
#include "form_cache.h"

#include "api/request/request.h"
#include "server/store/store.h"
#include <fcntl.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct kept {
    char owner[STORE_OWNER_SIZE], key[API_ID_SIZE]; /* "": the place is free */
    int file;
    size_t length;
    uint64_t used; /* the clock, when it was used last */
};

struct form_cache {
    pthread_mutex_t lock;
    uint64_t clock;
    size_t bytes;
    struct kept kept[FORM_CACHE_FILES];
};

struct form_cache *form_cache_new(void) {
    struct form_cache *cache = calloc(1, sizeof *cache);
    if (cache)
        pthread_mutex_init(&cache->lock, NULL);
    return cache;
}

static void drop(struct form_cache *cache, struct kept *kept) {
    if (!kept->key[0])
        return;
    close(kept->file);
    cache->bytes -= kept->length;
    *kept = (struct kept){.key = ""};
}

void form_cache_free(struct form_cache *cache) {
    if (!cache)
        return;
    for (int k = 0; k < FORM_CACHE_FILES; k++)
        drop(cache, &cache->kept[k]);
    pthread_mutex_destroy(&cache->lock);
    free(cache);
}

/* With the lock. NULL: it is not there. */
static struct kept *find(struct form_cache *cache, const char *owner, const char *key) {
    for (int k = 0; k < FORM_CACHE_FILES && *key; k++)
        if (!strcmp(cache->kept[k].key, key) && !strcmp(cache->kept[k].owner, owner))
            return &cache->kept[k];
    return NULL;
}

/* With the lock: the place that is free, or was used longest ago. */
static struct kept *oldest(struct form_cache *cache, bool taken) {
    struct kept *oldest = NULL;
    for (int k = 0; k < FORM_CACHE_FILES; k++) {
        struct kept *kept = &cache->kept[k];
        if ((!taken || kept->key[0]) && (!oldest || kept->used < oldest->used))
            oldest = kept;
    }
    return oldest;
}

void form_cache_put(struct form_cache *cache, const char *owner, const char *key, int file,
                    size_t length) {
    if (!cache || !*key || length > FORM_CACHE_BYTES)
        return;
    int own = fcntl(file, F_DUPFD_CLOEXEC, 0);
    if (own < 0)
        return;
    pthread_mutex_lock(&cache->lock);
    struct kept *kept = find(cache, owner, key);
    if (kept)
        drop(cache, kept);
    while (cache->bytes + length > FORM_CACHE_BYTES)
        drop(cache, oldest(cache, true));
    kept = oldest(cache, false);
    drop(cache, kept);
    snprintf(kept->owner, sizeof kept->owner, "%s", owner);
    snprintf(kept->key, sizeof kept->key, "%s", key);
    kept->file = own;
    kept->length = length;
    kept->used = ++cache->clock;
    cache->bytes += length;
    pthread_mutex_unlock(&cache->lock);
}

int form_cache_get(struct form_cache *cache, const char *owner, const char *key, size_t *length) {
    int file = -1;
    if (!cache)
        return -1;
    pthread_mutex_lock(&cache->lock);
    struct kept *kept = find(cache, owner, key);
    if (kept) {
        file = fcntl(kept->file, F_DUPFD_CLOEXEC, 0);
        kept->used = ++cache->clock;
        *length = kept->length;
    }
    pthread_mutex_unlock(&cache->lock);
    return file;
}
