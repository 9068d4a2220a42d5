/* SPDX-License-Identifier: MIT */
/* A laminate on the command line: its drapes, each in a temporary file. */
#ifndef CLI_LAMINATE_H
#define CLI_LAMINATE_H

#include "api/input.h"
#include "api/laminate/laminate.h"
#include "api/result/columns.h"
#include "files.h"
#include <stdio.h>

struct laminate_job {
    struct laminate laminate;
    struct arena *arena;
    const struct api_reader **nets; /* of each drape; NULL: it failed */
    struct api_problem *problems;   /* of each */
    FILE **containers;
    struct api_reader *readers;
    size_t net; /* being draped */
};

/* Decodes and drapes; shows progress where standard error is a terminal, and says there which
 * plies could not be draped while the rest stands. False with the problem set when nothing could
 * be done. To be closed in any case. */
bool laminate_job_run(struct laminate_job *job, const struct api_input *input,
                      const struct api_limits *limits, struct api_problem *problem);
void laminate_job_close(struct laminate_job *job);

/* Tells on standard error what the pieces of plies cover, how they meet, and what courses take. */
void laminate_job_tell(const struct laminate_job *job);

/* Writes what became of each ply as a JSON document. */
bool laminate_job_report(const struct laminate_job *job, const struct files_output *output,
                         struct api_problem *problem);

#endif
