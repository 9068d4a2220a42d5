/* SPDX-License-Identifier: MIT */
#include "seal.h"
#include "api/checksum.h"

int64_t seal_of_chunk(const struct seal_chunk *chunk, const void *bytes, size_t length) {
    const int64_t of[] = {chunk->job, chunk->token, chunk->index, chunk->last};
    return checksum_of(checksum_of(0, of, sizeof of), bytes, length);
}

int64_t seal_of_request(const char *id, const void *bytes, size_t length) {
    return checksum_of(checksum_text(0, id), bytes, length);
}

int64_t seal_of_numbers(const char *study, const void *bytes, size_t length) {
    return seal_of_request(study, bytes, length);
}

int64_t seal_of_item(const struct store_item *item) {
    int64_t of = checksum_text(checksum_text(0, item->id), item->description);
    return checksum_of(of, item->definition, item->definition_length);
}

int64_t seal_of_text(const char *text) {
    return checksum_text(0, text);
}
