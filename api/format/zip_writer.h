/* SPDX-License-Identifier: MIT */
/* A zip archive on its way to a sink: one entry after the other, packed as its bytes come. */
#ifndef API_FORMAT_ZIP_WRITER_H
#define API_FORMAT_ZIP_WRITER_H

#include "api/sink.h"
#include "solver/arena.h"
#include "zip.h"

struct zip_writer;

/* NULL without memory. The caller frees it; NULL is allowed. */
struct zip_writer *zip_writer_new(const struct api_sink *sink);
void zip_writer_free(struct zip_writer *writer);

enum zip_fault {
    ZIP_SOUND,
    ZIP_NO_MEMORY,
    ZIP_REFUSED,  /* by the sink */
    ZIP_TOO_LARGE /* an entry, of 4 GiB */
};

/* Begins an entry; then its bytes; then its end, and of it the size before packing. False after a
 * fault, for good. */
bool zip_writer_open(struct zip_writer *writer, const char *name);
bool zip_writer_write(struct zip_writer *writer, const void *bytes, size_t length);
bool zip_writer_close(struct zip_writer *writer, uint64_t *size);

/* The directory, after the last entry. */
bool zip_writer_end(struct zip_writer *writer);

enum zip_fault zip_writer_fault(const struct zip_writer *writer);

#endif
