/* SPDX-License-Identifier: MIT */
/* Which hosts are this daemon's, and which web pages may change something or read an answer. */
#include "server/http/origin.h"
#include "tests/check.h"
#include <arpa/inet.h>
#include <string.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* One that listens on that address. */
static struct config config_at(const char *address, const char *public_name,
                               const char *cors_origin) {
    struct config config = {.public_name = public_name, .cors_origin = cors_origin};
    struct sockaddr_in *v4 = (struct sockaddr_in *)&config.address;
    struct sockaddr_in6 *v6 = (struct sockaddr_in6 *)&config.address;
    if (inet_pton(AF_INET, address, &v4->sin_addr) == 1)
        v4->sin_family = AF_INET;
    else if (inet_pton(AF_INET6, address, &v6->sin6_addr) == 1)
        v6->sin6_family = AF_INET6;
    return config;
}

static void test_origin_allows_the_hosts_it_has(void **state) {
    static const struct {
        const char *address, *names, *host;
        bool allowed;
    } rows[] = {
        {"127.0.0.1", "", "localhost", true},
        {"127.0.0.1", "", "LocalHost:8080", true},
        {"127.0.0.1", "", "localhost.", false},
        {"127.0.0.1", "", "localhos", false},
        {"127.0.0.1", "", "", false},
        {"127.0.0.1", "", "127.0.0.1", true},
        {"127.0.0.1", "", "127.8.9.1:80", true},
        {"127.0.0.1", "", "128.0.0.1", false},
        {"127.0.0.1", "", "126.255.255.255", false},
        {"127.0.0.1", "", "[::1]:8080", true},
        {"127.0.0.1", "", "[::2]", false},
        {"127.0.0.1", "", "::1", false},
        {"127.0.0.1", "", "[]", false},
        {"127.0.0.1", "", "[127.0.0.1]", false},
        {"127.0.0.1", "", "192.0.2.7", false},
        {"127.0.0.1", "", "1111:2222:3333:4444:5555:6666:123.123.123.1234567", false},
        {"127.0.0.1", "", "[1111:2222:3333:4444:5555:6666:123.123.123.123]", false},
        {"127.0.0.1", "", "[1111:2222:3333:4444:5555:6666:7777:8888:9999:aaaa:bbbb]", false},
        {"192.0.2.7", "", "192.0.2.7", true},
        {"192.0.2.7", "", "192.0.2.8", false},
        {"192.0.2.7", "", "[2001:db8::7]", false},
        {"0.0.0.0", "", "192.0.2.8:80", true},
        {"0.0.0.0", "", "[2001:db8::7]", true},
        {"0.0.0.0", "", "draped.test", false},
        {"2001:db8::7", "", "[2001:db8::7]:80", true},
        {"2001:db8::7", "", "[2001:db8::8]", false},
        {"2001:db8::7", "", "192.0.2.7", false},
        {"::", "", "[2001:db8::7]", true},
        {"::", "", "192.0.2.7", true},
        {"127.0.0.1", "draped.test", "draped.test", true},
        {"127.0.0.1", "draped.test", "DRAPED.test:8080", true},
        {"127.0.0.1", "draped.test", "draped.tes", false},
        {"127.0.0.1", "draped.test", "draped.test2", false},
        {"127.0.0.1", "one.test,draped.test", "draped.test", true},
        {"127.0.0.1", "draped.test,two.test", "draped.test", true},
        {"127.0.0.1", "one.test,two.test", "draped.test", false},
        {"127.0.0.1", "*", "draped.test", true},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct config config = config_at(rows[k].address, rows[k].names, "");
        struct request request = {.headers = {{"Host", rows[k].host}}, .header_count = 1};
        struct reply reply = {.request_id = ""};
        bool allowed = origin_allows_host(&config, &request, &reply);
        if (allowed != rows[k].allowed || reply.status != (allowed ? 0 : 403))
            fail_msg("%s of %s %s: %d", rows[k].host, rows[k].address, rows[k].names, reply.status);
        reply_clear(&reply);
    }
}

/* The authority of an absolute target counts instead; HTTP/1.0 may have none. */
static void test_origin_asks_for_a_host(void **state) {
    struct config config = config_at("127.0.0.1", "", "");
    struct request absolute = {
        .authority = (char *)(intptr_t) "localhost", .headers = {{"Host", "a"}}, .header_count = 1};
    struct request old = {.http_1_0 = true}, none = {.http_1_0 = false};
    struct request old_named = {.http_1_0 = true, .headers = {{"Host", "a"}}, .header_count = 1};
    struct reply reply = {.request_id = ""};
    (void)state;
    assert_true(origin_allows_host(&config, &absolute, &reply));
    assert_true(origin_allows_host(&config, &old, &reply));
    assert_int_equal(reply.status, 0);
    assert_false(origin_allows_host(&config, &old_named, &reply));
    assert_false(origin_allows_host(&config, &none, &reply));
    reply_clear(&reply);
}

/* 64 characters of the host are said. */
static void test_origin_says_the_host_it_refuses(void **state) {
    struct config config = config_at("127.0.0.1", "", "");
    char host[80], said[100];
    (void)state;
    for (int length = 62; length < 68; length++) {
        snprintf(host, sizeof host, "%0*d", length, 0);
        snprintf(said, sizeof said, "the host '%.64s' is", host);
        struct request request = {.headers = {{"Host", host}}, .header_count = 1};
        struct reply reply = {.request_id = ""};
        assert_false(origin_allows_host(&config, &request, &reply));
        assert_non_null(strstr(reply.body, said));
        reply_clear(&reply);
    }
}

static void test_origin_reads_lists(void **state) {
    static const struct {
        const char *list;
        bool hosts, origins;
    } rows[] = {
        {"", true, true},
        {"*", true, true},
        {"draped.test", true, false},
        {"draped.test,[::1],two.test", false, false},
        {"draped.test,two.test", true, false},
        {"draped.test:80", false, false},
        {"draped.test,", false, false},
        {",draped.test", false, false},
        {"draped.test,a b", false, false},
        {"a b,draped.test", false, false},
        {"http://draped.test", false, true},
        {"https://draped.test:8080", false, true},
        {"https://draped.test,http://two.test", false, true},
        {"https://draped.test,two.test", false, false},
        {"https://draped.test/", false, false},
        {"https://", false, false},
        {"http://", false, false},
        {"http://a", false, true},
        {"https://a", false, true},
        {"ftp://draped.test", false, false},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++)
        if (origin_are_hosts(rows[k].list, false) != rows[k].hosts ||
            origin_are_hosts(rows[k].list, true) != rows[k].origins)
            fail_msg("'%s' is taken for another list", rows[k].list);
}

static void test_origin_allows_changes_of_its_own_pages(void **state) {
    static const struct {
        const char *site, *origin, *names, *cors;
        bool allowed;
    } rows[] = {
        {NULL, NULL, "", "", true}, /* no browser */
        {"same-origin", NULL, "", "", true},
        {"none", NULL, "", "", true},
        {"same-site", NULL, "", "", false},
        {"cross-site", NULL, "", "", false},
        {"same-origin", "http://evil.test", "", "", true}, /* the browser knows better */
        {"cross-site", "http://localhost:8080", "", "", false},
        {"cross-site", "http://page.test", "", "http://page.test", true},
        {"cross-site", "http://page.test", "", "http://other.test", false},
        {NULL, "http://localhost:8080", "", "", true},
        {NULL, "http://LOCALHOST:8080", "", "", true},
        {NULL, "http://localhost:8081", "", "", false},
        {NULL, "http://localhost", "", "", false},
        {NULL, "null", "", "", false},
        {NULL, "", "", "", false},
        {NULL, "http://page.test", "", "", false},
        {NULL, "http://page.test", "page.test", "", true},
        {NULL, "https://page.test:99", "one.test,page.test", "", true},
        {NULL, "http://page.test", "other.test", "", false},
        {NULL, "http://page.test", "*", "", false}, /* any name, but of the daemon */
        {NULL, "http://page.test", "", "http://page.test", true},
        {NULL, "http://page.test", "", "http://one.test,http://page.test", true},
        {NULL, "http://page.test", "", "https://page.test", false},
        {NULL, "http://page.test", "", "*", true},
        {NULL, "null", "", "*", true},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct config config = config_at("127.0.0.1", rows[k].names, rows[k].cors);
        struct request request = {.headers = {{"Host", "localhost:8080"}}, .header_count = 1};
        struct reply reply = {.request_id = ""};
        if (rows[k].site)
            request.headers[request.header_count++] =
                (struct request_field){"Sec-Fetch-Site", rows[k].site};
        if (rows[k].origin)
            request.headers[request.header_count++] =
                (struct request_field){"Origin", rows[k].origin};
        bool allowed = origin_allows_change(&config, &request, &reply);
        if (allowed != rows[k].allowed || reply.status != (allowed ? 0 : 403))
            fail_msg("%s %s, named %s, shared with %s: %d", rows[k].site, rows[k].origin,
                     rows[k].names, rows[k].cors, reply.status);
        reply_clear(&reply);
    }
}

/* The value of that header of the reply; NULL without. */
static const char *said_in(const struct reply *reply, const char *name) {
    for (size_t k = 0; k < reply->header_count; k++)
        if (!strcmp(reply->headers[k].name, name))
            return reply->headers[k].value;
    return NULL;
}

static void test_origin_shares_answers_with_listed_pages(void **state) {
    static const struct {
        const char *cors, *origin, *method, *asked;
        size_t headers; /* Vary; and for whom, and what may be read; and what may be sent */
    } rows[] = {
        {"", "http://page.test", "GET", NULL, 0},
        {"http://page.test", NULL, "GET", NULL, 1},
        {"http://page.test", "http://evil.test", "OPTIONS", "POST", 1},
        {"http://page.test", "http://page.test", "GET", NULL, 3},
        {"http://page.test", "http://page.test", "GET", "POST", 3},
        {"*", "http://page.test", "OPTIONS", NULL, 3},
        {"*", "http://page.test", "OPTIONS", "POST", 6},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct config config = config_at("127.0.0.1", "", rows[k].cors);
        struct request request = {.method = rows[k].method};
        struct reply reply = {.request_id = ""};
        if (rows[k].origin)
            request.headers[request.header_count++] =
                (struct request_field){"Origin", rows[k].origin};
        if (rows[k].asked)
            request.headers[request.header_count++] =
                (struct request_field){"Access-Control-Request-Method", rows[k].asked};
        origin_share(&config, &request, &reply);
        assert_int_equal(reply.header_count, rows[k].headers);
        if (rows[k].headers > 0)
            assert_string_equal(said_in(&reply, "Vary"), "Origin");
        if (rows[k].headers > 1) {
            assert_string_equal(said_in(&reply, "Access-Control-Allow-Origin"), rows[k].origin);
            assert_non_null(said_in(&reply, "Access-Control-Expose-Headers"));
        }
        if (rows[k].headers > 3) {
            assert_string_equal(said_in(&reply, "Access-Control-Allow-Methods"),
                                "GET, HEAD, POST, DELETE");
            assert_non_null(said_in(&reply, "Access-Control-Allow-Headers"));
            assert_string_equal(said_in(&reply, "Access-Control-Max-Age"), "600");
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_origin_allows_the_hosts_it_has),
        cmocka_unit_test(test_origin_asks_for_a_host),
        cmocka_unit_test(test_origin_says_the_host_it_refuses),
        cmocka_unit_test(test_origin_reads_lists),
        cmocka_unit_test(test_origin_allows_changes_of_its_own_pages),
        cmocka_unit_test(test_origin_shares_answers_with_listed_pages),
    };
    return cmocka_run_group_tests_name("origin", tests, NULL, NULL);
}
