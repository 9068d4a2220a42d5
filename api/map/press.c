/* SPDX-License-Identifier: MIT */
#include "press.h"

#include "api/result/fields.h"
#include "api/result/permeability.h"

double press_thickness(const struct api_request *cloth, double shear_deg) {
    struct api_request flexible = *cloth;
    double thickness = 0;
    flexible.cavity.rigid = false;
    (void)api_fields_derive(COLUMN_CELLS_thickness, &flexible, shear_deg, &thickness);
    return thickness;
}

/* Whether the cloth is locked is not the cavity's matter. */
bool press_row(const struct map_net *net, const struct api_request *cloth, double height,
               double shear_deg, double *row) {
    struct api_request pressed = *cloth;
    struct permeability k = {0};
    bool outside = false;
    double packed = 0;
    pressed.cavity = (struct api_cavity){.rigid = true, .height = height};
    if (cloth->permeability.model != API_PERMEABILITY_NONE)
        k = api_permeability_at(&cloth->permeability,
                                api_fields_fiber_volume_fraction(&pressed, shear_deg), shear_deg,
                                &outside);
    for (size_t g = 0; g < net->group_count; g++) {
        const struct map_group *group = &net->group[g];
        double *own = row + group->offset;
        if (!group->spec)
            continue;
        const enum column_id id = (enum column_id)(group->spec - column_specs);
        if (group->kind == MAP_TENSOR)
            map_tensor_values(k.k1, k.k2, k.k3, k.along, k.across, own);
        else if (id == COLUMN_CELLS_out_of_table)
            *own = outside;
        else if (id != COLUMN_CELLS_locked)
            (void)api_fields_derive(id, &pressed, shear_deg, own);
        packed = id == COLUMN_CELLS_packing_exceeded ? *own : packed;
    }
    return packed > 0;
}
