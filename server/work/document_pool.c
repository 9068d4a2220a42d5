/* SPDX-License-Identifier: MIT */
#include "document_pool.h"

#include "document_pool_parts.h"
#include "server/clock.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LOOK_MS = 50 }; /* how soon a dropped check, or the end of the pool, is noticed */

static bool is_unwanted(struct check *check) {
    pthread_mutex_lock(&check->pool->lock);
    bool unwanted = check->dropped || check->pool->stopping;
    pthread_mutex_unlock(&check->pool->lock);
    return unwanted;
}

static bool must_yield(struct check *check, int64_t now) {
    pthread_mutex_lock(&check->pool->lock);
    bool yields = lane_must_yield(check->pool, check, now);
    pthread_mutex_unlock(&check->pool->lock);
    return yields;
}

/* What to do with a check that has no answer yet. */
static enum check_outcome look(struct check *check) {
    int64_t now = clock_ms();
    if (is_unwanted(check))
        return OUTCOME_DROPPED;
    if (now >= check->packet.deadline_ms)
        return OUTCOME_TIMEOUT;
    if (check->lane == LANE_SLOW)
        return must_yield(check, now) ? OUTCOME_AGAIN : OUTCOME_LATER;
    if (now < check->begun_ms + DOCUMENT_POOL_EXPRESS_MS)
        return OUTCOME_LATER;
    enum check_outcome outcome = lane_move_to_slow(check->pool, check);
    if (outcome == OUTCOME_LATER)
        place_lower(check->place);
    return outcome;
}

/* On a thread of the pool: follows an order that has been sent to its end. */
static enum check_outcome follow(struct check *check) {
    enum check_outcome outcome = OUTCOME_LATER;
    while (outcome == OUTCOME_LATER) {
        int64_t until = check->lane == LANE_EXPRESS ? check->begun_ms + DOCUMENT_POOL_EXPRESS_MS
                                                    : check->packet.deadline_ms;
        int64_t wait = until - clock_ms();
        outcome = check_receive(check, wait < LOOK_MS ? wait : LOOK_MS);
        if (outcome == OUTCOME_LATER)
            outcome = look(check);
    }
    return outcome;
}

/* The end of a check: gives back the place, keeps of the files what was written, and notifies the
 * caller, or frees the check if that has gone. A process of the slow lane keeps its low priority,
 * so it is not used again. */
static void finish(struct check *check, enum check_outcome outcome, bool notify) {
    struct document_pool *pool = check->pool;
    char subject[ID_SIZE];
    if (outcome != OUTCOME_ANSWER || check->place->slow)
        place_end(check->place, outcome == OUTCOME_CRASHED);
    check_explain(check, outcome);
    check_close(check, CHECKER_DOCUMENTS);
    memcpy(subject, check->subject, sizeof subject);
    pthread_mutex_lock(&pool->lock);
    if (check->lane == LANE_EXPRESS && check->answer.processor_us > DOCUMENT_POOL_QUICK_MS * 1000)
        lane_note_long(pool, check->owner, clock_ms());
    lane_leave(pool, check);
    pool->stats.done++;
    pool->stats.crashes += outcome == OUTCOME_CRASHED;
    pool->stats.timeouts += outcome == OUTCOME_TIMEOUT;
    check->state = STATE_DONE;
    bool dropped = check->dropped;
    pthread_mutex_unlock(&pool->lock);
    if (dropped)
        check_free(check);
    else if (notify)
        job_events_notify(pool->events, subject, JOB_CHANGED);
}

/* Stops the process; the check waits for that lane and so many bytes, unless nobody wants it any
 * more. */
static void begin_anew(struct check *check, enum check_lane lane, int64_t reserve) {
    struct document_pool *pool = check->pool;
    int *output = &check->files[CHECKER_DOCUMENTS];
    place_end(check->place, false);
    if (*output >= 0)
        close(*output);
    *output = -1;
    pthread_mutex_lock(&pool->lock);
    lane_leave(pool, check);
    pool->stats.restarts++;
    check->lane = lane;
    check->reserve = reserve;
    check->state = STATE_WAITING;
    bool dropped = check->dropped;
    if (!dropped) {
        lane_append(&pool->waiting, check);
        pthread_cond_signal(&pool->changed);
    }
    pthread_mutex_unlock(&pool->lock);
    if (dropped)
        check_free(check);
}

/* Sends the order to the process of the check's place; to a new one if that has gone meanwhile. */
static bool set_off(struct check *check) {
    struct check_place *place = check->place;
    if (!check_files(check))
        return false;
    for (int attempt = 0; attempt < 2; attempt++) {
        if (!place_start(check->pool, place, check_imports(check)))
            return false;
        place_bound(check);
        if (check->lane == LANE_SLOW)
            place_lower(place);
        if (check_send(check))
            return true;
        place_end(place, false);
    }
    return false;
}

/* What an order takes is estimated by its length (`reserve_of`). The rare one that takes more, such
 * as a surface of very many spans with trims, is tried once more with all that there is. */
static bool is_cramped(const struct check *check, enum check_outcome outcome) {
    return outcome == OUTCOME_ANSWER && check->answer.problem.id == API_OUT_OF_MEMORY &&
           check->reserve < check_most(check->pool);
}

static void run(struct check *check, bool sent) {
    enum check_outcome outcome = sent || set_off(check) ? follow(check) : OUTCOME_NOT_BEGUN;
    bool killed = outcome == OUTCOME_CRASHED && !check->crashed && !check_imports(check);
    check->crashed = outcome == OUTCOME_CRASHED;
    if (is_cramped(check, outcome))
        begin_anew(check, LANE_SLOW, check_most(check->pool));
    else if (outcome == OUTCOME_AGAIN ||
             killed) /* perhaps by somebody else: it may try once more */
        begin_anew(check, outcome == OUTCOME_AGAIN ? LANE_SLOW : check->lane, check->reserve);
    else
        finish(check, outcome, true);
}

/* ------------------------------------------------------------------ the threads */

static struct check *find_adopted(const struct document_pool *pool) {
    struct check *check = pool->running;
    while (check && check->state != STATE_ADOPTED)
        check = check->next;
    return check;
}

/* With the lock: the next check, under way; NULL at the end. `sent` says whether its order is. */
static struct check *wait_for_check(struct document_pool *pool, bool *sent) {
    for (;;) {
        struct check *check = find_adopted(pool);
        *sent = check != NULL;
        if (check) {
            check->state = STATE_RUNNING;
            return check;
        }
        if (pool->stopping)
            return NULL;
        check = lane_choose(pool);
        if (check) {
            lane_withdraw(&pool->waiting, check);
            lane_begin(pool, check);
            return check;
        }
        pthread_cond_wait(&pool->changed, &pool->lock);
    }
}

/* As many as there are places, so that none waits for a thread. Each begins with starting the
 * process of one place, and lives as long as the pool, since a process ends with the thread that
 * started it. */
static void *work(void *context) {
    struct document_pool *pool = context;
    struct check *check;
    bool sent;
    pthread_mutex_lock(&pool->lock);
    struct check_place *own = &pool->places[pool->places_ready++];
    pthread_mutex_unlock(&pool->lock);
    if (own - pool->places < pool->settings.express)
        place_start(pool, own, false);
    pthread_mutex_lock(&pool->lock);
    own->next = pool->idle;
    pool->idle = own;
    while ((check = wait_for_check(pool, &sent))) {
        pthread_mutex_unlock(&pool->lock);
        run(check, sent);
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
    pool->value_count = settings->express + settings->slow;
    pool->places = calloc((size_t)pool->value_count, sizeof *pool->places);
    pool->threads = calloc((size_t)pool->value_count, sizeof *pool->threads);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->changed, NULL);
    while (pool->places && pool->threads && pool->thread_count < pool->value_count &&
           pthread_create(&pool->threads[pool->thread_count], NULL, work, pool) == 0)
        pool->thread_count++;
    if (pool->thread_count == pool->value_count)
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
    for (int k = 0; pool->places && k < pool->value_count; k++)
        child_kill(&pool->places[k].child);
    pthread_cond_destroy(&pool->changed);
    pthread_mutex_destroy(&pool->lock);
    free(pool->places);
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

/* With the lock: whether the check can begin with a process that runs already, and nobody else
 * would be the next. It has begun then. */
static bool begin_at_once(struct document_pool *pool, struct check *check) {
    if (check->columns.write || check_imports(check) || !lane_may_begin(pool, check) ||
        lane_choose(pool))
        return false;
    for (struct check_place **at = &pool->idle; *at; at = &(*at)->next) {
        struct check_place *place = *at;
        if (!child_running(&place->child) || place->imports)
            continue;
        *at = place->next;
        place->next = pool->idle;
        pool->idle = place;
        lane_begin(pool, check);
        return true;
    }
    return false;
}

/* The order, on the caller's thread; handed over to a thread of the pool unless it is answered
 * soon.
 */
static void run_at_once(struct check *check) {
    struct document_pool *pool = check->pool;
    bool sent = check_files(check);
    if (sent) {
        place_bound(check);
        sent = check_send(check);
    }
    if (sent && check_receive(check, DOCUMENT_POOL_AT_ONCE_MS) == OUTCOME_ANSWER) {
        if (is_cramped(check, OUTCOME_ANSWER))
            begin_anew(check, LANE_SLOW, check_most(pool));
        else
            finish(check, OUTCOME_ANSWER, false);
        return;
    }
    pthread_mutex_lock(&pool->lock);
    if (sent) {
        check->state = STATE_ADOPTED;
    } else {
        lane_leave(pool, check);
        check->state = STATE_WAITING;
        lane_append(&pool->waiting, check);
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
    bool full = lane_full(pool, check->owner, check->lane);
    check->last = lane_takes_long(pool, check->owner, clock_ms());
    bool begun = !full && begin_at_once(pool, check);
    if (!full && !begun) {
        lane_append(&pool->waiting, check);
        pthread_cond_signal(&pool->changed);
    }
    pthread_mutex_unlock(&pool->lock);
    if (begun)
        run_at_once(check);
    if (!full)
        return check;
    enum check_lane lane = check->lane;
    check->columns = (struct document_pool_columns){0}; /* still the caller's */
    check_free(check);
    check_explain_quota(problem, lane);
    return NULL;
}

bool check_done(struct check *check) {
    pthread_mutex_lock(&check->pool->lock);
    bool done = check->state == STATE_DONE;
    pthread_mutex_unlock(&check->pool->lock);
    return done;
}

const struct checker_answer *check_answer(const struct check *check) {
    return &check->answer;
}

ssize_t check_read(struct check *check, uint64_t offset, char *buffer, size_t size) {
    uint64_t left = check->answer.output_length - offset;
    if (offset >= check->answer.output_length)
        return 0;
    ssize_t got = pread(check->files[CHECKER_DOCUMENTS], buffer, size < left ? size : (size_t)left,
                        (off_t)offset);
    return got > 0 ? got : -1;
}

void check_drop(struct check *check) {
    if (!check)
        return;
    struct document_pool *pool = check->pool;
    pthread_mutex_lock(&pool->lock);
    bool free_here = check->state == STATE_DONE || check->state == STATE_WAITING;
    if (check->state == STATE_WAITING)
        lane_withdraw(&pool->waiting, check);
    check->dropped = true; /* else a thread of the pool frees it */
    pthread_mutex_unlock(&pool->lock);
    if (free_here)
        check_free(check);
}
