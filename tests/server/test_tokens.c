/* SPDX-License-Identifier: MIT */
/* The file of callers, the command that writes its lines, and what each role is allowed. */
#include "server/http/access.h"
#include "server/http/tokens.h"
#include "tests/check.h"
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* BLAKE2b-256 of "secret" and of "other", as `b2sum -l 256` says. */
#define SECRET "ae4aafb3c7d8616b739f05a30d06b4e2236fdea712168159f346e8a3efd57d9e"
#define OTHER "96396e0fda42892aedf84cc08c5d8fd4d9f2681f26926fb30f08127f269141e5"

static char path[] = "/tmp/draped-tokens-XXXXXX";

static int make_file(void **state) {
    (void)state;
    int file = mkstemp(path);
    return file < 0 ? -1 : close(file);
}

static int remove_file(void **state) {
    (void)state;
    return unlink(path);
}

/* Makes the file one of this text. */
static void write_file(const char *text) {
    FILE *file = fopen(path, "we");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static struct tokens *open_text(const char *text, char why[TOKENS_WHY_SIZE]) {
    write_file(text);
    why[0] = '\0';
    return tokens_open(path, why);
}

static void test_tokens_reads_its_file(void **state) {
    static const char text[] = "# callers\n\n"
                               "anna:write:" SECRET " \t\r\n"
                               "#bert:write:" OTHER "\n"
                               "A.b_c-9:admin:" OTHER;
    char why[TOKENS_WHY_SIZE];
    struct tokens_holder holder;
    (void)state;
    struct tokens *tokens = open_text(text, why);
    assert_non_null(tokens);
    assert_int_equal(tokens_count(tokens), 2);
    assert_true(tokens_find(tokens, "secret", &holder));
    assert_string_equal(holder.name, "anna");
    assert_int_equal(holder.role, TOKENS_WRITE);
    assert_true(tokens_find(tokens, "other", &holder));
    assert_string_equal(holder.name, "A.b_c-9");
    assert_int_equal(holder.role, TOKENS_ADMIN);
    assert_false(tokens_find(tokens, "secre", &holder));
    assert_false(tokens_find(tokens, "secrets", &holder));
    assert_false(tokens_find(tokens, "", &holder));
    tokens_free(tokens);
    tokens_free(NULL);
}

/* A name of 64 characters and a comment of any length are taken; what follows the comment is read.
 */
static void test_tokens_knows_how_long_things_may_be(void **state) {
    char text[2000], why[TOKENS_WHY_SIZE], name[80];
    struct tokens_holder holder;
    (void)state;
    for (int length = 1; length < 70; length++) {
        snprintf(name, sizeof name, "%0*d", length, 7);
        snprintf(text, sizeof text, "%s:read:" SECRET "\n", name);
        struct tokens *tokens = open_text(text, why);
        assert_int_equal(tokens != NULL, length <= 64);
        if (tokens) {
            assert_true(tokens_find(tokens, "secret", &holder));
            assert_string_equal(holder.name, name);
        }
        tokens_free(tokens);
    }
    for (int length = 1; length < 1000; length += 1 + (length < 250 || length > 260) * 80) {
        snprintf(text, sizeof text, "#%0*d\na:read:" SECRET "\n", length, 0);
        struct tokens *tokens = open_text(text, why);
        assert_non_null(tokens);
        assert_int_equal(tokens_count(tokens), 1);
        tokens_free(tokens);
    }
}

static void test_tokens_refuses_files_that_are_wrong(void **state) {
    static const struct {
        const char *text, *why; /* behind the path */
    } rows[] = {
        {"", " has no token, so no caller would be accepted"},
        {"#\n\n", " has no token, so no caller would be accepted"},
        {"anna", ": line 1 is not name:role:hash"},
        {"\n#\nanna:read", ": line 3 is not name:role:hash"},
        {":read:" SECRET, ": line 1 has no name"},
        {"an na:read:" SECRET, ": line 1 has no name"},
        {"an@a:read:" SECRET, ": line 1 has no name"},
        {"an[a:read:" SECRET, ": line 1 has no name"},
        {"an/a:read:" SECRET, ": line 1 has no name"},
        {"an{a:read:" SECRET, ": line 1 has no name"},
        {"anna:reads:" SECRET, ": line 1 has a role"},
        {"anna::" SECRET, ": line 1 has a role"},
        {"anna:read:" SECRET "0", ": line 1 has no hash"},
        {"anna:read:x" OTHER, ": line 1 has no hash"},
        {"anna:read:", ": line 1 has no hash"},
        {"anna:read:0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdeg",
         ": line 1 has no hash"},
        {"anna:read:g123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef",
         ": line 1 has no hash"},
        {"anna:read:" SECRET "\nbert:read:" SECRET, ": line 2 has the hash of an earlier line"},
        {"anna:read:" SECRET "\nbert:read:" OTHER "\nx", ": line 3 is not name:role:hash"},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        char why[TOKENS_WHY_SIZE];
        if (open_text(rows[k].text, why))
            fail_msg("taken: %s", rows[k].text);
        assert_memory_equal(why, path, strlen(path));
        if (strncmp(why + strlen(path), rows[k].why, strlen(rows[k].why)) != 0)
            fail_msg("'%s' says '%s'", rows[k].text, why);
    }
    char why[TOKENS_WHY_SIZE], long_line[400];
    assert_null(tokens_open("/nonexistent/tokens", why));
    assert_string_equal(why, "/nonexistent/tokens cannot be read: No such file or directory");
    assert_null(tokens_open("/", why));
    assert_non_null(strstr(why, "cannot be read: Is a directory"));
    snprintf(long_line, sizeof long_line, "%0300d\n", 0);
    assert_null(open_text(long_line, why));
    assert_non_null(strstr(why, ": line 1 is too long"));
    snprintf(long_line, sizeof long_line, "%300s\n", "");
    assert_null(open_text(long_line, why));
    assert_non_null(strstr(why, ": line 1 is too long"));
}

/* So many lines, each with a hash of its own. */
static void write_many(int count) {
    FILE *file = fopen(path, "we");
    assert_non_null(file);
    for (int k = 0; k < count; k++)
        fprintf(file, "n%d:read:%064x\n", k, k);
    assert_int_equal(fclose(file), 0);
}

static void test_tokens_are_limited(void **state) {
    char why[TOKENS_WHY_SIZE];
    (void)state;
    write_many(TOKENS_MAX);
    struct tokens *tokens = tokens_open(path, why);
    assert_non_null(tokens);
    assert_int_equal(tokens_count(tokens), TOKENS_MAX);
    write_many(TOKENS_MAX + 1);
    assert_false(tokens_reload(tokens, why));
    assert_non_null(strstr(why, ": line 10001 exceeds the limit of 10000 tokens"));
    assert_int_equal(tokens_count(tokens), TOKENS_MAX);
    tokens_free(tokens);
}

static void test_tokens_reloads_or_stays_as_it_is(void **state) {
    char why[TOKENS_WHY_SIZE];
    struct tokens_holder holder;
    (void)state;
    struct tokens *tokens = open_text("anna:read:" SECRET, why);
    assert_non_null(tokens);
    assert_int_equal(tokens_reloads(tokens), 0);
    write_file("anna");
    assert_false(tokens_reload(tokens, why));
    assert_non_null(strstr(why, ": line 1 is not"));
    assert_true(tokens_find(tokens, "secret", &holder));
    assert_int_equal(tokens_reloads(tokens), 0);
    write_file("bert:read:" OTHER);
    assert_true(tokens_reload(tokens, why));
    assert_int_equal(tokens_reloads(tokens), 1);
    assert_false(tokens_find(tokens, "secret", &holder));
    assert_true(tokens_find(tokens, "other", &holder));
    tokens_free(tokens);
}

static void test_tokens_are_made_at_random(void **state) {
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
    char one[TOKENS_RANDOM_SIZE], two[TOKENS_RANDOM_SIZE], id[ID_SIZE], same[ID_SIZE];
    (void)state;
    tokens_make(one);
    tokens_make(two);
    assert_int_equal(strspn(one, letters), TOKENS_RANDOM_SIZE - 1);
    assert_int_equal(strlen(one), TOKENS_RANDOM_SIZE - 1);
    assert_string_not_equal(one, two);
    tokens_name(one, id);
    tokens_name(one, same);
    assert_string_equal(id, same);
    assert_int_equal(strspn(id, "0123456789abcdef"), ID_SIZE - 1);
    tokens_name(two, same);
    assert_string_not_equal(id, same);
    tokens_name("secret", id); /* `b2sum -l 128` */
    assert_string_equal(id, "8f64bfc250ac98ecf5a0f6a52cde7ec5");
}

/* ------------------------------------------------------------------ hash-token */

/* Runs it with this standard input; its exit code, and what it writes. */
static int command(const char *const *words, int count, const char *input, char *out, char *err) {
    char *argv[8];
    out[0] = err[0] = '\0';
    for (int k = 0; k < count; k++)
        argv[k] = (char *)(intptr_t)words[k];
    FILE *in = fmemopen((char *)(intptr_t)input, strlen(input) + 1, "r");
    FILE *to = fmemopen(out, 2000, "w"), *messages = fmemopen(err, 2000, "w");
    assert_true(in && to && messages);
    int code = tokens_command(count, argv, in, to, messages);
    fclose(in);
    fclose(to);
    fclose(messages);
    return code;
}

static void test_tokens_command_writes_a_line(void **state) {
    static const char *const words[] = {"draped", "hash-token", "anna", "write", "--generate"};
    char out[2000], err[2000], why[TOKENS_WHY_SIZE];
    struct tokens_holder holder;
    (void)state;
    assert_int_equal(command(words, 4, "secret\r\n", out, err), 0);
    assert_string_equal(out, "anna:write:" SECRET "\n");
    assert_non_null(strstr(err, "this token is so short that it could be guessed"));
    assert_int_equal(command(words, 4, "0123456789012345678901", out, err), 0);
    assert_string_equal(err, "");
    assert_int_equal(command(words, 4, "012345678901234567890", out, err), 0);
    assert_non_null(strstr(err, "so short"));

    assert_int_equal(command(words, 5, "", out, err), 0);
    static const char says[] = "the token: ";
    assert_memory_equal(err, says, sizeof says - 1);
    char *token = err + sizeof says - 1;
    token[strcspn(token, "\n")] = '\0';
    assert_int_equal(strlen(token), TOKENS_RANDOM_SIZE - 1);
    struct tokens *tokens = open_text(out, why);
    assert_non_null(tokens);
    assert_true(tokens_find(tokens, token, &holder));
    assert_string_equal(holder.name, "anna");
    assert_int_equal(holder.role, TOKENS_WRITE);
    tokens_free(tokens);
}

static void test_tokens_command_refuses(void **state) {
    static const char *const wrong[][6] = {
        {"draped", "hash-token", "anna"},
        {"draped", "hash-token", "an na", "write"},
        {"draped", "hash-token", "anna", "write", "--made"},
        {"draped", "hash-token", "anna", "root"},
        {"draped", "hash-token", "anna", "write", "--generate", "more"},
    };
    static const char *const right[] = {"draped", "hash-token", "anna", "read"};
    char out[2000] = "", err[2000] = "", token[1200];
    (void)state;
    for (size_t k = 0; k < COUNT(wrong); k++) {
        int count = 0;
        while (count < 6 && wrong[k][count])
            count++;
        assert_int_equal(command(wrong[k], count, "secret\n", out, err), 2);
        assert_memory_equal(err, "usage: ", 7);
        assert_string_equal(out, "");
    }
    assert_int_equal(command(right, 4, "", out, err), 2);
    assert_int_equal(command(right, 4, "se cret\n", out, err), 2);
    assert_non_null(strstr(err, "a token is one line of letters"));
    assert_int_equal(command(right, 4, "sec`ret\n", out, err), 2);
    assert_int_equal(command(right, 4, "s-._~+/=\n", out, err), 0);
    for (int length = 1018; length < 1028; length++) { /* a line that the buffer cuts is refused */
        snprintf(token, sizeof token, "%0*d\n", length, 0);
        assert_int_equal(command(right, 4, token, out, err), length <= 1022 ? 0 : 2);
    }
}

/* ------------------------------------------------------------------ access */

enum { NO_LINK, LINK };

static void test_access_allows_what_the_role_may(void **state) {
    static const struct {
        const char *credentials;
        enum tokens_role needed;
        bool shown;
        int status; /* 0: allowed */
        const char *caller;
        bool sees_all;
        const char *challenge;
    } rows[] = {
        {"Bearer secret", TOKENS_READ, NO_LINK, 0, "anna", false, NULL},
        {"bEARER   secret", TOKENS_WRITE, NO_LINK, 0, "anna", false, NULL},
        {"Bearer secret", TOKENS_ADMIN, NO_LINK, 403, "anna", false,
         "Bearer realm=\"draped\", error=\"insufficient_scope\", scope=\"admin\""},
        {"Bearer other", TOKENS_ADMIN, NO_LINK, 0, "boss", true, NULL},
        {"Bearer third", TOKENS_READ, NO_LINK, 0, "eve", false, NULL},
        {"Bearer third", TOKENS_WRITE, NO_LINK, 403, "eve", false,
         "Bearer realm=\"draped\", error=\"insufficient_scope\", scope=\"write\""},
        {"Bearer wrong", TOKENS_READ, NO_LINK, 401, "", false,
         "Bearer realm=\"draped\", error=\"invalid_token\""},
        {"Bearer ", TOKENS_READ, NO_LINK, 401, "", false,
         "Bearer realm=\"draped\", error=\"invalid_token\""},
        {"Bearer", TOKENS_READ, NO_LINK, 401, "", false, "Bearer realm=\"draped\""},
        {"Basic secret", TOKENS_READ, NO_LINK, 401, "", false, "Bearer realm=\"draped\""},
        {"Bearer draped-link-x", TOKENS_READ, LINK, 0, "", false, NULL},
        {"Bearer draped-link-x", TOKENS_READ, NO_LINK, 403, "", false,
         "Bearer realm=\"draped\", error=\"insufficient_scope\", scope=\"read\""},
        {"Bearer draped-lin", TOKENS_READ, LINK, 401, "", false,
         "Bearer realm=\"draped\", error=\"invalid_token\""},
    };
    char why[TOKENS_WHY_SIZE];
    (void)state;
    struct tokens *tokens =
        open_text("anna:write:" SECRET "\nboss:admin:" OTHER
                  "\neve:read:e6d730d2a2a0c6b56b3777385445c535480c42dc5bbc7bdef791c2bd37773af0\n",
                  why);
    assert_non_null(tokens);
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct request request = {.headers = {{"Authorization", rows[k].credentials}},
                                  .header_count = 1};
        struct reply reply = {.request_id = ""};
        bool good = access_allow(tokens, &request, rows[k].needed, rows[k].shown, &reply);
        if (good != !rows[k].status || reply.status != rows[k].status)
            fail_msg("'%s' is %d", rows[k].credentials, reply.status);
        assert_string_equal(request.caller, rows[k].caller);
        assert_string_equal(request.owner, rows[k].caller);
        assert_int_equal(request.sees_all, rows[k].sees_all);
        assert_int_equal(request.link != NULL,
                         !strcmp(rows[k].credentials, "Bearer draped-link-x"));
        assert_int_equal(reply_has_header(&reply, "WWW-Authenticate"), rows[k].challenge != NULL);
        if (rows[k].challenge)
            assert_string_equal(reply.headers[0].value, rows[k].challenge);
        reply_clear(&reply);
    }
    tokens_free(tokens);
}

/* Without a file every call is allowed and sees all, but one with a link no more than elsewhere. */
static void test_access_without_tokens(void **state) {
    struct request request = {.header_count = 0};
    struct request link = {.headers = {{"Authorization", "Bearer draped-link-x"}},
                           .header_count = 1};
    struct reply reply = {.request_id = ""};
    (void)state;
    assert_true(access_allow(NULL, &request, TOKENS_ADMIN, false, &reply));
    assert_true(request.sees_all && !request.caller[0] && access_holds(NULL, &request));
    assert_true(access_allow(NULL, &link, TOKENS_READ, true, &reply));
    assert_true(!link.sees_all && link.link);
    assert_false(access_allow(NULL, &link, TOKENS_READ, false, &reply));
    assert_int_equal(reply.status, 403);
    reply_clear(&reply);
}

static bool still_holds(struct tokens *tokens, const struct request *request, const char *text) {
    char why[TOKENS_WHY_SIZE];
    write_file(text);
    assert_true(tokens_reload(tokens, why));
    return access_holds(tokens, request);
}

static void test_access_ends_with_the_token_or_its_role(void **state) {
    struct request anna = {.headers = {{"Authorization", "Bearer secret"}}, .header_count = 1};
    struct request boss = {.headers = {{"Authorization", "Bearer other"}}, .header_count = 1};
    struct request link = {.headers = {{"Authorization", "Bearer draped-link-x"}},
                           .header_count = 1};
    struct reply reply = {.request_id = ""};
    char why[TOKENS_WHY_SIZE];
    (void)state;
    struct tokens *tokens = open_text("anna:write:" SECRET "\nboss:admin:" OTHER, why);
    assert_true(access_allow(tokens, &anna, TOKENS_READ, false, &reply));
    assert_true(access_allow(tokens, &boss, TOKENS_READ, false, &reply));
    assert_true(access_allow(tokens, &link, TOKENS_READ, true, &reply));
    assert_true(access_holds(tokens, &anna) && access_holds(tokens, &boss));
    assert_true(access_holds(tokens, &link));
    assert_true(still_holds(tokens, &anna, "anna:read:" SECRET));
    assert_false(still_holds(tokens, &anna, "anne:write:" SECRET));
    assert_false(still_holds(tokens, &anna, "anna:write:" OTHER));
    assert_true(still_holds(tokens, &boss, "boss:admin:" OTHER));
    assert_false(still_holds(tokens, &boss, "boss:write:" OTHER));
    anna.header_count = 0;
    assert_false(access_holds(tokens, &anna));
    tokens_free(tokens);
    reply_clear(&reply);
}

static void test_access_marks_answers_as_private(void **state) {
    struct reply reply = {.request_id = ""};
    (void)state;
    access_mark(&reply);
    assert_int_equal(reply.header_count, 2);
    assert_string_equal(reply.headers[0].value, "private");
    assert_string_equal(reply.headers[1].name, "Vary");
    assert_string_equal(reply.headers[1].value, "Authorization");
    reply = (struct reply){.request_id = ""};
    reply_header(&reply, "Cache-Control", "no-store");
    access_mark(&reply);
    assert_int_equal(reply.header_count, 2);
    assert_string_equal(reply.headers[0].value, "no-store");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tokens_reads_its_file),
        cmocka_unit_test(test_tokens_knows_how_long_things_may_be),
        cmocka_unit_test(test_tokens_refuses_files_that_are_wrong),
        cmocka_unit_test(test_tokens_are_limited),
        cmocka_unit_test(test_tokens_reloads_or_stays_as_it_is),
        cmocka_unit_test(test_tokens_are_made_at_random),
        cmocka_unit_test(test_tokens_command_writes_a_line),
        cmocka_unit_test(test_tokens_command_refuses),
        cmocka_unit_test(test_access_allows_what_the_role_may),
        cmocka_unit_test(test_access_without_tokens),
        cmocka_unit_test(test_access_ends_with_the_token_or_its_role),
        cmocka_unit_test(test_access_marks_answers_as_private),
    };
    return cmocka_run_group_tests_name("tokens", tests, make_file, remove_file);
}
