/* SPDX-License-Identifier: MIT */
#include "api/json/value.h"
#include "api/request/members.h"
#include "courses.h"
#include <stdio.h>
#include <string.h>

static const struct value_range pressures = {1e-3, 1e12, false}; /* Pa */
enum { POLYGON_MAX = 100000 };

int laminate_layers(const struct laminate_ply *ply) {
    return ply->repeat * ply->drape.fabric.plies;
}

bool laminate_is_split(const struct laminate_ply *ply) {
    return ply->pieces && !ply->pieces->courses;
}

struct api_request laminate_drape(const struct laminate *laminate, size_t k) {
    struct api_request drape = laminate->plies[k].drape;
    const struct drape_zero *zero = &drape.settings.zero;
    if (zero->kind == DRAPE_ZERO_ROSETTE && vec3_norm2(zero->z) == 0 && laminate->side < 0)
        drape.settings.direction_deg = 0 - drape.settings.direction_deg;
    return drape;
}

void laminate_title(const struct laminate_ply *ply, char title[LAMINATE_TITLE_SIZE]) {
    const char *piece = ply->pieces ? ply->pieces->pieces[ply->piece].name : "";
    (void)snprintf(title, LAMINATE_TITLE_SIZE, "%s%s%s", ply->name, *piece ? ", " : "", piece);
}

bool laminate_split_closed(const struct drape_cut_line *split) {
    return split->count > 3 && vec3_distance(split->path[0], split->path[split->count - 1]) == 0;
}

size_t laminate_steps(double length, double step) {
    return (size_t)fmin(fmax(ceil(length / step), 1), 1e5);
}

/* ---- one ply ---- */

static void decode_boundary(const struct json_value *json, const struct api_surface *surface,
                            struct laminate_boundary *boundary) {
    static const char *const keys[] = {"polygon", "polygons", "trims", NULL};
    struct json_value polygon = value_member(json, keys[0]);
    struct json_value polygons = value_member(json, keys[1]);
    struct json_value trims = value_member(json, keys[2]);
    if (!value_object(json, keys))
        return;
    bool one = value_given(&polygon);
    if (one + value_given(&polygons) + value_given(&trims) != 1) {
        value_fault(json, "must have either \"polygon\", \"polygons\" or \"trims\"");
    } else if (!value_given(&trims)) {
        size_t count = one ? 1 : value_array(&polygons, 1) ? value_length(&polygons) : 0;
        struct laminate_loop *loops =
            count ? json_tree_alloc(json->tree, count, sizeof *loops) : NULL;
        boundary->loops = loops;
        boundary->count = count;
        for (size_t k = 0; loops && k < count; k++) {
            struct json_value own = one ? polygon : value_element(&polygons, k);
            double *rows;
            if (!value_rows(&own, decode_coordinates, 3, 3, &rows, &loops[k].count))
                continue;
            loops[k].points = (const void *)rows;
            if (loops[k].count > POLYGON_MAX)
                value_fault(&own, "has %zu points, and %d are allowed", loops[k].count,
                            POLYGON_MAX);
        }
    } else {
        struct api_surface loops = {.kind = API_SURFACE_NURBS};
        if (surface->kind != API_SURFACE_NURBS && surface->kind != API_SURFACE_NAMED)
            value_fault(&trims, "need a part of one NURBS surface, in whose parameters they are: "
                                "give a polygon instead");
        if (decode_trims(&trims, &loops) && loops.trim_count == 0)
            value_fault(&trims, "must have at least one loop");
        boundary->trims = loops.trims;
        boundary->trim_count = loops.trim_count;
    }
}

static void decode_seam(const struct json_value *json, struct laminate_seam *seam) {
    static const char *const keys[] = {"overlap", "gap", "over", NULL};
    static const char *const sides[] = {"first", "last"};
    struct json_value overlap = value_member(json, keys[0]), gap = value_member(json, keys[1]);
    struct json_value over = value_member(json, keys[2]);
    int index;
    if (!value_object(json, keys))
        return;
    if (value_given(&overlap) == value_given(&gap))
        value_fault(json, "must have either \"overlap\" or \"gap\"");
    else if (value_given(&overlap))
        value_number(&overlap, decode_lengths, &seam->overlap);
    else
        value_number(&gap, decode_lengths, &seam->gap);
    if (value_given(&over) && !value_given(&overlap))
        value_fault(&over, "needs an \"overlap\"");
    else if (value_given(&over) && value_choice(&over, sides, 2, &index))
        seam->over = index == 0 ? LAMINATE_OVER_FIRST : LAMINATE_OVER_LAST;
}

static void decode_splits(const struct json_value *json, struct laminate_pieces *pieces) {
    static const char *const keys[] = {"path", "name", NULL};
    size_t count;
    if (!decode_count(json, 1, LAMINATE_SPLITS_MAX, "splits", &count))
        return;
    struct drape_cut_line *splits = json_tree_alloc(json->tree, count + 1, sizeof *splits);
    for (size_t k = 0; k < count && splits; k++) {
        char name[LAMINATE_NAME_MAX + 1];
        struct json_value split = value_element(json, k), own = value_member(&split, "name");
        struct json_value path = value_member(&split, "path");
        if (value_object(&split, keys))
            decode_cut_path(&path, &splits[k]);
        if (value_given(&own))
            decode_name(&own, LAMINATE_NAME_MAX, name);
    }
    pieces->splits = splits;
    pieces->split_count = splits ? count : 0;
}

/* The pieces that the request speaks of; what one does not say is as the ply says. */
static void decode_pieces(const struct json_value *json, const struct api_request *ply,
                          struct laminate_pieces *pieces) {
    static const char *const keys[] = {
        "at",        "name",   "fabric",       "start", "direction", "generators", "method",
        "yarn_path", "extent", "permeability", "cuts",  "energy",    "course",     NULL};
    size_t count;
    bool laid = pieces->courses != NULL;
    if (!decode_count(json, 0, laid ? LAMINATE_COURSES_MAX : LAMINATE_PIECES_MAX, "pieces", &count))
        return;
    struct laminate_piece *list = json_tree_alloc(json->tree, count + 1, sizeof *list);
    for (size_t k = 0; k < count && list; k++) {
        struct json_value own = value_element(json, k), at = value_member(&own, "at");
        struct json_value name = value_member(&own, "name"), course = value_member(&own, "course");
        char *text = json_tree_alloc(json->tree, LAMINATE_NAME_MAX + 1, 1);
        list[k] = (struct laminate_piece){.name = text, .drape = *ply};
        list[k].drape.settings.start_kind = DRAPE_START_CENTROID;
        if (!text || !value_object(&own, keys))
            continue;
        (void)snprintf(text, LAMINATE_NAME_MAX + 1, "piece_%zu", k + 1);
        if (value_given(&name))
            decode_name(&name, LAMINATE_NAME_MAX, text);
        if (laid)
            courses_decode_figures(&course, list[k].figures);
        else
            value_vector(&at, decode_coordinates, 3, &list[k].at.x);
        if (value_given(laid ? &at : &course))
            value_fault(laid ? &at : &course,
                        laid ? "must be left out of a course" : "is of pieces that are courses");
        decode_ply(&own, &list[k].drape);
        for (size_t n = 0; n < k; n++)
            if (strcmp(list[n].name, text) == 0)
                value_fault(value_given(&name) ? &name : &own, "is the name of another piece");
    }
    pieces->pieces = list;
    pieces->count = list ? count : 0;
}

/* `courses` of a ply; and `pieces`, as what was understood has them. */
static void decode_courses_of_ply(const struct json_value *json, struct laminate_ply *ply) {
    struct json_value list = value_member(json, "pieces");
    struct laminate_pieces *pieces = json_tree_alloc(json->tree, 1, sizeof *pieces);
    if (!pieces)
        return;
    pieces->ply = ply->drape;
    struct json_value courses = value_member(json, "courses");
    pieces->courses = courses_decode(&courses, json, &ply->drape);
    ply->pieces = pieces->courses ? pieces : NULL;
    if (value_given(&list) && pieces->courses)
        decode_pieces(&list, &ply->drape, pieces);
}

/* `splits`, `seam` and `pieces` of a ply. */
static void decode_division(const struct json_value *json, struct laminate_ply *ply) {
    struct json_value splits = value_member(json, "splits"), seam = value_member(json, "seam");
    struct json_value list = value_member(json, "pieces"), start = value_member(json, "start");
    struct json_value boundary = value_member(json, "boundary");
    if (!value_given(&splits)) {
        if (value_given(&seam))
            value_fault(&seam, "needs \"splits\"");
        if (value_given(&list))
            value_fault(&list, "needs \"splits\"");
        return;
    }
    struct laminate_pieces *pieces = json_tree_alloc(json->tree, 1, sizeof *pieces);
    if (!pieces)
        return;
    if (value_given(&start))
        value_fault(&start, "must be left out beside \"splits\": each of \"pieces\" may have one");
    if (value_given(&boundary))
        value_fault(&boundary, "must be left out beside \"splits\"");
    ply->pieces = pieces;
    pieces->ply = ply->drape;
    decode_splits(&splits, pieces);
    if (value_given(&seam))
        decode_seam(&seam, &pieces->seam);
    if (value_given(&list))
        decode_pieces(&list, &ply->drape, pieces);
}

static void decode_laminate_ply(const struct json_value *json, const struct api_request *common,
                                size_t number, struct laminate_ply *ply) {
    static const char *const keys[] = {
        "name",         "repeat",     "compaction", "boundary",  "fabric", "start",
        "direction",    "generators", "method",     "yarn_path", "extent", "permeability",
        "areal_weight", "cuts",       "splits",     "seam",      "pieces", "energy",
        "courses",      "price",      NULL};
    struct json_value courses = value_member(json, "courses");
    struct json_value name = value_member(json, "name"), repeat = value_member(json, "repeat");
    struct json_value law = value_member(json, "compaction");
    struct json_value boundary = value_member(json, "boundary");
    struct json_value weight = value_member(json, "areal_weight");
    struct json_value price = value_member(json, "price");
    char *own = json_tree_alloc(json->tree, LAMINATE_NAME_MAX + 1, 1);
    *ply = (struct laminate_ply){.drape = *common, .repeat = 1, .name = own, .number = number};
    if (own)
        (void)snprintf(own, LAMINATE_NAME_MAX + 1, "ply_%zu", number + 1);
    if (own && value_given(&name))
        decode_name(&name, LAMINATE_NAME_MAX, own);
    if (!value_object(json, keys))
        return;
    decode_ply(json, &ply->drape);
    ply->areal_weight = ply->drape.fabric.areal_weight;
    ply->price = ply->drape.fabric.price;
    ply->law = ply->drape.fabric.compaction;
    if (value_given(&weight))
        value_number(&weight, decode_areal_weights, &ply->areal_weight);
    if (value_given(&price))
        value_number(&price, decode_prices, &ply->price);
    if (value_given(&repeat))
        value_integer(&repeat, 1, LAMINATE_REPEAT_MAX, &ply->repeat);
    if (value_given(&law))
        decode_compaction(&law, &ply->law);
    if (value_given(&boundary))
        decode_boundary(&boundary, &common->surface, &ply->boundary);
    if (value_given(&courses))
        decode_courses_of_ply(json, ply);
    else
        decode_division(json, ply);
}

/* ---- the stack ---- */

static void decode_plies(const struct json_value *list, const struct api_request *common,
                         struct laminate *laminate) {
    if (!value_array(list, 1))
        return;
    laminate->count = laminate->ply_count = value_length(list);
    if (laminate->count > LAMINATE_PLIES_MAX) {
        value_fault(list,
                    "has %zu plies, and %d are allowed: use \"repeat\" for equal plies in sequence",
                    laminate->count, LAMINATE_PLIES_MAX);
        laminate->count = laminate->ply_count = 0;
        return;
    }
    double below = 0; /* the heights h_k of the header */
    laminate->plies = json_tree_alloc(list->tree, laminate->count, sizeof *laminate->plies);
    for (size_t k = 0; laminate->plies && k < laminate->count; k++) {
        struct json_value ply = value_element(list, k);
        struct json_value fabric = value_member(&ply, "fabric");
        struct json_value thickness = value_member(&fabric, "thickness");
        struct json_value fraction = value_member(&fabric, "fiber_volume_fraction");
        struct laminate_ply *own = &laminate->plies[k];
        decode_laminate_ply(&ply, common, k, own);
        /* What the stack needs of a ply. */
        bool thick = own->drape.fabric.thickness > 0;
        if (laminate->nominal && !thick)
            value_fault(&thickness,
                        "is required for this offset, because each ply lies on those below it");
        else if (laminate->cavity.kind == STACK_HEIGHT && !thick)
            value_fault(&thickness, "is required in a cavity of a given height");
        else if (own->law.a > 0 && !thick)
            value_fault(&thickness, "is required by the compaction");
        if (own->law.a > 0 && !(own->drape.fabric.fiber_volume_fraction > 0))
            value_fault(&fraction, "is required by the compaction");
        double high = laminate_layers(own) * own->drape.fabric.thickness;
        if (laminate->nominal)
            own->drape.offset = laminate->side * (below + high / 2);
        below += high;
    }
}

enum api_problem_id laminate_decode(const struct api_input *input, const struct api_limits *limits,
                                    struct arena *arena, struct laminate *laminate,
                                    struct api_problem *problem) {
    static const char *const keys[] = {"surface", "length_unit", "plies",   "cavity",
                                       "offset",  "side",        "rosette", NULL};
    static const char *const offsets[] = {"none", "nominal"}, *const cavities[] = {"flexible"};
    static const char *const cavity_keys[] = {"pressure", "height", NULL};
    struct json_tree tree;
    struct api_request common;
    int index = 0;
    *laminate = (struct laminate){.side = 1};
    if (json_tree_parse(&tree, input->request, input->request_length, limits, arena, problem) !=
        API_OK)
        return problem->id;
    struct json_value root = value_root(&tree), plies = value_member(&root, "plies");
    struct json_value cavity = value_member(&root, "cavity");
    struct json_value offset = value_member(&root, "offset"), side = value_member(&root, "side");
    if (value_object(&root, keys)) {
        decode_common(&root, input, limits, &common);
        laminate->surface = common.surface;
        laminate->length_unit = common.length_unit;
        struct stack_cavity *own = &laminate->cavity;
        struct json_value pressure = value_member(&cavity, "pressure");
        struct json_value height = value_member(&cavity, "height");
        if (value_type(&cavity) == VALUE_STRING) {
            value_choice(&cavity, cavities, 1, &index);
        } else if (value_given(&cavity) && value_object(&cavity, cavity_keys)) {
            bool pressed = value_given(&pressure);
            if (pressed == value_given(&height))
                value_fault(&cavity,
                            "must be \"flexible\", or have either \"pressure\" or \"height\"");
            else
                own->kind = pressed ? STACK_PRESSURE : STACK_HEIGHT;
            if (own->kind == STACK_PRESSURE)
                value_number(&pressure, pressures, &own->pressure);
            else if (own->kind == STACK_HEIGHT)
                value_number(&height, decode_lengths, &own->height);
        }
        if (value_given(&offset) && value_choice(&offset, offsets, 2, &index))
            laminate->nominal = index == 1;
        if (laminate->nominal && laminate->surface.kind == API_SURFACE_MESH)
            value_fault(&offset, "\"nominal\" needs a surface, not a triangle mesh, whose "
                                 "curvature is not known: use \"none\"");
        if (value_given(&side) && value_integer(&side, -1, 1, &laminate->side) &&
            laminate->side == 0)
            value_fault(&side, "must be 1 or -1");
        decode_plies(&plies, &common, laminate);
    }
    json_tree_free(&tree);
    return problem->id;
}
