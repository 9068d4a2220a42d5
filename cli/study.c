/* SPDX-License-Identifier: MIT */
#include "study.h"

#include "files.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum { BAR_WIDTH = 40, ROWS_SHOWN = 10, COLUMN_WIDTH = 13 };

bool study_progress(void *context, double fraction) {
    char bar[BAR_WIDTH + 1] = {0};
    (void)context;
    for (int k = 0; k < BAR_WIDTH; k++)
        bar[k] = k < fraction * BAR_WIDTH ? '#' : '.';
    fprintf(stderr, "\rdraping variants [%s] %3.0f %%", bar, 100 * fraction);
    return true;
}

/* ---- the table ---- */

/* The columns of `variants`, one after the other. */
struct table {
    struct api_columns columns;
    double *values; /* [column][row] */
    size_t rows;
};

static const double *column_of(const struct table *table, const char *name) {
    const struct api_column *column = api_columns_find(&table->columns, API_TABLE_VARIANTS, name);
    return column ? table->values + (size_t)(column - table->columns.column) * table->rows : NULL;
}

/* The first objective that has a best one. */
static int first_objective(const struct api_study_summary *study) {
    for (int k = 0; k < QUANTITY_COUNT; k++)
        if (study->objective[k] && study->best[k] >= 0)
            return k;
    return -1;
}

/* Rows in the order of a study's best: the best first, then the front, then by the objective; what
 * failed, was coarse or breaks a limit at the end. */
struct rank {
    double group, value;
    size_t row;
};

static int compare_ranks(const void *a, const void *b) {
    const struct rank *x = a, *y = b;
    if (x->group != y->group)
        return x->group < y->group ? -1 : 1;
    if (x->value != y->value)
        return x->value < y->value ? -1 : 1;
    return (x->row > y->row) - (x->row < y->row);
}

/* Whether a column is worth its place: of what never differs from row to row little is learnt. */
static bool is_shown(const struct table *table, const struct api_column *column) {
    static const char *const hidden[] = {"x",        "y",      "z",      "coarseness",
                                         "feasible", "pareto", "failure"};
    const double *values = column_of(table, column->name);
    for (size_t k = 0; k < sizeof hidden / sizeof *hidden; k++)
        if (strcmp(column->name, hidden[k]) == 0)
            return false;
    for (size_t k = 1; k < table->rows; k++)
        if (values[k] != values[0])
            return true;
    return table->rows == 1;
}

/* Prints the best of the variants. */
static void print_rows(const struct table *table, int objective, FILE *stream) {
    const double *value = column_of(table, quantities[objective].name);
    const double *feasible = column_of(table, "feasible"), *pareto = column_of(table, "pareto");
    const double *failure = column_of(table, "failure");
    const double *coarse = column_of(table, "coarseness");
    struct rank *ranks = calloc(table->rows + 1, sizeof *ranks);
    if (!ranks)
        return;
    for (size_t k = 0; k < table->rows; k++) {
        bool best = k == (size_t)table->columns.study.best[objective];
        ranks[k] = (struct rank){best              ? 0
                                 : pareto[k] > 0   ? 1
                                 : failure[k] > 0  ? 5
                                 : coarse[k] > 1   ? 4
                                 : feasible[k] > 0 ? 2
                                                   : 3,
                                 value[k], k};
    }
    qsort(ranks, table->rows, sizeof *ranks, compare_ranks);
    fprintf(stream, "%8s", "variant");
    for (size_t c = 0; c < table->columns.count; c++)
        if (is_shown(table, &table->columns.column[c]))
            fprintf(stream, " %*s", COLUMN_WIDTH, table->columns.column[c].name);
    fputc('\n', stream);
    for (size_t k = 0; k < table->rows && k < ROWS_SHOWN && ranks[k].group < 4; k++) {
        size_t row = ranks[k].row;
        fprintf(stream, "%8zu", row);
        for (size_t c = 0; c < table->columns.count; c++) {
            const struct api_column *column = &table->columns.column[c];
            int width = (int)strlen(column->name);
            if (is_shown(table, column))
                fprintf(stream, " %*.6g", width > COLUMN_WIDTH ? width : COLUMN_WIDTH,
                        table->values[c * table->rows + row]);
        }
        fprintf(stream, "%s\n",
                !(feasible[row] > 0) ? "  breaks a limit"
                : pareto[row] > 0    ? "  on the front"
                                     : "");
    }
    free(ranks);
}

void study_print(const struct api_reader *result, FILE *stream, struct api_problem *problem) {
    struct table table = {0};
    struct api_columns *columns = &table.columns;
    const struct api_study_summary *study = &columns->study;
    if (api_columns_open(result, columns, problem) != API_OK)
        return;
    table.rows = api_columns_rows(columns, API_TABLE_VARIANTS);
    while (columns->column[columns->count - 1].table != API_TABLE_VARIANTS)
        columns->count--; /* those of other tables come behind */
    table.values = calloc(columns->count * table.rows + 1, sizeof *table.values);
    bool ok = table.values != NULL;
    if (!ok)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the table");
    for (size_t k = 0; ok && k < columns->count; k++) {
        ok = api_columns_read(result, &columns->column[k], 0, table.rows,
                              table.values + k * table.rows);
        if (!ok)
            api_problem_set(problem, API_INTERNAL, "the study could not be read back");
    }
    int objective = ok ? first_objective(study) : -1;
    for (size_t k = 0; ok && k < study->warnings.count; k++)
        files_complain("warning", study->warnings.list[k].detail);
    if (ok)
        fprintf(stream, "%zu variants in %.3g s; %zu keep the limits, %zu are on the front\n",
                study->variants, study->solve_ms / 1e3, study->feasible, study->pareto);
    if (ok && study->verdict.variant >= 0)
        fprintf(stream, "variant %d is %s%s\n", study->verdict.variant,
                study->verdict.obstacle == VERDICT_DRAPABLE ? "" : "not drapable: ",
                study->verdict.detail);
    if (objective >= 0)
        print_rows(&table, objective, stream);
    free(table.values);
}

bool study_write_variant(const struct api_study *study, const struct api_limits *limits,
                         const struct api_reader *result, const char *variant, FILE *stream,
                         struct api_problem *problem) {
    const struct api_sink sink = {.write = files_append, .context = stream};
    struct api_columns columns;
    if (api_columns_open(result, &columns, problem) != API_OK)
        return false;
    int objective = first_objective(&columns.study);
    bool best = strcmp(variant, "best") == 0;
    char *end;
    errno = 0;
    size_t k =
        best && objective >= 0 ? (size_t)columns.study.best[objective] : strtoul(variant, &end, 10);
    if (best ? objective < 0 : *variant < '0' || *variant > '9' || *end != '\0' || errno != 0) {
        api_problem_set(problem, API_NOT_FOUND,
                        best ? "the study has no best variant: none could be draped"
                             : "--variant takes a number, or \"best\"");
        return false;
    }
    struct arena *arena = arena_new(limits->max_memory);
    if (!arena)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the request");
    bool ok = arena && api_study_variant_request(study, result, k, arena, &sink, problem) == API_OK;
    arena_free(arena);
    return ok && fputc('\n', stream) != EOF;
}
