/* SPDX-License-Identifier: MIT */
#include "rim_front.h"

/* Twice what places are looked for by, in spacings; a place behind a side; and what is no way. */
static const double reach = 1.0 / 32, behind = 1e-9, nothing = 1e-12;

/* The place at which the line from `a` through `b` meets a side of cells near `b`, the first behind
 * which there is no cloth or, where cells lie behind all of them, the first; false where none is
 * within reach. */
static bool side_ahead(struct rim_cloth *cloth, const struct rim_point *a,
                       const struct rim_point *b, double side[2]) {
    const double at[2] = {b->p, b->q}, way[2] = {b->p - a->p, b->q - a->q};
    double length = sqrt(way[0] * way[0] + way[1] * way[1]), share[2], least = HUGE_VAL;
    for (int k = 0; k < 2; k++) {
        double line = way[k] > 0 ? ceil(at[k]) : floor(at[k]);
        share[k] = fabs(way[k]) > nothing ? (line - at[k]) / way[k] : HUGE_VAL;
    }
    if (!a->covered || !b->covered)
        return false;
    bool second = share[1] < share[0];
    rim_cloth_look(cloth, b->sight, b->beside);
    for (int k = 0; k < 2; k++) {
        double own = share[k ? !second : second], beyond = own + behind / length;
        if (!(own * length <= reach))
            break;
        least = fmin(least, own);
        if (!rim_cloth_patch(cloth, (int32_t)floor(at[0] + beyond * way[0]),
                             (int32_t)floor(at[1] + beyond * way[1]))
                 ->known) {
            least = own;
            break;
        }
    }
    for (int k = 0; k < 2; k++)
        side[k] = at[k] + least * way[k];
    return least < HUGE_VAL;
}

/* The loop's points first .. first + count - 1. */
static void reach_in_loop(struct rim_cloth *cloth, struct rim_point *first, size_t count) {
    size_t begin = 0;
    while (begin < count && !first[begin].covered)
        begin++;
    for (size_t k = begin; k < begin + count && begin < count; k++) {
        size_t length = 0; /* of the stretch behind k */
        while (length < count && !first[(k + 1 + length) % count].covered)
            length++;
        if (length < 2)
            continue;
        size_t last = k + 1 + length;
        struct rim_point *to = &first[last % count], *next = &first[(last + 1) % count];
        double side[2], back[2];
        bool ends = side_ahead(cloth, &first[(k + count - 1) % count], &first[k % count], side);
        bool begins = side_ahead(cloth, next, to, back);
        for (size_t m = k + 1; m < last; m++) {
            struct rim_point *point = &first[m % count];
            bool at_end = begins && m + 1 == last;
            point->covered = at_end || (ends && m == k + 1);
            point->p = at_end ? back[0] : ends ? side[0] : point->p;
            point->q = at_end ? back[1] : ends ? side[1] : point->q;
        }
        k = last - 1;
    }
}

void rim_reach_front(struct rim *rim) {
    for (size_t first = 0, end; first < rim->count; first = end) {
        for (end = first + 1; end < rim->count && rim->points[end].loop == rim->points[first].loop;)
            end++;
        reach_in_loop(&rim->cloth, rim->points + first, end - first);
    }
}
