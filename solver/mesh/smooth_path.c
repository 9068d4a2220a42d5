/* SPDX-License-Identifier: MIT */
#include "smooth_path.h"

/* Steps of a move at the most, folds in one, rounds of a chord, halvings that find a fold. */
enum { STEPS_MAX = 5000, FOLDS_MAX = 200, CHORD_ROUNDS = 12, HALVINGS = 45 };

/* A step is at most this share of the move, and of a triangle's side. */
static const double move_share = 0.25, side_share = 0.6;

/* The path turns by no more than this in a step, and by no more more or less than that at its end
 * than at its beginning: a nose may begin within it. Steps are not halved below a share of the
 * move.
 */
static const double turn_most = 0.5, turn_change = 0.1, least_share = 1e-4;

/* Relative accuracy of a chord wanted, and still taken. */
static const double chord_wanted = 1e-12, chord_taken = 1e-8;

/* x' and x'' at a point with the direction t there. */
struct rate {
    struct vec3 first, second;
};

static struct vec3 across(struct vec3 t, struct vec3 n) {
    return vec3_unit(vec3_axpy(-vec3_dot(t, n), n, t));
}

static struct rate path_rate(const struct mesh_smooth_path *path, struct mesh_point at,
                             struct vec3 t) {
    struct mesh_jet jet;
    (void)mesh_smooth_follow(path->smooth, &at, false, 0);
    mesh_smooth_jet(path->smooth, &at, &jet);
    struct vec3 n = vec3_unit(jet.gradient);
    if (vec3_norm2(path->plane) > 0)
        return (struct rate){vec3_unit(vec3_cross(path->plane, n)), {0, 0, 0}};
    return (struct rate){t, vec3_scale(mesh_jet_form(&jet, t, t), n)};
}

static struct rate path_rate_ahead(const struct mesh_smooth_path *path, double h,
                                   const struct rate *by) {
    struct mesh_point at = {path->at.triangle, vec3_axpy(h, by->first, path->at.r)};
    return path_rate(path, at, vec3_axpy(h, by->second, path->direction));
}

static struct vec3 mean(double h, struct vec3 a, struct vec3 b, struct vec3 c, struct vec3 d) {
    return vec3_scale(h / 6, vec3_add(vec3_add(a, d), vec3_scale(2, vec3_add(b, c))));
}

/* Moves on by h on this side of folds; the half-edge that stops it, or MESH_NONE. `turn` becomes
 * the angle by which the path turns with the curvature at its beginning, and by how much more or
 * less it would with that at its end. */
static int32_t step_on(struct mesh_smooth_path *path, double h, double turn[2]) {
    struct rate a = path_rate(path, path->at, path->direction);
    struct rate b = path_rate_ahead(path, h / 2, &a), c = path_rate_ahead(path, h / 2, &b);
    struct rate d = path_rate_ahead(path, h, &c);
    turn[0] = h * vec3_norm(a.second);
    turn[1] = h * vec3_norm(vec3_sub(d.second, a.second));
    path->at.r = vec3_add(path->at.r, mean(h, a.first, b.first, c.first, d.first));
    path->direction = vec3_add(path->direction, mean(h, a.second, b.second, c.second, d.second));
    int32_t stop = mesh_smooth_follow(path->smooth, &path->at, false, 0);
    struct mesh_jet jet;
    mesh_smooth_project(path->smooth, &path->at);
    mesh_smooth_jet(path->smooth, &path->at, &jet);
    path->direction = across(path->direction, vec3_unit(jet.gradient));
    return stop;
}

/* Up to the fold that a step of h goes beyond, and over it; how far that was. */
static double step_over(struct mesh_smooth_path *path, double h) {
    double low = 0, high = h;
    int32_t edge = MESH_NONE;
    struct mesh_smooth_path before = *path;
    for (int k = 0; k < HALVINGS; k++) {
        struct mesh_smooth_path try = before;
        double middle = (low + high) / 2, turn[2];
        int32_t stop = step_on(&try, middle, turn);
        *(stop == MESH_NONE ? &low : &high) = middle;
        if (stop != MESH_NONE) {
            edge = stop;
            *path = try;
        }
    }
    if (edge == MESH_NONE)
        return high;
    /* from the point on the fold to its other side */
    const struct mesh *mesh = path->smooth->mesh;
    struct vec3 along = mesh_edge_vector(mesh, edge);
    struct vec3 n = mesh_smooth_normal(path->smooth, &path->at), x = across(along, n);
    double a = vec3_dot(path->direction, x), b = vec3_dot(path->direction, vec3_cross(x, n));
    path->at.triangle = mesh->twins[edge] / 3;
    mesh_smooth_project(path->smooth, &path->at);
    n = mesh_smooth_normal(path->smooth, &path->at);
    x = across(along, n);
    path->direction = vec3_unit(vec3_axpy(b, vec3_cross(x, n), vec3_scale(a, x)));
    return high;
}

bool mesh_smooth_path(struct mesh_smooth_path *path, const struct mesh_smooth *smooth,
                      const struct mesh_point *from, struct vec3 direction, struct vec3 plane) {
    struct vec3 n = mesh_smooth_normal(smooth, from), along = vec3_cross(vec3_unit(plane), n);
    bool section = vec3_norm2(plane) > 0, back = vec3_dot(along, direction) < 0;
    *path = (struct mesh_smooth_path){.smooth = smooth, .at = *from};
    if (section)
        path->plane = vec3_scale(back ? -1 : 1, vec3_unit(plane));
    path->direction = across(section ? vec3_cross(path->plane, n) : direction, n);
    return vec3_norm2(path->direction) > 0.5;
}

enum mesh_path_end mesh_smooth_length(struct mesh_smooth_path *path, double length) {
    const struct mesh *mesh = path->smooth->mesh;
    double left = length;
    for (int step = 0, folds = 0; step < STEPS_MAX && folds < FOLDS_MAX; step++) {
        double side = sqrt(mesh_twice_area(mesh, path->at.triangle));
        double h = fmin(move_share * length, side_share * side);
        struct mesh_smooth_path ahead;
        int32_t stop;
        for (;; h /= 2) { /* until the path turns evenly */
            double turn[2];
            ahead = *path;
            stop = step_on(&ahead, fmin(h, left), turn);
            if (stop != MESH_NONE || h < least_share * length ||
                (turn[0] < turn_most && turn[1] < turn_change))
                break;
        }
        bool last = left <= h;
        if (stop == MESH_NONE) {
            *path = ahead;
            left -= h;
        } else if (mesh->twins[stop] == MESH_NONE) {
            return MESH_PATH_BOUNDARY;
        } else {
            left -= step_over(path, last ? left : h);
            last = false;
            folds++;
        }
        if (!mesh_smooth_is_sound(path->smooth, &path->at))
            return MESH_PATH_LOST;
        if (last)
            return MESH_PATH_DONE;
    }
    return MESH_PATH_LOST;
}

enum mesh_path_end mesh_smooth_chord(struct mesh_smooth_path *path, double chord) {
    double length = chord;
    for (int round = 0; round < CHORD_ROUNDS; round++) {
        struct mesh_smooth_path ahead = *path;
        enum mesh_path_end end = mesh_smooth_length(&ahead, length);
        if (end != MESH_PATH_DONE)
            return end;
        struct vec3 way = vec3_sub(ahead.at.r, path->at.r);
        double size = vec3_norm(way), rate = vec3_dot(way, ahead.direction) / size;
        double error = fabs(size - chord);
        if (error <= chord_wanted * chord ||
            (round == CHORD_ROUNDS - 1 && error <= chord_taken * chord)) {
            *path = ahead;
            return MESH_PATH_DONE;
        }
        length += (chord - size) / fmax(rate, 0.3);
        if (!(length > 0 && length < 8 * chord))
            return MESH_PATH_LOST;
    }
    return MESH_PATH_LOST;
}
