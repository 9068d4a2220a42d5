/* SPDX-License-Identifier: MIT */
/* What a command reads, and the file it writes, which appears when it is complete or
 * not at all. Errors are reported on standard error. */
#ifndef CLI_FILES_H
#define CLI_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* A growing buffer of the heap; the caller frees `data`. */
struct files_bytes {
    char *data;
    size_t length, capacity;
};

/* One line: what has gone wrong with what. */
void files_complain(const char *what, const char *why);

/* All of a file; NULL: of standard input. */
bool files_read(const char *path, struct files_bytes *bytes);

/* The rest of a stream. */
bool files_drain(FILE *stream, struct files_bytes *bytes);

/* For `api_sink` and `api_reader`: writes to and reads from the stream that is their context. */
bool files_append(void *stream, const void *bytes, size_t length);
bool files_read_at(void *stream, uint64_t offset, void *buffer, size_t length);

/* Where the document goes: a stream, and for a regular file the temporary one beside it that takes
 * its place once it is complete. */
struct files_output {
    const char *name; /* for messages */
    FILE *stream;
    char *target, *temporary; /* NULL: the stream is the real one */
};

/* Opens it; NULL: standard output. To be closed even so, when that fails. */
bool files_open(struct files_output *output, const char *path);

/* Closes it; with `ok` what was written takes its place, else nothing stays. */
bool files_close(struct files_output *output, bool ok);

/* From now on a signal that ends the program removes the unfinished file. */
void files_watch_signals(void);

#endif
