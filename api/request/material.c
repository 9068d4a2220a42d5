/* SPDX-License-Identifier: MIT */
#include "material.h"

#include "api/json/text.h"
#include "api/json/value.h"
#include "materials.h" /* made from api/materials */
#include "members.h"
#include "normalise.h"
#include <stdio.h>
#include <string.h>

/* kg/m^3: fibres are between polyethylene and tungsten. */
static const double density_least = 500, density_most = 20000;

enum { WANTED_MAX = 256, LEVELS_MAX = 64 };

/* ---- the library ---- */

const struct api_material *api_material_at(size_t index) {
    return index < sizeof materials / sizeof *materials ? &materials[index] : NULL;
}

static const struct api_material *find(const char *name, size_t length) {
    const struct api_material *material;
    for (size_t k = 0; (material = api_material_at(k)); k++)
        if (strlen(material->name) == length && memcmp(material->name, name, length) == 0)
            return material;
    return NULL;
}

const struct api_material *api_material_named(const char *name) {
    return find(name, strlen(name));
}

const char *api_materials_heads(void) {
    return materials_heads;
}

/* ---- a document ---- */

/* What a document says besides figures. */
struct head {
    const char *name, *about, *source;
    bool example;
};

static void read_head(const struct json_value *json, struct head *head) {
    struct json_value name = value_member(json, "name"), about = value_member(json, "about");
    struct json_value source = value_member(json, "source");
    struct json_value example = value_member(json, "example");
    *head = (struct head){0};
    if (value_given(&name))
        value_string(&name, &head->name);
    if (value_given(&about))
        value_string(&about, &head->about);
    if (value_given(&source))
        value_string(&source, &head->source);
    if (value_given(&example))
        value_boolean(&example, &head->example);
}

static void write_head(struct api_text *text, const struct head *head, bool listed) {
    if (head->name)
        api_text_key_string(text, "name", head->name);
    if (head->about || listed)
        api_text_key_string(text, "about", head->about ? head->about : "");
    if (head->source || listed)
        api_text_key_string(text, "source", head->source ? head->source : "");
    api_text_key(text, "example");
    api_text_raw(text, head->example ? "true" : "false");
}

static void write_figures(struct api_text *text, const struct api_request *figures) {
    const struct api_fabric *fabric = &figures->fabric;
    if (fabric->areal_weight > 0)
        api_text_key_number(text, "areal_weight", fabric->areal_weight);
    api_text_key(text, "fabric");
    api_text_raw(text, "{");
    if (fabric->thickness > 0)
        api_text_key_number(text, "thickness", fabric->thickness);
    if (fabric->fiber_volume_fraction > 0)
        api_text_key_number(text, "fiber_volume_fraction", fabric->fiber_volume_fraction);
    if (fabric->locking_angle_deg >= 0)
        api_text_key_number(text, "locking_angle_deg", fabric->locking_angle_deg);
    api_text_raw(text, "}");
    api_normalise_permeability(text, &figures->permeability);
    api_normalise_compaction(text, &fabric->compaction);
}

/* Its figures in its own unit. */
static struct api_request read_figures(const struct json_value *json) {
    struct api_request figures = {.length_unit = &api_units[0],
                                  .fabric = {.locking_angle_deg = -1},
                                  .permeability = {.model = API_PERMEABILITY_NONE}};
    decode_material(json, &figures);
    return figures;
}

static void write(const struct json_value *json, const struct head *head,
                  const struct api_request *figures, struct api_material *material) {
    struct api_text text = api_text_growing(json->tree->arena);
    api_text_raw(&text, "{");
    write_head(&text, head, false);
    write_figures(&text, figures);
    api_text_raw(&text, "}");
    *material = (struct api_material){.length = text.length};
    material->json = api_text_finish(&text);
    if (!material->json)
        api_problem_set(json->tree->problem, API_OUT_OF_MEMORY,
                        "the material needs more memory than allowed");
}

bool material_read(const struct json_value *json, struct api_material *material) {
    struct head head;
    struct api_request figures = read_figures(json);
    read_head(json, &head);
    write(json, &head, &figures, material);
    return json->tree->problem->id == API_OK;
}

/* Names are parts of paths, and stand in requests without escapes. */
static bool is_name(const char *text, size_t length) {
    bool good = length > 0 && length < API_MATERIAL_NAME_SIZE && *text != '.';
    for (size_t k = 0; good && k < length; k++)
        good = (text[k] >= 'a' && text[k] <= 'z') || (text[k] >= 'A' && text[k] <= 'Z') ||
               (text[k] >= '0' && text[k] <= '9') || strchr("-_.", text[k]);
    return good;
}

static void check_name(const struct json_value *json, const char *name) {
    if (!name || !is_name(name, strlen(name)))
        value_fault(json, "must have 1 to %d letters, digits, '-', '_' and '.', no '.' first",
                    API_MATERIAL_NAME_SIZE - 1);
    else if (api_material_named(name))
        value_fault(json, "is a name of the library: give it one of its own");
}

/* The fibre that the figures speak of: its areal weight fills that share of the thickness. */
static void check_fibre(const struct json_value *json, const struct api_fabric *fabric) {
    struct json_value weight = value_member(json, "areal_weight");
    double volume = fabric->thickness * fabric->fiber_volume_fraction;
    if (!(fabric->areal_weight > 0) || !(volume > 0))
        return;
    double density = fabric->areal_weight / volume;
    if (density < density_least || density > density_most)
        value_fault(&weight,
                    "in that share of the thickness is a fibre of %.3g kg/m3: areal_weight is in "
                    "kg/m2, fabric.thickness in m",
                    density);
}

static void decode_document(const struct json_value *json, struct api_material *material,
                            const char **list) {
    struct head head;
    struct json_value name = value_member(json, "name");
    struct api_request figures = read_figures(json);
    struct api_text text = api_text_growing(json->tree->arena);
    if (value_type(json) != VALUE_OBJECT)
        return;
    read_head(json, &head);
    check_name(&name, head.name);
    check_fibre(json, &figures.fabric);
    if (json->tree->problem->id != API_OK)
        return;
    write(json, &head, &figures, material);
    api_text_raw(&text, "{");
    write_head(&text, &head, true);
    api_text_raw(&text, ",\"own\":true}");
    *list = api_text_finish(&text);
    char *copy = json_tree_alloc(json->tree, strlen(head.name) + 1, 1);
    if (copy)
        material->name = strcpy(copy, head.name);
}

enum api_problem_id api_material_decode(const char *bytes, size_t length,
                                        const struct api_limits *limits, struct arena *arena,
                                        struct api_material *material, const char **head,
                                        struct api_problem *problem) {
    struct json_tree tree;
    if (json_tree_parse(&tree, bytes, length, limits, arena, problem) != API_OK)
        return problem->id;
    struct json_value root = value_root(&tree);
    *head = NULL;
    decode_document(&root, material, head);
    json_tree_free(&tree);
    if (problem->id == API_OK && !*head)
        api_problem_set(problem, API_OUT_OF_MEMORY, "the material needs more memory than allowed");
    return problem->id;
}

/* ---- names in a request ---- */

/* Bytes of the text. */
struct span {
    const char *from, *to;
};

enum key { KEY_OTHER, KEY_FABRIC, KEY_MATERIAL };

/* An open array or object. */
struct level {
    bool object, fabric; /* fabric: the member of that name */
    bool in_value;       /* behind the colon */
    enum key key;        /* the latest */
};

struct reader {
    const char *at, *end;
    size_t depth;
    struct level level[LEVELS_MAX + 1]; /* the first is about the document */
};

static bool is(struct span span, const char *text) {
    size_t length = strlen(text);
    return (size_t)(span.to - span.from) == length && memcmp(span.from, text, length) == 0;
}

static enum key key_of(struct span span) {
    return is(span, "fabric") ? KEY_FABRIC : is(span, "material") ? KEY_MATERIAL : KEY_OTHER;
}

/* What lies between the quote before `at` and the next. */
static struct span take_string(struct reader *reader) {
    struct span span = {reader->at, reader->at};
    while (span.to < reader->end && *span.to != '"')
        span.to += *span.to == '\\' && span.to + 1 < reader->end ? 2 : 1;
    reader->at = span.to < reader->end ? span.to + 1 : reader->end;
    return span;
}

static struct level *innermost(struct reader *reader) {
    return &reader->level[reader->depth < LEVELS_MAX ? reader->depth : LEVELS_MAX];
}

static void open_level(struct reader *reader, bool object) {
    const struct level *outer = innermost(reader);
    bool fabric = outer->object && outer->in_value && outer->key == KEY_FABRIC;
    reader->depth++;
    *innermost(reader) = (struct level){.object = object, .fabric = fabric};
}

/* The next string that is the member `material` of a member `fabric`. */
static bool next_name(struct reader *reader, struct span *name) {
    while (reader->at < reader->end) {
        struct level *level = innermost(reader);
        char c = *reader->at++;
        if (c == '{' || c == '[') {
            open_level(reader, c == '{');
        } else if (c == '}' || c == ']') {
            reader->depth -= reader->depth > 0;
        } else if (c == ':' || c == ',') {
            level->in_value = c == ':';
        } else if (c == '"') {
            *name = take_string(reader);
            if (!level->in_value)
                level->key = key_of(*name);
            else if (level->object && level->fabric && level->key == KEY_MATERIAL)
                return true;
        }
    }
    return false;
}

bool api_material_mentioned(const char *request, size_t length) {
    static const char key[] = "\"material\"";
    return memmem(request, length, key, strlen(key)) != NULL;
}

/* Whether the lines have one that is the name. */
static bool has_line(const struct api_text *lines, struct span name) {
    size_t length = (size_t)(name.to - name.from);
    for (size_t at = 0; at < lines->length;) {
        const char *line = lines->bytes + at;
        size_t size = (size_t)((const char *)memchr(line, '\n', lines->length - at) - line);
        if (size == length && memcmp(line, name.from, length) == 0)
            return true;
        at += size + 1;
    }
    return false;
}

const char *api_material_wanted(const char *request, size_t length, struct arena *arena) {
    struct reader reader = {.at = request, .end = request + length};
    struct api_text lines = api_text_growing(arena);
    struct span name;
    for (int count = 0; count < WANTED_MAX && next_name(&reader, &name);) {
        size_t size = (size_t)(name.to - name.from);
        if (!is_name(name.from, size) || find(name.from, size) || has_line(&lines, name))
            continue;
        api_text_bytes(&lines, name.from, size);
        api_text_raw(&lines, "\n");
        count++;
    }
    return api_text_finish(&lines);
}

/* The document of that name; empty when there is none. */
static struct span document_of(struct span name, const char *own, size_t own_length) {
    static const char head[] = "{\"name\":\"";
    const size_t before = strlen(head), size = (size_t)(name.to - name.from);
    const struct api_material *material = find(name.from, size);
    if (material)
        return (struct span){material->json, material->json + material->length};
    for (const char *at = own, *end = own + own_length; at < end;) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        if ((size_t)(stop - at) > before + size && memcmp(at, head, before) == 0 &&
            memcmp(at + before, name.from, size) == 0 && at[before + size] == '"')
            return (struct span){at, stop};
        at = stop + (stop < end);
    }
    return (struct span){own, own};
}

const char *api_material_fill(const char *request, size_t length, const char *own,
                              size_t own_length, struct arena *arena, size_t *filled) {
    struct reader reader = {.at = request, .end = request + length};
    struct api_text text = api_text_growing(arena);
    const char *done = request;
    struct span name;
    while (next_name(&reader, &name)) {
        struct span document = document_of(name, own, own_length);
        if (document.from == document.to || reader.at <= name.to)
            continue;
        api_text_bytes(&text, done, (size_t)(name.from - 1 - done));
        api_text_bytes(&text, document.from, (size_t)(document.to - document.from));
        done = reader.at;
    }
    api_text_bytes(&text, done, (size_t)(request + length - done));
    *filled = text.length;
    return api_text_finish(&text);
}
