/* SPDX-License-Identifier: MIT */
/*
 * drape-import: STEP and IGES files as surfaces that draped takes. The file is read by a child
 * process that is locked in (`server/work/sandbox.h`) and bounded in memory and time, so that no
 * file can do more than fail. Exit status: 0, 1 when the file cannot be imported (why is on
 * stderr), 2 when the command line is wrong. `drape-import checker` is the same as a child of the
 * daemon.
 */
#include "api/files/files.h"
#include "api/run.h"
#include "cli/files.h"
#include "import.h"
#include "server/work/checker.h"
#include "server/work/sandbox.h"
#include "server/work/worker.h"
#include "solver/surface/nurbs.h"
#include <errno.h>
#include <getopt.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

_Static_assert((int)IMPORT_DEGREE_MAX == (int)NURBS_DEGREE_MAX &&
                   (int)IMPORT_SIZE_MAX == (int)NURBS_SIZE_MAX,
               "the solver takes what is imported");

enum { EXIT_USAGE = 2, FACES_CHOSEN_MAX = 65535, NUMBER_MAX = 100000000 };

static const char help[] =
    "Usage: drape-import [OPTION]... PART.step|PART.iges\n"
    "Writes the faces of a CAD file as a surface for draped and drape: exact NURBS with\n"
    "their trims, in the file's own unit, as JSON. What was healed or left out is\n"
    "reported on standard error.\n"
    "\n"
    "  --faces LIST       only these faces: 3,4,10-17, by their numbers in the file\n"
    "  --list             write what the file holds, in place of the surface: number,\n"
    "                     area, box, centre, normal, kind and name of each face\n"
    "  --format FORMAT    step or iges; default: by the name, else by the content\n"
    "  --unit UNIT        of a file that states none: m, mm, cm, um, in, ft; default: mm\n"
    "  --memory MIB       the most that reading may take; default: 4096\n"
    "  --time SECONDS     the most processor time that reading may take; default: 300\n"
    "  -o, --output FILE  where to write; default: standard output. The file appears\n"
    "                     when it is complete, or not at all\n"
    "  -h, --help         this text\n"
    "  --version          the version\n"
    "\n"
    "Exit status: 0; 1 when the file cannot be imported, with the reason on standard\n"
    "error; 2 when the command line is wrong.\n";

struct arguments {
    const char *input, *output; /* NULL: standard output */
    const char *format;         /* NULL: not given */
    const char *unit;
    int *faces;
    size_t face_count;
    long memory_mib, seconds;
    bool list;
};

/* ---- the command line ---- */

static int compare_faces(const void *a, const void *b) {
    int x = *(const int *)a, y = *(const int *)b;
    return (x > y) - (x < y);
}

/* A number of digits alone, which `*at` is then behind. */
static bool take_digits(const char **at, long *number) {
    char *end;
    if (**at < '0' || **at > '9')
        return false;
    *number = strtol(*at, &end, 10);
    *at = end;
    return *number <= NUMBER_MAX;
}

/* "3,4,10-17": sorted, each once. */
static bool take_faces(struct arguments *arguments, const char *list) {
    size_t count = 0, kept = 0;
    int *faces = arguments->faces =
        arguments->faces ? arguments->faces : malloc(FACES_CHOSEN_MAX * sizeof *arguments->faces);
    for (const char *at = list; faces; at++) {
        long from, to;
        if (!take_digits(&at, &from))
            return false;
        to = from;
        if ((*at == '-' && (at++, !take_digits(&at, &to))) || from > to)
            return false;
        for (; from <= to; from++) {
            if (count == FACES_CHOSEN_MAX)
                return false;
            faces[count++] = (int)from;
        }
        if (*at == '\0')
            break;
        if (*at != ',')
            return false;
    }
    if (!faces)
        return false;
    qsort(faces, count, sizeof *faces, compare_faces);
    for (size_t k = 0; k < count; k++)
        if (kept == 0 || faces[k] != faces[kept - 1])
            faces[kept++] = faces[k];
    arguments->face_count = kept;
    return true;
}

static const struct option option_table[] = {
    {"faces", required_argument, NULL, 0}, {"format", required_argument, NULL, 0},
    {"unit", required_argument, NULL, 0},  {"memory", required_argument, NULL, 0},
    {"time", required_argument, NULL, 0},  {"output", required_argument, NULL, 'o'},
    {"list", no_argument, NULL, 'l'},      {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'v'},   {0},
};

/* Fills `arguments`; -1, or the exit status when there is nothing to do. */
static int parse_arguments(int argc, char **argv, struct arguments *arguments) {
    int option, index = 0;
    while ((option = getopt_long(argc, argv, "ho:", option_table, &index)) != -1) {
        const char *name = option == 'o' ? "output" : option_table[index].name, *value = optarg;
        bool good = true;
        if (option == 'h')
            return fputs(help, stdout) < 0 || fflush(stdout) != 0;
        if (option == 'v')
            return puts("drape-import " DRAPE_VERSION) < 0;
        if (option == '?')
            return EXIT_USAGE;
        if (option == 'l') {
            arguments->list = true;
        } else if (strcmp(name, "faces") == 0) {
            good = take_faces(arguments, value);
        } else if (strcmp(name, "unit") == 0) {
            arguments->unit = value;
            good = file_unit_known(value);
        } else if (strcmp(name, "format") == 0) {
            arguments->format = value;
            good = strcmp(value, "step") == 0 || strcmp(value, "iges") == 0;
        } else if (strcmp(name, "memory") == 0 || strcmp(name, "time") == 0) {
            long *number = *name == 'm' ? &arguments->memory_mib : &arguments->seconds;
            good = take_digits(&value, number) && *value == '\0' && *number > 0;
        } else {
            arguments->output = strcmp(value, "-") == 0 ? NULL : value;
        }
        if (!good) {
            fprintf(stderr, "drape-import: --%s does not take \"%s\"\n", name, optarg);
            return EXIT_USAGE;
        }
    }
    if (argc - optind != 1) {
        files_complain(argc > optind ? argv[optind + 1] : "no file",
                       argc > optind ? "one file at a time" : "--help says how to give one");
        return EXIT_USAGE;
    }
    arguments->input = argv[optind];
    return -1;
}

/* ---- the child that reads the file ---- */

/* What goes over the socket: whether it is the document, and then that or the reason why not. */
static bool send_whole(int fd, const char *bytes, size_t length) {
    while (length > 0) {
        ssize_t written = write(fd, bytes, length);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return false;
        bytes += written;
        length -= (size_t)written;
    }
    return true;
}

/* Reads the file in a child; `text` gets the document. */
static bool import_apart(const struct arguments *arguments, const struct import_order *order,
                         struct files_bytes *text) {
    const rlim_t seconds = (rlim_t)arguments->seconds, bytes = (rlim_t)arguments->memory_mib << 20;
    int ends[2], status = 0;
    if (pipe(ends) != 0) {
        files_complain("cannot start", strerror(errno));
        return false;
    }
    pid_t child = fork();
    if (child == 0) {
        struct import_answer answer;
        import_prepare();
        setrlimit(RLIMIT_CPU, &(const struct rlimit){seconds, seconds});
        if (!SANDBOX_SANITIZED)
            setrlimit(RLIMIT_AS, &(const struct rlimit){bytes, bytes});
        if (dup2(ends[1], WORKER_FD) < 0 || !sandbox_enter(WORKER_FD, 0))
            _exit(EXIT_FAILURE);
        bool read = import_cad(order, &answer);
        const char *words = read ? answer.text : answer.why;
        bool sent = send_whole(WORKER_FD, read ? "+" : "-", 1) &&
                    send_whole(WORKER_FD, words, read ? answer.length : strlen(words));
        _exit(sent ? EXIT_SUCCESS : EXIT_FAILURE);
    }
    close(ends[1]);
    FILE *stream = child > 0 ? fdopen(ends[0], "rb") : NULL;
    bool good = stream && files_drain(stream, text);
    if (stream)
        fclose(stream);
    while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR)
        continue;
    if (!good || status != 0 || text->length == 0) {
        char why[128] = "the reader ended before it was done";
        int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
        if (signal == SIGXCPU || signal == SIGKILL)
            snprintf(why, sizeof why, "takes longer to read than --time allows, %ld s",
                     arguments->seconds);
        else if (signal)
            snprintf(why, sizeof why, "crashed the reader (%s)", sigdescr_np(signal));
        files_complain(arguments->input, why);
        return false;
    }
    if (text->data[0] == '+')
        return true;
    fprintf(stderr, "drape-import: %s: %.*s\n", arguments->input, (int)text->length - 1,
            text->data + 1);
    return false;
}

static bool import_named_file(const struct arguments *arguments) {
    static const char key[] = "\"notes\":[\"";
    struct files_bytes file = {0}, text = {0};
    struct files_output output = {0};
    bool ok = files_read(arguments->input, &file) && files_open(&output, arguments->output);
    /* The format by the file's name, else by its first line. */
    const char *format = arguments->format, *dot = strrchr(arguments->input, '.');
    bool iges = dot && (strcasecmp(dot, ".igs") == 0 || strcasecmp(dot, ".iges") == 0);
    bool step = dot && (strcasecmp(dot, ".stp") == 0 || strcasecmp(dot, ".step") == 0);
    if (!format)
        format = iges || (!step && file.length > 80 && file.data[72] == 'S') ? "iges" : "step";
    const struct import_order order = {.format = format,
                                       .bytes = file.data ? file.data : "",
                                       .length = file.length,
                                       .unit = arguments->unit,
                                       .faces = arguments->faces,
                                       .face_count = arguments->face_count,
                                       .list = arguments->list};
    ok = ok && import_apart(arguments, &order, &text);
    const char *notes = ok ? memmem(text.data, text.length, key, sizeof key - 1) : NULL;
    const char *end = ok ? text.data + text.length : NULL;
    if (ok)
        ok = fwrite(text.data + 1, 1, text.length - 1, output.stream) == text.length - 1;
    /* The notes of the document, a line each, for whoever runs this by hand. */
    for (const char *at = notes ? notes + sizeof key - 1 : end; at < end;) {
        fprintf(stderr, "drape-import: %s: ", arguments->input);
        for (; at < end && *at != '"'; at++) {
            at += *at == '\\' && at + 1 < end;
            fputc(*at, stderr);
        }
        fputc('\n', stderr);
        at = end - at < 3 || at[1] != ',' ? end : at + 3;
    }
    ok = files_close(&output, ok);
    free(file.data);
    free(text.data);
    return ok;
}

/* ---- as a child of the daemon ---- */

static char *import_body(const char *body, size_t length, const char *format, const char *unit,
                         size_t *text_length, char why[API_DETAIL_MAX]) {
    const struct import_order order = {
        .format = format, .bytes = body, .length = length, .unit = unit};
    struct import_answer answer;
    if (!import_cad(&order, &answer)) {
        snprintf(why, API_DETAIL_MAX, "%s", answer.why);
        return NULL;
    }
    *text_length = answer.length;
    return answer.text;
}

int main(int argc, char **argv) {
    static const struct checker_abilities abilities = {.import = import_body};
    if (argc == 2 && strcmp(argv[1], CHECKER_ARGUMENT) == 0) {
        import_prepare();
        return checker_serve(&abilities);
    }
    struct arguments arguments = {.unit = "", .memory_mib = 4096, .seconds = 300};
    int status = parse_arguments(argc, argv, &arguments);
    if (status < 0) {
        files_watch_signals();
        status = import_named_file(&arguments) ? EXIT_SUCCESS : EXIT_FAILURE;
    }
    free(arguments.faces);
    return status;
}
