/* SPDX-License-Identifier: MIT */
/* libdrape's interface (`drape.h`) over `api/run.h`, its formats and maps. */
#include "drape.h"

#include "api/files/files.h"
#include "api/format/format.h"
#include "api/map/cavity.h"
#include "api/map/map.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/result/columns.h"
#include "api/run.h"
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { OPTIONS_SIZE = 4096 }; /* bytes of all options */

struct drape {
    struct api_input input; /* its request is the drape's own copy */
    struct api_limits limits;
    char id[API_ID_SIZE];
    char *container; /* the stored result (`columns.h`) */
    size_t length, capacity;
    struct api_columns columns;
    double *values[API_COLUMNS_MAX]; /* of columns that have been asked for */
    char *summary;                   /* once asked for */
    bool failed;                     /* the run: there is no result */
    struct api_problem problem;      /* of the last call */
    char *problem_text;
};

/* ---- the process ---- */

static pthread_once_t once = PTHREAD_ONCE_INIT;
static bool prepared;

static void prepare_once(void) {
    prepared = api_prepare();
}

const char *drape_version(void) {
    return DRAPE_VERSION;
}

/* ---- problems ---- */

/* Begins a call: what the last one had to say is gone, but for what the run failed of. */
static bool begin_call(struct drape *drape) {
    if (drape->failed)
        return false;
    free(drape->problem_text);
    drape->problem_text = NULL;
    drape->problem = (struct api_problem){0};
    return true;
}

/* Ends a call; whether nothing was wrong. */
static bool end(struct drape *drape) {
    if (drape->problem.id != API_OK)
        drape->problem_text = api_problem_json(&drape->problem, NULL);
    return drape->problem.id == API_OK;
}

const char *drape_problem(const struct drape *drape) {
    if (drape->problem.id == API_OK)
        return NULL;
    return drape->problem_text
               ? drape->problem_text
               : "{\"type\":\"/problems/out-of-memory\",\"title\":\"The drape needs "
                 "more memory than allowed\",\"status\":500,"
                 "\"detail\":\"no memory for the problem\"}";
}

/* What there is, for a problem's detail: a name more, or dots once there is no room. */
enum { KNOWN_SIZE = API_DETAIL_MAX - 64 };
static void list(char known[KNOWN_SIZE], const char *name) {
    size_t used = strlen(known);
    if (used + strlen(name) + sizeof "  ..." < KNOWN_SIZE)
        sprintf(known + used, " %s", name);
    else if (strcmp(known + used - 3, "...") != 0)
        strcpy(known + used, " ...");
}

/* ---- options ---- */

/* Calls `set` for each NAME=VALUE of the options, in `text` of OPTIONS_SIZE, which the values then
 * lie in. Where it returns false without a problem the option is not known. */
static bool each_option(const char *options, char *text,
                        bool (*set)(void *context, const char *name, const char *value,
                                    struct api_problem *problem),
                        void *context, struct api_problem *problem) {
    char *rest = text, *name;
    if (!options)
        return true;
    if (strlen(options) >= OPTIONS_SIZE)
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "the options must have less than %d characters", OPTIONS_SIZE);
    strcpy(text, options);
    while ((name = strsep(&rest, "&"))) {
        char *value = strchr(name, '=');
        if (!*name)
            continue;
        if (!value)
            return !api_problem_set(problem, API_INVALID_REQUEST,
                                    "%.64s must be followed by =", name);
        *value++ = '\0';
        if (!set(context, name, value, problem))
            return !api_problem_set(problem, API_INVALID_REQUEST, "%.64s is no option here", name);
    }
    return true;
}

/* A whole number from 1 to `most`. */
static bool read_option_count(const char *name, const char *value, unsigned long long most,
                              size_t *count, struct api_problem *problem) {
    char *behind;
    unsigned long long number = strtoull(value, &behind, 10);
    if (*value < '0' || *value > '9' || *behind || number < 1 || number > most)
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "%s must be a whole number from 1 to %llu", name, most);
    *count = (size_t)number;
    return true;
}

/* Of the run, for a struct api_limits. */
static bool set_limit(void *context, const char *name, const char *value,
                      struct api_problem *problem) {
    struct api_limits *limits = context;
    size_t threads = (size_t)limits->threads;
    bool good = strcmp(name, "max_nodes") == 0
                    ? read_option_count(name, value, 1000000000, &limits->max_nodes, problem)
                : strcmp(name, "max_memory") == 0
                    ? read_option_count(name, value, SIZE_MAX / 2, &limits->max_memory, problem)
                    : strcmp(name, "threads") == 0 &&
                          read_option_count(name, value, 1024, &threads, problem);
    limits->threads = (int)threads;
    return good;
}

/* What a document is to look like, and of a map what is said of its mesh. */
struct wish {
    struct format_options options;
    struct map_target *target; /* NULL: it is no map */
    struct arena *arena;
};

/* The same of a document. */
static bool set_wish(void *context, const char *name, const char *value,
                     struct api_problem *problem) {
    struct wish *wish = context;
    return format_option(&wish->options, name, value, problem) ||
           (problem->id == API_OK && wish->target &&
            map_target_option(wish->target, name, value, wish->arena, problem));
}

/* ---- the run ---- */

/* Appends to the container, which grows by doubling. */
static bool keep(void *context, const void *bytes, size_t length) {
    struct drape *drape = context;
    if (length > drape->capacity - drape->length) {
        size_t capacity = 2 * drape->capacity + length;
        char *grown = realloc(drape->container, capacity);
        if (!grown)
            return !api_problem_no_memory(&drape->problem, "the result");
        drape->container = grown;
        drape->capacity = capacity;
    }
    memcpy(drape->container + drape->length, bytes, length);
    drape->length += length;
    return true;
}

struct caller {
    drape_progress *progress;
    void *context;
};

static bool ask_caller(void *context, double fraction) {
    const struct caller *caller = context;
    return caller->progress(caller->context, fraction) == 0;
}

/* The id that the service would know the result by. */
static bool identify(struct drape *drape) {
    static const char what[] = "the request";
    struct api_request request;
    struct arena *arena = arena_new(drape->limits.max_memory);
    if (!arena)
        return !api_problem_no_memory(&drape->problem, what);
    bool good =
        api_decode(&drape->input, &drape->limits, arena, &request, &drape->problem) == API_OK &&
        (api_digest_request(&request, arena, drape->id) ||
         !api_problem_no_memory(&drape->problem, what));
    arena_free(arena);
    return good;
}

static struct api_reader reader_of(const struct drape *drape, struct api_memory *memory) {
    *memory = (struct api_memory){drape->container, drape->length};
    return api_reader_of(memory);
}

static bool run_for_caller(struct drape *drape, const char *options, struct caller *caller) {
    char text[OPTIONS_SIZE];
    struct api_memory memory;
    const struct drape_monitor monitor = {ask_caller, caller};
    const struct api_sink sink = {.write = keep, .context = drape};
    pthread_once(&once, prepare_once);
    if (!prepared)
        return !api_problem_set(&drape->problem, API_INTERNAL,
                                "the system gives no random numbers");
    if (!each_option(options, text, set_limit, &drape->limits, &drape->problem) ||
        !identify(drape) ||
        api_run(&drape->input, &drape->limits, caller->progress ? &monitor : NULL, &sink,
                &drape->problem) != API_OK)
        return false;
    const struct api_reader reader = reader_of(drape, &memory);
    return api_columns_open(&reader, &drape->columns, &drape->problem) == API_OK;
}

struct drape *drape_run(const char *request, size_t length, const char *options,
                        drape_progress *progress, void *context) {
    struct drape *drape = calloc(1, sizeof *drape);
    char *copy = malloc(length + 1);
    if (!drape || !copy) {
        free(drape);
        free(copy);
        return NULL;
    }
    if (length)
        memcpy(copy, request, length);
    drape->limits = api_limits_default;
    drape->input = (struct api_input){.request = copy, .request_length = length};
    (void)run_for_caller(drape, options, &(struct caller){progress, context});
    drape->failed = !end(drape);
    return drape;
}

void drape_free(struct drape *drape) {
    if (!drape)
        return;
    for (size_t k = 0; k < API_COLUMNS_MAX; k++)
        free(drape->values[k]);
    free((void *)(uintptr_t)drape->input.request);
    free(drape->container);
    free(drape->summary);
    free(drape->problem_text);
    free(drape);
}

/* ---- the result ---- */

const char *drape_summary(struct drape *drape) {
    if (!begin_call(drape))
        return NULL;
    if (!drape->summary)
        drape->summary = api_columns_summary_json(&drape->columns);
    if (!drape->summary)
        api_problem_no_memory(&drape->problem, "the summary");
    return end(drape) ? drape->summary : NULL;
}

/* The number of the column "TABLE.NAME"; that of columns, with the problem set, when there is
 * none. */
static size_t find_column(struct drape *drape, const char *name) {
    const struct api_columns *columns = &drape->columns;
    char known[KNOWN_SIZE] = "";
    size_t k = 0, table = strcspn(name, ".");
    for (; k < columns->count; k++) {
        char full[2 * API_COLUMN_NAME_SIZE];
        snprintf(full, sizeof full, "%s.%s", api_table_name(columns->column[k].table),
                 columns->column[k].name);
        if (strcmp(full, name) == 0)
            return k;
        if (strncmp(full, name, table + 1) == 0) /* of its table; else of all */
            list(known, full);
    }
    bool tables = !*known;
    for (size_t c = 0; c < columns->count && tables; c++)
        if (c == 0 || columns->column[c].table != columns->column[c - 1].table)
            list(known, api_table_name(columns->column[c].table));
    api_problem_set(&drape->problem, API_INVALID_REQUEST, "no column %.32s; there are%s", name,
                    known);
    return k;
}

const double *drape_column(struct drape *drape, const char *name, size_t *count) {
    struct api_memory memory;
    if (count)
        *count = 0;
    if (!begin_call(drape))
        return NULL;
    size_t k = find_column(drape, name);
    const struct api_column *column = &drape->columns.column[k];
    if (k < drape->columns.count && !drape->values[k]) {
        const struct api_reader reader = reader_of(drape, &memory);
        double *values = calloc(column->rows + 1, sizeof *values);
        if (!values)
            api_problem_no_memory(&drape->problem, "the column");
        else if (!api_columns_read(&reader, column, 0, column->rows, values))
            api_problem_set(&drape->problem, API_DAMAGED, "the column cannot be read");
        drape->values[k] = values;
    }
    if (!end(drape))
        return NULL;
    if (count)
        *count = column->rows;
    return drape->values[k];
}

/* ---- documents ---- */

/* All of a document, with a 0 behind it; NULL with the problem set. */
static char *encode(struct drape *drape, const struct format *format, struct format_source source,
                    const struct format_options *options, size_t *length) {
    enum { PIECE = 1 << 16 };
    source.id = drape->id;
    struct encoder *encoder = encoder_new(format, &source, options, &drape->problem);
    char *document = NULL;
    size_t used = 0, capacity = 0;
    ssize_t more = encoder ? 1 : -1;
    while (more > 0) {
        if (capacity - used <= PIECE) {
            capacity = 2 * capacity + 2 * PIECE;
            char *grown = realloc(document, capacity);
            if (!grown) {
                api_problem_no_memory(&drape->problem, "the document");
                break;
            }
            document = grown;
        }
        more = encoder_read(encoder, document + used, PIECE);
        used += more > 0 ? (size_t)more : 0;
    }
    encoder_free(encoder);
    if (more < 0)
        api_problem_set(&drape->problem, API_DAMAGED, "the result cannot be read");
    if (drape->problem.id != API_OK) {
        free(document);
        return NULL;
    }
    document[used] = '\0';
    if (length)
        *length = used;
    return document;
}

/* The format of that name and of one of these uses, or NULL with the problem set, which names what
 * there is. */
static const struct format *find_format(const char *name, const enum format_use *uses, size_t count,
                                        struct api_problem *problem) {
    char known[KNOWN_SIZE] = "";
    for (size_t u = 0; u < count; u++) {
        const struct format *format = format_named(uses[u], name);
        if (format)
            return format;
        for (size_t k = 0; (format = format_at(uses[u], k)); k++)
            list(known, format->name);
    }
    api_problem_set(problem, API_NOT_ACCEPTABLE, "no format %.32s; there are%s", name, known);
    return NULL;
}

char *drape_document(struct drape *drape, const char *name, const char *options, size_t *length) {
    static const enum format_use uses[] = {FORMAT_RESULT, FORMAT_PATTERN};
    char text[OPTIONS_SIZE], *document = NULL;
    struct api_memory memory;
    struct wish wish = {0};
    if (!begin_call(drape))
        return NULL;
    const struct api_reader reader = reader_of(drape, &memory);
    const struct format *format =
        find_format(name, uses, sizeof uses / sizeof *uses, &drape->problem);
    if (format && each_option(options, text, set_wish, &wish, &drape->problem))
        document =
            encode(drape, format, (struct format_source){.reader = &reader}, &wish.options, length);
    return end(drape) ? document : NULL;
}

/* The mesh, by the name of its format. */
static bool read_mesh(const char *bytes, size_t length, const char *name, struct arena *arena,
                      struct map_target *target, struct api_problem *problem) {
    const struct file_format *format = file_format_named(name);
    if (strcmp(name, "json") == 0)
        return map_target_json(bytes, length, arena, target, problem) == API_OK;
    if (!format || format->cad)
        return !api_problem_set(problem, API_UNSUPPORTED_MEDIA_TYPE,
                                "no mesh is read from %.32s: json, or a mesh file's format", name);
    return file_read_target(format, bytes, length, arena, target, problem) == API_OK;
}

char *drape_map(struct drape *drape, const char *mesh, size_t mesh_length, const char *mesh_format,
                const char *name, const char *options, size_t *length) {
    static const enum format_use use = FORMAT_MAP;
    struct api_problem *problem = &drape->problem;
    char text[OPTIONS_SIZE], *document = NULL;
    struct api_memory memory;
    struct map_target target;
    if (!begin_call(drape))
        return NULL;
    const struct api_reader reader = reader_of(drape, &memory);
    const struct format *format = find_format(name, &use, 1, problem);
    struct arena *arena = arena_new(drape->limits.max_memory);
    struct api_map *map = arena ? arena_alloc(arena, 1, sizeof *map) : NULL;
    struct wish wish = {.target = &target, .arena = arena};
    if (!map)
        api_problem_no_memory(problem, "the map");
    bool good = map && format &&
                read_mesh(mesh, mesh_length, mesh_format, arena, &target, problem) &&
                each_option(options, text, set_wish, &wish, problem);
    if (good && !target.elements && format->elements)
        good = !api_problem_set(problem, API_NOT_ACCEPTABLE,
                                "%s needs elements, but the mesh has only points", format->name);
    target.wants_yarns = good && format->yarns;
    if (good &&
        cavity_take_cloth(&target, &reader, &drape->input, &drape->limits, arena, problem) &&
        api_map_make(&reader, &target, NULL, arena, map, problem) == API_OK) {
        document = encode(drape, format, (struct format_source){.fields = &map->fields},
                          &wish.options, length);
    }
    arena_free(arena);
    return end(drape) ? document : NULL;
}

void drape_free_document(char *document) {
    free(document);
}
