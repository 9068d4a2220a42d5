/* SPDX-License-Identifier: MIT */
/* The JSON body of a map request, read straight into arrays. */
#include "target.h"

#include "api/json/scan.h"
#include "ids.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- arrays ---- */

/* What an array of the document holds: rows of `width` numbers, or with a width of 1 numbers. Whole
 * numbers are kept as int32_t, those of rows with -1 up to a fourth; others as doubles. */
struct kind {
    int width;
    bool whole;
    double low, high;
    const char *what; /* each number must be */
};

static const struct kind points = {3, false, -MAP_COORDINATE_MAX, MAP_COORDINATE_MAX,
                                   "must be between -1e12 and 1e12"};
static const struct kind triangles = {3, true, 0, INT32_MAX,
                                      "must be the index of a vertex, from 0"};
static const struct kind quads = {4, true, 0, INT32_MAX, "must be the index of a vertex, from 0"};
static const struct kind ids = {1, true, 1, INT32_MAX, "must be a whole number from 1"};
static const struct kind inlets = {1, true, 0, INT32_MAX,
                                   "must be the index of an element, from 0"};
static const struct kind heights = {1, false, 0, MAP_COORDINATE_MAX,
                                    "must be a height, or 0 for the stack's own"};

struct array {
    void *values; /* NULL: not in the document */
    size_t count; /* rows, or numbers */
};

/* One element: a number, or a row of them. */
static bool read_element(struct scan *scan, const char *path, const struct kind *kind, long row,
                         double values[4]) {
    const char *form =
        kind->width == 3 ? "must be an array of three numbers" : "must be an array of four numbers";
    bool flat = kind->width == 1, more;
    if (!flat && !scan_open(scan, '[', path, row, form))
        return false;
    for (int k = 0; k < kind->width; k++) {
        if (!flat && k == 0 && scan_peek(scan) == ']')
            return scan_invalid(scan, path, row, -1, "%s", form);
        if (!scan_number(scan, path, row, flat ? -1 : k, &values[k]))
            return false;
        if (!flat && !scan_next(scan, ']', &more))
            return false;
        if (!flat && more != (k < kind->width - 1))
            return scan_invalid(scan, path, row, -1, "%s", form);
    }
    return true;
}

static bool read_number_array(struct scan *scan, const char *path, const struct kind *kind,
                              struct array *array) {
    static const size_t sizes[2] = {sizeof(double), sizeof(int32_t)};
    const int stride = kind->width > 1 && kind->whole ? 4 : kind->width;
    bool more = true;
    if (array->values)
        return scan_malformed(scan, "the key is given twice");
    if (!scan_open(scan, '[', path, -1,
                   kind->width > 1 ? "must be an array of arrays of numbers"
                   : kind->whole   ? "must be an array of whole numbers"
                                   : "must be an array of numbers"))
        return false;
    if (kind->width > 1 && scan_peek(scan) == ']')
        return scan_invalid(scan, path, -1, -1, "must not be empty");
    size_t room = 1, depth = 1; /* an element more than there are commas between them */
    for (const char *c = scan->at; c < scan->end && depth > 0; c++) {
        room += *c == ',' && depth == 1;
        depth += *c == '[';
        depth -= *c == ']';
    }
    if (room > INT32_MAX)
        return scan_invalid(scan, path, -1, -1, "has too many elements");
    array->values = arena_take(scan->arena, room * (size_t)stride, sizes[kind->whole]);
    if (!array->values)
        return scan_no_memory(scan);
    if (scan_take(scan, ']'))
        return true;
    for (size_t at = 0; more; at += (size_t)stride) {
        long row = (long)array->count++;
        double values[4] = {-1, -1, -1, -1};
        if (!read_element(scan, path, kind, row, values))
            return false;
        for (int k = 0; k < kind->width; k++)
            if (!(values[k] >= kind->low && values[k] <= kind->high) ||
                (kind->whole && values[k] != floor(values[k])))
                return scan_invalid(scan, path, row, kind->width > 1 ? k : -1, "%s", kind->what);
        for (int k = 0; k < stride && kind->whole; k++)
            ((int32_t *)array->values)[at + (size_t)k] = (int32_t)values[k];
        if (!kind->whole)
            memcpy((double *)array->values + at, values, (size_t)stride * sizeof *values);
        if (!scan_next(scan, ']', &more))
            return false;
    }
    return true;
}

/* ---- the document ---- */

/* What a mesh is made from. */
struct mesh_text {
    struct array vertices, triangles, quads, ids, vertex_ids;
};

/* The document, before it is known to make sense. */
struct document {
    struct array points, inlet, heights;
    bool has_mesh, has_punch;
    struct mesh_text mesh, punch;
};

/* The mesh or the punch. */
static bool read_json_mesh(struct scan *scan, const char *name, struct mesh_text *mesh) {
    const struct {
        const char *key;
        const struct kind *kind;
        struct array *array;
    } members[] = {{"vertices", &points, &mesh->vertices},
                   {"triangles", &triangles, &mesh->triangles},
                   {"quads", &quads, &mesh->quads},
                   {"ids", &ids, &mesh->ids},
                   {"vertex_ids", &ids, &mesh->vertex_ids}};
    enum { MEMBERS = sizeof members / sizeof *members };
    char key[SCAN_KEY_SIZE], path[2 * SCAN_KEY_SIZE + 2];
    bool more = true;
    snprintf(path, sizeof path, "/%s", name);
    if (!scan_open(scan, '{', path, -1, "must be an object"))
        return false;
    if (scan_take(scan, '}'))
        return true;
    while (more) {
        size_t k = 0;
        if (!scan_key(scan, key))
            return false;
        snprintf(path, sizeof path, "/%s/%s", name, key);
        while (k < MEMBERS && strcmp(members[k].key, key) != 0)
            k++;
        if (k == MEMBERS)
            return scan_invalid(scan, path, -1, -1, "is not known here");
        if (!read_number_array(scan, path, members[k].kind, members[k].array) ||
            !scan_next(scan, '}', &more))
            return false;
    }
    return true;
}

static bool read_document(struct scan *scan, struct document *document) {
    char key[SCAN_KEY_SIZE], path[SCAN_KEY_SIZE + 1];
    bool more = true;
    if (!scan_open(scan, '{', "", -1, "must be an object"))
        return false;
    if (scan_take(scan, '}'))
        more = false;
    while (more) {
        if (!scan_key(scan, key))
            return false;
        snprintf(path, sizeof path, "/%s", key);
        bool is_points = strcmp(key, "points") == 0, mesh = strcmp(key, "mesh") == 0;
        bool punch = strcmp(key, "punch") == 0, good;
        if ((is_points || mesh) && (document->points.values || document->has_mesh))
            return scan_invalid(
                scan, path, -1, -1,
                "must not be given: the document must have only one of \"points\" and \"mesh\"");
        if (punch && document->has_punch)
            return scan_malformed(scan, "the key is given twice");
        document->has_mesh = document->has_mesh || mesh;
        document->has_punch = document->has_punch || punch;
        if (mesh || punch)
            good = read_json_mesh(scan, key, mesh ? &document->mesh : &document->punch);
        else if (is_points)
            good = read_number_array(scan, path, &points, &document->points);
        else if (strcmp(key, "cavity_heights") == 0)
            good = read_number_array(scan, path, &heights, &document->heights);
        else if (strcmp(key, "inlet_elements") == 0)
            good = read_number_array(scan, path, &inlets, &document->inlet);
        else
            good = scan_invalid(scan, path, -1, -1, "is not known here");
        if (!good || !scan_next(scan, '}', &more))
            return false;
    }
    return (scan_peek(scan) == '\0' && scan->at == scan->end) ||
           scan_malformed(scan, "there is text after the end of the document");
}

/* ---- sense ---- */

/* Whether the elements have vertices that are there. */
static bool check_elements(struct scan *scan, const struct array *elements, const char *path,
                           size_t vertices) {
    const int32_t(*corners)[4] = elements->values;
    for (size_t row = 0; row < elements->count; row++)
        for (int k = 0; k < 4 && corners[row][k] >= 0; k++)
            if ((size_t)corners[row][k] >= vertices)
                return scan_invalid(scan, path, (long)row, k,
                                    "must be the index of a vertex, less than %zu", vertices);
    return true;
}

/* What a mesh or a punch has to have: its triangles, and then its quads. */
static bool take_elements(struct scan *scan, const char *name, const struct mesh_text *mesh,
                          const int32_t (**elements)[4], size_t *count) {
    const struct array *first = &mesh->triangles, *second = &mesh->quads;
    char path[3][SCAN_KEY_SIZE + 16];
    static const char *const keys[] = {"vertices", "triangles", "quads"};
    for (int k = 0; k < 3; k++)
        snprintf(path[k], sizeof path[k], "/%s/%s", name, keys[k]);
    if (!mesh->vertices.values)
        return scan_invalid(scan, path[0], -1, -1, "is required");
    if (!first->values && !second->values)
        return scan_invalid(scan, path[1], -1, -1, "is required, or \"quads\"");
    if (!check_elements(scan, first, path[1], mesh->vertices.count) ||
        !check_elements(scan, second, path[2], mesh->vertices.count))
        return false;
    int32_t(*rows)[4] = first->values ? first->values : second->values;
    *count = first->count + second->count;
    if (first->values && second->values) {
        rows = arena_take(scan->arena, *count, sizeof *rows);
        if (!rows)
            return scan_no_memory(scan);
        memcpy(rows, first->values, first->count * sizeof *rows);
        memcpy(rows + first->count, second->values, second->count * sizeof *rows);
    }
    *elements = (const int32_t(*)[4])rows;
    return true;
}

/* Numbers that the mesh gives: one each, all different. */
static bool take_ids(struct scan *scan, const struct array *given, const char *path, size_t count,
                     const int32_t **target) {
    const int32_t *values = given->values;
    if (!values)
        return true;
    if (given->count != count)
        return scan_invalid(scan, path, -1, -1, "must have %zu numbers, not %zu", count,
                            given->count);
    struct arena_mark mark = arena_mark(scan->arena);
    const struct map_id *sorted = map_ids_sort(values, count, scan->arena);
    long repeated = sorted ? map_ids_repeated(sorted, count) : -1;
    arena_rewind(scan->arena, mark);
    if (!sorted)
        return scan_no_memory(scan);
    *target = values;
    return repeated < 0 ||
           scan_invalid(scan, path, repeated, -1, "is given twice: %d", values[repeated]);
}

/* The points or the mesh, and what is said of the cavity. */
static bool take_document(struct scan *scan, const struct document *document,
                          struct map_target *target) {
    const struct array *given = &document->heights;
    const struct mesh_text *mesh = &document->mesh;
    const int32_t *inlet = document->inlet.values;
    if (document->has_mesh) {
        target->vertices = mesh->vertices.values;
        target->vertex_count = mesh->vertices.count;
        if (!take_elements(scan, "mesh", mesh, &target->elements, &target->element_count) ||
            !take_ids(scan, &mesh->ids, "/mesh/ids", target->element_count, &target->ids) ||
            !take_ids(scan, &mesh->vertex_ids, "/mesh/vertex_ids", mesh->vertices.count,
                      &target->vertex_ids))
            return false;
    } else {
        if (!document->points.values)
            return scan_invalid(scan, "", -1, -1, "must have either \"points\" or \"mesh\"");
        if (inlet)
            return scan_invalid(scan, "/inlet_elements", -1, -1, "needs a mesh");
        target->vertices = document->points.values;
        target->vertex_count = target->element_count = document->points.count;
    }
    if (inlet) {
        target->has_role[MAP_INLET] = true;
        target->roles = arena_alloc(scan->arena, target->element_count, 1);
        if (!target->roles)
            return scan_no_memory(scan);
    }
    for (size_t k = 0; inlet && k < document->inlet.count; k++) {
        if ((size_t)inlet[k] >= target->element_count)
            return scan_invalid(scan, "/inlet_elements", (long)k, -1,
                                "must be the index of an element, less than %zu",
                                target->element_count);
        target->roles[inlet[k]] = MAP_INLET;
    }
    if (given->values && document->has_punch)
        return scan_invalid(scan, "/punch", -1, -1, "must not be given beside \"cavity_heights\"");
    if (given->values && given->count != target->element_count)
        return scan_invalid(scan, "/cavity_heights", -1, -1, "must have %zu numbers, not %zu",
                            target->element_count, given->count);
    target->heights = given->values;
    target->punch_vertices = document->punch.vertices.values;
    return !document->has_punch ||
           take_elements(scan, "punch", &document->punch, &target->punch, &target->punch_count);
}

enum api_problem_id map_target_json(const char *bytes, size_t length, struct arena *arena,
                                    struct map_target *target, struct api_problem *problem) {
    struct scan scan = {bytes, bytes, bytes + length, arena, problem};
    struct document document = {0};
    *target = (struct map_target){0};
    if (length == 0)
        scan_malformed(&scan, "the document is empty");
    else if (read_document(&scan, &document))
        (void)take_document(&scan, &document, target);
    return problem->id;
}
