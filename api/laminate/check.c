/* SPDX-License-Identifier: MIT */
#include "check.h"

#include "api/request/digest.h"
#include "api/request/prepared_form.h"
#include "map.h"
#include "patterns.h"
#include "run.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINE_SIZE = LAMINATE_NAME_MAX + 64 };

/* ---- checking ---- */

static bool sink_text(const struct api_sink *sink, const char *text) {
    return sink->write(sink->context, text, strlen(text));
}

/* The requests: first how long they are, then themselves, so that one is in memory at a time. */
static bool put_requests(const struct laminate *laminate, bool lengths, struct arena *arena,
                         const struct api_sink *sink) {
    bool good = true;
    for (size_t n = 0; good && n < laminate->net_count; n++) {
        struct arena_mark mark = arena_mark(arena);
        const char *request = laminate_request(laminate, n, arena);
        char line[LINE_SIZE];
        if (request && lengths)
            (void)snprintf(line, sizeof line, "%s %zu\n", laminate->net_digest[n], strlen(request));
        good = request && sink_text(sink, lengths ? line : request);
        arena_rewind(arena, mark);
    }
    return good;
}

static enum api_problem_id check_in(const struct api_input *input, const struct api_limits *limits,
                                    const struct api_sink *sink, struct arena *arena,
                                    struct api_check *check, struct api_problem *problem) {
    struct laminate laminate;
    char line[LINE_SIZE];
    if (laminate_decode(input, limits, arena, &laminate, problem) != API_OK)
        return problem->id;
    memcpy(check->surface, laminate.surface.id, sizeof check->surface);
    check->needs_surface = laminate.surface.kind == API_SURFACE_NAMED;
    if (check->needs_surface || laminate_resolve(&laminate, limits, arena, problem) != API_OK)
        return problem->id;
    if (!laminate.surface.form && !prepared_part_is_large(&laminate.surface))
        laminate.surface.form = prepared_form_make(&laminate.surface, arena);
    if (laminate_check_drapes(&laminate, limits, arena, problem) != API_OK)
        return problem->id;
    /* The record, as in the header. */
    struct api_text text = api_text_growing(arena);
    const char *document = laminate_normalise(&laminate, arena);
    for (size_t k = 0; k < laminate.count; k++) {
        const struct laminate_ply *ply = &laminate.plies[k];
        api_text_format(&text, "%zu %s", ply->net, ply->piece ? "" : ply->name);
        if (ply->pieces)
            api_text_format(&text, "\t%s", ply->pieces->pieces[ply->piece].name);
        api_text_raw(&text, "\n");
    }
    api_text_raw(&text, "\n");
    api_text_raw(&text, document ? document : "");
    const char *record = document ? api_text_finish(&text) : NULL;
    if (!record)
        return api_problem_no_memory(problem, "the laminate");
    memcpy(check->digest, laminate.revision, sizeof check->digest);
    (void)snprintf(line, sizeof line, "%zu %zu\n", laminate.net_count, strlen(record));
    bool good = sink_text(sink, line) && put_requests(&laminate, true, arena, sink) &&
                sink_text(sink, "\n") && put_requests(&laminate, false, arena, sink) &&
                sink_text(sink, record);
    return good ? API_OK : api_problem_no_memory(problem, "the laminate");
}

enum api_problem_id laminate_check(const struct api_input *input, const struct api_limits *limits,
                                   const struct api_sink *sink, struct api_check *check,
                                   struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    *check = (struct api_check){0};
    if (arena)
        (void)!check_in(input, limits, sink, arena, check, problem);
    else
        api_problem_no_memory(problem, "the laminate");
    arena_free(arena);
    return problem->id;
}

/* ---- mapping ---- */

/* A stored laminate and the readers of its results, NULL where there is none. */
static enum api_problem_id open_record(const char *record, size_t length, const char *columns,
                                       size_t columns_length, const struct api_limits *limits,
                                       struct arena *arena, struct laminate *laminate,
                                       const struct api_reader ***nets,
                                       struct api_problem *problem) {
    static const char gap[] = "\n\n";
    uint64_t lengths[1 + LAMINATE_PLIES_MAX] = {0};
    const char *document = memmem(record, length, gap, strlen(gap));
    if (!document)
        return api_problem_set(problem, API_INTERNAL, "the stored laminate is damaged");
    document += strlen(gap);
    const struct api_input input = {.request = document,
                                    .request_length = length - (size_t)(document - record)};
    if (laminate_decode(&input, limits, arena, laminate, problem) != API_OK ||
        laminate_resolve(laminate, limits, arena, problem) != API_OK)
        return problem->id;
    size_t count = laminate->net_count, at = (1 + count) * sizeof *lengths;
    struct api_memory *memory = arena_alloc(arena, count, sizeof *memory);
    struct api_reader *readers = arena_alloc(arena, count, sizeof *readers);
    *nets = arena_alloc(arena, count, sizeof **nets);
    if (!memory || !readers || !*nets)
        return api_problem_no_memory(problem, "the laminate");
    if (columns_length >= at)
        memcpy(lengths, columns, at);
    bool good = columns_length >= at && lengths[0] == count;
    for (size_t n = 0; good && n < count; n++) {
        uint64_t own = lengths[1 + n];
        good = own <= columns_length - at;
        memory[n] = (struct api_memory){columns + at, (size_t)own};
        readers[n] = api_reader_of(&memory[n]);
        (*nets)[n] = own ? &readers[n] : NULL;
        at += good ? (size_t)own : 0;
    }
    return good ? API_OK
                : api_problem_set(problem, API_INTERNAL,
                                  "the stored results of the laminate are damaged");
}

enum api_problem_id laminate_map_record(const char *record, size_t length, const char *columns,
                                        size_t columns_length, const struct api_limits *limits,
                                        const struct map_target *target,
                                        const struct drape_monitor *monitor, struct arena *arena,
                                        struct api_map *map, struct api_problem *problem) {
    const struct api_reader **nets;
    struct laminate laminate;
    if (open_record(record, length, columns, columns_length, limits, arena, &laminate, &nets,
                    problem) != API_OK)
        return problem->id;
    return laminate_map(&laminate, nets, target, monitor, arena, map, problem);
}

enum api_problem_id laminate_pattern_record(const char *record, size_t length, const char *columns,
                                            size_t columns_length, const struct api_limits *limits,
                                            int ply, const char *format, const char *options,
                                            size_t options_length, const struct api_sink *sink,
                                            struct arena *arena, struct api_problem *problem) {
    const struct api_reader **nets;
    struct laminate laminate;
    struct laminate_roll roll = {.width = 0};
    for (const char *at = options; at < options + options_length;) {
        const char *name = at, *value = name + strlen(name) + 1;
        at = value + strlen(value) + 1;
        if (!laminate_roll_option(&roll, name, value, problem) && problem->id != API_OK)
            return problem->id;
    }
    if (open_record(record, length, columns, columns_length, limits, arena, &laminate, &nets,
                    problem) != API_OK)
        return problem->id;
    return laminate_patterns(&laminate, nets, ply, format, &roll, sink, arena, problem);
}
