/* SPDX-License-Identifier: MIT */
/* The mesh of Gmsh (.msh), versions 2.2 and 4.1 as text; physical groups are its sets. */
#include "mesh_file.h"

#include <string.h>

/* Gmsh's numbers of the kinds of shell elements, and their names; others are passed over. */
static const struct {
    int32_t type;
    int corners;
    bool curved;
} shells[] = {{2, 3, false}, {3, 4, false}, {9, 3, true}, {10, 4, true},
              {16, 4, true}, {20, 3, true}, {21, 3, true}};

/* The physical group of each surface of version 4.1, which names surfaces at their elements. */
enum { SURFACES_MAX = 4096 };

struct gmsh {
    struct mesh_field fields[MESH_FIELDS_MAX];
    size_t count;
    size_t surfaces;
    int32_t surface[SURFACES_MAX], group[SURFACES_MAX];
};

/* The words of the next line that has any. */
static bool next_words(struct mesh_file *file, struct gmsh *gmsh, size_t least) {
    struct mesh_field line;
    do {
        if (!mesh_file_next(file, &line))
            return MESH_REFUSE(file, "the file ends in the middle of a section");
        gmsh->count = mesh_file_words(line, gmsh->fields);
    } while (gmsh->count == 0);
    return gmsh->count >= least ||
           MESH_REFUSE(file, "the line must have at least %zu numbers", least);
}

/* Word k of the line as a whole number of no sign. */
static bool whole(struct mesh_file *file, const struct gmsh *gmsh, size_t k, int32_t *number) {
    return mesh_file_number(file, gmsh->fields[k], "a number of the line", 0, number);
}

/* A tag, whose sign is an orientation. */
static bool take_tag(struct mesh_file *file, struct mesh_field field, int32_t *tag) {
    if (field.length > 1 && field.at[0] == '-') {
        field.at++;
        field.length--;
    }
    return mesh_file_number(file, field, "a tag", 0, tag);
}

static bool take_format(struct mesh_file *file, struct gmsh *gmsh, bool *blocks) {
    if (!next_words(file, gmsh, 2))
        return false;
    *blocks = mesh_field_is(gmsh->fields[0], "4.1");
    if (!*blocks && !mesh_field_is(gmsh->fields[0], "2.2") && !mesh_field_is(gmsh->fields[0], "2"))
        return MESH_REFUSE(file,
                           "version %.*s is not read: write 4.1 or 2.2 "
                           "(Mesh.MshFileVersion)",
                           gmsh->fields[0].length < 8 ? (int)gmsh->fields[0].length : 8,
                           gmsh->fields[0].at);
    return mesh_field_is(gmsh->fields[1], "0") ||
           MESH_REFUSE(file, "the file is binary: write it as text (Mesh.Binary = 0)");
}

/* DIMENSION TAG "NAME": the names are given to properties by the tag, which is the property. */
static bool take_names(struct mesh_file *file, struct gmsh *gmsh) {
    int32_t count, dimension, tag;
    if (!next_words(file, gmsh, 1) || !whole(file, gmsh, 0, &count))
        return false;
    for (int32_t k = 0; k < count; k++) {
        if (!next_words(file, gmsh, 3) || !whole(file, gmsh, 0, &dimension) ||
            !whole(file, gmsh, 1, &tag))
            return false;
        const char *at = gmsh->fields[2].at;
        const char *end = gmsh->fields[gmsh->count - 1].at + gmsh->fields[gmsh->count - 1].length;
        at += *at == '"';
        end -= end > at && end[-1] == '"';
        if (dimension == 2 &&
            !mesh_file_name(file, tag, (struct mesh_field){at, (size_t)(end - at)}))
            return false;
    }
    return true;
}

/* Of the surfaces which physical group is the first of each. */
static bool take_entities(struct mesh_file *file, struct gmsh *gmsh) {
    int32_t counts[4], groups;
    if (!next_words(file, gmsh, 4))
        return false;
    for (size_t k = 0; k < 4; k++)
        if (!whole(file, gmsh, k, &counts[k]))
            return false;
    gmsh->surfaces = 0;
    for (int dimension = 0; dimension < 3; dimension++)
        for (int32_t k = 0; k < counts[dimension]; k++) {
            size_t at = dimension == 0 ? 4 : 7; /* behind the tag and the box */
            if (!next_words(file, gmsh, at + 1))
                return false;
            if (dimension < 2)
                continue;
            if (!whole(file, gmsh, at, &groups))
                return false;
            if (groups == 0)
                continue;
            if (gmsh->surfaces == SURFACES_MAX || gmsh->count < at + 2)
                return MESH_REFUSE(file, "there are more than %d surfaces in groups", SURFACES_MAX);
            if (!take_tag(file, gmsh->fields[0], &gmsh->surface[gmsh->surfaces]) ||
                !take_tag(file, gmsh->fields[at + 1], &gmsh->group[gmsh->surfaces]))
                return false;
            gmsh->surfaces++;
        }
    return true;
}

static int32_t group_of(const struct gmsh *gmsh, int32_t surface) {
    for (size_t k = 0; k < gmsh->surfaces; k++)
        if (gmsh->surface[k] == surface)
            return gmsh->group[k];
    return 0;
}

/* ID X Y Z. */
static bool take_nodes(struct mesh_file *file, struct gmsh *gmsh) {
    int32_t count;
    if (!next_words(file, gmsh, 1) || !whole(file, gmsh, 0, &count))
        return false;
    for (int32_t k = 0; k < count; k++)
        if (!next_words(file, gmsh, 4) || !mesh_file_node(file, gmsh->fields[0], gmsh->fields + 1))
            return false;
    return true;
}

/* Blocks of so many ids, and then so many places: both are read beside each other. */
static bool take_node_blocks(struct mesh_file *file, struct gmsh *gmsh) {
    int32_t blocks, count;
    if (!next_words(file, gmsh, 2) || !whole(file, gmsh, 0, &blocks))
        return false;
    for (int32_t block = 0; block < blocks; block++) {
        if (!next_words(file, gmsh, 4) || !whole(file, gmsh, 3, &count))
            return false;
        struct mesh_file ids = {
            .problem = file->problem, .at = file->at, .end = file->end, .line = file->line};
        struct mesh_field line, id[MESH_FIELDS_MAX];
        for (int32_t k = 0; k < count; k++)
            if (!next_words(file, gmsh, 1))
                return false;
        for (int32_t k = 0; k < count; k++) {
            do {
                if (!mesh_file_next(&ids, &line))
                    return MESH_REFUSE(file, "the file ends in the middle of a section");
            } while (mesh_file_words(line, id) == 0);
            if (!next_words(file, gmsh, 3) || !mesh_file_node(file, id[0], gmsh->fields))
                return false;
        }
    }
    return true;
}

/* The element whose id is the first word and whose nodes begin at `at`. */
static bool take_gmsh_element(struct mesh_file *file, struct gmsh *gmsh, int32_t type, int32_t pid,
                              size_t at) {
    size_t k = 0;
    while (k < sizeof shells / sizeof *shells && shells[k].type != type)
        k++;
    if (k == sizeof shells / sizeof *shells) {
        static const char *const names[] = {
            [1] = "lines",    [4] = "tetrahedra", [5] = "hexahedra",   [6] = "prisms",
            [7] = "pyramids", [8] = "lines",      [11] = "tetrahedra", [15] = "points"};
        const char *name = type >= 0 && (size_t)type < sizeof names / sizeof *names && names[type]
                               ? names[type]
                               : "elements of other kinds";
        mesh_file_pass(file, (struct mesh_field){name, strlen(name)});
        return true;
    }
    return (gmsh->count >= at + (size_t)shells[k].corners ||
            MESH_REFUSE(file, "the element has less than %d nodes", shells[k].corners)) &&
           mesh_file_element(file, gmsh->fields[0], pid, gmsh->fields + at, shells[k].corners,
                             shells[k].curved);
}

/* ID TYPE TAGS TAG... NODE...: the first tag is the physical group. */
static bool take_gmsh_elements(struct mesh_file *file, struct gmsh *gmsh) {
    int32_t count, type, tags, pid;
    if (!next_words(file, gmsh, 1) || !whole(file, gmsh, 0, &count))
        return false;
    for (int32_t k = 0; k < count; k++) {
        pid = 0;
        if (!next_words(file, gmsh, 4) || !whole(file, gmsh, 1, &type) ||
            !whole(file, gmsh, 2, &tags))
            return false;
        if (tags > MESH_FIELDS_MAX || gmsh->count <= (size_t)tags + 3)
            return MESH_REFUSE(file, "the element has no nodes behind its %d tags", tags);
        if ((tags > 0 && !take_tag(file, gmsh->fields[3], &pid)) ||
            !take_gmsh_element(file, gmsh, type, pid, (size_t)tags + 3))
            return false;
    }
    return true;
}

static bool take_element_blocks(struct mesh_file *file, struct gmsh *gmsh) {
    int32_t blocks, dimension, surface, type, count;
    if (!next_words(file, gmsh, 1) || !whole(file, gmsh, 0, &blocks))
        return false;
    for (int32_t block = 0; block < blocks; block++) {
        if (!next_words(file, gmsh, 4) || !whole(file, gmsh, 0, &dimension) ||
            !take_tag(file, gmsh->fields[1], &surface) || !whole(file, gmsh, 2, &type) ||
            !whole(file, gmsh, 3, &count))
            return false;
        int32_t pid = dimension == 2 ? group_of(gmsh, surface) : 0;
        for (int32_t k = 0; k < count; k++)
            if (!next_words(file, gmsh, 2) || !take_gmsh_element(file, gmsh, type, pid, 1))
                return false;
    }
    return true;
}

static bool read_sections(struct mesh_file *file) {
    struct gmsh gmsh = {.surfaces = 0};
    struct mesh_field line;
    bool blocks = false, known = false, good = true;
    while (good && mesh_file_next(file, &line)) {
        if (mesh_field_is(line, "$MeshFormat"))
            known = good = take_format(file, &gmsh, &blocks);
        else if (line.length && line.at[0] == '$' && !known && !mesh_field_is(line, "$Comments"))
            good = MESH_REFUSE(file, "this is not a mesh of Gmsh: it must begin with $MeshFormat");
        else if (mesh_field_is(line, "$PhysicalNames"))
            good = take_names(file, &gmsh);
        else if (mesh_field_is(line, "$Entities"))
            good = take_entities(file, &gmsh);
        else if (mesh_field_is(line, "$Nodes"))
            good = blocks ? take_node_blocks(file, &gmsh) : take_nodes(file, &gmsh);
        else if (mesh_field_is(line, "$Elements"))
            good = blocks ? take_element_blocks(file, &gmsh) : take_gmsh_elements(file, &gmsh);
    }
    return good && (known || MESH_REFUSE(file, "this is not a mesh of Gmsh: it has no "
                                               "$MeshFormat"));
}

enum api_problem_id map_target_gmsh(const char *bytes, size_t length, struct arena *arena,
                                    struct map_target *target, struct api_problem *problem) {
    return mesh_file_read(read_sections, bytes, length, arena, target, problem);
}
