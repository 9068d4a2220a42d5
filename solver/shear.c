/* SPDX-License-Identifier: MIT */
#include "shear.h"

#include "angle.h"

enum { REACH = 4, POINTS = 5, STENCILS = 10, FIRST_OF_SECOND_ORDER = 5 };

/* First derivatives, up to a positive factor, from the places from .. from + POINTS - 1. */
struct stencil {
    int from, to;
    double weight[POINTS];
};

/* In the order in which they are preferred. */
static const struct stencil stencils[STENCILS] = {
    {-2, 2, {1, -8, 0, 8, -1}},
    {-1, 3, {-3, -10, 18, -6, 1}},
    {-3, 1, {-1, 6, -18, 10, 3}},
    {0, 4, {-25, 48, -36, 16, -3}},
    {-4, 0, {3, -16, 36, -48, 25}},
    {-1, 1, {-1, 0, 1}},
    {0, 2, {-3, 4, -1}},
    {-2, 0, {1, -4, 3}},
    {0, 1, {-1, 1}},
    {-1, 0, {-1, 1}},
};

/* The yarn's direction at (i, j) along (di, dj), not a unit vector; zero where no yarn passes. */
static struct vec3 tangent(struct net *net, int32_t i, int32_t j, int di, int dj,
                           enum shear_order order) {
    const struct net_node *node[2 * REACH + 1];
    int back = 0, ahead = 0, most = order == SHEAR_FOURTH ? REACH : 2;
    node[REACH] = net_place(net, i, j);
    for (; ahead < most; ahead++) {
        int k = ahead + 1;
        if (!(node[REACH + k] = net_place(net, i + k * di, j + k * dj)))
            break;
    }
    for (; back < most; back++) {
        int k = back + 1;
        if (!(node[REACH - k] = net_place(net, i - k * di, j - k * dj)))
            break;
    }
    struct vec3 sum = {0, 0, 0};
    for (int s = order == SHEAR_FOURTH ? 0 : FIRST_OF_SECOND_ORDER; s < STENCILS; s++) {
        const struct stencil *stencil = &stencils[s];
        if (-stencil->from > back || stencil->to > ahead)
            continue;
        for (int k = stencil->from; k <= stencil->to; k++)
            sum = vec3_axpy(stencil->weight[k - stencil->from], node[REACH + k]->r, sum);
        break;
    }
    return sum;
}

static double shear_between(struct vec3 warp, struct vec3 weft) {
    bool both = vec3_norm2(warp) > 0 && vec3_norm2(weft) > 0;
    return both ? angle_atan2_deg(vec3_dot(warp, weft), vec3_norm(vec3_cross(warp, weft))) : 0;
}

double shear_at_node(struct net *net, int32_t i, int32_t j, enum shear_order order) {
    return shear_between(tangent(net, i, j, 1, 0, order), tangent(net, i, j, 0, 1, order));
}

struct shear_cell shear_of_cell(struct vec3 a, struct vec3 b, struct vec3 c, struct vec3 d) {
    struct shear_cell cell;
    cell.warp = vec3_unit(vec3_add(vec3_sub(b, a), vec3_sub(c, d)));
    cell.weft = vec3_unit(vec3_add(vec3_sub(d, a), vec3_sub(c, b)));
    cell.shear_deg = shear_between(cell.warp, cell.weft);
    return cell;
}
