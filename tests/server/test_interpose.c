/* SPDX-License-Identifier: MIT */
/* What the program has in place of functions of the C library. */
#include "server/http/interpose.h"
#include "tests/store/scratch.h"
#include <errno.h>
#include <sys/epoll.h>
#include <unistd.h>

/* Two threads of libmicrohttpd may take out its listening socket at once when it stops. */
static void test_interpose_takes_a_file_out_of_a_set_twice(void **state) {
    (void)state;
    int pipe_ends[2], set = epoll_create1(EPOLL_CLOEXEC);
    struct epoll_event event = {.events = EPOLLIN};
    assert_true(set >= 0);
    assert_int_equal(pipe(pipe_ends), 0);
    assert_int_equal(epoll_ctl(set, EPOLL_CTL_ADD, pipe_ends[0], &event), 0);
    errno = 0;
    for (int k = 0; k < 3; k++)
        assert_int_equal(epoll_ctl(set, EPOLL_CTL_DEL, pipe_ends[0], NULL), 0);
    assert_int_equal(errno, 0);
    assert_int_equal(epoll_ctl(set, EPOLL_CTL_MOD, pipe_ends[0], &event), -1);
    assert_int_equal(errno, ENOENT);
    close(pipe_ends[0]);
    assert_int_equal(epoll_ctl(set, EPOLL_CTL_DEL, pipe_ends[0], NULL), -1);
    assert_int_equal(errno, EBADF);
    close(pipe_ends[1]);
    close(set);
}

/* Of a descriptor that is not known nothing is checked. */
static void test_interpose_watches_nothing_before_its_start(void **state) {
    (void)state;
    assert_false(interpose_watch(0, NULL));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_interpose_takes_a_file_out_of_a_set_twice),
        cmocka_unit_test(test_interpose_watches_nothing_before_its_start),
    };
    return cmocka_run_group_tests_name("interpose", tests, NULL, NULL);
}
