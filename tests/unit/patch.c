/* SPDX-License-Identifier: MIT */
#include "patch.h"

enum { ORDER_MAX = NURBS_DEGREE_MAX + 1 };

struct homogeneous {
    long double c[4];
};

static void make_axis(struct nurbs_axis *axis, double *knots, int degree, bool clamped,
                      struct random *random) {
    int size = degree + 1 + random_index(random, PATCH_SIZE_MAX - degree);
    int count = size + degree + 1;
    knots[0] = random_between(random, -2, 2);
    for (int i = 1; i < count; i++) {
        bool end = clamped && (i <= degree || i > size);
        bool repeated = i > degree + 1 && i < size && random_index(random, 6) == 0 &&
                        knots[i - 1] > knots[i - 2];
        knots[i] =
            knots[i - 1] + (end || (repeated && degree > 1) ? 0 : random_between(random, 0.3, 1));
    }
    *axis = (struct nurbs_axis){degree, size, knots, (size_t)count};
}

void patch_make(struct patch *patch, const struct patch_kind *kind, struct random *random) {
    struct nurbs *nurbs = &patch->nurbs;
    *nurbs = (struct nurbs){.points = patch->points};
    make_axis(&nurbs->u, patch->knots[0], kind->p, kind->clamped, random);
    make_axis(&nurbs->v, patch->knots[1], kind->q, kind->clamped, random);
    nurbs->point_count = (size_t)(nurbs->u.size * nurbs->v.size);
    for (int i = 0; i < nurbs->u.size; i++)
        for (int j = 0; j < nurbs->v.size; j++) {
            int at = i * nurbs->v.size + j;
            patch->points[at] =
                vec3_make(i + random_between(random, -0.3, 0.3),
                          j + random_between(random, -0.3, 0.3), random_between(random, -1, 1));
            patch->weights[at] = random_between(random, 0.6, 1.6);
        }
    if (kind->rational) {
        nurbs->weights = patch->weights;
        nurbs->weight_count = nurbs->point_count;
    }
}

double patch_parameter(const struct nurbs_axis *axis, struct random *random, int *span) {
    do
        *span = axis->degree + random_index(random, axis->size - axis->degree);
    while (!(axis->knots[*span + 1] > axis->knots[*span]));
    double share = random_between(random, 0.05, 0.95);
    return axis->knots[*span] + share * (axis->knots[*span + 1] - axis->knots[*span]);
}

/* de Boor's algorithm on the p + 1 coefficients of span l, in place. */
static struct homogeneous de_boor(const struct nurbs_axis *axis, int l, long double x,
                                  struct homogeneous *d) {
    int p = axis->degree;
    for (int r = 1; r <= p; r++)
        for (int j = p; j >= r; j--) {
            long double low = axis->knots[j + l - p], high = axis->knots[j + 1 + l - r];
            long double a = (x - low) / (high - low);
            for (int k = 0; k < 4; k++)
                d[j].c[k] = (1 - a) * d[j - 1].c[k] + a * d[j].c[k];
        }
    return d[p];
}

struct patch_point patch_evaluate(const struct nurbs *nurbs, int lu, int lv, long double u,
                                  long double v) {
    int p = nurbs->u.degree, q = nurbs->v.degree;
    struct homogeneous column[ORDER_MAX], row[ORDER_MAX];
    for (int i = 0; i <= p; i++) {
        for (int j = 0; j <= q; j++) {
            size_t at = (size_t)((lu - p + i) * nurbs->v.size + lv - q + j);
            long double w = nurbs->weights ? nurbs->weights[at] : 1;
            struct vec3 r = nurbs->points[at];
            row[j] = (struct homogeneous){{w * r.x, w * r.y, w * r.z, w}};
        }
        column[i] = de_boor(&nurbs->v, lv, v, row);
    }
    struct homogeneous a = de_boor(&nurbs->u, lu, u, column);
    return (struct patch_point){a.c[0] / a.c[3], a.c[1] / a.c[3], a.c[2] / a.c[3]};
}
