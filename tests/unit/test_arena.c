/* SPDX-License-Identifier: MIT */
#include "solver/arena.h"

#include "support.h"
#include "tests/check.h"
#include <string.h>

static const size_t large = 3 * 1024 * 1024;

static void test_arena_gives_zeroed_aligned_memory(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = arena_new((size_t)1 << 30);
    for (int i = 0; i < 2000; i++) {
        size_t count = (size_t)random_index(&random, i % 100 ? 300 : 300000);
        unsigned char *memory = arena_alloc(arena, count, 1);
        assert_non_null(memory);
        assert_int_equal((uintptr_t)memory % 64, 0);
        for (size_t k = 0; k < count; k++)
            assert_int_equal(memory[k], 0);
        memset(memory, 0xff, count);
    }
    arena_free(arena);
    arena_free(NULL);
}

static void test_arena_rewind_gives_back_what_was_taken_since_the_mark(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 30);
    char *kept = arena_alloc(arena, 100, 1);
    memset(kept, 'k', 100);
    size_t held = arena_held(arena);
    struct arena_mark mark = arena_mark(arena);
    char *first = arena_alloc(arena, 64, 1);
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < 5; i++)
            memset(arena_alloc(arena, large, 1), 'x', large);
        check_above(arena_held(arena), 5 * large);
        arena_rewind(arena, mark);
        assert_int_equal(arena_held(arena), held);
    }
    char *again = arena_alloc(arena, 64, 1);
    assert_ptr_equal(first, again);
    assert_int_equal(again[0], 0);
    for (int k = 0; k < 100; k++)
        assert_int_equal(kept[k], 'k');
    check_above(arena_peak(arena), 5 * large);
    arena_free(arena);
}

static void test_arena_rewind_to_an_empty_one(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 30);
    struct arena_mark mark = arena_mark(arena);
    assert_non_null(arena_alloc(arena, large, 1));
    arena_rewind(arena, mark);
    assert_int_equal(arena_held(arena), 0);
    assert_non_null(arena_alloc(arena, 1, 1));
    arena_free(arena);
}

static void test_arena_never_holds_more_than_its_budget(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int round = 0; round < 200; round++) {
        size_t budget = (size_t)random_index(&random, 1 << 20);
        struct arena *arena = arena_new(budget);
        while (arena_alloc(arena, 1 + (size_t)random_index(&random, 1 << 15), 1))
            assert_in_range(arena_held(arena), 1, budget);
        assert_in_range(arena_peak(arena), 0, budget);
        arena_free(arena);
    }
}

static void test_arena_refuses_products_that_overflow(void **state) {
    (void)state;
    struct arena *arena = arena_new(SIZE_MAX);
    assert_null(arena_alloc(arena, SIZE_MAX / 2, 3));
    assert_null(arena_alloc(arena, SIZE_MAX, 1));
    assert_null(arena_alloc(arena, SIZE_MAX - 64, 1));
    assert_non_null(arena_alloc(arena, 0, SIZE_MAX));
    arena_free(arena);
}

static void test_arena_fails_from_the_nth_allocation_on(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 20);
    arena_fail_at(arena, 3);
    assert_non_null(arena_alloc(arena, 8, 8));
    assert_non_null(arena_alloc(arena, 8, 8));
    assert_null(arena_alloc(arena, 8, 8));
    assert_null(arena_alloc(arena, 8, 8));
    arena_fail_at(arena, 0);
    assert_non_null(arena_alloc(arena, 8, 8));
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arena_gives_zeroed_aligned_memory),
        cmocka_unit_test(test_arena_rewind_gives_back_what_was_taken_since_the_mark),
        cmocka_unit_test(test_arena_rewind_to_an_empty_one),
        cmocka_unit_test(test_arena_never_holds_more_than_its_budget),
        cmocka_unit_test(test_arena_refuses_products_that_overflow),
        cmocka_unit_test(test_arena_fails_from_the_nth_allocation_on),
    };
    return cmocka_run_group_tests_name("arena", tests, NULL, NULL);
}
