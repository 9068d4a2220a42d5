/* SPDX-License-Identifier: MIT */
/* Whose a request is: addresses, and what proxies say that may. */
#include "server/http/owner.h"
#include "tests/check.h"
#include <arpa/inet.h>
#include <string.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* The socket address of a text; "" has none. */
static const struct sockaddr *address_of(const char *text) {
    static union {
        struct sockaddr any;
        struct sockaddr_in v4;
        struct sockaddr_in6 v6;
    } address;
    memset(&address, 0, sizeof address);
    if (inet_pton(AF_INET, text, &address.v4.sin_addr) == 1)
        address.v4.sin_family = AF_INET;
    else if (inet_pton(AF_INET6, text, &address.v6.sin6_addr) == 1)
        address.v6.sin6_family = AF_INET6;
    else
        address.any.sa_family = AF_UNIX;
    return &address.any;
}

static void test_owner_is_the_address_or_the_network(void **state) {
    static const struct {
        const char *address, *owner;
    } rows[] = {
        {"192.0.2.7", "@192.0.2.7"},
        {"::ffff:192.0.2.7", "@192.0.2.7"},
        {"2001:db8:1:2:3:4:5:6", "@2001:db8:1:2::/64"},
        {"2001:db8:1:2::", "@2001:db8:1:2::/64"},
        {"::1", "@::/64"},
        {"", "@"},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        char name[REQUEST_CALLER_SIZE];
        owner_of_address(address_of(rows[k].address), name);
        assert_string_equal(name, rows[k].owner);
    }
    char name[REQUEST_CALLER_SIZE];
    owner_of_address(NULL, name);
    assert_string_equal(name, "@");
}

static void test_owner_reads_lists_of_addresses(void **state) {
    static const char *const good[] = {"",
                                       "192.0.2.7",
                                       "192.0.2.7,::1",
                                       " 192.0.2.7\t, \t[::1]:80 ",
                                       "\"192.0.2.7:80\"",
                                       "2001:db8:1111:2222:3333:4444:5555:6666",
                                       "1111:2222:3333:4444:5555:6666:123.123.123.123"};
    static const char *const bad[] = {
        ",",      "192.0.2.7,",  "192.0.2",
        "proxy",  "192.0.2.7/8", "\"::1",
        "::1\"",  "[::1",        "192.0.2.7 ::1",
        "::1::2", "\"",          "1111:2222:3333:4444:5555:6666:7777:8888:9999:aaaa"};
    (void)state;
    for (size_t k = 0; k < COUNT(good); k++)
        if (!owner_are_addresses(good[k]))
            fail_msg("'%s' is refused", good[k]);
    for (size_t k = 0; k < COUNT(bad); k++)
        if (owner_are_addresses(bad[k]))
            fail_msg("'%s' is taken", bad[k]);
}

static void test_owner_trusts_listed_addresses_alone(void **state) {
    static const char trusted[] = "10.0.0.1, 10.0.0.2,[2001:db8::1]";
    static const char *const listed[] = {"10.0.0.1", "10.0.0.2", "::ffff:10.0.0.2", "2001:db8::1"};
    static const char *const others[] = {"10.0.0.3", "2001:db8::2", "::a00:1", ""};
    (void)state;
    for (size_t k = 0; k < COUNT(listed); k++)
        assert_true(owner_trusts(trusted, address_of(listed[k])));
    for (size_t k = 0; k < COUNT(others); k++)
        assert_false(owner_trusts(trusted, address_of(others[k])));
    assert_false(owner_trusts("", address_of("10.0.0.1")));
}

static void test_owner_of_a_request_is_whom_the_proxies_name(void **state) {
    static const struct {
        const char *peer, *name, *value, *again, *owner;
    } rows[] = {
        {"10.0.0.1", "X-Forwarded-For", "192.0.2.7", NULL, "@192.0.2.7"},
        {"10.0.0.1", "x-forwarded-for", "192.0.2.7:80", NULL, "@192.0.2.7"},
        {"10.0.0.1", "X-Forwarded-For", "[2001:db8:0:7::1]:80", NULL, "@2001:db8:0:7::/64"},
        {"10.0.0.1", "X-Forwarded-For", "198.51.100.1, 192.0.2.7", NULL, "@192.0.2.7"},
        {"10.0.0.1", "X-Forwarded-For", "198.51.100.1, 192.0.2.7, 10.0.0.2", NULL, "@192.0.2.7"},
        {"10.0.0.1", "X-Forwarded-For", "10.0.0.2", NULL, "@10.0.0.2"},
        {"10.0.0.1", "X-Forwarded-For", "10.0.0.2, 10.0.0.1", NULL, "@10.0.0.2"},
        {"10.0.0.1", "X-Forwarded-For", "198.51.100.1", "192.0.2.7", "@192.0.2.7"},
        {"10.0.0.1", "X-Forwarded-For", "192.0.2.7", "10.0.0.2", "@192.0.2.7"},
        {"10.0.0.1", "X-Forwarded-For", "192.0.2.7, unknown", NULL, "@10.0.0.1"},
        {"10.0.0.1", "X-Forwarded-For", "unknown, 192.0.2.7", NULL, "@192.0.2.7"},
        {"10.0.0.1", "X-Forwarded-For", "unknown, 10.0.0.2", NULL, "@10.0.0.1"},
        {"10.0.0.1", "X-Forwarded-For", "192.0.2.7,", NULL, "@10.0.0.1"},
        {"10.0.0.1", "X-Forwarded-For", "", NULL, "@10.0.0.1"},
        {"10.0.0.1", "X-Forwarded-For", "for=192.0.2.7", NULL, "@10.0.0.1"},
        {"10.0.0.1", "X-Forwarded", "192.0.2.7", NULL, "@10.0.0.1"},
        {"10.0.0.3", "X-Forwarded-For", "192.0.2.7", NULL, "@10.0.0.3"},
        {"10.0.0.1", "Forwarded", "for=192.0.2.7", NULL, "@192.0.2.7"},
        {"10.0.0.1", "Forwarded", "FOR=\"192.0.2.7:80\"", NULL, "@192.0.2.7"},
        {"10.0.0.1", "Forwarded", "for=\"[2001:db8:0:7::1]\"", NULL, "@2001:db8:0:7::/64"},
        {"10.0.0.1", "Forwarded", "proto=https; for=192.0.2.7;by=10.0.0.1", NULL, "@192.0.2.7"},
        {"10.0.0.1", "Forwarded", "proto=https;;for=192.0.2.7", NULL, "@192.0.2.7"},
        {"10.0.0.1", "Forwarded", "for=198.51.100.1, for=192.0.2.7;by=x", NULL, "@192.0.2.7"},
        {"10.0.0.1", "Forwarded", "for=", NULL, "@10.0.0.1"},
        {"10.0.0.1", "Forwarded", "for=1", NULL, "@10.0.0.1"},
        {"10.0.0.1", "Forwarded", "for=::", NULL, "@::/64"},
        {"10.0.0.1", "Forwarded", "for=_hidden", NULL, "@10.0.0.1"},
        {"10.0.0.1", "Forwarded", "xfor=192.0.2.7", NULL, "@10.0.0.1"},
        {"10.0.0.1", "Forwarded", "proto=https; ", NULL, "@10.0.0.1"},
        {"10.0.0.3", "Forwarded", "for=192.0.2.7", NULL, "@10.0.0.3"},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct request request = {.headers = {{"Host", "a"},
                                              {rows[k].name, rows[k].value},
                                              {rows[k].name, rows[k].again}},
                                  .header_count = rows[k].again ? 3 : 2};
        char name[REQUEST_CALLER_SIZE];
        owner_of_request("10.0.0.1,10.0.0.2", address_of(rows[k].peer), &request, name);
        if (strcmp(name, rows[k].owner) != 0)
            fail_msg("%s: %s is %s, not %s", rows[k].name, rows[k].value, name, rows[k].owner);
    }
}

/* Forwarded goes before X-Forwarded-For, which counts when it is there alone. */
static void test_owner_prefers_the_standard_header(void **state) {
    struct request request = {
        .headers = {{"X-Forwarded-For", "192.0.2.1"}, {"Forwarded", "for=192.0.2.2"}},
        .header_count = 2};
    char name[REQUEST_CALLER_SIZE];
    (void)state;
    owner_of_request("10.0.0.1", address_of("10.0.0.1"), &request, name);
    assert_string_equal(name, "@192.0.2.2");
    request.header_count = 0;
    owner_of_request("10.0.0.1", address_of("10.0.0.1"), &request, name);
    assert_string_equal(name, "@10.0.0.1");
}

static void test_owner_is_local_without_a_proxy(void **state) {
    static const char *const local[] = {"127.0.0.1", "127.255.0.3", "::1", "::ffff:127.0.0.1"};
    static const char *const far[] = {"126.0.0.1", "128.0.0.1", "192.0.2.127",
                                      "::2",       "7f00::1",   ""};
    static const char *const passed_on[] = {"Forwarded", "x-forwarded-for", "Via"};
    const struct request own = {.headers = {{"Host", "a"}}, .header_count = 1};
    (void)state;
    for (size_t k = 0; k < COUNT(local); k++) {
        assert_true(owner_is_local(address_of(local[k]), &own));
        for (size_t i = 0; i < COUNT(passed_on); i++) {
            const struct request request = {.headers = {{passed_on[i], ""}}, .header_count = 1};
            assert_false(owner_is_local(address_of(local[k]), &request));
        }
    }
    for (size_t k = 0; k < COUNT(far); k++)
        assert_false(owner_is_local(address_of(far[k]), &own));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_owner_is_the_address_or_the_network),
        cmocka_unit_test(test_owner_reads_lists_of_addresses),
        cmocka_unit_test(test_owner_trusts_listed_addresses_alone),
        cmocka_unit_test(test_owner_of_a_request_is_whom_the_proxies_name),
        cmocka_unit_test(test_owner_prefers_the_standard_header),
        cmocka_unit_test(test_owner_is_local_without_a_proxy),
    };
    return cmocka_run_group_tests_name("owner", tests, NULL, NULL);
}
