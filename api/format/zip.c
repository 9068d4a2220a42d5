/* SPDX-License-Identifier: MIT */
#include "zip.h"

#include <string.h>

static const uint32_t LARGE = 0xffffffff; /* stands for a number that is in the 64-bit form */

enum {
    VERSION_PLAIN = 20, /* what a reader must know: 2.0, or 4.5 for the 64-bit forms */
    VERSION_64 = 45,
    MADE_BY_UNIX = 3 << 8,
    FLAG_TRAILED = 1 << 3,
    FIRST_DAY = 1 << 5 | 1, /* 1980-01-01 */
    EXTRA_64 = 1,
    MANY = 0xffff
};

static const uint32_t REGULAR_FILE = 0100644u << 16;

/* Numbers of as many bytes as the digits of `sizes` say, the low ones first. */
static void put_fields(struct api_text *text, const char *sizes, const uint64_t values[]) {
    for (; *sizes; sizes++, values++) {
        char bytes[8];
        int size = *sizes - '0';
        for (int k = 0; k < size; k++)
            bytes[k] = (char)(*values >> (8 * k) & 0xff);
        api_text_bytes(text, bytes, (size_t)size);
    }
}

static uint32_t narrow(uint64_t value) {
    return value < LARGE ? (uint32_t)value : LARGE;
}

/* Version, flags, method, time and day: the same in both headers. */
static void put_kind(struct api_text *text, const struct zip_entry *entry, bool large) {
    put_fields(text, "22222",
               (const uint64_t[]){large ? VERSION_64 : VERSION_PLAIN,
                                  entry->trailed ? FLAG_TRAILED : 0, (uint64_t)entry->method, 0,
                                  FIRST_DAY});
}

void zip_begin_entry(struct api_text *text, const struct zip_entry *entry) {
    bool known = !entry->trailed, large = known && (entry->size >= LARGE || entry->packed >= LARGE);
    put_fields(text, "4", (const uint64_t[]){0x04034b50});
    put_kind(text, entry, large);
    put_fields(text, "44422",
               (const uint64_t[]){known ? entry->crc : 0,
                                  large   ? LARGE
                                  : known ? entry->packed
                                          : 0,
                                  large   ? LARGE
                                  : known ? entry->size
                                          : 0,
                                  strlen(entry->name), large ? 20 : 0});
    api_text_raw(text, entry->name);
    if (large)
        put_fields(text, "2288", (const uint64_t[]){EXTRA_64, 16, entry->size, entry->packed});
}

void zip_end_entry(struct api_text *text, const struct zip_entry *entry) {
    put_fields(text, "4444",
               (const uint64_t[]){0x08074b50, entry->crc, entry->packed, entry->size});
}

/* The directory's entries, and its end. */
void zip_end(struct api_text *text, const struct zip_entry *entries, size_t count,
             uint64_t offset) {
    size_t start = text->length;
    for (const struct zip_entry *entry = entries; entry < entries + count; entry++) {
        const uint64_t numbers[] = {entry->size, entry->packed, entry->offset};
        uint64_t wide = 0;
        for (int k = 0; k < 3; k++)
            wide += numbers[k] >= LARGE;
        put_fields(
            text, "42",
            (const uint64_t[]){0x02014b50, MADE_BY_UNIX | (wide ? VERSION_64 : VERSION_PLAIN)});
        put_kind(text, entry, wide > 0);
        /* The 6 bytes are comment, disk and internal attributes. */
        put_fields(text, "44422644",
                   (const uint64_t[]){entry->crc, narrow(entry->packed), narrow(entry->size),
                                      strlen(entry->name), wide ? 4 + 8 * wide : 0, 0, REGULAR_FILE,
                                      narrow(entry->offset)});
        api_text_raw(text, entry->name);
        if (wide)
            put_fields(text, "22", (const uint64_t[]){EXTRA_64, 8 * wide});
        for (int k = 0; k < 3; k++)
            if (numbers[k] >= LARGE)
                put_fields(text, "8", &numbers[k]);
    }
    uint64_t length = text->length - start, many = count < MANY ? count : MANY;
    /* The 64-bit form: 44 is the number of bytes that follow, the zeros are disks. */
    if (count >= MANY || offset >= LARGE || length >= LARGE)
        put_fields(text, "4822888884484",
                   (const uint64_t[]){0x06064b50, 44, MADE_BY_UNIX | VERSION_64, VERSION_64, 0,
                                      count, count, length, offset, 0x07064b50, 0, offset + length,
                                      1});
    put_fields(text, "4422442",
               (const uint64_t[]){0x06054b50, 0, many, many, narrow(length), narrow(offset), 0});
}
