/* SPDX-License-Identifier: MIT */
/*
 * CompoST, the open JSON of the National Composites Centre: a CompositeDB whose plies, of pieces
 * where they have some, are a Sequence; and of each a DrapingSimulation with its mesh, the elements
 * of the caller's that it lies on, and the shear angle of each.
 *
 * Names of classes and fields, and that an object says its class in `_serialized_type`, are those
 * of CompoST/CompositeStandard.py and ExampleFiles of version 0.9.5, which is under the MIT licence
 * (github.com/National-Composites-Centre/CompoST at 57d67f2). What that standard has no field for
 * is in `additionalParameters`, which it leaves to whoever writes: the unit, and by element its id,
 * angle, thickness, fibre volume fraction and the permeability of the stack.
 */
#include "deck.h"
#include <math.h>

enum { ITEM = 2048 }; /* bytes of one at most, with a name of 255 characters escaped */

/* What is written, in this order; from SPLINE to BREAK and from SIMULATION to
 * SIMULATED for each ply anew. */
enum section {
    HEAD,
    MATERIALS,
    PLIES,
    SEQUENCED,
    SPLINE,
    POINT,
    BREAK,
    SIMULATIONS,
    SIMULATION,
    MESH,
    SHEAR,
    ID,
    ANGLE,
    THICKNESS,
    FRACTION,
    K1,
    K2,
    K3,
    SIMULATED,
    TAIL,
    SECTIONS
};

static const char *const lists[SECTIONS] = {[ID] = "element",
                                            [ANGLE] = "angle_deg",
                                            [THICKNESS] = "thickness",
                                            [FRACTION] = "fiber_volume_fraction",
                                            [K1] = "k1",
                                            [K2] = "k2",
                                            [K3] = "k3"};

struct state {
    enum section section;
    int ply;
    bool splines;                         /* there has been one */
    bool listed;                          /* something of the list that is being written */
    const struct api_column_source *k[3]; /* NULL: there is no permeability */
};

/* The ids of what there is of ply k: its material, itself, its simulation, the ply it is a piece of
 */
enum { SEQUENCE_ID = 1, OWN_IDS = 4 };
static int id_of(int ply, int which) {
    return SEQUENCE_ID + 1 + OWN_IDS * ply + which;
}

/* The edge of a ply, if there is one. Splines are numbered behind all else. */
static const struct map_outline *outline_of(const struct map_plies *plies, int ply) {
    return plies->outlines && plies->outlines[ply].count ? &plies->outlines[ply] : NULL;
}
static int spline_id(const struct map_plies *plies, int ply) {
    return id_of((int)plies->ply_count, 0) + ply;
}

/* Whether a closed line turns by more than 20 degrees at a point: a spline through its points is
 * one of several, which meet there. */
static bool breaks_at(const struct map_outline *line, size_t k) {
    static const double cosine = 0.9396926207859084;
    const struct vec3 *p = line->points;
    struct vec3 in = vec3_sub(p[k], p[k > 0 ? k - 1 : line->count - 2]);
    struct vec3 out = vec3_sub(p[k + 1], p[k]);
    return vec3_dot(in, out) < cosine * vec3_norm(in) * vec3_norm(out);
}

static bool begin_compost(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    const struct map_fields *fields = &encoder->fields;
    static const enum column_id ids[] = {COLUMN_CELLS_k1, COLUMN_CELLS_k2, COLUMN_CELLS_k3};
    for (int k = 0; k < 3; k++)
        state->k[k] = encoder_find(fields->columns, fields->column_count, API_TABLE_CELLS,
                                   column_specs[ids[k]].name);
    return fields->plies->row_count > 0 ||
           !api_problem_set(problem, API_INVALID_REQUEST,
                            "compost describes plies, but none of the %zu elements lies on the "
                            "cloth: check the length unit and the position of the mesh",
                            fields->element_count);
}

/* ---- objects ---- */

static void open_object(struct api_text *text, const char *class, const char *name, int id) {
    api_text_format(text, "{\"_serialized_type\":\"CompoST.CompositeStandard.%s\"", class);
    if (name)
        api_text_key_string(text, "memberName", name);
    if (id)
        api_text_key_integer(text, "ID", id);
}

static void write_compost_material(struct api_text *text, const struct map_plies *plies, int ply) {
    open_object(text, "GenericMaterial", plies->names[ply], id_of(ply, 0));
    api_text_raw(text, "}");
}

/* A ply, or a piece in the ply that its first one opens and its last one closes. */
static void write_ply(struct api_text *text, const struct map_plies *plies, int ply) {
    const int(*numbers)[2] = plies->numbers;
    bool piece = numbers && numbers[ply][1] > 0;
    bool first = !piece || ply == 0 || numbers[ply - 1][0] != numbers[ply][0];
    bool last =
        !piece || ply + 1 == (int)plies->ply_count || numbers[ply + 1][0] != numbers[ply][0];
    if (piece && first) {
        open_object(text, "Ply", NULL, id_of(ply, 3));
        api_text_raw(text, ",\"subComponents\":[");
    }
    open_object(text, piece ? "Piece" : "Ply", plies->names[ply], id_of(ply, 1));
    api_text_raw(text, ",\"material\":");
    write_compost_material(text, plies, ply);
    if (outline_of(plies, ply))
        api_text_key_integer(text, "splineRelimitationRef", spline_id(plies, ply));
    api_text_raw(text, piece && last ? "}]}" : "}");
}

static void open_simulation(struct encoder *encoder, int ply) {
    const struct map_plies *plies = encoder->fields.plies;
    double most = 0;
    for (size_t n = 0; n < plies->row_count; n++)
        if (plies->rows[n].ply == ply)
            most = fmax(most, fabs(plies->rows[n].shear_deg));
    open_object(&encoder->piece, "DrapingSimulation", plies->names[ply], id_of(ply, 2));
    api_text_key_integer(&encoder->piece, "plyID", id_of(ply, 1));
    api_text_key_number(&encoder->piece, "maxShearAngle", most);
    api_text_raw(&encoder->piece, ",\"drapedMesh\":");
    open_object(&encoder->piece, "AreaMesh", NULL, 0);
    api_text_raw(&encoder->piece, ",\"meshElements\":[");
}

static void write_compost_point(struct api_text *text, struct vec3 p) {
    open_object(text, "Point", NULL, 0);
    api_text_key_number(text, "x", p.x);
    api_text_key_number(text, "y", p.y);
    api_text_key_number(text, "z", p.z);
    api_text_raw(text, "}");
}

static void write_mesh_element(struct encoder *encoder, size_t e) {
    const struct map_fields *fields = &encoder->fields;
    struct api_text *text = &encoder->piece;
    open_object(text, "MeshElement", NULL, 0);
    api_text_raw(text, ",\"nodes\":[");
    for (int k = 0; k < 4 && fields->elements[e][k] >= 0; k++) {
        api_text_raw(text, k ? "," : "");
        write_compost_point(text, fields->vertices[fields->elements[e][k]]);
    }
    api_text_raw(text, "]}");
}

/* The value that the section's list has of a ply at an element. */
static double list_value(struct encoder *encoder, const struct map_ply_row *row, size_t e) {
    const struct state *state = encoder->state;
    double value[1] = {0};
    switch (state->section) {
    case SHEAR:
        return row->shear_deg;
    case ID:
        return deck_element_id(&encoder->fields, e);
    case ANGLE:
        return row->angle_deg;
    case THICKNESS:
        return row->thickness;
    case FRACTION:
        return row->fiber_volume_fraction;
    default:
        encoder_fill(encoder, state->k[state->section - K1], e, 1, value);
        return value[0];
    }
}

/* ---- the document ---- */

/* How many items the section has; 0: it is left out. */
static size_t count_items(const struct encoder *encoder) {
    const struct state *state = encoder->state;
    const struct map_plies *plies = encoder->fields.plies;
    const struct map_outline *outline =
        state->ply < (int)plies->ply_count ? outline_of(plies, state->ply) : NULL;
    switch (state->section) {
    case SPLINE:
        return outline != NULL;
    case POINT:
        return outline ? outline->count : 0;
    case BREAK:
        return outline ? outline->count - 1 : 0;
    case MATERIALS:
    case PLIES:
        return plies->ply_count;
    case THICKNESS:
        return plies->thickness ? encoder->fields.element_count : 0;
    case FRACTION:
        return plies->fraction ? encoder->fields.element_count : 0;
    case K1:
    case K2:
    case K3:
        return state->k[state->section - K1] ? encoder->fields.element_count : 0;
    case MESH:
    case SHEAR:
    case ID:
    case ANGLE:
        return encoder->fields.element_count;
    default:
        return 1;
    }
}

static void write_list_item(struct encoder *encoder, size_t e) {
    struct state *state = encoder->state;
    const struct map_ply_row *row = stack_row(&encoder->fields, e, state->ply);
    if (!row)
        return;
    api_text_raw(&encoder->piece, state->listed ? "," : "");
    state->listed = true;
    if (state->section == MESH)
        write_mesh_element(encoder, e);
    else
        api_text_number(&encoder->piece, list_value(encoder, row, e));
}

/* What there is of the spline of the ply: its head, a point, or the number of one that is a break.
 */
static void write_spline_item(struct encoder *encoder, size_t item) {
    struct state *state = encoder->state;
    struct api_text *text = &encoder->piece;
    const struct map_plies *plies = encoder->fields.plies;
    const struct map_outline *outline = outline_of(plies, state->ply);
    if (state->section == SPLINE) {
        api_text_raw(text, state->splines ? "," : "");
        state->splines = true;
        open_object(text, "Spline", plies->names[state->ply], spline_id(plies, state->ply));
    } else if (state->section == POINT) {
        api_text_raw(text, item ? "," : ",\"points\":[");
        write_compost_point(text, outline->points[item]);
    } else {
        api_text_raw(text, item ? "" : "],\"breaks\":[");
        if (breaks_at(outline, item)) {
            api_text_format(text, "%s%zu", state->listed ? "," : "", item);
            state->listed = true;
        }
        api_text_raw(text, item + 2 == outline->count ? "]}" : "");
    }
}

static void write_item(struct encoder *encoder, size_t item) {
    const struct state *state = encoder->state;
    struct api_text *text = &encoder->piece;
    switch (state->section) {
    case HEAD:
        open_object(text, "CompositeDB", NULL, 0);
        api_text_key_string(text, "name", encoder->id);
        api_text_raw(text, ",\"allMaterials\":[");
        break;
    case MATERIALS:
        api_text_raw(text, item ? "," : "");
        write_compost_material(text, encoder->fields.plies, (int)item);
        break;
    case PLIES:
        if (item == 0) {
            api_text_raw(text, "],\"allComposite\":[");
            open_object(text, "Sequence", NULL, SEQUENCE_ID);
            api_text_raw(text, ",\"additionalParameters\":{\"length_unit\":");
            api_text_string(text, encoder->fields.unit->name);
            if (encoder->fields.revision)
                api_text_key_string(text, "revision", encoder->fields.revision);
            api_text_raw(text, "},\"subComponents\":[");
        }
        api_text_raw(text, item ? "," : "");
        write_ply(text, encoder->fields.plies, (int)item);
        break;
    case SEQUENCED:
        api_text_raw(text, encoder->fields.plies->outlines ? "]}],\"allGeometry\":[" : "]}");
        break;
    case SPLINE:
    case POINT:
    case BREAK:
        write_spline_item(encoder, item);
        break;
    case SIMULATIONS:
        api_text_raw(text, "],\"allSimulations\":[");
        break;
    case SIMULATION:
        api_text_raw(text, state->ply ? "," : "");
        open_simulation(encoder, state->ply);
        break;
    case SIMULATED:
        api_text_raw(text, "}}");
        break;
    case TAIL:
        api_text_raw(text, "],\"fileMetadata\":");
        open_object(text, "FileMetadata", NULL, 0);
        api_text_key_string(text, "version", "0.9.5");
        api_text_key_integer(
            text, "maxID",
            spline_id(encoder->fields.plies, encoder->fields.plies->outlines
                                                 ? (int)encoder->fields.plies->ply_count - 1
                                                 : -1));
        api_text_raw(text, "}}\n");
        break;
    default:
        write_list_item(encoder, item);
    }
}

/* Opens and closes the lists, which follow each other. */
static void begin_list(struct encoder *encoder) {
    struct state *state = encoder->state;
    state->listed = false;
    if (state->section == SHEAR)
        api_text_raw(&encoder->piece, "]},\"mappedShearAngles\":[");
    else if (state->section == ID)
        api_text_raw(&encoder->piece, "],\"additionalParameters\":{\"element\":[");
    else if (lists[state->section])
        api_text_format(&encoder->piece, ",\"%s\":[", lists[state->section]);
}

/* Where what is written of each ply begins, by where it ends. */
static enum section again_from(enum section end) {
    return end == BREAK ? SPLINE : SIMULATION;
}

static void next_compost(struct encoder *encoder) {
    struct state *state = encoder->state;
    const int plies = (int)encoder->fields.plies->ply_count;
    while (state->section < SECTIONS && encoder->piece.capacity - encoder->piece.length > ITEM) {
        size_t items = count_items(encoder);
        if (encoder->row == 0 && items > 0)
            begin_list(encoder);
        if (items > 0)
            write_item(encoder, encoder->row++);
        if (encoder->row < items)
            continue;
        if (items > 0 && lists[state->section])
            api_text_raw(&encoder->piece, "]");
        encoder->row = 0;
        bool last = state->section == BREAK || state->section == SIMULATED;
        bool again = last && ++state->ply < plies;
        state->ply = last && !again ? 0 : state->ply;
        state->section = again ? again_from(state->section) : (enum section)(state->section + 1);
    }
    encoder->ended = state->section == SECTIONS;
}

const struct format format_compost = {
    .name = "compost",
    .media_type = "application/x-compost+json",
    .about = "CompoST of the National Composites Centre: plies, and of each the mesh and its shear",
    .exact = "every bit",
    .uses = FORMAT_MAP,
    .elements = true,
    .outlines = true,
    .state_size = sizeof(struct state),
    .begin = begin_compost,
    .next = next_compost};
