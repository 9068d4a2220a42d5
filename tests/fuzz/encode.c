/* SPDX-License-Identifier: MIT */
#include "encode.h"

#include "api/format/format.h"
#include "api/run.h"
#include <string.h>

enum { LOOKS_MOST = 2000 };

void fuzz_prepare(void) {
    static bool prepared;
    if (!prepared)
        prepared = api_prepare();
}

bool fuzz_go_on(void *looks, double fraction) {
    FUZZ_PROMISE(fraction >= 0.0 && fraction <= 1.0);
    return ++*(int *)looks < LOOKS_MOST;
}

const struct api_limits fuzz_limits = {.max_nodes = 300,
                                       .max_memory = 1 << 26,
                                       .max_elements = 2000,
                                       .max_control_points = 100,
                                       .max_depth = 16,
                                       .threads = 1,
                                       .max_variants = 200};

bool fuzz_append(void *context, const void *bytes, size_t length) {
    struct fuzz_bytes *all = context;
    if (all->size + length > all->capacity) {
        all->capacity = 2 * all->capacity + length;
        all->data = realloc(all->data, all->capacity);
        FUZZ_PROMISE(all->data != NULL);
    }
    memcpy(all->data + all->size, bytes, length);
    all->size += length;
    return true;
}

static void encode_one(const struct format *format, const struct api_reader *reader, bool sound) {
    static char piece[4096];
    const struct format_source source = {.id = "fuzz", .reader = reader};
    const struct format_options options = {.precision = 6};
    struct api_problem problem = {0};
    struct encoder *encoder = encoder_new(format, &source, &options, &problem);
    uint64_t total = 0;
    ssize_t got = 0;
    FUZZ_PROMISE((encoder != NULL) == (problem.id == API_OK));
    FUZZ_PROMISE(encoder || !sound);
    if (!encoder)
        return;
    uint64_t promised = encoder_length(encoder);
    /* A damaged header may promise columns of any length. */
    while (total < 1 << 20 && (got = encoder_read(encoder, piece, sizeof piece)) > 0)
        total += (uint64_t)got;
    FUZZ_PROMISE(got >= 0 || !sound);
    FUZZ_PROMISE(got != 0 || !promised || total == promised);
    encoder_free(encoder);
}

void encode_all(const uint8_t *data, size_t size, bool sound) {
    struct api_memory memory = {(const char *)data, size};
    const struct api_reader reader = api_reader_of(&memory);
    const struct format *format;
    for (size_t k = 0; (format = format_at(FORMAT_RESULT, k)); k++)
        encode_one(format, &reader, sound);
}
