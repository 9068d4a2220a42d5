/* SPDX-License-Identifier: MIT */
/*
 * How tightly a surface bends, and where it turns back on itself: at a cusp, a fold by 180 degrees,
 * or along a line beyond which weights or control points have turned it inside out.
 */
#include "solver/surface/trim.h"
#include "surface_point.h"
#include <string.h>

/* Samples of a direction: as many as spans within these bounds, in each span as many as go. */
enum { SAMPLES_LEAST = 32, SAMPLES_MOST = 128, SAMPLES_ALL = 4096 };

/* Between two samples whose normals differ by more than a right angle so many halvings find whether
 * they do so at one point, by more than the 178 degrees at which cloth ends: where the surface goes
 * round a bend they do not. */
enum { HALVINGS = 50, SHARPENINGS = 40 };
static const double back_cosine = -0.99939;

/* A little off the middle, where symmetric parts have their cusps and so no normal. */
static const double half = 0.49;

/* Near poles the parameters' own bends grow beyond what the surface's can be told from. */
static const double regular_share = 1e-3;

/* A point of the region and the normal there; zero where there is none. */
struct sample {
    double uv[2];
    struct vec3 r, normal;
};

static bool sample_at(const struct surface *surface, const struct trim *trim,
                      struct surface_cursor *cursor, double u, double v,
                      struct surface_point *point, struct sample *sample) {
    double outer[2], uv[2] = {u, v};
    *sample = (struct sample){.uv = {u, v}};
    surface_outer(surface, uv, outer);
    if ((trim && !trim_contains(trim, outer)) || !surface_point_at(surface, cursor, uv, point))
        return false;
    sample->r = point->jet.r;
    sample->normal = point->normal;
    return true;
}

static bool opposed(const struct sample *a, const struct sample *b) {
    return vec3_dot(a->normal, b->normal) < 0;
}

static bool turns_back_between(const struct surface *surface, const struct trim *trim,
                               struct sample a, struct sample b, struct vec3 *at) {
    struct surface_cursor cursor = {0};
    struct surface_point point;
    struct sample middle;
    for (int k = 0; k < HALVINGS && opposed(&a, &b); k++) {
        if (!sample_at(surface, trim, &cursor, a.uv[0] + half * (b.uv[0] - a.uv[0]),
                       a.uv[1] + half * (b.uv[1] - a.uv[1]), &point, &middle))
            break;
        *(opposed(&a, &middle) ? &b : &a) = middle;
    }
    *at = a.r;
    return vec3_dot(a.normal, b.normal) < back_cosine;
}

static double greatest_curvature(const struct surface_point *point) {
    double mean, radius;
    if (!(surface_point_determinant(point) > regular_share * point->first[0] * point->first[2]))
        return 0;
    surface_point_principal_curvatures(point, &mean, &radius);
    return fabs(mean) + radius;
}

/* The greatest curvature about a sample that has the greatest of all: to where it grows, by steps
 * in each direction that are halved where it does not. */
static double sharpen(const struct surface *surface, const struct trim *trim, const double from[2],
                      const int count[2], double most) {
    struct surface_cursor cursor = {0};
    double uv[2] = {from[0], from[1]}, lower[2], upper[2], step[2];
    surface_domain(surface, lower, upper);
    for (int k = 0; k < 2; k++)
        step[k] = (upper[k] - lower[k]) / count[k];
    for (int round = 0; round < SHARPENINGS; round++) {
        bool grows = false;
        for (int way = 0; way < 4; way++) {
            struct surface_point point;
            struct sample own;
            double there[2] = {uv[0], uv[1]};
            int k = way / 2;
            there[k] = fmin(fmax(there[k] + (way % 2 ? step[k] : -step[k]), lower[k]), upper[k]);
            if (!sample_at(surface, trim, &cursor, there[0], there[1], &point, &own) ||
                !(greatest_curvature(&point) > most))
                continue;
            most = greatest_curvature(&point);
            uv[0] = there[0];
            uv[1] = there[1];
            grows = true;
        }
        for (int k = 0; k < 2 && !grows; k++)
            step[k] /= 2;
    }
    return most;
}

/* Number k of the `count` samples of a direction. */
static double place_of_sample(const struct surface_axis *axis, int k, int count) {
    double at = (k + 0.5) * axis->span_count / count;
    int span = (int)at;
    return axis->breaks[span] + (at - span) * (axis->breaks[span + 1] - axis->breaks[span]);
}

void surface_bends_find(const struct surface *surface, const struct trim *trim,
                        struct surface_bends *bends) {
    const struct surface_axis *axis = surface->axis;
    struct sample row[SAMPLES_MOST] = {{.uv = {0}}};
    struct surface_cursor cursor = {0};
    double most = 0, sharpest[2] = {0, 0};
    int count[2];
    for (int k = 0; k < 2; k++)
        count[k] = (int)fmin(fmax(axis[k].span_count, SAMPLES_LEAST), SAMPLES_MOST);
    if (count[0] * count[1] > SAMPLES_ALL)
        count[0] = count[1] = 64;
    *bends = (struct surface_bends){.turns_back = false};
    for (int j = 0; j < count[1]; j++) {
        struct sample last = {.uv = {0}};
        double v = place_of_sample(&axis[1], j, count[1]);
        for (int i = 0; i < count[0]; i++) {
            struct surface_point point;
            struct sample own;
            if (sample_at(surface, trim, &cursor, place_of_sample(&axis[0], i, count[0]), v, &point,
                          &own) &&
                greatest_curvature(&point) > most) {
                most = greatest_curvature(&point);
                memcpy(sharpest, own.uv, sizeof sharpest);
            }
            const struct sample *before = opposed(&last, &own)     ? &last
                                          : opposed(&row[i], &own) ? &row[i]
                                                                   : NULL;
            if (before && !bends->turns_back)
                bends->turns_back = turns_back_between(surface, trim, *before, own, &bends->turn);
            last = row[i] = own;
        }
    }
    bends->least_radius = 1 / (most > 0 ? sharpen(surface, trim, sharpest, count, most) : 0);
}
