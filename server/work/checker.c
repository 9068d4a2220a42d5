/* SPDX-License-Identifier: MIT */
#include "checker.h"
#include "api/files/files.h"
#include "api/format/format.h"
#include "api/json/text.h"
#include "api/laminate/check.h"
#include "api/map/cavity.h"
#include "api/map/map.h"
#include "api/run.h"
#include "api/study/study.h"
#include "sandbox.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/spool.h"
#include "worker.h"
#include <errno.h>
#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

enum {
    FILES_MAX = CHECKER_DOCUMENTS + 1,
    WRITE_BYTES = 128 * 1024,
    KEPT_BYTES = 4 * 1024 * 1024 /* between orders: most need no new memory from the system */
};

/* An order under way. */
struct task {
    struct checker_order order;
    char packet[CHECKER_INLINE_MAX];
    const char *document[CHECKER_DOCUMENTS];
    void *mapped[CHECKER_DOCUMENTS]; /* of those that are files */
    int file[FILES_MAX], files;      /* received with it */
    int output;                      /* -1: none */
    size_t buffered;
    char buffer[WRITE_BYTES];
    struct checker_answer answer;
};

/* ------------------------------------------------------------------ what is written */

static bool flush(struct task *task) {
    bool good = spool_write(task->output, task->buffer, task->buffered);
    task->buffered = 0;
    return good;
}

/* The output as an `api_sink`. */
static bool put(void *context, const void *bytes, size_t length) {
    struct task *task = context;
    task->answer.output_length += length;
    if (task->buffered + length > sizeof task->buffer && !flush(task))
        return false;
    if (length > sizeof task->buffer)
        return spool_write(task->output, bytes, length);
    memcpy(task->buffer + task->buffered, bytes, length);
    task->buffered += length;
    return true;
}

/* ------------------------------------------------------------------ a map */

static bool in_time(void *context, double fraction) {
    const struct task *task = context;
    (void)fraction;
    return clock_ms() < task->order.deadline_ms;
}

/* The options of the order for the mesh and for the format. */
static bool take_options(const struct task *task, struct arena *arena, struct map_target *mesh,
                         struct format_options *options, struct api_problem *problem) {
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

static bool read_mesh(const struct task *task, const struct format *format, struct arena *arena,
                      struct map_target *mesh, struct api_problem *problem) {
    const char *body = task->document[CHECKER_BODY];
    size_t length = task->order.length[CHECKER_BODY];
    enum api_problem_id id = task->order.nastran
                                 ? map_target_nastran(body, length, arena, mesh, problem)
                                 : map_target_json(body, length, arena, mesh, problem);
    if (id == API_OK && !mesh->elements && format->elements)
        api_problem_set(problem, API_NOT_ACCEPTABLE,
                        "%s is of elements; a map onto points is available as json, csv",
                        format->name);
    return problem->id == API_OK;
}

/* Writes a document of the format. */
static void write_document(struct task *task, const struct format *format,
                           const struct format_source *source, const struct format_options *options,
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
        api_problem_set(problem, API_UNAVAILABLE, "there is no room to write the answer now");
    encoder_free(encoder);
}

/* The stored surface, NULL without one. */
static const char *surface_of(const struct task *task) {
    return task->order.length[CHECKER_SECOND] ? task->document[CHECKER_SECOND] : NULL;
}

/* ------------------------------------------------------------------ a variant of a study */

/* In an arena of its own, which it goes back in while what the sink is given stays. */
static enum api_problem_id write_variant(const struct task *task, const struct api_sink *sink,
                                         struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    const struct api_input input = {.request = task->document[CHECKER_REQUEST],
                                    .request_length = order->length[CHECKER_REQUEST],
                                    .surface = surface_of(task),
                                    .surface_length = order->length[CHECKER_SECOND]};
    struct api_memory columns = {task->document[CHECKER_COLUMNS], order->length[CHECKER_COLUMNS]};
    const struct api_reader reader = api_reader_of(&columns);
    struct arena *arena = arena_new(order->limits.max_memory);
    struct api_study *study = arena ? api_study_open(&input, &order->limits, problem) : NULL;
    if (!arena)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the variant");
    else if (study)
        (void)!api_study_variant_request(study, &reader, (size_t)order->variant, arena, sink,
                                         problem);
    api_study_close(study);
    arena_free(arena);
    return problem->id;
}

static bool append(void *context, const void *bytes, size_t length) {
    api_text_bytes(context, bytes, length);
    return !((struct api_text *)context)->failed;
}

/* Drapes the variant; its request and its result lie in the arena. */
static enum api_problem_id drape_variant(const struct task *task,
                                         const struct drape_monitor *monitor, struct arena *arena,
                                         struct api_input *input, struct api_memory *result,
                                         struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    struct api_text request = api_text_growing(arena), container = api_text_growing(arena);
    const struct api_sink to_request = {.write = append, .context = &request};
    const struct api_sink to_container = {.write = append, .context = &container};
    if (write_variant(task, &to_request, problem) != API_OK)
        return problem->id;
    *input = (struct api_input){.request = request.bytes,
                                .request_length = request.length,
                                .surface = surface_of(task),
                                .surface_length = order->length[CHECKER_SECOND]};
    if (api_run(input, &order->limits, monitor, &to_container, problem) == API_OK)
        *result = (struct api_memory){container.bytes, container.length};
    return problem->id;
}

/* ------------------------------------------------------------------ maps and samples */

/* Of a drape, of a variant or of a laminate. */
static enum api_problem_id fill_map(const struct task *task, struct map_target *mesh,
                                    const struct drape_monitor *monitor, struct arena *arena,
                                    struct api_map *map, struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    struct api_memory columns = {task->document[CHECKER_COLUMNS], order->length[CHECKER_COLUMNS]};
    if (order->kind == CHECKER_STACK)
        return laminate_map_record(task->document[CHECKER_SECOND], order->length[CHECKER_SECOND],
                                   columns.bytes, columns.length, &order->limits, mesh, monitor,
                                   arena, map, problem);
    struct api_input input = {.request = task->document[CHECKER_SECOND],
                              .request_length = order->length[CHECKER_SECOND]};
    if (order->kind == CHECKER_SAMPLE_MAP &&
        drape_variant(task, monitor, arena, &input, &columns, problem) != API_OK)
        return problem->id;
    const struct api_reader reader = api_reader_of(&columns);
    if (!cavity_take_cloth(mesh, &reader, &input, &order->limits, arena, problem))
        return problem->id;
    return api_map_make(&reader, mesh, monitor, arena, map, problem);
}

static void make_map(struct task *task, struct api_problem *problem) {
    static struct api_map map;
    const struct checker_order *order = &task->order;
    const struct drape_monitor monitor = {in_time, task};
    const struct format *format = format_named(FORMAT_MAP, order->format);
    struct format_options options = {0};
    struct map_target mesh;
    struct arena *arena = arena_new(order->limits.max_memory);
    if (!arena || !format)
        api_problem_set(problem, API_OUT_OF_MEMORY, "the map needs more memory than allowed");
    else if (read_mesh(task, format, arena, &mesh, problem) &&
             take_options(task, arena, &mesh, &options, problem) &&
             fill_map(task, &mesh, &monitor, arena, &map, problem) == API_OK)
        write_document(task, format,
                       &(struct format_source){.id = order->id, .fields = &map.fields}, &options,
                       problem);
    arena_free(arena);
}

static void make_sample(struct task *task, struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    const struct drape_monitor monitor = {in_time, task};
    const struct format *format = format_named(FORMAT_RESULT, order->format);
    struct format_options options = {0};
    struct map_target mesh; /* no option is for it */
    struct api_input input;
    struct api_memory result;
    struct arena *arena = arena_new(order->limits.max_memory);
    if (!arena || !format) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the drape needs more memory than allowed");
    } else if (take_options(task, arena, &mesh, &options, problem) &&
               drape_variant(task, &monitor, arena, &input, &result, problem) == API_OK) {
        const struct api_reader reader = api_reader_of(&result);
        write_document(task, format, &(struct format_source){.id = order->id, .reader = &reader},
                       &options, problem);
    }
    arena_free(arena);
}

/* ------------------------------------------------------------------ reports and patterns */

static void make_report(struct task *task, const struct api_input *input,
                        struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    const char *digest = task->document[CHECKER_SECOND];
    const struct format *format = format_named(FORMAT_REPORT, order->format);
    struct api_memory result = {task->document[CHECKER_COLUMNS], order->length[CHECKER_COLUMNS]};
    const struct api_reader reader = api_reader_of(&result);
    struct format_options options = {0};
    struct map_target mesh; /* no option is for it */
    struct arena *arena = arena_new(order->limits.max_memory);
    struct api_columns *columns = arena ? arena_alloc(arena, 1, sizeof *columns) : NULL;
    if (!columns || !format) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the report needs more memory than allowed");
    } else if (take_options(task, arena, &mesh, &options, problem) &&
               api_columns_open(&reader, columns, problem) == API_OK) {
        struct api_text inputs = api_text_growing(arena);
        const struct api_sink sink = {.write = append, .context = &inputs};
        if (api_check_normalise(input, &order->limits, &columns->start, &sink, problem) == API_OK)
            write_document(
                task, format,
                &(struct format_source){.id = order->id,
                                        .reader = &reader,
                                        .record = {.inputs = api_text_finish(&inputs),
                                                   .digest = digest,
                                                   .finished = digest + strlen(digest) + 1,
                                                   .program = "draped " DRAPED_VERSION}},
                &options, problem);
    }
    arena_free(arena);
}

static enum api_problem_id write_patterns(const struct task *task, const struct api_sink *sink,
                                          struct api_problem *problem) {
    const struct checker_order *order = &task->order;
    struct arena *arena = arena_new(order->limits.max_memory);
    if (!arena)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the patterns");
    else
        (void)!laminate_pattern_record(
            task->document[CHECKER_SECOND], order->length[CHECKER_SECOND],
            task->document[CHECKER_COLUMNS], order->length[CHECKER_COLUMNS], &order->limits,
            (int)order->variant - 1, order->format, task->document[CHECKER_OPTIONS],
            order->length[CHECKER_OPTIONS], sink, arena, problem);
    arena_free(arena);
    return problem->id;
}

/* ------------------------------------------------------------------ an order */

static int64_t processor_us(void) {
    struct timespec used;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    return used.tv_sec * INT64_C(1000000) + used.tv_nsec / 1000;
}

/* A surface to be stored that comes as a file of CAD or mesh. */
static enum api_problem_id import_file(struct task *task, const struct checker_abilities *abilities,
                                       struct arena *arena, const struct api_sink *sink) {
    const struct checker_order *order = &task->order;
    const char *body = task->document[CHECKER_BODY], *text = NULL;
    const struct file_format *format = file_format_named(order->source);
    struct api_problem *problem = &task->answer.problem;
    size_t length = order->length[CHECKER_BODY], text_length = 0;
    char why[API_DETAIL_MAX] = "", *imported = NULL;
    if (!format || (format->cad && !abilities->import)) {
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
    enum api_problem_id id = problem->id;
    if (text)
        id = api_check_surface(&input, &order->limits, sink, &task->answer.check, problem);
    free(imported);
    return id;
}

static enum api_problem_id check_surface(struct task *task,
                                         const struct checker_abilities *abilities,
                                         const struct api_input *input,
                                         const struct api_sink *sink) {
    struct checker_answer *answer = &task->answer;
    if (!task->order.source[0])
        return api_check_surface(input, &task->order.limits, sink, &answer->check,
                                 &answer->problem);
    struct arena *arena = arena_new(task->order.limits.max_memory);
    if (arena)
        import_file(task, abilities, arena, sink);
    else
        api_problem_set(&answer->problem, API_OUT_OF_MEMORY, "no memory for the file");
    arena_free(arena);
    return answer->problem.id;
}

/* A request to be accepted, whose materials are in `input` already. */
static enum api_problem_id check_filled(struct task *task, const struct api_input *input,
                                        const struct api_sink *sink) {
    const struct checker_order *order = &task->order;
    struct checker_answer *answer = &task->answer;
    if (order->kind == CHECKER_LAMINATE)
        return laminate_check(input, &order->limits, sink, &answer->check, &answer->problem);
    return order->kind == CHECKER_STUDY
               ? api_check_study(input, &order->limits, &answer->check, &answer->problem)
               : api_check_drape(input, &order->limits, &answer->check, &answer->problem);
}

/* One that may name materials. What is written of a laminate has its plies' requests and record; of
 * the others it is the request. */
static enum api_problem_id check_mentions(struct task *task, struct api_input input,
                                          const struct api_sink *sink) {
    const struct checker_order *order = &task->order;
    struct checker_answer *answer = &task->answer;
    struct api_check found = {0};
    struct arena *arena = arena_new(order->limits.max_memory);
    size_t own = order->length[CHECKER_MATERIALS];
    if (!arena)
        api_problem_set(&answer->problem, API_OUT_OF_MEMORY, "no memory for the request");
    else if (api_check_mentions(&input, own ? task->document[CHECKER_MATERIALS] : NULL, own, sink,
                                arena, &found, &answer->problem) == API_OK &&
             !found.needs_materials) {
        if (order->kind == CHECKER_LAMINATE)
            found.filled_length = 0;
        else if (!sink->write(sink->context, input.request, input.request_length))
            api_problem_set(&answer->problem, API_UNAVAILABLE, "there is no room for it now");
        if (answer->problem.id == API_OK)
            (void)!check_filled(task, &input, sink);
    }
    answer->check.needs_materials = found.needs_materials;
    answer->check.filled_length = found.filled_length;
    arena_free(arena);
    return answer->problem.id;
}

static enum api_problem_id check_request(struct task *task, const struct api_input *input,
                                         const struct api_sink *sink) {
    return api_material_mentioned(input->request, input->request_length)
               ? check_mentions(task, *input, sink)
               : check_filled(task, input, sink);
}

static void carry_out(struct task *task, const struct checker_abilities *abilities) {
    const int64_t begun = processor_us();
    const struct checker_order *order = &task->order;
    struct checker_answer *answer = &task->answer;
    const struct api_input input = {.request = task->document[CHECKER_BODY],
                                    .request_length = order->length[CHECKER_BODY],
                                    .surface = surface_of(task),
                                    .surface_length = order->length[CHECKER_SECOND]};
    const struct api_sink sink = {.write = put, .context = task};
    const struct api_start *start = order->has_start ? &order->start : NULL;
    enum api_problem_id id = API_OK;
    switch (order->kind) {
    case CHECKER_DRAPE:
    case CHECKER_STUDY:
    case CHECKER_LAMINATE:
        id = check_request(task, &input, &sink);
        break;
    case CHECKER_MATERIAL:
        id = api_check_material(&input, &order->limits, &sink, &answer->check, &answer->problem);
        break;
    case CHECKER_PATTERNS:
        id = write_patterns(task, &sink, &answer->problem);
        break;
    case CHECKER_VARIANT:
        id = write_variant(task, &sink, &answer->problem);
        break;
    case CHECKER_SAMPLE:
        make_sample(task, &answer->problem);
        break;
    case CHECKER_REPORT:
        make_report(task, &input, &answer->problem);
        break;
    case CHECKER_SURFACE:
        id = check_surface(task, abilities, &input, &sink);
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
        make_map(task, &answer->problem);
    }
    if (id == API_OK && task->buffered && !flush(task))
        api_problem_set(&answer->problem, API_UNAVAILABLE, "there is no room for the answer now");
    answer->processor_us = processor_us() - begun;
}

/* Finds the documents in the packet and in the files. */
static bool find_documents(struct task *task, size_t packet_length) {
    static char empty[1];
    size_t at = 0;
    int file = 0;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++) {
        size_t length = task->order.length[k];
        if (!(task->order.files & 1u << k)) {
            task->document[k] = task->packet + at;
            at += length;
            if (length > packet_length || at > packet_length)
                return false;
            continue;
        }
        task->document[k] = empty;
        if (file == task->files)
            return false;
        if (!length) {
            file++;
            continue;
        }
        void *bytes = mmap(NULL, length, PROT_READ, MAP_PRIVATE, task->file[file++], 0);
        if (bytes == MAP_FAILED)
            return false;
        task->document[k] = task->mapped[k] = bytes;
    }
    task->output = task->order.files & 1u << CHECKER_DOCUMENTS ? task->file[file++] : -1;
    return file == task->files;
}

static void clear(struct task *task) {
    uint64_t used = 0;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++) {
        if (task->mapped[k])
            munmap(task->mapped[k], task->order.length[k]);
        task->mapped[k] = NULL;
        used += task->order.length[k];
    }
    for (int k = 0; k < task->files; k++)
        close(task->file[k]);
    task->files = 0;
    if (used > CHECKER_INLINE_MAX)
        malloc_trim(0);
}

/* The length of the documents in the packet; negative at the end. */
static ssize_t receive(struct task *task) {
    struct iovec parts[] = {{&task->order, sizeof task->order},
                            {task->packet, sizeof task->packet}};
    union {
        struct cmsghdr head;
        char bytes[CMSG_SPACE(FILES_MAX * sizeof(int))];
    } control;
    struct msghdr message = {.msg_iov = parts,
                             .msg_iovlen = 2,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    ssize_t got;
    do
        got = recvmsg(WORKER_FD, &message, MSG_CMSG_CLOEXEC);
    while (got < 0 && errno == EINTR);
    if (got < (ssize_t)sizeof task->order || message.msg_flags & (MSG_TRUNC | MSG_CTRUNC))
        return -1;
    struct cmsghdr *files = CMSG_FIRSTHDR(&message);
    task->files = files ? (int)((files->cmsg_len - CMSG_LEN(0)) / sizeof(int)) : 0;
    if (files)
        memcpy(task->file, CMSG_DATA(files), (size_t)task->files * sizeof(int));
    return got - (ssize_t)sizeof task->order;
}

/* Of a problem as many places as there are. */
static bool send_answer(const struct checker_answer *answer) {
    size_t places = answer->problem.count < API_ERRORS_MAX ? answer->problem.count : API_ERRORS_MAX;
    size_t length =
        offsetof(struct checker_answer, problem.place) + places * sizeof answer->problem.place[0];
    return send(WORKER_FD, answer, length, MSG_NOSIGNAL) == (ssize_t)length;
}

/* ------------------------------------------------------------------ the process */

/* No life without the daemon. What an order frees stays with the process, up to KEPT_BYTES. */
static bool set_up(void) {
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    mallopt(M_TRIM_THRESHOLD, KEPT_BYTES);
    mallopt(M_MMAP_THRESHOLD, KEPT_BYTES);
    return api_prepare() && prctl(PR_SET_PDEATHSIG, SIGKILL) == 0 &&
           sandbox_enter(WORKER_FD, FILES_MAX);
}

/* Bytes of address space, 0 when that cannot be read. */
static uint64_t address_space(void) {
    unsigned long long pages = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (!file)
        return 0;
    if (fscanf(file, "%llu", &pages) != 1)
        pages = 0;
    fclose(file);
    return pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

int checker_serve(const struct checker_abilities *abilities) {
    static struct task task;
    const struct checker_hello hello = {address_space()};
    ssize_t length;
    if (!hello.address_space || !set_up() ||
        send(WORKER_FD, &hello, sizeof hello, MSG_NOSIGNAL) != (ssize_t)sizeof hello)
        return 1;
    while ((length = receive(&task)) >= 0) {
        memset(&task.answer, 0, offsetof(struct checker_answer, problem.place));
        task.buffered = 0;
        bool good = find_documents(&task, (size_t)length);
        if (good && abilities->before)
            abilities->before(task.document[CHECKER_BODY], task.order.length[CHECKER_BODY]);
        if (good)
            carry_out(&task, abilities);
        clear(&task);
        if (!good || !send_answer(&task.answer))
            return 1;
    }
    return 0;
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
    size_t head = offsetof(struct checker_answer, problem.place);
    if (length < head || problem->id >= API_PROBLEM_COUNT || problem->count > API_ERRORS_MAX ||
        length != head + problem->count * sizeof problem->place[0] ||
        (problem->id != API_OK) != (problem->count > 0))
        return false;
    memset((char *)answer + length, 0, sizeof *answer - length);
    for (size_t k = 0; k < problem->count; k++)
        if (!terminated(problem->place[k].pointer, API_POINTER_MAX) ||
            !terminated(problem->place[k].detail, API_DETAIL_MAX))
            return false;
    return terminated(answer->check.digest, API_ID_SIZE) &&
           terminated(answer->check.surface, API_ID_SIZE) &&
           terminated(answer->check.material, API_MATERIAL_NAME_SIZE) &&
           terminated(answer->note, CHECKER_NOTE_SIZE) &&
           answer->check.filled_length <= answer->output_length &&
           answer->check.definition_length <= answer->output_length;
}
