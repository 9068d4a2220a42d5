/* SPDX-License-Identifier: MIT */
#include "overlap_patches.h"

#include <string.h>

/* Patches that there is room for at first, and nodes of a patch and its sites, as a rule. */
enum { FIRST_PATCHES = 64, PATCH_NODES = 14, PATCH_SITES = 12 };

static int32_t *take_none(struct arena *arena, size_t count) {
    int32_t *numbers = arena_take(arena, count, sizeof *numbers);
    for (size_t k = 0; numbers && k < count; k++)
        numbers[k] = OVERLAP_NONE;
    return numbers;
}

static size_t power_of_two(size_t least) {
    size_t power = 1;
    while (power < least)
        power *= 2;
    return power;
}

/* Room for so many patches. */
static bool grow_patches(struct overlap_patches *patches, size_t room) {
    size_t slot_count = power_of_two(room + room / 2);
    struct overlap_patch *patch = arena_take(patches->arena, room, sizeof *patch);
    int32_t *slots = patch ? take_none(patches->arena, slot_count) : NULL;
    if (!slots || room > INT32_MAX)
        return false;
    if (patches->count)
        memcpy(patch, patches->patch, patches->count * sizeof *patch);
    patches->patch = patch;
    patches->room = room;
    patches->slots = slots;
    patches->slot_count = slot_count;
    for (size_t k = 0; k < patches->count; k++)
        *overlap_patches_slot(patches, patch[k].pi, patch[k].pj) = (int32_t)k;
    return true;
}

/* Enters a patch in the cubes that its box touches and `before`, unless NULL, did not, as long as
 * there is room: false where there is none. */
static bool enter(struct overlap_patches *patches, size_t number,
                  const struct overlap_box *before) {
    struct overlap_cubes old = {.last = {-1, -1, -1}};
    struct overlap_cubes now = overlap_patches_cubes(patches, &patches->patch[number].box);
    int64_t at[3];
    if (before)
        old = overlap_patches_cubes(patches, before);
    for (at[0] = now.first[0]; at[0] <= now.last[0]; at[0]++)
        for (at[1] = now.first[1]; at[1] <= now.last[1]; at[1]++)
            for (at[2] = now.first[2]; at[2] <= now.last[2]; at[2]++) {
                bool entered = true;
                for (int k = 0; k < 3; k++)
                    entered = entered && at[k] >= old.first[k] && at[k] <= old.last[k];
                if (entered)
                    continue;
                if (patches->site_count == patches->site_room)
                    return false;
                size_t cube = overlap_hash(at[0], at[1], at[2]) & (patches->cube_count - 1);
                patches->sites[patches->site_count] =
                    (struct overlap_entry){(int32_t)number, patches->cubes[cube]};
                patches->cubes[cube] = (int32_t)patches->site_count++;
            }
    return true;
}

/* Room for so many sites at least: all patches are entered anew. There are half as many hashes, or
 * up to twice that. */
static bool grow_sites(struct overlap_patches *patches, size_t room) {
    bool fits = false;
    for (; !fits; room *= 2) {
        patches->sites = arena_take(patches->arena, room, sizeof *patches->sites);
        patches->cube_count = power_of_two(room / 2);
        patches->cubes = take_none(patches->arena, patches->cube_count);
        if (!patches->sites || !patches->cubes || room > INT32_MAX)
            return false;
        patches->site_room = room;
        patches->site_count = 0;
        fits = true;
        for (size_t k = 0; k < patches->count && fits; k++)
            fits = enter(patches, k, NULL);
    }
    return true;
}

bool overlap_patches_make(struct overlap_patches *patches, struct arena *arena, size_t nodes,
                          double cube) {
    size_t room = FIRST_PATCHES + nodes / PATCH_NODES;
    *patches = (struct overlap_patches){.arena = arena, .cube = cube};
    return grow_patches(patches, room) && grow_sites(patches, PATCH_SITES * room);
}

enum status overlap_patches_stretch(struct overlap_patches *patches, int32_t pi, int32_t pj,
                                    const struct net_tile *tile, const struct overlap_box *box,
                                    struct overlap_shape shape) {
    bool known = overlap_patches_find(patches, pi, pj) != NULL;
    if (!known) {
        if (patches->count == patches->room && !grow_patches(patches, 2 * patches->room))
            return STATUS_OUT_OF_MEMORY;
        *overlap_patches_slot(patches, pi, pj) = (int32_t)patches->count;
        patches->patch[patches->count++] =
            (struct overlap_patch){pi, pj, tile, *box, shape, OVERLAP_NONE};
    }
    size_t number = (size_t)*overlap_patches_slot(patches, pi, pj);
    struct overlap_patch *patch = &patches->patch[number];
    struct overlap_box before = patch->box;
    patch->shape = shape;
    for (int k = 0; k < 3; k++) {
        patch->box.low[k] = fmin(before.low[k], box->low[k]);
        patch->box.high[k] = fmax(before.high[k], box->high[k]);
    }
    bool fits = enter(patches, number, known ? &before : NULL);
    return fits || grow_sites(patches, 2 * patches->site_room) ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* Whether two boxes touch, and a cube is the first of those that they have in common: along each
 * axis one of them begins in it. `cubes` are those of the first box. */
static bool touch_first_in(const struct overlap_patches *patches, const struct overlap_box *box,
                           const struct overlap_cubes *cubes, const struct overlap_box *other,
                           const int64_t at[3]) {
    bool first = true;
    for (int k = 0; k < 3; k++)
        first =
            first && box->low[k] <= other->high[k] && other->low[k] <= box->high[k] &&
            (at[k] == cubes->first[k] || at[k] == (int64_t)floor(other->low[k] / patches->cube));
    return first;
}

bool overlap_patches_meet(const struct overlap_patches *patches, const struct overlap_patch *patch,
                          double reach, bool (*enough)(void *context, int32_t other),
                          void *context) {
    struct overlap_box inner = patch->box; /* of the nodes alone: of one, rounding leaves some */
    for (int k = 0; k < 3; k++) {
        double middle = (inner.low[k] + inner.high[k]) / 2;
        inner.low[k] = fmin(inner.low[k] + reach, middle);
        inner.high[k] = fmax(inner.high[k] - reach, middle);
    }
    struct overlap_cubes cubes = overlap_patches_cubes(patches, &inner);
    int64_t at[3];
    for (at[0] = cubes.first[0]; at[0] <= cubes.last[0]; at[0]++)
        for (at[1] = cubes.first[1]; at[1] <= cubes.last[1]; at[1]++)
            for (at[2] = cubes.first[2]; at[2] <= cubes.last[2]; at[2]++) {
                int32_t site = overlap_patches_first(patches, at);
                for (; site != OVERLAP_NONE; site = patches->sites[site].next) {
                    int32_t other = patches->sites[site].patch;
                    const struct overlap_box *box = &patches->patch[other].box;
                    if (touch_first_in(patches, &inner, &cubes, box, at) && enough(context, other))
                        return true;
                }
            }
    return false;
}
