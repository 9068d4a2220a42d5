/* SPDX-License-Identifier: MIT */
#include "stream.h"
#include <stdlib.h>
#include <string.h>

enum { HEAD_BYTES = 64 * 1024 }; /* documents up to this size are sent with their length */

/* A document with its first bytes. */
struct stream {
    struct stream_source source;
    char *head;
    size_t head_length, head_sent;
};

static void stream_free(void *context) {
    struct stream *stream = context;
    stream->source.free(stream->source.context);
    free(stream->head);
    free(stream);
}

static ssize_t stream_next(void *context, char *buffer, size_t size) {
    struct stream *stream = context;
    size_t left = stream->head_length - stream->head_sent;
    if (left) {
        size_t length = left < size ? left : size;
        memcpy(buffer, stream->head + stream->head_sent, length);
        stream->head_sent += length;
        return (ssize_t)length;
    }
    ssize_t got = stream->source.read(stream->source.context, buffer, size);
    return got > 0 ? got : got == 0 ? REPLY_END : REPLY_BROKEN;
}

/* Reads the beginning of the document. `*whole` tells that there is no more. False when it cannot
 * be made. */
static bool begin(struct stream *stream, bool *whole) {
    stream->head = malloc(HEAD_BYTES);
    *whole = false;
    while (stream->head && !*whole && stream->head_length < HEAD_BYTES) {
        ssize_t got =
            stream->source.read(stream->source.context, stream->head + stream->head_length,
                                HEAD_BYTES - stream->head_length);
        if (got < 0)
            return false;
        stream->head_length += (size_t)got;
        *whole = got == 0;
    }
    return stream->head != NULL;
}

static void reply_packed(const struct request *request, struct reply *reply, const char *type,
                         enum pack_coding coding, struct reply_stream stream) {
    if (!pack_stream(coding, &stream)) {
        stream.free(stream.context);
        reply_refuse(reply, request->id, API_UNAVAILABLE, "there is no memory for this now");
        return;
    }
    reply_header(reply, "Content-Encoding", "%s", pack_name(coding));
    reply_stream(reply, 200, type, stream, 0);
}

static void reply_begun(const struct request *request, struct reply *reply, const char *type,
                        enum pack_coding coding, struct stream *stream) {
    const struct reply_stream bytes = {stream_next, stream_free, stream, 0};
    bool whole;
    if (!begin(stream, &whole)) {
        stream_free(stream);
        reply_refuse(reply, request->id, API_INTERNAL, "the stored result cannot be read");
    } else if (coding != PACK_IDENTITY) {
        reply_packed(request, reply, type, coding, bytes);
    } else if (whole) {
        reply_bytes(reply, 200, type, stream->head, stream->head_length);
        stream->head = NULL;
        stream_free(stream);
    } else {
        reply_stream(reply, 200, type, bytes, stream->source.length);
    }
}

void stream_reply(const struct request *request, struct reply *reply, const char *type,
                  enum pack_coding coding, const struct stream_source *source) {
    struct stream *stream = calloc(1, sizeof *stream);
    if (!stream) {
        source->free(source->context);
        reply_refuse(reply, request->id, API_UNAVAILABLE, "there is no memory for this now");
        return;
    }
    stream->source = *source;
    reply_begun(request, reply, type, coding, stream);
}
