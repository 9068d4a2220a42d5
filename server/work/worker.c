/* SPDX-License-Identifier: MIT */
#include "worker.h"
#include "forms.h"
#include "frame.h"
#include "sandbox.h"
#include "server/clock.h"
#include "study.h"
#include <malloc.h>
#include <stdlib.h>
#include <string.h>

enum {
    PROGRESS_MS = 20,             /* shortest time between two progress frames */
    KEPT_BYTES = 32 * 1024 * 1024 /* between jobs: most need no new memory from the system */
};

/* One job under way. */
struct task {
    bool gone;    /* the dispatcher is */
    bool careful; /* every progress is told */
    int64_t last_progress_ms;
    size_t used;
    size_t total;
    char *summary; /* of the container; malloc'ed */
    unsigned char buffer[FRAME_MAX_BYTES];
};

/* ------------------------------------------------------------------ sending */

/* Sends what is in the buffer; false when the dispatcher is gone. */
static bool flush_buffer(struct task *task, enum frame_type type) {
    if (task->used > 0 && !task->gone)
        task->gone = !frame_send(WORKER_FD, type, task->buffer, task->used);
    task->used = 0;
    return !task->gone;
}

static bool send_result(void *context, const void *bytes, size_t length) {
    struct task *task = context;
    const unsigned char *from = bytes;
    task->total += length;
    while (length > 0) {
        size_t room = sizeof task->buffer - task->used;
        size_t part = length < room ? length : room;
        memcpy(task->buffer + task->used, from, part);
        task->used += part;
        from += part;
        length -= part;
        if (task->used == sizeof task->buffer && !flush_buffer(task, FRAME_RESULT))
            return false;
    }
    return !task->gone;
}

static bool keep_summary(void *context, const char *json) {
    struct task *task = context;
    free(task->summary);
    task->summary = strdup(json);
    return task->summary && !task->gone;
}

static bool send_progress(void *context, double fraction) {
    struct task *task = context;
    int64_t now = clock_ms();
    if (!task->careful && now - task->last_progress_ms < PROGRESS_MS)
        return !task->gone;
    task->last_progress_ms = now;
    task->gone = !frame_send(WORKER_FD, FRAME_PROGRESS, &fraction, sizeof fraction);
    return !task->gone;
}

static bool send_study_task(void *context, const void *bytes, size_t length, size_t variants) {
    struct task *task = context;
    struct frame_task packed = {.variants = variants, .length = length};
    if (length > sizeof packed.bytes)
        return false;
    memcpy(packed.bytes, bytes, length);
    memcpy(task->buffer + task->used, &packed, sizeof packed);
    task->used += sizeof packed;
    return task->used + sizeof packed <= sizeof task->buffer || flush_buffer(task, FRAME_TASKS);
}

/* Without memory for the document one from static storage says just that. */
static bool send_problem(const struct api_problem *problem) {
    static const char no_memory[] =
        "{\"type\":\"/problems/out-of-memory\",\"title\":\"The drape needs more memory than "
        "allowed\",\"status\":500,\"detail\":\"There was no memory to describe the problem.\"}";
    char *json = api_problem_json(problem, NULL);
    const char *text = json ? json : no_memory;
    bool sent = frame_send(WORKER_FD, FRAME_PROBLEM, text, strlen(text));
    free(json);
    return sent;
}

/* ------------------------------------------------------------------ a job */

/* Carries the job out and says how it ended; false when the dispatcher is gone. */
static bool run_job(const struct worker_engine *engine, struct task *task,
                    const struct frame_job *job, const struct worker_order *order) {
    struct api_problem problem = {0};
    struct drape_monitor monitor = {.progress = send_progress, .context = task};
    struct api_sink sink = {.write = send_result, .context = task, .summary = keep_summary};
    struct worker_round round = {.add = send_study_task, .context = task};
    task->gone = false;
    task->careful = job->careful;
    task->last_progress_ms = clock_ms();
    task->used = task->total = 0;
    free(task->summary);
    task->summary = NULL;
    enum api_problem_id id =
        job->kind == FRAME_STEP ? engine->step(order, &round, &sink, &problem)
        : job->kind == FRAME_TASK
            ? engine->task(order, &monitor, &sink, &problem)
            : engine->run(order->input, order->limits, &monitor, &sink, &problem);
    if (task->gone)
        return false;
    if (id != API_OK)
        return send_problem(&problem);
    if (round.count > 0) {
        struct frame_round end = {.done = round.done, .total = round.total};
        memcpy(end.best, round.best, sizeof end.best);
        return flush_buffer(task, FRAME_TASKS) &&
               frame_send(WORKER_FD, FRAME_ROUND, &end, sizeof end);
    }
    const char *summary = job->kind == FRAME_TASK ? "{}" : task->summary;
    if (!summary) {
        api_problem_set(&problem, API_INTERNAL, "The result has no summary.");
        return send_problem(&problem);
    }
    return flush_buffer(task, FRAME_RESULT) &&
           frame_send(WORKER_FD, FRAME_DONE, summary, strlen(summary));
}

/* ------------------------------------------------------------------ the process */

int worker_serve(const struct worker_engine *engine) {
    static struct task task;
    struct frame_job job;
    enum frame_state state = FRAME_CLOSED;
    bool good = true;
    int files[FRAME_FILES_MAX], file_count = 0;
    if (!sandbox_begin(WORKER_FD, 1, KEPT_BYTES))
        return 1;
    while (good && (state = frame_expect(WORKER_FD, FRAME_JOB, &job, sizeof job, files,
                                         &file_count)) == FRAME_READY) {
        struct forms_mapped form;
        good = forms_map(file_count > 0 ? files[0] : -1, job.form_length, &form);
        uint64_t length = job.length + job.request_length + job.surface_length;
        char *bytes = malloc(length + 1);
        if (!bytes) {
            struct api_problem problem = {0};
            api_problem_set(&problem, API_OUT_OF_MEMORY, "The request does not fit into memory.");
            while (good &&
                   length > 0) { /* read away, so that the next frame starts where it should */
                size_t part = length < sizeof task.buffer ? (size_t)length : sizeof task.buffer;
                good = frame_receive(WORKER_FD, task.buffer, part);
                length -= part;
            }
            good = good && send_problem(&problem);
            forms_unmap(&form);
            continue;
        }
        struct api_input input = {.request = bytes + job.length,
                                  .request_length = job.request_length,
                                  .surface = bytes + job.length + job.request_length,
                                  .surface_length = job.surface_length,
                                  .form = form.bytes,
                                  .form_length = form.length};
        if (job.form_kept)
            input.opened = forms_open(&form);
        struct worker_order order = {.input = &input,
                                     .limits = &job.limits,
                                     .bytes = bytes,
                                     .length = job.length,
                                     .spent_ms = job.spent_ms};
        good =
            good && frame_receive(WORKER_FD, bytes, length) && run_job(engine, &task, &job, &order);
        forms_unmap(&form);
        free(bytes);
        if (length + task.total > KEPT_BYTES)
            malloc_trim(0);
    }
    return good && state == FRAME_CLOSED ? 0 : 1;
}

int worker_main(void) {
    static const struct worker_engine engine = {
        .run = api_run, .step = study_step, .task = study_task};
    return api_prepare() ? worker_serve(&engine) : 1;
}
