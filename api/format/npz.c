/* SPDX-License-Identifier: MIT */
/* NumPy's archive: a stored zip with an array of float64 for each column, "nodes.x" and so on. A
 * zip wants an array's checksum before its bytes, so each column is read twice. */
#include "encoder.h"
#include "zip.h"
#include <endian.h>
#include <stdio.h>
#include <string.h>
#include <zlib.h>

enum { VALUE = 8, ARRAY_HEADER = 128 };

struct state {
    uint64_t position; /* in the document, of the next piece */
    struct zip_entry entry[API_COLUMNS_MAX];
};

/* The next rows of a column as the bytes of the archive. */
static size_t read_array_rows(struct encoder *encoder, const struct api_column_source *column,
                              size_t first) {
    size_t left = column->rows - first, count = left < ENCODER_VALUES ? left : ENCODER_VALUES;
    encoder_fill(encoder, column, first, count, encoder->values);
    for (size_t k = 0; k < count; k++) {
        uint64_t bits;
        memcpy(&bits, &encoder->values[k], VALUE);
        bits = htole64(bits);
        memcpy(&encoder->values[k], &bits, VALUE);
    }
    return count;
}

/* An array's values stand behind a description (format 1.0), always ARRAY_HEADER bytes. The
 * directory of API_COLUMNS_MAX entries fits into one piece. */
static void next_npz(struct encoder *encoder) {
    enum { PREFIX = 10 };
    static const char magic[PREFIX] = {
        '\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0, ARRAY_HEADER - PREFIX};
    struct state *state = encoder->state;
    if (encoder->column < encoder->count) {
        const struct api_column_source *column = &encoder->selected[encoder->column];
        if (encoder->row == 0) {
            struct zip_entry *entry = &state->entry[encoder->column];
            char header[ARRAY_HEADER + 1];
            memcpy(header, magic, PREFIX);
            int length = PREFIX + snprintf(header + PREFIX, sizeof header - PREFIX,
                                           "{'descr': '<f8', 'fortran_order': False, "
                                           "'shape': (%zu,), }",
                                           column->rows);
            snprintf(header + length, sizeof header - (size_t)length, "%*s", ARRAY_HEADER - length,
                     "\n");
            uLong crc = crc32(0, (const Bytef *)header, ARRAY_HEADER);
            for (size_t row = 0, count; row < column->rows && !encoder->failed; row += count) {
                count = read_array_rows(encoder, column, row);
                crc = crc32_z(crc, (const Bytef *)encoder->values, count * VALUE);
            }
            entry->crc = (uint32_t)crc;
            entry->offset = state->position;
            zip_begin_entry(&encoder->piece, entry);
            api_text_bytes(&encoder->piece, header, ARRAY_HEADER);
        }
        size_t count = read_array_rows(encoder, column, encoder->row);
        api_text_bytes(&encoder->piece, encoder->values, count * VALUE);
        encoder_advance(encoder, column->rows, count);
    } else {
        zip_end(&encoder->piece, state->entry, encoder->count, state->position);
        encoder->ended = true;
    }
    state->position += encoder->piece.length;
}

/* Names and sizes of all entries; their headers are made once to know the length of the document.
 */
static bool begin_npz(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    struct api_text text = api_text_over(encoder->buffer, sizeof encoder->buffer);
    uint64_t length = 0;
    (void)problem;
    for (size_t k = 0; k < encoder->count; k++) {
        const struct api_column_source *column = &encoder->selected[k];
        struct zip_entry *entry = &state->entry[k];
        snprintf(entry->name, sizeof entry->name, "%s.%s.npy", api_table_name(column->table),
                 column->name);
        entry->size = entry->packed = ARRAY_HEADER + (uint64_t)column->rows * VALUE;
        entry->offset = length;
        text.length = 0;
        zip_begin_entry(&text, entry);
        length += text.length + entry->packed;
    }
    text.length = 0;
    zip_end(&text, state->entry, encoder->count, length);
    encoder->length = length + text.length;
    return true;
}

const struct format format_npz = {.name = "npz",
                                  .uses = FORMAT_RESULT,
                                  .tables = true,
                                  .media_type = "application/x-npz",
                                  .about = "NumPy archive: an array for each column",
                                  .exact = "every bit",
                                  .state_size = sizeof(struct state),
                                  .begin = begin_npz,
                                  .next = next_npz};
