/* SPDX-License-Identifier: MIT */
#include "seams.h"

#include <math.h>

/*
 * The angle between the warps of two pieces at a post. Each knows it from its own way round, left
 * of which it lies; these ways are opposite, so that the lines differ by the difference of both.
 * Pieces that are seen from different sides have the same way.
 */
static double yarns_angle(const struct split_side *a, const struct split_side *b) {
    double other = a->forward == b->forward ? -b->warp_deg : b->warp_deg;
    return fabs(remainder(a->warp_deg - other, 180));
}

/* Length and angles. */
static void look_along(const struct flat_piece *a, const struct flat_piece *b,
                       const struct split_posts *posts, struct seam *seam) {
    double weight = 0;
    for (size_t k = 0; k < posts->count; k++) {
        double length = (a->sides[k].length + b->sides[k].length) / 2;
        if (!a->sides[k].there || !b->sides[k].there)
            continue;
        seam->length += length;
        double angle = yarns_angle(&a->sides[k], &b->sides[k]);
        if (isnan(angle))
            continue;
        weight += length;
        seam->mean_deg += length * angle;
        seam->greatest_deg = fmax(seam->greatest_deg, angle);
    }
    seam->mean_deg = weight > 0 ? seam->mean_deg / weight : 0;
}

/* What the seam adds to a piece, or takes from it. */
static enum api_problem_id measure_side(const struct laminate_pieces *pieces,
                                        const struct flat_piece *const *all,
                                        const struct flat_ply *own, size_t piece, size_t other,
                                        struct arena *arena, struct seam *seam,
                                        struct api_problem *problem) {
    struct arena_mark mark = arena_mark(arena);
    struct polygons cut = {0};
    if (flat_piece_sew(all, pieces->count, piece, other, &own->cloth, &pieces->seam, arena, &cut,
                       problem) == API_OK) {
        double more = polygons_area(&cut) - own->region_area;
        double cosine = flat_piece_seam_cosine(all, pieces->count, piece, other, more > 0);
        seam->overlap_area += fmax(more, 0);
        seam->gap_area += fmax(-more, 0);
        seam->overlap_width += fmax(more, 0) * cosine / seam->length;
        seam->gap_width += fmax(-more, 0) * cosine / seam->length;
    }
    polygons_free(&cut);
    arena_rewind(arena, mark);
    return problem->id;
}

enum api_problem_id seams_make(const struct laminate *laminate, const struct flat_plies *shapes,
                               size_t first, struct arena *arena, const struct seam **seams,
                               size_t *count, struct api_problem *problem) {
    const struct flat_ply *siblings[LAMINATE_SIBLINGS_MAX];
    const struct flat_piece *all[LAMINATE_PIECES_MAX];
    struct split_posts posts;
    *count = 0;
    const struct laminate_ply *ply = &laminate->plies[shapes->shapes[first].ply];
    const struct laminate_pieces *pieces = ply->pieces;
    if (!laminate_is_split(ply))
        return API_OK;
    (void)flat_plies_siblings(shapes, laminate, first, siblings);
    struct seam *list = arena_alloc(arena, pieces->count * pieces->count, sizeof *list);
    if (!list || !split_posts_make(pieces, arena, &posts))
        return api_problem_no_memory(problem, "the seams");
    for (size_t n = 0; n < pieces->count; n++)
        all[n] = siblings[n] ? siblings[n]->piece : NULL;
    for (size_t a = 0; a < pieces->count; a++)
        for (size_t b = a + 1; b < pieces->count && all[a]; b++) {
            struct seam *seam = &list[*count];
            if (!all[b])
                continue;
            *seam = (struct seam){.piece = {a, b}};
            look_along(all[a], all[b], &posts, seam);
            if (!(seam->length > 0))
                continue;
            ++*count;
            if (measure_side(pieces, all, siblings[a], a, b, arena, seam, problem) != API_OK ||
                measure_side(pieces, all, siblings[b], b, a, arena, seam, problem) != API_OK)
                return problem->id;
        }
    *seams = list;
    return API_OK;
}

void seams_write(const struct laminate_pieces *pieces, const struct seam *seam,
                 struct api_text *text) {
    api_text_raw(text, "{");
    api_text_key(text, "pieces");
    api_text_raw(text, "[");
    api_text_string(text, pieces->pieces[seam->piece[0]].name);
    api_text_raw(text, ",");
    api_text_string(text, pieces->pieces[seam->piece[1]].name);
    api_text_raw(text, "]");
    api_text_key_number(text, "length", seam->length);
    api_text_key_number(text, "mean_angle_deg", seam->mean_deg);
    api_text_key_number(text, "greatest_angle_deg", seam->greatest_deg);
    api_text_key_number(text, "overlap_area", seam->overlap_area);
    api_text_key_number(text, "gap_area", seam->gap_area);
    api_text_key_number(text, "overlap_width", seam->overlap_width);
    api_text_key_number(text, "gap_width", seam->gap_width);
    api_text_raw(text, "}");
}
