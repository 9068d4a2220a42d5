/* SPDX-License-Identifier: MIT */
/*
 * drape: the same solver without the daemon. Reads a request document, writes the result document,
 * or the result's fields on a mesh; progress on stderr when that is a terminal. Exit status: 0, 1
 * when the drape could not be done (why is on stderr), 2 when the command line is wrong.
 */
#include "api/format/format.h"
#include "api/laminate/map.h"
#include "api/map/cavity.h"
#include "api/map/map.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/material.h"
#include "api/request/normalise.h"
#include "api/run.h"
#include "files.h"
#include "hold_out.h"
#include "laminate.h"
#include "material.h"
#include "part.h"
#include "study.h"
#include <errno.h>
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <time.h>
#include <unistd.h>

enum { EXIT_USAGE = 2 };

/* The formats stand between the two; the registry has them. */
static const char help_head[] =
    "Usage: drape [OPTION]... [REQUEST.json|-]\n"
    "Drapes a fabric over a surface: reads a drape request (by default from standard\n"
    "input) and writes the result, or the result's fields on a mesh. Its surface may\n"
    "be a file, {\"surface\": {\"file\": \"PART.step\"}}: STEP and IGES by drape-import,\n"
    "STL, OBJ, Nastran; faces are chosen as of a stored surface.\n"
    "\n"
    "Of a laminate, which has plies, each is draped; with --map the stack is written,\n"
    "as svg or dxf the patterns of all layers on a roll, as html the ply book, else\n"
    "what became of every ply.\n"
    "\n"
    "Of a study, which has a drape and what to vary of it, all variants are written\n"
    "(json, csv, npz) and the best of them shown as a table: on standard error when\n"
    "the document goes to standard output, else there.\n"
    "\n"
    "  --format FORMAT    default: json; the formats of\n";
static const char help_tail[] =
    "  --map MESH         write the fields on this mesh: Nastran bulk data, or points or\n"
    "                     triangles as JSON when the name ends in .json\n"
    "  --inlet LIST       elements of the inlet, for lcmsim: 17,18,pid:3, by the file's\n"
    "                     ids, by property, or by place: sphere:x:y:z:radius,\n"
    "                     line:x:y:z:x:y:z:distance\n"
    "  --outlet LIST      those of the outlet\n"
    "  --reference X,Y,Z  with --map: angles of plies run from this direction, projected\n"
    "                     on each element; default: from its first edge\n"
    "  --edge-channel W,K for lcmsim: elements within W of the rim of the cloth have the\n"
    "                     permeability K, in m^2 (race-tracking)\n"
    "  --cavity-height H  with --map: the height of the cavity, by property as\n"
    "                     pid:3:0.002,pid:4:0.003\n"
    "  --punch LIST       with --map: pid:7, elements that are the other side of the\n"
    "                     cavity; the rest of the mesh lies on the tool\n"
    "  --within D         nastran, abaqus: one group of stacks that differ by D degrees\n"
    "                     and D % of thickness at most; default: 0, no more than digits\n"
    "  --lcmsim-version N 2 or 3; default: 3\n"
    "  --at-most-fiber-volume-fraction F\n"
    "                     lcmsim: take denser elements to have this; otherwise those\n"
    "                     that are too dense to be filled are left out\n"
    "  -o, --output FILE  where to write; default: standard output. The file appears\n"
    "                     when it is complete, or not at all\n"
    "  --fields LIST      only these columns: nodes.x,cells.shear_deg; of a map: k1,k2\n"
    "  --precision P      round numbers to P significant digits, 1..17\n"
    "  --report           the same as --format html\n"
    "  --allowance L      svg, dxf, html: a second line L outside the cut, in the length\n"
    "                     unit\n"
    "  --part NAME        svg, dxf, html: for the title\n"
    "  --ply NAME         svg, dxf, html: for the title\n"
    "  --table TABLE      for csv: nodes (default) or cells; of a map cells or plies\n"
    "  --hold-one-out TABLE\n"
    "                     no drape: how well a table of permeabilities, alone or in a\n"
    "                     request, foretells each row and column from the others\n"
    "  --max-nodes N      refuse larger nets; default 4000000\n"
    "  --max-variants N   refuse larger studies; default 1000000\n"
    "  --variant K        of a study: write the drape request of variant K instead,\n"
    "                     or with \"best\" of the best of its first objective\n"
    "  --threads N        threads to solve with; default 1\n"
    "  --material FILE    a fabric of your own, which the request names as those of the\n"
    "                     library; may be given several times\n"
    "  --materials        the fabrics of the library\n"
    "  -h, --help         this text\n"
    "  --version          the solver's version\n"
    "\n"
    "Exit status: 0; 1 when the drape could not be done, with the reason on standard\n"
    "error; 2 when the command line is wrong.\n";

/* What is said of the mesh. */
enum { MESH_OPTIONS = 6 };
static const char *const mesh_options[MESH_OPTIONS] = {"inlet",     "outlet",        "edge-channel",
                                                       "reference", "cavity-height", "punch"};

struct arguments {
    const char *input, *output;     /* NULL: standard input, standard output */
    const char *map;                /* NULL: no mesh */
    const char *mesh[MESH_OPTIONS]; /* values of mesh_options; NULL: not given */
    const char *variant;            /* of a study: whose request is wanted; NULL: its result is */
    bool study;                     /* the request is one */
    struct material_files materials;
    const char *table; /* to hold values out of; NULL: a drape */
    const char *format_name;
    const struct format *format;
    struct format_options options;
    struct api_limits limits;
    char id[API_ID_SIZE]; /* that the service would know the result by */
};

static void print_problem(const struct api_problem *problem) {
    files_complain(api_problem_slug(problem->id), api_problem_title(problem->id));
    for (size_t i = 0; i < problem->count; i++) {
        const struct api_problem_place *place = &problem->place[i];
        const char *pointer = place->pointer[0] ? place->pointer : "(the whole document)";
        fprintf(stderr, "  %s%s%s\n", problem->has_pointer ? pointer : "",
                problem->has_pointer ? ": " : "", place->detail);
    }
}

/* ---- the command line ---- */

/* A title and the formats of a use, below each other as the help's other lines are. */
static void print_formats(const char *title, enum format_use use) {
    enum { WIDTH = 79, INDENT = 21 };
    const struct format *format;
    int column = printf("%*s%s", INDENT, "", title);
    for (size_t k = 0; (format = format_at(use, k)); k++) {
        if (column + (int)strlen(format->name) + 2 > WIDTH)
            column = printf("\n%*s", INDENT - 1, "") - 1;
        column += printf(" %s%s", format->name, format_at(use, k + 1) ? "," : "\n");
    }
}

static int print_help(void) {
    fputs(help_head, stdout);
    print_formats("a result:", FORMAT_RESULT);
    print_formats("its flat cut pattern:", FORMAT_PATTERN);
    print_formats("a report to print:", FORMAT_REPORT);
    print_formats("with --map, on a mesh:", FORMAT_MAP);
    fputs(help_tail, stdout);
    return fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* Each with the line that says what it is. */
static int print_materials(void) {
    const struct api_material *material;
    for (size_t k = 0; (material = api_material_at(k)); k++)
        printf("%-28s%s\n", material->name, material->about);
    return fflush(stdout) == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

/* A whole number of at least 1 that fits in `most`. */
static bool parse_count(const char *text, long most, long *value) {
    char *end;
    errno = 0;
    *value = strtol(text, &end, 10);
    return errno == 0 && end != text && *end == '\0' && *value >= 1 && *value <= most;
}

/* Flags have a dash where the service's parameters have a low line. */
static const char *parameter_of(const char *flag) {
    static char name[64];
    size_t length = strlen(flag);
    for (size_t k = 0; k <= length && k < sizeof name; k++)
        name[k] = flag[k] == '-' ? '_' : flag[k];
    return name;
}

static bool take_format_option(struct arguments *arguments, const char *flag, const char *value) {
    struct api_problem problem = {0};
    return format_option(&arguments->options, parameter_of(flag), value, &problem);
}

/* One option with its value; false when the value is wrong. */
static bool take_option(struct arguments *arguments, const char *name, const char *value) {
    const struct {
        const char *name, **text;
    } texts[] = {{"format", &arguments->format_name},    {"map", &arguments->map},
                 {mesh_options[0], &arguments->mesh[0]}, {mesh_options[1], &arguments->mesh[1]},
                 {mesh_options[2], &arguments->mesh[2]}, {mesh_options[3], &arguments->mesh[3]},
                 {mesh_options[4], &arguments->mesh[4]}, {mesh_options[5], &arguments->mesh[5]},
                 {"variant", &arguments->variant},       {"output", &arguments->output},
                 {"hold-one-out", &arguments->table}};
    long count = 0;
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        if (strcmp(name, texts[k].name) == 0) {
            *texts[k].text = value;
            return true;
        }
    }
    if (strcmp(name, "report") == 0) {
        arguments->format_name = "html";
        return true;
    }
    if (strcmp(name, "material") == 0) {
        struct material_files *files = &arguments->materials;
        if (files->count < MATERIAL_FILES_MAX)
            files->path[files->count] = value;
        return files->count++ < MATERIAL_FILES_MAX;
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
    if (strcmp(name, "max-variants") == 0) {
        bool ok = parse_count(value, 1000000000, &count);
        arguments->limits.max_variants = (size_t)count;
        return ok;
    }
    return take_format_option(arguments, name, value);
}

static const struct option option_table[] = {
    {"format", required_argument, NULL, 0},
    {"output", required_argument, NULL, 'o'},
    {"map", required_argument, NULL, 0},
    {"hold-one-out", required_argument, NULL, 0},
    {"inlet", required_argument, NULL, 0},
    {"outlet", required_argument, NULL, 0},
    {"reference", required_argument, NULL, 0},
    {"within", required_argument, NULL, 0},
    {"edge-channel", required_argument, NULL, 0},
    {"cavity-height", required_argument, NULL, 0},
    {"punch", required_argument, NULL, 0},
    {"lcmsim-version", required_argument, NULL, 0},
    {"at-most-fiber-volume-fraction", required_argument, NULL, 0},
    {"fields", required_argument, NULL, 0},
    {"allowance", required_argument, NULL, 0},
    {"report", no_argument, NULL, 0},
    {"part", required_argument, NULL, 0},
    {"ply", required_argument, NULL, 0},
    {"precision", required_argument, NULL, 0},
    {"table", required_argument, NULL, 0},
    {"threads", required_argument, NULL, 0},
    {"max-nodes", required_argument, NULL, 0},
    {"max-variants", required_argument, NULL, 0},
    {"variant", required_argument, NULL, 0},
    {"material", required_argument, NULL, 0},
    {"materials", no_argument, NULL, 'm'},
    {"help", no_argument, NULL, 'h'},
    {"version", no_argument, NULL, 'v'},
    {0},
};

/* The format, once it is known whether there is a mesh. */
static bool choose_format(struct arguments *arguments) {
    static const enum format_use uses[] = {FORMAT_RESULT, FORMAT_PATTERN, FORMAT_REPORT};
    const char *name = arguments->format_name ? arguments->format_name : "json";
    if (arguments->map)
        arguments->format = format_named(FORMAT_MAP, name);
    for (size_t k = 0; !arguments->map && !arguments->format && k < sizeof uses / sizeof *uses; k++)
        arguments->format = format_named(uses[k], name);
    if (arguments->format)
        return true;
    fprintf(stderr, "drape: --format does not take \"%s\"%s\n", name,
            arguments->map ? " with --map" : "");
    return false;
}

/* Fills `arguments`; -1, or the exit status when there is nothing to run. */
static int parse_arguments(int argc, char **argv, struct arguments *arguments) {
    int option, index = 0;
    while ((option = getopt_long(argc, argv, "ho:", option_table, &index)) != -1) {
        const char *name = option == 'o' ? "output" : option_table[index].name;
        if (option == 'h')
            return print_help();
        if (option == 'm')
            return print_materials();
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
        files_complain(argv[optind + 1], "one request at a time");
        return EXIT_USAGE;
    }
    if (optind < argc && strcmp(argv[optind], "-") != 0)
        arguments->input = argv[optind];
    if (arguments->output && strcmp(arguments->output, "-") == 0)
        arguments->output = NULL;
    for (int k = 0; k < MESH_OPTIONS; k++) {
        if (arguments->mesh[k] && !arguments->map) {
            fprintf(stderr, "drape: --%s: needs --map\n", mesh_options[k]);
            return EXIT_USAGE;
        }
    }
    return choose_format(arguments) ? -1 : EXIT_USAGE;
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

static bool solve(const struct arguments *arguments, const struct api_input *input, FILE *container,
                  char id[API_ID_SIZE], struct api_problem *problem) {
    const struct api_limits *limits = &arguments->limits;
    const struct api_sink sink = {.write = write_container, .context = container};
    const struct drape_monitor monitor = {arguments->study ? study_progress : show_progress, NULL};
    bool terminal = isatty(STDERR_FILENO);
    if (!(arguments->study ? study_identify : identify)(input, limits, id, problem))
        return false;
    enum api_problem_id result = (arguments->study ? api_study_run : api_run)(
        input, limits, terminal ? &monitor : NULL, &sink, problem);
    if (terminal)
        fputs("\r\033[K", stderr);
    return result == API_OK;
}

/* ---- output ---- */

static bool write_bytes(struct encoder *encoder, const struct files_output *output) {
    static char buffer[1 << 16];
    ssize_t length;
    while ((length = encoder_read(encoder, buffer, sizeof buffer)) > 0) {
        if (fwrite(buffer, 1, (size_t)length, output->stream) != (size_t)length) {
            files_complain(output->name, strerror(errno));
            return false;
        }
    }
    if (length < 0)
        files_complain(output->name, "the solved net could not be read back");
    return length == 0;
}

static bool write_document(const struct arguments *arguments, struct format_source source,
                           const struct files_output *output, struct api_problem *problem) {
    source.id = arguments->id;
    struct encoder *encoder = encoder_new(arguments->format, &source, &arguments->options, problem);
    bool ok = encoder && write_bytes(encoder, output);
    encoder_free(encoder);
    return ok;
}

/* ---- as a report ---- */

/* The request as it was understood, in the arena; NULL with the problem. */
static const char *understood(const struct api_input *input, const struct api_limits *limits,
                              const struct api_reader *reader, struct arena *arena,
                              struct api_problem *problem) {
    static struct api_columns columns;
    struct api_request decoded;
    const char *text = NULL;
    if (api_columns_open(reader, &columns, problem) == API_OK &&
        api_decode(input, limits, arena, &decoded, problem) == API_OK)
        text = api_normalise(&decoded, &columns.start, arena);
    if (!text)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the request");
    return text;
}

static bool write_report(const struct arguments *arguments, const struct api_input *input,
                         const struct api_reader *reader, const struct files_output *output,
                         struct api_problem *problem) {
    char finished[32];
    time_t now = time(NULL);
    struct tm date;
    struct arena *arena = arena_new(arguments->limits.max_memory);
    const char *inputs =
        arena ? understood(input, &arguments->limits, reader, arena, problem) : NULL;
    strftime(finished, sizeof finished, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &date));
    const struct format_source source = {.reader = reader,
                                         .record = {.inputs = inputs,
                                                    .digest = arguments->id,
                                                    .finished = finished,
                                                    .program = "drape " DRAPE_SOLVER_VERSION}};
    bool ok = inputs && write_document(arguments, source, output, problem);
    arena_free(arena);
    return ok;
}

/* ---- on a mesh ---- */

static bool read_mesh(const struct arguments *arguments, const struct files_bytes *text,
                      struct arena *arena, struct map_target *mesh, struct api_problem *problem) {
    size_t length = strlen(arguments->map);
    bool json = length >= 5 && strcasecmp(arguments->map + length - 5, ".json") == 0;
    enum api_problem_id result = (json ? map_target_json : map_target_nastran)(
        text->data, text->length, arena, mesh, problem);
    for (int k = 0; result == API_OK && k < MESH_OPTIONS; k++)
        if (arguments->mesh[k] && !map_target_option(mesh, parameter_of(mesh_options[k]),
                                                     arguments->mesh[k], arena, problem))
            return false;
    if (result == API_OK && !mesh->elements && arguments->format->elements)
        api_problem_set(problem, API_NOT_ACCEPTABLE, "%s is of elements, but these are points",
                        arguments->format->name);
    return problem->id == API_OK;
}

/* Of the drape of `input` that `reader` has, or of a laminate. */
static bool write_map(const struct arguments *arguments, const struct api_input *input,
                      const struct api_reader *reader, const struct laminate_job *stack,
                      const struct files_output *output, struct api_problem *problem) {
    static struct api_map map;
    struct files_bytes text = {0};
    struct map_target mesh;
    struct arena *arena = arena_new(arguments->limits.max_memory);
    bool ok = false;
    if (!arena)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the map");
    else
        ok = files_read(arguments->map, &text) &&
             read_mesh(arguments, &text, arena, &mesh, problem) &&
             (stack ||
              cavity_take_cloth(&mesh, reader, input, &arguments->limits, arena, problem)) &&
             (stack ? laminate_map(&stack->laminate, stack->nets, &mesh, NULL, arena, &map, problem)
                    : api_map_make(reader, &mesh, NULL, arena, &map, problem)) == API_OK &&
             write_document(arguments, (struct format_source){.fields = &map.fields}, output,
                            problem);
    for (size_t k = 0; ok && k < map.fields.warning_count; k++)
        files_complain("warning", map.fields.warnings[k]);
    arena_free(arena);
    free(text.data);
    return ok;
}

/* ---- all of it ---- */

/* On standard error, so that whoever reads the document alone knows as well. */
static void print_warnings(const struct api_reader *reader, struct api_problem *problem) {
    static struct api_columns columns;
    if (api_columns_open(reader, &columns, problem) != API_OK)
        return;
    for (size_t k = 0; k < columns.summary.warnings.count; k++)
        files_complain("warning", columns.summary.warnings.list[k].detail);
}

/* A stack of plies: on a mesh, or what became of each. */
static bool laminate(const struct arguments *arguments, const struct api_input *input,
                     const struct files_output *output, struct api_problem *problem) {
    struct laminate_job job;
    bool ok = laminate_job_run(&job, input, &arguments->limits, problem);
    if (ok && arguments->map)
        ok = write_map(arguments, NULL, NULL, &job, output, problem);
    else if (ok && strcmp(arguments->format->name, "json") == 0)
        ok = laminate_job_report(&job, output, problem);
    else if (ok && arguments->format->uses & (FORMAT_PATTERN | FORMAT_REPORT))
        ok = laminate_job_draw(&job, arguments->format->name, output, problem);
    else if (ok)
        api_problem_set(problem, API_NOT_ACCEPTABLE,
                        "a laminate has no %s of its own: take --map, or drape one of its plies",
                        arguments->format->name);
    laminate_job_close(&job);
    return ok && problem->id == API_OK;
}

/* What a study cannot do, said before it is done. */
static bool check_study(const struct arguments *arguments, struct api_problem *problem) {
    if (arguments->study && arguments->map)
        api_problem_set(problem, API_NOT_ACCEPTABLE,
                        "--map is for drapes: write one with --variant and drape it");
    else if (arguments->study && !arguments->format->tables)
        api_problem_set(problem, API_NOT_ACCEPTABLE, "a study has no %s; drape one of its variants",
                        arguments->format->name);
    else if (!arguments->study && arguments->variant)
        api_problem_set(problem, API_NOT_ACCEPTABLE, "--variant is for studies");
    return problem->id == API_OK;
}

/* The document that is wanted of what was solved. */
static bool write_wanted(const struct arguments *arguments, const struct api_input *input,
                         const struct api_reader *reader, const struct files_output *output,
                         struct api_problem *problem) {
    if (arguments->study)
        study_print(reader, arguments->output && !arguments->variant ? stdout : stderr, problem);
    else
        print_warnings(reader, problem);
    if (arguments->variant)
        return study_write_variant(input, &arguments->limits, reader, arguments->variant,
                                   output->stream, problem);
    if (arguments->map)
        return write_map(arguments, input, reader, NULL, output, problem);
    if (arguments->format->uses & FORMAT_REPORT)
        return write_report(arguments, input, reader, output, problem);
    return write_document(arguments, (struct format_source){.reader = reader}, output, problem);
}

static bool drape(struct arguments *arguments, struct files_bytes *request, FILE *container,
                  const struct files_output *output) {
    const struct api_reader reader = {read_container, container};
    struct api_problem problem = {0};
    struct files_bytes surface = {0};
    bool ok = material_resolve(request, &arguments->materials, &arguments->limits, &problem) &&
              part_resolve(request, &arguments->limits, &surface, &problem);
    const struct api_input input = {request->data, request->length, surface.data, surface.length};
    bool stack = ok && laminate_is(input.request, input.request_length, &arguments->limits);
    arguments->study =
        ok && !stack && api_is_study(input.request, input.request_length, &arguments->limits);
    if (stack)
        ok = laminate(arguments, &input, output, &problem);
    else
        ok = ok && check_study(arguments, &problem) &&
             solve(arguments, &input, container, arguments->id, &problem) &&
             write_wanted(arguments, &input, &reader, output, &problem);
    free(surface.data);
    if (problem.id != API_OK)
        print_problem(&problem);
    return ok;
}

/* From the request to the document, once the command line is understood. */
static bool work(struct arguments *arguments) {
    struct files_bytes request = {0};
    struct files_output output = {0};
    FILE *container = tmpfile();
    if (!container || !api_prepare()) {
        files_complain("cannot start", container ? "no randomness" : strerror(errno));
        return false;
    }
    bool ok = files_read(arguments->input, &request) && files_open(&output, arguments->output) &&
              drape(arguments, &request, container, &output);
    ok = files_close(&output, ok);
    fclose(container);
    free(request.data);
    return ok;
}

/* What a table foretells, on standard output. */
static bool judge_table(const struct arguments *arguments) {
    struct api_problem problem = {0};
    struct files_bytes text = {0};
    bool ok = api_prepare() && files_read(arguments->table, &text) &&
              hold_out_print(text.data, text.length, &arguments->limits, stdout, &problem);
    if (problem.id != API_OK)
        print_problem(&problem);
    free(text.data);
    return fflush(stdout) == 0 && ok;
}

int main(int argc, char **argv) {
    struct arguments arguments = {.limits = api_limits_default};
    int status = parse_arguments(argc, argv, &arguments);
    if (status >= 0)
        return status;
    if (arguments.table)
        return judge_table(&arguments) ? EXIT_SUCCESS : EXIT_FAILURE;
    files_watch_signals();
    return work(&arguments) ? EXIT_SUCCESS : EXIT_FAILURE;
}
