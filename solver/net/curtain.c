/* SPDX-License-Identifier: MIT */
#include "curtain.h"

#include <math.h>

/* The lower end of post k is corner 2 k, the upper one 2 k + 1: between two posts of a line lie the
 * triangles (2 k, 2 k + 2, 2 k + 3) and (2 k, 2 k + 3, 2 k + 1). */
struct curtain {
    struct vec3 *corners;
    struct vec3 *normals;      /* of the posts */
    struct vec3 *faces;        /* normals of both triangles of each strip */
    struct curtain_post *ends; /* of the lines */
    size_t line_count;
    size_t *first;       /* post of each strip: it goes on to the next one */
    struct boxes *boxes; /* round the strips */
    struct box box;      /* round all of them */
};

enum status curtain_make(const struct curtain_line *lines, size_t count, struct arena *arena,
                         struct curtain **made) {
    size_t posts = 0, strips = 0;
    for (size_t n = 0; n < count; n++)
        posts += lines[n].count;
    struct curtain *curtain = arena_alloc(arena, 1, sizeof *curtain);
    struct box *boxes = arena_alloc(arena, posts, sizeof *boxes);
    if (!curtain || !boxes ||
        !(curtain->corners = arena_alloc(arena, 2 * posts, sizeof(struct vec3))) ||
        !(curtain->normals = arena_alloc(arena, posts, sizeof(struct vec3))) ||
        !(curtain->faces = arena_alloc(arena, 2 * posts, sizeof(struct vec3))) ||
        !(curtain->ends = arena_alloc(arena, count, sizeof(struct curtain_post))) ||
        !(curtain->first = arena_alloc(arena, posts, sizeof(size_t))))
        return STATUS_OUT_OF_MEMORY;
    *made = curtain;
    curtain->line_count = count;
    posts = 0;
    for (size_t n = 0; n < count; n++) {
        curtain->ends[n] = lines[n].posts[lines[n].count - 1];
        for (size_t k = 0; k < lines[n].count; k++, posts++) {
            const struct curtain_post *post = &lines[n].posts[k];
            struct vec3 *own = &curtain->corners[2 * posts];
            own[0] = vec3_axpy(-post->height, post->normal, post->r);
            own[1] = vec3_axpy(post->height, post->normal, post->r);
            curtain->normals[posts] = post->normal;
            if (k == 0)
                continue;
            struct box one = box_round(own[-2], own[-1], 0), other = box_round(own[0], own[1], 0);
            boxes[strips] = box_join(&one, &other);
            struct vec3 across = vec3_sub(own[1], own[-2]);
            curtain->faces[2 * strips] = vec3_cross(vec3_sub(own[0], own[-2]), across);
            curtain->faces[2 * strips + 1] = vec3_cross(across, vec3_sub(own[-1], own[-2]));
            curtain->box = strips ? box_join(&curtain->box, &boxes[strips]) : boxes[strips];
            curtain->first[strips++] = posts - 1;
        }
    }
    return boxes_make(boxes, strips, arena, &curtain->boxes);
}

struct box curtain_box(const struct curtain *curtain, double reach) {
    return box_round(vec3_axpy(-reach, vec3_make(1, 1, 1), curtain->box.lower),
                     vec3_axpy(reach, vec3_make(1, 1, 1), curtain->box.upper), 0);
}

struct near {
    const struct curtain *curtain;
    struct vec3 r;
    double reach;
    bool found;
};

/* Whether the place is near a strip, upright between two posts: from the foot on the line between
 * their middles by what remains of the way when its part along the height there is taken out. */
static bool look_at_strip(void *context, int32_t number) {
    struct near *near = context;
    const struct vec3 *corners = near->curtain->corners + 2 * near->curtain->first[number];
    struct vec3 middle[2], up[2];
    for (int k = 0; k < 2; k++) {
        middle[k] = vec3_scale(0.5, vec3_add(corners[2 * k], corners[2 * k + 1]));
        up[k] = vec3_scale(0.5, vec3_sub(corners[2 * k + 1], corners[2 * k]));
    }
    struct vec3 along = vec3_sub(middle[1], middle[0]), from = vec3_sub(near->r, middle[0]);
    double size2 = vec3_norm2(along), share = size2 > 0 ? vec3_dot(from, along) / size2 : 0;
    share = fmin(fmax(share, 0), 1);
    struct vec3 off = vec3_axpy(-share, along, from);
    struct vec3 height = vec3_axpy(share, vec3_sub(up[1], up[0]), up[0]);
    double height2 = vec3_norm2(height), part = height2 > 0 ? vec3_dot(off, height) / height2 : 0;
    off = vec3_axpy(-fmin(fmax(part, -1), 1), height, off);
    near->found = vec3_norm2(off) <= near->reach * near->reach;
    return !near->found;
}

bool curtain_is_near(const struct curtain *curtain, struct vec3 r, double reach) {
    struct box box = box_round(r, r, reach);
    struct near near = {curtain, r, reach, false};
    if (boxes_overlap(&curtain->box, &box) && box_distance2(&curtain->box, r) <= reach * reach)
        boxes_visit(curtain->boxes, &box, look_at_strip, &near);
    return near.found;
}

struct way {
    const struct curtain *curtain;
    struct vec3 from, to;
    bool parted;
    size_t post; /* of the strip that it pierces */
};

static double volume(struct vec3 a, struct vec3 b, struct vec3 c, struct vec3 d) {
    return vec3_dot(vec3_sub(b, a), vec3_cross(vec3_sub(c, a), vec3_sub(d, a)));
}

/* On which side of the line through the way an edge of a triangle passes it: of both triangles that
 * share the edge the opposite. */
static bool passes_edge(const struct way *way, size_t a, size_t b) {
    const struct vec3 *corners = way->curtain->corners;
    size_t low = a < b ? a : b, high = a < b ? b : a;
    return (volume(way->from, way->to, corners[low], corners[high]) >= 0) == (a < b);
}

static bool pierces(const struct way *way, size_t a, size_t b, size_t c, struct vec3 normal) {
    const struct vec3 at = way->curtain->corners[a];
    bool begins = vec3_dot(normal, vec3_sub(way->from, at)) > 0;
    bool ends = vec3_dot(normal, vec3_sub(way->to, at)) > 0;
    if (begins == ends)
        return false;
    bool side = passes_edge(way, a, b);
    return passes_edge(way, b, c) == side && passes_edge(way, c, a) == side;
}

static bool visit_curtain_strip(void *context, int32_t number) {
    struct way *way = context;
    size_t post = way->curtain->first[number], at = 2 * post;
    const struct vec3 *face = &way->curtain->faces[2 * (size_t)number];
    way->parted =
        pierces(way, at, at + 2, at + 3, face[0]) || pierces(way, at, at + 3, at + 1, face[1]);
    way->post = post;
    return !way->parted;
}

const struct curtain_post *curtain_end(const struct curtain *curtain, struct vec3 r) {
    const struct curtain_post *nearest = curtain->ends;
    for (size_t n = 1; n < curtain->line_count; n++)
        if (vec3_norm2(vec3_sub(curtain->ends[n].r, r)) < vec3_norm2(vec3_sub(nearest->r, r)))
            nearest = &curtain->ends[n];
    return nearest;
}

double curtain_end_distance(const struct curtain *curtain, struct vec3 r) {
    return vec3_distance(r, curtain_end(curtain, r)->r);
}

bool curtain_parts(const struct curtain *curtain, struct vec3 from, struct vec3 to,
                   struct vec3 *normal) {
    struct way way = {.curtain = curtain, .from = from, .to = to};
    struct box box = box_round(from, to, 0);
    if (boxes_overlap(&curtain->box, &box))
        boxes_visit(curtain->boxes, &box, visit_curtain_strip, &way);
    if (normal && way.parted)
        *normal = curtain->normals[way.post];
    return way.parted;
}
