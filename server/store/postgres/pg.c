/* SPDX-License-Identifier: MIT */
#include "pg.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/metrics.h"
#include <errno.h>
#include <libpq-fe.h>
#include <poll.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    VERSION_MIN = 130000,
    STATEMENTS = 64, /* prepared ones a connection; the backend has about 50 */
    NAME_SIZE = 24,
    IDLE_MS = 60000, /* a connection unused for so long is closed */
    BACK_OFF_FIRST_MS = 100,
    BACK_OFF_MOST_MS = 5000,
    TRIES = 4 /* of a statement: lost connections, deadlocks, a pooler's surprises */
};

/* What the server calls its types. */
enum kind { KIND_BYTES = 17, KIND_INT = 20, KIND_TEXT = 25, KIND_REAL = 701 };

struct link {
    PGconn *connection;
    unsigned generation; /* of the pool when it was made */
    int64_t used_ms;     /* when it was given back */
    size_t count;
    const char *prepared[STATEMENTS];
};

struct pg {
    char *url;
    char *password; /* NULL without; to be kept out of messages */
    int64_t patience_ms;
    atomic_bool nameless; /* a pooler does not know prepared statements */

    pthread_mutex_t lock;
    pthread_cond_t back; /* a link was given back */
    struct link *idle[PG_LINKS];
    size_t idle_count, open;
    unsigned generation; /* grows when connections turn out to be lost */
    bool down, trying;   /* the last try failed; a thread tries now */
    int64_t back_off_ms, try_at_ms;
};

/* ------------------------------------------------------------------ messages */

static void say(char why[STORE_WHY_SIZE], const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* One line, without the end of line that libpq adds. */
static void say(char why[STORE_WHY_SIZE], const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, STORE_WHY_SIZE, format, arguments);
    va_end(arguments);
    for (char *c = why; *c; c++)
        if (*c == '\n' || *c == '\t')
            *c = c[1] ? ' ' : '\0';
}

/* A server may quote what it was sent. */
static void hide_password(const struct pg *pg, char *text) {
    size_t length = pg->password ? strlen(pg->password) : 0;
    for (char *found = text; length > 0 && (found = strstr(found, pg->password)) != NULL;)
        memset(found, '*', length);
}

static void explain(const struct pg *pg, char why[STORE_WHY_SIZE], const char *what,
                    const char *message) {
    say(why, "%s: %s", what, message);
    hide_password(pg, why);
}

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

/* ------------------------------------------------------------------ the URL */

static bool plain(const char *value, const char *forbidden) {
    return !value || !strpbrk(value, forbidden);
}

/* A password with an unescaped @ or / shifts what follows, and pieces of it would be taken, and
 * told, for a host or a database. So would libpq's message about what it cannot read. */
static bool read_url(struct pg *pg, char why[STORE_WHY_SIZE]) {
    PQconninfoOption *options = PQconninfoParse(pg->url, NULL);
    bool good = options != NULL;
    for (PQconninfoOption *option = options; option && option->keyword; option++) {
        if (!strcmp(option->keyword, "password") && option->val && option->val[0])
            pg->password = strdup(option->val);
        else if (!strcmp(option->keyword, "port"))
            good = good && (!option->val || option->val[strspn(option->val, "0123456789,")] == 0);
        else if (!strcmp(option->keyword, "dbname"))
            good = good && plain(option->val, "@");
        else if (!strcmp(option->keyword, "host"))
            good = good && (plain(option->val, "@") || option->val[0] == '/');
    }
    PQconninfoFree(options);
    if (!good)
        say(why, "the URL of the store cannot be read: it is postgresql://USER:PASSWORD@HOST:PORT/"
                 "DATABASE, with %%40 for an @, %%2F for a / and %%25 for a %% in the password");
    return good;
}

/* ------------------------------------------------------------------ connections */

static void link_free(struct link *link) {
    if (!link)
        return;
    PQfinish(link->connection);
    free(link);
}

/* Without this libpq would write them on stderr, where the log is. */
static void take_notice(void *context, const char *message) {
    (void)context;
    log_debug(log_event("store_notice"), log_text("text", message));
}

static PGconn *connect_to(const struct pg *pg) {
    static const char *const names[] = {
        "fallback_application_name", "connect_timeout", "keepalives_idle", "keepalives_interval",
        "keepalives_count",          "client_encoding", "dbname",          NULL};
    const char *const values[] = {"draped", "5", "10", "5", "3", "UTF8", pg->url, NULL};
    PGconn *connection = PQconnectdbParams(names, values, 1); /* the URL comes last and wins */
    PQsetNoticeProcessor(connection, take_notice, NULL);
    return connection;
}

/* A lock is waited for a little less long than an answer. */
static bool set_lock_timeout(const struct pg *pg, PGconn *connection) {
    char sql[64];
    snprintf(sql, sizeof sql, "SET lock_timeout = %lld", (long long)pg->patience_ms * 4 / 5);
    PGresult *result = PQexec(connection, sql);
    bool good = PQresultStatus(result) == PGRES_COMMAND_OK;
    PQclear(result);
    return good;
}

static struct link *link_new(const struct pg *pg, char why[STORE_WHY_SIZE]) {
    struct link *link = calloc(1, sizeof *link);
    if (!link) {
        say(why, "no memory for a connection");
        return NULL;
    }
    link->connection = connect_to(pg);
    if (PQstatus(link->connection) != CONNECTION_OK || !set_lock_timeout(pg, link->connection))
        explain(pg, why, "the database cannot be used", PQerrorMessage(link->connection));
    else if (PQserverVersion(link->connection) < VERSION_MIN)
        say(why, "the database server is PostgreSQL %d, and 13 is the oldest that will do",
            PQserverVersion(link->connection) / 10000);
    else if (PQsetnonblocking(link->connection, 1) == 0)
        return link;
    link_free(link);
    return NULL;
}

/* After a failure: who calls before the next try is due is answered at once, so that the threads
 * which serve callers do not all stand and wait. */
static void note_try(struct pg *pg, bool good) {
    pg->trying = false;
    pg->down = !good;
    int64_t next = pg->back_off_ms * 2;
    pg->back_off_ms = good                       ? 0
                      : next < BACK_OFF_FIRST_MS ? BACK_OFF_FIRST_MS
                      : next > BACK_OFF_MOST_MS  ? BACK_OFF_MOST_MS
                                                 : next;
    pg->try_at_ms = clock_ms() + pg->back_off_ms;
}

/* A new connection; the lock is held and given up meanwhile. */
static struct link *open_link(struct pg *pg) {
    char why[STORE_WHY_SIZE] = "";
    bool was_down = pg->down;
    unsigned generation = pg->generation;
    pg->open++;
    pg->trying = pg->down;
    pthread_mutex_unlock(&pg->lock);
    struct link *link = link_new(pg, why);
    if (!link)
        log_warning(log_event("store_unreachable"), log_text("why", why));
    else if (was_down)
        log_info(log_event("store_reached"));
    pthread_mutex_lock(&pg->lock);
    note_try(pg, link != NULL);
    if (link)
        link->generation = generation;
    else
        pg->open--;
    pthread_cond_signal(&pg->back);
    return link;
}

/* A connection, or NULL with an answer. */
static struct link *take(struct pg *pg, enum store_answer *answer) {
    struct timespec until = clock_after_ms(pg->patience_ms);
    struct link *link = NULL;
    int code = 0;
    *answer = STORE_DOWN;
    pthread_mutex_lock(&pg->lock);
    while (pg->idle_count == 0 && pg->open == PG_LINKS && code == 0)
        code = pthread_cond_timedwait(&pg->back, &pg->lock, &until);
    if (pg->idle_count > 0)
        link = pg->idle[--pg->idle_count];
    else if (pg->open == PG_LINKS)
        *answer = STORE_BUSY;
    else if (!pg->down || (!pg->trying && clock_ms() >= pg->try_at_ms))
        link = open_link(pg);
    pthread_mutex_unlock(&pg->lock);
    return link;
}

/* Takes out the one that was used longest ago if that is long enough; the lock is held. */
static struct link *take_stale(struct pg *pg) {
    if (pg->idle_count < 2 || clock_ms() - pg->idle[0]->used_ms < IDLE_MS)
        return NULL;
    struct link *stale = pg->idle[0];
    memmove(pg->idle, pg->idle + 1, --pg->idle_count * sizeof *pg->idle);
    pg->open--;
    return stale;
}

/* The last one used is used next. One that was lost takes along those made before: what cut it has
 * cut them. */
static void give(struct pg *pg, struct link *link, bool lost) {
    struct link *drop[PG_LINKS + 1] = {0};
    size_t count = 0;
    pthread_mutex_lock(&pg->lock);
    if (lost && link->generation == pg->generation) {
        pg->generation++;
        while (pg->idle_count > 0)
            drop[count++] = pg->idle[--pg->idle_count];
        pg->open -= count;
    }
    if (link->generation == pg->generation) {
        link->used_ms = clock_ms();
        pg->idle[pg->idle_count++] = link;
        drop[count++] = take_stale(pg);
    } else {
        drop[count++] = link;
        pg->open--;
    }
    pthread_cond_broadcast(&pg->back);
    pthread_mutex_unlock(&pg->lock);
    for (size_t k = 0; k < count; k++)
        link_free(drop[k]);
}

/* ------------------------------------------------------------------ running */

/* Waits until the answer is complete; false when the connection is lost or the time is over. */
static bool wait_answer(PGconn *connection, int64_t until_ms) {
    int unsent = PQflush(connection);
    while (unsent > 0 || PQisBusy(connection)) {
        struct pollfd file = {.fd = PQsocket(connection),
                              .events = (short)(POLLIN | (unsent > 0 ? POLLOUT : 0))};
        int64_t left = until_ms - clock_ms();
        int ready = left > 0 ? poll(&file, 1, (int)left) : 0;
        if (ready == 0 || (ready < 0 && errno != EINTR) || !PQconsumeInput(connection))
            return false;
        unsent = PQflush(connection);
    }
    return unsent == 0;
}

/* The last result of what was sent, or the first that failed. NULL: the connection is lost. */
static PGresult *receive(PGconn *connection, int64_t until_ms) {
    PGresult *kept = NULL;
    bool good = true;
    while ((good = wait_answer(connection, until_ms))) {
        PGresult *next = PQgetResult(connection);
        if (!next)
            break;
        bool failed = PQresultStatus(kept) == PGRES_FATAL_ERROR && kept;
        PQclear(failed ? next : kept);
        kept = failed ? kept : next;
    }
    if (good && PQstatus(connection) == CONNECTION_OK)
        return kept;
    PQclear(kept);
    return NULL;
}

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
static bool prepare(struct link *link, const struct pg_query *query,
                    const struct arguments *arguments, const char *name, int64_t until_ms,
                    PGresult **failed) {
    *failed = NULL;
    for (size_t k = 0; k < link->count; k++)
        if (link->prepared[k] == query->sql)
            return true;
    if (!PQsendPrepare(link->connection, name, query->sql, query->bound, arguments->types))
        return false;
    PGresult *result = receive(link->connection, until_ms);
    if (PQresultStatus(result) != PGRES_COMMAND_OK) {
        *failed = result;
        return false;
    }
    PQclear(result);
    if (link->count < STATEMENTS)
        link->prepared[link->count++] = query->sql;
    return true;
}

/* NULL: the connection is lost. */
static PGresult *execute(struct pg *pg, struct link *link, const struct pg_query *query) {
    struct arguments a;
    char name[NAME_SIZE];
    PGresult *failed = NULL;
    int64_t until = clock_ms() + pg->patience_ms;
    bool nameless = atomic_load(&pg->nameless);
    lay_out(query, &a);
    name_of(query->sql, name);
    if (!nameless && !prepare(link, query, &a, name, until, &failed))
        return failed;
    bool sent = nameless ? PQsendQueryParams(link->connection, query->sql, query->bound, a.types,
                                             a.values, a.lengths, a.formats, 1)
                         : PQsendQueryPrepared(link->connection, name, query->bound, a.values,
                                               a.lengths, a.formats, 1);
    return sent ? receive(link->connection, until) : NULL;
}

enum verdict { VERDICT_GOOD, VERDICT_TAKEN, VERDICT_BUSY, VERDICT_DOWN, VERDICT_AGAIN };

/* What to make of an answer; `*lost`: the connection is not to be used again. */
static enum verdict judge(struct pg *pg, const PGresult *result, bool *lost) {
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
        atomic_store(&pg->nameless, true);
        return VERDICT_AGAIN;
    }
    /* The server goes down, or has become a replica that cannot be written. */
    *lost = among(state, "25006 57P01 57P02 57P03") || !strncmp(state, "08", 2);
    return *lost && strcmp(state, "25006") ? VERDICT_AGAIN : VERDICT_DOWN;
}

static void note_failure(const struct pg *pg, const struct pg_query *query,
                         const PGresult *result) {
    char text[STORE_WHY_SIZE];
    say(text, "%s", result ? message_of(result) : "the connection was lost");
    hide_password(pg, text);
    log_error(log_event("store_failed"), log_text("error", text),
              log_text("sqlstate", result ? state_of(result) : ""), log_text("sql", query->sql));
}

size_t pg_run(struct pg_query *query) {
    static const enum store_answer answers[] = {STORE_OK, STORE_CONFLICT, STORE_BUSY, STORE_DOWN,
                                                STORE_DOWN};
    struct pg *pg = query->pg;
    for (int k = 0; k < TRIES && query->answer == STORE_OK; k++) {
        bool lost = false;
        struct link *link = take(pg, &query->answer);
        if (!link)
            return 0;
        PGresult *result = execute(pg, link, query);
        enum verdict verdict = judge(pg, result, &lost);
        query->answer = answers[verdict];
        query->taken = verdict == VERDICT_TAKEN;
        if (verdict == VERDICT_GOOD)
            query->result = result;
        else if (verdict == VERDICT_DOWN || (verdict == VERDICT_AGAIN && k == TRIES - 1))
            note_failure(pg, query, result);
        give(pg, link, lost);
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
    if (query->answer == STORE_BUSY || query->answer == STORE_DOWN)
        metrics_store_failed(query->answer == STORE_BUSY);
    return query->answer;
}

bool pg_script(struct pg *pg, const char *sql, bool *taken, char why[STORE_WHY_SIZE]) {
    enum store_answer answer;
    bool lost = true;
    struct link *link = take(pg, &answer);
    if (!link) {
        say(why, "the database cannot be reached");
        return false;
    }
    PGresult *result = PQsendQuery(link->connection, sql)
                           ? receive(link->connection, clock_ms() + 20 * pg->patience_ms)
                           : NULL;
    enum verdict verdict = judge(pg, result, &lost);
    if (verdict != VERDICT_GOOD)
        explain(pg, why,
                among(state_of(result), "42501") ? "this user of the database lacks a right"
                                                 : "the database refuses",
                result ? message_of(result) : "the connection was lost");
    if (taken)
        *taken = verdict == VERDICT_TAKEN;
    PQclear(result);
    give(pg, link, lost);
    return verdict == VERDICT_GOOD;
}

/* ------------------------------------------------------------------ parameters and rows */

struct pg_query pg_query(struct pg *pg, const char *sql) {
    return (struct pg_query){.pg = pg, .sql = sql};
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

/* ------------------------------------------------------------------ open and close */

static void set_up_locks(struct pg *pg) {
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&pg->lock, NULL);
    pthread_cond_init(&pg->back, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

/* What must be so for answers to mean what they say. */
static bool check_server(struct pg *pg, char why[STORE_WHY_SIZE]) {
    struct pg_query query = pg_query(pg, "SELECT pg_is_in_recovery() OR"
                                         " current_setting('default_transaction_read_only') = 'on',"
                                         " current_setting('synchronous_commit') = 'off'");
    size_t rows = pg_run(&query);
    bool read_only = rows && pg_int(&query, 0, 0);
    bool loose = rows && pg_int(&query, 0, 1);
    enum store_answer answer = pg_end(&query);
    if (answer != STORE_OK)
        say(why, "the database does not answer (see the log)");
    else if (read_only)
        say(why, "the database is a replica or set read-only: name the primary in the URL; with "
                 "several hosts there, add target_session_attrs=read-write");
    else if (loose)
        say(why, "the database has synchronous_commit off for this user, so that it would forget "
                 "what it has acknowledged: ALTER ROLE ... SET synchronous_commit = on");
    return answer == STORE_OK && !read_only && !loose;
}

/* The first connection tells why there is none. */
static bool connect_first(struct pg *pg, char why[STORE_WHY_SIZE]) {
    struct link *link = link_new(pg, why);
    if (!link)
        return false;
    pg->open = 1;
    give(pg, link, false);
    return check_server(pg, why);
}

struct pg *pg_open(const char *url, int64_t patience_ms, char why[STORE_WHY_SIZE]) {
    struct pg *pg = calloc(1, sizeof *pg);
    if (!pg) {
        say(why, "no memory for the database");
        return NULL;
    }
    set_up_locks(pg);
    pg->patience_ms = patience_ms;
    pg->url = strdup(url);
    if (pg->url && read_url(pg, why) && connect_first(pg, why))
        return pg;
    pg_close(pg);
    return NULL;
}

void pg_close(struct pg *pg) {
    if (!pg)
        return;
    while (pg->idle_count > 0)
        link_free(pg->idle[--pg->idle_count]);
    pthread_mutex_destroy(&pg->lock);
    pthread_cond_destroy(&pg->back);
    free(pg->password);
    free(pg->url);
    free(pg);
}

/* ------------------------------------------------------------------ notifications */

struct pg_ear {
    struct pg *pg;
    PGconn *connection; /* NULL without */
};

struct pg_ear *pg_ear_new(struct pg *pg) {
    struct pg_ear *ear = calloc(1, sizeof *ear);
    if (ear)
        ear->pg = pg;
    return ear;
}

static void hang_up(struct pg_ear *ear) {
    PQfinish(ear->connection);
    ear->connection = NULL;
}

void pg_ear_free(struct pg_ear *ear) {
    if (!ear)
        return;
    hang_up(ear);
    free(ear);
}

static bool listen_in(struct pg_ear *ear) {
    if (ear->connection)
        return true;
    ear->connection = connect_to(ear->pg);
    PGresult *result = PQexec(ear->connection, "LISTEN draped");
    bool good =
        PQresultStatus(result) == PGRES_COMMAND_OK && PQsetnonblocking(ear->connection, 1) == 0;
    PQclear(result);
    if (!good)
        hang_up(ear);
    return good;
}

/* What has been received; whether there was anything. */
static bool hear_all(struct pg_ear *ear, void (*hear)(void *context, const char *text),
                     void *context) {
    bool any = false;
    for (PGnotify *told = NULL; (told = PQnotifies(ear->connection)) != NULL; PQfreemem(told)) {
        any = true;
        if (told->be_pid != PQbackendPID(ear->connection))
            hear(context, told->extra);
    }
    return any;
}

bool pg_ear_wait(struct pg_ear *ear, int wake, int ms,
                 void (*hear)(void *context, const char *text), void *context) {
    if (!listen_in(ear))
        return false;
    struct pollfd files[2] = {{.fd = PQsocket(ear->connection), .events = POLLIN},
                              {.fd = wake, .events = POLLIN}};
    bool heard = hear_all(ear, hear, context); /* some came while we spoke */
    if (poll(files, 2, heard ? 0 : ms) <= 0 || !files[0].revents)
        return true;
    if (!PQconsumeInput(ear->connection)) {
        hang_up(ear);
        return false;
    }
    hear_all(ear, hear, context);
    return true;
}

/* In a transaction of its own, which writes nothing: the server lets only one transaction that
 * announces end at a time, and one that waited for its disk meanwhile would hold up all others. */
bool pg_ear_say(struct pg_ear *ear, const char *text) {
    if (!listen_in(ear))
        return false;
    bool sent = PQsendQueryParams(ear->connection, "SELECT pg_notify('draped', $1)", 1, NULL, &text,
                                  NULL, NULL, 0);
    PGresult *result = sent ? receive(ear->connection, clock_ms() + ear->pg->patience_ms) : NULL;
    bool good = PQresultStatus(result) == PGRES_TUPLES_OK;
    PQclear(result);
    if (!good)
        hang_up(ear);
    return good;
}
