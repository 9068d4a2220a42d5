/* SPDX-License-Identifier: MIT */
#include "pieces.h"

#include "disguise.h"
#include "tests/check.h"
#include <string.h>

static const double cubic_knots[] = {0, 0, 0, 0, 1, 1, 1, 1};

/* The loops of a piece in its shell's arena. */
static void trim_piece(struct pieces *pieces, int k, struct shell_patch *part,
                       struct arena *arena) {
    struct trim_loop *loops = arena_alloc(arena, 2, sizeof *loops);
    for (int n = 0; n < 2; n++) {
        struct outline *outline = &pieces->outline[k][n];
        for (int c = 0; c < outline->count; c++)
            outline->curve[c].points = (const double(*)[2])outline->point[c];
        if (outline->count)
            loops[part->loop_count++] = (struct trim_loop){.reversed = !outline->hole,
                                                           .curves = outline->curve,
                                                           .count = (size_t)outline->count};
    }
    part->loops = loops;
}

struct shell_patch *pieces_parts(struct pieces *pieces, struct arena *arena) {
    struct shell_patch *parts = arena_alloc(arena, (size_t)pieces->count, sizeof *parts);
    for (int k = 0; k < pieces->count; k++) {
        struct nurbs nurbs = shape_nurbs(&pieces->shape[k]);
        struct surface *surface;
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        parts[k].surface = surface;
        trim_piece(pieces, k, &parts[k], arena);
    }
    return parts;
}

struct shell *pieces_shell(struct pieces *pieces, struct arena *arena) {
    struct shell *shell = NULL;
    struct shell_fault fault;
    enum status status =
        shell_make(pieces_parts(pieces, arena), (size_t)pieces->count, 0, arena, &shell, &fault);
    if (status != STATUS_OK)
        print_error("status %d: fault %d of faces %d, %d, %d of %d at (%g, %g, %g)\n", status,
                    fault.kind, fault.face[0], fault.face[1], fault.face[2], pieces->count,
                    fault.at.x, fault.at.y, fault.at.z);
    assert_int_equal(status, STATUS_OK);
    return shell;
}

static void cut_lines(double low, double high, int count, uint64_t *seed, double *lines) {
    for (int k = 0; k <= count; k++)
        lines[k] = low + (high - low) * k / count;
    for (int k = 1; k < count; k++)
        lines[k] += random_between(seed, -0.3, 0.3) * (high - low) / count;
}

/* By lines of both directions, shuffled. */
static void cut_isolines(struct pieces *pieces, const struct shape *whole, uint64_t *seed) {
    const int count[2] = {1 + (int)(random_unit(seed) * 6), 2 + (int)(random_unit(seed) * 6)};
    double lower[2], upper[2], lines[2][PIECES_MAX + 1];
    int total = pieces->count = count[0] * count[1];
    shape_domain(whole, lower, upper);
    for (int k = 0; k < 2; k++)
        cut_lines(lower[k], upper[k], count[k], seed, lines[k]);
    for (int n = 0; n < total; n++) {
        int a = n / count[1], b = n % count[1];
        struct shape *piece = &pieces->shape[n];
        *piece = *whole;
        shape_cut(piece, &lines[0][a], &lines[1][b]);
        for (int k = 0; k < 2; k++)
            (void)disguise_direction(piece, k, seed);
        if (random_unit(seed) < 0.5)
            shape_transpose(piece);
    }
    for (int n = total - 1; n > 0; n--) {
        int other = (int)(random_unit(seed) * (n + 1));
        struct shape swap = pieces->shape[n];
        pieces->shape[n] = pieces->shape[other];
        pieces->shape[other] = swap;
    }
}

/* ---- joints at a slant, and islands ---- */

static void add_curve(struct outline *outline, const double from[2], const double to[2],
                      const double (*between)[2]) {
    double(*p)[2] = outline->point[outline->count];
    bool line = between == NULL;
    memcpy(p[0], from, sizeof p[0]);
    memcpy(p[line ? 1 : 3], to, sizeof p[0]);
    for (int k = 0; k < 2 && !line; k++)
        memcpy(p[1 + k], between[k], sizeof p[0]);
    outline->curve[outline->count++] = (struct trim_curve){
        .degree = line ? 1 : 3, .count = line ? 2 : 4, .knots = line ? NULL : cubic_knots};
}

static void put_back(double p[2], const double low[2], const double length[2],
                     const double map[2][2], bool swap) {
    for (int k = 0; k < 2; k++)
        p[k] = map[k][0] + map[k][1] * (low[k] + p[k] * length[k]);
    if (swap) {
        double x = p[0];
        p[0] = p[1];
        p[1] = x;
    }
}

/* The piece within its outlines, of a surface that goes on a little beyond them. */
static void make_piece(struct pieces *pieces, const struct shape *whole, int n, uint64_t *seed) {
    struct shape *piece = &pieces->shape[n];
    double lower[2], upper[2], length[2], box[2][2], map[2][2];
    shape_domain(whole, lower, upper);
    *piece = *whole;
    for (int k = 0; k < 2; k++) {
        double least = 1, most = 0, margin = random_between(seed, 0, 0.2);
        length[k] = upper[k] - lower[k];
        for (int c = 0; c < pieces->outline[n][0].count && !pieces->outline[n][0].hole; c++)
            for (size_t i = 0; i < pieces->outline[n][0].curve[c].count; i++) {
                least = fmin(least, pieces->outline[n][0].point[c][i][k]);
                most = fmax(most, pieces->outline[n][0].point[c][i][k]);
            }
        if (pieces->outline[n][0].hole) {
            least = 0;
            most = 1;
        }
        box[k][0] = fmax(least - margin, 0);
        box[k][1] = fmin(most + margin, 1);
        for (int e = 0; e < 2; e++)
            box[k][e] = box[k][e] == 1 ? upper[k] : lower[k] + box[k][e] * length[k];
    }
    shape_cut(piece, box[0], box[1]);
    for (int k = 0; k < 2; k++)
        disguise_affine(piece, k, seed, map[k]);
    bool swap = random_unit(seed) < 0.5;
    if (swap)
        shape_transpose(piece);
    for (int loop = 0; loop < 2; loop++)
        for (int c = 0; c < pieces->outline[n][loop].count; c++)
            for (size_t i = 0; i < pieces->outline[n][loop].curve[c].count; i++)
                put_back(pieces->outline[n][loop].point[c][i], lower, length,
                         (const double(*)[2])map, swap);
}

/* Cubics from v = 0 to v = 1 that do not meet, and the strips between them. */
static void cut_strips(struct pieces *pieces, const struct shape *whole, uint64_t *seed) {
    double line[PIECES_MAX + 1][4][2];
    int count = pieces->count = 2 + (int)(random_unit(seed) * 6);
    for (int k = 0; k <= count; k++)
        for (int i = 0; i < 4; i++) {
            bool end = k == 0 || k == count;
            line[k][i][0] = (double)k / count + (end ? 0 : random_between(seed, -0.4, 0.4) / count);
            line[k][i][1] = i / 3.0;
        }
    for (int k = 0; k < count; k++) {
        struct outline *o = &pieces->outline[k][0];
        double(*a)[2] = line[k], (*b)[2] = line[k + 1];
        const double back[2][2] = {{a[2][0], a[2][1]}, {a[1][0], a[1][1]}};
        add_curve(o, a[0], b[0], NULL);
        add_curve(o, b[0], b[3], (const double(*)[2])(b + 1));
        add_curve(o, b[3], a[3], NULL);
        add_curve(o, a[3], a[0], back);
        make_piece(pieces, whole, k, seed);
    }
}

/* Straight sides round moved points. */
void pieces_cut_grid(struct pieces *pieces, const struct shape *whole, int nu, int nv,
                     uint64_t *seed) {
    static double point[10][10][2];
    int n = 0;
    memset(pieces->outline, 0, sizeof pieces->outline);
    pieces->count = nu * nv;
    for (int i = 0; i <= nu; i++)
        for (int j = 0; j <= nv; j++) {
            bool in_u = i > 0 && i<nu, in_v = j> 0 && j < nv;
            point[i][j][0] = (i + (in_u ? random_between(seed, -0.3, 0.3) : 0)) / nu;
            point[i][j][1] = (j + (in_v ? random_between(seed, -0.3, 0.3) : 0)) / nv;
        }
    for (int i = 0; i < nu; i++)
        for (int j = 0; j < nv; j++, n++) {
            struct outline *o = &pieces->outline[n][0];
            add_curve(o, point[i][j], point[i + 1][j], NULL);
            add_curve(o, point[i + 1][j], point[i + 1][j + 1], NULL);
            add_curve(o, point[i + 1][j + 1], point[i][j + 1], NULL);
            add_curve(o, point[i][j + 1], point[i][j], NULL);
            for (int c = 0; c < 4; c++)
                memcpy(pieces->corners[n][c], o->point[c][0], sizeof pieces->corners[n][c]);
            make_piece(pieces, whole, n, seed);
        }
}

static void cut_quads(struct pieces *pieces, const struct shape *whole, uint64_t *seed) {
    int nu = 1 + (int)(random_unit(seed) * 6), nv = 2 + (int)(random_unit(seed) * 5);
    pieces_cut_grid(pieces, whole, nu, nv, seed);
}

/* A rounded island in the whole, begun at different places by the two. */
static void cut_island(struct pieces *pieces, const struct shape *whole, uint64_t *seed) {
    double at[2], r = random_between(seed, 0.05, 0.25);
    pieces->count = 2;
    for (int k = 0; k < 2; k++)
        at[k] = random_between(seed, 0.3, 0.7);
    for (int n = 0; n < 2; n++) {
        int first = (int)(random_unit(seed) * 4);
        pieces->outline[n][0].hole = n == 0;
        for (int q = first; q < first + 4; q++) {
            static const int8_t corner[5][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 0}};
            double p[4][2];
            for (int k = 0; k < 2; k++) {
                double a = corner[q % 4][k], b = corner[q % 4 + 1][k];
                p[0][k] = at[k] + r * a;
                p[3][k] = at[k] + r * b;
                p[1][k] = at[k] + r * (a + 0.55 * b);
                p[2][k] = at[k] + r * (b + 0.55 * a);
            }
            add_curve(&pieces->outline[n][0], p[0], p[3], (const double(*)[2])(p + 1));
        }
        make_piece(pieces, whole, n, seed);
    }
}

/* ---- slivers, short sides and sides that meet several ---- */

/* What is as small as what real files have: from nothing that can be seen to a thousandth of the
 * domain, at times nothing. */
static double small(uint64_t *seed) {
    double share = random_unit(seed);
    return share < 0.2 ? 0 : 1e-3 * pow(1e-6, share);
}

/* Cuts of a row at its lower and its upper end. */
enum { ROWS_MAX = 5, CUTS_MAX = 8 };
struct row {
    int count; /* of cuts, the row's own ends included */
    double at[CUTS_MAX][2];
};

static void add_cut(struct row *row, double low, double high) {
    row->at[row->count][0] = low;
    row->at[row->count++][1] = high;
}

/* Some cuts are doubled, some all but meet one of the row below. */
static void cut_row(struct row *row, const struct row *below, uint64_t *seed) {
    int count = 1 + (int)(random_unit(seed) * 4);
    *row = (struct row){0};
    add_cut(row, 0, 0);
    for (int k = 1; k < count; k++) {
        double low = (k + random_between(seed, -0.3, 0.3)) / count;
        double high = (k + random_between(seed, -0.3, 0.3)) / count;
        for (int n = 1; below && n + 1 < below->count; n++)
            if (fabs(below->at[n][1] - low) < 0.15 / count && random_unit(seed) < 0.7)
                low = below->at[n][1] + small(seed);
        add_cut(row, low, high);
        if (random_unit(seed) < 0.3)
            add_cut(row, low + small(seed), high + small(seed));
    }
    add_cut(row, 1, 1);
}

/* A quadrilateral of a row; along v if `turned`. */
static void outline_brick(struct outline *o, const double (*at)[2], const double *v, bool turned) {
    const double x[4] = {at[0][0], at[1][0], at[1][1], at[0][1]};
    double corner[5][2];
    for (int k = 0; k < 5; k++) {
        corner[k][turned] = x[k % 4];
        corner[k][!turned] = v[k % 4 / 2];
    }
    for (int k = 0; k < 4; k++)
        add_curve(o, corner[k], corner[k + 1], NULL);
}

static void cut_bricks(struct pieces *pieces, const struct shape *whole, uint64_t *seed) {
    struct row row[ROWS_MAX + 1];
    double line[2 * ROWS_MAX];
    bool turned = random_unit(seed) < 0.5;
    int wanted = 1 + (int)(random_unit(seed) * 3), rows = 0;
    pieces->count = 0;
    for (int k = 0; k <= wanted; k++) {
        bool inner = k > 0 && k < wanted;
        line[rows++] = (k + (inner ? random_between(seed, -0.3, 0.3) : 0)) / wanted;
        if (inner && random_unit(seed) < 0.3) {
            double height = small(seed);
            line[rows] = line[rows - 1] + height;
            rows += height > 0;
        }
    }
    for (int n = 0; n + 1 < rows; n++) {
        cut_row(&row[n], n ? &row[n - 1] : NULL, seed);
        for (int k = 0; k + 1 < row[n].count; k++) {
            const double(*at)[2] = (const double(*)[2])(row[n].at + k);
            if (at[0][0] == at[1][0] && at[0][1] == at[1][1])
                continue; /* nothing of it is left */
            outline_brick(&pieces->outline[pieces->count][0], at, line + n, turned);
            make_piece(pieces, whole, pieces->count++, seed);
        }
    }
}

void pieces_cut(struct pieces *pieces, enum cutting cutting, const struct shape *whole,
                uint64_t *seed) {
    void (*const cuts[])(struct pieces *, const struct shape *, uint64_t *) = {
        cut_isolines, cut_strips, cut_quads, cut_island, cut_bricks};
    memset(pieces->outline, 0, sizeof pieces->outline);
    cuts[cutting](pieces, whole, seed);
}

const char *cutting_name(enum cutting cutting) {
    static const char *const names[] = {"isolines", "strips", "quads", "island", "bricks"};
    return names[cutting];
}

/* ---- what is wrong with them ---- */

static void swap_coordinates(struct outline *outline) {
    for (int c = 0; c < outline->count; c++)
        for (size_t i = 0; i < outline->curve[c].count; i++) {
            double *p = outline->point[c][i], x = p[0];
            p[0] = p[1];
            p[1] = x;
        }
}

void pieces_disturb(struct pieces *pieces, double gap, uint64_t *seed) {
    for (int n = 0; n < pieces->count; n++) {
        struct motion motion = motion_identity();
        motion.shift = vec3_make(random_between(seed, -gap, gap), random_between(seed, -gap, gap),
                                 random_between(seed, -gap, gap));
        shape_move(&pieces->shape[n], &motion);
    }
    if (pieces->count < PIECES_MAX && random_unit(seed) < 0.5) {
        int twin = (int)(random_unit(seed) * pieces->count), last = pieces->count++;
        pieces->shape[last] = pieces->shape[twin];
        memcpy(pieces->outline[last], pieces->outline[twin], sizeof pieces->outline[twin]);
        shape_transpose(&pieces->shape[last]);
        for (int loop = 0; loop < 2; loop++)
            swap_coordinates(&pieces->outline[last][loop]);
    }
}

void pieces_stretch(struct pieces *pieces, double share, uint64_t *seed) {
    for (int n = 0; n < pieces->count; n++) {
        struct outline *outline = &pieces->outline[n][0];
        double by = 1 + random_between(seed, -share, share), lower[2], upper[2], middle[2] = {0, 0};
        int points = 0;
        shape_domain(&pieces->shape[n], lower, upper);
        for (int c = 0; c < outline->count; c++)
            for (size_t i = 0; i < outline->curve[c].count; i++, points++)
                for (int k = 0; k < 2; k++)
                    middle[k] += outline->point[c][i][k];
        for (int c = 0; c < outline->count; c++)
            for (size_t i = 0; i < outline->curve[c].count; i++)
                for (int k = 0; k < 2; k++) {
                    double at = middle[k] / points, *p = &outline->point[c][i][k];
                    bool on_border = *p == lower[k] || *p == upper[k];
                    *p = on_border ? *p : fmin(fmax(at + by * (*p - at), lower[k]), upper[k]);
                }
    }
}
