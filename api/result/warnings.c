/* SPDX-License-Identifier: MIT */
#include "warnings.h"

#include "permeability.h"
#include "shear_limit.h"
#include "solver/permeability.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Fewer cells than this tell little of a drape; a spacing is proposed that gives more than that. */
static const double few_cells = 25, many_cells = 100;

/* Diagonals of parts in metres: from a clip to the blade of a wind turbine; and what most have. */
static const double least_size = 0.005, largest_size = 120;
static const double usual_least = 0.05, usual_largest = 10;

/* Plies in metres: from a veil to the thickest woven roving; and what most have. */
static const double thinnest_ply = 1e-5, thickest_ply = 0.02;
static const double usual_thinnest = 5e-5, usual_thickest = 5e-3;

/* A stack that is a larger share of the part is none; one of less may be thicker than a fillet's
 * radius, which is looked for in many faces. */
static const double thickest_share = 0.1, noticeable_share = 0.005;

/* The control net is this much longer in the order it was given. */
static const double longer_net = 1.25;

void warnings_add(struct api_warnings *warnings, const char *code, const char *pointer,
                  const char *detail, ...) {
    struct api_warning *warning = &warnings->list[warnings->count];
    va_list values;
    if (warnings->count == API_WARNINGS_MAX)
        return;
    warnings->count++;
    snprintf(warning->code, sizeof warning->code, "%s", code);
    snprintf(warning->pointer, sizeof warning->pointer, "%s", pointer);
    va_start(values, detail);
    vsnprintf(warning->detail, sizeof warning->detail, detail, values);
    va_end(values);
}

double warnings_fine_spacing(double area) {
    return sqrt(area / (1.5 * many_cells));
}

double warnings_two_digits(double value) {
    double digit = pow(10, floor(log10(value)) - 1);
    return floor(value / digit) * digit;
}

/* Of the sign of the shear that goes furthest beyond its locking angle. */
static void check_locking(const struct warnings_subject *s, struct api_summary *summary) {
    static const char pointer[] = "/fabric/locking_angle_deg";
    const struct api_fabric *fabric = &s->request->fabric;
    double limit_deg[2];
    verdict_shear_limits(s->request, limit_deg);
    const struct verdict_case judged = verdict_case_of(s->result, limit_deg);
    double most = judged.shear_deg, angle = judged.limit_deg;
    if (!shear_limit_given(fabric) && most > angle)
        warnings_add(
            &summary->warnings, "locked", pointer,
            "the cloth shears by up to %.1f degrees; most woven fabrics wrinkle at 40 to 60, and "
            "the request has no locking angle",
            most);
    else if (summary->locked_cells > 0 && !shear_limit_is_even(fabric))
        warnings_add(&summary->warnings, "locked", pointer,
                     "%.0f of %zu cells shear beyond the locking angles: up to %.1f degrees of %s "
                     "shear, which locks at %g; the fabric would wrinkle there",
                     summary->locked_cells, summary->cells, most,
                     angle == limit_deg[1] ? "negative" : "positive", angle);
    else if (summary->locked_cells > 0)
        warnings_add(
            &summary->warnings, "locked", pointer,
            "%.0f of %zu cells shear beyond the locking angle of %g degrees, and %.1f is the most: "
            "the fabric would wrinkle there",
            summary->locked_cells, summary->cells, angle, most);
    else if (shear_limit_given(fabric) && most > angle)
        warnings_add(&summary->warnings, "locked", pointer,
                     "at its rim the cloth shears by up to %.1f degrees; the locking angle is %g",
                     most, angle);
}

static void check_fabric(const struct warnings_subject *s, struct api_summary *summary) {
    const struct api_request *request = s->request;
    const struct api_cavity *cavity = &request->cavity;
    check_locking(s, summary);
    if (!(summary->packing_exceeded_cells > 0))
        return;
    double fraction = request->fabric.fiber_volume_fraction;
    if (cavity->rigid)
        fraction *= request->fabric.plies * request->fabric.thickness / cavity->height *
                    permeability_areal_ratio(summary->max_shear_deg, request->settings.slide);
    warnings_add(
        &summary->warnings, "packing_exceeded",
        cavity->rigid ? "/cavity/height" : "/fabric/fiber_volume_fraction",
        "%.0f of %zu cells hold more fibres than can be packed: their fibre volume fraction is up "
        "to %.3g, and the limit is %.3g%s",
        summary->packing_exceeded_cells, summary->cells, fraction,
        api_packing_limit(&request->permeability), cavity->rigid ? "; make the cavity higher" : "");
}

/* Whether the yarn through the start ends there on one of its sides. */
static bool leaves_at_once(const struct drape_nodes *nodes, int k) {
    const int32_t *along = k ? nodes->j : nodes->i, *across = k ? nodes->i : nodes->j;
    int sides = 0;
    for (size_t n = 0; n < nodes->count; n++)
        if (across[n] == 0)
            sides |= (along[n] == 1) + 2 * (along[n] == -1);
    return sides != 3;
}

/* Of generators that were sought, or that end where they begin. */
static void check_steering(const struct warnings_subject *s, struct api_summary *summary) {
    static const char *const pointers[2] = {"/generators/warp", "/generators/weft"};
    const struct drape_steering *steering = &summary->steering;
    const struct drape_generator *generator = s->request->settings.generator;
    bool sought = steering->sought[0] || steering->sought[1];
    if (sought && !steering->fell)
        warnings_add(&summary->warnings, "not_steered", "/generators",
                     "no generators were found that cost less than geodesics (%.6g): the drape is "
                     "theirs",
                     steering->energy[0]);
    for (int k = 0; k < 2; k++) {
        bool steered = generator[k].kind == DRAPE_GENERATOR_STEERED || steering->sought[k];
        if (steered && leaves_at_once(&s->result->nodes, k))
            warnings_add(&summary->warnings, "steers_nothing", pointers[k],
                         "the %s generator leaves the part where it begins, at (%.4g, %.4g, %.4g): "
                         "the curvature of one of its sides has no effect; begin further inside",
                         k ? "weft" : "warp", s->result->start_point.x, s->result->start_point.y,
                         s->result->start_point.z);
    }
}

/* The diagonal of the box round the nodes and the rim. */
static double size_of_part(const struct warnings_subject *s) {
    const struct drape_nodes *nodes = &s->result->nodes;
    const struct drape_rim *rim = &s->result->rim;
    const double *const columns[2][3] = {{nodes->x, nodes->y, nodes->z}, {rim->x, rim->y, rim->z}};
    const size_t counts[2] = {nodes->count, rim->count};
    double sum = 0;
    for (int axis = 0; axis < 3; axis++) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (int table = 0; table < 2; table++)
            for (size_t k = 0; k < counts[table]; k++) {
                double at = columns[table][axis][k];
                low = at < low ? at : low;
                high = at > high ? at : high;
            }
        sum += high > low ? (high - low) * (high - low) : 0;
    }
    return sqrt(sum);
}

/* The unit in which a length would lie within these bounds in metres, millimetres before others;
 * NULL: none. */
static const struct api_unit *likely_unit(double length, double least, double most) {
    const struct api_unit *likely = NULL;
    for (int k = 0; k < API_UNIT_COUNT; k++) {
        double metres = length * api_units[k].metres;
        if (metres >= least && metres <= most && (!likely || strcmp(api_units[k].name, "mm") == 0))
            likely = &api_units[k];
    }
    return likely;
}

static bool check_size(const struct warnings_subject *s, double size, struct api_summary *summary) {
    const struct api_unit *unit = s->request->length_unit;
    double metres = size * unit->metres;
    if ((metres >= least_size && metres <= largest_size) || size == 0)
        return true;
    const struct api_unit *likely = likely_unit(size, usual_least, usual_largest);
    warnings_add(&summary->warnings, "size", "/length_unit",
                 likely ? "the part is %.3g %s large; did you mean %s?"
                        : "the part is %.3g %s large; is that its unit?",
                 size, unit->name, likely ? likely->name : "");
    return false;
}

/* A thickness in another unit than the part is found by what plies have; `sized`: the part's own is
 * likely. */
static void check_thickness(const struct warnings_subject *s, double size, bool sized,
                            struct api_summary *summary) {
    const struct api_fabric *fabric = &s->request->fabric;
    const struct api_unit *unit = s->request->length_unit;
    double ply = fabric->thickness, metres = ply * unit->metres, stack = ply * fabric->plies;
    static const char pointer[] = "/fabric/thickness";
    const struct api_unit *likely = likely_unit(ply, usual_thinnest, usual_thickest);
    if (ply == 0 || size == 0)
        return;
    bool unlikely = sized && (metres < thinnest_ply || metres > thickest_ply);
    if (unlikely || stack > thickest_share * size) {
        char meant[64] = "";
        if (likely && likely != unit)
            snprintf(meant, sizeof meant, "; did you mean %.3g %s, which is %.3g %s?", ply,
                     likely->name, ply * likely->metres / unit->metres, unit->name);
        warnings_add(&summary->warnings, "thickness", pointer,
                     "a ply is %.3g %s thick, on a part that is %.3g %s large%s", ply, unit->name,
                     size, unit->name, meant);
        return;
    }
    bool noticeable = stack > noticeable_share * size;
    double radius = noticeable ? prepared_part_bends(s->prepared)->least_radius : HUGE_VAL;
    if (stack > radius)
        warnings_add(
            &summary->warnings, "thickness", pointer,
            "the plies are %.3g %s thick, more than the least radius of the part, %.3g: on "
            "the inner side of the bend they would not fit",
            stack, unit->name, radius);
}

/* The length of all edges of the control net when point (i, j) is number i stride_u + j stride_v.
 */
static double net_length(const struct nurbs *nurbs, size_t stride_u, size_t stride_v) {
    double sum = 0;
    size_t nu = (size_t)nurbs->u.size, nv = (size_t)nurbs->v.size;
    for (size_t i = 0; i < nu; i++)
        for (size_t j = 0; j < nv; j++) {
            struct vec3 own = nurbs->points[i * stride_u + j * stride_v];
            if (i + 1 < nu)
                sum += vec3_distance(own, nurbs->points[(i + 1) * stride_u + j * stride_v]);
            if (j + 1 < nv)
                sum += vec3_distance(own, nurbs->points[i * stride_u + (j + 1) * stride_v]);
        }
    return sum;
}

/* The face that a gap or an overlap keeps apart from the net's piece, and where. */
static void tell_apart(const struct warnings_subject *s, size_t size, char text[]) {
    const struct shell_apart *apart = s->apart;
    double tolerance = shell_tolerance(s->prepared->shell.shell);
    char title[API_FACE_TITLE_SIZE], way[40] = "overlaps it";
    prepared_shell_face_title(&s->request->surface, apart->face, title);
    if (apart->distance > tolerance)
        snprintf(way, sizeof way, "is %.3g from it", apart->distance);
    snprintf(text, size,
             ". Face %s %s at (%.4g, %.4g, %.4g): edges that differ by more than the tolerance, "
             "%.3g, are not joined",
             title, way, apart->at.x, apart->at.y, apart->at.z, tolerance);
}

static void check_components(const struct warnings_subject *s, struct api_summary *summary) {
    const struct drape_rim *rim = &s->result->rim;
    /* Loops of the rim that no cloth reaches anywhere. */
    size_t loops = 0;
    for (size_t first = 0, k = 0; k < rim->count; k++) {
        bool last = k + 1 == rim->count || rim->loop[k + 1] != rim->loop[k], reached = false;
        if (!last)
            continue;
        for (; first <= k; first++)
            reached = reached || rim->covered[first];
        loops += !reached;
    }
    char kept_apart[sizeof summary->warnings.list->detail] = "";
    if (s->apart->distance < s->request->settings.spacing[0])
        tell_apart(s, sizeof kept_apart, kept_apart);
    if (s->components > 1)
        warnings_add(
            &summary->warnings, "components", "/surface",
            "the surface has %zu pieces that are not connected; the net is on the one with "
            "the start%s",
            s->components, kept_apart);
    else if (loops > 0 && summary->cells > 0)
        warnings_add(&summary->warnings, "components", "/surface",
                     "the net does not reach %zu of the closed edges of the part", loops);
}

/* Why a net ends within the part. */
static const struct {
    enum drape_reason reason;
    const char *words;
} endings[] = {
    {DRAPE_REASON_COLLAPSED,
     "warp and weft become parallel. Another start or direction may reach further (a study finds "
     "it); else cut the cloth there"},
    {DRAPE_REASON_NO_CONVERGENCE,
     "the next node was not found: the surface bends too tightly for the spacing, or has a gap. "
     "Try a smaller spacing or another start"},
    {DRAPE_REASON_FOLD,
     "two sides of the net meet misaligned, as round a tube or a hole. Another start or direction "
     "may reach further (a study finds it); else cut the cloth there"},
};

static void check_uncovered(const struct warnings_subject *s, struct api_summary *summary) {
    struct verdict_end end;
    if (summary->outcome == DRAPE_COMPLETE || summary->cells == 0 ||
        !verdict_find_end(s->result, &end))
        return;
    for (size_t k = 0; k < sizeof endings / sizeof *endings; k++)
        if (endings[k].reason == end.reason)
            warnings_add(&summary->warnings, "uncovered", "/start",
                         "%.3g %% is covered: at (%.4g, %.4g, %.4g), the first of %zu points, %s",
                         100 * summary->cloth_coverage, end.at.x, end.at.y, end.at.z, end.count,
                         endings[k].words);
    /* The net ends nowhere within the part, and yet no cloth was found at points of its edge. */
    if (end.reason != DRAPE_REASON_BOUNDARY ||
        s->result->summary.front_reasons[DRAPE_REASON_BOUNDARY] < s->result->front.count)
        return;
    warnings_add(
        &summary->warnings, "uncovered", "/fabric/spacing",
        "%.3g %% is covered: %zu of %zu points of the part's edge have no cloth, the first at "
        "(%.4g, %.4g, %.4g), and yet the net does not end before it. A fold or corner there is too "
        "sharp for this spacing; try another",
        100 * summary->cloth_coverage, end.count, s->result->rim.count, end.at.x, end.at.y,
        end.at.z);
}

/* Where the lips of a cut would pass each other in the flat cloth, one piece cannot close it.
 * Narrow overlaps are the rounding of a rim of straight lines, and of the angle by chords. */
static void check_cuts(const struct warnings_subject *s, struct api_summary *summary) {
    static const double least_angle = 0.5, least_width = 0.01; /* degrees; spacings */
    const struct drape_cuts *cuts = &s->result->cuts;
    const double *d = s->request->settings.spacing;
    double rounding = least_width * fmin(d[0], d[1]);
    const char *unit = s->request->length_unit->name;
    for (size_t k = 0; k < cuts->count; k++) {
        double angle = cuts->tip_angle_deg[k], length = cuts->length[k];
        double width = fmax(-cuts->mouth_width[k], 0);
        bool narrow = width < rounding && cuts->area[k] > -rounding * length;
        if (narrow && angle > -least_angle)
            continue;
        char pointer[32];
        snprintf(pointer, sizeof pointer, "/cuts/%zu", k);
        warnings_add(&summary->warnings, "cut_opens", pointer,
                     "%s at (%.5g, %.5g, %.5g) opens: flat, its lips overlap by %.3g %s at the "
                     "mouth, %.3g degrees at the tip and %.3g %s2 in all, which one piece cannot "
                     "close. Move it or its tip, or drape in pieces",
                     s->request->cut_names[k], cuts->mouth[k].x, cuts->mouth[k].y, cuts->mouth[k].z,
                     width, unit, fmax(-angle, 0), fmax(-cuts->area[k], 0), unit);
    }
}

/* A net goes on round a place where it collapses, and what it finds there hangs on the spacing. */
static void check_collapsed(const struct warnings_subject *s, struct api_summary *summary) {
    struct verdict_end end;
    if (verdict_find_end(s->result, &end) && end.reason == DRAPE_REASON_COLLAPSED)
        warnings_add(&summary->warnings, "collapsed", "/start",
                     "warp and weft are parallel at (%.4g, %.4g, %.4g), the first of %zu points; "
                     "cloth beyond them counts, but its shear and extent, and with them greatest, "
                     "95 %% and covered area, change with the spacing",
                     end.at.x, end.at.y, end.at.z, end.count);
}

/* Faces with a hole in place of a pole, by its width in spacings. */
static const double hole_least = 0.1;

static void check_poles(const struct warnings_subject *s, struct api_summary *summary) {
    const double *d = s->request->settings.spacing;
    char pointer[40] = "/surface"; /* as long as one may be */
    struct vec3 at;
    double spread;
    int32_t face = drape_find_hole(&s->prepared->part, hole_least * fmin(d[0], d[1]), &at, &spread);
    if (face < 0)
        return;
    if (s->request->surface.kind == API_SURFACE_SHELL)
        snprintf(pointer, sizeof pointer, "/surface/faces/%d", (int)face);
    warnings_add(&summary->warnings, "hole", pointer,
                 "an edge of face %d is all but a point, %.2g %s wide at (%.6g, %.6g, %.6g): the "
                 "part has a hole there, round which the net has to go. Where it should be a "
                 "point, give its control points one position",
                 (int)face, spread, s->request->length_unit->name, at.x, at.y, at.z);
}

void warnings_make(const struct warnings_subject *subject, struct api_summary *summary) {
    struct api_warnings *warnings = &summary->warnings;
    const struct api_request *request = subject->request;
    struct surface_bends bends = {.least_radius = HUGE_VAL};
    const double *d = request->settings.spacing;
    const char *unit = request->length_unit->name;
    warnings->count = 0;
    if ((double)summary->cells < few_cells) {
        double spacing = warnings_two_digits(warnings_fine_spacing(summary->part_area));
        warnings_add(
            warnings, "coarse", "/fabric/spacing",
            "the net has %zu %s, too few to judge the drape by: a spacing of %.2g %s gives "
            "more than %g",
            summary->cells, summary->cells == 1 ? "cell" : "cells", spacing, unit, many_cells);
    }
    check_components(subject, summary);
    check_poles(subject, summary);
    check_uncovered(subject, summary);
    check_collapsed(subject, summary);
    check_cuts(subject, summary);
    check_steering(subject, summary);
    if (subject->result->summary.overlaps)
        warnings_add(
            warnings, "overlap", "/start",
            "the flat pattern overlaps itself: the same cloth would cover two regions of the part. "
            "Move the start, or drape the part in pieces");
    check_fabric(subject, summary);
    /* Whether the surface bends more tightly than a cell, or turns back on itself. */
    if (subject->prepared->part.surface)
        bends = *prepared_part_bends(subject->prepared);
    if (bends.least_radius < fmin(d[0], d[1]))
        warnings_add(
            warnings, "fillet", "/fabric/spacing",
            "the surface bends with a radius of %.3g %s, and the yarns turn round it within one "
            "cell: make the spacing smaller than the radius",
            bends.least_radius, unit);
    if (bends.turns_back)
        warnings_add(
            warnings, "cusp", "/surface",
            "the surface turns back on itself at (%.6g, %.6g, %.6g), and the cloth ends there: "
            "look for a cusp, a fold by 180 degrees, or control points or weights that turn it "
            "inside out",
            bends.turn.x, bends.turn.y, bends.turn.z);
    double size = size_of_part(subject);
    bool sized = check_size(subject, size, summary);
    check_thickness(subject, size, sized, summary);
    const struct nurbs *nurbs = &request->surface.nurbs;
    bool net = request->surface.kind == API_SURFACE_NURBS && nurbs->u.size != nurbs->v.size;
    double given = net ? net_length(nurbs, (size_t)nurbs->v.size, 1) : 0;
    double other = net ? net_length(nurbs, 1, (size_t)nurbs->u.size) : 0;
    if (given > longer_net * other)
        warnings_add(
            warnings, "points_order", "/surface/control_points",
            "the control net runs to and fro: with the points in the other order it would be %.2g "
            "times shorter; v must run fastest, with size_u %d and size_v %d",
            given / other, nurbs->u.size, nurbs->v.size);
}
