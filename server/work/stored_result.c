/* SPDX-License-Identifier: MIT */
#include "stored_result.h"
#include "server/spool.h"
#include <stdlib.h>

enum { COPY_BYTES = 256 * 1024 };

static bool read_stored(void *context, uint64_t offset, void *buffer, size_t length) {
    const struct stored_result *stored = context;
    uint64_t end = (uint64_t)stored->result.length;
    return offset <= end && length <= end - offset &&
           store_result_read(stored->store, &stored->result, (int64_t)offset, buffer, length) ==
               STORE_OK;
}

struct api_reader stored_result_reader(struct stored_result *stored) {
    return (struct api_reader){read_stored, stored};
}

bool stored_result_copy(struct stored_result *stored, int file) {
    char *bytes = malloc(COPY_BYTES);
    uint64_t end = (uint64_t)stored->result.length;
    bool good = bytes != NULL;
    for (uint64_t at = 0; good && at < end; at += COPY_BYTES) {
        size_t length = end - at < COPY_BYTES ? (size_t)(end - at) : COPY_BYTES;
        good = read_stored(stored, at, bytes, length) && spool_write(file, bytes, length);
    }
    free(bytes);
    return good;
}
