/* SPDX-License-Identifier: MIT */
/*
 * Structures that point at each other, as one piece of memory that can be kept and put anywhere.
 *
 * An *image* is a copy of what an arena holds, as far as it can be reached from a root. It begins
 * with the pointer to that, and every pointer has been *relocated*: it counts bytes from the
 * image's beginning. Where an image is to be used it is copied to memory, and the same walk over
 * the same structures relocates the pointers back to addresses.
 *
 * The walk is written once for each structure, beside it: `shell_relocate` and its like relocate
 * the pointer at `field` and go on with what it leads to, once. A pointer that leads out of the
 * arena, or of the image, fails the relocation: such an image is none.
 */
#ifndef SOLVER_RELOCATION_H
#define SOLVER_RELOCATION_H

#include "arena.h"
#include <stdbool.h>
#include <stdint.h>

/* Zero-initialised but for `walk`, which relocates what the root leads to: it is called with the
 * root's place in the copy. */
struct relocation {
    void (*walk)(struct relocation *relocation, void *root);
    char *bytes; /* the copy */
    size_t length;
    const struct arena_piece *pieces; /* of an image being made: what it is a copy of, in order */
    size_t piece_count;
    uint8_t *reached;     /* of an image being made: whether each ARENA_ALIGNMENT bytes are of it */
    const size_t *packed; /* of one being packed: where those go, likewise counted */
    uint8_t *seen; /* of every eight bytes a bit: whether `relocation_first` was asked there */
    bool failed;   /* a pointer led elsewhere, or memory ran out */
};

/* Relocates the pointer that lies at `field`, which leads to `count` elements of `size` bytes.
 * Returns where these are in the copy; NULL where the pointer is NULL or leads elsewhere. */
void *relocate(struct relocation *relocation, void *field, size_t count, size_t size);

/* Whether this place in the copy is asked for the first time, false for NULL: what several pointers
 * lead to is walked over once. */
bool relocation_first(struct relocation *relocation, const void *place);

/* Both: NULL also where that is not the first time. */
void *relocate_once(struct relocation *relocation, void *field, size_t count, size_t size);

/* A pointer to a text, which ends with a zero. */
void relocate_text(struct relocation *relocation, const char **field);

/* The image of what is reached from `root`, all of it in `from`, in the arena `to`: its bytes, and
 * how many in `length`. NULL without memory, when it has a pointer that leads elsewhere, or one in
 * the root itself that the walk has left out. */
const void *relocation_take(struct relocation *relocation, const struct arena *from,
                            const void *root, size_t root_size, struct arena *to, size_t *length);

/* The root of an image that is put to use in `arena`; the bytes are copied. NULL as above. */
void *relocation_open(struct relocation *relocation, const void *bytes, size_t length,
                      size_t root_size, struct arena *arena);

#endif
