/* SPDX-License-Identifier: MIT */
/* The pool of checkers with real processes. A body that begins with a word and a number makes its
 * process sleep, crash or take memory before it is read. */
#include "api/check.h"
#include "api/run.h"
#include "server/clock.h"
#include "server/job_events.h"
#include "server/spool.h"
#include "server/work/document_pool.h"
#include "server/work/worker.h"
#include "tests/store/capture.h"
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

enum { WAIT_MS = 300000, CHECKS = 40 }; /* with ThreadSanitizer, on a busy machine */

#define SURFACE                                                                                    \
    "{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"        \
    "\"size_u\":2,\"size_v\":2,\"control_points\":[[0,0,0],[0,1,0],[1,0,0],[1,1,0]]}"
#define DRAPE "{\"surface\":" SURFACE ",\"fabric\":{\"spacing\":0.1}}"

static struct job_events *events;
static struct document_pool *pool;

/* In the process. Not through a bad pointer: sanitizers would report it as a bug of ours. */
static void misbehave(const char *body, size_t length) {
    char text[32] = "";
    memcpy(text, body, length < sizeof text - 1 ? length : sizeof text - 1);
    long number = strtol(text + strcspn(text, "0123456789"), NULL, 10);
    if (!strncmp(text, "crash", 5)) {
        signal(SIGSEGV, SIG_DFL);
        raise(SIGSEGV);
    } else if (!strncmp(text, "sleep", 5)) {
        nanosleep(&(struct timespec){number / 1000, number % 1000 * 1000000}, NULL);
    }
}

static struct document_pool_settings settings(void) {
    return (struct document_pool_settings){.fast = 2,
                                           .slow = 2,
                                           .memory = INT64_C(256) << 20,
                                           .timeout_ms = 20000,
                                           .map_timeout_ms = 20000,
                                           .import_timeout_ms = 20000,
                                           .turn_ms = DOCUMENT_POOL_TURN_MS,
                                           .max_output = INT64_C(64) << 20,
                                           .folder = "",
                                           .memory_flag = "check-memory"};
}

static void start(const struct document_pool_settings *wanted) {
    events = job_events_new();
    pool = document_pool_start(events, wanted);
    assert_non_null(pool);
}

static int stop(void **state) {
    (void)state;
    document_pool_stop(pool);
    job_events_free(events);
    pool = NULL;
    events = NULL;
    return 0;
}

static struct document_pool_order order_of(enum checker_kind kind, const char *body) {
    struct document_pool_order order = {
        .kind = kind, .owner = "a", .limits = api_limits_default, .body_file = -1};
    order.document[CHECKER_BODY] = body;
    order.length[CHECKER_BODY] = strlen(body);
    return order;
}

static struct check *begin(const struct document_pool_order *order) {
    struct api_problem problem = {0};
    struct check *check = document_pool_begin(pool, order, "subject", &problem);
    assert_int_equal(problem.id, API_OK);
    assert_non_null(check);
    return check;
}

static void wait_for(struct check *check) {
    for (int64_t until = clock_ms() + WAIT_MS; !check_done(check);) {
        assert_true(clock_ms() < until);
        usleep(1000);
    }
}

static enum api_problem_id end_of(struct check *check) {
    wait_for(check);
    enum api_problem_id id = check_answer(check)->problem.id;
    check_drop(check);
    return id;
}

/* ------------------------------------------------------------------ answers */

static void test_document_pool_drape(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    struct api_check direct;
    struct api_problem problem = {0};
    struct api_input input = {.request = DRAPE, .request_length = strlen(DRAPE)};
    start(&wanted);
    assert_int_equal(api_check_drape(&input, &api_limits_default, NULL, &direct, &problem), API_OK);
    struct document_pool_order order = order_of(CHECKER_DRAPE, DRAPE);
    struct check *check = begin(&order);
    wait_for(check);
    const struct checker_answer *answer = check_answer(check);
    assert_int_equal(answer->problem.id, API_OK);
    assert_string_equal(answer->check.digest, direct.digest);
    assert_int_equal(strlen(answer->check.digest), API_ID_LENGTH);
    assert_false(answer->check.needs_surface);
    check_drop(check);
}

static void test_document_pool_places_of_problem(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    start(&wanted);
    struct document_pool_order order =
        order_of(CHECKER_DRAPE, "{\"surface\":" SURFACE ",\"fabric\":{\"spacing\":-1},\"x\":1}");
    struct check *check = begin(&order);
    wait_for(check);
    const struct api_problem *problem = &check_answer(check)->problem;
    assert_int_equal(problem->id, API_INVALID_REQUEST);
    assert_int_equal(problem->count, 2);
    check_drop(check);
}

static void test_document_pool_named_surface(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    start(&wanted);
    struct document_pool_order order = order_of(
        CHECKER_DRAPE,
        "{\"surface\":{\"id\":\"0123456789abcdef0123456789abcdef\"},\"fabric\":{\"spacing\":0.1}}");
    struct check *check = begin(&order);
    wait_for(check);
    assert_true(check_answer(check)->check.needs_surface);
    assert_string_equal(check_answer(check)->check.surface, "0123456789abcdef0123456789abcdef");
    check_drop(check);
    order.document[CHECKER_SECOND] = SURFACE;
    order.length[CHECKER_SECOND] = strlen(SURFACE);
    check = begin(&order);
    wait_for(check);
    assert_int_equal(check_answer(check)->problem.id, API_OK);
    assert_false(check_answer(check)->check.needs_surface);
    check_drop(check);
}

/* A surface in a sealed file, since it is longer than a packet. */
static void test_document_pool_long_surface(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    size_t blanks = 100000;
    char *body = malloc(blanks + sizeof SURFACE), *text = malloc(4096);
    assert_true(body && text);
    memset(body, ' ', blanks);
    memcpy(body + blanks, SURFACE, sizeof SURFACE);
    start(&wanted);
    struct document_pool_order order = order_of(CHECKER_SURFACE, body);
    order.body_file = spool_of_bytes(body, strlen(body));
    assert_true(order.body_file >= 0);
    struct check *check = begin(&order);
    wait_for(check);
    const struct checker_answer *answer = check_answer(check);
    assert_int_equal(answer->problem.id, API_OK);
    assert_true(answer->output_length < 4096);
    assert_int_equal(check_read(check, 0, text, 4096), (int)answer->output_length);
    assert_int_equal(check_read(check, answer->output_length, text, 4096), 0);
    assert_memory_equal(text, "{\"degree_u\":1", 13);
    assert_int_equal(text[answer->check.definition_length], '{');
    assert_int_equal(text[answer->output_length - 1], '}');
    check_drop(check);
    close(order.body_file);
    free(body);
    free(text);
}

/* Whoever has taken a checker over answers what it likes: texts without an end, more errors than
 * it has sent, parts that are longer than what was written. */
static void test_document_pool_believes_only_what_may_be(void **state) {
    static struct checker_answer answer;
    const size_t head = offsetof(struct checker_answer, problem.error);
    const size_t error = sizeof answer.problem.error[0];
    size_t *const parts[] = {&answer.check.filled_length, &answer.check.definition_length};
    char *const texts[] = {answer.check.digest, answer.check.surface, answer.check.text,
                           answer.check.ground};
    (void)state;
    answer.output_length = 10;
    for (int k = 0; k < 2; k++)
        for (*parts[k] = 12; *parts[k] > 0; --*parts[k])
            assert_int_equal(checker_answer_sound(&answer, head), *parts[k] <= 10);
    for (int k = 0; k < 4; k++) {
        memset(texts[k], 'a', API_ID_SIZE);
        assert_false(checker_answer_sound(&answer, head));
        texts[k][API_ID_SIZE - 1] = '\0';
        assert_true(checker_answer_sound(&answer, head));
    }
    assert_false(checker_answer_sound(&answer, head - 1));
    assert_false(checker_answer_sound(&answer, head + error));
    answer.problem.count = 1;
    assert_false(checker_answer_sound(&answer, head + error)); /* an error of no problem */
    answer.problem.id = API_INVALID_REQUEST;
    assert_true(checker_answer_sound(&answer, head + error));
    assert_false(checker_answer_sound(&answer, head));
    memset(answer.problem.error[0].detail, 'a', API_DETAIL_MAX);
    assert_false(checker_answer_sound(&answer, head + error));
    answer.problem = (struct api_problem){.id = API_PROBLEM_COUNT, .count = 1};
    assert_false(checker_answer_sound(&answer, head + error));
    answer.problem = (struct api_problem){.id = API_INVALID_REQUEST};
    assert_false(checker_answer_sound(&answer, head));
}

/* ------------------------------------------------------------------ lanes */

/* Orders of every kind of length at once: all are answered, in whatever order. */
static void test_document_pool_many(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    struct check *checks[CHECKS];
    char bodies[CHECKS][32];
    start(&wanted);
    for (int k = 0; k < CHECKS; k++) {
        snprintf(bodies[k], sizeof bodies[k], "sleep %d", k % 7);
        struct document_pool_order order = order_of(CHECKER_DRAPE, bodies[k]);
        order.owner = k % 2 ? "a" : "b";
        checks[k] = begin(&order);
    }
    for (int k = 0; k < CHECKS; k++)
        assert_int_equal(end_of(checks[k]), API_MALFORMED_JSON);
}

/* Slow orders of two owners fill the slow queue and the fast queue over and over; a quick one is
 * answered before any of them. */
static void test_document_pool_quick_passes_slow(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    struct check *slow[6];
    struct document_pool_stats stats;
    start(&wanted);
    for (int k = 0; k < 6; k++) {
        struct document_pool_order order = order_of(CHECKER_DRAPE, "sleep 3000");
        order.owner = k % 2 ? "slow" : "slower";
        slow[k] = begin(&order);
    }
    struct document_pool_order order = order_of(CHECKER_DRAPE, DRAPE);
    order.owner = "quick";
    assert_int_equal(end_of(begin(&order)), API_OK);
    for (int k = 0; k < 6; k++)
        assert_false(check_done(slow[k]));
    for (int k = 0; k < 6; k++)
        assert_int_equal(end_of(slow[k]), API_MALFORMED_JSON);
    document_pool_stats(pool, &stats);
    assert_true(stats.restarts > 0);
    assert_int_equal(stats.under_way[0] + stats.under_way[1] + stats.waiting, 0);
    assert_int_equal(stats.reserved, 0);
}

/* One owner alone has at most one of the two slow places. */
static void test_document_pool_share_of_slow_lane(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    struct check *slow[4];
    struct document_pool_stats stats;
    start(&wanted);
    for (int k = 0; k < 4; k++) {
        struct document_pool_order order = order_of(CHECKER_DRAPE, "sleep 1000");
        slow[k] = begin(&order);
    }
    int64_t most = 0;
    for (bool done = false; !done;) {
        done = true;
        for (int k = 0; k < 4; k++)
            done = done && check_done(slow[k]);
        document_pool_stats(pool, &stats);
        most = stats.under_way[1] > most ? stats.under_way[1] : most;
        usleep(5000);
    }
    assert_int_equal(most, 1);
    for (int k = 0; k < 4; k++)
        check_drop(slow[k]);
}

/* One that has left the fast queue, and stays for long. */
static struct check *begin_slow(void) {
    struct document_pool_order order = order_of(CHECKER_DRAPE, "sleep 15000");
    struct check *slow = begin(&order);
    struct document_pool_stats stats;
    document_pool_stats(pool, &stats);
    for (int64_t until = clock_ms() + WAIT_MS; stats.under_way[1] == 0; usleep(1000)) {
        assert_true(clock_ms() < until);
        document_pool_stats(pool, &stats);
    }
    return slow;
}

/* Of those that wait the first is that of the owner with the fewest under way, however many came
 * before it. */
static void test_document_pool_next_is_of_the_owner_with_fewest(void **state) {
    (void)state;
    enum { WAITING = 20 };
    struct document_pool_settings wanted = settings();
    struct check *slow, *waiting[WAITING];
    wanted.fast = 1;
    start(&wanted);
    slow = begin_slow();
    struct document_pool_order order = order_of(CHECKER_DRAPE, "sleep 100");
    for (int k = 0; k < WAITING; k++)
        waiting[k] = begin(&order);
    order.owner = "other";
    assert_int_equal(end_of(begin(&order)), API_MALFORMED_JSON);
    assert_false(check_done(waiting[WAITING - 1]));
    for (int k = 0; k < WAITING; k++)
        check_drop(waiting[k]);
    check_drop(slow);
}

static struct check *begin_of(const char *owner, const char *body) {
    struct document_pool_order order = order_of(CHECKER_DRAPE, body);
    order.owner = owner;
    return begin(&order);
}

/* With one fast process, which `first` has for a while: of the two that then wait the second is
 * answered first. */
static void check_passes(const char *first, const char *waits, const char *passes) {
    struct check *running = begin_of(first, "sleep 100"), *other = begin_of(waits, "sleep 100");
    assert_int_equal(end_of(begin_of(passes, "sleep 10")), API_MALFORMED_JSON);
    assert_false(check_done(other));
    check_drop(running);
    check_drop(other);
}

/* What has just been answered was its owner's turn; and who has a slow one under way comes behind
 * who has none, although neither has just been answered. */
static void test_document_pool_owners_take_turns(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    wanted.fast = 1;
    start(&wanted);
    check_passes("one", "one", "two");
    struct check *slow = begin_slow();
    check_passes("third", "a", "two");
    check_drop(slow);
}

/* Whoever comes to a slow queue that two other owners hold waits for a turn of theirs, not for all
 * that they wait with; and they end in spite of that. */
static void test_document_pool_slow_lane_has_turns(void **state) {
    (void)state;
    enum { HELD = 4 };
    struct document_pool_settings wanted = settings();
    struct check *held[HELD];
    struct document_pool_stats stats;
    wanted.turn_ms = 500;
    start(&wanted);
    for (int k = 0; k < HELD; k++)
        held[k] = begin_of(k % 2 ? "slow" : "slower", "sleep 6000");
    int64_t begun = clock_ms();
    assert_int_equal(end_of(begin_of("other", "sleep 400")), API_MALFORMED_JSON);
    document_pool_stats(pool, &stats);
    print_message("# waited %lld ms, %lld restarts\n", (long long)(clock_ms() - begun),
                  (long long)stats.restarts);
    assert_in_range(stats.restarts, 1, 5); /* three left the fast queue, one gave way */
    for (int k = 0; k < HELD; k++)
        assert_false(check_done(held[k]));
    for (int k = 0; k < HELD; k++)
        assert_int_equal(end_of(held[k]), API_MALFORMED_JSON);
}

/* An owner whose orders took long leaves one of the fast processes to others. */
static void test_document_pool_long_ones_leave_a_place(void **state) {
    (void)state;
    enum { ORDERS = 8 };
    struct document_pool_settings wanted = settings();
    struct check *slow, *checks[ORDERS];
    struct document_pool_stats stats;
    start(&wanted);
    slow = begin_slow();
    struct document_pool_order order = order_of(CHECKER_DRAPE, "sleep 10");
    for (int k = 0; k < ORDERS; k++)
        checks[k] = begin(&order);
    for (int64_t until = clock_ms() + WAIT_MS; !check_done(checks[ORDERS - 1]); usleep(500)) {
        assert_true(clock_ms() < until);
        document_pool_stats(pool, &stats);
        assert_in_range(stats.under_way[0], 0, 1);
    }
    for (int k = 0; k < ORDERS; k++)
        assert_int_equal(end_of(checks[k]), API_MALFORMED_JSON);
    check_drop(slow);
}

/* All that are under way have one budget together. */
static void test_document_pool_share_a_budget(void **state) {
    (void)state;
    enum { ORDERS = 8 };
    struct document_pool_settings wanted = settings();
    struct check *checks[ORDERS];
    struct document_pool_stats stats;
    wanted.fast = 4;
    wanted.memory = INT64_C(32) << 20; /* of which one may take half */
    start(&wanted);
    for (int k = 0; k < ORDERS; k++) {
        struct document_pool_order order = order_of(CHECKER_DRAPE, "sleep 50");
        checks[k] = begin(&order);
        document_pool_stats(pool, &stats);
        assert_true(stats.reserved <= wanted.memory);
    }
    for (int64_t until = clock_ms() + WAIT_MS; !check_done(checks[ORDERS - 1]); usleep(1000)) {
        document_pool_stats(pool, &stats);
        assert_true(stats.reserved <= wanted.memory);
        assert_true(clock_ms() < until);
    }
    for (int k = 0; k < ORDERS; k++)
        assert_int_equal(end_of(checks[k]), API_MALFORMED_JSON);
}

/* The slow queue's queue has an end for one owner, and none of it is the other's affair. */
static void test_document_pool_quota_of_waiting(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    struct check *checks[DOCUMENT_POOL_SLOW_MAX + 8];
    int refused = 0;
    wanted.timeout_ms = 60000;
    start(&wanted);
    for (int k = 0; k < DOCUMENT_POOL_SLOW_MAX + 8; k++) {
        struct document_pool_order order = order_of(CHECKER_DRAPE, "sleep 50000");
        checks[k] = begin(&order);
    }
    /* one has a place, and so many wait */
    for (int64_t until = clock_ms() + WAIT_MS; refused < 7 && clock_ms() < until; usleep(10000)) {
        refused = 0;
        for (int k = 0; k < DOCUMENT_POOL_SLOW_MAX + 8; k++)
            refused += check_done(checks[k]) && check_answer(checks[k])->problem.id == API_QUOTA;
    }
    assert_int_equal(refused, 7);
    struct document_pool_order order = order_of(CHECKER_DRAPE, DRAPE);
    order.owner = "other";
    assert_int_equal(end_of(begin(&order)), API_OK);
    for (int k = 0; k < DOCUMENT_POOL_SLOW_MAX + 8; k++)
        check_drop(checks[k]);
}

/* ------------------------------------------------------------------ what goes wrong */

static void test_document_pool_crash(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    struct document_pool_stats stats;
    start(&wanted);
    for (int k = 0; k < 5; k++) {
        struct document_pool_order order = order_of(CHECKER_DRAPE, "crash");
        assert_int_equal(end_of(begin(&order)), API_INTERNAL);
        order = order_of(CHECKER_DRAPE, DRAPE);
        assert_int_equal(end_of(begin(&order)), API_OK);
    }
    document_pool_stats(pool, &stats);
    assert_int_equal(stats.crashes, 5);
}

static void test_document_pool_timeout(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    struct document_pool_stats stats;
    wanted.timeout_ms = 300;
    start(&wanted);
    struct document_pool_order order = order_of(CHECKER_DRAPE, "sleep 20000");
    assert_int_equal(end_of(begin(&order)), API_TOO_LARGE);
    document_pool_stats(pool, &stats);
    assert_int_equal(stats.timeouts, 1);
}

static void test_document_pool_drop(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    struct document_pool_stats stats;
    start(&wanted);
    struct document_pool_order order = order_of(CHECKER_DRAPE, "sleep 20000");
    for (int k = 0; k < 6; k++)
        check_drop(begin(&order));
    for (int64_t until = clock_ms() + WAIT_MS;;) {
        document_pool_stats(pool, &stats);
        if (!stats.under_way[0] && !stats.under_way[1])
            break;
        assert_true(clock_ms() < until);
        usleep(1000);
    }
    assert_int_equal(stats.reserved, 0);
    order = order_of(CHECKER_DRAPE, DRAPE);
    assert_int_equal(end_of(begin(&order)), API_OK);
}

/* A tree of half a megabyte of empty arrays takes more than is left in a budget that is small. */
static void test_document_pool_memory(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    size_t count = 200000;
    char *body = malloc(3 * count + 3), *to = body;
    assert_non_null(body);
    *to++ = '[';
    for (size_t k = 0; k < count; k++)
        to += sprintf(to, "%s[]", k ? "," : "");
    memcpy(to, "]", 2);
    wanted.memory = INT64_C(8) << 20;
    start(&wanted);
    struct document_pool_order order = order_of(CHECKER_DRAPE, body);
    enum api_problem_id id = end_of(begin(&order));
    free(body);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    assert_int_equal(id, API_INVALID_REQUEST); /* sanitizers have no bound of memory */
#else
    assert_int_equal(id, API_TOO_LARGE);
#endif
    order = order_of(CHECKER_DRAPE, DRAPE);
    assert_int_equal(end_of(begin(&order)), API_OK);
}

/* A surface of degree 9 with `size` points a side, and a trim around all but its rim. */
static char *trimmed_surface(int size) {
    char *body = malloc((size_t)size * (size_t)size * 16 + (size_t)size * 16 + 1000), *to = body;
    assert_non_null(body);
    to += sprintf(to, "{\"degree_u\":9,\"degree_v\":9,\"size_u\":%d,\"size_v\":%d", size, size);
    for (int side = 0; side < 2; side++) {
        to += sprintf(to, ",\"knotvector_%c\":[", side ? 'v' : 'u');
        for (int k = 0; k < size + 10; k++)
            to += sprintf(to, "%s%d", k ? "," : "", k < 10 ? 0 : k < size ? k - 9 : size - 9);
        *to++ = ']';
    }
    to += sprintf(to, ",\"control_points\":[");
    for (int k = 0; k < size * size; k++)
        to += sprintf(to, "%s[%d,%d,0]", k ? "," : "", k / size, k % size);
    sprintf(to,
            "],\"trims\":[{\"degree\":1,\"knotvector\":[0,0,1,2,3,4,4],\"reversed\":true,"
            "\"control_points\":[[1,1],[%d,1],[%d,%d],[1,%d],[1,1]]}]}",
            size - 10, size - 10, size - 10, size - 10);
    return body;
}

/* More memory than such a body usually takes: it is begun anew with all that there is. */
static void test_document_pool_more_memory_than_usual(void **state) {
    (void)state;
    struct document_pool_settings wanted = settings();
    struct document_pool_stats stats;
    char *body = trimmed_surface(260);
    wanted.memory = INT64_C(640) << 20;
    wanted.timeout_ms = WAIT_MS;
    start(&wanted);
    struct document_pool_order order = order_of(CHECKER_SURFACE, body);
    order.body_file = spool_of_bytes(body, strlen(body));
    assert_true(order.body_file >= 0);
    assert_int_equal(end_of(begin(&order)), API_OK);
    document_pool_stats(pool, &stats);
    assert_int_equal(stats.restarts, 1);
    assert_int_equal(stats.reserved, 0);
    close(order.body_file);
    free(body);
}

int main(int argc, char **argv) {
    if (argc == 2 && !strcmp(argv[1], CHECKER_ARGUMENT))
        return checker_serve(&(struct checker_abilities){.before = misbehave});
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_document_pool_drape, stop),
        cmocka_unit_test_teardown(test_document_pool_places_of_problem, stop),
        cmocka_unit_test_teardown(test_document_pool_named_surface, stop),
        cmocka_unit_test_teardown(test_document_pool_long_surface, stop),
        cmocka_unit_test(test_document_pool_believes_only_what_may_be),
        cmocka_unit_test_teardown(test_document_pool_many, stop),
        cmocka_unit_test_teardown(test_document_pool_quick_passes_slow, stop),
        cmocka_unit_test_teardown(test_document_pool_share_of_slow_lane, stop),
        cmocka_unit_test_teardown(test_document_pool_next_is_of_the_owner_with_fewest, stop),
        cmocka_unit_test_teardown(test_document_pool_owners_take_turns, stop),
        cmocka_unit_test_teardown(test_document_pool_slow_lane_has_turns, stop),
        cmocka_unit_test_teardown(test_document_pool_long_ones_leave_a_place, stop),
        cmocka_unit_test_teardown(test_document_pool_share_a_budget, stop),
        cmocka_unit_test_teardown(test_document_pool_quota_of_waiting, stop),
        cmocka_unit_test_teardown(test_document_pool_crash, stop),
        cmocka_unit_test_teardown(test_document_pool_timeout, stop),
        cmocka_unit_test_teardown(test_document_pool_drop, stop),
        cmocka_unit_test_teardown(test_document_pool_memory, stop),
        cmocka_unit_test_teardown(test_document_pool_more_memory_than_usual, stop),
    };
    return api_prepare() ? cmocka_run_group_tests(tests, NULL, NULL) : 1;
}
