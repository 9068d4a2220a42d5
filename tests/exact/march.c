/* SPDX-License-Identifier: MIT */
#include "march.h"
#include "goursat.h"
#include "measure.h"
#include <assert.h>
#include <stdlib.h>

enum { NEWTON_MAX = 30, GENERATOR_BLOCKS = 16, GENERATOR_ORDER = 16 };

/* Once the residual is this small, the step just taken squares it. */
static const double NEARLY = 1e-9;

struct march {
    const struct plain_setup *setup;
    struct drape_nodes *nodes;
    struct grid grid;
    double *chord[2]; /* gib4: chord of the edge to (i-1, j) and to (i, j-1), by node */
};

static int place(const struct march *march, int i, int j) {
    const int *n = march->setup->n;
    return (j + n[1]) * (2 * n[0] + 1) + i + n[0];
}

static struct vec3 point(const struct march *march, int i, int j) {
    return node_point(march->nodes, place(march, i, j));
}

static void set_node(struct march *march, int i, int j, const double uv[2]) {
    int at = place(march, i, j);
    struct vec3 r = shape_point(march->setup->shape, uv);
    march->nodes->u[at] = uv[0];
    march->nodes->v[at] = uv[1];
    march->nodes->x[at] = r.x;
    march->nodes->y[at] = r.y;
    march->nodes->z[at] = r.z;
}

/* The arc length beyond `from` at which the chord from r is d: secant steps. */
static double equal_chord(const struct march *march, const struct exact_geodesic *geodesic,
                          double from, struct vec3 r, double d) {
    double s = from + d, uv[2];
    for (int it = 0; it < 12; it++) {
        exact_geodesic_at(geodesic, s, uv, NULL);
        s += d - vec3_distance(shape_point(march->setup->shape, uv), r);
    }
    return s;
}

/* One arm. Nodes lie at arc lengths l d; for basic, and in the corrected march, at equal or
 * corrected chords: what all other yarns get, or the first row would not fit. */
static void generator(struct march *march, int k, int sign, bool corrected) {
    const struct plain_setup *setup = march->setup;
    struct exact_geodesic_setup along = {
        .shape = setup->shape,
        .uv = {setup->uv[0], setup->uv[1]},
        .direction = vec3_scale(sign, k ? setup->weft : setup->warp),
        .length = setup->spacing[k] * setup->n[k] * 1.01,
        .blocks = GENERATOR_BLOCKS,
        .order = GENERATOR_ORDER,
    };
    struct exact_geodesic *geodesic = exact_geodesic_make(&along);
    double s = 0;
    for (int l = 1; l <= setup->n[k]; l++) {
        double uv[2], d = setup->spacing[k];
        int i = k ? 0 : sign * l, j = k ? sign * l : 0;
        struct vec3 last = k ? point(march, 0, j - sign) : point(march, i - sign, 0);
        int edge = sign > 0 ? l : 1 - l;
        if (corrected) {
            d = march->chord[k][k ? place(march, 0, edge) : place(march, edge, 0)];
        }
        bool by_chord = corrected || setup->method == DRAPE_BASIC;
        s = by_chord ? equal_chord(march, geodesic, s, last, d) : l * d;
        exact_geodesic_at(geodesic, s, uv, NULL);
        set_node(march, i, j, uv);
    }
    exact_geodesic_free(geodesic);
}

static void generators(struct march *march, bool corrected) {
    for (int k = 0; k < 4; k++) {
        generator(march, k / 2, k % 2 ? -1 : 1, corrected);
    }
}

/* Newton for |D - B| = b, |D - C| = c in (u, v). */
static void intersect(const struct shape *shape, struct vec3 rb, struct vec3 rc,
                      const double chord[2], double uv[2]) {
    for (int it = 0; it < NEWTON_MAX; it++) {
        struct surface_jet jet;
        shape_evaluate(shape, uv[0], uv[1], &jet);
        struct vec3 c = vec3_sub(jet.r, rc), b = vec3_sub(jet.r, rb);
        double f = (vec3_norm2(c) - chord[0] * chord[0]) / 2;
        double g = (vec3_norm2(b) - chord[1] * chord[1]) / 2;
        double fu = vec3_dot(c, jet.u), fv = vec3_dot(c, jet.v);
        double gu = vec3_dot(b, jet.u), gv = vec3_dot(b, jet.v), det = fu * gv - fv * gu;
        uv[0] -= (f * gv - g * fv) / det;
        uv[1] -= (g * fu - f * gu) / det;
        if (fabs(f) + fabs(g) < NEARLY * (chord[0] * chord[0] + chord[1] * chord[1])) {
            return;
        }
    }
}

static void step(struct march *march, int i, int j, bool corrected) {
    const struct plain_setup *setup = march->setup;
    const struct drape_nodes *nodes = march->nodes;
    int si = i < 0 ? -1 : 1, sj = j < 0 ? -1 : 1;
    int a = place(march, i - si, j - sj), b = place(march, i - si, j), c = place(march, i, j - sj);
    int d = place(march, i, j);
    double chord[2] = {setup->spacing[1], setup->spacing[0]};
    double uv[2] = {nodes->u[b] + nodes->u[c] - nodes->u[a],
                    nodes->v[b] + nodes->v[c] - nodes->v[a]};
    if (corrected) {
        chord[0] = march->chord[1][sj > 0 ? d : c];
        chord[1] = march->chord[0][si > 0 ? d : b];
    } else if (setup->method != DRAPE_BASIC) {
        gib_chords(setup->shape, nodes, &march->grid, i, j, setup->spacing, chord);
    }
    intersect(setup->shape, node_point(nodes, b), node_point(nodes, c), chord, uv);
    set_node(march, i, j, uv);
}

static void sweep(struct march *march, bool corrected) {
    const int *n = march->setup->n;
    for (int j = 1; j <= n[1]; j++) {
        for (int i = 1; i <= n[0]; i++) {
            step(march, i, j, corrected);
            step(march, -i, j, corrected);
            step(march, i, -j, corrected);
            step(march, -i, -j, corrected);
        }
    }
}

/* Node l of the yarn through (i, j) in direction k. */
static struct vec3 yarn(const struct march *march, int k, int i, int j, int l) {
    return k ? point(march, i, l) : point(march, l, j);
}

/* sum of w_m r_(l + m step), divided by nothing. */
static struct vec3 stencil(const struct march *march, int k, int i, int j, int first, int direction,
                           const double *w, int count) {
    struct vec3 sum = {0, 0, 0};
    for (int m = 0; m < count; m++) {
        sum = vec3_axpy(w[m], yarn(march, k, i, j, first + m * direction), sum);
    }
    return sum;
}

/* At node l of its yarn as the edge between `from` and `to` sees it: the error of the first net has
 * a kink across the generators, so differences stay on the edge's own side of them. */
static struct vec3 second_difference(const struct march *march, int k, int i, int j, int side) {
    static const double middle[] = {1, -2, 1}, end[] = {2, -5, 4, -1};
    int l = k ? j : i, n = march->setup->n[k];
    if (l == 0 || abs(l) == n) {
        return stencil(march, k, i, j, l, l == 0 ? side : -side, end, 4);
    }
    return stencil(march, k, i, j, l - 1, 1, middle, 3);
}

/* chord = d sqrt(1 - q / 12 - p (23 / 720 + 0.001786 q)), q = |M|^2 / d^2, M being D2 averaged over
 * both ends of the edge and p the square of what D2 changes across that, over d^2. */
static void correct_chords(struct march *march) {
    const struct plain_setup *setup = march->setup;
    for (int k = 0; k < 2; k++) {
        double d = setup->spacing[k];
        for (int j = -setup->n[1] + k; j <= setup->n[1]; j++) {
            for (int i = -setup->n[0] + 1 - k; i <= setup->n[0]; i++) {
                int side = (k ? j : i) > 0 ? 1 : -1;
                struct vec3 one = second_difference(march, k, i, j, side);
                struct vec3 two = second_difference(march, k, i - 1 + k, j - k, side);
                struct vec3 mean = vec3_scale(0.5, vec3_add(one, two));
                struct vec3 across = vec3_cross(vec3_unit(mean), vec3_sub(one, two));
                double q = vec3_norm2(mean) / (d * d), p = vec3_norm2(across) / (d * d);
                double share = 1 - q / 12 - p * (23.0 / 720 + 0.001786 * q);
                march->chord[k][place(march, i, j)] = d * sqrt(share);
            }
        }
    }
}

/* The tangent (length immaterial): three-point stencils of second order, or five-point ones. */
static struct vec3 tangent(const struct march *march, int k, int i, int j) {
    static const double three[2][3] = {{-1, 0, 1}, {-3, 4, -1}};
    static const double five[3][5] = {
        {1, -8, 0, 8, -1}, {-3, -10, 18, -6, 1}, {-25, 48, -36, 16, -3}};
    int l = k ? j : i, n = march->setup->n[k], gap = n - abs(l), inward = l < 0 ? 1 : -1;
    struct vec3 t;
    if (march->setup->method != DRAPE_BASIC) {
        int row = gap >= 2 ? 0 : 2 - gap;
        int first = row == 0 ? l - 2 : row == 1 ? l - inward : l;
        t = stencil(march, k, i, j, first, row ? inward : 1, five[row], 5);
        return row ? vec3_scale(inward, t) : t;
    }
    if (gap == 0) {
        return vec3_scale(inward, stencil(march, k, i, j, l, inward, three[1], 3));
    }
    return stencil(march, k, i, j, l - 1, 1, three[0], 3);
}

static void index_nodes(struct march *march) {
    const int *n = march->setup->n;
    for (int j = -n[1]; j <= n[1]; j++) {
        for (int i = -n[0]; i <= n[0]; i++) {
            march->nodes->i[place(march, i, j)] = i;
            march->nodes->j[place(march, i, j)] = j;
        }
    }
    grid_make(&march->grid, march->nodes);
}

static struct drape_nodes *nodes_new(size_t count) {
    struct drape_nodes *nodes = calloc(1, sizeof *nodes);
    assert(nodes);
    double **columns[] = {&nodes->u, &nodes->v, &nodes->x, &nodes->y, &nodes->z, &nodes->shear_deg};
    nodes->count = count;
    nodes->i = calloc(count, sizeof *nodes->i);
    nodes->j = calloc(count, sizeof *nodes->j);
    assert(nodes->i && nodes->j);
    for (int k = 0; k < 6; k++) {
        *columns[k] = calloc(count, sizeof(double));
        assert(*columns[k]);
    }
    return nodes;
}

struct drape_nodes *plain_make(const struct plain_setup *setup) {
    size_t count = (size_t)((2 * setup->n[0] + 1) * (2 * setup->n[1] + 1));
    struct march march = {.setup = setup, .nodes = nodes_new(count)};
    index_nodes(&march);
    set_node(&march, 0, 0, setup->uv);
    for (int k = 0; k < 2; k++) {
        march.chord[k] = calloc(count, sizeof(double));
        assert(march.chord[k]);
    }
    generators(&march, false);
    sweep(&march, false);
    if (setup->method == DRAPE_GIB4) {
        correct_chords(&march);
        generators(&march, true);
        sweep(&march, true);
    }
    for (size_t k = 0; k < count; k++) {
        int i = march.nodes->i[k], j = march.nodes->j[k];
        double w = vec3_angle(tangent(&march, 0, i, j), tangent(&march, 1, i, j));
        march.nodes->shear_deg[k] = 90 - w * 180 / M_PI;
    }
    grid_free(&march.grid);
    free(march.chord[0]);
    free(march.chord[1]);
    return march.nodes;
}

void plain_free(struct drape_nodes *nodes) {
    if (nodes) {
        double *columns[] = {nodes->u, nodes->v, nodes->x, nodes->y, nodes->z, nodes->shear_deg};
        for (int k = 0; k < 6; k++) {
            free(columns[k]);
        }
        free(nodes->i);
        free(nodes->j);
        free(nodes);
    }
}
