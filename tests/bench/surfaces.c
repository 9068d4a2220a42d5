/* SPDX-License-Identifier: MIT */
#include "surfaces.h"

#include <math.h>

/* A free-form surface about [-1, 1]^2: what its kind is made of. */
struct recipe {
    const char *name;
    int degree[2], spans[2];
    int multiplicity;     /* of interior knots */
    double uneven;        /* the longest span is about this many times the shortest */
    double height, waves; /* of the control net: amplitude, and radians from side to side */
    double weights;       /* 1 / weights .. weights */
    int trim;             /* 0 none; 1 a hole; 2 a slanted border and a hole */
};

static const struct recipe recipes[] = {
    {"biquadratic", {2, 2}, {4, 4}, 1, 4, 0.25, 4, 3, 0},
    {"bicubic", {3, 3}, {6, 6}, 1, 4, 0.25, 5, 3, 0},
    {"biquartic", {4, 4}, {2, 3}, 1, 3, 0.3, 4, 2, 0},
    {"biquintic, one span", {5, 5}, {1, 1}, 1, 1, 0.6, 6, 3, 0},
    {"biquintic", {5, 5}, {4, 2}, 1, 6, 0.3, 5, 3, 0},
    {"sextic", {6, 6}, {2, 2}, 1, 3, 0.4, 5, 3, 0},
    {"septic, one span", {7, 7}, {1, 1}, 1, 1, 0.8, 7, 3, 0},
    {"2 x 7", {2, 7}, {5, 1}, 1, 4, 0.3, 5, 2, 0},
    {"3 x 5, double knots", {3, 5}, {4, 3}, 2, 4, 0.2, 4, 3, 0},
    {"bicubic, 20 x 20 spans", {3, 3}, {20, 20}, 1, 10, 0.2, 7, 3, 0},
    {"bicubic with a hole", {3, 3}, {5, 5}, 1, 4, 0.2, 5, 2, 1},
    {"quintic, slanted border", {5, 3}, {3, 3}, 1, 4, 0.3, 5, 3, 2},
};
enum { RECIPES = sizeof recipes / sizeof *recipes };

/* Spans whose lengths grow and shrink along the axis, over [0, 1]. */
static void make_axis(struct shape *shape, int k, const struct recipe *recipe) {
    int p = recipe->degree[k], spans = recipe->spans[k], count = 0;
    double at = 0, whole = 0, *knots = shape->knots[k];
    for (int s = 0; s < spans; s++)
        whole += pow(recipe->uneven, 0.5 * sin(2.0 * s + k));
    for (int i = 0; i <= p; i++)
        knots[count++] = 0;
    for (int s = 0; s + 1 < spans; s++) {
        at += pow(recipe->uneven, 0.5 * sin(2.0 * s + k)) / whole;
        for (int i = 0; i < recipe->multiplicity; i++)
            knots[count++] = at;
    }
    for (int i = 0; i <= p; i++)
        knots[count++] = 1;
    shape->degree[k] = p;
    shape->size[k] = count - p - 1;
}

static double greville(const struct shape *shape, int k, int i) {
    double sum = 0;
    for (int m = 1; m <= shape->degree[k]; m++)
        sum += shape->knots[k][i + m];
    return 2 * sum / shape->degree[k] - 1;
}

static void make_free_form(struct shape *shape, const struct recipe *recipe) {
    make_axis(shape, 0, recipe);
    make_axis(shape, 1, recipe);
    for (int i = 0; i < shape->size[0]; i++)
        for (int j = 0; j < shape->size[1]; j++) {
            double x = greville(shape, 0, i), y = greville(shape, 1, j), n = recipe->waves / 2;
            double w = pow(recipe->weights, sin(1.7 * i + 2.9 * j));
            double *h = shape->h[i * shape->size[1] + j];
            h[0] = w * x;
            h[1] = w * y;
            h[2] = w * recipe->height * (sin(n * x + 0.3) * cos(n * y) + 0.3 * x * y);
            h[3] = w;
        }
}

static void add_loop(struct bench_surface *s, const double centre[2], const double radius[2],
                     int corners, bool reversed) {
    size_t k = s->loop_count++;
    for (int c = 0; c < corners; c++)
        for (int n = 0; n < 2; n++) {
            double angle = 2 * M_PI * (c + 0.4) / corners;
            s->corners[k][c][n] = centre[n] + radius[n] * (n ? sin(angle) : cos(angle));
        }
    s->curves[k] = (struct trim_curve){
        .degree = 1, .points = (const double(*)[2])s->corners[k], .count = (size_t)corners};
    s->loops[k] = (struct trim_loop){reversed, &s->curves[k], 1};
}

static void add_trims(struct bench_surface *s, int kind) {
    static const double hole[2] = {0.3, 0.65}, hole_radius[2] = {0.12, 0.08};
    static const double middle[2] = {0.5, 0.5}, border[2] = {0.48, 0.4};
    if (kind >= 2)
        add_loop(s, middle, border, 5, true);
    if (kind >= 1)
        add_loop(s, hole, hole_radius, 24, false);
}

static void make_round(struct bench_surface *s, int which) {
    static const double whole[2] = {0, 2 * M_PI}, quarter[2] = {0, M_PI / 2};
    static const double up[2] = {0, M_PI / 2}, band[2] = {-1.2, 1.2}, tube[2] = {0, 2 * M_PI};
    static const double all[2] = {-M_PI / 2, M_PI / 2}, foot[2] = {1, 0}, top[2] = {0.4, 1.5};
    static const double rod[2] = {1, 2};
    static const char *const names[] = {
        "sphere, two poles",  "torus",      "cylinder",         "cone frustum",
        "octant of a sphere", "hemisphere", "band of a sphere", "disk, singular corners"};
    s->name = names[which];
    if (which == 0)
        shape_sphere(&s->shape, 1, whole, all, M_PI / 2);
    else if (which == 1)
        shape_torus(&s->shape, 2, 0.7, whole, tube, M_PI / 2);
    else if (which == 2)
        shape_frustum(&s->shape, whole, foot, rod, M_PI / 2);
    else if (which == 3)
        shape_frustum(&s->shape, whole, foot, top, M_PI / 2);
    else if (which == 4)
        shape_sphere(&s->shape, 1, quarter, up, M_PI / 2);
    else if (which == 5)
        shape_sphere(&s->shape, 1, whole, up, M_PI / 2);
    else if (which == 6)
        shape_sphere(&s->shape, 1, whole, band, M_PI / 2);
    else
        shape_disk(&s->shape, 1);
}

void bench_surface_make(struct bench_surface *surface, int number) {
    *surface = (struct bench_surface){.angle_deg = 20 + 17 * number, .start = {0.47, 0.53}};
    if (number < RECIPES) {
        surface->name = recipes[number].name;
        make_free_form(&surface->shape, &recipes[number]);
        add_trims(surface, recipes[number].trim);
    } else {
        make_round(surface, number - RECIPES);
    }
}
