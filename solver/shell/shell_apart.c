/* SPDX-License-Identifier: MIT */
#include "shell.h"

#include "../arena.h"
#include <math.h>

/* Points of a straight edge are this share of the shell's size apart; those of bent ones less. */
static const double apart_share = 0.25;

/* Points that are looked at, at the most: what is told is where to look, not a measure. */
enum { APART_POINTS = 1000 };

enum status shell_nearest_apart(const struct shell *shell, int32_t face, struct arena *arena,
                                struct shell_apart *apart) {
    int32_t own = shell_component(shell, face), count = (int32_t)shell_component_count(shell);
    size_t edges = shell_edge_count(shell);
    int left = APART_POINTS;
    *apart = (struct shell_apart){.face = face, .distance = HUGE_VAL};
    for (int32_t other = 0; other < count && left > 0; other++) {
        if (other == own)
            continue;
        struct arena_mark mark = arena_mark(arena);
        struct shell_line *lines;
        if (shell_lines(shell, other, apart_share * shell_size(shell), arena, &lines) != STATUS_OK)
            return STATUS_OUT_OF_MEMORY;
        for (size_t e = 0; e < edges; e++)
            for (size_t k = 0; k < lines[e].count && left > 0; k++, left--) {
                struct shell_point place;
                double distance;
                shell_nearest(shell, lines[e].r[k], own, &place, &distance);
                if (distance < apart->distance)
                    *apart = (struct shell_apart){lines[e].face, lines[e].r[k], distance};
            }
        arena_rewind(arena, mark);
    }
    return STATUS_OK;
}
