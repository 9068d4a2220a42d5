/* SPDX-License-Identifier: MIT */
/*
 * The settings one by one: the flag, variable, default, range and help of each member of `struct
 * config`, and how text becomes its value. What they have to be together is checked in config.c.
 */
#ifndef SERVER_FLAGS_H
#define SERVER_FLAGS_H

#include "config.h"
#include <stdio.h>

enum { FLAGS_HELP_COLUMN = 34 }; /* of the text of --help, after the flags */

/* A number whose default is computed from others. */
#define FLAGS_UNSET INT64_C(-1)

enum flags_taken {
    FLAGS_TAKEN,
    FLAGS_OTHER, /* no flag of these */
    FLAGS_BAD    /* a message is on stderr */
};

/* Prints a message on stderr; always false. */
bool config_report(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Sets all members by the environment, else to their defaults; with `store_alone` only --data and
 * --store, the others to zero. False with a message on stderr. */
bool flags_set_defaults(struct config *config, bool store_alone);

/* Takes the flag at argv[*at], and its value, which may be the next argument: `*at` is then that.
 */
enum flags_taken flags_take(struct config *config, char **argv, int argc, int *at,
                            bool store_alone);

/* The lines of --help. */
void flags_help(FILE *out);

/* What would be used, one `name = value` a line; no store URL, which may hold a password. */
void flags_print(const struct config *config, FILE *out);

#endif
