/* SPDX-License-Identifier: MIT */
/*
 * Where a search looks next: at variants that a model of all variants so far rates as good, and
 * that are not too near to those already draped. Each quantity has a model (`surrogate.h`) over
 * start, direction and pre-shear. The largest shear has one for each division of the part and is
 * the largest of them: each is smooth, while their largest has edges, and its least lies on one.
 *
 * For each new variant candidates are drawn about one of the good ones so far, and from the best of
 * them steps are taken downwards. Candidates are rated by a weighted sum of their modelled value
 * and of their nearness to known variants, both as shares of the candidates' range, with weights
 * that change from one variant to the next (Regis and Shoemaker, INFORMS J. Computing 19, 2007).
 * Limits are those of the model.
 *
 * Where some variants are draped on a coarser net than others, the net is one more coordinate of
 * the model: what the nets differ by is learned as variants of both come in. All is rated as the
 * drape's own net would have it.
 */
#ifndef API_STUDY_SURROGATE_SEARCH_H
#define API_STUDY_SURROGATE_SEARCH_H

#include "score.h"

enum { SEARCH_AIMS_MOST = 16 };

/* What is to be small: the greatest of factor q + shift over the quantities q whose factor is not
 * 0. */
struct search_aim {
    double factor[QUANTITY_COUNT], shift[QUANTITY_COUNT];
};

/* A search as far as it is. */
struct surrogate_search {
    const struct api_study *study;
    double period;     /* of the warp's angle; 0: it is bounded by the study's range */
    double coarseness; /* of proposals, but of the share `fine`, which have 1 */
    double fine;
    const struct study_row *rows;
    size_t count; /* of rows */
    const struct search_aim *aims;
    size_t aim_count;
    double progress; /* share of the budget that is used */
};

/* The next `wanted` variants, the aims taking turns. Without a row that was draped there are none,
 * `*found` is 0. Errors: STATUS_OUT_OF_MEMORY. */
enum status surrogate_search_next(const struct surrogate_search *search, size_t wanted,
                                  struct arena *arena, struct study_variant *variants,
                                  size_t *found) STATUS_MUST_USE;

#endif
