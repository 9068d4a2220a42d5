/* SPDX-License-Identifier: MIT */
#include "walk.h"

#include "fan.h"

/* An edge's end is met when passed within this share of the edge; a direction that leaves a line by
 * less than this angle runs along it. */
static const double same = 1e-10;

/* How far the mesh's edge may bend away from a straight walk along it, at one vertex and in all in
 * one move; degrees. */
static const double bend_max = 0.6, bends_max = 1.2;

/* What rounding leaves of a coordinate, in shares of `same`. */
static const double rounding = 1e-5;

/* The longest way to a chord, in chords. */
static const double winding_max = 8;

/* Where a walk is to end: `length` on along its way, or before at a distance whose square is
 * `chord2` from `origin`, and for a search as soon as it passes `target`. */
struct goal {
    double length, chord2;
    struct vec3 origin;
    const struct mesh_point *target;
    double near; /* it counts as passed within this distance */
    bool passed;
};

/* A line out of a triangle: the edge it leaves by, the length until then, and at which share of the
 * edge. */
struct way_out {
    int edge;
    double length, share;
};

static const struct way_out no_way = {MESH_NONE, HUGE_VAL, 0};

/* With x the edge, m = n x x points inward; the line r + l e is beyond it where m . (r - v) + l m .
 * e < 0. */
static void try_edge(const struct mesh_walk *walk, int k, struct way_out *best) {
    const struct mesh *mesh = walk->mesh;
    int32_t t = walk->place.triangle;
    struct vec3 v = mesh_corner_point(mesh, t, k);
    struct vec3 x = vec3_sub(mesh_corner_point(mesh, t, (k + 1) % 3), v);
    struct vec3 inward = vec3_cross(mesh->normals[t], x), offset = vec3_sub(walk->place.r, v);
    double rate = -vec3_dot(inward, walk->direction), length2 = vec3_norm2(x);
    if (!(rate > 0 && rate * rate > same * same * length2))
        return;
    double length = fmax(vec3_dot(inward, offset), 0) / rate;
    if (length >= best->length)
        return;
    double share = vec3_dot(vec3_axpy(length, walk->direction, offset), x) / length2;
    *best = (struct way_out){k, length, fmin(fmax(share, 0), 1)};
}

static struct way_out find_way_out(const struct mesh_walk *walk) {
    struct way_out way = no_way;
    for (int k = 0; k < 3; k++)
        if (walk->corner == MESH_NONE ? k != walk->entry : k == (walk->corner + 1) % 3)
            try_edge(walk, k, &way);
    return way;
}

static struct vec3 edge_point(const struct mesh *mesh, int32_t t, int edge, double share) {
    struct vec3 a = mesh_corner_point(mesh, t, edge);
    struct vec3 b = mesh_corner_point(mesh, t, (edge + 1) % 3);
    return share >= 1 ? b : vec3_axpy(share, vec3_sub(b, a), a);
}

static bool is_section(const struct mesh_walk *walk) {
    return vec3_norm2(walk->plane) > 0;
}

/* Through an edge: what the direction has along the edge and across stays. False where the mesh
 * ends. */
static bool cross_edge(struct mesh_walk *walk, int edge) {
    const struct mesh *mesh = walk->mesh;
    int32_t t = walk->place.triangle, twin = mesh->twins[3 * t + edge];
    if (twin == MESH_NONE)
        return false;
    int32_t next = twin / 3;
    struct vec3 x = vec3_unit(
        vec3_sub(mesh_corner_point(mesh, t, (edge + 1) % 3), mesh_corner_point(mesh, t, edge)));
    double along = vec3_dot(walk->direction, x);
    double across = vec3_dot(walk->direction, vec3_cross(x, mesh->normals[t]));
    struct vec3 ahead = vec3_cross(x, mesh->normals[next]);
    walk->direction = is_section(walk) ? vec3_unit(vec3_cross(walk->plane, mesh->normals[next]))
                                       : vec3_unit(vec3_axpy(across, ahead, vec3_scale(along, x)));
    walk->place.triangle = next;
    walk->entry = twin % 3;
    walk->corner = MESH_NONE;
    return true;
}

/* Stands on the fan's vertex and looks along the direction at `angle`. */
static void face(struct mesh_walk *walk, const struct mesh_fan *fan, double angle) {
    mesh_fan_direction(fan, angle, &walk->place.triangle, &walk->corner, &walk->direction);
    walk->entry = MESH_NONE;
}

/* The angle of the way on for a walk that came in to the fan's vertex from the direction `from`;
 * false when it leads off the mesh. */
static bool straight_angle(struct mesh_walk *walk, const struct mesh_fan *fan, double from,
                           double *on) {
    double left = fan->total - from, right = from;
    if (fan->closed) {
        *on = from + fan->total / 2;
        *on -= *on > fan->total ? fan->total : 0;
        return true;
    }
    double missing = fmax(180 - fmax(left, right), 0);
    walk->bent += missing;
    *on = left >= right ? fmin(from + 180, fan->total) : fmax(from - 180, 0);
    return missing <= bend_max && walk->bent <= bends_max;
}

/* The section's way on from a vertex: through the triangle into which its line there points. */
static bool face_section(struct mesh_walk *walk, int corner) {
    const struct mesh *mesh = walk->mesh;
    struct mesh_fan fan = mesh_fan_make(mesh, walk->place.triangle, corner);
    int32_t at = fan.first;
    do {
        struct vec3 p[3], normal = mesh->normals[at / 3];
        struct vec3 e = vec3_unit(vec3_cross(walk->plane, normal));
        mesh_corner_points(mesh, at / 3, p);
        struct vec3 a = vec3_unit(vec3_sub(p[(at + 1) % 3], p[at % 3]));
        struct vec3 b = vec3_unit(vec3_sub(p[(at + 2) % 3], p[at % 3]));
        if (vec3_dot(vec3_cross(a, e), normal) >= -same &&
            vec3_dot(vec3_cross(e, b), normal) >= -same && vec3_dot(e, vec3_add(a, b)) > 0) {
            walk->place.triangle = at / 3;
            walk->corner = at % 3;
            walk->entry = MESH_NONE;
            walk->direction = e;
            return true;
        }
        at = mesh_fan_next(mesh, at);
    } while (at != MESH_NONE && at != fan.first);
    return false;
}

/* Through the vertex at a corner of the triangle it has come to. */
static bool pass_corner(struct mesh_walk *walk, int corner) {
    const struct mesh *mesh = walk->mesh;
    int32_t t = walk->place.triangle;
    if (is_section(walk))
        return face_section(walk, corner);
    struct mesh_fan fan = mesh_fan_make(mesh, t, corner);
    double on, back = mesh_fan_angle(mesh, t, corner, vec3_scale(-1, walk->direction));
    double from = fmin(fmax(fan.before + back, 0), fan.total);
    if (!straight_angle(walk, &fan, from, &on))
        return false;
    face(walk, &fan, on);
    return true;
}

/* Out of the triangle; false where the mesh ends. */
static bool leave(struct mesh_walk *walk, const struct way_out *way) {
    int32_t t = walk->place.triangle;
    walk->place.r = edge_point(walk->mesh, t, way->edge, way->share);
    if (way->share > same && way->share < 1 - same)
        return cross_edge(walk, way->edge);
    int corner = way->share > 0.5 ? (way->edge + 1) % 3 : way->edge;
    walk->place.r = mesh_corner_point(walk->mesh, t, corner);
    return pass_corner(walk, corner);
}

/* The length along the line until the goal: for the chord the positive root of |o + l e|^2 =
 * chord^2, where o is the way from the origin. */
static double length_to_goal(const struct mesh_walk *walk, const struct goal *goal) {
    if (!(goal->chord2 < HUGE_VAL))
        return goal->length;
    struct vec3 o = vec3_sub(walk->place.r, goal->origin);
    double half = vec3_dot(o, walk->direction), rest = fmax(goal->chord2 - vec3_norm2(o), 0);
    double root = sqrt(half * half + rest);
    double length = half > 0 ? rest / (half + root) : root - half;
    return fmin(length, goal->length);
}

/* Whether the walk passes the goal's target within the next `length`. */
static bool passes(const struct mesh_walk *walk, const struct goal *goal, double length) {
    struct vec3 to = vec3_sub(goal->target->r, walk->place.r);
    double along = fmin(fmax(vec3_dot(to, walk->direction), 0), length);
    return walk->place.triangle == goal->target->triangle ||
           vec3_norm(vec3_axpy(-along, walk->direction, to)) <= goal->near;
}

/* So many triangles no walk passes that is not going in circles. */
static size_t steps_max(const struct mesh *mesh) {
    return 10000 + 4 * mesh->triangle_count;
}

/* Ends the walk `length` on in its triangle. */
static void stop(struct mesh_walk *walk, double length) {
    walk->place.r = vec3_axpy(length, walk->direction, walk->place.r);
    if (length > 0)
        walk->corner = walk->entry = MESH_NONE;
}

static enum mesh_walk_end run(struct mesh_walk *walk, struct goal *goal) {
    walk->bent = 0;
    for (size_t step = steps_max(walk->mesh); step > 0; step--) {
        struct way_out way = find_way_out(walk);
        if (way.edge == MESH_NONE)
            return MESH_WALK_LOST;
        double length = length_to_goal(walk, goal);
        goal->passed = goal->target && passes(walk, goal, fmin(length, way.length));
        if (goal->passed)
            return MESH_WALK_DONE;
        if (length <= way.length) {
            bool wound = goal->chord2 < HUGE_VAL && length == goal->length;
            stop(walk, length);
            return wound ? MESH_WALK_LOST : MESH_WALK_DONE;
        }
        goal->length -= way.length;
        if (!leave(walk, &way))
            return MESH_WALK_BOUNDARY;
    }
    return MESH_WALK_LOST;
}

/* The corner of its triangle that a place is on, or MESH_NONE. */
static int corner_at(const struct mesh *mesh, const struct mesh_point *place) {
    struct vec3 p[3];
    mesh_corner_points(mesh, place->triangle, p);
    for (int k = 0; k < 3; k++) {
        double shortest2 = fmin(vec3_norm2(vec3_sub(p[(k + 1) % 3], p[k])),
                                vec3_norm2(vec3_sub(p[(k + 2) % 3], p[k])));
        if (vec3_norm2(vec3_sub(place->r, p[k])) <= same * same * shortest2)
            return k;
    }
    return MESH_NONE;
}

/* Sets off from a vertex. Inside the mesh a full turn of directions is mapped to the whole fan. */
static bool set_off_from_corner(struct mesh_walk *walk, int corner) {
    const struct mesh *mesh = walk->mesh;
    int32_t t = walk->place.triangle;
    struct mesh_fan fan = mesh_fan_make(mesh, t, corner);
    double angle = mesh_fan_angle(mesh, t, corner, walk->direction);
    walk->place.r = mesh_corner_point(mesh, t, corner);
    if (fan.closed) {
        double turned = angle * fan.total / 360;
        face(walk, &fan, turned < 0 ? turned + fan.total : turned);
        return true;
    }
    angle += fan.before;
    if (angle > fan.total + bend_max && angle - 360 >= -bend_max)
        angle -= 360;
    if (angle < -bend_max && angle + 360 <= fan.total + bend_max)
        angle += 360;
    face(walk, &fan, fmin(fmax(angle, 0), fan.total));
    return angle >= -bend_max && angle <= fan.total + bend_max;
}

bool mesh_walk_straight(struct mesh_walk *walk, const struct mesh *mesh,
                        const struct mesh_point *from, struct vec3 direction) {
    *walk =
        (struct mesh_walk){.mesh = mesh, .place = *from, .entry = MESH_NONE, .corner = MESH_NONE};
    walk->direction = mesh_tangent(mesh, from->triangle, direction);
    if (!(vec3_norm2(walk->direction) > 0.5))
        return false;
    int corner = corner_at(mesh, from);
    return corner == MESH_NONE || set_off_from_corner(walk, corner);
}

bool mesh_walk_section(struct mesh_walk *walk, const struct mesh *mesh,
                       const struct mesh_point *from, struct vec3 plane, struct vec3 direction) {
    *walk =
        (struct mesh_walk){.mesh = mesh, .place = *from, .entry = MESH_NONE, .corner = MESH_NONE};
    struct vec3 along = vec3_cross(vec3_unit(plane), mesh->normals[from->triangle]);
    double sign = vec3_dot(along, direction) < 0 ? -1 : 1;
    if (!(vec3_norm(along) > same))
        return false;
    walk->plane = vec3_scale(sign, vec3_unit(plane));
    walk->direction = vec3_scale(sign, vec3_unit(along));
    int corner = corner_at(mesh, from);
    return corner == MESH_NONE || face_section(walk, corner);
}

bool mesh_walk_towards(struct mesh_walk *walk, const struct mesh *mesh,
                       const struct mesh_point *from, struct vec3 target) {
    struct vec3 between = vec3_sub(target, from->r);
    struct vec3 plane = vec3_cross(between, mesh->normals[from->triangle]);
    return vec3_norm2(plane) > 0 && mesh_walk_section(walk, mesh, from, plane, between);
}

enum mesh_walk_end mesh_walk_length(struct mesh_walk *walk, double length) {
    struct goal goal = {.length = length, .chord2 = HUGE_VAL};
    return run(walk, &goal);
}

enum mesh_walk_end mesh_walk_chord(struct mesh_walk *walk, double chord) {
    struct goal goal = {
        .length = winding_max * chord, .chord2 = chord * chord, .origin = walk->place.r};
    return run(walk, &goal);
}

bool mesh_walk_connects(const struct mesh *mesh, const struct mesh_point *from,
                        const struct mesh_point *to, double reach) {
    struct mesh_walk walk;
    struct goal goal = {.length = reach, .chord2 = HUGE_VAL, .target = to};
    if (from->triangle == to->triangle)
        return true;
    goal.near = 10 * same * (reach + rounding * mesh->magnitude);
    return mesh_walk_towards(&walk, mesh, from, to->r) && run(&walk, &goal) == MESH_WALK_DONE &&
           goal.passed;
}
