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
    GZIP_WINDOW_BITS = 15 + 16 /* zlib's way to say: with gzip's header */
};

struct packer {
    struct reply_stream source;
    enum pack_coding coding;
    ZSTD_CCtx *zstd;
    z_stream gzip;
    char input[INPUT_BYTES];
    size_t length, taken; /* of the input */
    bool source_ended, ended;
};

static const char *const names[] = {"identity", "zstd", "gzip"};

const char *pack_name(enum pack_coding coding) {
    return names[coding];
}

enum pack_coding pack_choose(const char *accept_encoding) {
    enum pack_coding best = PACK_IDENTITY;
    int highest = accept_coding(accept_encoding, "identity");
    for (int coding = PACK_GZIP; coding >= PACK_ZSTD; coding--) {
        int quality = accept_coding(accept_encoding, names[coding]);
        if (quality > 0 && quality >= highest) {
            highest = quality;
            best = (enum pack_coding)coding;
        }
    }
    return best;
}

/* Each packs what there is of the input into the buffer and returns how many bytes came out; false
 * when the library fails. `ended` is set once the end is written. */
static bool pack_zstd(struct packer *packer, char *buffer, size_t size, size_t *made) {
    ZSTD_inBuffer in = {packer->input, packer->length, packer->taken};
    ZSTD_outBuffer out = {buffer, size, 0};
    size_t left = ZSTD_compressStream2(packer->zstd, &out, &in,
                                       packer->source_ended ? ZSTD_e_end : ZSTD_e_continue);
    packer->taken = in.pos;
    packer->ended = packer->source_ended && left == 0;
    *made = out.pos;
    return !ZSTD_isError(left);
}

static bool pack_gzip(struct packer *packer, char *buffer, size_t size, size_t *made) {
    z_stream *gzip = &packer->gzip;
    gzip->next_in = (Bytef *)packer->input + packer->taken;
    gzip->avail_in = (uInt)(packer->length - packer->taken);
    gzip->next_out = (Bytef *)buffer;
    gzip->avail_out = (uInt)size;
    int answer = deflate(gzip, packer->source_ended ? Z_FINISH : Z_NO_FLUSH);
    packer->taken = packer->length - gzip->avail_in;
    packer->ended = answer == Z_STREAM_END;
    *made = size - gzip->avail_out;
    return answer == Z_OK || answer == Z_STREAM_END || answer == Z_BUF_ERROR;
}

/* Fills the empty input; REPLY_WAIT and REPLY_BROKEN are passed on. */
static ssize_t fetch(struct packer *packer) {
    ssize_t got = packer->source.next(packer->source.context, packer->input, INPUT_BYTES);
    packer->taken = 0;
    packer->length = got > 0 ? (size_t)got : 0;
    packer->source_ended = got == REPLY_END;
    return got;
}

static ssize_t packer_next(void *context, char *buffer, size_t size) {
    struct packer *packer = context;
    size_t part = size < UINT32_MAX ? size : UINT32_MAX;
    while (!packer->ended) {
        size_t made;
        if (packer->taken == packer->length && !packer->source_ended) {
            ssize_t got = fetch(packer);
            if (got == REPLY_WAIT || got == REPLY_BROKEN)
                return got;
        }
        bool good = packer->coding == PACK_ZSTD ? pack_zstd(packer, buffer, part, &made)
                                                : pack_gzip(packer, buffer, part, &made);
        if (!good)
            return REPLY_BROKEN;
        if (made > 0)
            return (ssize_t)made;
    }
    return REPLY_END;
}

static void free_packer(struct packer *packer) {
    ZSTD_freeCCtx(packer->zstd);
    if (packer->coding == PACK_GZIP)
        deflateEnd(&packer->gzip);
    free(packer);
}

static void packer_free(void *context) {
    struct packer *packer = context;
    packer->source.free(packer->source.context);
    free_packer(packer);
}

static bool prepare(struct packer *packer) {
    if (packer->coding == PACK_GZIP)
        return deflateInit2(&packer->gzip, GZIP_LEVEL, Z_DEFLATED, GZIP_WINDOW_BITS, 8,
                            Z_DEFAULT_STRATEGY) == Z_OK;
    packer->zstd = ZSTD_createCCtx();
    return packer->zstd &&
           !ZSTD_isError(
               ZSTD_CCtx_setParameter(packer->zstd, ZSTD_c_compressionLevel, ZSTD_LEVEL)) &&
           !ZSTD_isError(ZSTD_CCtx_setParameter(packer->zstd, ZSTD_c_windowLog, ZSTD_WINDOW_LOG));
}

bool pack_stream(enum pack_coding coding, struct reply_stream *stream) {
    struct packer *packer = calloc(1, sizeof *packer);
    if (!packer)
        return false;
    packer->coding = coding;
    if (!prepare(packer)) {
        free_packer(packer);
        return false;
    }
    packer->source = *stream;
    *stream = (struct reply_stream){packer_next, packer_free, packer, 0};
    return true;
}
