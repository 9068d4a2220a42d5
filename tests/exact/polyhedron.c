/* SPDX-License-Identifier: MIT */
#include "polyhedron.h"

#include "tests/check.h"
#include <math.h>
#include <string.h>

static const double same = 1e-9;

/* ---- faces in the plane ---- */

static void local_place(const struct polyhedron_face *face, struct vec3 r, double at[2]) {
    struct vec3 from = vec3_sub(r, face->corner[0]);
    for (int k = 0; k < 2; k++)
        at[k] = vec3_dot(from, face->axis[k]);
}

static void turn(const struct polyhedron_face *face, const double x[2], double to[2]) {
    to[0] = face->c * x[0] - face->s * x[1];
    to[1] = face->s * x[0] + face->c * x[1];
}

void polyhedron_unfold(const struct polyhedron *p, int number, struct vec3 r, double at[2]) {
    const struct polyhedron_face *face = &p->face[number];
    double x[2];
    local_place(face, r, x);
    turn(face, x, at);
    for (int k = 0; k < 2; k++)
        at[k] += face->at[k];
}

void polyhedron_unfold_direction(const struct polyhedron *p, int number, struct vec3 a,
                                 double to[2]) {
    const struct polyhedron_face *face = &p->face[number];
    const double x[2] = {vec3_dot(a, face->axis[0]), vec3_dot(a, face->axis[1])};
    turn(face, x, to);
}

static bool is_cut(const struct polyhedron *p, struct vec3 a, struct vec3 b) {
    for (int k = 0; k < p->cut_count; k++)
        for (int side = 0; side < 2; side++)
            if (vec3_distance(p->path[k][side], a) < same &&
                vec3_distance(p->path[k][!side], b) < same)
                return true;
    return false;
}

/* Lays a face in the plane beside one that is there, if they share an edge that is not cut. */
static void unfold_beside(struct polyhedron *p, int known, int next) {
    struct polyhedron_face *to = &p->face[next];
    const struct polyhedron_face *from = &p->face[known];
    for (int k = 0; k < from->count; k++)
        for (int m = 0; m < to->count; m++) {
            struct vec3 a = from->corner[k], b = from->corner[(k + 1) % from->count];
            if (vec3_distance(to->corner[(m + 1) % to->count], a) > same ||
                vec3_distance(to->corner[m], b) > same || is_cut(p, a, b))
                continue;
            double flat[2][2], own[2][2], at[2];
            polyhedron_unfold(p, known, a, flat[0]);
            polyhedron_unfold(p, known, b, flat[1]);
            local_place(to, a, own[0]);
            local_place(to, b, own[1]);
            double angle = atan2(flat[1][1] - flat[0][1], flat[1][0] - flat[0][0]) -
                           atan2(own[1][1] - own[0][1], own[1][0] - own[0][0]);
            to->c = cos(angle);
            to->s = sin(angle);
            turn(to, own[0], at);
            for (int x = 0; x < 2; x++)
                to->at[x] = flat[0][x] - at[x];
            to->unfolded = true;
        }
}

/* Frames of the faces, their places in the plane, and by how much their angles round each tip are
 * less than a turn. */
static void settle(struct polyhedron *p) {
    for (int n = 0; n < p->count; n++) {
        struct polyhedron_face *f = &p->face[n];
        struct vec3 normal = {0, 0, 0};
        for (int k = 1; k + 1 < f->count; k++)
            normal = vec3_add(normal, vec3_cross(vec3_sub(f->corner[k], f->corner[0]),
                                                 vec3_sub(f->corner[k + 1], f->corner[0])));
        f->axis[0] = vec3_unit(vec3_sub(f->corner[1], f->corner[0]));
        f->axis[1] = vec3_cross(vec3_unit(normal), f->axis[0]);
        f->unfolded = false;
    }
    p->face[0].unfolded = true;
    p->face[0].c = 1;
    p->face[0].s = p->face[0].at[0] = p->face[0].at[1] = 0;
    for (int round = 0; round < p->count; round++)
        for (int known = 0; known < p->count; known++)
            for (int next = 0; next < p->count && p->face[known].unfolded; next++)
                if (!p->face[next].unfolded)
                    unfold_beside(p, known, next);
    for (int cut = 0; cut < p->cut_count; cut++) {
        p->cuts[cut] = (struct drape_cut_line){p->path[cut], 2};
        p->tip_deg[cut] = 360;
        for (int n = 0; n < p->count; n++)
            for (int k = 0; k < p->face[n].count; k++) {
                const struct polyhedron_face *f = &p->face[n];
                struct vec3 tip = f->corner[k], a = f->corner[(k + 1) % f->count];
                struct vec3 b = f->corner[(k + f->count - 1) % f->count];
                if (vec3_distance(tip, p->path[cut][1]) > same)
                    continue;
                a = vec3_sub(a, tip);
                b = vec3_sub(b, tip);
                p->tip_deg[cut] -= atan2(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b)) * 180 / M_PI;
            }
    }
}

/* ---- parts ---- */

static void move(struct polyhedron *p, const struct motion *motion) {
    for (int n = 0; n < p->count; n++)
        for (int k = 0; k < p->face[n].count; k++)
            p->face[n].corner[k] = motion_point(motion, p->face[n].corner[k]);
    for (int n = 0; n < p->cut_count; n++)
        for (int k = 0; k < 2; k++)
            p->path[n][k] = motion_point(motion, p->path[n][k]);
}

static void disorient(struct polyhedron *p, uint64_t *seed) {
    struct vec3 axis = {random_between(seed, -1, 1), random_between(seed, -1, 1),
                        random_between(seed, -1, 1)};
    struct vec3 shift = {random_between(seed, -50, 50), random_between(seed, -50, 50),
                         random_between(seed, -50, 50)};
    struct motion motion =
        motion_similar(1, vec3_unit(axis), random_between(seed, 0, 2 * M_PI), shift);
    move(p, &motion);
    settle(p);
}

/* Corners near a circle, none of them within what the others enclose. */
static void make_corners(struct vec3 *corner, int n, uint64_t *seed) {
    double begin = random_between(seed, 0, 2 * M_PI);
    for (int k = 0; k < n; k++) {
        double angle = begin + (k + random_between(seed, -0.2, 0.2)) * 2 * M_PI / n;
        corner[k] = vec3_make(80 * cos(angle), 80 * sin(angle), 0);
    }
}

void polyhedron_pyramid(struct polyhedron *p, int n, double height, uint64_t *seed) {
    struct vec3 rim[POLYHEDRON_CORNERS];
    struct vec3 apex = {random_between(seed, -15, 15), random_between(seed, -15, 15), height};
    make_corners(rim, n, seed);
    memset(p, 0, sizeof *p);
    p->count = n;
    for (int k = 0; k < n; k++) {
        p->face[k].count = 3;
        p->face[k].corner[0] = rim[k];
        p->face[k].corner[1] = rim[(k + 1) % n];
        p->face[k].corner[2] = apex;
    }
    p->cut_count = 1;
    p->path[0][0] = rim[0];
    p->path[0][1] = apex;
    disorient(p, seed);
}

void polyhedron_prism(struct polyhedron *p, int n, double height, uint64_t *seed) {
    struct vec3 top[POLYHEDRON_CORNERS], down = {0, 0, -height};
    make_corners(top, n, seed);
    memset(p, 0, sizeof *p);
    p->count = n + 1;
    p->cut_count = n;
    p->face[0].count = n;
    memcpy(p->face[0].corner, top, (size_t)n * sizeof *top);
    for (int k = 0; k < n; k++) {
        struct polyhedron_face *wall = &p->face[k + 1];
        wall->count = 4;
        wall->corner[0] = vec3_add(top[k], down);
        wall->corner[1] = vec3_add(top[(k + 1) % n], down);
        wall->corner[2] = top[(k + 1) % n];
        wall->corner[3] = top[k];
        p->path[k][0] = wall->corner[0];
        p->path[k][1] = top[k];
    }
    disorient(p, seed);
}

void polyhedron_change(struct polyhedron *p, double scale, bool mirror) {
    struct motion motion = motion_stretch(mirror ? -scale : scale, scale, scale);
    move(p, &motion);
    for (int n = 0; n < p->count && mirror; n++)
        for (int k = 0; k < p->face[n].count / 2; k++) {
            struct vec3 *a = &p->face[n].corner[k], swap = *a;
            *a = p->face[n].corner[p->face[n].count - 1 - k];
            p->face[n].corner[p->face[n].count - 1 - k] = swap;
        }
    settle(p);
}

/* ---- for the solver ---- */

struct shell *polyhedron_shell(struct polyhedron *p, struct arena *arena) {
    struct shell_patch *patches = arena_alloc(arena, (size_t)p->count, sizeof *patches);
    struct shell_fault fault;
    struct shell *shell = NULL;
    for (int n = 0; n < p->count; n++) {
        struct polyhedron_face *f = &p->face[n];
        double low[2] = {0, 0}, high[2] = {0, 0};
        struct vec3 normal = vec3_cross(f->axis[0], f->axis[1]);
        for (int k = 0; k <= f->count; k++)
            local_place(f, f->corner[k % f->count], f->outline[k]);
        for (int k = 0; k < f->count; k++)
            for (int x = 0; x < 2; x++) {
                low[x] = fmin(low[x], f->outline[k][x] - 5);
                high[x] = fmax(high[x], f->outline[k][x] + 5);
            }
        const double x[2] = {low[0], high[0]}, y[2] = {low[1], high[1]};
        shape_plane(&f->shape, x, y);
        struct motion motion = {.m = {{f->axis[0].x, f->axis[1].x, normal.x},
                                      {f->axis[0].y, f->axis[1].y, normal.y},
                                      {f->axis[0].z, f->axis[1].z, normal.z}},
                                .shift = f->corner[0]};
        shape_move(&f->shape, &motion);
        f->curve = (struct trim_curve){
            .degree = 1, .points = (const double(*)[2])f->outline, .count = (size_t)f->count + 1};
        f->loop = (struct trim_loop){true, &f->curve, 1};
        struct nurbs nurbs = shape_nurbs(&f->shape);
        struct surface *surface;
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        patches[n] = (struct shell_patch){.surface = surface, .loops = &f->loop, .loop_count = 1};
    }
    assert_int_equal(shell_make(patches, (size_t)p->count, 0, arena, &shell, &fault), STATUS_OK);
    return shell;
}

struct vec3 polyhedron_inside(const struct polyhedron *p, int face, uint64_t *seed) {
    const struct polyhedron_face *f = &p->face[face];
    struct vec3 sum = {0, 0, 0};
    double whole = 0;
    for (int k = 0; k < f->count; k++) {
        double weight = random_between(seed, 0.3, 1);
        sum = vec3_axpy(weight, f->corner[k], sum);
        whole += weight;
    }
    return vec3_scale(1 / whole, sum);
}
