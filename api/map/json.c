/* SPDX-License-Identifier: MIT */
/* The JSON body of a map request, read straight into arrays. */
#include "target.h"

#include "api/json/scan.h"
#include "ids.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static const double coordinate_max = 1e12;

/* ---- arrays ---- */

/* How many brackets open right inside the array that has just been opened. */
static size_t count_rows(const struct scan *scan) {
    size_t rows = 0, depth = 1;
    for (const char *c = scan->at; c < scan->end && depth > 0; c++) {
        rows += *c == '[' && depth == 1;
        depth += *c == '[';
        depth -= *c == ']';
    }
    return rows;
}

/* A row of three or four numbers; `*more`: another row follows it. */
static bool read_row(struct scan *scan, const char *path, long row, int width, double values[4],
                     bool *more) {
    const char *form =
        width == 3 ? "must be an array of three numbers" : "must be an array of four numbers";
    bool another;
    if (!scan_open(scan, '[', path, row, form))
        return false;
    for (int k = 0; k < width; k++) {
        if (k == 0 && scan_peek(scan) == ']')
            return scan_invalid(scan, path, row, -1, "%s", form);
        if (!scan_number(scan, path, row, k, &values[k]) || !scan_next(scan, ']', &another))
            return false;
        if (another != (k < width - 1))
            return scan_invalid(scan, path, row, -1, "%s", form);
    }
    return scan_next(scan, ']', more);
}

static bool begin_rows(struct scan *scan, const char *path, size_t size, size_t *rows,
                       void **array) {
    if (!scan_open(scan, '[', path, -1, "must be an array of arrays of numbers"))
        return false;
    if (scan_peek(scan) == ']')
        return scan_invalid(scan, path, -1, -1, "must not be empty");
    *rows = count_rows(scan);
    *array = arena_take(scan->arena, *rows, size);
    if (*rows > INT32_MAX)
        return scan_invalid(scan, path, -1, -1, "has too many elements");
    return *array || scan_no_memory(scan);
}

static bool read_points(struct scan *scan, const char *path, const struct vec3 **points,
                        size_t *count) {
    struct vec3 *rows;
    void *array;
    double v[4];
    bool more = true;
    size_t room, row = 0;
    if (!begin_rows(scan, path, sizeof *rows, &room, &array))
        return false;
    rows = array;
    for (; more; row++) {
        if (!read_row(scan, path, (long)row, 3, v, &more))
            return false;
        for (int k = 0; k < 3; k++)
            if (fabs(v[k]) > coordinate_max)
                return scan_invalid(scan, path, (long)row, k, "must be between -1e12 and 1e12");
        rows[row] = vec3_make(v[0], v[1], v[2]);
    }
    *points = rows;
    *count = row;
    return true;
}

static bool is_index(double value) {
    return value >= 0 && value <= INT32_MAX && value == floor(value);
}

/* Elements of one kind. */
struct shapes {
    int32_t (*corners)[4];
    size_t count;
};

static bool read_shapes(struct scan *scan, const char *path, int width, struct shapes *shapes) {
    void *array;
    double v[4];
    bool more = true;
    size_t room;
    if (!begin_rows(scan, path, sizeof *shapes->corners, &room, &array))
        return false;
    shapes->corners = array;
    for (; more; shapes->count++) {
        int32_t *corners = shapes->corners[shapes->count];
        corners[3] = -1;
        if (!read_row(scan, path, (long)shapes->count, width, v, &more))
            return false;
        for (int k = 0; k < width; k++) {
            if (!is_index(v[k]))
                return scan_invalid(scan, path, (long)shapes->count, k,
                                    "must be the index of a vertex, from 0");
            corners[k] = (int32_t)v[k];
        }
    }
    return true;
}

/* How many numbers the array that has just been opened may have. */
static size_t count_numbers(const struct scan *scan) {
    size_t count = 1;
    for (const char *c = scan->at; c < scan->end && *c != ']'; c++)
        count += *c == ',';
    return count;
}

struct indices {
    int32_t *values;
    size_t count;
};

/* Whole numbers from `least` on; `what` each must be. */
static bool read_indices(struct scan *scan, const char *path, int least, const char *what,
                         struct indices *indices) {
    bool more = true;
    if (!scan_open(scan, '[', path, -1, "must be an array of whole numbers"))
        return false;
    indices->values = arena_take(scan->arena, count_numbers(scan), sizeof *indices->values);
    if (!indices->values)
        return scan_no_memory(scan);
    if (scan_take(scan, ']'))
        return true;
    while (more) {
        long row = (long)indices->count;
        double value;
        if (!scan_number(scan, path, row, -1, &value))
            return false;
        if (!is_index(value) || value < least)
            return scan_invalid(scan, path, row, -1, "%s", what);
        indices->values[indices->count++] = (int32_t)value;
        if (!scan_next(scan, ']', &more))
            return false;
    }
    return true;
}

/* ---- the document ---- */

/* What a mesh is made from. */
struct mesh_text {
    const struct vec3 *vertices;
    size_t vertex_count;
    struct shapes triangles, quads;
    struct indices ids, vertex_ids;
};

static bool read_mesh_member(struct scan *scan, const char *name, const char *key,
                             struct mesh_text *mesh) {
    char path[2 * SCAN_KEY_SIZE + 2];
    snprintf(path, sizeof path, "/%s/%s", name, key);
    bool quads = strcmp(key, "quads") == 0, vertex_ids = strcmp(key, "vertex_ids") == 0;
    struct shapes *shapes = quads ? &mesh->quads : &mesh->triangles;
    struct indices *ids = vertex_ids ? &mesh->vertex_ids : &mesh->ids;
    static const char twice[] = "the key is there twice";
    if (strcmp(key, "vertices") == 0)
        return mesh->vertices ? scan_malformed(scan, twice)
                              : read_points(scan, path, &mesh->vertices, &mesh->vertex_count);
    if (quads || strcmp(key, "triangles") == 0)
        return shapes->corners ? scan_malformed(scan, twice)
                               : read_shapes(scan, path, quads ? 4 : 3, shapes);
    if (vertex_ids || strcmp(key, "ids") == 0)
        return ids->values ? scan_malformed(scan, twice)
                           : read_indices(scan, path, 1, "must be a whole number from 1", ids);
    return scan_invalid(scan, path, -1, -1, "is not known here");
}

/* The mesh or the punch. */
static bool read_mesh(struct scan *scan, const char *name, struct mesh_text *mesh) {
    char key[SCAN_KEY_SIZE], path[SCAN_KEY_SIZE + 1];
    bool more = true;
    snprintf(path, sizeof path, "/%s", name);
    if (!scan_open(scan, '{', path, -1, "must be an object"))
        return false;
    if (scan_take(scan, '}'))
        return true;
    while (more)
        if (!scan_key(scan, key) || !read_mesh_member(scan, name, key, mesh) ||
            !scan_next(scan, '}', &more))
            return false;
    return true;
}

/* The document, before it is known to make sense. */
struct document {
    const struct vec3 *points;
    size_t point_count;
    bool has_mesh, has_punch;
    struct mesh_text mesh, punch;
    struct indices inlet;
    struct heights {
        double *values;
        size_t count;
    } heights;
};

/* Of the cavity: positive, or 0 where that of the stack holds. */
static bool read_heights(struct scan *scan, const char *path, struct heights *heights) {
    bool more = true;
    if (!scan_open(scan, '[', path, -1, "must be an array of numbers"))
        return false;
    heights->values = arena_take(scan->arena, count_numbers(scan), sizeof *heights->values);
    if (!heights->values)
        return scan_no_memory(scan);
    if (scan_take(scan, ']'))
        return true;
    while (more) {
        double *own = &heights->values[heights->count];
        long row = (long)heights->count++;
        if (!scan_number(scan, path, row, -1, own))
            return false;
        if (!(*own >= 0 && *own <= coordinate_max))
            return scan_invalid(scan, path, row, -1, "must be a height, or 0 for the stack's own");
        if (!scan_next(scan, ']', &more))
            return false;
    }
    return true;
}

static bool read_member(struct scan *scan, const char *key, struct document *document) {
    char path[SCAN_KEY_SIZE + 1];
    snprintf(path, sizeof path, "/%s", key);
    bool points = strcmp(key, "points") == 0, mesh = strcmp(key, "mesh") == 0;
    if ((points || mesh) && (document->points || document->has_mesh))
        return scan_invalid(scan, path, -1, -1, "must be the only one of \"points\" and \"mesh\"");
    document->has_mesh = document->has_mesh || mesh;
    if (points)
        return read_points(scan, path, &document->points, &document->point_count);
    if (mesh)
        return read_mesh(scan, key, &document->mesh);
    if (strcmp(key, "punch") == 0) {
        bool twice = document->has_punch;
        document->has_punch = true;
        return twice ? scan_malformed(scan, "the key is there twice")
                     : read_mesh(scan, key, &document->punch);
    }
    if (strcmp(key, "cavity_heights") == 0)
        return document->heights.values ? scan_malformed(scan, "the key is there twice")
                                        : read_heights(scan, path, &document->heights);
    if (strcmp(key, "inlet_elements") == 0)
        return document->inlet.values
                   ? scan_malformed(scan, "the key is there twice")
                   : read_indices(scan, path, 0, "must be the index of an element, from 0",
                                  &document->inlet);
    return scan_invalid(scan, path, -1, -1, "is not known here");
}

static bool read_document(struct scan *scan, struct document *document) {
    char key[SCAN_KEY_SIZE];
    bool more = true;
    if (!scan_open(scan, '{', "", -1, "must be an object"))
        return false;
    if (scan_take(scan, '}'))
        more = false;
    while (more)
        if (!scan_key(scan, key) || !read_member(scan, key, document) ||
            !scan_next(scan, '}', &more))
            return false;
    return scan_peek(scan) == '\0' && scan->at == scan->end
               ? true
               : scan_malformed(scan, "there is something behind the document");
}

/* ---- sense ---- */

static bool check_shapes(struct scan *scan, const struct shapes *shapes, const char *path,
                         size_t vertices) {
    for (size_t row = 0; row < shapes->count; row++)
        for (int k = 0; k < 4 && shapes->corners[row][k] >= 0; k++)
            if ((size_t)shapes->corners[row][k] >= vertices)
                return scan_invalid(scan, path, (long)row, k,
                                    "must be the index of a vertex, less than %zu", vertices);
    return true;
}

/* The elements of both kinds, one after the other. */
static bool join_shapes(struct scan *scan, const struct mesh_text *mesh,
                        const int32_t (**elements)[4], size_t *count) {
    const struct shapes *triangles = &mesh->triangles, *quads = &mesh->quads;
    int32_t(*rows)[4] = triangles->corners ? triangles->corners : quads->corners;
    *count = triangles->count + quads->count;
    if (triangles->corners && quads->corners) {
        rows = arena_take(scan->arena, *count, sizeof *rows);
        if (!rows)
            return scan_no_memory(scan);
        memcpy(rows, triangles->corners, triangles->count * sizeof *rows);
        memcpy(rows + triangles->count, quads->corners, quads->count * sizeof *rows);
    }
    *elements = (const int32_t(*)[4])rows;
    return true;
}

/* What a mesh or a punch has to have. */
static bool take_elements(struct scan *scan, const char *name, const struct mesh_text *mesh,
                          const int32_t (**elements)[4], size_t *count) {
    char path[3][SCAN_KEY_SIZE + 16];
    static const char *const keys[] = {"vertices", "triangles", "quads"};
    for (int k = 0; k < 3; k++)
        snprintf(path[k], sizeof path[k], "/%s/%s", name, keys[k]);
    if (!mesh->vertices)
        return scan_invalid(scan, path[0], -1, -1, "is required");
    if (!mesh->triangles.corners && !mesh->quads.corners)
        return scan_invalid(scan, path[1], -1, -1, "is required, or \"quads\"");
    return check_shapes(scan, &mesh->triangles, path[1], mesh->vertex_count) &&
           check_shapes(scan, &mesh->quads, path[2], mesh->vertex_count) &&
           join_shapes(scan, mesh, elements, count);
}

/* Numbers that the mesh gives: one each, all different. */
static bool take_ids(struct scan *scan, const struct indices *ids, const char *path, size_t count,
                     const int32_t **target) {
    if (!ids->values)
        return true;
    if (ids->count != count)
        return scan_invalid(scan, path, -1, -1, "must have %zu numbers, not %zu", count,
                            ids->count);
    struct arena_mark mark = arena_mark(scan->arena);
    const struct map_id *sorted = map_ids_sort(ids->values, count, scan->arena);
    long repeated = sorted ? map_ids_repeated(sorted, count) : -1;
    arena_rewind(scan->arena, mark);
    if (!sorted)
        return scan_no_memory(scan);
    *target = ids->values;
    return repeated < 0 ||
           scan_invalid(scan, path, repeated, -1, "is there twice: %d", ids->values[repeated]);
}

static bool mark_inlet(struct scan *scan, const struct indices *inlet, struct map_target *target) {
    uint8_t *marks = arena_alloc(scan->arena, target->element_count, 1);
    if (!marks)
        return scan_no_memory(scan);
    for (size_t k = 0; k < inlet->count; k++) {
        if ((size_t)inlet->values[k] >= target->element_count)
            return scan_invalid(scan, "/inlet_elements", (long)k, -1,
                                "must be the index of an element, less than %zu",
                                target->element_count);
        marks[inlet->values[k]] = MAP_INLET;
    }
    target->roles = marks;
    target->has_role[MAP_INLET] = true;
    return true;
}

static bool take_mesh(struct scan *scan, const struct document *document,
                      struct map_target *target) {
    const struct mesh_text *mesh = &document->mesh;
    target->vertices = mesh->vertices;
    target->vertex_count = mesh->vertex_count;
    return take_elements(scan, "mesh", mesh, &target->elements, &target->element_count) &&
           take_ids(scan, &mesh->ids, "/mesh/ids", target->element_count, &target->ids) &&
           take_ids(scan, &mesh->vertex_ids, "/mesh/vertex_ids", mesh->vertex_count,
                    &target->vertex_ids) &&
           (!document->inlet.values || mark_inlet(scan, &document->inlet, target));
}

static bool take_points(struct scan *scan, const struct document *document,
                        struct map_target *target) {
    if (!document->points)
        return scan_invalid(scan, "", -1, -1, "must have either \"points\" or \"mesh\"");
    if (document->inlet.values)
        return scan_invalid(scan, "/inlet_elements", -1, -1, "needs a mesh");
    target->vertices = document->points;
    target->vertex_count = target->element_count = document->point_count;
    return true;
}

static bool take_cavity(struct scan *scan, const struct document *document,
                        struct map_target *target) {
    const struct heights *heights = &document->heights;
    if (heights->values && document->has_punch)
        return scan_invalid(scan, "/punch", -1, -1, "must not be given beside \"cavity_heights\"");
    if (heights->values && heights->count != target->element_count)
        return scan_invalid(scan, "/cavity_heights", -1, -1, "must have %zu numbers, not %zu",
                            target->element_count, heights->count);
    target->heights = heights->values;
    target->punch_vertices = document->punch.vertices;
    return !document->has_punch ||
           take_elements(scan, "punch", &document->punch, &target->punch, &target->punch_count);
}

static bool take_document(struct scan *scan, const struct document *document,
                          struct map_target *target) {
    return (document->has_mesh ? take_mesh : take_points)(scan, document, target) &&
           take_cavity(scan, document, target);
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
