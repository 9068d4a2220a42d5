/* SPDX-License-Identifier: MIT */
/* An order that a checker process has under way, and what it does with each kind. */
#ifndef SERVER_WORK_CHECKER_TASK_H
#define SERVER_WORK_CHECKER_TASK_H

#include "checker.h"
#include "frame.h"

enum { CHECKER_WRITE_BYTES = 128 * 1024 };

struct checker_task {
    struct checker_order order;
    char packet[CHECKER_INLINE_MAX]; /* short documents */
    const char *document[CHECKER_DOCUMENTS];
    void *mapped[CHECKER_DOCUMENTS];  /* of those that are files */
    int file[FRAME_FILES_MAX], files; /* received with it */
    int output, form_output;          /* -1: none */
    size_t buffered;
    char buffer[CHECKER_WRITE_BYTES]; /* of what is written */
    struct checker_answer answer;
};

/* The stored surface, NULL without one. */
static inline const char *checker_task_surface(const struct checker_task *task) {
    return task->order.length[CHECKER_SECOND] ? task->document[CHECKER_SECOND] : NULL;
}

/* Does what the order asks and fills the answer. */
void checker_task_carry_out(struct checker_task *task, const struct checker_abilities *abilities);

/* The documents that are made of what is stored: fields on the caller's mesh, the drape of a
 * variant of a study, a report, to the output by themselves; the request of a variant and the
 * patterns of a laminate to a sink. */
void checker_task_document(struct checker_task *task, struct api_problem *problem);
enum api_problem_id checker_task_variant(const struct checker_task *task,
                                         const struct api_sink *sink, struct api_problem *problem);
enum api_problem_id checker_task_patterns(const struct checker_task *task,
                                          const struct api_sink *sink, struct api_problem *problem);

#endif
