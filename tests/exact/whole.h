/* SPDX-License-Identifier: MIT */
/*
 * The net of a shell against that of the surface that it was cut from, node by node.
 */
#ifndef DRAPE_TESTS_WHOLE_H
#define DRAPE_TESTS_WHOLE_H

#include "pieces.h"
#include "scenes.h"

/* A scene cut one way, and how it is draped. */
struct whole_case {
    enum cutting cutting;
    enum drape_method method;
    double gap; /* faces are disturbed by so much of the size (`pieces_disturb`); 0: they are not */
    uint64_t seed;
    double slide; /* of drape_settings */
};

/* Nodes may be off by this share of the size, and twice the gap. */
#define WHOLE_SAME 1e-9

/* Whether the start's faces of the two are turned against each other: nodes (i, j) of one are
 * (i, -j) of the other. */
bool whole_is_turned(const struct drape_run *whole, const struct drape_result *other);

/* Whether all nodes are those of the whole, and the rim; says how it is not, or is with
 * DRAPED_VERBOSE set. */
bool whole_is_same(struct scene *scene, const struct whole_case *c);

/* The same of a scene made for it, by the method that the seed gives. */
bool whole_scene_is_same(enum scene_id id, enum cutting cutting, double gap, uint64_t seed);

#endif
