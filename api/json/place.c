/* SPDX-License-Identifier: MIT */
#include "place.h"

#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* With the array that the value is a mark of, if it is one. */
static struct tree_place unpack(struct tree_place place) {
    const char *string = json_string_value(place.value);
    const struct numbers_array *array = string ? numbers_find(&place.tree->numbers, string) : NULL;
    if (array)
        place.packed = (struct tree_packed){array->values, array->rows, array->width};
    return place;
}

struct tree_place tree_root(const struct tree *tree) {
    return unpack((struct tree_place){.tree = tree, .value = tree->root});
}

struct tree_place tree_member(const struct tree_place *parent, const char *key) {
    return unpack((struct tree_place){.tree = parent->tree,
                                      .parent = parent,
                                      .key = key,
                                      .value = json_object_get(parent->value, key)});
}

struct tree_place tree_element(const struct tree_place *parent, size_t index) {
    struct tree_place place = {.tree = parent->tree, .parent = parent, .index = index};
    const struct tree_packed *packed = &parent->packed;
    size_t width = packed->width ? packed->width : 1;
    if (index < packed->rows)
        place.packed = (struct tree_packed){packed->values + index * width, packed->width, 0};
    else
        place.value = json_array_get(parent->value, index);
    return unpack(place);
}

enum tree_type tree_type(const struct tree_place *place) {
    static const enum tree_type types[] = {
        [JSON_OBJECT] = TREE_OBJECT,  [JSON_ARRAY] = TREE_ARRAY, [JSON_STRING] = TREE_STRING,
        [JSON_INTEGER] = TREE_NUMBER, [JSON_REAL] = TREE_NUMBER, [JSON_TRUE] = TREE_BOOLEAN,
        [JSON_FALSE] = TREE_BOOLEAN,  [JSON_NULL] = TREE_NULL,
    };
    if (place->packed.values)
        return place->packed.rows ? TREE_ARRAY : TREE_NUMBER;
    return place->value ? types[json_typeof(place->value)] : TREE_MISSING;
}

size_t tree_length(const struct tree_place *place) {
    return place->packed.rows + json_array_size(place->value) + json_object_size(place->value);
}

/* Of a place that is a number. */
static double number_at(const struct tree_place *place) {
    return place->packed.values ? *place->packed.values : json_number_value(place->value);
}

/* Appends `/key` to a pointer of API_POINTER_MAX bytes, `~` and `/` escaped, cut when it is full.
 */
static size_t append_key(char *pointer, size_t length, const char *key) {
    const size_t last = API_POINTER_MAX - 1;
    if (length < last)
        pointer[length++] = '/';
    for (; *key && length + 1 < last; key++) {
        bool escape = *key == '~' || *key == '/';
        if (escape)
            pointer[length++] = '~';
        pointer[length++] = !escape ? *key : *key == '~' ? '0' : '1';
    }
    pointer[length] = '\0';
    return length;
}

static size_t write_pointer(const struct tree_place *place, char *pointer) {
    pointer[0] = '\0';
    if (!place->parent)
        return 0;
    size_t length = write_pointer(place->parent, pointer);
    char index[24];
    snprintf(index, sizeof index, "%zu", place->index);
    return append_key(pointer, length, place->key ? place->key : index);
}

void tree_fault(const struct tree_place *place, const char *detail, ...) {
    char pointer[API_POINTER_MAX], text[API_DETAIL_MAX];
    write_pointer(place, pointer);
    va_list list;
    va_start(list, detail);
    vsnprintf(text, sizeof text, detail, list);
    va_end(list);
    api_problem_add(place->tree->problem, pointer, "%s", text);
}

/* Whether the value has the type; else reports what it must be. */
static bool check_type(const struct tree_place *place, enum tree_type type, const char *noun) {
    if (tree_type(place) == type)
        return true;
    if (tree_given(place))
        tree_fault(place, "must be %s", noun);
    else
        tree_fault(place, "is required: %s", noun);
    return false;
}

static bool is_listed(const char *key, const char *const keys[]) {
    while (*keys && strcmp(key, *keys) != 0)
        keys++;
    return *keys != NULL;
}

bool tree_object(const struct tree_place *place, const char *const keys[]) {
    if (!check_type(place, TREE_OBJECT, "an object"))
        return false;
    /* jansson iterates over mutable objects only; nothing is changed here. */
    union {
        const json_t *constant;
        json_t *mutable;
    } object = {place->value};
    const char *key;
    json_t *value;
    json_object_foreach(object.mutable, key, value) {
        struct tree_place member = tree_member(place, key);
        if (!is_listed(key, keys))
            tree_fault(&member, "is not a key that is known here");
    }
    return true;
}

bool tree_array(const struct tree_place *place, size_t least) {
    if (!check_type(place, TREE_ARRAY, "an array"))
        return false;
    if (tree_length(place) >= least)
        return true;
    tree_fault(place, "must have at least %zu elements", least);
    return false;
}

bool tree_string(const struct tree_place *place, const char **value) {
    if (!check_type(place, TREE_STRING, "a string"))
        return false;
    *value = json_string_value(place->value);
    return true;
}

/* "a", "b" or "c" */
static void list_names(char *text, size_t size, const char *const names[], size_t count) {
    size_t length = 0;
    for (size_t i = 0; i < count && length < size; i++) {
        const char *before = i == 0 ? "" : i + 1 == count ? " or " : ", ";
        length += (size_t)snprintf(text + length, size - length, "%s\"%s\"", before, names[i]);
    }
}

bool tree_choice(const struct tree_place *place, const char *const names[], size_t count,
                 int *value) {
    char allowed[API_DETAIL_MAX / 2] = "";
    list_names(allowed, sizeof allowed, names, count);
    if (!check_type(place, TREE_STRING, allowed))
        return false;
    for (size_t i = 0; i < count; i++) {
        if (strcmp(json_string_value(place->value), names[i]) == 0) {
            *value = (int)i;
            return true;
        }
    }
    tree_fault(place, "must be %s", allowed);
    return false;
}

static bool in_range(struct tree_range range, double value) {
    return range.open ? value > range.low && value < range.high
                      : value >= range.low && value <= range.high;
}

static void fault_range(const struct tree_place *place, const char *what, struct tree_range range) {
    tree_fault(place, "must be %s %s %g and %g", what, range.open ? "strictly between" : "between",
               range.low, range.high);
}

bool tree_number(const struct tree_place *place, struct tree_range range, double *value) {
    if (!check_type(place, TREE_NUMBER, "a number"))
        return false;
    double number = number_at(place);
    if (!in_range(range, number)) {
        fault_range(place, "a number", range);
        return false;
    }
    *value = number + 0.0; /* -0 becomes 0: they are the same in every request */
    return true;
}

bool tree_integer(const struct tree_place *place, int low, int high, int *value) {
    if (!check_type(place, TREE_NUMBER, "a whole number"))
        return false;
    struct tree_range range = {low, high, false};
    double number = number_at(place);
    if (!in_range(range, number) || number != floor(number)) {
        tree_fault(place, "must be a whole number between %d and %d", low, high);
        return false;
    }
    *value = (int)number;
    return true;
}

bool tree_boolean(const struct tree_place *place, bool *value) {
    enum tree_type type = tree_type(place);
    double number = type == TREE_NUMBER ? number_at(place) : 0;
    if (type != TREE_BOOLEAN && (type != TREE_NUMBER || (number != 0 && number != 1))) {
        tree_fault(place, "must be true or false");
        return false;
    }
    *value = json_is_true(place->value) || number == 1;
    return true;
}

bool tree_vector(const struct tree_place *place, struct tree_range range, size_t count,
                 double *values) {
    if (tree_type(place) != TREE_ARRAY || tree_length(place) != count) {
        tree_fault(place,
                   tree_given(place) ? "must be an array of %zu numbers"
                                     : "is required: an array of %zu numbers",
                   count);
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        struct tree_place element = tree_element(place, i);
        if (!tree_number(&element, range, &values[i]))
            return false;
    }
    return true;
}

bool tree_numbers(const struct tree_place *place, struct tree_range range, size_t least,
                  const double **values, size_t *count) {
    if (!tree_array(place, least))
        return false;
    size_t length = tree_length(place);
    double *numbers = tree_alloc(place->tree, length, sizeof *numbers);
    if (!numbers || !tree_vector(place, range, length, numbers))
        return false;
    *values = numbers;
    *count = length;
    return true;
}

bool tree_rows(const struct tree_place *place, struct tree_range range, size_t width, size_t least,
               double **values, size_t *count) {
    if (!tree_array(place, least))
        return false;
    size_t length = tree_length(place);
    double *rows = tree_alloc(place->tree, length, width * sizeof *rows);
    if (!rows)
        return false;
    for (size_t i = 0; i < length; i++) {
        struct tree_place row = tree_element(place, i);
        if (!tree_vector(&row, range, width, rows + i * width))
            return false;
    }
    *values = rows;
    *count = length;
    return true;
}

void *tree_alloc(const struct tree *tree, size_t count, size_t size) {
    void *memory = arena_alloc(tree->arena, count, size);
    if (!memory)
        api_problem_set(tree->problem, API_OUT_OF_MEMORY, "the document needs too much memory");
    return memory;
}
