/* SPDX-License-Identifier: MIT */
/*
 * Copies of a PostgreSQL store: every table as COPY gives it, in binary, from one snapshot. A
 * line of words comes before each part:
 *
 *     draped-backup 1 postgresql SCHEMA
 *     table NAME COLUMNS          then blocks, each a line with its length and so many bytes; 0
 * ends rows NUMBER CHECKSUM sequence NAME VALUE end
 *
 * A copy is put back in one transaction, in which the schema that was there gets another name: it
 * is all there and compared, or nothing has changed.
 */
#include "server/store/backup.h"
#include "pool.h"
#include "postgres.h"
#include <errno.h>
#include <inttypes.h>
#include <libpq-fe.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LINE_SIZE = 1024, SQL_SIZE = 2048, BLOCK_MAX = 1 << 30, CONNECT_MS = 10000 };

/* By which the server lists these connections; those of daemons are "draped". */
#define OWN_NAME "draped-backup"

/* COPY's binary format: a signature, flags and the length of an extension, then rows, each the
 * number of its fields and every field with its length before it; -1 fields end it. */
enum { SIGNATURE = 11, HEADER = 19 };

/* A connection whose messages hold no password. */
struct link {
    struct pool *pool;
    PGconn *libpq;
};

static bool say(const struct link *link, char why[STORE_WHY_SIZE], const char *what) {
    pool_say(why, "%s: %s", what, PQerrorMessage(link->libpq));
    pool_hide_password(link->pool, why);
    return false;
}

/* Statements without rows. */
static bool run(const struct link *link, const char *sql, char why[STORE_WHY_SIZE]) {
    PGresult *result = PQexec(link->libpq, sql);
    ExecStatusType status = PQresultStatus(result);
    PQclear(result);
    return status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK ||
           say(link, why, "the database refuses");
}

/* Rows of text; NULL with `why`. */
static PGresult *ask(const struct link *link, const char *sql, char why[STORE_WHY_SIZE]) {
    PGresult *result = PQexec(link->libpq, sql);
    if (PQresultStatus(result) == PGRES_TUPLES_OK)
        return result;
    say(link, why, "the database refuses");
    PQclear(result);
    return NULL;
}

static bool ask_number(const struct link *link, const char *sql, int64_t *number,
                       char why[STORE_WHY_SIZE]) {
    PGresult *result = ask(link, sql, why);
    *number = result && PQntuples(result) > 0 ? strtoll(PQgetvalue(result, 0, 0), NULL, 10) : 0;
    PQclear(result);
    return result != NULL;
}

/* Whatever limits the server has for its usual statements, these take as long as they take. */
static bool link_open(const char *url, struct link *link, char why[STORE_WHY_SIZE]) {
    link->pool = pool_open(url, CONNECT_MS, why);
    if (!link->pool)
        return false;
    link->libpq = pool_connect(link->pool);
    return (PQstatus(link->libpq) == CONNECTION_OK || say(link, why, "the database")) &&
           pg_script(link->pool, "SET application_name = '" OWN_NAME "'", NULL, why) &&
           run(link,
               "SET application_name = '" OWN_NAME "'; SET statement_timeout = 0;"
               "SET idle_in_transaction_session_timeout = 0; SET synchronize_seqscans = off",
               why);
}

static void link_close(struct link *link) {
    PQfinish(link->libpq);
    pool_close(link->pool);
}

/* ------------------------------------------------------------------ rows of a table */

static uint32_t big_endian(const unsigned char *bytes, size_t size) {
    uint32_t value = 0;
    for (size_t k = 0; k < size; k++)
        value = value << 8 | bytes[k];
    return value;
}

/* Counts the rows in a block of whole ones; the first block of a table has the header too. False
 * when they are not what COPY writes. */
static bool count_rows(const unsigned char *block, size_t length, bool first, int64_t *rows) {
    size_t at = 0;
    if (first) {
        if (length < HEADER || memcmp(block, "PGCOPY\n\377\r\n\0", SIGNATURE) != 0)
            return false;
        at = HEADER;
    }
    while (at + 2 <= length) {
        int16_t fields = (int16_t)big_endian(block + at, 2);
        at += 2;
        if (fields < 0)
            return at == length;
        for (; fields > 0; fields--) {
            if (at + 4 > length)
                return false;
            int32_t size = (int32_t)big_endian(block + at, 4);
            at += 4;
            if (size > 0 && (size_t)size > length - at)
                return false;
            at += size > 0 ? (size_t)size : 0;
        }
        ++*rows;
    }
    return at == length;
}

/* What takes the blocks of a table; false ends it. */
typedef bool block_taker(void *context, const unsigned char *block, size_t length);

struct counting {
    struct checksum checksum;
    int64_t rows;
    bool begun;
};

static bool count_block(struct counting *counting, const unsigned char *block, size_t length) {
    checksum_add(&counting->checksum, block, length);
    bool good = count_rows(block, length, !counting->begun, &counting->rows);
    counting->begun = true;
    return good;
}

/* Reads a table from the server, and counts it; `take` (may be NULL) gets every block. */
static bool read_table(const struct link *link, const char *columns, struct backup_table *table,
                       block_taker *take, void *context, char why[STORE_WHY_SIZE]) {
    char sql[SQL_SIZE];
    char *block = NULL;
    int length = 0;
    struct counting counting = {.rows = 0};
    snprintf(sql, sizeof sql, "COPY draped.%s (%s) TO STDOUT (FORMAT binary)", table->name,
             columns);
    PGresult *result = PQexec(link->libpq, sql);
    bool good = PQresultStatus(result) == PGRES_COPY_OUT || say(link, why, "COPY");
    PQclear(result);
    if (!good)
        return false;
    checksum_begin(&counting.checksum);
    while ((length = PQgetCopyData(link->libpq, &block, 0)) > 0) {
        if (good && !count_block(&counting, (unsigned char *)block, (size_t)length)) {
            backup_fail(why, "the server sends rows of an unknown form");
            good = false;
        }
        if (good && take && !take(context, (unsigned char *)block, (size_t)length)) {
            backup_fail(why, "the copy cannot be written: %s", strerror(errno));
            good = false;
        }
        PQfreemem(block);
    }
    while ((result = PQgetResult(link->libpq)) != NULL) {
        if (PQresultStatus(result) != PGRES_COMMAND_OK)
            good = say(link, why, "COPY");
        PQclear(result);
    }
    checksum_end(&counting.checksum, table->checksum);
    table->rows = counting.rows;
    return good && length != -2;
}

/* ------------------------------------------------------------------ making a copy */

static bool write_block(void *context, const unsigned char *block, size_t length) {
    FILE *out = context;
    return fprintf(out, "%zu\n", length) > 0 && fwrite(block, 1, length, out) == length;
}

static bool write_table(const struct link *link, FILE *out, const char *columns,
                        struct backup_table *table, char why[STORE_WHY_SIZE]) {
    fprintf(out, "table %s %s\n", table->name, columns);
    if (!read_table(link, columns, table, write_block, out, why))
        return false;
    fprintf(out, "0\nrows %" PRId64 " %s\n", table->rows, table->checksum);
    return true;
}

/* Results come first: jobs refer to them. */
static bool write_tables(const struct link *link, FILE *out, struct backup_contents *contents,
                         char why[STORE_WHY_SIZE]) {
    PGresult *tables =
        ask(link,
            "SELECT c.relname, string_agg(quote_ident(a.attname), ',' ORDER BY a.attnum)"
            " FROM pg_class c JOIN pg_attribute a ON a.attrelid = c.oid"
            " WHERE c.relkind = 'r' AND c.relnamespace = 'draped'::regnamespace"
            " AND a.attnum > 0 AND NOT a.attisdropped"
            " GROUP BY c.relname ORDER BY c.relname <> 'results', c.relname",
            why);
    bool good = tables != NULL;
    for (int k = 0; good && k < PQntuples(tables) && k < BACKUP_TABLES; k++) {
        struct backup_table *table = &contents->tables[contents->count++];
        snprintf(table->name, sizeof table->name, "%s", PQgetvalue(tables, k, 0));
        good = write_table(link, out, PQgetvalue(tables, k, 1), table, why);
    }
    PQclear(tables);
    return good;
}

/* They belong to no snapshot, and later values do no harm. */
static bool write_sequences(const struct link *link, FILE *out, char why[STORE_WHY_SIZE]) {
    PGresult *sequences = ask(link,
                              "SELECT sequencename, last_value FROM pg_sequences"
                              " WHERE schemaname = 'draped' AND last_value IS NOT NULL",
                              why);
    for (int k = 0; sequences && k < PQntuples(sequences); k++)
        fprintf(out, "sequence %s %s\n", PQgetvalue(sequences, k, 0), PQgetvalue(sequences, k, 1));
    PQclear(sequences);
    return sequences != NULL;
}

static bool write_copy(const struct link *link, FILE *out, struct backup_contents *contents,
                       char why[STORE_WHY_SIZE]) {
    int64_t there = 0;
    if (!run(link, "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY", why) ||
        !ask_number(link, "SELECT (to_regclass('draped.schema_version') IS NOT NULL)::integer",
                    &there, why))
        return false;
    if (!there) {
        return backup_fail(why, "the database holds no store of draped");
    }
    if (!ask_number(link, "SELECT max(version) FROM draped.schema_version", &contents->schema, why))
        return false;
    fprintf(out, "draped-backup 1 postgresql %" PRId64 "\n", contents->schema);
    bool good = write_tables(link, out, contents, why) && write_sequences(link, out, why);
    fprintf(out, "end\n");
    return good;
}

/* ------------------------------------------------------------------ reading a copy */

/* A copy that is read. */
struct reader {
    FILE *in;
    const char *path;
    char line[LINE_SIZE];
    unsigned char *block;
    size_t length, room;
};

static bool damaged(const struct reader *reader, char why[STORE_WHY_SIZE]) {
    return backup_fail(why, "%s is damaged or not whole", reader->path);
}

static bool next_line(struct reader *reader) {
    size_t length = fgets(reader->line, sizeof reader->line, reader->in) ? strlen(reader->line) : 0;
    if (length == 0 || reader->line[length - 1] != '\n')
        return false;
    reader->line[length - 1] = '\0';
    return true;
}

/* `length` is 0 after the last one. */
static bool next_block(struct reader *reader) {
    if (!next_line(reader))
        return false;
    char *end = NULL;
    unsigned long length = strtoul(reader->line, &end, 10);
    if (end == reader->line || *end || length > BLOCK_MAX)
        return false;
    if (length > reader->room) {
        unsigned char *larger = realloc(reader->block, length);
        if (!larger)
            return false;
        reader->block = larger;
        reader->room = length;
    }
    reader->length = length;
    return fread(reader->block, 1, length, reader->in) == length;
}

/* The parts of a copy; each may be NULL. `table` comes before the blocks of a table, `done` after
 * them. */
struct taker {
    bool (*begin)(void *context, int64_t schema, char *why);
    bool (*table)(void *context, const char *name, const char *columns, char *why);
    bool (*block)(void *context, const unsigned char *block, size_t length, char *why);
    bool (*done)(void *context, char *why);
    bool (*sequence)(void *context, const char *name, const char *value, char *why);
    void *context;
};

/* It becomes a part of a statement. */
static bool is_name(const char *text, const char *besides) {
    for (; *text; text++)
        if (!strchr("abcdefghijklmnopqrstuvwxyz_0123456789", *text) && !strchr(besides, *text))
            return false;
    return true;
}

/* The blocks after "table NAME COLUMNS", compared with the line "rows". */
static bool pass_table(struct reader *reader, const struct taker *taker,
                       struct backup_contents *contents, char why[STORE_WHY_SIZE]) {
    char *name = reader->line + strlen("table ");
    char *columns = strchr(name, ' ');
    struct counting counting = {.rows = 0};
    if (!columns || contents->count == BACKUP_TABLES)
        return damaged(reader, why);
    *columns++ = '\0';
    if (!is_name(name, "") || !is_name(columns, ",\""))
        return damaged(reader, why);
    struct backup_table *table = &contents->tables[contents->count++];
    snprintf(table->name, sizeof table->name, "%s", name);
    if (taker->table && !taker->table(taker->context, table->name, columns, why))
        return false;
    checksum_begin(&counting.checksum);
    bool good;
    while ((good = next_block(reader)) && reader->length > 0) {
        if (!count_block(&counting, reader->block, reader->length))
            return damaged(reader, why);
        if (taker->block && !taker->block(taker->context, reader->block, reader->length, why))
            return false;
    }
    checksum_end(&counting.checksum, table->checksum);
    table->rows = counting.rows;
    char expected[LINE_SIZE];
    snprintf(expected, sizeof expected, "rows %" PRId64 " %s", table->rows, table->checksum);
    if (!good || !next_line(reader) || strcmp(reader->line, expected) != 0)
        return damaged(reader, why);
    return !taker->done || taker->done(taker->context, why);
}

static bool pass_sequence(struct reader *reader, const struct taker *taker,
                          char why[STORE_WHY_SIZE]) {
    char *name = reader->line + strlen("sequence ");
    char *value = strchr(name, ' ');
    if (!value || value[1 + strspn(value + 1, "0123456789")] || !value[1])
        return damaged(reader, why);
    *value++ = '\0';
    if (!is_name(name, ""))
        return damaged(reader, why);
    return !taker->sequence || taker->sequence(taker->context, name, value, why);
}

static bool pass_parts(struct reader *reader, const struct taker *taker,
                       struct backup_contents *contents, char why[STORE_WHY_SIZE]) {
    while (next_line(reader)) {
        bool good = true;
        if (!strcmp(reader->line, "end"))
            return fgetc(reader->in) == EOF || damaged(reader, why);
        if (!strncmp(reader->line, "table ", 6))
            good = pass_table(reader, taker, contents, why);
        else if (!strncmp(reader->line, "sequence ", 9))
            good = pass_sequence(reader, taker, why);
        else
            good = damaged(reader, why);
        if (!good)
            return false;
    }
    return damaged(reader, why);
}

/* Reads a copy from its beginning to its end. */
static bool pass(const char *path, const struct taker *taker, struct backup_contents *contents,
                 char why[STORE_WHY_SIZE]) {
    struct reader reader = {.in = fopen(path, "re"), .path = path};
    memset(contents, 0, sizeof *contents);
    if (!reader.in) {
        return backup_fail(why, "%s cannot be read: %s", path, strerror(errno));
    }
    long long schema = 0;
    bool good = next_line(&reader) &&
                sscanf(reader.line, "draped-backup 1 postgresql %lld", &schema) == 1 && schema > 0;
    contents->schema = schema;
    if (!good)
        backup_fail(why, "%s is no back-up of a PostgreSQL store", path);
    good = good && backup_known(path, schema, postgres_schema(), why) &&
           (!taker->begin || taker->begin(taker->context, schema, why)) &&
           pass_parts(&reader, taker, contents, why);
    free(reader.block);
    fclose(reader.in);
    return good;
}

/* The file is complete when it can be read from end to end, as it is on the disk. */
bool postgres_backup_make(const char *url, const char *path, struct backup_contents *contents,
                          char why[STORE_WHY_SIZE]) {
    static const struct taker nothing = {0};
    struct link link = {0};
    struct backup_contents found;
    FILE *out = fopen(path, "wxe");
    if (!out) {
        return backup_fail(why, "%s cannot be written: %s", path, strerror(errno));
    }
    bool good = link_open(url, &link, why) && write_copy(&link, out, contents, why);
    link_close(&link);
    bool whole = fflush(out) == 0 && !ferror(out);
    whole = fclose(out) == 0 && whole;
    if (good && !whole) {
        backup_fail(why, "%s cannot be written: %s", path, strerror(errno));
        good = false;
    }
    return good && backup_sync(path, why) && pass(path, &nothing, &found, why) &&
           backup_same(&found, contents, why);
}

/* ------------------------------------------------------------------ putting back */

struct restoring {
    struct link link;
    bool copying;
    struct backup_contents stored; /* what the server has of it */
    char columns[LINE_SIZE];
};

/* The tables of the copy's version, empty, without the triggers that count. */
static bool make_tables(void *context, int64_t schema, char *why) {
    struct restoring *restoring = context;
    char script[POSTGRES_SCRIPT_SIZE];
    bool good = run(&restoring->link, "CREATE SCHEMA draped;" POSTGRES_VERSIONS, why);
    for (int64_t version = 1; good && version <= schema; version++)
        good = postgres_schema_step(version, script) && run(&restoring->link, script, why);
    return good;
}

static bool begin_table(void *context, const char *name, const char *columns, char *why) {
    struct restoring *restoring = context;
    char sql[SQL_SIZE];
    struct backup_table *table = &restoring->stored.tables[restoring->stored.count++];
    snprintf(table->name, sizeof table->name, "%s", name);
    snprintf(restoring->columns, sizeof restoring->columns, "%s", columns);
    snprintf(sql, sizeof sql,
             "ALTER TABLE draped.%s DISABLE TRIGGER USER; DELETE FROM draped.%s;"
             "COPY draped.%s (%s) FROM STDIN (FORMAT binary)",
             name, name, name, columns);
    PGresult *result = PQexec(restoring->link.libpq, sql);
    restoring->copying = PQresultStatus(result) == PGRES_COPY_IN;
    PQclear(result);
    return restoring->copying || say(&restoring->link, why, "COPY");
}

static bool send_block(void *context, const unsigned char *block, size_t length, char *why) {
    struct restoring *restoring = context;
    return PQputCopyData(restoring->link.libpq, (const char *)block, (int)length) == 1 ||
           say(&restoring->link, why, "COPY");
}

/* Ends the table, and reads it back. */
static bool end_table(void *context, char *why) {
    struct restoring *restoring = context;
    char sql[SQL_SIZE];
    struct backup_table *table = &restoring->stored.tables[restoring->stored.count - 1];
    bool good = PQputCopyEnd(restoring->link.libpq, NULL) == 1;
    PGresult *result;
    restoring->copying = false;
    while ((result = PQgetResult(restoring->link.libpq)) != NULL) {
        good = good && PQresultStatus(result) == PGRES_COMMAND_OK;
        PQclear(result);
    }
    if (!good)
        return say(&restoring->link, why, "COPY");
    snprintf(sql, sizeof sql, "ALTER TABLE draped.%s ENABLE TRIGGER USER", table->name);
    return read_table(&restoring->link, restoring->columns, table, NULL, NULL, why) &&
           run(&restoring->link, sql, why);
}

static bool set_sequence(void *context, const char *name, const char *value, char *why) {
    struct restoring *restoring = context;
    char sql[SQL_SIZE];
    snprintf(sql, sizeof sql, "SELECT setval('draped.%s', %s)", name, value);
    return run(&restoring->link, sql, why);
}

/* What is there gets another name; processes that use it are in the way. */
static bool make_room(const struct link *link, char kept[BACKUP_KEPT_SIZE], char *why) {
    char sql[SQL_SIZE], time[BACKUP_TIME_SIZE];
    int64_t there = 0, others = 0;
    if (!ask_number(link, "SELECT (to_regnamespace('draped') IS NOT NULL)::integer", &there, why) ||
        !ask_number(link,
                    "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database()"
                    " AND application_name = 'draped'",
                    &others, why))
        return false;
    if (others > 0) {
        return backup_fail(
            why, "draped has %" PRId64 " connections to the database: stop all of its processes",
            others);
    }
    if (!there)
        return true;
    backup_time(time);
    for (char *c = time; *c; c++)
        *c = *c == '.' ? '_' : *c == 'T' ? 't' : *c == 'Z' ? 'z' : *c;
    snprintf(kept, BACKUP_KEPT_SIZE, "schema draped_before_%s", time);
    snprintf(sql, sizeof sql, "ALTER SCHEMA draped RENAME TO draped_before_%s", time);
    return run(link, sql, why);
}

/* The connection of the pool, and this one, are no daemon's. */
static bool restore_all(struct restoring *restoring, const char *path,
                        struct backup_contents *contents, char kept[BACKUP_KEPT_SIZE], char *why) {
    const struct taker taker = {.begin = make_tables,
                                .table = begin_table,
                                .block = send_block,
                                .done = end_table,
                                .sequence = set_sequence,
                                .context = restoring};
    return run(&restoring->link,
               "BEGIN;" POSTGRES_SCHEMA_LOCK "SET LOCAL client_min_messages = 'error'", why) &&
           make_room(&restoring->link, kept, why) && pass(path, &taker, contents, why) &&
           (restoring->stored.schema = contents->schema) > 0 &&
           backup_same(&restoring->stored, contents, why) && run(&restoring->link, "COMMIT", why);
}

bool postgres_backup_restore(const char *url, const char *path, struct backup_contents *contents,
                             char kept[BACKUP_KEPT_SIZE], char why[STORE_WHY_SIZE]) {
    static const struct taker nothing = {0};
    struct restoring *restoring = calloc(1, sizeof *restoring);
    bool good = restoring && pass(path, &nothing, contents, why) &&
                link_open(url, &restoring->link, why) &&
                restore_all(restoring, path, contents, kept, why);
    if (restoring)
        link_close(&restoring->link); /* what is not committed is undone */
    else
        backup_fail(why, "no memory to restore");
    if (!good)
        kept[0] = '\0';
    free(restoring);
    return good;
}
