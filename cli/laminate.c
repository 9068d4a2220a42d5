/* SPDX-License-Identifier: MIT */
#include "laminate.h"

#include "api/json/text.h"
#include "api/laminate/courses.h"
#include "api/laminate/flat_plies.h"
#include "api/laminate/run.h"
#include "api/laminate/seams.h"
#include <errno.h>
#include <string.h>
#include <unistd.h>

static bool show_ply_progress(void *context, double fraction) {
    const struct laminate_job *job = context;
    fprintf(stderr, "\rdraping %zu of %zu: %3.0f %%", job->net + 1, job->laminate.net_count,
            100 * fraction);
    return true;
}

bool laminate_job_run(struct laminate_job *job, const struct api_input *input,
                      const struct api_limits *limits, struct api_problem *problem) {
    const struct drape_monitor monitor = {show_ply_progress, job};
    bool terminal = isatty(STDERR_FILENO);
    size_t done = 0;
    *job = (struct laminate_job){.arena = arena_new(limits->max_memory)};
    if (!job->arena) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the laminate");
        return false;
    }
    if (laminate_decode(input, limits, job->arena, &job->laminate, problem) != API_OK)
        return false;
    if (job->laminate.surface.kind == API_SURFACE_NAMED)
        api_problem_add(problem, "/surface/id", "no surface is stored under this id");
    if (problem->id != API_OK ||
        laminate_resolve(&job->laminate, limits, job->arena, problem) != API_OK)
        return false;
    size_t count = job->laminate.net_count;
    job->nets = arena_alloc(job->arena, count, sizeof *job->nets);
    job->problems = arena_alloc(job->arena, count, sizeof *job->problems);
    job->containers = arena_alloc(job->arena, count, sizeof *job->containers);
    job->readers = arena_alloc(job->arena, count, sizeof *job->readers);
    if (!job->nets || !job->problems || !job->containers || !job->readers) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the laminate");
        return false;
    }
    for (size_t n = 0; n < count; n++) {
        job->net = n;
        job->containers[n] = tmpfile();
        if (!job->containers[n]) {
            api_problem_set(problem, API_INTERNAL, "no temporary file: %s", strerror(errno));
            return false;
        }
        const struct api_sink sink = {.write = files_append, .context = job->containers[n]};
        job->readers[n] = (struct api_reader){files_read_at, job->containers[n]};
        if (laminate_run(&job->laminate, n, input, limits, terminal ? &monitor : NULL, &sink,
                         &job->problems[n]) == API_OK)
            job->nets[n] = &job->readers[n];
    }
    if (terminal)
        fputs("\r\033[K", stderr);
    for (size_t n = 0; n < count; n++) {
        done += job->nets[n] != NULL;
        for (size_t k = 0; k < job->problems[n].count; k++)
            files_complain("warning", job->problems[n].error[k].detail);
    }
    if (done == 0)
        *problem = job->problems[0];
    return done > 0;
}

void laminate_job_close(struct laminate_job *job) {
    for (size_t n = 0; job->containers && n < job->laminate.net_count; n++)
        if (job->containers[n])
            fclose(job->containers[n]);
    arena_free(job->arena);
}

/* The number of a ply's cloth: within its boundary, if it has one. */
static void report_cloth(const struct laminate_job *job, size_t k, const struct flat_ply *shape,
                         struct api_text *text) {
    const struct laminate_ply *ply = &job->laminate.plies[k];
    double metres = job->laminate.length_unit->metres;
    api_text_key_number(text, "cloth_coverage", shape->covered);
    api_text_key_number(text, "max_shear_deg", shape->max_shear_deg);
    if (shape->locked_cells >= 0)
        api_text_key_number(text, "locked_cells", shape->locked_cells);
    api_text_key_number(text, "area", shape->area);
    if (ply->areal_weight > 0)
        api_text_key_number(
            text, "mass", laminate_layers(ply) * ply->areal_weight * shape->area * metres * metres);
}

/* What became of one ply, or of one piece, beside its name. */
static bool report_ply(const struct laminate_job *job, size_t k, const struct flat_ply *shape,
                       const struct api_problem *fault, struct api_text *text,
                       struct api_problem *problem) {
    static struct api_columns columns;
    const struct laminate_ply *ply = &job->laminate.plies[k];
    const struct api_reader *net = job->nets[ply->net];
    api_text_key_string(text, "digest", job->laminate.net_digest[ply->net]);
    api_text_key_string(text, "status", net ? "succeeded" : "failed");
    if (!net) {
        api_text_key_string(text, "error", job->problems[ply->net].error[0].detail);
        return true;
    }
    if (api_columns_open(net, &columns, problem) != API_OK)
        return false;
    const struct api_summary *summary = &columns.summary;
    bool partial = shape ? shape->partial : summary->outcome == DRAPE_PARTIAL;
    api_text_key_string(text, "outcome", outcome_names[partial ? DRAPE_PARTIAL : DRAPE_COMPLETE]);
    api_text_key_integer(text, "nodes", (int64_t)summary->nodes);
    if (shape)
        report_cloth(job, k, shape, text);
    if (!ply->boundary.count && !ply->pieces)
        api_text_key_number(text, "mean_shear_deg", summary->mean_shear_deg);
    api_text_key(text, "warnings");
    api_text_raw(text, "[");
    size_t said = 0;
    for (size_t w = 0; w < summary->warnings.count; w++) {
        if (!flat_plies_concerns(&job->laminate, k, &summary->warnings.list[w]))
            continue;
        api_text_raw(text, said++ ? "," : "");
        api_text_string(text, summary->warnings.list[w].detail);
    }
    if (!shape) {
        api_text_raw(text, said ? "," : "");
        api_text_string(text, fault->error[0].detail);
    }
    api_text_raw(text, "]");
    return true;
}

/* The sums over the courses of a ply. */
static void report_courses(const struct laminate_pieces *pieces, struct api_text *text) {
    double sums[COURSE_FIGURES];
    courses_sum_up(pieces, sums);
    api_text_key_object(text, "courses");
    api_text_key_integer(text, "count", (int64_t)pieces->count);
    courses_write_figures(text, sums);
    api_text_raw(text, "}");
}

/* The pieces of a ply whose first is ply k, and its seams, or what its courses are together. */
static bool report_pieces(const struct laminate_job *job, size_t k, const struct flat_plies *shapes,
                          bool known, const struct api_problem *fault, struct api_text *text,
                          struct api_problem *problem) {
    const struct laminate_pieces *pieces = job->laminate.plies[k].pieces;
    const struct flat_ply *siblings[LAMINATE_SIBLINGS_MAX] = {NULL};
    const struct seam *seams;
    size_t count = 0;
    if (known && shapes->count)
        (void)flat_plies_siblings(shapes, &job->laminate, 0, siblings);
    if (known && shapes->count)
        api_text_key_number(text, "cloth_coverage", shapes->shapes[0].covered);
    if (pieces->courses)
        report_courses(pieces, text);
    api_text_key(text, "pieces");
    for (size_t n = 0; n < pieces->count; n++) {
        api_text_raw(text, n ? ",{" : "[{");
        api_text_key_string(text, "name", pieces->pieces[n].name);
        if (pieces->courses) {
            api_text_key_object(text, "course");
            courses_write_figures(text, pieces->pieces[n].figures);
            api_text_raw(text, "}");
        }
        if (!report_ply(job, k + n, siblings[n], fault, text, problem))
            return false;
        api_text_raw(text, "}");
    }
    api_text_raw(text, "]");
    if (pieces->courses)
        return true;
    if (known && shapes->count &&
        seams_make(&job->laminate, shapes, 0, job->arena, &seams, &count, problem) != API_OK)
        return false;
    api_text_key(text, "seams");
    api_text_raw(text, "[");
    for (size_t n = 0; n < count; n++) {
        api_text_raw(text, n ? "," : "");
        seams_write(pieces, &seams[n], text);
    }
    api_text_raw(text, "]");
    return true;
}

bool laminate_job_report(const struct laminate_job *job, const struct files_output *output,
                         struct api_problem *problem) {
    struct api_text text = api_text_growing(job->arena);
    api_text_raw(&text, "{\"plies\":[");
    for (size_t k = 0, next; k < job->laminate.count; k = next) {
        const struct laminate_ply *ply = &job->laminate.plies[k];
        struct api_problem own = {0};
        struct flat_plies shapes;
        api_text_raw(&text, k ? ",{" : "{");
        api_text_key_string(&text, "name", ply->name);
        api_text_key_integer(&text, "layers", laminate_layers(ply));
        api_text_key_number(&text, "offset", ply->drape.offset);
        bool known = flat_plies_make(&job->laminate, job->nets, (int)ply->number, job->arena,
                                     &shapes, &own) == API_OK;
        next = k + (ply->pieces ? ply->pieces->count : 1);
        bool good = ply->pieces
                        ? report_pieces(job, k, &shapes, known, &own, &text, problem)
                        : report_ply(job, k, known && shapes.count ? &shapes.shapes[0] : NULL, &own,
                                     &text, problem);
        api_text_raw(&text, "}");
        flat_plies_free(&shapes);
        if (!good)
            return false;
    }
    api_text_raw(&text, "]}\n");
    const char *document = api_text_finish(&text);
    if (!document)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the document");
    else if (fputs(document, output->stream) < 0)
        api_problem_set(problem, API_INTERNAL, "%s: %s", output->name, strerror(errno));
    return problem->id == API_OK;
}
