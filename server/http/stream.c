/* SPDX-License-Identifier: MIT */
#include "stream.h"
#include "negotiate.h"
#include "server/clock.h"
#include "server/metrics.h"
#include <stdlib.h>
#include <string.h>

enum {
    HEAD_BYTES = 64 * 1024,      /* documents up to this size are sent with their length */
    SKIP_BYTES = 4 * 1024 * 1024 /* of a range's beginning that are thrown away at a time */
};

/* A document with its first bytes. */
struct stream {
    struct stream_source source;
    char *head;
    size_t head_length, head_sent;
    bool whole, failed;  /* the head is all there is; it cannot be made */
    int64_t encode_us;   /* spent so far */
    uint64_t skip, left; /* bytes until a range begins, and of it */
};

void stream_free(struct stream *stream) {
    if (!stream)
        return;
    metrics_time(METRICS_ENCODE, stream->encode_us);
    stream->source.free(stream->source.context);
    free(stream->head);
    free(stream);
}

static void free_stream(void *context) {
    stream_free(context);
}

static ssize_t read_source(struct stream *stream, char *buffer, size_t size) {
    int64_t begun = clock_us();
    ssize_t got = stream->source.read(stream->source.context, buffer, size);
    stream->encode_us += clock_us() - begun;
    return got;
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
    ssize_t got = read_source(stream, buffer, size);
    return got > 0 ? got : got == 0 ? REPLY_END : REPLY_BROKEN;
}

/* A range of the stream: what is before it is made and thrown away, a piece at a time, so that
 * others have their turn in between. */
static ssize_t range_next(void *context, char *buffer, size_t size) {
    struct stream *stream = context;
    for (uint64_t most = SKIP_BYTES; stream->skip > 0;) {
        if (most == 0)
            return REPLY_WAIT;
        uint64_t wanted = stream->skip < most ? stream->skip : most;
        ssize_t got = stream_next(context, buffer, wanted < size ? (size_t)wanted : size);
        if (got <= 0)
            return got;
        stream->skip -= (uint64_t)got;
        most -= (uint64_t)got;
    }
    if (stream->left == 0)
        return REPLY_END;
    ssize_t got = stream_next(context, buffer, stream->left < size ? (size_t)stream->left : size);
    stream->left -= got > 0 ? (uint64_t)got : 0;
    return got;
}

struct stream *stream_begin(const struct stream_source *source, size_t most) {
    struct stream *stream = calloc(1, sizeof *stream);
    char *head = stream ? malloc(most) : NULL;
    if (!head) {
        source->free(source->context);
        free(stream);
        return NULL;
    }
    stream->source = *source;
    stream->head = head;
    while (!stream->whole && !stream->failed && stream->head_length < most) {
        ssize_t got = read_source(stream, head + stream->head_length, most - stream->head_length);
        stream->failed = got < 0;
        stream->whole = got == 0;
        stream->head_length += got > 0 ? (size_t)got : 0;
    }
    return stream;
}

/* Answers with a part of a document of that length, if that is what is wanted: of the version that
 * the client has a part of already. */
static bool reply_part(const struct request *request, struct reply *reply, const char *type,
                       struct stream *stream, uint64_t length) {
    const char *etag = stream->source.etag, *version = request_header(request, "If-Range");
    const unsigned long long all = length;
    struct negotiate_range range;
    if (!etag || !length || strcmp(request->method, "GET") != 0)
        return false;
    reply_header(reply, "Accept-Ranges", "bytes");
    if (version && strcmp(version, etag) != 0)
        return false;
    enum negotiate_part part = negotiate_range(request_header(request, "Range"), length, &range);
    if (part == NEGOTIATE_ALL)
        return false;
    if (part == NEGOTIATE_NONE) {
        stream_free(stream);
        reply_header(reply, "Content-Range", "bytes */%llu", all);
        reply_refuse(reply, API_RANGE, "the range begins beyond the document, which has %llu bytes",
                     all);
        return true;
    }
    stream->skip = range.first;
    stream->left = range.last - range.first + 1;
    reply_header(reply, "Content-Range", "bytes %llu-%llu/%llu", (unsigned long long)range.first,
                 (unsigned long long)range.last, all);
    reply_stream(reply, 206, type, (struct reply_stream){range_next, free_stream, stream, 0},
                 (size_t)stream->left);
    return true;
}

void stream_send(const struct request *request, struct reply *reply, const char *type,
                 enum compress_coding coding, struct stream *stream) {
    struct reply_stream bytes = {stream_next, free_stream, stream, 0};
    if (stream->failed) {
        stream_free(stream);
        reply_refuse(reply, API_INTERNAL, "the stored result cannot be read");
    } else if (coding != COMPRESS_IDENTITY && !compress_stream(coding, &bytes)) {
        stream_free(stream);
        reply_no_memory(reply);
    } else if (coding != COMPRESS_IDENTITY) {
        reply_header(reply, "Content-Encoding", "%s", compress_name(coding));
        reply_stream(reply, 200, type, bytes, 0);
    } else if (reply_part(request, reply, type, stream,
                          stream->whole ? stream->head_length : stream->source.length)) {
        return;
    } else if (stream->whole && stream->head_length > HEAD_BYTES) {
        /* In pieces all the same: the client has to fetch each in time. */
        bytes.block = HEAD_BYTES;
        reply_stream(reply, 200, type, bytes, stream->head_length);
    } else if (stream->whole) {
        reply_bytes(reply, 200, type, stream->head, stream->head_length);
        stream->head = NULL;
        stream_free(stream);
    } else {
        reply_stream(reply, 200, type, bytes, stream->source.length);
    }
}

void stream_reply(const struct request *request, struct reply *reply, const char *type,
                  enum compress_coding coding, const struct stream_source *source) {
    struct stream *stream = stream_begin(source, HEAD_BYTES);
    if (stream)
        stream_send(request, reply, type, coding, stream);
    else
        reply_no_memory(reply);
}
