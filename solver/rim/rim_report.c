/* SPDX-License-Identifier: MIT */
#include "rim_report.h"

#include "node_shear.h"
#include "rim_lips.h"
#include "solver/angle.h"
#include "solver/fishnet/slide_formulas.h"
#include "solver/power.h"
#include "solver/team.h"
#include "solver/wide.h"
#include "statistics.h"
#include <stdlib.h>

/* Bins of the absolute shear: a hundredth of a degree or so. */
enum { BINS = DRAPE_SHEAR_BINS };

/* Areas by their shear: `change[b]` is by how much the density changes at bin b. From bin `end` on
 * there is none, nor are changes set after that. */
struct spread {
    double change[BINS + 2];
    int end;
    double area, moment; /* in all, and times the shear */
};

static const double bin_width = DRAPE_SHEAR_BIN;

INLINE int bin_of(double shear_deg) {
    double in_range = shear_deg < 0 ? 0 : shear_deg > 90 ? 90 : shear_deg;
    return (int)(in_range / bin_width);
}

static void spread_to(struct spread *s, int end) {
    for (int bin = s->end + 1; bin <= end; bin++)
        s->change[bin] = 0;
    s->end = end > s->end ? end : s->end;
}

/* Area that lies evenly in the bins `from` to the one before `to`, `each` in each; its shear is
 * `mean` in the mean. */
INLINE void spread_area(struct spread *s, double area, int from, int to, double each, double mean) {
    spread_to(s, to);
    s->change[from] += each;
    s->change[to] -= each;
    s->area += area;
    s->moment += area * mean;
}

static void add_spread(struct spread *to, const struct spread *more) {
    spread_to(to, more->end);
    for (int bin = 0; bin <= more->end; bin++)
        to->change[bin] += more->change[bin];
    to->area += more->area;
    to->moment += more->moment;
}

/* The area of each bin. */
static void list_spread(const struct spread *s, double cell, double area[BINS]) {
    double density = 0;
    for (int bin = 0; bin < BINS; bin++) {
        density += bin < s->end ? s->change[bin] : 0;
        area[bin] = bin < s->end && density > 0 ? density * cell : 0;
    }
}

/* The largest absolute shear so far, and where. */
struct most {
    double shear_deg, p, q;
    struct vec3 r;
};

static void raise_most(struct most *most, const struct most *by) {
    if (by->shear_deg > most->shear_deg)
        *most = *by;
}

static struct vec3 node_point(const struct drape_nodes *n, size_t k) {
    return vec3_make(n->x[k], n->y[k], n->z[k]);
}

/* In the order of nodes and cells. */
static bool node_comes_before(int32_t i, int32_t j, int32_t i2, int32_t j2) {
    return j < j2 || (j == j2 && i < i2);
}

/* The row of node (i, j), from a row on that is not behind it; both are sorted alike. */
static size_t seek_node(const struct drape_nodes *n, size_t from, int32_t i, int32_t j) {
    while (from < n->count && node_comes_before(n->i[from], n->j[from], i, j))
        from++;
    return from;
}

/* What is gathered of cloth; in lines of the cache of its own. */
struct sums {
    _Alignas(64) struct spread spread;
    struct spread negative; /* of that, whose shear is negative; where statistics ask for it */
    struct most most[2];    /* of cloth that is pinned, and that is grown */
    struct most side[2];    /* of positive and of negative shear */
    double flat;            /* area of the unsheared cloth */
    double grown;           /* sheared area of what is grown */
    double turned;          /* area times a power of its angle between warp and that wanted */
};

/* No more of the many bins is touched than there is shear. */
static void begin_sums(struct sums *sums) {
    struct spread *const spreads[] = {&sums->spread, &sums->negative};
    for (int k = 0; k < 2; k++) {
        spreads[k]->change[0] = 0;
        spreads[k]->end = 0;
        spreads[k]->area = spreads[k]->moment = 0;
        sums->most[k] = sums->side[k] = (struct most){0};
    }
    sums->flat = sums->turned = sums->grown = 0;
}

/* The measured cloth. */
struct gathering {
    struct march *march;
    struct rim *rim;
    const struct rim_cells *cells; /* that the rim cuts */
    struct drape_result *result;
    struct node_shear between;
    struct drape_statistics *statistics;
    struct sums *sums;
    size_t stretches; /* that whole cells are divided into, in their order */
    struct sums *of_stretches;
};

/* Takes in the shear at a place of the cloth. */
static void note_shear(const struct gathering *g, struct sums *sums, bool grown, double shear_deg,
                       double p, double q, struct vec3 r) {
    const struct most own = {fabs(shear_deg), p, q, r};
    statistics_note_shear(g->statistics, shear_deg, r);
    raise_most(&sums->most[grown], &own);
    raise_most(&sums->side[shear_deg < 0], &own);
}

/* Whether that would tell anything new. */
INLINE bool is_notable(const struct gathering *g, const struct sums *sums, bool grown,
                       double shear_deg) {
    return fabs(shear_deg) > sums->most[grown].shear_deg ||
           fabs(shear_deg) > sums->side[shear_deg < 0].shear_deg ||
           statistics_divides(g->statistics);
}

/* Whether that of any of `count` places may. */
INLINE bool any_notable(const struct gathering *g, const struct sums *sums, const uint8_t *grown,
                        const double *shear_deg, size_t count) {
    const double most = sums->most[0].shear_deg, of_grown = sums->most[1].shear_deg;
    const double plus = sums->side[0].shear_deg, minus = -sums->side[1].shear_deg;
    int64_t any = statistics_divides(g->statistics);
    for (size_t k = 0; k < count; k++) {
        double size = fabs(shear_deg[k]);
        any |= (shear_deg[k] > plus) | (shear_deg[k] < minus) | (size > most) |
               ((grown[k] != 0) & (size > of_grown));
    }
    return any;
}

/* Area whose absolute shear lies evenly in bins, as above; `mean` has its sign. */
INLINE void spread_signed(const struct gathering *g, struct sums *sums, double area, int from,
                          int to, double each, double mean) {
    spread_area(&sums->spread, area, from, to, each, fabs(mean));
    if (g->statistics && mean < 0)
        spread_area(&sums->negative, area, from, to, each, fabs(mean));
}

/* By how much weft that slides is longer, by the sine of the shear; where parallels meet no more
 * than at 85 degrees. */
static double stretch_at(const struct gathering *g, double sine) {
    double c = g->march->settings->slide;
    return c > 0 ? slide_stretch(c, fmin(fabs(sine), SLIDE_STEEPEST)) : 1;
}

/* Adds the angle of an area's warp from the direction wanted, in the plane of warp and weft; 0..90.
 */
static void add_turned(const struct gathering *g, struct sums *sums, double area, struct vec3 warp,
                       struct vec3 weft) {
    if (!g->statistics || !(vec3_norm2(g->statistics->wanted) > 0))
        return;
    struct vec3 wanted = g->statistics->wanted, normal = vec3_unit(vec3_cross(warp, weft));
    struct vec3 along = vec3_axpy(-vec3_dot(wanted, normal), normal, wanted);
    double sine = vec3_norm(vec3_cross(along, warp)), cosine = fabs(vec3_dot(along, warp));
    double angle = sine + cosine > 0 ? angle_atan2_deg(sine, cosine) : 45;
    double exponent = fmax(g->statistics->exponent, 1);
    sums->turned += area * (exponent > 1 ? power_of(angle, exponent) : angle);
}

/* ---- whole cells ---- */

/* So many cells are worth a stretch of their own, and stretches at the most: how many there are
 * must not depend on who is there to measure them, or sums would. */
enum { WORTH = 1 << 16, STRETCHES = 8 };

/* Cells side by side in a row, no more than fit in a few lines of the cache, with the numbers of
 * the nodes at their corners: each below and the one after it, and above alike. */
enum { RUN = 16 };
struct cell_run {
    size_t first, below, above;
    int count;
    double share[RUN]; /* of each that is cloth */
};

/* What is gathered of each of them. */
struct cell_areas {
    double area[RUN], each[RUN]; /* all, and in each of the bins */
    int from[RUN], to[RUN];
    bool grown[RUN];
};

/* The cells side by side from number `first` on, before `end`. */
static int count_run(const struct drape_cells *c, size_t first, size_t end) {
    int most = end - first < RUN ? (int)(end - first) : RUN, count = most;
    const int32_t *i = c->i + first, *j = c->j + first;
    if (i[most - 1] == i[0] + most - 1 && j[most - 1] == j[0])
        return most;
    for (count = 1; i[count] == i[0] + count && j[count] == j[0];)
        count++;
    return count;
}

/* The greatest and the least of four. */
INLINE double most_of(double a, double b, double c, double d) {
    double ab = a > b ? a : b, cd = c > d ? c : d;
    return ab > cd ? ab : cd;
}
INLINE double least_of(double a, double b, double c, double d) {
    double ab = a < b ? a : b, cd = c < d ? c : d;
    return ab < cd ? ab : cd;
}

/* Loops without branches, so that they become vector instructions. */
INLINE void measure_run(const struct gathering *g, const struct cell_run *run, int count,
                        struct cell_areas *to) {
    const struct drape_nodes *n = &g->result->nodes;
    const struct drape_cells *c = &g->result->cells;
    const double *a = n->shear_deg + run->below, *b = n->shear_deg + run->above;
    const double *wx = c->warp_x + run->first, *wy = c->warp_y + run->first;
    const double *wz = c->warp_z + run->first, *fx = c->weft_x + run->first;
    const double *fy = c->weft_y + run->first, *fz = c->weft_z + run->first;
    double cosine[RUN];
    for (int k = 0; k < count; k++) {
        double p = fabs(a[k]), q = fabs(a[k + 1]), r = fabs(b[k]), s = fabs(b[k + 1]);
        to->from[k] = bin_of(least_of(p, q, r, s));
        to->to[k] = bin_of(most_of(p, q, r, s)) + 1;
    }
    /* by the sine of the yarns' angle, and where weft slides its length */
    for (int k = 0; k < count; k++) {
        cosine[k] = wx[k] * fx[k] + wy[k] * fy[k] + wz[k] * fz[k];
        double square = 1 - cosine[k] * cosine[k];
        to->area[k] = run->share[k] * sqrt(square > 0 ? square : 0);
    }
    for (int k = 0; k < count && g->march->settings->slide > 0; k++)
        to->area[k] *= stretch_at(g, cosine[k]);
    for (int k = 0; k < count; k++)
        to->each[k] = to->area[k] / (to->to[k] - to->from[k]);
    const uint8_t *low = n->grown + run->below, *high = n->grown + run->above;
    for (int k = 0; k < count; k++)
        to->grown[k] = low[k] | low[k + 1] | high[k] | high[k + 1];
}

/* Most runs are as long as they can be. */
WIDE_CLONES
static void measure_cells(const struct gathering *g, const struct cell_run *run,
                          struct cell_areas *to) {
    if (run->count == RUN)
        measure_run(g, run, RUN, to);
    else
        measure_run(g, run, run->count, to);
}

/* Takes in cell k of a run. */
INLINE void add_run_cell(const struct gathering *g, struct sums *sums, const struct cell_run *run,
                         const struct cell_areas *areas, int k) {
    const struct drape_nodes *n = &g->result->nodes;
    const struct drape_cells *c = &g->result->cells;
    const size_t at = run->first + (size_t)k;
    const double area = areas->area[k], own = c->shear_deg[at];
    spread_signed(g, sums, area, areas->from[k], areas->to[k], areas->each[k], own);
    sums->flat += run->share[k];
    sums->grown += areas->grown[k] ? area : 0;
    add_turned(g, sums, area, vec3_make(c->warp_x[at], c->warp_y[at], c->warp_z[at]),
               vec3_make(c->weft_x[at], c->weft_y[at], c->weft_z[at]));
    const bool grown = areas->grown[k];
    if (is_notable(g, sums, grown, own)) {
        const double p = c->i[at] + 0.5, q = c->j[at] + 0.5;
        const size_t below = run->below + (size_t)k, above = run->above + (size_t)k;
        const size_t corner[4] = {below, below + 1, above, above + 1};
        struct vec3 sum = {0, 0, 0};
        for (int m = 0; m < 4; m++)
            sum = vec3_add(sum, node_point(n, corner[m]));
        note_shear(g, sums, grown, own, p, q, vec3_scale(0.25, sum));
    }
}

static void add_stretch(void *data, int number) {
    const struct gathering *g = data;
    const struct drape_nodes *n = &g->result->nodes;
    const struct drape_cells *c = &g->result->cells;
    const struct rim_cell *next = g->cells->cells, *last = next + g->cells->count;
    struct sums *sums = &g->of_stretches[number];
    size_t first = (size_t)number * c->count / g->stretches;
    size_t end = (size_t)(number + 1) * c->count / g->stretches;
    /* of the row of cells and the one above: each cell before has a node of its own */
    struct cell_run run = {.first = first, .below = first, .above = first};
    for (; run.first < end; run.first += (size_t)run.count) {
        struct cell_areas areas;
        int32_t i = c->i[run.first], j = c->j[run.first];
        run.count = count_run(c, run.first, end);
        run.below = seek_node(n, run.below, i, j);
        run.above = seek_node(n, run.above, i, j + 1);
        for (int k = 0; k < RUN; k++)
            run.share[k] = 1;
        for (; next < last && node_comes_before(next->i, next->j, i + run.count, j); next++)
            if (next->j == j && next->i >= i && !next->loose)
                run.share[next->i - i] = next->share;
        measure_cells(g, &run, &areas);
        for (int k = 0; k < run.count; k++)
            add_run_cell(g, sums, &run, &areas, k);
    }
}

/* All of them; the divisions of the statistics are noted by one alone. */
static enum status add_wholes(struct gathering *g) {
    size_t count = 1 + g->result->cells.count / WORTH;
    count = statistics_divides(g->statistics) ? 1 : count < STRETCHES ? count : STRETCHES;
    struct arena_mark mark = arena_mark(g->march->arena);
    struct sums *sums = count > 1 ? arena_take(g->march->arena, count, sizeof *sums) : g->sums;
    if (!sums)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count && count > 1; k++)
        begin_sums(&sums[k]);
    g->stretches = count;
    g->of_stretches = sums;
    team_run(count > 1 ? g->march->settings->team : NULL, (int)count, add_stretch, g);
    for (size_t k = 0; k < count && count > 1; k++) {
        const struct sums *more = &sums[k];
        add_spread(&g->sums->spread, &more->spread);
        add_spread(&g->sums->negative, &more->negative);
        g->sums->flat += more->flat;
        g->sums->turned += more->turned;
        g->sums->grown += more->grown;
        for (int n = 0; n < 2; n++) {
            raise_most(&g->sums->most[n], &more->most[n]);
            raise_most(&g->sums->side[n], &more->side[n]);
        }
    }
    arena_rewind(g->march->arena, mark);
    return STATUS_OK;
}

/* ---- the cells that are cut ---- */

/* Adds a cell with its mean directions, as those of whole cells. Where differences in space say
 * little they are turned about their bisector, to the shear that is known. */
static void list_cut(struct drape_cut *cut, const struct rim_patch *patch, double shear_deg) {
    const struct vec3 corner[4] = {patch->r[1][1], patch->r[1][2], patch->r[2][2], patch->r[2][1]};
    struct vec3 diagonal = vec3_sub(corner[2], corner[0]), other = vec3_sub(corner[1], corner[3]);
    struct vec3 warp = vec3_unit(vec3_add(diagonal, other));
    struct vec3 weft = vec3_unit(vec3_sub(diagonal, other));
    struct drape_cells *c = &cut->cells;
    size_t at = c->count;
    if (!patch->rough) {
        shear_deg = shear_between_deg((const struct vec3[2]){warp, weft});
    } else {
        double sine, cosine;
        struct vec3 along = vec3_unit(vec3_add(warp, weft)), across = vec3_sub(warp, weft);
        across = vec3_unit(vec3_axpy(-vec3_dot(across, along), along, across));
        angle_sincos_deg((90 - shear_deg) / 2, &sine, &cosine);
        warp = vec3_axpy(sine, across, vec3_scale(cosine, along));
        weft = vec3_axpy(-sine, across, vec3_scale(cosine, along));
    }
    if (vec3_norm2(warp) == 0 || vec3_norm2(weft) == 0)
        return;
    c->i[at] = patch->i;
    c->j[at] = patch->j;
    c->shear_deg[at] = shear_deg;
    vec3_to_columns(warp, c->warp_x, c->warp_y, c->warp_z, at);
    vec3_to_columns(weft, c->weft_x, c->weft_y, c->weft_z, at);
    for (int k = 0; k < 4; k++) {
        double **to = &cut->corner[3 * k];
        vec3_to_columns(corner[k], to[0], to[1], to[2], at);
    }
    c->count++;
}

/* The shear of the cloth at (p, q), in or beside the cell (i, j): between nodes and ghosts; on a
 * mesh, which has no ghosts, that of the cell's patch, whose corners are extrapolated; near folds,
 * where they may not be where yarns go, of the nodes that there are. */
static bool cloth_shear_at(struct gathering *g, int32_t i, int32_t j, double p, double q,
                           double *shear_deg, bool *grown) {
    bool known = node_shear_between(&g->between, p, q, shear_deg, grown);
    const struct rim_patch *patch = g->march->mesh ? rim_cloth_patch(&g->rim->cloth, i, j) : NULL;
    bool folded = patch && (patch->rough || (patch->extended && march_mesh_folds(g->march)));
    if (patch && patch->known && !(known && folded)) {
        struct rim_cloth_point place;
        rim_patch_point(patch, p, q, &place);
        *shear_deg = shear_between_deg(place.along);
    }
    *shear_deg = shear_rounded(*shear_deg);
    return known;
}

/* The share of a cell that is rounding. */
static const double least_share = 1e-9;

/* Whether of a cell within the rim that is not whole the boundary alone leaves corners out, by less
 * than the rim is right to, or the tip of a cut touches an edge; p and q of `cell` become those of
 * such a corner. */
static bool is_left_out(struct rim *rim, struct rim_cell *cell) {
    bool out = false;
    for (int k = 0; k < 4; k++) {
        int32_t i = cell->i + (k & 1), j = cell->j + k / 2;
        const struct net_node *node = net_find(rim->cloth.march->net, i, j);
        if (!node || node->state == NET_UNKNOWN ||
            (node->state == NET_FAILED && node->reason != DRAPE_REASON_BOUNDARY))
            return false;
        if (node->state == NET_INSIDE && !node->parted)
            continue;
        out = true;
        cell->p = i;
        cell->q = j;
    }
    return out && rim_cloth_patch(&rim->cloth, cell->i, cell->j)->known;
}

/* Puts the cells that are left out though they lie within the rim among those that it cuts: all of
 * each is cloth. */
static enum status add_left_out(struct rim *rim, const struct drape_cells *c,
                                struct rim_cells *cells) {
    struct arena *arena = rim->cloth.march->arena;
    struct rim_cell *all = NULL;
    size_t count = 0, room = 0, at = 0;
    for (size_t k = 0; k < cells->count; k++)
        for (int32_t n = 0; n <= cells->cells[k].inner; n++) {
            struct rim_cell own = cells->cells[k];
            own.i += n;
            while (at < c->count && node_comes_before(c->i[at], c->j[at], own.i, own.j))
                at++;
            bool whole = at < c->count && c->i[at] == own.i && c->j[at] == own.j;
            size_t rest = (size_t)(cells->cells[k].inner - n), last = at + rest;
            if (whole && n > 0 && last < c->count && c->j[last] == own.j &&
                c->i[last] == own.i + (int32_t)rest)
                break; /* as all those after it */
            if (n > 0)
                own.share = 1;
            if (n > 0 && (whole || !is_left_out(rim, &own)))
                continue;
            if (count == room)
                all = arena_enlarge(arena, all, count, sizeof *all, &room);
            if (!all)
                return STATUS_OUT_OF_MEMORY;
            all[count++] = own;
        }
    cells->cells = all;
    cells->count = count;
    return STATUS_OK;
}

/* The cells that are not whole, each by the share that the rim leaves of it: its shear goes from
 * that at the rim to that as far on the other side of its middle. */
static void add_cut_cells(struct gathering *g) {
    const struct drape_cells *c = &g->result->cells;
    size_t at = 0;
    for (size_t k = 0; k < g->cells->count; k++) {
        const struct rim_cell *cell = &g->cells->cells[k];
        while (at < c->count && node_comes_before(c->i[at], c->j[at], cell->i, cell->j))
            at++;
        if (at < c->count && c->i[at] == cell->i && c->j[at] == cell->j)
            continue;
        const struct rim_point *point = &g->rim->points[cell->point];
        rim_cloth_look(&g->rim->cloth, point->sight, point->beside);
        const struct rim_patch *patch = rim_cloth_patch(&g->rim->cloth, cell->i, cell->j);
        double sine, cosine, shear_deg, at_rim, share = cell->share, rest = 1 - share;
        struct rim_cloth_point middle;
        bool grown;
        if (cell->loose || share < least_share || (!g->march->cuts && !patch->known))
            continue;
        double p = share * (cell->i + 0.5) + rest * cell->p;
        double q = share * (cell->j + 0.5) + rest * cell->q;
        (void)cloth_shear_at(g, cell->i, cell->j, p, q, &shear_deg, &grown);
        (void)cloth_shear_at(g, cell->i, cell->j, cell->p, cell->q, &at_rim, NULL);
        double shear = fabs(shear_deg), half = fabs(shear - fabs(at_rim));
        angle_sincos_deg(90 - shear, &sine, &cosine);
        sine *= stretch_at(g, cosine);
        int from = bin_of(shear - half), to = bin_of(shear + half) + 1;
        double area = share * sine;
        spread_signed(g, g->sums, area, from, to, area / (to - from), shear_deg);
        g->sums->flat += share;
        g->sums->grown += grown ? share * sine : 0;
        if (!patch->known) /* beside the tip of a cut: corners lie behind it */
            continue;
        list_cut(&g->result->cut, patch, shear_deg);
        rim_patch_point(patch, p, q, &middle);
        add_turned(g, g->sums, share * sine, vec3_unit(middle.along[0]),
                   vec3_unit(middle.along[1]));
    }
}

/* The largest shear along the rim: along a straight piece in a cell bilinear shear is a parabola,
 * greatest at an end or at its top. So it does not hang on where the rim has its points. */
static void find_most_of_rim(struct gathering *g) {
    struct rim_walk walk = {.rim = g->rim};
    struct rim_piece piece;
    while (rim_walk_next(&walk, &piece)) {
        double share[4] = {0, 1, 0.5, -1}, shear_deg[4];
        for (int k = 0; k < 4 && !piece.loose; k++) {
            bool grown;
            if (k == 3) /* the top of the parabola through the three, if it has one */
                share[3] = 0.5 + (shear_deg[0] - shear_deg[1]) /
                                     (4 * (shear_deg[0] + shear_deg[1] - 2 * shear_deg[2]));
            if (!(share[k] >= 0 && share[k] <= 1))
                break;
            double p = piece.from[0] + share[k] * (piece.to[0] - piece.from[0]);
            double q = piece.from[1] + share[k] * (piece.to[1] - piece.from[1]);
            if (!cloth_shear_at(g, piece.i, piece.j, p, q, &shear_deg[k], &grown))
                break;
            note_shear(g, g->sums, grown, shear_deg[k], p, q,
                       vec3_axpy(share[k], vec3_sub(piece.r[1], piece.r[0]), piece.r[0]));
        }
    }
}

/* And at the nodes. Within cells there is none that is larger. */
WIDE_CLONES
static void find_most_of_nodes(struct gathering *g) {
    const struct drape_nodes *n = &g->result->nodes;
    for (size_t first = 0; first < n->count; first += RUN) {
        size_t count = n->count - first < RUN ? n->count - first : RUN;
        if (!any_notable(g, g->sums, n->grown + first, n->shear_deg + first, count))
            continue;
        for (size_t k = first; k < first + count; k++)
            if (is_notable(g, g->sums, n->grown[k], n->shear_deg[k]))
                note_shear(g, g->sums, n->grown[k], n->shear_deg[k], n->i[k], n->j[k],
                           node_point(n, k));
    }
}

/* By how much the greatest shear may be wrong: by its own error, or since it is greater elsewhere.
 */
static double most_error(struct gathering *g, const struct most *most) {
    const struct drape_nodes *n = &g->result->nodes;
    double error = node_shear_error(&g->between, most->p, most->q);
    for (size_t k = 0; k < n->count; k++)
        error = fmax(error, fabs(n->shear_deg[k]) + n->shear_error_deg[k] - most->shear_deg);
    return fmin(error, 180);
}

/* What can lie between the net and itself where it meets itself, in cells for each place there. */
static const double gap_cells = 2;

/* What a place at which the net ends within the part leaves uncovered, in cells, at the least. */
static const double lost_cells = 0.25;

/* The share of the part that lies under the cloth: all where the cloth ends nowhere but at the rim,
 * all of which it reaches, and where it meets itself. Where it is not all, it is that of the cells,
 * and no less than that of the whole ones, of which a rim that the cloth does not reach may seem to
 * cut some; their area is not exact on a coarse net, but where the net ends within the part some of
 * it is bare. */
static double cloth_coverage(const struct gathering *g) {
    const size_t *reasons = g->result->summary.front_reasons;
    const double *d = g->march->settings->spacing;
    double area = march_area(g->march), cell = d[0] * d[1] / area;
    size_t folds = reasons[DRAPE_REASON_FOLD], ends = 0;
    for (int k = 0; k < DRAPE_REASON_COUNT; k++)
        ends += k == DRAPE_REASON_BOUNDARY || k == DRAPE_REASON_FOLD ? 0 : reasons[k];
    if (ends == 0 && g->result->cells.count > 0 && g->march->counts.out_of_step == 0) {
        double uncovered = area - g->sums->spread.area * d[0] * d[1];
        bool whole = g->rim->loop_count > 0 ? g->rim->covered
                                            : uncovered <= gap_cells * (double)folds * d[0] * d[1];
        if (whole)
            return 1;
    }
    double most = fmax(1 - lost_cells * (double)ends * cell, 0);
    return fmin(fmax(g->sums->spread.area * cell, g->result->summary.coverage), most);
}

static void fill_statistics(const struct gathering *g, struct drape_statistics *statistics) {
    const double *d = g->march->settings->spacing;
    list_spread(&g->sums->spread, d[0] * d[1], statistics->area);
    list_spread(&g->sums->negative, d[0] * d[1], statistics->negative);
    statistics->wanted_deg = g->sums->spread.area > 0 ? g->sums->turned / g->sums->spread.area : 0;
    if (statistics->exponent > 1)
        statistics->wanted_deg = power_of(statistics->wanted_deg, 1 / statistics->exponent);
    /* The box round the pattern. A surface without a rim is cut where the net meets itself. */
    const int32_t *range[2] = {g->result->warp_range, g->result->weft_range};
    for (int k = 0; k < 2; k++) {
        statistics->lower[k] = range[k][0];
        statistics->upper[k] = range[k][1];
        for (size_t n = 0; n < g->rim->count; n++) {
            double at = k ? g->rim->points[n].q : g->rim->points[n].p;
            statistics->lower[k] = n == 0 ? at : fmin(statistics->lower[k], at);
            statistics->upper[k] = n == 0 ? at : fmax(statistics->upper[k], at);
        }
    }
}

static enum status measure_cloth(struct march *march, struct rim *rim,
                                 const struct rim_cells *cells, struct drape_result *result) {
    struct sums sums;
    const struct spread *spread = &sums.spread;
    struct drape_statistics *statistics = march->settings->statistics;
    struct gathering g = {.march = march,
                          .rim = rim,
                          .cells = cells,
                          .result = result,
                          .statistics = statistics,
                          .sums = &sums};
    struct drape_summary *s = &result->summary;
    const double *d = march->settings->spacing;
    begin_sums(&sums);
    sums.most[0].r = march->start.point.jet.r;
    for (size_t k = 0; statistics && k < statistics->divisions; k++)
        statistics->most[k] = 0;
    if (node_shear_make(march, &result->nodes, &g.between) != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    find_most_of_nodes(&g);
    find_most_of_rim(&g);
    if (add_wholes(&g) != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    add_cut_cells(&g);
    s->max_shear_pinned_deg = sums.most[0].shear_deg;
    s->max_shear_grown_deg = sums.grown > 0 ? sums.most[1].shear_deg : -1;
    s->grown_area = sums.grown * d[0] * d[1];
    raise_most(&sums.most[0], &sums.most[1]);
    s->max_shear_deg = sums.most[0].shear_deg;
    s->max_shear_at[0] = sums.most[0].p;
    s->max_shear_at[1] = sums.most[0].q;
    s->max_shear_point = sums.most[0].r;
    s->max_shear_error_deg = result->nodes.shear_error_deg ? most_error(&g, &sums.most[0]) : -1;
    for (int k = 0; k < 2; k++)
        s->most[k] = (struct drape_most){sums.side[k].shear_deg, sums.side[k].r};
    s->mean_shear_deg =
        spread->area > 0 ? fmin(spread->moment / spread->area, s->max_shear_deg) : 0;
    /* the shear that 95 % of the area have less than */
    double density = 0, sum = 0, wanted = 0.95 * spread->area, quantile = 0;
    for (int bin = 0; bin < spread->end; bin++) {
        density += spread->change[bin];
        if (sum + density >= wanted && density > 0) {
            quantile = fmin((bin + (wanted - sum) / density) * bin_width, 90);
            break;
        }
        sum += density;
    }
    s->p95_shear_deg = fmin(quantile, s->max_shear_deg);
    s->overlaps = cells->overlaps;
    s->part_area = march_area(march);
    s->cloth_area = spread->area * d[0] * d[1];
    s->flat_area = sums.flat * d[0] * d[1];
    s->cloth_coverage = cloth_coverage(&g);
    s->coverage = fmin(s->coverage, s->cloth_coverage);
    s->outcome = s->cloth_coverage >= DRAPE_COMPLETE_COVERAGE && result->cells.count
                     ? DRAPE_COMPLETE
                     : DRAPE_PARTIAL;
    if (statistics)
        fill_statistics(&g, statistics);
    return STATUS_OK;
}

/* ---- columns ---- */

static enum status list_rim(const struct march *march, const struct rim *rim,
                            struct drape_rim *out) {
    double **columns[] = {&out->x, &out->y, &out->z, &out->u, &out->v, &out->p, &out->q};
    out->count = rim->count;
    out->loop = arena_take(march->arena, rim->count, sizeof *out->loop);
    out->covered = arena_take(march->arena, rim->count, sizeof *out->covered);
    bool shell = march->surface && march->surface->shell;
    out->face = shell ? arena_take(march->arena, rim->count, sizeof *out->face) : NULL;
    int32_t cuts = (int32_t)march->settings->cut_count; /* those to apexes come after */
    out->cut = cuts ? arena_take(march->arena, rim->count, sizeof *out->cut) : NULL;
    bool all = out->loop && out->covered && (out->face || !shell) && (out->cut || !cuts);
    for (size_t c = 0; c < sizeof columns / sizeof *columns; c++)
        all = all && (*columns[c] = arena_take(march->arena, rim->count, sizeof(double)));
    for (size_t k = 0; all && k < rim->count; k++) {
        const struct rim_point *point = &rim->points[k];
        const struct surface *surface = rim_edges_surface(march, point->face);
        double uv[2]; /* the caller's parameters, inside the domain */
        for (int c = 0; c < 2; c++) {
            uv[c] = point->uv[c];
            if (!surface)
                continue;
            const struct surface_axis *axis = &surface->axis[c];
            double wrapped = surface_axis_wrap(axis, uv[c]);
            uv[c] = fmin(fmax(wrapped, surface_axis_lower(axis)), surface_axis_upper(axis));
        }
        if (surface)
            surface_outer(surface, uv, uv);
        const double values[] = {point->r.x, point->r.y, point->r.z, uv[0],
                                 uv[1],      point->p,   point->q};
        for (size_t c = 0; c < sizeof columns / sizeof *columns; c++)
            (*columns[c])[k] = values[c];
        out->loop[k] = point->loop;
        if (shell)
            out->face[k] = point->face;
        if (out->cut)
            out->cut[k] = abs(rim->lip_of[point->sight]) <= cuts ? rim->lip_of[point->sight] : 0;
        out->covered[k] = point->covered;
    }
    return all ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

struct rim_found *rim_report_begin(struct march *march) {
    struct rim_found *found = arena_alloc(march->arena, 1, sizeof *found);
    struct arena *arena = march->settings->team ? arena_child(march->arena) : march->arena;
    if (!found || !arena)
        return NULL;
    found->march = *march;
    found->net = *march->net;
    found->march.net = &found->net;
    found->march.arena = found->net.arena = arena;
    return found;
}

void rim_report_find(struct rim_found *found) {
    found->status = rim_make(&found->march, &found->rim);
    if (found->status == STATUS_OK)
        found->status = rim_cells_make(&found->march, &found->rim, &found->cells);
}

enum status rim_report(struct march *march, struct rim_found *found, struct drape_result *result) {
    struct arena *arena = march->arena;
    struct drape_cut *cut = &result->cut;
    struct drape_cells *c = &cut->cells;
    double **columns[] = {&c->shear_deg, &c->warp_x, &c->warp_y, &c->warp_z,
                          &c->weft_x,    &c->weft_y, &c->weft_z};
    enum status status = found->status;
    if (status == STATUS_OK)
        status = add_left_out(&found->rim, &result->cells, &found->cells);
    if (status != STATUS_OK)
        return status;
    size_t room = found->cells.count;
    *cut = (struct drape_cut){.cells = {.i = arena_take(arena, room, sizeof *c->i),
                                        .j = arena_take(arena, room, sizeof *c->j)}};
    bool all = c->i && c->j;
    for (size_t k = 0; k < sizeof columns / sizeof *columns; k++)
        all = all && (*columns[k] = arena_take(arena, room, sizeof(double)));
    for (int k = 0; k < 12; k++)
        all = all && (cut->corner[k] = arena_take(arena, room, sizeof(double)));
    status = all ? measure_cloth(march, &found->rim, &found->cells, result) : STATUS_OUT_OF_MEMORY;
    if (status == STATUS_OK)
        status = rim_lips_measure(march, &found->rim, &result->cuts);
    if (status != STATUS_OK)
        return status;
    return found->rim.cloth.failed ? STATUS_OUT_OF_MEMORY
                                   : list_rim(march, &found->rim, &result->rim);
}
