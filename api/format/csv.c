/* SPDX-License-Identifier: MIT */
/* One table, nodes or cells of a result or the rows of a map, as lines of comma-separated values
 * under a line of names. */
#include "encoder.h"
#include <string.h>

/* Some rows, whose columns lie side by side in `values`; the names before the first. A value is a
 * number, nothing where there is none, or the name of a variant's failure. */
static void next_csv(struct encoder *encoder) {
    size_t rows = encoder->selected[0].rows;
    size_t count = encoder_left(encoder, rows, ENCODER_VALUES / encoder->count);
    for (size_t i = 0; i < encoder->count && !encoder->begun; i++)
        api_text_format(&encoder->piece, "%s%s", encoder->selected[i].name,
                        i + 1 < encoder->count ? "," : "\n");
    encoder->begun = true;
    for (size_t i = 0; i < encoder->count; i++)
        if (!encoder_fill(encoder, &encoder->selected[i], encoder->row, count,
                          encoder->values + i * count))
            return;
    char *at = encoder->piece.bytes + encoder->piece.length;
    for (size_t row = 0; row < count; row++)
        for (size_t i = 0; i < encoder->count; i++) {
            const struct api_column_source *column = &encoder->selected[i];
            double value = encoder->values[i * count + row];
            bool failure =
                column->table == API_TABLE_VARIANTS && strcmp(column->name, "failure") == 0;
            if (failure && value >= 0 && value < FAILURE_COUNT)
                at = stpcpy(at, failure_names[(int)value]);
            else
                at += encoder_value(encoder, column, value, at);
            *at++ = i + 1 < encoder->count ? ',' : '\n';
        }
    encoder->piece.length = (size_t)(at - encoder->piece.bytes);
    encoder->ended = encoder_advance(encoder, rows, count);
}

const struct format format_csv = {.name = "csv",
                                  .media_type = "text/csv",
                                  .about = "one table: a row for each node, cell or point",
                                  .exact = "every bit; `precision` rounds",
                                  .uses = FORMAT_RESULT | FORMAT_MAP,
                                  .tables = true,
                                  .one_table = true,
                                  .next = next_csv};
