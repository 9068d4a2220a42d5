/* SPDX-License-Identifier: MIT */
/*
 * Result documents, streamed. An encoder reads a stored container piece by piece and gives the
 * document's bytes as they are asked for, in bounded memory, which is how an HTTP server wants to
 * send them. A format is one entry of the table below and one file that fills it in.
 */
#ifndef API_FORMAT_ENCODE_H
#define API_FORMAT_ENCODE_H

#include "api/problem.h"
#include "api/result/columns.h"
#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

struct api_format;

/* By its name in `?format=` ("json"), or by media type without parameters ("application/json",
 * any case); NULL when there is none. `api_format_at` walks the table, the default first; NULL
 * after the last. */
const struct api_format *api_format_named(const char *name);
const struct api_format *api_format_for_media_type(const char *media_type);
const struct api_format *api_format_at(size_t index);
const char *api_format_name(const struct api_format *format);
const char *api_format_media_type(const struct api_format *format); /* for Content-Type */

struct api_encode_options {
    const char *id;       /* of the drape, for formats that carry it */
    double queue_ms;      /* how long it waited; for summary.timing_ms */
    int precision;        /* significant digits, 1..17; 0: the shortest that reads back the same */
    const char *fields;   /* "nodes.x,cells.k1": only these columns; NULL or "": all */
    enum api_table table; /* for formats that hold one table; nodes or cells */
};

/* Sets the option that a query parameter or command-line flag `name` (precision, fields, table)
 * stands for; `fields` is kept as a pointer to `value`. False with `problem` set (invalid-request,
 * naming the option) when `value` is not in its range; false with `problem` unset when there is no
 * option of that name. */
bool api_encode_option(struct api_encode_options *options, const char *name, const char *value,
                       struct api_problem *problem);

struct api_encoder;

/*
 * A new encoder over `reader`, which must outlive it; `options` is copied with its strings. NULL
 * with `problem` set: API_INVALID_REQUEST for a field that the result does not have, API_INTERNAL
 * for a damaged container, API_OUT_OF_MEMORY. The caller owns it.
 */
struct api_encoder *api_encoder_new(const struct api_format *format,
                                    const struct api_reader *reader,
                                    const struct api_encode_options *options,
                                    struct api_problem *problem);

/* The next bytes of the document, at most `size`: how many; 0 at its end; -1 when the container
 * could not be read (what was sent so far is then no document). */
ssize_t api_encoder_read(struct api_encoder *encoder, char *buffer, size_t size);

/* The length of the whole document, 0 when it is only known at its end. */
uint64_t api_encoder_length(const struct api_encoder *encoder);

/* NULL is allowed. */
void api_encoder_free(struct api_encoder *encoder);

#endif
