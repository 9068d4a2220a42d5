/* SPDX-License-Identifier: MIT */
#include "division.h"

#include "solver/mesh/tessellation.h"
#include "solver/net/curtain.h"
#include "solver/shell/shell.h"
#include <string.h>

/* So many triangles of equal sides would cover the part, and so many are allowed. */
enum { TRIANGLES = 20000, TRIANGLES_MOST = 1000000, REFINEMENTS = 12 };

/* Of the length of a triangle's edge: the steps along a split, how high its curtain is, how far
 * beyond its ends it goes on; and the area, of the square of it, below which a region is a sliver
 * between a split and the edge. */
static const double step = 0.25, height = 0.7, beyond = 1.5, sliver = 1;

static const double sixty_degrees = 0.43301270189221935; /* the area of a triangle with sides 1 */

/* ---- the triangles ---- */

/* The same mesh with every triangle cut into four. */
static enum status refine(const struct mesh *coarse, struct arena *arena, struct mesh **fine) {
    size_t halves = 3 * coarse->triangle_count, count = coarse->vertex_count;
    struct vec3 *vertices = arena_take(arena, count + halves, sizeof *vertices);
    int32_t(*corners)[3] = arena_take(arena, 4 * coarse->triangle_count, sizeof *corners);
    int32_t *middle = arena_take(arena, halves, sizeof *middle);
    if (!vertices || !corners || !middle)
        return STATUS_OUT_OF_MEMORY;
    memcpy(vertices, coarse->vertices, count * sizeof *vertices);
    for (size_t h = 0; h < halves; h++) {
        int32_t twin = coarse->twins[h];
        if (twin != MESH_NONE && (size_t)twin < h) {
            middle[h] = middle[twin];
            continue;
        }
        struct vec3 from = mesh_corner_point(coarse, (int32_t)(h / 3), (int)(h % 3));
        middle[h] = (int32_t)count;
        vertices[count++] = vec3_axpy(0.5, mesh_edge_vector(coarse, (int32_t)h), from);
    }
    for (size_t t = 0; t < coarse->triangle_count; t++) {
        const int32_t *c = coarse->corners[t], *m = &middle[3 * t];
        const int32_t own[4][3] = {
            {c[0], m[0], m[2]}, {m[0], c[1], m[1]}, {m[2], m[1], c[2]}, {m[0], m[1], m[2]}};
        memcpy(corners[4 * t], own, sizeof own);
    }
    const struct mesh_source source = {.vertices = vertices,
                                       .vertex_count = count,
                                       .triangles = (const int32_t(*)[3])corners,
                                       .triangle_count = 4 * coarse->triangle_count};
    return mesh_make(&source, arena, fine, NULL);
}

static double longest_edge(const struct mesh *mesh) {
    double longest = 0;
    for (size_t h = 0; h < 3 * mesh->triangle_count; h++)
        longest = fmax(longest, vec3_norm(mesh_edge_vector(mesh, (int32_t)h)));
    return longest;
}

enum api_problem_id division_mesh(const struct drape_part *part, int32_t face, struct arena *arena,
                                  const struct mesh **mesh, double *size,
                                  struct api_problem *problem) {
    struct vec3 middle;
    struct mesh *made = NULL;
    double area = part->surface ? surface_area(part->surface, &middle)
                  : part->shell
                      ? shell_area(part->shell, shell_component(part->shell, face), &middle)
                      : part->mesh->area;
    enum status status = STATUS_OK;
    *size = sqrt(area / (TRIANGLES * sixty_degrees));
    if (part->surface)
        status = mesh_from_surface(part->surface, *size, TRIANGLES_MOST, arena, &made);
    else if (part->shell)
        status = mesh_from_shell(part->shell, face, *size, TRIANGLES_MOST, arena, &made);
    *mesh = part->mesh ? part->mesh : made;
    for (int n = 0; part->mesh && status == STATUS_OK && n < REFINEMENTS; n++) {
        double longest = longest_edge(*mesh);
        if (longest <= 2 * *size || 4 * (*mesh)->triangle_count > TRIANGLES_MOST) {
            *size = fmax(*size, longest);
            break;
        }
        status = refine(*mesh, arena, &made);
        *mesh = made;
    }
    if (status == STATUS_OUT_OF_MEMORY)
        return api_problem_no_memory(problem, "the laminate");
    return status == STATUS_OK
               ? API_OK
               : api_problem_set(problem, API_DEGENERATE_SURFACE,
                                 "the part is too uneven for \"splits\": it cannot be covered with "
                                 "even triangles, through which its regions are found");
}

/* ---- splits ---- */

/* The posts of a split's curtain: on the part in steps, with the mean normal of both sides, and
 * beyond both ends, unless it is closed. False where it is off the part, with the place. */
static bool lay_split(const struct mesh *mesh, double size, double reach,
                      const struct drape_cut_line *split, struct curtain_post *posts, size_t *count,
                      struct vec3 *at) {
    struct mesh_point near;
    double distance;
    size_t first = *count;
    bool closed = laminate_split_closed(split);
    *count += !closed;
    for (size_t k = 1; k < split->count; k++) {
        struct vec3 from = split->path[k - 1], way = vec3_sub(split->path[k], from);
        struct vec3 along = vec3_unit(way), normal;
        size_t steps = laminate_steps(vec3_norm(way), step * size);
        for (size_t n = k > 1; n <= steps; n++) {
            *at = vec3_axpy((double)n / (double)steps, way, from);
            if (!mesh_nearest(mesh, *at, MESH_ANY, &near, &distance) || distance > reach)
                return false;
            struct curtain_post *post = &posts[(*count)++];
            *post = (struct curtain_post){.r = near.r, .height = height * size};
            normal = mesh->normals[near.triangle];
            struct vec3 aside = vec3_scale(0.1 * size, vec3_unit(vec3_cross(normal, along)));
            struct vec3 above = vec3_scale(0.05 * size, normal);
            for (int side = 0; side < 4; side++) { /* of a fold one is next to the other face */
                struct vec3 beside = vec3_axpy(side % 2 ? 1 : -1, aside, post->r);
                beside = vec3_axpy(side / 2 ? 1 : -1, above, beside);
                if (mesh_nearest(mesh, beside, MESH_ANY, &near, NULL))
                    normal = vec3_add(normal, mesh->normals[near.triangle]);
            }
            post->normal = vec3_unit(normal);
        }
    }
    if (closed) {
        posts[*count - 1] = posts[first];
        return true;
    }
    struct curtain_post *begin = &posts[first], *end = &posts[(*count)++];
    *begin = begin[1];
    begin->r = vec3_axpy(beyond * size, vec3_unit(vec3_sub(begin[1].r, begin[2].r)), begin[1].r);
    *end = end[-1];
    end->r = vec3_axpy(beyond * size, vec3_unit(vec3_sub(end[-1].r, end[-2].r)), end[-1].r);
    return true;
}

static size_t most_posts(const struct drape_cut_line *split, double size) {
    size_t count = 4;
    for (size_t k = 1; k < split->count; k++)
        count += 1 + laminate_steps(vec3_distance(split->path[k], split->path[k - 1]), step * size);
    return count;
}

/* ---- regions ---- */

static struct vec3 region_middle(const struct mesh *mesh, int32_t triangle) {
    struct vec3 p[3];
    mesh_corner_points(mesh, triangle, p);
    return vec3_scale(1.0 / 3, vec3_add(p[0], vec3_add(p[1], p[2])));
}

static bool is_cut_away(const struct drape_part *part, const struct mesh *mesh, int32_t triangle) {
    double uv[2];
    const struct mesh_point at = {triangle, region_middle(mesh, triangle)};
    if (!part->surface || !part->trim)
        return false;
    mesh_parameters(mesh, &at, uv);
    return !trim_contains(part->trim, uv);
}

enum { UNSEEN = -2 };

/* Gives a number to all triangles that are reached from one; their area. */
static double flood_region(struct division *d, int32_t from, int32_t number, int32_t *queue,
                           size_t *reached) {
    double area = 0;
    size_t done = 0, count = 0;
    queue[count++] = from;
    d->region[from] = number;
    while (done < count) {
        int32_t t = queue[done++];
        area += mesh_twice_area(d->mesh, t) / 2;
        for (int k = 0; k < 3; k++) {
            int32_t twin = d->mesh->twins[3 * t + k], next = twin / 3;
            if (twin == MESH_NONE || d->region[next] != UNSEEN ||
                curtain_parts(d->curtain, region_middle(d->mesh, t), region_middle(d->mesh, next),
                              NULL))
                continue;
            d->region[next] = number;
            queue[count++] = next;
        }
    }
    *reached = count;
    return area;
}

/* The place of a region nearest to the mean of its area; and its depth, by posts of the splits. */
static void measure_division(const struct division *d, const int32_t *own, size_t count,
                             const struct curtain_post *posts, size_t post_count,
                             struct division_region *region) {
    struct vec3 mean = {0, 0, 0};
    double least = HUGE_VAL;
    for (size_t k = 0; k < count; k++)
        mean = vec3_axpy(mesh_twice_area(d->mesh, own[k]) / (2 * region->area),
                         region_middle(d->mesh, own[k]), mean);
    for (size_t k = 0; k < count; k++) {
        struct vec3 middle = region_middle(d->mesh, own[k]);
        double distance = vec3_distance(middle, mean), depth = HUGE_VAL;
        if (distance < least) {
            least = distance;
            region->middle = middle;
        }
        for (size_t n = 0; n < post_count && depth > region->depth; n++)
            depth = fmin(depth, vec3_distance(posts[n].r, middle));
        region->depth = fmax(region->depth, depth);
    }
    struct mesh_point near;
    size_t number = (size_t)(region - d->regions);
    if (mesh_nearest(d->mesh, mean, MESH_ANY, &near, NULL) &&
        d->region[near.triangle] == (int32_t)number &&
        !curtain_parts(d->curtain, near.r, region_middle(d->mesh, near.triangle), NULL))
        region->middle = near.r;
}

int32_t division_region_at(const struct division *d, struct vec3 r) {
    enum { ROUND = 64 };
    int32_t queue[ROUND];
    struct mesh_point near;
    size_t count = 1;
    if (!mesh_nearest(d->mesh, r, MESH_ANY, &near, NULL))
        return DIVISION_NONE;
    queue[0] = near.triangle;
    for (size_t done = 0; done < count; done++) {
        int32_t t = queue[done];
        if (d->region[t] >= 0 &&
            !curtain_parts(d->curtain, near.r, region_middle(d->mesh, t), NULL))
            return d->region[t];
        for (int k = 0; k < 3 && count < ROUND; k++) {
            int32_t twin = d->mesh->twins[3 * t + k];
            bool seen = twin == MESH_NONE;
            for (size_t n = 0; n < count && !seen; n++)
                seen = queue[n] == twin / 3;
            if (!seen)
                queue[count++] = twin / 3;
        }
    }
    return d->region[near.triangle];
}

/* Whether the same region is on both sides of a split all along. */
static bool divides_nothing(const struct division *d, double size, const struct curtain_post *posts,
                            size_t count) {
    for (size_t k = 1; k < count; k++) {
        struct vec3 along = vec3_unit(vec3_sub(posts[k].r, posts[k - 1].r));
        struct vec3 aside = vec3_scale(size, vec3_cross(posts[k].normal, along));
        int32_t left = division_region_at(d, vec3_add(posts[k].r, aside));
        int32_t right = division_region_at(d, vec3_sub(posts[k].r, aside));
        if (left >= 0 && right >= 0 && left != right)
            return false;
    }
    return true;
}

/* Whether all posts of a split are so near to splits before it that no region lies between. */
static bool lies_on_others(const struct curtain_line *lines, size_t own, double size) {
    bool near = own > 0;
    for (size_t k = 1; k + 1 < lines[own].count && near; k++) {
        near = false;
        for (size_t other = 0; other < own && !near; other++)
            for (size_t n = 0; n < lines[other].count && !near; n++)
                near = vec3_distance(lines[own].posts[k].r, lines[other].posts[n].r) < size;
    }
    return near;
}

bool division_make(const struct drape_part *part, const struct mesh *mesh, double size,
                   double reach, const struct laminate_pieces *pieces, struct arena *arena,
                   struct division *d, enum division_fault *fault) {
    size_t triangles = mesh->triangle_count, most = 0, count = 0, reached;
    *d = (struct division){.mesh = mesh};
    *fault = DIVISION_SOUND;
    for (size_t k = 0; k < pieces->split_count; k++)
        most += most_posts(&pieces->splits[k], size);
    struct curtain_post *posts = arena_take(arena, most, sizeof *posts);
    struct curtain_line *lines = arena_take(arena, pieces->split_count, sizeof *lines);
    int32_t *queue = arena_take(arena, triangles, sizeof *queue);
    d->region = arena_take(arena, triangles, sizeof *d->region);
    if (!posts || !lines || !queue || !d->region)
        return false;
    for (; d->fault < pieces->split_count; d->fault++) {
        size_t first = count;
        *fault = DIVISION_OFF_PART;
        if (!lay_split(mesh, size, reach, &pieces->splits[d->fault], posts, &count, &d->at))
            return true;
        lines[d->fault] = (struct curtain_line){posts + first, count - first};
    }
    *fault = DIVISION_SOUND;
    if (curtain_make(lines, pieces->split_count, arena, &d->curtain) != STATUS_OK)
        return false;
    for (size_t t = 0; t < triangles; t++)
        d->region[t] = is_cut_away(part, mesh, (int32_t)t) ? DIVISION_NONE : UNSEEN;
    d->regions = arena_alloc(arena, LAMINATE_PIECES_MAX + 1, sizeof *d->regions);
    for (size_t t = 0; d->regions && t < triangles && d->count <= LAMINATE_PIECES_MAX; t++) {
        if (d->region[t] != UNSEEN)
            continue;
        struct division_region *own = &d->regions[d->count];
        own->area = flood_region(d, (int32_t)t, (int32_t)d->count, queue, &reached);
        if (own->area > sliver * size * size) {
            measure_division(d, queue, reached, posts, count, own);
            d->count++;
            continue;
        }
        for (size_t k = 0; k < reached; k++)
            d->region[queue[k]] = DIVISION_NONE;
    }
    if (!d->regions)
        return false;
    for (d->fault = 0; d->fault < pieces->split_count; d->fault++) {
        const struct curtain_line *own = &lines[d->fault];
        d->at = pieces->splits[d->fault].path[0];
        *fault = lies_on_others(lines, d->fault, size)              ? DIVISION_REPEATED
                 : divides_nothing(d, size, own->posts, own->count) ? DIVISION_DIVIDES_NOTHING
                                                                    : DIVISION_SOUND;
        if (*fault != DIVISION_SOUND)
            return true;
    }
    return true;
}
