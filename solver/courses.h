/* SPDX-License-Identifier: MIT */
/*
 * Courses: cloth has the width of its roll, and is laid strip beside strip until a part is covered.
 *
 * The first course's near edge is a parallel of a line on the part: a geodesic, a path, or an edge
 * of the part. Each other course's near edge is a parallel of the far edge of the cloth beside it,
 * so that the gap between both is what was asked for at every place (`course/line.h`). A course is
 * a net of its own (`drape.h`): its warp generator is its near edge, its weft generator the
 * geodesic across it at the course's origin.
 */
#ifndef SOLVER_COURSES_H
#define SOLVER_COURSES_H

#include "drape.h"

enum { COURSES_MAX = 256, COURSES_VALUES_MAX = 16 };

enum courses_along_kind {
    COURSES_ALONG_DIRECTION, /* the geodesic through the start of the drape's settings, as warp */
    COURSES_ALONG_EDGE,      /* the part's edge nearest to a point, from corner to corner, with the
                                part on its left; trims as flattened, to 1e-3 spacings */
    COURSES_ALONG_PATH       /* points in space, straight between, each brought to the part */
};

/* A distance that varies along a course from end to end of the part: the Bezier polynomial with
 * these values, which lies between the least and the greatest of them. */
struct courses_offset {
    const double *values;
    size_t count; /* at most COURSES_VALUES_MAX; 0: no distance */
};

/* Value k of a list whose last one goes on; `otherwise` of an empty list. */
static inline double courses_value(const double *list, size_t count, size_t k, double otherwise) {
    return count ? list[k < count ? k : count - 1] : otherwise;
}

/* What to lay. `drape` is of every course: start and direction alone of the line along which the
 * first one is laid, spacing across as many equal parts of the width; without extent, cuts,
 * generators and pre-shear. Owned by the caller. */
struct courses_settings {
    struct drape_settings drape;
    enum courses_along_kind along;
    struct vec3 edge; /* COURSES_ALONG_EDGE: a point next to it */
    const struct vec3 *path;
    size_t path_count;    /* COURSES_ALONG_PATH: at least 2 */
    bool both;            /* then to the other side too, from the first course's near edge on */
    bool to_right;        /* the courses follow each other to the right of warp, else to the left:
                             against the normal of the part, of several faces on the first's side */
    const double *widths; /* of the courses in order, > 0, the last of all that follow */
    size_t width_count;   /* at least 1 */
    struct courses_offset first; /* of the first near edge from the line, towards the courses */
    const struct courses_offset *gaps; /* between a course and the next; below 0 they overlap. The
                                          last one of all that follow */
    size_t gap_count;
    const double *origins; /* where weft generators are, as shares of the near edges' length on the
                              part; the last one of all that follow; none: 0.5 */
    size_t origin_count;
    size_t most;        /* so many courses at the most, 0: COURSES_MAX */
    double ends;        /* cloth beyond both ends of a course; >= 0 */
    struct vec3 wanted; /* where warp should run, projected on the part; zero: not asked */
    double exponent;    /* p of the means of the angle from there; 0 is 1 */
    bool rough;         /* near edges keep their distance to 1e-5 spacings and have places a spacing
                           apart to a hundredth, as searches need; else to 1e-8, and to 1e-8 along
                           smooth lines */
};

/* A course. Lengths and areas are those of the flat cloth where nothing else is said. */
struct course {
    double width;
    bool to_right;          /* of its near edge, at which weft's index is 0 */
    int32_t rows;           /* cells across */
    double spacing[2];      /* of its net */
    double ends[2];         /* where it is cut, as lengths along warp from its origin */
    double cut_length;      /* between them: from end to end of the part, and
                               `ends` twice */
    double area;            /* that is cut from the roll: width times cut length */
    double net_area;        /* of it on the part */
    double trim_area;       /* the rest */
    double wanted_deg;      /* p-mean by area of the angle between warp and the wanted direction, */
    double wanted_most_deg; /* the greatest of a cell, 0..90; 0 where it is not asked for */
    double gap[2];          /* least and greatest distance from the course before, on the part;
                               of the first one from the line */
    double gap_area;        /* between it and the course before; */
    double overlap_area;    /* cloth of it that lies on that one */
    size_t place_count, place_start; /* of its near edge, with the origin */
    const struct drape_place *places;
    struct drape_result net;
};

struct courses_result {
    struct course *courses;
    size_t count;
    double area, net_area, trim_area, gap_area, overlap_area; /* of all */
    double cloth_coverage;                /* share of the part under one course at least */
    double max_shear_deg, mean_shear_deg; /* the greatest, and the mean by flat area */
    double wanted_deg, wanted_most_deg;
    double gap_most; /* greatest distance of neighbours with cloth, >= 0 */
    size_t faulty;   /* after an error: the number of the course */
};

/*
 * Lays courses until the far edge of one has no place on the part; where that is so of the first
 * one it is the only one, and may have no cloth there. Of a shell the component of the
 * start's face, or of that nearest to the edge or path, is covered.
 *
 * Errors: as `drape_solve`; STATUS_INVALID of a mesh, of a width, gap or origin out of range, and
 * of a width beyond the size of the part; STATUS_START_OFF_SURFACE where the path or edge is
 * further from the part than a spacing; STATUS_NO_CONVERGENCE where a near edge is lost: its
 * parallel is further away than its centre of curvature.
 */
enum status courses_lay(const struct drape_part *part, const struct courses_settings *settings,
                        const struct drape_monitor *monitor, struct arena *arena,
                        struct courses_result *result) STATUS_MUST_USE;

#endif
