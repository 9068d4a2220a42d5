/* SPDX-License-Identifier: MIT */
#include "cell_corners.h"

static bool begin_sites(struct site_reader *places, const struct api_reader *reader,
                        const struct api_columns *columns, enum api_table table) {
    *places = (struct site_reader){.reader = reader};
    places->column[0] = api_columns_find(columns, table, "i");
    places->column[1] = api_columns_find(columns, table, "j");
    return places->column[0] && places->column[1] && places->column[0]->rows <= INT32_MAX;
}

bool cell_corners_begin(struct cell_corners *quads, const struct api_reader *reader,
                        const struct api_columns *columns) {
    return begin_sites(&quads->cells, reader, columns, API_TABLE_CELLS) &&
           begin_sites(&quads->low, reader, columns, API_TABLE_NODES) &&
           begin_sites(&quads->high, reader, columns, API_TABLE_NODES);
}

/* The block with the current row; false beyond the last one. */
static bool load_block(struct site_reader *places) {
    size_t left = places->column[0]->rows - places->row;
    places->first = places->row;
    places->held = left < CELL_CORNERS_BLOCK ? left : CELL_CORNERS_BLOCK;
    for (int k = 0; k < 2 && places->held; k++)
        if (!api_columns_read(places->reader, places->column[k], places->first, places->held,
                              places->block[k]))
            places->held = 0;
    return places->held > 0;
}

static inline bool current(struct site_reader *places, double *i, double *j) {
    if (places->row - places->first >= places->held && !load_block(places))
        return false;
    *i = places->block[0][places->row - places->first];
    *j = places->block[1][places->row - places->first];
    return true;
}

/* Goes forward to (i, j). */
static bool seek_site(struct site_reader *places, double i, double j) {
    double at_i, at_j;
    while (current(places, &at_i, &at_j)) {
        if (at_j == j && at_i == i)
            return true;
        if (at_j > j || (at_j == j && at_i > i))
            return false;
        places->row++;
    }
    return false;
}

/* In a row sorted by i the node (i+1, j), which a cell has, comes right after (i, j). */
bool cell_corners_next(struct cell_corners *quads, size_t count, int32_t (*corners)[4],
                       int32_t (*places)[2]) {
    size_t nodes = quads->low.column[0]->rows;
    for (size_t k = 0; k < count; k++, quads->cells.row++) {
        double i, j;
        if (!current(&quads->cells, &i, &j) || !seek_site(&quads->low, i, j) ||
            !seek_site(&quads->high, i, j + 1) || quads->high.row + 1 >= nodes)
            return false;
        int32_t low = (int32_t)quads->low.row, high = (int32_t)quads->high.row;
        corners[k][0] = low;
        corners[k][1] = low + 1;
        corners[k][2] = high + 1;
        corners[k][3] = high;
        if (places) {
            places[k][0] = (int32_t)i;
            places[k][1] = (int32_t)j;
        }
    }
    return true;
}
