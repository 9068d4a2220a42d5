/* SPDX-License-Identifier: MIT */
#include "goursat.h"
#include "chebyshev.h"
#include <assert.h>
#include <stdlib.h>

enum { PICARD_MAX = 200, GENERATOR_BLOCKS = 16, GENERATOR_ORDER = 16 };
static const double PICARD_GOAL = 1e-12; /* relative to the block's step */

/* (u, v) and its derivatives at one collocation point. */
struct state {
    double x[2], p[2], q[2];
};

/* The block that holds s in [0, length], and the place in it. */
static int block_of(double s, double length, int blocks, double *rest) {
    double place = s / length * blocks;
    int b = (int)floor(place);
    b = b < 0 ? 0 : b >= blocks ? blocks - 1 : b;
    *rest = place - b;
    return b;
}

/* quadrant[(t < 0) * 2 + (s < 0)], each blocks x blocks x n x n states, s slowest in a block. */
struct exact_net {
    struct exact_net_setup setup;
    struct chebyshev rule;
    struct state *quadrant[4];
};

static struct state *net_block(const struct exact_net *net, struct state *quadrant, int a, int b) {
    int n = net->rule.n;
    return quadrant + ((a * net->setup.blocks + b) * n) * n;
}

/* New p, q and x of one block from F; returns the largest change relative to the step. */
static double net_sweep(const struct exact_net *net, struct state *at, const double (*f)[2],
                        const double h[2]) {
    const struct chebyshev *rule = &net->rule;
    int n = rule->n;
    double change = 0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            struct state *here = at + i * n + j;
            for (int k = 0; k < 2; k++) {
                double p = at[i * n].p[k], q = at[j].q[k], before = here->x[k];
                double x = at[i * n].x[k];
                for (int l = 0; l < n; l++) {
                    p += h[1] * rule->integral[j][l] * f[i * n + l][k];
                    q += h[0] * rule->integral[i][l] * f[l * n + j][k];
                    x += h[1] * rule->integral[j][l] * at[i * n + l].q[k];
                }
                if (j > 0) {
                    here->p[k] = p;
                    here->x[k] = x;
                }
                if (i > 0) {
                    here->q[k] = q;
                }
                change = fmax(change, fabs(here->x[k] - before));
            }
        }
    }
    return change;
}

/* The block's edges i = 0 (x, q) and j = 0 (x, p) are known; the other states are guesses. */
static void net_solve_block(const struct exact_net *net, struct state *at, const double h[2]) {
    static double f[CHEBYSHEV_MAX * CHEBYSHEV_MAX][2];
    int n = net->rule.n;
    double change = (double)INFINITY, size = 0;
    for (int i = 1; i < n; i++) {
        for (int j = 1; j < n; j++) {
            for (int k = 0; k < 2; k++) {
                at[i * n + j].x[k] = at[i * n].x[k] + at[j].x[k] - at[0].x[k];
            }
        }
    }
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            for (int k = 0; k < 2; k++) {
                at[i * n + j].p[k] = at[i * n].p[k];
                at[i * n + j].q[k] = at[j].q[k];
                size = fmax(size, fabs(h[0] * at[i * n].p[k]) + fabs(h[1] * at[j].q[k]));
            }
        }
    }
    for (int sweep = 0; sweep < PICARD_MAX; sweep++) {
        double before = change;
        for (int l = 0; l < n * n; l++) {
            struct surface_jet jet;
            shape_evaluate(net->setup.shape, at[l].x[0], at[l].x[1], &jet);
            jet_connection(&jet, at[l].p, at[l].q, f[l]);
        }
        change = net_sweep(net, at, (const double(*)[2])f, h) / size;
        if (change < PICARD_GOAL && change >= before / 2) { /* only rounding is left */
            break;
        }
    }
}

/* The generator k at the net's own points, blocks x n; the caller frees it. */
static struct state *generator(const struct exact_net *net, int k, double sign) {
    struct exact_geodesic_setup setup = {
        .shape = net->setup.shape,
        .uv = {net->setup.uv[0], net->setup.uv[1]},
        .direction = vec3_scale(sign, k ? net->setup.weft : net->setup.warp),
        .length = net->setup.length[k],
        .blocks = GENERATOR_BLOCKS,
        .order = GENERATOR_ORDER,
    };
    struct exact_geodesic *geodesic = exact_geodesic_make(&setup);
    int n = net->rule.n, blocks = net->setup.blocks;
    struct state *at = calloc((size_t)(blocks * n), sizeof *at);
    assert(at);
    for (int i = 0; i < blocks * n; i++) {
        double s = (i / n + net->rule.x[i % n]) * setup.length / blocks;
        exact_geodesic_at(geodesic, s, at[i].x, at[i].p);
    }
    exact_geodesic_free(geodesic);
    return at;
}

/* Known edges of block (a, b): from its neighbours, or from the generators. */
static void net_edges(const struct exact_net *net, struct state *quadrant, int a, int b,
                      const struct state *warp, const struct state *weft) {
    int n = net->rule.n;
    struct state *at = net_block(net, quadrant, a, b);
    for (int i = 0; i < n; i++) {
        struct state *low = at + i * n, *left = at + i;
        if (b > 0) {
            *low = net_block(net, quadrant, a, b - 1)[i * n + n - 1];
        } else {
            *low = warp[a * n + i];
        }
        if (a > 0) {
            *left = net_block(net, quadrant, a - 1, b)[(n - 1) * n + i];
        } else {
            const struct state *from = &weft[b * n + i];
            double p[2] = {left->p[0], left->p[1]};
            *left =
                (struct state){{from->x[0], from->x[1]}, {p[0], p[1]}, {from->p[0], from->p[1]}};
        }
    }
}

static void net_quadrant(struct exact_net *net, int which) {
    int blocks = net->setup.blocks, n = net->rule.n;
    double h[2] = {net->setup.length[0] / blocks, net->setup.length[1] / blocks};
    struct state *warp = generator(net, 0, which % 2 ? -1 : 1);
    struct state *weft = generator(net, 1, which / 2 ? -1 : 1);
    struct state *quadrant = calloc((size_t)(blocks * blocks * n * n), sizeof *quadrant);
    assert(quadrant);
    for (int a = 0; a < blocks; a++) {
        for (int b = 0; b < blocks; b++) {
            net_edges(net, quadrant, a, b, warp, weft);
            net_solve_block(net, net_block(net, quadrant, a, b), h);
        }
    }
    net->quadrant[which] = quadrant;
    free(warp);
    free(weft);
}

struct exact_net *exact_net_make(const struct exact_net_setup *setup) {
    struct exact_net *net = calloc(1, sizeof *net);
    assert(net);
    net->setup = *setup;
    chebyshev_make(&net->rule, setup->order);
    for (int which = 0; which < (setup->one_quadrant ? 1 : 4); which++) {
        net_quadrant(net, which);
    }
    return net;
}

void exact_net_free(struct exact_net *net) {
    if (net) {
        for (int which = 0; which < 4; which++) {
            free(net->quadrant[which]);
        }
        free(net);
    }
}

void exact_net_at(const struct exact_net *net, double s, double t, struct exact_net_point *point) {
    double rest[2], ws[CHEBYSHEV_MAX], wt[CHEBYSHEV_MAX];
    int n = net->rule.n;
    int a = block_of(fabs(s), net->setup.length[0], net->setup.blocks, &rest[0]);
    int b = block_of(fabs(t), net->setup.length[1], net->setup.blocks, &rest[1]);
    const struct state *at = net_block(net, net->quadrant[(t < 0) * 2 + (s < 0)], a, b);
    struct state sum = {.x = {0, 0}};
    chebyshev_weights(&net->rule, rest[0], ws);
    chebyshev_weights(&net->rule, rest[1], wt);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            double weight = ws[i] * wt[j];
            for (int k = 0; k < 2; k++) {
                sum.x[k] += weight * at[i * n + j].x[k];
                sum.p[k] += weight * at[i * n + j].p[k];
                sum.q[k] += weight * at[i * n + j].q[k];
            }
        }
    }
    double ss = s < 0 ? -1 : 1, st = t < 0 ? -1 : 1;
    struct surface_jet jet;
    shape_evaluate(net->setup.shape, sum.x[0], sum.x[1], &jet);
    point->uv[0] = sum.x[0];
    point->uv[1] = sum.x[1];
    point->r = jet.r;
    point->warp = vec3_axpy(ss * sum.p[0], jet.u, vec3_scale(ss * sum.p[1], jet.v));
    point->weft = vec3_axpy(st * sum.q[0], jet.u, vec3_scale(st * sum.q[1], jet.v));
    point->shear_deg = 90 - vec3_angle(point->warp, point->weft) * 180 / M_PI;
}

/* dA = |r_s x r_t| ds dt; the last row of the integral matrix integrates over the block. */
double exact_net_curvature(const struct exact_net *net, int sign_s, int sign_t) {
    int n = net->rule.n, blocks = net->setup.blocks;
    struct state *quadrant = net->quadrant[(sign_t < 0) * 2 + (sign_s < 0)];
    const double *weight = net->rule.integral[n - 1];
    double h = net->setup.length[0] * net->setup.length[1] / (blocks * blocks), sum = 0;
    for (int l = 0; l < blocks * blocks * n * n; l++) {
        const struct state *at = quadrant + l;
        struct surface_jet jet;
        shape_evaluate(net->setup.shape, at->x[0], at->x[1], &jet);
        double area = at->p[0] * at->q[1] - at->p[1] * at->q[0];
        area = fabs(area) * vec3_norm(vec3_cross(jet.u, jet.v));
        sum += h * weight[l / n % n] * weight[l % n] * jet_gauss(&jet) * area;
    }
    return sum;
}
