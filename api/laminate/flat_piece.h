/* SPDX-License-Identifier: MIT */
/*
 * A piece of a ply on its cloth. Its drape is of the whole part, and its splits are lines on that
 * cloth: the piece is the face between them and the rim in which its start lies, made wider or
 * smaller along the splits as the seam says. All is flat, in lengths along warp and weft from the
 * start; widths of seams are those on the part, by the shear of the cells beside the split.
 */
#ifndef API_LAMINATE_FLAT_PIECE_H
#define API_LAMINATE_FLAT_PIECE_H

#include "api/map/net.h"
#include "api/result/polygons.h"
#include "laminate.h"

/* Places along the splits of a ply, half a spacing apart, the same for all of its pieces: split
 * after split. */
struct split_post {
    struct vec3 r;
    double length; /* to the next one; 0: the last of its split */
};
struct split_posts {
    struct split_post *list;
    size_t count;
};

/* In the arena; false without memory. */
bool split_posts_make(const struct laminate_pieces *pieces, struct arena *arena,
                      struct split_posts *posts);

/* What a piece is at a post whose split bounds it. */
struct split_side {
    bool there;
    bool forward;    /* the piece is to the left, in (p, q), of the way to the next post */
    double warp_deg; /* from the way round the piece, which lies left, to the warp */
    double length;   /* of its boundary up to the next post, on the part */
    double longest;  /* of the edges of that boundary, flat */
};

struct flat_piece {
    struct polygons region; /* of the cloth, in its region */
    int32_t *numbers; /* of each of its points: the post behind which it follows a split; -1 */
    struct split_side *sides; /* of each post */
    double (*sines)[2];       /* of the shear within and beyond each edge along a split, or NaN */
};

/* The piece of a net that is loaded with its warp and weft: `cloth` are the polygons of all of it.
 * `piece` is zero-initialised, and freed in any case. API_INVALID_REQUEST where the start is beyond
 * the cloth. */
enum api_problem_id flat_piece_make(const struct map_net *net, const struct polygons *cloth,
                                    const struct split_posts *posts, struct arena *arena,
                                    struct flat_piece *piece,
                                    struct api_problem *problem) STATUS_MUST_USE;

/* The piece `own` of `count` with its seams, or with that to the piece `only` alone, if it is
 * within `count`: `cut` is zero-initialised, and freed by the caller. */
enum api_problem_id flat_piece_sew(const struct flat_piece *const *all, size_t count, size_t own,
                                   size_t only, const struct polygons *cloth,
                                   const struct laminate_seam *seam, struct arena *arena,
                                   struct polygons *cut,
                                   struct api_problem *problem) STATUS_MUST_USE;

/* Of the cloth of a piece along its seam to another, beyond the split or within it, what a share of
 * the flat area is of that on the part: by length, 1 / mean(1 / cosine of the shear). */
double flat_piece_seam_cosine(const struct flat_piece *const *all, size_t count, size_t own,
                              size_t other, bool outside);

void flat_piece_free(struct flat_piece *piece);

#endif
