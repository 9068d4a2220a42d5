/* SPDX-License-Identifier: MIT */
#include "sqlite.h"
#include "file_identity.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/metrics.h"
#include "server/store/sql.h"
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

enum {
    READERS = 4,              /* reading connections */
    BATCH_OPERATIONS = 256,   /* most operations in one transaction */
    LOG_ROUNDS = 4,           /* tries to get the log copied whole */
    RESERVE_BYTES = 1 << 19,  /* of the disk, that requests and results leave free: 64 pages */
    PLENTY_BYTES = 1 << 30,   /* more than the log ever has */
    TAKE_LOG_BYTES = 32 << 20 /* of results in the log, that are taken into the database at once */
};

/* A caller that waits for its change to be kept. */
struct pending {
    sqlite_operation operation;
    void *context;
    enum db_durability durability;
    enum store_answer answer;
    bool done;
    sem_t moved; /* it is done, or may lead */
    struct pending *next;
};

struct sqlite_store {
    struct store base;
    char *path;
    struct process_lock *process;
    struct file_identity *identity;

    struct db *writer;
    pthread_mutex_t queue_lock;
    struct pending *first, **end; /* waiting operations in order */
    bool leading;                 /* some thread is running a batch */
    atomic_bool broken;           /* the last write or taking of the log failed */

    pthread_mutex_t readers_lock;
    pthread_cond_t reader_back;
    struct db *readers[READERS]; /* the idle ones first */
    size_t idle;

    pthread_mutex_t keeper_lock;
    struct db *keeper;           /* takes the log into the database, beside the writer */
    atomic_int_fast64_t unpaced; /* bytes since it has done so for `sqlite_pace` */
};

struct sqlite_store *sqlite_of(struct store *store) {
    return (struct sqlite_store *)store;
}

const struct store_options *sqlite_options(const struct sqlite_store *store) {
    return &store->base.options;
}

int64_t sqlite_now(const struct sqlite_store *store) {
    return store->base.options.clock ? store->base.options.clock() : clock_utc_us();
}

int64_t sqlite_steady(const struct sqlite_store *store) {
    return store_monotonic_us(&store->base);
}

const struct process_lock *sqlite_process(const struct sqlite_store *store) {
    return store->process;
}

/* ------------------------------------------------------------------ writing together */

/* What is written to a file that has gone from its path is lost: refused like a database that
 * cannot be used. */
static enum store_answer check_presence(struct sqlite_store *store) {
    if (file_identity_check(store->identity))
        return STORE_OK;
    metrics_store_failed(false);
    return STORE_MISSING;
}

/* A failed statement may end the transaction as a whole (disk full, I/O error): then nothing of the
 * batch has happened. Who waited in vain for the lock of another process does so once: it holds up
 * threads that answer calls. */
static void run_batch(struct sqlite_store *store, struct pending *batch) {
    struct db *db = store->writer;
    /* One operation that must not be lost is enough to wait for the disk. */
    enum db_durability durability = DB_LAZY;
    for (const struct pending *one = batch; one; one = one->next)
        if (one->durability == DB_DURABLE)
            durability = DB_DURABLE;
    db_wait_for_locks(db, atomic_load(&store->broken) ? 0 : store->base.options.busy_ms);
    enum store_answer answer = check_presence(store);
    if (answer == STORE_OK)
        answer = db_keep(db, durability);
    if (answer == STORE_OK)
        answer = db_run(db, "BEGIN IMMEDIATE");
    if (answer == STORE_OK) {
        bool wrote = false, open = true;
        for (struct pending *one = batch; one && open; one = one->next) {
            /* of several, one that does not succeed is undone alone */
            answer = batch->next ? db_run(db, "SAVEPOINT operation") : STORE_OK;
            if (answer == STORE_OK) {
                answer = one->operation(store, db, one->context);
                if (batch->next && answer != STORE_OK && db_in_transaction(db))
                    db_run(db, "ROLLBACK TO operation");
                if (batch->next && db_in_transaction(db))
                    db_run(db, "RELEASE operation");
            }
            one->answer = answer;
            wrote = wrote || answer == STORE_OK;
            open = db_in_transaction(db);
        }
        if (open) {
            answer = wrote ? db_run(db, "COMMIT") : STORE_OK;
            if (db_in_transaction(db))
                db_run(db, "ROLLBACK");
            if (answer == STORE_OK && wrote)
                answer = check_presence(store);
        } else if (!store_failed(answer)) {
            answer = STORE_DOWN;
        }
    }
    for (struct pending *one = answer == STORE_OK ? NULL : batch; one; one = one->next)
        one->answer = answer;
    atomic_store(&store->broken, answer != STORE_OK);
}

/* The first of those that wait, whose thread takes the rest with it. Nobody who is woken needs the
 * lock again: else all of a batch would wait for each other once more. */
static void lead(struct sqlite_store *store) {
    pthread_mutex_lock(&store->queue_lock);
    struct pending *batch = store->first, *last = batch;
    for (int n = 1; last->next && n < BATCH_OPERATIONS; n++)
        last = last->next;
    store->first = last->next;
    if (!store->first)
        store->end = &store->first;
    last->next = NULL;
    pthread_mutex_unlock(&store->queue_lock);
    run_batch(store, batch);
    pthread_mutex_lock(&store->queue_lock);
    struct pending *leader = store->first;
    store->leading = leader != NULL;
    pthread_mutex_unlock(&store->queue_lock);
    if (leader)
        sem_post(&leader->moved);
    for (struct pending *one = batch->next, *next; one; one = next) {
        next = one->next;
        one->done = true;
        sem_post(&one->moved);
    }
}

/* A thread that finds nobody leading leads; else it waits until it is answered, or may lead. */
enum store_answer sqlite_write(struct store *base, enum db_durability durability,
                               sqlite_operation operation, void *context) {
    struct sqlite_store *store = sqlite_of(base);
    struct pending own = {.operation = operation, .context = context, .durability = durability};
    sem_init(&own.moved, 0, 0);
    pthread_mutex_lock(&store->queue_lock);
    *store->end = &own;
    store->end = &own.next;
    bool wait = store->leading;
    store->leading = true;
    pthread_mutex_unlock(&store->queue_lock);
    while (wait && sem_wait(&own.moved) != 0)
        continue; /* a signal */
    if (!own.done)
        lead(store);
    sem_destroy(&own.moved);
    return own.answer;
}

struct change {
    const struct query *query;
    enum store_answer none;
};

static enum store_answer change_operation(struct sqlite_store *store, struct db *db,
                                          void *context) {
    (void)store;
    const struct change *change = context;
    struct query query = db_query(db, change->query->sql);
    query_bind_values(&query, change->query->values, (size_t)change->query->bound);
    return db_change(&query, change->none);
}

enum store_answer sqlite_change(struct store *store, enum db_durability durability,
                                const struct query *query, enum store_answer none) {
    struct change change = {query, none};
    return sqlite_write(store, durability, change_operation, &change);
}

/* What is written takes room twice, in the log and then in the database; where there is plenty,
 * what is in the log already need not be counted. */
enum store_answer sqlite_room_for(struct store *base, size_t bytes) {
    const char *path = sqlite_of(base)->path;
    struct statvfs disk;
    struct stat file;
    if (statvfs(path, &disk) != 0)
        return STORE_OK; /* the write itself will say what is wrong */
    uint64_t left = (uint64_t)disk.f_bavail * disk.f_frsize;
    uint64_t wanted = 2 * (uint64_t)bytes + RESERVE_BYTES;
    if (left >= wanted + PLENTY_BYTES)
        return STORE_OK;
    /* By how much the file grows when the log is taken into it. */
    struct query query =
        sqlite_read(base, "SELECT page_count * page_size FROM pragma_page_count, pragma_page_size");
    int64_t size = 0;
    bool grows = query_number(&query, STORE_OK, &size) == STORE_OK && stat(path, &file) == 0 &&
                 size > file.st_size;
    if (left >= wanted + (grows ? (uint64_t)(size - file.st_size) : 0))
        return STORE_OK;
    metrics_store_failed(false);
    log_error(log_event("store_error"), log_text("answer", store_answer_name(STORE_NO_SPACE)),
              log_int("bytes_left", (int64_t)left));
    return STORE_NO_SPACE;
}

struct db *sqlite_take_reader(struct store *base) {
    struct sqlite_store *store = sqlite_of(base);
    pthread_mutex_lock(&store->readers_lock);
    while (store->idle == 0)
        pthread_cond_wait(&store->reader_back, &store->readers_lock);
    struct db *db = store->readers[--store->idle];
    pthread_mutex_unlock(&store->readers_lock);
    return db;
}

enum store_answer sqlite_give_reader(struct store *base, struct db *db, enum store_answer answer) {
    struct sqlite_store *store = sqlite_of(base);
    pthread_mutex_lock(&store->readers_lock);
    store->readers[store->idle++] = db;
    pthread_cond_signal(&store->reader_back);
    pthread_mutex_unlock(&store->readers_lock);
    return answer;
}

/* While the bulk is copied writers go on; the little that came meanwhile is soon copied too, and
 * only when nothing is left does the log begin anew instead of growing. */
enum store_answer sqlite_take_log(struct store *base) {
    struct sqlite_store *store = sqlite_of(base);
    enum store_answer answer = check_presence(store);
    bool all = false;
    pthread_mutex_lock(&store->keeper_lock);
    for (int k = 0; k < LOG_ROUNDS && answer == STORE_OK && !all; k++)
        answer = db_checkpoint(store->keeper, &all);
    pthread_mutex_unlock(&store->keeper_lock);
    if (answer == STORE_OK || answer == STORE_BUSY)
        return STORE_OK;
    atomic_store(&store->broken, true);
    return answer;
}

/* Has what was written lazily so far written to the disk. */
static enum store_answer sqlite_flush(struct store *base) {
    struct sqlite_store *store = sqlite_of(base);
    pthread_mutex_lock(&store->keeper_lock);
    enum store_answer answer = db_sync_log(store->keeper);
    pthread_mutex_unlock(&store->keeper_lock);
    return answer == STORE_OK ? check_presence(store) : answer;
}

enum store_answer sqlite_pace(struct store *base, int64_t bytes) {
    struct sqlite_store *store = sqlite_of(base);
    if (atomic_fetch_add(&store->unpaced, (int_fast64_t)bytes) + bytes > TAKE_LOG_BYTES) {
        atomic_store(&store->unpaced, 0);
        return sqlite_take_log(base);
    }
    return sqlite_flush(base);
}

/* ------------------------------------------------------------------ open and close */

/* Page size and auto_vacuum have an effect only before the first table; pages of 8 KiB took a tenth
 * off the time of a small drape against 4 KiB, larger ones nothing more. Debian's SQLite fills what
 * is deleted with zeros, by way of the log: dropping a result that finds no room would take as much
 * room again. The sweep, and who writes large results, take the log into the database long before
 * it has the 128 MiB at which a caller would have to. The checks cover the tables whose loss would
 * be silent, not the bulk of requests and results. */
static bool open_connections(struct sqlite_store *store, char why[STORE_WHY_SIZE]) {
    struct db *db = store->writer = db_open(store->path, store->base.options.busy_ms, why);
    if (!db)
        return false;
    if (db_read_only(db)) {
        snprintf(why, STORE_WHY_SIZE, "the database %s cannot be written", store->path);
        return false;
    }
    bool empty; /* what is not ours is not even set up */
    if (!sqlite_check_tables(db, &empty, why) || !db_set_up(db,
                                                            "PRAGMA page_size=8192;"
                                                            "PRAGMA auto_vacuum=INCREMENTAL;"
                                                            "PRAGMA journal_mode=WAL;"
                                                            "PRAGMA synchronous=FULL;"
                                                            "PRAGMA foreign_keys=ON;"
                                                            "PRAGMA temp_store=MEMORY;"
                                                            "PRAGMA secure_delete=FAST;"
                                                            "PRAGMA journal_size_limit=67108864;"
                                                            "PRAGMA wal_autocheckpoint=16384;"
                                                            "BEGIN IMMEDIATE",
                                                            why))
        return false;
    bool good = sqlite_prepare_tables(db, why) && db_set_up(db, "COMMIT", why);
    if (!good && db_in_transaction(db))
        (void)db_run(db, "ROLLBACK");
    if (!good || !db_check(db, "PRAGMA quick_check('jobs')", why) ||
        !db_check(db, "PRAGMA quick_check('results')", why) ||
        !db_check(db, "PRAGMA quick_check('surfaces')", why) ||
        !db_check(db, "PRAGMA quick_check('materials')", why) ||
        !db_check(db, "PRAGMA quick_check('links')", why))
        return false;
    store->keeper = db_open(store->path, store->base.options.busy_ms, why);
    /* A connection that has read nothing does not know that there is a log. */
    if (!store->keeper || !db_set_up(store->keeper, "SELECT version FROM schema_version", why))
        return false;
    for (int k = 0; k < READERS; k++) {
        db = db_open(store->path, store->base.options.busy_ms, why);
        if (!db)
            return false;
        store->readers[store->idle++] = db;
        if (!db_set_up(db, "PRAGMA query_only=ON;PRAGMA temp_store=MEMORY", why))
            return false;
    }
    return true;
}

static void sqlite_close(struct store *base) {
    struct sqlite_store *store = sqlite_of(base);
    while (store->idle > 0)
        db_close(store->readers[--store->idle]);
    db_close(store->keeper);
    db_close(store->writer);
    file_identity_free(store->identity);
    process_lock_free(store->process);
    pthread_mutex_destroy(&store->queue_lock);
    pthread_mutex_destroy(&store->readers_lock);
    pthread_mutex_destroy(&store->keeper_lock);
    pthread_cond_destroy(&store->reader_back);
    free(store->path);
    free(store);
}

/* That so little as a beat can be written is not enough: the log may have room for it on a full
 * disk. */
static enum store_answer sqlite_ping(struct store *store) {
    if (!file_identity_check(sqlite_of(store)->identity))
        return STORE_MISSING;
    struct query query = sqlite_read(store, "SELECT n FROM counts WHERE status = " SQL_QUEUED);
    enum store_answer answer = query_run(&query);
    return answer == STORE_OK ? sqlite_room_for(store, 0) : answer;
}

bool sqlite_broken(struct sqlite_store *store) {
    return atomic_load(&store->broken);
}

static const struct dialect dialect = {
    .counts = "SELECT status, n FROM draped.counts"
              " UNION ALL SELECT 10 + status, n FROM draped.ended",
    .hosts = "SELECT count(*), coalesce(sum(workers), 0), coalesce(sum(busy), 0)"
             " FROM draped.hosts WHERE seen > $1 - $2",
    .chunk = "SELECT bytes, seal FROM draped.chunks WHERE id = $1 * (1 << 24) + $2",
    .check = "PRAGMA integrity_check",
};

_Static_assert(STORE_CHUNKS_BITS == 24, "as in the statement of a chunk");

struct reader sqlite_reader(struct db *db) {
    return (struct reader){db_query, db, &dialect};
}

static void return_reader(struct query *query) {
    (void)sqlite_give_reader(query->lender, query->connection, STORE_OK);
}

struct query sqlite_read(void *store, const char *sql) {
    struct query query = db_query(sqlite_take_reader(store), sql);
    query.lender = store;
    query.give_back = return_reader;
    return query;
}

static const struct store_ops sqlite_ops = {
    .close = sqlite_close,
    .ping = sqlite_ping,
    .beat = sqlite_beat,
    .leave = sqlite_leave,
    .submit = sqlite_submit,
    .flush = sqlite_flush,
    .submit_family = sqlite_submit_family,
    .cancel = sqlite_cancel,
    .remove = sqlite_remove,
    .claim = sqlite_claim,
    .starving = sqlite_starving,
    .renew = sqlite_renew,
    .fail = sqlite_fail,
    .requeue = sqlite_requeue,
    .begin_round = sqlite_begin_round,
    .end_task = sqlite_end_task,
    .change_task = sqlite_change_task,
    .find_ended = sqlite_find_ended,
    .take_over = sqlite_take_over,
    .find_due = sqlite_find_due,
    .step = sqlite_step,
    .checkpoint = sqlite_take_log,
    .result_append = sqlite_result_append,
    .result_commit = sqlite_result_commit,
    .result_drop = sqlite_result_drop,
    .item_put = sqlite_item_put,
    .form_put = sqlite_form_put,
    .item_delete = sqlite_item_delete,
};

struct store *store_sqlite_open(const char *path, const struct store_options *options,
                                struct job_events *events, char why[STORE_WHY_SIZE]) {
    struct sqlite_store *store = calloc(1, sizeof *store);
    if (!store || !(store->path = strdup(path))) {
        snprintf(why, STORE_WHY_SIZE, "no memory for the database");
        free(store);
        return NULL;
    }
    store->base.ops = &sqlite_ops;
    store->base.events = events;
    store->base.options = *options;
    store->base.reader = (struct reader){sqlite_read, store, &dialect};
    store->end = &store->first;
    pthread_mutex_init(&store->queue_lock, NULL);
    pthread_mutex_init(&store->readers_lock, NULL);
    pthread_mutex_init(&store->keeper_lock, NULL);
    pthread_cond_init(&store->reader_back, NULL);
    store->process = process_lock_take(path, options->shared, why);
    if (store->process && open_connections(store, why)) {
        store->identity = file_identity_new(path);
        if (store->identity)
            return &store->base;
        snprintf(why, STORE_WHY_SIZE, "the files of the database %s cannot be found", path);
    }
    sqlite_close(&store->base);
    return NULL;
}
