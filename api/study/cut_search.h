/* SPDX-License-Identifier: MIT */
/*
 * The search for cuts, `"vary": {"splits": "proposed"}`. It begins with the drape as it is. While a
 * net breaks the limits, the cuts that it asks for (`proposal.h`) are added to those that it had:
 * twice, once with all mouths at the nearest edge and once with them ahead of the ridges, where
 * these differ. Then the ends move: from the best cuts so far each is tried shorter, with its tip
 * and its mouth a step to either side, and once left out; what is better of each of them is tried
 * together; and where nothing was, the step is halved. A variant is better if it misses the limits
 * by less, then if its cuts are shorter.
 */
#ifndef API_STUDY_CUT_SEARCH_H
#define API_STUDY_CUT_SEARCH_H

#include "task.h"

/* Drapes the study's drape to have the edge of the part, `study->edge`: none where it fails.
 * Errors: STATUS_OUT_OF_MEMORY. */
enum status cut_search_prepare(struct api_study *study) STATUS_MUST_USE;

enum api_problem_id cut_search_plan(const struct api_study *study, const struct study_row *rows,
                                    size_t count, struct arena *arena, struct api_study_plan *plan,
                                    struct api_problem *problem) STATUS_MUST_USE;

/* Gives a variant its cuts, those of the study's drape before them. Errors: STATUS_OUT_OF_MEMORY.
 */
enum status cut_search_lay(const struct api_study *study, const struct study_cut *cuts,
                           size_t count, struct arena *arena,
                           struct study_variant *variant) STATUS_MUST_USE;

/* The columns of the table `proposed`, in `arena`: one row for each cut of each variant. How many
 * columns, or SIZE_MAX without memory. */
size_t cut_search_columns(const struct study_row *rows, size_t count, struct arena *arena,
                          struct api_column_source *sources);

/* Lays the cuts of variant k of a stored result; API_INTERNAL where that is damaged. */
enum api_problem_id cut_search_read(const struct api_study *study, const struct api_reader *result,
                                    const struct api_columns *columns, size_t k,
                                    struct arena *arena, struct study_variant *variant,
                                    struct api_problem *problem) STATUS_MUST_USE;

/* Names the cuts of a variant in the request of its drape: those of the search proposed_1, .. */
enum api_problem_id cut_search_name(const struct api_study *study,
                                    const struct study_variant *variant, struct arena *arena,
                                    struct api_request *request,
                                    struct api_problem *problem) STATUS_MUST_USE;

#endif
