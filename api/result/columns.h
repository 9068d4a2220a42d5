/* SPDX-License-Identifier: MIT */
/*
 * The result as it is stored: a header, then every column of every table as one run of
 * little-endian float64. Encoders read it piece by piece; nobody holds it whole.
 *
 * - 8 bytes: "DRAPECOL"
 * - 4 bytes: format version, little-endian
 * - 4 bytes: length n of the directory, little-endian
 * - n bytes: the directory, a JSON object with summary, grid, start and the list of columns, padded
 *   with spaces so that the columns start on a multiple of 8
 * - the columns in the order of the directory, 8 bytes a row
 */
#ifndef API_RESULT_COLUMNS_H
#define API_RESULT_COLUMNS_H

#include "api/problem.h"
#include "api/request/normalise.h"
#include "api/sink.h"
#include "solver/arena.h"
#include "solver/drape.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    API_HEADER_MAX = 16384, /* bytes before the first column: a reader of these can be opened */
    API_COLUMNS_MAX = 64,
    API_COLUMN_NAME_SIZE = 32,
    API_VERSION_SIZE = 32
};

enum api_table { API_TABLE_NODES, API_TABLE_CELLS, API_TABLE_FRONT, API_TABLE_COUNT };

/* "nodes", "cells", "front". */
const char *api_table_name(enum api_table table);

/* A column of the stored result. Numbers stand for names in one place: front.reason holds
 * `enum drape_reason`. */
struct api_column {
    enum api_table table;
    char name[API_COLUMN_NAME_SIZE];
    bool integer;    /* every value is a whole number within 2^53 */
    size_t rows;     /* the same for all columns of a table */
    uint64_t offset; /* of its first value, from the start of the container */
};

struct api_summary {
    enum drape_outcome outcome;
    size_t nodes, cells;
    double coverage; /* share of the area in cells, 0..1 */
    double max_shear_deg, mean_shear_deg;
    size_t locked_cells;           /* 0 without a locking angle */
    size_t packing_exceeded_cells; /* 0 without a fibre volume fraction */
    double residual_max;
    double newton_iterations_mean;
    double error_estimate_max; /* negative: the method gives none */
    size_t front_reasons[DRAPE_REASON_COUNT];
    double solve_ms;
    char solver_version[API_VERSION_SIZE];
};

struct api_grid {
    int warp[2], weft[2]; /* least and greatest i and j */
    double spacing[2];
};

/* The header of a result. */
struct api_columns {
    struct api_summary summary;
    struct api_grid grid;
    struct api_start start;
    const struct api_unit *unit; /* of lengths; NULL when writing: the default */
    size_t count;
    struct api_column column[API_COLUMNS_MAX];
    uint64_t length; /* of the whole container */
};

/* A column that gives its values, whatever they come from: `fill` gives the rows first ..
 * first + count - 1, or returns false when they cannot be read. `context` outlives it. */
struct api_column_source {
    enum api_table table;
    const char *name;
    bool integer;
    size_t rows;
    bool (*fill)(const void *context, size_t first, size_t count, double *values);
    const void *context;
};

/*
 * Writes a container to `sink`: the summary, grid and start of `header`, then `count` columns; the
 * directory is made here (`header->count`, `column` and `length` are set). Scratch comes from
 * `arena` and is given back. Problems: API_INTERNAL when a value is not finite, with the column's
 * name, or when there are more than API_COLUMNS_MAX; API_CANCELLED when the sink refuses;
 * API_OUT_OF_MEMORY.
 */
enum api_problem_id api_columns_write(struct api_columns *header,
                                      const struct api_column_source *sources, size_t count,
                                      const struct api_sink *sink, struct arena *arena,
                                      struct api_problem *problem) STATUS_MUST_USE;

/* A stored container: `read_at` copies `length` bytes from `offset`; false when it cannot. */
struct api_reader {
    bool (*read_at)(void *context, uint64_t offset, void *buffer, size_t length);
    void *context;
};

/* Reads and checks the header. API_INTERNAL when the container is damaged or unreadable. */
enum api_problem_id api_columns_open(const struct api_reader *reader, struct api_columns *columns,
                                     struct api_problem *problem) STATUS_MUST_USE;

/* The rows first .. first + count - 1 of a column; false when they cannot be read, or when one is
 * no number that the writer would have let pass. */
bool api_columns_read(const struct api_reader *reader, const struct api_column *column,
                      size_t first, size_t count, double *values) STATUS_MUST_USE;

/* The column of that table and name, or NULL. */
const struct api_column *api_columns_find(const struct api_columns *columns, enum api_table table,
                                          const char *name);

/* The rows that every column of the table has. */
size_t api_columns_rows(const struct api_columns *columns, enum api_table table);

/* The contract's summary object, with `queue_ms` of waiting: what a status document shows. A
 * malloc'ed string that the caller frees; NULL without memory. */
char *api_summary_json(const struct api_summary *summary, double queue_ms);

#endif
