/* SPDX-License-Identifier: MIT */
/*
 * What the nets of a laminate say at each element of a target, or at each of its points: which
 * plies lie there, how they are
 * sheared and how they are turned. The nets are read one after the other.
 */
#ifndef API_LAMINATE_PLY_SAMPLES_H
#define API_LAMINATE_PLY_SAMPLES_H

#include "api/map/map.h"
#include "laminate.h"

/* What a net says at an element. */
struct ply_sample {
    double shear_deg; /* NaN: the net does not reach it */
    double warp[2];   /* the unit warp in the element's frame */
};

/* Where the first net reaches an element: two directions of its tangent plane, their normal, the
 * point, and how far that net's surface was moved. */
struct sample_frame {
    struct vec3 first, second, normal; /* zero: no net has reached the element */
    struct vec3 foot;
    double height;
};

/* The first seven are the caller's; all others lie in the arena. */
struct ply_samples {
    const struct laminate *laminate;
    const struct map_target *target;
    const struct drape_monitor *monitor;
    struct api_map *map;
    struct arena *arena;
    struct api_problem *problem;
    size_t count; /* of elements */
    struct sample_frame *frames;
    struct ply_sample *samples; /* [net][element] */
    uint8_t *mirrored;          /* alike: the net's normal is against the frame's */
    uint8_t **inside;      /* of each ply with a boundary and each piece, by element; else NULL */
    struct region *pieces; /* of each ply: on its cloth, if it is a piece */
    double *away;          /* of each ply: how far its boundary is from its cloth */
    bool *there;           /* of each net */
    double *distance;      /* of each element: to the nearest net */
    size_t rows;           /* plies at elements, together */
    double spacing;        /* the largest of the nets */
    bool channelled;       /* the channel along the rim has been looked for */
};

/* Reads the nets, NULL where one failed, and sets the unit of the map. False with the problem set.
 */
bool ply_samples_read(struct ply_samples *samples, const struct api_reader *const *nets);

/* Whether ply k lies at a element. */
bool ply_samples_has(const struct ply_samples *samples, size_t k, size_t element);

/* Asks the monitor now and then; false with the problem set when it is enough. */
bool ply_samples_go_on(struct ply_samples *samples, size_t done, double share);

/* Sets the problem; false. */
bool ply_samples_no_memory(struct ply_samples *samples);

#endif
