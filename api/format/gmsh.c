/* SPDX-License-Identifier: MIT */
/*
 * A mesh of Gmsh, MSH 2.2 as text (gmsh.info/doc/texinfo/gmsh.html, "MSH file format version 2
 * (Legacy)"): properties are physical groups, with the names of the mesh's sets, and each field is
 * a view on the elements. Gmsh has views of 1, 3 and 9 components, so a tensor is written whole.
 */
#include "deck.h"
#include "field_mesh.h"

enum { TRIANGLE = 2, QUADRANGLE = 3 }; /* Gmsh's types of elements */

static bool is_property(const struct map_fields *fields, int32_t property) {
    for (size_t k = 0; fields->pids && k < fields->element_count; k++)
        if (fields->pids[k] == property)
            return true;
    return false;
}

static void gmsh_head(struct encoder *encoder) {
    const struct map_fields *fields = &encoder->fields;
    struct api_text *text = &encoder->piece;
    char origin[ENCODER_NOTE_SIZE];
    encoder_origin(encoder, origin);
    api_text_format(text,
                    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Comments\n%s; lengths in %s\n"
                    "$EndComments\n",
                    origin, fields->unit->name);
    size_t names = 0;
    for (size_t k = 0; k < fields->set_count; k++)
        names += is_property(fields, fields->sets[k].property);
    if (names) {
        api_text_format(text, "$PhysicalNames\n%zu\n", names);
        for (size_t k = 0; k < fields->set_count; k++)
            if (is_property(fields, fields->sets[k].property))
                api_text_format(text, "2 %d \"%s\"\n", fields->sets[k].property,
                                fields->sets[k].name);
        api_text_raw(text, "$EndPhysicalNames\n");
    }
    api_text_format(text, "$Nodes\n%zu\n", fields->vertex_count);
}

static void write_values(struct api_text *text, const double *values, int count) {
    for (int k = 0; k < count; k++) {
        api_text_raw(text, " ");
        if (values[k] == values[k])
            api_text_number(text, values[k]);
        else
            api_text_raw(text, "nan");
    }
    api_text_raw(text, "\n");
}

static void gmsh_node(struct encoder *encoder, size_t vertex) {
    struct vec3 p = encoder->fields.vertices[vertex];
    api_text_integer(&encoder->piece, deck_vertex_id(&encoder->fields, vertex));
    write_values(&encoder->piece, (const double[]){p.x, p.y, p.z}, 3);
}

static void gmsh_between(struct encoder *encoder) {
    api_text_format(&encoder->piece, "$EndNodes\n$Elements\n%zu\n", encoder->fields.element_count);
}

/* ID TYPE 2 PHYSICAL ELEMENTARY NODE... */
static void gmsh_element(struct encoder *encoder, size_t element) {
    const struct map_fields *fields = &encoder->fields;
    const int32_t *corners = fields->elements[element];
    int32_t property = fields->pids ? fields->pids[element] : 0;
    api_text_format(&encoder->piece, "%d %d 2 %d %d", deck_element_id(fields, element),
                    corners[3] < 0 ? TRIANGLE : QUADRANGLE, property, property);
    for (int k = 0; k < 4 && corners[k] >= 0; k++)
        api_text_format(&encoder->piece, " %d", deck_vertex_id(fields, (size_t)corners[k]));
    api_text_raw(&encoder->piece, "\n");
}

static void gmsh_tail(struct encoder *encoder) {
    api_text_raw(&encoder->piece, "$EndElements\n");
}

/* One string tag, its name; one real, the time; three integers: the step, the components and the
 * elements. */
static void gmsh_view(struct encoder *encoder, const struct vtk_array *array) {
    api_text_format(&encoder->piece, "$ElementData\n1\n\"%s\"\n1\n0\n3\n0\n%d\n%zu\n", array->name,
                    array->components == 6 ? 9 : array->components, encoder->fields.element_count);
}

static void gmsh_value(struct encoder *encoder, const struct vtk_array *array, size_t element,
                       const double *values) {
    static const int whole[] = {0, 3, 5, 3, 1, 4, 5, 4, 2}; /* XX XY XZ YX YY YZ ZX ZY ZZ */
    enum { WHOLE = sizeof whole / sizeof *whole };
    double tensor[WHOLE];
    for (int k = 0; k < WHOLE && array->components == 6; k++)
        tensor[k] = values[whole[k]];
    api_text_integer(&encoder->piece, deck_element_id(&encoder->fields, element));
    if (array->components == 6)
        write_values(&encoder->piece, tensor, WHOLE);
    else
        write_values(&encoder->piece, values, array->components);
}

static const struct field_mesh mesh = {.head = gmsh_head,
                                       .node = gmsh_node,
                                       .between = gmsh_between,
                                       .element = gmsh_element,
                                       .tail = gmsh_tail,
                                       .field = gmsh_view,
                                       .value = gmsh_value,
                                       .end_field = "$EndElementData\n"};

const struct format format_gmsh = {
    .name = "gmsh",
    .media_type = "text/x-gmsh",
    .about = "a mesh of Gmsh (MSH 2.2) with the fields of its elements and plies as views",
    .exact = "every bit",
    FIELD_MESH_FORMAT(mesh, field_mesh_begin)};
