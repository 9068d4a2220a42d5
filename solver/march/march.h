/* SPDX-License-Identifier: MIT */
/*
 * The march: grows the net over the surface.
 *
 * 1. Two generators through the start, four arms.
 * 2. The four quadrants between them, row by row: node (i, j) from A = (i-1, j-1), B = (i-1, j),
 *    C = (i, j-1), over the continued surface where it is left, so that a part drapes like the
 *    larger surface it was cut from.
 * 3. What the quadrants cannot reach: cells with three corners give the fourth, from whichever
 *    side; where none is left, a yarn whose pinning neighbour is missing goes straight on.
 */
#ifndef SOLVER_MARCH_MARCH_H
#define SOLVER_MARCH_MARCH_H

#include "solver/arena.h"
#include "solver/fishnet/correction.h"
#include "solver/fishnet/fishnet.h"
#include "solver/fishnet/rough.h"
#include "solver/mesh/smooth_path.h"
#include "solver/net/net.h"
#include "solver/net/overlap.h"
#include "solver/settings.h"
#include "solver/shell/shell_slit.h"
#include "solver/shell/surface_point.h"
#include "solver/surface/trim.h"
#include <stdatomic.h>

/* How a generator that is a polyline passes the start. */
struct march_curve {
    struct surface_point
        from;       /* the start; at a pole with the parameters that the polyline has there */
    int sense;      /* of its points along the positive arm: 1 or -1 */
    size_t next[2]; /* its first point off the start in the sense of its points, and against it */
    bool ends[2];   /* there is none */
};

/* The start and its two yarn directions. */
struct march_start {
    struct surface_point point;
    struct vec3 warp, weft; /* unit, in the tangent plane */
    struct vec3 zero;       /* likewise: what angles are counted from; 0 where that has no part */
    struct vec3 side;       /* the normal, of several faces on the first one's side */
    struct surface_point
        smooth; /* on a mesh made of a surface: the start there, and the directions */
    struct vec3 smooth_direction[2];
    struct march_curve curve[2];
};

/* What has been reported to the monitor. */
struct march_watch {
    _Atomic size_t inside; /* nodes of all parts */
    size_t next;           /* nodes inside at which the monitor is called again */
    atomic_flag busy;      /* a thread is calling it */
    _Atomic bool stopped;  /* it answered stop */
};

/* The rough edges of a node that is about to be placed, and whether it rests on growth. */
struct march_edges {
    uint8_t rough, parted; /* as net_node's */
    struct net_yarns yarns;
};

/* A node that the growth placed: as the fourth corner of the cell that lies in the direction (di,
 * dj) of its A, or by a yarn from (i - di, j - dj), straight on or across another one. */
enum march_way { MARCH_CELL, MARCH_STRAIGHT, MARCH_ACROSS };

struct march_step {
    int32_t i, j;
    int8_t di, dj;
    uint8_t way; /* enum march_way */
};

struct march_steps {
    struct march_step *step;
    size_t count, room;
};

/* Yarns do not stretch: the ends of none are further apart than its spacing by more than this
 * share. */
#define MARCH_STRETCH 1e-3

/* What lies between a place and its face of a shell. */
struct march_look {
    const struct surface *surface; /* the face; NULL: none has been looked at */
    double uv[2];
    struct crossing crossing;
};

/* Where the net of a closed surface or a tube is cut open: opposite the start, or where trims leave
 * the surface bare (`march_open`). */
struct march_cut {
    const struct shell_slit *slit[2]; /* of a shell, the second of one that closes both ways; NULL:
                                         it is not cut */
    double centre[2];                 /* closed directions are cut half a turn from there */
    bool passed;                      /* the net now goes on over the cuts */
    bool inward; /* the surface bends to the side of its normal at the start: the net's order is
                    that of its mirror image, so that it does not follow from where normals point */
};

struct cuts;

struct march_counts {
    size_t inside, ghosts; /* nodes placed */
    size_t reported;       /* of those inside, to the watch */
    size_t solved;         /* cells, by so many iterations, with residuals of at most: */
    size_t iterations;
    double residual_max;
    size_t out_of_step; /* places where branches of the net come together that do not fit */
    bool broken;        /* the net ends inside the part: yarns collapse, or no node was found */
};

struct march {
    /* What is given. */
    const struct surface *surface; /* of a shell the start's face; NULL on a mesh of the caller's */
    const struct trim *trim;       /* the usable region of a surface; NULL: all of it */
    const struct mesh *mesh;       /* the caller's, or for the method mosaic; else NULL */
    const struct mesh *tube; /* `march_tube_mesh` of the surface; NULL: it is made where needed */
    const struct mesh_smooth *smooth; /* what a mesh of the caller's stands for; NULL for mosaic */
    const struct drape_settings *settings;
    const struct drape_method_traits *method; /* of the settings' method */
    const struct drape_monitor *monitor;      /* may be NULL */
    struct arena *arena;
    struct march_watch *watch; /* shared by all quadrants of the march */
    struct march_start start;
    struct march_cut cut;
    const struct cuts *cuts; /* of the cloth; NULL: it has none */
    /* The net, and of a march that corrects another the net before. */
    struct net *net;
    struct march_counts counts;
    double size;      /* of the part, however it is turned and cut: the root of twelve times its
                         radius of gyration, which of a flat rectangle is the diagonal */
    size_t max_nodes; /* at most those of the settings */
    int fringe;       /* ghosts beyond the last node inside that difference stencils reach */
    struct net *first;
    struct net_view before;   /* of `first` */
    struct march_steps grown; /* the growth's, in order, if there is a net before */
    /* Whether the net meets itself. */
    struct overlap *overlap; /* NULL as long as it cannot */
    bool watched;            /* overlaps are looked for from the first node on */
    bool by_rows;            /* but not by march_place: by the quadrant, when rows are complete */
    bool growing;            /* branches of the net may come together that are out of step */
    /* Of the part of it that is at work. */
    const struct net_node *arm[2]; /* the places of the warp and weft arm beside a quadrant, where
                                      the net itself is not to be asked for them; else NULL */
    double length[2]; /* of the edges of a cell along warp and weft: the spacings, but where weft
                         slides what is being tried */
    struct surface_cursor cursor;
    struct march_edges edges; /* of the node solved last, for march_place */
    struct march_look look;   /* over the edge of a face of a shell, the last one */
};

/* Runs the whole march, twice for a method that corrects its first net; `march` has its surface or
 * mesh, its settings, method, monitor, arena, start and watch, and the cut of `march_open`, the
 * rest zero. Errors: STATUS_OUT_OF_MEMORY, STATUS_TOO_MANY_NODES, STATUS_CANCELLED, and
 * STATUS_START_STUCK when no yarn gets further than the start. */
enum status march_run(struct march *march) STATUS_MUST_USE;

/* Before that: cuts what is closed open opposite the start, or where trims leave it bare. Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status march_open(struct march *march) STATUS_MUST_USE;

/* The mesh by which it does so for a shell that may be a tube, of which `surface` is a face; NULL:
 * it is none, or cannot have one. Errors: STATUS_OUT_OF_MEMORY. */
enum status march_tube_mesh(const struct surface *surface, struct arena *arena,
                            const struct mesh **tube) STATUS_MUST_USE;

/* The steps it consists of, in files of their own. */
enum status march_generators(struct march *march) STATUS_MUST_USE;
enum status march_quadrants(struct march *march) STATUS_MUST_USE;
enum status march_growth(struct march *march) STATUS_MUST_USE;

/* A place of an arm: the arc length to it, the unit tangent and what is to the left of it, and the
 * Gaussian curvature there and half way from the place before; 0 where there is none. */
struct march_stop {
    double gone;
    struct vec3 r, tangent, left;
    double gauss, gauss_before;
};

/* The places 0, 1, .. of the arm with this number (positive and negative arm of warp, then of
 * weft), as exact as paths can be, by arcs or chords of the spacing; how many of `count` there are.
 * Not on a mesh. */
int32_t march_arm_stops(struct march *march, int number, int32_t count,
                        struct march_stop *stops) STATUS_MUST_USE;

/* Whether (i, j) lies in the extent asked for. */
bool march_in_extent(const struct march *march, int32_t i, int32_t j);

/* From now on the net is watched for meeting itself. */
enum status march_watch_overlaps(struct march *march) STATUS_MUST_USE;

/* Whether a net that was not watched from its first node on lies on itself somewhere. Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status march_find_overlap(struct march *march, bool *found) STATUS_MUST_USE;

/* The caller's parameters (u, v) of a point inside, in the domain of closed directions; on a mesh
 * without any (triangle, 0). Whether they lie in the domain. */
bool march_parameters(const struct march *march, const struct surface_point *point, double uv[2]);

/* The face of a shell that a point is on, 0 where there is no shell. */
static inline int32_t march_face(const struct march *march, const struct surface_point *point) {
    if (march->mesh && march->mesh->faces)
        return march->mesh->faces[(int32_t)point->uv[0]];
    return point->surface ? point->surface->face : 0;
}

/* What nodes have parameters of: NULL where they lie on triangles. */
static inline const struct surface *march_whole(const struct march *march) {
    return march->mesh ? NULL : march->surface;
}

/* The surface that a node's parameters belong to; NULL where it lies on triangles. */
static inline const struct surface *march_surface(const struct march *march,
                                                  const struct net_node *node) {
    const struct surface *surface = march_whole(march);
    return surface && surface->shell ? shell_surface(surface->shell, node->face) : surface;
}

/* The continuation is trusted up to so far from the boundary. */
double march_reach(const struct march *march);

/* Area to be covered. */
double march_area(const struct march *march);

/* Whether the net has left what is to be covered for good at a point that is not inside, as far
 * as is known: it is beyond the domain, or the box of the trimmed region. */
bool march_has_left(const struct march *march, const struct surface_point *point);

/* The zone of a point, that of the start or another, on the mesh or on the surface that it was made
 * of, and unless it is inside why the net ends there; only the start may lie on a trim. What is
 * next to the edge of the trimmed region is on it, as at the domain's own. */
enum surface_point_zone march_zone(struct march *march, const struct surface_point *point,
                                   bool start, enum drape_reason *reason);

/* Puts a point at (i, j), inside or as a ghost; beyond healthy continuation, or
 * where the net is already, a failure with its reason. `zone` gets which. */
enum status march_place(struct march *march, int32_t i, int32_t j,
                        const struct surface_point *point,
                        enum surface_point_zone *zone) STATUS_MUST_USE;

/* What lies between a point and its face of a shell; until the next call. */
const struct crossing *march_look_over(struct march *march, const struct surface_point *point);

/* Whether a point fits in at (i, j): all places known beside it are a spacing away along the
 * surface. Ghosts beside a node inside need not be. */
bool march_joins(struct march *march, int32_t i, int32_t j, const struct surface_point *point,
                 enum surface_point_zone zone);

/* Whether a net that ends for this reason has broken there: not at an edge, nor for what it was
 * asked for. */
static inline bool march_breaks_net(enum drape_reason reason) {
    return reason == DRAPE_REASON_COLLAPSED || reason == DRAPE_REASON_NO_CONVERGENCE ||
           reason == DRAPE_REASON_DEGENERATE;
}

/* Notes that there can be no node at (i, j). */
enum status march_fail(struct march *march, int32_t i, int32_t j,
                       enum drape_reason reason) STATUS_MUST_USE;

/* Notes that a cell could not be solved from B. Beside a cut its D may be a place that the cloth
 * does not have: that is left open, to be reached from elsewhere. */
enum status march_fail_cell(struct march *march, int32_t i, int32_t j, enum drape_reason reason,
                            const struct surface_point *b) STATUS_MUST_USE;

/* Whether a cut is within a cell's reach. */
bool march_is_beside_cut(const struct march *march, struct vec3 at);

/* Whether the tip of a cut is so near that yarns may go round it. */
bool march_is_beside_tip(const struct march *march, struct vec3 at);

/* Whether it is nearer than so many spacings. */
bool march_is_near_tip(const struct march *march, struct vec3 at, double reach);

/* Whether the edges of a cell whose A is there are laid as geodesics, for the tip of a cut: the
 * part may come to a point there, of which arcs know nothing. */
bool march_is_at_point(const struct march *march, struct vec3 at);

/* Whether a cut parts a node from a place of the part near it: the geodesic between them, or the
 * chord where that tells or there is none, passes it. Of a place that is not beside a tip only
 * where it is in space is asked. */
bool march_is_hidden(struct march *march, const struct net_node *node,
                     const struct surface_point *eye);

/* Whether a cut is passed on the way from the place `eye` beside the lip of a cut to one on it, and
 * on along a geodesic from there. */
bool march_way_passes_cut(struct march *march, const struct surface_point *eye,
                          const struct surface_point *lip, struct vec3 direction, double length);

/* Whether a cut parts the neighbour of (i, j) on the side (di, dj) from a point, whose rough edges
 * are those noted for march_place. */
bool march_is_parted(struct march *march, int32_t i, int32_t j, int di, int dj,
                     const struct surface_point *to);

/* The same of all four, as NET_EDGE_BITs, of a point beside a cut. */
uint8_t march_find_parted(struct march *march, int32_t i, int32_t j,
                          const struct surface_point *point);

/* The node at (i, j), NULL where the net has no place; on the arms beside a quadrant, whose tiles
 * others may be filling, from the quadrant's copy, which at the arm's end is no place. */
const struct net_node *march_node_at(const struct march *march, int32_t i, int32_t j);

/* The point of a node of the net; false where there is no tangent plane. */
bool march_point_at(struct march *march, const struct net_node *node, struct surface_point *point);

/* The unit normal of the surface at a node of the net; zero where there is none. */
struct vec3 march_normal_at(struct march *march, const struct net_node *node);

/* The point of a place of the net; false when (i, j) has none. */
bool march_point(struct march *march, int32_t i, int32_t j, struct surface_point *point);

/* The square of the distance from a pole, so many spacings, in which parameters turn too fast to be
 * extrapolated from cell to cell. */
static inline double march_pole_reach2(const struct march *march) {
    const double steps = 16, *d = march->settings->spacing;
    double reach = steps * (d[0] > d[1] ? d[0] : d[1]);
    return reach * reach;
}

/* A cell to be solved for D = (i, j), which lies in the direction (si, sj), each 1 or -1, of A: AC
 * along warp, AB along weft. */
struct march_cell {
    int32_t i, j;
    int si, sj;
    const struct surface_point *a, *b, *c;
    struct vec3 trend;      /* by which CD is expected to differ from AB */
    const double *guess_uv; /* the parameters expected of D, away from poles; or NULL */
    struct slide *slide;    /* where weft slides: by it the chord of CD follows from D; else NULL */
    double excess;          /* by which CD's chord is to be longer than that of its length */
};

/* The unit tangent of the yarn from the node (i, j), which is at `point`, to the one at
 * (i + di, j + dj), at that end of it, in the tangent plane there. False when the net lacks one. */
bool march_yarn(struct march *march, int32_t i, int32_t j, int di, int dj,
                const struct surface_point *point, struct vec3 *direction);

/* The directions in which the yarns through A leave B and C towards A, and those in which BD and CD
 * leave if the cell is a parallelogram on the unfolded surface: they turn from the former by the
 * angle between the yarns at A. False when the net lacks one of them. */
bool march_turn_as_at_a(struct march *march, const struct march_cell *at, struct vec3 back[2],
                        struct vec3 start[2]);

/* Notes for march_place that the edge to D from its neighbour on the negative (sign 1) or positive
 * (-1) side along warp (family 0) or weft is rough: the unit tangents of that yarn, towards D,
 * where it leaves and arrives. */
void march_note_edge(struct march *march, int family, int sign, struct vec3 start, struct vec3 end);

/* The same of both edges of a cell that end in D: `start` and `end` of BD and CD, as in `struct
 * fishnet_yarns`. */
void march_note_edges(struct march *march, const struct march_cell *at, const struct vec3 start[2],
                      const struct vec3 end[2]);

/* Of a second march, whose `before` has been moved to D: the parameters of D in the net before,
 * moved as those of the other corners have moved since. False where that net lacks one of them. */
bool march_guess_from_before(const struct march *march, const struct march_cell *at, double uv[2]);

/* The corrections of the edges BD and CD by the net before; `has` where there is one. */
struct march_corrections {
    struct correction of[2];
    bool has[2];
    double excess; /* of the cell, whose weft slides: it then has no correction of CD */
};

void march_find_corrections(const struct march *march, const struct march_cell *at,
                            struct march_corrections *c);

/* The chord of edge k, from `from`, where the surface's curvature along it is known, as its arc's;
 * of a correction that does not agree with that nothing but the sideways part is used. */
double march_corrected_chord(struct march_corrections *c, int k, const struct surface_point *from,
                             double curvature, double arc_chord);

/* What the edge to D from B (k = 0) or C is, with the curvature of its arc, and its *chord, which
 * was found before D was known: as far as that is to be kept, *chord does not change. Of a rough
 * edge it tells nothing. */
enum rough_kind march_edge_chord(const struct march *march, const struct march_corrections *c,
                                 int k, const struct surface_point *from,
                                 const struct surface_point *to, double curvature, double *chord);

/* Notes what a cell took to be solved. */
static inline void march_count_solved(struct march *march, size_t iterations, double residual) {
    struct march_counts *counts = &march->counts;
    counts->solved++;
    counts->iterations += iterations;
    counts->residual_max = residual > counts->residual_max ? residual : counts->residual_max;
}

/* Solves a cell. Notes the cost; on failure gives the reason. */
bool march_solve_corner(struct march *march, const struct march_cell *at, struct fishnet_node *node,
                        enum drape_reason *reason);

/* The same with the lengths at hand, march->length, whatever it costs; and where weft slides along
 * warp, by which that of CD follows from the shear (march_slide.c). */
bool march_solve_lengths(struct march *march, const struct march_cell *at,
                         struct fishnet_node *node, enum drape_reason *reason);
bool march_slide_corner(struct march *march, const struct march_cell *at, struct fishnet_node *node,
                        enum drape_reason *reason);

/* Where weft slides: whether a cell rests on places of the fibre below beyond the one after C. */
bool march_slide_rests_far(struct march *march, const struct march_cell *at);

/* Where weft slides: how long an edge of weft is that sets off from (i, j), which is at `point`,
 * along `weft`, by the shear there. */
double march_slide_length(struct march *march, int32_t i, int32_t j,
                          const struct surface_point *point, struct vec3 weft);

/* By how much the chord of CD in the net before is shorter than the law of the fabric asks of it
 * there, to fourth order; 0 where that net does not tell. */
double march_slide_excess(struct march *march, const struct march_cell *at);

/* The place one spacing straight on from `from` along the projection of `direction`, as the
 * method measures spacings along a generator; false when there is none, and `reason` why. It is to
 * be the neighbour on the side (di, dj). */
bool march_straight_on(struct march *march, const struct surface_point *from, struct vec3 direction,
                       int di, int dj, struct surface_point *point, enum drape_reason *reason);

/* The same by the yarn that comes to (i, j), which is at `from`, from the other side, by its two
 * edges before. Not where it lies along the yarn that it crosses there: it would only wind on
 * beside that. */
bool march_goes_on(struct march *march, int32_t i, int32_t j, int di, int dj,
                   const struct surface_point *from, struct surface_point *to,
                   enum drape_reason *reason);

/* Notes how a node that is placed after the quadrants' came about, for the estimate of its error,
 * and whether it has grown. Errors: STATUS_OUT_OF_MEMORY. */
enum status march_note_step(struct march *march, int32_t i, int32_t j, int di, int dj,
                            enum march_way way, bool grown) STATUS_MUST_USE;

/*
 * The same on a mesh (march_mesh.c). A point there has its triangle as uv[0]; on flat triangles
 * neither derivatives nor curvature, on the smooth surface two orthonormal tangents as r_u and r_v
 * and the second fundamental form in them.
 */
struct surface_point march_mesh_point(const struct march *march, const struct mesh_point *place);
struct mesh_point march_mesh_point_of(const struct surface_point *point);
bool march_mesh_corner(struct march *march, const struct march_cell *at, struct vec3 guess,
                       struct fishnet_node *node, enum drape_reason *reason);
bool march_mesh_straight_on(struct march *march, const struct surface_point *from,
                            struct vec3 direction, int di, int dj, struct surface_point *point);

/* Sets off from a point along a generator (NULL: straight on) on a mesh of the caller's to the side
 * of `direction`, and on along it to the next place, the neighbour on the side (di, dj), as the
 * method measures spacings, which notes for march_place whether that edge is rough; `lost`: it
 * failed otherwise than at the edge. */
struct march_mesh_yarn {
    struct mesh_path flat;          /* on flat triangles */
    struct mesh_smooth_path smooth; /* on the smooth surface */
};

/* Flat triangles that turn by more than 10 degrees at an edge have a fold there, by the cosine,
 * which no straight chord crosses as a yarn does: up to here it is too short by less than 0.4 %. */
#define MARCH_MESH_CREASE 0.9848

/* Whether the march goes over flat triangles among which there are folds. */
bool march_mesh_folds(const struct march *march);

/* A direction at a point on a fold as the point's own triangle has it, whichever of those round it
 * the direction is in: a unit tangent. */
struct vec3 march_mesh_unfolded(const struct march *march, const struct surface_point *point,
                                struct vec3 way);

/* Notes as march_note_edge the edge from `from` to `to`, neighbours on the side (di, dj), if it
 * leads over a fold, `folded`, or one of them lies on a fold: a yarn that leaves there as `start`
 * and comes as `end`. */
void march_mesh_note(struct march *march, const struct surface_point *from,
                     const struct surface_point *to, bool folded, int di, int dj, struct vec3 start,
                     struct vec3 end);

bool march_mesh_arm(const struct march *march, const struct surface_point *from,
                    const struct drape_generator *generator, struct vec3 direction,
                    struct march_mesh_yarn *yarn);
bool march_mesh_lay(struct march *march, struct march_mesh_yarn *yarn, int di, int dj,
                    struct surface_point *point, bool *lost);

/* From `from` to the place one chord away towards `target`, the next place of the generator of a
 * family, 0 warp and 1 weft, on the surface the mesh was made of: triangles turn a straight walk
 * aside, the surface does not. When the generator is `folded` on the way there, to the place
 * nearest to `target`. */
bool march_mesh_towards(struct march *march, const struct surface_point *from, struct vec3 target,
                        int family, bool folded, struct surface_point *point, bool *lost);

/* Of a net that is done: where it ends inside the part, what has gone on beside that may have come
 * to lie on other cells. Takes out the further of two that do, for the reason `fold`. Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status march_separate_layers(struct march *march) STATUS_MUST_USE;

/* Reports to the monitor; false: stop. */
bool march_progress(struct march *march);

#endif
