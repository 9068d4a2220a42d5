/* SPDX-License-Identifier: MIT */
#include "support.h"

#include "api/request/decode.h"
#include "api/request/prepared_part.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- random numbers ---- */

struct random random_begin(const char *test) {
    print_message("# %s:\n", test);
    return (struct random){check_seed(1)};
}

/* splitmix64 */
uint64_t random_bits(struct random *random) {
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

double random_between(struct random *random, double low, double high) {
    return low + (high - low) * (double)(random_bits(random) >> 11) * 0x1p-53;
}

int random_index(struct random *random, int count) {
    return (int)(random_bits(random) % (uint64_t)count);
}

/* ---- bytes ---- */

static void bytes_reserve(struct bytes *bytes, size_t length) {
    if (bytes->capacity - bytes->length > length)
        return;
    bytes->capacity = 2 * bytes->capacity + length + 1;
    bytes->data = realloc(bytes->data, bytes->capacity);
    assert_non_null(bytes->data);
}

void bytes_add(struct bytes *bytes, const void *data, size_t length) {
    bytes_reserve(bytes, length);
    if (length)
        memcpy(bytes->data + bytes->length, data, length);
    bytes->length += length;
    bytes->data[bytes->length] = '\0';
}

void bytes_format(struct bytes *bytes, const char *format, ...) {
    char text[4096];
    va_list list;
    va_start(list, format);
    int length = vsnprintf(text, sizeof text, format, list);
    va_end(list);
    assert_in_range(length, 0, sizeof text - 1);
    bytes_add(bytes, text, (size_t)length);
}

void bytes_free(struct bytes *bytes) {
    free(bytes->data);
    *bytes = (struct bytes){0};
}

struct bytes file_read(const char *path) {
    struct bytes bytes = {0};
    char block[4096];
    size_t length;
    FILE *file = fopen(path, "rb");
    if (!file)
        fail_msg("%s cannot be read; tests run in the project's folder", path);
    bytes_add(&bytes, "", 0);
    while ((length = fread(block, 1, sizeof block, file)) > 0)
        bytes_add(&bytes, block, length);
    fclose(file);
    return bytes;
}

struct bytes text_replace(const char *text, const char *what, const char *with) {
    struct bytes bytes = {0};
    const char *at = strstr(text, what);
    if (!at)
        fail_msg("\"%s\" is not in the text", what);
    bytes_add(&bytes, text, (size_t)(at - text));
    bytes_add(&bytes, with, strlen(with));
    bytes_add(&bytes, at + strlen(what), strlen(at + strlen(what)));
    return bytes;
}

/* ---- requests ---- */

const char *request_text(const char *name) {
    enum { MOST = 16 };
    static struct {
        char path[64];
        struct bytes text;
    } known[MOST];
    char path[sizeof known->path];
    size_t k = 0;
    snprintf(path, sizeof path, "tests/unit/requests/%s.json", name);
    while (k < MOST && known[k].text.data && strcmp(known[k].path, path) != 0)
        k++;
    assert_in_range(k, 0, MOST - 1);
    if (!known[k].text.data) {
        memcpy(known[k].path, path, sizeof path);
        known[k].text = file_read(path);
        known[k].text.data[strcspn(known[k].text.data, "\n")] = 0;
    }
    return known[k].text.data;
}

void prepare(void) {
    assert_true(api_prepare());
}

enum api_problem_id decode_text(const char *text, struct arena *arena, struct api_request *request,
                                struct api_problem *problem) {
    const struct api_input input = {.request = text, .request_length = strlen(text)};
    *problem = (struct api_problem){0};
    return api_decode(&input, &api_limits_default, arena, request, problem);
}

const char *describe_text(const struct api_surface *surface, struct arena *arena,
                          struct api_problem *problem) {
    struct prepared_part whole;
    struct api_problem fault = {0};
    if (prepared_part_make_whole(surface, arena, &whole, &fault) == API_OK)
        return prepared_part_describe(surface, &whole, &fault, arena, problem);
    *problem = fault;
    return NULL;
}

/* ---- containers ---- */

static bool write_bytes(void *context, const void *data, size_t length) {
    bytes_add(context, data, length);
    return true;
}

static bool read_bytes(void *context, uint64_t offset, void *buffer, size_t length) {
    const struct bytes *bytes = context;
    if (offset > bytes->length || length > bytes->length - offset)
        return false;
    if (length)
        memcpy(buffer, bytes->data + offset, length);
    return true;
}

struct api_sink sink_into(struct bytes *bytes) {
    return (struct api_sink){.write = write_bytes, .context = bytes};
}

struct api_reader reader_over(struct bytes *bytes) {
    return (struct api_reader){read_bytes, bytes};
}

enum api_problem_id run_text(const char *text, struct bytes *bytes, struct api_problem *problem) {
    const struct api_input input = {.request = text, .request_length = strlen(text)};
    const struct api_sink sink = sink_into(bytes);
    *problem = (struct api_problem){0};
    return api_run(&input, &api_limits_default, NULL, &sink, problem);
}
