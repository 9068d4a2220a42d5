/* SPDX-License-Identifier: MIT */
#include "hold_out.h"

#include "api/request/decode.h"
#include "api/result/permeability.h"
#include <math.h>
#include <string.h>

enum { PARTS = 3 }; /* k1, k2, k3 */

static size_t columns_of(const struct api_permeability *table) {
    return table->fractions ? table->fractions : 1;
}

/* The values without a row or a column (the other one is past the end). */
static const double *without(const double *values, size_t rows, size_t columns, size_t row,
                             size_t column, struct arena *arena) {
    size_t count = 0;
    double *rest = values ? arena_take(arena, rows * columns, sizeof *rest) : NULL;
    for (size_t i = 0; rest && i < rows; i++)
        for (size_t j = 0; j < columns; j++)
            if (i != row && j != column)
                rest[count++] = values[i * columns + j];
    return rest;
}

/* The table without a row, or without a column; false without memory. */
static bool table_without(const struct api_permeability *table, size_t row, size_t column,
                          struct arena *arena, struct api_permeability *rest) {
    size_t rows = table->rows, columns = columns_of(table);
    *rest = *table;
    rest->table_k1 = without(table->table_k1, rows, columns, row, column, arena);
    rest->table_k2 = without(table->table_k2, rows, columns, row, column, arena);
    rest->table_k3 = without(table->table_k3, rows, columns, row, column, arena);
    rest->angle_deg = without(table->angle_deg, rows, columns, row, column, arena);
    rest->shear_deg = without(table->shear_deg, rows, 1, row, 1, arena);
    rest->rows -= row < rows;
    if (table->fractions) {
        rest->table_fractions = without(table->table_fractions, 1, columns, 1, column, arena);
        rest->fractions -= column < columns;
    }
    return rest->table_k1 && rest->table_k2 && rest->table_k3 && rest->shear_deg &&
           (rest->angle_deg || !table->angle_deg) && (rest->table_fractions || !table->fractions);
}

/* Leaves out each inner row, or each inner column. */
static bool leave_out(const struct api_permeability *table, bool rows, struct arena *arena,
                      FILE *out) {
    size_t columns = columns_of(table), none = table->rows + columns;
    size_t count = rows ? table->rows : columns, compared = 0;
    double largest[PARTS] = {0}, squares[PARTS] = {0};
    if (count < 3)
        return true;
    fprintf(out, "without the %s of each line, percent:\n%9s%s%10s%10s%10s\n",
            rows ? "shear_deg" : "fiber_volume_fraction", "shear_deg",
            table->fractions ? "       Vf" : "", "k1", "k2", "k3");
    for (size_t k = 1; k + 1 < count; k++) {
        struct api_permeability rest;
        if (!table_without(table, rows ? k : none, rows ? none : k, arena, &rest))
            return false;
        for (size_t other = 0; other < (rows ? columns : table->rows); other++, compared++) {
            double shear = table->shear_deg[rows ? k : other];
            double vf = table->fractions ? table->table_fractions[rows ? other : k]
                                         : 0.5; /* which is not used */
            struct permeability own = api_permeability_at(table, vf, shear, 0, NULL);
            struct permeability told = api_permeability_at(&rest, vf, shear, 0, NULL);
            const double ratio[PARTS] = {told.k1 / own.k1, told.k2 / own.k2, told.k3 / own.k3};
            fprintf(out, "%9g", shear);
            if (table->fractions)
                fprintf(out, "%9g", vf);
            for (int part = 0; part < PARTS; part++) {
                double percent = 100 * (ratio[part] - 1);
                fprintf(out, "%+10.2f", fabs(percent) < 0.005 ? 0 : percent); /* no -0.00 */
                squares[part] += percent * percent;
                largest[part] = fmax(largest[part], fabs(percent));
            }
            fprintf(out, "\n");
        }
    }
    fprintf(out, "%*s", table->fractions ? 18 : 9, "largest");
    for (int part = 0; part < PARTS; part++)
        fprintf(out, "%10.2f", largest[part]);
    fprintf(out, "\n%*s", table->fractions ? 18 : 9, "rms");
    for (int part = 0; part < PARTS; part++)
        fprintf(out, "%10.2f", sqrt(squares[part] / (double)compared));
    fprintf(out, "\n");
    return true;
}

bool hold_out_print(const char *bytes, size_t length, const struct api_limits *limits, FILE *out,
                    struct api_problem *problem) {
    struct api_permeability table;
    struct arena *arena = arena_new(limits->max_memory);
    if (arena && api_decode_permeability(bytes, length, limits, arena, &table, problem) == API_OK &&
        (table.model != API_PERMEABILITY_TABLE || (table.rows < 3 && table.fractions < 3)))
        api_problem_set(
            problem, API_INVALID_REQUEST,
            "only a table of three shear angles or three fractions and more has a value "
            "to leave out");
    if (!arena || (problem->id == API_OK &&
                   (!leave_out(&table, true, arena, out) || !leave_out(&table, false, arena, out))))
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the table");
    arena_free(arena);
    return problem->id == API_OK;
}
