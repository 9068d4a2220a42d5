/* SPDX-License-Identifier: MIT */
/*
 * Uncertainty: variants drawn at random about the drape as it was meant, the nominal one. Of each
 * cell field it gives the mean and the 5 % and 95 % quantiles of the samples at the middles of the
 * nominal cells, where a sample has the fields of the nearest point of its cloth, as a map has them
 * (`api/map/map.h`).
 *
 * Sample k is drawn from the seed and k alone. Starts are spread evenly over the disc in the
 * tangent plane and moved onto the part; an angle is the nominal one plus a normal deviate, the sum
 * of twelve uniform ones (so it ends at six deviations).
 */
#ifndef API_STUDY_SAMPLE_H
#define API_STUDY_SAMPLE_H

#include "task.h"

/* The drape as it was meant. */
struct sample_nominal {
    struct study_variant variant;
    struct vec3 axis[2];  /* of the tangent plane at the start */
    size_t count;         /* of cells */
    int32_t (*places)[2]; /* their i and j */
    struct vec3 *middles;
    size_t field_count; /* columns of cells but i and j */
    char (*names)[API_COLUMN_NAME_SIZE];
};

/* Drapes it. Problems as of its drape, and API_TOO_LARGE where the numbers of all samples are more
 * than `limits->max_memory`. */
enum api_problem_id sample_prepare(struct api_study *study, const struct api_limits *limits,
                                   struct api_problem *problem) STATUS_MUST_USE;

enum api_problem_id sample_plan(const struct api_study *study, size_t count, struct arena *arena,
                                struct api_study_plan *plan,
                                struct api_problem *problem) STATUS_MUST_USE;

/* Sample k. */
struct study_variant sample_variant(const struct api_study *study, size_t k);

/* Sends the fields of a sample, whose row was sent, at the nominal places, field by field; zeros
 * where it fails. API_OUT_OF_MEMORY, API_CANCELLED, and problems as of a map. */
enum api_problem_id sample_send_fields(const struct task_run *run, const struct study_row *row,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* The columns of the table `bands` from the numbers of all tasks, in `arena`: i, j, x, y, z, and of
 * each field NAME_mean, NAME_p05 and NAME_p95. How many, or SIZE_MAX without memory. */
size_t sample_bands(const struct api_study *study, const struct api_study_numbers *numbers,
                    const struct study_row *rows, size_t count, struct arena *arena,
                    struct api_column_source *sources);

#endif
