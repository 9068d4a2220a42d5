/* SPDX-License-Identifier: MIT */
/*
 * drape: the same solver without the daemon. Reads a request document, writes the result document;
 * progress on stderr when that is a terminal. Exit status: 0, 1 when the drape could not be done
 * (why is on stderr), 2 when the command line is wrong.
 */
#include "decode.h"
#include "digest.h"
#include "encode.h"
#include "run.h"
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { EXIT_USAGE = 2, COPY_SIZE = 1 << 16 };

static const char help[] =
    "Usage: drape [OPTION]... [REQUEST.json|-]\n"
    "Drapes a fabric over a surface: reads a drape request, writes the result.\n"
    "\n"
    "  --format FORMAT    json (default) or csv\n"
    "  -o, --output FILE  where to write; default: standard output\n"
    "  --fields LIST      only these columns: nodes.x,cells.shear_deg\n"
    "  --precision P      round numbers to P significant digits, 1..17\n"
    "  --table TABLE      for csv: nodes (default) or cells\n"
    "  --max-nodes N      refuse larger nets; default 4000000\n"
    "  --threads N        threads to solve with; default 1\n"
    "  --help             this text\n"
    "  --version          the solver's version\n";

struct arguments {
    const char *input, *output; /* NULL: standard input, standard output */
    const struct api_format *format;
    struct api_encode_options options;
    struct api_limits limits;
};

/* A growing buffer of the heap. */
struct bytes {
    char *data;
    size_t length, capacity;
};

static void complain(const char *what, const char *why) {
    fprintf(stderr, "drape: %s: %s\n", what, why);
}

static void print_problem(const struct api_problem *problem) {
    complain(api_problem_slug(problem->id), api_problem_title(problem->id));
    for (size_t i = 0; i < problem->count; i++) {
        const struct api_problem_place *place = &problem->place[i];
        bool named = problem->has_pointer && place->pointer[0];
        fprintf(stderr, "  %s%s%s\n", named ? place->pointer : "", named ? ": " : "",
                place->detail);
    }
}

/* ---- the command line ---- */

/* A whole number of at least 1 that fits in `most`. */
static bool parse_count(const char *text, long most, long *value) {
    char *end;
    errno = 0;
    *value = strtol(text, &end, 10);
    return errno == 0 && end != text && *end == '\0' && *value >= 1 && *value <= most;
}

/* One option with its value; false when the value is wrong. */
static bool take_option(struct arguments *arguments, const char *name, const char *value) {
    struct api_problem problem = {0};
    long count = 0;
    if (strcmp(name, "output") == 0) {
        arguments->output = strcmp(value, "-") == 0 ? NULL : value;
        return true;
    }
    if (strcmp(name, "format") == 0) {
        arguments->format = api_format_named(value);
        return arguments->format != NULL;
    }
    if (strcmp(name, "threads") == 0) {
        bool ok = parse_count(value, 1024, &count);
        arguments->limits.threads = (int)count;
        return ok;
    }
    if (strcmp(name, "max-nodes") == 0) {
        bool ok = parse_count(value, 1000000000, &count);
        arguments->limits.max_nodes = (size_t)count;
        return ok;
    }
    return api_encode_option(&arguments->options, name, value, &problem);
}

static const struct option option_table[] = {
    {"format", required_argument, NULL, 0},    {"output", required_argument, NULL, 'o'},
    {"fields", required_argument, NULL, 0},    {"precision", required_argument, NULL, 0},
    {"table", required_argument, NULL, 0},     {"threads", required_argument, NULL, 0},
    {"max-nodes", required_argument, NULL, 0}, {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'v'},       {0},
};

/* Fills `arguments`; -1, or the exit status when there is nothing to run. */
static int parse_arguments(int argc, char **argv, struct arguments *arguments) {
    int option, index = 0;
    while ((option = getopt_long(argc, argv, "o:", option_table, &index)) != -1) {
        const char *name = option == 'o' ? "output" : option_table[index].name;
        if (option == 'h')
            return fputs(help, stdout) < 0 ? EXIT_FAILURE : EXIT_SUCCESS;
        if (option == 'v')
            return puts("drape " DRAPE_SOLVER_VERSION) < 0 ? EXIT_FAILURE : EXIT_SUCCESS;
        if (option == '?')
            return EXIT_USAGE;
        if (!take_option(arguments, name, optarg)) {
            fprintf(stderr, "drape: --%s does not take \"%s\"\n", name, optarg);
            return EXIT_USAGE;
        }
    }
    if (argc - optind > 1) {
        complain(argv[optind + 1], "one request at a time");
        return EXIT_USAGE;
    }
    if (optind < argc && strcmp(argv[optind], "-") != 0)
        arguments->input = argv[optind];
    return -1;
}

/* ---- input ---- */

static bool grow(struct bytes *bytes) {
    size_t capacity = bytes->capacity ? 2 * bytes->capacity : COPY_SIZE;
    char *data = realloc(bytes->data, capacity);
    if (!data)
        return false;
    bytes->data = data;
    bytes->capacity = capacity;
    return true;
}

static bool read_stream(FILE *stream, struct bytes *bytes) {
    while (!feof(stream)) {
        if (bytes->length == bytes->capacity && !grow(bytes))
            return false;
        bytes->length +=
            fread(bytes->data + bytes->length, 1, bytes->capacity - bytes->length, stream);
        if (ferror(stream))
            return false;
    }
    return true;
}

static bool read_input(const char *path, struct bytes *bytes) {
    FILE *stream = path ? fopen(path, "rb") : stdin;
    bool ok = stream && read_stream(stream, bytes);
    if (!ok)
        complain(path ? path : "standard input", strerror(errno));
    if (stream && path)
        fclose(stream);
    return ok;
}

/* ---- solving into a temporary file ---- */

static bool show_progress(void *context, double fraction) {
    (void)context;
    fprintf(stderr, "\rdraping %3.0f %%", 100 * fraction);
    return true;
}

static bool write_container(void *context, const void *bytes, size_t length) {
    return fwrite(bytes, 1, length, context) == length;
}

static bool read_container(void *context, uint64_t offset, void *buffer, size_t length) {
    return fseeko(context, (off_t)offset, SEEK_SET) == 0 &&
           fread(buffer, 1, length, context) == length;
}

/* The id that the service would know the request's result by. */
static bool identify(const struct api_input *input, const struct api_limits *limits,
                     char id[API_ID_SIZE], struct api_problem *problem) {
    struct api_request request;
    struct arena *arena = arena_new(limits->max_memory);
    bool ok = arena && api_decode(input, limits, arena, &request, problem) == API_OK &&
              api_digest_request(&request, arena, id);
    if (!ok)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the request");
    arena_free(arena);
    return ok;
}

static bool solve(const struct bytes *request, const struct api_limits *limits, FILE *container,
                  char id[API_ID_SIZE], struct api_problem *problem) {
    const struct api_input input = {.request = request->data, .request_length = request->length};
    const struct api_sink sink = {write_container, container};
    const struct drape_monitor monitor = {show_progress, NULL};
    bool terminal = isatty(STDERR_FILENO);
    if (!identify(&input, limits, id, problem))
        return false;
    enum api_problem_id result =
        api_run(&input, limits, terminal ? &monitor : NULL, &sink, problem);
    if (terminal)
        fputs("\r\033[K", stderr);
    return result == API_OK;
}

/* ---- output ---- */

static bool copy_result(struct api_encoder *encoder, FILE *stream) {
    static char buffer[COPY_SIZE];
    ssize_t length;
    while ((length = api_encoder_read(encoder, buffer, sizeof buffer)) > 0)
        if (fwrite(buffer, 1, (size_t)length, stream) != (size_t)length)
            return false;
    return length == 0 && fflush(stream) == 0;
}

static bool write_output(const char *path, struct api_encoder *encoder) {
    FILE *stream = path ? fopen(path, "wb") : stdout;
    bool ok = stream && copy_result(encoder, stream);
    if (stream && path)
        ok = fclose(stream) == 0 && ok;
    if (!ok)
        complain(path ? path : "standard output", strerror(errno));
    return ok;
}

static bool drape(struct arguments *arguments, const struct bytes *request, FILE *container) {
    const struct api_reader reader = {read_container, container};
    struct api_problem problem = {0};
    struct api_encoder *encoder = NULL;
    char id[API_ID_SIZE];
    if (solve(request, &arguments->limits, container, id, &problem)) {
        arguments->options.id = id;
        encoder = api_encoder_new(arguments->format, &reader, &arguments->options, &problem);
    }
    bool ok = encoder && write_output(arguments->output, encoder);
    if (problem.id != API_OK)
        print_problem(&problem);
    api_encoder_free(encoder);
    return ok;
}

int main(int argc, char **argv) {
    struct arguments arguments = {.format = api_format_at(0), .limits = api_limits_default};
    struct bytes request = {0};
    int status = parse_arguments(argc, argv, &arguments);
    if (status >= 0)
        return status;
    FILE *container = tmpfile();
    if (!container || !api_prepare()) {
        complain("cannot start", container ? "no randomness" : strerror(errno));
        return EXIT_FAILURE;
    }
    bool ok = read_input(arguments.input, &request) && drape(&arguments, &request, container);
    fclose(container);
    free(request.data);
    return ok ? EXIT_SUCCESS : EXIT_FAILURE;
}
