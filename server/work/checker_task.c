/* SPDX-License-Identifier: MIT */
#include "checker_task.h"

#include "api/files/files.h"
#include "api/laminate/check.h"
#include "api/study/study.h"
#include "server/spool.h"
#include <stdlib.h>
#include <string.h>
#include <time.h>

static bool flush_output(struct checker_task *task) {
    bool good = spool_write(task->output, task->buffer, task->buffered);
    task->buffered = 0;
    return good;
}

/* The output as an `api_sink`. */
static bool write_answer(void *context, const void *bytes, size_t length) {
    struct checker_task *task = context;
    task->answer.output_length += length;
    if (task->buffered + length > sizeof task->buffer && !flush_output(task))
        return false;
    if (length > sizeof task->buffer)
        return spool_write(task->output, bytes, length);
    memcpy(task->buffer + task->buffered, bytes, length);
    task->buffered += length;
    return true;
}

/* The file for a prepared form as an `api_sink`. */
static bool write_form(void *context, const void *bytes, size_t length) {
    const struct checker_task *task = context;
    return spool_write(task->form_output, bytes, length);
}

static int64_t processor_us(void) {
    struct timespec used;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    return used.tv_sec * INT64_C(1000000) + used.tv_nsec / 1000;
}

/* A surface to be stored that comes as a file of CAD or mesh. */
static enum api_problem_id check_surface_file(struct checker_task *task,
                                              const struct checker_abilities *abilities,
                                              const struct api_sink *sink,
                                              const struct api_sink *forms) {
    const struct checker_order *order = &task->order;
    const char *body = task->document[CHECKER_BODY], *text = NULL;
    const struct file_format *format = file_format_named(order->source);
    struct api_problem *problem = &task->answer.problem;
    size_t length = order->length[CHECKER_BODY], text_length = 0;
    char why[API_DETAIL_MAX] = "", *imported = NULL;
    struct arena *arena = arena_new(order->limits.max_memory);
    if (!arena) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "there is no memory for the file");
    } else if (!format || (format->cad && !abilities->import)) {
        api_problem_set(problem, API_INTERNAL, "this process cannot import files");
    } else if (format->cad) {
        text = imported =
            abilities->import(body, length, order->source, order->unit, &text_length, why);
        if (!text)
            api_problem_set(problem, API_UNREADABLE_FILE, "%s", why);
    } else if (file_read_mesh(format, body, length, order->unit, arena, &text, &text_length,
                              problem) != API_OK) {
        text = NULL;
    }
    const struct api_input input = {.request = text, .request_length = text_length};
    if (text)
        (void)!api_check_surface(&input, &order->limits, sink, forms, &task->answer.check, problem);
    free(imported);
    arena_free(arena);
    return problem->id;
}

/* A request to be accepted, whose materials are in `input` already. */
static enum api_problem_id check_filled(struct checker_task *task, const struct api_input *input,
                                        const struct api_sink *sink, const struct api_sink *forms) {
    const struct checker_order *order = &task->order;
    struct checker_answer *answer = &task->answer;
    if (order->kind == CHECKER_LAMINATE)
        return laminate_check(input, &order->limits, sink, &answer->check, &answer->problem);
    return order->kind == CHECKER_STUDY
               ? api_check_study(input, &order->limits, forms, &answer->check, &answer->problem)
               : api_check_drape(input, &order->limits, forms, &answer->check, &answer->problem);
}

/* A request to be accepted. What is written of a laminate has its plies' requests and record; of
 * the others that name materials it is the request. */
static enum api_problem_id check_request(struct checker_task *task, struct api_input input,
                                         const struct api_sink *sink,
                                         const struct api_sink *forms) {
    const struct checker_order *order = &task->order;
    struct checker_answer *answer = &task->answer;
    struct api_check found = {0};
    size_t own = order->length[CHECKER_MATERIALS];
    if (!api_material_mentioned(input.request, input.request_length))
        return check_filled(task, &input, sink, forms);
    struct arena *arena = arena_new(order->limits.max_memory);
    if (!arena)
        api_problem_set(&answer->problem, API_OUT_OF_MEMORY, "there is no memory for the request");
    else if (api_check_mentions(&input, own ? task->document[CHECKER_MATERIALS] : NULL, own, sink,
                                arena, &found, &answer->problem) == API_OK &&
             !found.needs_materials) {
        if (order->kind == CHECKER_LAMINATE)
            found.filled_length = 0;
        else if (!sink->write(sink->context, input.request, input.request_length))
            api_problem_set(&answer->problem, API_UNAVAILABLE,
                            "there is no disk space for the request now");
        if (answer->problem.id == API_OK)
            (void)!check_filled(task, &input, sink, forms);
    }
    answer->check.needs_materials = found.needs_materials;
    answer->check.filled_length = found.filled_length;
    arena_free(arena);
    return answer->problem.id;
}

void checker_task_carry_out(struct checker_task *task, const struct checker_abilities *abilities) {
    const int64_t begun = processor_us();
    const struct checker_order *order = &task->order;
    struct checker_answer *answer = &task->answer;
    const struct api_input input = {.request = task->document[CHECKER_BODY],
                                    .request_length = order->length[CHECKER_BODY],
                                    .surface = checker_task_surface(task),
                                    .surface_length = order->length[CHECKER_SECOND],
                                    .form = task->document[CHECKER_FORM],
                                    .form_length = order->length[CHECKER_FORM]};
    const struct api_sink form_sink = {.write = write_form, .context = task};
    const struct api_sink *forms = task->form_output >= 0 ? &form_sink : NULL;
    const struct api_sink sink = {.write = write_answer, .context = task};
    const struct api_start *start = order->has_start ? &order->start : NULL;
    enum api_problem_id id = API_OK;
    switch (order->kind) {
    case CHECKER_DRAPE:
    case CHECKER_STUDY:
    case CHECKER_LAMINATE:
        id = check_request(task, input, &sink, forms);
        break;
    case CHECKER_MATERIAL:
        id = api_check_material(&input, &order->limits, &sink, &answer->check, &answer->problem);
        break;
    case CHECKER_PATTERNS:
        id = checker_task_patterns(task, &sink, &answer->problem);
        break;
    case CHECKER_VARIANT:
        id = checker_task_variant(task, &sink, &answer->problem);
        break;
    case CHECKER_SURFACE:
        id = order->source[0] ? check_surface_file(task, abilities, &sink, forms)
                              : api_check_surface(&input, &order->limits, &sink, forms,
                                                  &answer->check, &answer->problem);
        break;
    case CHECKER_PREVIEW:
        id = api_check_preview(&input, &order->limits, &sink, &answer->problem);
        break;
    case CHECKER_UNDERSTOOD:
        id = api_study_normalise(&input, &order->limits, &sink, &answer->problem);
        break;
    case CHECKER_NORMALISE:
        id = api_check_normalise(&input, &order->limits, start, &sink, &answer->problem);
        break;
    default:
        checker_task_document(task, &answer->problem); /* a map, a sample or a report */
    }
    if (id == API_OK && task->buffered && !flush_output(task))
        api_problem_set(&answer->problem, API_UNAVAILABLE,
                        "there is no disk space for the answer now");
    answer->processor_us = processor_us() - begun;
}
