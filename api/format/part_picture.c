/* SPDX-License-Identifier: MIT */
#include "part_picture.h"

#include "api/result/cell_corners.h"
#include "api/result/fields.h"
#include "api/result/stored_rim.h"
#include "colour.h"
#include <math.h>
#include <string.h>

enum {
    WIDTH = 1500, /* pixels: 200 an inch on a page of A4 */
    HEIGHT = 1000,
    MARGIN = 30,
    BLOCK = 512, /* rows read at a time */
    YARNS = 24,  /* about as many along the longer side */
    HATCH = 4    /* pixels */
};

enum { CUT_I, CUT_J, CUT_CORNERS, CUT_SHEAR = CUT_CORNERS + 12, CUT_LOCKED, CUT_COLUMNS };

/* The colours: paper, shades of shear, the same darker below yarns, and these. */
enum { SHADE = 1, DARK = SHADE + PICTURE_SHADES, LOCKED = DARK + PICTURE_SHADES, RIM, WARP, WEFT };

static const uint8_t marks[][3] = {
    {0xc0, 0x00, 0x1a}, {0x1b, 0x23, 0x30}, {0xb4, 0x5f, 0x06}, {0x0b, 0x6a, 0xa2}};

static const double yarn_shade = 0.72;     /* of the colour below it */
static const double least_range_deg = 1;   /* below it the colours do not spread */
static const double closed = 0.2;          /* share of the area that faces one way, at the most */
static const double view[] = {0.35, -0.7}; /* along warp and weft beside 1 along the normal */
static const double lift = 3;              /* pixels that lines lie above the cells */

void part_picture_colour(double share, uint8_t rgb[3]) {
    double srgb[3];
    colour_viridis(share, srgb);
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(255 * srgb[c] + 0.5);
}

/* ---- reading ---- */

/* Points of a table by their rows, which go forward but for steps within a block. */
struct points {
    const struct api_column *column[4]; /* x, y, z, and of a rim the loop */
    size_t first, held;
    double block[4][BLOCK];
};

struct scene {
    struct part_picture *picture;
    const struct api_reader *reader;
    const struct api_columns *columns;
    const struct api_column *shear, *locked; /* of the cells; `locked` may be NULL */
    struct points low, high;                 /* corners on both sides of a row of cells */
    struct cell_corners quads;
    struct vec3 origin, axis[3]; /* to the right, down, to the eye */
    double shift[2];             /* the pixel of the origin */
    int height;                  /* of the picture */
    double shear_deg[BLOCK], is_locked[BLOCK];
    int32_t corners[BLOCK][4], places[BLOCK][2];
    struct vec3 area;  /* the cells' areas, as vectors */
    double area_total; /* and as numbers */
    int32_t last[2];   /* the greatest i of cells along the warp generator, j along the weft's */
    /* Of the cells that the rim cuts: i, j, the corners, the shear, whether they are locked. */
    const struct api_column *cut[CUT_COLUMNS];
    double cut_block[CUT_COLUMNS][BLOCK];
    struct stored_rim *edge;
};

static bool find_point_columns(const struct scene *scene, enum api_table table,
                               struct points *points) {
    static const char *const names[] = {"x", "y", "z", "loop"};
    points->held = 0;
    for (int k = 0; k < 4; k++)
        points->column[k] = api_columns_find(scene->columns, table, names[k]);
    return points->column[0] && points->column[1] && points->column[2];
}

static bool read_corner(const struct scene *scene, struct points *points, size_t row,
                        struct vec3 *point) {
    if (row < points->first || row >= points->first + points->held) {
        size_t left = points->column[0]->rows - row;
        points->first = row;
        points->held = left < BLOCK ? left : BLOCK;
        for (int k = 0; k < 4; k++)
            if (points->column[k] && !api_columns_read(scene->reader, points->column[k], row,
                                                       points->held, points->block[k]))
                return false;
    }
    size_t at = row - points->first;
    *point = vec3_make(points->block[0][at], points->block[1][at], points->block[2][at]);
    return true;
}

/* The edges of a cell: two along warp, two along weft. */
static const int edges[4][2] = {{0, 1}, {3, 2}, {0, 3}, {1, 2}};
enum { ALL_EDGES = 15 };

/* A cell or a strip of one: its corners in turn, the place of the cell, which edges (1 << k) are on
 * yarns. */
struct cell {
    struct vec3 corner[4];
    const int32_t *place;
    double shear_deg;
    bool locked;
    unsigned yarns;
};

typedef void visitor(struct scene *scene, const struct cell *cell);

/* Calls for every cell. False when they cannot be read. */
static bool visit_cells(struct scene *scene, visitor *visit) {
    size_t rows = scene->shear->rows, count;
    scene->low.held = scene->high.held = 0;
    if (!cell_corners_begin(&scene->quads, scene->reader, scene->columns))
        return false;
    for (size_t first = 0; first < rows; first += count) {
        count = rows - first < BLOCK ? rows - first : BLOCK;
        memset(scene->is_locked, 0, sizeof scene->is_locked);
        if (!cell_corners_next(&scene->quads, count, scene->corners, scene->places) ||
            !api_columns_read(scene->reader, scene->shear, first, count, scene->shear_deg) ||
            (scene->locked &&
             !api_columns_read(scene->reader, scene->locked, first, count, scene->is_locked)))
            return false;
        for (size_t k = 0; k < count; k++) {
            struct cell cell = {.place = scene->places[k],
                                .shear_deg = scene->shear_deg[k],
                                .locked = scene->is_locked[k] > 0,
                                .yarns = ALL_EDGES};
            for (int c = 0; c < 4; c++)
                if (!read_corner(scene, c < 2 ? &scene->low : &scene->high,
                                 (size_t)scene->corners[k][c], &cell.corner[c]))
                    return false;
            visit(scene, &cell);
        }
    }
    return true;
}

/* ---- the view ---- */

/* Half the product of the diagonals. */
static void sum_area(struct scene *scene, const struct cell *cell) {
    const struct vec3 *corner = cell->corner;
    struct vec3 area =
        vec3_scale(0.5, vec3_cross(vec3_sub(corner[2], corner[0]), vec3_sub(corner[3], corner[1])));
    scene->area = vec3_add(scene->area, area);
    scene->area_total += vec3_norm(area);
}

/* In pixels; before the scale is set in length units. */
static void project_point(const struct scene *scene, struct vec3 point, double pixel[3]) {
    struct vec3 offset = vec3_sub(point, scene->origin);
    for (int k = 0; k < 3; k++)
        pixel[k] = scene->picture->scale * vec3_dot(offset, scene->axis[k]) +
                   (k < 2 ? scene->shift[k] : 0);
}

/* Where the eye is; then the box of nodes and rim, the start within, into the picture with a
 * margin. False when they cannot be read. */
static bool choose_view(struct scene *scene) {
    static const enum api_table tables[] = {API_TABLE_NODES, API_TABLE_RIM};
    double low[2] = {0, 0}, high[2] = {0, 0}, pixel[3];
    struct vec3 point;
    const struct api_start *start = &scene->columns->start;
    struct vec3 normal = vec3_unit(vec3_cross(start->warp, start->weft));
    if (vec3_norm(scene->area) > closed * scene->area_total)
        normal = vec3_unit(scene->area);
    struct vec3 along = vec3_axpy(-vec3_dot(start->warp, normal), normal, start->warp);
    if (vec3_norm(along) < closed)
        along = vec3_axpy(-vec3_dot(start->weft, normal), normal, start->weft);
    along = vec3_unit(along);
    struct vec3 across = vec3_cross(normal, along), *axis = scene->axis;
    axis[2] = vec3_unit(vec3_axpy(view[0], along, vec3_axpy(view[1], across, normal)));
    axis[0] = vec3_unit(vec3_cross(normal, axis[2]));
    axis[1] = vec3_cross(axis[0], axis[2]);
    scene->origin = start->point;
    scene->picture->scale = 1;
    for (int t = 0; t < 2; t++) {
        size_t rows = api_columns_rows(scene->columns, tables[t]);
        if (rows && !find_point_columns(scene, tables[t], &scene->low))
            return false;
        for (size_t row = 0; row < rows; row++) {
            if (!read_corner(scene, &scene->low, row, &point))
                return false;
            project_point(scene, point, pixel);
            for (int k = 0; k < 2; k++) {
                low[k] = fmin(low[k], pixel[k]);
                high[k] = fmax(high[k], pixel[k]);
            }
        }
    }
    double size[2] = {high[0] - low[0], high[1] - low[1]};
    double scale = fmin((WIDTH - 2 * MARGIN) / size[0], (HEIGHT - 2 * MARGIN) / size[1]);
    scene->picture->scale = isfinite(scale) ? scale : 1;
    for (int k = 0; k < 2; k++)
        scene->shift[k] = MARGIN - scene->picture->scale * low[k];
    scene->shift[0] += (WIDTH - 2 * MARGIN - scene->picture->scale * size[0]) / 2;
    scene->height = (int)ceil(scene->picture->scale * size[1]) + 2 * MARGIN;
    return find_point_columns(scene, API_TABLE_NODES, &scene->low);
}

/* ---- drawing ---- */

static void fill_cell(struct scene *scene, const struct cell *cell) {
    double pixel[4][3];
    double share = fmin(fabs(cell->shear_deg) / scene->picture->range_deg, 1);
    uint8_t colour = (uint8_t)(SHADE + (int)(share * (PICTURE_SHADES - 1) + 0.5));
    for (int c = 0; c < 4; c++)
        project_point(scene, cell->corner[c], pixel[c]);
    for (int k = 1; k < 3; k++) {
        raster_triangle(&scene->picture->raster, pixel[0], pixel[k], pixel[k + 1], colour, 0);
        if (cell->locked)
            raster_triangle(&scene->picture->raster, pixel[0], pixel[k], pixel[k + 1], LOCKED,
                            HATCH);
    }
}

static void draw_edge(struct scene *scene, struct vec3 from, struct vec3 to, int width,
                      const uint8_t *over) {
    double a[3], b[3];
    project_point(scene, from, a);
    project_point(scene, to, b);
    raster_line(&scene->picture->raster, a, b, width, lift, over);
}

/* What every colour becomes under a line of one colour, or under a yarn. */
static void under_line(int colour, uint8_t over[RASTER_COLOURS]) {
    for (int k = 0; k < RASTER_COLOURS; k++)
        over[k] = (uint8_t)(colour ? colour : k >= SHADE && k < DARK ? k + PICTURE_SHADES : k);
}

/* The cell's edges on yarns that are drawn: those of the generators in their colours, and where
 * these end, for their names. */
static void draw_yarns(struct scene *scene, const struct cell *cell) {
    uint8_t over[RASTER_COLOURS];
    for (int k = 0; k < 4; k++) {
        int family = k / 2, number = cell->place[1 - family] + k % 2;
        if (!(cell->yarns & 1u << k) || number % scene->picture->yarns)
            continue;
        under_line(number ? 0 : family ? WEFT : WARP, over);
        draw_edge(scene, cell->corner[edges[k][0]], cell->corner[edges[k][1]], number ? 1 : 3,
                  over);
        if (number == 0 && k % 2 == 0 && cell->place[family] >= scene->last[family]) {
            double pixel[3];
            scene->last[family] = cell->place[family];
            project_point(scene, cell->corner[family ? 3 : 1], pixel);
            memcpy(scene->picture->end[family], pixel, sizeof scene->picture->end[family]);
        }
    }
}

/* ---- the cells that the rim cuts ---- */

/* On the bilinear patch of a cell's corners, from a and b in 0..1. */
static struct vec3 point_in_cell(const struct cell *cell, double a, double b) {
    const struct vec3 *corner = cell->corner;
    struct vec3 low = vec3_axpy(a, vec3_sub(corner[1], corner[0]), corner[0]);
    struct vec3 high = vec3_axpy(a, vec3_sub(corner[2], corner[3]), corner[3]);
    return vec3_axpy(b, vec3_sub(high, low), low);
}

/* Strip k of n of a cell up to the rim, and half of those beside it. Its ends there are moved onto
 * the part's edge, from which the patch of a coarse cell keeps a distance. */
static void visit_strip(struct scene *scene, visitor *visit, const struct cell *cell, int k,
                        int n) {
    struct stretch_end stretch[STORED_RIM_STRETCHES][2];
    double i = cell->place[0], j = cell->place[1], middle = (k + 0.5) / n;
    double at[2] = {fmax(middle - 1.0 / n, 0), fmin(middle + 1.0 / n, 1)};
    size_t count = stored_rim_stretches(scene->edge, j + middle, i, i + 1, stretch);
    for (size_t s = 0; s < count; s++) {
        struct cell strip = *cell;
        for (int e = 0; e < 2; e++) {
            const struct stretch_end *end = &stretch[s][e];
            struct vec3 shift = {0};
            if (end->known)
                shift = vec3_sub(end->point, point_in_cell(cell, end->p - i, middle));
            for (int h = 0; h < 2; h++)
                strip.corner[edges[h][e]] = vec3_add(point_in_cell(cell, end->p - i, at[h]), shift);
        }
        strip.yarns = (k == 0) | (unsigned)(k == n - 1) << 1 |
                      (unsigned)(stretch[s][0].p <= i) << 2 |
                      (unsigned)(stretch[s][1].p >= i + 1) << 3;
        visit(scene, &strip);
    }
}

/* Calls for every strip, along warp and of a pixel's height, of these cells. False when they cannot
 * be read. */
static bool visit_cut(struct scene *scene, visitor *visit) {
    size_t rows = api_columns_rows(scene->columns, API_TABLE_CUT), count;
    double(*block)[BLOCK] = scene->cut_block;
    for (size_t first = 0; first < rows; first += count) {
        count = rows - first < BLOCK ? rows - first : BLOCK;
        for (int c = 0; c < CUT_COLUMNS; c++)
            if (c == CUT_LOCKED && !scene->cut[c])
                continue;
            else if (!scene->cut[c] ||
                     !api_columns_read(scene->reader, scene->cut[c], first, count, block[c]))
                return false;
        for (size_t k = 0; k < count; k++) {
            double low = HUGE_VAL, high = -HUGE_VAL, pixel[3];
            const int32_t place[2] = {(int32_t)block[CUT_I][k], (int32_t)block[CUT_J][k]};
            struct cell cell = {.place = place,
                                .shear_deg = block[CUT_SHEAR][k],
                                .locked = scene->cut[CUT_LOCKED] && block[CUT_LOCKED][k] > 0};
            for (int c = 0; c < 4; c++) {
                double(*corner)[BLOCK] = block + CUT_CORNERS + 3 * c;
                cell.corner[c] = vec3_make(corner[0][k], corner[1][k], corner[2][k]);
                project_point(scene, cell.corner[c], pixel);
                low = fmin(low, fmin(pixel[0], pixel[1]));
                high = fmax(high, fmax(pixel[0], pixel[1]));
            }
            int strips = (int)fmin(fmax(ceil(high - low), 1), WIDTH);
            for (int s = 0; s < strips; s++)
                visit_strip(scene, visit, &cell, s, strips);
        }
    }
    return true;
}

/* ---- the rim ---- */

/* Each point to the one before; the last of a loop to its first. */
static bool draw_rim(struct scene *scene) {
    size_t rows = api_columns_rows(scene->columns, API_TABLE_RIM);
    struct vec3 point, last = {0}, first = {0};
    uint8_t over[RASTER_COLOURS];
    double loop, before = -1;
    under_line(RIM, over);
    if (rows && !find_point_columns(scene, API_TABLE_RIM, &scene->low))
        return false;
    for (size_t row = 0; row < rows; row++, before = loop, last = point) {
        if (!read_corner(scene, &scene->low, row, &point))
            return false;
        loop = scene->low.block[3][row - scene->low.first];
        bool same = row && loop == before; /* both are whole numbers */
        if (row)
            draw_edge(scene, last, same ? point : first, 2, over);
        if (!same)
            first = point;
    }
    if (rows)
        draw_edge(scene, last, first, 2, over);
    return true;
}

static enum api_problem_id draw_scene(struct scene *scene, struct api_problem *problem) {
    static const char damaged[] = "the stored result is damaged";
    static const char *const names[] = {
        [CUT_I] = "i", [CUT_J] = "j", [CUT_SHEAR] = "shear_deg", [CUT_LOCKED] = "locked"};
    const struct api_grid *grid = &scene->columns->grid;
    struct raster *raster = &scene->picture->raster;
    double start[3];
    scene->shear = api_columns_find(scene->columns, API_TABLE_CELLS, "shear_deg");
    scene->locked = api_columns_find(scene->columns, API_TABLE_CELLS, "locked");
    for (int c = 0; c < CUT_COLUMNS; c++) {
        bool corner = c >= CUT_CORNERS && c < CUT_SHEAR;
        scene->cut[c] = api_columns_find(scene->columns, API_TABLE_CUT,
                                         corner ? api_fields_corners[c - CUT_CORNERS] : names[c]);
    }
    if (!scene->shear || !find_point_columns(scene, API_TABLE_NODES, &scene->low) ||
        !find_point_columns(scene, API_TABLE_NODES, &scene->high) ||
        !visit_cells(scene, sum_area) || !choose_view(scene))
        return api_problem_set(problem, API_INTERNAL, damaged);
    if (!raster_begin(raster, WIDTH, scene->height))
        return api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the picture");
    /* The palette: paper, shades, darker ones, and the marks' colours. */
    memset(raster->palette, 0xff, 3);
    for (int k = 0; k < PICTURE_SHADES; k++) {
        uint8_t *rgb = raster->palette[SHADE + k], *dark = raster->palette[DARK + k];
        part_picture_colour((double)k / (PICTURE_SHADES - 1), rgb);
        for (int c = 0; c < 3; c++)
            dark[c] = (uint8_t)(yarn_shade * rgb[c]);
    }
    memcpy(raster->palette[LOCKED], marks, sizeof marks);
    project_point(scene, scene->origin, start);
    for (int k = 0; k < 2; k++)
        scene->picture->start[k] = scene->picture->end[0][k] = scene->picture->end[1][k] = start[k];
    int warp = grid->warp[1] - grid->warp[0], weft = grid->weft[1] - grid->weft[0];
    scene->picture->yarns = 1 + (warp > weft ? warp : weft) / YARNS;
    if (!visit_cells(scene, fill_cell) || !visit_cut(scene, fill_cell) ||
        !visit_cells(scene, draw_yarns) || !visit_cut(scene, draw_yarns) || !draw_rim(scene))
        return api_problem_set(problem, API_INTERNAL, damaged);
    return API_OK;
}

enum api_problem_id part_picture_draw(struct part_picture *picture, const struct api_reader *reader,
                                      const struct api_columns *columns,
                                      struct api_problem *problem) {
    struct arena *arena = arena_new(SIZE_MAX);
    struct scene *scene = arena ? arena_alloc(arena, 1, sizeof *scene) : NULL;
    if (!scene) {
        arena_free(arena);
        return api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the picture");
    }
    scene->picture = picture;
    scene->reader = reader;
    scene->columns = columns;
    picture->range_deg = fmax(columns->summary.max_shear_deg, least_range_deg);
    enum api_problem_id id = stored_rim_make(reader, columns, arena, &scene->edge, problem);
    if (id == API_OK)
        id = draw_scene(scene, problem);
    arena_free(arena);
    return id;
}
