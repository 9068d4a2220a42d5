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

/* Answers with the document, 200; with the part of it that the request's Range wants, 206 or 416,
 * where the length is known and nothing is compressed; or with a problem when it cannot even be
 * begun. The source is taken over: it is freed once the reply is. */
void stream_reply(const struct request *request, struct reply *reply, const char *type,
                  enum compress_coding coding, const struct stream_source *source);

#endif
