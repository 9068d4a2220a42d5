/* SPDX-License-Identifier: MIT */
/* A document that is made while it is sent, as an answer: compressed when the caller takes that,
 * with its length when it is short or the length is known. */
#ifndef SERVER_STREAM_H
#define SERVER_STREAM_H

#include "pack.h"
#include "reply.h"
#include "request.h"
#include <stdint.h>

struct stream_source {
    /* The next bytes, at most `size`: how many; 0 at the end; -1 when they cannot be made. */
    ssize_t (*read)(void *context, char *buffer, size_t size);
    void (*free)(void *context);
    void *context;
    uint64_t length; /* of all of it, 0 when that is only known at the end */
};

/* Answers with the document, 200, or with a problem when it cannot even be begun. The source is
 * taken over: it is freed once the reply is. */
void stream_reply(const struct request *request, struct reply *reply, const char *type,
                  enum pack_coding coding, const struct stream_source *source);

#endif
