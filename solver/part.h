/* SPDX-License-Identifier: MIT */
/* The workpiece: one surface, the faces of a CAD part, or a triangle mesh. */
#ifndef SOLVER_PART_H
#define SOLVER_PART_H

struct surface;
struct trim;
struct shell;
struct mesh;

/* One of the three; nothing of it is owned. */
struct drape_part {
    const struct surface *surface;
    const struct trim *trim; /* the usable region of `surface`; NULL: all of it */
    const struct shell *shell;
    const struct mesh *mesh;
};

#endif
