/* SPDX-License-Identifier: MIT */
#include "tokens.h"
#include <errno.h>
#include <pthread.h>
#include <sodium.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    HASH_BYTES = 32,
    LINE_SIZE = 256,
    TOKEN_SIZE = 1024,
    SHORT_TOKEN = 22 /* characters of base64 that hold 128 bits: fewer might be guessed */
};

struct entry {
    struct tokens_holder holder;
    unsigned char hash[HASH_BYTES];
};

struct table {
    struct entry *entries;
    size_t count;
};

struct tokens {
    char *path;
    atomic_int_fast64_t reloads;
    pthread_rwlock_t lock; /* of the table */
    struct table table;
};

static const char *const roles[] = {"read", "write", "admin"};

/* Always false. */
__attribute__((format(printf, 2, 3))) static bool explain_tokens(char why[TOKENS_WHY_SIZE],
                                                                 const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, TOKENS_WHY_SIZE, format, arguments);
    va_end(arguments);
    return false;
}

static void hash_token(const char *token, unsigned char hash[HASH_BYTES]) {
    crypto_generichash(hash, HASH_BYTES, (const unsigned char *)token, strlen(token), NULL, 0);
}

/* ------------------------------------------------------------------ a line */

/* Whether the text is 1 to `longest` letters, digits or any of the marks. */
static bool consists_of(const char *text, const char *marks, size_t longest) {
    size_t length = 0;
    for (const char *c = text; *c; c++, length++)
        if (!((*c >= '0' && *c <= '9') || ((*c | 32) >= 'a' && (*c | 32) <= 'z') ||
              strchr(marks, *c)))
            return false;
    return length > 0 && length <= longest;
}

static bool read_name(const char *text, struct tokens_holder *holder) {
    if (!consists_of(text, "._-", TOKENS_NAME_SIZE - 1))
        return false;
    memcpy(holder->name, text, strlen(text) + 1);
    return true;
}

static bool read_role(const char *text, struct tokens_holder *holder) {
    for (size_t k = 0; k < sizeof roles / sizeof *roles; k++)
        if (!strcmp(text, roles[k])) {
            holder->role = (enum tokens_role)k;
            return true;
        }
    return false;
}

/* Adds a line to the table; the reason why it cannot, or NULL. Reasons hold nothing of the line: it
 * may be a token that was put there by mistake. Two lines of one token would make its owner
 * ambiguous. */
static const char *add_token_line(struct table *table, char *line) {
    struct entry entry;
    char *name = strsep(&line, ":"), *role = strsep(&line, ":"), *hash = line;
    if (!role || !hash)
        return "is not name:role:hash; draped hash-token makes such lines";
    if (!read_name(name, &entry.holder))
        return "has no name of 1 to 64 letters, digits, '.', '_' or '-'";
    if (!read_role(role, &entry.holder))
        return "has a role other than read, write and admin";
    size_t length = 0; /* what is not hexadecimal ends it early */
    if (strlen(hash) != 2 * HASH_BYTES ||
        sodium_hex2bin(entry.hash, HASH_BYTES, hash, 2 * HASH_BYTES, NULL, &length, NULL) != 0 ||
        length != HASH_BYTES)
        return "has no hash of 64 hexadecimal digits; draped hash-token makes it";
    if (table->count == TOKENS_MAX)
        return "exceeds the limit of 10000 tokens";
    for (size_t k = 0; k < table->count; k++)
        if (!memcmp(table->entries[k].hash, entry.hash, HASH_BYTES))
            return "has the hash of an earlier line";
    struct entry *grown = realloc(table->entries, (table->count + 1) * sizeof *grown);
    if (!grown)
        return "does not fit into memory";
    table->entries = grown;
    grown[table->count++] = entry;
    return NULL;
}

/* ------------------------------------------------------------------ the file */

static void cut_blanks(char *line) {
    size_t length = strlen(line);
    while (length > 0 && strchr(" \t\r\n", line[length - 1]))
        line[--length] = '\0';
}

/* The tokens of the file; false, and nothing is kept, with a sentence in `why`. */
static bool load_tokens(const char *path, struct table *table, char why[TOKENS_WHY_SIZE]) {
    char line[LINE_SIZE];
    bool good = true;
    *table = (struct table){NULL, 0};
    FILE *file = fopen(path, "re");
    if (!file)
        return explain_tokens(why, "%.128s cannot be read: %s", path, strerror(errno));
    for (int number = 1; good && fgets(line, sizeof line, file); number++) {
        bool cut = !strchr(line, '\n') && !feof(file);
        cut_blanks(line);
        if ((!cut && !line[0]) || line[0] == '#') {
            for (int c = 0; cut && c != EOF && c != '\n';) /* a long comment goes on */
                c = getc(file);
            continue;
        }
        const char *fault = cut ? "is too long" : add_token_line(table, line);
        if (fault)
            good = explain_tokens(why, "%.128s: line %d %s", path, number, fault);
    }
    if (good && ferror(file))
        good = explain_tokens(why, "%.128s cannot be read: %s", path, strerror(errno));
    else if (good && table->count == 0)
        good = explain_tokens(why, "%.128s has no token, so no caller would be accepted", path);
    fclose(file);
    if (!good)
        free(table->entries);
    return good;
}

struct tokens *tokens_open(const char *path, char why[TOKENS_WHY_SIZE]) {
    struct table table;
    if (!load_tokens(path, &table, why))
        return NULL;
    struct tokens *tokens = calloc(1, sizeof *tokens);
    char *copy = strdup(path);
    if (!tokens || !copy) {
        explain_tokens(why, "there is no memory");
        free(tokens);
        free(copy);
        free(table.entries);
        return NULL;
    }
    tokens->path = copy;
    tokens->table = table;
    pthread_rwlock_init(&tokens->lock, NULL);
    return tokens;
}

void tokens_free(struct tokens *tokens) {
    if (!tokens)
        return;
    pthread_rwlock_destroy(&tokens->lock);
    free(tokens->table.entries);
    free(tokens->path);
    free(tokens);
}

bool tokens_reload(struct tokens *tokens, char why[TOKENS_WHY_SIZE]) {
    struct table table, old;
    if (!load_tokens(tokens->path, &table, why))
        return false;
    pthread_rwlock_wrlock(&tokens->lock);
    old = tokens->table;
    tokens->table = table;
    atomic_fetch_add(&tokens->reloads, 1);
    pthread_rwlock_unlock(&tokens->lock);
    free(old.entries);
    return true;
}

int64_t tokens_reloads(struct tokens *tokens) {
    return atomic_load(&tokens->reloads);
}

size_t tokens_count(struct tokens *tokens) {
    pthread_rwlock_rdlock(&tokens->lock);
    size_t count = tokens->table.count;
    pthread_rwlock_unlock(&tokens->lock);
    return count;
}

bool tokens_find(struct tokens *tokens, const char *token, struct tokens_holder *holder) {
    unsigned char hash[HASH_BYTES];
    size_t found = SIZE_MAX;
    hash_token(token, hash);
    pthread_rwlock_rdlock(&tokens->lock);
    for (size_t k = 0; k < tokens->table.count; k++) /* all of them, whatever is found */
        if (sodium_memcmp(tokens->table.entries[k].hash, hash, HASH_BYTES) == 0)
            found = k;
    if (found != SIZE_MAX)
        *holder = tokens->table.entries[found].holder;
    pthread_rwlock_unlock(&tokens->lock);
    return found != SIZE_MAX;
}

void tokens_make(char token[TOKENS_RANDOM_SIZE]) {
    unsigned char random[TOKENS_RANDOM_BYTES];
    randombytes_buf(random, sizeof random);
    sodium_bin2base64(token, TOKENS_RANDOM_SIZE, random, sizeof random,
                      sodium_base64_VARIANT_URLSAFE_NO_PADDING);
    sodium_memzero(random, sizeof random);
}

void tokens_name(const char *token, char id[ID_SIZE]) {
    unsigned char hash[(ID_SIZE - 1) / 2];
    crypto_generichash(hash, sizeof hash, (const unsigned char *)token, strlen(token), NULL, 0);
    sodium_bin2hex(id, ID_SIZE, hash, sizeof hash);
}

/* ------------------------------------------------------------------ draped hash-token */

int tokens_command(int argc, char **argv, FILE *in, FILE *out, FILE *err) {
    static const char usage[] =
        "usage: draped hash-token NAME read|write|admin [--generate]\n"
        "Writes a line for the file of --tokens: of the token on standard input, or of a new one,\n"
        "which --generate prints on standard error, this once. Tokens must be random: what is "
        "kept\n"
        "of them is a fast hash.\n";
    struct tokens_holder holder;
    unsigned char hash[HASH_BYTES];
    char token[TOKEN_SIZE], hex[2 * HASH_BYTES + 1];
    bool generate = argc == 5 && !strcmp(argv[4], "--generate");
    if ((argc != 4 && !generate) || !read_name(argv[2], &holder) || !read_role(argv[3], &holder)) {
        fputs(usage, err);
        return 2;
    }
    token[0] = '\0';
    if (generate) {
        tokens_make(token);
        fprintf(err, "the token: %s\n", token);
    } else if (fgets(token, sizeof token, in)) {
        cut_blanks(token);
    }
    if (!consists_of(token, "-._~+/=", TOKEN_SIZE - 2)) { /* behind "Bearer" (RFC 6750, 2.1) */
        fputs("draped: a token is one line of letters, digits or any of -._~+/=\n", err);
        return 2;
    }
    if (strlen(token) < SHORT_TOKEN)
        fputs("draped: this token is so short that it could be guessed; --generate makes a good "
              "one\n",
              err);
    hash_token(token, hash);
    sodium_bin2hex(hex, sizeof hex, hash, sizeof hash);
    fprintf(out, "%s:%s:%s\n", holder.name, roles[holder.role], hex);
    sodium_memzero(token, sizeof token);
    return fflush(out) == 0 ? 0 : 1;
}
