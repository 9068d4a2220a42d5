/* SPDX-License-Identifier: MIT */
/* The check of what comes over a connection, on the raw requests of tests/faults/framing.cases: how
 * they are split makes no difference, and what the daemon answers and keeps is well-formed. */
#include "server/http/wire.h"
#include "tests/store/scratch.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RAW_MAX = 4 << 20, SPLITS = 5 };

static char raw[RAW_MAX];
static size_t raw_length;

static void append(const char *bytes, size_t length) {
    assert_true(raw_length + length <= RAW_MAX);
    memcpy(raw + raw_length, bytes, length);
    raw_length += length;
}

/* One character as the file writes it: itself or an escape of Python's; `*text` moves on. */
static char unescape(const char **text) {
    static const char letters[] = "rnt0\\\"", values[] = "\r\n\t\0\\\"";
    if (**text != '\\')
        return *(*text)++;
    char kind = *++*text;
    ++*text;
    if (kind == 'x') {
        char digits[3] = {(*text)[0], (*text)[1], 0};
        *text += 2;
        return (char)strtol(digits, NULL, 16);
    }
    const char *found = strchr(letters, kind);
    assert_non_null(found);
    return values[found - letters];
}

/* Appends the text of [text, end), unescaped; <pause> stands for nothing, {TEXT*N} for N times. */
static void append_text(const char *text, const char *end) {
    while (text < end) {
        const char *star = *text == '{' ? memchr(text, '*', (size_t)(end - text)) : NULL;
        const char *close = star ? memchr(star, '}', (size_t)(end - star)) : NULL;
        if (!strncmp(text, "<pause>", 7)) {
            text += 7;
        } else if (close && memchr(text + 1, '{', (size_t)(star - text - 1)) == NULL &&
                   star[1 + strspn(star + 1, "0123456789")] == '}') {
            for (long k = strtol(star + 1, NULL, 10); k > 0; k--)
                append_text(text + 1, star);
            text = close + 1;
        } else {
            char c = unescape(&text);
            append(&c, 1);
        }
    }
}

/* The bytes of a line of the file, in `raw`. False for a line that is no case. */
static bool read_case(char *line, char **name, char **wanted) {
    static const char get[] = "GET /version HTTP/1.1\r\nHost: localhost\r\n";
    static const char post[] =
        "POST /v1/drapes HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n";
    line[strcspn(line, "\n")] = '\0';
    *name = line;
    *wanted = strstr(line, " | ");
    if (*line == '#' || !*wanted)
        return false;
    char *text = strstr(*wanted + 3, " | ");
    **wanted = *text = '\0';
    *wanted += 3;
    text += 3;
    raw_length = 0;
    if (!strncmp(text, "@GET ", 5))
        append(get, sizeof get - 1), text += 5;
    else if (!strncmp(text, "@POST ", 6))
        append(post, sizeof post - 1), text += 6;
    append_text(text, text + strlen(text));
    return true;
}

/* Feeds `raw` in pieces of at most `most` bytes; how many were good. */
static size_t feed(struct wire *wire, size_t most, unsigned *seed) {
    size_t at = 0;
    wire_init(wire);
    while (at < raw_length && wire->problem == API_OK) {
        size_t length = most == 1 ? 1 : 1 + (size_t)rand_r(seed) % most;
        if (length > raw_length - at)
            length = raw_length - at;
        at += wire_check(wire, raw + at, length, NULL);
    }
    return at;
}

static void for_each_case(void (*check)(const char *name, const char *wanted)) {
    FILE *file = fopen("tests/faults/framing.cases", "re");
    char *line = NULL, *name, *wanted;
    size_t size = 0;
    int count = 0;
    assert_non_null(file);
    while (getline(&line, &size, file) > 0)
        if (read_case(line, &name, &wanted)) {
            check(name, wanted);
            count++;
        }
    assert_true(count >= 300);
    free(line);
    fclose(file);
}

static void expect_same(const char *name, const char *wanted) {
    struct wire whole, pieces;
    unsigned seed = 1;
    (void)wanted;
    wire_init(&whole);
    size_t good = wire_check(&whole, raw, raw_length, NULL);
    for (int k = 0; k < SPLITS; k++)
        if (feed(&pieces, k ? 40 : 1, &seed) != good || pieces.problem != whole.problem ||
            pieces.detail != whole.detail || pieces.messages != whole.messages)
            fail_msg("%s: split, it is another message", name);
}

static void test_wire_verdict_does_not_depend_on_splits(void **state) {
    (void)state;
    for_each_case(expect_same);
}

/* Of the cases that leave the connection open all bytes are good, and nothing is left over. */
static void expect_good(const char *name, const char *wanted) {
    struct wire wire;
    wire_init(&wire);
    size_t good = wire_check(&wire, raw, raw_length, NULL);
    if (strstr(wanted, "keep") && (wire.problem != API_OK || !wire_between(&wire)))
        fail_msg("%s: refused at %zu: %s", name, good, wire.detail ? wire.detail : "incomplete");
}

static void test_wire_accepts_what_is_answered_and_kept(void **state) {
    (void)state;
    for_each_case(expect_good);
}

static void test_wire_says_where_the_last_message_begins(void **state) {
    static const char first[] = "GET / HTTP/1.1\r\nHost: a\r\n\r\n",
                      second[] = "GET  / HTTP/1.1\r\n";
    struct wire wire;
    size_t begun;
    (void)state;
    raw_length = 0;
    append(first, sizeof first - 1);
    append(second, sizeof second - 1);
    wire_init(&wire);
    assert_int_equal(wire_check(&wire, raw, raw_length, &begun), sizeof first - 1 + 4);
    assert_int_equal(begun, sizeof first - 1);
    assert_int_equal(wire.messages, 1);
    assert_int_equal(wire.problem, API_BAD_REQUEST);
    assert_int_equal(wire_check(&wire, raw, raw_length, &begun), 0);
}

static void test_wire_knows_the_end_of_a_connection(void **state) {
    static const struct {
        const char *head;
        bool closing;
    } heads[] = {
        {"GET / HTTP/1.1\r\nHost: a\r\n\r\n", false},
        {"GET / HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n", true},
        {"GET / HTTP/1.1\r\nHost: a\r\nConnection: x,Close\r\n\r\n", true},
        {"GET / HTTP/1.1\r\nHost: a\r\nConnection: closed\r\n\r\n", false},
        {"GET / HTTP/1.0\r\n\r\n", true},
        {"GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n", false},
    };
    (void)state;
    for (size_t k = 0; k < sizeof heads / sizeof *heads; k++) {
        struct wire wire;
        wire_init(&wire);
        assert_int_equal(wire_check(&wire, heads[k].head, strlen(heads[k].head), NULL),
                         strlen(heads[k].head));
        assert_int_equal(wire.closing, heads[k].closing);
    }
}

static void test_wire_knows_authorities(void **state) {
    static const char *const good[] = {"a", "a.b:80", "127.0.0.1:", "[::1]:8080", "a_b", "%41b"};
    static const char *const bad[] = {"",     ":80", "a b",      "a/b",    "u@a", "a:b",
                                      "[::1", "[]",  "a:123456", "[::1]a", "a%4"};
    (void)state;
    for (size_t k = 0; k < sizeof good / sizeof *good; k++)
        assert_true(wire_is_authority(good[k], strlen(good[k])));
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        assert_false(wire_is_authority(bad[k], strlen(bad[k])));
}

static void test_wire_knows_targets(void **state) {
    static const char *const good[] = {"/", "/a/b?c", "*", "http://a/", "HTTPS://a.b:80/c", "//a"};
    static const char *const bad[] = {"a",       "a/b",      "ab/c",        "http:/a/", "http:///a",
                                      "http://", "ftp://a/", "http://u@a/", "**",       "*/"};
    (void)state;
    for (size_t k = 0; k < sizeof good / sizeof *good + sizeof bad / sizeof *bad; k++) {
        bool is_good = k < sizeof good / sizeof *good;
        const char *target = is_good ? good[k] : bad[k - sizeof good / sizeof *good];
        const char *method = strcmp(target, "*") ? "GET" : "OPTIONS";
        char head[100];
        struct wire wire;
        int length =
            snprintf(head, sizeof head, "%s %s HTTP/1.1\r\nHost: a\r\n\r\n", method, target);
        wire_init(&wire);
        size_t checked = wire_check(&wire, head, (size_t)length, NULL);
        if ((checked == (size_t)length && wire.problem == API_OK) != is_good)
            fail_msg("the target '%s': problem %d", target, (int)wire.problem);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wire_verdict_does_not_depend_on_splits),
        cmocka_unit_test(test_wire_accepts_what_is_answered_and_kept),
        cmocka_unit_test(test_wire_says_where_the_last_message_begins),
        cmocka_unit_test(test_wire_knows_the_end_of_a_connection),
        cmocka_unit_test(test_wire_knows_authorities),
        cmocka_unit_test(test_wire_knows_targets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
