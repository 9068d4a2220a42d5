/* SPDX-License-Identifier: MIT */
#include "triangles.h"

#include "api/map/target.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double weld_share = 1e-7, coordinate_most = 1e12;

static bool no_memory_for_mesh(struct triangles *t) {
    return !api_problem_no_memory(t->problem, "the mesh");
}

bool triangles_add_vertex(struct triangles *t, struct vec3 v) {
    if (!(fabs(v.x) <= coordinate_most && fabs(v.y) <= coordinate_most &&
          fabs(v.z) <= coordinate_most))
        return !api_problem_set(t->problem, API_UNREADABLE_FILE,
                                "vertex %zu has no finite coordinates of at most 1e12",
                                t->vertex_count);
    if (t->vertex_count == t->vertex_room) {
        struct vec3 *vertices = arena_enlarge(t->arena, t->vertices, t->vertex_count,
                                              sizeof *vertices, &t->vertex_room);
        if (!vertices || t->vertex_count >= INT32_MAX)
            return no_memory_for_mesh(t);
        t->vertices = vertices;
    }
    t->vertices[t->vertex_count++] = v;
    return true;
}

bool triangles_add(struct triangles *t, const int32_t corners[3]) {
    if (t->count == t->room) {
        int32_t(*all)[3] = arena_enlarge(t->arena, t->corners, t->count, sizeof *all, &t->room);
        if (!all)
            return no_memory_for_mesh(t);
        t->corners = all;
    }
    memcpy(t->corners[t->count++], corners, sizeof *t->corners);
    return true;
}

/* ---- welding ---- */

/* Vertices by the cells of a grid that are as large as what is welded. */
struct grid {
    struct vec3 low;
    double cell;
    uint32_t *slots, mask; /* the first vertex + 1 of a cell, by hashing; 0: none */
    uint32_t *next;        /* of vertices in the same slot */
};

static uint32_t weld_slot(const struct grid *grid, const int64_t at[3]) {
    uint64_t hash = (uint64_t)at[0] * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (uint64_t)at[1]) * 0xc2b2ae3d27d4eb4fu;
    hash = (hash ^ (uint64_t)at[2]) * 0x165667b19e3779f9u;
    return (uint32_t)(hash >> 32) & grid->mask;
}

static void cell_of(const struct grid *grid, struct vec3 v, int64_t at[3]) {
    at[0] = (int64_t)floor((v.x - grid->low.x) / grid->cell);
    at[1] = (int64_t)floor((v.y - grid->low.y) / grid->cell);
    at[2] = (int64_t)floor((v.z - grid->low.z) / grid->cell);
}

/* The vertex that `v` is one with, among the first `count` kept; else `count`. */
static uint32_t find_kept(const struct grid *grid, const struct vec3 *kept, uint32_t count,
                          struct vec3 v) {
    int64_t middle[3];
    cell_of(grid, v, middle);
    for (int k = 0; k < 27; k++) {
        const int64_t at[3] = {middle[0] + k % 3 - 1, middle[1] + k / 3 % 3 - 1,
                               middle[2] + k / 9 - 1};
        for (uint32_t one = grid->slots[weld_slot(grid, at)]; one; one = grid->next[one - 1])
            if (vec3_distance(kept[one - 1], v) <= grid->cell)
                return one - 1;
    }
    return count;
}

static bool make_weld_grid(struct triangles *t, struct grid *grid) {
    struct vec3 low = t->vertices[0], high = low;
    uint32_t slots = 1024;
    for (size_t k = 0; k < t->vertex_count; k++) {
        low = vec3_min(low, t->vertices[k]);
        high = vec3_max(high, t->vertices[k]);
    }
    while (slots < t->vertex_count && slots < 1u << 30)
        slots *= 2;
    *grid = (struct grid){.low = low,
                          .cell = fmax(weld_share * vec3_distance(low, high), 1e-300),
                          .slots = arena_alloc(t->arena, slots, sizeof *grid->slots),
                          .mask = slots - 1,
                          .next = arena_alloc(t->arena, t->vertex_count, sizeof *grid->next)};
    return grid->slots && grid->next;
}

static bool has_triangle_area(const struct vec3 *v, const int32_t c[3]) {
    struct vec3 a = vec3_sub(v[c[1]], v[c[0]]), b = vec3_sub(v[c[2]], v[c[0]]);
    double longest = fmax(vec3_norm(a), fmax(vec3_norm(b), vec3_distance(v[c[1]], v[c[2]])));
    return vec3_norm(vec3_cross(a, b)) > 1e-6 * longest * longest;
}

struct keyed {
    int32_t key[3]; /* the corners, rising */
    uint32_t triangle;
};

static int compare_keyed(const void *a, const void *b) {
    const struct keyed *x = a, *y = b;
    for (int k = 0; k < 3; k++)
        if (x->key[k] != y->key[k])
            return x->key[k] < y->key[k] ? -1 : 1;
    return (x->triangle > y->triangle) - (x->triangle < y->triangle);
}

static void swap_if(int32_t *a, int32_t *b) {
    int32_t low = *a < *b ? *a : *b, high = *a < *b ? *b : *a;
    *a = low;
    *b = high;
}

/* Marks the second and further triangles on the same corners by a corner of -1. */
static bool drop_duplicates(struct triangles *t) {
    struct keyed *keys = arena_alloc(t->arena, t->count, sizeof *keys);
    if (!keys)
        return no_memory_for_mesh(t);
    for (size_t k = 0; k < t->count; k++) {
        int32_t *key = keys[k].key;
        memcpy(key, t->corners[k], sizeof keys[k].key);
        swap_if(&key[0], &key[1]);
        swap_if(&key[1], &key[2]);
        swap_if(&key[0], &key[1]);
        keys[k].triangle = (uint32_t)k;
    }
    qsort(keys, t->count, sizeof *keys, compare_keyed);
    for (size_t k = 1; k < t->count; k++)
        if (memcmp(keys[k].key, keys[k - 1].key, sizeof keys[k].key) == 0)
            t->corners[keys[k].triangle][0] = -1;
    return true;
}

bool triangles_weld(struct triangles *t) {
    struct grid grid;
    uint32_t kept = 0;
    size_t left = 0;
    if (t->count == 0)
        return !api_problem_set(t->problem, API_UNREADABLE_FILE, "the file holds no triangle");
    int32_t *number = arena_alloc(t->arena, t->vertex_count, sizeof *number);
    if (!number || !make_weld_grid(t, &grid))
        return no_memory_for_mesh(t);
    for (size_t k = 0; k < t->vertex_count; k++) {
        uint32_t same = find_kept(&grid, t->vertices, kept, t->vertices[k]);
        number[k] = (int32_t)same;
        if (same < kept)
            continue;
        int64_t at[3];
        cell_of(&grid, t->vertices[k], at);
        uint32_t *slot = &grid.slots[weld_slot(&grid, at)];
        t->vertices[kept] = t->vertices[k];
        grid.next[kept] = *slot;
        *slot = ++kept;
    }
    t->vertex_count = kept;
    for (size_t k = 0; k < t->count; k++) {
        int32_t *c = t->corners[left];
        for (int corner = 0; corner < 3; corner++)
            c[corner] = number[t->corners[k][corner]];
        bool good =
            c[0] != c[1] && c[1] != c[2] && c[2] != c[0] && has_triangle_area(t->vertices, c);
        left += good;
        t->without_area += !good;
    }
    t->count = left;
    if (!drop_duplicates(t))
        return false;
    left = 0;
    for (size_t k = 0; k < t->count; k++)
        if (t->corners[k][0] >= 0)
            memmove(t->corners[left++], t->corners[k], sizeof t->corners[k]);
    t->duplicate = t->count - left;
    t->count = left;
    if (left == 0)
        api_problem_set(t->problem, API_UNREADABLE_FILE, "no triangle of the file has an area");
    return left > 0;
}

/* ---- STL ---- */

enum { STL_HEAD = 80, STL_TRIANGLE = 50 };

static bool add_corners(struct triangles *t, const struct vec3 point[3]) {
    int32_t first = (int32_t)t->vertex_count;
    for (int k = 0; k < 3; k++)
        if (!triangles_add_vertex(t, point[k]))
            return false;
    return triangles_add(t, (const int32_t[3]){first, first + 1, first + 2});
}

/* The next number of a line; false at its end. The bytes end with a zero. */
static bool take_line_number(const char **at, const char *end, double *number) {
    char word[64], *stop;
    size_t length = 0;
    while (*at < end && (**at == ' ' || **at == '\t'))
        ++*at;
    while (*at + length < end && length + 1 < sizeof word && !strchr(" \t\r\n", (*at)[length]))
        length++;
    memcpy(word, *at, length);
    word[length] = '\0';
    *at += length;
    *number = strtod(word, &stop);
    return length > 0 && *stop == '\0';
}

static bool unreadable_line(struct triangles *t, size_t line, const char *what) {
    return !api_problem_set(t->problem, API_UNREADABLE_FILE, "line %zu: %s", line, what);
}

/* A line of the file: where its first word is, and the word's length. */
struct line {
    const char *at, *end;
    size_t number, word;
};

static bool next_file_line(struct line *line, const char *bytes_end) {
    const char *at = line->number ? line->end + 1 : line->at;
    if (at >= bytes_end)
        return false;
    const char *end = memchr(at, '\n', (size_t)(bytes_end - at));
    line->end = end ? end : bytes_end;
    line->number++;
    while (at < line->end && strchr(" \t\r", *at) && *at)
        at++;
    line->at = at;
    line->word = 0;
    while (at + line->word < line->end && !strchr(" \t\r", at[line->word]))
        line->word++;
    return true;
}

static bool word_is(const struct line *line, const char *word) {
    return line->word == strlen(word) && strncasecmp(line->at, word, line->word) == 0;
}

static bool take_point(struct triangles *t, const struct line *line, struct vec3 *point) {
    const char *at = line->at + line->word;
    return (take_line_number(&at, line->end, &point->x) &&
            take_line_number(&at, line->end, &point->y) &&
            take_line_number(&at, line->end, &point->z)) ||
           unreadable_line(t, line->number, "a vertex must have three numbers");
}

bool triangles_read_stl(struct triangles *t, const char *bytes, size_t length) {
    if (length >= STL_HEAD + 4) {
        uint32_t count;
        memcpy(&count, bytes + STL_HEAD, sizeof count);
        bool binary = STL_HEAD + 4 + (size_t)count * STL_TRIANGLE == length;
        for (size_t k = 0; binary && k < count; k++) {
            float numbers[12];
            struct vec3 point[3];
            memcpy(numbers, bytes + STL_HEAD + 4 + k * STL_TRIANGLE, sizeof numbers);
            for (size_t c = 0; c < 3; c++) {
                const float *at = numbers + 3 + 3 * c;
                point[c] = vec3_make((double)at[0], (double)at[1], (double)at[2]);
            }
            if (!add_corners(t, point))
                return false;
        }
        if (binary)
            return true;
    }
    if (length < 5 || strncasecmp(bytes, "solid", 5) != 0)
        return !api_problem_set(
            t->problem, API_UNREADABLE_FILE,
            "this is not an STL file: it does not begin with \"solid\", and its length is "
            "not that of a binary one");
    struct line line = {.at = bytes};
    struct vec3 point[3];
    int have = 0;
    while (next_file_line(&line, bytes + length)) {
        if (word_is(&line, "facet")) {
            have = 0;
        } else if (word_is(&line, "vertex")) {
            if (have == 3)
                return unreadable_line(t, line.number, "a facet has more than three vertices");
            if (!take_point(t, &line, &point[have++]))
                return false;
        } else if (word_is(&line, "endfacet")) {
            if (have != 3)
                return unreadable_line(t, line.number, "a facet has less than three vertices");
            if (!add_corners(t, point))
                return false;
        }
    }
    return true;
}

/* ---- OBJ ---- */

/* A polygon as a fan of triangles. Its corners are such as 7, 7/1/2 or -1, from 1. */
static bool read_polygon(struct triangles *t, const struct line *line) {
    int32_t fan[3];
    int corners = 0;
    for (const char *at = line->at + line->word;;) {
        char word[32], *stop;
        size_t length = 0;
        while (at < line->end && strchr(" \t\r", *at))
            at++;
        if (at == line->end)
            break;
        while (at + length < line->end && length + 1 < sizeof word && !strchr(" \t\r", at[length]))
            length++;
        memcpy(word, at, length);
        word[length] = '\0';
        long number = strtol(word, &stop, 10);
        long vertex = number < 0 ? (long)t->vertex_count + number : number - 1;
        if (stop == word || vertex < 0 || (size_t)vertex >= t->vertex_count)
            return unreadable_line(t, line->number, "a face refers to a vertex that is not there");
        while (at < line->end && !strchr(" \t\r", *at))
            at++;
        fan[corners < 2 ? corners : 2] = (int32_t)vertex;
        if (++corners >= 3) {
            if (!triangles_add(t, fan))
                return false;
            fan[1] = fan[2];
        }
    }
    return corners >= 3 || unreadable_line(t, line->number, "a face has less than three vertices");
}

bool triangles_read_obj(struct triangles *t, const char *bytes, size_t length) {
    struct line line = {.at = bytes};
    while (next_file_line(&line, bytes + length)) {
        struct vec3 point;
        if (word_is(&line, "v") &&
            !(take_point(t, &line, &point) && triangles_add_vertex(t, point)))
            return false;
        if (word_is(&line, "f") && !read_polygon(t, &line))
            return false;
    }
    return true;
}

/* ---- shells ---- */

/* Quadrilaterals are cut along their shorter diagonal. */
bool triangles_read_shells(struct triangles *t, map_target_reader *read, const char *bytes,
                           size_t length) {
    struct map_target target;
    if (read(bytes, length, t->arena, &target, t->problem) != API_OK) {
        if (t->problem->id == API_INVALID_REQUEST)
            t->problem->id = API_UNREADABLE_FILE;
        return false;
    }
    for (size_t k = 0; k < target.vertex_count; k++)
        if (!triangles_add_vertex(t, target.vertices[k]))
            return false;
    for (size_t k = 0; target.elements && k < target.element_count; k++) {
        const int32_t *e = target.elements[k];
        const struct vec3 *v = target.vertices;
        bool other = e[3] >= 0 && vec3_distance(v[e[1]], v[e[3]]) < vec3_distance(v[e[0]], v[e[2]]);
        if (!triangles_add(t, (const int32_t[3]){e[0], e[1], other ? e[3] : e[2]}))
            return false;
        if (e[3] >= 0 && !triangles_add(t, (const int32_t[3]){other ? e[1] : e[0], e[2], e[3]}))
            return false;
    }
    return true;
}
