/* SPDX-License-Identifier: MIT */
#include "slope.h"

#include "solver/angle.h"
#include <string.h>

static const double radian = ANGLE_PI / 180;

/* The cell from (i, j) on: its corners are (i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1). */
enum { CORNERS = 4 };
static const int corner_i[CORNERS] = {0, 1, 1, 0}, corner_j[CORNERS] = {0, 0, 1, 1};

/* e = r_s, f = r_t times the spacings, their means over the cell. */
struct cell {
    bool known;         /* all four corners have derivatives */
    double shear, area; /* of the part of it that is to be covered, by its corners */
    struct vec3 e, f;
    double *change; /* J of all parameters */
};

struct cells {
    const struct steer_variation *variation;
    const double *spacing;
    struct cell *cell;
};

static void measure_cell(const struct steer_variation *v, int32_t index, struct cell *cell) {
    struct vec3 r[CORNERS];
    double inside = 0;
    int32_t at[2] = {v->low[0] + index % v->size[0], v->low[1] + index / v->size[0]};
    for (int k = 0; k < CORNERS; k++) {
        int32_t corner = steer_index(v, at[0] + corner_i[k], at[1] + corner_j[k]);
        if (corner < 0 || v->slot[corner] < 0)
            return;
        r[k] = v->node[corner]->r;
        inside += v->node[corner]->state == NET_INSIDE;
    }
    cell->known = true;
    cell->e = vec3_scale(0.5, vec3_add(vec3_sub(r[1], r[0]), vec3_sub(r[2], r[3])));
    cell->f = vec3_scale(0.5, vec3_add(vec3_sub(r[3], r[0]), vec3_sub(r[2], r[1])));
    double cross = vec3_norm(vec3_cross(cell->e, cell->f));
    cell->area = inside / CORNERS * cross;
    cell->shear = radian * angle_atan2_deg(vec3_dot(cell->e, cell->f), cross);
}

/* The cell beside `index` along warp (k = 0) or weft, on the side 1 or -1; NULL: not known. */
static const struct cell *cell_beside(const struct cells *cells, int32_t index, int k, int side) {
    const struct steer_variation *v = cells->variation;
    int32_t at[2] = {v->low[0] + index % v->size[0], v->low[1] + index / v->size[0]};
    at[k] += side;
    int32_t other = steer_index(v, at[0], at[1]);
    return other >= 0 && cells->cell[other].known ? &cells->cell[other] : NULL;
}

/* Two cells whose difference by 1 / `by` is the derivative at a cell along yarn k, as many places
 * apart as there are. */
struct pair {
    const struct cell *low, *high;
    double by;
};

static struct pair pair_at(const struct cells *cells, int32_t index, int k) {
    const struct cell *here = &cells->cell[index];
    const struct cell *low = cell_beside(cells, index, k, -1),
                      *high = cell_beside(cells, index, k, 1);
    return (struct pair){low ? low : here, high ? high : here, low && high ? 0.5 : 1};
}

/* J = sum over the corners of a vector by the corner's derivative. With e . f = c, |e x f| = a, m
 * their unit normal and g = atan(c / a),
 *
 *     dg = ((a f - c (f x m)) . de + (a e - c (m x e)) . df) / (a^2 + c^2);
 *
 * by the mean dr of the corners cloth moves a e + b f, which takes g_i a + g_j b off. */
WIDE_CLONES
static void change_cell(const struct cells *cells, int32_t index) {
    const struct steer_variation *v = cells->variation;
    struct cell *cell = &cells->cell[index];
    int32_t at[2] = {v->low[0] + index % v->size[0], v->low[1] + index / v->size[0]};
    struct vec3 e = cell->e, f = cell->f, normal = vec3_cross(e, f), by[CORNERS];
    double c = vec3_dot(e, f), a = vec3_norm(normal), ee = vec3_norm2(e), ff = vec3_norm2(f);
    struct vec3 m = vec3_scale(1 / a, normal);
    struct vec3 of_e = vec3_axpy(-c, vec3_cross(f, m), vec3_scale(a, f));
    struct vec3 of_f = vec3_axpy(-c, vec3_cross(m, e), vec3_scale(a, e));
    double whole = 0.5 / (ee * ff), rate[2];
    for (int k = 0; k < 2; k++) {
        struct pair pair = pair_at(cells, index, k);
        rate[k] = pair.by * (pair.high->shear - pair.low->shear) / (CORNERS * a * a);
    }
    struct vec3 drift =
        vec3_axpy(rate[0] * ff - rate[1] * c, e, vec3_scale(rate[1] * ee - rate[0] * c, f));
    for (int k = 0; k < CORNERS; k++) {
        by[k] = vec3_axpy(corner_i[k] ? whole : -whole, of_e,
                          vec3_scale(corner_j[k] ? whole : -whole, of_f));
        by[k] = vec3_sub(by[k], drift);
    }
    for (int k = 0; k < CORNERS; k++) {
        const double *d = steer_derivative(v, at[0] + corner_i[k], at[1] + corner_j[k]);
        for (int n = 0; n < v->row; n += STEER_LANES)
            steer_store(cell->change + n,
                        steer_load(cell->change + n) + steer_dot(by[k], d + n, v->row));
    }
}

/* Adds a term of the energy with this slope and stiffness that changes by `change`. */
INLINE void add_term(struct steer_slope *slope, double rise, double stiffness,
                     const double *change) {
    for (int n = 0; n < slope->variation.parameters; n++) {
        double scaled = stiffness * change[n], *row = slope->matrix[n];
        slope->gradient[n] += rise * change[n];
        for (int m = n / STEER_LANES * STEER_LANES; m < slope->variation.row; m += STEER_LANES)
            steer_store(row + m, steer_load(row + m) + scaled * steer_load(change + m));
    }
}

WIDE_CLONES
static void add_cell_terms(const struct cells *cells, int32_t index,
                           const struct drape_energy *energy, struct steer_slope *slope) {
    const struct cell *cell = &cells->cell[index];
    struct steer_density density = steer_density_at(energy, cell->shear);
    double bend[STEER_PARAMETERS];
    add_term(slope, cell->area * density.slope, cell->area * density.stiffness, cell->change);
    for (int k = 0; k < 2; k++) {
        struct pair pair = pair_at(cells, index, k);
        double by = pair.by / cells->spacing[k];
        double curvature = by * (pair.high->shear - pair.low->shear);
        double stiffness = slope->stiffness * cell->area;
        for (int n = 0; n < slope->variation.row; n++)
            bend[n] = by * (pair.high->change[n] - pair.low->change[n]);
        slope->bending += stiffness * curvature * curvature / 2;
        add_term(slope, stiffness * curvature, stiffness, bend);
    }
}

enum status steer_slope_make(struct march *march) {
    struct steer_slope *slope = march->settings->slope;
    struct steer_variation *v = &slope->variation;
    enum status status = steer_variation_make(march, slope->varied, v);
    if (status != STATUS_OK)
        return status;
    int32_t count = v->size[0] * v->size[1];
    struct cells cells = {v, march->settings->spacing,
                          arena_alloc(march->arena, (size_t)count, sizeof *cells.cell)};
    double *change = arena_alloc(march->arena, (size_t)v->known * (size_t)v->row, sizeof *change);
    if (!cells.cell || !change)
        return STATUS_OUT_OF_MEMORY;
    slope->bending = 0;
    memset(slope->gradient, 0, sizeof slope->gradient);
    memset(slope->matrix, 0, sizeof slope->matrix);
    for (int32_t n = 0; n < count; n++) {
        measure_cell(v, n, &cells.cell[n]);
        if (!cells.cell[n].known)
            continue;
        cells.cell[n].change = change; /* there are fewer cells than nodes */
        change += v->row;
    }
    for (int32_t n = 0; n < count; n++)
        if (cells.cell[n].known)
            change_cell(&cells, n);
    for (int32_t n = 0; n < count; n++)
        if (cells.cell[n].known && cells.cell[n].area > 0)
            add_cell_terms(&cells, n, &march->settings->energy, slope);
    return STATUS_OK;
}
