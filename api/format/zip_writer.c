/* SPDX-License-Identifier: MIT */
#define ZLIB_CONST /* what is packed stays as it is */
#include "zip_writer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { PACKED_ROOM = 1 << 16, PACKED_LEVEL = 6, PACKED_RAW = -15 };

struct zip_writer {
    struct api_sink sink;
    enum zip_fault fault;
    struct zip_entry *entries;
    size_t count, capacity;
    uint64_t position; /* in the archive */
    z_stream deflate;
    char packed[PACKED_ROOM];
};

static bool fail_zip(struct zip_writer *writer, enum zip_fault fault) {
    writer->fault = writer->fault ? writer->fault : fault;
    return false;
}

static bool put_packed(struct zip_writer *writer, const void *bytes, size_t length) {
    writer->position += length;
    return writer->sink.write(writer->sink.context, bytes, length) || fail_zip(writer, ZIP_REFUSED);
}

struct zip_writer *zip_writer_new(const struct api_sink *sink) {
    struct zip_writer *writer = calloc(1, sizeof *writer);
    if (!writer)
        return NULL;
    writer->sink = *sink;
    if (deflateInit2(&writer->deflate, PACKED_LEVEL, Z_DEFLATED, PACKED_RAW, 8,
                     Z_DEFAULT_STRATEGY) == Z_OK)
        return writer;
    free(writer);
    return NULL;
}

void zip_writer_free(struct zip_writer *writer) {
    if (writer) {
        deflateEnd(&writer->deflate);
        free(writer->entries);
    }
    free(writer);
}

bool zip_writer_open(struct zip_writer *writer, const char *name) {
    struct api_text text = api_text_over(writer->packed, sizeof writer->packed);
    if (writer->fault)
        return false;
    if (writer->count == writer->capacity) {
        size_t capacity = writer->capacity ? 2 * writer->capacity : 64;
        struct zip_entry *entries = realloc(writer->entries, capacity * sizeof *entries);
        if (!entries)
            return fail_zip(writer, ZIP_NO_MEMORY);
        writer->entries = entries;
        writer->capacity = capacity;
    }
    struct zip_entry *entry = &writer->entries[writer->count];
    *entry = (struct zip_entry){.method = ZIP_DEFLATED,
                                .trailed = true,
                                .crc = (uint32_t)crc32(0, NULL, 0),
                                .offset = writer->position};
    (void)snprintf(entry->name, sizeof entry->name, "%s", name);
    zip_begin_entry(&text, entry);
    (void)deflateReset(&writer->deflate);
    return put_packed(writer, writer->packed, text.length);
}

/* Packs bytes of the open entry, or all that are left. */
static bool pack_entry(struct zip_writer *writer, const void *bytes, size_t length, int flush) {
    struct zip_entry *entry = &writer->entries[writer->count];
    writer->deflate.next_in = bytes;
    writer->deflate.avail_in = (uInt)length;
    do {
        writer->deflate.next_out = (Bytef *)writer->packed;
        writer->deflate.avail_out = PACKED_ROOM;
        (void)deflate(&writer->deflate, flush);
        size_t made = PACKED_ROOM - writer->deflate.avail_out;
        entry->packed += made;
        if (made && !put_packed(writer, writer->packed, made))
            return false;
    } while (writer->deflate.avail_out == 0);
    return true;
}

bool zip_writer_write(struct zip_writer *writer, const void *bytes, size_t length) {
    if (writer->fault || length == 0)
        return !writer->fault;
    struct zip_entry *entry = &writer->entries[writer->count];
    if (length > UINT32_MAX - entry->size)
        return fail_zip(writer, ZIP_TOO_LARGE);
    entry->size += length;
    entry->crc = (uint32_t)crc32_z(entry->crc, bytes, length);
    return pack_entry(writer, bytes, length, Z_NO_FLUSH);
}

bool zip_writer_close(struct zip_writer *writer, uint64_t *size) {
    struct api_text text = api_text_over(writer->packed, sizeof writer->packed);
    if (writer->fault || !pack_entry(writer, NULL, 0, Z_FINISH))
        return false;
    *size = writer->entries[writer->count].size;
    zip_end_entry(&text, &writer->entries[writer->count++]);
    return put_packed(writer, writer->packed, text.length);
}

bool zip_writer_end(struct zip_writer *writer) {
    struct arena *arena = writer->fault ? NULL : arena_new(SIZE_MAX);
    struct api_text text = api_text_growing(arena);
    if (arena)
        zip_end(&text, writer->entries, writer->count, writer->position);
    bool good = arena && !text.failed ? put_packed(writer, text.bytes, text.length)
                                      : fail_zip(writer, ZIP_NO_MEMORY);
    arena_free(arena);
    return good;
}

enum zip_fault zip_writer_fault(const struct zip_writer *writer) {
    return writer->fault;
}
