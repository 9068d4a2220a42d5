/* SPDX-License-Identifier: MIT */
#include "shear.h"

#include "solver/angle.h"
#include "solver/wide.h"
#include <string.h>

/* Half the shear, in radians, that is rounding: flat cloth has 0, not 1e-12 degrees. Nodes are
 * found to 1e-12 spacings. */
static const double shear_rounding = 4e-11;

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

/* The yarn's direction at (x, y), not a unit vector, by the first stencil all places of which the
 * yarn has; zero when there is none. That of most nodes is there in short. */
static struct vec3 tangent(const struct net_window *window, int x, int y, int dx, int dy,
                           enum shear_order order) {
    if (order == SHEAR_SECOND) {
        const struct net_node *ahead = net_window_place(window, x + dx, y + dy);
        const struct net_node *back = net_window_place(window, x - dx, y - dy);
        if (ahead && back)
            return vec3_sub(ahead->r, back->r);
    }
    for (int s = order == SHEAR_FOURTH ? 0 : FIRST_OF_SECOND_ORDER; s < STENCILS; s++) {
        const struct stencil *stencil = &stencils[s];
        struct vec3 sum = vec3_make(0, 0, 0);
        bool whole = true;
        for (int k = stencil->from; k <= stencil->to && whole; k++) {
            const struct net_node *node = net_window_place(window, x + k * dx, y + k * dy);
            whole = node != NULL;
            if (whole)
                sum = vec3_axpy(stencil->weight[k - stencil->from], node->r, sum);
        }
        if (whole)
            return sum;
    }
    return vec3_make(0, 0, 0);
}

static void set_directions(struct shear_row *row, int x, struct vec3 warp, struct vec3 weft) {
    vec3_to_columns(warp, row->warp[0], row->warp[1], row->warp[2], (size_t)x);
    vec3_to_columns(weft, row->weft[0], row->weft[1], row->weft[2], (size_t)x);
}

void shear_node(struct shear_row *row, const struct net_window *window, int x, int y,
                enum shear_order order) {
    set_directions(row, x, tangent(window, x, y, 1, 0, order), tangent(window, x, y, 0, 1, order));
}

/* The second difference of a yarn over an edge from (x, y), as the mean of those at its two ends or
 * the one there is; zero when there is none. */
static struct vec3 yarn_bend(const struct net_window *window, int x, int y, int dx, int dy,
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

/* The square of the sine of the yarns' angle, at least: flatter cells are turned by less. */
static const double least_sine2 = 0.1;

/* What to turn a cell's means e and f by, half of it each: e + turn / f^2 f and f + turn / e^2 e.
 * From the products (e, e), (f, f), (e, f), that of the twist with both bends, and those of the
 * bend along e, the twist and the bend along f with e x f, whose square is `cross2`. */
INLINE double cell_turn(const double product[3], double twist_bend, const double across[3],
                        double cross2) {
    double ee = product[0], ff = product[1], ef = product[2], whole = ee * ff;
    double by = 1 / (cross2 > 0 ? cross2 : 1), twist2 = across[1] * across[1] * by;
    double shorter = (across[0] * across[0] * by / 3 + twist2) / ee +
                     (across[2] * across[2] * by / 3 + twist2) / ff;
    double least = least_sine2 * whole, sine2 = cross2 > least ? cross2 : least;
    return (twist_bend / 3 - ef * shorter / 4) * whole / sine2;
}

void shear_cell(struct shear_row *row, const struct net_window *window, int x, int y, bool rough) {
    struct vec3 a = net_window_find(window, x, y)->r, b = net_window_find(window, x + 1, y)->r;
    struct vec3 c = net_window_find(window, x + 1, y + 1)->r;
    struct vec3 d = net_window_find(window, x, y + 1)->r;
    struct vec3 warp = vec3_add(vec3_sub(b, a), vec3_sub(c, d));
    struct vec3 weft = vec3_add(vec3_sub(d, a), vec3_sub(c, b));
    if (rough) {
        set_directions(row, x, warp, weft);
        return;
    }
    struct vec3 twist = vec3_add(vec3_sub(a, b), vec3_sub(c, d));
    struct vec3 p = yarn_bend(window, x, y, 1, 0, a, b), q = yarn_bend(window, x, y, 0, 1, a, d);
    struct vec3 cross = vec3_cross(warp, weft);
    const double product[3] = {vec3_norm2(warp), vec3_norm2(weft), vec3_dot(warp, weft)};
    const double across[3] = {vec3_dot(p, cross), vec3_dot(twist, cross), vec3_dot(q, cross)};
    double turn = cell_turn(product, vec3_dot(twist, vec3_add(p, q)), across, vec3_norm2(cross));
    set_directions(row, x, vec3_axpy(turn / vec3_norm2(weft), weft, warp),
                   vec3_axpy(turn / vec3_norm2(warp), warp, weft));
}

/* tan(gamma / 2) = x.y / (|x| |y| + |x cross y|) */
double shear_between_deg(const struct vec3 along[2]) {
    double square = vec3_norm2(along[0]) * vec3_norm2(along[1]);
    double whole = sqrt(square) + vec3_norm(vec3_cross(along[0], along[1]));
    double half_tangent = whole > 0 ? vec3_dot(along[0], along[1]) / whole : 0;
    return shear_rounded(2 * angle_atan_deg(half_tangent));
}

double shear_rounded(double shear_deg) {
    return fabs(shear_deg) > 2 * shear_rounding * (180 / ANGLE_PI) ? shear_deg : 0;
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

/* `count` places of a row of the window from x on, which are one tile's. */
INLINE void load_places(struct shear_block *block, const struct net_window *window, int n, int x,
                        int y, int count) {
    const struct net_node *from = net_window_find(window, x, y);
    int to = x + SHEAR_REACH;
    for (int k = 0; k < 3 && !from; k++)
        memset(&block->r[k][n][to], 0, (size_t)count * sizeof(double));
    for (int k = 0; k < count && from; k++) {
        block->r[0][n][to + k] = from[k].r.x;
        block->r[1][n][to + k] = from[k].r.y;
        block->r[2][n][to + k] = from[k].r.z;
    }
}

void shear_load(struct shear_block *block, const struct net_window *window, int y) {
    for (int n = 0; n < SHEAR_ROWS; n++) {
        int from = y + n - SHEAR_REACH;
        load_places(block, window, n, -SHEAR_REACH, from, SHEAR_REACH);
        load_places(block, window, n, 0, from, NET_TILE);
        load_places(block, window, n, NET_TILE, from, SHEAR_REACH);
        block->place[n] =
            (uint32_t)(net_window_row(window, NET_BIT_PLACE, from) >> (NET_TILE - SHEAR_REACH)) &
            ((1u << (SHEAR_PLACES + 2 * SHEAR_REACH)) - 1);
    }
}

/* The places of row y, as own bits. */
static uint32_t places(const struct shear_block *block, int x, int y) {
    return block->place[y + SHEAR_REACH] >> (x + SHEAR_REACH) & ((1u << SHEAR_PLACES) - 1);
}

/* Where block->r of the place (x, y) off a place begins. */
INLINE const double *row_from(const struct shear_block *block, int k, int x, int y) {
    return &block->r[k][y + SHEAR_REACH][x + SHEAR_REACH];
}

INLINE void differences(const struct shear_block *block, int dx, int dy, enum shear_order order,
                        double (*to)[SHEAR_PLACES]) {
    for (int k = 0; k < 3; k++) {
        const double *a = row_from(block, k, -2 * dx, -2 * dy), *b = row_from(block, k, -dx, -dy);
        const double *c = row_from(block, k, 0, 0), *d = row_from(block, k, dx, dy);
        const double *e = row_from(block, k, 2 * dx, 2 * dy);
        if (order == SHEAR_SECOND)
            for (int x = 0; x < SHEAR_PLACES; x++)
                to[k][x] = d[x] - b[x];
        else
            for (int x = 0; x < SHEAR_PLACES; x++)
                to[k][x] = a[x] + -8 * b[x] + 0 * c[x] + 8 * d[x] - e[x];
    }
}

WIDE_CLONES
uint32_t shear_nodes(const struct shear_block *block, enum shear_order order,
                     struct shear_row *row) {
    uint32_t all =
        places(block, -1, 0) & places(block, 1, 0) & places(block, 0, -1) & places(block, 0, 1);
    if (order == SHEAR_FOURTH)
        all &=
            places(block, -2, 0) & places(block, 2, 0) & places(block, 0, -2) & places(block, 0, 2);
    differences(block, 1, 0, order, row->warp);
    differences(block, 0, 1, order, row->weft);
    return all;
}

/* What shear_cell has of a cell, for a row: its four sides' sums and differences, one coordinate.
 */
INLINE void cell_sums(const struct shear_block *block, int k, double *warp, double *weft,
                      double *twist, double *bend_warp, double *bend_weft) {
    const double *a = row_from(block, k, 0, 0), *b = row_from(block, k, 1, 0);
    const double *c = row_from(block, k, 1, 1), *d = row_from(block, k, 0, 1);
    const double *left = row_from(block, k, -1, 0), *right = row_from(block, k, 2, 0);
    const double *down = row_from(block, k, 0, -1), *up = row_from(block, k, 0, 2);
    for (int x = 0; x < SHEAR_PLACES; x++) {
        double ab = b[x] - a[x], ad = d[x] - a[x];
        warp[x] = ab + (c[x] - d[x]);
        weft[x] = ad + (c[x] - b[x]);
        twist[x] = (a[x] - b[x]) + (c[x] - d[x]);
        bend_warp[x] = 0.5 * ((ab - (a[x] - left[x])) + ((right[x] - b[x]) - ab));
        bend_weft[x] = 0.5 * ((ad - (a[x] - down[x])) + ((up[x] - d[x]) - ad));
    }
}

INLINE double dot_at(double (*a)[SHEAR_PLACES], double (*b)[SHEAR_PLACES], int x) {
    return a[0][x] * b[0][x] + a[1][x] * b[1][x] + a[2][x] * b[2][x];
}

WIDE_CLONES
uint32_t shear_cells(const struct shear_block *block, struct shear_row *row, double *area) {
    double warp[3][SHEAR_PLACES], weft[3][SHEAR_PLACES];
    double twist[3][SHEAR_PLACES], p[3][SHEAR_PLACES], q[3][SHEAR_PLACES];
    double cross[3][SHEAR_PLACES];
    for (int k = 0; k < 3; k++)
        cell_sums(block, k, warp[k], weft[k], twist[k], p[k], q[k]);
    for (int x = 0; x < SHEAR_PLACES; x++)
        for (int k = 0; k < 3; k++) {
            int l = (k + 1) % 3, m = (k + 2) % 3;
            cross[k][x] = warp[l][x] * weft[m][x] - warp[m][x] * weft[l][x];
        }
    for (int x = 0; x < SHEAR_PLACES; x++) {
        const double product[3] = {dot_at(warp, warp, x), dot_at(weft, weft, x),
                                   dot_at(warp, weft, x)};
        const double across[3] = {dot_at(p, cross, x), dot_at(twist, cross, x),
                                  dot_at(q, cross, x)};
        double turn = cell_turn(product, dot_at(twist, p, x) + dot_at(twist, q, x), across,
                                dot_at(cross, cross, x));
        double to_warp = turn / product[1], to_weft = turn / product[0];
        for (int k = 0; k < 3; k++) {
            row->warp[k][x] = warp[k][x] + to_warp * weft[k][x];
            row->weft[k][x] = weft[k][x] + to_weft * warp[k][x];
        }
    }
    const double *a[3], *b[3], *c[3], *d[3];
    for (int k = 0; k < 3; k++) {
        a[k] = row_from(block, k, 0, 0);
        b[k] = row_from(block, k, 1, 0);
        c[k] = row_from(block, k, 1, 1);
        d[k] = row_from(block, k, 0, 1);
    }
    for (int x = 0; x < SHEAR_PLACES; x++) {
        double px = c[0][x] - a[0][x], py = c[1][x] - a[1][x], pz = c[2][x] - a[2][x];
        double qx = d[0][x] - b[0][x], qy = d[1][x] - b[1][x], qz = d[2][x] - b[2][x];
        double nx = py * qz - pz * qy, ny = pz * qx - px * qz, nz = px * qy - py * qx;
        area[x] = sqrt(nx * nx + ny * ny + nz * nz) / 2;
    }
    return places(block, -1, 0) & places(block, 2, 0) & places(block, 0, -1) & places(block, 0, 2);
}

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

/* With w the angle between the yarns and gamma = 90 deg - w, tan(gamma / 2) = sin gamma / (1 + cos
 * gamma) = g.e / (|g| |e| + |g x e|). Then as angle_atan_deg, its table looked up in between. */
WIDE_CLONES
void shear_angles(const struct shear_row *row, double *shear_deg) {
    double t[SHEAR_PLACES], near[SHEAR_PLACES];
    int next[SHEAR_PLACES];
    const double *gx = row->warp[0], *gy = row->warp[1], *gz = row->warp[2];
    const double *ex = row->weft[0], *ey = row->weft[1], *ez = row->weft[2];
    for (int k = 0; k < SHEAR_PLACES; k++) {
        double gg = gx[k] * gx[k] + gy[k] * gy[k] + gz[k] * gz[k];
        double ee = ex[k] * ex[k] + ey[k] * ey[k] + ez[k] * ez[k];
        double ge = gx[k] * ex[k] + gy[k] * ey[k] + gz[k] * ez[k];
        double cx = gy[k] * ez[k] - gz[k] * ey[k], cy = gz[k] * ex[k] - gx[k] * ez[k];
        double cz = gx[k] * ey[k] - gy[k] * ex[k];
        double whole = sqrt(gg * ee) + sqrt(cx * cx + cy * cy + cz * cz);
        double ratio = ge / (whole > 0 ? whole : 1);
        bool is_shear = fabs(ratio) <= 1.01 && fabs(ratio) > shear_rounding;
        t[k] = is_shear ? ratio : 0; /* NaN where there is no node */
    }
    for (int k = 0; k < SHEAR_PLACES; k++)
        next[k] = angle_next_sixteenth(fabs(t[k]));
    for (int k = 0; k < SHEAR_PLACES; k++)
        near[k] = angle_arctangents[next[k]];
    for (int k = 0; k < SHEAR_PLACES; k++) {
        double angle = angle_atan_from(next[k], near[k], fabs(t[k])) * (180 / ANGLE_PI);
        shear_deg[k] = 2 * copysign(angle, t[k]);
    }
}
