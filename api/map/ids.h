/* SPDX-License-Identifier: MIT */
/* The numbers that a file gives to its grids and elements, and their indices. */
#ifndef API_MAP_IDS_H
#define API_MAP_IDS_H

#include "solver/arena.h"
#include <stddef.h>
#include <stdint.h>

struct map_id {
    int32_t id;
    int32_t index;
};

/* The ids with their indices, sorted by id, then index, in `arena`; NULL without memory. */
struct map_id *map_ids_sort(const int32_t *ids, size_t count, struct arena *arena);

/* The index of the second of two equal ids, or -1. */
int32_t map_ids_repeated(const struct map_id *ids, size_t count);

/* Where the ids begin that are not below one. */
size_t map_ids_from(const struct map_id *ids, size_t count, int32_t id);

/* The index of an id, or -1. */
int32_t map_ids_find(const struct map_id *ids, size_t count, int32_t id);

#endif
