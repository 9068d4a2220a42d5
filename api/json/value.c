/* SPDX-License-Identifier: MIT */
#include "value.h"

#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* With the array that the value is a mark of, if it is one. */
static struct json_value unpack_marked(struct json_value json) {
    const char *string = json_string_value(json.value);
    const struct numbers_array *array = string ? numbers_find(&json.tree->numbers, string) : NULL;
    if (array)
        json.packed = (struct value_packed){array->values, array->rows, array->width};
    return json;
}

struct json_value value_root(const struct json_tree *tree) {
    return unpack_marked((struct json_value){.tree = tree, .value = tree->root});
}

struct json_value value_member(const struct json_value *parent, const char *key) {
    return unpack_marked((struct json_value){.tree = parent->tree,
                                             .parent = parent,
                                             .key = key,
                                             .value = json_object_get(parent->value, key)});
}

struct json_value value_element(const struct json_value *parent, size_t index) {
    struct json_value json = {.tree = parent->tree, .parent = parent, .index = index};
    const struct value_packed *packed = &parent->packed;
    size_t width = packed->width ? packed->width : 1;
    if (index < packed->rows)
        json.packed = (struct value_packed){packed->values + index * width, packed->width, 0};
    else
        json.value = json_array_get(parent->value, index);
    return unpack_marked(json);
}

enum value_type value_type(const struct json_value *json) {
    static const enum value_type types[] = {
        [JSON_OBJECT] = VALUE_OBJECT,  [JSON_ARRAY] = VALUE_ARRAY, [JSON_STRING] = VALUE_STRING,
        [JSON_INTEGER] = VALUE_NUMBER, [JSON_REAL] = VALUE_NUMBER, [JSON_TRUE] = VALUE_BOOLEAN,
        [JSON_FALSE] = VALUE_BOOLEAN,  [JSON_NULL] = VALUE_NULL,
    };
    if (json->packed.values)
        return json->packed.rows ? VALUE_ARRAY : VALUE_NUMBER;
    return json->value ? types[json_typeof(json->value)] : VALUE_MISSING;
}

size_t value_length(const struct json_value *json) {
    return json->packed.rows + json_array_size(json->value) + json_object_size(json->value);
}

/* Of a value that is a number. */
static double number_at(const struct json_value *json) {
    return json->packed.values ? *json->packed.values : json_number_value(json->value);
}

/* The pointer to a value, of API_POINTER_MAX bytes, `~` and `/` in keys escaped, cut when it is
 * full. Returns its length. */
static size_t write_pointer(const struct json_value *json, char *pointer) {
    const size_t last = API_POINTER_MAX - 1;
    char index[24];
    pointer[0] = '\0';
    if (!json->parent)
        return 0;
    size_t length = write_pointer(json->parent, pointer);
    snprintf(index, sizeof index, "%zu", json->index);
    if (length < last)
        pointer[length++] = '/';
    for (const char *key = json->key ? json->key : index; *key && length + 1 < last; key++) {
        bool escape = *key == '~' || *key == '/';
        if (escape)
            pointer[length++] = '~';
        pointer[length++] = !escape ? *key : *key == '~' ? '0' : '1';
    }
    pointer[length] = '\0';
    return length;
}

bool value_fault(const struct json_value *json, const char *detail, ...) {
    char pointer[API_POINTER_MAX], text[API_DETAIL_MAX];
    write_pointer(json, pointer);
    va_list list;
    va_start(list, detail);
    vsnprintf(text, sizeof text, detail, list);
    va_end(list);
    return !api_problem_add(json->tree->problem, pointer, "%s", text);
}

/* Whether the value has the type; else reports what it must be. */
static bool check_type(const struct json_value *json, enum value_type type, const char *noun) {
    return value_type(json) == type ||
           value_fault(json, value_given(json) ? "must be %s" : "is required: %s", noun);
}

bool value_object(const struct json_value *json, const char *const keys[]) {
    if (!check_type(json, VALUE_OBJECT, "an object"))
        return false;
    /* jansson iterates over mutable objects only; nothing is changed here. */
    union {
        const json_t *constant;
        json_t *mutable;
    } object = {json->value};
    const char *key;
    json_t *value;
    json_object_foreach(object.mutable, key, value) {
        struct json_value member = value_member(json, key);
        size_t k = 0;
        while (keys[k] && strcmp(key, keys[k]) != 0)
            k++;
        if (!keys[k])
            value_fault(&member, "is not a known key here");
    }
    return true;
}

bool value_array(const struct json_value *json, size_t least) {
    if (!check_type(json, VALUE_ARRAY, "an array"))
        return false;
    return value_length(json) >= least ||
           value_fault(json, "must have at least %zu element%s", least, least == 1 ? "" : "s");
}

bool value_string(const struct json_value *json, const char **value) {
    if (!check_type(json, VALUE_STRING, "a string"))
        return false;
    *value = json_string_value(json->value);
    return true;
}

bool value_choice(const struct json_value *json, const char *const names[], size_t count,
                  int *value) {
    char allowed[API_DETAIL_MAX - 32] = ""; /* the rest is for the words around it */
    size_t length = 0;
    for (size_t i = 0; i < count && length < sizeof allowed; i++) { /* "a", "b" or "c" */
        const char *before = i == 0 ? "" : i + 1 == count ? " or " : ", ";
        length += (size_t)snprintf(allowed + length, sizeof allowed - length, "%s\"%s\"", before,
                                   names[i]);
    }
    if (!check_type(json, VALUE_STRING, allowed))
        return false;
    for (size_t i = 0; i < count; i++) {
        if (strcmp(json_string_value(json->value), names[i]) == 0) {
            *value = (int)i;
            return true;
        }
    }
    return value_fault(json, "must be %s", allowed);
}

static bool value_in_range(struct value_range range, double value) {
    return range.open ? value > range.low && value < range.high
                      : value >= range.low && value <= range.high;
}

bool value_number(const struct json_value *json, struct value_range range, double *value) {
    if (!check_type(json, VALUE_NUMBER, "a number"))
        return false;
    double number = number_at(json);
    if (!value_in_range(range, number))
        return value_fault(json, "must be a number %s %g and %g",
                           range.open ? "strictly between" : "between", range.low, range.high);
    *value = number + 0.0; /* -0 becomes 0: they are the same in every request */
    return true;
}

bool value_integer(const struct json_value *json, int low, int high, int *value) {
    if (!check_type(json, VALUE_NUMBER, "a whole number"))
        return false;
    struct value_range range = {low, high, false};
    double number = number_at(json);
    if (!value_in_range(range, number) || number != floor(number))
        return value_fault(json, "must be a whole number between %d and %d", low, high);
    *value = (int)number;
    return true;
}

bool value_boolean(const struct json_value *json, bool *value) {
    enum value_type type = value_type(json);
    double number = type == VALUE_NUMBER ? number_at(json) : 0;
    if (type != VALUE_BOOLEAN && (type != VALUE_NUMBER || (number != 0 && number != 1)))
        return value_fault(json, "must be true or false");
    *value = json_is_true(json->value) || number == 1;
    return true;
}

bool value_vector(const struct json_value *json, struct value_range range, size_t count,
                  double *values) {
    if (value_type(json) != VALUE_ARRAY || value_length(json) != count)
        return value_fault(json,
                           value_given(json) ? "must be an array of %zu numbers"
                                             : "is required: an array of %zu numbers",
                           count);
    for (size_t i = 0; i < count; i++) {
        struct json_value element = value_element(json, i);
        if (!value_number(&element, range, &values[i]))
            return false;
    }
    return true;
}

bool value_numbers(const struct json_value *json, struct value_range range, size_t least,
                   const double **values, size_t *count) {
    if (!value_array(json, least))
        return false;
    size_t length = value_length(json);
    double *numbers = json_tree_alloc(json->tree, length, sizeof *numbers);
    if (!numbers || !value_vector(json, range, length, numbers))
        return false;
    *values = numbers;
    *count = length;
    return true;
}

bool value_rows(const struct json_value *json, struct value_range range, size_t width, size_t least,
                double **values, size_t *count) {
    if (!value_array(json, least))
        return false;
    size_t length = value_length(json);
    double *rows = json_tree_alloc(json->tree, length, width * sizeof *rows);
    if (!rows)
        return false;
    for (size_t i = 0; i < length; i++) {
        struct json_value row = value_element(json, i);
        if (!value_vector(&row, range, width, rows + i * width))
            return false;
    }
    *values = rows;
    *count = length;
    return true;
}

void *json_tree_alloc(const struct json_tree *tree, size_t count, size_t size) {
    void *memory = arena_alloc(tree->arena, count, size);
    if (!memory)
        api_problem_no_memory(tree->problem, "the document");
    return memory;
}
