/* SPDX-License-Identifier: MIT */
#include "query.h"
#include "pool.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/metrics.h"
#include <libpq-fe.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    NAME_SIZE = 24,
    TRIES = 4 /* of a statement: lost connections, deadlocks, a pooler's surprises */
};

/* What the server calls its types. */
enum kind { KIND_BYTES = 17, KIND_INT = 20, KIND_TEXT = 25, KIND_REAL = 701 };

/* ------------------------------------------------------------------ errors */

static const char *state_of(const PGresult *result) {
    const char *state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
    return state ? state : "";
}

static const char *message_of(const PGresult *result) {
    const char *message = PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
    return message ? message : PQresultErrorMessage(result);
}

static bool among(const char *state, const char *states) {
    return state[0] && strstr(states, state);
}

/* ------------------------------------------------------------------ running */

/* FNV-1a of the text: behind a pooler other processes of ours use the same connection, and the
 * same name must mean the same statement there. */
static void name_of(const char *sql, char name[NAME_SIZE]) {
    uint64_t hash = UINT64_C(14695981039346656037);
    for (const char *c = sql; *c; c++)
        hash = (hash ^ (unsigned char)*c) * UINT64_C(1099511628211);
    snprintf(name, NAME_SIZE, "draped_%016llx", (unsigned long long)hash);
}

struct arguments {
    Oid types[PG_PARAMETERS];
    const char *values[PG_PARAMETERS];
    int lengths[PG_PARAMETERS];
    int formats[PG_PARAMETERS];
};

static void lay_out(const struct pg_query *query, struct arguments *arguments) {
    for (int k = 0; k < query->bound; k++) {
        const struct pg_parameter *parameter = &query->parameters[k];
        bool number = parameter->kind == KIND_INT || parameter->kind == KIND_REAL;
        bool null = !number && !parameter->bytes;
        const void *value = number ? parameter->number : parameter->bytes;
        arguments->types[k] = (Oid)parameter->kind;
        arguments->values[k] = null || (number && parameter->length == 0) ? NULL : value;
        arguments->lengths[k] = (int)parameter->length;
        arguments->formats[k] = 1;
    }
}

/* Prepares the statement on the connection if it is not yet. NULL: it is; else what failed. */
static bool prepare(struct pool_connection *connection, const struct pg_query *query,
                    const struct arguments *arguments, const char *name, int64_t until_ms,
                    PGresult **failed) {
    *failed = NULL;
    for (size_t k = 0; k < connection->count; k++)
        if (connection->prepared[k] == query->sql)
            return true;
    if (!PQsendPrepare(connection->libpq, name, query->sql, query->bound, arguments->types))
        return false;
    PGresult *result = pool_receive(connection->libpq, until_ms);
    if (PQresultStatus(result) != PGRES_COMMAND_OK) {
        *failed = result;
        return false;
    }
    PQclear(result);
    if (connection->count < POOL_STATEMENTS)
        connection->prepared[connection->count++] = query->sql;
    return true;
}

/* NULL: the connection is lost. */
static PGresult *execute(struct pool *pool, struct pool_connection *connection,
                         const struct pg_query *query) {
    struct arguments a;
    char name[NAME_SIZE];
    PGresult *failed = NULL;
    int64_t until = clock_ms() + pool_patience_ms(pool);
    bool nameless = pool_nameless(pool);
    lay_out(query, &a);
    name_of(query->sql, name);
    if (!nameless && !prepare(connection, query, &a, name, until, &failed))
        return failed;
    bool sent = nameless ? PQsendQueryParams(connection->libpq, query->sql, query->bound, a.types,
                                             a.values, a.lengths, a.formats, 1)
                         : PQsendQueryPrepared(connection->libpq, name, query->bound, a.values,
                                               a.lengths, a.formats, 1);
    return sent ? pool_receive(connection->libpq, until) : NULL;
}

enum verdict {
    VERDICT_GOOD,
    VERDICT_TAKEN,
    VERDICT_BUSY,
    VERDICT_DOWN,
    VERDICT_FULL,
    VERDICT_READ_ONLY,
    VERDICT_AGAIN
};

/* What to make of an answer; `*lost`: the connection is not to be used again. */
static enum verdict judge(struct pool *pool, const PGresult *result, bool *lost) {
    ExecStatusType status = PQresultStatus(result);
    const char *state = state_of(result);
    *lost = !result;
    if (!result)
        return VERDICT_AGAIN;
    if (status == PGRES_TUPLES_OK || status == PGRES_COMMAND_OK)
        return VERDICT_GOOD;
    if (among(state, "23505"))
        return VERDICT_TAKEN;
    if (among(state, "40001 40P01")) /* it stood in another's way and was undone */
        return VERDICT_AGAIN;
    if (among(state, "55P03 57014"))
        return VERDICT_BUSY;
    if (among(state, "26000 42P05")) { /* prepared statements do not stay, or are another's */
        pool_set_nameless(pool);
        return VERDICT_AGAIN;
    }
    /* The server goes down, or has become a replica that cannot be written. */
    *lost = among(state, "25006 57P01 57P02 57P03") || !strncmp(state, "08", 2);
    if (among(state, "53100"))
        return VERDICT_FULL;
    if (among(state, "25006"))
        return VERDICT_READ_ONLY;
    return *lost ? VERDICT_AGAIN : VERDICT_DOWN;
}

static void note_failure(const struct pool *pool, const struct pg_query *query,
                         const PGresult *result) {
    char text[STORE_WHY_SIZE];
    pool_say(text, "%s", result ? message_of(result) : "the connection was lost");
    pool_hide_password(pool, text);
    log_error(log_event("store_failed"), log_text("error", text),
              log_text("sqlstate", result ? state_of(result) : ""), log_text("sql", query->sql));
}

size_t pg_run(struct pg_query *query) {
    static const enum store_answer answers[] = {
        [VERDICT_GOOD] = STORE_OK,       [VERDICT_TAKEN] = STORE_CONFLICT,
        [VERDICT_BUSY] = STORE_BUSY,     [VERDICT_DOWN] = STORE_DOWN,
        [VERDICT_FULL] = STORE_NO_SPACE, [VERDICT_READ_ONLY] = STORE_READ_ONLY,
        [VERDICT_AGAIN] = STORE_DOWN};
    struct pool *pool = query->pool;
    for (int k = 0; k < TRIES && query->answer == STORE_OK; k++) {
        bool lost = false;
        struct pool_connection *connection = pool_take(pool, &query->answer);
        if (!connection)
            return 0;
        PGresult *result = execute(pool, connection, query);
        enum verdict verdict = judge(pool, result, &lost);
        query->answer = answers[verdict];
        query->taken = verdict == VERDICT_TAKEN;
        if (verdict == VERDICT_GOOD)
            query->result = result;
        else if (verdict == VERDICT_DOWN || verdict == VERDICT_FULL ||
                 verdict == VERDICT_READ_ONLY || (verdict == VERDICT_AGAIN && k == TRIES - 1))
            note_failure(pool, query, result);
        pool_give(pool, connection, lost);
        if (verdict == VERDICT_GOOD)
            return (size_t)PQntuples(result);
        PQclear(result);
        if (verdict == VERDICT_AGAIN && k < TRIES - 1)
            query->answer = STORE_OK;
    }
    return 0;
}

enum store_answer pg_end(struct pg_query *query) {
    PQclear(query->result);
    query->result = NULL;
    if (store_failed(query->answer))
        metrics_store_failed(query->answer == STORE_BUSY);
    return query->answer;
}

static void explain(const struct pool *pool, char why[STORE_WHY_SIZE], const PGresult *result) {
    pool_say(why, "%s: %s",
             among(state_of(result), "42501") ? "this user of the database has no privilege"
                                              : "the database refuses",
             result ? message_of(result) : "the connection was lost");
    pool_hide_password(pool, why);
}

bool pg_script(struct pool *pool, const char *sql, bool *taken, char why[STORE_WHY_SIZE]) {
    enum store_answer answer;
    bool lost = true;
    struct pool_connection *connection = pool_take(pool, &answer);
    if (!connection) {
        pool_say(why, "the database cannot be reached");
        return false;
    }
    PGresult *result =
        PQsendQuery(connection->libpq, sql)
            ? pool_receive(connection->libpq, clock_ms() + 20 * pool_patience_ms(pool))
            : NULL;
    enum verdict verdict = judge(pool, result, &lost);
    if (verdict != VERDICT_GOOD)
        explain(pool, why, result);
    if (taken)
        *taken = verdict == VERDICT_TAKEN;
    PQclear(result);
    pool_give(pool, connection, lost);
    return verdict == VERDICT_GOOD;
}

/* ------------------------------------------------------------------ parameters and rows */

struct pg_query pg_query(struct pool *pool, const char *sql) {
    return (struct pg_query){.pool = pool, .sql = sql};
}

static struct pg_parameter *next(struct pg_query *query, enum kind kind) {
    struct pg_parameter *parameter = &query->parameters[query->bound++];
    parameter->kind = kind;
    return parameter;
}

/* Numbers travel with the highest byte first. */
static void put_number(struct pg_parameter *parameter, uint64_t bits) {
    for (int k = 0; k < 8; k++)
        parameter->number[k] = (unsigned char)(bits >> (56 - 8 * k));
    parameter->length = sizeof parameter->number;
}

void pg_bind_int(struct pg_query *query, int64_t value) {
    put_number(next(query, KIND_INT), (uint64_t)value);
}

void pg_bind_no_int(struct pg_query *query) {
    next(query, KIND_INT)->length = 0;
}

void pg_bind_real(struct pg_query *query, double value) {
    uint64_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    put_number(next(query, KIND_REAL), bits);
}

void pg_bind_text(struct pg_query *query, const char *value) {
    struct pg_parameter *parameter = next(query, KIND_TEXT);
    parameter->bytes = value;
    parameter->length = value ? strlen(value) : 0;
}

void pg_bind_bytes(struct pg_query *query, const void *bytes, size_t length) {
    struct pg_parameter *parameter = next(query, KIND_BYTES);
    parameter->bytes = bytes ? bytes : "";
    parameter->length = length;
}

static uint64_t get_number(const struct pg_query *query, size_t row, int column, int *length) {
    const unsigned char *bytes = (const unsigned char *)PQgetvalue(query->result, (int)row, column);
    uint64_t bits = 0;
    *length = PQgetlength(query->result, (int)row, column);
    for (int k = 0; k < *length && k < 8; k++)
        bits = bits << 8 | bytes[k];
    return bits;
}

int64_t pg_int(const struct pg_query *query, size_t row, int column) {
    int length = 0;
    uint64_t bits = get_number(query, row, column, &length);
    switch (length) {
    case 2:
        return (int16_t)bits;
    case 4:
        return (int32_t)bits;
    default:
        return (int64_t)bits;
    }
}

double pg_real(const struct pg_query *query, size_t row, int column) {
    int length = 0;
    double value = 0;
    uint64_t bits = get_number(query, row, column, &length);
    memcpy(&value, &bits, sizeof value);
    return value;
}

const char *pg_text(const struct pg_query *query, size_t row, int column) {
    return PQgetisnull(query->result, (int)row, column)
               ? NULL
               : PQgetvalue(query->result, (int)row, column);
}

const void *pg_bytes(const struct pg_query *query, size_t row, int column, size_t *length) {
    *length = (size_t)PQgetlength(query->result, (int)row, column);
    return pg_text(query, row, column);
}

void pg_copy(const struct pg_query *query, size_t row, int column, char *to, size_t size) {
    const char *text = pg_text(query, row, column);
    snprintf(to, size, "%s", text ? text : "");
}

void pg_duplicate(struct pg_query *query, size_t row, int column, char **to, size_t *length) {
    size_t size = 0;
    const void *bytes = pg_bytes(query, row, column, &size);
    *to = bytes ? malloc(size + 1) : NULL;
    if (!bytes)
        return;
    if (!*to) {
        query->answer = STORE_DOWN;
        return;
    }
    memcpy(*to, bytes, size + 1); /* libpq adds a zero */
    if (length)
        *length = size;
}
