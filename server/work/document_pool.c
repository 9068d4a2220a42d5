/* SPDX-License-Identifier: MIT */
#include "document_pool.h"

#include "document_pool_internal.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/spool.h"
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    LOOK_MS = 50,      /* how soon a dropped check, or the end of the pool, is noticed */
    SLOW_NICENESS = 10 /* of a process in the slow queue, above ours */
};

/* ------------------------------------------------------------------ queues, with the lock */

/* Of the lists, `waiting` and `running`. */
static void queue_append(struct check **list, struct check *check) {
    while (*list)
        list = &(*list)->next;
    check->next = NULL;
    *list = check;
}

static void queue_withdraw(struct check **list, const struct check *check) {
    while (*list && *list != check)
        list = &(*list)->next;
    if (*list)
        *list = check->next;
}

/* The checks of a list that are the owner's, in any queue when that is QUEUES. */
static int count_checks(const struct check *list, const char *owner, enum check_queue queue) {
    int found = 0;
    for (; list; list = list->next)
        found += !strcmp(list->owner, owner) && (queue == QUEUES || list->queue == queue);
    return found;
}

/* Whether as many of the owner's wait in the queue as may. */
static bool queue_full(const struct document_pool *pool, const char *owner,
                       enum check_queue queue) {
    return count_checks(pool->waiting, owner, queue) >=
           (queue == QUEUE_SLOW ? DOCUMENT_POOL_SLOW_MAX : DOCUMENT_POOL_WAITING_MAX);
}

/* Whether the slow queue has room for a check of the owner. */
static bool slow_has_room(const struct document_pool *pool, const char *owner) {
    int most = pool->settings.slow;
    int share = most > 1 ? most - 1 : 1;
    return pool->stats.under_way[QUEUE_SLOW] < most &&
           count_checks(pool->running, owner, QUEUE_SLOW) < share;
}

/* An order of the owner has taken long in the fast queue: its next ones come last there. */
static void queue_note_long(struct document_pool *pool, const char *owner, int64_t now) {
    int at = 0;
    for (int k = 0; k < DOCUMENT_POOL_LONG_OWNERS; k++) {
        if (!strcmp(pool->long_owners[k].owner, owner)) {
            at = k;
            break;
        }
        if (pool->long_owners[k].until_ms < pool->long_owners[at].until_ms)
            at = k;
    }
    memcpy(pool->long_owners[at].owner, owner, DOCUMENT_POOL_OWNER_SIZE);
    pool->long_owners[at].until_ms = now + DOCUMENT_POOL_LONG_MS;
    for (struct check *check = pool->waiting; check; check = check->next)
        check->last = check->last || !strcmp(check->owner, owner);
}

/* Whether the check may begin now, in the queue it is in. */
static bool queue_may_begin(const struct document_pool *pool, const struct check *check) {
    int kept = check->last && pool->settings.fast > 1; /* for the others */
    if (!pool->idle || pool->stats.reserved + check->reserve > pool->settings.memory)
        return false;
    return check->queue == QUEUE_SLOW
               ? slow_has_room(pool, check->owner)
               : pool->stats.under_way[QUEUE_FAST] < pool->settings.fast - kept;
}

/* The check that begins next: of those that may, the first of the owner with the fewest under way,
 * of whom nothing took long lately. NULL: none may. */
static struct check *queue_choose(const struct document_pool *pool) {
    struct check *best = NULL;
    int least = 0;
    for (struct check *check = pool->waiting; check; check = check->next) {
        if (!queue_may_begin(pool, check))
            continue;
        int rank = count_checks(pool->running, check->owner, QUEUES);
        if (check->queue == QUEUE_FAST && check->last)
            rank += pool->process_count;
        if (best && rank >= least)
            continue;
        best = check;
        least = rank;
    }
    return best;
}

/* Gives the check, which is in no list, the first idle process. */
static void queue_begin(struct document_pool *pool, struct check *check) {
    check->process = pool->idle;
    pool->idle = check->process->next;
    check->state = CHECK_RUNNING;
    check->begun_ms = clock_ms();
    pool->stats.under_way[check->queue]++;
    pool->stats.reserved += check->reserve;
    queue_append(&pool->running, check);
}

/* A process, or bytes of the budget, have become free: most of the time nobody waits for them. */
static void wake_for_waiting(struct document_pool *pool) {
    if (pool->waiting)
        pthread_cond_broadcast(&pool->changed);
}

/* Gives back the process and its share of the budget; what else of its owner waits comes behind
 * what others wait with. */
static void queue_leave(struct document_pool *pool, struct check *check) {
    struct check *own = NULL, **end = &own, **at = &pool->waiting;
    queue_withdraw(&pool->running, check);
    while (*at) { /* what waits of the owner comes behind all else that waits */
        struct check *waits = *at;
        if (strcmp(waits->owner, check->owner) != 0) {
            at = &waits->next;
            continue;
        }
        *at = waits->next;
        *end = waits;
        end = &waits->next;
    }
    *end = NULL;
    *at = own;
    check->process->next = pool->idle;
    pool->idle = check->process;
    check->process = NULL;
    pool->stats.under_way[check->queue]--;
    pool->stats.reserved -= check->reserve;
    wake_for_waiting(pool);
}

/* ------------------------------------------------------------------ a process */

bool document_pool_can_import(void) {
    char importer[CHILD_PATH_SIZE];
    child_beside(DOCUMENT_POOL_IMPORTER, importer);
    return access(importer, X_OK) == 0;
}

/* Starts the process if none runs, or another program, and waits for its word that it is locked
 * in. */
static bool process_start(struct document_pool *pool, struct checker_process *process,
                          bool imports) {
    struct checker_hello hello;
    char importer[CHILD_PATH_SIZE];
    if (child_running(&process->child) && process->imports == imports)
        return true;
    child_kill(&process->child);
    child_beside(DOCUMENT_POOL_IMPORTER, importer);
    if (!child_start(&process->child, imports ? importer : NULL, CHECKER_ARGUMENT))
        return false;
    process->imports = imports;
    process->limit = 0;
    process->slow = false;
    if (frame_expect(process->child.socket, FRAME_HELLO, &hello, sizeof hello, NULL, NULL) !=
        FRAME_READY) {
        child_kill(&process->child);
        return false;
    }
    process->base = hello.address_space;
    child_bound(&process->child, RLIMIT_FSIZE, (uint64_t)pool->settings.max_output);
    return true;
}

/* Bounds its memory for the order, whose documents are mapped beside it; most orders have the same.
 */
static void process_bound(struct check *check) {
    struct checker_process *process = check->process;
    uint64_t limit = process->base + (uint64_t)check->reserve;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++)
        limit += check->files[k] >= 0 ? check->packet.length[k] : 0;
    if (process->limit == limit)
        return;
    process->limit = limit;
    child_bound(&process->child, RLIMIT_AS, limit);
}

/* Ends it; a crash is said in the log. */
static void process_end(struct checker_process *process, bool crashed) {
    char why[CHILD_WHY_SIZE];
    if (crashed) {
        child_reap(&process->child, why);
        log_warning(log_event("checker_crashed"), log_text("why", why),
                    log_text("program", process->imports ? DOCUMENT_POOL_IMPORTER : "draped"));
    } else {
        child_kill(&process->child);
    }
}

/* Gives it the priority of the slow queue. */
static void process_lower(struct checker_process *process) {
    if (!process->slow)
        child_lower(&process->child, SLOW_NICENESS);
    process->slow = true;
}

/* ------------------------------------------------------------------ a check on its process */

/* On a thread of the pool: follows an order that has been sent to its end. One that takes too long
 * for the fast queue moves to the slow one with its process, if that has room; if not, it has to
 * begin anew there, unless too many of the owner's wait. */
static enum check_outcome follow_check(struct check *check) {
    struct document_pool *pool = check->pool;
    for (;;) {
        bool fast = check->queue == QUEUE_FAST;
        int64_t fast_until = check->begun_ms + DOCUMENT_POOL_FAST_MS;
        int64_t wait = (fast ? fast_until : check->packet.deadline_ms) - clock_ms();
        enum check_outcome outcome = check_receive(check, wait < LOOK_MS ? wait : LOOK_MS);
        if (outcome != CHECK_LATER)
            return outcome;
        int64_t now = clock_ms();
        pthread_mutex_lock(&pool->lock);
        bool unwanted = check->dropped || pool->stopping;
        /* in the slow queue it gives way when it has had its turn, and an owner with nothing there
         * waits for one */
        bool yields = false;
        int64_t turn = pool->settings.turn_ms << (check->turns < 16 ? check->turns : 16);
        if (!unwanted && !fast && now < check->packet.deadline_ms &&
            now >= check->begun_ms + turn && now >= pool->yielded_ms + DOCUMENT_POOL_YIELD_MS)
            for (const struct check *other = pool->waiting; other && !yields; other = other->next)
                yields = other->queue == QUEUE_SLOW && strcmp(other->owner, check->owner) != 0 &&
                         count_checks(pool->running, other->owner, QUEUE_SLOW) == 0;
        if (yields) {
            pool->yielded_ms = now;
            check->turns++;
        }
        pthread_mutex_unlock(&pool->lock);
        if (unwanted)
            return CHECK_DROPPED;
        if (now >= check->packet.deadline_ms)
            return CHECK_TIMEOUT;
        if (yields)
            return CHECK_AGAIN;
        if (!fast || now < fast_until)
            continue;
        pthread_mutex_lock(&pool->lock);
        bool room = slow_has_room(pool, check->owner);
        bool full = queue_full(pool, check->owner, QUEUE_SLOW);
        queue_note_long(pool, check->owner, clock_ms());
        if (room) {
            pool->stats.under_way[QUEUE_FAST]--;
            pool->stats.under_way[QUEUE_SLOW]++;
            check->queue = QUEUE_SLOW;
            wake_for_waiting(pool);
        }
        pthread_mutex_unlock(&pool->lock);
        if (!room)
            return full ? CHECK_QUOTA : CHECK_AGAIN;
        process_lower(check->process);
    }
}

/* Stops the process; the check waits in that queue for so many bytes, unless nobody wants it any
 * more. */
static void begin_anew(struct check *check, enum check_queue queue, int64_t reserve) {
    struct document_pool *pool = check->pool;
    process_end(check->process, false);
    check_close(check, CHECKER_OUTPUT, CHECKER_FILES);
    pthread_mutex_lock(&pool->lock);
    queue_leave(pool, check);
    pool->stats.restarts++;
    check->queue = queue;
    check->reserve = reserve;
    check->state = CHECK_WAITING;
    bool dropped = check->dropped;
    if (!dropped) {
        queue_append(&pool->waiting, check);
        pthread_cond_signal(&pool->changed);
    }
    pthread_mutex_unlock(&pool->lock);
    if (dropped)
        check_free(check);
}

/* The end of a check: gives back the process, keeps of the files what was written, and notifies the
 * caller, or frees the check if that has gone. A process of the slow queue keeps its low priority,
 * so it is not used again. What an order takes is estimated by its length (`reserve_of`). The
 * rare one that takes more, such as a surface of very many spans with trims, is tried once more
 * with all that there is. */
static void finish_check(struct check *check, enum check_outcome outcome, bool notify) {
    struct document_pool *pool = check->pool;
    char subject[ID_SIZE];
    if (outcome == CHECK_ANSWER && check->answer.problem.id == API_OUT_OF_MEMORY &&
        check->reserve < check_most(pool)) {
        begin_anew(check, QUEUE_SLOW, check_most(pool));
        return;
    }
    if (outcome != CHECK_ANSWER || check->process->slow)
        process_end(check->process, outcome == CHECK_CRASHED);
    check_explain(check, outcome);
    check_close(check, 0, CHECKER_DOCUMENTS);
    memcpy(subject, check->subject, sizeof subject);
    pthread_mutex_lock(&pool->lock);
    if (check->queue == QUEUE_FAST && check->answer.processor_us > DOCUMENT_POOL_QUICK_MS * 1000)
        queue_note_long(pool, check->owner, clock_ms());
    queue_leave(pool, check);
    pool->stats.done++;
    pool->stats.crashes += outcome == CHECK_CRASHED;
    pool->stats.timeouts += outcome == CHECK_TIMEOUT;
    check->state = CHECK_DONE;
    bool dropped = check->dropped;
    pthread_mutex_unlock(&pool->lock);
    if (dropped)
        check_free(check);
    else if (notify)
        job_events_notify(pool->events, subject, JOB_CHANGED);
}

/* Works on a check, whose order has been `sent` or else is sent now, to a new process if the one it
 * has is gone. */
static void run_check(struct check *check, bool sent) {
    bool begun = sent || check_files(check);
    for (int sends = 0; begun && !sent && sends < 2; sends++) {
        begun = process_start(check->pool, check->process, check_imports(check));
        if (!begun)
            break;
        process_bound(check);
        if (check->queue == QUEUE_SLOW)
            process_lower(check->process);
        sent = check_send(check);
        if (!sent)
            process_end(check->process, false);
    }
    enum check_outcome outcome = sent ? follow_check(check) : CHECK_NOT_BEGUN;
    bool killed = outcome == CHECK_CRASHED && !check->crashed && !check_imports(check);
    check->crashed = outcome == CHECK_CRASHED;
    if (outcome == CHECK_AGAIN || killed) /* perhaps by somebody else: it may try once more */
        begin_anew(check, outcome == CHECK_AGAIN ? QUEUE_SLOW : check->queue, check->reserve);
    else
        finish_check(check, outcome, true);
}

/* ------------------------------------------------------------------ the threads */

/* As many as there are processes, so that none waits for a thread. Each begins with starting one
 * process, and lives as long as the pool, since a process ends with the thread that started it.
 * Checks whose order has been sent come before those that wait. */
static void *serve_checks(void *context) {
    struct document_pool *pool = context;
    pthread_mutex_lock(&pool->lock);
    struct checker_process *own = &pool->processes[pool->processes_ready++];
    pthread_mutex_unlock(&pool->lock);
    if (own - pool->processes < pool->settings.fast)
        process_start(pool, own, false);
    pthread_mutex_lock(&pool->lock);
    own->next = pool->idle;
    pool->idle = own;
    for (;;) {
        struct check *check = pool->running;
        while (check && check->state != CHECK_ADOPTED)
            check = check->next;
        bool sent = check != NULL;
        if (!sent && pool->stopping)
            break;
        check = sent ? check : queue_choose(pool);
        if (!check) {
            pthread_cond_wait(&pool->changed, &pool->lock);
            continue;
        }
        if (sent) {
            check->state = CHECK_RUNNING;
        } else {
            queue_withdraw(&pool->waiting, check);
            queue_begin(pool, check);
        }
        pthread_mutex_unlock(&pool->lock);
        run_check(check, sent);
        pthread_mutex_lock(&pool->lock);
    }
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

struct document_pool *document_pool_start(struct job_events *events,
                                          const struct document_pool_settings *settings) {
    struct document_pool *pool = calloc(1, sizeof *pool);
    if (!pool)
        return NULL;
    pool->events = events;
    pool->settings = *settings;
    pool->process_count = settings->fast + settings->slow;
    pool->processes = calloc((size_t)pool->process_count, sizeof *pool->processes);
    pool->threads = calloc((size_t)pool->process_count, sizeof *pool->threads);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->changed, NULL);
    while (pool->processes && pool->threads && pool->thread_count < pool->process_count &&
           pthread_create(&pool->threads[pool->thread_count], NULL, serve_checks, pool) == 0)
        pool->thread_count++;
    if (pool->thread_count == pool->process_count)
        return pool;
    document_pool_stop(pool);
    return NULL;
}

void document_pool_stop(struct document_pool *pool) {
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->stopping = true;
    pthread_cond_broadcast(&pool->changed);
    pthread_mutex_unlock(&pool->lock);
    for (int k = 0; k < pool->thread_count; k++)
        pthread_join(pool->threads[k], NULL);
    for (int k = 0; pool->processes && k < pool->process_count; k++)
        child_kill(&pool->processes[k].child);
    pthread_cond_destroy(&pool->changed);
    pthread_mutex_destroy(&pool->lock);
    free(pool->processes);
    free(pool->threads);
    free(pool);
}

void document_pool_stats(struct document_pool *pool, struct document_pool_stats *stats) {
    pthread_mutex_lock(&pool->lock);
    *stats = pool->stats;
    for (const struct check *check = pool->waiting; check; check = check->next)
        stats->waiting++;
    pthread_mutex_unlock(&pool->lock);
}

/* ------------------------------------------------------------------ the callers */

/* The order, on the caller's thread; a thread of the pool takes over unless it is answered soon. */
static void run_at_once(struct check *check) {
    struct document_pool *pool = check->pool;
    bool sent = check_files(check);
    if (sent) {
        process_bound(check);
        sent = check_send(check);
    }
    if (sent && check_receive(check, DOCUMENT_POOL_AT_ONCE_MS) == CHECK_ANSWER) {
        finish_check(check, CHECK_ANSWER, false);
        return;
    }
    pthread_mutex_lock(&pool->lock);
    if (sent) {
        check->state = CHECK_ADOPTED;
    } else {
        queue_leave(pool, check);
        check->state = CHECK_WAITING;
        queue_append(&pool->waiting, check);
    }
    pthread_cond_signal(&pool->changed);
    pthread_mutex_unlock(&pool->lock);
}

struct check *document_pool_begin(struct document_pool *pool,
                                  const struct document_pool_order *order, const char *subject,
                                  struct api_problem *problem) {
    struct check *check = check_new(pool, order, subject);
    if (!check) {
        api_problem_set(problem, API_UNAVAILABLE, "there is no memory for this now");
        return NULL;
    }
    pthread_mutex_lock(&pool->lock);
    bool full = queue_full(pool, check->owner, check->queue);
    int64_t now = clock_ms();
    for (int k = 0; k < DOCUMENT_POOL_LONG_OWNERS; k++)
        if (pool->long_owners[k].until_ms > now &&
            !strcmp(pool->long_owners[k].owner, check->owner))
            check->last = true;
    bool begun = false;
    if (!full && !check->columns.write && !check_imports(check) && queue_may_begin(pool, check) &&
        !queue_choose(pool)) {
        /* no other check would be the next: it begins at once if a process runs that is free */
        struct checker_process **at = &pool->idle;
        while (*at && (!child_running(&(*at)->child) || (*at)->imports))
            at = &(*at)->next;
        struct checker_process *process = *at;
        begun = process != NULL;
        if (begun) {
            *at = process->next;
            process->next = pool->idle;
            pool->idle = process;
            queue_begin(pool, check);
        }
    }
    if (!full && !begun) {
        queue_append(&pool->waiting, check);
        pthread_cond_signal(&pool->changed);
    }
    pthread_mutex_unlock(&pool->lock);
    if (begun)
        run_at_once(check);
    if (!full)
        return check;
    enum check_queue queue = check->queue;
    check->columns = (struct document_pool_columns){0}; /* still the caller's */
    check_free(check);
    check_explain_quota(problem, queue);
    return NULL;
}

bool check_done(struct check *check) {
    pthread_mutex_lock(&check->pool->lock);
    bool done = check->state == CHECK_DONE;
    pthread_mutex_unlock(&check->pool->lock);
    return done;
}

const struct checker_answer *check_answer(const struct check *check) {
    return &check->answer;
}

/* A form of another length than is said is none. */
int check_form(const struct check *check, size_t *length) {
    const int file = check->files[CHECKER_FORM_OUTPUT];
    struct stat written;
    *length = check->answer.check.form_length;
    bool good = file >= 0 && *length > 0 && fstat(file, &written) == 0 &&
                (uint64_t)written.st_size == *length && spool_seal(file);
    return good ? fcntl(file, F_DUPFD_CLOEXEC, 0) : -1;
}

ssize_t check_read(struct check *check, uint64_t offset, char *buffer, size_t size) {
    uint64_t left = check->answer.output_length - offset;
    if (offset >= check->answer.output_length)
        return 0;
    ssize_t got = pread(check->files[CHECKER_OUTPUT], buffer, size < left ? size : (size_t)left,
                        (off_t)offset);
    return got > 0 ? got : -1;
}

void check_drop(struct check *check) {
    if (!check)
        return;
    struct document_pool *pool = check->pool;
    pthread_mutex_lock(&pool->lock);
    bool free_here = check->state == CHECK_DONE || check->state == CHECK_WAITING;
    if (check->state == CHECK_WAITING)
        queue_withdraw(&pool->waiting, check);
    check->dropped = true; /* else a thread of the pool frees it */
    pthread_mutex_unlock(&pool->lock);
    if (free_here)
        check_free(check);
}
