/* SPDX-License-Identifier: MIT */
#include "flat_piece.h"

#include "band.h"
#include "plane.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* In spacings: the steps along splits; how far a split goes on where it leaves the cloth, so that
 * it passes the rim, in its last steps, too; how far beside a split the yarns are looked at; and
 * the shortest edge that has a direction. */
static const double step = 0.5, beyond = 1.5, beside = 0.75, least_edge = 1e-6;

/* Shear changes by less, as a sine, within two cells where the part is smooth. */
static const double jump = 0.2;

static const double degrees = 57.295779513082321;

bool split_posts_make(const struct laminate_pieces *pieces, struct arena *arena,
                      struct split_posts *posts) {
    double least = HUGE_VAL;
    size_t total = 0;
    for (size_t k = 0; k < pieces->count; k++)
        for (int x = 0; x < 2; x++)
            least = fmin(least, step * pieces->pieces[k].drape.settings.spacing[x]);
    for (size_t k = 0; k < pieces->split_count; k++)
        for (size_t n = 1; n < pieces->splits[k].count; n++)
            total += 1 + laminate_steps(vec3_distance(pieces->splits[k].path[n - 1],
                                                      pieces->splits[k].path[n]),
                                        least);
    *posts = (struct split_posts){.list = arena_alloc(arena, total, sizeof *posts->list)};
    if (!posts->list)
        return false;
    for (size_t k = 0; k < pieces->split_count; k++) {
        const struct drape_cut_line *split = &pieces->splits[k];
        for (size_t n = 1; n < split->count; n++) {
            struct vec3 way = vec3_sub(split->path[n], split->path[n - 1]);
            size_t steps = laminate_steps(vec3_norm(way), least);
            for (size_t m = 0; m < steps; m++)
                posts->list[posts->count++] = (struct split_post){
                    vec3_axpy((double)m / (double)steps, way, split->path[n - 1]),
                    vec3_norm(way) / (double)steps};
        }
        posts->list[posts->count++].r = split->path[split->count - 1];
    }
    return true;
}

/* ---- splits on the cloth ---- */

struct traced {
    bool there;
    double at[2]; /* lengths along warp and weft */
};

/*
 * Where a place of the part is in a cell, from its distances to the four corners, which are those
 * on the cloth as long as the part between is flat, a fold through the place included. With u along
 * warp and v along weft from corner 0, sides a and b and the sine s of the shear,
 *     d^2(u, v) = u^2 + v^2 + 2 s u v,
 * so that the differences to d_0^2 give A = u + s v, B = v + s u and s. False where that is no
 * place of the cell.
 */
static bool place_by_distances(const struct map_net *net, int32_t cell, struct vec3 r,
                               double pq[2]) {
    enum { SLACK_PERCENT = 30 };
    static const double most_sine = 0.97;
    const struct facets_source *source = &net->facets->source;
    const double *side = net->columns.grid.spacing, a = side[0], b = side[1];
    double d2[4];
    for (int k = 0; k < 4; k++)
        d2[k] = vec3_norm2(vec3_sub(r, source->nodes[source->corners[cell][k]]));
    double A = (d2[0] - d2[1] + a * a) / (2 * a), B = (d2[0] - d2[3] + b * b) / (2 * b);
    double s = (d2[2] - d2[0] - a * a - b * b + 2 * a * A + 2 * b * B) / (2 * a * b);
    if (!(fabs(s) < most_sine))
        return false;
    const double share[2] = {(A - s * B) / (1 - s * s) / a, (B - s * A) / (1 - s * s) / b};
    for (int k = 0; k < 2; k++) {
        if (!(share[k] > -SLACK_PERCENT / 100.0 && share[k] < 1 + SLACK_PERCENT / 100.0))
            return false;
        pq[k] = source->places[cell][k] + share[k];
    }
    return true;
}

static struct traced *trace_posts(const struct map_net *net, const struct split_posts *posts,
                                  struct arena *arena) {
    struct facets_search search = facets_search_begin(net->facets);
    struct traced *traced = arena_alloc(arena, posts->count, sizeof *traced);
    for (size_t k = 0; traced && k < posts->count; k++) {
        struct facets_point at;
        double pq[2];
        facets_nearest(&search, posts->list[k].r, &at);
        if (map_net_is_beyond(net, &at))
            continue;
        if (!place_by_distances(net, at.cell, posts->list[k].r, pq))
            map_net_coordinates(net->facets, &at, pq);
        traced[k].there = true;
        for (int x = 0; x < 2; x++)
            traced[k].at[x] = pq[x] * net->columns.grid.spacing[x];
    }
    return traced;
}

/* Goes on straight from b, to which it came from a: no less than it would to the next post, for
 * which cloth that is much sheared takes many spacings. Before the first post the way is towards b,
 * as it is along the split. */
static bool extend_piece(struct segments *segments, const double a[2], const double b[2],
                         double length, size_t number, bool towards) {
    double x = b[0] - a[0], y = b[1] - a[1], share = fmax(length / hypot(x, y), beyond);
    const double end[2] = {b[0] + share * x, b[1] + share * y};
    return !(hypot(x, y) > 0) ||
           segments_add(segments, towards ? end : b, towards ? b : end, (int32_t)number);
}

/* Adds the splits, each from its first place on the cloth to its last, straight where it leaves the
 * cloth or the cloth has collapsed between, so that it still divides; and a little beyond both. */
static bool add_splits(const struct map_net *net, const struct split_posts *posts,
                       const struct traced *traced, struct segments *segments) {
    double far = beyond * net->spacing;
    bool good = true;
    for (size_t first = 0, end; first < posts->count && good; first = end) {
        size_t before = posts->count; /* the last post on the cloth; and the one before that */
        const double *from = NULL;
        for (end = first; end < posts->count && (end == first || posts->list[end - 1].length > 0);
             end++) {
            if (!traced[end].there)
                continue;
            if (before < posts->count) {
                if (!from)
                    good = good && extend_piece(segments, traced[end].at, traced[before].at, far,
                                                before, true);
                from = traced[before].at;
                good = good && segments_add(segments, from, traced[end].at, (int32_t)(end - 1));
            }
            before = end;
        }
        if (from)
            good = good && extend_piece(segments, from, traced[before].at, far, before - 1, false);
    }
    return good;
}

/* ---- the region ---- */

/* The sine of the shear of the cell at a place; NaN where there is none. */
static double sine_at(const struct map_net *net, const double at[2]) {
    const struct facets_source *source = &net->facets->source;
    const double *d = net->columns.grid.spacing;
    double i = floor(at[0] / d[0]), j = floor(at[1] / d[1]);
    for (size_t c = 0; c < source->cell_count; c++) {
        if (source->places[c][0] != (int32_t)i || source->places[c][1] != (int32_t)j)
            continue;
        const double *row = net->rows + c * net->width;
        const struct vec3 *warp = (const void *)(row + net->warp);
        const struct vec3 *weft = (const void *)(row + net->weft);
        return vec3_dot(*warp, *weft);
    }
    return NAN;
}

/* What the piece is along its splits: the way along one, in cloth that is sheared by s, is
 * (x + s y, c y). The longest of the edges behind a post says where the warp is. */
static void look_at_sides(const struct map_net *net, const struct segment *const *along,
                          struct flat_piece *piece) {
    const struct polygons_point *p = piece->region.points;
    for (size_t k = 0, first = 0; k < piece->region.count; k++) {
        const struct polygons_point *next = &p[p[k].last ? first : k + 1];
        double length = hypot(next->x - p[k].x, next->y - p[k].y);
        const struct segment *split = along[k];
        double x = split->to[0] - split->from[0], y = split->to[1] - split->from[1];
        bool forward = x * (next->x - p[k].x) + y * (next->y - p[k].y) > 0;
        double share = (forward ? 1 : -1) * length / hypot(x, y);
        first = p[k].last ? k + 1 : first;
        piece->numbers[k] = split->number;
        piece->sines[k][0] = piece->sines[k][1] = NAN;
        if (split->number < 0 || length <= least_edge * net->spacing)
            continue;
        x *= share;
        y *= share;
        double left[2] = {-beside * net->spacing * y / length, beside * net->spacing * x / length};
        double middle[2] = {(p[k].x + next->x) / 2, (p[k].y + next->y) / 2};
        double *sines = piece->sines[k];
        for (int out = 0; out < 2; out++)
            sines[out] = sine_at(net, (const double[]){middle[0] + (out ? -left[0] : left[0]),
                                                       middle[1] + (out ? -left[1] : left[1])});
        sines[1] = isnan(sines[1]) ? sines[0] : sines[1];
        /* On the line between, but not where the shear jumps, at a fold. */
        double s = fabs(sines[1] - sines[0]) < jump ? (sines[0] + sines[1]) / 2 : sines[0];
        double c = sqrt(1 - s * s);
        struct split_side *side = &piece->sides[split->number];
        side->length += isnan(s) ? length : hypot(x + s * y, c * y);
        if (!(length > side->longest))
            continue;
        side->there = true;
        side->forward = forward;
        side->warp_deg = degrees * atan2(-c * y, x + s * y);
        side->longest = length;
    }
}

enum api_problem_id flat_piece_make(const struct map_net *net, const struct polygons *cloth,
                                    const struct split_posts *posts, struct arena *arena,
                                    struct flat_piece *piece, struct api_problem *problem) {
    static const double start[2] = {0, 0};
    struct segments segments = {.arena = arena};
    struct traced *traced = trace_posts(net, posts, arena);
    const struct segment **along;
    /* The splits first: of edges on each other their numbers stay. */
    if (!traced || !add_splits(net, posts, traced, &segments) ||
        !segments_add_polygons(&segments, cloth, -1))
        return api_problem_no_memory(problem, "the laminate");
    if (plane_face(&segments, start, &piece->region, &along, problem) != API_OK)
        return problem->id;
    if (piece->region.count == 0)
        return api_problem_set(problem, API_INVALID_REQUEST,
                               "a piece starts beyond its own cloth: give it another start");
    bool bounded = false;
    for (size_t k = 0; k < piece->region.count; k++)
        bounded = bounded || along[k]->number >= 0;
    if (!bounded)
        return api_problem_set(
            problem, API_INVALID_REQUEST,
            "no split bounds a piece on its own cloth, which collapses before it "
            "gets there: give the piece another start or direction");
    piece->numbers = malloc(piece->region.count * sizeof *piece->numbers);
    piece->sides = calloc(posts->count, sizeof *piece->sides);
    piece->sines = malloc(piece->region.count * sizeof *piece->sines);
    if (!piece->numbers || !piece->sides || !piece->sines)
        return api_problem_no_memory(problem, "the laminate");
    look_at_sides(net, along, piece);
    return API_OK;
}

void flat_piece_free(struct flat_piece *piece) {
    polygons_free(&piece->region);
    free(piece->numbers);
    free(piece->sides);
    free(piece->sines);
    *piece = (struct flat_piece){.numbers = NULL};
}

/* ---- seams ---- */

/* The piece on the other side of a split at a post; `count` where there is none. */
static size_t neighbour_at(const struct flat_piece *const *all, size_t count, size_t own,
                           int32_t post) {
    for (size_t k = 0; k < count; k++)
        if (k != own && all[k] && all[k]->sides[post].there)
            return k;
    return count;
}

/* How far the piece goes beyond its split there, or ends before it. */
static double seam_reach(const struct laminate_seam *seam, size_t own, size_t neighbour) {
    if (seam->gap > 0)
        return seam->gap / 2;
    if (seam->over == LAMINATE_OVER_NONE)
        return seam->overlap / 2;
    return (neighbour < own) == (seam->over == LAMINATE_OVER_FIRST) ? seam->overlap : 0;
}

double flat_piece_seam_cosine(const struct flat_piece *const *all, size_t count, size_t own,
                              size_t other, bool outside) {
    const struct flat_piece *piece = all[own];
    const struct polygons_point *p = piece->region.points;
    double part = 0, flat = 0;
    for (size_t k = 0, first = 0; k < piece->region.count; k++) {
        const struct polygons_point *next = &p[p[k].last ? first : k + 1];
        double length = hypot(next->x - p[k].x, next->y - p[k].y), s = piece->sines[k][outside];
        first = p[k].last ? k + 1 : first;
        if (piece->numbers[k] < 0 || isnan(s) ||
            neighbour_at(all, count, own, piece->numbers[k]) != other)
            continue;
        part += length;
        flat += length / sqrt(1 - s * s);
    }
    return flat > 0 ? part / flat : 1;
}

/* A seam changes a piece by no more than its band, and by nothing on its other side. */
static enum api_problem_id check_cut_area(const struct polygons *region,
                                          const struct polygons *shapes, bool outside,
                                          const struct polygons *cut, struct api_problem *problem) {
    static const double slack = 1e-6;
    double own = polygons_area(region), band = polygons_area(shapes);
    double more = (polygons_area(cut) - own) * (outside ? 1 : -1);
    if (more >= -slack * own && more <= band + slack * own)
        return API_OK;
    return api_problem_set(problem, API_INTERNAL,
                           "the seams of a piece of area %.6g change it by %.6g, but lie within "
                           "%.6g: tell us of the request",
                           own, outside ? more : -more, band);
}

enum api_problem_id flat_piece_sew(const struct flat_piece *const *all, size_t count, size_t own,
                                   size_t only, const struct polygons *cloth,
                                   const struct laminate_seam *seam, struct arena *arena,
                                   struct polygons *cut, struct api_problem *problem) {
    const struct polygons *region = &all[own]->region;
    struct polygons shapes = {0}, beyond_split = {0};
    bool outside = seam->gap <= 0;
    struct band_edge *edges = arena_alloc(arena, region->count, sizeof *edges);
    if (!edges)
        return api_problem_no_memory(problem, "the laminate");
    for (size_t k = 0; k < region->count; k++) {
        int32_t post = all[own]->numbers[k];
        size_t neighbour = post < 0 ? count : neighbour_at(all, count, own, post);
        if (post >= 0 && (only >= count || neighbour == only))
            edges[k] =
                (struct band_edge){seam_reach(seam, own, neighbour), all[own]->sines[k][outside]};
    }
    if (!band_make(region, edges, &shapes))
        api_problem_no_memory(problem, "the laminate");
    else if (!outside)
        (void)!plane_combine(region, PLANE_FIRST_ALONE, &shapes, cut, problem);
    else if (plane_combine(&shapes, PLANE_BOTH, cloth, &beyond_split, problem) == API_OK)
        (void)!plane_combine(region, PLANE_EITHER, &beyond_split, cut, problem);
    if (problem->id == API_OK)
        (void)!check_cut_area(region, &shapes, outside, cut, problem);
    polygons_free(&beyond_split);
    polygons_free(&shapes);
    return problem->id;
}
