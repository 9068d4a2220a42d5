/* SPDX-License-Identifier: MIT */
/*
 * The ply book: one HTML page to print and file, without scripts, links or anything from elsewhere.
 * The sequence of the plies with direction, start, area and mass; then each with its flat pattern,
 * what its drape says and its warnings.
 */
#ifndef API_LAMINATE_PLY_BOOK_H
#define API_LAMINATE_PLY_BOOK_H

#include "api/format/cut_sheet.h"
#include "flat_plies.h"

/* Of a laminate with its nets and their shapes, as they are cut from rolls. A net that cannot be
 * read is said to be so. */
void ply_book_write(const struct laminate *laminate, const struct api_reader *const *nets,
                    const struct flat_plies *shapes, const struct cut_sheet *sheet,
                    struct api_text *text);

#endif
