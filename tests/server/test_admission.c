/* SPDX-License-Identifier: MIT */
/* How much one owner may have of what there is for all, and which connection makes room for a new
 * one: ages are set by the test. */
#include "server/clock.h"
#include "server/http/admission.h"
#include "tests/store/scratch.h"
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

enum { PLACES = 3, SECOND_US = 1000000 };

/* PLACES connections, of one owner who may have no more or of several when there are no more, the
 * first idle for longest; and a place for one that comes then. */
struct house {
    struct quotas *quotas;
    struct admissions *admissions;
    struct admission_client clients[PLACES + 1];
    int peers[PLACES + 1], sockets[PLACES + 1];
};

enum { OWNERS_MOST = 12, OWNERS_ALIKE = 10 };

static void name_owner(char name[16], int k) {
    snprintf(name, 16, "owner%d", k);
}

static bool enter(struct house *house, int k, const char *owner) {
    return admission_enter(house->admissions, &house->clients[k], owner, false, house->sockets[k]);
}

static void fill(struct house *house, int64_t most, int64_t owner_most,
                 const char *const owners[PLACES]) {
    const int64_t limits[QUOTAS_KINDS] = {[QUOTAS_CONNECTIONS] = most};
    house->quotas = quotas_new(limits);
    house->admissions = admissions_new(house->quotas, owner_most);
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

/* No place is left. */
static void fill_up(struct house *house, const char *const owners[PLACES]) {
    fill(house, 100, 100, owners);
    while (quotas_left(house->quotas, QUOTAS_CONNECTIONS) > 0)
        assert_true(quotas_add(house->quotas, "others", QUOTAS_CONNECTIONS, 1));
}

static int set_up_full(void **state) {
    static struct house house;
    static const char *const owners[PLACES] = {"few", "many", "many"};
    fill_up(&house, owners);
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
    int64_t others = quotas_of(house->quotas, "others", QUOTAS_CONNECTIONS);
    if (others > 0)
        quotas_give(house->quotas, "others", QUOTAS_CONNECTIONS, others);
    admissions_free(house->admissions);
    quotas_free(house->quotas);
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

/* ------------------------------------------------------------------ shares */

static void give_back(struct quotas *quotas, int owners, enum quotas_kind kind) {
    for (int k = 0; k < owners; k++) {
        char name[16];
        name_owner(name, k);
        int64_t held = quotas_of(quotas, name, kind);
        if (held > 0)
            quotas_give(quotas, name, kind, held);
    }
}

/* All take all they can get: each has the same, as much is left, and whoever comes then finds a
 * place. */
static void test_shares_leave_a_place_for_who_comes(void **state) {
    (void)state;
    unsigned seed = 1;
    for (int round = 0; round < 200; round++) {
        int owners = 1 + rand_r(&seed) % OWNERS_MOST;
        int64_t limit = owners + 1 + rand_r(&seed) % 1000;
        struct quotas *quotas = quotas_new((int64_t[QUOTAS_KINDS]){limit, limit, limit});
        char name[16];
        int first = rand_r(&seed) % owners, refused = 0;
        for (int k = first; refused < owners; k++) {
            name_owner(name, k % owners);
            refused = quotas_take(quotas, name, QUOTAS_STREAMS, 1, INT64_MAX) ? 0 : refused + 1;
        }
        int64_t left = quotas_left(quotas, QUOTAS_STREAMS), sum = 0;
        for (int k = 0; k < owners; k++) {
            name_owner(name, k);
            int64_t held = quotas_of(quotas, name, QUOTAS_STREAMS);
            assert_in_range(held, left, left + 1);
            sum += held;
        }
        assert_int_equal(sum + left, limit);
        assert_int_not_equal(left, 0);
        assert_true(quotas_take(quotas, "new", QUOTAS_STREAMS, 1, INT64_MAX));
        give_back(quotas, owners, QUOTAS_STREAMS);
        assert_int_equal(quotas_left(quotas, QUOTAS_STREAMS), limit - 1);
        quotas_give(quotas, "new", QUOTAS_STREAMS, 1);
        quotas_free(quotas);
    }
}

/* The bytes of each owner's only body, in pieces: they leave room for small ones, but that of an
 * owner alone may have any size. */
static void test_shares_let_the_only_body_grow(void **state) {
    (void)state;
    const int64_t limits[QUOTAS_KINDS] = {[QUOTAS_BODIES] = 1600000};
    struct quotas *quotas = quotas_new(limits);
    for (int k = 0; k < OWNERS_MOST; k++) {
        int64_t held = 0;
        char name[16];
        name_owner(name, k);
        while (held < 300000 && quotas_grow(quotas, name, QUOTAS_BODIES, 1000, held))
            held += 1000;
        assert_int_equal(held, k < 5 ? 300000 : 0);
    }
    assert_int_equal(quotas_left(quotas, QUOTAS_BODIES), 100000);
    assert_false(quotas_take(quotas, "owner0", QUOTAS_BODIES, 1000, INT64_MAX));
    for (int k = 5; k < OWNERS_MOST; k++) {
        char name[16];
        name_owner(name, k);
        assert_true(quotas_take(quotas, name, QUOTAS_BODIES, 1000, INT64_MAX));
        assert_false(quotas_grow(quotas, name, QUOTAS_BODIES, 1000, 0));
    }
    give_back(quotas, OWNERS_MOST, QUOTAS_BODIES);
    quotas_free(quotas);

    quotas = quotas_new(limits);
    assert_true(quotas_grow(quotas, "alone", QUOTAS_BODIES, 1600000, 0));
    assert_false(quotas_grow(quotas, "alone", QUOTAS_BODIES, 1, 1600000));
    quotas_give(quotas, "alone", QUOTAS_BODIES, 1600000);
    quotas_free(quotas);
}

/* Owners whose connections are all busy take what they can get. */
static void test_admission_leaves_a_place_for_who_comes(void **state) {
    (void)state;
    enum { MOST = 64, TRIES = 400 };
    static struct admission_client clients[TRIES], last;
    unsigned seed = 2;
    for (int owners = 1; owners <= OWNERS_MOST; owners++) {
        struct quotas *quotas = quotas_new((int64_t[QUOTAS_KINDS]){MOST, MOST, MOST});
        struct admissions *admissions = admissions_new(quotas, MOST);
        bool in[TRIES];
        for (int k = 0; k < TRIES; k++) {
            char name[16];
            name_owner(name, rand_r(&seed) % owners);
            in[k] = admission_enter(admissions, &clients[k], name, false, -1);
            if (in[k]) {
                assert_int_not_equal(clients[k].how, ADMISSION_FULL);
                admission_busy(admissions, &clients[k], true);
            }
        }
        assert_true(admission_enter(admissions, &last, "new", false, -1));
        assert_int_equal(last.how, ADMISSION_SERVED);
        admission_leave(admissions, &last);
        for (int k = 0; k < TRIES; k++)
            if (in[k])
                admission_leave(admissions, &clients[k]);
        assert_int_equal(quotas_left(quotas, QUOTAS_CONNECTIONS), MOST);
        admissions_free(admissions);
        quotas_free(quotas);
    }
}

/* With no place left whoever has fewer gets one of who has more, never the other way. */
static void test_admission_takes_of_who_has_more(void **state) {
    struct house *house = *state;
    assert_true(enter(house, PLACES, "few"));
    assert_int_equal(house->clients[PLACES].how, ADMISSION_SERVED);
    assert_true(house->clients[1].closing);
}

static void test_admission_takes_of_nobody_who_has_fewer(void **state) {
    struct house *house = *state;
    admission_busy(house->admissions, &house->clients[1], true);
    admission_busy(house->admissions, &house->clients[2], true);
    assert_true(enter(house, PLACES, "many"));
    assert_int_equal(house->clients[PLACES].how, ADMISSION_OWNER_FULL);
    assert_false(house->clients[0].closing);
}

/* All busy, the first heard longest ago. */
static void make_busy(struct house *house) {
    for (int k = 0; k < PLACES; k++) {
        admission_busy(house->admissions, &house->clients[k], true);
        atomic_store(&house->clients[k].active_us, clock_us() - (PLACES - k) * SECOND_US);
    }
}

static void test_admission_takes_a_busy_one_of_who_has_most(void **state) {
    struct house *house = *state;
    make_busy(house);
    expect_replaced(house, 1);
}

static void test_admission_takes_no_busy_one_of_a_proxy(void **state) {
    struct house *house = *state;
    make_busy(house);
    house->clients[1].shared = true;
    expect_replaced(house, 2);
}

static void test_admission_takes_no_busy_one_of_who_has_as_few(void **state) {
    struct house *house = *state;
    make_busy(house);
    house->clients[1].shared = house->clients[2].shared = true;
    assert_true(enter(house, PLACES, "owner"));
    assert_int_equal(house->clients[PLACES].how, ADMISSION_FULL);
    assert_false(house->clients[0].closing);
}

/* Owners with busy connections alone, one after the other: who comes late gets as many as others.
 */
static void test_admission_shares_busy_ones_alike(void **state) {
    (void)state;
    enum { MOST = 60, TRIES = 1000, EACH = MOST / OWNERS_ALIKE };
    static struct admission_client clients[TRIES];
    struct quotas *quotas = quotas_new((int64_t[QUOTAS_KINDS]){MOST, MOST, MOST});
    struct admissions *admissions = admissions_new(quotas, MOST);
    bool in[TRIES] = {false};
    char name[16];
    for (int k = 0; k < TRIES; k++) {
        name_owner(name, k * OWNERS_ALIKE / TRIES);
        in[k] = admission_enter(admissions, &clients[k], name, false, -1);
        if (in[k])
            admission_busy(admissions, &clients[k], true);
        for (int i = 0; i < k; i++) /* its thread has let it go */
            if (in[i] && clients[i].closing) {
                admission_leave(admissions, &clients[i]);
                in[i] = false;
            }
    }
    for (int k = 0; k < OWNERS_ALIKE; k++) {
        name_owner(name, k);
        assert_in_range(quotas_of(quotas, name, QUOTAS_CONNECTIONS), EACH - 1, EACH + 1);
    }
    for (int k = 0; k < TRIES; k++)
        if (in[k])
            admission_leave(admissions, &clients[k]);
    admissions_free(admissions);
    quotas_free(quotas);
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
        IN_FULL_HOUSE(test_admission_takes_of_who_has_more),
        IN_FULL_HOUSE(test_admission_takes_of_nobody_who_has_fewer),
        IN_FULL_HOUSE(test_admission_takes_a_busy_one_of_who_has_most),
        IN_FULL_HOUSE(test_admission_takes_no_busy_one_of_a_proxy),
        IN_FULL_HOUSE(test_admission_takes_no_busy_one_of_who_has_as_few),
        cmocka_unit_test(test_admission_shares_busy_ones_alike),
        cmocka_unit_test(test_admission_leaves_a_place_for_who_comes),
        cmocka_unit_test(test_shares_leave_a_place_for_who_comes),
        cmocka_unit_test(test_shares_let_the_only_body_grow),
    };
    return cmocka_run_group_tests_name("admission", tests, NULL, NULL);
}
