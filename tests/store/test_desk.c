/* SPDX-License-Identifier: MIT */
/* The threads that attend to slow calls: each exchange once, none left behind, and when they are
 * needed. */
#include "scratch.h"
#include "server/http/client.h"
#include "server/http/desk.h"
#include <stdatomic.h>
#include <unistd.h>

enum { EXCHANGES = 500, BUSY_US = 200 };

static struct exchange exchanges[EXCHANGES];
static atomic_int attended[EXCHANGES];

static void attend(struct exchange *exchange) {
    usleep(BUSY_US);
    atomic_fetch_add(&attended[exchange - exchanges], 1);
}

/* Stopped at once after the last one: all that was handed over is attended to before it ends. */
static void test_desk_attends_to_each_once(void **state) {
    (void)state;
    for (int round = 1; round <= 3; round++) {
        struct desk *desk = desk_start(attend);
        assert_non_null(desk);
        for (int k = 0; k < EXCHANGES; k++) {
            exchanges[k] = (struct exchange){0};
            desk_hand_over(desk, &exchanges[k]);
        }
        desk_stop(desk);
        desk_free(desk);
        for (int k = 0; k < EXCHANGES; k++)
            assert_int_equal(atomic_load(&attended[k]), round);
    }
    desk_stop(NULL);
    desk_free(NULL);
}

/* One slow call is enough; some twenty quick ones end it. */
static void test_desk_is_needed_while_calls_are_slow(void **state) {
    (void)state;
    struct desk *desk = desk_start(attend);
    assert_non_null(desk);
    assert_false(desk_needed(desk));
    desk_note(desk, DESK_SLOW_US);
    assert_false(desk_needed(desk));
    desk_note(desk, 10 * DESK_SLOW_US);
    assert_true(desk_needed(desk));
    int quick = 0;
    for (; quick < 100 && desk_needed(desk); quick++)
        desk_note(desk, 100);
    assert_in_range(quick, 10, 30);
    desk_stop(desk);
    desk_free(desk);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_desk_attends_to_each_once),
        cmocka_unit_test(test_desk_is_needed_while_calls_are_slow),
    };
    return cmocka_run_group_tests_name("desk", tests, NULL, NULL);
}
