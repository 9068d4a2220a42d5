/* SPDX-License-Identifier: MIT */
/*
 * The memory of one job: blocks taken from the heap as needed, never more than a budget, all given
 * back at once. Scratch is taken after a mark and returned by rewinding to it. An arena belongs to
 * one thread.
 */
#ifndef SOLVER_ARENA_H
#define SOLVER_ARENA_H

#include <stddef.h>

struct arena;

enum { ARENA_ALIGNMENT = 64 }; /* of what it hands out */

/* A place to rewind to; valid until the arena is rewound to an earlier one. */
struct arena_mark {
    void *block;
    size_t used;
};

/* A part of what an arena holds that lies in one piece. */
struct arena_piece {
    const char *bytes;
    size_t length; /* a multiple of ARENA_ALIGNMENT */
};

/* A new arena that will hold at most `budget` bytes of the heap; NULL when even its own record
 * cannot be had. The caller owns it and gives it back with `arena_free`. */
struct arena *arena_new(size_t budget);

/* An arena for another thread, whose memory counts against `parent`'s budget and is given back with
 * it, not by `arena_free`. Made by the thread that has the parent; NULL as above. */
struct arena *arena_child(struct arena *parent);

/* Has what was never written to be zeros in all that the arena takes from the heap from now on, so
 * that nothing that others left there is copied with it (`relocation.h`). */
void arena_clear(struct arena *arena);

/* Gives everything back; NULL is allowed. */
void arena_free(struct arena *arena);

/* `count` elements of `size` bytes, zeroed, aligned to 64 bytes; NULL when the product overflows,
 * the budget is used up or the heap is empty. Zero elements give a valid pointer. */
void *arena_alloc(struct arena *arena, size_t count, size_t size);

/* The same without the zeros, for arrays that are filled at once. */
void *arena_take(struct arena *arena, size_t count, size_t size);

/* `count` elements of which the first `used` are a copy of those of `from`, the others without
 * zeros. NULL as above. */
void *arena_copy(struct arena *arena, const void *from, size_t used, size_t count, size_t size);

/* A copy of a full array of `count` elements with room for twice as many, at least 256, without
 * zeros; `room` gets how many. The old one stays where it is until the arena is rewound. NULL as
 * above. */
void *arena_enlarge(struct arena *arena, const void *from, size_t count, size_t size, size_t *room);

struct arena_mark arena_mark(const struct arena *arena);

/* Returns all that was taken since `mark`. */
void arena_rewind(struct arena *arena, struct arena_mark mark);

/* The first `most` of the pieces that the arena holds, without its children; returns how many it
 * has. `pieces` may be NULL when `most` is 0. */
size_t arena_pieces(const struct arena *arena, struct arena_piece *pieces, size_t most);

/* The bytes held now, and the most that were ever held, with all children. */
size_t arena_held(const struct arena *arena);
size_t arena_peak(const struct arena *arena);

/* For tests: the n-th allocation from now on (1 is the next) and all after it fail, those of all
 * children counted too; 0 never. */
void arena_fail_at(struct arena *arena, size_t n);

#endif
