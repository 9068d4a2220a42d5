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

/* `size` bytes of a number, the low ones first. */
static void put_little_endian(struct api_text *text, uint64_t value, int size) {
    char bytes[8];
    for (int k = 0; k < size; k++)
        bytes[k] = (char)(value >> (8 * k) & 0xff);
    api_text_bytes(text, bytes, (size_t)size);
}

static uint32_t narrow(uint64_t value) {
    return value < LARGE ? (uint32_t)value : LARGE;
}

/* Version, flags, method, time and day: the same in both headers. */
static void put_kind(struct api_text *text, const struct zip_entry *entry, bool large) {
    put_little_endian(text, large ? VERSION_64 : VERSION_PLAIN, 2);
    put_little_endian(text, entry->trailed ? FLAG_TRAILED : 0, 2);
    put_little_endian(text, (uint64_t)entry->method, 2);
    put_little_endian(text, 0, 2);
    put_little_endian(text, FIRST_DAY, 2);
}

void zip_begin_entry(struct api_text *text, const struct zip_entry *entry) {
    bool known = !entry->trailed, large = known && (entry->size >= LARGE || entry->packed >= LARGE);
    put_little_endian(text, 0x04034b50, 4);
    put_kind(text, entry, large);
    put_little_endian(text, known ? entry->crc : 0, 4);
    put_little_endian(text, large ? LARGE : known ? entry->packed : 0, 4);
    put_little_endian(text, large ? LARGE : known ? entry->size : 0, 4);
    put_little_endian(text, strlen(entry->name), 2);
    put_little_endian(text, large ? 20 : 0, 2);
    api_text_raw(text, entry->name);
    if (large) {
        put_little_endian(text, EXTRA_64, 2);
        put_little_endian(text, 16, 2);
        put_little_endian(text, entry->size, 8);
        put_little_endian(text, entry->packed, 8);
    }
}

void zip_end_entry(struct api_text *text, const struct zip_entry *entry) {
    put_little_endian(text, 0x08074b50, 4);
    put_little_endian(text, entry->crc, 4);
    put_little_endian(text, entry->packed, 4);
    put_little_endian(text, entry->size, 4);
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
        put_little_endian(text, 0x02014b50, 4);
        put_little_endian(text, MADE_BY_UNIX | (wide ? VERSION_64 : VERSION_PLAIN), 2);
        put_kind(text, entry, wide > 0);
        put_little_endian(text, entry->crc, 4);
        put_little_endian(text, narrow(entry->packed), 4);
        put_little_endian(text, narrow(entry->size), 4);
        put_little_endian(text, strlen(entry->name), 2);
        put_little_endian(text, wide ? 4 + 8 * wide : 0, 2);
        put_little_endian(text, 0, 6); /* comment, disk, internal attributes */
        put_little_endian(text, REGULAR_FILE, 4);
        put_little_endian(text, narrow(entry->offset), 4);
        api_text_raw(text, entry->name);
        if (wide) {
            put_little_endian(text, EXTRA_64, 2);
            put_little_endian(text, 8 * wide, 2);
        }
        for (int k = 0; k < 3; k++)
            if (numbers[k] >= LARGE)
                put_little_endian(text, numbers[k], 8);
    }
    uint64_t length = text->length - start;
    if (count >= MANY || offset >= LARGE || length >= LARGE) {
        put_little_endian(text, 0x06064b50, 4);
        put_little_endian(text, 44, 8); /* bytes that follow */
        put_little_endian(text, MADE_BY_UNIX | VERSION_64, 2);
        put_little_endian(text, VERSION_64, 2);
        put_little_endian(text, 0, 8); /* disks */
        put_little_endian(text, count, 8);
        put_little_endian(text, count, 8);
        put_little_endian(text, length, 8);
        put_little_endian(text, offset, 8);
        put_little_endian(text, 0x07064b50, 4);
        put_little_endian(text, 0, 4);
        put_little_endian(text, offset + length, 8);
        put_little_endian(text, 1, 4);
    }
    put_little_endian(text, 0x06054b50, 4);
    put_little_endian(text, 0, 4);
    put_little_endian(text, count < MANY ? count : MANY, 2);
    put_little_endian(text, count < MANY ? count : MANY, 2);
    put_little_endian(text, narrow(length), 4);
    put_little_endian(text, narrow(offset), 4);
    put_little_endian(text, 0, 2);
}
