/* SPDX-License-Identifier: MIT */
#include "arena.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { ALIGNMENT = ARENA_ALIGNMENT };

/* Small jobs should cost one block, large ones few, and what the last one leaves unused little: a
 * new block is a 32nd of what there is, up to two megabytes. */
static const size_t block_smallest = 64 * 1024;
static const size_t block_largest = 2 * 1024 * 1024;

/* Blocks of this size and more take large pages, where the machine gives them to those who ask; the
 * parts of them that are asked for begin and end at a page of any machine. */
static const size_t block_paged = 256 * 1024;
static const size_t page_largest = 64 * 1024;

struct block {
    struct block *previous;
    size_t capacity; /* bytes of data behind this header */
    size_t used;
};

/* Data begins at the first aligned offset behind the header. */
static const size_t header_size = ALIGNMENT;
_Static_assert(sizeof(struct block) <= ALIGNMENT, "a block's header fits before its data");

struct arena {
    struct block *last;
    size_t next_capacity;
    size_t taken;          /* by all blocks it ever had */
    struct arena *root;    /* whose budget counts: itself unless it is a child */
    bool cleared;          /* its memory begins as zeros */
    struct arena *sibling; /* the child made before; of a root its last child */
    size_t budget;         /* of a root, as are those below */
    _Atomic size_t held, peak;
    _Atomic size_t fail_in; /* allocations until the first failing one; 0: none fails */
};

struct arena *arena_new(size_t budget) {
    struct arena *arena = calloc(1, sizeof *arena);
    if (arena) {
        arena->root = arena;
        arena->budget = budget;
        arena->next_capacity = block_smallest;
    }
    return arena;
}

void arena_clear(struct arena *arena) {
    arena->cleared = true;
}

static bool injected_failure(struct arena *root) {
    size_t left = atomic_load(&root->fail_in);
    while (left > 1 && !atomic_compare_exchange_weak(&root->fail_in, &left, left - 1))
        ;
    return left == 1;
}

struct arena *arena_child(struct arena *parent) {
    struct arena *child = injected_failure(parent->root) ? NULL : calloc(1, sizeof *child);
    if (child) {
        child->root = parent->root;
        child->next_capacity = block_smallest;
        child->sibling = parent->root->sibling;
        parent->root->sibling = child;
    }
    return child;
}

/* Takes from the budget; false when it is used up. */
static bool take(struct arena *root, size_t bytes) {
    size_t held = atomic_load(&root->held);
    do {
        if (bytes > root->budget - held)
            return false;
    } while (!atomic_compare_exchange_weak(&root->held, &held, held + bytes));
    size_t peak = atomic_load(&root->peak);
    while (peak < held + bytes && !atomic_compare_exchange_weak(&root->peak, &peak, held + bytes))
        ;
    return true;
}

static void release_last(struct arena *arena) {
    struct block *block = arena->last;
    arena->last = block->previous;
    atomic_fetch_sub(&arena->root->held, header_size + block->capacity);
    free(block);
}

static void release_all(struct arena *arena) {
    while (arena->last)
        release_last(arena);
}

void arena_free(struct arena *arena) {
    if (!arena)
        return;
    for (struct arena *child = arena->sibling, *next; child; child = next) {
        next = child->sibling;
        release_all(child);
        free(child);
    }
    release_all(arena);
    free(arena);
}

static bool add_block(struct arena *arena, size_t needed) {
    bool large = needed > arena->next_capacity / 4; /* a block of its own leaves nothing unused */
    size_t capacity = large ? needed : arena->next_capacity;
    if (!take(arena->root, header_size + capacity)) {
        capacity = needed;
        if (!take(arena->root, header_size + capacity))
            return false;
    }
    struct block *block = aligned_alloc(ALIGNMENT, header_size + capacity);
    if (!block) {
        atomic_fetch_sub(&arena->root->held, header_size + capacity);
        return false;
    }
#ifdef MADV_HUGEPAGE
    /* The first drape of a million nodes in a process spends a sixth of its time on small pages,
     * each later one a twentieth. */
    size_t size = header_size + capacity, before = -(uintptr_t)block % page_largest;
    if (size >= block_paged)
        (void)madvise((char *)block + before, (size - before) / page_largest * page_largest,
                      MADV_HUGEPAGE);
#endif
    if (arena->cleared)
        memset((char *)block + header_size, 0, capacity);
    *block = (struct block){.previous = arena->last, .capacity = capacity};
    arena->last = block;
    arena->taken += capacity;
    size_t share = arena->taken / 32 / ALIGNMENT * ALIGNMENT;
    arena->next_capacity = share < block_smallest  ? block_smallest
                           : share > block_largest ? block_largest
                                                   : share;
    return true;
}

void *arena_take(struct arena *arena, size_t count, size_t size) {
    size_t bytes;
    bool overflows =
        __builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - 2 * ALIGNMENT;
    if (injected_failure(arena->root) || overflows)
        return NULL;
    bytes = bytes ? (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT : ALIGNMENT;
    struct block *block = arena->last;
    if ((!block || bytes > block->capacity - block->used) && !add_block(arena, bytes))
        return NULL;
    block = arena->last;
    void *memory = (char *)block + header_size + block->used;
    block->used += bytes;
    return memory;
}

void *arena_alloc(struct arena *arena, size_t count, size_t size) {
    void *memory = arena_take(arena, count, size);
    return memory ? memset(memory, 0, count * size) : NULL;
}

void *arena_copy(struct arena *arena, const void *from, size_t used, size_t count, size_t size) {
    void *to = arena_take(arena, count, size);
    if (to && used)
        memcpy(to, from, used * size);
    return to;
}

void *arena_enlarge(struct arena *arena, const void *from, size_t count, size_t size,
                    size_t *room) {
    enum { LEAST = 256 };
    size_t wanted = count > LEAST / 2 ? 2 * count : LEAST;
    void *to = arena_copy(arena, from, count, wanted, size);
    *room = to ? wanted : *room;
    return to;
}

struct arena_mark arena_mark(const struct arena *arena) {
    return (struct arena_mark){arena->last, arena->last ? arena->last->used : 0};
}

void arena_rewind(struct arena *arena, struct arena_mark mark) {
    while (arena->last && arena->last != mark.block)
        release_last(arena);
    if (arena->last)
        arena->last->used = mark.used;
}

size_t arena_pieces(const struct arena *arena, struct arena_piece *pieces, size_t most) {
    size_t count = 0;
    for (const struct block *block = arena->last; block; block = block->previous, count++)
        if (count < most)
            pieces[count] = (struct arena_piece){(const char *)block + header_size, block->used};
    return count;
}

size_t arena_held(const struct arena *arena) {
    return atomic_load(&arena->root->held);
}

size_t arena_peak(const struct arena *arena) {
    return atomic_load(&arena->root->peak);
}

void arena_fail_at(struct arena *arena, size_t n) {
    atomic_store(&arena->root->fail_in, n);
}
