/* SPDX-License-Identifier: MIT */
/*
 * The result as it is stored: a header, then every column of every table as one run of
 * little-endian numbers. Encoders read it piece by piece and never hold all of it.
 *
 * - 8 bytes: "DRAPECOL"
 * - 4 bytes: format version, little-endian
 * - 4 bytes: length n of the result header, little-endian
 * - n bytes: the result header, a JSON object with summary, grid, start and the list of columns,
 * padded with spaces so that the columns start on a multiple of 8
 * - the columns in the order of the result header, each in its form (`enum api_form`), padded with
 * zeros to a multiple of 8
 *
 * The numbers that come back have the bits of those that were written: a whole number takes the
 * bytes that the column's range needs, and a column of one value is that value, which leaves three
 * fifths of what float64 alone would take. Version 1 has no other form than float64.
 */
#ifndef API_RESULT_COLUMNS_H
#define API_RESULT_COLUMNS_H

#include "api/problem.h"
#include "api/sink.h"
#include "result_header.h"
#include "solver/arena.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    API_HEADER_MAX = 24576
}; /* bytes before the first column: a reader of these can be opened */

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
 * result header is made here (`header->count`, `column` and `length` are set). Scratch comes from
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

/* A container in memory, which outlives the reader. */
struct api_memory {
    const char *bytes;
    size_t length;
};
struct api_reader api_reader_of(struct api_memory *memory);

/* Reads and checks the header. API_INTERNAL when the container is damaged or unreadable. */
enum api_problem_id api_columns_open(const struct api_reader *reader, struct api_columns *columns,
                                     struct api_problem *problem) STATUS_MUST_USE;

/* Whether all bytes that the header speaks of are there. Until then its counts of rows, which need
 * no bytes where a column repeats one value, are not to be relied on. */
bool api_columns_whole(const struct api_reader *reader, const struct api_columns *columns);

/* The rows first .. first + count - 1 of a column; false when they cannot be read, or when one is
 * no number that the writer accepts. */
bool api_columns_read(const struct api_reader *reader, const struct api_column *column,
                      size_t first, size_t count, double *values) STATUS_MUST_USE;

#endif
