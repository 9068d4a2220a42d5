/* SPDX-License-Identifier: MIT */
#include "format.h"

#include "api/json/number.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* The registry; of each use the default first. */
extern const struct format format_json, format_csv, format_vtp, format_glb, format_npz, format_vtu,
    format_lcmsim, format_lcmsim_h5, format_lims, format_nastran, format_optistruct, format_radioss,
    format_lsdyna, format_abaqus, format_calculix, format_abd, format_acp, format_compost,
    format_svg, format_dxf, format_astm, format_hpgl, format_html, format_account, format_laser,
    format_laser_csv, format_virtek, format_bundle, format_gmsh, format_universal;
static const struct format *const formats[] = {
    &format_json,      &format_csv,      &format_vtp,        &format_glb,     &format_npz,
    &format_vtu,       &format_gmsh,     &format_universal,  &format_lcmsim,
#ifndef WITHOUT_HDF5 /* as the shared library is */
    &format_lcmsim_h5,
#endif
    &format_lims,      &format_nastran,  &format_optistruct, &format_radioss, &format_lsdyna,
    &format_abaqus,    &format_calculix, &format_abd,        &format_acp,     &format_compost,
    &format_svg,       &format_dxf,      &format_astm,       &format_hpgl,    &format_html,
    &format_account,   &format_laser,    &format_laser_csv,  &format_virtek,  &format_bundle,
};

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

static bool set_table(struct format_options *options, const char *value) {
    static const enum api_table tables[] = {API_TABLE_NODES,    API_TABLE_CELLS,    API_TABLE_CUTS,
                                            API_TABLE_PLIES,    API_TABLE_VARIANTS, API_TABLE_BANDS,
                                            API_TABLE_PROPOSED, API_TABLE_COURSES};
    for (size_t k = 0; k < sizeof tables / sizeof *tables; k++)
        if (strcmp(value, api_table_name(tables[k])) == 0) {
            options->table = tables[k];
            options->table_given = true;
            return true;
        }
    return false;
}

static bool set_plies_as(struct format_options *options, const char *value) {
    static const char *const names[] = {
        [PLIES_AS_WARP] = "warp", [PLIES_AS_YARNS] = "yarns", [PLIES_AS_BISECTOR] = "bisector"};
    for (int k = PLIES_AS_WARP; k <= PLIES_AS_BISECTOR; k++)
        if (strcmp(value, names[k]) == 0) {
            options->plies_as = (enum format_plies_as)k;
            return true;
        }
    return false;
}

/* A number from `least` to `most`, both included. */
static bool set_number(double *option, const char *value, double least, double most) {
    double number;
    size_t length = strlen(value);
    if (length == 0 || api_number_read(value, length, &number) != length || !(number >= least) ||
        !(number <= most))
        return false;
    *option = number;
    return true;
}

/* A whole number without a sign, likewise. */
static bool set_whole_number(int *option, const char *value, int least, int most) {
    char *end;
    long number = strtol(value, &end, 10);
    if (*value < '0' || *value > '9' || *end != '\0' || number < least || number > most)
        return false;
    *option = (int)number;
    return true;
}

bool format_option(struct format_options *options, const char *name, const char *value,
                   struct api_problem *problem) {
    enum {
        PRECISION,
        TABLE,
        VERSION,
        FRACTION,
        WITHIN,
        PLIES_AS,
        ALLOWANCE,
        PARTIAL,
        PART,
        PLY,
        FIELDS,
        OPTIONS
    };
    static const struct {
        const char *name, *wanted;
    } known[OPTIONS] = {
        [PRECISION] = {"precision", "must be a whole number from 1 to 17"},
        [TABLE] = {"table", "must be nodes or cells; of a map cells or plies; of a study variants, "
                            "bands or proposed"},
        [VERSION] = {"lcmsim_version", "must be 2 or 3"},
        [FRACTION] = {"at_most_fiber_volume_fraction", "must be a number between 0 and 1"},
        [WITHIN] = {"within", "must be a number from 0 to 10, in degrees and percent of thickness"},
        [PLIES_AS] = {"plies_as", "must be yarns, bisector or warp"},
        [ALLOWANCE] = {"allowance", "must be 0 or more, in the drape's length unit"},
        [PARTIAL] = {"partial", "must be 0 or 1"},
        [PART] = {"part", "must have at most 63 ASCII characters, none of them <>&\"'%"},
        [PLY] = {"ply", "must have at most 63 ASCII characters, none of them <>&\"'%"},
        [FIELDS] = {"fields", ""},
    };
    bool good = true;
    int option = 0;
    while (option < OPTIONS && strcmp(name, known[option].name) != 0)
        option++;
    switch (option) {
    case PRECISION:
        good = set_whole_number(&options->precision, value, 1, API_PRECISION_EXACT);
        break;
    case TABLE:
        good = set_table(options, value);
        break;
    case VERSION:
        good = value[0] != '\0' && value[1] == '\0' &&
               set_whole_number(&options->lcmsim_version, value, 2, 3);
        break;
    case FRACTION:
        good = set_number(&options->fiber_volume_fraction, value, DBL_MIN, 1 - DBL_EPSILON / 2);
        break;
    case WITHIN:
        good = set_number(&options->within, value, 0, 10);
        options->within_given = true;
        break;
    case PLIES_AS:
        good = set_plies_as(options, value);
        break;
    case ALLOWANCE:
        good = set_number(&options->allowance, value, 0, 1e12);
        break;
    case PARTIAL:
        good = (value[0] == '0' || value[0] == '1') && value[1] == '\0';
        options->partial = value[0] == '1';
        break;
    case PART:
    case PLY:
        good = strlen(value) < FORMAT_NAME_SIZE;
        for (const char *at = value; *at; at++) /* of ASCII what needs no escaping anywhere */
            good = good && *at >= ' ' && *at <= '~' && !strchr("<>&\"'%", *at);
        if (good)
            strcpy(option == PART ? options->part : options->ply, value);
        break;
    case FIELDS:
        options->fields = value;
        break;
    default:
        return false;
    }
    if (!good)
        api_problem_set(problem, API_INVALID_REQUEST, "%s %s", name, known[option].wanted);
    return good;
}

double format_within(const struct format_options *options) {
    return options->within_given ? options->within : FORMAT_WITHIN;
}
