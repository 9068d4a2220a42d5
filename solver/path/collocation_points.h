/* SPDX-License-Identifier: MIT */
/* The body of a collocation kernel, for files that say LANES and COLLOCATION_KERNEL. */
#ifndef SOLVER_PATH_COLLOCATION_POINTS_H
#define SOLVER_PATH_COLLOCATION_POINTS_H

#include "collocation.h"
#include "solver/surface/evaluate_lanes.h"

#define FORMULAS_OF_LANES
#include "solver/shell/tangent_plane.h"
#undef FORMULAS_OF_LANES

#define POINTS COLLOCATION_POINTS
#define BATCHES(k) for (int k = 0; k < POINTS; k += LANES)

/* Gauss's method: what each point counts in the whole, and, by column, in what has come about at
 * each of the others. */
static const double gauss_weight[POINTS] = {
    0.05061426814518813, 0.11119051722668724, 0.15685332293894363, 0.181341891689181,
    0.181341891689181,   0.15685332293894363, 0.11119051722668724, 0.05061426814518813};
static const double gauss_column[POINTS][POINTS] = {
    {0.025307134072594065, 0.05475932176755432, 0.048587535998912884, 0.05186552097058123,
     0.04975503156092328, 0.051233073840438646, 0.05017146584084589, 0.05089177647230505},
    {-0.009105943305970076, 0.05559525861334362, 0.12085952499717317, 0.1061934901483484,
     0.114388331537048, 0.10896480245140233, 0.11275545213763617, 0.11021775956262797},
    {0.006280831147030474, -0.01363979623578167, 0.07842666146947182, 0.17067113427455363,
     0.14961211637772137, 0.16149678880104812, 0.15371356995347998, 0.1587709981935806},
    {-0.004483015613054752, 0.008149708858360551, -0.01597510336187843, 0.0906709458445905,
     0.197362933010206, 0.17297015896895482, 0.18655724377832814, 0.17826340032085422},
    {0.0030784913683267797, -0.0052153520891471536, 0.008371732720226163, -0.016021041321025012,
     0.0906709458445905, 0.19731699505105943, 0.17319218283082044, 0.18582490730223575},
    {-0.0019176752546369523, 0.003139752985463669, -0.00464346586210448, 0.00724120656122227,
     -0.013817811335609978, 0.07842666146947182, 0.17049311917472532, 0.15057249179191318},
    {0.0009727576640592635, -0.0015649349109489424, 0.0022257147752849, -0.0031978143103607703,
     0.004997027078338829, -0.009669007770485932, 0.05559525861334362, 0.12029646053265731},
    {-0.0002775083271169192, 0.00044280230434223783, -0.0006188056952505154, 0.0008592365842648527,
     -0.001251252825393105, 0.0020267321462752487, -0.004145053622366191, 0.025307134072594065},
};

typedef double points[POINTS];

INLINE struct lanes3 load_points(points *of, int k) {
    return (struct lanes3){lanes_load(&of[0][k]), lanes_load(&of[1][k]), lanes_load(&of[2][k])};
}

INLINE void store_points(struct lanes3 a, points *of, int k) {
    lanes_store(a.x, &of[0][k]);
    lanes_store(a.y, &of[1][k]);
    lanes_store(a.z, &of[2][k]);
}

/* Of a unit tangent t with the components (a, b): the part of its derivative along the normal. */
INLINE struct lanes3 bend_of(const struct lanes_jet *jet, struct lanes3 tangent) {
    struct tangent_basis_lanes basis = tangent_basis_of_lanes(jet->u, jet->v);
    struct lanes3 cross = lanes3_cross(jet->u, jet->v);
    lanes ab[2];
    tangent_components_lanes(&basis, tangent, ab);
    struct lanes3 along = jet_bend_lanes(jet, ab);
    return lanes3_scale(lanes3_dot(along, cross) * basis.inverse, cross);
}

/* What a rate has brought about at the points k and those beside it, by a share of the piece. */
INLINE struct lanes3 come_about(points *rate, int k) {
    struct lanes3 sum = {{0}, {0}, {0}};
    _Pragma("GCC unroll 8") for (int j = 0; j < POINTS; j++) {
        lanes column = lanes_load(&gauss_column[j][k]);
        sum.x += column * rate[0][j];
        sum.y += column * rate[1][j];
        sum.z += column * rate[2][j];
    }
    return sum;
}

INLINE struct vec3 whole_of(points *rate) {
    double sum[3];
    for (int x = 0; x < 3; x++) {
        sum[x] = 0;
        for (int j = 0; j < POINTS; j++)
            sum[x] += gauss_weight[j] * rate[x][j];
    }
    return vec3_make(sum[0], sum[1], sum[2]);
}

static void evaluate_piece(const struct surface *surface, struct collocation_piece *piece) {
    _Alignas(64) points turned[3]; /* the tangent, less that at the start */
    lanes length = lanes_of(piece->length);
    BATCHES(k) {
        struct lanes_jet jet;
        span_jet_lanes(surface, piece->span[0], piece->span[1],
                       lanes_load(&piece->uv[0][k]) - piece->turn[0],
                       lanes_load(&piece->uv[1][k]) - piece->turn[1], &jet);
        store_points(bend_of(&jet, load_points(piece->tangent, k)), piece->bend, k);
        store_points(jet.r, piece->jet, k);
        store_points(jet.u, piece->jet + 3, k);
        store_points(jet.v, piece->jet + 6, k);
        store_points(jet.uu, piece->jet + 9, k);
        store_points(jet.uv, piece->jet + 12, k);
        store_points(jet.vv, piece->jet + 15, k);
    }
    BATCHES(k) store_points(lanes3_scale(length, come_about(piece->bend, k)), turned, k);
    BATCHES(k) {
        struct lanes3 way = come_about(turned, k), leave = lanes3_of(piece->leave);
        way = lanes3_axpy(lanes_load(&collocation_point[k]), leave, way);
        store_points(lanes3_add(leave, load_points(turned, k)), piece->tangent, k);
        store_points(lanes3_axpy(length, way, lanes3_of(piece->from)), piece->r, k);
    }
    piece->arrive = vec3_axpy(piece->length, whole_of(piece->bend), piece->leave);
    piece->to = vec3_axpy(piece->length, vec3_add(piece->leave, whole_of(turned)), piece->from);
}

static void move_piece(struct collocation_piece *piece, struct vec3 turn, const double shift[2]) {
    BATCHES(k) {
        lanes share = lanes_load(&collocation_point[k]), ab[2];
        lanes along = piece->begin + piece->length * share;
        lanes further = shift[0] + (shift[1] - shift[0]) * share;
        struct lanes3 tangent = load_points(piece->tangent, k);
        struct lanes3 bend = load_points(piece->bend, k), turned = lanes3_of(turn);
        struct lanes3 to = lanes3_axpy(along, turned, load_points(piece->r, k));
        to = lanes3_axpy(further, lanes3_axpy(further / 2, bend, tangent), to);
        struct lanes3 step = lanes3_sub(to, load_points(piece->jet, k));
        const struct lanes_jet jet = {.u = load_points(piece->jet + 3, k),
                                      .v = load_points(piece->jet + 6, k),
                                      .uu = load_points(piece->jet + 9, k),
                                      .uv = load_points(piece->jet + 12, k),
                                      .vv = load_points(piece->jet + 15, k)};
        struct tangent_basis_lanes b = tangent_basis_of_lanes(jet.u, jet.v);
        tangent_components_lanes(&b, step, ab);
        struct lanes3 second = jet_bend_lanes(&jet, ab);
        tangent_components_lanes(&b, lanes3_axpy(lanes_of(-0.5), second, step), ab);
        lanes_store(lanes_load(&piece->uv[0][k]) + ab[0], piece->uv[0] + k);
        lanes_store(lanes_load(&piece->uv[1][k]) + ab[1], piece->uv[1] + k);
        lanes_store(b.e * ab[0] * ab[0] + 2 * b.f * ab[0] * ab[1] + b.g * ab[1] * ab[1],
                    piece->moved2 + k);
        tangent = lanes3_add(tangent, lanes3_axpy(further, bend, turned));
        store_points(tangent, piece->tangent, k);
    }
}

const struct collocation_kernel COLLOCATION_KERNEL = {evaluate_piece, move_piece};

#endif
