/* SPDX-License-Identifier: MIT */
/* Trees of boxes: what they find is what a look at every box finds, however the boxes lie. */
#include "solver/surface/boxes.h"

#include "own_arena.h"
#include "tests/check.h"

enum { COUNT = 3000, QUESTIONS = 60 };

struct found {
    const struct box *boxes, *asked;
    size_t count;
    bool seen[COUNT];
};

static bool meets(const struct box *a, const struct box *b) {
    return a->lower.x <= b->upper.x && b->lower.x <= a->upper.x && a->lower.y <= b->upper.y &&
           b->lower.y <= a->upper.y && a->lower.z <= b->upper.z && b->lower.z <= a->upper.z;
}

static bool note(void *context, int32_t number) {
    struct found *found = context;
    assert_in_range(number, 0, COUNT - 1);
    assert_false(found->seen[number]);
    assert_true(meets(&found->boxes[number], found->asked));
    found->seen[number] = true;
    found->count++;
    return true;
}

/* In 0..1, the same on every machine. */
static double draw(uint64_t *state) {
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(*state >> 11) * 0x1p-53;
}

/* Boxes along x: in order, in the order that defeats a middle of three, all at one place, at
 * random. */
static struct box box_of(int kind, int k, uint64_t *state) {
    double x = kind == 0   ? k
               : kind == 1 ? (k % 2 ? k : COUNT - k) / 2
               : kind == 2 ? 7
                           : COUNT * draw(state);
    struct vec3 at = {x, kind == 3 ? COUNT * draw(state) : 0, kind == 3 ? 10 * draw(state) : 0};
    return box_round(at, at, 3 * draw(state));
}

static void test_boxes_find_all_that_meet(void **state) {
    static struct box boxes[COUNT];
    uint64_t seed = 1;
    (void)state;
    for (int kind = 0; kind < 4; kind++)
        for (size_t count = kind == 3 ? COUNT : 1; count <= COUNT; count = 3 * count + 1) {
            struct arena_mark mark = arena_mark(arena);
            struct boxes *tree;
            for (int k = 0; k < (int)count; k++)
                boxes[k] = box_of(kind, k, &seed);
            assert_int_equal(boxes_make(boxes, count, arena, &tree), STATUS_OK);
            for (int q = 0; q < QUESTIONS; q++) {
                struct vec3 at = {COUNT * draw(&seed), kind == 3 ? COUNT * draw(&seed) : 0, 0};
                struct box asked = box_round(at, at, q * q);
                struct found found = {.boxes = boxes, .asked = &asked};
                size_t wanted = 0;
                for (size_t k = 0; k < count; k++)
                    wanted += meets(&boxes[k], &asked);
                boxes_visit(tree, &asked, note, &found);
                assert_int_equal(found.count, wanted);
            }
            arena_rewind(arena, mark);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_boxes_find_all_that_meet)};
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
