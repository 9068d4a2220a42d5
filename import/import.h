/* SPDX-License-Identifier: MIT */
/*
 * The C face of what Open CASCADE does: a CAD file's bytes become the document of a surface. The
 * functions read no file and print nothing; what they need of the system is memory, so that they
 * may be called in a sandbox.
 */
#ifndef CLI_IMPORT_IMPORT_H
#define CLI_IMPORT_IMPORT_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The largest degree and number of control points in a direction; `solver/surface/nurbs.h`. */
enum { IMPORT_DEGREE_MAX = 9, IMPORT_SIZE_MAX = 512 };

struct import_order {
    const char *format; /* "step" or "iges" */
    const char *bytes;
    size_t length;
    const char *unit; /* of a file that states none; "": mm */
    const int *faces; /* their numbers, rising; `face_count` 0: all */
    size_t face_count;
    bool list; /* what the file holds, in place of the surface */
};

enum { IMPORT_WHY_SIZE = 240 };

struct import_answer {
    char *text; /* malloc'ed; NULL when it failed */
    size_t length;
    char why[IMPORT_WHY_SIZE]; /* a sentence, when it failed */
};

/* False when the file cannot be imported. Memory that runs out ends the same way. */
bool import_cad(const struct import_order *order, struct import_answer *answer);

/* What the libraries would look up in files when they are first used. */
void import_prepare(void);

#ifdef __cplusplus
}
#endif

#endif
