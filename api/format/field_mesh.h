/* SPDX-License-Identifier: MIT */
/*
 * Mesh files of pre-processors, as text, with the fields of a map on their elements: the nodes, the
 * elements, the sets of elements that have names, and each field, element by element. A format is
 * data, `struct field_mesh`: what it writes before, for each item, and behind.
 *
 * Numbers of elements and nodes are the caller's, as `deck_element_id` has them. Where a field has
 * no value on an element (of a ply that is not there) it is NaN there.
 */
#ifndef API_FORMAT_FIELD_MESH_H
#define API_FORMAT_FIELD_MESH_H

#include "vtk.h"

enum { FIELD_MESH_ITEM = 2048 }; /* bytes that any of these writes at most but the head */

struct field_mesh {
    void (*head)(struct encoder *encoder); /* ENCODER_PIECE bytes of room */
    void (*node)(struct encoder *encoder, size_t vertex);
    void (*between)(struct encoder *encoder); /* behind the nodes */
    void (*element)(struct encoder *encoder, size_t element);
    void (*tail)(struct encoder *encoder); /* behind the elements */
    /* Member `index` of the `count` ones of a set: the elements of its property. NULL: the format
     * has the sets elsewhere. */
    void (*member)(struct encoder *encoder, size_t set, size_t element, size_t index, size_t count);
    void (*close)(struct encoder *encoder); /* behind the sets; NULL: nothing */
    void (*field)(struct encoder *encoder, const struct vtk_array *array);
    /* `values` are the array's components, of tensors XX YY ZZ XY YZ XZ; NaN: there is none. */
    void (*value)(struct encoder *encoder, const struct vtk_array *array, size_t element,
                  const double *values);
    const char *end_field;
};

struct field_mesh_state {
    struct vtk_file file; /* for its list of fields */
    int section;          /* of the file that is being written */
    size_t field;         /* of the list, in the last section */
    size_t index, count;  /* the next member of the set that is being written, and all of it */
};

/* What a format is beside its name, media type and texts; `mesh` is a struct field_mesh. */
#define FIELD_MESH_FORMAT(mesh, prepare)                                                           \
    .uses = FORMAT_MAP, .elements = true, .flow = true, .own = &(mesh),                            \
    .state_size = sizeof(struct field_mesh_state), .begin = (prepare), .next = field_mesh_next

/* Finds the fields. Sets the problem of a stack with more of them than there is room for; false. */
bool field_mesh_full(const struct encoder *encoder, struct api_problem *problem);
bool field_mesh_begin(struct encoder *encoder, struct api_problem *problem);
void field_mesh_next(struct encoder *encoder);

#endif
