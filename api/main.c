/* SPDX-License-Identifier: MIT */
/*
 * drape: the same solver without the daemon. Reads a request document, writes the result document;
 * progress on stderr when that is a terminal. Exit status: 0, 1 when the drape could not be done
 * (why is on stderr), 2 when the command line is wrong.
 */
#include "decode.h"
#include "digest.h"
#include "encode.h"
#include "pattern.h"
#include "run.h"
#include <errno.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { EXIT_USAGE = 2, COPY_SIZE = 1 << 16 };

static const char help[] =
    "Usage: drape [OPTION]... [REQUEST.json|-]\n"
    "Drapes a fabric over a surface: reads a drape request (by default from standard\n"
    "input) and writes the result.\n"
    "\n"
    "  --format FORMAT    json (default), csv, vtp, glb or npz; or the flat cut pattern\n"
    "                     as svg or dxf\n"
    "  -o, --output FILE  where to write; default: standard output. The file appears\n"
    "                     when it is complete, or not at all\n"
    "  --fields LIST      only these columns: nodes.x,cells.shear_deg\n"
    "  --precision P      round numbers to P significant digits, 1..17\n"
    "  --table TABLE      for csv: nodes (default) or cells\n"
    "  --max-nodes N      refuse larger nets; default 4000000\n"
    "  --threads N        threads to solve with; default 1\n"
    "  -h, --help         this text\n"
    "  --version          the solver's version\n"
    "\n"
    "Exit status: 0; 1 when the drape could not be done, with the reason on standard\n"
    "error; 2 when the command line is wrong.\n";

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
        const char *pointer = place->pointer[0] ? place->pointer : "(the whole document)";
        fprintf(stderr, "  %s%s%s\n", problem->has_pointer ? pointer : "",
                problem->has_pointer ? ": " : "", place->detail);
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
        if (!arguments->format)
            arguments->format = api_pattern_named(value);
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
    while ((option = getopt_long(argc, argv, "ho:", option_table, &index)) != -1) {
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

/* Where the document goes: a stream, and for a regular file the temporary one beside it that takes
 * its place once it is complete. */
struct output {
    const char *name; /* for messages */
    FILE *stream;
    char *target, *temporary; /* NULL: the stream is the real one */
};

/* The temporary file of this process, for a signal that ends it. */
static char *volatile unfinished;

static void end_by_signal(int number) {
    if (unfinished)
        unlink(unfinished);
    raise(number); /* its default action is back */
}

static void watch_signals(void) {
    const int numbers[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    struct sigaction action = {.sa_handler = end_by_signal, .sa_flags = (int)SA_RESETHAND};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        sigaction(numbers[i], &action, NULL);
}

static mode_t mode_of_new_files(void) {
    mode_t mask = umask(0);
    umask(mask);
    return 0666 & ~mask;
}

/* A temporary file beside `target`, with the mode that the target will have. */
static bool open_temporary(struct output *output, mode_t mode) {
    if (!output->target || asprintf(&output->temporary, "%s.XXXXXX", output->target) < 0) {
        output->temporary = NULL;
        return false;
    }
    int file = mkstemp(output->temporary);
    if (file < 0) {
        free(output->temporary);
        output->temporary = NULL;
        return false;
    }
    unfinished = output->temporary;
    output->stream = fchmod(file, mode) == 0 ? fdopen(file, "wb") : NULL;
    if (!output->stream)
        close(file);
    return output->stream != NULL;
}

static bool open_output(struct output *output, const char *path) {
    struct stat old;
    bool exists = path && stat(path, &old) == 0, ok;
    *output = (struct output){.name = path ? path : "standard output"};
    if (!path) {
        output->stream = stdout;
        ok = true;
    } else if (exists && !S_ISREG(old.st_mode)) {
        output->stream = fopen(path, "wb");
        ok = output->stream != NULL;
    } else {
        output->target = exists ? realpath(path, NULL) : strdup(path);
        ok = (!exists || access(path, W_OK) == 0) &&
             open_temporary(output, exists ? old.st_mode & 0777 : mode_of_new_files());
    }
    if (!ok)
        complain(output->name, strerror(errno));
    return ok;
}

/* Closes it; with `ok` what was written takes its place, else nothing stays. */
static bool close_output(struct output *output, bool ok) {
    bool wanted = ok;
    if (output->stream)
        ok = (output->stream == stdout ? fflush(stdout) : fclose(output->stream)) == 0 && ok;
    if (output->temporary)
        ok = ok && rename(output->temporary, output->target) == 0;
    if (wanted && !ok)
        complain(output->name, strerror(errno));
    if (output->temporary && !ok)
        unlink(output->temporary);
    unfinished = NULL;
    free(output->temporary);
    free(output->target);
    return ok;
}

static bool write_document(struct api_encoder *encoder, const struct output *output) {
    static char buffer[COPY_SIZE];
    ssize_t length;
    while ((length = api_encoder_read(encoder, buffer, sizeof buffer)) > 0) {
        if (fwrite(buffer, 1, (size_t)length, output->stream) != (size_t)length) {
            complain(output->name, strerror(errno));
            return false;
        }
    }
    if (length < 0)
        complain(output->name, "the solved net could not be read back");
    return length == 0;
}

static bool drape(struct arguments *arguments, const struct bytes *request, FILE *container,
                  const struct output *output) {
    const struct api_reader reader = {read_container, container};
    struct api_problem problem = {0};
    struct api_encoder *encoder = NULL;
    char id[API_ID_SIZE];
    if (solve(request, &arguments->limits, container, id, &problem)) {
        arguments->options.id = id;
        encoder = api_encoder_new(arguments->format, &reader, &arguments->options, &problem);
    }
    bool ok = encoder && write_document(encoder, output);
    if (problem.id != API_OK)
        print_problem(&problem);
    api_encoder_free(encoder);
    return ok;
}

/* From the request to the document, once the command line is understood. */
static bool work(struct arguments *arguments) {
    struct bytes request = {0};
    struct output output = {0};
    FILE *container = tmpfile();
    if (!container || !api_prepare()) {
        complain("cannot start", container ? "no randomness" : strerror(errno));
        return false;
    }
    bool ok = read_input(arguments->input, &request) && open_output(&output, arguments->output) &&
              drape(arguments, &request, container, &output);
    ok = close_output(&output, ok);
    fclose(container);
    free(request.data);
    return ok;
}

int main(int argc, char **argv) {
    struct arguments arguments = {.format = api_format_at(0), .limits = api_limits_default};
    int status = parse_arguments(argc, argv, &arguments);
    if (status >= 0)
        return status;
    watch_signals();
    return work(&arguments) ? EXIT_SUCCESS : EXIT_FAILURE;
}
