/* SPDX-License-Identifier: MIT */
#include "fit.h"

#include "ring.h"

/* Vertices that a fit looks for, and the most it takes; triangles it goes through for them. */
enum { POINTS_WANTED = 16, POINTS_MAX = 48, TRIANGLES_MAX = 160, TERMS_QUADRATIC = 5 };

/* Two vertices more than terms, so that one that is off is evened out. */
enum { POINTS_CUBIC = FIT_TERMS + 2, POINTS_QUADRATIC = TERMS_QUADRATIC + 1 };

/* A column of the least-squares problem of which the others leave less than this share is not
 * determined. */
static const double independent = 1e-3;

/* Triangles whose normal makes a larger angle with the vertex's than 60 degrees are another side.
 */
static const double same_side = 0.5;

/* A fit that is steeper than this against the mean normal, or rises by more than this many times
 * its own reach by its second or third powers, does not describe the surface. */
static const double steepest = 0.6, rise_most = 2;

bool mesh_is_fold(const struct mesh *mesh, int32_t edge) {
    const struct vec3 *normals = mesh->normals;
    return vec3_dot(normals[edge / 3], normals[mesh->twins[edge] / 3]) < MESH_FOLD_COSINE;
}

/* Whether the surface goes on smoothly across a half-edge. */
static bool is_smooth_across(const struct mesh *mesh, int32_t edge) {
    return mesh->twins[edge] != MESH_NONE && !mesh_is_fold(mesh, edge);
}

/* The first corner, clockwise, of the side that a corner of a triangle belongs to. */
static int32_t first_of_side(const struct mesh *mesh, int32_t corner) {
    int32_t at = corner;
    while (is_smooth_across(mesh, at)) {
        at = mesh_ring_previous(mesh, at);
        if (at == corner)
            break;
    }
    return at;
}

/* Numbers the sides of all vertices; their normals go to `fit`, if there is one. Each triangle
 * counts by the sine of its angle over the lengths of its edges, which is exact on a sphere (N.
 * Max, Weights for computing vertex normals from facet normals, 1999). */
static size_t number_sides(const struct mesh *mesh, int32_t *side, struct mesh_fit *fit) {
    size_t count = 0;
    for (int32_t corner = 0; corner < 3 * (int32_t)mesh->triangle_count; corner++)
        side[corner] = MESH_NONE;
    for (int32_t corner = 0; corner < 3 * (int32_t)mesh->triangle_count; corner++) {
        if (side[corner] != MESH_NONE)
            continue;
        struct vec3 sum = {0, 0, 0};
        int32_t first = first_of_side(mesh, corner), at = first;
        for (;;) {
            struct vec3 p[3];
            mesh_corner_points(mesh, at / 3, p);
            struct vec3 a = vec3_sub(p[(at + 1) % 3], p[at % 3]);
            struct vec3 b = vec3_sub(p[(at + 2) % 3], p[at % 3]);
            sum = vec3_axpy(1 / (vec3_norm2(a) * vec3_norm2(b)), vec3_cross(a, b), sum);
            side[at] = (int32_t)count;
            int32_t next =
                is_smooth_across(mesh, mesh_previous_half(at)) ? mesh_ring_next(mesh, at) : first;
            if (next == first)
                break;
            at = next;
        }
        if (fit)
            fit[count] = (struct mesh_fit){.origin = mesh_corner_point(mesh, first / 3, first % 3),
                                           .normal = vec3_unit(sum)};
        count++;
    }
    return count;
}

/* What is near a vertex: triangles in rings, connected without folds, and their vertices. */
struct vicinity {
    const struct mesh *mesh;
    int32_t *seen; /* of each triangle: the last fit that has been there, plus 1 */
    int32_t triangles[TRIANGLES_MAX];
    struct vec3 points[POINTS_MAX];
    int triangle_count, point_count;
};

/* Notes a triangle and those of its vertices that are not known yet. */
static void look_at_triangle(struct vicinity *v, const struct mesh_fit *fit, int32_t t,
                             int32_t stamp) {
    if (v->seen[t] == stamp || v->triangle_count == TRIANGLES_MAX)
        return;
    v->seen[t] = stamp;
    if (!(vec3_dot(v->mesh->normals[t], fit->normal) > same_side))
        return;
    v->triangles[v->triangle_count++] = t;
    for (int k = 0; k < 3; k++) {
        struct vec3 r = mesh_corner_point(v->mesh, t, k);
        bool known = v->point_count == POINTS_MAX || vec3_distance(r, fit->origin) == 0;
        for (int n = 0; n < v->point_count && !known; n++)
            known = vec3_distance(r, v->points[n]) == 0;
        if (!known)
            v->points[v->point_count++] = r;
    }
}

/* The triangles of a side, begun at one of its corners, and whole rings round them until there are
 * vertices enough. */
static void look_around_vertex(struct vicinity *v, const struct mesh_fit *fit, int32_t corner,
                               int32_t stamp) {
    const struct mesh *mesh = v->mesh;
    v->triangle_count = v->point_count = 0;
    int32_t first = first_of_side(mesh, corner), at = first;
    do {
        look_at_triangle(v, fit, at / 3, stamp);
        at = is_smooth_across(mesh, mesh_previous_half(at)) ? mesh_ring_next(mesh, at) : MESH_NONE;
    } while (at != MESH_NONE && at != first);
    for (int begin = 0; begin < v->triangle_count && v->point_count < POINTS_WANTED;) {
        int end = v->triangle_count;
        for (; begin < end; begin++)
            for (int k = 0; k < 3; k++)
                if (is_smooth_across(mesh, 3 * v->triangles[begin] + k))
                    look_at_triangle(v, fit, mesh->twins[3 * v->triangles[begin] + k] / 3, stamp);
    }
}

/* A least-squares problem: columns of the terms, and last that of the heights. */
struct problem {
    double column[FIT_TERMS + 1][POINTS_MAX];
    double size[FIT_TERMS + 1]; /* of each column at first */
    int rows;
};

static double dot_columns(const struct problem *p, int a, int b) {
    double sum = 0;
    for (int k = 0; k < p->rows; k++)
        sum += p->column[a][k] * p->column[b][k];
    return sum;
}

/* The first `terms` coefficients by the modified Gram-Schmidt process, the heights as one more
 * column; false where they are not determined. The columns are used up. */
static bool solve_least_squares(struct problem *p, int terms, double coefficient[FIT_TERMS]) {
    double r[FIT_TERMS][FIT_TERMS + 1];
    for (int m = 0; m < terms; m++) {
        r[m][m] = sqrt(dot_columns(p, m, m));
        if (!(r[m][m] > independent * p->size[m]))
            return false;
        for (int k = 0; k < p->rows; k++)
            p->column[m][k] /= r[m][m];
        for (int n = m + 1; n <= FIT_TERMS; n++) {
            r[m][n] = dot_columns(p, m, n);
            for (int k = 0; k < p->rows; k++)
                p->column[n][k] -= r[m][n] * p->column[m][k];
        }
    }
    for (int m = terms - 1; m >= 0; m--) {
        coefficient[m] = r[m][FIT_TERMS];
        for (int n = m + 1; n < terms; n++)
            coefficient[m] -= r[m][n] * coefficient[n];
        coefficient[m] /= r[m][m];
    }
    return true;
}

/* Of each point the rise by second and by third powers counts: they may lie far along a nose and
 * near across it, and its curvature is no matter beyond them. */
static bool describes_surface(const double c[FIT_TERMS], const struct vicinity *v,
                              const struct mesh_fit *fit, double reach) {
    if (!(c[0] * c[0] + c[1] * c[1] < steepest * steepest))
        return false;
    for (int k = 0; k < v->point_count; k++) {
        struct vec3 offset = vec3_scale(1 / reach, vec3_sub(v->points[k], fit->origin));
        double x = fabs(vec3_dot(offset, fit->x)), y = fabs(vec3_dot(offset, fit->y));
        double second = fabs(c[2]) * x * x + fabs(c[3]) * x * y + fabs(c[4]) * y * y;
        double third = fabs(c[5]) * x * x * x + fabs(c[6]) * x * x * y + fabs(c[7]) * x * y * y +
                       fabs(c[8]) * y * y * y;
        if (!(second < rise_most && third < rise_most))
            return false;
    }
    return true;
}

/* The highest polynomial that the vertices around determine; at worst the tangent plane. */
static void fit_surface(struct mesh_fit *fit, const struct vicinity *v) {
    static const int terms[2] = {FIT_TERMS, TERMS_QUADRATIC};
    static const int least[2] = {POINTS_CUBIC, POINTS_QUADRATIC};
    struct problem problem;
    double reach = 0;
    struct vec3 n = fit->normal;
    double a = fabs(n.x), b = fabs(n.y), along = fabs(n.z);
    struct vec3 across = a <= b && a <= along ? vec3_make(1, 0, 0)
                         : b <= along         ? vec3_make(0, 1, 0)
                                              : vec3_make(0, 0, 1);
    fit->x = vec3_unit(vec3_cross(across, n));
    fit->y = vec3_cross(n, fit->x);
    for (int k = 0; k < v->point_count; k++)
        reach = fmax(reach, vec3_distance(v->points[k], fit->origin));
    for (int k = 0; k < 2; k++) {
        double c[FIT_TERMS] = {0};
        if (v->point_count < least[k])
            continue;
        /* vertices count less the further off they are; lengths in units of `reach` */
        problem.rows = v->point_count;
        for (int row = 0; row < problem.rows; row++) {
            struct vec3 offset = vec3_scale(1 / reach, vec3_sub(v->points[row], fit->origin));
            double x = vec3_dot(offset, fit->x), y = vec3_dot(offset, fit->y);
            double weight = 1 / (0.1 + x * x + y * y);
            double term[FIT_TERMS + 1] = {
                x,         y,         x * x,     x * y,     y * y,
                x * x * x, x * x * y, x * y * y, y * y * y, vec3_dot(offset, fit->normal)};
            for (int m = 0; m <= FIT_TERMS; m++)
                problem.column[m][row] = weight * term[m];
        }
        for (int m = 0; m <= FIT_TERMS; m++)
            problem.size[m] = sqrt(dot_columns(&problem, m, m));
        if (!solve_least_squares(&problem, terms[k], c) || !describes_surface(c, v, fit, reach))
            continue;
        for (int m = 0; m < 2; m++)
            fit->slope[m] = c[m];
        for (int m = 0; m < 3; m++)
            fit->second[m] = c[2 + m] / reach;
        for (int m = 0; m < 4; m++)
            fit->third[m] = c[5 + m] / (reach * reach);
        return;
    }
}

enum status mesh_fits_make(const struct mesh *mesh, struct arena *arena, struct mesh_fits *fits) {
    size_t corners = 3 * mesh->triangle_count;
    int32_t *side = arena_take(arena, corners, sizeof *side);
    if (!side)
        return STATUS_OUT_OF_MEMORY;
    *fits = (struct mesh_fits){.of = (int32_t(*)[3])side, .count = number_sides(mesh, side, NULL)};
    fits->fit = arena_take(arena, fits->count, sizeof *fits->fit);
    struct arena_mark mark = arena_mark(arena);
    struct vicinity v = {.mesh = mesh};
    v.seen = arena_alloc(arena, mesh->triangle_count, sizeof *v.seen);
    if (!fits->fit || !v.seen)
        return STATUS_OUT_OF_MEMORY;
    (void)number_sides(mesh, side, fits->fit);
    int32_t next = 0;
    for (int32_t corner = 0; corner < (int32_t)corners; corner++)
        if (side[corner] == next) {
            next++;
            look_around_vertex(&v, &fits->fit[side[corner]], corner, next);
            fit_surface(&fits->fit[side[corner]], &v);
        }
    arena_rewind(arena, mark);
    return STATUS_OK;
}
