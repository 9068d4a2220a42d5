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

/* How long each turn may last: due neither before nor later than a moment after. */
static void test_deadlines_give_each_turn_its_time(void **state) {
    static const struct {
        enum deadlines_turn turn;
        size_t length;
        int64_t ms;
    } turns[] = {
        {DEADLINES_IDLE, 5000, DEADLINES_IDLE_MS + DEADLINES_HEAD_MS},
        {DEADLINES_BODY, 5000, DEADLINES_BODY_MS},
        {DEADLINES_REPLY, 0, DEADLINES_REPLY_MS},
        {DEADLINES_REPLY, 5 * DEADLINES_BODY_RATE, DEADLINES_REPLY_MS + 5000},
    };
    struct pair *pair = *state;
    for (size_t k = 0; k < sizeof turns / sizeof *turns; k++) {
        int64_t begun = clock_ms();
        assert_true(deadlines_turn(pair->deadlines, &pair->entry, turns[k].turn, turns[k].length));
        assert_in_range(pair->entry.due, begun + turns[k].ms, clock_ms() + turns[k].ms);
    }
    deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_OURS, 5000);
    assert_true(pair->entry.due == INT64_MAX);
}

/* A byte is worth a millisecond, but what is left never exceeds what there was at first. */
static void test_deadlines_extend_a_body_by_what_comes(void **state) {
    struct pair *pair = *state;
    assert_true(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_BODY, 0));
    for (int64_t gone = 9000; gone > 0; gone -= 3000) {
        int64_t due = pair->entry.due = clock_ms() + DEADLINES_BODY_MS - gone;
        assert_true(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_RECEIVED,
                                   2 * DEADLINES_BODY_RATE));
        assert_int_equal(pair->entry.due, due + 2000);
    }
    pair->entry.due = clock_ms() + DEADLINES_BODY_MS - 1000;
    int64_t begun = clock_ms();
    assert_true(
        deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_RECEIVED, 2 * DEADLINES_BODY_RATE));
    assert_in_range(pair->entry.due, begun + DEADLINES_BODY_MS, clock_ms() + DEADLINES_BODY_MS);
}

/* Who was told that it was late has two seconds to read so; so has who got the last answer. */
static void test_deadlines_let_the_last_answer_be_read(void **state) {
    struct pair *pair = *state;
    const int64_t now = clock_ms() + DEADLINES_HEAD_MS + 1000;
    assert_int_equal(deadlines_reap(pair->deadlines, now), 1);
    assert_int_equal(deadlines_reap(pair->deadlines, now + 1999), 0);
    assert_int_equal(send(pair->client, "?", 1, MSG_NOSIGNAL), 1);
    assert_int_equal(deadlines_reap(pair->deadlines, now + 2000), 0);
    assert_int_equal(send(pair->client, "?", 1, MSG_NOSIGNAL), -1);
    assert_true(pair->entry.due == INT64_MAX);
    assert_int_equal(pair->late, 1);

    int64_t begun = clock_ms();
    deadlines_cut(pair->deadlines, &pair->entry);
    assert_in_range(pair->entry.due, begun + 2000, clock_ms() + 2000);
    assert_false(deadlines_turn(pair->deadlines, &pair->entry, DEADLINES_IDLE, 0));
    assert_in_range(pair->entry.due, begun + 2000, clock_ms() + 2000);
}

/* The last answer is as late as any: what is unread then makes no difference. */
static void test_deadlines_close_who_was_cut_whatever_it_sent(void **state) {
    struct pair *pair = *state;
    deadlines_cut(pair->deadlines, &pair->entry);
    assert_int_equal(write(pair->client, "more", 4), 4);
    assert_int_equal(reap_after(pair, 3000), 0);
    assert_int_equal(send(pair->client, "?", 1, MSG_NOSIGNAL), -1);
    assert_int_equal(pair->late, 0);
}

/* Taken out in any order, the others are still looked at. */
static void test_deadlines_look_at_all_that_are_in(void **state) {
    enum { ALL = 4 };
    static const int orders[][ALL] = {{0, 1, 2, 3}, {3, 2, 1, 0}, {1, 2, 0, 3}, {2, 0, 3, 1}};
    struct pair *pair = *state;
    for (size_t order = 0; order < sizeof orders / sizeof *orders; order++) {
        struct deadlines *deadlines = deadlines_new(count_late, pair);
        struct deadlines_client entries[ALL];
        for (int k = 0; k < ALL; k++)
            deadlines_add(deadlines, &entries[k], pair->server, 1000);
        for (int gone = 0; gone < ALL; gone++) {
            for (int k = 0; k < ALL; k++) {
                entries[k].due = 1;
                entries[k].cut = false;
            }
            assert_int_equal(deadlines_reap(deadlines, 0), 0);
            assert_int_equal(deadlines_reap(deadlines, 1), ALL - gone);
            deadlines_remove(deadlines, &entries[orders[order][gone]]);
        }
        assert_int_equal(deadlines_reap(deadlines, INT64_MAX - 1), 0);
        deadlines_free(deadlines);
    }
    deadlines_free(NULL);
}

int main(void) {
#define WITH_PAIR(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        WITH_PAIR(test_deadlines_cut_a_late_head),
        WITH_PAIR(test_deadlines_give_a_long_reply_its_time),
        WITH_PAIR(test_deadlines_cut_a_reply_that_is_not_fetched),
        WITH_PAIR(test_deadlines_count_only_the_time_of_the_client),
        WITH_PAIR(test_deadlines_cut_a_body_that_drips),
        WITH_PAIR(test_deadlines_give_each_turn_its_time),
        WITH_PAIR(test_deadlines_extend_a_body_by_what_comes),
        WITH_PAIR(test_deadlines_let_the_last_answer_be_read),
        WITH_PAIR(test_deadlines_close_who_was_cut_whatever_it_sent),
        WITH_PAIR(test_deadlines_look_at_all_that_are_in),
    };
    return cmocka_run_group_tests_name("deadlines", tests, NULL, NULL);
}
