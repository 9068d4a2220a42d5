/* SPDX-License-Identifier: MIT */
#include "path.h"

#include "ring.h"

/* An edge's end is met when passed within this share of the edge; a direction that leaves a line by
 * less than this angle runs along it. */
static const double same = 1e-10;

/* How far the mesh's edge may bend away from a straight path along it, at one vertex and in all in
 * one move; degrees. */
static const double bend_max = 0.6, bends_max = 1.2;

/* What rounding leaves of a coordinate, in shares of `same`. */
static const double rounding = 1e-5;

/* What is to end this little beyond the edge of the mesh, by its length or chord, ends on it. */
static const double beyond = 1e-9;

/* The longest way to a chord, in chords. */
static const double winding_max = 8;

/* Where a path is to end: `length` on along its way, or before at a distance whose square is
 * `chord2` from `origin`, and for a search as soon as it passes `target`. */
struct goal {
    double length, chord2;
    double slack; /* by so much of the length the mesh may end before */
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

/* Where the line leaves the triangle. With x an edge, m = n x x points inward; the line r + l e is
 * beyond it where m . (r - v) + l m . e < 0. */
static struct way_out find_way_out(const struct mesh_path *path) {
    const struct mesh *mesh = path->mesh;
    int32_t t = path->at.triangle;
    struct way_out way = {MESH_NONE, HUGE_VAL, 0};
    for (int k = 0; k < 3; k++) {
        if (path->corner == MESH_NONE ? k == path->entry : k != (path->corner + 1) % 3)
            continue;
        struct vec3 x = mesh_edge_vector(mesh, 3 * t + k);
        struct vec3 inward = vec3_cross(mesh->normals[t], x);
        struct vec3 offset = vec3_sub(path->at.r, mesh_corner_point(mesh, t, k));
        double rate = -vec3_dot(inward, path->direction), length2 = vec3_norm2(x);
        if (!(rate > 0 && rate * rate > same * same * length2))
            continue;
        double length = fmax(vec3_dot(inward, offset), 0) / rate;
        if (length >= way.length)
            continue;
        double share = vec3_dot(vec3_axpy(length, path->direction, offset), x) / length2;
        way = (struct way_out){k, length, fmin(fmax(share, 0), 1)};
    }
    return way;
}

/* Through an edge: what the direction has along the edge and across stays. False where the mesh
 * ends. */
static bool enter_triangle(struct mesh_path *path, int edge) {
    const struct mesh *mesh = path->mesh;
    int32_t t = path->at.triangle, twin = mesh->twins[3 * t + edge];
    if (twin == MESH_NONE)
        return false;
    int32_t next = twin / 3;
    struct vec3 x = vec3_unit(mesh_edge_vector(mesh, 3 * t + edge));
    double along = vec3_dot(path->direction, x);
    double across = vec3_dot(path->direction, vec3_cross(x, mesh->normals[t]));
    struct vec3 ahead = vec3_cross(x, mesh->normals[next]);
    path->direction = vec3_norm2(path->plane) > 0
                          ? vec3_unit(vec3_cross(path->plane, mesh->normals[next]))
                          : vec3_unit(vec3_axpy(across, ahead, vec3_scale(along, x)));
    path->at.triangle = next;
    path->entry = twin % 3;
    path->corner = MESH_NONE;
    return true;
}

/* Stands on the ring's vertex and looks along the direction at `angle`. */
static void face(struct mesh_path *path, const struct mesh_ring *ring, double angle) {
    mesh_ring_direction(ring, angle, &path->at.triangle, &path->corner, &path->direction);
    path->entry = MESH_NONE;
}

/* The section's way on from a vertex: through the triangle into which its line there points. */
static bool face_section(struct mesh_path *path, int corner) {
    const struct mesh *mesh = path->mesh;
    struct mesh_ring ring = mesh_ring_make(mesh, path->at.triangle, corner);
    int32_t at = ring.first;
    do {
        struct vec3 normal = mesh->normals[at / 3];
        struct vec3 e = vec3_unit(vec3_cross(path->plane, normal));
        struct vec3 a = vec3_unit(mesh_edge_vector(mesh, at));
        struct vec3 b = vec3_scale(-1, vec3_unit(mesh_edge_vector(mesh, mesh_previous_half(at))));
        if (vec3_dot(vec3_cross(a, e), normal) >= -same &&
            vec3_dot(vec3_cross(e, b), normal) >= -same && vec3_dot(e, vec3_add(a, b)) > 0) {
            path->at.triangle = at / 3;
            path->corner = at % 3;
            path->entry = MESH_NONE;
            path->direction = e;
            return true;
        }
        at = mesh_ring_next(mesh, at);
    } while (at != MESH_NONE && at != ring.first);
    return false;
}

/* Through the vertex at a corner of the triangle it has come to, with half of the angle there on
 * either side; at the mesh's edge with 180 degrees on one. False when it leads off the mesh. */
static bool pass_corner(struct mesh_path *path, int corner) {
    const struct mesh *mesh = path->mesh;
    int32_t t = path->at.triangle;
    if (vec3_norm2(path->plane) > 0)
        return face_section(path, corner);
    struct mesh_ring ring = mesh_ring_make(mesh, t, corner);
    double on, back = mesh_ring_angle(mesh, t, corner, vec3_scale(-1, path->direction));
    double from = fmin(fmax(ring.before + back, 0), ring.total);
    if (ring.closed) {
        on = from + ring.total / 2;
        on -= on > ring.total ? ring.total : 0;
    } else {
        double left = ring.total - from, right = from;
        double missing = fmax(180 - fmax(left, right), 0);
        path->bent += missing;
        on = left >= right ? fmin(from + 180, ring.total) : fmax(from - 180, 0);
        if (!(missing <= bend_max && path->bent <= bends_max))
            return false;
    }
    face(path, &ring, on);
    return true;
}

/* On to the goal, through as many triangles as a path passes that is not going in circles. */
static enum mesh_path_end follow_path(struct mesh_path *path, struct goal *goal) {
    path->bent = 0;
    path->sharpest = 1;
    for (size_t step = 10000 + 4 * path->mesh->triangle_count; step > 0; step--) {
        struct way_out way = find_way_out(path);
        if (way.edge == MESH_NONE)
            return MESH_PATH_LOST;
        double length = goal->length;
        if (goal->chord2 < HUGE_VAL) {
            /* the positive root of |o + l e|^2 = chord^2, where o is the way from the origin */
            struct vec3 o = vec3_sub(path->at.r, goal->origin);
            double half = vec3_dot(o, path->direction);
            double rest = fmax(goal->chord2 - vec3_norm2(o), 0), root = sqrt(half * half + rest);
            length = fmin(half > 0 ? rest / (half + root) : root - half, length);
        }
        if (goal->target) {
            struct vec3 to = vec3_sub(goal->target->r, path->at.r);
            double next = fmin(length, way.length);
            double along = fmin(fmax(vec3_dot(to, path->direction), 0), next);
            goal->passed = path->at.triangle == goal->target->triangle ||
                           vec3_norm(vec3_axpy(-along, path->direction, to)) <= goal->near;
        }
        if (goal->passed)
            return MESH_PATH_DONE;
        if (length <= way.length) {
            bool wound = goal->chord2 < HUGE_VAL && length == goal->length;
            path->at.r = vec3_axpy(length, path->direction, path->at.r);
            if (length > 0)
                path->corner = path->entry = MESH_NONE;
            return wound ? MESH_PATH_LOST : MESH_PATH_DONE;
        }
        goal->length -= way.length;
        int32_t half = 3 * path->at.triangle + way.edge;
        int corner = way.share > 0.5 ? (way.edge + 1) % 3 : way.edge;
        bool through_edge = way.share > same && way.share < 1 - same;
        path->at.r = mesh_corner_point(path->mesh, half / 3, through_edge ? way.edge : corner);
        if (through_edge)
            path->at.r = vec3_axpy(way.share, mesh_edge_vector(path->mesh, half), path->at.r);
        if (!(through_edge ? enter_triangle(path, way.edge) : pass_corner(path, corner)))
            return length - way.length <= goal->slack ? MESH_PATH_DONE : MESH_PATH_BOUNDARY;
        const struct vec3 *normals = path->mesh->normals;
        path->sharpest =
            fmin(path->sharpest, vec3_dot(normals[half / 3], normals[path->at.triangle]));
    }
    return MESH_PATH_LOST;
}

/* The corner of its triangle that a point is on, or MESH_NONE. */
static int corner_under(const struct mesh *mesh, const struct mesh_point *at) {
    struct vec3 p[3];
    mesh_corner_points(mesh, at->triangle, p);
    for (int k = 0; k < 3; k++) {
        double shortest2 = fmin(vec3_norm2(vec3_sub(p[(k + 1) % 3], p[k])),
                                vec3_norm2(vec3_sub(p[(k + 2) % 3], p[k])));
        if (vec3_norm2(vec3_sub(at->r, p[k])) <= same * same * shortest2)
            return k;
    }
    return MESH_NONE;
}

bool mesh_path_straight(struct mesh_path *path, const struct mesh *mesh,
                        const struct mesh_point *from, struct vec3 direction) {
    *path = (struct mesh_path){.mesh = mesh, .at = *from, .entry = MESH_NONE, .corner = MESH_NONE};
    path->direction = mesh_tangent(mesh, from->triangle, direction);
    if (!(vec3_norm2(path->direction) > 0.5))
        return false;
    int corner = corner_under(mesh, from);
    if (corner == MESH_NONE)
        return true;
    /* From a vertex: inside the mesh a full turn of directions is mapped to the whole ring. */
    int32_t t = from->triangle;
    struct mesh_ring ring = mesh_ring_make(mesh, t, corner);
    double angle = mesh_ring_angle(mesh, t, corner, path->direction);
    path->at.r = mesh_corner_point(mesh, t, corner);
    if (ring.closed) {
        double turned = angle * ring.total / 360;
        face(path, &ring, turned < 0 ? turned + ring.total : turned);
        return true;
    }
    angle += ring.before;
    if (angle > ring.total + bend_max && angle - 360 >= -bend_max)
        angle -= 360;
    if (angle < -bend_max && angle + 360 <= ring.total + bend_max)
        angle += 360;
    face(path, &ring, fmin(fmax(angle, 0), ring.total));
    return angle >= -bend_max && angle <= ring.total + bend_max;
}

bool mesh_path_section(struct mesh_path *path, const struct mesh *mesh,
                       const struct mesh_point *from, struct vec3 plane, struct vec3 direction) {
    *path = (struct mesh_path){.mesh = mesh, .at = *from, .entry = MESH_NONE, .corner = MESH_NONE};
    struct vec3 along = vec3_cross(vec3_unit(plane), mesh->normals[from->triangle]);
    double sign = vec3_dot(along, direction) < 0 ? -1 : 1;
    if (!(vec3_norm(along) > same))
        return false;
    path->plane = vec3_scale(sign, vec3_unit(plane));
    path->direction = vec3_scale(sign, vec3_unit(along));
    int corner = corner_under(mesh, from);
    return corner == MESH_NONE || face_section(path, corner);
}

bool mesh_path_towards(struct mesh_path *path, const struct mesh *mesh,
                       const struct mesh_point *from, struct vec3 target) {
    struct vec3 between = vec3_sub(target, from->r);
    struct vec3 plane = vec3_cross(between, mesh->normals[from->triangle]);
    return vec3_norm2(plane) > 0 && mesh_path_section(path, mesh, from, plane, between);
}

enum mesh_path_end mesh_path_length(struct mesh_path *path, double length) {
    struct goal goal = {.length = length, .slack = beyond * length, .chord2 = HUGE_VAL};
    return follow_path(path, &goal);
}

enum mesh_path_end mesh_path_chord(struct mesh_path *path, double chord) {
    struct goal goal = {.length = winding_max * chord,
                        .slack = beyond * chord,
                        .chord2 = chord * chord,
                        .origin = path->at.r};
    return follow_path(path, &goal);
}

bool mesh_path_connects(const struct mesh *mesh, const struct mesh_point *from,
                        const struct mesh_point *to, double reach) {
    struct mesh_path path;
    struct goal goal = {.length = reach, .chord2 = HUGE_VAL, .target = to};
    if (from->triangle == to->triangle)
        return true;
    goal.near = 10 * same * (reach + rounding * mesh->magnitude);
    return mesh_path_towards(&path, mesh, from, to->r) &&
           follow_path(&path, &goal) == MESH_PATH_DONE && goal.passed;
}
