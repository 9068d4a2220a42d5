/* SPDX-License-Identifier: MIT */
/* The threads that attend to slow calls: each exchange once, none left behind, and when they are
 * needed. */
#include "server/http/client.h"
#include "server/http/slow_calls.h"
#include "tests/store/scratch.h"
#include <semaphore.h>
#include <stdatomic.h>
#include <unistd.h>

enum { EXCHANGES = 500, BUSY_US = 200 };

static struct request anybody;
static struct exchange exchanges[EXCHANGES];
static atomic_int attended[EXCHANGES];
static atomic_int reading, most_reading;

static bool reads(ptrdiff_t k) {
    return k % 2;
}

static void attend(struct exchange *exchange) {
    ptrdiff_t k = exchange - exchanges;
    int now = atomic_fetch_add(&reading, reads(k)) + reads(k);
    if (now > atomic_load(&most_reading))
        atomic_store(&most_reading, now);
    usleep(BUSY_US);
    atomic_fetch_sub(&reading, reads(k));
    atomic_fetch_add(&attended[k], 1);
}

/* Stopped at once after the last one: all that was handed over is attended to before it ends, and
 * those that read never take more than their share of the threads. */
static void test_slow_calls_attends_to_each_once(void **state) {
    (void)state;
    for (int round = 1; round <= 3; round++) {
        struct slow_calls *slow_calls = slow_calls_start(attend);
        assert_non_null(slow_calls);
        for (int k = 0; k < EXCHANGES; k++) {
            exchanges[k] = (struct exchange){.request = &anybody};
            slow_calls_hand_over(slow_calls, reads(k) ? SLOW_CALLS_READS : SLOW_CALLS_CHANGES,
                                 &exchanges[k]);
        }
        slow_calls_stop(slow_calls);
        slow_calls_free(slow_calls);
        for (int k = 0; k < EXCHANGES; k++)
            assert_int_equal(atomic_load(&attended[k]), round);
    }
    assert_in_range(atomic_load(&most_reading), 1, SLOW_CALLS_READERS);
    slow_calls_stop(NULL);
    slow_calls_free(NULL);
}

static _Atomic(struct exchange *) begun[EXCHANGES];
static atomic_int begun_count;
static sem_t gate;

static void attend_at_gate(struct exchange *exchange) {
    atomic_store(&begun[atomic_fetch_add(&begun_count, 1)], exchange);
    sem_wait(&gate);
}

static void wait_for_begun(int count) {
    for (int k = 0; k < count; k++)
        while (!atomic_load(&begun[k]))
            usleep(1000);
}

/* All threads and a long line are one owner's: the only call of another is the next all the same.
 */
static void test_slow_calls_takes_the_owner_with_the_fewest(void **state) {
    static struct request one = {.owner = "one"}, other = {.owner = "other"};
    (void)state;
    assert_int_equal(sem_init(&gate, 0, 0), 0);
    struct slow_calls *slow_calls = slow_calls_start(attend_at_gate);
    assert_non_null(slow_calls);
    for (int k = 0; k < 3 * SLOW_CALLS_THREADS; k++) {
        exchanges[k] = (struct exchange){.request = &one};
        slow_calls_hand_over(slow_calls, SLOW_CALLS_CHANGES, &exchanges[k]);
    }
    wait_for_begun(SLOW_CALLS_THREADS);
    struct exchange last = {.request = &other}, behind = {.request = &one};
    slow_calls_hand_over(slow_calls, SLOW_CALLS_CHANGES, &last);
    slow_calls_hand_over(slow_calls, SLOW_CALLS_CHANGES, &behind);
    sem_post(&gate);
    wait_for_begun(SLOW_CALLS_THREADS + 1);
    assert_ptr_equal(atomic_load(&begun[SLOW_CALLS_THREADS]), &last);
    for (int k = 0; k <= 3 * SLOW_CALLS_THREADS; k++)
        sem_post(&gate);
    slow_calls_stop(slow_calls);
    slow_calls_free(slow_calls);
    assert_int_equal(atomic_load(&begun_count), 3 * SLOW_CALLS_THREADS + 2);
    sem_destroy(&gate);
}

/* One slow call is enough; some twenty quick ones end it. What changes take says nothing of reads.
 */
static void test_slow_calls_is_needed_while_calls_are_slow(void **state) {
    (void)state;
    struct slow_calls *slow_calls = slow_calls_start(attend);
    assert_non_null(slow_calls);
    assert_false(slow_calls_are_slow(slow_calls, SLOW_CALLS_CHANGES));
    slow_calls_note(slow_calls, SLOW_CALLS_CHANGES, SLOW_CALLS_SLOW_US);
    assert_false(slow_calls_are_slow(slow_calls, SLOW_CALLS_CHANGES));
    slow_calls_note(slow_calls, SLOW_CALLS_CHANGES, 10 * SLOW_CALLS_SLOW_US);
    assert_true(slow_calls_are_slow(slow_calls, SLOW_CALLS_CHANGES));
    assert_false(slow_calls_are_slow(slow_calls, SLOW_CALLS_READS));
    int quick = 0;
    for (; quick < 100 && slow_calls_are_slow(slow_calls, SLOW_CALLS_CHANGES); quick++)
        slow_calls_note(slow_calls, SLOW_CALLS_CHANGES, 100);
    assert_in_range(quick, 10, 30);
    slow_calls_stop(slow_calls);
    slow_calls_free(slow_calls);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_slow_calls_attends_to_each_once),
        cmocka_unit_test(test_slow_calls_takes_the_owner_with_the_fewest),
        cmocka_unit_test(test_slow_calls_is_needed_while_calls_are_slow),
    };
    return cmocka_run_group_tests_name("slow calls", tests, NULL, NULL);
}
