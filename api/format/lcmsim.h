/* SPDX-License-Identifier: MIT */
/*
 * A case for LCMsim (v2 and v3): a zip with mesh.bdf, part_description.csv, simulation_params.csv
 * and README.txt, in SI units. LCMsim takes properties by part, and has few of them; so elements
 * that are alike share one. README.txt in the zip says how much they differ at most.
 */
#ifndef API_FORMAT_LCMSIM_H
#define API_FORMAT_LCMSIM_H

#include "format.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    LCMSIM_BINS_MAX = 125,
    LCMSIM_FIRST_PART = 2, /* of the bins */
    LCMSIM_INLET_PART = 1,
    LCMSIM_NUMBER_MAX = 99999999 /* what a field of 8 digits holds */
};

/* The local inputs of one element, or the area-weighted mean of a bin. */
struct lcmsim_inputs {
    double thickness, porosity;
    double k1, k2, k3;
    struct vec3 direction; /* of k1, a unit vector; its sign means nothing */
};

struct lcmsim_bins {
    size_t count;
    struct lcmsim_inputs bin[LCMSIM_BINS_MAX];
    bool has_inlet;
    struct lcmsim_inputs inlet;
    uint8_t *part; /* of each element, malloc'ed */
    /* The largest differences between an element and its bin. */
    double direction_deg; /* in the element's plane, where k2/k1 < LCMSIM_ISOTROPIC */
    double k1, thickness; /* relative to the bin's */
};

/* A permeability that differs less than this by direction has none that matters. */
static const double LCMSIM_ISOTROPIC = 0.99;

/* The columns of an element's inputs, in the order of `struct lcmsim_inputs`. */
enum { LCMSIM_COLUMNS = 8 };
void lcmsim_column_names(const char *names[LCMSIM_COLUMNS]);

/* Whether a case can be made of the fields: all columns are there, and every element has a
 * thickness, pores and a permeability that are positive, as LCMsim's equations need. False with the
 * problem set: API_INVALID_REQUEST or API_TOO_LARGE. */
bool lcmsim_check(const struct map_fields *fields, struct api_problem *problem);

/* Puts the elements of the mesh into bins: the one with the largest area-weighted variance of
 * (k1 direction weighted by anisotropy, log k1, log thickness, k2/k1, porosity) is cut at its mean
 * until there are enough, or all that are in one are alike. False without memory. */
bool lcmsim_make_bins(struct lcmsim_bins *bins, const struct map_fields *fields);
void lcmsim_free_bins(struct lcmsim_bins *bins);

/* A number in a bulk-data field of 8 characters: the closest plain decimal, or with a signed
 * exponent and no letter ("1.2346-4"), right-aligned. */
void lcmsim_field(double value, char field[8]);

#endif
