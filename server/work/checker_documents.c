/* SPDX-License-Identifier: MIT */
#include "api/files/files.h"
#include "api/format/format.h"
#include "api/json/text.h"
#include "api/laminate/check.h"
#include "api/map/cavity.h"
#include "api/map/map.h"
#include "api/run.h"
#include "api/study/study.h"
#include "checker_task.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/spool.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static bool in_time(void *context, double fraction) {
    const struct checker_task *task = context;
    (void)fraction;
    return clock_ms() < task->order.deadline_ms;
}

/* The options of the order for the mesh and for the format. */
static bool take_options(const struct checker_task *task, struct arena *arena,
                         struct map_target *mesh, struct format_options *options,
                         struct api_problem *problem) {
    const char *at = task->document[CHECKER_OPTIONS];
    const char *end = at + task->order.length[CHECKER_OPTIONS];
    while (problem->id == API_OK && at < end) {
        const char *name = at, *value = name + strlen(name) + 1;
        if (!map_target_option(mesh, name, value, arena, problem) && problem->id == API_OK)
            format_option(options, name, value, problem);
        at = value + strlen(value) + 1;
    }
    return problem->id == API_OK;
}

/* Writes a document of the format. */
static void write_checked_document(struct checker_task *task, const struct format *format,
                                   const struct format_source *source,
                                   const struct format_options *options,
                                   struct api_problem *problem) {
    struct encoder *encoder = encoder_new(format, source, options, problem);
    if (!encoder)
        return;
    snprintf(task->answer.note, sizeof task->answer.note, "%s", encoder_binning(encoder));
    ssize_t got;
    while ((got = encoder_read(encoder, task->buffer, sizeof task->buffer)) > 0 &&
           spool_write(task->output, task->buffer, (size_t)got))
        task->answer.output_length += (uint64_t)got;
    if (got)
        api_problem_set(problem, API_UNAVAILABLE, "there is no disk space for the answer now");
    encoder_free(encoder);
}

/* ---- a variant of a study ---- */

/* In an arena of its own, which it goes back in while what the sink is given stays. */
enum api_problem_id checker_task_variant(const struct checker_task *task,
                                         const struct api_sink *sink, struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    const struct api_input input = {.request = task->document[CHECKER_REQUEST],
                                    .request_length = order->length[CHECKER_REQUEST],
                                    .surface = checker_task_surface(task),
                                    .surface_length = order->length[CHECKER_SECOND]};
    struct api_memory columns = {task->document[CHECKER_COLUMNS], order->length[CHECKER_COLUMNS]};
    const struct api_reader reader = api_reader_of(&columns);
    struct arena *arena = arena_new(order->limits.max_memory);
    struct api_study *study = arena ? api_study_open(&input, &order->limits, problem) : NULL;
    if (!arena)
        api_problem_set(problem, API_OUT_OF_MEMORY, "there is no memory for the variant");
    else if (study && order->kind != CHECKER_VARIANT && api_study_lays_courses(study))
        api_problem_set(problem, API_NOT_ACCEPTABLE,
                        "a variant of courses is a laminate and no drape: post the request of the "
                        "variant to /v1/laminates");
    else if (study)
        (void)!api_study_variant_request(study, &reader, (size_t)order->variant, arena, sink,
                                         problem);
    api_study_close(study);
    arena_free(arena);
    return problem->id;
}

static bool append_text(void *context, const void *bytes, size_t length) {
    api_text_bytes(context, bytes, length);
    return !((struct api_text *)context)->failed;
}

/* A text that could not grow has refused what was written: that is no cancellation. */
static enum api_problem_id without_room(const struct api_text *text, struct api_problem *problem) {
    if (text->failed) {
        memset(problem, 0, sizeof *problem);
        api_problem_set(problem, API_OUT_OF_MEMORY, "the drape needs more memory than allowed");
    }
    return problem->id;
}

/* Drapes the variant; its request and its result lie in the arena. */
static enum api_problem_id drape_variant(const struct checker_task *task,
                                         const struct drape_monitor *monitor, struct arena *arena,
                                         struct api_input *input, struct api_memory *result,
                                         struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    struct api_text request = api_text_growing(arena), container = api_text_growing(arena);
    const struct api_sink to_request = {.write = append_text, .context = &request};
    const struct api_sink to_container = {.write = append_text, .context = &container};
    if (checker_task_variant(task, &to_request, problem) != API_OK)
        return without_room(&request, problem);
    *input = (struct api_input){.request = request.bytes,
                                .request_length = request.length,
                                .surface = checker_task_surface(task),
                                .surface_length = order->length[CHECKER_SECOND]};
    if (api_run(input, &order->limits, monitor, &to_container, problem) == API_OK)
        *result = (struct api_memory){container.bytes, container.length};
    return without_room(&container, problem);
}

/* ---- maps, samples and reports ---- */

/* The source of a map: the drape's, the variant's or the laminate's fields on the mesh of the body,
 * which the source refers to. */
static bool make_map(const struct checker_task *task, const struct format *format,
                     const struct drape_monitor *monitor, struct arena *arena,
                     struct map_target *mesh, struct format_options *options,
                     struct format_source *source, struct api_problem *problem) {
    static struct api_map map;
    const struct checker_order *order = &task->order;
    const char *body = task->document[CHECKER_BODY];
    size_t length = order->length[CHECKER_BODY];
    struct api_memory columns = {task->document[CHECKER_COLUMNS], order->length[CHECKER_COLUMNS]};
    struct api_input input = {.request = task->document[CHECKER_SECOND],
                              .request_length = order->length[CHECKER_SECOND]};
    const struct file_format *file = file_format_named(order->mesh);
    enum api_problem_id read = file ? file_read_target(file, body, length, arena, mesh, problem)
                                    : map_target_json(body, length, arena, mesh, problem);
    if (read == API_OK && !mesh->elements && format->elements)
        api_problem_set(problem, API_NOT_ACCEPTABLE,
                        "%s needs a mesh with elements; a map onto points is available as json, "
                        "csv",
                        format->name);
    source->fields = &map.fields;
    if (problem->id != API_OK || !take_options(task, arena, mesh, options, problem))
        return false;
    mesh->wants_outlines = format->outlines;
    if (order->kind == CHECKER_STACK)
        return laminate_map_record(input.request, input.request_length, columns.bytes,
                                   columns.length, &order->limits, mesh, monitor, arena, &map,
                                   problem) == API_OK;
    if (order->kind == CHECKER_SAMPLE_MAP &&
        drape_variant(task, monitor, arena, &input, &columns, problem) != API_OK)
        return false;
    const struct api_reader reader = api_reader_of(&columns);
    mesh->wants_yarns = format->yarns;
    return cavity_take_cloth(mesh, &reader, &input, &order->limits, arena, problem) &&
           api_map_make(&reader, mesh, monitor, arena, &map, problem) == API_OK;
}

/* The source of a report: the result, and what it is of. The second document is none of the
 * request's: what that names of stored surfaces stays a name. */
static bool make_record(const struct checker_task *task, const struct api_reader *reader,
                        struct arena *arena, struct format_source *source,
                        struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    const struct api_input input = {.request = task->document[CHECKER_BODY],
                                    .request_length = order->length[CHECKER_BODY]};
    const char *digest = task->document[CHECKER_SECOND];
    struct api_columns *columns = arena_alloc(arena, 1, sizeof *columns);
    struct api_text inputs = api_text_growing(arena);
    const struct api_sink sink = {.write = append_text, .context = &inputs};
    if (!columns) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the report needs more memory than allowed");
        return false;
    }
    if (api_columns_open(reader, columns, problem) != API_OK)
        return false;
    if (api_check_normalise(&input, &order->limits, &columns->start, &sink, problem) != API_OK)
        return without_room(&inputs, problem) == API_OK;
    source->record.inputs = api_text_finish(&inputs);
    source->record.digest = digest;
    source->record.finished = digest + strlen(digest) + 1;
    source->record.program = "draped " DRAPE_VERSION;
    return true;
}

/* Of a drape, or of the variant of a study: so cases can be told apart. */
void checker_task_document(struct checker_task *task, struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    const bool report = order->kind == CHECKER_REPORT, sample = order->kind == CHECKER_SAMPLE;
    const struct drape_monitor monitor = {in_time, task};
    const struct format *format = format_named(report   ? FORMAT_REPORT
                                               : sample ? FORMAT_RESULT
                                                        : FORMAT_MAP,
                                               order->format);
    struct api_memory result = {task->document[CHECKER_COLUMNS], order->length[CHECKER_COLUMNS]};
    struct format_source source = {.id = order->id};
    struct format_options options = {0};
    struct map_target mesh; /* of a map; the others have no option for it */
    struct api_input input;
    char id[FORMAT_ID_SIZE];
    struct arena *arena = arena_new(order->limits.max_memory);
    if (!arena || !format) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the document needs more memory than allowed");
        arena_free(arena);
        return;
    }
    if (sample || order->kind == CHECKER_SAMPLE_MAP) {
        (void)snprintf(id, sizeof id, "%s/variants/%" PRIu64, order->id, order->variant);
        source.id = id;
    }
    bool good = report || sample
                    ? take_options(task, arena, &mesh, &options, problem)
                    : make_map(task, format, &monitor, arena, &mesh, &options, &source, problem);
    if (good && sample)
        good = drape_variant(task, &monitor, arena, &input, &result, problem) == API_OK;
    const struct api_reader reader = api_reader_of(&result);
    if (report || sample)
        source.reader = &reader;
    if (good && report)
        good = make_record(task, &reader, arena, &source, problem);
    if (good)
        write_checked_document(task, format, &source, &options, problem);
    arena_free(arena);
}

enum api_problem_id checker_task_patterns(const struct checker_task *task,
                                          const struct api_sink *sink,
                                          struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    struct arena *arena = arena_new(order->limits.max_memory);
    if (!arena)
        api_problem_set(problem, API_OUT_OF_MEMORY, "there is no memory for the patterns");
    else
        (void)!laminate_pattern_record(
            task->document[CHECKER_SECOND], order->length[CHECKER_SECOND],
            task->document[CHECKER_COLUMNS], order->length[CHECKER_COLUMNS], &order->limits,
            (int)order->variant - 1, order->format, task->document[CHECKER_OPTIONS],
            order->length[CHECKER_OPTIONS], sink, arena, problem);
    arena_free(arena);
    return problem->id;
}
