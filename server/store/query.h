/* SPDX-License-Identifier: MIT */
/*
 * One execution of a statement on either database. It is used like this: begun by `db_query`
 * (SQLite), `pg_query` (PostgreSQL) or `reads.h` (either), the binds in order, `query_row` while
 * there are rows, `query_end`. After a failure everything is a no-op until `query_end` reports it,
 * so that only one place has to look.
 *
 * A statement that both databases read has its tables in the schema `draped`, which SQLite's
 * connections call their only one, and its parameters as $1, $2, ..., of which each first appears
 * after those before it: SQLite numbers them so.
 */
#ifndef SERVER_STORE_QUERY_H
#define SERVER_STORE_QUERY_H

#include "answer.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct query;
struct store;

enum { QUERY_PARAMETERS = 24 }; /* of a statement, at the most */

enum query_kind { QUERY_NULL, QUERY_INT, QUERY_REAL, QUERY_TEXT, QUERY_BYTES };

/* A parameter or a column. */
struct query_value {
    enum query_kind kind;
    bool null; /* of that kind */
    int64_t integer;
    double real;
    const void *bytes; /* text and bytes; NULL is SQL's null */
    size_t length;
};

/* What a database does for a statement. */
struct query_driver {
    /* Binds the parameters and executes it, then goes on; false at the end and at a failure. */
    bool (*row)(struct query *query);
    struct query_value (*column)(const struct query *query, int column);
    enum store_answer (*end)(struct query *query);
};

/* The fields are the driver's, but for `taken`. */
struct query {
    const struct query_driver *driver;
    void *connection;     /* struct db, or struct pool */
    struct store *lender; /* of the connection, who gets it back by `give_back`; or NULL */
    void (*give_back)(struct query *query);
    const char *sql;
    void *statement; /* SQLite's, or PostgreSQL's rows */
    int row;         /* rows so far */
    int bound;       /* parameters so far */
    struct query_value values[QUERY_PARAMETERS];
    int code; /* SQLite's */
    enum store_answer answer;
    bool no_memory;
    bool taken; /* PostgreSQL: STORE_CONFLICT because something unique was there already */
};

/* Parameters. NULL is SQL's null, and so is `of_no_int`. */
struct query_value of_int(int64_t value);
struct query_value of_no_int(void);
struct query_value of_real(double value);
struct query_value of_text(const char *text);
struct query_value of_bytes(const void *bytes, size_t length);

/* Sets the next parameters, as of_int(1), of_text("a"), ...; memory is the caller's until the first
 * row. */
#define query_bind(query, ...)                                                                     \
    query_bind_values(query, (const struct query_value[]){__VA_ARGS__},                            \
                      sizeof((const struct query_value[]){__VA_ARGS__}) /                          \
                          sizeof(struct query_value))
void query_bind_values(struct query *query, const struct query_value *values, size_t count);

/* Goes on to the next row, or executes; false at the end and at a failure. */
bool query_row(struct query *query);

/* Whether a column of the current row is SQL's null. */
bool query_is_null(const struct query *query, int column);

/* Columns of the current row, from 0; memory is valid until the next row. Null is 0, NULL or "". */
int64_t query_int(const struct query *query, int column);
double query_real(const struct query *query, int column);
const char *query_text(const struct query *query, int column);
const void *query_bytes(const struct query *query, int column, size_t *length);

/* Copies a text into an array, cut to its size. */
void query_copy(const struct query *query, int column, char *to, size_t size);

/* A malloc'ed, zero-terminated copy in `*to` (NULL for null); no memory fails the query. `length`
 * may be NULL. */
void query_duplicate(struct query *query, int column, char **to, size_t *length);

/* STORE_OK, or how the database failed (logged). */
enum store_answer query_end(struct query *query);

/* The same; `none` when it went well and nothing was found. */
enum store_answer query_end_found(struct query *query, bool found, enum store_answer none);

/* Takes a number from the first row, 0 without one; `none` when it went well and there is none. */
enum store_answer query_number(struct query *query, enum store_answer none, int64_t *number);

/* Executes a statement that gives no rows, or of whose rows it matters only whether there is one:
 * else the answer is `none`. */
enum store_answer query_run(struct query *query);
enum store_answer query_find(struct query *query, enum store_answer none);

#endif
