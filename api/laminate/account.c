/* SPDX-License-Identifier: MIT */
#include "account.h"

#include "api/result/summary.h"
#include "courses.h"
#include <math.h>

enum api_problem_id ply_account_make(const struct laminate *laminate,
                                     const struct flat_plies *shapes, size_t first,
                                     struct arena *arena, struct ply_account *account,
                                     struct api_problem *problem) {
    const struct laminate_pieces *pieces = laminate->plies[first].pieces;
    size_t shape = shapes->count; /* the first of the ply */
    *account =
        (struct ply_account){.first = first, .count = pieces ? pieces->count : 1, .covered = NAN};
    for (int k = 0; k < COURSE_FIGURES; k++)
        account->courses[k] = NAN;
    for (size_t n = shapes->count; n-- > 0;)
        if (shapes->shapes[n].ply >= first && shapes->shapes[n].ply < first + account->count) {
            account->shapes[shapes->shapes[n].ply - first] = &shapes->shapes[n];
            shape = n;
        }
    if (pieces && pieces->courses)
        courses_sum_up(pieces, account->courses);
    if (shape == shapes->count)
        return API_OK;
    account->covered = shapes->shapes[shape].covered;
    return seams_make(laminate, shapes, shape, arena, &account->seams, &account->seam_count,
                      problem);
}

/* ---- as a document ---- */

struct account_writer {
    const struct laminate *laminate;
    const struct api_reader *const *nets;
    const struct api_problem *problems;
    const struct api_problem *fault; /* what could not be found out of the ply */
    struct api_text *text;
    struct api_columns columns; /* of the drape that is told of */
};

/* The numbers of a ply's cloth: within its boundary, if it has one. */
static void write_cloth(const struct account_writer *w, const struct flat_ply *shape) {
    const struct laminate_ply *ply = &w->laminate->plies[shape->ply];
    double metres = w->laminate->length_unit->metres;
    api_text_key_number(w->text, "cloth_coverage", shape->covered);
    api_text_key_number(w->text, "max_shear_deg", shape->max_shear_deg);
    if (shape->locked_cells >= 0)
        api_text_key_number(w->text, "locked_cells", shape->locked_cells);
    api_text_key_number(w->text, "area", shape->area);
    if (ply->areal_weight > 0)
        api_text_key_number(w->text, "mass",
                            laminate_layers(ply) * ply->areal_weight * shape->area * metres *
                                metres);
}

/* Why a ply, or a piece, has no drape. */
static const char *failure_of(const struct account_writer *w, size_t net) {
    return w->problems ? w->problems[net].error[0].detail
                       : "its drape failed, and the status of the laminate says why";
}

/* What became of one ply, or of one piece, beside its name. */
static enum api_problem_id write_entry(struct account_writer *w, size_t k,
                                       const struct flat_ply *shape, struct api_problem *problem) {
    const struct laminate_ply *ply = &w->laminate->plies[k];
    const struct api_reader *net = w->nets[ply->net];
    const struct api_summary *summary = &w->columns.summary;
    struct api_text *text = w->text;
    size_t said = 0;
    api_text_key_string(text, "digest", w->laminate->net_digest[ply->net]);
    api_text_key_string(text, "status", net ? "succeeded" : "failed");
    if (!net) {
        api_text_key_string(text, "error", failure_of(w, ply->net));
        return API_OK;
    }
    if (api_columns_open(net, &w->columns, problem) != API_OK)
        return problem->id;
    bool partial = shape ? shape->partial : summary->outcome == DRAPE_PARTIAL;
    api_text_key_string(text, "outcome", outcome_names[partial ? DRAPE_PARTIAL : DRAPE_COMPLETE]);
    api_text_key_integer(text, "nodes", (int64_t)summary->nodes);
    if (shape)
        write_cloth(w, shape);
    if (!ply->boundary.count && !ply->pieces)
        api_text_key_number(text, "mean_shear_deg", summary->mean_shear_deg);
    api_text_key(text, "warnings");
    api_text_raw(text, "[");
    for (size_t n = 0; n < summary->warnings.count; n++) {
        if (!flat_plies_concerns(w->laminate, k, &summary->warnings.list[n]))
            continue;
        api_text_raw(text, said++ ? "," : "");
        api_text_string(text, summary->warnings.list[n].detail);
    }
    if (w->fault->id != API_OK) {
        api_text_raw(text, said ? "," : "");
        api_text_string(text, w->fault->error[0].detail);
    }
    api_text_raw(text, "]");
    return API_OK;
}

/* The pieces of a ply, and its seams, or what its courses are together. */
static enum api_problem_id write_division(struct account_writer *w,
                                          const struct ply_account *account,
                                          struct api_problem *problem) {
    const struct laminate_pieces *pieces = w->laminate->plies[account->first].pieces;
    struct api_text *text = w->text;
    if (!isnan(account->covered))
        api_text_key_number(text, "cloth_coverage", account->covered);
    if (pieces->courses) {
        api_text_key_object(text, "courses");
        api_text_key_integer(text, "count", (int64_t)pieces->count);
        courses_write_figures(text, account->courses);
        api_text_raw(text, "}");
    }
    api_text_key(text, "pieces");
    for (size_t n = 0; n < account->count; n++) {
        api_text_raw(text, n ? ",{" : "[{");
        api_text_key_string(text, "name", pieces->pieces[n].name);
        if (pieces->courses) {
            api_text_key_object(text, "course");
            courses_write_figures(text, pieces->pieces[n].figures);
            api_text_raw(text, "}");
        }
        if (write_entry(w, account->first + n, account->shapes[n], problem) != API_OK)
            return problem->id;
        api_text_raw(text, "}");
    }
    api_text_raw(text, "]");
    if (pieces->courses)
        return API_OK;
    api_text_key(text, "seams");
    api_text_raw(text, "[");
    for (size_t n = 0; n < account->seam_count; n++) {
        api_text_raw(text, n ? "," : "");
        seams_write(pieces, &account->seams[n], text);
    }
    api_text_raw(text, "]");
    return API_OK;
}

enum api_problem_id laminate_account_write(const struct laminate *laminate,
                                           const struct api_reader *const *nets,
                                           const struct api_problem *problems,
                                           struct api_text *text, struct api_problem *problem) {
    struct account_writer *w = arena_alloc(text->arena, 1, sizeof *w);
    struct ply_account *account = arena_alloc(text->arena, 1, sizeof *account);
    if (!w || !account)
        return api_problem_no_memory(problem, "the account");
    *w = (struct account_writer){
        .laminate = laminate, .nets = nets, .problems = problems, .text = text};
    api_text_raw(text, "{\"plies\":[");
    for (size_t k = 0; k < laminate->count && problem->id == API_OK; k += account->count) {
        const struct laminate_ply *ply = &laminate->plies[k];
        struct api_problem fault = {.id = API_OK};
        struct flat_plies shapes;
        w->fault = &fault;
        api_text_raw(text, k ? ",{" : "{");
        api_text_key_string(text, "name", ply->name);
        api_text_key_integer(text, "layers", laminate_layers(ply));
        api_text_key_number(text, "offset", ply->drape.offset);
        if (flat_plies_make(laminate, nets, (int)ply->number, text->arena, &shapes, &fault) !=
            API_OK)
            flat_plies_free(&shapes);
        (void)!ply_account_make(laminate, &shapes, k, text->arena, account, &fault);
        (void)!(ply->pieces ? write_division(w, account, problem)
                            : write_entry(w, k, account->shapes[0], problem));
        api_text_raw(text, "}");
        flat_plies_free(&shapes);
    }
    api_text_raw(text, "]}\n");
    return problem->id;
}
