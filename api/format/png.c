/* SPDX-License-Identifier: MIT */
#include "png.h"

#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { HEADER = 13, FRAME = 12, PALETTE = 3 * RASTER_COLOURS };

static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

static uint8_t *put_u32(uint8_t *at, uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8)
        *at++ = (uint8_t)(value >> shift);
    return at;
}

/* Length, name, data, checksum of name and data. */
static uint8_t *put_chunk(uint8_t *at, const char *name, const uint8_t *data, size_t length) {
    at = put_u32(at, (uint32_t)length);
    memcpy(at, name, 4);
    if (length)
        memcpy(at + 4, data, length);
    uint32_t sum = (uint32_t)crc32(0, at, (uInt)(length + 4));
    return put_u32(at + 4 + length, sum);
}

uint8_t *png_encode(const struct raster *raster, size_t *length) {
    uint8_t header[HEADER] = {[8] = 8, [9] = 3}; /* bits of a pixel; it is a number of a colour */
    size_t row = (size_t)raster->width, rows = (size_t)raster->height;
    uLong size = compressBound((uLong)(rows * (row + 1)));
    uint8_t *plain = malloc(rows * (row + 1)), *packed = malloc(size);
    for (size_t k = 0; k < rows && plain && packed; k++) { /* behind the filter's number: none */
        plain[k * (row + 1)] = 0;
        memcpy(plain + k * (row + 1) + 1, raster->pixels + k * row, row);
    }
    bool good = plain && packed && compress(packed, &size, plain, rows * (row + 1)) == Z_OK;
    free(plain);
    *length = sizeof signature + 4 * FRAME + HEADER + PALETTE + size;
    uint8_t *file = good ? malloc(*length) : NULL;
    if (file) {
        put_u32(put_u32(header, (uint32_t)raster->width), (uint32_t)raster->height);
        memcpy(file, signature, sizeof signature);
        uint8_t *at = put_chunk(file + sizeof signature, "IHDR", header, HEADER);
        at = put_chunk(at, "PLTE", raster->palette[0], PALETTE);
        at = put_chunk(at, "IDAT", packed, size);
        put_chunk(at, "IEND", NULL, 0);
    }
    free(packed);
    return file;
}
