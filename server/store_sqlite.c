/* SPDX-License-Identifier: MIT */
#include "store_sqlite.h"
#include "log.h"
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sqlite3.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <time.h>
#include <unistd.h>

enum {
    READERS = 4,           /* reading connections */
    STATEMENTS = 64,       /* prepared ones kept per connection */
    BATCH_OPERATIONS = 256 /* most operations in one transaction */
};

struct db {
    sqlite3 *handle;
    size_t count;
    struct {
        const char *sql;
        sqlite3_stmt *statement;
    } cache[STATEMENTS];
};

/* A caller that waits for its change to become durable. */
struct pending {
    sqlite_operation operation;
    void *context;
    enum store_answer answer;
    bool done;
    struct pending *next;
};

struct sqlite_store {
    struct store base;
    struct store_options options;
    char *path;
    char holder[ID_SIZE];
    int holder_lock; /* of the file that shows we live; -1 before it exists */

    struct db *writer;
    pthread_mutex_t queue_lock;
    pthread_cond_t queue_moved;
    struct pending *first, **end; /* waiting operations in order */
    bool leading;                 /* some thread is running a batch */
    atomic_bool broken;           /* the last write failed */

    pthread_mutex_t readers_lock;
    pthread_cond_t reader_back;
    struct db *readers[READERS]; /* the idle ones first */
    size_t idle;
};

int64_t sqlite_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

struct sqlite_store *sqlite_of(struct store *store) {
    return (struct sqlite_store *)store;
}

const struct store_options *sqlite_options(const struct sqlite_store *store) {
    return &store->options;
}

/* ------------------------------------------------------------------ statements */

static enum store_answer answer_of(int code) {
    switch (code & 0xff) {
    case SQLITE_OK:
    case SQLITE_ROW:
    case SQLITE_DONE:
        return STORE_OK;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return STORE_BUSY;
    default:
        return STORE_DOWN;
    }
}

static enum store_answer report(struct db *db, int code) {
    enum store_answer answer = answer_of(code);
    if (answer != STORE_OK)
        log_error(log_event("store_error"), log_text("answer", store_answer_name(answer)),
                  log_int("code", code), log_text("detail", sqlite3_errmsg(db->handle)));
    return answer;
}

static sqlite3_stmt *prepare(struct db *db, const char *sql, int *code) {
    for (size_t k = 0; k < db->count; k++)
        if (db->cache[k].sql == sql)
            return db->cache[k].statement;
    sqlite3_stmt *statement = NULL;
    if (db->count == STATEMENTS) {
        *code = SQLITE_FULL;
        return NULL;
    }
    *code = sqlite3_prepare_v3(db->handle, sql, -1, SQLITE_PREPARE_PERSISTENT, &statement, NULL);
    if (*code == SQLITE_OK) {
        db->cache[db->count].sql = sql;
        db->cache[db->count++].statement = statement;
    }
    return statement;
}

struct query db_query(struct db *db, const char *sql) {
    struct query query = {.db = db};
    query.statement = prepare(db, sql, &query.code);
    return query;
}

void query_bind_int(struct query *query, int64_t value) {
    if (query->code == SQLITE_OK)
        query->code = sqlite3_bind_int64(query->statement, ++query->bound, value);
}

void query_bind_real(struct query *query, double value) {
    if (query->code == SQLITE_OK)
        query->code = sqlite3_bind_double(query->statement, ++query->bound, value);
}

void query_bind_text(struct query *query, const char *value) {
    if (query->code == SQLITE_OK)
        query->code = sqlite3_bind_text(query->statement, ++query->bound, value, -1, SQLITE_STATIC);
}

void query_bind_bytes(struct query *query, const void *bytes, size_t length) {
    if (query->code == SQLITE_OK)
        query->code = sqlite3_bind_blob64(query->statement, ++query->bound, bytes ? bytes : "",
                                          length, SQLITE_STATIC);
}

bool query_row(struct query *query) {
    if (query->code != SQLITE_OK && query->code != SQLITE_ROW)
        return false;
    query->code = sqlite3_step(query->statement);
    return query->code == SQLITE_ROW;
}

int64_t query_int(const struct query *query, int column) {
    return sqlite3_column_int64(query->statement, column);
}

double query_real(const struct query *query, int column) {
    return sqlite3_column_double(query->statement, column);
}

const char *query_text(const struct query *query, int column) {
    return (const char *)sqlite3_column_text(query->statement, column);
}

const void *query_bytes(const struct query *query, int column, size_t *length) {
    const void *bytes = sqlite3_column_blob(query->statement, column);
    *length = (size_t)sqlite3_column_bytes(query->statement, column);
    return bytes;
}

void query_copy(const struct query *query, int column, char *to, size_t size) {
    const char *text = query_text(query, column);
    snprintf(to, size, "%s", text ? text : "");
}

void query_duplicate(struct query *query, int column, char **to, size_t *length) {
    size_t size = 0;
    *to = NULL;
    if (sqlite3_column_type(query->statement, column) == SQLITE_NULL)
        return;
    const void *bytes = query_bytes(query, column, &size);
    *to = malloc(size + 1);
    if (!*to || (!bytes && size > 0)) {
        query->code = SQLITE_NOMEM;
        return;
    }
    if (size > 0)
        memcpy(*to, bytes, size);
    (*to)[size] = '\0';
    if (length)
        *length = size;
}

enum store_answer query_end(struct query *query) {
    enum store_answer answer = report(query->db, query->code);
    if (query->statement) {
        sqlite3_reset(query->statement);
        sqlite3_clear_bindings(query->statement);
    }
    return answer;
}

enum store_answer query_run(struct query *query) {
    query_row(query);
    return query_end(query);
}

int64_t db_changes(struct db *db) {
    return sqlite3_changes64(db->handle);
}

int64_t db_last_row(struct db *db) {
    return sqlite3_last_insert_rowid(db->handle);
}

enum store_answer db_read_chunk(struct db *db, int64_t row, size_t offset, void *bytes,
                                size_t length) {
    sqlite3_blob *blob = NULL;
    int code = sqlite3_blob_open(db->handle, "main", "chunks", "bytes", row, 0, &blob);
    if (code == SQLITE_OK && offset + length > (size_t)sqlite3_blob_bytes(blob))
        code = SQLITE_CORRUPT;
    else if (code == SQLITE_OK)
        code = sqlite3_blob_read(blob, bytes, (int)length, (int)offset);
    /* SQLITE_ERROR is what a missing row gives. */
    enum store_answer answer = code == SQLITE_ERROR ? STORE_EMPTY : report(db, code);
    sqlite3_blob_close(blob);
    return answer;
}

enum store_answer db_script(struct db *db, const char *sql) {
    return report(db, sqlite3_exec(db->handle, sql, NULL, NULL, NULL));
}

/* ------------------------------------------------------------------ writing together */

static enum store_answer run_statement(struct db *db, const char *sql) {
    struct query query = db_query(db, sql);
    return query_run(&query);
}

/* One of several operations of a transaction: it alone is undone when it does not succeed. */
static enum store_answer run_guarded(struct sqlite_store *store, struct pending *one) {
    struct db *db = store->writer;
    enum store_answer answer = run_statement(db, "SAVEPOINT operation");
    if (answer != STORE_OK)
        return answer;
    answer = one->operation(store, db, one->context);
    if (answer != STORE_OK && !sqlite3_get_autocommit(db->handle))
        run_statement(db, "ROLLBACK TO operation");
    if (!sqlite3_get_autocommit(db->handle))
        run_statement(db, "RELEASE operation");
    return answer;
}

static void answer_all(struct pending *batch, enum store_answer answer) {
    for (; batch; batch = batch->next)
        batch->answer = answer;
}

/* A failed statement may have ended the transaction as a whole (disk full, I/O error): then nothing
 * of the batch has happened. */
static enum store_answer finish_batch(struct sqlite_store *store, bool wrote) {
    struct db *db = store->writer;
    if (sqlite3_get_autocommit(db->handle))
        return STORE_DOWN;
    enum store_answer answer = wrote ? run_statement(db, "COMMIT") : STORE_OK;
    if (!sqlite3_get_autocommit(db->handle))
        run_statement(db, "ROLLBACK");
    return answer;
}

static void run_batch(struct sqlite_store *store, struct pending *batch) {
    enum store_answer answer = run_statement(store->writer, "BEGIN IMMEDIATE");
    if (answer != STORE_OK) {
        answer_all(batch, answer);
        atomic_store(&store->broken, answer == STORE_DOWN);
        return;
    }
    bool alone = !batch->next;
    bool wrote = false;
    for (struct pending *one = batch; one; one = one->next) {
        one->answer =
            alone ? one->operation(store, store->writer, one->context) : run_guarded(store, one);
        wrote = wrote || one->answer == STORE_OK;
        if (sqlite3_get_autocommit(store->writer->handle))
            break;
    }
    answer = finish_batch(store, wrote);
    if (answer != STORE_OK)
        answer_all(batch, answer);
    atomic_store(&store->broken, answer == STORE_DOWN);
}

/* Takes up to BATCH_OPERATIONS from the queue; the lock is held. */
static struct pending *take_batch(struct sqlite_store *store) {
    struct pending *batch = store->first;
    struct pending *last = batch;
    for (int n = 1; last->next && n < BATCH_OPERATIONS; n++)
        last = last->next;
    store->first = last->next;
    if (!store->first)
        store->end = &store->first;
    last->next = NULL;
    return batch;
}

/* The first thread that finds nobody leading runs what has queued up, its own operation among it.
 */
enum store_answer sqlite_write(struct store *base, sqlite_operation operation, void *context) {
    struct sqlite_store *store = sqlite_of(base);
    struct pending own = {.operation = operation, .context = context};
    pthread_mutex_lock(&store->queue_lock);
    *store->end = &own;
    store->end = &own.next;
    while (!own.done) {
        if (store->leading) {
            pthread_cond_wait(&store->queue_moved, &store->queue_lock);
            continue;
        }
        struct pending *batch = take_batch(store);
        store->leading = true;
        pthread_mutex_unlock(&store->queue_lock);
        run_batch(store, batch);
        pthread_mutex_lock(&store->queue_lock);
        store->leading = false;
        for (struct pending *one = batch, *next; one; one = next) {
            next = one->next;
            one->done = true;
        }
        pthread_cond_broadcast(&store->queue_moved);
    }
    pthread_mutex_unlock(&store->queue_lock);
    return own.answer;
}

enum store_answer sqlite_read(struct store *base, sqlite_operation operation, void *context) {
    struct sqlite_store *store = sqlite_of(base);
    pthread_mutex_lock(&store->readers_lock);
    while (store->idle == 0)
        pthread_cond_wait(&store->reader_back, &store->readers_lock);
    struct db *db = store->readers[--store->idle];
    pthread_mutex_unlock(&store->readers_lock);
    enum store_answer answer = operation(store, db, context);
    pthread_mutex_lock(&store->readers_lock);
    store->readers[store->idle++] = db;
    pthread_cond_signal(&store->reader_back);
    pthread_mutex_unlock(&store->readers_lock);
    return answer;
}

/* ------------------------------------------------------------------ who lives */

/*
 * Every process that has the store open holds a lock on a file of its own beside the database. When
 * it dies, however it dies, the kernel frees the lock, and whoever looks next knows that its claims
 * will never be completed: they need not wait for their lease.
 */
static bool holder_path(const struct sqlite_store *store, const char *holder, char *path,
                        size_t size) {
    int length = snprintf(path, size, "%s-holder-%s", store->path, holder);
    return length > 0 && (size_t)length < size;
}

const char *sqlite_holder(const struct sqlite_store *store) {
    return store->holder;
}

bool sqlite_holder_dead(const struct sqlite_store *store, const char *holder) {
    char path[4096];
    if (!strcmp(holder, store->holder))
        return false;
    if (!id_valid(holder) || !holder_path(store, holder, path, sizeof path))
        return true;
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return errno == ENOENT;
    bool dead = flock(file, LOCK_EX | LOCK_NB) == 0;
    if (dead)
        unlink(path);
    close(file);
    return dead;
}

static bool hold(struct sqlite_store *store, char why[STORE_WHY_SIZE]) {
    char path[4096];
    id_make(store->holder);
    if (holder_path(store, store->holder, path, sizeof path))
        store->holder_lock = open(path, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (store->holder_lock < 0 || flock(store->holder_lock, LOCK_EX | LOCK_NB) != 0) {
        snprintf(why, STORE_WHY_SIZE, "cannot write beside %s: %s", store->path, strerror(errno));
        return false;
    }
    return true;
}

static void release_hold(struct sqlite_store *store) {
    char path[4096];
    if (store->holder_lock < 0)
        return;
    if (holder_path(store, store->holder, path, sizeof path))
        unlink(path);
    close(store->holder_lock);
}

/* ------------------------------------------------------------------ open and close */

static void db_close(struct db *db) {
    if (!db)
        return;
    for (size_t k = 0; k < db->count; k++)
        sqlite3_finalize(db->cache[k].statement);
    sqlite3_close(db->handle);
    free(db);
}

/* Explains a failure to open; the extended code and SQLite's text tell the rest. */
static void explain(char why[STORE_WHY_SIZE], const char *path, int code, const char *detail) {
    const char *what = "cannot be opened";
    switch (code & 0xff) {
    case SQLITE_NOTADB:
        what = "is not a database, or is damaged";
        break;
    case SQLITE_CORRUPT:
        what = "is damaged: restore it from a backup";
        break;
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        what = "is locked by another process";
        break;
    case SQLITE_READONLY:
    case SQLITE_PERM:
        what = "cannot be written";
        break;
    case SQLITE_FULL:
        what = "cannot grow: the disk is full";
        break;
    default:
        break;
    }
    snprintf(why, STORE_WHY_SIZE, "the database %s %s (%s)", path, what, detail);
}

static struct db *db_open(const char *path, const struct store_options *options,
                          char why[STORE_WHY_SIZE]) {
    struct db *db = calloc(1, sizeof *db);
    if (!db) {
        snprintf(why, STORE_WHY_SIZE, "no memory for the database");
        return NULL;
    }
    int flags =
        SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
    int code = sqlite3_open_v2(path, &db->handle, flags, NULL);
    if (code == SQLITE_OK)
        code = sqlite3_busy_timeout(db->handle, (int)options->busy_ms);
    if (code == SQLITE_OK)
        return db;
    explain(why, path, code, db->handle ? sqlite3_errmsg(db->handle) : "no memory");
    db_close(db);
    return NULL;
}

static bool execute(struct db *db, const char *path, const char *sql, char why[STORE_WHY_SIZE]) {
    int code = sqlite3_exec(db->handle, sql, NULL, NULL, NULL);
    if (code != SQLITE_OK)
        explain(why, path, code, sqlite3_errmsg(db->handle));
    return code == SQLITE_OK;
}

/* auto_vacuum has an effect only before the first table; the check covers the tables whose loss
 * would be silent, not the bulk of requests and results. */
static bool set_up_writer(struct sqlite_store *store, char why[STORE_WHY_SIZE]) {
    struct db *db = store->writer;
    if (sqlite3_db_readonly(db->handle, "main") == 1) {
        explain(why, store->path, SQLITE_READONLY, "read-only");
        return false;
    }
    if (!execute(db, store->path,
                 "PRAGMA auto_vacuum=INCREMENTAL;"
                 "PRAGMA journal_mode=WAL;"
                 "PRAGMA synchronous=FULL;"
                 "PRAGMA foreign_keys=ON;"
                 "PRAGMA temp_store=MEMORY;"
                 "PRAGMA cache_size=-32768;"
                 "PRAGMA journal_size_limit=67108864;"
                 "BEGIN IMMEDIATE",
                 why))
        return false;
    bool good = sqlite_migrate(db, why) && execute(db, store->path, "COMMIT", why);
    if (!good && !sqlite3_get_autocommit(db->handle))
        sqlite3_exec(db->handle, "ROLLBACK", NULL, NULL, NULL);
    return good;
}

static bool check_table(struct sqlite_store *store, const char *sql, char why[STORE_WHY_SIZE]) {
    char verdict[256] = "";
    struct query query = db_query(store->writer, sql);
    if (query_row(&query))
        query_copy(&query, 0, verdict, sizeof verdict);
    int code = query.code;
    if (query_end(&query) == STORE_OK && !strcmp(verdict, "ok"))
        return true;
    explain(why, store->path, code == SQLITE_ROW ? SQLITE_CORRUPT : code, verdict);
    return false;
}

static bool open_readers(struct sqlite_store *store, char why[STORE_WHY_SIZE]) {
    for (int k = 0; k < READERS; k++) {
        struct db *db = db_open(store->path, &store->options, why);
        if (!db)
            return false;
        store->readers[store->idle++] = db;
        if (!execute(db, store->path, "PRAGMA query_only=ON;PRAGMA temp_store=MEMORY", why))
            return false;
    }
    return true;
}

static void sqlite_close(struct store *base) {
    struct sqlite_store *store = sqlite_of(base);
    while (store->idle > 0)
        db_close(store->readers[--store->idle]);
    db_close(store->writer);
    release_hold(store);
    pthread_mutex_destroy(&store->queue_lock);
    pthread_cond_destroy(&store->queue_moved);
    pthread_mutex_destroy(&store->readers_lock);
    pthread_cond_destroy(&store->reader_back);
    free(store->path);
    free(store);
}

static enum store_answer ping_read(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    (void)context;
    struct query query = db_query(db, "SELECT n FROM counts WHERE status = 0");
    query_row(&query);
    return query_end(&query);
}

static enum store_answer ping_write(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    (void)context;
    return run_statement(db, "UPDATE counts SET n = n WHERE status = 0");
}

/* The disk is written to only to find out whether a failure is over. */
static enum store_answer sqlite_ping(struct store *store) {
    enum store_answer answer = sqlite_read(store, ping_read, NULL);
    if (answer == STORE_OK && atomic_load(&sqlite_of(store)->broken))
        answer = sqlite_write(store, ping_write, NULL);
    return answer;
}

static const struct store_ops sqlite_ops = {
    .close = sqlite_close,
    .ping = sqlite_ping,
    .submit = sqlite_submit,
    .get = sqlite_get,
    .request = sqlite_request,
    .list = sqlite_list,
    .cancel = sqlite_cancel,
    .remove = sqlite_remove,
    .counts = sqlite_counts,
    .claim = sqlite_claim,
    .renew = sqlite_renew,
    .check = sqlite_check,
    .fail = sqlite_fail,
    .crashed = sqlite_crashed,
    .release = sqlite_release,
    .sweep = sqlite_sweep,
    .result_append = sqlite_result_append,
    .result_commit = sqlite_result_commit,
    .result_drop = sqlite_result_drop,
    .result_find = sqlite_result_find,
    .result_read = sqlite_result_read,
    .surface_put = sqlite_surface_put,
    .surface_get = sqlite_surface_get,
    .surface_list = sqlite_surface_list,
    .surface_delete = sqlite_surface_delete,
};

static struct sqlite_store *sqlite_new(const char *path, const struct store_options *options,
                                       struct hub *hub) {
    struct sqlite_store *store = calloc(1, sizeof *store);
    if (!store)
        return NULL;
    store->base.ops = &sqlite_ops;
    store->base.hub = hub;
    store->options = *options;
    store->holder_lock = -1;
    store->end = &store->first;
    store->path = strdup(path);
    pthread_mutex_init(&store->queue_lock, NULL);
    pthread_cond_init(&store->queue_moved, NULL);
    pthread_mutex_init(&store->readers_lock, NULL);
    pthread_cond_init(&store->reader_back, NULL);
    if (!store->path) {
        sqlite_close(&store->base);
        return NULL;
    }
    return store;
}

struct store *store_sqlite_open(const char *path, const struct store_options *options,
                                struct hub *hub, char why[STORE_WHY_SIZE]) {
    struct sqlite_store *store = sqlite_new(path, options, hub);
    if (!store) {
        snprintf(why, STORE_WHY_SIZE, "no memory for the database");
        return NULL;
    }
    store->writer = db_open(path, options, why);
    if (store->writer && set_up_writer(store, why) &&
        check_table(store, "PRAGMA quick_check('jobs')", why) &&
        check_table(store, "PRAGMA quick_check('results')", why) &&
        check_table(store, "PRAGMA quick_check('surfaces')", why) && hold(store, why) &&
        open_readers(store, why))
        return &store->base;
    sqlite_close(&store->base);
    return NULL;
}
