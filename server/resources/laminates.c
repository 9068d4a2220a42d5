/* SPDX-License-Identifier: MIT */
/*
 * What only laminates have: drapes that are submitted with them, the plies in their status, the map
 * of the stack, the pattern of a ply. What is kept of a laminate is its record
 * (`api/laminate/check.h`): the lines before the empty one say of each ply, or piece of one, which
 * drape it has, and its name.
 */
#include "laminates.h"
#include "api/json/text.h"
#include "documents.h"
#include "handlers.h"
#include "server/spool.h"
#include "server/work/stored_result.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PLY_SEGMENT = 4 };

/* ------------------------------------------------------------------ submission */

/* The next line from `*at` on, zero-terminated in place; NULL at the end. */
static char *take_line(char **at) {
    char *line = *at, *end = strchr(line, '\n');
    if (!end)
        return NULL;
    *end = '\0';
    *at = end + 1;
    return line;
}

/* What the checker wrote: the lengths of all, the digest and length of every drape's request, an
 * empty line, these requests, and the record. */
enum store_answer laminates_submit(struct call *call, struct check *check,
                                   const struct store_submission *submission,
                                   struct store_receipt *receipt) {
    size_t length = (size_t)check_answer(check)->output_length, count = 0, record_length = 0;
    char *text = checking_text(check, 0, length), *at = text;
    enum store_answer answer = STORE_BUSY;
    bool good = text && sscanf(text, "%zu %zu", &count, &record_length) == 2 && count > 0;
    struct store_member *members = good ? calloc(count, sizeof *members) : NULL;
    char *line = members ? take_line(&at) : NULL;
    size_t total = record_length;
    for (size_t n = 0; line && n < count; n++) {
        line = take_line(&at);
        char *space = line ? strchr(line, ' ') : NULL;
        if (space) {
            *space = '\0';
            members[n].digest = line;
            members[n].request_length = strtoull(space + 1, NULL, 10);
            total += members[n].request_length;
        } else {
            line = NULL;
        }
    }
    line = line ? take_line(&at) : NULL;
    if (line && !*line && total == length - (size_t)(at - text)) {
        for (size_t n = 0; n < count; n++) {
            members[n].request = at;
            at += members[n].request_length;
        }
        struct store_family family = {.parent = *submission, .members = members, .count = count};
        family.parent.request = at;
        family.parent.request_length = record_length;
        family.parent.total = (int64_t)count;
        answer = store_submit_family(call->services->store, &family, receipt);
    }
    free(members);
    free(text);
    return answer;
}

/* ------------------------------------------------------------------ plies */

/* The drapes of a laminate and its record. */
struct stack {
    char *record; /* zero-terminated */
    size_t length;
    struct store_page members;
};

static void stack_clear(struct stack *stack) {
    free(stack->record);
    store_page_clear(&stack->members);
}

/* The laminate of that record, which it takes over; NULL: STORE_EMPTY. To be cleared in any case.
 */
static enum store_answer stack_get(struct store *store, const char *id, char *record, size_t length,
                                   struct stack *stack) {
    *stack = (struct stack){.record = record, .length = length};
    return record ? store_members(store, id, &stack->members) : STORE_EMPTY;
}

static const struct store_job *member_of(const struct stack *stack, size_t part) {
    for (size_t k = 0; k < stack->members.count; k++)
        if (stack->members.jobs[k].position == (int64_t)part)
            return &stack->members.jobs[k];
    return NULL;
}

/* A ply, or a piece of one, as its line says. */
struct ply_line {
    size_t part;       /* its drape */
    const char *name;  /* "": a further piece of the ply before it */
    const char *piece; /* NULL: the ply is of one */
};

/* That whose line begins at `*at`; false after the last. */
static bool next_ply(char **at, struct ply_line *ply) {
    char *line = take_line(at), *end, *tab;
    if (!line || !*line)
        return false;
    tab = strchr(line, '\t');
    if (tab)
        *tab = '\0';
    ply->piece = tab ? tab + 1 : NULL;
    ply->part = strtoull(line, &end, 10);
    ply->name = *end ? end + 1 : end;
    return true;
}

/* What a status says of a ply, or a piece, beside its name. */
static void write_member_status(struct api_text *text, const struct store_job *member) {
    if (member) {
        api_text_key_string(text, "id", member->id);
        api_text_key_string(text, "status", store_status_name(member->status));
    }
    if (member && member->error) {
        api_text_key(text, "error");
        api_text_raw(text, member->error);
    }
    api_text_raw(text, "}");
}

char *laminates_status(struct store *store, const struct store_job *job) {
    struct stack stack = {0};
    struct arena *arena = arena_new((size_t)1 << 26);
    char *document = NULL, *record = NULL;
    size_t length = 0;
    enum store_answer answer = store_request(store, job->id, &record, &length);
    if (arena && answer == STORE_OK &&
        stack_get(store, job->id, record, length, &stack) == STORE_OK) {
        struct api_text text = api_text_growing(arena);
        char *at = stack.record;
        struct ply_line ply;
        bool pieces = false; /* those of a ply are being listed */
        api_text_raw(&text, "[");
        for (bool first = true; next_ply(&at, &ply); first = false) {
            bool further = ply.piece && !*ply.name;
            if (!further) {
                api_text_raw(&text, pieces ? "]}" : "");
                api_text_raw(&text, first ? "{" : ",{");
                api_text_key_string(&text, "name", ply.name);
            }
            pieces = ply.piece;
            if (pieces && !further)
                api_text_key(&text, "pieces");
            if (pieces) {
                api_text_raw(&text, further ? ",{" : "[{");
                api_text_key_string(&text, "name", ply.piece);
            }
            write_member_status(&text, member_of(&stack, ply.part));
        }
        api_text_raw(&text, pieces ? "]}]" : "]");
        const char *plies = api_text_finish(&text);
        document = plies ? documents_status(job, plies) : NULL;
    } else {
        struct store_job shown = *job; /* what it consisted of has been removed */
        shown.altered = job->altered || answer == STORE_ALTERED;
        document = documents_status(&shown, NULL);
    }
    stack_clear(&stack);
    arena_free(arena);
    return document;
}

enum http_next laminates_request(struct call *call) {
    struct store_job job = {0};
    size_t length = 0;
    char *bytes = call_find_job(call, &job) ? call_stored_request(call, job.id, &length) : NULL;
    const char *gap = bytes ? memmem(bytes, length, "\n\n", 2) : NULL;
    if (gap)
        reply_text(call->reply, 200, "application/json",
                   strndup(gap + 2, length - (size_t)(gap + 2 - bytes)));
    else if (bytes)
        call_request_failed(call, STORE_EMPTY);
    free(bytes);
    store_job_clear(&job);
    return HTTP_DONE;
}

/* ------------------------------------------------------------------ the map */

/* The results of the drapes, in their order; length 0 where there is none. */
struct results {
    size_t count;
    struct stored_result result[];
};

/* As `laminate_map_record` reads them, on a thread of the pool. */
static bool write_results(void *context, int file) {
    struct results *results = context;
    uint64_t head = results->count;
    bool good = spool_write(file, &head, sizeof head);
    for (size_t n = 0; good && n < results->count; n++) {
        head = (uint64_t)results->result[n].result.length;
        good = spool_write(file, &head, sizeof head);
    }
    for (size_t n = 0; good && n < results->count; n++)
        good = stored_result_copy(&results->result[n], file);
    return good;
}

/* The results, and how many plies there are. NULL without memory or any result. */
static struct results *find_results(struct store *store, const struct stack *stack, size_t *plies,
                                    size_t *length) {
    char *copy = strdup(stack->record), *at = copy;
    struct ply_line ply;
    size_t count = 0;
    bool any = false;
    for (*plies = 0; copy && next_ply(&at, &ply); *plies += !ply.piece || *ply.name)
        count = ply.part + 1 > count ? ply.part + 1 : count;
    free(copy);
    struct results *results =
        count ? calloc(1, sizeof *results + count * sizeof results->result[0]) : NULL;
    if (!results)
        return NULL;
    results->count = count;
    *length = (1 + count) * sizeof(uint64_t);
    for (size_t n = 0; n < count; n++) {
        const struct store_job *member = member_of(stack, n);
        struct stored_result *own = &results->result[n];
        own->store = store;
        if (!member || member->status != STORE_SUCCEEDED ||
            store_result_find(store, member->id, &own->result) != STORE_OK)
            own->result.length = 0;
        any = any || own->result.length > 0;
        *length += (size_t)own->result.length;
    }
    if (any)
        return results;
    free(results);
    return NULL;
}

bool laminates_take_columns(struct call *call, struct document_pool_order *order, char **record) {
    struct store *store = call->services->store;
    struct store_job job = {0};
    struct stack stack = {0};
    struct results *results = NULL;
    size_t plies = 0, length = 0;
    *record = NULL;
    char *bytes = NULL;
    if (call_find_job(call, &job) && results_ready(call, &job))
        bytes = call_stored_request(call, job.id, &length);
    if (bytes) {
        enum store_answer answer = stack_get(store, job.id, bytes, length, &stack);
        if (answer == STORE_OK)
            results = find_results(store, &stack, &plies, &length);
        if (answer != STORE_OK)
            call_request_failed(call, answer);
        else if (!results)
            reply_refuse(call->reply, API_GONE, "no ply of the laminate has a result");
    }
    if (results) {
        order->kind = CHECKER_STACK;
        order->variant = plies;
        order->columns = (struct document_pool_columns){write_results, free, results, length};
        order->document[CHECKER_SECOND] = *record = stack.record;
        order->length[CHECKER_SECOND] = stack.length;
        stack.record = NULL;
    }
    stack_clear(&stack);
    store_job_clear(&job);
    return results != NULL;
}

/* ------------------------------------------------------------------ patterns */

/* `ply` from 1, or 0 for all of them. */
static enum http_next reply_patterns(struct call *call, enum format_use use, uint64_t ply) {
    struct call_choice choice;
    if (!call_choose(call, use, &choice))
        return HTTP_DONE;
    if (!call->request->state) {
        struct document_pool_order order = checking_order(call, CHECKER_PATTERNS);
        char *record;
        if (!laminates_take_columns(call, &order, &record))
            return HTTP_DONE;
        if (ply > order.variant) {
            free(record);
            free(order.columns.context);
            return call_not_found(call, "ply");
        }
        order.kind = CHECKER_PATTERNS;
        order.format = choice.format->name;
        order.variant = ply;
        if (!maps_begin(call, &order, record))
            return HTTP_DONE;
    }
    return maps_answer(call, choice.format, NULL);
}

enum http_next laminates_patterns(struct call *call) {
    return reply_patterns(call, FORMAT_PATTERN, 0);
}

enum http_next laminates_laser(struct call *call) {
    return reply_patterns(call, FORMAT_LASER, 0);
}

enum http_next laminates_bundle(struct call *call) {
    return reply_patterns(call, FORMAT_BUNDLE, 0);
}

enum http_next laminates_report(struct call *call) {
    return reply_patterns(call, FORMAT_BOOK, 0);
}

enum http_next laminates_pattern(struct call *call) {
    int64_t k = 0;
    if (!request_parse_int(call->request->segments[PLY_SEGMENT], 0, INT32_MAX - 1, &k))
        return call_not_found(call, "ply");
    return reply_patterns(call, FORMAT_PATTERN, (uint64_t)k + 1);
}
