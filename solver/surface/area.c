/* SPDX-License-Identifier: MIT */
/*
 * The area of a surface, int |r_u x r_v| du dv, and its first and second moment, span by span by
 * Gauss and Legendre's rule. Where weights of very different size crowd most of a span into a
 * corner of its parameters, or the patch turns inside out along a line, no rule of a few points
 * knows it: a piece of a span in which the integrand does not die out in Legendre's polynomials is
 * halved.
 */
#include "quadrature.h"
#include "spans.h"

enum { DEPTH = 60, PIECES_MOST = 8000 };

/* Of the share of a piece the square of that of its last polynomials is about what is wrong of it:
 * as a part of the whole it may be this. */
static const double unresolved = 1e-6;

struct sums {
    double area;
    struct vec3 moment;
    double square; /* of the distance from the middle of the surface's box */
};

struct piece {
    int span[2], depth;
    double from[2], half[2];
    int along;    /* the direction in which it is resolved worst */
    double wrong; /* about what is wrong of its area */
};

/* Adds a piece to the sums, which in the order of its points are the same bits whatever its tail.
 */
static void integrate_piece(const struct surface *surface, const struct quadrature *rule,
                            struct piece *piece, struct sums *sums) {
    const double *half = piece->half;
    struct surface_element elements[QUADRATURE_MAX * QUADRATURE_MAX];
    double u[QUADRATURE_MAX] = {0}, v[QUADRATURE_MAX] = {0},
           density[QUADRATURE_MAX * QUADRATURE_MAX];
    double tail[2] = {0, 0}, before = sums->area;
    int n = rule->count;
    for (int k = 0; k < n; k++) {
        u[k] = piece->from[0] + half[0] * (1 + rule->node[k]);
        v[k] = piece->from[1] + half[1] * (1 + rule->node[k]);
    }
    const struct surface_grid grid = {{piece->span[0], piece->span[1]}, {n, n}, {u, v}};
    if (surface->height == 0)
        surface_evaluate_grid(surface, &grid, elements);
    for (int k = 0; k < n * n && surface->height != 0; k++) {
        struct surface_jet jet;
        surface_evaluate_span(surface, grid.span[0], grid.span[1], u[k / n], v[k % n], &jet);
        elements[k] = (struct surface_element){jet.r, jet.u, jet.v};
    }
    for (int a = 0; a < n; a++)
        for (int b = 0; b < n; b++) {
            const struct surface_element *at = &elements[a * n + b];
            double own = vec3_norm(vec3_cross(at->u, at->v));
            double element = own * half[0] * half[1] * rule->weight[a] * rule->weight[b];
            density[a * n + b] = own;
            sums->area += element;
            sums->moment = vec3_axpy(element, at->r, sums->moment);
            sums->square += element * vec3_norm2(vec3_sub(at->r, surface_box_middle(surface)));
        }
    for (int k = 0; k < n; k++) {
        tail[0] += rule->weight[k] * quadrature_tail(rule, density + k, n);
        tail[1] += rule->weight[k] * quadrature_tail(rule, density + k * n, 1);
    }
    double area = sums->area - before, most = (tail[0] + tail[1]) * half[0] * half[1];
    piece->along = tail[1] > tail[0];
    piece->wrong = area > 0 ? most * most / area : 0;
}

/* Adds the halves of a piece, or theirs, as long as `left` of them may be looked at and more than
 * `most` is wrong of each. */
static void refine_piece(const struct surface *surface, const struct quadrature *rule, double most,
                         int *left, const struct piece *piece, struct sums *sums) {
    int n = piece->along;
    for (int k = 0; k < 2; k++) {
        struct piece half = *piece;
        struct sums before = *sums;
        half.depth++;
        half.half[n] = piece->half[n] / 2;
        half.from[n] = piece->from[n] + k * piece->half[n];
        integrate_piece(surface, rule, &half, sums);
        if (!(half.wrong > most) || half.depth == DEPTH || --*left < 0)
            continue;
        *sums = before;
        refine_piece(surface, rule, most, left, &half, sums);
    }
}

static struct piece whole_span(const struct surface *surface, int k) {
    int count = surface->axis[1].span_count;
    struct piece piece = {.span = {k / count, k % count}};
    for (int n = 0; n < 2; n++) {
        const double *breaks = &surface->axis[n].breaks[piece.span[n]];
        piece.from[n] = breaks[0];
        piece.half[n] = (breaks[1] - breaks[0]) / 2;
    }
    return piece;
}

/* With c the centroid, the mean of |r - c|^2 is that of |r - m|^2 less |c - m|^2. */
static enum status set_measures(struct surface *surface, const struct sums *sums) {
    double least = SURFACE_COINCIDENCE * SURFACE_COINCIDENCE * surface->size * surface->size;
    surface->area = sums->area;
    if (!(sums->area > least) || !isfinite(sums->area))
        return STATUS_DEGENERATE_SURFACE;
    surface->centroid = vec3_scale(1 / sums->area, sums->moment);
    surface->gyration2 = sums->square / sums->area -
                         vec3_norm2(vec3_sub(surface->centroid, surface_box_middle(surface)));
    return STATUS_OK;
}

enum status surface_integrate(struct surface *surface) {
    int spans = surface->axis[0].span_count * surface->axis[1].span_count, left = PIECES_MOST;
    /* many points per span and direction where spans are few and large */
    int order = spans <= 64 ? 16 : spans <= 1024 ? 8 : spans <= 16384 ? 4 : 2;
    struct quadrature rule = quadrature_make(order);
    struct sums sums = {0}, whole = {0};
    double worst = 0;
    for (int k = 0; k < spans; k++) {
        struct piece piece = whole_span(surface, k);
        integrate_piece(surface, &rule, &piece, &whole);
        worst = fmax(worst, piece.wrong);
    }
    if (!(worst > unresolved * whole.area))
        return set_measures(surface, &whole);
    for (int k = 0; k < spans; k++) {
        struct piece piece = whole_span(surface, k);
        struct sums before = sums;
        integrate_piece(surface, &rule, &piece, &sums);
        if (!(piece.wrong > unresolved * whole.area))
            continue;
        sums = before;
        refine_piece(surface, &rule, unresolved * whole.area, &left, &piece, &sums);
    }
    return set_measures(surface, &sums);
}
