/* SPDX-License-Identifier: MIT */
#include "mesh_file.h"

#include "api/json/number.h"
#include "api/json/text.h"
#include "ids.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* ---- lines and fields ---- */

static bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

static struct mesh_field trimmed(const char *at, const char *end) {
    while (at < end && is_blank(*at))
        at++;
    while (at < end && is_blank(end[-1]))
        end--;
    return (struct mesh_field){at, (size_t)(end - at)};
}

/* Blanks before its first word stay: they count where fields have columns. */
bool mesh_file_next(struct mesh_file *file, struct mesh_field *line) {
    if (file->at >= file->end)
        return false;
    const char *end = memchr(file->at, '\n', (size_t)(file->end - file->at));
    end = end ? end : file->end;
    const char *start = file->at, *last = end;
    while (last > start && is_blank(last[-1]))
        last--;
    *line = (struct mesh_field){start, (size_t)(last - start)};
    file->at = end < file->end ? end + 1 : end;
    file->line++;
    return true;
}

size_t mesh_file_commas(struct mesh_field line, struct mesh_field fields[MESH_FIELDS_MAX]) {
    const char *at = line.at, *end = line.at + line.length;
    size_t count = 0;
    while (at <= end && count < MESH_FIELDS_MAX) {
        const char *comma = at < end ? memchr(at, ',', (size_t)(end - at)) : NULL;
        comma = comma ? comma : end;
        fields[count++] = trimmed(at, comma);
        at = comma + 1;
    }
    return count;
}

size_t mesh_file_words(struct mesh_field line, struct mesh_field fields[MESH_FIELDS_MAX]) {
    const char *at = line.at, *end = line.at + line.length;
    size_t count = 0;
    while (count < MESH_FIELDS_MAX) {
        while (at < end && is_blank(*at))
            at++;
        const char *start = at;
        while (at < end && !is_blank(*at))
            at++;
        if (at == start)
            break;
        fields[count++] = (struct mesh_field){start, (size_t)(at - start)};
    }
    return count;
}

size_t mesh_file_columns(struct mesh_field line, size_t first, size_t width,
                         struct mesh_field fields[MESH_FIELDS_MAX]) {
    size_t count = 0;
    if (line.length && memchr(line.at, ',', line.length))
        return mesh_file_commas(line, fields);
    for (size_t at = 0, wide; at < line.length && count < MESH_FIELDS_MAX; at += wide) {
        wide = count ? width : first;
        size_t end = at + wide < line.length ? at + wide : line.length;
        fields[count++] = trimmed(line.at + at, line.at + end);
    }
    return count;
}

bool mesh_field_begins(struct mesh_field field, const char *word) {
    return field.length >= strlen(word) && strncasecmp(field.at, word, strlen(word)) == 0;
}

bool mesh_field_is(struct mesh_field field, const char *word) {
    return field.length == strlen(word) && mesh_field_begins(field, word);
}

/* A field in a message: at most this many of its characters. */
static int shown(struct mesh_field field) {
    return field.length < 24 ? (int)field.length : 24;
}

bool mesh_file_number(struct mesh_file *file, struct mesh_field field, const char *what,
                      int32_t least, int32_t *number) {
    int64_t value = 0;
    size_t k = field.length > 1 && field.at[0] == '+';
    bool good = field.length > k;
    for (; good && k < field.length; k++) {
        good = field.at[k] >= '0' && field.at[k] <= '9';
        value = 10 * value + (field.at[k] - '0');
        good = good && value <= INT32_MAX;
    }
    *number = good ? (int32_t)value : 0;
    return (good && value >= least) ||
           MESH_REFUSE(file, "%s must be a whole number from %d to 2147483647, not '%.*s'", what,
                       least, shown(field), field.at);
}

bool mesh_file_real(struct mesh_file *file, struct mesh_field field, double *value) {
    char text[48];
    size_t length = 0;
    bool plus = field.length > 1 && field.at[0] == '+' && field.at[1] != '-';
    for (size_t k = plus; k < field.length && length < sizeof text; k++)
        text[length++] = field.at[k] == 'D' || field.at[k] == 'd' ? 'E' : field.at[k];
    *value = 0;
    return (length > 0 && length < sizeof text && api_number_read(text, length, value) == length &&
            fabs(*value) <= MAP_COORDINATE_MAX) ||
           MESH_REFUSE(file, "a coordinate must be a number of at most 1e12, not '%.*s'",
                       shown(field), field.at);
}

/* ---- what a file has ---- */

bool mesh_file_node(struct mesh_file *file, struct mesh_field id,
                    const struct mesh_field coordinates[3]) {
    int32_t number;
    double v[3];
    if (!mesh_file_number(file, id, "the id of a node", 1, &number))
        return false;
    for (int k = 0; k < 3; k++)
        if (!mesh_file_real(file, coordinates[k], &v[k]))
            return false;
    size_t at = file->nodes.count++;
    if (!file->counting) {
        file->nodes.point[at] = vec3_make(v[0], v[1], v[2]);
        file->nodes.id[at] = number;
        file->nodes.line[at] = (uint32_t)file->line;
    }
    return true;
}

bool mesh_file_element(struct mesh_file *file, struct mesh_field id, int32_t pid,
                       const struct mesh_field corners[4], int count, bool curved) {
    int32_t number, nodes[4] = {[3] = -1};
    if (!mesh_file_number(file, id, "the id of an element", 1, &number))
        return false;
    for (int k = 0; k < count; k++)
        if (!mesh_file_number(file, corners[k], "a corner", 1, &nodes[k]))
            return false;
    size_t at = file->elements.count++;
    file->curved += file->counting && curved;
    if (!file->counting) {
        memcpy(file->elements.nodes[at], nodes, sizeof nodes);
        file->elements.id[at] = number;
        file->elements.pid[at] = pid;
        file->elements.line[at] = (uint32_t)file->line;
    }
    return true;
}

/* The number of a name in a list of them, from 1; 0 when it is not there. */
static int32_t find_set(const struct mesh_file *file, struct mesh_field name) {
    for (size_t k = 0; k < file->set_count; k++)
        if (mesh_field_is(name, file->set[k]))
            return (int32_t)k + 1;
    return 0;
}

int32_t mesh_file_set(struct mesh_file *file, struct mesh_field name) {
    name.length = name.length < MESH_NAME_SIZE ? name.length : MESH_NAME_SIZE - 1;
    int32_t set = find_set(file, name);
    if (set)
        return set;
    if (file->set_count == MESH_SETS_MAX) {
        (void)MESH_REFUSE(file, "there are more than %d sets of elements", MESH_SETS_MAX);
        return 0;
    }
    for (size_t k = 0; k < name.length; k++) /* of what is printed ASCII alone */
        file->set[file->set_count][k] = name.at[k] >= ' ' && name.at[k] <= '~' ? name.at[k] : '?';
    file->set[file->set_count][name.length] = '\0';
    file->property[file->set_count] = (int32_t)file->set_count + 1;
    return (int32_t)++file->set_count;
}

bool mesh_file_name(struct mesh_file *file, int32_t pid, struct mesh_field name) {
    int32_t set = mesh_file_set(file, name);
    if (set)
        file->property[set - 1] = pid;
    return set > 0;
}

bool mesh_file_add(struct mesh_file *file, int32_t set, int32_t first, int32_t last, int32_t step) {
    if (!file->counting)
        file->ranges.range[file->ranges.count] = (struct map_range){set, first, last, step};
    file->ranges.count++;
    return true;
}

void mesh_file_pass(struct mesh_file *file, struct mesh_field name) {
    size_t k = 0;
    if (!file->counting)
        return;
    name.length = name.length < MESH_NAME_SIZE ? name.length : MESH_NAME_SIZE - 1;
    while (k < file->passed_names && !mesh_field_is(name, file->passed[k].name))
        k++;
    if (k == MESH_PASSED_MAX) {
        file->passed_others++;
        return;
    }
    if (k == file->passed_names) {
        for (size_t c = 0; c < name.length; c++)
            file->passed[k].name[c] = name.at[c] >= ' ' && name.at[c] <= '~' ? name.at[c] : '?';
        file->passed_names++;
    }
    file->passed[k].count++;
}

/* ---- the mesh of it ---- */

/* How often an element may be in sets on average, so that no file takes for ever. */
enum { SETS_OF_ELEMENT = 64 };

/* Gives the elements of sets that have no property the number of the first set they are in. */
static bool apply_sets(struct mesh_file *file, const struct map_id *elements) {
    size_t count = file->elements.count, left = SETS_OF_ELEMENT * (count + file->ranges.count);
    for (size_t r = 0; r < file->ranges.count; r++) {
        const struct map_range range = file->ranges.range[r];
        for (size_t low = map_ids_from(elements, count, range.first);
             low < count && elements[low].id <= range.last; low++) {
            if (left-- == 0)
                return MAP_REFUSE(file->problem, "the elements are in more than %d sets each",
                                  SETS_OF_ELEMENT);
            int32_t *pid = &file->elements.pid[elements[low].index];
            if (*pid == 0 && (elements[low].id - range.first) % range.step == 0)
                *pid = range.set;
        }
    }
    return true;
}

/* Turns the ids of corners into numbers of nodes. */
static bool connect_nodes(struct mesh_file *file, struct arena *arena) {
    const struct map_id *nodes = map_ids_sort(file->nodes.id, file->nodes.count, arena);
    const struct map_id *elements = map_ids_sort(file->elements.id, file->elements.count, arena);
    if (!nodes || !elements)
        return map_target_no_memory(file->problem);
    int32_t node = map_ids_repeated(nodes, file->nodes.count);
    int32_t element = map_ids_repeated(elements, file->elements.count);
    if (node >= 0)
        return MAP_REFUSE(file->problem, "line %u: node %d is defined twice",
                          file->nodes.line[node], file->nodes.id[node]);
    if (element >= 0)
        return MAP_REFUSE(file->problem, "line %u: element %d is defined twice",
                          file->elements.line[element], file->elements.id[element]);
    for (size_t row = 0; row < file->elements.count; row++) {
        int32_t *corners = file->elements.nodes[row];
        for (int k = 0; k < 4 && corners[k] >= 0; k++) {
            int32_t index = map_ids_find(nodes, file->nodes.count, corners[k]);
            if (index < 0)
                return MAP_REFUSE(
                    file->problem, "line %u: element %d has the corner %d, but there is no node %d",
                    file->elements.line[row], file->elements.id[row], corners[k], corners[k]);
            corners[k] = index;
        }
    }
    return apply_sets(file, elements);
}

/* "24 B31, 3 C3D8". */
static void name_passed_over(const struct mesh_file *file, struct api_text *text) {
    for (size_t k = 0; k < file->passed_names; k++)
        api_text_format(text, "%s%zu %s", k ? ", " : "", file->passed[k].count,
                        file->passed[k].name);
    if (file->passed_others)
        api_text_format(text, ", %zu others", file->passed_others);
}

/* What was passed over, and which properties the sets have become. */
static bool warn_of(const struct mesh_file *file, struct arena *arena, struct map_target *target) {
    struct api_text text = api_text_growing(arena);
    const char *between = "";
    if (!file->passed_names && !file->curved && !file->set_count)
        return true;
    if (file->passed_names) {
        api_text_raw(&text, "ignored: ");
        name_passed_over(file, &text);
        api_text_raw(&text, " (only nodes, shell elements and their sets are read)");
        between = "; ";
    }
    if (file->curved) {
        api_text_format(&text,
                        "%s%zu elements are read by their corners, without the nodes in the middle "
                        "of their edges",
                        between, file->curved);
        between = "; ";
    }
    for (size_t k = 0; k < file->set_count && k < MESH_PASSED_MAX; k++)
        api_text_format(&text, "%s%d %s",
                        k          ? ", "
                        : *between ? "; properties: "
                                   : "properties: ",
                        file->property[k], file->set[k]);
    if (file->set_count > MESH_PASSED_MAX)
        api_text_format(&text, ", and %zu others", file->set_count - MESH_PASSED_MAX);
    target->warning = api_text_finish(&text);
    return target->warning != NULL;
}

/* The names of the sets, for the target. */
static struct map_set *list_sets(const struct mesh_file *file, struct arena *arena) {
    struct map_set *sets = arena_take(arena, file->set_count, sizeof *sets);
    for (size_t k = 0; sets && k < file->set_count; k++)
        sets[k] = (struct map_set){file->set[k], file->property[k]};
    return sets;
}

/* One pass. */
static bool pass_through(struct mesh_file *file, bool (*read)(struct mesh_file *file),
                         const char *bytes, size_t length) {
    file->at = bytes;
    file->end = bytes + length;
    file->line = file->nodes.count = file->elements.count = file->ranges.count = 0;
    return read(file) && file->problem->id == API_OK;
}

enum api_problem_id mesh_file_read(bool (*read)(struct mesh_file *file), const char *bytes,
                                   size_t length, struct arena *arena, struct map_target *target,
                                   struct api_problem *problem) {
    struct mesh_file *file = arena_alloc(arena, 1, sizeof *file);
    *target = (struct map_target){0};
    if (!file)
        return api_problem_no_memory(problem, "the mesh");
    file->problem = problem;
    file->counting = true;
    if (!pass_through(file, read, bytes, length))
        return problem->id;
    if (file->elements.count == 0) {
        struct api_text text = api_text_growing(arena);
        name_passed_over(file, &text);
        const char *passed = api_text_finish(&text);
        return api_problem_set(problem, API_INVALID_REQUEST,
                               "the file has no shell elements; beside %zu nodes it has %.120s",
                               file->nodes.count, passed && *passed ? passed : "nothing");
    }
    size_t nodes = file->nodes.count, elements = file->elements.count, ranges = file->ranges.count;
    file->counting = false;
    file->nodes.point = arena_take(arena, nodes, sizeof *file->nodes.point);
    file->nodes.id = arena_take(arena, nodes, sizeof *file->nodes.id);
    file->nodes.line = arena_take(arena, nodes, sizeof *file->nodes.line);
    file->elements.nodes = arena_take(arena, elements, sizeof *file->elements.nodes);
    file->elements.id = arena_take(arena, elements, sizeof *file->elements.id);
    file->elements.pid = arena_take(arena, elements, sizeof *file->elements.pid);
    file->elements.line = arena_take(arena, elements, sizeof *file->elements.line);
    file->ranges.range = arena_take(arena, ranges, sizeof *file->ranges.range);
    if (!file->nodes.point || !file->nodes.id || !file->nodes.line || !file->elements.nodes ||
        !file->elements.id || !file->elements.pid || !file->elements.line || !file->ranges.range)
        return api_problem_no_memory(problem, "the mesh");
    if (elements > INT32_MAX || nodes > INT32_MAX)
        return api_problem_set(problem, API_INVALID_REQUEST, "the mesh has too many elements");
    if (!pass_through(file, read, bytes, length))
        return problem->id;
    struct arena_mark mark = arena_mark(arena);
    bool good = connect_nodes(file, arena);
    arena_rewind(arena, mark);
    *target = (struct map_target){.vertices = file->nodes.point,
                                  .vertex_count = nodes,
                                  .elements = (const int32_t(*)[4])file->elements.nodes,
                                  .element_count = elements,
                                  .ids = file->elements.id,
                                  .vertex_ids = file->nodes.id,
                                  .pids = file->elements.pid,
                                  .sets = list_sets(file, arena),
                                  .set_count = file->set_count,
                                  .ranges = file->ranges.range,
                                  .range_count = ranges};
    if (good && !target->sets)
        return api_problem_no_memory(problem, "the mesh");
    if (good && !warn_of(file, arena, target))
        api_problem_no_memory(problem, "the mesh");
    return problem->id;
}
