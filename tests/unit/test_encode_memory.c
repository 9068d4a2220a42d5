/* SPDX-License-Identifier: MIT */
/* The encoders take their memory from the C library: each of its allocations fails once, from it
 * on, in every format. Then there is no document, and under a sanitizer nothing is lost. */
#include "check.h"
#include "small.h"
#include "support.h"

#include "api/format/encode.h"
#include "api/format/pattern.h"
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

static void read_result(const void *format, struct bytes *container, struct document *out) {
    struct api_reader reader = reader_over(container);
    struct api_problem problem = {0};
    const struct api_encode_options options = {.id = "small"};
    struct api_encoder *encoder = api_encoder_new(format, &reader, &options, &problem);
    ssize_t length = encoder ? 0 : -1, more = encoder ? 1 : 0;
    while (more > 0) {
        more = api_encoder_read(encoder, out->bytes + length, DOCUMENT_MAX - (size_t)length);
        length = more < 0 ? -1 : length + more;
    }
    api_encoder_free(encoder);
    out->length = length;
    out->problem = problem.id;
}

static void read_mesh(const void *format, struct bytes *container, struct document *out) {
    struct api_mesh_fields fields = small_mesh();
    struct api_problem problem = {0};
    struct api_mesh_encoder *encoder = api_mesh_encoder_new(format, &fields, &problem);
    ssize_t length = encoder ? 0 : -1, more = encoder ? 1 : 0;
    (void)container;
    while (more > 0) {
        more = api_mesh_encoder_read(encoder, out->bytes + length, DOCUMENT_MAX - (size_t)length);
        length = more < 0 ? -1 : length + more;
    }
    api_mesh_encoder_free(encoder);
    out->length = length;
    out->problem = problem.id;
}

typedef void reading(const void *format, struct bytes *container, struct document *out);

/* Until none is left to fail; each time out-of-memory, or a stop in the middle. */
static void check_format(const char *name, reading *read, const void *format,
                         struct bytes *container) {
    static struct document sound, failing;
    size_t n = 0;
    read(format, container, &sound);
    assert_true(sound.length > 0);
    do {
        taken = 0;
        fail_at = ++n;
        read(format, container, &failing);
        fail_at = 0;
        assert_true(failing.length == -1 || taken < n);
        assert_true(failing.problem == API_OK || failing.problem == API_OUT_OF_MEMORY);
    } while (taken >= n);
    assert_int_equal(failing.length, sound.length);
    assert_memory_equal(failing.bytes, sound.bytes, (size_t)sound.length);
    printf("  %-7s %zu allocations\n", name, n - 1);
}

static void test_encode_memory_of_results(void **state) {
    struct bytes container = small_result();
    const struct api_format *format;
    (void)state;
    for (size_t k = 0; (format = api_format_at(k)); k++)
        check_format(api_format_name(format), read_result, format, &container);
    for (size_t k = 0; (format = api_pattern_at(k)); k++)
        check_format(api_format_name(format), read_result, format, &container);
    bytes_free(&container);
}

static void test_encode_memory_of_meshes(void **state) {
    const struct api_mesh_format *format;
    (void)state;
    for (size_t k = 0; (format = api_mesh_format_at(k)); k++)
        check_format(api_mesh_format_name(format), read_mesh, format, NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_encode_memory_of_results),
        cmocka_unit_test(test_encode_memory_of_meshes),
    };
    prepare();
    return cmocka_run_group_tests_name("encode_memory", tests, NULL, NULL);
}
