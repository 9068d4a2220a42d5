/* SPDX-License-Identifier: MIT */
/*
 * The directions in which yarns leave the nodes of a net, in the surface: the logarithms of a
 * node's neighbours at it. Near rough edges (`rough.h`) shear is measured between them; differences
 * of positions in space see there how the surface turns. Directions on either side of a crease are
 * those of the surface unfolded about it, in the tangent plane of the node's point.
 */
#ifndef SOLVER_FISHNET_YARN_H
#define SOLVER_FISHNET_YARN_H

#include "rough.h"
#include "solver/net/net.h"
#include "solver/shell/surface_point.h"

/* A net and the surface that it lies on. */
struct yarn_net {
    const struct net *net;
    const struct surface *surface; /* NULL where it lies on triangles */
    struct surface_cursor *cursor;
};

/* A place of the net. */
struct yarn_place {
    int32_t i, j;
    const struct net_node *node;
};

/* A node with its point, and the directions of its yarns as far as they have been looked for:
 * towards the higher index, by family and by the side, lower (0) or higher (1), of the neighbour
 * that they come from; zero where there is none. */
struct yarn_spot {
    int32_t i, j;
    struct surface_point point;
    uint8_t known; /* NET_EDGE_BIT of those that have been */
    bool filled;   /* it is that of (i, j) */
    struct vec3 onward[2][2];
};

/* The unit tangent of the yarn of a family, 0 warp and 1 weft, at `here`, which is at `point`,
 * towards its neighbour `there` on the side of the lower (0) or higher (1) index: of a rough edge
 * as it was laid, else the chord's, turned by the geodesic torsion. */
struct vec3 yarn_leave(const struct yarn_net *yarns, const struct yarn_place *here,
                       const struct yarn_place *there, int family, int side,
                       const struct surface_point *point);

/* The unit tangent at `point` of the geodesic to an end, as `logarithm_leave`, but right beside the
 * tips of cuts, too, where surfaces may bend within a spacing, and one direction alone tells how a
 * yarn goes. */
struct vec3 yarn_leave_well(const struct surface *surface, struct surface_cursor *cursor,
                            const struct surface_point *point, const struct rough_end *end);

/* The angle between warp and weft at a node with places on both yarns, each taken as the mean of
 * its two directions, or as the one it has: 0..180 degrees, and 90 where only one yarn passes. The
 * node is (x, y) of the window, and the spot its own. */
double yarn_node_angle(const struct yarn_net *yarns, const struct net_window *window, int x, int y,
                       struct yarn_spot *spot);

/* Whether the surface is developable at a point, for all that matters to cells of this spacing:
 * where |K| d^2 is small yarns do not turn sideways, and one direction of a yarn tells the other.
 */
bool yarn_is_developable(const struct surface_point *point, const double spacing[2]);

/* Whether one of the four edges of the cell with the corners (x, y) and (x + 1, y + 1) is rough. */
bool yarn_cell_is_rough(const struct net_window *window, int x, int y);

/* The angle of the cell's yarns in degrees, 0 to 180: the mean of those at its four corners, (x,
 * y), (x + 1, y), (x + 1, y + 1), (x, y + 1), whichever way they turn. */
double yarn_cell_angle(const struct yarn_net *yarns, const struct net_window *window, int x, int y,
                       struct yarn_spot *const corner[4]);

/* Whether its warp and weft, as they leave the four corners, turn one way: a cell of cloth, which
 * may be bent over a crease. */
bool yarn_cell_is_open(const struct yarn_net *yarns, const struct net_window *window, int x, int y,
                       struct yarn_spot *const corner[4]);

#endif
