/* SPDX-License-Identifier: MIT */
#include "api/request/normalise.h"
#include "courses.h"

/* The splits and the seam of a ply. */
static void normalise_splits(struct api_text *text, const struct laminate_pieces *pieces) {
    static const char *const over[] = {NULL, "first", "last"};
    const struct laminate_seam *seam = &pieces->seam;
    api_text_key(text, "splits");
    for (size_t k = 0; k < pieces->split_count; k++) {
        api_text_raw(text, k ? ",{" : "[{");
        api_text_key_rows(text, "path", &pieces->splits[k].path[0].x, 3, pieces->splits[k].count);
        api_text_raw(text, "}");
    }
    api_text_raw(text, "]");
    if (seam->overlap > 0 || seam->gap > 0) {
        api_text_key_object(text, "seam");
        api_text_key_number(text, seam->gap > 0 ? "gap" : "overlap",
                            fmax(seam->overlap, seam->gap));
        if (seam->over)
            api_text_key_string(text, "over", over[seam->over]);
        api_text_raw(text, "}");
    }
}

/* How a ply is divided, and all of its pieces. */
static void normalise_pieces(struct api_text *text, const struct laminate_pieces *pieces) {
    if (pieces->courses)
        courses_normalise(text, pieces->courses);
    else
        normalise_splits(text, pieces);
    if (pieces->count == 0) /* they have not been laid */
        return;
    api_text_key(text, "pieces");
    for (size_t k = 0; k < pieces->count; k++) {
        const struct laminate_piece *own = &pieces->pieces[k];
        api_text_raw(text, k ? ",{" : "[{");
        api_text_key_string(text, "name", own->name);
        if (pieces->courses) {
            api_text_key_object(text, "course");
            courses_write_figures(text, own->figures);
            api_text_raw(text, "}");
        } else {
            api_text_key_numbers(text, "at", &own->at.x, 3);
        }
        api_normalise_cloth(text, &own->drape, NULL);
        if (own->drape.settings.cut_count == 0 && pieces->ply.settings.cut_count)
            api_text_key_rows(text, "cuts", NULL, 1, 0);
        api_normalise_permeability(text, &own->drape.permeability);
        api_text_raw(text, "}");
    }
    api_text_raw(text, "]");
}

const char *laminate_normalise(const struct laminate *laminate, struct arena *arena) {
    const struct stack_cavity *cavity = &laminate->cavity;
    struct api_text text = api_text_growing(arena);
    api_text_raw(&text, "{");
    api_normalise_ground(&text, &laminate->surface, laminate->length_unit);
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
        if (ply->price > 0)
            api_text_key_number(&text, "price", ply->price);
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
        const struct api_request *cloth = ply->pieces ? &ply->pieces->ply : &ply->drape;
        api_normalise_cloth(&text, cloth, NULL);
        api_normalise_permeability(&text, &cloth->permeability);
        if (ply->pieces) {
            normalise_pieces(&text, ply->pieces);
            k += ply->pieces->count ? ply->pieces->count - 1 : 0;
        }
        api_text_raw(&text, "}");
    }
    api_text_raw(&text, "]}");
    return api_text_finish(&text);
}

const char *courses_document(const struct api_request *drape, const struct courses_settings *lay,
                             struct arena *arena) {
    const struct laminate_courses courses = {.lay = *lay};
    const struct laminate_pieces pieces = {.courses = &courses, .ply = *drape};
    struct laminate_ply ply = {.name = "ply_1", .drape = *drape, .pieces = &pieces, .repeat = 1};
    const struct laminate laminate = {.surface = drape->surface,
                                      .length_unit = drape->length_unit,
                                      .plies = &ply,
                                      .count = 1,
                                      .ply_count = 1,
                                      .side = 1};
    return laminate_normalise(&laminate, arena);
}
