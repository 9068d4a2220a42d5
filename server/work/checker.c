/* SPDX-License-Identifier: MIT */
#include "checker.h"

#include "api/request/material.h"
#include "api/run.h"
#include "checker_task.h"
#include "frame.h"
#include "sandbox.h"
#include "worker.h"
#include <malloc.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* Kept between orders: most need no new memory from the system. */
enum { KEPT_BYTES = 4 * 1024 * 1024 };

_Static_assert((int)CHECKER_FILES <= (int)FRAME_FILES_MAX, "all files fit in a frame");
_Static_assert(sizeof(struct checker_answer) <= FRAME_MAX_BYTES, "an answer fits in a frame");

/* Receives the next order with its documents: short ones behind it, the others as files. */
static enum frame_state receive_order(struct checker_task *task) {
    static char empty[1];
    size_t inlined = 0;
    int file = 0;
    enum frame_state state = frame_expect(WORKER_FD, FRAME_ORDER, &task->order, sizeof task->order,
                                          task->file, &task->files);
    for (int k = 0; k < CHECKER_DOCUMENTS && state == FRAME_READY; k++) {
        size_t length = task->order.length[k];
        if (!(task->order.files & 1u << k)) {
            if (length > sizeof task->packet - inlined)
                return FRAME_BROKEN;
            task->document[k] = task->packet + inlined;
            inlined += length;
            continue;
        }
        task->document[k] = empty;
        if (file == task->files)
            return FRAME_BROKEN;
        void *bytes = NULL;
        if (length)
            bytes = mmap(NULL, length, PROT_READ, MAP_PRIVATE, task->file[file], 0);
        file++;
        if (bytes == MAP_FAILED)
            return FRAME_BROKEN;
        if (bytes)
            task->document[k] = task->mapped[k] = bytes;
    }
    if (state != FRAME_READY)
        return state;
    task->output = task->form_output = -1;
    if (task->order.files & 1u << CHECKER_OUTPUT && file < task->files)
        task->output = task->file[file++];
    if (task->order.files & 1u << CHECKER_FORM_OUTPUT && file < task->files)
        task->form_output = task->file[file++];
    return file == task->files && frame_receive(WORKER_FD, task->packet, inlined) ? FRAME_READY
                                                                                  : FRAME_BROKEN;
}

/* ------------------------------------------------------------------ the process */

int checker_serve(const struct checker_abilities *abilities) {
    static struct checker_task task;
    enum frame_state state;
    unsigned long long pages = 0; /* of address space; 0 when that cannot be read */
    FILE *file = fopen("/proc/self/statm", "re");
    if (file && fscanf(file, "%llu", &pages) != 1)
        pages = 0;
    if (file)
        fclose(file);
    const struct checker_hello hello = {pages * (uint64_t)sysconf(_SC_PAGESIZE)};
    if (!hello.address_space || !api_prepare() ||
        !sandbox_begin(WORKER_FD, FRAME_FILES_MAX, KEPT_BYTES) ||
        !frame_send(WORKER_FD, FRAME_HELLO, &hello, sizeof hello))
        return 1;
    while ((state = receive_order(&task)) == FRAME_READY) {
        const struct api_problem *problem = &task.answer.problem;
        uint64_t used = 0;
        memset(&task.answer, 0, offsetof(struct checker_answer, problem.error));
        task.buffered = 0;
        if (abilities->before)
            abilities->before(task.document[CHECKER_BODY], task.order.length[CHECKER_BODY]);
        checker_task_carry_out(&task, abilities);
        for (int k = 0; k < CHECKER_DOCUMENTS; k++) {
            if (task.mapped[k])
                munmap(task.mapped[k], task.order.length[k]);
            task.mapped[k] = NULL;
            used += task.order.length[k];
        }
        for (int k = 0; k < task.files; k++)
            close(task.file[k]);
        task.files = 0;
        if (used > CHECKER_INLINE_MAX)
            malloc_trim(0);
        /* Of a problem as many errors are sent as there are. */
        size_t errors = problem->count < API_ERRORS_MAX ? problem->count : API_ERRORS_MAX;
        if (!frame_send(WORKER_FD, FRAME_ANSWER, &task.answer,
                        offsetof(struct checker_answer, problem.error) +
                            errors * sizeof problem->error[0]))
            return 1;
    }
    return state == FRAME_CLOSED ? 0 : 1;
}

int checker_main(void) {
    static const struct checker_abilities none;
    return checker_serve(&none);
}

/* ------------------------------------------------------------------ the other end */

static bool terminated(const char *text, size_t size) {
    return memchr(text, '\0', size) != NULL;
}

bool checker_answer_sound(struct checker_answer *answer, size_t length) {
    const struct api_problem *problem = &answer->problem;
    size_t head = offsetof(struct checker_answer, problem.error);
    if (length < head || problem->id >= API_PROBLEM_COUNT || problem->count > API_ERRORS_MAX ||
        length != head + problem->count * sizeof problem->error[0] ||
        (problem->id != API_OK) != (problem->count > 0))
        return false;
    memset((char *)answer + length, 0, sizeof *answer - length);
    for (size_t k = 0; k < problem->count; k++)
        if (!terminated(problem->error[k].pointer, API_POINTER_MAX) ||
            !terminated(problem->error[k].detail, API_DETAIL_MAX))
            return false;
    return terminated(answer->check.digest, API_ID_SIZE) &&
           terminated(answer->check.surface, API_ID_SIZE) &&
           terminated(answer->check.text, API_ID_SIZE) &&
           terminated(answer->check.ground, API_ID_SIZE) &&
           terminated(answer->check.material, API_MATERIAL_NAME_SIZE) &&
           terminated(answer->note, CHECKER_NOTE_SIZE) &&
           answer->check.filled_length <= answer->output_length &&
           answer->check.definition_length <= answer->output_length;
}
