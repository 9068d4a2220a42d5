/* SPDX-License-Identifier: MIT */
/* Arrays of numbers that are taken out of a document: whatever is in it, reading it and what is
 * said of its faults are the same as without. */
#include "api/json/numbers.h"
#include "api/json/value.h"
#include "api/limits.h"
#include "api/run.h"
#include "tests/check.h"
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DOCUMENTS = 20000, ROOM = 1 << 16, MEMORY = 1 << 26 };

/* ------------------------------------------------------------------ random documents */

static unsigned long state = 20261121;

static unsigned random_below(unsigned end) {
    state = state * 6364136223846793005UL + 1442695040888963407UL;
    return (unsigned)(state >> 33) % end;
}

struct text {
    char bytes[ROOM];
    size_t length;
};

static void put(struct text *text, const char *more) {
    size_t length = strlen(more);
    if (text->length + length < ROOM) {
        memcpy(text->bytes + text->length, more, length);
        text->length += length;
    }
}

static void put_number(struct text *text) {
    static const char *const odd[] = {
        "0",     "-0",       "1e5",  "-1.5E-7", "0.1",
        "1e400", "1e-400",   "01",   "1.",      ".5",
        "+1",    "4.9e-324", "1E+2", "-",       "12345678901234567890",
        "null",  "\"a\""};
    char number[32];
    if (random_below(40) == 0) {
        put(text, odd[random_below(sizeof odd / sizeof *odd)]);
        return;
    }
    snprintf(number, sizeof number, "%.*g", 1 + (int)random_below(17),
             ((double)random_below(1u << 30) - (1 << 29)) / (1 + random_below(100000)));
    put(text, number);
}

static const char *blank(void) {
    static const char *const blanks[] = {"", "", "", " ", "\n", "\t ", "\r\n"};
    return blanks[random_below(7)];
}

static void put_array(struct text *text, unsigned count, unsigned width) {
    put(text, "[");
    for (unsigned k = 0; k < count; k++) {
        put(text, k ? "," : "");
        put(text, blank());
        if (width)
            put_array(text, random_below(60) ? width : width + 1, 0);
        else
            put_number(text);
        put(text, blank());
    }
    put(text, "]");
}

static void put_value(struct text *text, unsigned depth) {
    char key[16];
    switch (random_below(depth < 4 ? 6 : 4)) {
    case 0:
        put_number(text);
        break;
    case 1:
        put(text, random_below(2) ? "\"a\\\"[1,2]\\u0001\"" : "\"\\u00e9\\u4e2d[\"");
        break;
    case 2:
        put_array(text, random_below(40), 0);
        break;
    case 3:
        put_array(text, random_below(20), 1 + random_below(4));
        break;
    default:
        put(text, "{");
        for (unsigned k = 0, n = random_below(4); k < n; k++) {
            snprintf(key, sizeof key, "%s\"k%u\":", k ? "," : "", k);
            put(text, key);
            put_value(text, depth + 1);
            put(text, blank());
        }
        put(text, "}");
    }
}

/* ------------------------------------------------------------------ the same document twice */

static void assert_same(const struct json_value *place, const json_t *value) {
    switch (json_typeof(value)) {
    case JSON_OBJECT: {
        const char *key;
        json_t *member;
        json_object_foreach((json_t *)(uintptr_t)value, key, member) {
            struct json_value inner = value_member(place, key);
            assert_same(&inner, member);
        }
        assert_int_equal(value_type(place), VALUE_OBJECT);
        break;
    }
    case JSON_ARRAY:
        assert_int_equal(value_type(place), VALUE_ARRAY);
        assert_int_equal(value_length(place), json_array_size(value));
        for (size_t k = 0; k < json_array_size(value); k++) {
            struct json_value inner = value_element(place, k);
            assert_same(&inner, json_array_get(value, k));
        }
        assert_false(value_given(
            &(struct json_value){value_element(place, json_array_size(value)).tree, NULL, NULL, 0,
                                 value_element(place, json_array_size(value)).value,
                                 value_element(place, json_array_size(value)).packed}));
        break;
    case JSON_STRING: {
        const char *string;
        assert_true(value_string(place, &string));
        assert_string_equal(string, json_string_value(value));
        break;
    }
    case JSON_REAL: {
        double number;
        assert_true(value_number(place, (struct value_range){-1e308, 1e308, false}, &number));
        assert_true(number == json_real_value(value));
        break;
    }
    default:
        assert_int_equal(value_type(place), json_is_null(value) ? VALUE_NULL : VALUE_BOOLEAN);
    }
}

/* Whether it could be parsed. */
static bool compare(const char *bytes, size_t length, size_t *packed) {
    struct arena *arena = arena_new(MEMORY);
    struct api_problem problem = {0};
    struct json_tree tree;
    json_error_t error;
    struct api_limits limits = api_limits_default;
    json_t *value = json_loadb(
        bytes, length, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL | JSON_DECODE_ANY, &error);
    enum api_problem_id id = json_tree_parse(&tree, bytes, length, &limits, arena, &problem);
    assert_true(!value == (id != API_OK));
    if (value) {
        struct json_value root = value_root(&tree);
        assert_same(&root, value);
        *packed += tree.numbers.count;
    } else if (id == API_MALFORMED_JSON) {
        char detail[API_DETAIL_MAX];
        for (char *c = error.text; *c; c++)
            *c = *c < ' ' || *c > '~' ? '?' : *c;
        snprintf(detail, sizeof detail, "line %d, column %d: %s", error.line, error.column,
                 error.text);
        if (strcmp(problem.error[0].detail, detail) != 0)
            fail_msg("%s, not %s:\n%.*s", problem.error[0].detail, detail, (int)length, bytes);
    } else {
        assert_int_equal(json_error_code(&error), json_error_numeric_overflow);
    }
    json_tree_free(&tree);
    json_decref(value);
    arena_free(arena);
    return value != NULL;
}

static void test_numbers_random_documents(void **context) {
    (void)context;
    static struct text text;
    size_t good = 0, packed = 0;
    print_message("seed %lu\n", state);
    for (int k = 0; k < DOCUMENTS; k++) {
        text.length = 0;
        put_value(&text, 0);
        good += compare(text.bytes, text.length, &packed);
        if (text.length == 0)
            continue;
        text.bytes[random_below((unsigned)text.length)] = (char)random_below(128);
        good += compare(text.bytes, text.length, &packed);
    }
    print_message("%zu good documents with %zu arrays taken out\n", good, packed);
    check_above(good, DOCUMENTS / 2);
    check_above(packed, DOCUMENTS / 8);
}

/* A string that looks like a mark is a string. */
static void test_numbers_marks_cannot_be_written(void **context) {
    (void)context;
    size_t packed = 0;
    const char document[] = "{\"a\":[1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16],"
                            "\"b\":\"\\u00010000000000000000:0\"}";
    assert_true(compare(document, sizeof document - 1, &packed));
    assert_int_equal(packed, 1);
}

/* A control net of 512 x 512 points takes less than four bytes of memory a byte of text. */
static void test_numbers_memory(void **context) {
    (void)context;
    size_t count = 512 * 512, length = 0;
    char *bytes = malloc(count * 40 + 2);
    assert_non_null(bytes);
    bytes[length++] = '[';
    for (size_t k = 0; k < count; k++)
        length += (size_t)sprintf(bytes + length, "%s[%zu.25,%zu.5,0.123]", k ? "," : "", k, k);
    bytes[length++] = ']';
    struct arena *arena = arena_new(MEMORY);
    struct numbers numbers;
    assert_true(numbers_take_out(bytes, length, arena, &numbers));
    assert_int_equal(numbers.count, 1);
    assert_int_equal(numbers.array[0].rows, count);
    assert_int_equal(numbers.array[0].width, 3);
    check_below(numbers.length, 100);
    print_message("%zu bytes of text, %zu of memory\n", length, arena_peak(arena));
    check_below(arena_peak(arena), 4 * length);
    arena_free(arena);
    free(bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers_random_documents),
        cmocka_unit_test(test_numbers_marks_cannot_be_written),
        cmocka_unit_test(test_numbers_memory),
    };
    return api_prepare() ? cmocka_run_group_tests(tests, NULL, NULL) : 1;
}
