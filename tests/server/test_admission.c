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

/* ------------------------------------------------------------------ in reserve */

/* Busy ones of proxies, which nobody may close: whoever comes is in reserve, and beyond that in the
 * place of the one in reserve that is idle for longest; of none that has sent something. */
static void test_admission_replaces_in_reserve_who_is_idle_longest(void **state) {
    static struct admission_client reserve[ADMISSION_RESERVE + 2];
    struct house *house = *state;
    int ends[2];
    make_busy(house);
    for (int k = 0; k < PLACES; k++)
        house->clients[k].shared = true;
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    for (int k = 0; k < ADMISSION_RESERVE; k++) {
        assert_true(
            admission_enter(house->admissions, &reserve[k], "new", false, k == 7 ? ends[0] : -1));
        assert_int_equal(reserve[k].how, ADMISSION_FULL);
        atomic_store(&reserve[k].active_us, clock_us() - (k == 5 || k == 7 ? k : 1) * SECOND_US);
    }
    assert_int_equal(write(ends[1], "GET", 3), 3);
    for (int n = 0; n < 2; n++) {
        assert_true(
            admission_enter(house->admissions, &reserve[ADMISSION_RESERVE + n], "few", false, -1));
        assert_int_equal(reserve[ADMISSION_RESERVE + n].how, ADMISSION_OWNER_FULL);
        for (int k = 0; k < ADMISSION_RESERVE; k++)
            assert_int_equal(reserve[k].closing, k == 5 || (n == 1 && k == 0));
    }
    for (int k = 0; k < ADMISSION_RESERVE + 2; k++)
        atomic_store(&reserve[k].active_us, clock_us() + SECOND_US);
    assert_false(enter(house, PLACES, "new")); /* none is idle */
    for (int k = 0; k < PLACES; k++)
        assert_false(house->clients[k].closing);
    for (int k = 0; k < ADMISSION_RESERVE + 2; k++)
        admission_leave(house->admissions, &reserve[k]);
    assert_true(enter(house, PLACES, "new"));
    close(ends[0]);
    close(ends[1]);
}

/* Of an owner with many idle ones no more are closed than may be on their way out. */
static void test_admission_closes_so_many_at_a_time(void **state) {
    enum { MOST = 100 };
    static struct admission_client clients[MOST + ADMISSION_CLOSING + 1];
    const int64_t limits[QUOTAS_KINDS] = {[QUOTAS_CONNECTIONS] = 1000};
    struct quotas *quotas = quotas_new(limits);
    struct admissions *admissions = admissions_new(quotas, MOST);
    (void)state;
    for (int k = 0; k < MOST + ADMISSION_CLOSING + 1; k++) {
        assert_true(admission_enter(admissions, &clients[k], "owner", false, -1));
        assert_int_equal(clients[k].how,
                         k < MOST + ADMISSION_CLOSING ? ADMISSION_SERVED : ADMISSION_OWNER_FULL);
        atomic_store(&clients[k].active_us, clock_us() - SECOND_US);
    }
    for (int k = 0; k < MOST; k++)
        assert_int_equal(clients[k].closing, k < ADMISSION_CLOSING);
    assert_int_equal(quotas_of(quotas, "owner", QUOTAS_CONNECTIONS), MOST);
    for (int k = 0; k < MOST + ADMISSION_CLOSING + 1; k++)
        admission_leave(admissions, &clients[k]);
    assert_int_equal(quotas_left(quotas, QUOTAS_CONNECTIONS), 1000);
    assert_true(admission_enter(admissions, &clients[0], "owner", false, -1));
    admission_leave(admissions, &clients[0]);
    admissions_free(admissions);
    admissions_free(NULL);
    quotas_free(quotas);
    quotas_free(NULL);
}

/* A tenth of a second passes before one counts as idle. */
static void test_admission_gives_a_moment_of_grace(void **state) {
    struct house *house = *state;
    int64_t begun = clock_us();
    for (int k = 0; k < PLACES; k++)
        atomic_store(&house->clients[k].active_us, begun);
    assert_true(enter(house, PLACES, "owner"));
    if (clock_us() - begun < SECOND_US / 10) /* this machine was not too slow to see it */
        assert_int_equal(house->clients[PLACES].how, ADMISSION_OWNER_FULL);
    admission_leave(house->admissions, &house->clients[PLACES]);
    scratch_sleep(150);
    assert_true(enter(house, PLACES, "owner"));
    assert_int_equal(house->clients[PLACES].how, ADMISSION_SERVED);
}

/* Whoever has left is not looked at any more, wherever it stood. */
static void test_admission_forgets_who_has_left(void **state) {
    static const char *const owners[PLACES] = {"owner", "owner", "owner"};
    (void)state;
    for (int gone = 0; gone < PLACES; gone++) {
        static struct house house;
        fill(&house, 100, PLACES, owners);
        void *same = &house;
        admission_leave(house.admissions, &house.clients[gone]);
        house.clients[gone].closing = false;
        atomic_store(&house.clients[gone].active_us, 0);
        struct admission_client in_its_place;
        assert_true(admission_enter(house.admissions, &in_its_place, "owner", false, -1));
        assert_int_equal(in_its_place.how, ADMISSION_SERVED);
        expect_replaced(&house, gone == 0 ? 1 : 0);
        admission_leave(house.admissions, &in_its_place);
        assert_true(enter(&house, gone, "owner")); /* for the end, which has all leave */
        assert_int_equal(tear_down(&same), 0);
    }
}

/* At the last one below a bound of its own, and at the last one that is left. */
static void test_quotas_end_where_they_say(void **state) {
    static const struct {
        int64_t limit, others, held, amount, most;
        bool fits;
    } rows[] = {
        {100, 0, 0, 1, 1, true},    {100, 0, 0, 2, 1, false},    {100, 0, 1, 1, 2, true},
        {100, 0, 1, 1, 1, false},   {100, 0, 0, 50, 99, true},   {100, 0, 0, 51, 99, false},
        {100, 0, 49, 1, 99, true},  {100, 0, 50, 1, 99, false},  {100, 98, 0, 1, 99, true},
        {100, 98, 0, 2, 99, false}, {100, 100, 0, 1, 99, false}, {100, 90, 4, 1, 99, true},
        {100, 90, 5, 1, 99, false},
    };
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        struct quotas *quotas = quotas_new((int64_t[QUOTAS_KINDS]){0, rows[k].limit, 0});
        if (rows[k].others)
            assert_true(quotas_add(quotas, "others", QUOTAS_STREAMS, rows[k].others));
        if (rows[k].held)
            assert_true(quotas_add(quotas, "owner", QUOTAS_STREAMS, rows[k].held));
        assert_int_equal(quotas_fit(quotas, "owner", QUOTAS_STREAMS, rows[k].amount, rows[k].most),
                         rows[k].fits);
        assert_int_equal(quotas_take(quotas, "owner", QUOTAS_STREAMS, rows[k].amount, rows[k].most),
                         rows[k].fits);
        int64_t held = rows[k].held + rows[k].fits * rows[k].amount;
        assert_int_equal(quotas_of(quotas, "owner", QUOTAS_STREAMS), held);
        assert_int_equal(quotas_left(quotas, QUOTAS_STREAMS),
                         rows[k].limit - rows[k].others - held);
        if (held)
            quotas_give(quotas, "owner", QUOTAS_STREAMS, held);
        if (rows[k].others)
            quotas_give(quotas, "others", QUOTAS_STREAMS, rows[k].others);
        quotas_free(quotas);
    }
}

/* What one kind takes says nothing of another, and who has given all back is forgotten. */
static void test_quotas_keep_kinds_apart(void **state) {
    struct quotas *quotas = quotas_new((int64_t[QUOTAS_KINDS]){10, 20, 30});
    (void)state;
    assert_true(quotas_add(quotas, "a", QUOTAS_CONNECTIONS, 1));
    assert_true(quotas_add(quotas, "a", QUOTAS_BODIES, 3));
    assert_true(quotas_add(quotas, "b", QUOTAS_BODIES, 4));
    for (int give = 0; give < 3; give++) {
        assert_int_equal(quotas_of(quotas, "a", QUOTAS_CONNECTIONS), give < 2);
        assert_int_equal(quotas_of(quotas, "a", QUOTAS_STREAMS), 0);
        assert_int_equal(quotas_of(quotas, "a", QUOTAS_BODIES), give < 1 ? 3 : 0);
        assert_int_equal(quotas_of(quotas, "b", QUOTAS_BODIES), 4);
        assert_int_equal(quotas_left(quotas, QUOTAS_CONNECTIONS), give < 2 ? 9 : 10);
        assert_int_equal(quotas_left(quotas, QUOTAS_STREAMS), 20);
        assert_int_equal(quotas_left(quotas, QUOTAS_BODIES), give < 1 ? 23 : 26);
        if (give < 2)
            quotas_give(quotas, "a", give ? QUOTAS_CONNECTIONS : QUOTAS_BODIES, give ? 1 : 3);
    }
    quotas_give(quotas, "b", QUOTAS_BODIES, 4);
    for (int kind = 0; kind < QUOTAS_KINDS; kind++) /* all of them, of which one goes in part */
        assert_true(quotas_add(quotas, "c", kind, 5));
    for (int kind = 0; kind < QUOTAS_KINDS; kind++) {
        quotas_give(quotas, "c", kind, 2);
        for (int k = 0; k < QUOTAS_KINDS; k++)
            assert_int_equal(quotas_of(quotas, "c", k), k <= kind ? 3 : 5);
    }
    for (int kind = 0; kind < QUOTAS_KINDS; kind++)
        quotas_give(quotas, "c", kind, 3);
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
        IN_FULL_HOUSE(test_admission_replaces_in_reserve_who_is_idle_longest),
        IN_HOUSE(test_admission_gives_a_moment_of_grace),
        cmocka_unit_test(test_admission_forgets_who_has_left),
        cmocka_unit_test(test_admission_closes_so_many_at_a_time),
        cmocka_unit_test(test_quotas_end_where_they_say),
        cmocka_unit_test(test_quotas_keep_kinds_apart),
    };
    return cmocka_run_group_tests_name("admission", tests, NULL, NULL);
}
