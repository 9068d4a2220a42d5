/* SPDX-License-Identifier: MIT */
/* What clients accept and prefer: tables of headers with what they mean by RFC 9110 and RFC 7240.
 */
#include "server/http/compress.h"
#include "server/http/negotiate.h"
#include "tests/check.h"
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

static void test_negotiate_takes_the_most_specific_range(void **state) {
    static const struct {
        const char *accept;
        int quality; /* of application/json */
    } rows[] = {
        {NULL, 1000},
        {"", 1000},
        {" \t", 1000},
        {"application/json", 1000},
        {"APPLICATION/JSON", 1000},
        {"\t application/json \t;\tq=0.5", 500},
        {"text/html", 0},
        {"application/jso", 0},
        {"application/json5", 0},
        {"*/*;q=0.25", 250},
        {"application/*;q=0.125", 125},
        {"applicatiom/*", 0},
        {"text/*", 0},
        {"*/json", 0},
        {"*/*;q=1,application/*;q=0.5,application/json;q=0.25", 250},
        {"application/json;q=0.25,application/*;q=0.5,*/*;q=1", 250},
        {"application/*;q=0.5,*/*", 500},
        {"*/*,application/*;q=0.5", 500},
        {"application/json;q=0.25,application/json;q=0.5", 250},
        {",, application/json;q=0.75", 750},
        {";q=1, application/json;q=0.75", 750},
        {"application/json;level=1;Q=0.5", 500},
        {"application/json;level=1", 1000},
        {"application/json;q", 1000},
        {"application/json;q=2", 1000},
        {"application/json;q=1", 1000},
        {"application/json;q=0.999", 999},
        {"application/json;q=0", 0},
        {"application/json;q=-1", 0},
        {"application/json;q=nan", 0},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++)
        if (negotiate_quality(rows[k].accept, "application/json") != rows[k].quality)
            fail_msg("'%s' wants %d of it", rows[k].accept,
                     negotiate_quality(rows[k].accept, "application/json"));
}

/* Of a piece 255 bytes are kept: a longer one matches what it is cut to, and nothing behind it is
 * taken for a part of it. */
static void test_negotiate_cuts_long_pieces(void **state) {
    char type[300], list[400];
    (void)state;
    for (size_t length = 250; length < 260; length++) {
        memset(type, 'a', length);
        memcpy(type, "text/", 5);
        type[length] = '\0';
        snprintf(list, sizeof list, "%s,text/b;q=0.5", type);
        assert_int_equal(negotiate_quality(list, type), length < 256 ? 1000 : 0);
        assert_int_equal(negotiate_quality(list, "text/b"), 500);
    }
}

static void test_negotiate_knows_codings(void **state) {
    static const struct {
        const char *accept;
        int gzip;
        enum compress_coding best;
    } rows[] = {
        {NULL, 0, COMPRESS_IDENTITY},
        {"", 0, COMPRESS_IDENTITY},
        {"gzip", 1000, COMPRESS_GZIP},
        {"GZIP;q=0.5", 500, COMPRESS_GZIP},
        {"x-gzip", 0, COMPRESS_IDENTITY},
        {"zstd", 0, COMPRESS_ZSTD},
        {"gzip,zstd", 1000, COMPRESS_ZSTD},
        {"zstd;q=0.4, gzip;q=0.5", 500, COMPRESS_GZIP},
        {"zstd;q=0.5, gzip;q=0.5", 500, COMPRESS_ZSTD},
        {"*", 1000, COMPRESS_ZSTD},
        {"*;q=0.3", 300, COMPRESS_ZSTD},
        {"*;q=0.3, gzip;q=0", 0, COMPRESS_ZSTD},
        {"gzip;q=0.2, *;q=0.3", 200, COMPRESS_ZSTD},
        {"gzip;q=0", 0, COMPRESS_IDENTITY},
        {"identity, gzip;q=0.5", 500, COMPRESS_IDENTITY},
        {"identity;q=0.5, gzip;q=0.5", 500, COMPRESS_GZIP},
        {";q=1,gzip", 1000, COMPRESS_GZIP},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++)
        if (negotiate_coding(rows[k].accept, "gzip") != rows[k].gzip ||
            compress_choose(rows[k].accept) != rows[k].best)
            fail_msg("'%s': gzip %d, best is %s", rows[k].accept,
                     negotiate_coding(rows[k].accept, "gzip"),
                     compress_name(compress_choose(rows[k].accept)));
    assert_string_equal(compress_name(COMPRESS_IDENTITY), "identity");
    assert_string_equal(compress_name(COMPRESS_ZSTD), "zstd");
    assert_string_equal(compress_name(COMPRESS_GZIP), "gzip");
}

static void test_negotiate_reads_how_long_to_wait(void **state) {
    static const struct {
        const char *prefer;
        int64_t seconds; /* of at most 50 */
    } rows[] = {
        {NULL, 0},
        {"", 0},
        {"wait=7", 7},
        {"WAIT=7", 7},
        {"wait = 7", 7},
        {"wait\t=\t\"7\"", 7},
        {"wait=\"7", 0},
        {"wait=7\"", 0},
        {"wait=\"\"", 0},
        {"wait=\"", 0},
        {"wait=", 0},
        {"wait", 0},
        {"wai=7", 0},
        {"await=7", 0},
        {"waiting=7", 0},
        {"wait=49", 49},
        {"wait=50", 50},
        {"wait=51", 50},
        {"wait=9223372036854775807", 50},
        {"wait=9223372036854775808", 0},
        {"wait=-1", 0},
        {"wait=1.5", 0},
        {"respond-async, wait=7", 7},
        {"respond-async; wait=7", 7},
        {"wait=x, wait=7", 7},
        {"wait=7, wait=8", 7},
        {"wait, wait=8", 8},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++)
        if (negotiate_wait(rows[k].prefer, 50) != rows[k].seconds)
            fail_msg("'%s' waits %d s", rows[k].prefer, (int)negotiate_wait(rows[k].prefer, 50));
}

static void test_negotiate_compares_tags(void **state) {
    static const char *const match[] = {"\"a\"", "W/\"a\"", "*", "\"b\", \"a\"", "\"b\" ,\t*"};
    static const char *const other[] = {NULL, "",        "\"b\"",  "a",
                                        "W/", "w/\"a\"", "\"a\"b", "\"b\",\"c\""};
    (void)state;
    for (size_t k = 0; k < COUNT(match); k++)
        assert_true(negotiate_etag_matches(match[k], "\"a\""));
    for (size_t k = 0; k < COUNT(other); k++)
        assert_false(negotiate_etag_matches(other[k], "\"a\""));
}

static void test_negotiate_knows_types(void **state) {
    static const struct {
        const char *type;
        bool json, text; /* whether it is JSON, whether it is text/csv */
    } rows[] = {
        {"application/json", true, false},
        {"Application/JSON ; charset=UTF-8", true, false},
        {"application/json;charset=\"utf-8\"", true, false},
        {"application/json;version=1", true, false},
        {"application/json;charset=latin-1", false, false},
        {"application/json;version=1;charset=latin-1", false, false},
        {"application/problem+json", true, false},
        {"+json", true, false},
        {"json", false, false},
        {"application/json2", false, false},
        {"application/problem+jsons", false, false},
        {"text/csv", false, true},
        {"TEXT/CSV;header=present", false, true},
        {"text/csv2", false, false},
        {"", false, false},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++)
        if (negotiate_is_json(rows[k].type) != rows[k].json ||
            negotiate_is_type(rows[k].type, "text/csv") != rows[k].text)
            fail_msg("'%s' is taken for another type", rows[k].type);
}

/* RFC 9110, 14.1.2: of ten bytes. */
static void test_negotiate_reads_ranges(void **state) {
    static const struct {
        const char *range;
        enum negotiate_part part;
        uint64_t first, last;
    } rows[] = {
        {NULL, NEGOTIATE_ALL, 0, 0},
        {"", NEGOTIATE_ALL, 0, 0},
        {"bytes=0-0", NEGOTIATE_SOME, 0, 0},
        {"BYTES=0-9", NEGOTIATE_SOME, 0, 9},
        {"bytes=2-5", NEGOTIATE_SOME, 2, 5},
        {"bytes=2-10", NEGOTIATE_SOME, 2, 9},
        {"bytes=9-", NEGOTIATE_SOME, 9, 9},
        {"bytes=9-9", NEGOTIATE_SOME, 9, 9},
        {"bytes=0-", NEGOTIATE_SOME, 0, 9},
        {"bytes=10-", NEGOTIATE_NONE, 0, 0},
        {"bytes=10-11", NEGOTIATE_NONE, 0, 0},
        {"bytes=-0", NEGOTIATE_NONE, 0, 0},
        {"bytes=-1", NEGOTIATE_SOME, 9, 9},
        {"bytes=-9", NEGOTIATE_SOME, 1, 9},
        {"bytes=-10", NEGOTIATE_SOME, 0, 9},
        {"bytes=-11", NEGOTIATE_SOME, 0, 9},
        {"bytes=5-4", NEGOTIATE_ALL, 0, 0},
        {"bytes=-", NEGOTIATE_ALL, 0, 0},
        {"bytes=", NEGOTIATE_ALL, 0, 0},
        {"bytes=5", NEGOTIATE_ALL, 0, 0},
        {"bytes=5-6,8-9", NEGOTIATE_ALL, 0, 0},
        {"bytes= 5-6", NEGOTIATE_ALL, 0, 0},
        {"bytes=5-6 ", NEGOTIATE_ALL, 0, 0},
        {"lines=0-1", NEGOTIATE_ALL, 0, 0},
        {"bytes=0-18446744073709551615", NEGOTIATE_SOME, 0, 9},
        {"bytes=0-18446744073709551616", NEGOTIATE_SOME, 0, 9},
        {"bytes=18446744073709551617-", NEGOTIATE_NONE, 0, 0},
        {"bytes=-18446744073709551617", NEGOTIATE_SOME, 0, 9},
        {"bytes=18446744073709551618-18446744073709551616", NEGOTIATE_NONE, 0, 0},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct negotiate_range range = {0, 0};
        enum negotiate_part part = negotiate_range(rows[k].range, 10, &range);
        if (part != rows[k].part || range.first != rows[k].first || range.last != rows[k].last)
            fail_msg("'%s' is part %d, %d to %d", rows[k].range, part, (int)range.first,
                     (int)range.last);
    }
    struct negotiate_range range;
    assert_int_equal(negotiate_range("bytes=-1", 0, &range), NEGOTIATE_NONE);
    assert_int_equal(negotiate_range("bytes=0-", 0, &range), NEGOTIATE_NONE);
    assert_int_equal(negotiate_range("bytes=18446744073709551614-", UINT64_MAX, &range),
                     NEGOTIATE_SOME);
    assert_true(range.first == UINT64_MAX - 1 && range.last == UINT64_MAX - 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_negotiate_takes_the_most_specific_range),
        cmocka_unit_test(test_negotiate_cuts_long_pieces),
        cmocka_unit_test(test_negotiate_knows_codings),
        cmocka_unit_test(test_negotiate_reads_how_long_to_wait),
        cmocka_unit_test(test_negotiate_compares_tags),
        cmocka_unit_test(test_negotiate_knows_types),
        cmocka_unit_test(test_negotiate_reads_ranges),
    };
    return cmocka_run_group_tests_name("negotiate", tests, NULL, NULL);
}
