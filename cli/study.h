/* SPDX-License-Identifier: MIT */
/* Studies on the command line: progress as a bar, the best variants as a table. */
#ifndef CLI_STUDY_H
#define CLI_STUDY_H

#include "api/study/study.h"
#include <stdio.h>

/* A monitor's: draws the bar on standard error. */
bool study_progress(void *context, double fraction);

/* Prints warnings on standard error, and the best variants of a study's result on `stream`. */
void study_print(const struct api_reader *result, FILE *stream, struct api_problem *problem);

/* Writes the drape request of a variant, by its number or "best". */
bool study_write_variant(const struct api_study *study, const struct api_limits *limits,
                         const struct api_reader *result, const char *variant, FILE *stream,
                         struct api_problem *problem);

#endif
