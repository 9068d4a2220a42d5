/* SPDX-License-Identifier: MIT */
/* An arena that every test of a file has of its own, by set_up and tear_down. */
#ifndef UNIT_OWN_ARENA_H
#define UNIT_OWN_ARENA_H

#include "solver/arena.h"

static struct arena *arena;

static int set_up(void **state) {
    (void)state;
    arena = arena_new((size_t)1 << 27);
    return arena ? 0 : -1;
}

static int tear_down(void **state) {
    (void)state;
    arena_free(arena);
    return 0;
}

#endif
