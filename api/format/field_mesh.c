/* SPDX-License-Identifier: MIT */
#include "field_mesh.h"

#include <string.h>

enum section { HEAD, NODES, BETWEEN, ELEMENTS, TAIL, MEMBERS, CLOSE, FIELDS, SECTIONS };

bool field_mesh_full(const struct encoder *encoder, struct api_problem *problem) {
    return !api_problem_set(problem, API_TOO_LARGE,
                            "the stack has too many plies for %s: give `fields` without plies.*, "
                            "or choose csv",
                            encoder->format->name);
}

/* Ids and properties, which come first, are the mesh's own. */
bool field_mesh_begin(struct encoder *encoder, struct api_problem *problem) {
    struct vtk_file *file = encoder->state;
    struct map_fields fields = encoder->fields;
    while (fields.column_count > 0 &&
           (strcmp(fields.columns->name, column_specs[COLUMN_CELLS_id].name) == 0 ||
            strcmp(fields.columns->name, column_specs[COLUMN_CELLS_pid].name) == 0)) {
        fields.columns++;
        fields.column_count--;
    }
    return vtk_add_elements(file, &fields) || field_mesh_full(encoder, problem);
}

/* An element in the list of a set, if it is in it. */
static void write_if_member(struct encoder *encoder, size_t set, size_t element) {
    const struct field_mesh *mesh = encoder->format->own;
    const struct map_fields *fields = &encoder->fields;
    struct field_mesh_state *state = encoder->state;
    int32_t property = fields->sets[set].property;
    if (element == 0) {
        state->index = state->count = 0;
        for (size_t k = 0; k < fields->element_count; k++)
            state->count += fields->pids[k] == property;
    }
    if (fields->pids[element] == property)
        mesh->member(encoder, set, element, state->index++, state->count);
}

/* As many rows of a field as there is room for; how many. */
static size_t write_field_rows(struct encoder *encoder, const struct vtk_array *array, size_t row) {
    _Alignas(8) unsigned char block[VTK_BLOCK];
    const struct field_mesh *mesh = encoder->format->own;
    const double *reals = (const double *)block;
    const int64_t *integers = (const int64_t *)block;
    size_t width = (size_t)array->components, most = VTK_BLOCK / (sizeof(double) * width);
    size_t room = (encoder->piece.capacity - encoder->piece.length) / FIELD_MESH_ITEM;
    size_t count = encoder_left(encoder, array->rows, room < most ? room : most);
    encoder->failed = !vtk_fill(encoder, array, row, count, block);
    for (size_t k = 0; k < count && !encoder->failed; k++) {
        double whole = array->type == VTK_INT64 ? (double)integers[k] : 0;
        mesh->value(encoder, array, row + k, array->type == VTK_INT64 ? &whole : reals + k * width);
    }
    if (row + count == array->rows)
        api_text_raw(&encoder->piece, mesh->end_field);
    return count;
}

/* Writes the item or items that come next of a section; how many. */
static size_t write_items(struct encoder *encoder, enum section section, size_t row) {
    const struct field_mesh *mesh = encoder->format->own;
    const struct map_fields *fields = &encoder->fields;
    const struct field_mesh_state *state = encoder->state;
    const struct vtk_array *array = &state->file.array[state->field];
    switch (section) {
    case HEAD:
        mesh->head(encoder);
        break;
    case NODES:
        mesh->node(encoder, row);
        break;
    case BETWEEN:
        mesh->between(encoder);
        break;
    case ELEMENTS:
        mesh->element(encoder, row);
        break;
    case TAIL:
        mesh->tail(encoder);
        break;
    case MEMBERS:
        write_if_member(encoder, row / fields->element_count, row % fields->element_count);
        break;
    case CLOSE:
        if (mesh->close)
            mesh->close(encoder);
        break;
    case FIELDS:
        if (row == 0)
            mesh->field(encoder, array);
        return write_field_rows(encoder, array, row);
    case SECTIONS:
        break;
    }
    return 1;
}

void field_mesh_next(struct encoder *encoder) {
    const struct field_mesh *mesh = encoder->format->own;
    const struct map_fields *fields = &encoder->fields;
    struct field_mesh_state *state = encoder->state;
    const size_t rows[SECTIONS] = {
        [HEAD] = 1,
        [NODES] = fields->vertex_count,
        [BETWEEN] = 1,
        [ELEMENTS] = fields->element_count,
        [TAIL] = 1,
        [MEMBERS] = mesh->member && fields->pids ? fields->set_count * fields->element_count : 0,
        [CLOSE] = 1,
        [FIELDS] = fields->element_count};
    while (state->section < SECTIONS && !encoder->failed &&
           encoder->piece.capacity - encoder->piece.length > 2 * FIELD_MESH_ITEM) {
        if (state->section == FIELDS && state->field == state->file.count) {
            state->section = SECTIONS;
            break;
        }
        if (encoder->row < rows[state->section])
            encoder->row += write_items(encoder, (enum section)state->section, encoder->row);
        if (encoder->row < rows[state->section])
            continue;
        encoder->row = 0;
        state->field += state->section == FIELDS;
        state->section += state->section != FIELDS;
    }
    encoder->ended = state->section == SECTIONS;
}
