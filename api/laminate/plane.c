/* SPDX-License-Identifier: MIT */
#include "plane.h"

#include <geos_c.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The lines of the grid are 2^-36 of the size apart, 1.5e-11; a segment on it is within so many of
 * them from where it was. */
enum { GRID_BITS = 36, NEAR = 16 };

/* A handle, and the grid that all is rounded to. A geometry of NULL is one that failed, of which
 * the problem tells; functions of GEOS do not take it. */
struct plane {
    GEOSContextHandle_t geos;
    double grid;
    struct api_problem *problem;
};

static void note_error(const char *words, void *problem) {
    if (strstr(words, "bad_alloc"))
        api_problem_no_memory(problem, "polygons");
    else
        api_problem_set(problem, API_INTERNAL, "polygons of the plane: %s", words);
}

static bool open_plane(double size, struct plane *plane, struct api_problem *problem) {
    *plane =
        (struct plane){GEOS_init_r(), ldexp(1, ilogb(size > 0 ? size : 1) - GRID_BITS), problem};
    if (!plane->geos)
        return api_problem_no_memory(problem, "polygons"), false;
    (void)GEOSContext_setErrorMessageHandler_r(plane->geos, note_error, problem);
    return true;
}

/* Whoever failed without a word has no memory. */
static enum api_problem_id close_plane(struct plane *plane, bool good) {
    GEOS_finish_r(plane->geos);
    return good ? plane->problem->id : api_problem_no_memory(plane->problem, "polygons");
}

static void drop_geometry(const struct plane *plane, GEOSGeometry *geometry) {
    if (geometry)
        GEOSGeom_destroy_r(plane->geos, geometry);
}

/* A number of geometries as one, which has them from there on. */
static GEOSGeometry *collect_geometries(const struct plane *plane, int type, GEOSGeometry **parts,
                                        size_t count) {
    bool good = parts != NULL;
    for (size_t k = 0; k < count && good; k++)
        good = parts[k] != NULL;
    if (good)
        return GEOSGeom_createCollection_r(plane->geos, type, parts, (unsigned)count);
    for (size_t k = 0; k < count && parts; k++)
        drop_geometry(plane, parts[k]);
    return NULL;
}

/* ---- areas ---- */

/* The area within the polygon of the points first..end, whichever way it turns, without what it
 * has twice where it crosses itself. */
static GEOSGeometry *ring_area(const struct plane *plane, const struct polygons *polygons,
                               size_t first, size_t end) {
    const struct polygons_point *p = polygons->points;
    GEOSCoordSequence *places = GEOSCoordSeq_create_r(plane->geos, (unsigned)(end - first + 1), 2);
    for (size_t k = first; k <= end && places; k++) {
        const struct polygons_point *at = &p[k < end ? k : first];
        (void)GEOSCoordSeq_setXY_r(plane->geos, places, (unsigned)(k - first), at->x, at->y);
    }
    GEOSGeometry *ring = places ? GEOSGeom_createLinearRing_r(plane->geos, places) : NULL;
    GEOSGeometry *area = ring ? GEOSGeom_createPolygon_r(plane->geos, ring, NULL, 0) : NULL;
    if (!area || GEOSisSimple_r(plane->geos, ring) == 1)
        return area;
    GEOSMakeValidParams *how = GEOSMakeValidParams_create_r(plane->geos);
    GEOSGeometry *valid = NULL; /* areas alone, not what collapses to lines */
    if (how && GEOSMakeValidParams_setMethod_r(plane->geos, how, GEOS_MAKE_VALID_STRUCTURE) &&
        GEOSMakeValidParams_setKeepCollapsed_r(plane->geos, how, 0))
        valid = GEOSMakeValidWithParams_r(plane->geos, area, how);
    if (how)
        GEOSMakeValidParams_destroy_r(plane->geos, how);
    drop_geometry(plane, area);
    return valid;
}

/* The union of the polygons that turn left, or of those that turn right. */
static GEOSGeometry *turning_area(const struct plane *plane, const struct polygons *polygons,
                                  bool left) {
    GEOSGeometry **parts = malloc((polygons->count + 1) * sizeof(GEOSGeometry *));
    size_t count = 0;
    for (size_t first = 0, end; parts && first < polygons->count; first = end)
        if ((polygons_loop_area(polygons, first, &end) > 0) == left)
            parts[count++] = ring_area(plane, polygons, first, end);
    GEOSGeometry *all = collect_geometries(plane, GEOS_GEOMETRYCOLLECTION, parts, count);
    GEOSGeometry *area = all ? GEOSUnaryUnionPrec_r(plane->geos, all, plane->grid) : NULL;
    drop_geometry(plane, all);
    free(parts);
    return area;
}

/* Takes both. */
static GEOSGeometry *combine_areas(const struct plane *plane, GEOSGeometry *a,
                                   enum plane_operation operation, GEOSGeometry *b) {
    GEOSGeometry *result = NULL;
    if (a && b && operation == PLANE_EITHER)
        result = GEOSUnionPrec_r(plane->geos, a, b, plane->grid);
    else if (a && b)
        result = operation == PLANE_BOTH ? GEOSIntersectionPrec_r(plane->geos, a, b, plane->grid)
                                         : GEOSDifferencePrec_r(plane->geos, a, b, plane->grid);
    drop_geometry(plane, a);
    drop_geometry(plane, b);
    return result;
}

static GEOSGeometry *enclosed_area(const struct plane *plane, const struct polygons *polygons) {
    return combine_areas(plane, turning_area(plane, polygons, true), PLANE_FIRST_ALONE,
                         turning_area(plane, polygons, false));
}

/* ---- and back ---- */

/* Adds a ring, what its polygon encloses on its left. */
static bool add_plane_ring(const struct plane *plane, const GEOSGeometry *ring, bool hole,
                           struct polygons *result) {
    const GEOSCoordSequence *places = GEOSGeom_getCoordSeq_r(plane->geos, ring);
    unsigned count = 0;
    char left = 0;
    bool good = places && GEOSCoordSeq_getSize_r(plane->geos, places, &count) &&
                GEOSCoordSeq_isCCW_r(plane->geos, places, &left);
    for (unsigned k = 0; k + 1 < count && good; k++) {
        double x, y;
        good = GEOSCoordSeq_getXY_r(plane->geos, places, (left != 0) != hole ? k : count - 1 - k,
                                    &x, &y) &&
               polygons_add(result, x, y);
    }
    polygons_close(result);
    return good;
}

/* Adds what a geometry encloses; lines and points, where areas touch, enclose nothing. */
static bool add_area(const struct plane *plane, const GEOSGeometry *geometry,
                     struct polygons *result) {
    int type = GEOSGeomTypeId_r(plane->geos, geometry);
    bool good = true;
    if (type == GEOS_MULTIPOLYGON || type == GEOS_GEOMETRYCOLLECTION)
        for (int k = 0; k < GEOSGetNumGeometries_r(plane->geos, geometry) && good; k++)
            good = add_area(plane, GEOSGetGeometryN_r(plane->geos, geometry, k), result);
    if (type != GEOS_POLYGON || GEOSisEmpty_r(plane->geos, geometry))
        return good;
    good = add_plane_ring(plane, GEOSGetExteriorRing_r(plane->geos, geometry), false, result);
    for (int k = 0; k < GEOSGetNumInteriorRings_r(plane->geos, geometry) && good; k++)
        good =
            add_plane_ring(plane, GEOSGetInteriorRingN_r(plane->geos, geometry, k), true, result);
    return good;
}

static double larger_size(const struct polygons *a, const struct polygons *b) {
    double size = 0, low[2], high[2];
    for (int k = 0; k < 2; k++) {
        polygons_bounds(k ? b : a, low, high);
        for (int x = 0; x < 2; x++)
            size = fmax(size, fmax(fabs(low[x]), fabs(high[x])));
    }
    return size;
}

enum api_problem_id plane_combine(const struct polygons *a, enum plane_operation operation,
                                  const struct polygons *b, struct polygons *result,
                                  struct api_problem *problem) {
    struct plane plane;
    if (!open_plane(larger_size(a, b), &plane, problem))
        return problem->id;
    GEOSGeometry *area =
        combine_areas(&plane, enclosed_area(&plane, a), operation, enclosed_area(&plane, b));
    bool good = area && add_area(&plane, area, result);
    drop_geometry(&plane, area);
    return close_plane(&plane, good);
}

/* ---- lines and the faces between them ---- */

bool segments_add(struct segments *s, const double from[2], const double to[2], int32_t number) {
    if (s->count == s->room) {
        void *larger = arena_enlarge(s->arena, s->list, s->count, sizeof *s->list, &s->room);
        if (!larger)
            return false;
        s->list = larger;
    }
    s->list[s->count++] = (struct segment){{from[0], from[1]}, {to[0], to[1]}, number};
    return true;
}

bool segments_add_polygons(struct segments *s, const struct polygons *polygons, int32_t number) {
    const struct polygons_point *p = polygons->points;
    bool good = true;
    for (size_t k = 0, first = 0; k < polygons->count && good; k++) {
        const struct polygons_point *next = &p[p[k].last ? first : k + 1];
        const double from[2] = {p[k].x, p[k].y}, to[2] = {next->x, next->y};
        good = segments_add(s, from, to, number);
        first = p[k].last ? k + 1 : first;
    }
    return good;
}

static GEOSGeometry *plane_line(const struct plane *plane, const double from[2],
                                const double to[2]) {
    GEOSCoordSequence *ends = GEOSCoordSeq_create_r(plane->geos, 2, 2);
    if (!ends)
        return NULL;
    (void)GEOSCoordSeq_setXY_r(plane->geos, ends, 0, from[0], from[1]);
    (void)GEOSCoordSeq_setXY_r(plane->geos, ends, 1, to[0], to[1]);
    return GEOSGeom_createLineString_r(plane->geos, ends);
}

/* The segments as lines, by the same numbers. */
static GEOSGeometry *lines_of(const struct plane *plane, const struct segments *segments) {
    GEOSGeometry **lines = malloc((segments->count + 1) * sizeof(GEOSGeometry *));
    for (size_t k = 0; k < segments->count && lines; k++)
        lines[k] = plane_line(plane, segments->list[k].from, segments->list[k].to);
    GEOSGeometry *all =
        lines ? collect_geometries(plane, GEOS_MULTILINESTRING, lines, segments->count) : NULL;
    free(lines);
    return all;
}

/* The face that a point is in, of all between lines; empty where it is in none. */
static GEOSGeometry *face_round(const struct plane *plane, const GEOSGeometry *lines,
                                const double at[2]) {
    GEOSGeometry *noded = GEOSUnaryUnionPrec_r(plane->geos, lines, plane->grid), *found = NULL;
    const GEOSGeometry *const all[] = {noded};
    GEOSGeometry *faces = noded ? GEOSPolygonize_r(plane->geos, all, 1) : NULL;
    GEOSGeometry *point = GEOSGeom_createPointFromXY_r(plane->geos, at[0], at[1]);
    int count = faces && point ? GEOSGetNumGeometries_r(plane->geos, faces) : 0;
    for (int k = 0; k < count && !found; k++) {
        const GEOSGeometry *face = GEOSGetGeometryN_r(plane->geos, faces, k);
        if (GEOSIntersects_r(plane->geos, face, point) == 1)
            found = GEOSGeom_clone_r(plane->geos, face);
    }
    if (!found && faces && point)
        found = GEOSGeom_createEmptyPolygon_r(plane->geos);
    drop_geometry(plane, point);
    drop_geometry(plane, faces);
    drop_geometry(plane, noded);
    return found;
}

/* The first segment that a place is near. */
struct near_place {
    const double *at;
    double reach;
    const struct segment *found;
};

static void look_near(void *item, void *context) {
    struct near_place *near = context;
    const struct segment *s = item;
    double way[2] = {s->to[0] - s->from[0], s->to[1] - s->from[1]};
    double to[2] = {near->at[0] - s->from[0], near->at[1] - s->from[1]};
    double length2 = way[0] * way[0] + way[1] * way[1];
    double share = length2 > 0 ? (to[0] * way[0] + to[1] * way[1]) / length2 : 0;
    share = fmin(fmax(share, 0), 1);
    if (hypot(to[0] - share * way[0], to[1] - share * way[1]) <= near->reach &&
        (!near->found || s < near->found))
        near->found = s;
}

/* Of each point of a face the segment along which its edge runs. */
static bool find_along(const struct plane *plane, const struct segments *segments,
                       const GEOSGeometry *lines, const struct polygons *face,
                       const struct segment **along) {
    const struct polygons_point *p = face->points;
    GEOSSTRtree *tree = GEOSSTRtree_create_r(plane->geos, 10);
    bool good = tree != NULL;
    for (size_t k = 0; k < segments->count && good; k++)
        GEOSSTRtree_insert_r(plane->geos, tree, GEOSGetGeometryN_r(plane->geos, lines, (int)k),
                             &segments->list[k]);
    for (size_t k = 0, first = 0; k < face->count && good; k++) {
        const struct polygons_point *next = &p[p[k].last ? first : k + 1];
        const double middle[2] = {(p[k].x + next->x) / 2, (p[k].y + next->y) / 2};
        double reach = NEAR * plane->grid;
        struct near_place near = {middle, reach, NULL};
        GEOSGeometry *box =
            plane_line(plane, (const double[]){middle[0] - reach, middle[1] - reach},
                       (const double[]){middle[0] + reach, middle[1] + reach});
        if (box)
            GEOSSTRtree_query_r(plane->geos, tree, box, look_near, &near);
        drop_geometry(plane, box);
        along[k] = near.found;
        good = near.found || (box && api_problem_set(plane->problem, API_INTERNAL,
                                                     "the edge of a face lies on no segment"));
        first = p[k].last ? k + 1 : first;
    }
    if (tree)
        GEOSSTRtree_destroy_r(plane->geos, tree);
    return good;
}

enum api_problem_id plane_face(const struct segments *segments, const double at[2],
                               struct polygons *face, const struct segment ***along,
                               struct api_problem *problem) {
    struct plane plane;
    double size = 0;
    for (size_t k = 0; k < segments->count; k++)
        for (int x = 0; x < 2; x++)
            size = fmax(size, fmax(fabs(segments->list[k].from[x]), fabs(segments->list[k].to[x])));
    if (!open_plane(size, &plane, problem))
        return problem->id;
    GEOSGeometry *lines = lines_of(&plane, segments);
    GEOSGeometry *round = lines ? face_round(&plane, lines, at) : NULL;
    bool good = round && add_area(&plane, round, face);
    *along = good ? arena_take(segments->arena, face->count + 1, sizeof **along) : NULL;
    good = *along && find_along(&plane, segments, lines, face, *along);
    drop_geometry(&plane, round);
    drop_geometry(&plane, lines);
    return close_plane(&plane, good);
}
