/* SPDX-License-Identifier: MIT */
#include "flat_plies.h"

#include "api/map/net.h"
#include "api/result/shear_limit.h"
#include "plane.h"
#include "region.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* As of the pattern of a drape: what points of the rim are left out for, in spacings. */
static const double tolerance = 5e-4;

static const double degrees = 57.295779513082321;

/* The loops of a boundary turned so that they enclose what is on their left, holes the other way
 * round, in (p, q). */
static bool oriented_loops(const struct region *region, struct polygons *loops) {
    for (size_t n = 0; n < region->loop_count; n++) {
        size_t low = region->first[n], count = region->first[n + 1] - low;
        double sum = 0;
        for (size_t k = 0; k < count; k++) {
            const double *a = region->points[low + k], *b = region->points[low + (k + 1) % count];
            sum += a[0] * b[1] - b[0] * a[1];
        }
        int depth = 0; /* of this loop within the others */
        for (size_t m = 0; m < region->loop_count; m++) {
            struct polygons one = {0};
            bool good = true;
            for (size_t k = region->first[m]; good && m != n && k < region->first[m + 1]; k++)
                good = polygons_add(&one, region->points[k][0], region->points[k][1]);
            polygons_close(&one);
            depth += good && m != n &&
                     polygons_contain(&one, region->points[low][0], region->points[low][1]);
            polygons_free(&one);
            if (!good)
                return false;
        }
        bool back = (sum > 0) == (depth % 2 == 1);
        for (size_t k = 0; k < count; k++) {
            const double *at = region->points[low + (back ? count - 1 - k : k)];
            if (!polygons_add(loops, at[0], at[1]))
                return false;
        }
        polygons_close(loops);
    }
    return true;
}

/* ---- the cells of a ply with a boundary ---- */

struct cell {
    int32_t i, j;
};

static int compare_ply_cells(const void *a, const void *b) {
    const struct cell *x = a, *y = b;
    return x->j != y->j ? (x->j > y->j) - (x->j < y->j) : (x->i > y->i) - (x->i < y->i);
}

/* The cells that a boundary passes, sorted; it is known by points half a spacing apart. */
static struct cell *cells_passed(const struct region *region, size_t *count, struct arena *arena) {
    *count = region->first[region->loop_count];
    struct cell *cells = arena_alloc(arena, *count, sizeof *cells);
    for (size_t k = 0; cells && k < *count; k++)
        cells[k] = (struct cell){(int32_t)floor(region->points[k][0]),
                                 (int32_t)floor(region->points[k][1])};
    if (cells)
        qsort(cells, *count, sizeof *cells, compare_ply_cells);
    return cells;
}

/* How many cells a ply has, whole ones and those that its edge passes, and the sum of the cosines
 * of their shear. */
struct cell_sums {
    double cosine[2];
    size_t count[2];
};

/* Takes the cells of a table, whole ones or those that the rim cuts, into the ply's numbers: those
 * whose middle lies within the boundary, or that it passes; of a piece, whose cloth goes on beyond
 * its splits in the net alone, only those that it has whole. False when they cannot be read. */
static bool add_cells_inside(const struct api_reader *reader, const struct api_columns *columns,
                             enum api_table table, const struct region *region,
                             const struct cell *passed, size_t passed_count,
                             const struct api_fabric *fabric, struct cell_sums *sums,
                             struct flat_ply *shape) {
    enum { BLOCK = 512, COLUMNS = 3 };
    static const char *const names[COLUMNS] = {"i", "j", "shear_deg"};
    double block[COLUMNS][BLOCK];
    size_t rows = api_columns_rows(columns, table);
    for (size_t first = 0, held; first < rows; first += held) {
        held = rows - first < BLOCK ? rows - first : BLOCK;
        for (int c = 0; c < COLUMNS; c++) {
            const struct api_column *column = api_columns_find(columns, table, names[c]);
            if (!column || !api_columns_read(reader, column, first, held, block[c]))
                return false;
        }
        for (size_t k = 0; k < held; k++) {
            const double middle[2] = {block[0][k] + 0.5, block[1][k] + 0.5};
            const struct cell key = {(int32_t)block[0][k], (int32_t)block[1][k]};
            double signed_deg = block[2][k], shear_deg = fabs(signed_deg);
            bool cut = bsearch(&key, passed, passed_count, sizeof *passed, compare_ply_cells);
            if (!cut && !region_contains(region, middle))
                continue;
            sums->cosine[cut] += cos(shear_deg / degrees);
            sums->count[cut]++;
            if (cut && shape->piece)
                continue;
            shape->max_shear_deg = fmax(shape->max_shear_deg, shear_deg);
            shape->locked_cells +=
                table == API_TABLE_CELLS && shear_limit_locks(fabric, signed_deg);
        }
    }
    return true;
}

/* The numbers of a ply from the cells within a region of its net, of that flat area. A cell of
 * sides a and b has the area a b cos(shear) on the part; of those that the edge passes the ply has
 * what its flat area leaves over, and their mean cosine. */
static enum api_problem_id
count_cells(const struct laminate *laminate, const struct api_reader *reader,
            const struct api_columns *columns, const struct region *region, double area,
            struct arena *arena, struct flat_ply *shape, struct api_problem *problem) {
    const struct api_fabric *fabric = &laminate->plies[shape->ply].drape.fabric;
    const double cell = columns->grid.spacing[0] * columns->grid.spacing[1];
    struct cell_sums sums = {0};
    size_t count;
    struct cell *passed = cells_passed(region, &count, arena);
    if (!passed)
        return api_problem_no_memory(problem, "the patterns");
    shape->max_shear_deg = 0;
    shape->locked_cells = shear_limit_given(fabric) ? 0 : -1;
    for (int k = 0; k < 2; k++)
        if (!add_cells_inside(reader, columns, k ? API_TABLE_CUT : API_TABLE_CELLS, region, passed,
                              count, fabric, &sums, shape))
            return map_net_damaged(problem);
    shape->surface = cell * sums.cosine[0];
    shape->surface += (area - cell * (double)sums.count[0]) *
                      (sums.count[1] ? sums.cosine[1] / (double)sums.count[1] : 1);
    return API_OK;
}

/* What of the cut lies within the ply's boundary, and what the cells there say. */
static enum api_problem_id clip_to_boundary(const struct laminate *laminate,
                                            const struct api_reader *reader, struct map_net *cloth,
                                            struct arena *arena, struct flat_ply *shape,
                                            struct api_problem *problem) {
    static const enum column_id kept[] = {COLUMN_CELLS_warp, COLUMN_CELLS_weft};
    const double *d = cloth->columns.grid.spacing;
    struct polygons loops = {0}, both = {0};
    struct region region;
    map_net_keep(cloth, kept, sizeof kept / sizeof *kept);
    if (map_net_load(reader, NULL, arena, cloth, problem) != API_OK ||
        region_make(laminate, shape->ply, cloth->facets, d, arena, &region, problem) != API_OK)
        return problem->id;
    if (!oriented_loops(&region, &loops))
        api_problem_no_memory(problem, "the patterns");
    else if (plane_combine(&loops, PLANE_BOTH, &shape->cut, &both, problem) == API_OK) {
        polygons_free(&shape->cut);
        shape->cut = both;
        double whole = polygons_area(&loops), area = polygons_area(&both);
        shape->area = area * d[0] * d[1];
        shape->covered = whole > 0 ? fmin(area / whole, 1) : 0;
        both = (struct polygons){0};
    }
    polygons_free(&both);
    polygons_free(&loops);
    if (problem->id == API_OK)
        (void)!count_cells(laminate, reader, &cloth->columns, &region, shape->area, arena, shape,
                           problem);
    return problem->id;
}

/* ---- notches ---- */

/* Whether (x, y) lies on an edge of the polygons, up to `slack`. */
static bool lies_on_edge(const struct polygons *polygons, double x, double y, double slack) {
    const struct polygons_point *p = polygons->points;
    for (size_t k = 0, first = 0; k < polygons->count; k++) {
        const struct polygons_point *next = &p[p[k].last ? first : k + 1];
        double way[2] = {next->x - p[k].x, next->y - p[k].y}, at[2] = {x - p[k].x, y - p[k].y};
        double length2 = way[0] * way[0] + way[1] * way[1];
        double share = length2 > 0 ? (at[0] * way[0] + at[1] * way[1]) / length2 : 0;
        share = fmin(fmax(share, 0), 1);
        first = p[k].last ? k + 1 : first;
        if (hypot(at[0] - share * way[0], at[1] - share * way[1]) <= slack)
            return true;
    }
    return false;
}

/* Keeps the notches of lips. */
static bool take_lip_notches(const struct flat_pattern *flat, const double d[2],
                             struct flat_ply *shape) {
    shape->notches = calloc(flat->notch_count + 1, sizeof *shape->notches);
    for (size_t k = flat->generator_notches; shape->notches && k < flat->notch_count; k++) {
        const struct pattern_notch *own = &flat->notches[k];
        /* at right angles to a lip, and so by the other spacing each */
        double in[2] = {own->in[0] * d[1], own->in[1] * d[0]}, size = hypot(in[0], in[1]);
        shape->notches[shape->lip_notches++] =
            (struct pattern_notch){own->p * d[0], own->q * d[1], {in[0] / size, in[1] / size}};
    }
    shape->notch_count = shape->lip_notches;
    return shape->notches != NULL;
}

/* Then, of the cut as it has become: the notches of lips that are still on its edge, and where the
 * generators cross it. */
static bool find_notches(struct flat_ply *shape, const double d[2]) {
    size_t kept = 0;
    struct pattern_notch *notches =
        realloc(shape->notches, (shape->lip_notches + 2 * shape->cut.count + 1) * sizeof *notches);
    if (!notches)
        return false;
    for (size_t k = 0; k < shape->lip_notches; k++)
        if (lies_on_edge(&shape->cut, notches[k].p, notches[k].q, 4 * tolerance * fmin(d[0], d[1])))
            notches[kept++] = notches[k];
    shape->notches = notches;
    shape->lip_notches = kept;
    shape->notch_count = kept + flat_pattern_generator_notches(&shape->cut, notches + kept);
    return true;
}

/* ---- pieces ---- */

/* Whether the boundary of a piece, but its splits, runs along where the net ended though the part
 * goes on. */
static bool ends_bare(const struct flat_pattern *flat, const struct flat_piece *piece,
                      const double d[2]) {
    static const double along = 0.02; /* in spacings */
    const struct polygons_point *p = piece->region.points;
    for (size_t k = 0, first = 0; k < piece->region.count; k++) {
        const struct polygons_point *next = &p[p[k].last ? first : k + 1];
        const double middle[2] = {(p[k].x + next->x) / 2 / d[0], (p[k].y + next->y) / 2 / d[1]};
        first = p[k].last ? k + 1 : first;
        for (size_t n = 0; n < flat->front_count && piece->numbers[k] < 0; n++) {
            const double *from = flat->fronts[n].from, *to = flat->fronts[n].to;
            double way[2] = {to[0] - from[0], to[1] - from[1]};
            double at[2] = {middle[0] - from[0], middle[1] - from[1]};
            double length = hypot(way[0], way[1]);
            double share = (at[0] * way[0] + at[1] * way[1]) / (length * length);
            if (share >= 0 && share <= 1 && fabs(at[0] * way[1] - at[1] * way[0]) <= along * length)
                return true;
        }
    }
    return false;
}

static void scale_polygons(struct polygons *polygons, const double d[2]) {
    for (size_t n = 0; n < polygons->count; n++) {
        polygons->points[n].x *= d[0];
        polygons->points[n].y *= d[1];
    }
}

/* What of the cloth lies in the region of the piece. */
static enum api_problem_id find_region(const struct laminate *laminate,
                                       const struct api_reader *reader, struct map_net *cloth,
                                       const struct flat_pattern *flat, struct arena *arena,
                                       struct flat_ply *shape, struct api_problem *problem) {
    static const enum column_id kept[] = {COLUMN_CELLS_warp, COLUMN_CELLS_weft};
    struct split_posts posts;
    map_net_keep(cloth, kept, sizeof kept / sizeof *kept);
    if (map_net_load(reader, NULL, arena, cloth, problem) != API_OK)
        return problem->id;
    shape->cloth = shape->cut;
    shape->cut = (struct polygons){0};
    scale_polygons(&shape->cloth, cloth->columns.grid.spacing);
    shape->piece = calloc(1, sizeof *shape->piece);
    if (!shape->piece || !split_posts_make(laminate->plies[shape->ply].pieces, arena, &posts))
        return api_problem_no_memory(problem, "the patterns");
    if (flat_piece_make(cloth, &shape->cloth, &posts, arena, shape->piece, problem) != API_OK)
        return problem->id;
    shape->partial = ends_bare(flat, shape->piece, cloth->columns.grid.spacing);
    shape->region_area = polygons_area(&shape->piece->region);
    return API_OK;
}

bool flat_plies_siblings(const struct flat_plies *shapes, const struct laminate *laminate,
                         size_t first, const struct flat_ply *siblings[LAMINATE_SIBLINGS_MAX]) {
    const struct laminate_ply *own = &laminate->plies[shapes->shapes[first].ply];
    memset(siblings, 0, LAMINATE_SIBLINGS_MAX * sizeof *siblings);
    for (size_t n = first; own->pieces && n < shapes->count; n++) {
        const struct laminate_ply *ply = &laminate->plies[shapes->shapes[n].ply];
        if (ply->number == own->number)
            siblings[ply->piece] = &shapes->shapes[n];
    }
    return own->pieces != NULL;
}

/* Makes the seams of a piece, and finds its numbers. */
static enum api_problem_id sew_piece(const struct laminate *laminate,
                                     const struct flat_ply *const *siblings,
                                     const struct api_reader *reader, struct map_net *cloth,
                                     struct arena *arena, struct flat_ply *shape,
                                     struct api_problem *problem) {
    const struct laminate_ply *ply = &laminate->plies[shape->ply];
    const struct laminate_pieces *pieces = ply->pieces;
    const struct flat_piece *all[LAMINATE_PIECES_MAX];
    struct region region, own;
    for (size_t n = 0; n < pieces->count; n++)
        all[n] = siblings[n] ? siblings[n]->piece : NULL;
    if (map_net_open(reader, cloth, problem) != API_OK)
        return problem->id;
    if (flat_piece_sew(all, pieces->count, ply->piece, pieces->count, &shape->cloth, &pieces->seam,
                       arena, &shape->cut, problem) != API_OK)
        return problem->id;
    const double *d = cloth->columns.grid.spacing;
    const struct polygons *in_region = &shape->piece->region; /* without what lies over others */
    if (!region_of_polygons(&shape->cut, d, arena, &region) ||
        !region_of_polygons(in_region, d, arena, &own))
        return api_problem_no_memory(problem, "the patterns");
    shape->area = polygons_area(&shape->cut);
    polygons_bounds(&shape->cut, shape->low, shape->high);
    if (!find_notches(shape, d))
        return api_problem_no_memory(problem, "the patterns");
    bool over = shape->area > shape->region_area;
    if (count_cells(laminate, reader, &cloth->columns, over ? &own : &region,
                    over ? shape->region_area : shape->area, arena, shape, problem) != API_OK)
        return problem->id;
    shape->region_surface = shape->surface;
    return count_cells(laminate, reader, &cloth->columns, &region, shape->area, arena, shape,
                       problem);
}

/* How much of the part all pieces of a ply cover, each what it has in its region: all of it where
 * none ends bare or has a gap, if that is what their areas say, too. These are sums over cells,
 * which lack 2.3e-3 of half a cap of a sphere that is 11 cells across, and 5e-4 of 43. */
static void cover_with_pieces(const struct laminate_pieces *pieces, struct flat_ply *first,
                              size_t count) {
    static const double least = 0.99;
    bool whole = count == pieces->count && pieces->seam.gap <= 0;
    double area = 0;
    for (size_t n = 0; n < count; n++) {
        area += first[n].region_surface;
        whole = whole && !first[n].partial;
    }
    for (size_t n = 0; n < count; n++)
        first[n].covered =
            whole && area > least * first[n].part_area ? 1 : fmin(area / first[n].part_area, 1);
}

/* Likewise of courses, whose gaps are asked for. */
static void cover_with_courses(const struct laminate *laminate, struct flat_ply *first,
                               size_t count) {
    double covered = 0, gaps = 0;
    for (size_t n = 0; n < count; n++) {
        const struct laminate_ply *ply = &laminate->plies[first[n].ply];
        const double *own = ply->pieces->pieces[ply->piece].figures;
        covered += own[COURSE_COVERAGE];
        gaps += own[COURSE_GAP_AREA] / first[n].part_area;
    }
    for (size_t n = 0; n < count; n++) {
        first[n].covered = fmin(covered, 1);
        first[n].partial = covered + gaps < DRAPE_COMPLETE_COVERAGE;
    }
}

/* The pieces of the ply whose first shape that is. */
static enum api_problem_id sew_pieces(const struct laminate *laminate,
                                      const struct api_reader *const *nets, size_t first,
                                      struct map_net *cloth, struct arena *arena,
                                      struct flat_plies *shapes, struct api_problem *problem) {
    const struct flat_ply *siblings[LAMINATE_SIBLINGS_MAX];
    size_t count = 0;
    if (!flat_plies_siblings(shapes, laminate, first, siblings))
        return API_OK;
    const struct laminate_ply *ply = &laminate->plies[shapes->shapes[first].ply];
    for (size_t n = 0; n < ply->pieces->count && problem->id == API_OK; n++) {
        struct arena_mark mark = arena_mark(arena);
        if (!siblings[n])
            continue;
        struct flat_ply *own = &shapes->shapes[first + count++];
        if (ply->pieces->courses)
            continue;
        (void)!sew_piece(laminate, siblings, nets[laminate->plies[own->ply].net], cloth, arena, own,
                         problem);
        arena_rewind(arena, mark);
    }
    if (ply->pieces->courses)
        cover_with_courses(laminate, &shapes->shapes[first], count);
    else
        cover_with_pieces(ply->pieces, &shapes->shapes[first], count);
    return problem->id;
}

/* The pattern and the numbers of a ply. */
static enum api_problem_id make_flat_ply(const struct laminate *laminate,
                                         const struct api_reader *reader, struct map_net *cloth,
                                         struct arena *arena, struct flat_ply *shape,
                                         struct api_problem *problem) {
    struct flat_pattern flat = {0};
    if (map_net_open(reader, cloth, problem) != API_OK)
        return problem->id;
    const struct api_summary *summary = &cloth->columns.summary;
    (void)!flat_pattern_make(&flat, reader, &cloth->columns, tolerance, problem);
    shape->part_area = summary->part_area;
    shape->cut = flat.polygons;
    flat.polygons = (struct polygons){0};
    if (problem->id == API_OK && !take_lip_notches(&flat, cloth->columns.grid.spacing, shape))
        api_problem_no_memory(problem, "the patterns");
    if (problem->id == API_OK && laminate_is_split(&laminate->plies[shape->ply])) {
        (void)!find_region(laminate, reader, cloth, &flat, arena, shape, problem);
        flat_pattern_free(&flat);
        return problem->id;
    }
    flat_pattern_free(&flat);
    shape->area = summary->flat_area;
    shape->covered = summary->cloth_coverage;
    shape->max_shear_deg = summary->max_shear_deg;
    shape->locked_cells = summary->locked_cells;
    if (problem->id == API_OK && laminate->plies[shape->ply].boundary.count)
        (void)!clip_to_boundary(laminate, reader, cloth, arena, shape, problem);
    shape->partial = shape->covered < DRAPE_COMPLETE_COVERAGE;
    if (problem->id == API_OK)
        scale_polygons(&shape->cut, cloth->columns.grid.spacing);
    polygons_bounds(&shape->cut, shape->low, shape->high);
    if (problem->id == API_OK && !find_notches(shape, cloth->columns.grid.spacing))
        api_problem_no_memory(problem, "the patterns");
    return problem->id;
}

enum api_problem_id flat_plies_make(const struct laminate *laminate,
                                    const struct api_reader *const *nets, int ply,
                                    struct arena *arena, struct flat_plies *shapes,
                                    struct api_problem *problem) {
    struct map_net *cloth = arena_alloc(arena, 1, sizeof *cloth);
    *shapes =
        (struct flat_plies){.shapes = arena_alloc(arena, laminate->count, sizeof *shapes->shapes)};
    if (!shapes->shapes || !cloth)
        return api_problem_no_memory(problem, "the patterns");
    for (size_t k = 0; k < laminate->count && problem->id == API_OK; k++) {
        const struct api_reader *reader = nets[laminate->plies[k].net];
        struct arena_mark mark = arena_mark(arena);
        if (!reader || (ply != LAMINATE_ALL && laminate->plies[k].number != (size_t)ply))
            continue;
        struct flat_ply *shape = &shapes->shapes[shapes->count++];
        *shape = (struct flat_ply){.ply = k};
        (void)!make_flat_ply(laminate, reader, cloth, arena, shape, problem);
        arena_rewind(arena, mark);
    }
    for (size_t n = 0; n < shapes->count && problem->id == API_OK; n++)
        if (n == 0 || laminate->plies[shapes->shapes[n - 1].ply].number !=
                          laminate->plies[shapes->shapes[n].ply].number)
            (void)!sew_pieces(laminate, nets, n, cloth, arena, shapes, problem);
    return problem->id;
}

bool flat_plies_concerns(const struct laminate *laminate, size_t k,
                         const struct api_warning *warning) {
    static const char *const whole[] = {"uncovered", "locked", "collapsed", "packing_exceeded",
                                        "components"};
    bool of_whole = false;
    for (size_t n = 0; n < sizeof whole / sizeof *whole; n++)
        of_whole = of_whole || strcmp(warning->code, whole[n]) == 0;
    return (laminate->plies[k].boundary.count == 0 && !laminate->plies[k].pieces) || !of_whole;
}

void flat_plies_free(struct flat_plies *shapes) {
    for (size_t k = 0; k < shapes->count; k++) {
        struct flat_ply *shape = &shapes->shapes[k];
        polygons_free(&shape->cut);
        polygons_free(&shape->cloth);
        free(shape->notches);
        if (shape->piece)
            flat_piece_free(shape->piece);
        free(shape->piece);
    }
    shapes->count = 0;
}
