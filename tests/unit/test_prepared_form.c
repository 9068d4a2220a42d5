/* SPDX-License-Identifier: MIT */
/* A drape of a prepared form has the bits of one of the definition, and bytes that are no sound
 * form are never taken for one. */
#include "api/check.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/prepared_form.h"
#include "solver/drape.h"
#include "support.h"
#include "tests/check.h"
#include <glob.h>
#include <jansson.h>
#include <malloc.h>
#include <string.h>

/* What is freed is overwritten: a pointer that was left behind in a form leads to nothing. */
enum { FREED = 0xa5 };

static int setup(void **state) {
    (void)state;
    mallopt(M_PERTURB, FREED);
    prepare();
    return 0;
}

/* What a run came to: its problem, or its container. */
struct outcome {
    struct api_problem problem;
    struct bytes container;
};

static struct outcome outcome_of(const struct api_input *input) {
    struct outcome outcome = {.problem = {.id = API_OK}};
    struct api_sink sink = sink_into(&outcome.container);
    (void)!api_run(input, &api_limits_default, NULL, &sink, &outcome.problem);
    return outcome;
}

static void assert_same_warnings(const struct api_warnings *one, const struct api_warnings *other) {
    assert_int_equal(one->count, other->count);
    for (size_t k = 0; k < one->count; k++)
        assert_string_equal(one->list[k].detail, other->list[k].detail);
}

/* Its columns and, in the header, its warnings. */
static const char *columns_of(struct outcome *outcome, struct api_columns *header, size_t *length) {
    const struct api_reader reader = reader_over(&outcome->container);
    struct api_problem problem;
    assert_int_equal(api_columns_open(&reader, header, &problem), API_OK);
    size_t from = (size_t)header->column[0].offset;
    *length = outcome->container.length - from;
    return outcome->container.data + from;
}

/* The run of this input comes to the same: the same problem, or the same columns and warnings. What
 * the header says of time is another. */
static void assert_comes_to(struct outcome *wanted, const struct api_input *input) {
    struct outcome got = outcome_of(input);
    assert_int_equal(got.problem.id, wanted->problem.id);
    if (got.problem.id == API_OK) {
        struct api_columns header[2];
        size_t length[2];
        const char *columns = columns_of(&got, &header[0], &length[0]);
        const char *others = columns_of(wanted, &header[1], &length[1]);
        assert_same_warnings(&header[0].summary.warnings, &header[1].summary.warnings);
        assert_int_equal(length[0], length[1]);
        assert_memory_equal(columns, others, length[0]);
    } else {
        assert_string_equal(got.problem.error[0].detail, wanted->problem.error[0].detail);
    }
    bytes_free(&got.container);
}

static void assert_same_results(const struct api_input *one, const struct api_input *other) {
    struct outcome wanted = outcome_of(one);
    assert_comes_to(&wanted, other);
    bytes_free(&wanted.container);
}

static struct api_input input_of(const char *request, const struct bytes *surface,
                                 const struct bytes *form) {
    return (struct api_input){.request = request,
                              .request_length = strlen(request),
                              .surface = surface ? surface->data : NULL,
                              .surface_length = surface ? surface->length : 0,
                              .form = form ? form->data : NULL,
                              .form_length = form ? form->length : 0};
}

/* The form of a request as a whole. */
static struct bytes form_of_request(const char *text) {
    struct arena *arena = arena_new((size_t)1 << 30);
    const struct api_input input = input_of(text, NULL, NULL);
    struct api_problem problem = {0};
    struct api_request request;
    struct prepared_part part;
    struct bytes form = {0};
    const struct api_sink sink = sink_into(&form);
    char source[API_ID_SIZE];
    arena_clear(arena);
    api_digest_bytes(text, strlen(text), source);
    if (api_decode(&input, &api_limits_default, arena, &request, &problem) == API_OK &&
        prepared_part_make(&request, &api_limits_default, arena, &part, &problem) == API_OK) {
        size_t written = prepared_form_write(&request, &part, source, arena, &sink);
        assert_int_equal(written, form.length);
        check_above(written, 0);
        /* only what is reached, not what its making left behind */
        assert_true(2 * form.length < arena_held(arena));
    }
    arena_free(arena);
    return form;
}

/* A surface as it is stored. */
struct stored {
    char id[API_ID_SIZE];
    struct bytes definition, form;
};

static bool store(const json_t *surface, struct stored *stored) {
    char *text = json_dumps(surface, 0);
    const struct api_input input = input_of(text, NULL, NULL);
    struct api_check check;
    struct api_problem problem = {0};
    *stored = (struct stored){0};
    const struct api_sink sink = sink_into(&stored->definition), forms = sink_into(&stored->form);
    bool good =
        api_check_surface(&input, &api_limits_default, &sink, &forms, &check, &problem) == API_OK;
    memcpy(stored->id, check.surface, API_ID_SIZE);
    stored->definition.length = check.definition_length;
    assert_int_equal(stored->form.length, check.form_length);
    free(text);
    return good;
}

static void stored_free(struct stored *stored) {
    bytes_free(&stored->definition);
    bytes_free(&stored->form);
}

/* The request with {"id": ...} and more in the place of its surface, and of its offset. */
static char *naming(const json_t *request, const struct stored *stored, const char *more,
                    double offset) {
    json_t *named = json_deep_copy(request);
    json_t *choice = json_loads(more, 0, NULL);
    json_object_set_new(choice, "id", json_string(stored->id));
    json_object_set_new(named, "surface", choice);
    if (offset != 0)
        json_object_set_new(named, "offset", json_real(offset));
    char *text = json_dumps(named, 0);
    json_decref(named);
    return text;
}

/* A request on the stored surface: by its definition, by its form, by the form that the check of
 * either makes, and by a form of another choice. */
static void check_named(const char *text, const struct stored *stored) {
    const struct api_input by_text = input_of(text, &stored->definition, NULL);
    struct api_input by_form = input_of(text, NULL, &stored->form);
    struct api_problem problem[2] = {{.id = API_OK}, {.id = API_OK}};
    struct api_check check[2];
    struct bytes made[2] = {{0}, {0}};
    const struct api_sink sinks[2] = {sink_into(&made[0]), sink_into(&made[1])};
    struct outcome wanted = outcome_of(&by_text);
    assert_comes_to(&wanted, &by_form);
    (void)!api_check_drape(&by_text, &api_limits_default, &sinks[0], &check[0], &problem[0]);
    (void)!api_check_drape(&by_form, &api_limits_default, &sinks[1], &check[1], &problem[1]);
    assert_int_equal(problem[0].id, problem[1].id);
    assert_string_equal(check[0].digest, check[1].digest);
    assert_false(check[1].form_renewed);
    if (problem[0].id == API_OK)
        assert_true(check[0].form_renewed);
    for (int k = 0; k < 2 && problem[0].id == API_OK; k++) {
        const struct api_input again = input_of(text, NULL, &made[k]);
        if (made[k].length > 0)
            assert_comes_to(&wanted, &again);
    }
    bytes_free(&wanted.container);
    bytes_free(&made[0]);
    bytes_free(&made[1]);
}

/* In short runs with a part of the choices, other ones with the next file. */
static void check_file(const char *path, size_t number) {
    const int step = check_stride(3);
    struct bytes file = file_read(path);
    json_t *request = json_loadb(file.data, file.length, 0, NULL);
    struct bytes form = form_of_request(file.data);
    struct stored stored;
    const struct api_input plain = input_of(file.data, NULL, NULL);
    const struct api_input prepared = input_of(file.data, NULL, &form);
    assert_same_results(&plain, &prepared);
    printf("%-48s %8zu bytes, form %9zu\n", path, file.length, form.length);
    json_t *surface = json_object_get(request, "surface");
    if (store(surface, &stored)) {
        bool faces = json_object_get(surface, "faces") || json_object_get(surface, "vertices");
        const char *const choices[] = {"{}", "{\"faces\":[0]}", "{\"grow_from\":1}",
                                       "{\"grow_from\":{\"point\":[1,2,3]}}"};
        for (int k = (int)(number % (size_t)step); k < (faces ? 8 : 2); k += step) {
            char *text = naming(request, &stored, choices[k / 2], k % 2 * 1e-3);
            check_named(text, &stored);
            free(text);
        }
    }
    stored_free(&stored);
    bytes_free(&form);
    bytes_free(&file);
    json_decref(request);
}

static void test_prepared_forms_give_the_same_bits(void **state) {
    (void)state;
    static const char *const patterns[] = {"api/examples/*.json", "tests/requests/*.json"};
    glob_t files = {0};
    size_t seen = 0;
    for (int k = 0; k < 2; k++)
        assert_int_equal(glob(patterns[k], k ? GLOB_APPEND : 0, NULL, &files), 0);
    for (size_t k = 0; k < files.gl_pathc; k++, seen++)
        check_file(files.gl_pathv[k], k);
    globfree(&files);
    check_above((double)seen, 20);
}

/* What else a request points to: cuts with their names, curves, tables. */
static void test_prepared_forms_keep_the_whole_request(void **state) {
    (void)state;
    static const char *const members[] = {
        "\"cuts\":[{\"name\":\"dart\",\"path\":[[2,0.3,1.955],[1.1,0.3,0.56]]}]",
        "\"start\":{\"uv\":[0.5,0.5]},\"generators\":{\"warp\":{\"uv\":[[0,0.5],[1,0.5]]}}",
        "\"permeability\":{\"model\":\"table\",\"shear_deg\":[0,40],\"k1\":[1e-10,2e-10],"
        "\"k2\":[1e-10,1e-10],\"k3\":[1e-11,1e-11]}"};
    for (size_t k = 0; k < sizeof members / sizeof *members; k++) {
        struct bytes text = {0};
        bytes_format(&text, "{%s,%s", members[k], request_text("saddle") + 1);
        struct bytes form = form_of_request(text.data);
        const struct api_input plain = input_of(text.data, NULL, NULL);
        const struct api_input prepared = input_of(text.data, NULL, &form);
        check_above(form.length, 0);
        assert_same_results(&plain, &prepared);
        bytes_free(&form);
        bytes_free(&text);
    }
}

/* How a part bends follows from its faces alone: who has the form does not look for it again. */
static void test_prepared_forms_know_how_the_part_bends(void **state) {
    (void)state;
    static const char *const requests[] = {"saddle", "trimmed"};
    for (size_t k = 0; k < sizeof requests / sizeof *requests; k++) {
        const char *text = request_text(requests[k]);
        struct bytes form = form_of_request(text);
        const struct api_input input = {.form = form.data, .form_length = form.length};
        struct arena *arena = arena_new((size_t)1 << 28);
        struct surface_bends bends;
        char source[API_ID_SIZE];
        api_digest_bytes(text, strlen(text), source);
        const struct prepared_form *opened = prepared_form_find(&input, source, arena);
        assert_non_null(opened);
        drape_find_bends(&opened->part.part, &bends);
        check_above(bends.least_radius, 0);
        assert_memory_equal(&opened->part.bends.least_radius, &bends.least_radius, sizeof(double));
        assert_int_equal(opened->part.bends.turns_back, bends.turns_back);
        arena_free(arena);
        bytes_free(&form);
    }
}

/* A square tube of four faces: its drapes need not make the mesh by which it is cut open. */
static void test_prepared_forms_have_the_mesh_of_a_tube(void **state) {
    (void)state;
    static const double corner[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    struct bytes text = {0};
    bytes_format(&text, "%s", "{\"fabric\":{\"spacing\":0.2},\"surface\":{\"faces\":[");
    for (int k = 0; k < 4; k++) {
        const double *a = corner[k], *b = corner[k + 1];
        bytes_format(&text,
                     "%s{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,"
                     "\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],\"control_points\":"
                     "[[%g,%g,0],[%g,%g,3],[%g,%g,0],[%g,%g,3]]}",
                     k ? "," : "", a[0], a[1], a[0], a[1], b[0], b[1], b[0], b[1]);
    }
    bytes_format(&text, "%s", "]}}");
    struct bytes form = form_of_request(text.data);
    const struct api_input plain = input_of(text.data, NULL, NULL);
    const struct api_input prepared = input_of(text.data, NULL, &form);
    struct arena *arena = arena_new((size_t)1 << 28);
    struct api_problem problem = {0};
    struct api_request request;
    struct prepared_part part;
    assert_int_equal(api_decode(&prepared, &api_limits_default, arena, &request, &problem), API_OK);
    assert_int_equal(prepared_part_make(&request, &api_limits_default, arena, &part, &problem),
                     API_OK);
    assert_int_equal(prepared_part_settle(&part, arena, &request.settings, &problem), API_OK);
    assert_non_null(request.settings.prepared);
    assert_same_results(&plain, &prepared);
    arena_free(arena);
    bytes_free(&form);
    bytes_free(&text);
}

/* Texts are kept to their ends, however long. */
static void test_prepared_forms_keep_long_names(void **state) {
    (void)state;
    enum { LONG = 200 };
    char name[LONG + 1], source[API_ID_SIZE];
    memset(name, 'n', LONG);
    name[LONG] = '\0';
    struct bytes file = file_read("tests/requests/swept_in_faces.json");
    json_t *request = json_loadb(file.data, file.length, 0, NULL);
    json_t *faces = json_object_get(json_object_get(request, "surface"), "faces");
    json_object_set_new(json_array_get(faces, 1), "name", json_string(name));
    char *text = json_dumps(request, 0);
    struct bytes form = form_of_request(text);
    struct arena *arena = arena_new((size_t)1 << 28);
    api_digest_bytes(text, strlen(text), source);
    const struct prepared_form *opened = prepared_form_open(form.data, form.length, source, arena);
    assert_non_null(opened);
    assert_string_equal(opened->request.surface.faces[1].face_name, name);
    arena_free(arena);
    bytes_free(&form);
    bytes_free(&file);
    free(text);
    json_decref(request);
}

/* A tent of triangles, two faces with a trim, and a patch. */
static const char *const small[] = {"tent", "trimmed", "saddle", "fibres"};
enum { SMALL = sizeof small / sizeof *small };

static void test_prepared_forms_of_a_changed_bit_are_none(void **state) {
    (void)state;
    for (size_t n = 0; n < SMALL; n++) {
        const char *text = request_text(small[n]);
        struct bytes form = form_of_request(text);
        const struct api_input plain = input_of(text, NULL, NULL);
        struct api_input damaged = input_of(text, NULL, &form);
        char source[API_ID_SIZE];
        api_digest_bytes(text, strlen(text), source);
        assert_true(prepared_form_sound(form.data, form.length, source));
        size_t step = form.length / 997 + 1; /* a prime number of places, all in the head */
        for (size_t at = 0; at < form.length; at += at < 256 ? 1 : step)
            for (int bit = 0; bit < 8; bit++) {
                form.data[at] = (char)(form.data[at] ^ 1 << bit);
                if (prepared_form_sound(form.data, form.length, source))
                    fail_msg("bit %d of byte %zu may change", bit, at);
                if (at % 499 == 0 && bit == 3)
                    assert_same_results(&plain, &damaged);
                form.data[at] = (char)(form.data[at] ^ 1 << bit);
            }
        for (size_t length = 0; length < form.length; length += form.length / 99 + 1) {
            assert_false(prepared_form_sound(form.data, length, source));
            damaged.form_length = length;
            assert_same_results(&plain, &damaged);
        }
        bytes_free(&form);
    }
}

/* One of another document is as none. */
static void test_prepared_forms_of_another_source_are_none(void **state) {
    (void)state;
    struct bytes form = form_of_request(request_text("saddle"));
    for (size_t n = 0; n < SMALL; n++) {
        const char *text = request_text(small[n]);
        const struct api_input plain = input_of(text, NULL, NULL);
        const struct api_input other = input_of(text, NULL, &form);
        char source[API_ID_SIZE];
        api_digest_bytes(text, strlen(text), source);
        assert_int_equal(prepared_form_sound(form.data, form.length, source),
                         !strcmp(small[n], "saddle"));
        assert_same_results(&plain, &other);
    }
    bytes_free(&form);
}

/* Forms are opened, and made, with the n-th allocation failing: then there is none. */
static void test_prepared_forms_without_memory_are_none(void **state) {
    (void)state;
    for (size_t k = 0; k < SMALL; k++) {
        const char *text = request_text(small[k]);
        struct bytes form = form_of_request(text);
        char source[API_ID_SIZE];
        api_digest_bytes(text, strlen(text), source);
        check_above(form.length, 0);
        const struct prepared_form *opened = NULL;
        size_t n = 0;
        while (!opened) {
            struct arena *arena = arena_new((size_t)1 << 28);
            arena_fail_at(arena, ++n);
            opened = prepared_form_open(form.data, form.length, source, arena);
            arena_free(arena);
        }
        check_above((double)n, 1);
        bytes_free(&form);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_prepared_forms_give_the_same_bits),
        cmocka_unit_test(test_prepared_forms_keep_the_whole_request),
        cmocka_unit_test(test_prepared_forms_know_how_the_part_bends),
        cmocka_unit_test(test_prepared_forms_have_the_mesh_of_a_tube),
        cmocka_unit_test(test_prepared_forms_keep_long_names),
        cmocka_unit_test(test_prepared_forms_of_a_changed_bit_are_none),
        cmocka_unit_test(test_prepared_forms_of_another_source_are_none),
        cmocka_unit_test(test_prepared_forms_without_memory_are_none),
    };
    return cmocka_run_group_tests(tests, setup, NULL);
}
