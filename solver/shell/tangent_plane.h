/* SPDX-License-Identifier: MIT */
/*
 * The tangent plane at a point, how the surface bends there and whether a pole is near, for numbers
 * and for lanes (`solver/numbers.h`). Inline, because every node needs it several times.
 */
#include "solver/numbers.h"

#ifdef FORMULAS_OF_LANES
/* Of several points what these formulas take, named as in struct surface_point. */
struct lanes_point {
    struct {
        struct lanes3 r, u, v;
    } jet;
    struct lanes3 normal;
    lanes first[3], second[3];
};
#endif

/* Whether a pole is nearer to a point than the square root of `distance2`. */
INLINE MASK NAME(surface_point_near_pole)(const struct surface *surface, VECTOR point,
                                          NUMBER distance2) {
    MASK near = distance2 < distance2;
    for (int k = 0; surface->has_poles && k < 4; k++) {
        const struct surface_axis *axis = &surface->axis[k / 2];
        if (axis->pole[k % 2])
            near |= V(norm2)(V(sub)(point, V(of)(axis->pole_point[k % 2]))) < distance2;
    }
    return near;
}

/* The first fundamental form, and the normal where r_u and r_v span a plane. */
INLINE MASK NAME(surface_point_first_form)(const struct surface *surface, const JET *jet,
                                           NUMBER first[3], VECTOR *normal) {
    VECTOR cross = V(cross)(jet->u, jet->v);
    NUMBER nu = V(norm2)(jet->u), nv = V(norm2)(jet->v), area = V(norm2)(cross);
    const double *least = surface->least_tangent2;
    first[0] = nu;
    first[1] = V(dot)(jet->u, jet->v);
    first[2] = nv;
    *normal = V(scale)(surface->side / N(sqrt)(area), cross);
    return (nu > least[0]) & (nv > least[1]) &
           (area > SURFACE_POINT_PARALLEL * SURFACE_POINT_PARALLEL * nu * nv);
}

INLINE void NAME(surface_point_second_form)(const JET *jet, VECTOR normal, NUMBER second[3]) {
    second[0] = V(dot)(jet->uu, normal);
    second[1] = V(dot)(jet->uv, normal);
    second[2] = V(dot)(jet->vv, normal);
}

/* The tangent plane by r_u and r_v, and the components of what has the products (p, q) with them.
 */
struct NAME(tangent_basis) {
    VECTOR u, v;
    NUMBER e, f, g, inverse; /* 1 / (E G - F^2) */
};

INLINE struct NAME(tangent_basis) NAME(tangent_basis_of)(VECTOR u, VECTOR v) {
    struct NAME(tangent_basis) b = {u, v, V(norm2)(u), V(dot)(u, v), V(norm2)(v), N(of)(0)};
    b.inverse = 1 / (b.e * b.g - b.f * b.f);
    return b;
}

INLINE void NAME(tangent_solve)(const struct NAME(tangent_basis) * b, NUMBER p, NUMBER q,
                                NUMBER ab[2]) {
    ab[0] = (b->g * p - b->f * q) * b->inverse;
    ab[1] = (b->e * q - b->f * p) * b->inverse;
}

INLINE void NAME(tangent_components)(const struct NAME(tangent_basis) * b, VECTOR of,
                                     NUMBER ab[2]) {
    NAME(tangent_solve)(b, V(dot)(of, b->u), V(dot)(of, b->v), ab);
}

/* r_uu a^2 + 2 r_uv a b + r_vv b^2: how r bends along r_u a + r_v b. */
INLINE VECTOR NAME(jet_bend)(const JET *jet, const NUMBER ab[2]) {
    VECTOR sum = V(scale)(ab[0] * ab[0], jet->uu);
    sum = V(axpy)(2 * ab[0] * ab[1], jet->uv, sum);
    return V(axpy)(ab[1] * ab[1], jet->vv, sum);
}

/* With E, F, G the first fundamental form and (p, q) = direction . (r_u, r_v), the components are
 * (G p - F q, E q - F p) / (E G - F^2); this is the numerator. */
INLINE void NAME(surface_point_scaled_components)(const POINT *point, VECTOR direction,
                                                  NUMBER ab[2]) {
    const NUMBER *first = point->first;
    NUMBER p = V(dot)(direction, point->jet.u), q = V(dot)(direction, point->jet.v);
    ab[0] = first[2] * p - first[1] * q;
    ab[1] = first[0] * q - first[1] * p;
}

INLINE NUMBER NAME(surface_point_determinant)(const POINT *point) {
    return point->first[0] * point->first[2] - point->first[1] * point->first[1];
}

/* Whether r_u and r_v are not parallel; written so that NaN says no. */
INLINE MASK NAME(surface_point_is_regular)(const POINT *point) {
    NUMBER least =
        SURFACE_POINT_PARALLEL * SURFACE_POINT_PARALLEL * point->first[0] * point->first[2];
    return NAME(surface_point_determinant)(point) > least;
}

/* Components (a, b) of the projection of `direction` on the tangent plane: r_u a + r_v b. False
 * where r_u and r_v are parallel. */
INLINE MASK NAME(surface_point_components)(const POINT *point, VECTOR direction, NUMBER ab[2]) {
    MASK regular = NAME(surface_point_is_regular)(point);
    if (!N(any)(regular))
        return regular;
    NUMBER inverse = 1 / NAME(surface_point_determinant)(point);
    NAME(surface_point_scaled_components)(point, direction, ab);
    ab[0] *= inverse;
    ab[1] *= inverse;
    return regular;
}

/* `direction` projected on the tangent plane, zero when it is normal to the surface; and that as a
 * unit vector. */
INLINE VECTOR NAME(surface_point_projection)(const POINT *point, VECTOR direction) {
    NUMBER along = V(dot)(direction, point->normal);
    return V(axpy)(-along, point->normal, direction);
}

INLINE VECTOR NAME(surface_point_tangent)(const POINT *point, VECTOR direction) {
    return V(unit)(NAME(surface_point_projection)(point, direction));
}

/* a^2, 2 a b, b^2 weighted by a fundamental form */
INLINE NUMBER NAME(surface_point_form)(const NUMBER coefficients[3], const NUMBER ab[2]) {
    return ab[0] * ab[0] * coefficients[0] + 2 * ab[0] * ab[1] * coefficients[1] +
           ab[1] * ab[1] * coefficients[2];
}

/* Normal curvature II(t, t) / I(t, t) in the direction t of the projection of `direction`
 * (paper, equation 12), in 1 / length, positive where the surface bends towards the normal; a ratio
 * of forms, so that the length of t does not matter. 0 where there is none. */
INLINE NUMBER NAME(surface_point_normal_curvature)(const POINT *point, VECTOR direction) {
    NUMBER ab[2];
    NAME(surface_point_scaled_components)(point, direction, ab);
    NUMBER length2 = NAME(surface_point_form)(point->first, ab);
    MASK good = NAME(surface_point_is_regular)(point) & (length2 > 0);
    return N(select)(good, NAME(surface_point_form)(point->second, ab) / length2, N(of)(0));
}

/* Gaussian curvature, det II / det I. */
INLINE NUMBER NAME(surface_point_gauss_curvature)(const POINT *point) {
    const NUMBER *second = point->second;
    return (second[0] * second[2] - second[1] * second[1]) / NAME(surface_point_determinant)(point);
}
