/* SPDX-License-Identifier: MIT */
/*
 * A mesh file while it is read: nodes and shell elements by the file's own ids, the sets that its
 * elements are in, and what is passed over. Readers of the formats go through the file twice: the
 * first pass counts, so that the second keeps everything in arrays of the right length. Ids are
 * 1..INT32_MAX. Functions that return bool report to the file's problem, with the line.
 */
#ifndef API_MAP_MESH_FILE_H
#define API_MAP_MESH_FILE_H

#include "target.h"

enum { MESH_SETS_MAX = 256, MESH_NAME_SIZE = 64, MESH_PASSED_MAX = 24, MESH_FIELDS_MAX = 40 };

struct mesh_file {
    struct api_problem *problem;
    bool counting;        /* the first pass: nothing is kept */
    const char *at, *end; /* what is left of the file */
    size_t line;          /* the number of the line that was read last, from 1 */
    struct {
        size_t count;
        struct vec3 *point;
        int32_t *id;
        uint32_t *line;
    } nodes;
    struct {
        size_t count;
        int32_t (*nodes)[4]; /* ids; the fourth of a triangle is -1 */
        int32_t *id, *pid;
        uint32_t *line;
    } elements;
    struct {
        size_t count;
        struct map_range *range;
    } ranges;
    char set[MESH_SETS_MAX][MESH_NAME_SIZE]; /* names of sets, whose numbers count from 1 */
    int32_t property[MESH_SETS_MAX];         /* that each is, of a format that numbers them */
    size_t set_count;
    size_t curved; /* elements with nodes in the middle of edges */
    struct {
        char name[MESH_NAME_SIZE];
        size_t count;
    } passed[MESH_PASSED_MAX];
    size_t passed_names, passed_others;
};

/* A piece of a line, without the blanks around it. */
struct mesh_field {
    const char *at;
    size_t length;
};

/* Refuses the line that was read last, with a printf-style detail; false. */
#define MESH_REFUSE(file, detail, ...)                                                             \
    MAP_REFUSE((file)->problem, "line %zu: " detail, (file)->line, ##__VA_ARGS__)

/* The next line, without its end; false at the end of the file. */
bool mesh_file_next(struct mesh_file *file, struct mesh_field *line);

/* The fields of a line, at most MESH_FIELDS_MAX: those between commas, between blanks, or where
 * there is no comma all `width` characters, the first of `first`. Returns how many. */
size_t mesh_file_commas(struct mesh_field line, struct mesh_field fields[MESH_FIELDS_MAX]);
size_t mesh_file_words(struct mesh_field line, struct mesh_field fields[MESH_FIELDS_MAX]);
size_t mesh_file_columns(struct mesh_field line, size_t first, size_t width,
                         struct mesh_field fields[MESH_FIELDS_MAX]);

/* Whether a field is a word, in any case; begins with it. */
bool mesh_field_is(struct mesh_field field, const char *word);
bool mesh_field_begins(struct mesh_field field, const char *word);

/* Read a field: a whole number from `least` to INT32_MAX; a coordinate, with E or D before its
 * exponent. `what` is it, for the problem. */
bool mesh_file_number(struct mesh_file *file, struct mesh_field field, const char *what,
                      int32_t least, int32_t *number);
bool mesh_file_real(struct mesh_file *file, struct mesh_field field, double *value);

/* A node by its id and coordinates in fields; an element by those of its 3 or 4 corners. `curved`:
 * it has nodes in the middle of its edges. */
bool mesh_file_node(struct mesh_file *file, struct mesh_field id,
                    const struct mesh_field coordinates[3]);
bool mesh_file_element(struct mesh_file *file, struct mesh_field id, int32_t pid,
                       const struct mesh_field corners[4], int count, bool curved);

/* The number of the set of that name, which is there from then on; 0, refused, when there are too
 * many. And that it has these elements: those that have no property yet get its number. */
int32_t mesh_file_set(struct mesh_file *file, struct mesh_field name);
bool mesh_file_add(struct mesh_file *file, int32_t set, int32_t first, int32_t last, int32_t step);

/* The name that the file gives a property. */
bool mesh_file_name(struct mesh_file *file, int32_t pid, struct mesh_field name);

/* Notes that something of this name was passed over. */
void mesh_file_pass(struct mesh_file *file, struct mesh_field name);

/* Reads a file by `read`, which goes through it once. Problems as of `map_target_nastran`. */
enum api_problem_id mesh_file_read(bool (*read)(struct mesh_file *file), const char *bytes,
                                   size_t length, struct arena *arena, struct map_target *target,
                                   struct api_problem *problem) STATUS_MUST_USE;

#endif
