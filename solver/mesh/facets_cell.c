/* SPDX-License-Identifier: MIT */
#include "facets_cell.h"

#include "solver/wide.h"
#include <stdint.h>
#include <string.h>

/* What the four sides have, side by side. */
typedef double sides __attribute__((vector_size(8 * FACETS_SIDES)));
typedef int64_t sides_mask __attribute__((vector_size(8 * FACETS_SIDES)));

struct sides3 {
    sides x, y, z;
};

INLINE sides pick_side(sides_mask choose, sides a, sides b) {
    return (sides)(((sides_mask)a & choose) | ((sides_mask)b & ~choose));
}

/* That of the next side. */
INLINE sides of_next_side(sides a) {
    return __builtin_shufflevector(a, a, 1, 2, 3, 0);
}

INLINE struct sides3 of_next_sides(struct sides3 a) {
    return (struct sides3){of_next_side(a.x), of_next_side(a.y), of_next_side(a.z)};
}

INLINE struct sides3 minus(struct sides3 a, struct sides3 b) {
    return (struct sides3){a.x - b.x, a.y - b.y, a.z - b.z};
}

INLINE sides dot_sides(struct sides3 a, struct sides3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

INLINE struct sides3 on_all_sides(struct vec3 a) {
    const sides zero = {0};
    return (struct sides3){a.x - zero, a.y - zero, a.z - zero};
}

/* The share of an edge before the foot on it, within it; 0 on one without length. */
INLINE sides share_of_edge(sides along, sides length2) {
    sides t = pick_side(length2 > 0, along / length2, (sides){0});
    return pick_side(t > 0, pick_side(t < 1, t, 1 - (sides){0}), (sides){0});
}

/* The weights of the points in the triangles a b c, a being the middle, nearest to p (C. Ericson,
 * Real-time collision detection, 5.1.5): the regions of the corners and edges first, by the signs
 * of dot products. A triangle without area has only edges. All of c is b of the next side. */
INLINE void weigh_nearest(struct sides3 a, struct sides3 b, struct sides3 p, sides weight[3]) {
    const sides none = {0}, one = 1 - none;
    struct sides3 ab = minus(b, a), ap = minus(p, a), bp = minus(p, b),
                  bc = minus(of_next_sides(b), b);
    sides d1 = dot_sides(ab, ap), d2 = of_next_side(d1), d3 = dot_sides(ab, bp),
          d6 = of_next_side(d3);
    sides d4 = dot_sides(of_next_sides(ab), bp), d5 = dot_sides(ab, of_next_sides(bp));
    sides va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    sides sum = va + vb + vc, wb = vb / sum, wc = vc / sum, wa = 1 - wb - wc;
    wa = pick_side(wa > 0, wa, none);
    sides on_ab = share_of_edge(d1, dot_sides(ab, ab)), on_ac = of_next_side(on_ab),
          on_bc = share_of_edge(dot_sides(bp, bc), dot_sides(bc, bc));
    /* From the last region to the first, which overrides those after it. */
    sides_mask edge = va <= 0;
    wa = pick_side(edge, none, wa);
    wb = pick_side(edge, 1 - on_bc, wb);
    wc = pick_side(edge, on_bc, wc);
    edge = (vb <= 0) & (d2 >= 0) & (d6 <= 0);
    wa = pick_side(edge, 1 - on_ac, wa);
    wb = pick_side(edge, none, wb);
    wc = pick_side(edge, on_ac, wc);
    edge = (vc <= 0) & (d1 >= 0) & (d3 <= 0);
    wa = pick_side(edge, 1 - on_ab, wa);
    wb = pick_side(edge, on_ab, wb);
    wc = pick_side(edge, none, wc);
    sides_mask at_c = (d6 >= 0) & (d5 <= d6), at_b = (d3 >= 0) & (d4 <= d3);
    sides_mask at_a = (d1 <= 0) & (d2 <= 0);
    weight[0] = pick_side(at_a, one, pick_side(at_b | at_c, none, wa));
    weight[1] = pick_side(at_a, none, pick_side(at_b, one, pick_side(at_c, none, wb)));
    weight[2] = pick_side(at_a | at_b, none, pick_side(at_c, one, wc));
}

WIDE_CLONES
void facets_cell_nearest(const struct facets_cell *cell, struct vec3 point,
                         struct facets_cell_point *nearest) {
    const struct vec3 *at = cell->corner;
    struct sides3 a = on_all_sides(cell->middle), p = on_all_sides(point);
    struct sides3 b = {{at[0].x, at[1].x, at[2].x, at[3].x},
                       {at[0].y, at[1].y, at[2].y, at[3].y},
                       {at[0].z, at[1].z, at[2].z, at[3].z}};
    struct sides3 c = of_next_sides(b);
    sides w[3];
    weigh_nearest(a, b, p, w);
    struct sides3 r = {w[0] * a.x + w[1] * b.x + w[2] * c.x, w[0] * a.y + w[1] * b.y + w[2] * c.y,
                       w[0] * a.z + w[1] * b.z + w[2] * c.z};
    struct sides3 gap = minus(p, r);
    sides distance2 = dot_sides(gap, gap);
    int k = 0;
    for (int side = 1; side < FACETS_SIDES; side++)
        k = distance2[side] < distance2[k] ? side : k;
    *nearest = (struct facets_cell_point){
        k, {w[0][k], w[1][k], w[2][k]}, vec3_make(r.x[k], r.y[k], r.z[k]), distance2[k]};
}
