/* SPDX-License-Identifier: MIT */
/* The mesh of a keyword deck of LS-DYNA (.k): *NODE and *ELEMENT_SHELL with its options. */
#include "mesh_file.h"

#include <string.h>

struct keyword {
    bool nodes, shells;
    bool wide; /* fields of 20 characters */
    int cards; /* that follow the first of each element */
};

/* *ELEMENT_SHELL_THICKNESS_OFFSET and the like: each option has a card of its own, but for
 * thickness and angle, which share one. */
static bool take_shell_options(struct mesh_file *file, struct keyword *keyword,
                               struct mesh_field name) {
    static const struct {
        const char *name;
        int card;
    } options[] = {{"_THICKNESS", 1}, {"_BETA", 1}, {"_MCID", 1}, {"_OFFSET", 2}, {"_DOF", 4}};
    int cards = 0;
    name.at += strlen("*ELEMENT_SHELL");
    name.length -= strlen("*ELEMENT_SHELL");
    while (name.length) {
        size_t k = 0;
        while (k < sizeof options / sizeof *options && !mesh_field_begins(name, options[k].name))
            k++;
        if (k == sizeof options / sizeof *options)
            return MESH_REFUSE(file,
                               "*ELEMENT_SHELL%.*s is not read: write the elements as "
                               "*ELEMENT_SHELL",
                               name.length < 32 ? (int)name.length : 32, name.at);
        cards |= options[k].card;
        name.at += strlen(options[k].name);
        name.length -= strlen(options[k].name);
    }
    keyword->shells = true;
    keyword->cards = (cards & 1) + (cards >> 1 & 1) + (cards >> 2 & 1);
    return true;
}

/* A keyword may end in + or LONG=Y, for fields of 20 characters. */
static bool take_dyna_keyword(struct mesh_file *file, struct mesh_field line, bool wide,
                              struct keyword *keyword) {
    struct mesh_field words[MESH_FIELDS_MAX];
    size_t count = mesh_file_words(line, words);
    struct mesh_field name = words[0];
    *keyword = (struct keyword){.wide = wide};
    if (name.at[name.length - 1] == '+' || name.at[name.length - 1] == '-') {
        keyword->wide = name.at[name.length - 1] == '+';
        name.length--;
    } else if (count > 1 && words[1].length == 1 && (*words[1].at == '+' || *words[1].at == '-'))
        keyword->wide = *words[1].at == '+';
    if (mesh_field_begins(name, "*INCLUDE"))
        return MESH_REFUSE(file, "the file that *INCLUDE names is not read: send one file with "
                                 "everything in it");
    if (mesh_field_begins(name, "*NODE_TRANSFORM") || mesh_field_is(name, "*NODE_THICKNESS"))
        return MESH_REFUSE(file, "%.*s is not read: write the nodes where they are",
                           (int)name.length, name.at);
    keyword->nodes = mesh_field_is(name, "*NODE");
    if (mesh_field_begins(name, "*ELEMENT_SHELL"))
        return take_shell_options(file, keyword, name);
    if (mesh_field_begins(name, "*ELEMENT"))
        mesh_file_pass(file, (struct mesh_field){name.at + 1, name.length - 1});
    return true;
}

/* EID PID N1 N2 N3 N4: a triangle has its third node again, or none. */
static bool take_shell_card(struct mesh_file *file, struct mesh_field line, bool wide) {
    struct mesh_field fields[MESH_FIELDS_MAX];
    size_t width = wide ? 20 : 8, count = mesh_file_columns(line, width, width, fields);
    int32_t pid, nodes[2] = {0, 0};
    bool mid = false;
    if (count < 5)
        return MESH_REFUSE(file, "a shell must have an id, a part and at least three nodes");
    for (size_t k = 4; k < 6 && k < count; k++)
        if (fields[k].length && !mesh_file_number(file, fields[k], "a corner", 0, &nodes[k - 4]))
            return false;
    for (size_t k = 6; k < 10 && k < count; k++)
        mid = mid || (fields[k].length && !mesh_field_is(fields[k], "0"));
    return mesh_file_number(file, fields[1], "the part", 0, &pid) &&
           mesh_file_element(file, fields[0], pid, fields + 2,
                             nodes[1] == 0 || nodes[1] == nodes[0] ? 3 : 4, mid);
}

static bool take_node(struct mesh_file *file, struct mesh_field line, bool wide) {
    struct mesh_field fields[MESH_FIELDS_MAX];
    static const struct mesh_field zero = {"0", 1};
    size_t count = mesh_file_columns(line, wide ? 20 : 8, wide ? 20 : 16, fields);
    for (; count < 4; count++)
        fields[count] = zero;
    for (size_t k = 1; k < 4; k++)
        fields[k] = fields[k].length ? fields[k] : zero;
    return mesh_file_node(file, fields[0], fields + 1);
}

static bool is_long(struct mesh_field line) {
    struct mesh_field words[MESH_FIELDS_MAX];
    size_t count = mesh_file_words(line, words);
    for (size_t k = 1; k < count; k++)
        if (mesh_field_begins(words[k], "LONG=Y") || mesh_field_begins(words[k], "LONG=K"))
            return true;
    return false;
}

static bool read_keywords(struct mesh_file *file) {
    struct mesh_field line;
    struct keyword keyword = {0};
    bool wide = false;
    int skip = 0;
    while (mesh_file_next(file, &line)) {
        if (line.length == 0 || line.at[0] == '$')
            continue;
        if (line.at[0] == '*') {
            struct mesh_field word = line;
            if (mesh_field_is(word, "*END"))
                break;
            skip = 0;
            if (mesh_field_begins(word, "*KEYWORD"))
                wide = is_long(line);
            if (!take_dyna_keyword(file, line, wide, &keyword))
                return false;
        } else if (skip > 0) {
            skip--;
        } else if (keyword.nodes) {
            if (!take_node(file, line, keyword.wide))
                return false;
        } else if (keyword.shells) {
            if (!take_shell_card(file, line, keyword.wide))
                return false;
            skip = keyword.cards;
        }
    }
    return true;
}

enum api_problem_id map_target_lsdyna(const char *bytes, size_t length, struct arena *arena,
                                      struct map_target *target, struct api_problem *problem) {
    return mesh_file_read(read_keywords, bytes, length, arena, target, problem);
}
