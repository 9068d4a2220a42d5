/* SPDX-License-Identifier: MIT */
/* The mesh of a universal file (.unv) of I-deas: datasets 2411, 2412 and groups of elements. */
#include "mesh_file.h"

#include <string.h>

enum { ELEMENT_CODE = 8 }; /* of what groups hold */

/* The fields of the next line; false, without a problem, at the end of the dataset. */
static bool next_record(struct mesh_file *file, struct mesh_field *line,
                        struct mesh_field fields[MESH_FIELDS_MAX], size_t *count) {
    do {
        if (!mesh_file_next(file, line))
            return false;
        *count = mesh_file_words(*line, fields);
    } while (*count == 0);
    return !(*count == 1 && mesh_field_is(fields[0], "-1"));
}

static bool cut_off(struct mesh_file *file) {
    return MESH_REFUSE(file, "the dataset ends in the middle of a record");
}

/* 2411: LABEL and three more; X Y Z. */
static bool read_universal_nodes(struct mesh_file *file) {
    struct mesh_field line, head[MESH_FIELDS_MAX], place[MESH_FIELDS_MAX];
    size_t count;
    while (next_record(file, &line, head, &count)) {
        if (!next_record(file, &line, place, &count) || count < 3)
            return cut_off(file);
        if (!mesh_file_node(file, head[0], place))
            return false;
    }
    return true;
}

/* Kinds of thin shells, plates, membranes and plane elements by their last digit: triangles, 1 and
 * 2, and quadrilaterals, 4 and 5, of which 2 and 5 have nodes in the middle of edges, between the
 * corners. Beams, below 30, have a record more. */
static bool take_universal_element(struct mesh_file *file, const struct mesh_field *head,
                                   size_t count) {
    struct mesh_field line, nodes[MESH_FIELDS_MAX], more[MESH_FIELDS_MAX], corners[4] = {{0}};
    int32_t kind, pid, number;
    if (count < 6 || !mesh_file_number(file, head[1], "the kind of an element", 1, &kind) ||
        !mesh_file_number(file, head[2], "the property", 0, &pid) ||
        !mesh_file_number(file, head[5], "the number of nodes", 1, &number))
        return count >= 6 ? false
                          : MESH_REFUSE(file, "an element has six numbers before its nodes");
    if (kind < 30 && kind > 10 && !next_record(file, &line, nodes, &count))
        return cut_off(file);
    size_t have = 0;
    for (int32_t left = number; left > 0; left -= (int32_t)count) {
        if (!next_record(file, &line, more, &count))
            return cut_off(file);
        for (size_t k = 0; k < count && have < MESH_FIELDS_MAX; k++)
            nodes[have++] = more[k];
    }
    int digit = kind % 10;
    bool shell = kind > 40 && kind < 100 && (digit == 1 || digit == 2 || digit == 4 || digit == 5);
    size_t wanted = digit < 3 ? 3 : 4, step = digit == 2 || digit == 5 ? 2 : 1;
    if (!shell) {
        mesh_file_pass(file, kind < 40 ? (struct mesh_field){"beams", 5}
                                       : (struct mesh_field){"elements of other kinds", 23});
        return true;
    }
    if (have < wanted * step)
        return MESH_REFUSE(file, "an element of kind %d has %zu nodes, not %zu", kind,
                           wanted * step, have);
    for (size_t k = 0; k < wanted; k++)
        corners[k] = nodes[k * step];
    /* The groups are the properties where there are any, which the first pass has told. */
    return mesh_file_element(file, head[0], file->set_count ? 0 : pid, corners, (int)wanted,
                             step == 2);
}

static bool read_universal_elements(struct mesh_file *file) {
    struct mesh_field line, head[MESH_FIELDS_MAX];
    size_t count;
    while (next_record(file, &line, head, &count))
        if (!take_universal_element(file, head, count))
            return false;
    return true;
}

/* GROUP ... COUNT; NAME; then CODE TAG LEAF COMPONENT, two of them a line. */
static bool read_universal_groups(struct mesh_file *file) {
    struct mesh_field line, fields[MESH_FIELDS_MAX];
    size_t count;
    int32_t left, code, tag;
    while (next_record(file, &line, fields, &count)) {
        if (!mesh_file_number(file, fields[count - 1], "how much a group holds", 0, &left) ||
            !mesh_file_next(file, &line))
            return file->problem->id == API_OK ? cut_off(file) : false;
        mesh_file_words(line, fields);
        struct mesh_field name = {line.at, line.length};
        while (name.length && *name.at == ' ') {
            name.at++;
            name.length--;
        }
        int32_t set = 0;
        while (left > 0) {
            if (!next_record(file, &line, fields, &count) || count % 4)
                return cut_off(file);
            for (size_t k = 0; k + 3 < count; k += 4, left--) {
                if (!mesh_file_number(file, fields[k], "a code", 0, &code) ||
                    !mesh_file_number(file, fields[k + 1], "a tag", 0, &tag))
                    return false;
                if (code != ELEMENT_CODE)
                    continue;
                set = set ? set : mesh_file_set(file, name);
                if (!set || !mesh_file_add(file, set, tag, tag, 1))
                    return false;
            }
        }
    }
    return true;
}

static bool skip_dataset(struct mesh_file *file) {
    struct mesh_field line, fields[MESH_FIELDS_MAX];
    size_t count;
    while (next_record(file, &line, fields, &count)) {
    }
    return true;
}

static bool read_datasets(struct mesh_file *file) {
    struct mesh_field line, fields[MESH_FIELDS_MAX];
    size_t count;
    bool good = true, any = false;
    while (good && mesh_file_next(file, &line)) {
        count = mesh_file_words(line, fields);
        if (count == 0)
            continue;
        if (count != 1 || !mesh_field_is(fields[0], "-1"))
            return MESH_REFUSE(file, "this is not a universal file: a dataset begins with -1");
        if (!next_record(file, &line, fields, &count))
            break;
        any = true;
        struct mesh_field number = fields[0];
        if (mesh_field_is(number, "2411"))
            good = read_universal_nodes(file);
        else if (mesh_field_is(number, "2412"))
            good = read_universal_elements(file);
        else if (mesh_field_is(number, "2467") || mesh_field_is(number, "2477") ||
                 mesh_field_is(number, "2452") || mesh_field_is(number, "2435"))
            good = read_universal_groups(file);
        else if (mesh_field_is(number, "781") || mesh_field_is(number, "780"))
            good = MESH_REFUSE(file,
                               "dataset %.*s is not read: write nodes as 2411 and elements "
                               "as 2412",
                               (int)number.length, number.at);
        else
            good = skip_dataset(file);
    }
    return good && (any || MESH_REFUSE(file, "this is not a universal file: it has no dataset"));
}

enum api_problem_id map_target_universal(const char *bytes, size_t length, struct arena *arena,
                                         struct map_target *target, struct api_problem *problem) {
    return mesh_file_read(read_datasets, bytes, length, arena, target, problem);
}
