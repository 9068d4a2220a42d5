/* SPDX-License-Identifier: MIT */
#include "api/json/locate.h"

#include "support.h"
#include "tests/check.h"
#include <string.h>

/* The pointer of what ends at the mark `^` of a text. */
static const char *locate(const char *text) {
    static char pointer[API_POINTER_MAX];
    api_locate(text, strcspn(text, "^"), pointer);
    return pointer;
}

static void test_locate_finds_members_and_elements(void **state) {
    (void)state;
    assert_string_equal(locate("1^"), "");
    assert_string_equal(locate("[1^"), "/0");
    assert_string_equal(locate("[1,2,3^"), "/2");
    assert_string_equal(locate("{\"a\":1^"), "/a");
    assert_string_equal(locate("{\"a\":1,\"b\":{\"c\":[[0,0],[0,5^"), "/b/c/1/1");
    assert_string_equal(locate("[[1,2],{\"x\":[]},3^"), "/2");
    assert_string_equal(locate("{\"a\":\"b\",\"c\":5^"), "/c");
    assert_string_equal(locate("{\"a,]}\":\"[{\\\"\",\"c\":5^"), "/c");
}

static void test_locate_goes_no_deeper_than_it_can(void **state) {
    (void)state;
    char text[300], pointer[API_POINTER_MAX];
    memset(text, '[', sizeof text);
    api_locate(text, sizeof text, pointer);
    assert_int_equal(strlen(pointer), API_POINTER_MAX - 1);
    memset(text, '{', sizeof text);
    api_locate(text, sizeof text, pointer);
    assert_int_equal(strspn(pointer, "/"), 64);
}

static void test_locate_cuts_long_keys(void **state) {
    (void)state;
    char text[600] = "{\"", pointer[API_POINTER_MAX];
    memset(text + 2, 'k', 500);
    strcpy(text + 502, "\":{\"x\":1");
    api_locate(text, strlen(text), pointer);
    assert_int_equal(strlen(pointer), API_POINTER_MAX - 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_locate_finds_members_and_elements),
        cmocka_unit_test(test_locate_goes_no_deeper_than_it_can),
        cmocka_unit_test(test_locate_cuts_long_keys),
    };
    return cmocka_run_group_tests_name("locate", tests, NULL, NULL);
}
