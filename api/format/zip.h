/* SPDX-License-Identifier: MIT */
/*
 * The frame of a zip archive (PKWARE's APPNOTE 6.3) that is written front to back: headers before
 * the entries, the directory behind them; the 64-bit forms where a number needs them. All entries
 * carry the first moment that the format knows, so that the same content gives the same bytes.
 */
#ifndef API_FORMAT_ZIP_H
#define API_FORMAT_ZIP_H

#include "api/json/text.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { ZIP_NAME_SIZE = 64, ZIP_HEADER_MAX = 256 }; /* room that a header needs */

enum zip_method { ZIP_STORED = 0, ZIP_DEFLATED = 8 };

struct zip_entry {
    char name[ZIP_NAME_SIZE];
    enum zip_method method;
    bool trailed; /* crc and sizes follow the bytes, because they are not known before them */
    uint32_t crc;
    uint64_t size;   /* of the content */
    uint64_t packed; /* of the bytes in the archive */
    uint64_t offset; /* of the entry's header */
};

/* The header before an entry's bytes. */
void zip_begin_entry(struct api_text *text, const struct zip_entry *entry);

/* What follows the bytes of a trailed entry; its sizes stay below 4 GiB. */
void zip_end_entry(struct api_text *text, const struct zip_entry *entry);

/* The directory of all entries, which begins `offset` bytes behind the archive's begin, and the
 * end.
 */
void zip_end(struct api_text *text, const struct zip_entry *entries, size_t count, uint64_t offset);

#endif
