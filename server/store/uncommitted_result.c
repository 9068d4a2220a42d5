/* SPDX-License-Identifier: MIT */
#include "uncommitted_result.h"
#include <stdlib.h>
#include <string.h>

struct store_uncommitted *uncommitted_new(struct store *store, const char *id) {
    struct store_uncommitted *uncommitted = calloc(1, sizeof *uncommitted);
    if (!uncommitted)
        return NULL;
    uncommitted->store = store;
    memcpy(uncommitted->id, id, sizeof uncommitted->id);
    atomic_init(&uncommitted->uses, 1);
    atomic_init(&uncommitted->number, 0);
    return uncommitted;
}

void uncommitted_list(struct store_uncommitted *uncommitted) {
    struct store_uncommitted_list *list = &uncommitted->store->uncommitted;
    pthread_mutex_lock(&list->lock);
    uncommitted->next = list->first;
    list->first = uncommitted;
    uncommitted->listed = true;
    pthread_mutex_unlock(&list->lock);
}

void uncommitted_close(struct store_uncommitted *uncommitted, int64_t number) {
    if (!uncommitted)
        return;
    if (uncommitted->listed) {
        struct store_uncommitted_list *list = &uncommitted->store->uncommitted;
        pthread_mutex_lock(&list->lock);
        struct store_uncommitted **at = &list->first;
        while (*at != uncommitted)
            at = &(*at)->next;
        *at = uncommitted->next;
        pthread_mutex_unlock(&list->lock);
    }
    atomic_store(&uncommitted->number, (int_fast64_t)number);
    store_uncommitted_drop(uncommitted);
}

struct store_uncommitted *store_uncommitted_share(struct store_uncommitted *uncommitted) {
    atomic_fetch_add(&uncommitted->uses, 1);
    return uncommitted;
}

struct store_uncommitted *store_uncommitted_take(struct store *store, const char *id) {
    struct store_uncommitted_list *list = &store->uncommitted;
    pthread_mutex_lock(&list->lock);
    struct store_uncommitted *uncommitted = list->first;
    while (uncommitted && strcmp(uncommitted->id, id) != 0)
        uncommitted = uncommitted->next;
    if (uncommitted)
        store_uncommitted_share(uncommitted);
    pthread_mutex_unlock(&list->lock);
    return uncommitted;
}

/* What was stored is going to be read now. */
void store_uncommitted_drop(struct store_uncommitted *uncommitted) {
    if (!uncommitted || atomic_fetch_sub(&uncommitted->uses, 1) > 1)
        return;
    int64_t number = atomic_load(&uncommitted->number);
    size_t left = uncommitted->length;
    for (int64_t k = 0; k < STORE_SEGMENT_CHUNKS; k++) {
        size_t length = left < STORE_CHUNK_BYTES ? left : STORE_CHUNK_BYTES;
        if (number && length)
            store_cache_put(uncommitted->store->cache, number, uncommitted->index + k,
                            uncommitted->chunks[k], length);
        else
            free(uncommitted->chunks[k]);
        left -= length;
    }
    free(uncommitted);
}

size_t store_uncommitted_length(const struct store_uncommitted *uncommitted) {
    return uncommitted->length;
}

bool store_uncommitted_kept(const struct store_uncommitted *uncommitted) {
    return atomic_load(&uncommitted->number) != 0;
}

bool store_uncommitted_read(const struct store_uncommitted *uncommitted, uint64_t offset,
                            void *bytes, size_t length) {
    unsigned char *to = bytes;
    if (offset > uncommitted->length || length > uncommitted->length - offset)
        return false;
    for (size_t at = (size_t)offset; length > 0;) {
        size_t within = at % STORE_CHUNK_BYTES, room = STORE_CHUNK_BYTES - within;
        size_t taken = length < room ? length : room;
        memcpy(to, uncommitted->chunks[at / STORE_CHUNK_BYTES] + within, taken);
        to += taken;
        at += taken;
        length -= taken;
    }
    return true;
}
