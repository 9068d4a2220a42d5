/* SPDX-License-Identifier: MIT */
#include "tessellation.h"
#include "triangulation.h"

#include "solver/surface/boxes.h"
#include "solver/surface/spans.h"
#include <stdlib.h>
#include <string.h>

/* Points of a face are at least this share of `size` away from its lines. */
static const double clear_of_lines = 0.45;

/* Ends of lines whose parameters differ by less than this share of the domain, at one place in
 * space, are one; and what is this near to a seam lies on it. */
static const double one_place = 1e-5;

/* A triangle may be so flat (`tessellation.c`); flatter ones are left out. */
static const double least_height = 1e-12, rounding = 1e-13;

/* Triangles that are left out at the most because they would not fit to the others. */
enum { MISFITS_MOST = 64, SPEEDS = 4 };

/* One face on its way to triangles. */
struct patch {
    const struct surface *surface;
    const struct trim *trim;
    struct arena *arena;
    double low[2], length[2]; /* of the domain, inner */
    double (*uv)[2];
    struct vec3 *r;
    size_t count;
    int32_t (*edges)[2]; /* first those of its lines, then those of seams */
    size_t edge_count;
    struct boxes *boxes; /* round the edges of its lines */
    double clearance;
};

/* All triangles so far. */
struct sheet {
    struct arena *arena;
    struct vec3 *vertices;
    double (*parameters)[2];
    size_t vertex_count, vertex_room;
    int32_t (*triangles)[3];
    int32_t *faces;
    size_t triangle_count, triangle_room;
    size_t most;
};

static int32_t add_patch_point(struct patch *p, const double uv[2], struct vec3 r) {
    memcpy(p->uv[p->count], uv, sizeof *p->uv);
    p->r[p->count] = r;
    return (int32_t)p->count++;
}

static void add_patch_edge(struct patch *p, int32_t a, int32_t b) {
    p->edges[p->edge_count][0] = a;
    p->edges[p->edge_count++][1] = b;
}

/* ---- lines ---- */

/* The lines of the face, which share the points where they end: what its triangles must keep. */
static enum status add_lines(struct patch *p, const struct shell_line *const *lines, size_t count) {
    int32_t *ends = arena_alloc(p->arena, 2 * count, sizeof *ends);
    size_t end_count = 0;
    if (!ends)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        const struct shell_line *line = lines[k];
        int32_t last = -1;
        for (size_t at = 0; at < line->count; at++) {
            bool end = at == 0 || at + 1 == line->count;
            const double *uv = line->uv[at];
            int32_t point = -1;
            for (size_t e = 0; end && e < end_count && point < 0; e++) {
                const double *other = p->uv[ends[e]];
                if (fabs(other[0] - uv[0]) <= one_place * p->length[0] &&
                    fabs(other[1] - uv[1]) <= one_place * p->length[1] &&
                    vec3_distance(p->r[ends[e]], line->r[at]) == 0)
                    point = ends[e];
            }
            if (point < 0)
                point = add_patch_point(p, uv, line->r[at]);
            if (end)
                ends[end_count++] = point;
            if (at > 0 && last != point)
                add_patch_edge(p, last, point);
            last = point;
        }
    }
    struct box *boxes = arena_take(p->arena, p->edge_count, sizeof *boxes);
    for (size_t k = 0; boxes && k < p->edge_count; k++)
        boxes[k] = box_round(p->r[p->edges[k][0]], p->r[p->edges[k][1]], p->clearance);
    return boxes ? boxes_make(boxes, p->edge_count, p->arena, &p->boxes) : STATUS_OUT_OF_MEMORY;
}

/* ---- points ---- */

struct near {
    const struct patch *patch;
    struct vec3 r;
    bool found;
};

static bool is_near_piece(void *context, int32_t number) {
    struct near *near = context;
    const struct patch *p = near->patch;
    struct vec3 a = p->r[p->edges[number][0]];
    struct vec3 way = vec3_sub(p->r[p->edges[number][1]], a), to = vec3_sub(near->r, a);
    double length2 = vec3_norm2(way);
    double share = length2 > 0 ? fmin(fmax(vec3_dot(to, way) / length2, 0), 1) : 0;
    near->found = vec3_norm(vec3_axpy(-share, way, to)) < p->clearance;
    return !near->found;
}

/* Whether inner parameters lie in the face's region. */
static bool patch_contains(const struct patch *p, const double uv[2]) {
    double outer[2];
    for (int k = 0; k < 2; k++)
        if (!(uv[k] >= p->low[k] && uv[k] <= p->low[k] + p->length[k]))
            return false;
    surface_outer(p->surface, uv, outer);
    return !p->trim || trim_contains(p->trim, outer);
}

/* Whether the face lies on both sides of the seam of direction k, at `at` of the other. */
static bool has_seam(const struct patch *p, int k, double at) {
    double inset[2] = {one_place * p->length[0], one_place * p->length[1]};
    double low = p->low[1 - k] + inset[1 - k], high = p->low[1 - k] + p->length[1 - k];
    for (int side = 0; side < 2; side++) {
        double uv[2];
        uv[1 - k] = fmin(fmax(at, low), high - inset[1 - k]);
        uv[k] = side ? p->low[k] + p->length[k] - inset[k] : p->low[k] + inset[k];
        if (!patch_contains(p, uv))
            return false;
    }
    return true;
}

/* The points of the tessellation that lie in the face and clear of its lines; those on a side of
 * the domain on both sides of a seam alike. */
static void add_inner_points(struct patch *p, const struct tessellation_points *points) {
    for (size_t n = 0; n < points->count; n++) {
        const double *uv = points->uv[n];
        struct near near = {.patch = p, .r = points->r[n]};
        struct box box = box_round(near.r, near.r, 0);
        int seam = -1;
        for (int k = 1; k >= 0; k--)
            if (p->surface->axis[k].closed &&
                (uv[k] <= p->low[k] || uv[k] >= p->low[k] + p->length[k]))
                seam = k;
        if (seam >= 0 ? !has_seam(p, seam, uv[1 - seam]) : !patch_contains(p, uv))
            continue;
        boxes_visit(p->boxes, &box, is_near_piece, &near);
        if (!near.found)
            add_patch_point(p, uv, near.r);
    }
}

/* ---- seams of closed directions ---- */

struct on_seam {
    double at;
    int32_t point;
};

static int compare_on_seam(const void *a, const void *b) {
    const struct on_seam *p = a, *q = b;
    if (p->at != q->at)
        return p->at < q->at ? -1 : 1;
    return p->point - q->point;
}

/* The lines along the sides of the domain that are seams, through the points that lie there. */
static enum status add_seams(struct patch *p) {
    for (int n = 0; n < 4; n++) {
        int k = n / 2, side = n % 2;
        double at = side ? p->low[k] + p->length[k] : p->low[k];
        size_t count = 0;
        if (!p->surface->axis[k].closed)
            continue;
        struct on_seam *found = arena_alloc(p->arena, p->count, sizeof *found);
        if (!found)
            return STATUS_OUT_OF_MEMORY;
        for (size_t m = 0; m < p->count; m++)
            if (fabs(p->uv[m][k] - at) <= one_place * p->length[k])
                found[count++] = (struct on_seam){p->uv[m][1 - k], (int32_t)m};
        if (count)
            qsort(found, count, sizeof *found, compare_on_seam);
        for (size_t m = 1; m < count; m++)
            if (has_seam(p, k, (found[m - 1].at + found[m].at) / 2))
                add_patch_edge(p, found[m - 1].point, found[m].point);
    }
    return STATUS_OK;
}

/* ---- triangles ---- */

/* Inner parameters in the unit square, both directions about as long as in space. */
static enum status to_plane(struct patch *p, double (**plane)[2]) {
    double sum[2] = {0, 0}, scale[2];
    struct surface_cursor cursor = {0};
    for (int n = 0; n < SPEEDS * SPEEDS; n++) {
        struct surface_jet jet;
        surface_jet_at(p->surface, &cursor, p->low[0] + p->length[0] * (n % SPEEDS + 0.5) / SPEEDS,
                       p->low[1] + p->length[1] * (n / SPEEDS + 0.5) / SPEEDS, &jet);
        sum[0] += vec3_norm(jet.u) * p->length[0];
        sum[1] += vec3_norm(jet.v) * p->length[1];
    }
    for (int k = 0; k < 2; k++)
        scale[k] = fmax(sum[k] / fmax(sum[0], sum[1]), 1e-3) / p->length[k];
    *plane = arena_take(p->arena, p->count, sizeof **plane);
    for (size_t n = 0; *plane && n < p->count; n++)
        for (int k = 0; k < 2; k++)
            (*plane)[n][k] = fmin(fmax((p->uv[n][k] - p->low[k]) * scale[k], 0), 1);
    return *plane ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* Chooses the regions that are in the face, by the middle of the largest triangle of each. */
static enum status choose_regions(const struct patch *p, const struct triangulation *t,
                                  bool **chosen) {
    double *largest = arena_alloc(p->arena, t->region_count, sizeof *largest);
    *chosen = arena_alloc(p->arena, t->region_count, sizeof **chosen);
    if (!largest || !*chosen)
        return STATUS_OUT_OF_MEMORY;
    for (size_t n = 0; n < t->count; n++) {
        const int32_t *c = t->corners[n];
        double uv[2];
        struct vec3 a = vec3_sub(t->points[c[1]], t->points[c[0]]);
        struct vec3 b = vec3_sub(t->points[c[2]], t->points[c[0]]);
        double area = vec3_cross(a, b).z;
        bool own = c[0] < (int32_t)p->count && c[1] < (int32_t)p->count && c[2] < (int32_t)p->count;
        area = own ? area : HUGE_VAL;
        if (!(area > largest[t->region[n]]))
            continue;
        largest[t->region[n]] = area;
        for (int k = 0; k < 2 && own; k++)
            uv[k] = (p->uv[c[0]][k] + p->uv[c[1]][k] + p->uv[c[2]][k]) / 3;
        (*chosen)[t->region[n]] = own && patch_contains(p, uv);
    }
    return STATUS_OK;
}

/* Adds the points of a face and those chosen triangles that have a height, as far as numbers tell.
 */
static enum status add_triangles(struct sheet *s, const struct patch *p,
                                 const struct triangulation *t, const bool *chosen) {
    size_t base = s->vertex_count, count = s->triangle_count;
    if (base + p->count > s->vertex_room) {
        s->vertex_room = 2 * (base + p->count);
        s->vertices = arena_copy(s->arena, s->vertices, base, s->vertex_room, sizeof *s->vertices);
        s->parameters =
            arena_copy(s->arena, s->parameters, base, s->vertex_room, sizeof *s->parameters);
    }
    if (count + t->count > s->triangle_room) {
        s->triangle_room = 2 * (count + t->count);
        s->triangles =
            arena_copy(s->arena, s->triangles, count, s->triangle_room, sizeof *s->triangles);
        s->faces = arena_copy(s->arena, s->faces, count, s->triangle_room, sizeof *s->faces);
    }
    if (!s->vertices || !s->parameters || !s->triangles || !s->faces)
        return STATUS_OUT_OF_MEMORY;
    for (size_t n = 0; n < p->count; n++) {
        s->vertices[base + n] = p->r[n];
        surface_outer(p->surface, p->uv[n], s->parameters[base + n]);
    }
    s->vertex_count += p->count;
    bool turned = p->surface->side < 0;
    for (size_t n = 0; n < t->count; n++) {
        const int32_t *c = t->corners[n];
        if (!chosen[t->region[n]])
            continue;
        struct vec3 a = vec3_sub(p->r[c[1]], p->r[c[0]]), b = vec3_sub(p->r[c[2]], p->r[c[0]]);
        double longest2 =
            fmax(fmax(vec3_norm2(a), vec3_norm2(b)), vec3_norm2(vec3_sub(p->r[c[2]], p->r[c[1]])));
        double twice = vec3_norm(vec3_cross(a, b));
        if (!(twice > 2 * least_height * longest2 &&
              twice > 2 * rounding * p->surface->magnitude * sqrt(longest2)))
            continue;
        s->faces[s->triangle_count] = p->surface->face;
        int32_t *to = s->triangles[s->triangle_count++];
        for (int k = 0; k < 3; k++)
            to[k] = (int32_t)base + c[turned ? 2 - k : k];
    }
    return s->triangle_count > s->most ? STATUS_TOO_MANY_NODES : STATUS_OK;
}

static enum status add_face_triangles(struct sheet *sheet, const struct shell *shell,
                                      int32_t number, const struct shell_line *const *lines,
                                      size_t line_count, double size, struct arena *scratch) {
    struct patch p = {.surface = shell_surface(shell, number),
                      .trim = shell_trim(shell, number),
                      .arena = scratch,
                      .clearance = clear_of_lines * size};
    struct tessellation_points points;
    struct triangulation *t;
    double(*plane)[2];
    bool *chosen;
    for (int k = 0; k < 2; k++) {
        p.low[k] = surface_axis_lower(&p.surface->axis[k]);
        p.length[k] = surface_axis_upper(&p.surface->axis[k]) - p.low[k];
    }
    enum status status = tessellation_points(p.surface, size, sheet->most, scratch, &points);
    if (status != STATUS_OK)
        return status;
    size_t on_lines = 0;
    for (size_t k = 0; k < line_count; k++)
        on_lines += lines[k]->count;
    size_t most = on_lines + points.count;
    p.uv = arena_take(scratch, most, sizeof *p.uv);
    p.r = arena_take(scratch, most, sizeof *p.r);
    p.edges = arena_take(scratch, on_lines + 4 * most, sizeof *p.edges);
    if (!p.uv || !p.r || !p.edges)
        return STATUS_OUT_OF_MEMORY;
    status = add_lines(&p, lines, line_count);
    if (status == STATUS_OK) {
        add_inner_points(&p, &points);
        status = add_seams(&p);
    }
    if (status == STATUS_OK)
        status = to_plane(&p, &plane);
    if (status == STATUS_OK)
        status = triangulate((const double(*)[2])plane, p.count, (const int32_t(*)[2])p.edges,
                             p.edge_count, scratch, &t);
    if (status == STATUS_OK)
        status = choose_regions(&p, t, &chosen);
    if (status == STATUS_OK)
        status = triangulation_improve(t, p.r, chosen, scratch);
    return status == STATUS_OK ? add_triangles(sheet, &p, t, chosen) : status;
}

/* ---- the whole ---- */

/* The mesh of all triangles, less a few that make an edge of three. */
static enum status make_shell_mesh(struct sheet *sheet, struct arena *arena, struct mesh **mesh) {
    struct mesh_fault fault = {0};
    for (int misfits = 0; misfits < MISFITS_MOST; misfits++) {
        const struct mesh_source source = {.vertices = sheet->vertices,
                                           .vertex_count = sheet->vertex_count,
                                           .triangles = (const int32_t(*)[3])sheet->triangles,
                                           .triangle_count = sheet->triangle_count,
                                           .least_height = least_height,
                                           .parameters = (const double(*)[2])sheet->parameters,
                                           .faces = sheet->faces};
        struct arena_mark mark = arena_mark(arena);
        enum status status = mesh_make(&source, arena, mesh, &fault);
        if (status != STATUS_INVALID)
            return status;
        arena_rewind(arena, mark);
        if (fault.kind < MESH_FAULT_NO_AREA || sheet->triangle_count < 2)
            break;
        size_t last = --sheet->triangle_count;
        memcpy(sheet->triangles[fault.index], sheet->triangles[last], sizeof *sheet->triangles);
        sheet->faces[fault.index] = sheet->faces[last];
    }
    return STATUS_DEGENERATE_SURFACE;
}

enum status mesh_from_shell(const struct shell *shell, int32_t face, double size, size_t most,
                            struct arena *arena, struct mesh **mesh) {
    int32_t component = shell_component(shell, face);
    size_t edges = shell_edge_count(shell), faces = shell_face_count(shell);
    struct arena *apart = arena_child(arena), *scratch = arena_child(arena);
    struct sheet sheet = {.arena = apart, .most = most};
    struct shell_line *lines;
    if (!apart || !scratch)
        return STATUS_OUT_OF_MEMORY;
    /* lines by their faces: those of face k are list[first[k]] .. list[first[k + 1] - 1] */
    size_t *first = arena_alloc(apart, faces + 2, sizeof *first);
    const struct shell_line **list = arena_alloc(apart, edges, sizeof *list);
    enum status status =
        first && list ? shell_lines(shell, component, size, apart, &lines) : STATUS_OUT_OF_MEMORY;
    for (size_t e = 0; status == STATUS_OK && e < edges; e++)
        first[lines[e].face + 2] += lines[e].count > 0;
    for (size_t k = 0; status == STATUS_OK && k < faces; k++)
        first[k + 2] += first[k + 1];
    for (size_t e = 0; status == STATUS_OK && e < edges; e++)
        if (lines[e].count > 0)
            list[first[lines[e].face + 1]++] = &lines[e];
    for (int32_t k = 0; k < (int32_t)faces && status == STATUS_OK; k++) {
        if (shell_component(shell, k) == component && !shell_is_duplicate(shell, k))
            status = add_face_triangles(&sheet, shell, k, list + first[k], first[k + 1] - first[k],
                                        size, scratch);
        arena_rewind(scratch, (struct arena_mark){0});
    }
    if (status == STATUS_OK)
        status = make_shell_mesh(&sheet, arena, mesh);
    arena_rewind(apart, (struct arena_mark){0});
    return status;
}
