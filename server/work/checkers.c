/* SPDX-License-Identifier: MIT */
#include "checkers.h"
#include "api/files/files.h"
#include "child.h"
#include "sandbox.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/spool.h"
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    LOOK_MS = 50,      /* how soon a dropped check, or the end of the pool, is noticed */
    LONG_OWNERS = 32,  /* of whom it is known that their orders take long */
    SLOW_NICENESS = 10 /* of a process in the slow lane, above ours */
};

/* What an order may take, in bytes: a part for itself, and for each byte of its documents. The tree
 * of a hostile document takes up to 79 bytes a byte, a surface of high degree as much; but of a
 * long document that is one of numbers, whose surface is not made ready (`api/check.h`). Of a map
 * the most is taken by its columns, some 300 bytes a place; a point in JSON is 8 bytes of text at
 * the least, an element in bulk data with its share of a node 60. */
#define CHECK_BYTES (INT64_C(24) << 20)
#define CHECK_BYTES_PER_BYTE 96
#define CHECK_LONG_BYTES (INT64_C(128) << 20)
#define CHECK_LONG_BYTES_PER_BYTE 24
#define IMPORT_BYTES (INT64_C(256) << 20)
#define IMPORT_BYTES_PER_BYTE 96
#define MAP_BYTES (INT64_C(64) << 20)
#define MAP_BYTES_PER_JSON_BYTE 48
#define MAP_BYTES_PER_BULK_BYTE 6
#define MAP_BYTES_PER_COLUMN_BYTE 2
#define SAMPLE_BYTES (INT64_C(256) << 20) /* a drape of half a million nodes */
#define STACK_BYTES_PER_BODY_BYTE 3       /* and ply: of an element that takes 30 bytes or more */

/* An order that may take more begins in the slow lane. */
#define EXPRESS_BYTES (INT64_C(128) << 20)

enum state {
    STATE_WAITING,
    STATE_RUNNING,
    STATE_ADOPTED, /* its order is on the way; a thread of the pool is to follow it */
    STATE_DONE
};

enum lane { LANE_EXPRESS, LANE_SLOW, LANES };

/* A place for a process, and the bounds that it has now. */
struct place {
    struct child child;
    uint64_t base;  /* bytes of address space it starts with */
    uint64_t limit; /* the bytes it may have now; 0: not bounded yet */
    bool slow;      /* runs at the lower priority */
    bool imports;   /* its process is the importer */
    struct place *next;
};

struct check {
    struct checkers *pool;
    struct checkers_columns columns;
    char subject[ID_SIZE], owner[CHECKERS_OWNER_SIZE];
    struct checker_order packet;
    char *inlined; /* the documents in the packet */
    size_t inlined_length;
    int files[CHECKER_DOCUMENTS + 1]; /* -1: none */
    int64_t reserve;                  /* bytes; grows to all that the slow lane has, once */
    size_t max_memory;                /* of the order's limits */
    struct checker_answer answer;
    bool crashed; /* its last process */

    struct check *next; /* under the lock, like what follows: in the list it is in */
    enum state state;
    enum lane lane;
    bool last; /* its owner's orders took long lately */
    struct place *place;
    int64_t begun_ms;
    bool dropped;
};

struct checkers {
    struct hub *hub;
    struct checkers_settings settings;
    int place_count;
    struct place *places;
    pthread_t *threads; /* one a place */
    int thread_count;

    pthread_mutex_t lock; /* what is below */
    pthread_cond_t changed;
    int places_ready;
    struct place *idle;
    struct check *waiting, *running; /* lists; `waiting` in the order of arrival */
    struct {
        char owner[CHECKERS_OWNER_SIZE];
        int64_t until_ms;
    } long_owners[LONG_OWNERS];
    struct checkers_stats stats;
    bool stopping;
};

/* ------------------------------------------------------------------ lists, under the lock */

static void append(struct check **list, struct check *check) {
    while (*list)
        list = &(*list)->next;
    check->next = NULL;
    *list = check;
}

static void withdraw(struct check **list, const struct check *check) {
    while (*list && *list != check)
        list = &(*list)->next;
    if (*list)
        *list = check->next;
}

/* The checks of a list that are the owner's, in any lane when that is LANES. */
static int count(const struct check *list, const char *owner, enum lane lane) {
    int found = 0;
    for (; list; list = list->next)
        found += !strcmp(list->owner, owner) && (lane == LANES || list->lane == lane);
    return found;
}

/* With the lock: whether as many of the owner's wait as may, in the lane. */
static bool queue_full(const struct checkers *pool, const char *owner, enum lane lane) {
    return count(pool->waiting, owner, lane) >=
           (lane == LANE_SLOW ? CHECKERS_SLOW_MAX : CHECKERS_WAITING_MAX);
}

/* What of the budget is kept for the express lane: enough for short documents in all its places,
 * but not more than half. */
static int64_t express_share(const struct checkers *pool) {
    int64_t share =
        pool->settings.express * (CHECK_BYTES + CHECK_BYTES_PER_BYTE * CHECKER_INLINE_MAX);
    return share < pool->settings.memory / 2 ? share : pool->settings.memory / 2;
}

/* The rest: the most that one order may take. */
static int64_t slow_share(const struct checkers *pool) {
    return pool->settings.memory - express_share(pool);
}

/* ------------------------------------------------------------------ the order as a packet */

static int64_t reserve_of(const struct checkers_order *order, int64_t most) {
    int64_t body = (int64_t)order->length[CHECKER_BODY];
    int64_t second = (int64_t)(order->length[CHECKER_SECOND] + order->length[CHECKER_MATERIALS]);
    int64_t columns = (int64_t)order->columns.length;
    bool sample = order->kind == CHECKER_SAMPLE || order->kind == CHECKER_SAMPLE_MAP;
    int64_t of_short = CHECK_BYTES + CHECK_BYTES_PER_BYTE * (body + second);
    int64_t of_long = CHECK_LONG_BYTES + CHECK_LONG_BYTES_PER_BYTE * (body + second);
    int64_t bytes = of_short < of_long ? of_short : of_long;
    if (order->source)
        bytes = IMPORT_BYTES + IMPORT_BYTES_PER_BYTE * body;
    bool stack = order->kind == CHECKER_STACK;
    if (order->kind == CHECKER_MAP || order->kind == CHECKER_PATTERNS ||
        order->kind == CHECKER_SAMPLE_MAP || stack)
        bytes = MAP_BYTES + MAP_BYTES_PER_COLUMN_BYTE * columns +
                (order->nastran ? MAP_BYTES_PER_BULK_BYTE : MAP_BYTES_PER_JSON_BYTE) * body;
    if (stack)
        bytes += STACK_BYTES_PER_BODY_BYTE * (int64_t)order->variant * body;
    if (order->kind == CHECKER_VARIANT || sample)
        bytes += MAP_BYTES_PER_COLUMN_BYTE * columns +
                 CHECK_LONG_BYTES_PER_BYTE * (int64_t)order->length[CHECKER_REQUEST];
    if (order->kind == CHECKER_REPORT)
        bytes += MAP_BYTES + MAP_BYTES_PER_COLUMN_BYTE * columns;
    if (sample)
        bytes += SAMPLE_BYTES;
    return bytes < most ? bytes : most;
}

/* What may take as long as a job: what it makes, for messages. */
static const char *const works[CHECKER_KINDS] = {
    [CHECKER_MAP] = "the map",       [CHECKER_SAMPLE_MAP] = "the map",
    [CHECKER_STACK] = "the map",     [CHECKER_SAMPLE] = "the drape",
    [CHECKER_REPORT] = "the report", [CHECKER_PATTERNS] = "the patterns"};

static int64_t timeout_of(const struct check *check) {
    const struct checkers_settings *settings = &check->pool->settings;
    bool long_work = works[check->packet.kind] || check->packet.source[0];
    return long_work ? settings->map_timeout_ms : settings->timeout_ms;
}

/* Keeps the documents: short ones in memory, long ones as files. False without room for them. */
static bool keep_documents(struct check *check, const struct checkers_order *order) {
    size_t total = 0;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++)
        total += order->length[k];
    bool inlined = total <= CHECKER_INLINE_MAX;
    char *to = check->inlined = inlined ? malloc(total + 1) : NULL;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++) {
        size_t length = order->length[k];
        if (inlined && to && length) {
            memcpy(to, order->document[k], length);
            to += length;
        } else if (!inlined && length) {
            bool ready = k == CHECKER_BODY && order->body_file >= 0;
            check->files[k] =
                ready ? dup(order->body_file) : spool_of_bytes(order->document[k], length);
            if (check->files[k] < 0)
                return false;
        }
    }
    check->inlined_length = inlined ? total : 0;
    return !inlined || to;
}

static void fill_packet(struct check *check, const struct checkers_order *order) {
    struct checker_order *packet = &check->packet;
    packet->kind = order->kind;
    packet->limits = order->limits;
    packet->nastran = order->nastran;
    packet->variant = order->variant;
    packet->has_start = order->start != NULL;
    if (order->start)
        packet->start = *order->start;
    snprintf(packet->source, sizeof packet->source, "%s", order->source ? order->source : "");
    snprintf(packet->unit, sizeof packet->unit, "%s", order->unit ? order->unit : "");
    snprintf(packet->id, sizeof packet->id, "%s", order->id ? order->id : "");
    snprintf(packet->format, sizeof packet->format, "%s", order->format ? order->format : "");
    for (int k = 0; k < CHECKER_DOCUMENTS; k++)
        packet->length[k] = order->length[k];
    packet->length[CHECKER_COLUMNS] = order->columns.length;
}

/* Of requests only those that may name materials are written. */
static bool has_output(const struct check *check) {
    bool request = check->packet.kind == CHECKER_DRAPE || check->packet.kind == CHECKER_STUDY;
    return !request || !check->inlined ||
           api_material_mentioned(check->inlined, check->packet.length[CHECKER_BODY]);
}

/* Makes what the process reads and writes besides the documents, unless it is there. */
static bool make_files(struct check *check) {
    const char *folder = check->pool->settings.folder;
    int *columns = &check->files[CHECKER_COLUMNS], *output = &check->files[CHECKER_DOCUMENTS];
    if (check->columns.write && *columns < 0) {
        *columns = spool_new(check->columns.length, folder);
        if (*columns < 0 || !check->columns.write(check->columns.context, *columns))
            return false;
    }
    bool writes = has_output(check);
    if (writes && *output < 0)
        *output = spool_new(check->packet.length[CHECKER_BODY], folder);
    return !writes || *output >= 0;
}

/* False when the process is gone, or its socket does not take the packet. */
static bool send_order(struct check *check) {
    struct checker_order *packet = &check->packet;
    struct iovec parts[] = {{packet, sizeof *packet}, {check->inlined, check->inlined_length}};
    union {
        struct cmsghdr head;
        char bytes[CMSG_SPACE((CHECKER_DOCUMENTS + 1) * sizeof(int))];
    } control = {0};
    struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
    size_t files = 0;
    packet->deadline_ms = check->begun_ms + timeout_of(check);
    packet->limits.max_memory =
        check->max_memory < (size_t)check->reserve ? check->max_memory : (size_t)check->reserve;
    packet->files = 0;
    for (int k = 0; k <= CHECKER_DOCUMENTS; k++) {
        if (check->files[k] < 0)
            continue;
        packet->files |= 1u << k;
        memcpy(CMSG_DATA(&control.head) + files++ * sizeof(int), &check->files[k], sizeof(int));
    }
    if (files) {
        control.head.cmsg_level = SOL_SOCKET;
        control.head.cmsg_type = SCM_RIGHTS;
        control.head.cmsg_len = CMSG_LEN(files * sizeof(int));
        message.msg_control = control.bytes;
        message.msg_controllen = CMSG_SPACE(files * sizeof(int));
    }
    return sendmsg(check->place->child.socket, &message, MSG_NOSIGNAL | MSG_DONTWAIT) > 0;
}

/* ------------------------------------------------------------------ the process */

static void bound(const struct place *place, int resource, uint64_t value) {
    if (!sandbox_bound(place->child.pid, resource, value))
        log_warning(log_event("checker_not_bounded"), log_text("detail", strerror(errno)));
}

/* Whether the check takes the importer. */
static bool is_cad(const struct check *check) {
    const struct file_format *format = file_format_named(check->packet.source);
    return format && format->cad;
}

bool checkers_can_import(void) {
    char importer[CHILD_PATH_SIZE];
    child_beside(CHECKERS_IMPORTER, importer);
    return access(importer, X_OK) == 0;
}

/* Starts the place's process if it has none, and waits for its word that it is locked in. */
static bool start_process(struct checkers *pool, struct place *place, bool imports) {
    struct checker_hello hello;
    char importer[CHILD_PATH_SIZE];
    if (child_running(&place->child) && place->imports == imports)
        return true;
    child_kill(&place->child);
    child_beside(CHECKERS_IMPORTER, importer);
    if (!child_start(&place->child, imports ? importer : NULL, CHECKER_ARGUMENT, SOCK_SEQPACKET))
        return false;
    place->imports = imports;
    place->limit = 0;
    place->slow = false;
    if (recv(place->child.socket, &hello, sizeof hello, 0) != (ssize_t)sizeof hello) {
        child_kill(&place->child);
        return false;
    }
    place->base = hello.address_space;
    bound(place, RLIMIT_FSIZE, (uint64_t)pool->settings.max_output);
    return true;
}

/* Bounds its memory for the order, whose documents are mapped beside it; most orders have the same.
 */
static void bound_memory(struct check *check) {
    struct place *place = check->place;
    uint64_t mapped = 0;
    for (int k = 0; k < CHECKER_DOCUMENTS; k++)
        mapped += check->files[k] >= 0 ? check->packet.length[k] : 0;
    uint64_t limit = place->base + (uint64_t)check->reserve + mapped;
    if (place->limit == limit)
        return;
    place->limit = limit;
    bound(place, RLIMIT_AS, limit);
}

static void end_process(struct place *place, bool crashed) {
    char why[CHILD_WHY_SIZE];
    if (crashed) {
        child_reap(&place->child, why);
        log_warning(log_event("checker_crashed"), log_text("why", why));
    } else {
        child_kill(&place->child);
    }
}

/* ------------------------------------------------------------------ lanes, under the lock */

/* Whether the slow lane has a place for the owner. */
static bool slow_place(const struct checkers *pool, const char *owner) {
    int most = pool->settings.slow;
    int share = most > 1 ? most - 1 : 1;
    return pool->stats.under_way[LANE_SLOW] < most &&
           count(pool->running, owner, LANE_SLOW) < share;
}

static bool takes_long(const struct checkers *pool, const char *owner, int64_t now) {
    for (int k = 0; k < LONG_OWNERS; k++)
        if (pool->long_owners[k].until_ms > now && !strcmp(pool->long_owners[k].owner, owner))
            return true;
    return false;
}

/* An order of the owner has taken long in the express lane: its next ones come last there. */
static void note_long(struct checkers *pool, const char *owner, int64_t now) {
    int at = 0;
    for (int k = 0; k < LONG_OWNERS; k++) {
        if (!strcmp(pool->long_owners[k].owner, owner)) {
            at = k;
            break;
        }
        if (pool->long_owners[k].until_ms < pool->long_owners[at].until_ms)
            at = k;
    }
    memcpy(pool->long_owners[at].owner, owner, CHECKERS_OWNER_SIZE);
    pool->long_owners[at].until_ms = now + CHECKERS_LONG_MS;
    for (struct check *check = pool->waiting; check; check = check->next)
        check->last = check->last || !strcmp(check->owner, owner);
}

/* Whether the check may begin now, in the lane it is in. */
static bool may_begin(const struct checkers *pool, const struct check *check) {
    int kept = check->last && pool->settings.express > 1; /* for the others */
    if (!pool->idle || pool->stats.reserved + check->reserve > pool->settings.memory)
        return false;
    return check->lane == LANE_SLOW
               ? slow_place(pool, check->owner)
               : pool->stats.under_way[LANE_EXPRESS] < pool->settings.express - kept;
}

/* The check that begins next: of those that may, the first of the owner with the fewest under way,
 * of whom nothing took long lately. NULL: none may. */
static struct check *choose(const struct checkers *pool) {
    struct check *best = NULL;
    int least = 0;
    for (struct check *check = pool->waiting; check; check = check->next) {
        if (!may_begin(pool, check))
            continue;
        int rank = count(pool->running, check->owner, LANES);
        if (check->lane == LANE_EXPRESS && check->last)
            rank += pool->place_count;
        if (best && rank >= least)
            continue;
        best = check;
        least = rank;
    }
    return best;
}

static void begin(struct checkers *pool, struct check *check) {
    check->place = pool->idle;
    pool->idle = check->place->next;
    check->state = STATE_RUNNING;
    check->begun_ms = clock_ms();
    pool->stats.under_way[check->lane]++;
    pool->stats.reserved += check->reserve;
    append(&pool->running, check);
}

/* A place, or bytes of the budget, have become free: most of the time nobody waits for them. */
static void wake_for_waiting(struct checkers *pool) {
    if (pool->waiting)
        pthread_cond_broadcast(&pool->changed);
}

/* Gives back the place and its share of the budget. */
static void leave(struct checkers *pool, struct check *check) {
    withdraw(&pool->running, check);
    check->place->next = pool->idle;
    pool->idle = check->place;
    check->place = NULL;
    pool->stats.under_way[check->lane]--;
    pool->stats.reserved -= check->reserve;
    wake_for_waiting(pool);
}

/* ------------------------------------------------------------------ one check */

enum outcome {
    OUTCOME_LATER, /* no answer yet */
    OUTCOME_ANSWER,
    OUTCOME_CRASHED,
    OUTCOME_TIMEOUT,
    OUTCOME_DROPPED,
    OUTCOME_NOT_BEGUN,
    OUTCOME_QUOTA,
    OUTCOME_AGAIN /* no place in the slow lane: to be begun anew */
};

/* Waits at most `ms` for the answer. */
static enum outcome receive(struct check *check, int64_t ms) {
    struct pollfd file = {check->place->child.socket, POLLIN, 0};
    if (poll(&file, 1, ms < 0 ? 0 : (int)ms) <= 0)
        return OUTCOME_LATER;
    ssize_t got = recv(file.fd, &check->answer, sizeof check->answer, MSG_DONTWAIT);
    if (got < 0 && (errno == EAGAIN || errno == EINTR))
        return OUTCOME_LATER;
    bool sound = got > 0 && checker_answer_sound(&check->answer, (size_t)got);
    return sound ? OUTCOME_ANSWER : OUTCOME_CRASHED;
}

static bool is_unwanted(struct check *check) {
    pthread_mutex_lock(&check->pool->lock);
    bool unwanted = check->dropped || check->pool->stopping;
    pthread_mutex_unlock(&check->pool->lock);
    return unwanted;
}

static void lower_priority(struct place *place) {
    if (!place->slow)
        child_lower(&place->child, SLOW_NICENESS);
    place->slow = true;
}

/* Moves the check, which takes too long for the express lane, to the slow one with its process, if
 * that has a place; if not, it has to begin anew there, unless too many of the owner's wait. */
static enum outcome move_to_slow(struct checkers *pool, struct check *check) {
    pthread_mutex_lock(&pool->lock);
    bool room = slow_place(pool, check->owner);
    bool full = queue_full(pool, check->owner, LANE_SLOW);
    note_long(pool, check->owner, clock_ms());
    if (room) {
        pool->stats.under_way[LANE_EXPRESS]--;
        pool->stats.under_way[LANE_SLOW]++;
        check->lane = LANE_SLOW;
        wake_for_waiting(pool);
    }
    pthread_mutex_unlock(&pool->lock);
    return room ? OUTCOME_LATER : full ? OUTCOME_QUOTA : OUTCOME_AGAIN;
}

/* What to do with a check that has no answer yet. */
static enum outcome look(struct check *check) {
    int64_t now = clock_ms();
    if (is_unwanted(check))
        return OUTCOME_DROPPED;
    if (now >= check->packet.deadline_ms)
        return OUTCOME_TIMEOUT;
    if (check->lane == LANE_SLOW || now < check->begun_ms + CHECKERS_EXPRESS_MS)
        return OUTCOME_LATER;
    enum outcome outcome = move_to_slow(check->pool, check);
    if (outcome == OUTCOME_LATER)
        lower_priority(check->place);
    return outcome;
}

/* On a thread of the pool: follows an order that has been sent to its end. */
static enum outcome follow(struct check *check) {
    enum outcome outcome = OUTCOME_LATER;
    while (outcome == OUTCOME_LATER) {
        int64_t until = check->lane == LANE_EXPRESS ? check->begun_ms + CHECKERS_EXPRESS_MS
                                                    : check->packet.deadline_ms;
        int64_t wait = until - clock_ms();
        outcome = receive(check, wait < LOOK_MS ? wait : LOOK_MS);
        if (outcome == OUTCOME_LATER)
            outcome = look(check);
    }
    return outcome;
}

static void explain_quota(struct api_problem *problem, enum lane lane) {
    if (lane == LANE_SLOW)
        api_problem_set(problem, API_QUOTA,
                        "%d bodies of yours that take long are waiting to be read already",
                        CHECKERS_SLOW_MAX);
    else
        api_problem_set(problem, API_QUOTA, "%d bodies of yours are waiting to be read already",
                        CHECKERS_WAITING_MAX);
}

/* Why the importer gave no surface. */
static void explain_import(struct check *check, enum outcome outcome) {
    struct api_problem *problem = &check->answer.problem;
    if (outcome == OUTCOME_TIMEOUT)
        api_problem_set(problem, API_UNREADABLE_FILE,
                        "importing the file took longer than %lld s (--job-timeout)",
                        (long long)timeout_of(check) / 1000);
    else if (outcome == OUTCOME_CRASHED)
        api_problem_set(problem, API_UNREADABLE_FILE,
                        "the file breaks the importer, which is Open CASCADE: write it anew, or in "
                        "another format");
    else
        api_problem_set(problem, API_UNREADABLE_FILE,
                        "importing the file needs more memory than %lld bytes (--%s)",
                        (long long)check->reserve, check->pool->settings.memory_flag);
}

/* What the caller is answered when there is no answer of the process, or one in words that are for
 * a drape. */
static void explain(struct check *check, enum outcome outcome) {
    struct api_problem *problem = &check->answer.problem;
    const char *work = works[check->packet.kind], *what = work ? work : "reading the body";
    enum api_problem_id id = outcome == OUTCOME_ANSWER ? problem->id : API_OK;
    if (outcome == OUTCOME_ANSWER && id != API_OUT_OF_MEMORY && id != API_CANCELLED)
        return;
    memset(&check->answer, 0, sizeof check->answer);
    if (is_cad(check) &&
        (outcome == OUTCOME_CRASHED || outcome == OUTCOME_TIMEOUT || id == API_OUT_OF_MEMORY)) {
        explain_import(check, outcome);
        return;
    }
    if (outcome == OUTCOME_QUOTA)
        explain_quota(problem, LANE_SLOW);
    else if (outcome == OUTCOME_CRASHED)
        api_problem_set(problem, API_INTERNAL, "%s crashed its process", what);
    else if (outcome == OUTCOME_TIMEOUT || id == API_CANCELLED)
        api_problem_set(problem, work ? API_JOB_TIMEOUT : API_TOO_LARGE,
                        "%s took longer than %lld s%s", what, (long long)timeout_of(check) / 1000,
                        work ? " (--job-timeout)" : "");
    else if (id == API_OUT_OF_MEMORY)
        api_problem_set(problem, API_TOO_LARGE, "%s needs more memory than %lld bytes (--%s)", what,
                        (long long)check->reserve, check->pool->settings.memory_flag);
    else
        api_problem_set(problem, API_UNAVAILABLE, "%s could not be begun now", what);
}

static void close_files(struct check *check, int end) {
    for (int k = 0; k < end; k++) {
        if (check->files[k] >= 0)
            close(check->files[k]);
        check->files[k] = -1;
    }
}

static void free_check(struct check *check) {
    close_files(check, CHECKER_DOCUMENTS + 1);
    if (check->columns.free)
        check->columns.free(check->columns.context);
    free(check->inlined);
    free(check);
}

/* The end of a check: gives back the place, keeps of the files what was written, and notifies the
 * caller, or frees the check if that has gone. A process of the slow lane keeps its low priority,
 * so it is not used again. */
static void finish(struct check *check, enum outcome outcome, bool notify) {
    struct checkers *pool = check->pool;
    char subject[ID_SIZE];
    if (outcome != OUTCOME_ANSWER || check->place->slow)
        end_process(check->place, outcome == OUTCOME_CRASHED);
    explain(check, outcome);
    close_files(check, CHECKER_DOCUMENTS);
    memcpy(subject, check->subject, sizeof subject);
    pthread_mutex_lock(&pool->lock);
    if (check->lane == LANE_EXPRESS && check->answer.processor_us > CHECKERS_QUICK_MS * 1000)
        note_long(pool, check->owner, clock_ms());
    leave(pool, check);
    pool->stats.done++;
    pool->stats.crashes += outcome == OUTCOME_CRASHED;
    pool->stats.timeouts += outcome == OUTCOME_TIMEOUT;
    check->state = STATE_DONE;
    bool dropped = check->dropped;
    pthread_mutex_unlock(&pool->lock);
    if (dropped)
        free_check(check);
    else if (notify)
        hub_notify(pool->hub, subject);
}

/* Stops the process; the check waits for that lane and so many bytes, unless nobody wants it any
 * more. */
static void begin_anew(struct check *check, enum lane lane, int64_t reserve) {
    struct checkers *pool = check->pool;
    int *output = &check->files[CHECKER_DOCUMENTS];
    end_process(check->place, false);
    if (*output >= 0)
        close(*output);
    *output = -1;
    pthread_mutex_lock(&pool->lock);
    leave(pool, check);
    pool->stats.restarts++;
    check->lane = lane;
    check->reserve = reserve;
    check->state = STATE_WAITING;
    bool dropped = check->dropped;
    if (!dropped) {
        append(&pool->waiting, check);
        pthread_cond_signal(&pool->changed);
    }
    pthread_mutex_unlock(&pool->lock);
    if (dropped)
        free_check(check);
}

/* Sends the order to the process of the check's place; to a new one if that has gone meanwhile. */
static bool set_off(struct check *check) {
    struct place *place = check->place;
    if (!make_files(check))
        return false;
    for (int attempt = 0; attempt < 2; attempt++) {
        if (!start_process(check->pool, place, is_cad(check)))
            return false;
        bound_memory(check);
        if (check->lane == LANE_SLOW)
            lower_priority(place);
        if (send_order(check))
            return true;
        end_process(place, false);
    }
    return false;
}

/* What an order takes is estimated by its length (`reserve_of`). The rare one that takes more, such
 * as a surface of very many spans with trims, is tried once more with all that there is. */
static bool is_cramped(const struct check *check, enum outcome outcome) {
    return outcome == OUTCOME_ANSWER && check->answer.problem.id == API_OUT_OF_MEMORY &&
           check->reserve < slow_share(check->pool);
}

static void run(struct check *check, bool sent) {
    enum outcome outcome = sent || set_off(check) ? follow(check) : OUTCOME_NOT_BEGUN;
    bool killed = outcome == OUTCOME_CRASHED && !check->crashed && !is_cad(check);
    check->crashed = outcome == OUTCOME_CRASHED;
    if (is_cramped(check, outcome))
        begin_anew(check, LANE_SLOW, slow_share(check->pool));
    else if (outcome == OUTCOME_AGAIN ||
             killed) /* perhaps by somebody else: it may try once more */
        begin_anew(check, outcome == OUTCOME_AGAIN ? LANE_SLOW : check->lane, check->reserve);
    else
        finish(check, outcome, true);
}

/* ------------------------------------------------------------------ the threads */

static struct check *find_adopted(const struct checkers *pool) {
    struct check *check = pool->running;
    while (check && check->state != STATE_ADOPTED)
        check = check->next;
    return check;
}

/* With the lock: the next check, under way; NULL at the end. `sent` says whether its order is. */
static struct check *wait_for_check(struct checkers *pool, bool *sent) {
    for (;;) {
        struct check *check = find_adopted(pool);
        *sent = check != NULL;
        if (check) {
            check->state = STATE_RUNNING;
            return check;
        }
        if (pool->stopping)
            return NULL;
        check = choose(pool);
        if (check) {
            withdraw(&pool->waiting, check);
            begin(pool, check);
            return check;
        }
        pthread_cond_wait(&pool->changed, &pool->lock);
    }
}

/* As many as there are places, so that none waits for a thread. Each begins with starting the
 * process of one place, and lives as long as the pool, since a process ends with the thread that
 * started it. */
static void *work(void *context) {
    struct checkers *pool = context;
    struct check *check;
    bool sent;
    pthread_mutex_lock(&pool->lock);
    struct place *own = &pool->places[pool->places_ready++];
    pthread_mutex_unlock(&pool->lock);
    if (own - pool->places < pool->settings.express)
        start_process(pool, own, false);
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

struct checkers *checkers_start(struct hub *hub, const struct checkers_settings *settings) {
    struct checkers *pool = calloc(1, sizeof *pool);
    if (!pool)
        return NULL;
    pool->hub = hub;
    pool->settings = *settings;
    pool->place_count = settings->express + settings->slow;
    pool->places = calloc((size_t)pool->place_count, sizeof *pool->places);
    pool->threads = calloc((size_t)pool->place_count, sizeof *pool->threads);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->changed, NULL);
    while (pool->places && pool->threads && pool->thread_count < pool->place_count &&
           pthread_create(&pool->threads[pool->thread_count], NULL, work, pool) == 0)
        pool->thread_count++;
    if (pool->thread_count == pool->place_count)
        return pool;
    checkers_stop(pool);
    return NULL;
}

void checkers_stop(struct checkers *pool) {
    if (!pool)
        return;
    pthread_mutex_lock(&pool->lock);
    pool->stopping = true;
    pthread_cond_broadcast(&pool->changed);
    pthread_mutex_unlock(&pool->lock);
    for (int k = 0; k < pool->thread_count; k++)
        pthread_join(pool->threads[k], NULL);
    for (int k = 0; pool->places && k < pool->place_count; k++)
        child_kill(&pool->places[k].child);
    pthread_cond_destroy(&pool->changed);
    pthread_mutex_destroy(&pool->lock);
    free(pool->places);
    free(pool->threads);
    free(pool);
}

void checkers_stats(struct checkers *pool, struct checkers_stats *stats) {
    pthread_mutex_lock(&pool->lock);
    *stats = pool->stats;
    for (const struct check *check = pool->waiting; check; check = check->next)
        stats->waiting++;
    pthread_mutex_unlock(&pool->lock);
}

/* ------------------------------------------------------------------ the callers */

static struct check *new_check(struct checkers *pool, const struct checkers_order *order,
                               const char *subject) {
    struct check *check = calloc(1, sizeof *check);
    if (!check)
        return NULL;
    check->pool = pool;
    for (int k = 0; k <= CHECKER_DOCUMENTS; k++)
        check->files[k] = -1;
    snprintf(check->subject, sizeof check->subject, "%s", subject);
    snprintf(check->owner, sizeof check->owner, "%s", order->owner);
    check->reserve = reserve_of(order, slow_share(pool));
    check->max_memory = order->limits.max_memory;
    check->lane = check->reserve > EXPRESS_BYTES ? LANE_SLOW : LANE_EXPRESS;
    fill_packet(check, order);
    if (keep_documents(check, order)) {
        check->columns = order->columns;
        return check;
    }
    free_check(check);
    return NULL;
}

/* With the lock: whether the check can begin with a process that runs already, and nobody else
 * would be the next. It has begun then. */
static bool begin_at_once(struct checkers *pool, struct check *check) {
    if (check->columns.write || is_cad(check) || !may_begin(pool, check) || choose(pool))
        return false;
    for (struct place **at = &pool->idle; *at; at = &(*at)->next) {
        struct place *place = *at;
        if (!child_running(&place->child) || place->imports)
            continue;
        *at = place->next;
        place->next = pool->idle;
        pool->idle = place;
        begin(pool, check);
        return true;
    }
    return false;
}

/* The order, on the caller's thread; handed over to a thread of the pool unless it is answered
 * soon.
 */
static void run_at_once(struct check *check) {
    struct checkers *pool = check->pool;
    bool sent = make_files(check);
    if (sent) {
        bound_memory(check);
        sent = send_order(check);
    }
    if (sent && receive(check, CHECKERS_AT_ONCE_MS) == OUTCOME_ANSWER) {
        if (is_cramped(check, OUTCOME_ANSWER))
            begin_anew(check, LANE_SLOW, slow_share(pool));
        else
            finish(check, OUTCOME_ANSWER, false);
        return;
    }
    pthread_mutex_lock(&pool->lock);
    if (sent) {
        check->state = STATE_ADOPTED;
    } else {
        leave(pool, check);
        check->state = STATE_WAITING;
        append(&pool->waiting, check);
    }
    pthread_cond_signal(&pool->changed);
    pthread_mutex_unlock(&pool->lock);
}

struct check *checkers_begin(struct checkers *pool, const struct checkers_order *order,
                             const char *subject, struct api_problem *problem) {
    struct check *check = new_check(pool, order, subject);
    if (!check) {
        api_problem_set(problem, API_UNAVAILABLE, "there is no memory for this now");
        return NULL;
    }
    pthread_mutex_lock(&pool->lock);
    bool full = queue_full(pool, check->owner, check->lane);
    check->last = takes_long(pool, check->owner, clock_ms());
    bool begun = !full && begin_at_once(pool, check);
    if (!full && !begun) {
        append(&pool->waiting, check);
        pthread_cond_signal(&pool->changed);
    }
    pthread_mutex_unlock(&pool->lock);
    if (begun)
        run_at_once(check);
    if (!full)
        return check;
    enum lane lane = check->lane;
    check->columns = (struct checkers_columns){0}; /* still the caller's */
    free_check(check);
    explain_quota(problem, lane);
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
    struct checkers *pool = check->pool;
    pthread_mutex_lock(&pool->lock);
    bool free_here = check->state == STATE_DONE || check->state == STATE_WAITING;
    if (check->state == STATE_WAITING)
        withdraw(&pool->waiting, check);
    check->dropped = true; /* else a thread of the pool frees it */
    pthread_mutex_unlock(&pool->lock);
    if (free_here)
        free_check(check);
}
