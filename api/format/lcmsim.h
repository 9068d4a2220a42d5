/* SPDX-License-Identifier: MIT */
/*
 * A case for LCMsim (v2 and v3): a zip with mesh.bdf, part_description.csv, simulation_params.csv
 * and README.txt, in SI units. LCMsim takes properties by part, and has few of them; so elements
 * that are alike share one. README.txt in the zip says how much they differ at most.
 */
#ifndef API_FORMAT_LCMSIM_H
#define API_FORMAT_LCMSIM_H

#include "format.h"
#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    LCMSIM_BINS_MAX = 125,
    LCMSIM_INLET_PART = 1,
    LCMSIM_FIRST_PART = 2, /* of the bins */
    LCMSIM_OUTLET_PART = LCMSIM_FIRST_PART + LCMSIM_BINS_MAX,
    LCMSIM_CHANNEL_PART = LCMSIM_OUTLET_PART - 1, /* in place of the last bin */
    LCMSIM_COLUMNS = 8,                           /* that an element's inputs come from */
    LCMSIM_NUMBER_MAX = 99999999                  /* what a field of 8 digits holds */
};

/* The local inputs of one element, or the area-weighted mean of a bin. */
struct lcmsim_inputs {
    double thickness, porosity;
    double k1, k2, k3;
    struct vec3 direction;        /* of k1, a unit vector; its sign means nothing */
    double relieved[MAP_RELIEFS]; /* the porosity under those pressures of resin */
};

/* How an element comes into the case. */
enum lcmsim_state {
    LCMSIM_AS_IT_IS,
    LCMSIM_CAPPED,   /* with the cap as its fibre volume fraction: it is denser */
    LCMSIM_LEFT_OUT, /* too dense to be filled: a wall to the flow */
};

/* Where the inputs come from. */
struct lcmsim_source {
    const struct map_fields *fields;
    const struct api_column_source *column[LCMSIM_COLUMNS], *packing; /* packing: or NULL */
    double cap;                  /* the largest fibre volume fraction; 0: there is none */
    bool has_capped;             /* there is an element that the inputs at the cap follow from */
    struct lcmsim_inputs capped; /* but for thickness and direction, which are an element's own */
};

enum lcmsim_difference {
    LCMSIM_DIRECTION, /* degrees in the element's plane, where k2/k1 < LCMSIM_ISOTROPIC */
    LCMSIM_K1,        /* relative to the bin's, as the next two */
    LCMSIM_K2,
    LCMSIM_THICKNESS,
    LCMSIM_POROSITY, /* absolute */
    LCMSIM_DIFFERENCES
};

struct lcmsim_bins {
    size_t count;
    struct lcmsim_inputs bin[LCMSIM_BINS_MAX];
    size_t role_count[MAP_ROLES]; /* elements of the inlet, the outlet, the channel */
    struct lcmsim_inputs role[MAP_ROLES];
    uint8_t *part;           /* of each element, 0 when left out; malloc'ed */
    size_t left_out, capped; /* elements */
    /* How much elements differ from their bins: the largest, and the bound that holds for 95 % of
     * the area (to a thousandth of the largest, rounded up). */
    double largest[LCMSIM_DIFFERENCES], most[LCMSIM_DIFFERENCES];
};

/* LCMsim refuses a larger porosity. */
static const double LCMSIM_POROSITY_MAX = 0.99;

/* A permeability that differs less than this by direction has none that matters. */
static const double LCMSIM_ISOTROPIC = 0.99;

/* Finds the columns. With a cap > 0 denser elements take part with the cap as their fibre volume
 * fraction: their permeability is that of the densest element below it, scaled to the cap by Kozeny
 * and Carman. False with the problem set: API_INVALID_REQUEST (a column is missing, nothing can be
 * filled) or API_TOO_LARGE. `fields` outlive the source. */
bool lcmsim_open(struct lcmsim_source *source, const struct map_fields *fields, double cap,
                 struct api_problem *problem) STATUS_MUST_USE;

/* The inputs of an element; of one that is left out what it has. */
enum lcmsim_state lcmsim_read(const struct lcmsim_source *source, size_t element,
                              struct lcmsim_inputs *in);

/* Its own fibre volume fraction. */
double lcmsim_fraction(const struct lcmsim_source *source, size_t element);

/* Puts the elements of the mesh into bins: the one with the largest area-weighted variance of
 * (k1 direction weighted by anisotropy, log k1, log thickness, log k2, porosity) is cut at its mean
 * until there are enough, or all that are in one are alike. False without memory. */
bool lcmsim_make_bins(struct lcmsim_bins *bins, const struct lcmsim_source *source) STATUS_MUST_USE;
void lcmsim_free_bins(struct lcmsim_bins *bins);

/* A number in a bulk-data field of 8 characters: the closest plain decimal, or with a signed
 * exponent and no letter ("1.2346-4"), right-aligned. */
void lcmsim_field(double value, char field[8]);

#endif
