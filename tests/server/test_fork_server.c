/* SPDX-License-Identifier: MIT */
/* The fork server: its copies are children like programs, one that crashed is the last of its
 * addresses, and when the fork server has gone children are had all the same. */
#include "server/work/child.h"
#include "server/work/fork_server.h"
#include "server/work/sandbox.h"
#include "server/work/worker.h"
#include "tests/store/scratch.h"
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* What a child says of itself; then it waits for the end, or crashes. */
struct word {
    pid_t pid, parent, group;
    uintptr_t address;
    char line[32]; /* what ps shows */
};

static int say(void) {
    struct word word = {getpid(), getppid(), getpgrp(), (uintptr_t)&word, ""};
    FILE *file = fopen("/proc/self/cmdline", "re");
    size_t got = file ? fread(word.line, 1, sizeof word.line - 1, file) : 0;
    for (size_t k = 0; k + 1 < got; k++)
        word.line[k] = word.line[k] ? word.line[k] : ' ';
    word.line[strcspn(word.line, "\n")] = '\0';
    char end = 0;
    if (send(WORKER_FD, &word, sizeof word, 0) != (ssize_t)sizeof word)
        return 1;
    while (recv(WORKER_FD, &end, sizeof end, 0) == 1)
        if (end == 'c')
            abort();
    return 7;
}

static const struct fork_server_role roles[] = {{"say", say}};

static struct word begin(struct child *child) {
    struct word word = {0};
    memset(child, 0, sizeof *child);
    assert_true(child_start(child, NULL, "say"));
    assert_int_equal(recv(child->socket, &word, sizeof word, 0), sizeof word);
    return word;
}

static void end(struct child *child) {
    char why[CHILD_WHY_SIZE];
    assert_int_equal(shutdown(child->socket, SHUT_RDWR), 0);
    child_reap(child, why);
    assert_string_equal(why, "exit with code 7");
}

static void test_fork_server_copies_are_children(void **state) {
    static struct child child[2];
    struct word word[2];
    (void)state;
    assert_true(fork_server_open());
    for (int k = 0; k < 2; k++) {
        word[k] = begin(&child[k]);
        assert_int_equal(word[k].pid, child[k].pid);
        assert_int_equal(word[k].parent, getpid());
        assert_int_equal(word[k].group, child[k].pid);
        assert_string_equal(strtok(word[k].line, " "), "draped");
        assert_string_equal(strtok(NULL, " "), "say");
    }
    if (!SANDBOX_SANITIZED)
        assert_int_equal(word[0].address, word[1].address); /* so they are copies */
    child_kill(&child[0]);
    end(&child[1]);
    fork_server_close();
}

/* Whether addresses are chosen at random here. */
static bool random_addresses(void) {
    FILE *file = fopen("/proc/sys/kernel/randomize_va_space", "re");
    int chosen = file ? fgetc(file) : '0';
    if (file)
        fclose(file);
    return chosen != '0';
}

static void test_fork_server_is_another_after_a_crash(void **state) {
    static struct child child;
    char why[CHILD_WHY_SIZE];
    (void)state;
    assert_true(fork_server_open());
    struct word before = begin(&child);
    assert_int_equal(send(child.socket, "c", 1, 0), 1);
    child_reap(&child, why);
    assert_non_null(strstr(why, "signal"));
    struct word after = begin(&child);
    assert_int_equal(after.parent, getpid());
    if (random_addresses() && !SANDBOX_SANITIZED)
        assert_int_not_equal(before.address, after.address);
    end(&child);
    fork_server_close();
}

/* The process of this one's children that is the fork server; 0: none. */
static pid_t find_fork_server(void) {
    char command[64], line[16] = "";
    snprintf(command, sizeof command, "pgrep -P %d -f '^draped fork-server'", (int)getpid());
    FILE *found = popen(command, "re");
    assert_non_null(found);
    bool any = fgets(line, sizeof line, found) != NULL;
    pclose(found);
    return any ? (pid_t)strtol(line, NULL, 10) : 0;
}

static void test_fork_server_that_has_gone_is_replaced(void **state) {
    static struct child child;
    (void)state;
    assert_true(fork_server_open());
    pid_t fork_server = find_fork_server();
    assert_int_equal(fork_server != 0, !SANDBOX_SANITIZED);
    if (fork_server)
        assert_int_equal(kill(fork_server, SIGKILL), 0);
    for (int k = 0; k < 3; k++) {
        assert_int_equal(begin(&child).parent, getpid());
        end(&child);
    }
    for (int k = 0; !SANDBOX_SANITIZED && !find_fork_server(); k++) {
        assert_true(k < 1000); /* some 10 s: it is being started */
        usleep(10000);
    }
    fork_server_close();
    assert_int_equal(find_fork_server(), 0);
    begin(&child); /* without one */
    end(&child);
}

int main(int argc, char **argv) {
    if (argc == 2 && !strcmp(argv[1], FORK_SERVER_ARGUMENT))
        return fork_server_serve(argv, roles, sizeof roles / sizeof *roles);
    if (argc == 2 && !strcmp(argv[1], "say"))
        return say();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fork_server_copies_are_children),
        cmocka_unit_test(test_fork_server_is_another_after_a_crash),
        cmocka_unit_test(test_fork_server_that_has_gone_is_replaced),
    };
    return cmocka_run_group_tests_name("fork server", tests, NULL, NULL);
}
