/* SPDX-License-Identifier: MIT */
/* What a service keeps of a laminate: what a check writes is what it says, and what is drawn from a
 * record and from results is what is drawn from the laminate itself. */
#include "api/laminate/account.h"
#include "api/laminate/check.h"
#include "api/laminate/courses.h"
#include "api/laminate/map.h"
#include "api/laminate/patterns.h"
#include "api/laminate/run.h"
#include "support.h"
#include "tests/check.h"
#include <stdio.h>
#include <string.h>

enum { NETS_MAX = 4 };

/* Two plies of which the last is as the first and shares its drape, and one of three pieces. */
static const char plies[] =
    "[{\"name\":\"skin\",\"repeat\":2,\"fabric\":{\"spacing\":0.5,\"thickness\":0.001}},"
    "{\"name\":\"thirds\",\"fabric\":{\"spacing\":0.5,\"thickness\":0.001},\"splits\":["
    "{\"path\":[[-1,-2,-1.5],[-1,-1,0],[-1,0,0.5],[-1,1,0],[-1,2,-1.5]]},"
    "{\"path\":[[1,-2,-1.5],[1,-1,0],[1,0,0.5],[1,1,0],[1,2,-1.5]]}]},"
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
    assert_int_equal(s->laminate.net_count, 4);
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
    assert_int_equal(count, 4);
    for (size_t n = 0; n < count; n++) {
        char digest[API_ID_SIZE] = "";
        assert_int_equal(sscanf(at, "%32s %zu%n", digest, &lengths[n], &used), 2);
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
    static const char lines[] = "0 skin\n1 thirds\tpiece_1\n2 \tpiece_2\n3 \tpiece_3\n0 again\n\n";
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

/* A laminate of these plies on the saddle, decoded and resolved in the arena. */
static enum api_problem_id resolve_plies(const char *list, struct bytes *text, struct arena *arena,
                                         struct laminate *laminate, struct api_problem *problem) {
    *problem = (struct api_problem){.id = API_OK};
    text->length = 0;
    bytes_format(text, "{\"surface\":%s,\"plies\":%s}", request_text("saddle_surface"), list);
    const struct api_input input = {.request = text->data, .request_length = text->length};
    if (laminate_decode(&input, &api_limits_default, arena, laminate, problem) != API_OK)
        return problem->id;
    return laminate_resolve(laminate, &api_limits_default, arena, problem);
}

/* What a drape cannot be is said of its ply, by the check or when it is draped. */
static void test_laminate_faults_are_of_their_ply(void **state) {
    static const char fine[] = "[{\"fabric\":{\"spacing\":0.5}},{\"fabric\":{\"spacing\":1e-6}}]";
    static const char far[] = "[{\"fabric\":{\"spacing\":0.5}},"
                              "{\"fabric\":{\"spacing\":0.6},\"start\":{\"point\":[9,9,9]}}]";
    struct stored *s = *state;
    struct bytes text = {0}, result = {0};
    struct laminate laminate;
    struct api_problem problem;
    const struct api_sink sink = sink_into(&result);
    assert_int_equal(resolve_plies(fine, &text, s->arena, &laminate, &problem), API_OK);
    assert_int_not_equal(laminate_check_drapes(&laminate, &api_limits_default, s->arena, &problem),
                         API_OK);
    assert_memory_equal(problem.error[0].pointer, "/plies/1/", 9);
    assert_int_equal(resolve_plies(far, &text, s->arena, &laminate, &problem), API_OK);
    const struct api_input input = {.request = text.data, .request_length = text.length};
    assert_int_equal(laminate_run(&laminate, 0, &input, &api_limits_default, NULL, &sink, &problem),
                     API_OK);
    assert_int_equal(problem.count, 0);
    assert_int_equal(laminate_run(&laminate, 1, &input, &api_limits_default, NULL, &sink, &problem),
                     API_START_OFF_SURFACE);
    assert_string_equal(problem.error[0].pointer, "/plies/1/start");
    bytes_free(&text);
    bytes_free(&result);
}

/* What was understood is understood as the same: a piece without the cuts of its ply, and the
 * courses of a drape. */
static void test_laminate_is_understood_as_the_same(void **state) {
    static const char cut[] = "[{\"fabric\":{\"spacing\":0.5},\"splits\":[{\"path\":"
                              "[[0,-2,-2],[0,-1,-0.5],[0,0,0],[0,1,-0.5],[0,2,-2]]}],"
                              "\"cuts\":[{\"path\":[[2,0,2],[1.5,0,1.125],[1,0,0.5]]}],"
                              "\"pieces\":[{\"at\":[-1,0,0.5],\"cuts\":[]}]}]";
    static const double widths[] = {1, 0.75}, gap[] = {0.125};
    static const struct courses_offset gaps[] = {{gap, 1}};
    const struct courses_settings lay = {
        .widths = widths, .width_count = 2, .gaps = gaps, .gap_count = 1, .both = true};
    struct stored *s = *state;
    struct bytes text = {0};
    struct laminate laminate, again;
    struct api_request drape;
    struct api_problem problem = {.id = API_OK};
    assert_int_equal(resolve_plies(cut, &text, s->arena, &laminate, &problem), API_OK);
    const char *document = laminate_normalise(&laminate, s->arena);
    assert_non_null(strstr(document, "\"cuts\":[]"));
    struct api_input input = {.request = document, .request_length = strlen(document)};
    assert_int_equal(laminate_decode(&input, &api_limits_default, s->arena, &again, &problem),
                     API_OK);
    assert_int_equal(laminate_resolve(&again, &api_limits_default, s->arena, &problem), API_OK);
    assert_string_equal(laminate_normalise(&again, s->arena), document);

    assert_int_equal(decode_text(request_text("saddle"), s->arena, &drape, &problem), API_OK);
    document = courses_document(&drape, &lay, s->arena);
    input = (struct api_input){.request = document, .request_length = strlen(document)};
    assert_int_equal(laminate_decode(&input, &api_limits_default, s->arena, &again, &problem),
                     API_OK);
    assert_int_equal(again.count, 1);
    assert_int_equal(again.side, 1);
    assert_int_equal(again.plies[0].repeat, 1);
    assert_string_equal(again.plies[0].name, "ply_1");
    assert_true(again.plies[0].drape.settings.spacing[0] == 0.5);
    const struct courses_settings *found = &again.plies[0].pieces->courses->lay;
    assert_int_equal(found->width_count, 2);
    assert_memory_equal(found->widths, widths, sizeof widths);
    assert_int_equal(found->gap_count, 1);
    assert_true(found->gaps[0].count == 1 && found->gaps[0].values[0] == 0.125);
    assert_true(found->both && found->along == COURSES_ALONG_DIRECTION);
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
    static const char *const formats[] = {"json", "svg"};
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

/* Of every ply its pieces, and the seams between those that meet. */
static void test_laminate_account_has_every_seam(void **state) {
    struct stored *s = *state;
    struct bytes drawn = {0};
    struct api_problem problem;
    size_t seams = 0;
    assert_int_equal(draw_record(s, s->columns.length, "json", "", 0, &drawn, &problem), API_OK);
    for (const char *at = drawn.data; (at = strstr(at, "{\"pieces\":[\"piece_")); at++)
        seams++;
    assert_int_equal(seams, 2);
    assert_non_null(strstr(drawn.data, "\"seams\":[{\"pieces\":["));
    bytes_free(&drawn);
}

/* On a triangle in the middle of the part: from the record as from the laminate, and with the names
 * of plies made different. */
static void test_laminate_record_maps_what_the_laminate_does(void **state) {
    static const struct vec3 corners[] = {{0.2, 0.1, 0}, {0.3, 0.1, 0}, {0.2, 0.2, 0}};
    static const int32_t elements[][4] = {{0, 1, 2, -1}};
    static const char same[] = "[{\"name\":\"a\",\"fabric\":{\"spacing\":0.5,\"thickness\":0.001}},"
                               "{\"name\":\"b\",\"fabric\":{\"spacing\":0.5,\"thickness\":0.001}},"
                               "{\"name\":\"b\",\"fabric\":{\"spacing\":0.5,\"thickness\":0.001}}]";
    static const char *const names[] = {"skin", "thirds, piece_1", "thirds, piece_2",
                                        "thirds, piece_3", "again"};
    static const char *const made[] = {"a", "b", "b_3"};
    const struct map_target target = {
        .vertices = corners, .vertex_count = 3, .elements = elements, .element_count = 1};
    struct stored *s = *state;
    struct api_problem problem = {.id = API_OK};
    struct api_map *map = arena_alloc(s->arena, 1, sizeof *map);
    struct bytes text = {0};
    struct laminate laminate;
    assert_int_equal(laminate_map_record(s->record, strlen(s->record), s->columns.data,
                                         s->columns.length, &api_limits_default, &target, NULL,
                                         s->arena, map, &problem),
                     API_OK);
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        assert_string_equal(map->fields.plies->names[k], names[k]);
    assert_string_equal(map->fields.revision, s->laminate.revision);
    assert_int_equal(resolve_plies(same, &text, s->arena, &laminate, &problem), API_OK);
    assert_int_equal(laminate.net_count, 1);
    assert_int_equal(laminate_map(&laminate, s->nets, &target, NULL, s->arena, map, &problem),
                     API_OK);
    for (size_t k = 0; k < sizeof made / sizeof *made; k++)
        assert_string_equal(map->fields.plies->names[k], made[k]);
    bytes_free(&text);
}

/* However late memory ends, that is what is said, of a map and of patterns. */
static void test_laminate_without_memory_is_a_problem(void **state) {
    static const struct vec3 corners[] = {{0.2, 0.1, 0}, {0.3, 0.1, 0}, {0.2, 0.2, 0}};
    static const int32_t elements[][4] = {{0, 1, 2, -1}};
    static uint8_t roles[] = {MAP_INLET};
    const struct map_target target = {.vertices = corners,
                                      .vertex_count = 3,
                                      .elements = elements,
                                      .element_count = 1,
                                      .roles = roles};
    const struct laminate_roll roll = {.width = 9, .gap = 0.25};
    struct stored *s = *state;
    struct api_map *map = arena_alloc(s->arena, 1, sizeof *map);
    for (int drawn = 0; drawn < 2; drawn++) {
        enum api_problem_id id = API_OUT_OF_MEMORY;
        size_t n = 0;
        while (id == API_OUT_OF_MEMORY) {
            struct api_problem problem = {.id = API_OK};
            struct bytes text = {0};
            const struct api_sink sink = sink_into(&text);
            struct arena *arena = arena_new((size_t)1 << 30);
            arena_fail_at(arena, n += 1 + n / 6); /* not all: there are hundreds */
            id = drawn ? laminate_patterns(&s->laminate, s->nets, LAMINATE_ALL, "svg", &roll, &sink,
                                           arena, &problem)
                       : laminate_map(&s->laminate, s->nets, &target, NULL, arena, map, &problem);
            assert_int_equal(id, problem.id);
            arena_free(arena);
            bytes_free(&text);
        }
        assert_int_equal(id, API_OK);
        assert_true(n > 30);
    }
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
    for (size_t length = 0; length <= 5 * sizeof(uint64_t); length += sizeof(uint64_t))
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
        cmocka_unit_test(test_laminate_faults_are_of_their_ply),
        cmocka_unit_test(test_laminate_is_understood_as_the_same),
        cmocka_unit_test(test_laminate_record_draws_what_the_laminate_does),
        cmocka_unit_test(test_laminate_account_has_every_seam),
        cmocka_unit_test(test_laminate_record_maps_what_the_laminate_does),
        cmocka_unit_test(test_laminate_without_memory_is_a_problem),
        cmocka_unit_test(test_laminate_record_that_is_damaged_is_told),
    };
    return cmocka_run_group_tests(tests, make_stored, free_stored);
}
