/* SPDX-License-Identifier: MIT */
/*
 * What a drape comes to: the nodes and cells of the net, its front, the rim of the cloth, and a
 * summary. Tables are columns of `count` elements.
 */
#ifndef SOLVER_RESULT_H
#define SOLVER_RESULT_H

#include "curvature.h"
#include "reason.h"
#include "vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Nodes on the surface, sorted by j, then i. Columns of `count` elements. */
struct drape_nodes {
    size_t count;
    int32_t *i, *j;
    double *u, *v; /* inside the domain */
    int32_t *face; /* on a shell: that u and v are parameters of; else NULL */
    double *x, *y, *z;
    double *shear_deg;       /* 90 - angle between warp and weft, > 0 where quadrant i,j > 0 closes;
                                always finite */
    double *error_estimate;  /* bound of the distance to the true net; NULL unless the method gives
                                one */
    double *shear_error_deg; /* bound of the error of shear_deg, likewise; NULL where no yarn has
                                six nodes, too */
    uint8_t *grown;          /* 1 where the node rests on a yarn that goes straight on from a free
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
    int32_t *cut;     /* whose lip goes on from the point: k + 1 towards the tip of cut k, -(k + 1)
                         back from it, 0 along other edges; NULL without cuts */
};

/* The cells that the edge of what is to be covered cuts, with corners beyond it on the continued
 * cloth: what is known of the cloth up to its rim. None where cloth does not reach the edge. Sorted
 * as cells; each column of `corner` is x, y, z of the corners (i,j), (i+1,j), (i+1,j+1), (i,j+1).
 */
struct drape_cut {
    struct drape_cells cells;
    double *corner[12];
};

/* What the cuts come to, in the order of the settings. Their two lips are one line of the part and
 * two of the flat cloth, which part at the tip. */
struct drape_cuts {
    size_t count;
    double *length;        /* on the part */
    double *tip_angle_deg; /* between the lips at the tip, in the flat cloth: above 0 a dart, whose
                              wedge is cut out, 0 a slit; below 0 the cloth would lie on itself */
    double *mouth_width;   /* between the lips' ends at the edge, in the flat cloth; below 0 where
                              they pass each other */
    double *area;          /* of the cloth between the lips and the chord or, round more than half a
                              turn, the arc from mouth to mouth; below 0 what one piece lacks */
    uint8_t *covered;      /* cloth reaches the tip and both lips' ends; else the three are 0 */
    struct vec3 *mouth;    /* where they begin on the part */
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
    double max_shear_pinned_deg; /* that of cells which the generators fix: it converges as the
                                    spacing gets smaller, .. */
    double max_shear_grown_deg;  /* .. and of cells that have a grown node, which need not; negative
                                    where there are none */
    double grown_area;           /* of the cloth in cells that have a grown node */
    double mean_shear_deg;       /* of the absolute shear, by area, the cells that the rim cuts
                                    included */
    double p95_shear_deg;        /* 95 % of the area has less */
    struct drape_most {          /* of positive [0] and of negative shear: */
        double shear_deg;        /* the largest absolute one, 0 where there is none, .. */
        struct vec3 point;       /* .. and where */
    } most[2];
    bool overlaps; /* in the flat the rim crosses itself: some of the cloth would have to be in two
                      places of the part */
    double residual_max;           /* largest |edge / promised length - 1| */
    double newton_iterations_mean; /* steps per node found by Newton */
    double error_estimate_max;     /* negative when the method gives none; */
    double shear_error_max;        /* of the nodes, degrees, .. */
    double max_shear_error_deg;    /* .. and of max_shear_deg, likewise */
    size_t front_reasons[DRAPE_REASON_COUNT];
};

/* What is wrong with a cut. */
enum cut_fault_kind {
    CUT_FAULTLESS,
    CUT_OFF_PART,      /* a point of its path is further from the part than a spacing */
    CUT_SHORT,         /* it is shorter than a spacing */
    CUT_AT_START,      /* it passes the start */
    CUT_CROSSES,       /* it crosses another one, */
    CUT_CROSSES_SELF,  /* or itself */
    CUT_BEGINS_INSIDE, /* its first point is no edge of the part, a hole or another cut */
    CUT_SPLITS         /* its last point is an edge, too: it divides the part */
};

struct cut_fault {
    enum cut_fault_kind kind;
    size_t cut, other; /* which, and which one it crosses */
    struct vec3 at;    /* where */
};

/* Of a drape whose generators were to cost the least energy (`steer/energy.h`). */
struct drape_steering {
    bool sought[2];   /* whether warp and weft were; else nothing below speaks of it */
    double energy[2]; /* with geodesics in their place, and of the drape; without bending */
    bool fell;        /* it is less; else the drape is that with geodesics */
    int iterations;   /* of the minimiser */
    struct drape_curvature
        curvature[2]; /* what was found: DRAPE_GENERATOR_STEERED gives the drape */
};

/* Everything lies in the arena of the call. */
struct drape_result {
    int32_t warp_range[2], weft_range[2]; /* least and greatest i and j among the nodes */
    double start_uv[2];                   /* what was chosen */
    int32_t start_face;                   /* on a shell: its face; else 0 */
    struct cut_fault faulty_cut;          /* after STATUS_CUT; else undefined */
    int faulty_generator; /* after STATUS_GENERATOR_..: 0 for warp, 1 for weft; else undefined */
    struct vec3 start_point, start_warp, start_weft;
    struct vec3 start_zero; /* unit: what the angle of the warp is counted from there; zero where a
                               rosette has no direction in the tangent plane */
    struct vec3 start_side; /* the unit normal there, of several faces on the first one's side */
    struct drape_nodes nodes;
    struct drape_cells cells;
    struct drape_front front;
    struct drape_rim rim;
    struct drape_cut cut;
    struct drape_cuts cuts;
    struct drape_summary summary;
    struct drape_steering steering;
};

/* Numbers of the cloth up to its rim beyond those of the summary, for those who compare many
 * drapes. Like these they do not jump when the start moves a little. */
enum { DRAPE_SHEAR_BINS = 8192, DRAPE_DIVISIONS = 32 };
#define DRAPE_SHEAR_BIN (90.0 / (DRAPE_SHEAR_BINS - 1)) /* degrees */
struct drape_statistics {
    struct vec3 wanted; /* asked for: where the warp should run, of any length; zero: not asked */
    double exponent;    /* asked for: p of the mean below; 0 is 1 */
    double wanted_deg;  /* p-th root of the mean p-th power by area of the angle, 0..90, between
                           warp and `wanted` projected on the surface; of places where it has no
                           projection 45 */
    double area[DRAPE_SHEAR_BINS]; /* whose absolute shear is DRAPE_SHEAR_BIN times b .. b + 1 */
    double negative[DRAPE_SHEAR_BINS]; /* of that, whose shear is negative */
    double lower[2], upper[2];    /* the box round the unsheared cloth: least and greatest p and q,
                                     of the rim if there is one, else of the nodes */
    const struct vec3 *middle;    /* asked for: of so many divisions, to each of which belongs the
                                     cloth that its middle is the nearest of */
    size_t divisions;             /* at most DRAPE_DIVISIONS; 0: not asked */
    double most[DRAPE_DIVISIONS]; /* the largest absolute shear of each, degrees; 0 without cloth.
                                     The largest of all is `max_shear_deg` of the summary */
};

#endif
