/* SPDX-License-Identifier: MIT */
/*
 * Every request of bad_requests/ is refused as its .expect file says. Line 1 is the problem's slug,
 * each line after it the pointer of one error, in any order and all of them; the whole document,
 * whose pointer is empty, is written as #.
 */
#include "support.h"
#include "tests/check.h"

#include "api/request/decode.h"
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char folder[] = "tests/unit/bad_requests";

static int is_request(const struct dirent *entry) {
    size_t length = strlen(entry->d_name);
    return length > 5 && strcmp(entry->d_name + length - 5, ".json") == 0;
}

/* The problem as the lines of an .expect file, its pointers sorted. */
static struct bytes describe(const struct api_problem *problem) {
    struct bytes text = {0};
    const char *pointers[API_ERRORS_MAX];
    size_t count = problem->has_pointer ? problem->count : 0;
    for (size_t i = 0; i < count; i++) {
        const char *pointer = problem->error[i].pointer[0] ? problem->error[i].pointer : "#";
        size_t at = i;
        for (; at > 0 && strcmp(pointers[at - 1], pointer) > 0; at--)
            pointers[at] = pointers[at - 1];
        pointers[at] = pointer;
    }
    bytes_format(&text, "%s\n", api_problem_slug(problem->id));
    for (size_t i = 0; i < count; i++)
        bytes_format(&text, "%s\n", pointers[i]);
    return text;
}

/* The file's lines, those after the first sorted. */
static struct bytes sort_expectation(const struct bytes *file) {
    struct api_problem problem = {.has_pointer = true};
    char *copy = strdup(file->data), *rest = NULL;
    assert_non_null(copy);
    problem.id = api_problem_from_slug(strtok_r(copy, "\n", &rest));
    for (char *line; (line = strtok_r(NULL, "\n", &rest)) && problem.count < API_ERRORS_MAX;)
        snprintf(problem.error[problem.count++].pointer, API_POINTER_MAX, "%s", line);
    free(copy);
    return describe(&problem);
}

static bool check(const char *name) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    struct bytes request = file_read(path);
    memcpy(strrchr(path, '.'), ".expect", sizeof ".expect");
    struct bytes file = file_read(path), expected = sort_expectation(&file);
    struct arena *arena = arena_new((size_t)1 << 26);
    struct api_request decoded;
    struct api_problem problem = {0};
    const struct api_input input = {.request = request.data, .request_length = request.length};
    enum api_problem_id id = api_decode(&input, &api_limits_default, arena, &decoded, &problem);
    struct bytes found = describe(&problem);
    bool ok = id == problem.id && strcmp(found.data, expected.data) == 0;
    for (size_t i = 0; i < problem.count; i++)
        ok = ok && problem.error[i].detail[0];
    if (!ok)
        print_error("%s: expected\n%sfound\n%s", name, expected.data, found.data);
    arena_free(arena);
    bytes_free(&request);
    bytes_free(&file);
    bytes_free(&expected);
    bytes_free(&found);
    return ok;
}

static void test_decode_refuses_bad_requests_at_their_places(void **state) {
    (void)state;
    struct dirent **entries;
    int count = scandir(folder, &entries, is_request, alphasort), failures = 0;
    check_at_least(count, 45);
    for (int i = 0; i < count; i++) {
        failures += !check(entries[i]->d_name);
        free(entries[i]);
    }
    free(entries);
    printf("%d bad requests\n", count);
    assert_int_equal(failures, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_decode_refuses_bad_requests_at_their_places),
    };
    prepare();
    return cmocka_run_group_tests_name("bad_requests", tests, NULL, NULL);
}
