/* SPDX-License-Identifier: MIT */
/* When clients that are slow lose their connection. Time is told to `deadlines_reap`. */
#include "server/http/deadlines.h"

#include "server/clock.h"
#include "tests/check.h"
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

/* A connection: `peer` is the client's end. `late` counts the answers 408. */
struct fixture {
    struct deadlines *deadlines;
    struct deadlines_client client;
    int peer, late;
};

static void count_late(void *context, int socket) {
    (void)socket;
    ++*(int *)context;
}

static void begin(struct fixture *fixture) {
    int ends[2];
    assert_return_code(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    fixture->peer = ends[1];
    fixture->late = 0;
    fixture->deadlines = deadlines_new(count_late, &fixture->late);
    assert_non_null(fixture->deadlines);
    deadlines_add(fixture->deadlines, &fixture->client, ends[0], DEADLINES_HEAD_MS);
}

static void end(struct fixture *fixture) {
    deadlines_remove(fixture->deadlines, &fixture->client);
    deadlines_free(fixture->deadlines);
    close(fixture->client.socket);
    close(fixture->peer);
}

/* Whether the client's connection is closed for reading and writing. */
static bool is_closed(const struct fixture *fixture) {
    char byte;
    return recv(fixture->peer, &byte, 1, MSG_DONTWAIT) == 0 &&
           send(fixture->peer, "x", 1, MSG_NOSIGNAL | MSG_DONTWAIT) < 0;
}

static void test_deadlines_answer_a_late_head_and_close_what_lingers(void **state) {
    (void)state;
    struct fixture fixture;
    int64_t before = clock_ms();
    begin(&fixture);
    int64_t due = clock_ms() + DEADLINES_HEAD_MS;
    assert_int_equal(deadlines_reap(fixture.deadlines, before + DEADLINES_HEAD_MS - 1), 0);
    assert_int_equal(deadlines_reap(fixture.deadlines, due), 1);
    assert_int_equal(fixture.late, 1);
    assert_false(is_closed(&fixture)); /* it may read the answer */
    assert_false(deadlines_body(fixture.deadlines, &fixture.client));
    assert_int_equal(deadlines_reap(fixture.deadlines, 2 * due), 0); /* counted already */
    assert_int_equal(fixture.late, 1);
    assert_true(is_closed(&fixture));
    end(&fixture);
}

/* A byte buys the time that it takes at the least rate, and many at once no more than the first
 * time. */
static void test_deadlines_of_a_body_follow_its_rate(void **state) {
    (void)state;
    struct fixture fixture;
    begin(&fixture);
    assert_true(deadlines_body(fixture.deadlines, &fixture.client));
    int64_t due = clock_ms() + DEADLINES_BODY_MS;
    nanosleep(&(struct timespec){.tv_nsec = 50000000}, NULL);
    assert_true(deadlines_received(fixture.deadlines, &fixture.client, 1));
    assert_int_equal(deadlines_reap(fixture.deadlines, due + 1), 1);
    end(&fixture);

    begin(&fixture);
    assert_true(deadlines_body(fixture.deadlines, &fixture.client));
    int64_t before = clock_ms();
    assert_true(deadlines_received(fixture.deadlines, &fixture.client, 100000000));
    due = clock_ms() + DEADLINES_BODY_MS;
    assert_int_equal(deadlines_reap(fixture.deadlines, before + DEADLINES_BODY_MS - 1), 0);
    assert_int_equal(deadlines_reap(fixture.deadlines, due), 1);
    end(&fixture);
}

/* A reply that nobody reads is cut, without an answer into its midst. */
static void test_deadlines_cut_a_reply_that_is_not_read(void **state) {
    (void)state;
    enum { BYTES = 30000 };
    struct fixture fixture;
    begin(&fixture);
    assert_true(deadlines_suspend(fixture.deadlines, &fixture.client));
    assert_int_equal(deadlines_reap(fixture.deadlines, clock_ms() + INT32_MAX), 0);
    int64_t for_ms = DEADLINES_REPLY_MS + BYTES * 1000 / DEADLINES_BODY_RATE, before = clock_ms();
    assert_true(deadlines_reply(fixture.deadlines, &fixture.client, BYTES));
    int64_t due = clock_ms() + for_ms;
    assert_int_equal(deadlines_reap(fixture.deadlines, before + for_ms - 1), 0);
    assert_false(is_closed(&fixture));
    assert_int_equal(deadlines_reap(fixture.deadlines, due), 1);
    assert_int_equal(fixture.late, 0);
    assert_true(is_closed(&fixture));
    assert_false(deadlines_idle(fixture.deadlines, &fixture.client));
    end(&fixture);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_deadlines_answer_a_late_head_and_close_what_lingers),
        cmocka_unit_test(test_deadlines_of_a_body_follow_its_rate),
        cmocka_unit_test(test_deadlines_cut_a_reply_that_is_not_read),
    };
    return cmocka_run_group_tests_name("deadlines", tests, NULL, NULL);
}
