/* SPDX-License-Identifier: MIT */
/* Who is cut, and when: by a clock that the test reads for itself. */
#include "server/clock.h"
#include "server/http/deadlines.h"
#include "tests/store/scratch.h"
#include <sys/socket.h>
#include <unistd.h>

/* A connection: `server` is the end that deadlines know. */
struct pair {
    struct deadlines *deadlines;
    struct deadlines_client entry;
    int client, server;
    int late; /* how often 408 was to be sent */
};

static void count_late(void *context, int socket) {
    struct pair *pair = context;
    assert_int_equal(socket, pair->server);
    pair->late++;
}

static int set_up(void **state) {
    static struct pair pair;
    int ends[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    pair = (struct pair){.client = ends[0], .server = ends[1]};
    pair.deadlines = deadlines_new(count_late, &pair);
    deadlines_add(pair.deadlines, &pair.entry, pair.server, DEADLINES_HEAD_MS);
    *state = &pair;
    return 0;
}

static int tear_down(void **state) {
    struct pair *pair = *state;
    deadlines_remove(pair->deadlines, &pair->entry);
    deadlines_free(pair->deadlines);
    close(pair->client);
    close(pair->server);
    return 0;
}

/* How many are cut so long from now. */
static int reap_after(struct pair *pair, int64_t ms) {
    return deadlines_reap(pair->deadlines, clock_ms() + ms);
}

static void expect_cut(struct pair *pair) {
    char byte;
    assert_int_equal(recv(pair->client, &byte, 1, MSG_DONTWAIT), 0);
}

static void test_deadlines_cut_a_late_head(void **state) {
    struct pair *pair = *state;
    assert_int_equal(reap_after(pair, DEADLINES_HEAD_MS - 1000), 0);
    assert_int_equal(reap_after(pair, DEADLINES_HEAD_MS + 1000), 1);
    assert_int_equal(pair->late, 1);
    expect_cut(pair);
    assert_int_equal(send(pair->client, "?", 1, MSG_NOSIGNAL), 1); /* what it sends is still read */
    /* Who does not go when told to is closed, without another word. */
    assert_int_equal(reap_after(pair, 2 * DEADLINES_HEAD_MS), 0);
    assert_int_equal(pair->late, 1);
    assert_int_equal(send(pair->client, "?", 1, MSG_NOSIGNAL), -1);
}

static void test_deadlines_give_a_long_reply_its_time(void **state) {
    struct pair *pair = *state;
    size_t length = 100 * DEADLINES_BODY_RATE; /* worth as many seconds */
    assert_true(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_REPLY, length));
    assert_int_equal(write(pair->server, "reply", 5), 5);
    assert_int_equal(reap_after(pair, DEADLINES_REPLY_MS + 99000), 0);
    assert_int_equal(reap_after(pair, DEADLINES_REPLY_MS + 101000), 1);
}

static void test_deadlines_cut_a_reply_that_is_not_fetched(void **state) {
    struct pair *pair = *state;
    assert_true(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_REPLY, 0));
    assert_int_equal(write(pair->server, "reply", 5), 5);
    assert_int_equal(reap_after(pair, DEADLINES_REPLY_MS - 1000), 0);
    assert_int_equal(reap_after(pair, DEADLINES_REPLY_MS + 1000), 1);
    assert_int_equal(pair->late, 0); /* no 408 in the midst of it */
    assert_false(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_REPLY, 0));
}

static void test_deadlines_count_only_the_time_of_the_client(void **state) {
    struct pair *pair = *state;
    char bytes[16];
    assert_true(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_BODY, 0));
    assert_int_equal(write(pair->client, "body", 4), 4);
    assert_int_equal(reap_after(pair, 100 * DEADLINES_BODY_MS), 0); /* we have not read it */
    assert_int_equal(read(pair->server, bytes, sizeof bytes), 4);
    assert_true(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_RECEIVED, 4));
    assert_int_equal(reap_after(pair, DEADLINES_BODY_MS - 1000), 0);

    assert_true(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_REPLY, 0));
    assert_int_equal(reap_after(pair, 100 * DEADLINES_REPLY_MS), 0); /* nothing is there to fetch */
    assert_int_equal(write(pair->server, "reply", 5), 5);
    assert_int_equal(reap_after(pair, DEADLINES_REPLY_MS + 1000), 1);
}

static void test_deadlines_cut_a_body_that_drips(void **state) {
    struct pair *pair = *state;
    assert_true(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_BODY, 0));
    int64_t due = pair->entry.due -= DEADLINES_BODY_MS / 2; /* that has gone by */
    assert_true(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_RECEIVED,
                               1)); /* worth a millisecond */
    assert_true(pair->entry.due <= due + 1);
    assert_int_equal(deadlines_reap(pair->deadlines, due + 1), 1);
    assert_int_equal(pair->late, 1);
}

int main(void) {
#define WITH_PAIR(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        WITH_PAIR(test_deadlines_cut_a_late_head),
        WITH_PAIR(test_deadlines_give_a_long_reply_its_time),
        WITH_PAIR(test_deadlines_cut_a_reply_that_is_not_fetched),
        WITH_PAIR(test_deadlines_count_only_the_time_of_the_client),
        WITH_PAIR(test_deadlines_cut_a_body_that_drips),
    };
    return cmocka_run_group_tests_name("deadlines", tests, NULL, NULL);
}
