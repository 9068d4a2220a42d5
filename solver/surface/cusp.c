/* SPDX-License-Identifier: MIT */
/*
 * Where a surface turns back on itself: at a cusp, a fold by 180 degrees, or along a line beyond
 * which weights or control points have turned it inside out. Cloth ends there.
 */
#include "spans.h"
#include "trim.h"

/* Samples in each direction. Between two whose normals differ by more than a right angle so many
 * halvings find whether they do so at one point, by more than the 178 degrees at which cloth ends:
 * where the surface goes round a bend they do not. */
enum { SAMPLES = 32, HALVINGS = 50 };
static const double back_cosine = -0.99939;

/* A little off the middle, where symmetric parts have their cusps and so no normal. */
static const double half = 0.49;

/* A point of the region and the normal there; not `known` where there is none. */
struct sample {
    double uv[2];
    struct vec3 r, normal;
    bool known;
};

static struct sample sample_at(const struct surface *surface, const struct trim *trim, double u,
                               double v) {
    struct sample sample = {.uv = {u, v}};
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    double outer[2];
    surface_outer(surface, sample.uv, outer);
    surface_jet_at(surface, &cursor, u, v, &jet);
    struct vec3 normal = vec3_cross(jet.u, jet.v);
    sample.r = jet.r;
    sample.known = vec3_norm2(normal) > 0 && (!trim || trim_contains(trim, outer));
    sample.normal = vec3_unit(normal);
    return sample;
}

static bool opposed(const struct sample *a, const struct sample *b) {
    return a->known && b->known && vec3_dot(a->normal, b->normal) < 0;
}

static bool turns_back_between(const struct surface *surface, const struct trim *trim,
                               struct sample a, struct sample b, struct vec3 *at) {
    for (int k = 0; k < HALVINGS && opposed(&a, &b); k++) {
        struct sample middle = sample_at(surface, trim, a.uv[0] + half * (b.uv[0] - a.uv[0]),
                                         a.uv[1] + half * (b.uv[1] - a.uv[1]));
        if (!middle.known)
            break;
        *(opposed(&a, &middle) ? &b : &a) = middle;
    }
    *at = a.r;
    return opposed(&a, &b) && vec3_dot(a.normal, b.normal) < back_cosine;
}

/* Number k of the samples of a direction: as many in each span as go. */
static double sample_of(const struct surface_axis *axis, int k) {
    double at = (k + 0.5) * axis->span_count / SAMPLES;
    int span = (int)at;
    return axis->breaks[span] + (at - span) * (axis->breaks[span + 1] - axis->breaks[span]);
}

bool surface_turns_back(const struct surface *surface, const struct trim *trim, struct vec3 *at) {
    struct sample row[SAMPLES] = {{.known = false}};
    for (int j = 0; j < SAMPLES; j++) {
        struct sample last = {.known = false};
        double v = sample_of(&surface->axis[1], j);
        for (int i = 0; i < SAMPLES; i++) {
            struct sample own = sample_at(surface, trim, sample_of(&surface->axis[0], i), v);
            if (turns_back_between(surface, trim, last, own, at) ||
                turns_back_between(surface, trim, row[i], own, at))
                return true;
            last = row[i] = own;
        }
    }
    return false;
}
