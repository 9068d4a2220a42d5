/* SPDX-License-Identifier: MIT */
/* One table, nodes, cells or cuts of a result or the rows of a map, as lines of comma-separated
 * values under a line of names. */
#include "encoder.h"
#include <string.h>

/* A word as a field: in quotes, doubled within, where it has what ends one. */
static char *write_word(char *at, const char *word) {
    if (!strpbrk(word, ",\""))
        return stpcpy(at, word);
    *at++ = '"';
    for (; *word; word++) {
        if (*word == '"')
            *at++ = '"';
        *at++ = *word;
    }
    *at++ = '"';
    return at;
}

/* Some rows, whose columns lie side by side in `values`; the names before the first. A value is a
 * number, nothing where there is none, or a word: the name of a variant's failure, or of a cut,
 * which are so few that the piece has room for all. */
static void next_csv(struct encoder *encoder) {
    size_t rows = encoder->selected[0].rows;
    size_t count = encoder_left(encoder, rows, ENCODER_VALUES / encoder->count);
    for (size_t i = 0; i < encoder->count && !encoder->begun; i++)
        api_text_format(&encoder->piece, "%s%s", encoder->selected[i].name,
                        i + 1 < encoder->count ? "," : "\n");
    encoder->begun = true;
    bool words[API_COLUMNS_MAX];
    for (size_t i = 0; i < encoder->count; i++)
        words[i] = encoder_has_words(&encoder->selected[i]);
    for (size_t i = 0; i < encoder->count; i++)
        if (!encoder_fill(encoder, &encoder->selected[i], encoder->row, count,
                          encoder->values + i * count))
            return;
    char *at = encoder->piece.bytes + encoder->piece.length;
    for (size_t row = 0; row < count; row++)
        for (size_t i = 0; i < encoder->count; i++) {
            const struct api_column_source *column = &encoder->selected[i];
            double value = encoder->values[i * count + row];
            const char *word = words[i] ? encoder_word(encoder, column, value) : NULL;
            if (word)
                at = write_word(at, word);
            else
                at += encoder_value(encoder, column, value, at);
            *at++ = i + 1 < encoder->count ? ',' : '\n';
        }
    encoder->piece.length = (size_t)(at - encoder->piece.bytes);
    encoder->ended = encoder_advance(encoder, rows, count);
}

const struct format format_csv = {.name = "csv",
                                  .media_type = "text/csv",
                                  .about = "one table: a row for each node, cell, cut or point",
                                  .exact = "every bit; `precision` rounds",
                                  .uses = FORMAT_RESULT | FORMAT_MAP,
                                  .flow = true,
                                  .tables = true,
                                  .one_table = true,
                                  .next = next_csv};
