/* SPDX-License-Identifier: MIT */
/*
 * What a drape is asked for: the method, the spacing, where the net starts and how its two
 * generators run, how far it goes, and what it may use: memory, threads, a monitor.
 *
 * Lengths are in the surface's own unit, angles in degrees where a name ends in `_deg`.
 */
#ifndef SOLVER_SETTINGS_H
#define SOLVER_SETTINGS_H

#include "curvature.h"
#include "method.h"
#include "vec.h"
#include "zero.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum drape_start_kind {
    DRAPE_START_CENTROID, /* the surface point nearest to the centroid of the area; one inside where
                              every yarn leaves that at once, or no cell begins there */
    DRAPE_START_UV,
    DRAPE_START_POINT /* the nearest surface point; an error if further than the spacing */
};

enum drape_direction_kind {
    DRAPE_DIRECTION_ANGLE, /* the direction of zero degrees, turned about r_u x r_v */
    DRAPE_DIRECTION_VECTOR /* projected on the tangent plane at the start */
};

enum drape_generator_kind {
    DRAPE_GENERATOR_GEODESIC,
    DRAPE_GENERATOR_CURVE,   /* a polyline in (u, v) through the start, to 1e-3 of the spacing */
    DRAPE_GENERATOR_PLANE,   /* the section by the plane through the start with this normal */
    DRAPE_GENERATOR_STEERED, /* with this geodesic curvature from the start in its direction */
    DRAPE_GENERATOR_LEAST,   /* steered so that the cloth costs the least energy */
    DRAPE_GENERATOR_PLACES   /* of warp: its nodes, past the last ones geodesics */
};

/* A node of a generator, on the part or on its continuation, and the direction of the yarn there.
 */
struct drape_place {
    int32_t face;      /* on a shell: that uv are parameters of; else 0 */
    double uv[2];      /* the caller's; of closed directions continuous from place to place */
    struct vec3 along; /* tangent towards the next place, of any length */
};

/* Whether two places of a line may be neighbours, by the chord between them in spacings: a chord is
 * shorter than its arc, and the continuation of a part bends, so that places spread there. */
static inline bool drape_place_follows(double chord) {
    return chord >= 0.3 && chord <= 1.5;
}

/* The positive arm of warp runs with the points of its curve, of a plane to that side to which the
 * direction points; the positive arm of weft to the left of it, seen against r_u x r_v. */
struct drape_generator {
    enum drape_generator_kind kind;
    const double (*curve)[2]; /* DRAPE_GENERATOR_CURVE: (u, v) points in order, owned by caller,
                                 straight between them, past their ends a geodesic */
    size_t curve_count;       /* at least 2 */
    struct vec3 plane_normal; /* DRAPE_GENERATOR_PLANE: any length but zero */
    const struct drape_place *places; /* DRAPE_GENERATOR_PLACES: owned by the caller, a spacing
                                         apart along the line (`drape_place_follows`) */
    size_t place_count, place_start;  /* at least 1; which of them is the start, whatever
                                         `start_kind` says: it may lie beyond the part */
    struct drape_curvature curvature; /* DRAPE_GENERATOR_STEERED; of _LEAST its points and the
                                         values to begin at. Lengths of 0: those of the
                                         geodesic's two sides */
};

/* A line over which the cloth is cut, from an edge of the part, of a hole or of a cut before it to
 * its tip inside; each of its places stands for the nearest one of the part (`laid_line.h`). */
struct drape_cut_line {
    const struct vec3 *path; /* owned by the caller, straight between */
    size_t count;            /* at least 2 */
};

/* Several threads for one drape, which the library asks for but does not make. `run` calls
 * task(data, k) for k = 0 .. count - 1, at the same time where it can, and returns when all have.
 * The result has the same bits with any team. */
struct drape_team {
    void (*run)(void *context, int count, void (*task)(void *data, int k), void *data);
    void *context;
};

/* The places of one row of weft, j, without a break from the column next to the start that has one:
 * i = first .. first + count - 1, ghosts beyond the part among them. Lies in the arena of the call.
 */
struct drape_row {
    int32_t j; /* asked for */
    int32_t first;
    struct drape_place *places;
    struct vec3 *r;
    bool *inside;
    size_t count;
};

/* What cloth is to cost the least of (`steer/energy.h`), in any unit of work. */
struct drape_energy {
    const double (*shear_curve)[2]; /* rows of an angle, degrees, rising from 0 or above, and the
                                       force by length, not falling; owned by the caller */
    size_t shear_count;             /* at least 2; 0: work g^2 by area */
    double norm;                    /* p, 1..64; 0: 2 */
    double bending;    /* moment by curvature and by width of a family of yarns; the work by area
                          is half of it times their squared curvature. 0: the least that keeps yarns
                          smooth */
    double min_radius; /* no generator that is sought bends tighter; 0: any */
};

struct drape_statistics;
struct drape_prepared;
struct steer_slope;

/* What to drape. Zero-initialised fields are the defaults, but spacing and max_nodes are required.
 * Index 0 of a pair is warp, 1 is weft. */
struct drape_settings {
    enum drape_method method;
    enum drape_yarn_path yarn_path;
    double spacing[2]; /* node distance along the yarns, > 0 */
    enum drape_start_kind start_kind;
    double start_uv[2];
    int32_t start_face; /* DRAPE_START_UV on a shell: the face that start_uv are parameters of */
    struct vec3 start_point;
    enum drape_direction_kind direction_kind;
    double direction_deg;
    struct vec3 direction_vector;
    struct drape_zero zero;
    double pre_shear_deg; /* weft starts at 90 deg less this from warp; -80..80 */
    double slide; /* weft sheared by g has the length b (cos g)^-slide: 0, pinned to warp, ..
                     1, along which it slides so that fibres of warp stay b apart. Above 0
                     the weft generator is a geodesic at right angles to warp, beside which
                     cloth is not sheared (`fishnet/slide.h`) */
    struct drape_generator generator[2];
    struct drape_energy energy; /* DRAPE_GENERATOR_LEAST */
    struct steer_slope *slope;  /* NULL, or to be filled by a search (`steer/slope.h`) */
    bool has_extent[2]; /* whether extent[k] bounds the net; else until the surface is covered */
    int extent[2][2];   /* lowest index <= 0 and highest index >= 0 */
    const struct drape_cut_line *cuts; /* `cut_count` of them */
    size_t cut_count;
    size_t max_nodes;                      /* STATUS_TOO_MANY_NODES beyond */
    struct drape_statistics *statistics;   /* NULL, or the caller's, to be filled */
    struct drape_row *row;                 /* NULL, or the caller's, to be filled; not on a mesh */
    const struct drape_prepared *prepared; /* what many drapes of the part share, by
                                              `drape_prepare`; NULL: each makes its own */
    const struct drape_team *team;         /* NULL: the calling thread alone */
    int lanes; /* nodes to be found at once at the most, 0: as many as the processor can; the result
                  has the same bits with any */
};

/* Watches a long run; called a few hundred times at the most, never at the same time, but with a
 * team from any of its threads. */
struct drape_monitor {
    bool (*progress)(void *context, double fraction); /* false: stop with STATUS_CANCELLED */
    void *context;
};

#endif
