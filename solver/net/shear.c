/* SPDX-License-Identifier: MIT */
#include "shear.h"

#include "solver/angle.h"
#include "solver/wide.h"

enum { POINTS = 5, STENCILS = 10, FIRST_OF_SECOND_ORDER = 5 };

/* First derivatives along a yarn, up to a positive factor, from the places from .. to. */
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

/* The yarn's direction at (x, y) by a stencil, not a unit vector; false where the yarn does not
 * have all its places. */
static bool difference(const struct net_window *window, int x, int y, int dx, int dy,
                       const struct stencil *stencil, struct vec3 *sum) {
    *sum = vec3_make(0, 0, 0);
    for (int k = stencil->from; k <= stencil->to; k++) {
        const struct net_node *node = net_window_place(window, x + k * dx, y + k * dy);
        if (!node)
            return false;
        *sum = vec3_axpy(stencil->weight[k - stencil->from], node->r, *sum);
    }
    return true;
}

/* By the first stencil that fits; zero when none does. That of most nodes is there in short. */
static struct vec3 tangent(const struct net_window *window, int x, int y, int dx, int dy,
                           enum shear_order order) {
    struct vec3 sum;
    if (order == SHEAR_SECOND) {
        const struct net_node *ahead = net_window_place(window, x + dx, y + dy);
        const struct net_node *back = net_window_place(window, x - dx, y - dy);
        if (ahead && back)
            return vec3_sub(ahead->r, back->r);
    }
    for (int s = order == SHEAR_FOURTH ? 0 : FIRST_OF_SECOND_ORDER; s < STENCILS; s++)
        if (difference(window, x, y, dx, dy, &stencils[s], &sum))
            return sum;
    return vec3_make(0, 0, 0);
}

static void add(struct shear_row *row, struct vec3 warp, struct vec3 weft) {
    const double a[3] = {warp.x, warp.y, warp.z}, b[3] = {weft.x, weft.y, weft.z};
    for (int k = 0; k < 3; k++) {
        row->warp[k][row->count] = a[k];
        row->weft[k][row->count] = b[k];
    }
    row->count++;
}

void shear_add_node(struct shear_row *row, const struct net_window *window, int x, int y,
                    enum shear_order order) {
    add(row, tangent(window, x, y, 1, 0, order), tangent(window, x, y, 0, 1, order));
}

/* The second difference of a yarn over an edge from (x, y), as the mean of those at its two ends or
 * the one there is; zero when there is none. */
static struct vec3 bend(const struct net_window *window, int x, int y, int dx, int dy,
                        struct vec3 from, struct vec3 to) {
    const struct net_node *back = net_window_place(window, x - dx, y - dy);
    const struct net_node *ahead = net_window_place(window, x + 2 * dx, y + 2 * dy);
    struct vec3 chord = vec3_sub(to, from), sum = vec3_make(0, 0, 0);
    if (back)
        sum = vec3_add(sum, vec3_sub(chord, vec3_sub(from, back->r)));
    if (ahead)
        sum = vec3_add(sum, vec3_sub(vec3_sub(ahead->r, to), chord));
    return back && ahead ? vec3_scale(0.5, sum) : sum;
}

void shear_add_cell(struct shear_row *row, const struct net_window *window, int x, int y,
                    const struct vec3 corner[4], bool rough) {
    struct vec3 a = corner[0], b = corner[1], c = corner[2], d = corner[3];
    struct vec3 warp = vec3_add(vec3_sub(b, a), vec3_sub(c, d));
    struct vec3 weft = vec3_add(vec3_sub(d, a), vec3_sub(c, b));
    if (rough) {
        add(row, warp, weft);
        return;
    }
    struct vec3 twist = vec3_add(vec3_sub(a, b), vec3_sub(c, d));
    struct vec3 bends = vec3_add(bend(window, x, y, 1, 0, a, b), bend(window, x, y, 0, 1, a, d));
    double turn = 2 * vec3_dot(twist, bends) / 6; /* half of it each, by the same angle */
    add(row, vec3_axpy(turn / vec3_norm2(weft), weft, warp),
        vec3_axpy(turn / vec3_norm2(warp), warp, weft));
}

void shear_set_angle(struct vec3 *warp, struct vec3 *weft, double w_deg) {
    double sine, cosine;
    struct vec3 middle = vec3_unit(vec3_add(*warp, *weft));
    struct vec3 side = vec3_unit(vec3_sub(*weft, *warp));
    angle_sincos_deg(w_deg / 2, &sine, &cosine);
    *warp = vec3_axpy(-sine, side, vec3_scale(cosine, middle));
    *weft = vec3_axpy(sine, side, vec3_scale(cosine, middle));
}

/* ---- a row at once: loops without branches, so that they become vector instructions ---- */

INLINE void normalise(double v[3][SHEAR_PLACES]) {
    for (int k = 0; k < SHEAR_PLACES; k++) {
        double length = sqrt(v[0][k] * v[0][k] + v[1][k] * v[1][k] + v[2][k] * v[2][k]);
        double inverse = 1 / (length > 0 ? length : 1);
        v[0][k] *= inverse;
        v[1][k] *= inverse;
        v[2][k] *= inverse;
    }
}

WIDE_CLONES
void shear_normalise(struct shear_row *row) {
    normalise(row->warp);
    normalise(row->weft);
}

/* With w the angle between the yarns and gamma = 90 deg - w,
 * tan(gamma / 2) = sin gamma / (1 + cos gamma) = g.e / (|g| |e| + |g x e|). */
INLINE void half_tangents(const struct shear_row *row, double *t) {
    const double *gx = row->warp[0], *gy = row->warp[1], *gz = row->warp[2];
    const double *ex = row->weft[0], *ey = row->weft[1], *ez = row->weft[2];
    for (int k = 0; k < SHEAR_PLACES; k++) {
        double gg = gx[k] * gx[k] + gy[k] * gy[k] + gz[k] * gz[k];
        double ee = ex[k] * ex[k] + ey[k] * ey[k] + ez[k] * ez[k];
        double ge = gx[k] * ex[k] + gy[k] * ey[k] + gz[k] * ez[k];
        double cx = gy[k] * ez[k] - gz[k] * ey[k], cy = gz[k] * ex[k] - gx[k] * ez[k];
        double cz = gx[k] * ey[k] - gy[k] * ex[k];
        double whole = sqrt(gg * ee) + sqrt(cx * cx + cy * cy + cz * cz);
        t[k] = ge / (whole > 0 ? whole : 1);
    }
}

WIDE_CLONES
void shear_angles(const struct shear_row *row, double *shear_deg) {
    double t[SHEAR_PLACES];
    half_tangents(row, t);
    for (int k = 0; k < row->count; k++)
        shear_deg[k] = 2 * angle_atan_deg(t[k]);
}
