/* SPDX-License-Identifier: MIT */
#include "permeability.h"

#include "solver/permeability.h"

/* What no arrangement of fibres exceeds in practice, where no packing is given. */
static const double vf_limit = 0.9;

static enum permeability_packing packing_of(const struct api_permeability *permeability) {
    return permeability->packing == API_PACKING_QUADRATIC ? PERMEABILITY_QUADRATIC
                                                          : PERMEABILITY_HEXAGONAL;
}

double api_packing_limit(const struct api_permeability *permeability) {
    return permeability->model == API_PERMEABILITY_GEBART
               ? permeability_packing_limit(packing_of(permeability))
               : vf_limit;
}

struct permeability api_permeability_at(const struct api_permeability *model, double vf,
                                        double shear_deg, double slide, bool *outside) {
    const double k[3] = {model->k1, model->k2, model->k3};
    if (model->model == API_PERMEABILITY_KOZENY_CARMAN)
        return permeability_kozeny_carman(k, model->at_fiber_volume_fraction, vf, shear_deg, slide);
    if (model->model == API_PERMEABILITY_GEBART)
        return permeability_gebart(model->fiber_radius, packing_of(model), vf, shear_deg, slide);
    double left_deg = permeability_unslid_deg(shear_deg, slide);
    const struct permeability_table table = {model->rows,     model->shear_deg, model->table_k1,
                                             model->table_k2, model->table_k3,  model->angle_deg};
    const struct permeability_grid grid = {
        model->rows,     model->fractions, model->shear_deg, model->table_fractions,
        model->table_k1, model->table_k2,  model->table_k3,  model->angle_deg};
    return model->fractions ? permeability_of_grid(&grid, vf, left_deg, outside)
                            : permeability_of_table(&table, left_deg, outside);
}

enum status
api_permeability_columns(const struct api_request *request, const struct drape_cells *cells,
                         double (*vf)(const struct api_request *request, double shear_deg),
                         struct arena *arena, struct api_permeability_columns *columns) {
    const struct api_permeability *model = &request->permeability;
    *columns = (struct api_permeability_columns){0};
    if (model->model == API_PERMEABILITY_NONE)
        return STATUS_OK;
    double **const column[] = {&columns->k1,          &columns->k2,   &columns->k3,
                               &columns->k1_x,        &columns->k1_y, &columns->k1_z,
                               &columns->out_of_table};
    const size_t wanted = sizeof column / sizeof *column - (model->model != API_PERMEABILITY_TABLE);
    for (size_t k = 0; k < wanted; k++) {
        *column[k] = arena_take(arena, cells->count, sizeof **column[k]);
        if (!*column[k])
            return STATUS_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < cells->count; i++) {
        double shear = cells->shear_deg[i];
        struct vec3 warp = vec3_make(cells->warp_x[i], cells->warp_y[i], cells->warp_z[i]);
        struct vec3 weft = vec3_make(cells->weft_x[i], cells->weft_y[i], cells->weft_z[i]);
        bool outside = false;
        struct permeability k = api_permeability_at(model, vf(request, shear), shear,
                                                    request->settings.slide, &outside);
        struct vec3 direction = permeability_direction(&k, warp, weft);
        columns->k1[i] = k.k1;
        columns->k2[i] = k.k2;
        columns->k3[i] = k.k3;
        vec3_to_columns(direction, columns->k1_x, columns->k1_y, columns->k1_z, i);
        if (columns->out_of_table)
            columns->out_of_table[i] = outside;
    }
    return STATUS_OK;
}
