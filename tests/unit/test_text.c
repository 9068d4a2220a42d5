/* SPDX-License-Identifier: MIT */
#include "api/json/text.h"

#include "tests/check.h"
#include <jansson.h>
#include <string.h>

static void check_string(const char *string, const char *expected) {
    char buffer[256];
    struct api_text text = api_text_over(buffer, sizeof buffer);
    api_text_string(&text, string);
    assert_string_equal(api_text_finish(&text), expected);
    json_t *value = json_loads(buffer, JSON_DECODE_ANY, NULL);
    assert_non_null(value);
    json_decref(value);
}

static void test_text_escapes_controls_quotes_and_backslashes(void **state) {
    (void)state;
    check_string("", "\"\"");
    check_string("a \"b\" \\c", "\"a \\\"b\\\" \\\\c\"");
    check_string("\t\n\x01\x1f\x7f", "\"\\u0009\\u000a\\u0001\\u001f\\u007f\"");
}

static void test_text_keeps_characters_and_replaces_what_is_none(void **state) {
    (void)state;
    check_string("gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80",
                 "\"gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\x98\x80\"");
    check_string("a\xc3", "\"a\\ufffd\"");                                /* cut */
    check_string("\xc0\xaf", "\"\\ufffd\\ufffd\"");                       /* overlong */
    check_string("\xed\xa0\x80", "\"\\ufffd\\ufffd\\ufffd\"");            /* a surrogate */
    check_string("\xf4\x90\x80\x80", "\"\\ufffd\\ufffd\\ufffd\\ufffd\""); /* beyond Unicode */
    check_string("\x80z\xff", "\"\\ufffdz\\ufffd\"");
}

static void test_text_without_room_has_failed(void **state) {
    (void)state;
    char buffer[8];
    for (size_t room = 0; room <= sizeof buffer; room++) {
        struct api_text text = api_text_over(buffer, room);
        api_text_string(&text, "a\"b\x01");
        assert_null(api_text_finish(&text));
        assert_true(text.failed && text.length <= room);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_text_escapes_controls_quotes_and_backslashes),
        cmocka_unit_test(test_text_keeps_characters_and_replaces_what_is_none),
        cmocka_unit_test(test_text_without_room_has_failed),
    };
    return cmocka_run_group_tests_name("text", tests, NULL, NULL);
}
