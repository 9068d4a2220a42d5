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

/* Places of one yarn round a node, NULL beyond its ends. */
struct yarn {
    const struct net_node *node[2 * REACH + 1];
    int back, ahead; /* places before and after the node */
};

/* How far the yarn through (x, y) along (dx, dy) goes on from there, up to `most` places, and its
 * nodes. */
static int follow(const struct net_window *window, int x, int y, int dx, int dy, int most,
                  struct yarn *yarn) {
    int count = 0, sign = dx + dy;
    for (; count < most; count++) {
        int k = count + 1;
        if (!(yarn->node[REACH + sign * k] = net_window_place(window, x + k * dx, y + k * dy)))
            break;
    }
    return count;
}

/* The yarn's direction by the first stencil that fits, not a unit vector; zero when none does. */
static struct vec3 difference(const struct yarn *yarn, int first_stencil) {
    struct vec3 sum = {0, 0, 0};
    for (int s = first_stencil; s < STENCILS; s++) {
        const struct stencil *stencil = &stencils[s];
        if (-stencil->from > yarn->back || stencil->to > yarn->ahead)
            continue;
        for (int k = stencil->from; k <= stencil->to; k++)
            sum = vec3_axpy(stencil->weight[k - stencil->from], yarn->node[REACH + k]->r, sum);
        break;
    }
    return sum;
}

static struct vec3 tangent(const struct net_window *window, int x, int y, int dx, int dy,
                           enum shear_order order) {
    struct yarn yarn;
    if (order == SHEAR_SECOND) {
        const struct net_node *ahead = net_window_place(window, x + dx, y + dy);
        const struct net_node *back = net_window_place(window, x - dx, y - dy);
        if (ahead && back)
            return vec3_sub(ahead->r, back->r);
    }
    int most = order == SHEAR_FOURTH ? REACH : 2;
    yarn.node[REACH] = net_window_place(window, x, y);
    yarn.ahead = follow(window, x, y, dx, dy, most, &yarn);
    yarn.back = follow(window, x, y, -dx, -dy, most, &yarn);
    return difference(&yarn, order == SHEAR_FOURTH ? 0 : FIRST_OF_SECOND_ORDER);
}

static double shear_between(struct vec3 warp, struct vec3 weft) {
    bool both = vec3_norm2(warp) > 0 && vec3_norm2(weft) > 0;
    return both ? angle_atan2_deg(vec3_dot(warp, weft), vec3_norm(vec3_cross(warp, weft))) : 0;
}

double shear_at_node(const struct net_window *window, int x, int y, enum shear_order order) {
    return shear_between(tangent(window, x, y, 1, 0, order), tangent(window, x, y, 0, 1, order));
}

struct shear_cell shear_of_cell(struct vec3 a, struct vec3 b, struct vec3 c, struct vec3 d) {
    struct shear_cell cell;
    cell.warp = vec3_unit(vec3_add(vec3_sub(b, a), vec3_sub(c, d)));
    cell.weft = vec3_unit(vec3_add(vec3_sub(d, a), vec3_sub(c, b)));
    cell.shear_deg = shear_between(cell.warp, cell.weft);
    return cell;
}
