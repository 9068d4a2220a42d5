/* SPDX-License-Identifier: MIT */
#include "place.h"

#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* With the array that the value is a mark of, if it is one. */
static struct json_place unpack(struct json_place place) {
    const char *string = json_string_value(place.value);
    const struct numbers_array *array = string ? numbers_find(&place.tree->numbers, string) : NULL;
    if (array)
        place.packed = (struct place_packed){array->values, array->rows, array->width};
    return place;
}

struct json_place place_root(const struct json_tree *tree) {
    return unpack((struct json_place){.tree = tree, .value = tree->root});
}

struct json_place place_member(const struct json_place *parent, const char *key) {
    return unpack((struct json_place){.tree = parent->tree,
                                      .parent = parent,
                                      .key = key,
                                      .value = json_object_get(parent->value, key)});
}

struct json_place place_element(const struct json_place *parent, size_t index) {
    struct json_place place = {.tree = parent->tree, .parent = parent, .index = index};
    const struct place_packed *packed = &parent->packed;
    size_t width = packed->width ? packed->width : 1;
    if (index < packed->rows)
        place.packed = (struct place_packed){packed->values + index * width, packed->width, 0};
    else
        place.value = json_array_get(parent->value, index);
    return unpack(place);
}

enum place_type place_type(const struct json_place *place) {
    static const enum place_type types[] = {
        [JSON_OBJECT] = PLACE_OBJECT,  [JSON_ARRAY] = PLACE_ARRAY, [JSON_STRING] = PLACE_STRING,
        [JSON_INTEGER] = PLACE_NUMBER, [JSON_REAL] = PLACE_NUMBER, [JSON_TRUE] = PLACE_BOOLEAN,
        [JSON_FALSE] = PLACE_BOOLEAN,  [JSON_NULL] = PLACE_NULL,
    };
    if (place->packed.values)
        return place->packed.rows ? PLACE_ARRAY : PLACE_NUMBER;
    return place->value ? types[json_typeof(place->value)] : PLACE_MISSING;
}

size_t place_length(const struct json_place *place) {
    return place->packed.rows + json_array_size(place->value) + json_object_size(place->value);
}

/* Of a place that is a number. */
static double number_at(const struct json_place *place) {
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

static size_t write_pointer(const struct json_place *place, char *pointer) {
    pointer[0] = '\0';
    if (!place->parent)
        return 0;
    size_t length = write_pointer(place->parent, pointer);
    char index[24];
    snprintf(index, sizeof index, "%zu", place->index);
    return append_key(pointer, length, place->key ? place->key : index);
}

void place_fault(const struct json_place *place, const char *detail, ...) {
    char pointer[API_POINTER_MAX], text[API_DETAIL_MAX];
    write_pointer(place, pointer);
    va_list list;
    va_start(list, detail);
    vsnprintf(text, sizeof text, detail, list);
    va_end(list);
    api_problem_add(place->tree->problem, pointer, "%s", text);
}

/* Whether the value has the type; else reports what it must be. */
static bool check_type(const struct json_place *place, enum place_type type, const char *noun) {
    if (place_type(place) == type)
        return true;
    if (place_given(place))
        place_fault(place, "must be %s", noun);
    else
        place_fault(place, "is required: %s", noun);
    return false;
}

static bool is_listed(const char *key, const char *const keys[]) {
    while (*keys && strcmp(key, *keys) != 0)
        keys++;
    return *keys != NULL;
}

bool place_object(const struct json_place *place, const char *const keys[]) {
    if (!check_type(place, PLACE_OBJECT, "an object"))
        return false;
    /* jansson iterates over mutable objects only; nothing is changed here. */
    union {
        const json_t *constant;
        json_t *mutable;
    } object = {place->value};
    const char *key;
    json_t *value;
    json_object_foreach(object.mutable, key, value) {
        struct json_place member = place_member(place, key);
        if (!is_listed(key, keys))
            place_fault(&member, "is not a key that is known here");
    }
    return true;
}

bool place_array(const struct json_place *place, size_t least) {
    if (!check_type(place, PLACE_ARRAY, "an array"))
        return false;
    if (place_length(place) >= least)
        return true;
    place_fault(place, "must have at least %zu element%s", least, least == 1 ? "" : "s");
    return false;
}

bool place_string(const struct json_place *place, const char **value) {
    if (!check_type(place, PLACE_STRING, "a string"))
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

bool place_choice(const struct json_place *place, const char *const names[], size_t count,
                  int *value) {
    char allowed[API_DETAIL_MAX - 32] = ""; /* the rest is for the words around it */
    list_names(allowed, sizeof allowed, names, count);
    if (!check_type(place, PLACE_STRING, allowed))
        return false;
    for (size_t i = 0; i < count; i++) {
        if (strcmp(json_string_value(place->value), names[i]) == 0) {
            *value = (int)i;
            return true;
        }
    }
    place_fault(place, "must be %s", allowed);
    return false;
}

static bool in_range(struct place_range range, double value) {
    return range.open ? value > range.low && value < range.high
                      : value >= range.low && value <= range.high;
}

static void fault_range(const struct json_place *place, const char *what,
                        struct place_range range) {
    place_fault(place, "must be %s %s %g and %g", what, range.open ? "strictly between" : "between",
                range.low, range.high);
}

bool place_number(const struct json_place *place, struct place_range range, double *value) {
    if (!check_type(place, PLACE_NUMBER, "a number"))
        return false;
    double number = number_at(place);
    if (!in_range(range, number)) {
        fault_range(place, "a number", range);
        return false;
    }
    *value = number + 0.0; /* -0 becomes 0: they are the same in every request */
    return true;
}

bool place_integer(const struct json_place *place, int low, int high, int *value) {
    if (!check_type(place, PLACE_NUMBER, "a whole number"))
        return false;
    struct place_range range = {low, high, false};
    double number = number_at(place);
    if (!in_range(range, number) || number != floor(number)) {
        place_fault(place, "must be a whole number between %d and %d", low, high);
        return false;
    }
    *value = (int)number;
    return true;
}

bool place_boolean(const struct json_place *place, bool *value) {
    enum place_type type = place_type(place);
    double number = type == PLACE_NUMBER ? number_at(place) : 0;
    if (type != PLACE_BOOLEAN && (type != PLACE_NUMBER || (number != 0 && number != 1))) {
        place_fault(place, "must be true or false");
        return false;
    }
    *value = json_is_true(place->value) || number == 1;
    return true;
}

bool place_vector(const struct json_place *place, struct place_range range, size_t count,
                  double *values) {
    if (place_type(place) != PLACE_ARRAY || place_length(place) != count) {
        place_fault(place,
                    place_given(place) ? "must be an array of %zu numbers"
                                       : "is required: an array of %zu numbers",
                    count);
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        struct json_place element = place_element(place, i);
        if (!place_number(&element, range, &values[i]))
            return false;
    }
    return true;
}

bool place_numbers(const struct json_place *place, struct place_range range, size_t least,
                   const double **values, size_t *count) {
    if (!place_array(place, least))
        return false;
    size_t length = place_length(place);
    double *numbers = json_tree_alloc(place->tree, length, sizeof *numbers);
    if (!numbers || !place_vector(place, range, length, numbers))
        return false;
    *values = numbers;
    *count = length;
    return true;
}

bool place_rows(const struct json_place *place, struct place_range range, size_t width,
                size_t least, double **values, size_t *count) {
    if (!place_array(place, least))
        return false;
    size_t length = place_length(place);
    double *rows = json_tree_alloc(place->tree, length, width * sizeof *rows);
    if (!rows)
        return false;
    for (size_t i = 0; i < length; i++) {
        struct json_place row = place_element(place, i);
        if (!place_vector(&row, range, width, rows + i * width))
            return false;
    }
    *values = rows;
    *count = length;
    return true;
}

void *json_tree_alloc(const struct json_tree *tree, size_t count, size_t size) {
    void *memory = arena_alloc(tree->arena, count, size);
    if (!memory)
        api_problem_set(tree->problem, API_OUT_OF_MEMORY, "the document needs too much memory");
    return memory;
}
