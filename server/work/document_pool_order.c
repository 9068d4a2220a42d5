/* SPDX-License-Identifier: MIT */
#include "document_pool_internal.h"

#include "api/files/files.h"
#include "server/spool.h"
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What an order may take, in bytes: a part for itself, and for each byte of its documents. The tree
 * of a hostile document takes up to 79 bytes a byte, a surface of high degree as much; but of a
 * long document that is one of numbers, whose surface is not made ready (`api/check.h`). Of a map
 * the most is taken by its columns, some 300 bytes a point; a point in JSON is 8 bytes of text at
 * the least, an element in bulk data with its share of a node 60. */
#define CHECK_BYTES (INT64_C(24) << 20)
#define CHECK_BYTES_PER_BYTE 96
#define CHECK_LONG_BYTES (INT64_C(128) << 20)
#define CHECK_LONG_BYTES_PER_BYTE 24
#define CHECK_BYTES_PER_FORM_BYTE 4 /* opened, with more made of it, written */
#define IMPORT_BYTES (INT64_C(256) << 20)
#define IMPORT_BYTES_PER_BYTE 96
#define MAP_BYTES (INT64_C(64) << 20)
#define MAP_BYTES_PER_JSON_BYTE 48
#define MAP_BYTES_PER_BULK_BYTE 6
#define MAP_BYTES_PER_COLUMN_BYTE 2
#define SAMPLE_BYTES (INT64_C(256) << 20) /* a drape of half a million nodes */
#define STACK_BYTES_PER_BODY_BYTE 3       /* and ply: of an element that takes 30 bytes or more */

#define SHORT_BODY 2048

/* An order that may take more begins in the slow queue. */
#define FAST_BYTES (INT64_C(128) << 20)

/* Kept for the fast queue is enough for short documents in all its processes, but not more than
 * half. */
int64_t check_most(const struct document_pool *pool) {
    int64_t memory = pool->settings.memory;
    int64_t kept = pool->settings.fast * (CHECK_BYTES + CHECK_BYTES_PER_BYTE * CHECKER_INLINE_MAX);
    return memory - (kept < memory / 2 ? kept : memory / 2);
}

static int64_t reserve_of(const struct document_pool_order *order, int64_t most) {
    int64_t body = (int64_t)order->length[CHECKER_BODY];
    int64_t second = (int64_t)(order->length[CHECKER_SECOND] + order->length[CHECKER_MATERIALS]);
    int64_t form = CHECK_BYTES_PER_FORM_BYTE * (int64_t)order->length[CHECKER_FORM];
    int64_t columns = (int64_t)order->columns.length;
    bool sample = order->kind == CHECKER_SAMPLE || order->kind == CHECKER_SAMPLE_MAP;
    int64_t of_short = CHECK_BYTES + CHECK_BYTES_PER_BYTE * (body + second);
    int64_t of_long = CHECK_LONG_BYTES + CHECK_LONG_BYTES_PER_BYTE * (body + second);
    int64_t bytes = of_short < of_long ? of_short : of_long;
    if (order->source)
        bytes = IMPORT_BYTES + IMPORT_BYTES_PER_BYTE * body;
    bool stack = order->kind == CHECKER_STACK;
    if (order->kind == CHECKER_MAP || order->kind == CHECKER_PATTERNS ||
        order->kind == CHECKER_SAMPLE_MAP || stack)
        bytes = MAP_BYTES + MAP_BYTES_PER_COLUMN_BYTE * columns +
                (order->mesh ? MAP_BYTES_PER_BULK_BYTE : MAP_BYTES_PER_JSON_BYTE) * body;
    if (stack)
        bytes += STACK_BYTES_PER_BODY_BYTE * (int64_t)order->variant * body;
    if (order->kind == CHECKER_VARIANT || sample)
        bytes += MAP_BYTES_PER_COLUMN_BYTE * columns +
                 CHECK_LONG_BYTES_PER_BYTE * (int64_t)order->length[CHECKER_REQUEST];
    if (order->kind == CHECKER_REPORT)
        bytes += MAP_BYTES + MAP_BYTES_PER_COLUMN_BYTE * columns;
    if (sample)
        bytes += SAMPLE_BYTES;
    bytes += form;
    return bytes < most ? bytes : most;
}

/* What may take as long as a job: what it makes, for messages. */
static const char *const works[CHECKER_KINDS] = {
    [CHECKER_MAP] = "the map",       [CHECKER_SAMPLE_MAP] = "the map",
    [CHECKER_STACK] = "the map",     [CHECKER_SAMPLE] = "the drape",
    [CHECKER_REPORT] = "the report", [CHECKER_PATTERNS] = "the patterns"};

int64_t check_timeout(const struct check *check) {
    const struct document_pool_settings *settings = &check->pool->settings;
    if (check->packet.source[0])
        return settings->import_timeout_ms;
    return works[check->packet.kind] ? settings->map_timeout_ms : settings->timeout_ms;
}

/* Whether it may make a prepared form that is worth to be handed on: of a request that is short, a
 * worker makes what it needs as soon. */
static bool makes_form(const struct check *check) {
    const struct checker_order *packet = &check->packet;
    bool request = packet->kind == CHECKER_DRAPE || packet->kind == CHECKER_STUDY;
    return packet->kind == CHECKER_SURFACE ||
           (request && (packet->length[CHECKER_BODY] > SHORT_BODY ||
                        packet->length[CHECKER_SECOND] || packet->length[CHECKER_FORM]));
}

/* Of requests only those that may name materials are written. */
bool check_files(struct check *check) {
    const char *folder = check->pool->settings.folder;
    int *columns = &check->files[CHECKER_COLUMNS], *output = &check->files[CHECKER_OUTPUT];
    if (check->columns.write && *columns < 0) {
        *columns = spool_new(check->columns.length, folder);
        if (*columns < 0 || !check->columns.write(check->columns.context, *columns))
            return false;
    }
    bool request = check->packet.kind == CHECKER_DRAPE || check->packet.kind == CHECKER_STUDY;
    bool writes = !request || !check->inlined ||
                  api_material_mentioned(check->inlined, check->packet.length[CHECKER_BODY]);
    if (writes && *output < 0)
        *output = spool_new(check->packet.length[CHECKER_BODY], folder);
    int *form = &check->files[CHECKER_FORM_OUTPUT];
    if (makes_form(check) && *form < 0)
        *form = spool_new(0, "");
    return !writes || *output >= 0;
}

bool check_send(struct check *check) {
    struct checker_order *packet = &check->packet;
    struct frame_outbox outbox;
    int files[CHECKER_FILES];
    size_t count = 0;
    packet->deadline_ms = check->begun_ms + check_timeout(check);
    packet->limits.max_memory =
        check->max_memory < (size_t)check->reserve ? check->max_memory : (size_t)check->reserve;
    packet->files = 0;
    for (int k = 0; k < CHECKER_FILES; k++)
        if (check->files[k] >= 0) {
            packet->files |= 1u << k;
            files[count++] = check->files[k];
        }
    frame_outbox_begin(&outbox, FRAME_ORDER, packet, sizeof *packet);
    frame_outbox_add(&outbox, check->inlined, check->inlined_length);
    outbox.files = files;
    outbox.file_count = count;
    return frame_push(check->process->child.socket, &outbox) == FRAME_READY;
}

enum check_outcome check_receive(struct check *check, int64_t ms) {
    struct child *child = &check->process->child;
    child_wait(child, POLLIN, -1, ms);
    enum frame_state state = frame_poll(child->socket, &child->inbox);
    if (state == FRAME_LATER)
        return CHECK_LATER;
    size_t length = child->inbox.head.length;
    bool sound = state == FRAME_READY && child->inbox.head.type == FRAME_ANSWER &&
                 length <= sizeof check->answer;
    if (sound)
        memcpy(&check->answer, child->inbox.bytes, length);
    return sound && checker_answer_sound(&check->answer, length) ? CHECK_ANSWER : CHECK_CRASHED;
}

bool check_imports(const struct check *check) {
    const struct file_format *format = file_format_named(check->packet.source);
    return format && format->cad;
}

void check_explain_quota(struct api_problem *problem, enum check_queue queue) {
    if (queue == QUEUE_SLOW)
        api_problem_set(problem, API_QUOTA,
                        "%d of your request bodies that take long to read are waiting already: "
                        "wait until they are read",
                        DOCUMENT_POOL_SLOW_MAX);
    else
        api_problem_set(
            problem, API_QUOTA,
            "%d of your request bodies are waiting to be read already: wait until they are read",
            DOCUMENT_POOL_WAITING_MAX);
}

void check_explain(struct check *check, enum check_outcome outcome) {
    struct api_problem *problem = &check->answer.problem;
    const char *work = works[check->packet.kind], *what = work ? work : "reading the body";
    const char *flag = check->pool->settings.memory_flag;
    const long long seconds = (long long)check_timeout(check) / 1000;
    const long long reserve = (long long)check->reserve;
    enum api_problem_id id = outcome == CHECK_ANSWER ? problem->id : API_OK;
    bool late = outcome == CHECK_TIMEOUT || id == API_CANCELLED;
    if (outcome == CHECK_ANSWER && id != API_OUT_OF_MEMORY && id != API_CANCELLED)
        return;
    memset(&check->answer, 0, sizeof check->answer);
    if (check_imports(check) && late)
        api_problem_set(problem, API_UNREADABLE_FILE,
                        "importing the file took longer than %lld s (--import-timeout)", seconds);
    else if (check_imports(check) && outcome == CHECK_CRASHED)
        api_problem_set(problem, API_UNREADABLE_FILE,
                        "the importer (Open CASCADE) crashed on the file: export it again, or in "
                        "another format");
    else if (check_imports(check) && id == API_OUT_OF_MEMORY)
        api_problem_set(problem, API_UNREADABLE_FILE,
                        "importing the file needs more memory than %lld bytes (--%s)", reserve,
                        flag);
    else if (outcome == CHECK_QUOTA)
        check_explain_quota(problem, QUEUE_SLOW);
    else if (outcome == CHECK_CRASHED)
        api_problem_set(problem, API_INTERNAL, "%s crashed", what);
    else if (late)
        api_problem_set(problem, work ? API_JOB_TIMEOUT : API_TOO_LARGE,
                        "%s took longer than %lld s%s", what, seconds,
                        work ? " (--job-timeout)" : "");
    else if (id == API_OUT_OF_MEMORY)
        api_problem_set(problem, API_TOO_LARGE, "%s needs more memory than %lld bytes (--%s)", what,
                        reserve, flag);
    else
        api_problem_set(problem, API_UNAVAILABLE, "%s could not be started now: try again", what);
}

void check_close(struct check *check, int begin, int end) {
    for (int k = begin; k < end; k++) {
        if (check->files[k] >= 0)
            close(check->files[k]);
        check->files[k] = -1;
    }
}

void check_free(struct check *check) {
    check_close(check, 0, CHECKER_FILES);
    if (check->columns.free)
        check->columns.free(check->columns.context);
    free(check->inlined);
    free(check);
}

struct check *check_new(struct document_pool *pool, const struct document_pool_order *order,
                        const char *subject) {
    struct check *check = calloc(1, sizeof *check);
    if (!check)
        return NULL;
    struct checker_order *packet = &check->packet;
    check->pool = pool;
    snprintf(check->subject, sizeof check->subject, "%s", subject);
    snprintf(check->owner, sizeof check->owner, "%s", order->owner);
    check->reserve = reserve_of(order, check_most(pool));
    check->max_memory = order->limits.max_memory;
    check->queue = check->reserve > FAST_BYTES ? QUEUE_SLOW : QUEUE_FAST;
    packet->kind = order->kind;
    packet->limits = order->limits;
    snprintf(packet->mesh, sizeof packet->mesh, "%s", order->mesh ? order->mesh : "");
    packet->variant = order->variant;
    packet->has_start = order->start != NULL;
    if (order->start)
        packet->start = *order->start;
    snprintf(packet->source, sizeof packet->source, "%s", order->source ? order->source : "");
    snprintf(packet->unit, sizeof packet->unit, "%s", order->unit ? order->unit : "");
    snprintf(packet->id, sizeof packet->id, "%s", order->id ? order->id : "");
    snprintf(packet->format, sizeof packet->format, "%s", order->format ? order->format : "");
    check->files[CHECKER_OUTPUT] = check->files[CHECKER_FORM_OUTPUT] = -1;
    size_t total = 0;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++) {
        check->files[k] = -1;
        packet->length[k] = order->length[k];
        total += k == CHECKER_FORM ? 0 : order->length[k];
    }
    packet->length[CHECKER_COLUMNS] = order->columns.length;
    /* keeps the documents: short ones in memory, long ones as files */
    bool inlined = total <= CHECKER_INLINE_MAX;
    char *to = check->inlined = inlined ? malloc(total + 1) : NULL;
    bool good = !inlined || to;
    check->inlined_length = inlined ? total : 0;
    for (int k = 0; k < CHECKER_DOCUMENTS && good; k++) {
        size_t length = order->length[k];
        if (k == CHECKER_FORM && length) {
            check->files[k] = dup(order->form_file);
            good = check->files[k] >= 0;
        } else if (inlined && length) {
            memcpy(to, order->document[k], length);
            to += length;
        } else if (length) {
            bool ready = k == CHECKER_BODY && order->body_file >= 0;
            check->files[k] =
                ready ? dup(order->body_file) : spool_of_bytes(order->document[k], length);
            good = check->files[k] >= 0;
        }
    }
    if (good) {
        check->columns = order->columns;
        return check;
    }
    check_free(check);
    return NULL;
}
