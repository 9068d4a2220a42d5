/* SPDX-License-Identifier: MIT */
#include "spans.h"

#include "solver/power.h"
#include <string.h>

enum { ORDER_MAX = NURBS_DEGREE_MAX + 1 };

/* A tangent this short, as a share of the surface's size over its domain, has vanished. */
static const double vanished_tangent = 1e-9;

/* Weights at the corners this near to balance are left as they are. */
static const double balanced = 1e-9;

/* A parametrisation that is further from balance is not one. */
static const double most_factor = 1e9;

/* Weights that differ by more within one span cancel in the coefficients of powers. */
static const double weights_for_powers = 100;

/* A span this narrow, as a share of the surface's size and of the domain, is a line. */
static const double line_width = 1e-10;

/* Bezier control points of one span as combinations of the span's B-spline control points:
 * b_k = sum_i weight[k][i] P_(l-p+i). */
struct extraction {
    int first; /* l - p */
    double weight[ORDER_MAX][ORDER_MAX];
};

/* b_k is the blossom of the span [t_l, t_(l+1)] at (a, .., a, b, .., b) with k times b = t_(l+1):
 * de Boor's algorithm with a new argument in each round, run on unit vectors. Holds for clamped
 * and unclamped knots alike. */
static void extract_span(const struct nurbs_axis *axis, int l, struct extraction *extraction) {
    int p = axis->degree;
    const double *t = axis->knots;
    extraction->first = l - p;
    for (int k = 0; k <= p; k++) {
        double d[ORDER_MAX][ORDER_MAX] = {{0}};
        for (int i = 0; i <= p; i++)
            d[i][i] = 1;
        for (int r = 1; r <= p; r++) {
            double x = r <= p - k ? t[l] : t[l + 1];
            for (int i = p; i >= r; i--) {
                double low = t[l - p + i], high = t[l + 1 + i - r];
                double alpha = (x - low) / (high - low);
                for (int m = 0; m <= p; m++)
                    d[i][m] = (1 - alpha) * d[i - 1][m] + alpha * d[i][m];
            }
        }
        for (int m = 0; m <= p; m++)
            extraction->weight[k][m] = d[p][m];
    }
}

static vec4 homogeneous(const struct nurbs *nurbs, int i, int j) {
    size_t at = (size_t)i * (size_t)nurbs->v.size + (size_t)j;
    double w = nurbs->weights ? nurbs->weights[at] : 1;
    struct vec3 p = nurbs->points[at];
    return (vec4){w * p.x, w * p.y, w * p.z, w};
}

static struct vec3 space_point(vec4 a) {
    return vec3_make(a[0] / a[3], a[1] / a[3], a[2] / a[3]);
}

/* Whether a span is one line: its control points along `direction` fall together. */
static bool is_line(const struct nurbs *nurbs, int direction, const struct extraction *extraction,
                    double size) {
    const struct nurbs_axis *axis = direction == 0 ? &nurbs->u : &nurbs->v;
    const struct nurbs_axis *other = direction == 0 ? &nurbs->v : &nurbs->u;
    for (int j = 0; j < other->size; j++) {
        struct vec3 first = {0, 0, 0};
        for (int k = 0; k <= axis->degree; k++) {
            vec4 sum = {0};
            for (int m = 0; m <= axis->degree; m++) {
                int i = extraction->first + m;
                sum += extraction->weight[k][m] *
                       (direction == 0 ? homogeneous(nurbs, i, j) : homogeneous(nurbs, j, i));
            }
            first = k == 0 ? space_point(sum) : first;
            if (vec3_distance(space_point(sum), first) > line_width * size)
                return false;
        }
    }
    return true;
}

/* Finds the spans of one direction; `extractions` gets one entry each. A fillet whose radius is
 * rounding is a fold: a span that is no wider than a line is left out, and the one before it ends
 * where it does. */
static enum status split_axis(const struct nurbs *nurbs, int direction, struct arena *arena,
                              struct surface *surface, struct extraction **extractions) {
    const struct nurbs_axis *from = direction == 0 ? &nurbs->u : &nurbs->v;
    struct surface_axis *axis = &surface->axis[direction];
    int p = from->degree, n = from->size, count = 0;
    bool left_out = false;
    axis->degree = p;
    axis->breaks = arena_alloc(arena, (size_t)(n - p + 1), sizeof *axis->breaks);
    axis->rates = arena_alloc(arena, (size_t)(n - p), sizeof *axis->rates);
    axis->middles = arena_alloc(arena, (size_t)(n - p), sizeof *axis->middles);
    axis->joints = arena_alloc(arena, (size_t)(n - p + 1), sizeof *axis->joints);
    axis->corners = arena_alloc(arena, (size_t)(n - p + 1), sizeof *axis->corners);
    *extractions = arena_alloc(arena, (size_t)(n - p), sizeof **extractions);
    if (!axis->breaks || !axis->rates || !axis->middles || !axis->joints || !axis->corners ||
        !*extractions)
        return STATUS_OUT_OF_MEMORY;
    axis->factor = 1;
    axis->outer[0] = from->knots[p];
    axis->outer[1] = from->knots[n];
    axis->origin = axis->outer[0] <= 0 && axis->outer[1] >= 0 ? 0 : axis->outer[0];
    double length = axis->outer[1] - axis->outer[0];
    for (int l = p; l < n; l++) {
        if (!(from->knots[l + 1] > from->knots[l]))
            continue;
        struct extraction *own = &(*extractions)[count];
        int first = l;
        while (first > 0 && from->knots[first - 1] == from->knots[l])
            first--;
        int smooth = left_out ? 0 : p - (l - first + 1);
        bool narrow = from->knots[l + 1] - from->knots[l] < line_width * length;
        extract_span(from, l, own);
        left_out = narrow && is_line(nurbs, direction, own, surface->size);
        if (left_out)
            continue;
        axis->breaks[count] = (count == 0 ? axis->outer[0] : from->knots[l]) - axis->origin;
        axis->joints[count] = count == 0 || smooth < 2;
        axis->corners[count] = count > 0 && smooth < 1;
        count++;
    }
    axis->breaks[count] = from->knots[n] - axis->origin;
    axis->joints[count] = true;
    axis->span_count = count;
    return STATUS_OK;
}

static void set_rates(struct surface_axis *axis) {
    for (int k = 0; k < axis->span_count; k++) {
        double width = axis->breaks[k + 1] - axis->breaks[k];
        axis->rates[k] = 1 / width;
        axis->middles[k] = axis->breaks[k] + width / 2;
    }
}

/* points = E_u P E_v^T for one span. */
static void fill_span(const struct nurbs *nurbs, const struct extraction *eu,
                      const struct extraction *ev, vec4 *points) {
    int p = nurbs->u.degree, q = nurbs->v.degree;
    vec4 row[ORDER_MAX][ORDER_MAX];
    for (int i = 0; i <= p; i++)
        for (int l = 0; l <= q; l++) {
            vec4 sum = {0};
            for (int j = 0; j <= q; j++)
                sum += ev->weight[l][j] * homogeneous(nurbs, eu->first + i, ev->first + j);
            row[i][l] = sum;
        }
    for (int k = 0; k <= p; k++)
        for (int l = 0; l <= q; l++) {
            vec4 sum = {0};
            for (int i = 0; i <= p; i++)
                sum += eu->weight[k][i] * row[i][l];
            points[k * (q + 1) + l] = sum;
        }
}

/* Bernstein polynomials in powers of the distance x from the middle of a span 1 / rate long:
 * row[k] = binomial(p, k) (1/2 + rate x)^k (1/2 - rate x)^(p - k). */
static void bernstein_powers(int p, double rate, double row[ORDER_MAX][ORDER_MAX]) {
    double binomial = 1;
    for (int k = 0; k <= p; k++) {
        double *c = row[k];
        memset(c, 0, ORDER_MAX * sizeof *c);
        c[0] = binomial;
        for (int factor = 0; factor < p; factor++) {
            double slope = factor < k ? rate : -rate;
            for (int m = p; m > 0; m--)
                c[m] = c[m] / 2 + slope * c[m - 1];
            c[0] /= 2;
        }
        binomial = binomial * (p - k) / (k + 1);
    }
}

/* powers[m][n] = sum_kl a[k][m] b[l][n] points[k][l] for each span. They are used where they are as
 * good as Bernstein polynomials: for spans whose weights do not differ by much. */
static enum status make_powers(struct arena *arena, struct surface *surface) {
    const struct surface_axis *u = &surface->axis[0], *v = &surface->axis[1];
    int nu = u->span_count, nv = v->span_count, p = u->degree, q = v->degree;
    double a[ORDER_MAX][ORDER_MAX], b[ORDER_MAX][ORDER_MAX];
    if (p > SURFACE_POWERS_DEGREE || q > SURFACE_POWERS_DEGREE)
        return STATUS_OK;
    size_t size = surface->points_per_span, spans = (size_t)nu * (size_t)nv;
    surface->powers = arena_alloc(arena, spans * size, sizeof *surface->powers);
    surface->in_powers = arena_alloc(arena, spans, sizeof *surface->in_powers);
    if (!surface->powers || !surface->in_powers)
        return STATUS_OUT_OF_MEMORY;
    for (int i = 0; i < nu * nv; i++) {
        const vec4 *points = surface->points + (size_t)i * size;
        double least = points[0][3], most = least;
        for (size_t k = 1; k < size; k++) {
            least = fmin(least, points[k][3]);
            most = fmax(most, points[k][3]);
        }
        surface->in_powers[i] = most <= weights_for_powers * least;
        bernstein_powers(p, u->rates[i / nv], a);
        bernstein_powers(q, v->rates[i % nv], b);
        for (size_t at = 0; at < size; at++) {
            vec4 sum = {0};
            for (int k = 0; k <= p; k++)
                for (int l = 0; l <= q; l++)
                    sum += a[k][at / (size_t)(q + 1)] * b[l][at % (size_t)(q + 1)] *
                           points[k * (q + 1) + l];
            surface->powers[(size_t)i * size + at] = sum;
        }
    }
    return STATUS_OK;
}

void surface_set_bounds(struct surface *surface, struct vec3 low, struct vec3 high) {
    surface->lower = low;
    surface->upper = high;
    surface->size = vec3_distance(low, high);
    surface->magnitude = fmax(fmax(fmax(-low.x, high.x), fmax(-low.y, high.y)),
                              fmax(fmax(-low.z, high.z), surface->size));
}

/* The homogeneous control point at position `along` of the border at the lower (end 0) or upper
 * (end 1) bound of `direction`; `span` counts along it. */
static vec4 border_point(const struct surface *surface, int direction, int end, int span,
                         int along) {
    const struct surface_axis *a = surface->axis;
    int across_span = end ? a[direction].span_count - 1 : 0;
    int across = end ? a[direction].degree : 0;
    int span_u = direction == 0 ? across_span : span, span_v = direction == 0 ? span : across_span;
    int k = direction == 0 ? across : along, l = direction == 0 ? along : across;
    size_t at = (size_t)span_u * (size_t)a[1].span_count + (size_t)span_v;
    return surface->points[at * surface->points_per_span + (size_t)(k * (a[1].degree + 1) + l)];
}

/* ---- the inner parameters of spans.h ---- */

/* The weight at the corner at the lower or upper end of u and of v. */
static double corner_weight(const struct surface *surface, int end_u, int end_v) {
    int last = surface->axis[1].span_count - 1;
    return border_point(surface, 0, end_u, end_v ? last : 0,
                        end_v ? surface->axis[1].degree : 0)[3];
}

/* Gives direction k the parameter in which the corners' weights balance: the points of a span from
 * a to b are multiplied by those of the factor's denominator, 1 / (1 + (c - 1) x / L), to the power
 * of the degree, whose Bezier points are products of its values at a and b. Affine changes of
 * weight from end to end, as degree and knots may have it, are left alone on closed directions,
 * which must stay closed. */
static void balance(struct surface *surface, int k) {
    struct surface_axis *axis = &surface->axis[k];
    double logarithm = 0;
    for (int end = 0; end < 2; end++)
        for (int other = 0; other < 2; other++)
            logarithm += (end ? 1 : -1) * power_log(k == 0 ? corner_weight(surface, end, other)
                                                           : corner_weight(surface, other, end));
    double c = power_exp(logarithm / (2 * axis->degree));
    if (!(fabs(c - 1) > balanced) || !(c > 1 / most_factor && c < most_factor))
        return;
    double length = axis->outer[1] - axis->outer[0], first = axis->breaks[0];
    double inverse[2], factor[ORDER_MAX];
    int columns = surface->axis[1].degree + 1, size = (int)surface->points_per_span;
    int spans = axis->span_count, others = surface->axis[1 - k].span_count;
    for (int s = 0; s < spans; s++) {
        for (int end = 0; end < 2; end++)
            inverse[end] = length / (length + (c - 1) * (axis->breaks[s + end] - first));
        for (int i = 0; i <= axis->degree; i++) {
            factor[i] = 1;
            for (int m = 0; m < axis->degree; m++)
                factor[i] *= inverse[m < i];
        }
        for (int o = 0; o < others; o++) {
            int at = k == 0 ? s * others + o : o * spans + s;
            vec4 *points = surface->points + (size_t)at * surface->points_per_span;
            for (int n = 0; n < size; n++)
                points[n] *= factor[k == 0 ? n / columns : n % columns];
        }
    }
    for (int s = 0; s <= spans; s++) {
        double x = axis->breaks[s] - first;
        axis->breaks[s] = s == spans ? length : c * length * x / (length + (c - 1) * x);
    }
    axis->factor = c;
    axis->origin = axis->outer[0];
}

static bool is_same_point(const struct surface *surface, vec4 a, vec4 b) {
    return vec3_distance(space_point(a), space_point(b)) <= SURFACE_COINCIDENCE * surface->size;
}

/* A border is a pole when all its control points are one; a direction is closed when its two
 * borders have the same control points and proportional weights. */
static void find_poles(struct surface *surface, int direction) {
    struct surface_axis *axis = &surface->axis[direction];
    const struct surface_axis *other = &surface->axis[1 - direction];
    vec4 first[2] = {border_point(surface, direction, 0, 0, 0),
                     border_point(surface, direction, 1, 0, 0)};
    axis->pole[0] = axis->pole[1] = axis->closed = true;
    axis->pole_point[0] = space_point(first[0]);
    axis->pole_point[1] = space_point(first[1]);
    for (int span = 0; span < other->span_count; span++)
        for (int along = 0; along <= other->degree; along++) {
            vec4 low = border_point(surface, direction, 0, span, along);
            vec4 high = border_point(surface, direction, 1, span, along);
            axis->pole[0] = axis->pole[0] && is_same_point(surface, low, first[0]);
            axis->pole[1] = axis->pole[1] && is_same_point(surface, high, first[1]);
            double skew = low[3] * first[1][3] - high[3] * first[0][3];
            axis->closed = axis->closed && is_same_point(surface, low, high) &&
                           fabs(skew) <= SURFACE_COINCIDENCE * fabs(low[3] * first[1][3]);
        }
}

bool surface_has_spread_pole(const struct surface *surface, double least, struct vec3 *at,
                             double *spread) {
    for (int border = 0; border < 4; border++) {
        int direction = border / 2, end = border % 2;
        const struct surface_axis *other = &surface->axis[1 - direction];
        *at = space_point(border_point(surface, direction, end, 0, 0));
        *spread = 0;
        for (int span = 0; span < other->span_count; span++)
            for (int along = 0; along <= other->degree; along++) {
                vec4 point = border_point(surface, direction, end, span, along);
                *spread = fmax(*spread, vec3_distance(space_point(point), *at));
            }
        if (other->closed && !surface->axis[direction].pole[end] && *spread < least)
            return true;
    }
    return false;
}

enum status surface_finish(struct surface *surface) {
    const struct surface_axis *a = surface->axis;
    surface->has_poles = a[0].pole[0] || a[0].pole[1] || a[1].pole[0] || a[1].pole[1];
    for (int k = 0; k < 2; k++) {
        double least = vanished_tangent * surface->size /
                       (surface_axis_upper(&a[k]) - surface_axis_lower(&a[k]));
        surface->least_tangent2[k] = least * least;
    }
    return surface_integrate(surface);
}

/* Whether the surface may fold along a knot line, on the continuation too: over one that allows it
 * the polynomials are not the same on both sides, as they are at a knot that was inserted. */
static bool has_fold(const struct surface *surface, int k) {
    static const double places[] = {0.125, 0.625};
    const struct surface_axis *axis = &surface->axis[k], *other = &surface->axis[1 - k];
    for (int at = 0; at < axis->span_count * other->span_count; at++) {
        int span = at / other->span_count, along = at % other->span_count;
        for (int n = 0; n < 4 && axis->corners[span]; n++) {
            struct surface_jet jet[2];
            double uv[2];
            uv[k] =
                axis->breaks[span] + places[n / 2] * (axis->breaks[span + 1] - axis->breaks[span]);
            uv[1 - k] = other->breaks[along] +
                        places[n % 2] * (other->breaks[along + 1] - other->breaks[along]);
            for (int side = 0; side < 2; side++) {
                int of[2];
                of[k] = span - side;
                of[1 - k] = along;
                surface_evaluate_span(surface, of[0], of[1], uv[0], uv[1], &jet[side]);
            }
            if (!(vec3_distance(jet[0].r, jet[1].r) <= SURFACE_COINCIDENCE * surface->size))
                return true;
        }
    }
    return false;
}

void surface_relocate_inside(struct relocation *relocation, struct surface *surface) {
    size_t spans = 1;
    for (int k = 0; k < 2; k++) {
        struct surface_axis *axis = &surface->axis[k];
        size_t count = (size_t)axis->span_count;
        relocate(relocation, &axis->breaks, count + 1, sizeof *axis->breaks);
        relocate(relocation, &axis->rates, count, sizeof *axis->rates);
        relocate(relocation, &axis->middles, count, sizeof *axis->middles);
        relocate(relocation, &axis->joints, count + 1, sizeof *axis->joints);
        relocate(relocation, &axis->corners, count + 1, sizeof *axis->corners);
        spans *= count;
    }
    size_t bytes = surface->points_per_span * sizeof *surface->points;
    relocate(relocation, &surface->points, spans, bytes);
    relocate(relocation, &surface->powers, spans, bytes);
    relocate(relocation, &surface->in_powers, spans, sizeof *surface->in_powers);
    relocate(relocation, &surface->shell, 1,
             1); /* which has the surface, not the other way round */
}

void surface_relocate(struct relocation *relocation, void *field) {
    struct surface *surface = relocate_once(relocation, field, 1, sizeof *surface);
    if (surface)
        surface_relocate_inside(relocation, surface);
}

enum status surface_make(const struct nurbs *nurbs, struct arena *arena, struct surface **surface) {
    struct extraction *extraction[2];
    struct surface *made = arena_alloc(arena, 1, sizeof *made);
    if (!made)
        return STATUS_OUT_OF_MEMORY;
    made->side = 1;
    struct vec3 low = nurbs->points[0], high = low;
    for (size_t i = 1; i < nurbs->point_count; i++) {
        low = vec3_min(low, nurbs->points[i]);
        high = vec3_max(high, nurbs->points[i]);
    }
    surface_set_bounds(made, low, high);
    enum status status = split_axis(nurbs, 0, arena, made, &extraction[0]);
    if (status == STATUS_OK)
        status = split_axis(nurbs, 1, arena, made, &extraction[1]);
    if (status != STATUS_OK)
        return status;
    size_t nu = (size_t)made->axis[0].span_count, nv = (size_t)made->axis[1].span_count;
    made->points_per_span = (size_t)((nurbs->u.degree + 1) * (nurbs->v.degree + 1));
    made->points = arena_alloc(arena, nu * nv * made->points_per_span, sizeof *made->points);
    if (!made->points)
        return STATUS_OUT_OF_MEMORY;
    for (size_t i = 0; i < nu * nv; i++)
        fill_span(nurbs, &extraction[0][i / nv], &extraction[1][i % nv],
                  made->points + i * made->points_per_span);
    balance(made, 0);
    balance(made, 1);
    set_rates(&made->axis[0]);
    set_rates(&made->axis[1]);
    find_poles(made, 0);
    find_poles(made, 1);
    *surface = made;
    status = make_powers(arena, made);
    if (status != STATUS_OK)
        return status;
    made->has_folds = has_fold(made, 0) || has_fold(made, 1);
    return surface_finish(made);
}

void surface_domain(const struct surface *surface, double lower[2], double upper[2]) {
    for (int k = 0; k < 2; k++) {
        lower[k] = surface->axis[k].outer[0];
        upper[k] = surface->axis[k].outer[1];
    }
}

bool surface_closed(const struct surface *surface, int direction) {
    return surface->axis[direction].closed;
}

void surface_bounds(const struct surface *surface, struct vec3 *lower, struct vec3 *upper) {
    *lower = surface->lower;
    *upper = surface->upper;
}

double surface_gyration2(const struct surface *surface) {
    return surface->gyration2;
}

double surface_area(const struct surface *surface, struct vec3 *centroid) {
    if (centroid)
        *centroid = surface->centroid;
    return surface->area;
}
