/* SPDX-License-Identifier: MIT */
#include "draft.h"
#include <stdlib.h>
#include <string.h>

struct store_draft *draft_new(struct store *store, const char *id) {
    struct store_draft *draft = calloc(1, sizeof *draft);
    if (!draft)
        return NULL;
    draft->store = store;
    memcpy(draft->id, id, sizeof draft->id);
    atomic_init(&draft->uses, 1);
    atomic_init(&draft->number, 0);
    return draft;
}

void draft_list(struct store_draft *draft) {
    struct store_drafts *drafts = &draft->store->drafts;
    pthread_mutex_lock(&drafts->lock);
    draft->next = drafts->first;
    drafts->first = draft;
    draft->listed = true;
    pthread_mutex_unlock(&drafts->lock);
}

static void unlist(struct store_draft *draft) {
    struct store_drafts *drafts = &draft->store->drafts;
    pthread_mutex_lock(&drafts->lock);
    struct store_draft **at = &drafts->first;
    while (*at != draft)
        at = &(*at)->next;
    *at = draft->next;
    pthread_mutex_unlock(&drafts->lock);
}

void draft_close(struct store_draft *draft, int64_t number) {
    if (!draft)
        return;
    if (draft->listed)
        unlist(draft);
    atomic_store(&draft->number, (int_fast64_t)number);
    store_draft_drop(draft);
}

struct store_draft *store_draft_share(struct store_draft *draft) {
    atomic_fetch_add(&draft->uses, 1);
    return draft;
}

struct store_draft *store_draft_take(struct store *store, const char *id) {
    struct store_drafts *drafts = &store->drafts;
    pthread_mutex_lock(&drafts->lock);
    struct store_draft *draft = drafts->first;
    while (draft && strcmp(draft->id, id) != 0)
        draft = draft->next;
    if (draft)
        store_draft_share(draft);
    pthread_mutex_unlock(&drafts->lock);
    return draft;
}

/* What was stored is going to be read now. */
void store_draft_drop(struct store_draft *draft) {
    if (!draft || atomic_fetch_sub(&draft->uses, 1) > 1)
        return;
    int64_t number = atomic_load(&draft->number);
    size_t left = draft->length;
    for (int64_t k = 0; k < STORE_PART_CHUNKS; k++) {
        size_t length = left < STORE_CHUNK_BYTES ? left : STORE_CHUNK_BYTES;
        if (number && length)
            store_cache_put(draft->store->cache, number, draft->index + k, draft->chunks[k],
                            length);
        else
            free(draft->chunks[k]);
        left -= length;
    }
    free(draft);
}

size_t store_draft_length(const struct store_draft *draft) {
    return draft->length;
}

bool store_draft_kept(const struct store_draft *draft) {
    return atomic_load(&draft->number) != 0;
}

bool store_draft_read(const struct store_draft *draft, uint64_t offset, void *bytes,
                      size_t length) {
    unsigned char *to = bytes;
    if (offset > draft->length || length > draft->length - offset)
        return false;
    for (size_t at = (size_t)offset; length > 0;) {
        size_t within = at % STORE_CHUNK_BYTES, room = STORE_CHUNK_BYTES - within;
        size_t taken = length < room ? length : room;
        memcpy(to, draft->chunks[at / STORE_CHUNK_BYTES] + within, taken);
        to += taken;
        at += taken;
        length -= taken;
    }
    return true;
}
