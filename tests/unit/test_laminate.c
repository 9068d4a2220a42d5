/* SPDX-License-Identifier: MIT */
/* What a service keeps of a laminate: what a check writes is what it says, and what is drawn from a
 * record and from results is what is drawn from the laminate itself. */
#include "api/laminate/account.h"
#include "api/laminate/check.h"
#include "api/laminate/patterns.h"
#include "api/laminate/run.h"
#include "support.h"
#include "tests/check.h"
#include <stdio.h>
#include <string.h>

enum { NETS_MAX = 4 };

/* Two plies of which the last is as the first and shares its drape, and one of two pieces. */
static const char plies[] =
    "[{\"name\":\"skin\",\"repeat\":2,\"fabric\":{\"spacing\":0.5,\"thickness\":0.001}},"
    "{\"name\":\"halves\",\"fabric\":{\"spacing\":0.5,\"thickness\":0.001},\"splits\":[{\"path\":"
    "[[0,-2,-2],[0,-1,-0.5],[0,0,0],[0,1,-0.5],[0,2,-2]]}]},"
    "{\"name\":\"again\",\"fabric\":{\"spacing\":0.5,\"thickness\":0.001}}]";

/* A laminate, what a check has written of it, and the results of its drapes. */
struct stored {
    struct arena *arena;
    struct bytes text, written, results[NETS_MAX], columns;
    struct laminate laminate;
    struct api_reader readers[NETS_MAX];
    const struct api_reader *nets[NETS_MAX];
    struct api_check check;
    const char *record; /* at the end of what was written */
};

/* All results behind their number and their lengths; that of `left_out` is lacking. */
static void put_columns(struct stored *s, size_t left_out) {
    uint64_t count = s->laminate.net_count;
    s->columns.length = 0;
    bytes_add(&s->columns, &count, sizeof count);
    for (size_t n = 0; n < count; n++) {
        uint64_t length = n == left_out ? 0 : s->results[n].length;
        bytes_add(&s->columns, &length, sizeof length);
        s->nets[n] = n == left_out ? NULL : &s->readers[n];
    }
    for (size_t n = 0; n < count; n++)
        if (n != left_out)
            bytes_add(&s->columns, s->results[n].data, s->results[n].length);
}

static int make_stored(void **state) {
    static struct stored stored;
    struct stored *s = *state = &stored;
    struct api_problem problem = {.id = API_OK};
    prepare();
    s->arena = arena_new((size_t)1 << 30);
    bytes_format(&s->text, "{\"surface\":%s,\"plies\":%s}", request_text("saddle_surface"), plies);
    const struct api_input input = {.request = s->text.data, .request_length = s->text.length};
    const struct api_sink sink = sink_into(&s->written);
    assert_int_equal(laminate_check(&input, &api_limits_default, &sink, &s->check, &problem),
                     API_OK);
    assert_int_equal(laminate_decode(&input, &api_limits_default, s->arena, &s->laminate, &problem),
                     API_OK);
    assert_int_equal(laminate_resolve(&s->laminate, &api_limits_default, s->arena, &problem),
                     API_OK);
    assert_int_equal(s->laminate.net_count, 3);
    for (size_t n = 0; n < s->laminate.net_count; n++) {
        const struct api_sink into = sink_into(&s->results[n]);
        assert_int_equal(
            laminate_run(&s->laminate, n, &input, &api_limits_default, NULL, &into, &problem),
            API_OK);
        s->readers[n] = reader_over(&s->results[n]);
    }
    put_columns(s, SIZE_MAX);
    return 0;
}

static int free_stored(void **state) {
    struct stored *s = *state;
    for (size_t n = 0; n < NETS_MAX; n++)
        bytes_free(&s->results[n]);
    bytes_free(&s->text);
    bytes_free(&s->written);
    bytes_free(&s->columns);
    arena_free(s->arena);
    return 0;
}

/* ---- checking ---- */

/* A line of numbers, a line for each drape, an empty one, the requests, the record; and the record
 * a line for each ply and piece, an empty one, and the laminate, which when checked again gives the
 * same. */
static void test_laminate_check_writes_what_it_says(void **state) {
    struct stored *s = *state;
    size_t count = 0, record_length = 0, lengths[NETS_MAX];
    int used = 0;
    const char *at = s->written.data;
    assert_int_equal(sscanf(at, "%zu %zu%n", &count, &record_length, &used), 2);
    at += used;
    assert_int_equal(*at++, '\n');
    assert_int_equal(count, 3);
    for (size_t n = 0; n < count; n++) {
        char digest[API_ID_SIZE] = "";
        assert_int_equal(sscanf(at, "%64s %zu%n", digest, &lengths[n], &used), 2);
        assert_string_equal(digest, s->laminate.net_digest[n]);
        at += used;
        assert_int_equal(*at++, '\n');
    }
    assert_int_equal(*at++, '\n');
    for (size_t n = 0; n < count; n++) {
        const char *request = laminate_request(&s->laminate, n, s->arena);
        assert_int_equal(lengths[n], strlen(request));
        assert_memory_equal(at, request, lengths[n]);
        at += lengths[n];
    }
    static const char lines[] = "0 skin\n1 halves\tpiece_1\n2 \tpiece_2\n0 again\n\n";
    assert_int_equal(record_length, strlen(at));
    assert_memory_equal(at, lines, strlen(lines));
    s->record = at;
    assert_string_equal(s->check.digest, s->laminate.revision);
    assert_string_equal(s->check.surface, "");
    assert_false(s->check.needs_surface);

    struct bytes again = {0};
    struct api_check check;
    struct api_problem problem = {.id = API_OK};
    const char *document = at + strlen(lines);
    const struct api_input input = {.request = document, .request_length = strlen(document)};
    const struct api_sink sink = sink_into(&again);
    assert_int_equal(laminate_check(&input, &api_limits_default, &sink, &check, &problem), API_OK);
    assert_string_equal(again.data, s->written.data);
    bytes_free(&again);
}

/* A laminate that names a stored surface is known by that, and no more is checked. */
static void test_laminate_check_asks_for_its_surface(void **state) {
    static const char id[] = "0123456789abcdef0123456789abcdef";
    struct bytes text = {0}, written = {0};
    struct api_check check;
    struct api_problem problem = {.id = API_OK};
    (void)state;
    bytes_format(&text, "{\"surface\":{\"id\":\"%s\"},\"plies\":%s}", id, plies);
    const struct api_input input = {.request = text.data, .request_length = text.length};
    const struct api_sink sink = sink_into(&written);
    assert_int_equal(laminate_check(&input, &api_limits_default, &sink, &check, &problem), API_OK);
    assert_true(check.needs_surface);
    assert_string_equal(check.surface, id);
    assert_int_equal(written.length, 0);
    bytes_free(&text);
}

/* ---- drawing ---- */

/* From the record with these options, which are pairs of strings. */
static enum api_problem_id draw_record(const struct stored *s, size_t length, const char *format,
                                       const char *options, size_t options_length,
                                       struct bytes *drawn, struct api_problem *problem) {
    const struct api_sink sink = sink_into(drawn);
    struct arena *arena = arena_new((size_t)1 << 30);
    *problem = (struct api_problem){.id = API_OK};
    drawn->length = 0;
    (void)!laminate_pattern_record(s->record, strlen(s->record), s->columns.data, length,
                                   &api_limits_default, LAMINATE_ALL, format, options,
                                   options_length, &sink, arena, problem);
    arena_free(arena);
    return problem->id;
}

/* With all results, and without that of a piece, which is said; options take their place. */
static void test_laminate_record_draws_what_the_laminate_does(void **state) {
    static const char *const formats[] = {"json", "svg", "html", "laser-csv"};
    static const char options[] = "width\0"
                                  "9\0"
                                  "gap\0"
                                  "0.25\0"
                                  "partial\0"
                                  "1";
    struct stored *s = *state;
    for (size_t k = 0; k < 2 * sizeof formats / sizeof *formats; k++) {
        const char *format = formats[k / 2];
        struct laminate_roll roll = {.width = 9, .gap = 0.25, .partial = true};
        struct bytes direct = {0}, drawn = {0};
        struct api_problem problem = {.id = API_OK};
        const struct api_sink sink = sink_into(&direct);
        put_columns(s, k % 2 ? 2 : SIZE_MAX);
        assert_int_equal(
            draw_record(s, s->columns.length, format, options, sizeof options, &drawn, &problem),
            API_OK);
        assert_int_equal(laminate_patterns(&s->laminate, s->nets, LAMINATE_ALL, format, &roll,
                                           &sink, s->arena, &problem),
                         API_OK);
        assert_int_equal(drawn.length, direct.length);
        assert_memory_equal(drawn.data, direct.data, direct.length);
        if (k < 2)
            assert_int_equal(strstr(drawn.data, "its drape failed") != NULL, k % 2);
        bytes_free(&direct);
        bytes_free(&drawn);
    }
    put_columns(s, SIZE_MAX);
}

/* Results that end early or are of another number of drapes, options out of range, and a record
 * without a laminate are told. */
static void test_laminate_record_that_is_damaged_is_told(void **state) {
    struct stored *s = *state;
    struct bytes drawn = {0};
    struct api_problem problem;
    const size_t whole = s->columns.length;
    assert_int_equal(draw_record(s, whole, "json", "", 0, &drawn, &problem), API_OK);
    assert_int_equal(draw_record(s, whole - 1, "json", "", 0, &drawn, &problem), API_INTERNAL);
    for (size_t length = 0; length <= 4 * sizeof(uint64_t); length += sizeof(uint64_t))
        assert_int_equal(draw_record(s, length, "json", "", 0, &drawn, &problem), API_INTERNAL);
    s->columns.data[0]++;
    assert_int_equal(draw_record(s, whole, "json", "", 0, &drawn, &problem), API_INTERNAL);
    assert_non_null(strstr(problem.error[0].detail, "results of the laminate are damaged"));
    s->columns.data[0]--;
    assert_int_equal(draw_record(s, whole, "svg", "width\0-1", 9, &drawn, &problem),
                     API_INVALID_REQUEST);
    assert_int_equal(draw_record(s, whole, "svg", "colour\0red\0gap\0x", 17, &drawn, &problem),
                     API_INVALID_REQUEST);
    const char *record = s->record;
    s->record = "0 skin\n{}";
    assert_int_equal(draw_record(s, whole, "json", "", 0, &drawn, &problem), API_INTERNAL);
    assert_non_null(strstr(problem.error[0].detail, "stored laminate is damaged"));
    s->record = record;
    bytes_free(&drawn);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_laminate_check_writes_what_it_says),
        cmocka_unit_test(test_laminate_check_asks_for_its_surface),
        cmocka_unit_test(test_laminate_record_draws_what_the_laminate_does),
        cmocka_unit_test(test_laminate_record_that_is_damaged_is_told),
    };
    return cmocka_run_group_tests(tests, make_stored, free_stored);
}
