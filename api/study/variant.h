/* SPDX-License-Identifier: MIT */
/* One variant of a study: what is draped, and the numbers that come of it. */
#ifndef API_STUDY_VARIANT_H
#define API_STUDY_VARIANT_H

#include "setup.h"

/* What is draped. */
struct study_variant {
    struct part_point start;
    double angle_deg, pre_shear_deg;
    double coarseness;    /* its spacing over the drape's own */
    enum failure failure; /* it is not draped, for this reason; FAILURE_NONE: it is */
    const struct study_cut *cuts;
    size_t cut_count;
    const double *unknowns; /* of its courses, as many as the study has; NULL: it has none */
    const struct drape_cut_line *lines; /* those of the study's drape, then `cuts`; NULL: none of
                                           its own */
};

/* As the numbers of tasks have it. */
struct study_row {
    struct study_variant variant; /* as it was draped */
    int round;
    enum failure failure;
    double quantity[QUANTITY_COUNT];  /* those that are judged; -1: none */
    bool bare;                        /* the cloth ends within the part, where nobody asked it to */
    bool placed;                      /* whether `at` is known */
    struct vec3 at;                   /* where it ends, else of the largest shear */
    double shear_deg, limit_deg;      /* as those of `struct verdict_case`, by the fabric */
    double most[DRAPE_DIVISIONS];     /* the largest shear of each of the study's divisions; 0 of a
                                         failure */
    const struct study_ridge *ridges; /* where cuts are: along which the net asks for more */
    size_t ridge_count;
};

enum { STUDY_ROW_NUMBERS = 18 + QUANTITY_COUNT };
enum { STUDY_CUT_NUMBERS = 2 + 2 * API_STUDY_CUTS * 6 };
/* The numbers of a row; `most` is not among them, and neither are cuts. */
void study_row_store(const struct study_row *row, double numbers[STUDY_ROW_NUMBERS]);

/* The numbers of its cuts, which in a study that proposes cuts are behind those. */
void study_row_store_cuts(const struct study_row *row, double numbers[STUDY_CUT_NUMBERS]);

/* All rows of a study's numbers, in `arena`. API_OUT_OF_MEMORY, API_INTERNAL for other numbers. */
enum api_problem_id study_rows(const struct api_study *study,
                               const struct api_study_numbers *numbers, struct arena *arena,
                               const struct study_row **rows, size_t *count,
                               struct api_problem *problem) STATUS_MUST_USE;

/* The start of a drape that was done. */
static inline struct part_point study_start_of(const struct drape_result *result) {
    return (struct part_point){
        result->start_face, {result->start_uv[0], result->start_uv[1]}, result->start_point};
}

/* Sets the pre-shear of such a drape, and its warp's angle at the variant's start, where that can
 * be measured. */
void study_note_direction(const struct api_study *study, const struct drape_settings *settings,
                          const struct drape_result *result, struct study_variant *variant);

/* Makes `study->k1` where that is judged. Errors: STATUS_OUT_OF_MEMORY. */
enum status study_find_k1(struct api_study *study) STATUS_MUST_USE;

/* The drape of a variant as settings; what the study does not vary stays as in its drape. */
struct drape_settings study_variant_settings(const struct api_study *study,
                                             const struct study_variant *variant);

/* Drapes a variant in `arena`, which is then as before, and fills the row but for its round.
 * Returns STATUS_CANCELLED when the monitor (may be NULL) said so, else STATUS_OK: a drape that
 * cannot be done is a row with a failure. `ridges` holds those of its net, where the study
 * proposes cuts. */
enum status study_variant_drape(const struct api_study *study, const struct study_variant *variant,
                                const struct drape_monitor *monitor, struct arena *arena,
                                struct study_ridge ridges[API_STUDY_CUTS],
                                struct study_row *row) STATUS_MUST_USE;

#endif
