/* SPDX-License-Identifier: MIT */
/* The encoders take their memory from the C library: each of its allocations fails once, from it
 * on, in every format. Then there is no document, and under a sanitizer nothing is lost. */
#include "small.h"
#include "support.h"
#include "tests/check.h"

#include "api/format/format.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The library's own functions, behind those of the sanitizer where there is one. */
#ifdef __SANITIZE_ADDRESS__
#define OWN(name) __interceptor_##name
#else
#define OWN(name) __libc_##name
#endif
void *OWN(malloc)(size_t size);
void *OWN(calloc)(size_t count, size_t size);
void *OWN(realloc)(void *memory, size_t size);

static size_t fail_at; /* 0: none fails */
static size_t taken;

static bool fails(void) {
    return fail_at > 0 && ++taken >= fail_at;
}

void *malloc(size_t size) {
    return fails() ? NULL : OWN(malloc)(size);
}

void *calloc(size_t count, size_t size) {
    return fails() ? NULL : OWN(calloc)(count, size);
}

void *realloc(void *memory, size_t size) {
    return fails() ? NULL : OWN(realloc)(memory, size);
}

enum { DOCUMENT_MAX = 64 * 1024 };

/* A document, or what stood in its way. */
struct document {
    char bytes[DOCUMENT_MAX];
    ssize_t length; /* -1: none */
    enum api_problem_id problem;
};

static void read_document(const struct format *format, const struct format_source *source,
                          struct document *out) {
    struct api_problem problem = {0};
    struct encoder *encoder = encoder_new(format, source, &(struct format_options){0}, &problem);
    ssize_t length = encoder ? 0 : -1, more = encoder ? 1 : 0;
    while (more > 0) {
        more = encoder_read(encoder, out->bytes + length, DOCUMENT_MAX - (size_t)length);
        length = more < 0 ? -1 : length + more;
    }
    encoder_free(encoder);
    out->length = length;
    out->problem = problem.id;
}

/* Until none is left to fail; each time out-of-memory, or a stop in the middle. */
static void check_format(const struct format *format, const struct format_source *source,
                         size_t most) {
    static struct document sound, failing;
    size_t n = 0;
    read_document(format, source, &sound);
    check_above(sound.length, 0);
    do {
        taken = 0;
        fail_at = ++n;
        read_document(format, source, &failing);
        fail_at = 0;
        assert_true(failing.length == -1 || taken < n);
        assert_true(failing.problem == API_OK || failing.problem == API_OUT_OF_MEMORY);
    } while (taken >= n && n < most);
    if (n < most) {
        assert_int_equal(failing.length, sound.length);
        assert_memory_equal(failing.bytes, sound.bytes, (size_t)sound.length);
    }
    printf("  %-7s %zu allocations\n", format->name, n - 1);
}

/* Of HDF5's our own five, before its library's, which does not survive every allocation that fails
 * within it. It runs where a crash costs one call, and no more: in a checker, or in the command. */
static void check_formats(enum format_use use, const struct format_source *source) {
    const struct format *format;
    assert_non_null(format_at(use, 0));
    for (size_t k = 0; (format = format_at(use, k)); k++)
        check_format(format, source, strcmp(format->name, "lcmsim-h5") == 0 ? 5 : SIZE_MAX);
}

static void test_encode_memory_of_results(void **state) {
    struct bytes container = small_result();
    struct api_reader reader = reader_over(&container);
    const struct format_source source = {.id = "small", .reader = &reader};
    (void)state;
    check_formats(FORMAT_RESULT, &source);
    check_formats(FORMAT_PATTERN, &source);
    check_formats(FORMAT_REPORT, &source);
    bytes_free(&container);
}

static void test_encode_memory_of_meshes(void **state) {
    struct map_fields fields = small_stack();
    struct map_plies plies = *fields.plies;
    struct map_ply_row rows[3]; /* of elements that look to one side, as some formats need them */
    memcpy(rows, plies.rows, sizeof rows);
    rows[2].mirrored = false;
    plies.rows = rows;
    const struct map_ply_kind kind = {0.5, {110e9, 6e9, 0.3, 2e9}}, kinds[] = {kind, kind};
    plies.kinds = kinds;
    fields.plies = &plies;
    const struct format_source source = {.id = "small", .fields = &fields};
    (void)state;
    check_formats(FORMAT_MAP, &source);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_encode_memory_of_results),
        cmocka_unit_test(test_encode_memory_of_meshes),
    };
    prepare();
    return cmocka_run_group_tests_name("encode_memory", tests, NULL, NULL);
}
