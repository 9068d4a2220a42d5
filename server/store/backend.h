/* SPDX-License-Identifier: MIT */
/*
 * What a backend of the store provides. `store.c` forwards the calls of `store.h` to it, cuts
 * results into chunks and reports changes as job events, so that a backend is about its database
 * alone. The meaning of each member is that of the function of the same name in `store.h`.
 */
#ifndef SERVER_STORE_BACKEND_H
#define SERVER_STORE_BACKEND_H

#include "cache.h"
#include "clock_check.h"
#include "cursor.h"
#include "reads.h"
#include "store.h"
#include <pthread.h>
#include <stdatomic.h>

/* Results are stored in chunks of this many bytes; only the last one may be shorter: few enough to
 * be read for a small piece of it, enough not to be many. A result has at most STORE_CHUNKS_MAX of
 * them (1 TiB). */
enum { STORE_CHUNK_BYTES = 1 << 16, STORE_CHUNKS_BITS = 24, STORE_CHUNKS_MAX = 1 << 24 };

/* They are written several at a time: a transaction is worth that many. */
enum { STORE_SEGMENT_CHUNKS = 16, STORE_SEGMENT_BYTES = STORE_SEGMENT_CHUNKS * STORE_CHUNK_BYTES };

/* Consecutive chunks of a result that is being written under a claim. */
struct store_segment {
    const struct store_claim *claim;
    int64_t number; /* of the result; 0 until its first segment is stored */
    int64_t index;  /* of the first chunk */
    unsigned char *const *chunks;
    size_t length;       /* of all of them */
    int64_t total;       /* the result's length, at a commit; before that so far */
    bool last;           /* commit */
    const char *summary; /* commit: the summary object */
    /* commit: what may be claimed in the same transaction, its `sequence` 0 as long as nothing is;
     * NULL: nothing is wanted */
    struct store_claim *next;
};

/* The bytes in chunk k of the segment, 0 beyond its last one, and the seal of a chunk. */
size_t segment_chunk_length(const struct store_segment *segment, size_t k);
int64_t segment_seal(const struct store_segment *segment, size_t k);

/* A running job whose claim has ended: its lease or, where that can be seen, its process. */
struct store_ended {
    struct store_claim claim; /* sequence, token and id */
    bool holder_gone;
};

/* What a sweep does besides, in this order. */
enum store_step {
    STORE_STEP_EXPIRE,        /* requests and results of jobs that ended before the retention */
    STORE_STEP_EXPIRE_EXCESS, /* the oldest of the owner with most while all are too large */
    STORE_STEP_REMOVE,        /* records of `records_us` and older */
    STORE_STEP_DOOM,          /* results that were begun by claims that no longer hold */
    STORE_STEP_CLEAR,         /* chunks of doomed results */
    STORE_STEP_SHRINK,        /* what is empty: free pages, counts of owners without anything */
    STORE_STEP_COUNT
};

/* A step of priority is worth a minute of waiting. */
#define STORE_PRIORITY_US (INT64_C(60) * 1000000)

/* SQL_BACKGROUND */
#define STORE_BACKGROUND (INT64_C(1) << 60)

/* Where a submission is to come in the queue of its owner. */
int64_t store_rank(const struct store_submission *submission, int64_t now);

/* The tables that this version of draped makes and uses, in both databases. */
enum { STORE_SCHEMA = 13 };

/* Whether tables of that version are these; else `why` says what to do. `what` names the store. */
bool store_schema_known(const char *what, int64_t schema, char why[STORE_WHY_SIZE]);

struct store_ops {
    bool wall_leases; /* leases are counted by the database's clock, which can be set */
    bool fails_late;  /* a full disk is seen by what needs room, not by every write */
    void (*close)(struct store *store);
    /* Tells other processes soon that `subject` has changed; never waits. NULL: they
     * find out by looking. */
    void (*announce)(struct store *store, const char *subject);
    enum store_answer (*ping)(struct store *store);
    /* Writes the row of the host, and runs what a claim runs so that it finds nothing. */
    enum store_answer (*beat)(struct store *store, const struct store_host *host);
    /* Removes the row of a host that goes. */
    void (*leave)(struct store *store, const char *name);
    enum store_answer (*submit)(struct store *store, const struct store_submission *submission,
                                struct store_receipt *receipt);
    /* NULL: what is submitted is durable in any case. */
    enum store_answer (*flush)(struct store *store);
    enum store_answer (*submit_family)(struct store *store, const struct store_family *family,
                                       struct store_receipt *receipt);
    enum store_answer (*cancel)(struct store *store, const char *id);
    enum store_answer (*remove)(struct store *store, const char *id);
    enum store_answer (*claim)(struct store *store, bool fresh, struct store_claim *claim);
    enum store_answer (*starving)(struct store *store, bool fresh);
    enum store_answer (*renew)(struct store *store, const struct store_claim *claim,
                               double progress);
    enum store_answer (*fail)(struct store *store, const struct store_claim *claim,
                              const char *error);
    /* Puts it back into the queue, the attempt excused or not, and its owner behind `later` turns
     * of others. STORE_CONFLICT likewise. */
    enum store_answer (*requeue)(struct store *store, const struct store_claim *claim, bool excused,
                                 int64_t later);
    enum store_answer (*begin_round)(struct store *store, const struct store_claim *claim,
                                     const struct store_round *round);
    enum store_answer (*end_task)(struct store *store, const struct store_claim *claim,
                                  const void *numbers, size_t length, int64_t spent);
    enum store_answer (*change_task)(struct store *store, const struct store_claim *claim,
                                     const void *task);
    /* Running jobs whose claims have ended, at most so many. */
    enum store_answer (*find_ended)(struct store *store, struct store_ended *ended, size_t most,
                                    size_t *count);
    /* Takes the job from its holder by a new token, from which on a late renewal is refused.
     * STORE_CONFLICT when its claim has not ended so after all. */
    enum store_answer (*take_over)(struct store *store, const struct store_ended *ended,
                                   int64_t *token);
    /* Finds by reading which steps have something to do, and the time by the database's clock. */
    enum store_answer (*find_due)(struct store *store, bool due[STORE_STEP_COUNT], int64_t *now);
    /* Does a part of the work in a short transaction, and counts what it handled. STORE_EMPTY:
     * there was none. */
    enum store_answer (*step)(struct store *store, enum store_step step, int64_t *done);
    /* At the end of a sweep; NULL: nothing. */
    enum store_answer (*checkpoint)(struct store *store);
    /* Stores a segment; for the first one begins the result and sets `segment->number`. */
    enum store_answer (*result_append)(struct store *store, struct store_segment *segment);
    /* Stores the last segment (which may be the only one, or empty) and ends the job. Sets
     * `segment->number`; to 0 when the result of another job was taken. */
    enum store_answer (*result_commit)(struct store *store, struct store_segment *segment);
    /* Drops a result that was begun and not committed. */
    enum store_answer (*result_drop)(struct store *store, int64_t number);
    enum store_answer (*item_put)(struct store *store, enum store_item_kind kind,
                                  const struct store_item *item, bool *created);
    enum store_answer (*form_put)(struct store *store, const char *owner, const char *id,
                                  const void *form, size_t length);
    enum store_answer (*item_delete)(struct store *store, enum store_item_kind kind,
                                     const char *owner, const char *id);
};

/* Rows of hosts that were silent for longer do not count, and then are removed. */
#define STORE_SEEN_US (INT64_C(1000000) * STORE_SEEN_SECONDS)
#define STORE_FORGOTTEN_US (INT64_C(3600) * 1000000)

/* The last beat. */
struct store_health {
    pthread_mutex_t lock;
    struct store_host host;
    enum store_answer answer;
    int64_t at_ms; /* by `clock_ms`; 0: none yet */
};

/* Those that are listed (uncommitted_result.h). */
struct store_uncommitted_list {
    pthread_mutex_t lock;
    struct store_uncommitted *first;
};

/* The results that were found altered lately, by their numbers. */
enum { STORE_ALTERED_KEPT = 64 };
struct store_altered {
    atomic_uint next;
    atomic_llong results[STORE_ALTERED_KEPT];
};

/* The head of every backend's own struct. A backend sets the first four. */
struct store {
    const struct store_ops *ops;
    struct store_options options;
    struct reader reader;
    struct clock_check clocks; /* of the sweeps */
    struct job_events *events;
    struct store_cache *cache;
    struct store_health health;
    struct store_uncommitted_list uncommitted;
    struct store_altered altered;
    unsigned char secret[CURSOR_SECRET_BYTES];
};

/* What the sweeps have seen of the clocks. */
struct clock_check store_clocks(const struct store *store);

/* Microseconds of the monotonic clock of this machine, the same for all its processes. */
int64_t store_monotonic_us(const struct store *store);

/* Takes note of how a write ended that needs room: a store whose disk was full is not usable until
 * there is room again, however little a beat needs. Returns the answer. */
enum store_answer store_note(struct store *store, enum store_answer answer);

/* Tells those that wait here, and other processes, that `subject` has changed. */
void store_tell(struct store *store, const char *subject);

/* Opens a backend; like `store_open`. */
struct store *store_sqlite_open(const char *path, const struct store_options *options,
                                struct job_events *events, char why[STORE_WHY_SIZE]);
struct store *store_postgres_open(const char *url, const struct store_options *options,
                                  struct job_events *events, char why[STORE_WHY_SIZE]);

#endif
