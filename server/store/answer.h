/* SPDX-License-Identifier: MIT */
/*
 * How a call of the store ended: the words that the store, its backends and their databases share.
 * They are kept apart from the problems of a request.
 */
#ifndef SERVER_STORE_ANSWER_H
#define SERVER_STORE_ANSWER_H

#include <stdbool.h>

enum store_answer {
    STORE_OK = 0,
    STORE_EMPTY,    /* nothing of that name, or nothing to hand out */
    STORE_CONFLICT, /* it exists, and its state forbids this */
    STORE_FULL,     /* a limit of the queue or of the owner is reached (submit only) */
    STORE_ALTERED,  /* what is stored under the name is not what was written (logged) */
    /* Failures of the database, logged: 503. */
    STORE_BUSY,      /* it was locked for too long: try again */
    STORE_DOWN,      /* it cannot be used; these say why: */
    STORE_NO_SPACE,  /* the disk is full */
    STORE_READ_ONLY, /* it cannot be written */
    STORE_DAMAGED,   /* the file is corrupt */
    STORE_MISSING    /* the file was removed, moved or replaced while it was open */
};

#define STORE_MUST_USE __attribute__((warn_unused_result))

/* The answer as a word of the log: "ok", "empty", ..., "out of disk space". */
const char *store_answer_name(enum store_answer answer);

/* Whether the database failed, as opposed to a refusal. */
static inline bool store_failed(enum store_answer answer) {
    return answer >= STORE_BUSY;
}

/* Of a message that says why a store cannot be opened. */
enum { STORE_WHY_SIZE = 512 };

#endif
