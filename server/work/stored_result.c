/* SPDX-License-Identifier: MIT */
#include "stored_result.h"

static bool read_at(void *context, uint64_t offset, void *buffer, size_t length) {
    const struct stored_result *stored = context;
    uint64_t end = (uint64_t)stored->result.length;
    return offset <= end && length <= end - offset &&
           store_result_read(stored->store, &stored->result, (int64_t)offset, buffer, length) ==
               STORE_OK;
}

struct api_reader stored_result_reader(struct stored_result *stored) {
    return (struct api_reader){read_at, stored};
}
