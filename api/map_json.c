/* SPDX-License-Identifier: MIT */
/* The JSON body of a map request, read straight into arrays. */
#include "map_mesh.h"

#include "number.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { KEY_SIZE = 32 };

static const double coordinate_max = 1e12;

struct scan {
    const char *begin, *at, *end;
    struct arena *arena;
    struct api_problem *problem;
};

/* ---- what is wrong ---- */

/* All return false. */

static bool malformed(struct scan *scan, const char *what) {
    size_t line = 1, column = 1;
    for (const char *c = scan->begin; c < scan->at; c++) {
        column = *c == '\n' ? 1 : column + 1;
        line += *c == '\n';
    }
    api_problem_set(scan->problem, API_MALFORMED_JSON, "line %zu, column %zu: %s", line, column,
                    what);
    return false;
}

/* At an element of a row of the array `path`, or the row, or the array: -1 for what is not there.
 */
static bool invalid(struct scan *scan, const char *path, long row, int element, const char *what,
                    ...) __attribute__((format(printf, 5, 6)));

static bool invalid(struct scan *scan, const char *path, long row, int element, const char *what,
                    ...) {
    char pointer[API_POINTER_MAX], detail[API_DETAIL_MAX];
    int used = snprintf(pointer, sizeof pointer, "%s", path);
    if (row >= 0)
        used += snprintf(pointer + used, sizeof pointer - (size_t)used, "/%ld", row);
    if (element >= 0)
        snprintf(pointer + used, sizeof pointer - (size_t)used, "/%d", element);
    va_list arguments;
    va_start(arguments, what);
    vsnprintf(detail, sizeof detail, what, arguments);
    va_end(arguments);
    api_problem_set_at(scan->problem, API_INVALID_REQUEST, pointer, "%s", detail);
    return false;
}

static bool no_memory(struct scan *scan) {
    api_problem_set(scan->problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
    return false;
}

/* ---- characters ---- */

/* The next character that is no space; 0 at the end. */
static char peek(struct scan *scan) {
    while (scan->at < scan->end &&
           (*scan->at == ' ' || *scan->at == '\n' || *scan->at == '\r' || *scan->at == '\t'))
        scan->at++;
    return scan->at < scan->end ? *scan->at : '\0';
}

static bool take(struct scan *scan, char wanted) {
    if (peek(scan) != wanted || scan->at == scan->end)
        return false;
    scan->at++;
    return true;
}

/* Whether a value of JSON begins here. */
static bool at_value(struct scan *scan) {
    static const char *const words[] = {"true", "false", "null"};
    char c = peek(scan);
    for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
        size_t length = strlen(words[k]);
        if ((size_t)(scan->end - scan->at) >= length && memcmp(scan->at, words[k], length) == 0)
            return true;
    }
    return c && strchr("{[\"-0123456789", c);
}

/* What is here is not the value that has to be here: another one is invalid, anything else is no
 * JSON. */
static bool refuse_value(struct scan *scan, const char *path, long row, int element,
                         const char *what) {
    if (at_value(scan))
        return invalid(scan, path, row, element, "%s", what);
    return malformed(scan,
                     scan->at == scan->end ? "the document ends early" : "a value is missing");
}

static bool open_value(struct scan *scan, char bracket, const char *path, long row,
                       const char *what) {
    return take(scan, bracket) || refuse_value(scan, path, row, -1, what);
}

/* After an element of an array or object: whether there is another one (`*more`). */
static bool next_element(struct scan *scan, char closing, bool *more) {
    *more = take(scan, ',');
    if (*more || take(scan, closing))
        return true;
    return malformed(scan, scan->at == scan->end ? "the document ends early"
                                                 : "a comma or a closing bracket is missing");
}

/* A key and its colon. One with escapes, or longer than any that is known, is cut and so unknown.
 */
static bool read_key(struct scan *scan, char key[KEY_SIZE]) {
    if (!take(scan, '"'))
        return malformed(scan, "a key in quotes is missing");
    size_t length = 0;
    for (; scan->at < scan->end && *scan->at != '"'; scan->at++) {
        if (*scan->at == '\\' || (unsigned char)*scan->at < ' ')
            return malformed(scan, "a key has a character that no key here has");
        if (length < KEY_SIZE - 1)
            key[length++] = *scan->at;
    }
    key[length] = '\0';
    if (scan->at == scan->end)
        return malformed(scan, "the document ends early");
    scan->at++;
    return take(scan, ':') || malformed(scan, "a colon is missing");
}

/* Whether the characters are a number as JSON writes it; what the number reader takes is more. */
static bool is_json_number(const char *text, size_t length) {
    const char *end = text + length;
    text += *text == '-';
    if (text < end && *text == '0' && text + 1 < end && text[1] >= '0' && text[1] <= '9')
        return false;
    if (text == end || *text < '0' || *text > '9')
        return false;
    while (text < end && *text >= '0' && *text <= '9')
        text++;
    return text == end || *text != '.' || (text + 1 < end && text[1] >= '0' && text[1] <= '9');
}

static bool read_number(struct scan *scan, const char *path, long row, int element, double *value) {
    char c = peek(scan);
    if (c != '-' && (c < '0' || c > '9'))
        return refuse_value(scan, path, row, element, "must be a number");
    size_t length = api_number_read(scan->at, (size_t)(scan->end - scan->at), value);
    if (length > 0 && !is_json_number(scan->at, length))
        return malformed(scan, "this is no number of JSON");
    if (length == 0 && c == '-' &&
        !(scan->at + 1 < scan->end && scan->at[1] >= '0' && scan->at[1] <= '9'))
        return malformed(scan, "this is no number of JSON");
    if (length == 0)
        return invalid(scan, path, row, element, "is too large for a double-precision number");
    scan->at += length;
    return true;
}

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

/* A row of three numbers; `*more` tells whether another row follows it. */
static bool read_row(struct scan *scan, const char *path, long row, double values[3], bool *more) {
    bool another;
    if (!open_value(scan, '[', path, row, "must be an array of three numbers"))
        return false;
    for (int k = 0; k < 3; k++) {
        if (k == 0 && peek(scan) == ']')
            return invalid(scan, path, row, -1, "must be an array of three numbers");
        if (!read_number(scan, path, row, k, &values[k]) || !next_element(scan, ']', &another))
            return false;
        if (another != (k < 2))
            return invalid(scan, path, row, -1, "must be an array of three numbers");
    }
    return next_element(scan, ']', more);
}

static bool begin_rows(struct scan *scan, const char *path, size_t size, size_t *rows,
                       void **array) {
    if (!open_value(scan, '[', path, -1, "must be an array of arrays of three numbers"))
        return false;
    if (peek(scan) == ']')
        return invalid(scan, path, -1, -1, "must not be empty");
    *rows = count_rows(scan);
    *array = arena_take(scan->arena, *rows, size);
    if (*rows > INT32_MAX)
        return invalid(scan, path, -1, -1, "has too many elements");
    return *array || no_memory(scan);
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
                return invalid(scan, path, (long)row, k, "must be between -1e12 and 1e12");
        rows[row] = vec3_make(v[0], v[1], v[2]);
    }
    *points = rows;
    *count = row;
    return true;
}

static bool is_index(double value) {
    return value >= 0 && value <= INT32_MAX && value == floor(value);
}

static bool read_triangles(struct scan *scan, const char *path, struct api_map_mesh *mesh) {
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
                return invalid(scan, path, (long)row, k, "must be the index of a vertex, from 0");
            rows[row][k] = (int32_t)v[k];
        }
        rows[row][3] = -1;
    }
    mesh->elements = (const int32_t(*)[4])rows;
    mesh->element_count = row;
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
    if (!open_value(scan, '[', path, -1, "must be an array of indices"))
        return false;
    indices->values = arena_take(scan->arena, count_numbers(scan), sizeof *indices->values);
    if (!indices->values)
        return no_memory(scan);
    if (take(scan, ']'))
        return true;
    while (more) {
        long row = (long)indices->count;
        double value;
        if (!read_number(scan, path, row, -1, &value))
            return false;
        if (!is_index(value))
            return invalid(scan, path, row, -1, "must be the index of an element, from 0");
        indices->values[indices->count++] = (int32_t)value;
        if (!next_element(scan, ']', &more))
            return false;
    }
    return true;
}

/* ---- the document ---- */

static bool read_mesh_member(struct scan *scan, const char *key, struct api_map_mesh *mesh) {
    char path[KEY_SIZE + 8];
    bool vertices = strcmp(key, "vertices") == 0;
    snprintf(path, sizeof path, "/mesh/%s", key);
    if (!vertices && strcmp(key, "triangles") != 0)
        return invalid(scan, path, -1, -1, "is not known here");
    if (vertices ? mesh->vertices != NULL : mesh->elements != NULL)
        return malformed(scan, "the key is there twice");
    return vertices ? read_points(scan, path, &mesh->vertices, &mesh->vertex_count)
                    : read_triangles(scan, path, mesh);
}

static bool read_mesh(struct scan *scan, struct api_map_mesh *mesh) {
    char key[KEY_SIZE];
    bool more = true;
    if (!open_value(scan, '{', "/mesh", -1, "must be an object"))
        return false;
    if (take(scan, '}'))
        return true;
    while (more)
        if (!read_key(scan, key) || !read_mesh_member(scan, key, mesh) ||
            !next_element(scan, '}', &more))
            return false;
    return true;
}

/* One member of the document. */
static bool read_member(struct scan *scan, const char *key, struct api_map_mesh *mesh,
                        bool has_mesh, struct indices *inlet) {
    char path[KEY_SIZE + 1];
    snprintf(path, sizeof path, "/%s", key);
    bool points = strcmp(key, "points") == 0;
    if ((points || strcmp(key, "mesh") == 0) && (mesh->vertices || has_mesh))
        return invalid(scan, path, -1, -1, "must be the only one of \"points\" and \"mesh\"");
    if (points)
        return read_points(scan, path, &mesh->vertices, &mesh->vertex_count);
    if (strcmp(key, "mesh") == 0)
        return read_mesh(scan, mesh);
    if (strcmp(key, "inlet_elements") == 0)
        return inlet->values ? malformed(scan, "the key is there twice")
                             : read_indices(scan, path, inlet);
    return invalid(scan, path, -1, -1, "is not known here");
}

static bool read_document(struct scan *scan, struct api_map_mesh *mesh, bool *has_mesh,
                          struct indices *inlet) {
    char key[KEY_SIZE];
    bool more = true;
    if (!open_value(scan, '{', "", -1, "must be an object"))
        return false;
    if (take(scan, '}'))
        more = false;
    while (more) {
        if (!read_key(scan, key) || !read_member(scan, key, mesh, *has_mesh, inlet))
            return false;
        *has_mesh = *has_mesh || strcmp(key, "mesh") == 0;
        if (!next_element(scan, '}', &more))
            return false;
    }
    return peek(scan) == '\0' && scan->at == scan->end
               ? true
               : malformed(scan, "there is something behind the document");
}

/* ---- sense ---- */

static bool check_elements(struct scan *scan, const struct api_map_mesh *mesh) {
    for (size_t row = 0; row < mesh->element_count; row++)
        for (int k = 0; k < 3; k++)
            if ((size_t)mesh->elements[row][k] >= mesh->vertex_count)
                return invalid(scan, "/mesh/triangles", (long)row, k,
                               "must be the index of a vertex, less than %zu", mesh->vertex_count);
    return true;
}

static bool mark_inlet(struct scan *scan, const struct indices *inlet, struct api_map_mesh *mesh) {
    uint8_t *marks = arena_alloc(scan->arena, mesh->element_count, 1);
    if (!marks)
        return no_memory(scan);
    for (size_t k = 0; k < inlet->count; k++) {
        if ((size_t)inlet->values[k] >= mesh->element_count)
            return invalid(scan, "/inlet_elements", (long)k, -1,
                           "must be the index of an element, less than %zu", mesh->element_count);
        marks[inlet->values[k]] = 1;
    }
    mesh->inlet = marks;
    return true;
}

static bool check(struct scan *scan, bool has_mesh, const struct indices *inlet,
                  struct api_map_mesh *mesh) {
    if (!has_mesh && !mesh->vertices)
        return invalid(scan, "", -1, -1, "must have either \"points\" or \"mesh\"");
    if (!mesh->vertices)
        return invalid(scan, "/mesh/vertices", -1, -1, "is required");
    if (has_mesh && !mesh->elements)
        return invalid(scan, "/mesh/triangles", -1, -1, "is required");
    if (!has_mesh)
        mesh->element_count = mesh->vertex_count;
    if (inlet->values && !has_mesh)
        return invalid(scan, "/inlet_elements", -1, -1, "needs a mesh");
    return (!has_mesh || check_elements(scan, mesh)) &&
           (!inlet->values || mark_inlet(scan, inlet, mesh));
}

enum api_problem_id api_map_mesh_json(const char *bytes, size_t length, struct arena *arena,
                                      struct api_map_mesh *mesh, struct api_problem *problem) {
    struct scan scan = {bytes, bytes, bytes + length, arena, problem};
    struct indices inlet = {0};
    bool has_mesh = false;
    *mesh = (struct api_map_mesh){0};
    if (length == 0)
        malformed(&scan, "the document is empty");
    else if (read_document(&scan, mesh, &has_mesh, &inlet))
        (void)check(&scan, has_mesh, &inlet, mesh);
    return problem->id;
}
