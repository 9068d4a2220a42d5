/* SPDX-License-Identifier: MIT */
/* The mesh of an input deck of Abaqus or CalculiX (.inp): *NODE, *ELEMENT, *ELSET. */
#include "mesh_file.h"

#include <string.h>
#include <strings.h>

/* What the data lines mean that follow a keyword. */
enum block { BLOCK_NOTHING, BLOCK_NODES, BLOCK_SHELLS, BLOCK_SET, BLOCK_INSTANCE };

struct deck {
    enum block block;
    int corners; /* of BLOCK_SHELLS */
    bool curved;
    int nodes;   /* of one element, which may take two lines */
    int32_t set; /* of the elements; 0: none */
    bool generate;
    struct mesh_field fields[2 * MESH_FIELDS_MAX]; /* of an element so far */
    size_t field_count;
};

/* The value of a parameter of a keyword's line, "" where it has none; false where it is not given.
 */
static bool keyword_parameter(const struct mesh_field *fields, size_t count, const char *name,
                              struct mesh_field *value) {
    for (size_t k = 1; k < count; k++) {
        const char *equals = memchr(fields[k].at, '=', fields[k].length);
        size_t length = equals ? (size_t)(equals - fields[k].at) : fields[k].length;
        while (length > 0 && fields[k].at[length - 1] == ' ')
            length--;
        if (length != strlen(name) || strncasecmp(fields[k].at, name, length) != 0)
            continue;
        const char *end = fields[k].at + fields[k].length, *at = equals ? equals + 1 : end;
        while (at < end && (*at == ' ' || *at == '"'))
            at++;
        while (end > at && (end[-1] == ' ' || end[-1] == '"'))
            end--;
        *value = (struct mesh_field){at, (size_t)(end - at)};
        return true;
    }
    return false;
}

/* The shells and membranes: their families, and how many nodes those have of which number. */
static bool take_type(struct deck *deck, struct mesh_field type) {
    static const char *const families[] = {"SFM3D", "STRI", "M3D", "R3D", "DS", "S"};
    size_t k = 0, at;
    while (k < sizeof families / sizeof *families && !mesh_field_begins(type, families[k]))
        k++;
    if (k == sizeof families / sizeof *families)
        return false;
    at = strlen(families[k]);
    char digit = at < type.length ? type.at[at] : '\0';
    bool stri65 = mesh_field_is(type, "STRI65");
    if (at + 1 < type.length && type.at[at + 1] >= '0' && type.at[at + 1] <= '9' && !stri65)
        return false;
    deck->nodes = digit - '0';
    deck->corners = digit == '3' || digit == '6' ? 3 : 4;
    deck->curved = digit > '4';
    return digit == '3' || digit == '4' || digit == '6' || digit == '8' || digit == '9';
}

static bool begin_elements(struct mesh_file *file, struct deck *deck,
                           const struct mesh_field *fields, size_t count) {
    struct mesh_field type = {"", 0}, set;
    if (!keyword_parameter(fields, count, "TYPE", &type))
        return MESH_REFUSE(file, "*ELEMENT has no TYPE");
    if (!take_type(deck, type)) {
        mesh_file_pass(file, type);
        return true;
    }
    deck->block = BLOCK_SHELLS;
    deck->set = 0;
    return !keyword_parameter(fields, count, "ELSET", &set) ||
           (deck->set = mesh_file_set(file, set)) > 0;
}

/* Those that make or move a mesh otherwise than by its nodes and elements. */
static bool refuse_generated(struct mesh_file *file, const struct mesh_field *fields,
                             size_t count) {
    static const char *const makers[] = {"*NGEN",  "*NFILL",  "*NCOPY", "*NMAP",
                                         "*ELGEN", "*ELCOPY", "*SYSTEM"};
    struct mesh_field value;
    if (mesh_field_is(fields[0], "*INCLUDE"))
        return MESH_REFUSE(file, "the file that *INCLUDE names is not read: send one file with "
                                 "everything in it");
    for (size_t k = 0; k < sizeof makers / sizeof *makers; k++)
        if (mesh_field_is(fields[0], makers[k]))
            return MESH_REFUSE(file, "%s is not read: write the mesh as nodes and elements",
                               makers[k]);
    if (mesh_field_is(fields[0], "*NODE") && keyword_parameter(fields, count, "SYSTEM", &value) &&
        !mesh_field_is(value, "R"))
        return MESH_REFUSE(file, "*NODE must be in rectangular coordinates");
    return true;
}

static bool take_keyword(struct mesh_file *file, struct deck *deck, struct mesh_field line) {
    struct mesh_field fields[MESH_FIELDS_MAX], set;
    size_t count = mesh_file_commas(line, fields);
    deck->block = BLOCK_NOTHING;
    if (deck->field_count)
        return MESH_REFUSE(file, "the element before has less than %d nodes", deck->nodes);
    if (!refuse_generated(file, fields, count))
        return false;
    if (mesh_field_is(fields[0], "*NODE"))
        deck->block = BLOCK_NODES;
    else if (mesh_field_is(fields[0], "*INSTANCE"))
        deck->block = BLOCK_INSTANCE;
    else if (mesh_field_is(fields[0], "*ELEMENT"))
        return begin_elements(file, deck, fields, count);
    else if (mesh_field_is(fields[0], "*ELSET")) {
        if (!keyword_parameter(fields, count, "ELSET", &set))
            return MESH_REFUSE(file, "*ELSET has no name");
        struct mesh_field value;
        deck->generate = keyword_parameter(fields, count, "GENERATE", &value);
        deck->block = BLOCK_SET;
        deck->set = mesh_file_set(file, set);
        return deck->set > 0;
    }
    return true;
}

/* An element takes as many lines as it has nodes for. */
static bool take_shell(struct mesh_file *file, struct deck *deck, struct mesh_field *fields,
                       size_t count) {
    count -= count > 1 && fields[count - 1].length == 0; /* the comma at the end of a line */
    for (size_t k = 0; k < count; k++)
        deck->fields[deck->field_count++] = fields[k];
    if (deck->field_count < (size_t)deck->nodes + 1)
        return true;
    count = deck->field_count;
    deck->field_count = 0;
    if (count > (size_t)deck->nodes + 1)
        return MESH_REFUSE(file, "an element of this type has %d nodes, not %zu", deck->nodes,
                           count - 1);
    return mesh_file_element(file, deck->fields[0], deck->set, deck->fields + 1, deck->corners,
                             deck->curved);
}

/* Ids, or with GENERATE one range, of a set; names of other sets are passed over. */
static bool take_members(struct mesh_file *file, const struct deck *deck,
                         const struct mesh_field *fields, size_t count) {
    int32_t range[3] = {0, 0, 1};
    if (deck->generate) {
        for (size_t k = 0; k < 3 && k < count && (k < 2 || fields[k].length); k++)
            if (!mesh_file_number(file, fields[k], "a range of elements", 1, &range[k]))
                return false;
        return mesh_file_add(file, deck->set, range[0], range[1], range[2]);
    }
    for (size_t k = 0; k < count; k++) {
        bool digit = fields[k].length && fields[k].at[0] >= '0' && fields[k].at[0] <= '9';
        if (!fields[k].length)
            continue;
        if (!digit)
            mesh_file_pass(file, (struct mesh_field){"sets of sets", 12});
        else if (!mesh_file_number(file, fields[k], "an element of a set", 1, &range[0]) ||
                 !mesh_file_add(file, deck->set, range[0], range[0], 1))
            return false;
    }
    return true;
}

static bool read_deck(struct mesh_file *file) {
    struct deck deck = {0};
    struct mesh_field line, fields[MESH_FIELDS_MAX];
    static const struct mesh_field zero = {"0", 1};
    while (mesh_file_next(file, &line)) {
        if (line.length == 0 || (line.length > 1 && line.at[0] == '*' && line.at[1] == '*'))
            continue;
        if (line.at[0] == '*') {
            if (!take_keyword(file, &deck, line))
                return false;
            continue;
        }
        if (deck.block == BLOCK_NOTHING)
            continue;
        size_t count = mesh_file_commas(line, fields);
        bool good = true;
        if (deck.block == BLOCK_INSTANCE)
            good = MESH_REFUSE(file, "an instance that is moved is not read: write its nodes where "
                                     "they are");
        else if (deck.block == BLOCK_NODES) {
            for (; count < 4; count++)
                fields[count] = zero;
            for (size_t k = 1; k < 4; k++)
                fields[k] = fields[k].length ? fields[k] : zero;
            good = mesh_file_node(file, fields[0], fields + 1);
        } else if (deck.block == BLOCK_SHELLS)
            good = take_shell(file, &deck, fields, count);
        else
            good = take_members(file, &deck, fields, count);
        if (!good)
            return false;
    }
    return deck.field_count == 0 ||
           MESH_REFUSE(file, "the last element has less than %d nodes", deck.nodes);
}

enum api_problem_id map_target_abaqus(const char *bytes, size_t length, struct arena *arena,
                                      struct map_target *target, struct api_problem *problem) {
    return mesh_file_read(read_deck, bytes, length, arena, target, problem);
}
