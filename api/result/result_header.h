/* SPDX-License-Identifier: MIT */
/*
 * The header of a result: the summary, the grid, the start and what columns there are, as a JSON
 * object. Where the columns lie follows from it (`columns.c`).
 */
#ifndef API_RESULT_RESULT_HEADER_H
#define API_RESULT_RESULT_HEADER_H

#include "api/request/normalise.h"
#include "api/request/request.h"
#include "column_list.h"
#include "study_summary.h"
#include "summary.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct api_text;
struct json_tree;

enum { API_COLUMNS_MAX = 160, API_COLUMN_NAME_SIZE = 32 };

/* How the values of a column are stored, little-endian. */
#define API_FORM_LIST(X)                                                                           \
    X(FLOAT64, "float64")                                                                          \
    X(INT8, "int8")                                                                                \
    X(INT16, "int16")                                                                              \
    X(INT32, "int32")                                                                              \
    X(REPEATED, "repeated") /* all rows have the one float64 that is stored */
enum api_form {
#define X(id, name) API_FORM_##id,
    API_FORM_LIST(X)
#undef X
        API_FORM_COUNT
};

/* A column of the stored result. Numbers stand for names in one place: front.reason holds
 * `enum drape_reason`. */
struct api_column {
    enum api_table table;
    char name[API_COLUMN_NAME_SIZE];
    bool integer; /* every value is a whole number within 2^53 */
    enum api_form form;
    size_t rows;     /* the same for all columns of a table */
    uint64_t offset; /* of its first value, from the start of the container */
};

struct api_grid {
    int warp[2], weft[2]; /* least and greatest i and j */
    double spacing[2];
};

/* What a container is the result of. */
enum api_document { API_DOCUMENT_DRAPE, API_DOCUMENT_STUDY };

/* The header of a result. */
struct api_columns {
    enum api_document document;
    struct api_study_summary study; /* of a study, which has no summary, grid and start */
    struct api_summary summary;
    struct api_grid grid;
    struct api_start start;
    const struct api_unit *unit; /* of lengths; NULL when writing: the default */
    size_t cut_count;            /* of a drape, */
    char cut_names[API_CUTS_MAX][API_CUT_NAME_MAX + 1]; /* and how they are called */
    size_t count;
    struct api_column column[API_COLUMNS_MAX];
    uint64_t length; /* of the whole container */
};

/* The column of that table and name, or NULL. */
const struct api_column *api_columns_find(const struct api_columns *columns, enum api_table table,
                                          const char *name);

/* The rows that every column of the table has. */
size_t api_columns_rows(const struct api_columns *columns, enum api_table table);

/* The summary of a drape or study as a malloc'ed string that the caller frees, with no time of
 * waiting; NULL without memory. */
char *api_columns_summary_json(const struct api_columns *columns);

/* The contract's `grid`. */
void result_header_write_grid(struct api_text *text, const struct api_grid *grid);

/* The whole header. */
void result_header_write(struct api_text *text, const struct api_columns *columns);

/* The columns that the header `text`, a zero-terminated string, lists at its end, but for their
 * offsets. Takes that list out of it, so that parsing the rest is quick: the list is three quarters
 * of it, and is read as `result_header_write` writes it and in no other form. False when it is not
 * so.
 */
bool result_header_take_columns(char *text, struct api_columns *columns) STATUS_MUST_USE;

/* Reads the rest into `columns`, which has been zero-initialised; what is wrong is reported to the
 * tree's problem. */
void result_header_read(const struct json_tree *tree, struct api_columns *columns);

#endif
