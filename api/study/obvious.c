/* SPDX-License-Identifier: MIT */
/*
 * The variants that an engineer would try first. A part that is its own mirror image in a plane is
 * mostly best laid from that plane, along it, across it or at 45 degrees to it; there the largest
 * shear has a narrow least, because the shear of both halves is the same only there, and starts
 * that are spread over the part miss it.
 */
#include "rounds.h"

#include "solver/angle.h"
#include <math.h>

/* A search of the least budget has more. */
enum { OBVIOUS_MOST = 12 };

/* ---- planes of symmetry ---- */

struct plane {
    struct vec3 at, normal;
};
enum { PLANES_MOST = 3 };

/* Points of the part that tell its symmetry, and how far their images may be from it, as a share of
 * its length: a fifth of the points' distance. */
enum { TRIED = 100 };
static const double symmetric = 0.02;

static double component(struct vec3 v, int k) {
    return k == 0 ? v.x : k == 1 ? v.y : v.z;
}

/* The principal axes of points: the eigenvectors of the sum of r r^T about their middle, by
 * Jacobi's rotations. */
static void principal_axes(const struct part_point *points, size_t count, struct vec3 middle,
                           struct vec3 axes[3]) {
    enum { SWEEPS = 12 };
    double a[3][3] = {{0}}, v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (size_t n = 0; n < count; n++) {
        struct vec3 r = vec3_sub(points[n].r, middle);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                a[i][j] += component(r, i) * component(r, j);
    }
    for (int step = 0; step < 3 * SWEEPS; step++) {
        int p = step % 3, q = (p + 1) % 3;
        if (a[p][q] == 0)
            continue;
        double cot = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        double t = copysign(1, cot) / (fabs(cot) + sqrt(cot * cot + 1));
        double c = 1 / sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; k++) { /* a J and v J */
            double x = a[k][p], y = a[k][q];
            a[k][p] = c * x - s * y;
            a[k][q] = s * x + c * y;
            x = v[k][p];
            v[k][p] = c * x - s * v[k][q];
            v[k][q] = s * x + c * v[k][q];
        }
        for (int k = 0; k < 3; k++) { /* J^T a */
            double x = a[p][k], y = a[q][k];
            a[p][k] = c * x - s * y;
            a[q][k] = s * x + c * y;
        }
    }
    for (int k = 0; k < 3; k++)
        axes[k] = vec3_make(v[0][k], v[1][k], v[2][k]);
}

static struct vec3 mirror(const struct plane *plane, struct vec3 r) {
    double height = vec3_dot(vec3_sub(r, plane->at), plane->normal);
    return vec3_axpy(-2 * height, plane->normal, r);
}

/* Planes through the middle of the part in which it is its own mirror image, but for a fiftieth of
 * its length: of those across its principal axes and across the axes of its coordinates, which
 * where the moments are equal are the likelier. */
static enum status find_planes(const struct api_study *study, struct plane planes[PLANES_MOST],
                               size_t *found) {
    const struct study_part *part = &study->part;
    struct part_point *points, image;
    struct vec3 middle = {0, 0, 0}, axes[6] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    size_t count;
    *found = 0;
    enum status status =
        even_points(&part->geometry, part->component, TRIED, study->arena, &points, &count);
    if (status != STATUS_OK)
        return status;
    const struct drape_part *g = &part->geometry;
    if (g->mesh)
        middle = g->mesh->components[part->component].centroid;
    else if (g->shell)
        (void)shell_area(g->shell, part->component, &middle);
    else if (g->trim)
        (void)trim_area(g->trim, &middle);
    else
        (void)surface_area(g->surface, &middle);
    principal_axes(points, count, middle, axes + 3);
    for (int k = 0; k < 6 && *found < PLANES_MOST; k++) {
        const struct plane plane = {middle, axes[k]};
        double sum = 0, distance;
        bool known = false;
        for (size_t p = 0; p < *found; p++)
            known = known || fabs(vec3_dot(planes[p].normal, plane.normal)) > 0.99;
        for (size_t n = 0; n < count && !known; n++) {
            study_part_nearest(part, mirror(&plane, points[n].r), &image, &distance);
            sum += distance * distance;
        }
        if (!known && sum <= symmetric * symmetric * part->area * (double)count)
            planes[(*found)++] = plane;
    }
    return STATUS_OK;
}

/* ---- starts and directions ---- */

/* The drape's own, as a small net has them. False where there is none. */
static bool find_own(const struct api_study *study, struct study_variant *own) {
    static const double nodes = 200;
    struct drape_settings settings = study->request.drape.settings;
    struct arena_mark mark = arena_mark(study->arena);
    struct drape_result result = {0};
    double coarseness = fmax(sqrt(study_nodes(study, 1) / nodes), 1);
    for (int k = 0; k < 2; k++)
        settings.spacing[k] *= coarseness;
    bool good =
        drape_solve(&study->part.geometry, &settings, NULL, study->arena, &result) == STATUS_OK;
    if (good) {
        own->start = study_start_of(&result);
        study_note_direction(study, &settings, &result, own);
    }
    arena_rewind(study->arena, mark);
    return good;
}

/* Adds a variant with this angle, unless it is one that there is or that the study does not have.
 */
static void add_variant(struct api_study *study, const struct study_variant *own,
                        double angle_deg) {
    const struct study_request *r = &study->request;
    const struct optimise_space space = optimise_space(study);
    struct study_variant variant = *own;
    bool known = study->obvious_count == OBVIOUS_MOST;
    if (r->angle.count > 0) {
        variant.angle_deg =
            angle_deg - space.turn * floor((angle_deg - r->angle.from) / space.turn + 1e-9);
        known = known || (!(space.period > 0) && variant.angle_deg > r->angle.to);
    }
    for (size_t k = 0; k < study->obvious_count; k++) {
        const struct study_variant *other = &study->obvious[k];
        double turned = r->angle.count > 0 ? variant.angle_deg - other->angle_deg : 0;
        known = known || (vec3_distance(other->start.r, variant.start.r) == 0 &&
                          fabs(turned - space.turn * nearbyint(turned / space.turn)) < 1e-3);
    }
    if (!known)
        study->obvious[study->obvious_count++] = variant;
}

/* Along a plane from a start, and at 45 degrees and across. */
static void add_plane(struct api_study *study, const struct study_variant *from,
                      const struct plane *plane) {
    struct vec3 normal, along;
    if (!study_part_axes(&study->part, &from->start, &normal, &along))
        return;
    struct vec3 way = vec3_cross(plane->normal, normal);
    if (vec3_norm(way) < 0.7) /* the part lies along the plane */
        return;
    double angle = angle_atan2_deg(vec3_dot(way, vec3_cross(normal, along)), vec3_dot(way, along));
    for (int k = 0; k < 3; k++)
        add_variant(study, from, angle + 45 * k);
}

enum status obvious_make(struct api_study *study) {
    const struct study_request *r = &study->request;
    struct study_variant own = {.coarseness = 1};
    struct plane planes[PLANES_MOST];
    size_t count = 0;
    study->obvious = arena_alloc(study->arena, OBVIOUS_MOST, sizeof *study->obvious);
    if (!study->obvious)
        return STATUS_OUT_OF_MEMORY;
    if (r->starts == STUDY_STARTS_POINTS || !find_own(study, &own))
        return STATUS_OK;
    if (r->pre_shear.count > 0)
        own.pre_shear_deg = fmin(fmax(own.pre_shear_deg, r->pre_shear.from), r->pre_shear.to);
    struct arena_mark mark = arena_mark(study->arena);
    enum status status = find_planes(study, planes, &count);
    arena_rewind(study->arena, mark);
    add_variant(study, &own, own.angle_deg);
    for (size_t k = 0; k < count && r->starts == STUDY_STARTS_GRID; k++) {
        struct study_variant from = own;
        struct vec3 image = mirror(&planes[k], own.start.r);
        double distance;
        study_part_nearest(&study->part, vec3_scale(0.5, vec3_add(own.start.r, image)), &from.start,
                           &distance);
        add_plane(study, &from, &planes[k]);
    }
    for (size_t k = 0; k < count; k++)
        add_plane(study, &own, &planes[k]);
    for (int k = 0; k < 4; k++)
        add_variant(study, &own, 45 * k);
    return status;
}
