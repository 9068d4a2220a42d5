/* SPDX-License-Identifier: MIT */
/* Materials: their documents, and their names in requests. */
#include "api/check.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/material.h"
#include "support.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OWN                                                                                        \
    "{\"name\":\"own\",\"about\":\"a \\\"twill\\\"\",\"example\":false,\"areal_weight\":0.3,"      \
    "\"fabric\":{\"thickness\":3e-04,\"fiber_volume_fraction\":0.5,\"locking_angle_deg\":40},"     \
    "\"permeability\":{\"model\":\"gebart\",\"fiber_radius\":4e-06,\"packing\":\"hexagonal\"},"    \
    "\"compaction\":{\"a\":0.2,\"b\":0.1}}"
#define PATCH "{\"vertices\":[[0,0,0],[1,0,0],[0,1,0]],\"triangles\":[[0,1,2]]}"

static int set_up(void **state) {
    *state = arena_new((size_t)1 << 24);
    return *state == NULL || !api_prepare();
}

static int tear_down(void **state) {
    arena_free(*state);
    return 0;
}

static enum api_problem_id decode(const char *text, struct arena *arena,
                                  struct api_material *material, const char **head,
                                  struct api_problem *problem) {
    *problem = (struct api_problem){0};
    return api_material_decode(text, strlen(text), &api_limits_default, arena, material, head,
                               problem);
}

/* What is kept is what was said, and reads as itself. */
static void test_material_is_written_as_it_is_read(void **state) {
    struct api_material material;
    struct api_problem problem;
    const char *head;
    assert_int_equal(decode(OWN, *state, &material, &head, &problem), API_OK);
    assert_string_equal(material.name, "own");
    assert_string_equal(material.json, OWN);
    assert_int_equal(material.length, strlen(OWN));
    assert_string_equal(head, "{\"name\":\"own\",\"about\":\"a \\\"twill\\\"\",\"source\":\"\","
                              "\"example\":false,\"own\":true}");
    for (size_t k = 0; api_material_at(k); k++) { /* so does the library, under other names */
        char *text = strdup(api_material_at(k)->json);
        memcpy(strstr(text, "\"name\":\"") + 8, "x", 1);
        assert_int_equal(decode(text, *state, &material, &head, &problem), API_OK);
        free(text);
    }
}

static void test_material_names_what_is_wrong(void **state) {
    static const struct {
        const char *text, *pointer;
    } bad[] = {
        {"[]", ""},
        {"{\"fabric\":{}}", "/name"},
        {"{\"name\":\"a/b\",\"fabric\":{}}", "/name"},
        {"{\"name\":\"..\",\"fabric\":{}}", "/name"},
        {"{\"name\":\"lcmsim-test-case\",\"fabric\":{}}", "/name"},
        {"{\"name\":\"a\"}", "/fabric"},
        {"{\"name\":\"a\",\"fabric\":{\"spacing\":1}}", "/fabric/spacing"},
        {"{\"name\":\"a\",\"fabric\":{},\"weight\":1}", "/weight"},
        {"{\"name\":\"a\",\"fabric\":{},\"source\":7}", "/source"},
        {"{\"name\":\"a\",\"fabric\":{},\"compaction\":{\"a\":-1,\"b\":1}}", "/compaction/a"},
        {"{\"name\":\"a\",\"fabric\":{},\"permeability\":{\"model\":\"gebart\"}}",
         "/permeability/fiber_radius"},
        /* mm for m */
        {"{\"name\":\"a\",\"areal_weight\":0.3,\"fabric\":{\"thickness\":0.3,"
         "\"fiber_volume_fraction\":0.5}}",
         "/areal_weight"},
    };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        struct api_material material;
        struct api_problem problem;
        const char *head;
        if (decode(bad[k].text, *state, &material, &head, &problem) != API_INVALID_REQUEST ||
            strcmp(problem.error[0].pointer, bad[k].pointer) != 0)
            fail_msg("%s: %s at '%s'", bad[k].text, api_problem_slug(problem.id),
                     problem.error[0].pointer);
    }
}

static const char *fill(const char *request, struct arena *arena) {
    size_t length;
    const char *filled =
        api_material_fill(request, strlen(request), OWN "\n", strlen(OWN) + 1, arena, &length);
    assert_non_null(filled);
    assert_int_equal(strlen(filled), length);
    return filled;
}

static void test_material_is_put_where_a_fabric_names_it(void **state) {
    static const char *const same[] = {
        "{\"fabric\":{\"material\":\"unknown\"}}",
        "{\"material\":\"own\"}",
        "{\"fabric\":[\"material\",\"own\"]}",
        "{\"fabric\":{\"about\":{\"material\":\"own\"}}}",
        "{\"fabric\":{\"about\":\"material\",\"name\":\"own\"}}",
        "{\"fabric\":{\"a\\\"material\":\"own\"}}",
        "{\"fabric\":{\"material\":{\"name\":\"own\"}}}",
        "{\"name\":\"\\\\\",\"x\":\"{\\\"fabric\\\":{\",\"material\":\"own\"}",
        "{\"fabric\":{\"material\":\"own",
        "{\"fabric\":{\"material\":\"own\\",
        "]]}}\"fabric\":\"material\":\"own\"",
        "",
    };
    static const struct {
        const char *from, *to;
    } filled[] = {
        {"{\"fabric\":{\"material\":\"own\"}}", "{\"fabric\":{\"material\":" OWN "}}"},
        {" { \"fabric\" : { \"spacing\" : 1 , \"material\" : \"own\" } } ",
         " { \"fabric\" : { \"spacing\" : 1 , \"material\" : " OWN " } } "},
        {"{\"plies\":[{\"fabric\":{\"material\":\"own\",\"x\":[{}]}},{\"fabric\":{\"x\":{},"
         "\"material\":\"own\"}}]}",
         "{\"plies\":[{\"fabric\":{\"material\":" OWN ",\"x\":[{}]}},{\"fabric\":{\"x\":{},"
         "\"material\":" OWN "}}]}"},
    };
    for (size_t k = 0; k < sizeof same / sizeof *same; k++)
        assert_string_equal(fill(same[k], *state), same[k]);
    for (size_t k = 0; k < sizeof filled / sizeof *filled; k++)
        assert_string_equal(fill(filled[k].from, *state), filled[k].to);
    const struct api_material *first = api_material_at(0);
    char request[256];
    snprintf(request, sizeof request, "{\"fabric\":{\"material\":\"%s\"}}", first->name);
    assert_non_null(strstr(fill(request, *state), first->json));
}

static void test_material_is_wanted_once_and_not_of_the_library(void **state) {
    static const char request[] =
        "{\"plies\":[{\"fabric\":{\"material\":\"b\"}},{\"fabric\":{\"material\":\"a.b\"}},"
        "{\"fabric\":{\"material\":\"b\"}},{\"fabric\":{\"material\":\"lcmsim-test-case\"}},"
        "{\"fabric\":{\"material\":\"a/b\"}},{\"fabric\":{\"material\":\"\"}}]}";
    assert_string_equal(api_material_wanted(request, strlen(request), *state), "b\na.b\n");
    assert_string_equal(api_material_wanted("{}", 2, *state), "");
}

/* Text that ends anywhere, brackets without end: nothing is read beyond it. */
static void test_material_looks_at_no_more_than_the_text(void **state) {
    char deep[400];
    static const char request[] = "{\"fabric\":{\"x\":\"\\\\\\\"\",\"material\":\"own\"}}";
    struct arena_mark mark = arena_mark(*state);
    for (size_t length = 0; length <= strlen(request); length++) {
        size_t filled;
        char *text = memcpy(malloc(length + !length), request, length);
        assert_non_null(api_material_wanted(text, length, *state));
        assert_non_null(api_material_fill(text, length, OWN, strlen(OWN), *state, &filled));
        assert_true(filled == length || filled == length + strlen(OWN) - strlen("\"own\""));
        free(text);
        arena_rewind(*state, mark);
    }
    memset(deep, '{', sizeof deep);
    assert_string_equal(api_material_wanted(deep, sizeof deep, *state), "");
}

/* By name or whole, in any unit, a request is the same; a stored surface whose unit is not known
 * yet keeps the document. */
static void test_material_whole_is_the_one_named(void **state) {
    static const char *const requests[] = {
        "{\"surface\":" PATCH ",\"length_unit\":\"mm\",\"method\":\"mosaic\",\"fabric\":{"
        "\"spacing\":0.1,\"material\":\"own\"}}",
        "{\"surface\":" PATCH ",\"length_unit\":\"mm\",\"method\":\"mosaic\",\"fabric\":{"
        "\"spacing\":0.1,\"thickness\":0.3,\"fiber_volume_fraction\":0.5,"
        "\"locking_angle_deg\":40},\"permeability\":{\"model\":\"gebart\",\"fiber_radius\":4e-6,"
        "\"packing\":\"hexagonal\"}}"};
    char digest[2][API_ID_SIZE];
    for (int k = 0; k < 2; k++) {
        const char *text = fill(requests[k], *state);
        const struct api_input input = {.request = text, .request_length = strlen(text)};
        struct api_problem problem = {0};
        struct api_request request;
        assert_int_equal(api_decode(&input, &api_limits_default, *state, &request, &problem),
                         API_OK);
        assert_true(api_digest_request(&request, *state, digest[k]));
    }
    assert_string_equal(digest[0], digest[1]);
    const char *stored = fill("{\"surface\":{\"id\":\"0123456789abcdef0123456789abcdef\"},"
                              "\"fabric\":{\"spacing\":0.1,\"material\":\"own\"}}",
                              *state);
    const struct api_input input = {.request = stored, .request_length = strlen(stored)};
    struct api_problem problem = {0};
    struct api_request request;
    assert_int_equal(api_decode(&input, &api_limits_default, *state, &request, &problem), API_OK);
    assert_non_null(strstr(api_normalise(&request, NULL, *state), "\"material\":" OWN));
}

/* ---- what a checker does with them ---- */

static bool collect(void *context, const void *bytes, size_t length) {
    api_text_bytes(context, bytes, length);
    return true;
}

/* First the names, then the request with what they stand for; without memory a problem. */
static void test_material_check_asks_for_names_first(void **state) {
    static const char request[] = "{\"fabric\":{\"material\":\"own\"}}";
    struct api_text text = api_text_growing(*state);
    const struct api_sink sink = {.write = collect, .context = &text};
    for (int known = 0; known < 2; known++) {
        struct api_input input = {.request = request, .request_length = strlen(request)};
        struct api_check check = {0};
        struct api_problem problem = {0};
        assert_int_equal(api_check_mentions(&input, known ? OWN : NULL, known ? strlen(OWN) : 0,
                                            &sink, *state, &check, &problem),
                         API_OK);
        assert_int_equal(check.needs_materials, !known);
        assert_string_equal(api_text_finish(&text), "own\n");
        assert_int_equal(check.filled_length, known ? input.request_length : 0);
        assert_int_equal(strstr(input.request, OWN) != NULL, known);
    }
    for (int known = 0; known < 2; known++) {
        struct api_input input = {.request = request, .request_length = strlen(request)};
        struct api_check check = {0};
        struct api_problem problem = {0};
        struct arena *arena = arena_new(1 << 20);
        arena_fail_at(arena, 1);
        assert_int_equal(api_check_mentions(&input, known ? OWN : NULL, known ? strlen(OWN) : 0,
                                            &sink, arena, &check, &problem),
                         API_OUT_OF_MEMORY);
        arena_free(arena);
    }
}

/* Every allocation of reading one failed in turn. */
static void test_material_survives_failed_allocations(void **state) {
    (void)state;
    enum api_problem_id id = API_OUT_OF_MEMORY;
    size_t n = 1;
    for (; id == API_OUT_OF_MEMORY && n < 1000; n++) {
        struct arena *arena = arena_new(1 << 24);
        struct api_material material;
        struct api_problem problem;
        const char *head;
        arena_fail_at(arena, n);
        id = decode(OWN, arena, &material, &head, &problem);
        arena_free(arena);
    }
    assert_int_equal(id, API_OK);
    assert_true(n > 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_material_is_written_as_it_is_read, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_material_names_what_is_wrong, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_material_is_put_where_a_fabric_names_it, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_material_is_wanted_once_and_not_of_the_library, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_material_looks_at_no_more_than_the_text, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(test_material_whole_is_the_one_named, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_material_check_asks_for_names_first, set_up,
                                        tear_down),
        cmocka_unit_test(test_material_survives_failed_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
