/* SPDX-License-Identifier: MIT */
/* A document that is made while it is sent, as an answer: compressed when the caller takes that,
 * with its length when it is short or the length is known. */
#ifndef SERVER_HTTP_STREAM_H
#define SERVER_HTTP_STREAM_H

#include "compress.h"
#include "reply.h"
#include "request.h"
#include <stdint.h>

struct stream_source {
    /* The next bytes, at most `size`: how many; 0 at the end; -1 when they cannot be made. */
    ssize_t (*read)(void *context, char *buffer, size_t size);
    void (*free)(void *context);
    void *context;
    const char *etag; /* NULL: no ranges of it are given */
    uint64_t length;  /* of all of it, 0 when that is only known at the end */
};

/* A document that is begun. */
struct stream;

/* Reads the beginning of a document, `most` bytes if it has as many. The source is taken over. NULL
 * without memory; what cannot be made is refused when it is to be sent. */
struct stream *stream_begin(const struct stream_source *source, size_t most);

/* `stream_reply` for one that is begun, which is taken over. */
void stream_send(const struct request *request, struct reply *reply, const char *type,
                 enum compress_coding coding, struct stream *stream);

/* One that is not sent. NULL is allowed. */
void stream_free(struct stream *stream);

/* Answers with the document, 200; with the part of it that the request's Range wants, 206 or 416,
 * where the length is known and nothing is compressed; or with a problem when it cannot even be
 * begun. The source is taken over: it is freed once the reply is. */
void stream_reply(const struct request *request, struct reply *reply, const char *type,
                  enum compress_coding coding, const struct stream_source *source);

#endif
