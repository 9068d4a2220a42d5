/* SPDX-License-Identifier: MIT */
/*
 * libdrape: lays a woven fabric of inextensible yarns, pinned at their crossings, on a surface.
 *
 * Node (i, j) of the net lies i spacings along warp and j spacings along weft from the start (0,0).
 * Two generator yarns through the start fix the whole net; every other node D follows from three
 * neighbours A, B, C by the step of `fishnet.h`. With s along warp and t along weft the exact net
 * is a Chebyshev net: |r_s| = |r_t| = 1, r_s . r_t = cos w, and the shear angle is 90 deg - w.
 * docs/mathematics.md has the model, the methods and the sources; `the paper` is its first one.
 *
 * Lengths are in the surface's own unit, angles in degrees where a name ends in `_deg`. The library
 * does no input or output, reads no clock, keeps no state between calls, never prints, never exits.
 */
#ifndef SOLVER_DRAPE_H
#define SOLVER_DRAPE_H

#include "arena.h"
#include "method.h"
#include "reason.h"
#include "solver/mesh/mesh.h"
#include "solver/shell/shell.h"
#include "solver/surface/surface.h"
#include "solver/surface/trim.h"
#include "status.h"
#include "vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Changes whenever the same request may give other numbers. */
#define DRAPE_SOLVER_VERSION "0.9.0"

enum drape_start_kind {
    DRAPE_START_CENTROID, /* the surface point nearest to the centroid of the area; one inside where
                              every yarn leaves that at once, or no cell begins there */
    DRAPE_START_UV,
    DRAPE_START_POINT /* the nearest surface point; an error if further than the spacing */
};

enum drape_direction_kind {
    DRAPE_DIRECTION_ANGLE, /* the u-tangent turned about r_u x r_v */
    DRAPE_DIRECTION_VECTOR /* projected on the tangent plane at the start */
};

enum drape_generator_kind {
    DRAPE_GENERATOR_GEODESIC,
    DRAPE_GENERATOR_CURVE, /* a polyline in (u, v) through the start, to 1e-3 of the spacing */
    DRAPE_GENERATOR_PLANE  /* the section by the plane through the start with this normal */
};

/* The positive arm of warp runs with the points of its curve, of a plane to that side to which the
 * direction points; the positive arm of weft to the left of it, seen against r_u x r_v. */
struct drape_generator {
    enum drape_generator_kind kind;
    const double (*curve)[2]; /* DRAPE_GENERATOR_CURVE: (u, v) points in order, owned by caller,
                                 straight between them, past their ends a geodesic */
    size_t curve_count;       /* at least 2 */
    struct vec3 plane_normal; /* DRAPE_GENERATOR_PLANE: any length but zero */
};

/* Several threads for one drape, which the library asks for but does not make. `run` calls
 * task(data, k) for k = 0 .. count - 1, at the same time where it can, and returns when all have.
 * The result has the same bits with any team. */
struct drape_team {
    void (*run)(void *context, int count, void (*task)(void *data, int k), void *data);
    void *context;
};

/* Numbers of the cloth up to its rim beyond those of the summary, for those who compare many
 * drapes. Like these they do not jump when the start moves a little. */
enum { DRAPE_SHEAR_BINS = 8192, DRAPE_DIVISIONS = 32 };
#define DRAPE_SHEAR_BIN (90.0 / (DRAPE_SHEAR_BINS - 1)) /* degrees */
struct drape_statistics {
    struct vec3 wanted; /* asked for: where the warp should run, of any length; zero: not asked */
    double wanted_deg;  /* mean angle by area, 0..90, between warp and `wanted` projected on the
                           surface; of places where it has no projection 45 */
    double area[DRAPE_SHEAR_BINS]; /* whose absolute shear is DRAPE_SHEAR_BIN times b .. b + 1 */
    double lower[2], upper[2];     /* the box round the unsheared cloth: least and greatest p and q,
                                      of the rim if there is one, else of the nodes */
    const struct vec3 *middle;     /* asked for: of so many divisions, to each of which belongs the
                                      cloth that its middle is the nearest of */
    size_t divisions;              /* at most DRAPE_DIVISIONS; 0: not asked */
    double most[DRAPE_DIVISIONS];  /* the largest absolute shear of each, degrees; 0 without cloth.
                                      The largest of all is `max_shear_deg` of the summary */
};

struct mesh_smooth;
struct drape_facets;

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
    double pre_shear_deg; /* weft starts at 90 deg less this from warp; -80..80 */
    struct drape_generator generator[2];
    bool has_extent[2]; /* whether extent[k] bounds the net; else until the surface is covered */
    int extent[2][2];   /* lowest index <= 0 and highest index >= 0 */
    const struct trim *trim;             /* the usable region; NULL: the whole surface */
    size_t max_nodes;                    /* STATUS_TOO_MANY_NODES beyond */
    struct drape_statistics *statistics; /* NULL, or the caller's, to be filled */
    const struct mesh_smooth *smooth;    /* of the mesh, made for many drapes of it by
                                            `drape_prepare_mesh`; NULL: each makes its own */
    const struct drape_facets *facets;   /* likewise of a surface or shell for the method mosaic, by
                                            `drape_prepare_facets` */
    const struct drape_team *team;       /* NULL: the calling thread alone */
    int lanes; /* nodes to be found at once at the most, 0: as many as the processor can; the result
                  has the same bits with any */
};

/* Watches a long run; called a few hundred times at the most, never at the same time, but with a
 * team from any of its threads. */
struct drape_monitor {
    bool (*progress)(void *context, double fraction); /* false: stop with STATUS_CANCELLED */
    void *context;
};

/* Nodes on the surface, sorted by j, then i. Columns of `count` elements. */
struct drape_nodes {
    size_t count;
    int32_t *i, *j;
    double *u, *v; /* inside the domain */
    int32_t *face; /* on a shell: that u and v are parameters of; else NULL */
    double *x, *y, *z;
    double *shear_deg;      /* 90 - angle between warp and weft, > 0 where quadrant i,j > 0 closes;
                               always finite */
    double *error_estimate; /* bound of the distance to the true net; NULL unless the method gives
                               one */
    uint8_t *grown;         /* 1 where the node rests on a yarn that goes straight on from a free
                               edge, or sets off across another; 0 where the generators fix it */
};

/* Cells with four nodes on the surface: corners (i,j), (i+1,j), (i+1,j+1), (i,j+1). Sorted by j,
 * then i. */
struct drape_cells {
    size_t count;
    int32_t *i, *j;
    double *shear_deg;                /* between the mean warp and mean weft direction, in the
                                         surface: of a cell that lies across a fold, unfolded */
    double *warp_x, *warp_y, *warp_z; /* unit mean warp direction, at that angle from weft */
    double *weft_x, *weft_y, *weft_z;
};

/* Places (i, j) next to the net where it has no node, each once, sorted by j, then i. For reason
 * `boundary` it is the last node inside. */
struct drape_front {
    size_t count;
    int32_t *i, *j;
    uint8_t *reason; /* enum drape_reason */
};

/* The edge of what is to be covered in the coordinates (p, q) of the net, i and j as real numbers:
 * closed loops of points, each with what is to be covered on its left in (p, q). Straight lines
 * between neighbours are right to 1e-3 spacings. Columns of `count` elements. */
struct drape_rim {
    size_t count;
    int32_t *loop; /* from 0, ascending */
    int32_t *face; /* on a shell: that u and v are parameters of; else NULL */
    double *x, *y, *z;
    double *u, *v; /* inside the domain; on a mesh (triangle, 0) */
    double *p, *q;
    uint8_t *covered; /* 0 where no cloth reaches the edge: p and q then are a place nearby */
};

/* The cells that the edge of what is to be covered cuts, with corners beyond it on the continued
 * cloth: what is known of the cloth up to its rim. None where cloth does not reach the edge. Sorted
 * as cells; each column of `corner` is x, y, z of the corners (i,j), (i+1,j), (i+1,j+1), (i,j+1).
 */
struct drape_cut {
    struct drape_cells cells;
    double *corner[12];
};

/* A drape is complete when it covers this share of the surface. */
#define DRAPE_COMPLETE_COVERAGE 0.999

enum drape_outcome { DRAPE_COMPLETE, DRAPE_PARTIAL };

struct drape_summary {
    enum drape_outcome outcome;  /* complete: it has cells, and `cloth_coverage` is at least
                                    DRAPE_COMPLETE_COVERAGE */
    double coverage;             /* share of the (trimmed) surface's area in cells, 0..1 */
    double cloth_coverage;       /* the same with the cells that the rim cuts */
    double part_area;            /* to be covered */
    double cloth_area;           /* of the cloth within the rim, on the surface */
    double flat_area;            /* the same unsheared: that of the cut pattern */
    double max_shear_deg;        /* the largest absolute shear of the cloth up to its rim */
    double max_shear_at[2];      /* where it is, p and q */
    struct vec3 max_shear_point; /* and in space */
    double mean_shear_deg;       /* of the absolute shear, by area, the cells that the rim cuts
                                    included */
    double p95_shear_deg;        /* 95 % of the area has less */
    bool overlaps; /* in the flat the rim crosses itself: some of the cloth would have to be in two
                      places of the part */
    double residual_max;           /* largest |edge / promised length - 1| */
    double newton_iterations_mean; /* steps per node found by Newton */
    double error_estimate_max;     /* negative when the method gives none */
    size_t front_reasons[DRAPE_REASON_COUNT];
};

/* Everything lies in the arena of the call. */
struct drape_result {
    int32_t warp_range[2], weft_range[2]; /* least and greatest i and j among the nodes */
    double start_uv[2];                   /* what was chosen */
    int32_t start_face;                   /* on a shell: its face; else 0 */
    int faulty_generator; /* after STATUS_GENERATOR_..: 0 for warp, 1 for weft; else undefined */
    struct vec3 start_point, start_warp, start_weft;
    struct drape_nodes nodes;
    struct drape_cells cells;
    struct drape_front front;
    struct drape_rim rim;
    struct drape_cut cut;
    struct drape_summary summary;
};

/*
 * Drapes `surface`. `monitor` may be NULL; scratch and result come from `arena`.
 * Errors: STATUS_INVALID (a setting out of its range), STATUS_START_OFF_SURFACE,
 * STATUS_START_STUCK, STATUS_DEGENERATE_SURFACE (no tangent plane at the start),
 * STATUS_GENERATOR_OFF_START, STATUS_GENERATOR_PARALLEL, STATUS_TOO_MANY_NODES,
 * STATUS_OUT_OF_MEMORY, STATUS_CANCELLED. A drape that cannot cover everything is a success whose
 * outcome is partial.
 */
enum status drape_solve(const struct surface *surface, const struct drape_settings *settings,
                        const struct drape_monitor *monitor, struct arena *arena,
                        struct drape_result *result) STATUS_MUST_USE;

/*
 * The same on a shell: on the component of its faces that the start lies on, which is that of the
 * largest area where nothing else is asked for. The face of the start gives the side of all.
 * Generators that are curves are in the parameters of that face, and geodesics beyond it. A shell
 * of one face is draped as that face's surface with its region. Errors as above; STATUS_INVALID
 * also for settings->trim, since the regions are the shell's.
 */
enum status drape_solve_shell(const struct shell *shell, const struct drape_settings *settings,
                              const struct drape_monitor *monitor, struct arena *arena,
                              struct drape_result *result) STATUS_MUST_USE;

/* The smooth surface of a mesh for `settings->smooth`, in `arena`; NULL for the method mosaic,
 * which needs none. It may be used by many threads at once. Errors: STATUS_OUT_OF_MEMORY. */
enum status drape_prepare_mesh(const struct mesh *mesh, enum drape_method method,
                               struct arena *arena,
                               const struct mesh_smooth **smooth) STATUS_MUST_USE;

/* The triangles that the method mosaic drapes in place of a surface, or of the component of a shell
 * (NULL: the other is meant), in `arena`; NULL for other methods. Drapes of another spacing or
 * component make their own. Errors: STATUS_OUT_OF_MEMORY, STATUS_TOO_MANY_NODES,
 * STATUS_DEGENERATE_SURFACE, as the drapes would have. */
enum status drape_prepare_facets(const struct surface *surface, const struct shell *shell,
                                 int32_t component, const struct drape_settings *settings,
                                 struct arena *arena,
                                 const struct drape_facets **facets) STATUS_MUST_USE;

/*
 * The same on a mesh: the component with the start is draped, for the method mosaic its flat
 * triangles, for gib (with yarn_path chord), basic and geodesic the smooth surface that they stand
 * for (`mesh/smooth.h`). u and v of the nodes are then (triangle, 0). Errors as above;
 * STATUS_INVALID also for gib4, a start by parameters and generators that are curves.
 */
enum status drape_solve_mesh(const struct mesh *mesh, const struct drape_settings *settings,
                             const struct drape_monitor *monitor, struct arena *arena,
                             struct drape_result *result) STATUS_MUST_USE;

#endif
