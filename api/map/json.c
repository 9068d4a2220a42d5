/* SPDX-License-Identifier: MIT */
/* The JSON body of a map request, read straight into arrays. */
#include "target.h"

#include "api/json/scan.h"
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

/* A row of three numbers; `*more`: another row follows it. */
static bool read_row(struct scan *scan, const char *path, long row, double values[3], bool *more) {
    bool another;
    if (!scan_open(scan, '[', path, row, "must be an array of three numbers"))
        return false;
    for (int k = 0; k < 3; k++) {
        if (k == 0 && scan_peek(scan) == ']')
            return scan_invalid(scan, path, row, -1, "must be an array of three numbers");
        if (!scan_number(scan, path, row, k, &values[k]) || !scan_next(scan, ']', &another))
            return false;
        if (another != (k < 2))
            return scan_invalid(scan, path, row, -1, "must be an array of three numbers");
    }
    return scan_next(scan, ']', more);
}

static bool begin_rows(struct scan *scan, const char *path, size_t size, size_t *rows,
                       void **array) {
    if (!scan_open(scan, '[', path, -1, "must be an array of arrays of three numbers"))
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
    double v[3];
    bool more = true;
    size_t room, row = 0;
    if (!begin_rows(scan, path, sizeof *rows, &room, &array))
        return false;
    rows = array;
    for (; more; row++) {
        if (!read_row(scan, path, (long)row, v, &more))
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

static bool read_triangles(struct scan *scan, const char *path, struct map_target *target) {
    int32_t(*rows)[4];
    void *array;
    double v[3];
    bool more = true;
    size_t room, row = 0;
    if (!begin_rows(scan, path, sizeof *rows, &room, &array))
        return false;
    rows = array;
    for (; more; row++) {
        if (!read_row(scan, path, (long)row, v, &more))
            return false;
        for (int k = 0; k < 3; k++) {
            if (!is_index(v[k]))
                return scan_invalid(scan, path, (long)row, k,
                                    "must be the index of a vertex, from 0");
            rows[row][k] = (int32_t)v[k];
        }
        rows[row][3] = -1;
    }
    target->elements = (const int32_t(*)[4])rows;
    target->element_count = row;
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

static bool read_indices(struct scan *scan, const char *path, struct indices *indices) {
    bool more = true;
    if (!scan_open(scan, '[', path, -1, "must be an array of indices"))
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
        if (!is_index(value))
            return scan_invalid(scan, path, row, -1, "must be the index of an element, from 0");
        indices->values[indices->count++] = (int32_t)value;
        if (!scan_next(scan, ']', &more))
            return false;
    }
    return true;
}

/* ---- the document ---- */

static bool read_mesh_member(struct scan *scan, const char *key, struct map_target *target) {
    char path[SCAN_KEY_SIZE + 8];
    bool vertices = strcmp(key, "vertices") == 0;
    snprintf(path, sizeof path, "/mesh/%s", key);
    if (!vertices && strcmp(key, "triangles") != 0)
        return scan_invalid(scan, path, -1, -1, "is not known here");
    if (vertices ? target->vertices != NULL : target->elements != NULL)
        return scan_malformed(scan, "the key is there twice");
    return vertices ? read_points(scan, path, &target->vertices, &target->vertex_count)
                    : read_triangles(scan, path, target);
}

static bool read_mesh(struct scan *scan, struct map_target *target) {
    char key[SCAN_KEY_SIZE];
    bool more = true;
    if (!scan_open(scan, '{', "/mesh", -1, "must be an object"))
        return false;
    if (scan_take(scan, '}'))
        return true;
    while (more)
        if (!scan_key(scan, key) || !read_mesh_member(scan, key, target) ||
            !scan_next(scan, '}', &more))
            return false;
    return true;
}

/* One member of the document. */
static bool read_member(struct scan *scan, const char *key, struct map_target *target,
                        bool has_mesh, struct indices *inlet) {
    char path[SCAN_KEY_SIZE + 1];
    snprintf(path, sizeof path, "/%s", key);
    bool points = strcmp(key, "points") == 0;
    if ((points || strcmp(key, "mesh") == 0) && (target->vertices || has_mesh))
        return scan_invalid(scan, path, -1, -1, "must be the only one of \"points\" and \"mesh\"");
    if (points)
        return read_points(scan, path, &target->vertices, &target->vertex_count);
    if (strcmp(key, "mesh") == 0)
        return read_mesh(scan, target);
    if (strcmp(key, "inlet_elements") == 0)
        return inlet->values ? scan_malformed(scan, "the key is there twice")
                             : read_indices(scan, path, inlet);
    return scan_invalid(scan, path, -1, -1, "is not known here");
}

static bool read_document(struct scan *scan, struct map_target *target, bool *has_mesh,
                          struct indices *inlet) {
    char key[SCAN_KEY_SIZE];
    bool more = true;
    if (!scan_open(scan, '{', "", -1, "must be an object"))
        return false;
    if (scan_take(scan, '}'))
        more = false;
    while (more) {
        if (!scan_key(scan, key) || !read_member(scan, key, target, *has_mesh, inlet))
            return false;
        *has_mesh = *has_mesh || strcmp(key, "mesh") == 0;
        if (!scan_next(scan, '}', &more))
            return false;
    }
    return scan_peek(scan) == '\0' && scan->at == scan->end
               ? true
               : scan_malformed(scan, "there is something behind the document");
}

/* ---- sense ---- */

static bool check_elements(struct scan *scan, const struct map_target *target) {
    for (size_t row = 0; row < target->element_count; row++)
        for (int k = 0; k < 3; k++)
            if ((size_t)target->elements[row][k] >= target->vertex_count)
                return scan_invalid(scan, "/mesh/triangles", (long)row, k,
                                    "must be the index of a vertex, less than %zu",
                                    target->vertex_count);
    return true;
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
    target->gates = marks;
    target->has_gate[MAP_INLET] = true;
    return true;
}

static bool check(struct scan *scan, bool has_mesh, const struct indices *inlet,
                  struct map_target *target) {
    if (!has_mesh && !target->vertices)
        return scan_invalid(scan, "", -1, -1, "must have either \"points\" or \"mesh\"");
    if (!target->vertices)
        return scan_invalid(scan, "/mesh/vertices", -1, -1, "is required");
    if (has_mesh && !target->elements)
        return scan_invalid(scan, "/mesh/triangles", -1, -1, "is required");
    if (!has_mesh)
        target->element_count = target->vertex_count;
    if (inlet->values && !has_mesh)
        return scan_invalid(scan, "/inlet_elements", -1, -1, "needs a mesh");
    return (!has_mesh || check_elements(scan, target)) &&
           (!inlet->values || mark_inlet(scan, inlet, target));
}

enum api_problem_id map_target_json(const char *bytes, size_t length, struct arena *arena,
                                    struct map_target *target, struct api_problem *problem) {
    struct scan scan = {bytes, bytes, bytes + length, arena, problem};
    struct indices inlet = {0};
    bool has_mesh = false;
    *target = (struct map_target){0};
    if (length == 0)
        scan_malformed(&scan, "the document is empty");
    else if (read_document(&scan, target, &has_mesh, &inlet))
        (void)check(&scan, has_mesh, &inlet, target);
    return problem->id;
}
