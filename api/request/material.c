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

/* ---- the library ---- */

const struct api_material *api_material_at(size_t index) {
    return index < sizeof materials / sizeof *materials ? &materials[index] : NULL;
}

const struct api_material *material_find(const char *name, size_t length) {
    const struct api_material *material;
    for (size_t k = 0; (material = api_material_at(k)); k++)
        if (strlen(material->name) == length && memcmp(material->name, name, length) == 0)
            return material;
    return NULL;
}

const struct api_material *api_material_named(const char *name) {
    return material_find(name, strlen(name));
}

const char *api_materials_heads(void) {
    return materials_heads;
}

/* ---- a document ---- */

static const struct value_range locking_angles = {0, 90, false}; /* deg */
static const struct value_range limit_shears = {-90, 90, false}; /* deg */
static const struct value_range severities = {0, 1, false}, slides = {0, 1, false};
static const struct value_range moduli = {1, 1e13, false}; /* Pa */
static const struct value_range poissons = {-1, 10, false};
static const struct value_range law_factors = {1e-12, 1e3, false}; /* a */
static const struct value_range law_exponents = {1e-3, 10, false}; /* b */

/* One angle, or one for each sign of the shear. */
static void decode_locking(const struct json_value *json, double angle_deg[2]) {
    static const char *const keys[] = {"positive", "negative", NULL};
    if (value_type(json) == VALUE_OBJECT && value_object(json, keys)) {
        struct json_value positive = value_member(json, keys[0]);
        struct json_value negative = value_member(json, keys[1]);
        value_number(&positive, locking_angles, &angle_deg[0]);
        value_number(&negative, locking_angles, &angle_deg[1]);
    } else if (value_type(json) == VALUE_NUMBER) {
        if (value_number(json, locking_angles, &angle_deg[0]))
            angle_deg[1] = angle_deg[0];
    } else if (value_type(json) != VALUE_OBJECT) {
        value_fault(json, "must be a number or {\"positive\", \"negative\"}");
    }
}

/* The severity must not fall where the shear grows, to either side of 0. */
static void decode_limit_curve(const struct json_value *json, struct api_limit_curve *curve) {
    static const char *const keys[] = {"shear_deg", "severity", NULL};
    struct json_value shear = value_member(json, keys[0]), severity = value_member(json, keys[1]);
    struct api_limit_curve own = {0};
    size_t count;
    if (!value_object(json, keys) ||
        !value_numbers(&shear, limit_shears, 2, &own.shear_deg, &own.rows) ||
        !decode_rising(&shear, own.shear_deg, own.rows) ||
        !value_numbers(&severity, severities, 2, &own.severity, &count))
        return;
    if (count != own.rows) {
        value_fault(&severity, "must have as many values as shear_deg");
        return;
    }
    for (size_t k = 1; k < own.rows; k++) {
        double rise = own.severity[k] - own.severity[k - 1];
        bool from_zero = own.shear_deg[k - 1] >= 0, to_zero = own.shear_deg[k] <= 0;
        struct json_value at = value_element(&severity, k);
        if (from_zero && rise < 0)
            value_fault(&at,
                        "must not be less than the value before it: severity rises with the shear");
        else if (to_zero && rise > 0)
            value_fault(&at, "must not be greater than the value before it: severity rises with "
                             "the shear to either side of 0");
        else if (!from_zero && !to_zero)
            value_fault(&shear, "must have the angle 0 between negative and positive ones");
        else
            continue;
        return;
    }
    *curve = own;
}

/* How the fabric gives way: by its name, or by how much its weft slides along warp. */
static void decode_kinematics(const struct json_value *json, double *slide) {
    static const char *const names[] = {"pin_jointed", "parallel_fibers"};
    static const char *const keys[] = {"slide", NULL};
    struct json_value share = value_member(json, "slide");
    const char *name = "";
    bool named = value_type(json) == VALUE_STRING && value_string(json, &name);
    for (int k = 0; k < 2; k++)
        if (strcmp(name, names[k]) == 0) {
            *slide = k;
            return;
        }
    if (named || value_type(json) != VALUE_OBJECT)
        value_fault(json, "must be \"pin_jointed\", \"parallel_fibers\" or {\"slide\": 0..1}");
    else if (value_object(json, keys))
        value_number(&share, slides, slide);
}

/* A unidirectional layer of the fabric's yarns and their resin. */
static void decode_lamina(const struct json_value *json, struct lamina *lamina) {
    static const char *const keys[] = {"e1", "e2", "nu12", "g12", NULL};
    struct lamina own = {0};
    double *const values[] = {&own.e1, &own.e2, &own.nu12, &own.g12};
    bool good = value_object(json, keys);
    for (int k = 0; good && k < 4; k++) {
        struct json_value value = value_member(json, keys[k]);
        good = value_number(&value, k == 2 ? poissons : moduli, values[k]);
    }
    if (good && !lamina_is_sound(&own))
        value_fault(json, "must have a nu12 below the square root of e1 / e2");
    else if (good)
        *lamina = own;
}

void decode_figures(const struct json_value *json, double metres, struct api_request *request) {
    struct json_value thickness = value_member(json, "thickness");
    struct json_value fraction = value_member(json, "fiber_volume_fraction");
    struct json_value locking = value_member(json, "locking_angle_deg");
    struct json_value limit = value_member(json, "limit_curve");
    struct json_value kinematics = value_member(json, "kinematics");
    struct json_value balance = value_member(json, "balance");
    struct json_value lamina = value_member(json, "lamina");
    struct api_fabric *fabric = &request->fabric;
    if (value_given(&thickness) && value_number(&thickness, decode_lengths, &fabric->thickness)) {
        if (metres != request->length_unit->metres)
            fabric->thickness *= metres / request->length_unit->metres;
        fabric->material = NULL;
    }
    if (value_given(&fraction))
        value_number(&fraction, decode_fractions, &fabric->fiber_volume_fraction);
    if (value_given(&locking))
        decode_locking(&locking, fabric->locking_angle_deg);
    if (value_given(&limit))
        decode_limit_curve(&limit, &fabric->limit);
    if (value_given(&kinematics))
        decode_kinematics(&kinematics, &request->settings.slide);
    if (value_given(&balance))
        value_number(&balance, decode_fractions, &fabric->balance);
    if (value_given(&lamina))
        decode_lamina(&lamina, &fabric->lamina);
}

void decode_compaction(const struct json_value *json, struct api_compaction *law) {
    static const char *const keys[] = {"a", "b", NULL};
    struct json_value a = value_member(json, "a"), b = value_member(json, "b");
    if (!value_object(json, keys))
        return;
    value_number(&a, law_factors, &law->a);
    value_number(&b, law_exponents, &law->b);
}

void decode_material(const struct json_value *json, struct api_request *request) {
    static const char *const keys[] = {"name",         "about",  "source",       "example",
                                       "areal_weight", "fabric", "permeability", "compaction",
                                       "price",        NULL};
    static const char *const fabric_keys[] = {"thickness",
                                              "fiber_volume_fraction",
                                              "locking_angle_deg",
                                              "limit_curve",
                                              "kinematics",
                                              "balance",
                                              "lamina",
                                              NULL};
    struct json_value fabric = value_member(json, "fabric");
    struct json_value permeability = value_member(json, "permeability");
    struct json_value weight = value_member(json, "areal_weight");
    struct json_value price = value_member(json, "price");
    struct json_value law = value_member(json, "compaction");
    if (!value_object(json, keys) || !value_object(&fabric, fabric_keys))
        return;
    decode_figures(&fabric, 1, request);
    if (value_given(&weight))
        value_number(&weight, decode_areal_weights, &request->fabric.areal_weight);
    if (value_given(&price))
        value_number(&price, decode_prices, &request->fabric.price);
    if (value_given(&permeability))
        decode_permeability(&permeability, &request->permeability);
    if (value_given(&law))
        decode_compaction(&law, &request->fabric.compaction);
}

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

static void write_material_head(struct api_text *text, const struct head *head, bool listed) {
    if (head->name)
        api_text_key_string(text, "name", head->name);
    if (head->about || listed)
        api_text_key_string(text, "about", head->about ? head->about : "");
    if (head->source || listed)
        api_text_key_string(text, "source", head->source ? head->source : "");
    api_text_key(text, "example");
    api_text_raw(text, head->example ? "true" : "false");
}

/* Its figures in its own unit. */
static struct api_request read_figures(const struct json_value *json) {
    struct api_request figures = {.length_unit = &api_units[0],
                                  .fabric = {.locking_angle_deg = {-1, -1}},
                                  .permeability = {.model = API_PERMEABILITY_NONE}};
    decode_material(json, &figures);
    return figures;
}

static void write_material(const struct json_value *json, const struct head *head,
                           const struct api_request *figures, struct api_material *material) {
    struct api_text text = api_text_growing(json->tree->arena);
    api_text_raw(&text, "{");
    write_material_head(&text, head, false);
    const struct api_fabric *fabric = &figures->fabric;
    if (fabric->areal_weight > 0)
        api_text_key_number(&text, "areal_weight", fabric->areal_weight);
    if (fabric->price > 0)
        api_text_key_number(&text, "price", fabric->price);
    api_text_key_object(&text, "fabric");
    if (fabric->thickness > 0)
        api_text_key_number(&text, "thickness", fabric->thickness);
    if (fabric->fiber_volume_fraction > 0)
        api_text_key_number(&text, "fiber_volume_fraction", fabric->fiber_volume_fraction);
    api_normalise_shear_limits(&text, fabric);
    api_normalise_kinematics(&text, figures->settings.slide);
    api_normalise_yarns(&text, fabric);
    api_text_raw(&text, "}");
    api_normalise_permeability(&text, &figures->permeability);
    api_normalise_compaction(&text, &fabric->compaction);
    api_text_raw(&text, "}");
    *material = (struct api_material){.length = text.length};
    material->json = api_text_finish(&text);
    if (!material->json)
        api_problem_no_memory(json->tree->problem, "the material");
}

bool material_read(const struct json_value *json, struct api_material *material) {
    struct head head;
    struct api_request figures = read_figures(json);
    read_head(json, &head);
    write_material(json, &head, &figures, material);
    return json->tree->problem->id == API_OK;
}

bool material_is_name(const char *text, size_t length) {
    bool good = length > 0 && length < API_MATERIAL_NAME_SIZE && *text != '.';
    for (size_t k = 0; good && k < length; k++)
        good = (text[k] >= 'a' && text[k] <= 'z') || (text[k] >= 'A' && text[k] <= 'Z') ||
               (text[k] >= '0' && text[k] <= '9') || strchr("-_.", text[k]);
    return good;
}

enum api_problem_id api_material_decode(const char *bytes, size_t length,
                                        const struct api_limits *limits, struct arena *arena,
                                        struct api_material *material, const char **list,
                                        struct api_problem *problem) {
    struct json_tree tree;
    if (json_tree_parse(&tree, bytes, length, limits, arena, problem) != API_OK)
        return problem->id;
    struct json_value root = value_root(&tree), name = value_member(&root, "name");
    struct json_value weight = value_member(&root, "areal_weight");
    struct api_request figures = read_figures(&root);
    struct api_text text = api_text_growing(arena);
    struct head head = {0};
    *list = NULL;
    if (value_type(&root) == VALUE_OBJECT) {
        read_head(&root, &head);
        if (!head.name || !material_is_name(head.name, strlen(head.name)))
            value_fault(&name, "must have 1 to %d letters, digits, '-', '_' and '.', no '.' first",
                        API_MATERIAL_NAME_SIZE - 1);
        else if (api_material_named(head.name))
            value_fault(&name, "is a name of the library: choose another name");
        /* The fibre that the figures speak of: its areal weight fills that share of the thickness.
         */
        const struct api_fabric *fabric = &figures.fabric;
        double volume = fabric->thickness * fabric->fiber_volume_fraction;
        double density = volume > 0 ? fabric->areal_weight / volume : 0;
        if (density > 0 && (density < density_least || density > density_most))
            value_fault(
                &weight,
                "with the thickness and the fibre volume fraction this gives fibres of %.3g kg/m3: "
                "areal_weight is in kg/m2, fabric.thickness in m",
                density);
    }
    if (problem->id == API_OK) {
        write_material(&root, &head, &figures, material);
        api_text_raw(&text, "{");
        write_material_head(&text, &head, true);
        api_text_raw(&text, ",\"own\":true}");
        *list = api_text_finish(&text);
        char *copy = json_tree_alloc(&tree, strlen(head.name) + 1, 1);
        if (copy)
            material->name = strcpy(copy, head.name);
    }
    json_tree_free(&tree);
    if (problem->id == API_OK && !*list)
        api_problem_no_memory(problem, "the material");
    return problem->id;
}
