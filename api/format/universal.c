/* SPDX-License-Identifier: MIT */
/*
 * A universal file of I-deas: dataset 164 (units), 2411 (nodes), 2412 (thin shell elements, 91 and
 * 94), 2467 (groups: the sets of the mesh) and for each field 2414 (analysis data on elements), by
 * the descriptions of the Structural Dynamics Research Laboratory, University of Cincinnati.
 * Elements on which a field has no value are left out of its dataset.
 */
#include "deck.h"
#include "field_mesh.h"
#include <math.h>
#include <string.h>

enum {
    TENSOR = 6,
    TRIANGLE = 91,
    QUADRILATERAL = 94,
    COLOUR = 7,
    ELEMENT_CODE = 8,
    ON_ELEMENTS = 2
};

/* SI: the length is in metres when it is divided by the factor. */
static void write_units(struct encoder *encoder) {
    const struct api_unit *unit = encoder->fields.unit;
    double factor = 1 / unit->metres;
    api_text_format(&encoder->piece,
                    "    -1\n   164\n%10d%-20s%10d\n%25.17E%25.17E%25.17E\n%25.17E\n    -1\n", 1,
                    unit->name, 2, factor, 1.0, 1.0, 0.0);
}

static void universal_head(struct encoder *encoder) {
    write_units(encoder);
    api_text_raw(&encoder->piece, "    -1\n  2411\n");
}

static void universal_node(struct encoder *encoder, size_t vertex) {
    struct vec3 p = encoder->fields.vertices[vertex];
    api_text_format(&encoder->piece, "%10d%10d%10d%10d\n%25.16E%25.16E%25.16E\n",
                    deck_vertex_id(&encoder->fields, vertex), 1, 1, 11, p.x, p.y, p.z);
}

static void universal_between(struct encoder *encoder) {
    api_text_raw(&encoder->piece, "    -1\n    -1\n  2412\n");
}

/* LABEL KIND PROPERTY MATERIAL COLOUR NODES; the nodes. */
static void universal_element(struct encoder *encoder, size_t element) {
    const struct map_fields *fields = &encoder->fields;
    const int32_t *corners = fields->elements[element];
    int count = element_corner_count(corners);
    api_text_format(&encoder->piece, "%10d%10d%10d%10d%10d%10d\n", deck_element_id(fields, element),
                    count == 3 ? TRIANGLE : QUADRILATERAL, fields->pids ? fields->pids[element] : 1,
                    1, COLOUR, count);
    for (int k = 0; k < count; k++)
        api_text_format(&encoder->piece, "%10d", deck_vertex_id(fields, (size_t)corners[k]));
    api_text_raw(&encoder->piece, "\n");
}

static void universal_tail(struct encoder *encoder) {
    api_text_raw(&encoder->piece, "    -1\n");
    if (encoder->fields.pids && encoder->fields.set_count)
        api_text_raw(&encoder->piece, "    -1\n  2467\n");
}

/* The number of the group, six of others, how many it has; its name; then two members a line. */
static void write_group_member(struct encoder *encoder, size_t set, size_t element, size_t index,
                               size_t count) {
    if (index == 0)
        api_text_format(&encoder->piece, "%10zu%10d%10d%10d%10d%10d%10d%10zu\n%s\n", set + 1, 0, 0,
                        0, 0, 0, 0, count, encoder->fields.sets[set].name);
    api_text_format(&encoder->piece, "%10d%10d%10d%10d%s", ELEMENT_CODE,
                    deck_element_id(&encoder->fields, element), 0, 0,
                    index % 2 || index + 1 == count ? "\n" : "");
}

static void close_groups(struct encoder *encoder) {
    if (encoder->fields.pids && encoder->fields.set_count)
        api_text_raw(&encoder->piece, "    -1\n");
}

/* Its number, name and place, five lines of text, what it is, and two lines each of integers and of
 * reals of an analysis, which there was none of. */
static void universal_field(struct encoder *encoder, const struct vtk_array *array) {
    enum { STRUCTURAL = 1, STATIC = 1, SINGLE = 2 };
    static const struct {
        int characteristic, result; /* scalar, vector; of an unknown kind */
    } kinds[] = {[1] = {1, 94}, [3] = {2, 95}};
    const struct field_mesh_state *state = encoder->state;
    struct api_text *text = &encoder->piece;
    char origin[ENCODER_NOTE_SIZE];
    int width = array->components;
    encoder_origin(encoder, origin);
    api_text_format(text, "    -1\n  2414\n%10zu\n%s\n%10d\n%.80s\nNONE\nNONE\nNONE\nNONE\n",
                    state->field + 1, array->name, ON_ELEMENTS, origin);
    api_text_format(text, "%10d%10d%10d%10d%10d%10d\n", STRUCTURAL, STATIC,
                    kinds[width].characteristic, kinds[width].result, SINGLE, width);
    api_text_format(text, "%10d%10d%10d%10d%10d%10d%10d%10d\n%10d%10d\n", 0, 0, 1, 0, 1, 0, 0, 0, 0,
                    0);
    for (int line = 0; line < 2; line++)
        api_text_format(text, "%13.5E%13.5E%13.5E%13.5E%13.5E%13.5E\n", 0.0, 0.0, 0.0, 0.0, 0.0,
                        0.0);
}

static void universal_value(struct encoder *encoder, const struct vtk_array *array, size_t element,
                            const double *values) {
    struct api_text *text = &encoder->piece;
    int width = array->components;
    for (int k = 0; k < width; k++)
        if (isnan(values[k]))
            return;
    api_text_format(text, "%10d%10d\n", deck_element_id(&encoder->fields, element), width);
    for (int k = 0; k < width; k++)
        api_text_format(text, "%13.5E", values[k]);
    api_text_raw(text, "\n");
}

/* A tensor becomes its components, each a field of its own: in which order a dataset has them is
 * not in the descriptions. */
static bool begin_universal(struct encoder *encoder, struct api_problem *problem) {
    struct vtk_file *file = encoder->state;
    bool room = field_mesh_begin(encoder, problem);
    for (size_t k = 0; room && k < file->count; k++) {
        const struct vtk_array tensor = file->array[k];
        if (tensor.components < TENSOR)
            continue;
        memmove(&file->array[k], &file->array[k + 1], (--file->count - k) * sizeof *file->array);
        for (int c = 0; c < TENSOR && tensor.kind == VTK_COLUMNS && room; c++)
            room =
                vtk_add_columns(file, VTK_CELL_DATA, tensor.column[c]->name, 1, &tensor.column[c]);
    }
    return room || field_mesh_full(encoder, problem);
}

static const struct field_mesh mesh = {.head = universal_head,
                                       .node = universal_node,
                                       .between = universal_between,
                                       .element = universal_element,
                                       .tail = universal_tail,
                                       .member = write_group_member,
                                       .close = close_groups,
                                       .field = universal_field,
                                       .value = universal_value,
                                       .end_field = "    -1\n"};

const struct format format_universal = {
    .name = "unv",
    .media_type = "text/x-unv",
    .about = "a universal file with the fields of the mesh's elements and plies as analysis data",
    .exact = "places to every bit, fields to 6 digits",
    FIELD_MESH_FORMAT(mesh, begin_universal)};
