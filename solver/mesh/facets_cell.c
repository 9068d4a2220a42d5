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

INLINE sides select(sides_mask choose, sides a, sides b) {
    return (sides)(((sides_mask)a & choose) | ((sides_mask)b & ~choose));
}

/* That of the next side. */
INLINE sides next(sides a) {
    return __builtin_shufflevector(a, a, 1, 2, 3, 0);
}

INLINE struct sides3 next3(struct sides3 a) {
    return (struct sides3){next(a.x), next(a.y), next(a.z)};
}

INLINE struct sides3 sub(struct sides3 a, struct sides3 b) {
    return (struct sides3){a.x - b.x, a.y - b.y, a.z - b.z};
}

INLINE sides dot(struct sides3 a, struct sides3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

INLINE struct sides3 all(struct vec3 a) {
    const sides zero = {0};
    return (struct sides3){a.x - zero, a.y - zero, a.z - zero};
}

INLINE struct sides3 corners_of(const struct facets_cell *cell) {
    const struct vec3 *c = cell->corner;
    return (struct sides3){{c[0].x, c[1].x, c[2].x, c[3].x},
                           {c[0].y, c[1].y, c[2].y, c[3].y},
                           {c[0].z, c[1].z, c[2].z, c[3].z}};
}

/* The share of an edge before the foot on it, within it; 0 on one without length. */
INLINE sides share(sides along, sides length2) {
    sides t = select(length2 > 0, along / length2, (sides){0});
    return select(t > 0, select(t < 1, t, 1 - (sides){0}), (sides){0});
}

/* The weights of the places in the triangles a b c, a being the middle, nearest to p (C. Ericson,
 * Real-time collision detection, 5.1.5): the regions of the corners and edges first, by the signs
 * of dot products. A triangle without area has only edges. All of c is b of the next side. */
INLINE void project(struct sides3 a, struct sides3 b, struct sides3 p, sides weight[3]) {
    const sides none = {0}, one = 1 - none;
    struct sides3 ab = sub(b, a), ap = sub(p, a), bp = sub(p, b), bc = sub(next3(b), b);
    sides d1 = dot(ab, ap), d2 = next(d1), d3 = dot(ab, bp), d6 = next(d3);
    sides d4 = dot(next3(ab), bp), d5 = dot(ab, next3(bp));
    sides va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    sides sum = va + vb + vc, wb = vb / sum, wc = vc / sum, wa = 1 - wb - wc;
    wa = select(wa > 0, wa, none);
    sides on_ab = share(d1, dot(ab, ab)), on_ac = next(on_ab),
          on_bc = share(dot(bp, bc), dot(bc, bc));
    /* From the last region to the first, which overrides those after it. */
    sides_mask edge = va <= 0;
    wa = select(edge, none, wa);
    wb = select(edge, 1 - on_bc, wb);
    wc = select(edge, on_bc, wc);
    edge = (vb <= 0) & (d2 >= 0) & (d6 <= 0);
    wa = select(edge, 1 - on_ac, wa);
    wb = select(edge, none, wb);
    wc = select(edge, on_ac, wc);
    edge = (vc <= 0) & (d1 >= 0) & (d3 <= 0);
    wa = select(edge, 1 - on_ab, wa);
    wb = select(edge, on_ab, wb);
    wc = select(edge, none, wc);
    sides_mask at_c = (d6 >= 0) & (d5 <= d6), at_b = (d3 >= 0) & (d4 <= d3);
    sides_mask at_a = (d1 <= 0) & (d2 <= 0);
    weight[0] = select(at_a, one, select(at_b | at_c, none, wa));
    weight[1] = select(at_a, none, select(at_b, one, select(at_c, none, wb)));
    weight[2] = select(at_a | at_b, none, select(at_c, one, wc));
}

WIDE_CLONES
void facets_cell_nearest(const struct facets_cell *cell, struct vec3 point,
                         struct facets_cell_point *place) {
    struct sides3 a = all(cell->middle), b = corners_of(cell), c = next3(b), p = all(point);
    sides w[3];
    project(a, b, p, w);
    struct sides3 r = {w[0] * a.x + w[1] * b.x + w[2] * c.x, w[0] * a.y + w[1] * b.y + w[2] * c.y,
                       w[0] * a.z + w[1] * b.z + w[2] * c.z};
    struct sides3 gap = sub(p, r);
    sides distance2 = dot(gap, gap);
    int k = 0;
    for (int side = 1; side < FACETS_SIDES; side++)
        k = distance2[side] < distance2[k] ? side : k;
    *place = (struct facets_cell_point){
        k, {w[0][k], w[1][k], w[2][k]}, vec3_make(r.x[k], r.y[k], r.z[k]), distance2[k]};
}
