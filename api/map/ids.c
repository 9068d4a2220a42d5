/* SPDX-License-Identifier: MIT */
#include "ids.h"

#include <stdbool.h>
#include <stdlib.h>

static int compare_ids(const void *a, const void *b) {
    const struct map_id *x = a, *y = b;
    return x->id != y->id ? (x->id > y->id) - (x->id < y->id)
                          : (x->index > y->index) - (x->index < y->index);
}

/* Most files have them sorted already. */
struct map_id *map_ids_sort(const int32_t *ids, size_t count, struct arena *arena) {
    struct map_id *keys = arena_take(arena, count, sizeof *keys);
    bool sorted = true;
    for (size_t k = 0; keys && k < count; k++) {
        keys[k] = (struct map_id){ids[k], (int32_t)k};
        sorted = sorted && (k == 0 || ids[k - 1] < ids[k]);
    }
    if (keys && !sorted)
        qsort(keys, count, sizeof *keys, compare_ids);
    return keys;
}

int32_t map_ids_repeated(const struct map_id *ids, size_t count) {
    for (size_t k = 1; k < count; k++)
        if (ids[k].id == ids[k - 1].id)
            return ids[k].index;
    return -1;
}

size_t map_ids_from(const struct map_id *ids, size_t count, int32_t id) {
    size_t low = 0, high = count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        bool before = ids[middle].id < id;
        low = before ? middle + 1 : low;
        high = before ? high : middle;
    }
    return low;
}

/* Ids without gaps are found at once. */
int32_t map_ids_find(const struct map_id *ids, size_t count, int32_t id) {
    int64_t guess = count > 0 ? (int64_t)id - ids[0].id : -1;
    if (guess >= 0 && guess < (int64_t)count && ids[guess].id == id)
        return ids[guess].index;
    size_t at = map_ids_from(ids, count, id);
    return at < count && ids[at].id == id ? ids[at].index : -1;
}
