/* SPDX-License-Identifier: MIT */
#include "contour.h"

#include "bounds.h"
#include "quadrature.h"
#include "spans.h"

enum { ORDER_MAX = NURBS_DEGREE_MAX + 1, NODES = 8, HALVINGS = 24 };

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

static void add(struct sums *sums, double factor, const struct sums *more) {
    sums->area += factor * more->area;
    sums->moment = vec3_axpy(factor, more->moment, sums->moment);
    sums->normal = vec3_axpy(factor, more->normal, sums->normal);
}

static void widen(struct contour *c, struct vec3 r) {
    c->lower = vec3_make(fmin(c->lower.x, r.x), fmin(c->lower.y, r.y), fmin(c->lower.z, r.z));
    c->upper = vec3_make(fmax(c->upper.x, r.x), fmax(c->upper.y, r.y), fmax(c->upper.z, r.z));
}

static void look(struct contour *c, const double uv[2]) {
    struct surface_jet jet;
    double u = fmin(fmax(uv[0], c->low[0]), c->high[0]);
    double v = fmin(fmax(uv[1], c->low[1]), c->high[1]);
    surface_evaluate(c->surface, &c->cursor, u, v, &jet);
    widen(c, jet.r);
}

/* F at (u, v): the integrals along the line v from the lower border to u, span by span. */
static struct sums line(struct contour *c, double u, double v) {
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
            add(&sums, weight, &(struct sums){element, vec3_scale(element, jet.r), normal});
        }
        from = end;
    }
    return sums;
}

/* ---- curves ---- */

/* A knot span of a curve, or a segment of a polyline, whose parameter is t in from..to. */
struct span {
    const struct trim_curve *curve;
    size_t at;
    double from, to;
};

/* The place and its derivative by t, by de Boor's algorithm in homogeneous coordinates. */
static void curve_at(const struct span *span, double t, double uv[2], double slope[2]) {
    const struct trim_curve *curve = span->curve;
    int p = curve->degree;
    double d[ORDER_MAX][3], last[3] = {0};
    if (!curve->knots) {
        const double *a = curve->points[span->at], *b = curve->points[span->at + 1];
        for (int k = 0; k < 2; k++) {
            uv[k] = a[k] + t * (b[k] - a[k]);
            slope[k] = b[k] - a[k];
        }
        return;
    }
    for (int k = 0; k <= p; k++) {
        size_t i = span->at - (size_t)p + (size_t)k;
        double w = curve->weights ? curve->weights[i] : 1;
        d[k][0] = w * curve->points[i][0];
        d[k][1] = w * curve->points[i][1];
        d[k][2] = w;
    }
    for (int r = 1; r <= p; r++)
        for (int k = p; k >= r; k--) {
            const double *knot = curve->knots + span->at - (size_t)p + (size_t)k;
            double width = knot[p - r + 1] - knot[0], a = (t - knot[0]) / width;
            for (int x = 0; x < 3; x++) {
                last[x] = p * (d[k][x] - d[k - 1][x]) / width;
                d[k][x] = (1 - a) * d[k - 1][x] + a * d[k][x];
            }
        }
    for (int k = 0; k < 2; k++) {
        uv[k] = d[p][k] / d[p][2];
        slope[k] = (last[k] - uv[k] * last[2]) / d[p][2];
    }
}

static int span_of(const struct contour *c, int direction, double x) {
    const struct surface_axis *axis = &c->surface->axis[direction];
    double inside = fmin(fmax(x, c->low[direction]), c->high[direction]);
    return surface_axis_span(axis, 0, surface_axis_inner(axis, inside));
}

/* Whether the ends of a piece lie in one span of the surface. */
static bool is_whole(const struct contour *c, const double a[2], const double b[2]) {
    return span_of(c, 0, a[0]) == span_of(c, 0, b[0]) && span_of(c, 1, a[1]) == span_of(c, 1, b[1]);
}

/* Adds the integral of F dv along a part of a span. */
static void add_piece(struct contour *c, const struct span *span, double from, double to,
                      struct sums *sums) {
    for (int k = 0; k < c->rule.count; k++) {
        double uv[2], slope[2];
        curve_at(span, (from + to + (to - from) * c->rule.node[k]) / 2, uv, slope);
        look(c, uv);
        if (slope[1] == 0)
            continue;
        struct sums inner = line(c, uv[0], uv[1]);
        add(sums, c->rule.weight[k] * (to - from) / 2 * slope[1], &inner);
    }
    c->work += c->surface->axis[0].span_count;
}

/* Halves a span once, and further towards where it crosses a knot of the surface. */
static void add_span(struct contour *c, const struct span *span, struct sums *sums) {
    struct part {
        double from, to;
        int depth;
    } stack[HALVINGS + 2] = {{span->from, span->to, 0}};
    int top = 0;
    while (top >= 0 && c->work < work_most) {
        struct part part = stack[top--];
        double a[2], b[2], slope[2], middle = (part.from + part.to) / 2;
        curve_at(span, part.from, a, slope);
        curve_at(span, part.to, b, slope);
        look(c, a);
        look(c, b);
        if (part.depth < (is_whole(c, a, b) ? span->curve->degree > 1 : HALVINGS)) {
            stack[++top] = (struct part){middle, part.to, part.depth + 1};
            stack[++top] = (struct part){part.from, middle, part.depth + 1};
        } else {
            add_piece(c, span, part.from, part.to, sums);
        }
    }
}

static void add_curve(struct contour *c, const struct trim_curve *curve, struct sums *sums) {
    if (!curve->knots) {
        for (size_t k = 0; k + 1 < curve->count; k++)
            add_span(c, &(struct span){curve, k, 0, 1}, sums);
        return;
    }
    for (size_t k = (size_t)curve->degree; k < curve->count; k++)
        if (curve->knots[k + 1] > curve->knots[k])
            add_span(c, &(struct span){curve, k, curve->knots[k], curve->knots[k + 1]}, sums);
}

static void curve_end(const struct trim_curve *curve, bool last, double uv[2]) {
    struct span span = {curve, last ? curve->count - 2 : 0, 0, 1};
    double t = last ? 1 : 0, slope[2];
    if (curve->knots) {
        span.at = last ? curve->count - 1 : (size_t)curve->degree;
        while (!(curve->knots[span.at + 1] > curve->knots[span.at]))
            last ? span.at-- : span.at++;
        t = curve->knots[last ? span.at + 1 : span.at];
    }
    curve_at(&span, t, uv, slope);
}

/* The inside of a loop, whichever way it runs. Curves that do not meet are joined straight. */
static struct sums loop_sums(struct contour *c, const struct trim_loop *loop) {
    struct sums sums = {0};
    for (size_t k = 0; k < loop->count; k++) {
        double ends[2][2];
        const struct trim_curve straight = {1, (const double(*)[2])ends, 2, NULL, NULL};
        add_curve(c, &loop->curves[k], &sums);
        curve_end(&loop->curves[k], true, ends[0]);
        curve_end(&loop->curves[(k + 1) % loop->count], false, ends[1]);
        if (ends[0][0] != ends[1][0] || ends[0][1] != ends[1][1])
            add_curve(c, &straight, &sums);
    }
    if (sums.area < 0) {
        struct sums turned = {0};
        add(&turned, -1, &sums);
        return turned;
    }
    return sums;
}

/* The whole domain: along its upper border of u. */
static struct sums domain_sums(struct contour *c) {
    const double border[2][2] = {{c->high[0], c->low[1]}, {c->high[0], c->high[1]}};
    const struct trim_curve upper = {1, border, 2, NULL, NULL};
    struct sums sums = {0};
    add_curve(c, &upper, &sums);
    return sums;
}

static struct vec3 unit_or_zero(struct vec3 v, double area) {
    double length = vec3_norm(v);
    return length > 1e-9 * area ? vec3_scale(1 / length, v) : vec3_make(0, 0, 0);
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
        add(&sums, loops[k].reversed ? 1 : -1, &loop);
        kept = kept || loops[k].reversed;
    }
    if (!kept) {
        struct sums whole = domain_sums(&c);
        add(&sums, 1, &whole);
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
    *measure = (struct contour_measure){
        .area = sums.area,
        .centre = vec3_scale(sums.area > 0 ? 1 / sums.area : 0, sums.moment),
        .normal = unit_or_zero(sums.normal, sums.area),
        .lower = c.lower,
        .upper = c.upper};
    if (count > 0 && (c.work >= work_most || fabs(sums.area - strips) > crossing * strips)) {
        measure->area = strips;
        measure->centre = centre;
    }
    return measure->area > 0 ? STATUS_OK : STATUS_DEGENERATE_SURFACE;
}
