/* SPDX-License-Identifier: MIT */
/* What handlers see of a request: its target, headers and body, at the bounds of each. */
#include "server/http/request.h"
#include "tests/check.h"
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* Path segments behind "/" each, query parameters as NAME=VALUE behind "?" each. */
static void describe(const struct request *request, char text[400]) {
    size_t at = 0;
    text[0] = '\0';
    for (size_t k = 0; k < request->segment_count; k++)
        at += (size_t)snprintf(text + at, 400 - at, "/%s", request->segments[k]);
    for (size_t k = 0; k < request->query_count; k++)
        at += (size_t)snprintf(text + at, 400 - at, "?%s=%s", request->query[k].name,
                               request->query[k].value);
}

static void test_request_decodes_its_target(void **state) {
    static const struct {
        const char *target, *parts, *authority;
    } rows[] = {
        {"/", "", NULL},
        {"*", "", NULL},
        {"/v1", "/v1", NULL},
        {"/v1/", "/v1/", NULL},
        {"//", "//", NULL},
        {"/v1/drapes/7", "/v1/drapes/7", NULL},
        {"/a%2Fb/c%20d%7e", "/a/b/c d~", NULL},
        {"/a+b?c+d=e+f", "/a+b?c d=e f", NULL},
        {"/?a=1&b=2", "?a=1?b=2", NULL},
        {"/?", "", NULL},
        {"/?&&a=1&", "?a=1", NULL},
        {"/?a&b=&=c", "?a=?b=?=c", NULL},
        {"/?a=1=2", "?a=1=2", NULL},
        {"/?a%3D=%26", "?a==&", NULL},
        {"/?a=1?b", "?a=1?b", NULL},
        {"/1/2/3/4/5/6/7/8", "/1/2/3/4/5/6/7/8", NULL},
        {"/1/2/3/4/5/6/7/8/9", "/1/2/3/4/5/6/7/8", NULL},
        {"http://draped.test/v1?a=1", "/v1?a=1", "draped.test"},
        {"https://[::1]:80/", "", "[::1]:80"},
        {"http://draped.test", "", "draped.test"},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        char text[400];
        struct request *request = request_new(rows[k].target);
        assert_non_null(request);
        describe(request, text);
        assert_string_equal(text, rows[k].parts);
        assert_string_equal(request->target, rows[k].target);
        assert_string_equal(request->fault, "");
        assert_int_equal(request->authority != NULL, rows[k].authority != NULL);
        if (rows[k].authority)
            assert_string_equal(request->authority, rows[k].authority);
        request_free(request);
    }
    request_free(NULL);
}

static void test_request_refuses_bad_encodings(void **state) {
    static const char *const good[] = {"/%01", "/%1f", "/%7F", "/%fF", "/%41?%42=%43", "/\x80"};
    static const char *const bad[] = {"/%00",  "/%",    "/%4",    "/%g0",  "/%0g",
                                      "/\x1f", "/\x7f", "/?a=%0", "/?%=a", "/a/%"};
    (void)state;
    for (size_t k = 0; k < COUNT(good); k++) {
        struct request *request = request_new(good[k]);
        assert_string_equal(request->fault, "");
        request_free(request);
    }
    for (size_t k = 0; k < COUNT(bad); k++) {
        struct request *request = request_new(bad[k]);
        if (!strstr(request->fault, "a control character, or a %"))
            fail_msg("%s: '%s'", bad[k], request->fault);
        request_free(request);
    }
}

static void test_request_takes_so_many_parameters(void **state) {
    char target[400] = "/?";
    (void)state;
    for (size_t k = 1; k <= REQUEST_QUERY_MAX + 1; k++) {
        snprintf(target + strlen(target), sizeof target - strlen(target), "&a%zu=%zu", k, k);
        struct request *request = request_new(target);
        assert_int_equal(request->query_count, k < REQUEST_QUERY_MAX ? k : REQUEST_QUERY_MAX);
        assert_string_equal(request->fault,
                            k <= REQUEST_QUERY_MAX ? "" : "the query has too many parameters");
        assert_string_equal(request_query(request, "a1"), "1");
        assert_null(request_query(request, "A1"));
        request_free(request);
    }
}

static void test_request_joins_lines_of_lists(void **state) {
    static const char *const lists[] = {"Accept", "accept-encoding", "Content-Encoding",
                                        "If-None-Match", "PREFER"};
    static const char *const singles[] = {"Content-Type",  "Idempotency-Key", "If-Range",
                                          "Last-Event-ID", "origin",          "Range",
                                          "Sec-Fetch-Site"};
    (void)state;
    for (size_t k = 0; k < COUNT(lists); k++) {
        struct request *request = request_new("/");
        request_add_header(request, lists[k], "a");
        request_add_header(request, lists[k], "b \t");
        request_add_header(request, lists[k], "c");
        assert_int_equal(request->header_count, 1);
        assert_string_equal(request_header(request, lists[k]), "a, b, c");
        assert_string_equal(request->fault, "");
        request_free(request);
    }
    for (size_t k = 0; k < COUNT(singles); k++) {
        char fault[100];
        struct request *request = request_new("/");
        request_add_header(request, singles[k], "a");
        assert_string_equal(request->fault, "");
        request_add_header(request, singles[k], "b");
        snprintf(fault, sizeof fault, "there is more than one %s", singles[k]);
        assert_string_equal(request->fault, fault);
        request_add_header(request, "Range", "a");
        request_add_header(request, "Range", "b");
        assert_string_equal(request->fault, fault); /* the first one */
        request_free(request);
    }
}

static void test_request_keeps_other_headers_as_they_are(void **state) {
    struct request *request = request_new("/");
    (void)state;
    request_add_header(request, "X-One", " a b ");
    request_add_header(request, "X-Blank", " \t");
    request_add_header(request, "X-One", "c");
    assert_int_equal(request->header_count, 3);
    assert_string_equal(request_header(request, "x-ONE"), " a b");
    assert_string_equal(request_header(request, "X-Blank"), "");
    assert_string_equal(request->headers[2].value, "c");
    assert_null(request_header(request, "X-On"));
    assert_string_equal(request->fault, "");
    request_free(request);

    request = request_new("/");
    for (int k = 0; k < REQUEST_HEADERS_MAX + 2; k++)
        request_add_header(request, k < REQUEST_HEADERS_MAX - 1 ? "X-One" : "X-Last", "a ");
    assert_int_equal(request->header_count, REQUEST_HEADERS_MAX);
    assert_string_equal(request_header(request, "X-Last"), "a ");
    assert_int_equal(request->owned_count, REQUEST_OWNED_MAX);
    for (int k = 0; k <= REQUEST_OWNED_MAX; k++)
        assert_string_equal(request->headers[k].value, k < REQUEST_OWNED_MAX ? "a" : "a ");
    request_free(request);
}

static void test_request_takes_ids_of_callers(void **state) {
    static const char *const good[] = {
        "a", "0Az9._:-", "0123456789012345678901234567890123456789012345678901234567890123"};
    static const char *const bad[] = {
        NULL,
        "",
        "a b",
        "a/b",
        "a\"",
        "a,b",
        "01234567890123456789012345678901234567890123456789012345678901234"};
    (void)state;
    for (size_t k = 0; k < COUNT(good) + COUNT(bad); k++) {
        bool taken = k < COUNT(good);
        const char *id = taken ? good[k] : bad[k - COUNT(good)];
        struct request request = {.headers = {{"x-request-id", id}}, .header_count = id ? 1 : 0};
        request_choose_id(&request);
        assert_true(request.id[0]);
        assert_int_equal(id && !strcmp(request.id, id), taken);
    }
}

static void test_request_knows_whether_a_body_comes(void **state) {
    static const struct {
        const char *name, *value;
        bool body;
        int64_t length;
    } rows[] = {
        {"Host", "a", false, -1},
        {"Content-Length", "0", false, 0},
        {"Content-Length", "1", true, 1},
        {"content-length", "9223372036854775807", true, INT64_MAX},
        {"Content-Length", "9223372036854775808", false, -1},
        {"Content-Length", "x", false, -1},
        {"Transfer-Encoding", "chunked", true, -1},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct request request = {.headers = {{rows[k].name, rows[k].value}}, .header_count = 1};
        int64_t length = 7;
        assert_int_equal(request_has_body(&request, &length), rows[k].body);
        assert_int_equal(length, rows[k].length);
    }
}

static void test_request_reads_integers(void **state) {
    static const struct {
        const char *text;
        int64_t value; /* -1: none of -5 to 100 */
    } rows[] = {
        {"0", 0},
        {"007", 7},
        {"99", 99},
        {"100", 100},
        {"101", -1},
        {"", -1},
        {"-1", -1},
        {"+1", -1},
        {" 1", -1},
        {"1 ", -1},
        {"1x", -1},
        {"x", -1},
        {"/", -1},
        {":", -1},
        {"9", 9},
        {"0x1", -1},
        {"99999999999999999999", -1},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        int64_t value = -1;
        bool good = request_parse_int(rows[k].text, -5, 100, &value);
        if (good != (rows[k].value >= 0) || value != rows[k].value)
            fail_msg("'%s' is %d", rows[k].text, (int)value);
    }
    int64_t value = -1;
    assert_false(request_parse_int("4", 5, 6, &value));
    assert_true(request_parse_int("5", 5, 6, &value));
    assert_true(request_parse_int("9223372036854775807", 0, INT64_MAX, &value));
    assert_false(request_parse_int("9223372036854775808", 0, INT64_MAX, &value));
    assert_true(value == INT64_MAX);
}

/* ------------------------------------------------------------------ bodies */

static char byte_at(size_t k) {
    return (char)(k % 251 + k / 251 % 5);
}

/* A request with a body of that length, which came in pieces. */
static struct request *with_body(size_t length, size_t piece) {
    struct request *request = request_new("/");
    char *bytes = malloc(piece);
    assert_non_null(bytes);
    for (size_t at = 0; at < length; at += piece) {
        size_t part = length - at < piece ? length - at : piece;
        for (size_t k = 0; k < part; k++)
            bytes[k] = byte_at(at + k);
        assert_true(request_append_body(request, bytes, part));
        assert_true(request->body_capacity > request->body_length);
        assert_int_equal(request->body[request->body_length], 0);
    }
    free(bytes);
    return request;
}

/* Short ones lie in the heap, longer ones in a file, which is sealed and as long as they are. */
static void test_request_keeps_bodies(void **state) {
    static const size_t lengths[] = {1,     100,   8191,  8192,  8193,  20000,
                                     32766, 32767, 32768, 32769, 65536, 300000};
    static const size_t pieces[] = {1000, 4096, 400000};
    (void)state;
    for (size_t k = 0; k < COUNT(lengths) * COUNT(pieces); k++) {
        size_t length = lengths[k / COUNT(pieces)], piece = pieces[k % COUNT(pieces)];
        struct request *request = with_body(length, piece);
        assert_int_equal(request->body_length, length);
        assert_int_equal(request->body_file >= 0, length + 1 > REQUEST_BODY_IN_HEAP);
        assert_true(request_complete_body(request));
        for (size_t i = 0; i < length; i++)
            if (request->body[i] != byte_at(i))
                fail_msg("of %zu bytes in pieces of %zu byte %zu is another", length, piece, i);
        assert_int_equal(request->body[length], 0);
        if (request->body_file >= 0) {
            struct stat about;
            assert_int_equal(fstat(request->body_file, &about), 0);
            assert_int_equal(about.st_size, length + 1);
            assert_int_equal(ftruncate(request->body_file, 1), -1);
        }
        request_free(request);
    }
    struct request *request = request_new("/");
    assert_true(request_complete_body(request));
    assert_null(request->body);
    request_free(request);
}

/* Memory doubles: a body of a million pieces is not copied a million times. */
static void test_request_grows_bodies_by_doubling(void **state) {
    size_t capacity = 0, moved = 0;
    struct request *request = request_new("/");
    (void)state;
    for (size_t k = 0; k < 100000; k++) {
        assert_true(request_append_body(request, "x", 1));
        moved += request->body_capacity != capacity;
        capacity = request->body_capacity;
    }
    assert_int_equal(moved, 5); /* 8, 16, 32, 64 and 128 kB */
    assert_int_equal(capacity, 16 * 8192);
    request_free(request);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_request_decodes_its_target),
        cmocka_unit_test(test_request_refuses_bad_encodings),
        cmocka_unit_test(test_request_takes_so_many_parameters),
        cmocka_unit_test(test_request_joins_lines_of_lists),
        cmocka_unit_test(test_request_keeps_other_headers_as_they_are),
        cmocka_unit_test(test_request_takes_ids_of_callers),
        cmocka_unit_test(test_request_knows_whether_a_body_comes),
        cmocka_unit_test(test_request_reads_integers),
        cmocka_unit_test(test_request_keeps_bodies),
        cmocka_unit_test(test_request_grows_bodies_by_doubling),
    };
    return cmocka_run_group_tests_name("request", tests, NULL, NULL);
}
