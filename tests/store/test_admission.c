/* SPDX-License-Identifier: MIT */
/* Which connection makes room for a new one: ages are set by the test. */
#include "scratch.h"
#include "server/clock.h"
#include "server/http/admission.h"
#include <sys/socket.h>
#include <unistd.h>

enum { PLACES = 3, SECOND_US = 1000000 };

/* PLACES connections, of one owner who may have no more or of several when there are no more, the
 * first idle for longest; and a place for one that comes then. */
struct house {
    struct shares *shares;
    struct admissions *admissions;
    struct admission_client clients[PLACES + 1];
    int peers[PLACES + 1], sockets[PLACES + 1];
};

static bool enter(struct house *house, int k, const char *owner) {
    return admission_enter(house->admissions, &house->clients[k], owner, false, house->sockets[k]);
}

static void fill(struct house *house, int64_t most, int64_t owner_most,
                 const char *const owners[PLACES]) {
    house->shares = shares_new();
    house->admissions = admissions_new(house->shares, most, owner_most);
    for (int k = 0; k <= PLACES; k++) {
        int ends[2];
        assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
        house->peers[k] = ends[0];
        house->sockets[k] = ends[1];
    }
    for (int k = 0; k < PLACES; k++) {
        assert_true(enter(house, k, owners[k]));
        atomic_store(&house->clients[k].active_us, clock_us() - (PLACES - k) * SECOND_US);
    }
}

static int set_up(void **state) {
    static struct house house;
    static const char *const owners[PLACES] = {"owner", "owner", "owner"};
    fill(&house, 100, PLACES, owners);
    *state = &house;
    return 0;
}

static int set_up_full(void **state) {
    static struct house house;
    static const char *const owners[PLACES] = {"few", "many", "many"};
    fill(&house, PLACES, 100, owners);
    *state = &house;
    return 0;
}

static int tear_down(void **state) {
    struct house *house = *state;
    for (int k = 0; k <= PLACES; k++) {
        admission_leave(house->admissions, &house->clients[k]);
        close(house->peers[k]);
        close(house->sockets[k]);
    }
    admissions_free(house->admissions);
    shares_free(house->shares);
    return 0;
}

/* Lets the new one in, which is served in the place of that one. */
static void expect_replaced(struct house *house, int replaced) {
    assert_true(enter(house, PLACES, "owner"));
    assert_int_equal(house->clients[PLACES].how, ADMISSION_SERVED);
    for (int k = 0; k < PLACES; k++)
        assert_int_equal(house->clients[k].closing, k == replaced);
}

static void test_admission_closes_the_one_idle_longest(void **state) {
    expect_replaced(*state, 0);
}

/* On a busy machine a request waits in its socket for longer than any grace. */
static void test_admission_closes_none_with_unread_bytes(void **state) {
    struct house *house = *state;
    assert_int_equal(write(house->peers[0], "GET", 3), 3);
    expect_replaced(house, 1);
}

static void test_admission_closes_none_that_was_just_heard(void **state) {
    struct house *house = *state;
    admission_heard(&house->clients[0]);
    admission_busy(house->admissions, &house->clients[1], true);
    expect_replaced(house, 2);
}

static void test_admission_refuses_when_all_have_unread_bytes(void **state) {
    struct house *house = *state;
    for (int k = 0; k < PLACES; k++)
        assert_int_equal(write(house->peers[k], "GET", 3), 3);
    assert_true(enter(house, PLACES, "owner"));
    assert_int_equal(house->clients[PLACES].how, ADMISSION_OWNER_FULL);
    for (int k = 0; k < PLACES; k++)
        assert_false(house->clients[k].closing);
}

static void test_admission_closes_one_of_who_has_most(void **state) {
    expect_replaced(*state, 1);
}

/* Who has most has none to close: one of those who have fewer gives way. */
static void test_admission_goes_on_to_who_has_fewer(void **state) {
    struct house *house = *state;
    admission_busy(house->admissions, &house->clients[1], true);
    assert_int_equal(write(house->peers[2], "GET", 3), 3);
    expect_replaced(house, 0);
}

int main(void) {
#define IN_FULL_HOUSE(test) cmocka_unit_test_setup_teardown(test, set_up_full, tear_down)
#define IN_HOUSE(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        IN_HOUSE(test_admission_closes_the_one_idle_longest),
        IN_HOUSE(test_admission_closes_none_with_unread_bytes),
        IN_HOUSE(test_admission_closes_none_that_was_just_heard),
        IN_HOUSE(test_admission_refuses_when_all_have_unread_bytes),
        IN_FULL_HOUSE(test_admission_closes_one_of_who_has_most),
        IN_FULL_HOUSE(test_admission_goes_on_to_who_has_fewer),
    };
    return cmocka_run_group_tests_name("admission", tests, NULL, NULL);
}
