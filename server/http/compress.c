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

static ssize_t compressor_next(void *context, char *buffer, size_t size) {
    struct compressor *compressor = context;
    z_stream *gzip = &compressor->gzip;
    size_t part = size < UINT32_MAX ? size : UINT32_MAX;
    while (!compressor->ended) {
        bool good;
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
        bool last = compressor->source_ended;
        if (compressor->coding == COMPRESS_ZSTD) {
            ZSTD_inBuffer in = {compressor->input, compressor->length, compressor->taken};
            ZSTD_outBuffer out = {buffer, part, 0};
            size_t left = ZSTD_compressStream2(compressor->zstd, &out, &in,
                                               last ? ZSTD_e_end : ZSTD_e_continue);
            compressor->taken = in.pos;
            compressor->ended = last && left == 0;
            made = out.pos;
            good = !ZSTD_isError(left);
        } else {
            gzip->next_in = (Bytef *)compressor->input + compressor->taken;
            gzip->avail_in = (uInt)(compressor->length - compressor->taken);
            gzip->next_out = (Bytef *)buffer;
            gzip->avail_out = (uInt)part;
            int answer = deflate(gzip, last ? Z_FINISH : Z_NO_FLUSH);
            compressor->taken = compressor->length - gzip->avail_in;
            compressor->ended = answer == Z_STREAM_END;
            made = part - gzip->avail_out;
            good = answer == Z_OK || answer == Z_STREAM_END || answer == Z_BUF_ERROR;
        }
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
