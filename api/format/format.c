/* SPDX-License-Identifier: MIT */
#include "format.h"

#include "api/json/number.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* The registry; of each use the default first. */
#define FORMATS(X)                                                                                 \
    X(json)                                                                                        \
    X(csv)                                                                                         \
    X(vtp)                                                                                         \
    X(glb)                                                                                         \
    X(npz)                                                                                         \
    X(vtu)                                                                                         \
    X(lcmsim)                                                                                      \
    X(lcmsim_h5)                                                                                   \
    X(nastran)                                                                                     \
    X(optistruct)                                                                                  \
    X(radioss)                                                                                     \
    X(lsdyna)                                                                                      \
    X(abaqus)                                                                                      \
    X(calculix)                                                                                    \
    X(svg)                                                                                         \
    X(dxf)                                                                                         \
    X(html)

#define DECLARE(name) extern const struct format format_##name;
#define LIST(name) &format_##name,
FORMATS(DECLARE)
static const struct format *const formats[] = {FORMATS(LIST)};

enum { COUNT = sizeof formats / sizeof *formats };

const struct format *format_at(enum format_use use, size_t index) {
    for (size_t k = 0; k < COUNT; k++)
        if (formats[k]->uses & use && index-- == 0)
            return formats[k];
    return NULL;
}

const struct format *format_named(enum format_use use, const char *name) {
    for (size_t k = 0; k < COUNT; k++)
        if (formats[k]->uses & use && strcmp(name, formats[k]->name) == 0)
            return formats[k];
    return NULL;
}

const struct format *format_for_media_type(enum format_use use, const char *media_type) {
    for (size_t k = 0; k < COUNT; k++)
        if (formats[k]->uses & use && strcasecmp(media_type, formats[k]->media_type) == 0)
            return formats[k];
    return NULL;
}

/* ---- options ---- */

static bool set_precision(struct format_options *options, const char *value,
                          struct api_problem *problem) {
    char *end;
    long digits = strtol(value, &end, 10);
    if (*value >= '0' && *value <= '9' && *end == '\0' && digits >= 1 &&
        digits <= API_PRECISION_EXACT) {
        options->precision = (int)digits;
        return true;
    }
    api_problem_set(problem, API_INVALID_REQUEST, "precision must be a whole number from 1 to %d",
                    API_PRECISION_EXACT);
    return false;
}

static bool set_table(struct format_options *options, const char *value,
                      struct api_problem *problem) {
    static const enum api_table tables[] = {API_TABLE_NODES, API_TABLE_CELLS, API_TABLE_PLIES,
                                            API_TABLE_VARIANTS, API_TABLE_BANDS};
    for (size_t k = 0; k < sizeof tables / sizeof *tables; k++) {
        if (strcmp(value, api_table_name(tables[k])) == 0) {
            options->table = tables[k];
            options->table_given = true;
            return true;
        }
    }
    api_problem_set(
        problem, API_INVALID_REQUEST,
        "table must be nodes or cells, of a map cells or plies, of a study variants or bands");
    return false;
}

static bool set_lcmsim_version(struct format_options *options, const char *value,
                               struct api_problem *problem) {
    if ((*value == '2' || *value == '3') && value[1] == '\0') {
        options->lcmsim_version = *value - '0';
        return true;
    }
    api_problem_set(problem, API_INVALID_REQUEST, "lcmsim_version must be 2 or 3");
    return false;
}

/* A number from `least` to `most`, both included; `what` it must be. */
static bool set_number(double *option, const char *value, double least, double most,
                       const char *what, struct api_problem *problem) {
    double number;
    size_t length = strlen(value);
    if (length > 0 && api_number_read(value, length, &number) == length && number >= least &&
        number <= most) {
        *option = number;
        return true;
    }
    api_problem_set(problem, API_INVALID_REQUEST, "%s", what);
    return false;
}

static bool set_fraction(struct format_options *options, const char *value,
                         struct api_problem *problem) {
    return set_number(&options->fiber_volume_fraction, value, DBL_MIN, 1 - DBL_EPSILON / 2,
                      "at_most_fiber_volume_fraction must be a number between 0 and 1", problem);
}

static bool set_allowance(struct format_options *options, const char *value,
                          struct api_problem *problem) {
    return set_number(&options->allowance, value, 0, 1e12,
                      "allowance must be a number from 0 on, in the drape's length unit", problem);
}

static bool set_within(struct format_options *options, const char *value,
                       struct api_problem *problem) {
    return set_number(&options->within, value, 0, 10,
                      "within must be a number from 0 to 10, in degrees and percent of thickness",
                      problem);
}

/* Names are printed: of ASCII what needs no escaping anywhere. */
static bool set_name(char name[FORMAT_NAME_SIZE], const char *option, const char *value,
                     struct api_problem *problem) {
    bool plain = strlen(value) < FORMAT_NAME_SIZE;
    for (const char *at = value; *at; at++)
        plain = plain && *at >= ' ' && *at <= '~' && !strchr("<>&\"'%", *at);
    if (plain) {
        strcpy(name, value);
        return true;
    }
    api_problem_set(problem, API_INVALID_REQUEST,
                    "%s must have at most %d characters of ASCII, none of <>&\"'%%", option,
                    FORMAT_NAME_SIZE - 1);
    return false;
}

bool format_option(struct format_options *options, const char *name, const char *value,
                   struct api_problem *problem) {
    if (strcmp(name, "precision") == 0)
        return set_precision(options, value, problem);
    if (strcmp(name, "table") == 0)
        return set_table(options, value, problem);
    if (strcmp(name, "lcmsim_version") == 0)
        return set_lcmsim_version(options, value, problem);
    if (strcmp(name, "at_most_fiber_volume_fraction") == 0)
        return set_fraction(options, value, problem);
    if (strcmp(name, "within") == 0)
        return set_within(options, value, problem);
    if (strcmp(name, "allowance") == 0)
        return set_allowance(options, value, problem);
    if (strcmp(name, "part") == 0 || strcmp(name, "ply") == 0)
        return set_name(name[1] == 'a' ? options->part : options->ply, name, value, problem);
    if (strcmp(name, "fields") != 0)
        return false;
    options->fields = value;
    return true;
}
