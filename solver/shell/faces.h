/* SPDX-License-Identifier: MIT */
/*
 * Inside of a shell: its faces and their boundaries. Only the files of solver/shell include it.
 *
 * The boundary of a face is a set of curves in its parameters, trim curves and sides of the domain.
 * Each is cut into edges where others end or it has a corner, and each edge into segments, straight
 * in (u, v) for all that matters. Where the face lies on both sides of an edge, as along the seam
 * of a closed direction, that is no boundary.
 */
#ifndef SOLVER_SHELL_FACES_H
#define SOLVER_SHELL_FACES_H

#include "shell.h"
#include "solver/surface/boxes.h"
#include "solver/surface/spans.h"

enum { EDGE_FREE = -1, FACE_GRID = 32 };

/* What a cell of the grid over a face's domain is. */
enum face_cell { FACE_CELL_MIXED, FACE_CELL_INSIDE, FACE_CELL_OUTSIDE };

/* A trim curve, or the straight line between two places of the domain. */
struct face_curve {
    int32_t face;
    const struct trim_curve *trim; /* NULL: the line */
    double line[2][2];             /* its ends, in inner parameters; t from 0 to 1 */
    double range[2];               /* of t */
    uint32_t first, count;         /* its points while edges are looked for */
};

struct face_edge_end {
    int32_t edge;
    int8_t end; /* 0 or 1 */
};

struct face_edge {
    int32_t curve;
    double t[2];   /* its part of the curve, t[0] < t[1] */
    int32_t mate;  /* the edge it is joined to, or EDGE_FREE */
    bool reversed; /* the two run against each other */
    bool bare;     /* no boundary: one point, or with the face on both sides */
    int8_t inside; /* the face lies to the left (1) or right (-1) of it in inner (u, v) */
    bool open[2];  /* joints: that end lies on the boundary of the shell, where the joint goes on in
                      ghosts' land: */
    bool straight[2];    /* in a straight line from `tip` with the derivative `beyond` of inner */
    double beyond[2][2]; /* (u, v) by t; else as its curve does, which sets out with it */
    double tip[2][2];
    struct vec3 end[2];
    struct face_edge_end follow[2]; /* the free edge that goes on from that end of a free edge, or
                                       begins at the open end of a joint; else EDGE_FREE */
};

/* A piece of an edge from a to b in inner parameters; in space from `r` to where the next one of
 * the edge begins. */
struct face_segment {
    double a[2], b[2];
    double t[2];
    struct vec3 r;
    int32_t edge;
};

/* Segments of one edge that follow each other, and the rectangle that they lie in. Runs are trees,
 * one of each edge: first the run of all its segments, then those of its halves, down to a few;
 * searches pass over most by their rectangles. */
struct face_run {
    uint32_t first, count;
    uint32_t next; /* the run after this and its halves; the one after this where it has none */
    int32_t edge;
    double centre[2], half[2];
};

struct face {
    const struct surface *plain; /* the caller's */
    struct surface surface;      /* the same as a face of this shell */
    const struct trim *trim;     /* NULL: all of the domain */
    double area, gyration2;
    struct vec3 centroid;
    struct box box;
    bool duplicate; /* of another face: it is left out */
    int32_t twin;   /* which */
    int32_t component;
    int8_t side; /* by which it has to be turned to face like the first of its component: 1 or -1 */
    struct face_segment *segments;
    uint32_t segment_count;
    struct face_run *runs;
    uint32_t run_count;
    struct shell_corner *round_pole[4]; /* other faces at its poles, as `shell_round_pole` */
    size_t round_pole_count[4];
    uint8_t *cells; /* FACE_GRID x FACE_GRID of the domain: enum face_cell */
};

struct shell {
    struct face *faces;
    size_t face_count, component_count;
    double tolerance, size;
    bool lenient; /* faults of edges and loops are no errors */
    struct vec3 lower, upper;
    struct shell_edges found;
    struct face_curve *curves;
    size_t curve_count;
    struct face_edge *edges;
    size_t edge_count;
    uint32_t *boundaries; /* of each component, in one piece each */
    uint32_t *plates;     /* those of them that are edges of plates */
    struct vec3 *rounded; /* the area that they run round, as a vector */
};

/* The face that edge `number` bounds, and the one that a surface of a shell is. */
static inline int32_t edge_face(const struct shell *shell, size_t number) {
    return shell->curves[shell->edges[number].curve].face;
}

static inline const struct face *face_of_surface(const struct surface *surface) {
    return &surface->shell->faces[surface->face];
}

/* A point on a curve: inner parameters and their derivative by t, the point and its derivative. */
struct curve_place {
    double t, uv[2], rate[2];
    struct surface_jet jet;
    struct vec3 r, tangent;
};

void curve_at(const struct shell *shell, const struct face_curve *curve, double t,
              struct curve_place *place);

/* The second derivative of a curve, by t, at a place of it. */
struct vec3 curve_second(const struct shell *shell, const struct face_curve *curve,
                         const struct curve_place *place);

/* The point at a share, 0..1, of an edge. */
static inline void edge_at_share(const struct shell *shell, const struct face_edge *edge,
                                 double share, struct curve_place *place) {
    curve_at(shell, &shell->curves[edge->curve], edge->t[0] + share * (edge->t[1] - edge->t[0]),
             place);
}

/* The same by the polynomials that the curve has at `from`, wherever t is. */
void curve_beyond(const struct shell *shell, const struct face_curve *curve, double from, double t,
                  struct curve_place *place);

/* The place of the curve between low and high nearest to `point`, by Newton's method from `from`;
 * its distance. */
double curve_nearest(const struct shell *shell, const struct face_curve *curve, struct vec3 point,
                     double from, const double range[2], struct curve_place *place);

/* Whether an edge is one point, as far as `reach`. */
bool edge_is_point(const struct shell *shell, const struct face_edge *edge, double reach);

/* The unit normals of the faces on both sides of a joined edge, on the shell's side, at `share` of
 * it; and where that is. */
void edge_normals(const struct shell *shell, const struct face_edge *edge, double share,
                  struct vec3 normal[2], struct vec3 *at);

/* Finds which faces meet at the poles of each. Errors: STATUS_OUT_OF_MEMORY. */
enum status faces_round_poles(struct shell *shell, struct arena *arena) STATUS_MUST_USE;

/* Divides the segments into runs. Errors: STATUS_OUT_OF_MEMORY. */
enum status face_make_runs(struct face *face, struct arena *arena) STATUS_MUST_USE;

/* Fills the grid, from the segments. Errors: STATUS_OUT_OF_MEMORY. */
enum status face_make_grid(struct face *face, struct arena *arena) STATUS_MUST_USE;

/* Whether the straight way between two places of the domain lies well inside the face, as far as
 * the grid tells. */
bool face_holds_way(const struct face *face, const double from[2], const double to[2]);

/* The difference of two parameters, the shorter way round a closed direction. */
static inline double face_way(const struct surface_axis *axis, double from, double to) {
    double difference = to - from;
    if (!axis->closed)
        return difference;
    double period = surface_axis_length(axis);
    return difference - period * floor(difference / period + 0.5);
}

/* Whether inner parameters are in the face: its domain, to 1e-9 of it, and its region. */
bool face_contains(const struct face *face, const double uv[2]);

/* Cuts the boundaries into edges and joins them; sets curves, edges, segments and what was found.
 * Errors: STATUS_OUT_OF_MEMORY, STATUS_INVALID with SHELL_THREE_FACES. */
enum status faces_join(struct shell *shell, const struct shell_patch *patches, struct arena *arena,
                       struct shell_fault *fault) STATUS_MUST_USE;

#endif
