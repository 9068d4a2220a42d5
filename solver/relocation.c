/* SPDX-License-Identifier: MIT */
#include "relocation.h"

#include <string.h>

/* Of all that arenas hand out. An image has the pointer to its root in its first such part, so that
 * no pointer in it is 0. */
enum { ALIGNMENT = ARENA_ALIGNMENT };

/* Where in the image that is which lies at `address`; false when it is none of what was copied. */
static bool place_of(const struct relocation *relocation, uintptr_t address, size_t bytes,
                     size_t *place) {
    size_t before = ALIGNMENT;
    if (relocation->packed) {
        *place = relocation->packed[address / ALIGNMENT] * ALIGNMENT + address % ALIGNMENT;
        return true; /* the first walk has looked */
    }
    if (!relocation->pieces) {
        *place = address;
        return address >= ALIGNMENT && address <= relocation->length &&
               bytes <= relocation->length - address;
    }
    for (size_t k = 0; k < relocation->piece_count; k++) {
        const struct arena_piece *piece = &relocation->pieces[k];
        size_t within = address - (uintptr_t)piece->bytes;
        *place = before + within;
        if (within < piece->length && bytes <= piece->length - within)
            return true;
        before += piece->length;
    }
    return false;
}

/* Of an image being made: these bytes of the copy are part of it. */
static void reach(struct relocation *relocation, const char *target, size_t bytes) {
    size_t place = (size_t)(target - relocation->bytes);
    size_t first = place / ALIGNMENT, end = (place + bytes + !bytes - 1) / ALIGNMENT + 1;
    if (relocation->reached)
        memset(relocation->reached + first, 1, end - first);
}

void *relocate(struct relocation *relocation, void *field, size_t count, size_t size) {
    uintptr_t address;
    size_t bytes, place;
    memcpy(&address, field, sizeof address);
    if (!address || relocation->failed)
        return NULL;
    relocation->failed = __builtin_mul_overflow(count, size, &bytes) ||
                         !place_of(relocation, address, bytes, &place);
    if (relocation->failed)
        return NULL;
    char *target = relocation->bytes + place;
    if (relocation->pieces)
        memcpy(field, &place, sizeof place);
    else
        memcpy(field, &target, sizeof target);
    reach(relocation, target, bytes);
    return target;
}

bool relocation_first(struct relocation *relocation, const void *place) {
    if (!place)
        return false;
    size_t number = (size_t)((const char *)place - relocation->bytes) / sizeof(void *);
    uint8_t *seen = &relocation->seen[number / 8], bit = (uint8_t)(1u << number % 8);
    bool first = !(*seen & bit);
    *seen |= bit;
    return first;
}

void *relocate_once(struct relocation *relocation, void *field, size_t count, size_t size) {
    void *target = relocate(relocation, field, count, size);
    return relocation_first(relocation, target) ? target : NULL;
}

void relocate_text(struct relocation *relocation, const char **field) {
    const char *text = relocate(relocation, field, 1, 1);
    const char *end = relocation->bytes + relocation->length;
    const char *zero = text ? memchr(text, '\0', (size_t)(end - text)) : NULL;
    relocation->failed = relocation->failed || (text && !zero);
    if (zero)
        reach(relocation, text, (size_t)(zero - text) + 1);
}

/* Walks over the copy from its root on. */
static void *walk_from_root(struct relocation *relocation, size_t root_size, struct arena *arena) {
    relocation->seen = arena_alloc(arena, relocation->length / ALIGNMENT + 1, 1);
    if (!relocation->seen)
        return NULL;
    void *root = relocate(relocation, relocation->bytes, 1, root_size);
    if (root)
        relocation->walk(relocation, root);
    return relocation->failed ? NULL : root;
}

/* Whether no word of the root is still an address in what was copied. */
static bool is_whole(const struct relocation *relocation, const char *root, size_t size) {
    bool whole = true;
    for (size_t k = 0; k + sizeof(uintptr_t) <= size; k += sizeof(uintptr_t)) {
        uintptr_t word;
        size_t place;
        memcpy(&word, root + k, sizeof word);
        whole = whole && !place_of(relocation, word, 1, &place);
    }
    return whole;
}

/* Copies all that the arena holds to `to`, behind the pointer to the root. */
static bool copy_pieces(struct relocation *relocation, const struct arena *from, const void *root,
                        struct arena *to) {
    size_t count = arena_pieces(from, NULL, 0);
    struct arena_piece *pieces = arena_take(to, count, sizeof *pieces);
    if (!pieces)
        return false;
    (void)arena_pieces(from, pieces, count);
    relocation->pieces = pieces;
    relocation->piece_count = count;
    relocation->length = ALIGNMENT;
    for (size_t k = 0; k < count; k++)
        relocation->length += pieces[k].length;
    char *at = relocation->bytes = arena_take(to, relocation->length, 1);
    if (!at)
        return false;
    memset(at, 0, ALIGNMENT);
    memcpy(at, &root, sizeof root);
    at += ALIGNMENT;
    for (size_t k = 0; k < count; k++) {
        memcpy(at, pieces[k].bytes, pieces[k].length);
        at += pieces[k].length;
    }
    return true;
}

/* Moves what has been reached together, and the pointers with it: arenas hold much that was only
 * needed while the structures were made. */
static const void *pack(struct relocation *relocation, size_t root_size, struct arena *arena) {
    size_t units = relocation->length / ALIGNMENT, used = 0;
    size_t *packed = arena_take(arena, units, sizeof *packed);
    if (!packed)
        return NULL;
    for (size_t k = 0; k < units; k++) {
        packed[k] = used;
        if (relocation->reached[k])
            memmove(relocation->bytes + used++ * ALIGNMENT, relocation->bytes + k * ALIGNMENT,
                    ALIGNMENT);
    }
    relocation->packed = packed;
    relocation->reached = NULL;
    relocation->length = used * ALIGNMENT;
    return walk_from_root(relocation, root_size, arena) ? relocation->bytes : NULL;
}

const void *relocation_take(struct relocation *relocation, const struct arena *from,
                            const void *root, size_t root_size, struct arena *to, size_t *length) {
    if (!copy_pieces(relocation, from, root, to))
        return NULL;
    relocation->reached = arena_alloc(to, relocation->length / ALIGNMENT, 1);
    if (!relocation->reached)
        return NULL;
    reach(relocation, relocation->bytes, sizeof root);
    const char *copy = walk_from_root(relocation, root_size, to);
    if (!copy || !is_whole(relocation, copy, root_size))
        return NULL;
    const void *image = pack(relocation, root_size, to);
    *length = relocation->length;
    return image;
}

void *relocation_open(struct relocation *relocation, const void *bytes, size_t length,
                      size_t root_size, struct arena *arena) {
    if (length < ALIGNMENT)
        return NULL;
    relocation->bytes = arena_copy(arena, bytes, length, length, 1);
    relocation->length = length;
    return relocation->bytes ? walk_from_root(relocation, root_size, arena) : NULL;
}
