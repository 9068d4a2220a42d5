/* SPDX-License-Identifier: MIT */
#include "even_points.h"

#include "solver/surface/spans.h"
#include "solver/wide.h"
#include <math.h>

/* Candidates for each point, and at the least; patches of a surface at the least, by which area is
 * shared out; moves of all points. */
enum { CANDIDATES = 20, CANDIDATES_LEAST = 4096, PATCHES_LEAST = 4096, CUTS_MOST = 16, MOVES = 20 };

/* A piece of the part, small enough to be taken for flat: of a face a rectangle of its inner
 * parameters, of a mesh a triangle. */
struct patch {
    int32_t face;
    double low[2], high[2];
    double area;
};

struct patches {
    struct patch *list;
    size_t count;
    double area;
};

/* ---- pieces ---- */

static const struct surface *face_surface(const struct drape_part *part, int32_t face) {
    return part->shell ? shell_surface(part->shell, face) : part->surface;
}

/* The triangles of a mesh, or the spans of the faces, each cut into cuts x cuts. */
static enum status cut_part(const struct drape_part *part, int32_t component, struct arena *arena,
                            struct patches *patches) {
    const struct mesh *mesh = part->mesh;
    if (mesh) {
        patches->list = arena_alloc(arena, mesh->triangle_count, sizeof *patches->list);
        for (int32_t t = 0; patches->list && t < (int32_t)mesh->triangle_count; t++) {
            if (mesh->component[t] != component)
                continue;
            double area = 0.5 * mesh_twice_area(mesh, t);
            patches->list[patches->count++] = (struct patch){.face = t, .area = area};
            patches->area += area;
        }
        return patches->list ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    }
    int32_t count = part->shell ? (int32_t)shell_face_count(part->shell) : 1;
    size_t spans = 0;
    int cuts = 1;
    for (int32_t face = 0; face < count; face++)
        if (!part->shell || shell_component(part->shell, face) == component) {
            const struct surface_axis *axis = face_surface(part, face)->axis;
            spans += (size_t)axis[0].span_count * (size_t)axis[1].span_count;
        }
    while (cuts < CUTS_MOST && spans * (size_t)(cuts * cuts) < PATCHES_LEAST)
        cuts++;
    patches->list = arena_take(arena, spans * (size_t)(cuts * cuts), sizeof *patches->list);
    for (int32_t face = 0; patches->list && face < count; face++) {
        if (part->shell && shell_component(part->shell, face) != component)
            continue;
        const struct surface *surface = face_surface(part, face);
        int across = surface->axis[1].span_count * cuts;
        for (int n = 0; n < surface->axis[0].span_count * cuts * across; n++) {
            const int at[2] = {n / across, n % across};
            struct patch *patch = &patches->list[patches->count++];
            patch->face = face;
            for (int k = 0; k < 2; k++) {
                const double *breaks = &surface->axis[k].breaks[at[k] / cuts];
                double step = (breaks[1] - breaks[0]) / cuts;
                patch->low[k] = breaks[0] + step * (at[k] % cuts);
                patch->high[k] = patch->low[k] + step;
            }
            struct surface_cursor cursor = {0};
            struct surface_jet jet;
            const double *low = patch->low, *high = patch->high;
            surface_jet_at(surface, &cursor, 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]),
                           &jet);
            patch->area =
                vec3_norm(vec3_cross(jet.u, jet.v)) * (high[0] - low[0]) * (high[1] - low[1]);
            patches->area += patch->area;
        }
    }
    return patches->list ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* ---- candidates ---- */

/* The point at the shares (a, b) of a patch; false outside the usable region. */
static bool point_in_patch(const struct drape_part *part, const struct patch *patch, double a,
                           double b, struct part_point *point) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    *point = (struct part_point){.face = patch->face};
    if (part->mesh) {
        struct vec3 p[3];
        bool beyond = a + b > 1;
        double s = beyond ? 1 - a : a, t = beyond ? 1 - b : b;
        mesh_corner_points(part->mesh, patch->face, p);
        point->r = vec3_axpy(s, vec3_sub(p[1], p[0]), vec3_axpy(t, vec3_sub(p[2], p[0]), p[0]));
        point->uv[0] = patch->face;
        return true;
    }
    const struct surface *surface = face_surface(part, patch->face);
    const struct trim *trim = part->shell ? shell_trim(part->shell, patch->face) : part->trim;
    double inner[2] = {patch->low[0] + a * (patch->high[0] - patch->low[0]),
                       patch->low[1] + b * (patch->high[1] - patch->low[1])};
    surface_outer(surface, inner, point->uv);
    surface_jet_at(surface, &cursor, inner[0], inner[1], &jet);
    point->r = jet.r;
    return !trim || trim_contains(trim, point->uv);
}

/* What Martin Roberts' R2 sequence adds each time: 1 / g and 1 / g^2 with g^3 = g + 1. */
static const double r2[2] = {0.7548776662466927, 0.5698402909980532};

/* Candidates: one for each share of the area in order, less those outside the region; of a region
 * that is a small part of its surface as many as of a whole one. */
static enum status make_candidates(const struct drape_part *part, const struct patches *patches,
                                   size_t count, struct arena *arena, struct part_point **list,
                                   size_t *made) {
    enum { TRIES = 4, MORE_MOST = 64 };
    size_t wanted = count * CANDIDATES, more = 1;
    wanted = wanted < CANDIDATES_LEAST ? CANDIDATES_LEAST : wanted;
    for (int try = 0;; try++) {
        struct arena_mark mark = arena_mark(arena);
        size_t all = wanted * more, at = 0;
        double before = 0, share = patches->area / (double)all;
        *made = 0;
        *list = arena_take(arena, all, sizeof **list);
        if (!*list)
            return STATUS_OUT_OF_MEMORY;
        for (size_t k = 0; k < all; k++) {
            while (at + 1 < patches->count &&
                   before + patches->list[at].area < ((double)k + 0.5) * share)
                before += patches->list[at++].area;
            double a = (double)(k + 1) * r2[0], b = (double)(k + 1) * r2[1];
            *made += point_in_patch(part, &patches->list[at], a - (double)(uint64_t)a,
                                    b - (double)(uint64_t)b, &(*list)[*made]);
        }
        if (try == TRIES || 2 * *made >= wanted || more >= MORE_MOST)
            return STATUS_OK;
        arena_rewind(arena, mark);
        more = *made ? 1 + wanted * more / *made : 8 * more;
        more = more > MORE_MOST ? MORE_MOST : more;
    }
}

/* ---- moves ---- */

/* Vectors of this width are plain C, of registers where a machine has them. */
enum { LANES = 4 };
typedef double lanes __attribute__((vector_size(8 * LANES)));
typedef int64_t lanes_mask __attribute__((vector_size(8 * LANES))); /* -1 where true, else 0 */

/* Seeds by cubes of space, hashed into chains; and in rows, LANES at a time. */
struct buckets {
    double side;
    size_t mask;
    int32_t *first, *next; /* of a bucket, of a seed; -1 ends a chain */
    const struct vec3 *seeds;
    size_t count, rows;
    struct seed_row {
        lanes x, y, z; /* behind the last seed infinite */
    } * row;
};

static size_t bucket_at(const struct buckets *b, int64_t x, int64_t y, int64_t z) {
    uint64_t hash = (uint64_t)x * 0x9E3779B97F4A7C15u ^ (uint64_t)y * 0xC2B2AE3D27D4EB4Fu ^
                    (uint64_t)z * 0x165667B19E3779F9u;
    return (size_t)(hash >> 32) & b->mask;
}

static int64_t cube(const struct buckets *b, double x) {
    return (int64_t)floor(x / b->side);
}

/* The nearest of all seeds, of equally near ones the first. */
WIDE_CLONES
static int32_t nearest_of_all(const struct buckets *b, struct vec3 r) {
    lanes least = (lanes){0} + HUGE_VAL;
    lanes_mask row = {0};
    for (size_t k = 0; k < b->rows; k++) {
        lanes x = b->row[k].x - r.x, y = b->row[k].y - r.y, z = b->row[k].z - r.z;
        lanes square = x * x + y * y + z * z;
        lanes_mask nearer = square < least;
        least = (lanes)(((lanes_mask)square & nearer) | ((lanes_mask)least & ~nearer));
        row = ((int64_t)k & nearer) | (row & ~nearer);
    }
    int best = 0;
    for (int l = 1; l < LANES; l++)
        if (least[l] < least[best] || (!(least[l] > least[best]) && row[l] < row[best]))
            best = l;
    return (int32_t)(row[best] * LANES + best);
}

/* So few seeds are looked at faster than 27 cubes. */
enum { FEW = 256 };

/* The work of the moves, by candidate and by seed. */
struct moves {
    const struct part_point *candidates;
    size_t candidate_count, count;
    int32_t *owner;  /* of a candidate: its seed */
    size_t *choice;  /* of a seed: its candidate */
    struct vec3 *at; /* and the point of that */
    struct vec3 *sum;
    double *members, *least;
};

/* Each seed to the middle of those candidates that it is the nearest of. */
static void move_once(struct moves *m, struct buckets *b) {
    /* the seeds, where they are now, into rows and buckets */
    for (size_t k = 0; k < b->rows * LANES; k++) {
        struct seed_row *row = &b->row[k / LANES];
        bool there = k < b->count;
        row->x[k % LANES] = there ? b->seeds[k].x : HUGE_VAL;
        row->y[k % LANES] = there ? b->seeds[k].y : 0;
        row->z[k % LANES] = there ? b->seeds[k].z : 0;
    }
    for (size_t k = 0; k <= b->mask; k++)
        b->first[k] = -1;
    for (size_t k = b->count; k-- > 0;) {
        const struct vec3 *s = &b->seeds[k];
        size_t at = bucket_at(b, cube(b, s->x), cube(b, s->y), cube(b, s->z));
        b->next[k] = b->first[at];
        b->first[at] = (int32_t)k;
    }
    for (size_t s = 0; s < m->count; s++) {
        m->sum[s] = vec3_make(0, 0, 0);
        m->members[s] = 0;
    }
    for (size_t c = 0; c < m->candidate_count; c++) {
        /* the nearest seed: of those in the cubes round it, if one is within one side, else of all
         */
        struct vec3 r = m->candidates[c].r;
        int64_t x = cube(b, r.x), y = cube(b, r.y), z = cube(b, r.z);
        int32_t s = -1;
        double least = 0;
        for (int k = 0; k < 27 && b->count > FEW; k++) {
            size_t at = bucket_at(b, x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1);
            for (int32_t n = b->first[at]; n >= 0; n = b->next[n]) {
                double d2 = vec3_norm2(vec3_sub(b->seeds[n], r));
                if (s < 0 || d2 < least || (!(d2 > least) && n < s)) {
                    s = n;
                    least = d2;
                }
            }
        }
        if (s < 0 || least > b->side * b->side)
            s = nearest_of_all(b, r);
        m->owner[c] = s;
        m->sum[s] = vec3_add(m->sum[s], r);
        m->members[s] += 1;
    }
    for (size_t s = 0; s < m->count; s++)
        if (m->members[s] > 0)
            m->at[s] = vec3_scale(1 / m->members[s], m->sum[s]);
}

static bool prepare_moves(struct moves *m, struct buckets *b, double area, struct arena *arena) {
    size_t buckets = 1;
    while (buckets < 2 * m->count)
        buckets *= 2;
    m->owner = arena_take(arena, m->candidate_count, sizeof *m->owner);
    m->choice = arena_take(arena, m->count, sizeof *m->choice);
    m->at = arena_take(arena, m->count, sizeof *m->at);
    m->sum = arena_take(arena, m->count, sizeof *m->sum);
    m->members = arena_take(arena, m->count, sizeof *m->members);
    m->least = arena_take(arena, m->count, sizeof *m->least);
    *b = (struct buckets){.side = 1.5 * sqrt(area / (double)m->count),
                          .mask = buckets - 1,
                          .first = arena_take(arena, buckets, sizeof *b->first),
                          .next = arena_take(arena, m->count, sizeof *b->next),
                          .seeds = m->at,
                          .count = m->count,
                          .rows = (m->count + LANES - 1) / LANES};
    b->row = arena_take(arena, b->rows, sizeof *b->row);
    if (!b->row || !m->owner || !m->choice || !m->at || !m->sum || !m->members || !m->least ||
        !b->first || !b->next)
        return false;
    for (size_t s = 0; s < m->count; s++) {
        m->choice[s] = (2 * s + 1) * m->candidate_count / (2 * m->count);
        m->at[s] = m->candidates[m->choice[s]].r;
    }
    return true;
}

enum status even_points(const struct drape_part *part, int32_t component, size_t count,
                        struct arena *arena, struct part_point **points, size_t *found) {
    struct patches patches = {0};
    struct part_point *candidates;
    struct moves moves = {.count = 0};
    struct buckets buckets;
    *found = 0;
    *points = arena_take(arena, count, sizeof **points);
    struct arena_mark mark = arena_mark(arena);
    enum status status = cut_part(part, component, arena, &patches);
    if (status == STATUS_OK && *points && patches.area > 0)
        status = make_candidates(part, &patches, count, arena, &candidates, &moves.candidate_count);
    if (status != STATUS_OK || !*points)
        return STATUS_OUT_OF_MEMORY;
    moves.candidates = candidates;
    moves.count = count < moves.candidate_count ? count : moves.candidate_count;
    if (moves.count > 0) {
        if (!prepare_moves(&moves, &buckets, patches.area, arena))
            return STATUS_OUT_OF_MEMORY;
        for (int k = 0; k < MOVES; k++)
            move_once(&moves, &buckets);
        /* to the nearest of its candidates, for the middle of a seed's may lie off the part */
        for (size_t s = 0; s < moves.count; s++)
            moves.least[s] = HUGE_VAL;
        for (size_t c = 0; c < moves.candidate_count; c++) {
            int32_t s = moves.owner[c];
            double d2 = vec3_norm2(vec3_sub(moves.at[s], candidates[c].r));
            if (d2 < moves.least[s]) {
                moves.least[s] = d2;
                moves.choice[s] = c;
            }
        }
    }
    for (size_t s = 0; s < moves.count; s++)
        (*points)[s] = candidates[moves.choice[s]];
    *found = moves.count;
    arena_rewind(arena, mark);
    return STATUS_OK;
}
