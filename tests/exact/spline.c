/* SPDX-License-Identifier: MIT */
/* The general part of `shapes.h`: evaluation, curvature, knot insertion, motions. */
#include "shapes.h"
#include <assert.h>
#include <string.h>

struct motion motion_identity(void) {
    return motion_stretch(1, 1, 1);
}

struct motion motion_stretch(double x, double y, double z) {
    return (struct motion){.m = {{x, 0, 0}, {0, y, 0}, {0, 0, z}}, .shift = {0, 0, 0}};
}

/* Rodrigues: R = I + sin a K + (1 - cos a) K^2, K the cross product with the unit axis. */
struct motion motion_similar(double scale, struct vec3 axis, double angle, struct vec3 shift) {
    struct vec3 e = vec3_unit(axis);
    double k[3][3] = {{0, -e.z, e.y}, {e.z, 0, -e.x}, {-e.y, e.x, 0}};
    struct motion motion = {.shift = shift};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            double square = 0;
            for (int l = 0; l < 3; l++) {
                square += k[i][l] * k[l][j];
            }
            double turn = (i == j) + sin(angle) * k[i][j] + (1 - cos(angle)) * square;
            motion.m[i][j] = scale * turn;
        }
    }
    return motion;
}

struct vec3 motion_vector(const struct motion *motion, struct vec3 a) {
    const double(*m)[3] = motion->m;
    return vec3_make(m[0][0] * a.x + m[0][1] * a.y + m[0][2] * a.z,
                     m[1][0] * a.x + m[1][1] * a.y + m[1][2] * a.z,
                     m[2][0] * a.x + m[2][1] * a.y + m[2][2] * a.z);
}

struct vec3 motion_point(const struct motion *motion, struct vec3 a) {
    return vec3_add(motion_vector(motion, a), motion->shift);
}

void shape_move(struct shape *shape, const struct motion *motion) {
    for (int i = 0; i < shape->size[0] * shape->size[1]; i++) {
        double *h = shape->h[i];
        struct vec3 a = motion_vector(motion, vec3_make(h[0], h[1], h[2]));
        a = vec3_axpy(h[3], motion->shift, a);
        h[0] = a.x;
        h[1] = a.y;
        h[2] = a.z;
    }
}

void shape_domain(const struct shape *shape, double lower[2], double upper[2]) {
    for (int k = 0; k < 2; k++) {
        lower[k] = shape->knots[k][shape->degree[k]];
        upper[k] = shape->knots[k][shape->size[k]];
    }
}

int shape_span(const struct shape *shape, int k, double x) {
    const double *knots = shape->knots[k];
    int span = shape->degree[k];
    for (int i = span; i < shape->size[k]; i++) {
        if (knots[i] < knots[i + 1] && knots[i] <= x) {
            span = i;
        }
    }
    return span;
}

/* From N_i^(d-1) to N_i^d, i = span - d .. span. */
static void raise_degree(const double *knots, int span, int d, double x, double *n) {
    double carried = 0;
    for (int r = 0; r < d; r++) {
        double right = knots[span + r + 1] - x, left = x - knots[span + 1 - d + r];
        double part = n[r] / (right + left);
        n[r] = carried + right * part;
        carried = left * part;
    }
    n[d] = carried;
}

/* From functions sum_i a_i N_i^q to those of the derivative of N^(q+1):
 * (N_i^(q+1))' = (q+1) (N_i^q / (t_(i+q+1) - t_i) - N_(i+1)^q / (t_(i+q+2) - t_(i+1))). */
static void raise_derivative(const double *knots, int span, int q, double *a) {
    double previous = 0;
    for (int r = 0; r <= q; r++) {
        int i = span - q + r;
        double slope = (q + 1) * a[r] / (knots[i + q + 1] - knots[i]);
        a[r] = previous - slope;
        previous = slope;
    }
    a[q + 1] = previous;
}

/* Values, first and second derivatives of the degree + 1 basis functions of a span. */
static void basis_jet(const struct shape *shape, int k, int span, double x,
                      double out[3][NURBS_DEGREE_MAX + 1]) {
    const double *knots = shape->knots[k];
    int p = shape->degree[k];
    memset(out, 0, 3 * sizeof out[0]);
    out[0][0] = 1;
    for (int d = 0; d <= p; d++) {
        if (d > 0) {
            raise_degree(knots, span, d, x, out[0]);
        }
        if (p - d == 1 || p - d == 2) {
            memcpy(out[p - d], out[0], sizeof out[0]);
        }
    }
    for (int order = 1; order <= 2 && order <= p; order++) {
        for (int q = p - order; q < p; q++) {
            raise_derivative(knots, span, q, out[order]);
        }
    }
}

/* Homogeneous sums sum N_i^(du) N_j^(dv) h_ij for the six derivatives of a jet. */
static void sum_span(const struct shape *shape, const int span[2],
                     double nu[3][NURBS_DEGREE_MAX + 1], double nv[3][NURBS_DEGREE_MAX + 1],
                     double sum[6][4]) {
    static const int orders[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
    memset(sum, 0, 6 * sizeof sum[0]);
    for (int i = 0; i <= shape->degree[0]; i++) {
        int at = (span[0] - shape->degree[0] + i) * shape->size[1] + span[1] - shape->degree[1];
        double row[3][4] = {{0}};
        for (int j = 0; j <= shape->degree[1]; j++) {
            for (int c = 0; c < 4; c++) {
                row[0][c] += nv[0][j] * shape->h[at + j][c];
                row[1][c] += nv[1][j] * shape->h[at + j][c];
                row[2][c] += nv[2][j] * shape->h[at + j][c];
            }
        }
        for (int o = 0; o < 6; o++) {
            for (int c = 0; c < 4; c++) {
                sum[o][c] += nu[orders[o][0]][i] * row[orders[o][1]][c];
            }
        }
    }
}

void shape_evaluate_in(const struct shape *shape, const int span[2], double u, double v,
                       struct surface_jet *jet) {
    double nu[3][NURBS_DEGREE_MAX + 1], nv[3][NURBS_DEGREE_MAX + 1], sum[6][4];
    basis_jet(shape, 0, span[0], u, nu);
    basis_jet(shape, 1, span[1], v, nv);
    sum_span(shape, span, nu, nv, sum);
    struct vec3 a[6];
    double w[6];
    for (int o = 0; o < 6; o++) {
        a[o] = vec3_make(sum[o][0], sum[o][1], sum[o][2]);
        w[o] = sum[o][3];
    }
    double s = 1 / w[0];
    jet->r = vec3_scale(s, a[0]);
    jet->u = vec3_scale(s, vec3_axpy(-w[1], jet->r, a[1]));
    jet->v = vec3_scale(s, vec3_axpy(-w[2], jet->r, a[2]));
    jet->uu = vec3_scale(s, vec3_axpy(-2 * w[1], jet->u, vec3_axpy(-w[3], jet->r, a[3])));
    jet->vv = vec3_scale(s, vec3_axpy(-2 * w[2], jet->v, vec3_axpy(-w[5], jet->r, a[5])));
    struct vec3 mixed = vec3_axpy(-w[1], jet->v, vec3_axpy(-w[2], jet->u, a[4]));
    jet->uv = vec3_scale(s, vec3_axpy(-w[4], jet->r, mixed));
}

void shape_evaluate(const struct shape *shape, double u, double v, struct surface_jet *jet) {
    int span[2] = {shape_span(shape, 0, u), shape_span(shape, 1, v)};
    shape_evaluate_in(shape, span, u, v, jet);
}

struct vec3 shape_point(const struct shape *shape, const double uv[2]) {
    struct surface_jet jet;
    shape_evaluate(shape, uv[0], uv[1], &jet);
    return jet.r;
}

/* One row of homogeneous points, `stride` apart, gets the knot: a_i Q_i + (1 - a_i) Q_(i-1). */
static void insert_in_row(double (*h)[4], int stride, const double *knots, int degree, int size,
                          int span, double knot) {
    for (int i = size; i > span - degree; i--) {
        double a = 0;
        if (i <= span) {
            a = (knot - knots[i]) / (knots[i + degree] - knots[i]);
        }
        for (int c = 0; c < 4; c++) {
            double here = i < size ? h[i * stride][c] : 0;
            h[i * stride][c] = a * here + (1 - a) * h[(i - 1) * stride][c];
        }
    }
}

void shape_insert_knot(struct shape *shape, int k, double knot) {
    int degree = shape->degree[k], size = shape->size[k], span = shape_span(shape, k, knot);
    assert(size < SHAPE_SIZE_MAX);
    if (k == 1) { /* make room: rows grow by one */
        shape_transpose(shape);
        shape_insert_knot(shape, 0, knot);
        shape_transpose(shape);
        return;
    }
    for (int j = 0; j < shape->size[1]; j++) {
        insert_in_row(shape->h + j, shape->size[1], shape->knots[0], degree, size, span, knot);
    }
    for (int i = size + degree + 1; i > span + 1; i--) {
        shape->knots[0][i] = shape->knots[0][i - 1];
    }
    shape->knots[0][span + 1] = knot;
    shape->size[0]++;
}

void shape_transpose(struct shape *shape) {
    static struct shape copy;
    copy = *shape;
    for (int k = 0; k < 2; k++) {
        shape->degree[k] = copy.degree[1 - k];
        shape->size[k] = copy.size[1 - k];
        memcpy(shape->knots[k], copy.knots[1 - k], sizeof copy.knots[0]);
    }
    for (int i = 0; i < copy.size[0]; i++) {
        for (int j = 0; j < copy.size[1]; j++) {
            memcpy(shape->h[j * copy.size[0] + i], copy.h[i * copy.size[1] + j], sizeof copy.h[0]);
        }
    }
}

/* Keeps rows low .. of direction 0, those whose functions live on [x[0], x[1]]. */
static void cut_rows(struct shape *shape, const double x[2]) {
    int p = shape->degree[0], row = shape->size[1];
    for (int end = 0; end < 2; end++) {
        int count = 0;
        for (int i = 0; i < shape->size[0] + p + 1; i++) {
            count += shape->knots[0][i] == x[end];
        }
        for (; count < p; count++) {
            shape_insert_knot(shape, 0, x[end]);
        }
    }
    int span = shape_span(shape, 0, x[0]), end = span;
    while (shape->knots[0][end] < x[1]) {
        end++;
    }
    int first = span - p, size = end - first, inner = end - span - 1;
    memmove(shape->h, shape->h + first * row, (size_t)(size * row) * sizeof shape->h[0]);
    memmove(shape->knots[0] + p + 1, shape->knots[0] + span + 1,
            (size_t)inner * sizeof shape->knots[0][0]);
    for (int i = 0; i <= p; i++) {
        shape->knots[0][i] = x[0];
        shape->knots[0][size + i] = x[1];
    }
    shape->size[0] = size;
}

void shape_cut(struct shape *shape, const double u[2], const double v[2]) {
    cut_rows(shape, u);
    shape_transpose(shape);
    cut_rows(shape, v);
    shape_transpose(shape);
}

enum { AREA_GRID = 80 };

double shape_area(const struct shape *shape) {
    double lower[2], upper[2], sum = 0;
    shape_domain(shape, lower, upper);
    double du = (upper[0] - lower[0]) / AREA_GRID, dv = (upper[1] - lower[1]) / AREA_GRID;
    for (int i = 0; i < AREA_GRID * AREA_GRID; i++) {
        struct surface_jet jet;
        double u = lower[0] + (i / AREA_GRID + 0.5) * du;
        double v = lower[1] + (i % AREA_GRID + 0.5) * dv;
        shape_evaluate(shape, u, v, &jet);
        sum += du * dv * vec3_norm(vec3_cross(jet.u, jet.v));
    }
    return sum;
}

double shape_perimeter(const struct shape *shape) {
    double lower[2], upper[2], sum = 0;
    shape_domain(shape, lower, upper);
    for (int side = 0; side < 4; side++) {
        int k = side / 2;
        struct vec3 last = {0, 0, 0};
        for (int i = 0; i <= AREA_GRID; i++) {
            double uv[2], share = (double)i / AREA_GRID;
            uv[k] = lower[k] * (1 - share) + upper[k] * share;
            uv[1 - k] = side % 2 ? upper[1 - k] : lower[1 - k];
            struct vec3 r = shape_point(shape, uv);
            sum += i ? vec3_distance(r, last) : 0;
            last = r;
        }
    }
    return sum;
}

struct nurbs shape_nurbs(struct shape *shape) {
    size_t count = (size_t)(shape->size[0] * shape->size[1]);
    for (size_t i = 0; i < count; i++) {
        const double *h = shape->h[i];
        shape->points[i] = vec3_make(h[0] / h[3], h[1] / h[3], h[2] / h[3]);
        shape->weights[i] = h[3];
    }
    struct nurbs nurbs = {
        .points = shape->points,
        .point_count = count,
        .weights = shape->weights,
        .weight_count = count,
    };
    struct nurbs_axis *axis[2] = {&nurbs.u, &nurbs.v};
    for (int k = 0; k < 2; k++) {
        axis[k]->degree = shape->degree[k];
        axis[k]->size = shape->size[k];
        axis[k]->knots = shape->knots[k];
        axis[k]->knot_count = (size_t)(shape->size[k] + shape->degree[k] + 1);
    }
    return nurbs;
}

struct vec3 jet_normal(const struct surface_jet *jet) {
    return vec3_unit(vec3_cross(jet->u, jet->v));
}

/* Least squares: [E F; F G] (du, dv) = (a . r_u, a . r_v). */
void jet_pull_back(const struct surface_jet *jet, struct vec3 a, double duv[2]) {
    double e = vec3_norm2(jet->u), f = vec3_dot(jet->u, jet->v), g = vec3_norm2(jet->v);
    double au = vec3_dot(a, jet->u), av = vec3_dot(a, jet->v), det = e * g - f * f;
    duv[0] = (g * au - f * av) / det;
    duv[1] = (e * av - f * au) / det;
}

double jet_second_form(const struct surface_jet *jet, struct vec3 a, struct vec3 b) {
    double p[2], q[2];
    struct vec3 n = jet_normal(jet);
    jet_pull_back(jet, a, p);
    jet_pull_back(jet, b, q);
    return p[0] * q[0] * vec3_dot(jet->uu, n) + (p[0] * q[1] + p[1] * q[0]) * vec3_dot(jet->uv, n) +
           p[1] * q[1] * vec3_dot(jet->vv, n);
}

double jet_gauss(const struct surface_jet *jet) {
    struct vec3 n = jet_normal(jet);
    double m = vec3_dot(jet->uv, n);
    double top = vec3_dot(jet->uu, n) * vec3_dot(jet->vv, n) - m * m;
    return top / vec3_norm2(vec3_cross(jet->u, jet->v));
}

void shape_frame(const struct shape *shape, const double uv[2], double angle_deg,
                 double pre_shear_deg, struct vec3 *warp, struct vec3 *weft) {
    struct surface_jet jet;
    shape_evaluate(shape, uv[0], uv[1], &jet);
    struct vec3 x = vec3_unit(jet.u), y = vec3_cross(jet_normal(&jet), x);
    double a = angle_deg * M_PI / 180, b = a + (90 - pre_shear_deg) * M_PI / 180;
    *warp = vec3_add(vec3_scale(cos(a), x), vec3_scale(sin(a), y));
    *weft = vec3_add(vec3_scale(cos(b), x), vec3_scale(sin(b), y));
}
