/* SPDX-License-Identifier: MIT */
#include "compress.h"
#include "negotiate.h"
#include <stdlib.h>
#include <zlib.h>
#include <zstd.h>

enum {
    INPUT_BYTES = 32 * 1024, /* asked of the source at a time */
    ZSTD_LEVEL = 1,          /* results are large and sent once: speed counts */
    ZSTD_WINDOW_LOG = 18,    /* bounds the memory of one reply, to about a megabyte */
    GZIP_LEVEL = 1,
    GZIP_WINDOW_BITS = 15 + 16 /* 16: with gzip's header */
};

struct compressor {
    struct reply_stream source;
    enum compress_coding coding;
    ZSTD_CCtx *zstd;
    z_stream gzip;
    char input[INPUT_BYTES];
    size_t length, taken; /* of the input */
    bool source_ended, ended;
};

static const char *const names[] = {"identity", "zstd", "gzip"};

const char *compress_name(enum compress_coding coding) {
    return names[coding];
}

enum compress_coding compress_choose(const char *accept_encoding) {
    enum compress_coding best = COMPRESS_IDENTITY;
    int highest = negotiate_coding(accept_encoding, "identity");
    for (int coding = COMPRESS_GZIP; coding >= COMPRESS_ZSTD; coding--) {
        int quality = negotiate_coding(accept_encoding, names[coding]);
        if (quality > 0 && quality >= highest) {
            highest = quality;
            best = (enum compress_coding)coding;
        }
    }
    return best;
}

/* Each compresses what there is of the input into the buffer and returns how many bytes came out;
 * false when the library fails. `ended` is set once the end is written. */
static bool compress_zstd(struct compressor *compressor, char *buffer, size_t size, size_t *made) {
    ZSTD_inBuffer in = {compressor->input, compressor->length, compressor->taken};
    ZSTD_outBuffer out = {buffer, size, 0};
    size_t left = ZSTD_compressStream2(compressor->zstd, &out, &in,
                                       compressor->source_ended ? ZSTD_e_end : ZSTD_e_continue);
    compressor->taken = in.pos;
    compressor->ended = compressor->source_ended && left == 0;
    *made = out.pos;
    return !ZSTD_isError(left);
}

static bool compress_gzip(struct compressor *compressor, char *buffer, size_t size, size_t *made) {
    z_stream *gzip = &compressor->gzip;
    gzip->next_in = (Bytef *)compressor->input + compressor->taken;
    gzip->avail_in = (uInt)(compressor->length - compressor->taken);
    gzip->next_out = (Bytef *)buffer;
    gzip->avail_out = (uInt)size;
    int answer = deflate(gzip, compressor->source_ended ? Z_FINISH : Z_NO_FLUSH);
    compressor->taken = compressor->length - gzip->avail_in;
    compressor->ended = answer == Z_STREAM_END;
    *made = size - gzip->avail_out;
    return answer == Z_OK || answer == Z_STREAM_END || answer == Z_BUF_ERROR;
}

static ssize_t compressor_next(void *context, char *buffer, size_t size) {
    struct compressor *compressor = context;
    size_t part = size < UINT32_MAX ? size : UINT32_MAX;
    while (!compressor->ended) {
        size_t made;
        if (compressor->taken == compressor->length && !compressor->source_ended) {
            ssize_t got =
                compressor->source.next(compressor->source.context, compressor->input, INPUT_BYTES);
            compressor->taken = 0;
            compressor->length = got > 0 ? (size_t)got : 0;
            compressor->source_ended = got == REPLY_END;
            if (got == REPLY_WAIT || got == REPLY_BROKEN)
                return got;
        }
        bool good = compressor->coding == COMPRESS_ZSTD
                        ? compress_zstd(compressor, buffer, part, &made)
                        : compress_gzip(compressor, buffer, part, &made);
        if (!good)
            return REPLY_BROKEN;
        if (made > 0)
            return (ssize_t)made;
    }
    return REPLY_END;
}

static void compressor_free(void *context) {
    struct compressor *compressor = context;
    if (compressor->source.free)
        compressor->source.free(compressor->source.context);
    ZSTD_freeCCtx(compressor->zstd);
    if (compressor->coding == COMPRESS_GZIP)
        deflateEnd(&compressor->gzip);
    free(compressor);
}

bool compress_stream(enum compress_coding coding, struct reply_stream *stream) {
    struct compressor *compressor = calloc(1, sizeof *compressor);
    if (!compressor)
        return false;
    compressor->coding = coding;
    bool good;
    if (coding == COMPRESS_GZIP) {
        good = deflateInit2(&compressor->gzip, GZIP_LEVEL, Z_DEFLATED, GZIP_WINDOW_BITS, 8,
                            Z_DEFAULT_STRATEGY) == Z_OK;
    } else {
        ZSTD_CCtx *zstd = compressor->zstd = ZSTD_createCCtx();
        good = zstd &&
               !ZSTD_isError(ZSTD_CCtx_setParameter(zstd, ZSTD_c_compressionLevel, ZSTD_LEVEL)) &&
               !ZSTD_isError(ZSTD_CCtx_setParameter(zstd, ZSTD_c_windowLog, ZSTD_WINDOW_LOG));
    }
    if (!good) {
        compressor_free(compressor);
        return false;
    }
    compressor->source = *stream;
    *stream = (struct reply_stream){compressor_next, compressor_free, compressor, 0};
    return true;
}
