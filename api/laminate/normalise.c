/* SPDX-License-Identifier: MIT */
#include "api/request/normalise.h"
#include "laminate.h"

const char *laminate_normalise(const struct laminate *laminate, struct arena *arena) {
    const struct stack_cavity *cavity = &laminate->cavity;
    struct api_text text = api_text_growing(arena);
    api_text_raw(&text, "{");
    api_normalise_ground(&text, &laminate->surface,
                         laminate->unit_of_surface ? NULL : laminate->length_unit);
    if (cavity->kind == STACK_FLEXIBLE) {
        api_text_key_string(&text, "cavity", "flexible");
    } else {
        bool pressed = cavity->kind == STACK_PRESSURE;
        api_text_key_object(&text, "cavity");
        api_text_key_number(&text, pressed ? "pressure" : "height",
                            pressed ? cavity->pressure : cavity->height);
        api_text_raw(&text, "}");
    }
    api_text_key_string(&text, "offset", laminate->nominal ? "nominal" : "none");
    api_text_key_integer(&text, "side", laminate->side);
    api_normalise_rosette(&text, &laminate->plies[0].drape);
    api_text_key(&text, "plies");
    api_text_raw(&text, "[");
    for (size_t k = 0; k < laminate->count; k++) {
        const struct laminate_ply *ply = &laminate->plies[k];
        const struct laminate_boundary *boundary = &ply->boundary;
        bool bounded = boundary->count > 0 || boundary->trim_count > 0;
        api_text_raw(&text, k ? ",{" : "{");
        api_text_key_string(&text, "name", ply->name);
        api_text_key_integer(&text, "repeat", ply->repeat);
        api_normalise_compaction(&text, &ply->law);
        if (ply->areal_weight > 0)
            api_text_key_number(&text, "areal_weight", ply->areal_weight);
        if (bounded)
            api_text_key_object(&text, "boundary");
        if (boundary->trim_count) {
            api_normalise_trims(&text, boundary->trims, boundary->trim_count);
        } else if (bounded) {
            api_text_key(&text, "polygons");
            for (size_t n = 0; n < boundary->count; n++) {
                const struct laminate_loop *loop = &boundary->loops[n];
                for (size_t p = 0; p < loop->count; p++) {
                    api_text_raw(&text, p ? "," : n ? ",[" : "[[");
                    api_text_numbers(&text, &loop->points[p].x, 3);
                }
                api_text_raw(&text, "]");
            }
            api_text_raw(&text, "]");
        }
        api_text_raw(&text, bounded ? "}" : "");
        api_normalise_cloth(&text, &ply->drape, NULL);
        api_normalise_permeability(&text, &ply->drape.permeability);
        api_text_raw(&text, "}");
    }
    api_text_raw(&text, "]}");
    return api_text_finish(&text);
}
