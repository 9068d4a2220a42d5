/* SPDX-License-Identifier: MIT */
/* Sockets at their beginning, where the front listens, and at their end, while a client that was
 * refused still sends. */
#include "server/http/lingering_close.h"
#include "server/http/listener.h"
#include "server/log.h"
#include "tests/check.h"
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <stdbool.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

enum { FILES = 1024, PATIENCE_MS = 1500 };

static int count_files(void) {
    int count = 0;
    for (int file = 0; file < FILES; file++)
        count += fcntl(file, F_GETFD) >= 0;
    return count;
}

/* Until so many files are open; whether that comes within the time. */
static bool wait_for_files(int count) {
    for (int k = 0; k < PATIENCE_MS && count_files() != count; k++)
        usleep(1000);
    return count_files() == count;
}

static struct config config_on(const char *address, int port) {
    struct config config = {.inherited = -1, .listen = address, .max_connections = 64};
    struct sockaddr_in *v4 = (struct sockaddr_in *)&config.address;
    struct sockaddr_in6 *v6 = (struct sockaddr_in6 *)&config.address;
    if (inet_pton(AF_INET, address, &v4->sin_addr) == 1) {
        v4->sin_family = AF_INET;
        v4->sin_port = htons((uint16_t)port);
        config.address_length = sizeof *v4;
    } else {
        assert_int_equal(inet_pton(AF_INET6, address, &v6->sin6_addr), 1);
        v6->sin6_family = AF_INET6;
        v6->sin6_port = htons((uint16_t)port);
        config.address_length = sizeof *v6;
    }
    return config;
}

/* A connection to a port of 127.0.0.1; -1 without. */
static int connect_to(int port) {
    struct sockaddr_in to = {.sin_family = AF_INET,
                             .sin_addr.s_addr = htonl(INADDR_LOOPBACK),
                             .sin_port = htons((uint16_t)port)};
    int file = socket(AF_INET, SOCK_STREAM, 0);
    if (connect(file, (struct sockaddr *)&to, sizeof to) == 0)
        return file;
    close(file);
    return -1;
}

static int option_of(int file, int level, int name) {
    int value = -1;
    socklen_t length = sizeof value;
    assert_int_equal(getsockopt(file, level, name, &value, &length), 0);
    return value;
}

static void expect_options(int listener) {
    assert_int_equal(option_of(listener, SOL_SOCKET, SO_KEEPALIVE), 1);
    assert_int_equal(option_of(listener, IPPROTO_TCP, TCP_KEEPIDLE), 15);
    assert_int_equal(option_of(listener, IPPROTO_TCP, TCP_KEEPINTVL), 5);
    assert_int_equal(option_of(listener, IPPROTO_TCP, TCP_USER_TIMEOUT), 60000);
}

/* Callers of IPv4 get through to [::] as well. */
static void test_listener_takes_calls(void **state) {
    static const char *const addresses[] = {"127.0.0.1", "0.0.0.0", "::"};
    (void)state;
    for (size_t k = 0; k < sizeof addresses / sizeof *addresses; k++) {
        struct config config = config_on(addresses[k], 0);
        int listener = listener_open(&config), port = listener_port(listener);
        assert_true(listener >= 0 && port > 0);
        expect_options(listener);
        int caller = connect_to(port);
        assert_true(caller >= 0);
        assert_true(option_of(listener, SOL_SOCKET, SO_REUSEADDR));
        assert_true(fcntl(listener, F_GETFL) & O_NONBLOCK);
        assert_true(fcntl(listener, F_GETFD) & FD_CLOEXEC);
        close(caller);

        struct config same = config_on(addresses[k], port); /* taken: nothing is left open */
        int files = count_files();
        assert_int_equal(listener_open(&same), -1);
        assert_int_equal(count_files(), files);
        close(listener);
    }
    assert_int_equal(listener_port(-1), 0);
}

/* The socket of the service manager is used as it is, and closed by whoever opened it. */
static void test_listener_uses_an_inherited_socket(void **state) {
    struct config config = config_on("127.0.0.1", 0), other = config;
    int files = count_files();
    (void)state;
    int given = socket(AF_INET, SOCK_STREAM, 0);
    other.inherited = given;
    assert_int_equal(listener_open(&other), given);
    expect_options(given);
    assert_int_equal(count_files(), files + 1);
    close(given);
}

/* Of descriptors there are enough for the connections and 256 others, where the system allows it.
 */
static void test_listener_asks_for_descriptors(void **state) {
    struct rlimit before, now;
    struct config config = config_on("127.0.0.1", 0);
    (void)state;
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
    check_at_least(before.rlim_max, 600);
    for (int64_t connections = 43; connections <= 45; connections++) {
        const struct rlimit few = {300, before.rlim_max};
        assert_int_equal(setrlimit(RLIMIT_NOFILE, &few), 0);
        assert_int_equal(listener_descriptors(), 300);
        config.max_connections = connections;
        close(listener_open(&config));
        assert_int_equal(getrlimit(RLIMIT_NOFILE, &now), 0);
        assert_int_equal(now.rlim_cur, connections > 44 ? connections + 256 : 300);
        assert_int_equal(now.rlim_max, before.rlim_max);
    }
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &before), 0);
}

/* ------------------------------------------------------------------ the end */

/* Both ends of a connection by TCP. */
static void connect_both(int ends[2]) {
    struct config config = config_on("127.0.0.1", 0);
    int listener = listener_open(&config);
    ends[0] = connect_to(listener_port(listener));
    ends[1] = accept(listener, NULL, NULL);
    assert_true(ends[0] >= 0 && ends[1] >= 0);
    close(listener);
}

/* A client that still sends is not met by a reset, which would take the answer away; and once it
 * has closed nothing is left of it. */
static void test_lingering_close_lets_the_client_read(void **state) {
    static char bytes[10000];
    int ends[2], files = count_files();
    (void)state;
    struct lingering_close *pool = lingering_close_start();
    assert_non_null(pool);
    int running = count_files();
    connect_both(ends);
    assert_int_equal(write(ends[1], "answer", 6), 6);
    lingering_close_add(pool, ends[1]);
    close(ends[1]);
    for (int k = 0; k < 30; k++) {
        assert_int_equal(send(ends[0], bytes, sizeof bytes, MSG_NOSIGNAL), sizeof bytes);
        usleep(5000);
    }
    assert_int_equal(count_files(), running + 2);
    assert_int_equal(read(ends[0], bytes, sizeof bytes), 6);
    assert_memory_equal(bytes, "answer", 6);
    assert_int_equal(read(ends[0], bytes, sizeof bytes), 0); /* the sending side was closed */
    close(ends[0]);
    assert_true(wait_for_files(running));
    lingering_close_stop(pool);
    lingering_close_stop(NULL);
    assert_int_equal(count_files(), files);
}

/* So many at a time; the end closes what is left. */
static void test_lingering_close_takes_so_many(void **state) {
    enum { MOST = 64, ALL = MOST + 3 };
    int ends[ALL][2], files = count_files();
    (void)state;
    struct lingering_close *pool = lingering_close_start();
    assert_non_null(pool);
    for (int k = 0; k < ALL; k++)
        assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends[k]), 0);
    int before = count_files();
    for (int k = 0; k < ALL; k++)
        lingering_close_add(pool, ends[k][1]);
    assert_int_equal(count_files(), before + MOST);
    for (int k = 0; k < ALL; k++) {
        close(ends[k][0]);
        close(ends[k][1]);
    }
    assert_true(wait_for_files(before - 2 * ALL));
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends[0]), 0);
    lingering_close_add(pool, ends[0][1]);
    close(ends[0][1]);
    lingering_close_stop(pool);
    close(ends[0][0]);
    assert_int_equal(count_files(), files);
}

static int be_quiet(void **state) {
    (void)state;
    log_init(LOG_LEVEL_ERROR);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_listener_takes_calls),
        cmocka_unit_test(test_listener_uses_an_inherited_socket),
        cmocka_unit_test(test_listener_asks_for_descriptors),
        cmocka_unit_test(test_lingering_close_lets_the_client_read),
        cmocka_unit_test(test_lingering_close_takes_so_many),
    };
    return cmocka_run_group_tests_name("sockets", tests, be_quiet, NULL);
}
