/* SPDX-License-Identifier: MIT */
/*
 * Pieces as pattern systems exchange them: DXF R12 by the conventions of ASTM D6673-10, whose
 * layers up to 14 are AAMA's. A piece is a block of its own, in millimetres, with the grain line
 * along x; layers have numbers for names. What is common to all is text on layer 1 of the drawing,
 * what is said of a piece is text on layer 1 of its block, each as `Key: value`. Of each polygon
 * there is a curve a second time, by which a reader checks what it has made of the first.
 */
#include "cut_sheet.h"

#include "dxf_writer.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { LETTER = 5, NOTCH = 5 /* mm: the height of letters, the depth of slits */ };

/* Where the edge turns by more than so much it is a turn point, else a curve point. */
static const double turn_deg = 20, degrees = 57.295779513082321;

/* Names of layers: a line of the cloth, and the curve to check it by. */
struct line_layers {
    const char *line, *check;
};
static const struct line_layers boundary = {"1", "84"}, cutout = {"11", "86"}, seam = {"14", "87"};

struct astm {
    struct api_text *text;
    double mm; /* of the sheet's unit */
};

/* ---- lines ---- */

static const char *point_layer(const struct polygons_point *before, const struct polygons_point *at,
                               const struct polygons_point *next) {
    double a[2] = {at->x - before->x, at->y - before->y}, b[2] = {next->x - at->x, next->y - at->y};
    double turn = atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
    return fabs(turn) * degrees > turn_deg ? "2" : "3";
}

/* A polygon of `count` corners. */
static void write_polygon(const struct astm *astm, const struct polygons_point *p, size_t count,
                          const struct line_layers *layers) {
    for (int curve = 0; curve < 2; curve++)
        for (size_t k = 0; k < count; k++)
            dxf_corner(astm->text, curve ? layers->check : layers->line, p[k].x * astm->mm,
                       p[k].y * astm->mm, k == 0, k + 1 == count);
    for (size_t k = 0; k < count; k++)
        dxf_point(astm->text, point_layer(&p[(k + count - 1) % count], &p[k], &p[(k + 1) % count]),
                  p[k].x * astm->mm, p[k].y * astm->mm, 0, 0);
}

/* All polygons: what encloses cloth turns to the left, a hole to the right. */
static void write_polygons(const struct astm *astm, const struct polygons *polygons,
                           const struct line_layers *outer, const struct line_layers *hole) {
    for (size_t first = 0, end; first < polygons->count; first = end) {
        bool encloses = polygons_loop_area(polygons, first, &end) > 0;
        write_polygon(astm, &polygons->points[first], end - first, encloses ? outer : hole);
    }
}

/* ---- pieces ---- */

/* Lines of text below each other. */
static void write_lines(const struct astm *astm, const char *layer, double x, double y,
                        const char *const *lines, size_t count) {
    for (size_t k = 0; k < count; k++)
        dxf_letters(astm->text, layer, x, y - 1.5 * LETTER * (double)k, LETTER, lines[k]);
}

/* A name of a block of R12. */
static void block_name(const struct cut_piece *piece, char name[CUT_NAME_SIZE]) {
    size_t length = strlen(piece->name);
    for (size_t k = 0; k <= length; k++)
        name[k] = (char)(piece->name[k] && !isalnum((unsigned char)piece->name[k])
                             ? '_'
                             : toupper((unsigned char)piece->name[k]));
}

static void write_piece(const struct astm *astm, const struct cut_sheet *sheet,
                        const struct cut_roll *roll, size_t k) {
    const struct cut_piece *piece = &roll->pieces[k];
    const struct nesting_shape *shape = &roll->shapes[k];
    const struct cut_chord grain = cut_chord_of(shape);
    double mm = astm->mm, quarter = (grain.x[1] - grain.x[0]) / 4;
    double x = (grain.x[0] + quarter) * mm, y = grain.y * mm;
    char block[CUT_NAME_SIZE], name[CUT_NAME_SIZE + 16], quantity[40], note[CUT_TEXT_SIZE];
    char material[CUT_TITLE_SIZE + 16], revision[API_ID_SIZE + 16];
    (void)snprintf(name, sizeof name, "Piece Name: %s", piece->name);
    (void)snprintf(quantity, sizeof quantity, "Quantity: %d,0", shape->layers);
    (void)snprintf(note, sizeof note, "Annotation: %s, revision %s", piece->title, sheet->revision);
    (void)snprintf(material, sizeof material, "Material: %s", roll->cloth);
    (void)snprintf(revision, sizeof revision, "revision %s", sheet->revision);
    const char *const said[] = {name, "Size: 1", quantity, note, material};
    const char *const shown[] = {piece->title, revision};
    block_name(piece, block);
    dxf_block(astm->text, "1", block);
    write_polygons(astm, shape->cut, &boundary, &cutout);
    if (piece->seam)
        write_polygons(astm, piece->seam, &seam, &seam);
    for (size_t n = 0; n < piece->notch_count; n++) {
        const struct pattern_notch *notch = &piece->notches[n];
        dxf_point(astm->text, "4", notch->p * mm, notch->q * mm, NOTCH,
                  atan2(notch->in[1], notch->in[0]) * degrees);
    }
    dxf_line(astm->text, "7", x, y, x + 2 * quarter * mm, y);
    if (polygons_contain(shape->cut, 0, 0)) /* the start of the drape is a mark to be punched */
        dxf_point(astm->text, "13", 0, 0, 0, 0);
    if (piece->zero[0] != 0 || piece->zero[1] != 0)
        dxf_line(astm->text, "8", 0, 0, quarter * mm * piece->zero[0],
                 quarter * mm * piece->zero[1]);
    write_lines(astm, "1", x, y - 5 * LETTER, said, *roll->cloth ? 5 : 4);
    write_lines(astm, "15", x, y - 2 * LETTER, shown, 2);
    dxf_block_end(astm->text, "1");
}

/* Each piece once, where its first layer lies on the roll. */
static void write_inserts(const struct astm *astm, const struct cut_roll *roll) {
    for (size_t n = 0; n < roll->place_count; n++) {
        const struct nesting_place *place = &roll->places[n];
        char block[CUT_NAME_SIZE];
        double at[2];
        if (place->layer)
            continue;
        nesting_point(&roll->shapes[place->shape], place, 0, 0, at);
        block_name(&roll->pieces[place->shape], block);
        dxf_insert(astm->text, "1", block, (roll->from + at[0]) * astm->mm, at[1] * astm->mm,
                   place->turned ? 180 : 0);
    }
}

void cut_sheet_write_astm(const struct cut_sheet *sheet, struct api_text *text) {
    static const struct dxf_layer layers[] = {
        {"1", DXF_WHITE}, {"2", DXF_RED},    {"3", DXF_YELLOW}, {"4", DXF_MAGENTA},
        {"7", DXF_GREEN}, {"8", DXF_BLUE},   {"11", DXF_WHITE}, {"13", DXF_CYAN},
        {"14", DXF_BLUE}, {"15", DXF_GREEN}, {"84", DXF_WHITE}, {"86", DXF_WHITE},
        {"87", DXF_WHITE}};
    const struct astm astm = {text, sheet->unit->metres * 1000};
    const struct cut_roll *end = &sheet->rolls[sheet->roll_count - 1];
    char style[CUT_NAME_SIZE + 16], author[64];
    (void)snprintf(style, sizeof style, "Style Name: %.20s", sheet->style);
    (void)snprintf(author, sizeof author, "Author: draped;drape;%s", DRAPE_VERSION);
    const char *const said[] = {style,
                                author,
                                "Sample Size: 1",
                                "Grade Rule Table: NONE",
                                "Units: METRIC",
                                "ASTM/D13Proposal 1 Version: D6673-10"};
    size_t lines = sizeof said / sizeof *said;
    const double low[2] = {0, -2.0 * LETTER * (double)lines},
                 high[2] = {(end->from + end->length) * astm.mm, sheet->width * astm.mm};
    dxf_head(text, "mm", low, high, layers, sizeof layers / sizeof *layers);
    dxf_section(text, "BLOCKS");
    for (size_t r = 0; r < sheet->roll_count; r++)
        for (size_t k = 0; k < sheet->rolls[r].count; k++)
            write_piece(&astm, sheet, &sheet->rolls[r], k);
    dxf_section_end(text);
    dxf_section(text, "ENTITIES");
    write_lines(&astm, "1", 0, -2 * LETTER, said, lines);
    for (size_t r = 0; r < sheet->roll_count; r++)
        write_inserts(&astm, &sheet->rolls[r]);
    dxf_section_end(text);
    dxf_foot(text);
}
