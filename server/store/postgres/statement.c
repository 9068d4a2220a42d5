/* SPDX-License-Identifier: MIT */
#include "statement.h"
#include "pool.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/metrics.h"
#include <libpq-fe.h>
#include <stdio.h>
#include <string.h>

enum {
    NAME_SIZE = 24,
    TRIES = 4 /* of a statement: lost connections, deadlocks, a pooler's surprises */
};

/* What the server calls its types. */
enum {
    TYPE_BOOL = 16,
    TYPE_BYTEA = 17,
    TYPE_INT8 = 20,
    TYPE_INT2 = 21,
    TYPE_INT4 = 23,
    TYPE_TEXT = 25,
    TYPE_FLOAT8 = 701
};

/* ------------------------------------------------------------------ errors */

static const char *sqlstate_of(const PGresult *result) {
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

/* NULL: the connection is lost. */
static PGresult *execute(struct pool *pool, struct pool_connection *connection,
                         const struct query *query) {
    static const Oid types[] = {[QUERY_INT] = TYPE_INT8,
                                [QUERY_REAL] = TYPE_FLOAT8,
                                [QUERY_TEXT] = TYPE_TEXT,
                                [QUERY_BYTES] = TYPE_BYTEA};
    struct {
        Oid types[QUERY_PARAMETERS];
        const char *values[QUERY_PARAMETERS];
        int lengths[QUERY_PARAMETERS], formats[QUERY_PARAMETERS];
        char numbers[QUERY_PARAMETERS][8];
    } a;
    PGconn *libpq = connection->libpq;
    char name[NAME_SIZE];
    uint64_t hash = UINT64_C(14695981039346656037);
    int64_t until = clock_ms() + pool_patience_ms(pool);
    bool nameless = pool_nameless(pool), ready = nameless;
    for (int k = 0; k < query->bound; k++) {
        const struct query_value *value = &query->values[k];
        uint64_t bits = (uint64_t)value->integer;
        if (value->kind == QUERY_REAL)
            memcpy(&bits, &value->real, sizeof bits);
        for (int n = 0; n < 8; n++) /* numbers travel with the highest byte first */
            a.numbers[k][n] = (char)(bits >> (56 - 8 * n));
        bool number = value->kind == QUERY_INT || value->kind == QUERY_REAL;
        a.types[k] = types[value->kind];
        a.values[k] = value->null ? NULL : number ? a.numbers[k] : value->bytes;
        a.lengths[k] = number ? 8 : (int)value->length;
        a.formats[k] = 1;
    }
    /* FNV-1a of the text: behind a pooler other processes of ours use the same connection, and the
     * same name must mean the same statement there. */
    for (const char *c = query->sql; *c; c++)
        hash = (hash ^ (unsigned char)*c) * UINT64_C(1099511628211);
    snprintf(name, sizeof name, "draped_%016llx", (unsigned long long)hash);
    for (size_t k = 0; k < connection->count && !ready; k++)
        ready = connection->prepared[k] == query->sql;
    if (!ready) {
        if (!PQsendPrepare(libpq, name, query->sql, query->bound, a.types))
            return NULL;
        PGresult *result = pool_receive(libpq, until);
        if (PQresultStatus(result) != PGRES_COMMAND_OK)
            return result;
        PQclear(result);
        if (connection->count < POOL_STATEMENTS)
            connection->prepared[connection->count++] = query->sql;
    }
    bool sent = nameless ? PQsendQueryParams(libpq, query->sql, query->bound, a.types, a.values,
                                             a.lengths, a.formats, 1)
                         : PQsendQueryPrepared(libpq, name, query->bound, a.values, a.lengths,
                                               a.formats, 1);
    return sent ? pool_receive(libpq, until) : NULL;
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
static enum verdict judge_answer(struct pool *pool, const PGresult *result, bool *lost) {
    ExecStatusType status = PQresultStatus(result);
    const char *state = sqlstate_of(result);
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

/* The first row comes with all tries of the statement. */
static bool pg_row(struct query *query) {
    static const enum store_answer answers[] = {
        [VERDICT_GOOD] = STORE_OK,       [VERDICT_TAKEN] = STORE_CONFLICT,
        [VERDICT_BUSY] = STORE_BUSY,     [VERDICT_DOWN] = STORE_DOWN,
        [VERDICT_FULL] = STORE_NO_SPACE, [VERDICT_READ_ONLY] = STORE_READ_ONLY,
        [VERDICT_AGAIN] = STORE_DOWN};
    struct pool *pool = query->connection;
    bool again = query->row++ == 0 && query->answer == STORE_OK;
    for (int tries = 1; again; tries++) {
        bool lost = false;
        struct pool_connection *connection = pool_take(pool, &query->answer);
        if (!connection)
            break;
        PGresult *result = execute(pool, connection, query);
        enum verdict verdict = judge_answer(pool, result, &lost);
        again = verdict == VERDICT_AGAIN && tries < TRIES;
        query->taken = verdict == VERDICT_TAKEN;
        query->answer = again ? STORE_OK : answers[verdict];
        if (verdict == VERDICT_DOWN || verdict == VERDICT_FULL || verdict == VERDICT_READ_ONLY ||
            (verdict == VERDICT_AGAIN && !again)) {
            char text[STORE_WHY_SIZE];
            pool_say(text, "%s", result ? message_of(result) : "the connection was lost");
            pool_hide_password(pool, text);
            log_error(log_event("store_failed"), log_text("error", text),
                      log_text("sqlstate", result ? sqlstate_of(result) : ""),
                      log_text("sql", query->sql));
        }
        pool_give(pool, connection, lost);
        if (verdict == VERDICT_GOOD)
            query->statement = result;
        else
            PQclear(result);
    }
    return query->statement && query->row <= PQntuples(query->statement);
}

static struct query_value pg_column(const struct query *query, int column) {
    const PGresult *result = query->statement;
    struct query_value value = {.null = PQgetisnull(result, query->row - 1, column) != 0};
    const char *bytes = PQgetvalue(result, query->row - 1, column);
    int length = PQgetlength(result, query->row - 1, column);
    uint64_t bits = 0;
    if (value.null)
        return value;
    for (int k = 0; k < length && k < 8; k++)
        bits = bits << 8 | (unsigned char)bytes[k];
    switch (PQftype(result, column)) {
    case TYPE_INT2:
        value.integer = (int16_t)bits;
        break;
    case TYPE_INT4:
        value.integer = (int32_t)bits;
        break;
    case TYPE_BOOL:
    case TYPE_INT8:
        value.integer = (int64_t)bits;
        break;
    case TYPE_FLOAT8:
        memcpy(&value.real, &bits, sizeof value.real);
        break;
    default: /* libpq adds a zero */
        value.bytes = bytes;
        value.length = (size_t)length;
    }
    return value;
}

static enum store_answer pg_end(struct query *query) {
    PQclear(query->statement);
    query->statement = NULL;
    if (store_failed(query->answer))
        metrics_store_failed(query->answer == STORE_BUSY);
    return query->answer;
}

struct query pg_query(void *pool, const char *sql) {
    static const struct query_driver driver = {pg_row, pg_column, pg_end};
    return (struct query){.driver = &driver, .connection = pool, .sql = sql};
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
    enum verdict verdict = judge_answer(pool, result, &lost);
    if (verdict != VERDICT_GOOD) {
        pool_say(why, "%s: %s",
                 among(sqlstate_of(result), "42501") ? "this user of the database has no privilege"
                                                     : "the database refuses",
                 result ? message_of(result) : "the connection was lost");
        pool_hide_password(pool, why);
    }
    if (taken)
        *taken = verdict == VERDICT_TAKEN;
    PQclear(result);
    pool_give(pool, connection, lost);
    return verdict == VERDICT_GOOD;
}
