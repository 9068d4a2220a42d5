/* SPDX-License-Identifier: MIT */
#include "offset.h"

#include "solver/angle.h"
#include "solver/surface/offset_jet.h"
#include "surface_point.h"
#include <string.h>

enum {
    SAMPLES = 4096,        /* of all spans together, and */
    SAMPLES_PER_SPAN = 12, /* of one in each direction, at the most */
    ROUNDS = 40,           /* of the search for the greatest curvature */
    CREASE_LOOKS = 8       /* along a knot, in each span */
};

/* Where there is no tangent plane n is that of a place so far inside, as a share of the span. */
static const double inside = 1e-6;

/* Where both curvatures and parameters are well enough known to be judged: |sin| of the angle
 * between r_u and r_v, squared. */
static const double regular_share = 1e-6;

/* ---- evaluation ---- */

/* Beside a pole. With its point P, and x from its end of the axis, the spans' coordinates less w P
 * vanish at x = 0: they are x B with polynomials B one degree lower across, and r = P + x R with
 * R = B / w. Let v be the axis across. Then m = x M, M = R_u x (R + x R_v), and n is that of M,
 * which loses nothing where m vanishes. */
struct pinch {
    double x;
    struct vec3 pole;
    struct third ratio; /* R and its derivatives */
};

/* The pole's end of axis k comes first, and x is positive inside: at an upper end it runs back. For
 * R, a Bernstein polynomial without its first coefficient is t sum_l c_l (q / l) b_(l-1)^(q-1). */
static void pinch_make(const struct surface *surface, const int span[2], const double uv[2], int k,
                       int end, struct pinch *pinch) {
    const struct surface_axis *across = &surface->axis[k], *along = &surface->axis[1 - k];
    int p = along->degree, q = across->degree, columns = surface->axis[1].degree + 1;
    size_t number = (size_t)span[0] * (size_t)surface->axis[1].span_count + (size_t)span[1];
    const vec4 *points = surface->points + number * surface->points_per_span;
    pinch->x = end ? surface_axis_upper(across) - uv[k] : uv[k] - surface_axis_lower(across);
    const double rate[2] = {along->rates[span[1 - k]], across->rates[span[k]]};
    const double t[2] = {(uv[1 - k] - along->breaks[span[1 - k]]) * rate[0], pinch->x * rate[1]};
    vec4 first = points[end ? (k == 1 ? q : q * columns) : 0];
    pinch->pole = vec3_make(first[0] / first[3], first[1] / first[3], first[2] / first[3]);
    /* The points of w r, the axis across running fastest, and those of B. */
    vec4 own[OFFSET_ORDER * OFFSET_ORDER], b[OFFSET_ORDER * OFFSET_ORDER];
    const vec4 pole = {pinch->pole.x, pinch->pole.y, pinch->pole.z, 0};
    for (int i = 0; i <= p; i++)
        for (int l = 0; l <= q; l++) {
            int at = end ? q - l : l;
            vec4 point = points[k == 1 ? i * columns + at : at * columns + i];
            own[i * (q + 1) + l] = point;
            if (l > 0)
                b[i * q + l - 1] = (point - point[3] * pole) * (rate[1] * q / l);
        }
    struct offset_basis by_p, by_less, by_q;
    struct jets a[4];
    offset_bernstein(p, t[0], rate[0], &by_p);
    offset_bernstein(q - 1, t[1], rate[1], &by_less);
    offset_bernstein(q, t[1], rate[1], &by_q);
    for (int lane = 0; lane < 3; lane++)
        offset_points(p, q - 1, b, lane, &by_p, &by_less, &a[lane]);
    offset_points(p, q, own, 3, &by_p, &by_q, &a[3]);
    offset_third(a, &pinch->ratio);
}

static void swap(struct vec3 *a, struct vec3 *b) {
    struct vec3 kept = *a;
    *a = *b;
    *b = kept;
}

/* The jet beside the pole at `end` of axis k. */
static void evaluate_pinched(const struct surface *surface, const int span[2], const double uv[2],
                             int k, int end, struct surface_jet *jet) {
    /* x R has the same derivatives of R, one less across, so many times. */
    static const int less[OF_PARTS] = {OF, OF, OF, OF, OF_U, OF_V, OF, OF_UU, OF_UV, OF_VV};
    static const int times[OF_PARTS] = {0, 0, 1, 0, 1, 2, 0, 1, 2, 3};
    struct pinch pinch;
    struct third third;
    struct surface_jet n;
    double area2;
    pinch_make(surface, span, uv, k, end, &pinch);
    const struct vec3 *ratio = pinch.ratio.of;
    for (int m = 0; m < OF_PARTS; m++)
        third.of[m] = vec3_axpy(times[m], ratio[less[m]], vec3_scale(pinch.x, ratio[m]));
    third.of[OF] = vec3_add(third.of[OF], pinch.pole);
    /* M = a x b for the sides a = R_u and b = r_v, and its derivatives: those that the cross
     * product of first derivatives has, with R_u in the place of r_u. */
    offset_normal_of(
        &(struct offset_sides){.a = {ratio[OF_U], ratio[OF_UU], ratio[OF_UV], ratio[OF_UUU],
                                     ratio[OF_UUV], ratio[OF_UVV]},
                               .b = {third.of[OF_V], third.of[OF_UV], third.of[OF_VV],
                                     third.of[OF_UUV], third.of[OF_UVV], third.of[OF_VVV]}},
        &n, &area2);
    /* Each axis that is turned round turns the normal, and so does their exchange. */
    double turn = (k == 1) == (end == 0) ? 1 : -1;
    offset_add(&third, turn * surface->height, &n, jet);
    if (end) {
        jet->v = vec3_scale(-1, jet->v);
        jet->uv = vec3_scale(-1, jet->uv);
    }
    if (k == 0) {
        swap(&jet->u, &jet->v);
        swap(&jet->uu, &jet->vv);
    }
}

/* The pole that a place is beside, if there is one. */
static bool find_pinch(const struct surface *surface, const int span[2], const double uv[2],
                       int *axis, int *end) {
    for (int k = 0; k < 2; k++)
        for (int e = 0; e < 2; e++) {
            const struct surface_axis *a = &surface->axis[k];
            if (a->pinched[e] && span[k] == (e ? a->span_count - 1 : 0) &&
                (e ? surface_axis_upper(a) - uv[k] : uv[k] - surface_axis_lower(a)) *
                        a->rates[span[k]] <=
                    SURFACE_PINCH) {
                *axis = k;
                *end = e;
                return true;
            }
        }
    return false;
}

void surface_evaluate_moved(const struct surface *surface, int span_u, int span_v, double u,
                            double v, struct surface_jet *jet) {
    const int span[2] = {span_u, span_v};
    const double uv[2] = {u, v};
    struct third third, there;
    struct surface_jet n;
    double area2;
    int k, end;
    if (find_pinch(surface, span, uv, &k, &end)) {
        evaluate_pinched(surface, span, uv, k, end, jet);
        return;
    }
    offset_base(surface, span_u, span_v, u, v, &third);
    offset_normal(&third, &n, &area2);
    if (!(area2 > 0)) {
        double at[2];
        for (int m = 0; m < 2; m++) {
            double middle = surface->axis[m].middles[span[m]];
            at[m] = uv[m] + inside * (middle - uv[m]);
        }
        offset_base(surface, span_u, span_v, at[0], at[1], &there);
        offset_normal(&there, &n, &area2);
    }
    offset_add(&third, surface->height, &n, jet);
}

/* ---- making ---- */

/* The place at `share` of a span's side that is the lower (end 0) or upper bound of `direction`. */
static void edge_jet(const struct surface *surface, int direction, int end, int span, double share,
                     struct surface_jet *jet) {
    const struct surface_axis *along = &surface->axis[1 - direction];
    const struct surface_axis *across = &surface->axis[direction];
    int at[2];
    double uv[2];
    at[1 - direction] = span;
    at[direction] = end ? across->span_count - 1 : 0;
    uv[1 - direction] =
        along->breaks[span] + share * (along->breaks[span + 1] - along->breaks[span]);
    uv[direction] = across->breaks[end ? across->span_count : 0];
    surface_evaluate_span(surface, at[0], at[1], uv[0], uv[1], jet);
}

/* The edges of a direction after they are moved: one is still a pole if all of it is still one
 * point, and the direction is closed if its edges still coincide. */
static void find_edges(struct surface *moved, int direction) {
    struct surface_axis *axis = &moved->axis[direction];
    double least = 1e-9 * moved->size;
    struct surface_jet first[2], jet[2];
    for (int end = 0; end < 2; end++) {
        edge_jet(moved, direction, end, 0, 0, &first[end]);
        axis->pole_point[end] = first[end].r;
    }
    for (int k = 0; k < CREASE_LOOKS * moved->axis[1 - direction].span_count; k++) {
        for (int end = 0; end < 2; end++) {
            edge_jet(moved, direction, end, k / CREASE_LOOKS,
                     (k % CREASE_LOOKS + 0.5) / CREASE_LOOKS, &jet[end]);
            bool point = vec3_distance(jet[end].r, first[end].r) <= least;
            axis->pole[end] = axis->pole[end] && point;
        }
        axis->closed = axis->closed && vec3_distance(jet[0].r, jet[1].r) <= least;
    }
}

enum status surface_offset(const struct surface *from, double height, struct arena *arena,
                           struct surface **moved) {
    const struct vec3 diagonal = {1, 1, 1};
    struct surface *made = arena_alloc(arena, 1, sizeof *made);
    if (!made)
        return STATUS_OUT_OF_MEMORY;
    *made = *from;
    made->height = height;
    for (int k = 0; k < 2; k++)
        memcpy(made->axis[k].pinched, from->axis[k].pole, sizeof made->axis[k].pinched);
    surface_set_bounds(made, vec3_axpy(-fabs(height), diagonal, from->lower),
                       vec3_axpy(fabs(height), diagonal, from->upper));
    find_edges(made, 0);
    find_edges(made, 1);
    *moved = made;
    return surface_finish(made);
}

double surface_offset_height(const struct surface *surface) {
    return surface->height;
}

/* ---- whether it holds ---- */

/* A search for the place where h k is greatest: the share of the way to the centre of curvature. */
struct look {
    struct surface base;
    const struct trim *trim;
    struct surface_cursor cursor;
    double height, share, uv[2];
};

/* Takes a place where the greatest of h k1 and h k2 is more than so far. That is not to be known
 * beside a pole, where the forms lose their digits: what is known around it has to do. */
static bool improve(struct look *look, const double uv[2]) {
    const struct surface_axis *axis = look->base.axis;
    const int span[2] = {surface_axis_span(&axis[0], 0, uv[0]),
                         surface_axis_span(&axis[1], 0, uv[1])};
    struct surface_point s;
    double outer[2], mean, radius, h = look->height, share = -1;
    int k, end;
    surface_outer(&look->base, uv, outer);
    if (!find_pinch(&look->base, span, uv, &k, &end) &&
        (!look->trim || trim_contains(look->trim, outer)) &&
        surface_point_at(&look->base, &look->cursor, uv, &s) &&
        surface_point_determinant(&s) > regular_share * s.first[0] * s.first[2]) {
        surface_point_principal_curvatures(&s, &mean, &radius);
        share = h * mean + fabs(h) * radius;
    }
    if (!(share > look->share))
        return false;
    look->share = share;
    memcpy(look->uv, uv, sizeof look->uv);
    return true;
}

/* Samples of every span, its sides included. */
static void sample(struct look *look) {
    const struct surface_axis *u = &look->base.axis[0], *v = &look->base.axis[1];
    double spans = (double)u->span_count * v->span_count;
    int n = (int)fmin(fmax(sqrt(SAMPLES / spans), 2), SAMPLES_PER_SPAN);
    for (int su = 0; su < u->span_count; su++)
        for (int sv = 0; sv < v->span_count; sv++)
            for (int k = 0; k < n * n; k++) {
                const double share[2] = {(double)(k / n) / (n - 1), (double)(k % n) / (n - 1)};
                const double uv[2] = {
                    u->breaks[su] + share[0] * (u->breaks[su + 1] - u->breaks[su]),
                    v->breaks[sv] + share[1] * (v->breaks[sv + 1] - v->breaks[sv])};
                (void)improve(look, uv);
            }
}

/* From the best sample uphill, by steps that halve where none of eight leads further. */
static void climb(struct look *look) {
    const struct surface_axis *axis = look->base.axis;
    double step[2];
    for (int k = 0; k < 2; k++) {
        int span = surface_axis_span(&axis[k], 0, look->uv[k]);
        step[k] = (axis[k].breaks[span + 1] - axis[k].breaks[span]) / SAMPLES_PER_SPAN;
    }
    for (int round = 0; round < ROUNDS; round++) {
        double from[2] = {look->uv[0], look->uv[1]};
        bool moved = false;
        for (int way = 0; way < 9; way++) {
            double uv[2];
            for (int k = 0; k < 2; k++)
                uv[k] = fmin(fmax(from[k] + ((k ? way / 3 : way % 3) - 1) * step[k],
                                  surface_axis_lower(&axis[k])),
                             surface_axis_upper(&axis[k]));
            moved = improve(look, uv) || moved;
        }
        for (int k = 0; k < 2 && !moved; k++)
            step[k] /= 2;
    }
}

static struct vec3 normal_of(const struct surface *base, const int span[2], const double uv[2]) {
    struct surface_jet jet;
    surface_evaluate_span(base, span[0], span[1], uv[0], uv[1], &jet);
    return vec3_unit(vec3_cross(jet.u, jet.v));
}

/* The distance between the unit normals on both sides of the knot before span `at` of direction k,
 * at a place of it: the gap that a crease leaves when it is moved by 1. */
static double crease_at(const struct look *look, int k, int at, int along, double share,
                        double uv[2]) {
    const struct surface_axis *axis = look->base.axis;
    int before[2], after[2];
    double outer[2];
    before[1 - k] = after[1 - k] = along;
    after[k] = at;
    before[k] = at > 0 ? at - 1 : axis[k].span_count - 1;
    uv[k] = axis[k].breaks[at];
    uv[1 - k] = axis[1 - k].breaks[along] +
                share * (axis[1 - k].breaks[along + 1] - axis[1 - k].breaks[along]);
    surface_outer(&look->base, uv, outer);
    if (look->trim && !trim_contains(look->trim, outer))
        return 0;
    struct vec3 a = normal_of(&look->base, after, uv);
    if (at == 0)
        uv[k] = axis[k].breaks[axis[k].span_count];
    struct vec3 b = normal_of(&look->base, before, uv);
    return vec3_distance(a, b);
}

/* The sharpest crease; `place` gets where it is. */
static double sharpest_crease(const struct look *look, double place[2]) {
    double sharpest = 0, uv[2];
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &look->base.axis[k], *other = &look->base.axis[1 - k];
        for (int at = axis->closed ? 0 : 1; at < axis->span_count; at++)
            for (int look_at = 0; look_at < CREASE_LOOKS * other->span_count; look_at++) {
                double share = (look_at % CREASE_LOOKS + 0.5) / CREASE_LOOKS;
                double crease = crease_at(look, k, at, look_at / CREASE_LOOKS, share, uv);
                if (!(crease > sharpest))
                    continue;
                sharpest = crease;
                memcpy(place, uv, 2 * sizeof *place);
            }
    }
    return sharpest;
}

bool surface_offset_holds(const struct surface *moved, const struct trim *trim, double gap,
                          struct surface_offset_fault *fault) {
    struct look look = {.base = *moved, .trim = trim, .height = moved->height, .share = -HUGE_VAL};
    double crease_uv[2], crease;
    struct surface_jet jet;
    look.base.height = 0;
    look.base.shell = NULL;
    look.base.side = 1;
    sample(&look);
    climb(&look);
    crease = sharpest_crease(&look, crease_uv);
    bool folds = look.share >= 1;
    bool creased = fabs(moved->height) * crease > gap;
    if (!folds && !creased)
        return true;
    const double *uv = folds ? look.uv : crease_uv;
    surface_jet_at(&look.base, &look.cursor, uv[0], uv[1], &jet);
    *fault = (struct surface_offset_fault){.at = jet.r};
    fault->radius = folds ? fabs(moved->height) / look.share : 0;
    fault->fold_deg = folds ? 0 : 2 * angle_atan2_deg(crease / 2, sqrt(1 - crease * crease / 4));
    surface_outer(&look.base, uv, fault->uv);
    return false;
}
