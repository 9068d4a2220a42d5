/* SPDX-License-Identifier: MIT */
/* Evaluation at one point (`span_jet.h` has the mathematics) and on grids, and walks along axes. */
#include "quadrature.h"
#include "span_jet.h"

WIDE_CLONES
void surface_evaluate_span(const struct surface *surface, int span_u, int span_v, double u,
                           double v, struct surface_jet *jet) {
    span_jet(surface, span_u, span_v, u, v, jet);
}

/* ---- a grid of points ---- */

/* The polynomials in u, and their derivatives by v, that a line of the same v has. */
struct line {
    vec4 value[ORDER_MAX], by_v[ORDER_MAX];
};

INLINE struct surface_element element_of(vec4 a, vec4 au, vec4 av) {
    const struct homogeneous sum = {.a = {a}, .u = {au}, .v = {av}};
    struct divided d = divide_first(&sum);
    return (struct surface_element){in_space(d.r), in_space(d.u), in_space(d.v)};
}

INLINE void grid_powers(int p, int q, const vec4 *powers, const double middle[2],
                        const struct surface_grid *grid, struct surface_element *elements) {
    for (int b = 0; b < grid->count[1]; b++) {
        struct line line;
        UNROLL for (int k = 0; k <= p; k++) {
            struct horner row = horner(q, powers + k * (q + 1), grid->at[1][b] - middle[1], 1);
            line.value[k] = row.value;
            line.by_v[k] = row.first;
        }
        for (int a = 0; a < grid->count[0]; a++) {
            double x = grid->at[0][a] - middle[0];
            struct horner h = horner(p, line.value, x, 1), hv = horner(p, line.by_v, x, 0);
            elements[a * grid->count[1] + b] = element_of(h.value, h.first, hv.value);
        }
    }
}

INLINE void grid_bernstein(int p, int q, const vec4 *points, const double from[2],
                           const double rate[2], const struct surface_grid *grid,
                           struct surface_element *elements) {
    struct basis u[QUADRATURE_MAX], v;
    for (int a = 0; a < grid->count[0]; a++)
        find_basis(p, (grid->at[0][a] - from[0]) * rate[0], rate[0], &u[a]);
    for (int b = 0; b < grid->count[1]; b++) {
        struct line line = {.value = {{0}}};
        find_basis(q, (grid->at[1][b] - from[1]) * rate[1], rate[1], &v);
        for (int k = 0; k <= p; k++)
            for (int l = 0; l <= q; l++) {
                line.value[k] += v.value[l] * points[k * (q + 1) + l];
                line.by_v[k] += v.first[l] * points[k * (q + 1) + l];
            }
        for (int a = 0; a < grid->count[0]; a++) {
            vec4 sum = {0}, by_u = {0}, by_v = {0};
            for (int k = 0; k <= p; k++) {
                sum += u[a].value[k] * line.value[k];
                by_u += u[a].first[k] * line.value[k];
                by_v += u[a].value[k] * line.by_v[k];
            }
            elements[a * grid->count[1] + b] = element_of(sum, by_u, by_v);
        }
    }
}

/* With the sums of `surface_evaluate_span` in its order, so with its bits; but what a line has in
 * common is found once. */
WIDE_CLONES
void surface_evaluate_grid(const struct surface *surface, const struct surface_grid *grid,
                           struct surface_element *elements) {
    const struct surface_axis *au = &surface->axis[0], *av = &surface->axis[1];
    const int *span = grid->span;
    size_t number = (size_t)span[0] * (size_t)av->span_count + (size_t)span[1];
    size_t first = number * surface->points_per_span;
    if (!(surface->powers && surface->in_powers[number])) {
        const double from[2] = {au->breaks[span[0]], av->breaks[span[1]]};
        const double rate[2] = {au->rates[span[0]], av->rates[span[1]]};
        grid_bernstein(au->degree, av->degree, surface->points + first, from, rate, grid, elements);
        return;
    }
    const double middle[2] = {au->middles[span[0]], av->middles[span[1]]};
#define CASE(P, Q)                                                                                 \
    case (P)*POWERS_ORDER + (Q):                                                                   \
        grid_powers(P, Q, surface->powers + first, middle, grid, elements);                        \
        break;
    switch (au->degree * POWERS_ORDER + av->degree) {
        SURFACE_LOW_DEGREES(CASE)
    default:
        break;
    }
#undef CASE
}

int surface_axis_span(const struct surface_axis *axis, int hint, double x) {
    const double *b = axis->breaks;
    if (hint < axis->span_count && x >= b[hint] && x < b[hint + 1])
        return hint;
    int low = 0, high = axis->span_count;
    while (high - low > 1) {
        int middle = low + (high - low) / 2;
        if (x >= b[middle])
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Breaks nearer to an end than this, as a share of the way, do not lie between the ends. */
static const double walk_slack = 1e-9;

struct surface_walk surface_walk_begin(const struct surface_axis *axis, double from, double to) {
    double wrapped = surface_axis_wrap(axis, from);
    struct surface_walk walk = {
        .axis = axis, .from = from, .way = to - from, .turn = from - wrapped};
    walk.next = surface_axis_span(axis, 0, wrapped) + (walk.way > 0);
    return walk;
}

bool surface_walk_next(struct surface_walk *walk) {
    const struct surface_axis *axis = walk->axis;
    double period = surface_axis_upper(axis) - surface_axis_lower(axis);
    int step = walk->way > 0 ? 1 : -1, last = axis->span_count;
    bool any = fabs(walk->way) > 0 && fabs(walk->way) <= period;
    while (any) {
        if (axis->closed && (walk->next > last || walk->next < 0)) {
            walk->turn += step * period;
            walk->next = step > 0 ? 1 : last - 1;
        }
        walk->number = walk->next;
        if (walk->number < 0 || walk->number > last ||
            (!axis->closed && (walk->number == 0 || walk->number == last)))
            return false;
        walk->next += step;
        walk->at = axis->breaks[walk->number] + walk->turn;
        walk->share = (walk->at - walk->from) / walk->way;
        if (!(walk->share < 1 - walk_slack))
            return false;
        if (walk->share > walk_slack)
            return true;
    }
    return false;
}

double surface_axis_wrap(const struct surface_axis *axis, double x) {
    double lower = axis->breaks[0], upper = axis->breaks[axis->span_count];
    if (!axis->closed || (x >= lower && x <= upper))
        return x;
    double period = upper - lower;
    double wrapped = x - period * floor((x - lower) / period);
    return wrapped > upper ? upper : wrapped;
}

double surface_axis_inner(const struct surface_axis *axis, double x) {
    double length = surface_axis_upper(axis) - surface_axis_lower(axis), c = axis->factor;
    if (c == 1)
        return x - axis->origin;
    double from = x - axis->outer[0];
    double turns = axis->closed ? floor(from / length) : 0;
    from -= turns * length;
    double inner = turns * length + c * length * from / (length + (c - 1) * from);
    bool between = x >= axis->outer[0] && x <= axis->outer[1];
    return between ? fmin(inner, surface_axis_upper(axis)) : inner;
}

double surface_axis_outer(const struct surface_axis *axis, double inner) {
    double length = surface_axis_upper(axis) - surface_axis_lower(axis), c = axis->factor;
    if (inner == surface_axis_lower(axis) || inner == surface_axis_upper(axis))
        return axis->outer[inner > surface_axis_lower(axis)];
    if (inner > surface_axis_lower(axis) && inner < surface_axis_upper(axis))
        return surface_axis_outer_between(axis, inner);
    if (c == 1)
        return inner + axis->origin;
    double turns = axis->closed ? floor(inner / length) : 0, at = inner - turns * length;
    return axis->outer[0] + turns * length + length * at / (c * length - (c - 1) * at);
}

double surface_axis_rate(const struct surface_axis *axis, double inner, double *second) {
    double length = surface_axis_upper(axis) - surface_axis_lower(axis), c = axis->factor;
    double at = axis->closed && c != 1 ? inner - length * floor(inner / length) : inner;
    double share = c == 1 ? 1 : (c * length - (c - 1) * at) / length;
    if (second)
        *second = c == 1 ? 0 : -2 * (c - 1) / (c * c * length) * share * share * share;
    return share * share / c;
}

void surface_inner(const struct surface *surface, const double outer[2], double inner[2]) {
    for (int k = 0; k < 2; k++)
        inner[k] = surface_axis_inner(&surface->axis[k], outer[k]);
}

/* The chain rule: r_x = s' r_s, r_xx = s'^2 r_ss + s'' r_s. */
void surface_evaluate(const struct surface *surface, struct surface_cursor *cursor, double u,
                      double v, struct surface_jet *jet) {
    const double outer[2] = {u, v};
    double s[2], second[2], rate[2];
    surface_inner(surface, outer, s);
    surface_jet_at(surface, cursor, s[0], s[1], jet);
    if (surface->axis[0].factor == 1 && surface->axis[1].factor == 1)
        return;
    for (int k = 0; k < 2; k++)
        rate[k] = surface_axis_rate(&surface->axis[k], s[k], &second[k]);
    jet->uu = vec3_axpy(second[0], jet->u, vec3_scale(rate[0] * rate[0], jet->uu));
    jet->vv = vec3_axpy(second[1], jet->v, vec3_scale(rate[1] * rate[1], jet->vv));
    jet->uv = vec3_scale(rate[0] * rate[1], jet->uv);
    jet->u = vec3_scale(rate[0], jet->u);
    jet->v = vec3_scale(rate[1], jet->v);
}

void surface_jet_at(const struct surface *surface, struct surface_cursor *cursor, double u,
                    double v, struct surface_jet *jet) {
    const struct surface_axis *au = &surface->axis[0], *av = &surface->axis[1];
    u = surface_axis_wrap(au, u);
    v = surface_axis_wrap(av, v);
    cursor->span_u = surface_axis_span(au, cursor->span_u, u);
    cursor->span_v = surface_axis_span(av, cursor->span_v, v);
    surface_evaluate_span(surface, cursor->span_u, cursor->span_v, u, v, jet);
}
