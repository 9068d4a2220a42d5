/* SPDX-License-Identifier: MIT */
/* The command line of drape: what its options say, and its help. */
#ifndef CLI_ARGUMENTS_H
#define CLI_ARGUMENTS_H

#include "api/format/format.h"
#include "api/laminate/patterns.h"
#include "api/request/digest.h"
#include "material.h"

enum { EXIT_USAGE = 2 };

/* What is said of the mesh: the names of its options. */
enum { MESH_OPTIONS = 6 };
extern const char *const arguments_mesh[MESH_OPTIONS];

struct arguments {
    const char *input, *output;     /* NULL: standard input, standard output */
    const char *map;                /* NULL: no mesh */
    const char *mesh[MESH_OPTIONS]; /* values of arguments_mesh; NULL: not given */
    const char *variant;            /* of a study: whose request is wanted; NULL: its result is */
    bool study;                     /* the request is one */
    struct material_files materials;
    const char *table; /* to hold values out of; NULL: a drape */
    const char *format_name;
    const struct format *format;
    struct format_options options;
    struct laminate_roll roll; /* of a laminate's patterns; `partial` is in the options */
    struct api_limits limits;
    char id[API_ID_SIZE]; /* that the service would know the result by */
};

/* Fills the arguments from the command line. -1, or the exit status when there is nothing to run:
 * help was asked for and has been printed, or what is wrong has been said. */
int arguments_parse(struct arguments *arguments, int argc, char **argv);

/* The name of the service's parameter that an option stands for, which has low lines where the
 * option has dashes; until the next call. */
const char *arguments_parameter(const char *option);

#endif
