/* SPDX-License-Identifier: MIT */
/*
 * drape: the same solver without the daemon. Reads a request document, writes the result document,
 * or the result's fields on a mesh; progress on stderr when that is a terminal. Exit status: 0, 1
 * when the drape could not be done (why is on stderr), 2 when the command line is wrong.
 */
#include "api/files/files.h"
#include "api/json/value.h"
#include "api/laminate/map.h"
#include "api/laminate/patterns.h"
#include "api/map/cavity.h"
#include "api/map/map.h"
#include "api/request/decode.h"
#include "api/request/normalise.h"
#include "api/result/stored_cuts.h"
#include "api/run.h"
#include "arguments.h"
#include "files.h"
#include "hold_out.h"
#include "laminate.h"
#include "part.h"
#include "study.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <time.h>
#include <unistd.h>

static void print_problem(const struct api_problem *problem) {
    files_complain(api_problem_slug(problem->id), api_problem_title(problem->id));
    for (size_t i = 0; i < problem->count; i++) {
        const struct api_problem_error *error = &problem->error[i];
        const char *pointer = error->pointer[0] ? error->pointer : "(the whole document)";
        fprintf(stderr, "  %s%s%s\n", problem->has_pointer ? pointer : "",
                problem->has_pointer ? ": " : "", error->detail);
    }
}

/* ---- solving into a temporary file ---- */

static bool show_drape_progress(void *context, double fraction) {
    (void)context;
    fprintf(stderr, "\rdraping %3.0f %%", 100 * fraction);
    return true;
}

/* The id that the service would know the result by: of the study, or of the drape of `input`. */
static bool find_id(const struct api_input *input, const struct api_study *study,
                    const struct api_limits *limits, char *id, struct api_problem *problem) {
    struct api_request request;
    struct arena *arena = arena_new(limits->max_memory);
    bool ok = arena != NULL;
    if (ok && study)
        ok = api_study_digest(study, arena, id);
    else if (ok)
        ok = api_decode(input, limits, arena, &request, problem) == API_OK &&
             api_digest_request(&request, arena, id);
    arena_free(arena);
    if (!ok && problem->id == API_OK)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the request");
    return ok;
}

static bool solve_into(struct arguments *arguments, const struct api_input *input,
                       const struct api_study *study, FILE *container,
                       struct api_problem *problem) {
    const struct api_limits *limits = &arguments->limits;
    const struct api_sink sink = {.write = files_append, .context = container};
    const struct drape_monitor monitor = {study ? study_progress : show_drape_progress, NULL};
    bool terminal = isatty(STDERR_FILENO);
    const struct drape_monitor *watched = terminal ? &monitor : NULL;
    if (!find_id(input, study, limits, arguments->id, problem))
        return false;
    enum api_problem_id result = study ? api_study_run(study, limits, watched, &sink, problem)
                                       : api_run(input, limits, watched, &sink, problem);
    if (terminal)
        fputs("\r\033[K", stderr);
    return result == API_OK;
}

/* ---- output ---- */

static bool encode_to(const struct files_output *output, const struct arguments *arguments,
                      struct format_source source, struct api_problem *problem) {
    static char buffer[1 << 16];
    ssize_t length = 0;
    source.id = arguments->id;
    struct encoder *encoder = encoder_new(arguments->format, &source, &arguments->options, problem);
    bool ok = encoder != NULL;
    while (ok && (length = encoder_read(encoder, buffer, sizeof buffer)) > 0) {
        ok = fwrite(buffer, 1, (size_t)length, output->stream) == (size_t)length;
        if (!ok)
            files_complain(output->name, strerror(errno));
    }
    if (length < 0)
        files_complain(output->name, "the solved net could not be read back");
    encoder_free(encoder);
    return ok && length == 0;
}

/* ---- on a mesh ---- */

/* The mesh of `--map`, by the end of its name: JSON, or a file of `file_formats`; without an end
 * that is known Nastran bulk data. */
static bool read_map_mesh(const struct arguments *arguments, struct files_bytes *text,
                          struct arena *arena, struct map_target *mesh,
                          struct api_problem *problem) {
    const char *path = arguments->map, *dot = strrchr(path, '.');
    const struct file_format *format = file_format_of(path);
    char why[FILE_REFUSAL_SIZE];
    if (format ? format->cad : file_refuse(path, why)) {
        files_complain(path, format ? "a map needs a mesh: mesh the part first" : why);
        return false;
    }
    if (!files_read(path, text))
        return false;
    if (dot && strcasecmp(dot, ".json") == 0)
        return map_target_json(text->data, text->length, arena, mesh, problem) == API_OK;
    return file_read_target(format ? format : file_format_named("nastran"), text->data,
                            text->length, arena, mesh, problem) == API_OK;
}

/* Of the drape of `input` that `reader` has, or of a laminate. */
static bool write_map(const struct arguments *arguments, const struct api_input *input,
                      const struct api_reader *reader, const struct laminate_job *stack,
                      const struct files_output *output, struct api_problem *problem) {
    static struct api_map map;
    struct files_bytes text = {0};
    struct map_target mesh;
    struct arena *arena = arena_new(arguments->limits.max_memory);
    if (!arena)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the map");
    bool ok = arena && read_map_mesh(arguments, &text, arena, &mesh, problem);
    for (int k = 0; ok && k < MESH_OPTIONS; k++)
        if (arguments->mesh[k])
            ok = map_target_option(&mesh, arguments_parameter(arguments_mesh[k]),
                                   arguments->mesh[k], arena, problem);
    if (ok && !mesh.elements && arguments->format->elements)
        api_problem_set(problem, API_NOT_ACCEPTABLE,
                        "%s needs elements, but the mesh has only points", arguments->format->name);
    mesh.wants_yarns = ok && arguments->format->yarns;
    mesh.wants_outlines = ok && arguments->format->outlines;
    ok = ok && problem->id == API_OK &&
         (stack || cavity_take_cloth(&mesh, reader, input, &arguments->limits, arena, problem)) &&
         (stack ? laminate_map(&stack->laminate, stack->nets, &mesh, NULL, arena, &map, problem)
                : api_map_make(reader, &mesh, NULL, arena, &map, problem)) == API_OK &&
         encode_to(output, arguments, (struct format_source){.fields = &map.fields}, problem);
    for (size_t k = 0; ok && k < map.fields.warning_count; k++)
        files_complain("warning", map.fields.warnings[k]);
    arena_free(arena);
    free(text.data);
    return ok;
}

/* ---- all of it ---- */

/* What became of each cut, on standard error. */
static void tell_cuts(const struct api_reader *reader, const struct api_columns *columns) {
    struct stored_cut cuts[API_CUTS_MAX];
    bool read = stored_cuts_read(reader, columns, cuts);
    for (size_t k = 0; k < columns->cut_count && read; k++) {
        char line[STORED_CUT_TEXT];
        stored_cut_describe(&cuts[k], columns->unit->name, line);
        files_complain("cut", line);
    }
}

/* What the generators that were sought cost, and how severe the shear is, on standard error. */
static void tell_energy(const struct api_summary *summary) {
    const struct drape_steering *steering = &summary->steering;
    char line[160];
    snprintf(line, sizeof line, "energy %.5g with geodesics, %.5g with those found, in %d steps",
             steering->energy[0], steering->energy[1], steering->iterations);
    if (steering->sought[0] || steering->sought[1])
        files_complain("generators", line);
    snprintf(line, sizeof line, "%.3g at the most, by the limit curve", summary->severity_max);
    if (summary->severity_max >= 0)
        files_complain("severity", line);
}

/* The document that the arguments ask for. Cuts, energies, warnings, and what stands in the way of
 * a drape, go to standard error as well, for those who do not read the document's. */
static bool write_requested(const struct arguments *arguments, const struct api_input *input,
                            const struct api_study *study, const struct api_reader *reader,
                            const struct files_output *output, struct api_problem *problem) {
    static struct api_columns columns;
    const struct api_limits *limits = &arguments->limits;
    if (study)
        study_print(reader, arguments->output && !arguments->variant ? stdout : stderr, problem);
    else if (api_columns_open(reader, &columns, problem) == API_OK) {
        tell_cuts(reader, &columns);
        tell_energy(&columns.summary);
        for (size_t k = 0; k < columns.summary.warnings.count; k++)
            files_complain("warning", columns.summary.warnings.list[k].detail);
        if (columns.summary.verdict.obstacle != VERDICT_DRAPABLE)
            files_complain("not drapable", columns.summary.verdict.detail);
    }
    if (arguments->variant)
        return study_write_variant(study, limits, reader, arguments->variant, output->stream,
                                   problem);
    if (arguments->map)
        return write_map(arguments, input, reader, NULL, output, problem);
    struct format_source source = {.reader = reader};
    if (!(arguments->format->uses & FORMAT_REPORT))
        return encode_to(output, arguments, source, problem);
    /* A report has the request as it was decoded. */
    char finished[32];
    time_t now = time(NULL);
    struct tm date;
    struct api_request decoded;
    struct arena *arena = arena_new(limits->max_memory);
    const char *inputs = NULL;
    if (arena && api_columns_open(reader, &columns, problem) == API_OK &&
        api_decode(input, limits, arena, &decoded, problem) == API_OK)
        inputs = api_normalise(&decoded, &columns.start, arena);
    if (!inputs)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the request");
    strftime(finished, sizeof finished, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &date));
    source.record.inputs = inputs;
    source.record.digest = arguments->id;
    source.record.finished = finished;
    source.record.program = "drape " DRAPE_VERSION;
    bool ok = inputs && encode_to(output, arguments, source, problem);
    arena_free(arena);
    return ok;
}

static bool answer(struct arguments *arguments, struct files_bytes *request, FILE *container,
                   const struct files_output *output) {
    const struct api_reader reader = {files_read_at, container};
    struct api_problem problem = {0};
    struct files_bytes surface = {0};
    bool ok = material_resolve(request, &arguments->materials, &arguments->limits, &problem) &&
              part_resolve(request, arguments->input, &arguments->limits, &surface, &problem);
    const struct api_input input = {.request = request->data,
                                    .request_length = request->length,
                                    .surface = surface.data,
                                    .surface_length = surface.length};
    bool stack =
        ok && json_document_has(input.request, input.request_length, &arguments->limits, "plies");
    arguments->study =
        ok && !stack &&
        json_document_has(input.request, input.request_length, &arguments->limits, "drape");
    if (stack) {
        /* On a mesh, or the outcome of each ply, or their patterns. */
        struct laminate_job job;
        const struct format *format = arguments->format;
        struct laminate_roll roll = arguments->roll;
        const struct api_sink sink = {.write = files_append, .context = output->stream};
        roll.partial = arguments->options.partial;
        ok = laminate_job_run(&job, &input, &arguments->limits, &problem);
        if (ok)
            laminate_job_tell(&job);
        if (ok && arguments->map)
            ok = write_map(arguments, NULL, NULL, &job, output, &problem);
        else if (ok && strcmp(format->name, "json") == 0)
            ok = laminate_job_report(&job, output, &problem);
        else if (ok &&
                 format->uses & (FORMAT_PATTERN | FORMAT_REPORT | FORMAT_LASER | FORMAT_BUNDLE))
            ok = laminate_patterns(&job.laminate, job.nets, LAMINATE_ALL, format->name, &roll,
                                   &sink, job.arena, &problem) == API_OK;
        else if (ok)
            api_problem_set(&problem, API_NOT_ACCEPTABLE,
                            "a laminate has no %s of its own: use --map, or drape one of its plies",
                            format->name);
        laminate_job_close(&job);
    } else if (ok && arguments->format->uses & (FORMAT_LASER | FORMAT_BUNDLE))
        api_problem_set(&problem, API_NOT_ACCEPTABLE,
                        "%s is of a laminate: give the drape as the one of its \"plies\"",
                        arguments->format->name);
    else if (ok && arguments->study && arguments->map)
        api_problem_set(&problem, API_NOT_ACCEPTABLE,
                        "--map is for drapes: write one with --variant and drape it");
    else if (ok && arguments->study && !arguments->format->tables)
        api_problem_set(&problem, API_NOT_ACCEPTABLE,
                        "a study has no %s; drape one of its variants", arguments->format->name);
    else if (ok && !arguments->study && arguments->variant)
        api_problem_set(&problem, API_NOT_ACCEPTABLE, "--variant is for studies");
    else if (ok) {
        struct api_study *study =
            arguments->study ? api_study_open(&input, &arguments->limits, &problem) : NULL;
        ok = problem.id == API_OK && solve_into(arguments, &input, study, container, &problem) &&
             write_requested(arguments, &input, study, &reader, output, &problem);
        api_study_close(study);
    }
    free(surface.data);
    if (problem.id != API_OK)
        print_problem(&problem);
    return ok && problem.id == API_OK;
}

int main(int argc, char **argv) {
    struct arguments arguments = {.limits = api_limits_default};
    int status = arguments_parse(&arguments, argc, argv);
    if (status >= 0)
        return status;
    struct files_bytes request = {0};
    if (arguments.table) { /* the errors of a table of permeability, on standard output */
        struct api_problem problem = {0};
        bool held =
            api_prepare() && files_read(arguments.table, &request) &&
            hold_out_print(request.data, request.length, &arguments.limits, stdout, &problem);
        if (problem.id != API_OK)
            print_problem(&problem);
        free(request.data);
        return fflush(stdout) == 0 && held ? EXIT_SUCCESS : EXIT_FAILURE;
    }
    files_watch_signals();
    struct files_output output = {0};
    FILE *container = tmpfile();
    if (!container || !api_prepare()) {
        files_complain("cannot start",
                       container ? "the system gives no random numbers" : strerror(errno));
        return EXIT_FAILURE;
    }
    bool ok = files_read(arguments.input, &request) && files_open(&output, arguments.output) &&
              answer(&arguments, &request, container, &output);
    ok = files_close(&output, ok);
    fclose(container);
    free(request.data);
    return ok ? EXIT_SUCCESS : EXIT_FAILURE;
}
