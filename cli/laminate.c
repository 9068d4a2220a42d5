/* SPDX-License-Identifier: MIT */
#include "laminate.h"

#include "api/json/text.h"
#include "api/laminate/account.h"
#include "api/laminate/run.h"
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
    bool cut = false;
    for (size_t k = 0; k < job->laminate.count; k++)
        cut = cut || job->laminate.plies[k].drape.settings.cut_count > 0;
    if (cut && laminate_check_drapes(&job->laminate, limits, job->arena, problem) != API_OK)
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

/* The seams of a ply between splits, or what its courses take. */
static void tell_division(const struct laminate *laminate, const struct ply_account *account) {
    const struct laminate_ply *ply = &laminate->plies[account->first];
    const struct laminate_piece *pieces = ply->pieces->pieces;
    const char *unit = laminate->length_unit->name;
    char line[256];
    snprintf(line, sizeof line, "%s, %zu %s cover %.4g %% of the part", ply->name, account->count,
             ply->pieces->courses ? "courses" : "pieces", 100 * account->covered);
    files_complain("ply", line);
    for (size_t k = 0; k < account->seam_count; k++) {
        const struct seam *seam = &account->seams[k];
        snprintf(line, sizeof line,
                 "%s, %s to %s, %.4g %s long, overlap %.4g wide, gap %.4g, warps at %.3g degrees",
                 ply->name, pieces[seam->piece[0]].name, pieces[seam->piece[1]].name, seam->length,
                 unit, seam->overlap_width, seam->gap_width, seam->greatest_deg);
        files_complain("seam", line);
    }
    const double *sums = account->courses;
    snprintf(line, sizeof line,
             "%s, %.4g %s2 from the roll, %.4g of it trimmed, gaps %.4g, overlaps %.4g", ply->name,
             sums[COURSE_AREA], unit, sums[COURSE_TRIM_AREA], sums[COURSE_GAP_AREA],
             sums[COURSE_OVERLAP_AREA]);
    if (ply->pieces->courses)
        files_complain("courses", line);
}

void laminate_job_tell(const struct laminate_job *job) {
    const struct laminate *laminate = &job->laminate;
    struct ply_account account;
    for (size_t k = 0; k < laminate->count; k += account.count) {
        struct arena_mark mark = arena_mark(job->arena);
        struct api_problem problem = {0};
        struct flat_plies shapes = {0};
        account.count = 1;
        if (!laminate->plies[k].pieces)
            continue;
        bool known = flat_plies_make(laminate, job->nets, (int)laminate->plies[k].number,
                                     job->arena, &shapes, &problem) == API_OK;
        if (!known)
            flat_plies_free(&shapes);
        if (ply_account_make(laminate, &shapes, k, job->arena, &account, &problem) == API_OK &&
            known)
            tell_division(laminate, &account);
        flat_plies_free(&shapes);
        arena_rewind(job->arena, mark);
    }
}

bool laminate_job_report(const struct laminate_job *job, const struct files_output *output,
                         struct api_problem *problem) {
    struct api_text text = api_text_growing(job->arena);
    if (laminate_account_write(&job->laminate, job->nets, job->problems, &text, problem) != API_OK)
        return false;
    const char *document = api_text_finish(&text);
    if (!document)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the document");
    else if (fputs(document, output->stream) < 0)
        api_problem_set(problem, API_INTERNAL, "%s: %s", output->name, strerror(errno));
    return problem->id == API_OK;
}
