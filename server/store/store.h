/* SPDX-License-Identifier: MIT */
/*
 * What must survive: jobs, their requests, results and surfaces. One interface; the backend is
 * chosen by the URL: SQLite in a file for one machine, PostgreSQL for any number of them.
 *
 * What is answered STORE_OK is durable: it survives a power cut. (Submissions of which nothing is
 * promised yet, claims, renewals, returns to the queue and chunks of unfinished results survive the
 * death of every process, but a power cut where the database is may take those of the last second;
 * a holder that still works under such a claim is refused as if it were old.) What is answered
 * otherwise has changed nothing. (A change answered STORE_DOWN because a connection to another
 * machine broke may have happened all the same. It can be repeated: a submission by its idempotency
 * key; an end is refused the second time.) Output arguments mean something only with STORE_OK,
 * unless a function says more.
 *
 * Requests, results, surfaces, materials and links are stored with a checksum (`seal.h`), which is
 * looked at when they are read. What is not what was written is logged and not handed out:
 * STORE_ALTERED.
 *
 * Claims are leases with a fencing token. `store_claim` counts the attempt and hands out the job
 * for a lease; the holder renews it; a holder of an older token than the job's is answered
 * STORE_CONFLICT and must drop its work. No transaction stays open between two calls. Setting a
 * clock takes no job from a live holder: with SQLite, whose holders are on this machine, leases are
 * counted by its monotonic clock; with PostgreSQL, whose clock counts, no lease is taken for ended
 * until holders have had a lease's time to renew since its clock jumped.
 *
 * Every function may be called from any thread at any time between open and close. Times are
 * microseconds since 1970 UTC by the database's clock; 0 means "not yet". Texts are UTF-8.
 */
#ifndef SERVER_STORE_STORE_H
#define SERVER_STORE_STORE_H

#include "answer.h"
#include "server/id.h"
#include "server/job_events.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct store;

enum {
    STORE_DIGEST_SIZE = 65,  /* digests: at most 64 characters and the final zero */
    STORE_OWNER_SIZE = 65,   /* names of owners: the same; "" is the anonymous one */
    STORE_KEY_SIZE = 256,    /* idempotency keys: at most 255 bytes and the final zero */
    STORE_REQUEST_SIZE = 65, /* ids of the HTTP requests that submit: at most 64 characters */
    STORE_HOST_SIZE = 65,
    STORE_TASK_BYTES = 512, /* of what a task is, at the most */
    STORE_LATER_TURNS = 32  /* what the whole turn of a long job is worth, in small ones */
};

/* The states of a job; the names are those of the contract. X(id, name) */
#define STORE_STATUS_LIST(X)                                                                       \
    X(QUEUED, "queued")                                                                            \
    X(RUNNING, "running")                                                                          \
    X(SUCCEEDED, "succeeded")                                                                      \
    X(FAILED, "failed")                                                                            \
    X(CANCELLED, "cancelled")

enum store_status {
#define X(id, name) STORE_##id,
    STORE_STATUS_LIST(X)
#undef X
        STORE_STATUS_COUNT
};

/* What a job is; the names are those of the log. X(id, name) */
#define STORE_KIND_LIST(X)                                                                         \
    X(DRAPE, "drape")                                                                              \
    X(STUDY, "study")                                                                              \
    X(TASK, "task") /* of a study: never among what callers see */                                 \
    X(LAMINATE, "laminate")

enum store_kind {
#define X(id, name) STORE_##id,
    STORE_KIND_LIST(X)
#undef X
        STORE_KIND_COUNT
};

const char *store_kind_name(enum store_kind kind);

const char *store_status_name(enum store_status status);
/* False for a name that is no status. */
bool store_status_from_name(const char *name, enum store_status *status);
/* Whether a job in this state will never change again (but for expiry and deletion). */
bool store_status_ended(enum store_status status);

/* ------------------------------------------------------------------ open and close */

struct store_options {
    int64_t queue_limit;     /* queued jobs at the most; submit answers STORE_FULL beyond */
    int64_t owner_running;   /* running jobs of one owner at the most; 0: no bound */
    int64_t lease_us;        /* how long a claim holds without renewal */
    int max_attempts;        /* a job whose worker died that often fails */
    int64_t busy_ms;         /* how long to wait for another process's lock */
    int64_t retention_us;    /* results of jobs that ended longer ago expire in `store_sweep` */
    int64_t records_us;      /* records of ended jobs are removed when older; at least that long */
    int64_t retention_bytes; /* of all results together: beyond it a sweep expires the oldest jobs
                                of the owner with most bytes; 0: no bound */
    int64_t clock_trust_us;  /* what is old expires only if the database's clock has not jumped for
                           so long, by the monotonic clock of this process */
    bool shared;             /* other processes may open it too; else it is ours alone (SQLite) */
    int64_t (*clock)(void);  /* for tests: microseconds since 1970 UTC; NULL: the system's */
    int64_t (*monotonic_clock)(void); /* for tests: monotonic microseconds; NULL: the system's */
};

/* 10,000 queued jobs; 60 s; 3; 5 s; 168 h; 672 h; 5 min; not shared; the system's clocks. */
extern const struct store_options store_options_default;

/* Whether the URL names a database that any number of machines may share. */
bool store_url_remote(const char *url);

/* The path of one that is a file, without `sqlite:`. */
const char *store_url_path(const char *url);

/* Opens the store at `url`: a path, or `sqlite:PATH`; the file is created when missing, its folder
 * is not. Or `postgresql://...`: what is missing is created in the database's schema `draped`.
 * `events` is notified of every change and must outlive the store. NULL
 * with a sentence in `why` when it cannot be used: wrong folder, read-only, open elsewhere (unless
 * both share it), corrupt, of another program, of another version's tables, of an unknown kind;
 * a server that cannot be reached, refuses the user, is older than 13, is a replica, forgets what
 * it acknowledged. The sentence never holds a password. */
struct store *store_open(const char *url, const struct store_options *options,
                         struct job_events *events, char why[STORE_WHY_SIZE]);

/* Waits for no one: no other call may be under way. NULL is allowed. */
void store_close(struct store *store);

/* Whether the store can be used (for /readyz): by a read, a look at the writer and the last beat,
 * which is made anew when it has failed or is two seconds old. */
enum store_answer store_ping(struct store *store) STORE_MUST_USE;

/* A daemon that has the store open, as the others see it. */
struct store_host {
    char name[ID_SIZE]; /* of the process; the store's own business */
    char host[STORE_HOST_SIZE];
    char role[8];
    char version[16];
    int64_t workers; /* processes */
    int64_t busy;    /* of them */
};

/* What later beats say of this process; `name` is not looked at. */
void store_introduce(struct store *store, const struct store_host *host);

/* A sign of life, to be given every few seconds: writes the row of this process, and tries what a
 * claim does without claiming. The answer is that of `store_health` until the next. */
enum { STORE_SEEN_SECONDS = 30 }; /* silent for longer: it does not count */
enum store_answer store_beat(struct store *store) STORE_MUST_USE;

/* How the last beat ended; STORE_OK before the first. While it has failed nothing is submitted. */
enum store_answer store_health(struct store *store) STORE_MUST_USE;

/* ------------------------------------------------------------------ jobs */

/* A job as it is reported to callers. `error` and `summary` are malloc'ed JSON texts or NULL; the
 * struct is emptied with `store_job_clear`. */
struct store_job {
    char id[ID_SIZE];
    int64_t sequence; /* position in the list, ascending with submission; unique */
    enum store_kind kind;
    enum store_status status;
    double progress;     /* 0..1 */
    int64_t done, total; /* of its variants (study) or plies (laminate) */
    int64_t created, started, finished;
    int attempts;
    int priority;
    int64_t position; /* its place in the laminate it belongs to, from 0 */
    bool expired;     /* request and result were removed by retention: answer 410 */
    bool altered;     /* error or summary is not what was written: both are NULL */
    char owner[STORE_OWNER_SIZE];
    char surface[STORE_DIGEST_SIZE]; /* the stored surface it names; "" when it has its own */
    char digest[STORE_DIGEST_SIZE];  /* of the request as understood, with the solver's version */
    char *error;                     /* failed: the problem document without request_id */
    char *summary;                   /* succeeded: the result's `summary` object; of a study before
                                        that the best so far, an object */
};

/* Frees what the struct owns, not the struct; twice is harmless. */
void store_job_clear(struct store_job *job);

/* What one owner may have at the most; 0: no bound. How many of an owner's jobs may run is an
 * option of the store, because it is kept by the processes that claim. */
struct store_quota {
    int64_t queued;
    int64_t bytes; /* as in struct store_usage */
};

/* What one owner has. */
struct store_usage {
    int64_t queued;  /* jobs */
    int64_t running; /* jobs */
    int64_t bytes;   /* of results, of requests that have not expired, and of surfaces */
};

/* Cheap: kept up to date by every change, by owner. All zero for an unknown owner. */
enum store_answer store_usage(struct store *store, const char *owner,
                              struct store_usage *usage) STORE_MUST_USE;

/* Which bound a submission has reached. */
enum store_bound {
    STORE_BOUND_QUEUE,        /* of all queued jobs: `queue_limit` */
    STORE_BOUND_OWNER_QUEUED, /* `quota.queued` */
    STORE_BOUND_OWNER_BYTES,  /* `quota.bytes`, with the request that was to be stored */
    STORE_BOUND_SHARE         /* of `queue_limit`, what is left: `share_fits` */
};

/* A new job; everything is the caller's and is not kept. */
struct store_submission {
    enum store_kind kind; /* drape or study; or laminate (`store_submit_family`) */
    int64_t total;        /* of a study: variants */
    const void *request;  /* the body as posted */
    size_t request_length;
    const char *digest;       /* an owner's jobs of the same digest share one result */
    const char *surface;      /* id of a stored surface, or NULL or "" */
    const char *owner;        /* NULL is "" */
    const char *key;          /* idempotency key, of this owner; NULL without */
    const char *origin;       /* id of the HTTP request, for the log; NULL without */
    int priority;             /* each step is worth a minute of waiting in the queue; 0 is usual */
    struct store_quota quota; /* of this owner */
    bool
        unpromised; /* nothing is promised of it before its end, or before `store_flush`: it need
                       not be durable until then. Not with a key, by which others are promised it */
};

struct store_receipt {
    char id[ID_SIZE];
    enum store_status status; /* STORE_SUCCEEDED at once when the result is there already */
    bool existing;            /* the key was known with the same body: the earlier job */
    enum store_bound full;    /* with STORE_FULL alone: which bound */
};

/* Queues a job. STORE_OK also for a known key with the same kind and body. STORE_CONFLICT: known
 * key, another body. STORE_EMPTY: the surface is not stored. STORE_FULL: over the
 * queue limit or a quota of the owner, and `receipt->full` says which (with PostgreSQL a few that
 * are submitted at the same moment may still come in). A job whose result is there already waits in
 * no queue. Concurrent calls share a wait for the disk. */
enum store_answer store_submit(struct store *store, const struct store_submission *submission,
                               struct store_receipt *receipt) STORE_MUST_USE;

/* Makes durable what was submitted `unpromised` and has not ended since: the end of a job that had
 * to be queued is durable, and everything before it. */
enum store_answer store_flush(struct store *store) STORE_MUST_USE;

/* The job, to be cleared by the caller also when the answer is not STORE_OK. STORE_EMPTY. */
enum store_answer store_get(struct store *store, const char *id,
                            struct store_job *job) STORE_MUST_USE;

/* The request's bytes as posted, in a malloc'ed buffer (zero-terminated beyond its length) that the
 * caller frees. STORE_EMPTY: no such job, or expired. */
enum store_answer store_request(struct store *store, const char *id, char **bytes,
                                size_t *length) STORE_MUST_USE;

struct store_filter {
    enum store_kind kind; /* of this kind alone */
    bool has_status;
    enum store_status status;
    const char *owner; /* NULL: of all owners */
    int64_t cursor;    /* 0: from the newest; else `next` of the page before (`cursor.h`) */
    int limit;         /* 1..1000 */
};

/* Newest first. `next` is 0 after the last page. Jobs submitted while paging do not shift pages. */
struct store_page {
    struct store_job *jobs; /* `count` of them */
    size_t count;
    int64_t next;
};

/* STORE_OK also when the page is empty. The caller clears the page with `store_page_clear`,
 * whatever the answer. */
enum store_answer store_list(struct store *store, const struct store_filter *filter,
                             struct store_page *page) STORE_MUST_USE;
void store_page_clear(struct store_page *page);

/* Ends a queued or running job as cancelled, with what belongs to it; its workers are stopped by
 * their dispatchers. STORE_OK: it is cancelled by this call. STORE_CONFLICT: it had ended before.
 * STORE_EMPTY: no such job. */
enum store_answer store_cancel(struct store *store, const char *id) STORE_MUST_USE;

/* Removes the record, the request and, if no other job refers to it, the result, with what belongs
 * to it; a running job is stopped by its dispatcher. STORE_EMPTY: no such job. */
enum store_answer store_delete(struct store *store, const char *id) STORE_MUST_USE;

struct store_counts {
    int64_t jobs[STORE_STATUS_COUNT]; /* without tasks; a job that waits for its own counts as
                                         running */
    int64_t tasks[2];                 /* of studies: queued, running */
    int64_t oldest_queued; /* when the job that has waited longest was created; 0 without any */
    int64_t ended[STORE_STATUS_COUNT]; /* into that status, since the store was made; never less */
    int64_t crashed;                   /* of the failed ones, as `solver-crashed` */
    int64_t hosts, workers, busy;      /* of processes that gave a sign of life lately */
};

/* Cheap: kept up to date by every change. */
enum store_answer store_counts(struct store *store, struct store_counts *counts) STORE_MUST_USE;

/* ------------------------------------------------------------------ for dispatchers */

/* The right to work on a job until `lease_end`. Plain memory. */
struct store_claim {
    char id[ID_SIZE];
    char surface[STORE_DIGEST_SIZE];
    char owner[STORE_OWNER_SIZE];
    char origin[STORE_REQUEST_SIZE]; /* the HTTP request that submitted it; "" */
    int64_t sequence;
    int64_t token;     /* grows with every claim of the job */
    int64_t waited_us; /* since the submission */
    int attempts;      /* how often it was handed out, this one included */
    enum store_kind kind;
    int64_t spent;        /* study: microseconds that its tasks have taken so far */
    char parent[ID_SIZE]; /* of a task: its study; else "" or the laminate it belongs to */
    size_t task_length;
    unsigned char task[STORE_TASK_BYTES];
    bool reused; /* the result was there already: the job has succeeded, nothing to do */
};

/* Hands out the queued job whose turn it is. STORE_EMPTY: none. Of the owners who have jobs in the
 * queue, and fewer running than `owner_running`, the one of whom fewest are running has the turn,
 * so that each gets a fair share of the workers however much the others have submitted; among
 * equals, the one whose last turn is longest ago, or who came first. The jobs of one owner, and so
 * all of them while there is only one, come by priority and age: a step of priority is worth a
 * minute of waiting, so that every job has its turn at last. */
enum store_answer store_claim(struct store *store, struct store_claim *claim) STORE_MUST_USE;

/* The same among the owners of whom nothing is running and who are not behind others by
 * `store_yield`, and of their jobs those that have not been handed out before. */
enum store_answer store_claim_fresh(struct store *store, struct store_claim *claim) STORE_MUST_USE;

/* Whether an owner of whom nothing is running (`fresh`: nor who is behind others by `store_yield`)
 * has a job in the queue: STORE_OK or STORE_EMPTY. */
enum store_answer store_starving(struct store *store, bool fresh) STORE_MUST_USE;

/* Prolongs the lease and stores the progress (0..1; it never goes back). STORE_CONFLICT: the claim
 * is lost (cancelled, deleted, expired and given to another). */
enum store_answer store_renew(struct store *store, const struct store_claim *claim,
                              double progress) STORE_MUST_USE;

/* Whether the claim still holds, by a read alone. STORE_OK or STORE_CONFLICT. */
enum store_answer store_check(struct store *store, const struct store_claim *claim) STORE_MUST_USE;

/* Ends the job as failed. `error` is the problem document. STORE_CONFLICT as above. */
enum store_answer store_fail(struct store *store, const struct store_claim *claim,
                             const char *error) STORE_MUST_USE;

/* The worker died: back to the queue, or failed as `solver-crashed` with `detail` (a clause such as
 * "signal 11") when this was the last attempt. */
enum store_answer store_crashed(struct store *store, const struct store_claim *claim,
                                const char *detail) STORE_MUST_USE;

/* Back to the queue at its old place. The attempt stays counted but is not held against the job. */
enum store_answer store_release(struct store *store,
                                const struct store_claim *claim) STORE_MUST_USE;

/* The same for a job that takes longer than others may wait for it: among owners with equally many
 * running, this one's next turn comes when others have had STORE_LATER_TURNS of them. */
enum store_answer store_yield(struct store *store, const struct store_claim *claim) STORE_MUST_USE;

/* ------------------------------------------------------------------ jobs that have jobs

 * A study is a job whose steps are claimed one after the other. What is claimed as a study has all
 * numbers of its rounds so far (`store_numbers`): its holder begins a round of tasks
 * (`store_begin_round`), from when on the study is running but held by nobody, or ends it as any
 * job. When the last task of a round has ended the study is in the queue again for its next step.
 *
 * Tasks are jobs, with leases and attempts, that only dispatchers see. They and the steps of their
 * study come after all other jobs of their owner, in the order of the studies, and count in no
 * limit of queued jobs. A task that fails ends its study with its own problem; a study that ends
 * takes its tasks and numbers with it.
 *
 * A laminate is a job that is never claimed: it has succeeded when the last of its drapes has
 * ended, however. These are jobs as any other. */

/* A round of tasks; everything is the caller's. */
struct store_round {
    const void *tasks;       /* `count` times `length` bytes, at most STORE_TASK_BYTES each */
    const int64_t *variants; /* of each task */
    size_t length, count;
    int64_t done, total; /* variants of the study, before this round and altogether */
    const char *best;    /* what was found so far, a JSON object; NULL: nothing */
};

/* Ends a step of the claimed study. At least one task. STORE_CONFLICT: the claim is lost. */
enum store_answer store_begin_round(struct store *store, const struct store_claim *claim,
                                    const struct store_round *round) STORE_MUST_USE;

/* Ends the claimed task, which took so many microseconds, with its numbers. What a power cut takes
 * of that is done again. STORE_CONFLICT as above. */
enum store_answer store_end_task(struct store *store, const struct store_claim *claim,
                                 const void *numbers, size_t length, int64_t spent) STORE_MUST_USE;

/* Puts the claimed task back into the queue as another: the same length. The attempt is not held
 * against it. STORE_CONFLICT as above. */
enum store_answer store_change_task(struct store *store, const struct store_claim *claim,
                                    const void *task) STORE_MUST_USE;

/* The numbers of all tasks of the claimed study, by round and place within it, in a malloc'ed
 * buffer that the caller frees. */
enum store_answer store_numbers(struct store *store, const struct store_claim *claim, void **bytes,
                                size_t *length) STORE_MUST_USE;

/* A laminate and its drapes, to be inserted together: at least one, of different digests. Owner,
 * surface, priority and origin are those of the laminate. */
struct store_family {
    struct store_submission parent;
    size_t count;
    struct store_member {
        const void *request;
        size_t request_length;
        const char *digest;
    } const *members;
};

/* As `store_submit`, for all of it or nothing; with regard to limits it is as many jobs as it has
 * drapes. The receipt is the laminate's. */
enum store_answer store_submit_family(struct store *store, const struct store_family *family,
                                      struct store_receipt *receipt) STORE_MUST_USE;

/* The drapes of a laminate that have not been removed, in their order; `position` of each says its
 * place. The caller clears the page, whatever the answer. */
enum store_answer store_members(struct store *store, const char *id,
                                struct store_page *page) STORE_MUST_USE;

/* What a sweep did. */
struct store_sweep {
    int requeued; /* leases that ended, or (SQLite) whose process is gone: back in the queue */
    int failed;   /* the same, without attempts left */
    int expired;  /* jobs whose request and result were removed */
    int removed;  /* records removed for good */
    bool more;    /* there is more to do: call again soon */
};

/* Housekeeping, in short transactions: ended leases, retention, remains of abandoned results, the
 * write-ahead log. To be called every second or so by the processes that share the store. */
enum store_answer store_sweep(struct store *store, struct store_sweep *sweep) STORE_MUST_USE;

/* ------------------------------------------------------------------ results */

/* A result being written by the holder of a claim; one thread. It buffers up to 1 MiB, so that
 * results of that size are written by the commit alone. */
struct store_writer;

/* NULL without memory. The claim is copied. */
struct store_writer *store_writer_new(struct store *store, const struct store_claim *claim);

/* Appends. Not STORE_OK: give it up. STORE_CONFLICT: the claim is lost. */
enum store_answer store_writer_append(struct store_writer *writer, const void *bytes,
                                      size_t length) STORE_MUST_USE;

/* Ends the job as succeeded with this result and its `summary` (a JSON object). If another job of
 * the owner with the same digest was first, its result is taken and this one dropped. What failed
 * may be tried again. */
enum store_answer store_writer_commit(struct store_writer *writer,
                                      const char *summary) STORE_MUST_USE;

/* The same, and `store_claim` of the next job where that costs no transaction of its own:
 * elsewhere, when there is none and when this answers otherwise than STORE_OK, `next->sequence` is
 * 0. */
enum store_answer store_writer_commit_and_claim(struct store_writer *writer, const char *summary,
                                                struct store_claim *next) STORE_MUST_USE;

/* Frees it; without a commit what was written is dropped. NULL is allowed. */
void store_writer_free(struct store_writer *writer);

/* A result of which the commit is under way: all of its bytes, though it may never be the job's.
 * Whoever waits for the job can make ready what it is going to say, while the disk is waited for;
 * said it may be when it is kept. */
struct store_uncommitted;

/* The one of a job, in this process; NULL when there is none. The caller drops it.
 * JOB_RESULT_READABLE
 * (`server/job_events.h`) tells when it is there: it is not for long, nor for results of more than
 * 1 MiB. */
struct store_uncommitted *store_uncommitted_take(struct store *store, const char *id);

/* The same for one more user, who drops it. */
struct store_uncommitted *store_uncommitted_share(struct store_uncommitted *uncommitted);

/* NULL is allowed. Before the store is closed. */
void store_uncommitted_drop(struct store_uncommitted *uncommitted);

size_t store_uncommitted_length(const struct store_uncommitted *uncommitted);

/* Copies exactly `length` bytes from `offset` on; false when there are not as many. */
bool store_uncommitted_read(const struct store_uncommitted *uncommitted, uint64_t offset,
                            void *bytes, size_t length);

/* Whether the commit has succeeded with it: its bytes are those of the job's stored result. */
bool store_uncommitted_kept(const struct store_uncommitted *uncommitted);

/* A finished result. Its bytes never change; `digest` of the job names them. */
struct store_result {
    char id[ID_SIZE]; /* of the job that was asked for */
    int64_t number;
    int64_t length;
    int64_t job, token; /* what wrote it */
};

/* The result of a succeeded job, filled with STORE_OK alone. STORE_EMPTY: no such job, not
 * succeeded, or expired. */
enum store_answer store_result_find(struct store *store, const char *id,
                                    struct store_result *result) STORE_MUST_USE;

/* Copies exactly `length` bytes from `offset` on; both within the result's length. STORE_EMPTY: the
 * result has been removed meanwhile. */
enum store_answer store_result_read(struct store *store, const struct store_result *result,
                                    int64_t offset, void *bytes, size_t length) STORE_MUST_USE;

/* ------------------------------------------------------------------ surfaces, materials, links */

/* What owners keep until they delete it. */
enum store_item_kind {
    STORE_SURFACES,  /* named by what they hold */
    STORE_MATERIALS, /* named by who posts them */
    STORE_LINKS,     /* named by the hashes of their tokens */
    STORE_ITEM_KINDS
};

/* "surface", "material", "link". */
const char *store_item_kind_name(enum store_item_kind kind);

/* Both texts are malloc'ed and may be NULL; cleared by `store_item_clear`. */
struct store_item {
    char id[STORE_DIGEST_SIZE]; /* the name */
    int64_t sequence;
    int64_t created;
    char owner[STORE_OWNER_SIZE];
    char *definition; /* the JSON document; of a link its record */
    size_t definition_length;
    char *description; /* the JSON object that lists show */
    char *form;        /* of a surface: its prepared form, for `store_item_put` alone; NULL: none */
    size_t form_length;
};

void store_item_clear(struct store_item *item);

/* Items belong to the owner that stored them: each owner of a name has an entry of its own, and
 * what one does with it does not touch the others'. */

/* Stores the item under its name for its owner. `*created` is false when that owner had the name
 * already; then nothing changes. */
enum store_answer store_item_put(struct store *store, enum store_item_kind kind,
                                 const struct store_item *item, bool *created) STORE_MUST_USE;

/* Both texts. `owner` NULL: of any owner; all surfaces of an id hold the same. STORE_EMPTY. */
enum store_answer store_item_get(struct store *store, enum store_item_kind kind, const char *owner,
                                 const char *id, struct store_item *item) STORE_MUST_USE;

/* The prepared form of a surface, which can be made from its definition again: bytes that another
 * version may have written, in a malloc'ed buffer that the caller frees; NULL: it has none. With
 * `form` NULL only whether there is the surface. STORE_EMPTY: there is none. */
enum store_answer store_form_get(struct store *store, const char *owner, const char *id,
                                 char **form, size_t *length) STORE_MUST_USE;

/* Puts another in its place, for all owners of the surface who are meant by `owner`. */
enum store_answer store_form_put(struct store *store, const char *owner, const char *id,
                                 const void *form, size_t length) STORE_MUST_USE;

/* `count` items without their definitions, newest first; `next` as in store_page. */
struct store_items {
    struct store_item *items;
    size_t count;
    int64_t next;
};

/* `owner` NULL: of all owners; `cursor` 0: from the newest. Cleared by `store_items_clear`. */
enum store_answer store_item_list(struct store *store, enum store_item_kind kind, const char *owner,
                                  int64_t cursor, int limit,
                                  struct store_items *page) STORE_MUST_USE;
void store_items_clear(struct store_items *page);

/* Takes it from its owner; `owner` NULL: from all who have it. STORE_EMPTY. STORE_CONFLICT of a
 * surface while a queued or running job of that owner needs it, or, when no other owner has it, of
 * any owner; jobs have their materials in their requests. */
enum store_answer store_item_delete(struct store *store, enum store_item_kind kind,
                                    const char *owner, const char *id) STORE_MUST_USE;

#endif
