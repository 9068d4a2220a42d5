/* SPDX-License-Identifier: MIT */
/*
 * The callers that are allowed: a file of one `name:role:hash` a line. The name is the owner of
 * what the caller stores; several lines may have the same one, for tokens of different roles or
 * while one is replaced. The hash is BLAKE2b-256 of the token in hexadecimal. A slow hash, made for
 * passwords, would add nothing: tokens are random (TOKENS_RANDOM_BYTES of them are what `draped
 * hash-token
 * --generate` makes), so that none is found by trying, and each request is hashed once more.
 * Blank lines and lines that begin with # are skipped.
 */
#ifndef SERVER_HTTP_TOKENS_H
#define SERVER_HTTP_TOKENS_H

#include "server/id.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum {
    TOKENS_NAME_SIZE = 65, /* 1 to 64 letters, digits or any of "._-", and the final zero */
    TOKENS_MAX = 10000,    /* lines of a file: every one is compared with every request */
    TOKENS_WHY_SIZE = 320,
    TOKENS_RANDOM_BYTES = 32,
    TOKENS_RANDOM_SIZE = 44 /* of these in base64, and the final zero */
};

/* Each may do what those before it may: see its own things, store and delete them, do both with
 * everybody's. */
enum tokens_role { TOKENS_READ, TOKENS_WRITE, TOKENS_ADMIN };

struct tokens_holder {
    char name[TOKENS_NAME_SIZE];
    enum tokens_role role;
};

struct tokens;

/* Reads the file, which is remembered for `tokens_reload`. NULL with a sentence in `why`, which
 * names the file and, where it can, the line. */
struct tokens *tokens_open(const char *path, char why[TOKENS_WHY_SIZE]);

/* NULL is allowed. */
void tokens_free(struct tokens *tokens);

/* Reads the file again. When that fails all stays as it was, and `why` says why. Any thread. */
bool tokens_reload(struct tokens *tokens, char why[TOKENS_WHY_SIZE]);

/* How often that has succeeded: holders may have changed since it was less. Any thread. */
int64_t tokens_reloads(struct tokens *tokens);

/* How many there are. */
size_t tokens_count(struct tokens *tokens);

/* The holder of the token; false when it has none. The time it takes does not depend on what the
 * token has in common with any line. Any thread. */
bool tokens_find(struct tokens *tokens, const char *token, struct tokens_holder *holder);

/* A new token. Any thread. */
void tokens_make(char token[TOKENS_RANDOM_SIZE]);

/* A short hash of a token, as an id, from which it cannot be found. */
void tokens_name(const char *token, char id[ID_SIZE]);

/* `draped hash-token NAME ROLE [--generate]`, argv[2] being NAME: writes the line of the token that
 * is read from `in`, or of a new one, which is printed on `err`. The process's exit code. */
int tokens_command(int argc, char **argv, FILE *in, FILE *out, FILE *err);

#endif
