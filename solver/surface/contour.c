/* SPDX-License-Identifier: MIT */
#include "contour.h"

#include "bounds.h"
#include "quadrature.h"
#include "spans.h"

enum { NODES = 8, HALVINGS = 24 };

/* Pieces of curves times spans of the surface that a measure may take; about a second. */
static const double work_most = 1e5;

/* How far the area may be from that of the strips before the loops are held to cross. */
static const double crossing = 2e-3;

/* Area, moment and sum of r_u x r_v. */
struct sums {
    double area;
    struct vec3 moment, normal;
};

struct contour {
    const struct surface *surface;
    struct surface_cursor cursor;
    struct quadrature rule;
    double low[2], high[2]; /* the domain */
    struct vec3 lower, upper;
    double work;
};

static void add_weighted(struct sums *sums, double factor, const struct sums *more) {
    sums->area += factor * more->area;
    sums->moment = vec3_axpy(factor, more->moment, sums->moment);
    sums->normal = vec3_axpy(factor, more->normal, sums->normal);
}

static void look_at(struct contour *c, const double uv[2]) {
    struct surface_jet jet;
    double u = fmin(fmax(uv[0], c->low[0]), c->high[0]);
    double v = fmin(fmax(uv[1], c->low[1]), c->high[1]);
    surface_evaluate(c->surface, &c->cursor, u, v, &jet);
    c->lower = vec3_min(c->lower, jet.r);
    c->upper = vec3_max(c->upper, jet.r);
}

/* F at (u, v): the integrals along the line v from the lower border to u, span by span. */
static struct sums line_sums(struct contour *c, double u, double v) {
    const struct surface_axis *axis = &c->surface->axis[0];
    struct sums sums = {0};
    double to = fmin(u, c->high[0]), at = fmin(fmax(v, c->low[1]), c->high[1]);
    double from = c->low[0];
    for (int span = 0; span < axis->span_count && from < to; span++) {
        double end = span + 1 == axis->span_count
                         ? c->high[0]
                         : surface_axis_outer(axis, axis->breaks[span + 1]);
        end = fmin(end, to);
        for (int k = 0; k < c->rule.count; k++) {
            struct surface_jet jet;
            double x = (from + end + (end - from) * c->rule.node[k]) / 2;
            surface_evaluate(c->surface, &c->cursor, x, at, &jet);
            struct vec3 normal = vec3_cross(jet.u, jet.v);
            double weight = c->rule.weight[k] * (end - from) / 2, element = vec3_norm(normal);
            add_weighted(&sums, weight,
                         &(struct sums){element, vec3_scale(element, jet.r), normal});
        }
        from = end;
    }
    return sums;
}

/* ---- curves ---- */

static int surface_span(const struct contour *c, int direction, double x) {
    const struct surface_axis *axis = &c->surface->axis[direction];
    double inside = fmin(fmax(x, c->low[direction]), c->high[direction]);
    return surface_axis_span(axis, 0, surface_axis_inner(axis, inside));
}

/* Adds the integral of F dv along a knot span of a curve, or a segment of a polyline, whose
 * parameter is in from..to: halves it once, and further towards where it crosses a knot of the
 * surface. */
static void integrate_span(struct contour *c, const struct trim_curve *curve, size_t at,
                           double from, double to, struct sums *sums) {
    struct piece {
        double from, to;
        int depth;
    } stack[HALVINGS + 2] = {{from, to, 0}};
    int top = 0;
    while (top >= 0 && c->work < work_most) {
        struct piece piece = stack[top--];
        double a[2], b[2], middle = (piece.from + piece.to) / 2;
        trim_curve_in_span(curve, at, piece.from, a, NULL);
        trim_curve_in_span(curve, at, piece.to, b, NULL);
        look_at(c, a);
        look_at(c, b);
        bool whole = surface_span(c, 0, a[0]) == surface_span(c, 0, b[0]) &&
                     surface_span(c, 1, a[1]) == surface_span(c, 1, b[1]);
        if (piece.depth < (whole ? curve->degree > 1 : HALVINGS)) {
            stack[++top] = (struct piece){middle, piece.to, piece.depth + 1};
            stack[++top] = (struct piece){piece.from, middle, piece.depth + 1};
            continue;
        }
        for (int k = 0; k < c->rule.count; k++) {
            double uv[2], slope[2], length = piece.to - piece.from;
            double t = (piece.from + piece.to + length * c->rule.node[k]) / 2;
            trim_curve_in_span(curve, at, t, uv, slope);
            look_at(c, uv);
            if (slope[1] == 0)
                continue;
            struct sums inner = line_sums(c, uv[0], uv[1]);
            add_weighted(sums, c->rule.weight[k] * length / 2 * slope[1], &inner);
        }
        c->work += c->surface->axis[0].span_count;
    }
}

static void integrate_curve(struct contour *c, const struct trim_curve *curve, struct sums *sums) {
    if (!curve->knots) {
        for (size_t k = 0; k + 1 < curve->count; k++)
            integrate_span(c, curve, k, 0, 1, sums);
        return;
    }
    for (size_t k = (size_t)curve->degree; k < curve->count; k++)
        if (curve->knots[k + 1] > curve->knots[k])
            integrate_span(c, curve, k, curve->knots[k], curve->knots[k + 1], sums);
}

/* The inside of a loop, whichever way it runs. Curves that do not meet are joined straight. */
static struct sums loop_sums(struct contour *c, const struct trim_loop *loop) {
    struct sums sums = {0};
    for (size_t k = 0; k < loop->count; k++) {
        double ends[2][2];
        const struct trim_curve straight = {1, (const double(*)[2])ends, 2, NULL, NULL};
        integrate_curve(c, &loop->curves[k], &sums);
        trim_curve_end(&loop->curves[k], 1, ends[0]);
        trim_curve_end(&loop->curves[(k + 1) % loop->count], 0, ends[1]);
        if (ends[0][0] != ends[1][0] || ends[0][1] != ends[1][1])
            integrate_curve(c, &straight, &sums);
    }
    if (sums.area < 0) {
        struct sums turned = {0};
        add_weighted(&turned, -1, &sums);
        return turned;
    }
    return sums;
}

enum status contour_measure(const struct surface *surface, const struct trim_loop *loops,
                            size_t count, struct arena *arena, struct contour_measure *measure) {
    struct contour c = {.surface = surface,
                        .rule = quadrature_make(NODES),
                        .lower = vec3_make(HUGE_VAL, HUGE_VAL, HUGE_VAL),
                        .upper = vec3_make(-HUGE_VAL, -HUGE_VAL, -HUGE_VAL)};
    struct sums sums = {0};
    bool kept = false;
    double strips = 0;
    struct vec3 centre = {0};
    surface_domain(surface, c.low, c.high);
    for (size_t k = 0; k < count; k++) {
        struct sums loop = loop_sums(&c, &loops[k]);
        add_weighted(&sums, loops[k].reversed ? 1 : -1, &loop);
        kept = kept || loops[k].reversed;
    }
    if (!kept) {
        /* the whole domain: along its upper border of u */
        const double border[2][2] = {{c.high[0], c.low[1]}, {c.high[0], c.high[1]}};
        const struct trim_curve upper = {1, border, 2, NULL, NULL};
        struct sums whole = {0};
        integrate_curve(&c, &upper, &whole);
        add_weighted(&sums, 1, &whole);
        bounds_tight(surface, &c.lower, &c.upper);
    }
    if (count > 0) {
        struct trim *trim;
        struct arena_mark mark = arena_mark(arena);
        enum status status = trim_make(surface, loops, count, arena, &trim);
        if (status != STATUS_OK)
            return status;
        strips = trim_area(trim, &centre);
        arena_rewind(arena, mark);
    }
    double normal = vec3_norm(sums.normal);
    *measure = (struct contour_measure){
        .area = sums.area,
        .centre = vec3_scale(sums.area > 0 ? 1 / sums.area : 0, sums.moment),
        .normal = vec3_scale(normal > 1e-9 * sums.area ? 1 / normal : 0, sums.normal),
        .lower = c.lower,
        .upper = c.upper};
    if (count > 0 && (c.work >= work_most || fabs(sums.area - strips) > crossing * strips)) {
        measure->area = strips;
        measure->centre = centre;
    }
    return measure->area > 0 ? STATUS_OK : STATUS_DEGENERATE_SURFACE;
}
