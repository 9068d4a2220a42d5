/* SPDX-License-Identifier: MIT */
#include "fishnet.h"

#include "rough.h"

#include "cell_formulas.h"
#include "solver/path/relaxation.h"
#include "solver/shell/crossing.h"
#include "solver/shell/shell.h"

enum { NEWTON_MAX = 40, HALVINGS_MAX = 13, PREDICTORS = 5, HOPS_MAX = 16 };

/* Below this sine of the angle between its yarns a cell that finds no corner has collapsed. */
static const double collapsed_sine = 0.12;

void fishnet_chords(struct surface_cursor *cursor, enum drape_yarn yarn, enum drape_yarn_path path,
                    const double length[2], struct fishnet_cell *cell) {
    const struct surface_point *a = cell->a, *b = cell->b, *c = cell->c;
    double found;
    cell->bd = length[0];
    cell->cd = length[1];
    cell->curvature[0] = cell->curvature[1] = 0;
    if (yarn == DRAPE_YARN_CHORD)
        return;
    struct vec3 r1 = surface_point_projection(a, vec3_sub(b->jet.r, a->jet.r));
    struct vec3 r2 = surface_point_projection(a, vec3_sub(c->jet.r, a->jet.r));
    if (path == DRAPE_PATH_RELAXATION) {
        if (a->surface == b->surface)
            (void)relaxation_tangents(a->surface, cursor, a, b, &r1, &found, NULL);
        if (a->surface == c->surface)
            (void)relaxation_tangents(a->surface, cursor, a, c, &r2, &found, NULL);
    }
    cell->curvature[1] = surface_point_curvature(cursor, c, r1);
    cell->curvature[0] = surface_point_curvature(cursor, b, r2);
    cell->cd = fishnet_arc_chord(length[1], cell->curvature[1]);
    cell->bd = fishnet_arc_chord(length[0], cell->curvature[0]);
}

/* Normals over a sharp fold, as a cosine. */
static const double folded = 0.5;

/* The normal by which A, C, B turn: B's, or that of C or A where the cell lies over a fold and B,
 * on it, has that of the other side. */
static struct vec3 turning_normal(const struct fishnet_cell *cell) {
    const struct surface_point *corner[3] = {cell->b, cell->c, cell->a};
    for (int k = 0; k < 3; k++) {
        struct vec3 normal = corner[k]->normal;
        if ((k == 0 || vec3_dot(normal, cell->b->normal) < folded) &&
            cell->orientation *
                    triangle_turn(cell->a->jet.r, cell->c->jet.r, cell->b->jet.r, normal) >
                0)
            return normal;
    }
    return vec3_make(0, 0, 0);
}

bool fishnet_right_root(const struct fishnet_cell *cell, const struct surface_point *d) {
    const struct corner corner = {.a = cell->a->jet.r,
                                  .b = cell->b->jet.r,
                                  .c = cell->c->jet.r,
                                  .bd = cell->bd,
                                  .cd = cell->cd};
    struct vec3 normal = turning_normal(cell);
    bool other = vec3_dot(cell->b->normal, d->normal) < folded && vec3_dot(normal, d->normal) < 0;
    return is_right_root(&corner, d->jet.r, cell->orientation, normal, other ? normal : d->normal);
}

/* From uv, which is at r, by `step`, no longer than `longest`; near a pole through its chart. The
 * surface that it is then on. */
static const struct surface *move_by(const struct surface *surface, struct surface_cursor *cursor,
                                     struct vec3 r, const double step[2], double longest,
                                     double uv[2]) {
    struct vec3 pole;
    struct surface_point from;
    struct surface_place to;
    double reach = FISHNET_POLE_STEPS * longest;
    if (surface_point_near_pole(surface, r, reach * reach) &&
        surface_point_at(surface, cursor, uv, &from)) {
        struct vec3 spatial = vec3_axpy(step[1], from.jet.v, vec3_scale(step[0], from.jet.u));
        if (surface_point_pole_distance(surface, from.jet.r, &pole) <
                FISHNET_POLE_STEPS * vec3_norm(spatial) &&
            surface_point_pull(cursor, &from, spatial, &to)) {
            uv[0] = to.uv[0];
            uv[1] = to.uv[1];
            return to.surface;
        }
    }
    uv[0] += step[0];
    uv[1] += step[1];
    return surface;
}

static void scale_step(double step[2], double share) {
    step[0] *= share;
    step[1] *= share;
}

/* Where no step reduces an error of less than this share of an edge beyond the domain, it is
 * rounding of the continuation, whose polynomials cancel far out. */
static const double hidden_by_rounding = 1e-6;

/* Back to the last place that reduced the error: a root but for rounding. */
static bool is_root_but_for_rounding(const struct surface *surface, struct surface_cursor *cursor,
                                     const double uv[2], double error, struct fishnet_node *node) {
    node->residual = error;
    return error <= hidden_by_rounding && surface_point_at(surface, cursor, uv, &node->point) &&
           surface_point_is_beyond(&node->point, 0);
}

/* Newton from uv; a step that does not reduce the error is halved. */
static bool find_root(const struct surface *surface, struct surface_cursor *cursor,
                      const struct fishnet_cell *cell, const double uv[2],
                      struct fishnet_node *node) {
    bool ordered = cell->bd < cell->cd;
    double least = ordered ? cell->bd : cell->cd, longest = 2 * (ordered ? cell->cd : cell->bd);
    double enough = enough_error(surface, least);
    double limit = cell->corrects ? FISHNET_CORRECTED_GUESS : FISHNET_GUESS_SHARE * enough;
    int halvings = 0;
    double share2 = 0; /* the last step's size by the edge's, squared; 0 when it was shortened */
    double previous = HUGE_VAL, step[2] = {0, 0}, from[2] = {uv[0], uv[1]};
    struct surface_point *point = &node->point;
    struct vec3 b = cell->b->jet.r, c = cell->c->jet.r, from_r = c;
    const struct surface *from_surface = surface;
    struct corner d; /* member by member: clearing all of it takes as long as a step */
    d.bd = cell->bd;
    d.cd = cell->cd;
    square_chords(&d);
    point->uv[0] = uv[0];
    point->uv[1] = uv[1];
    for (int round = 0; round < NEWTON_MAX; round++) {
        surface_jet_at(surface, cursor, point->uv[0], point->uv[1], &point->jet);
        d.wb = vec3_sub(point->jet.r, b);
        d.wc = d.gradient = vec3_sub(point->jet.r, c);
        if (cell->slide)
            slide_chord(&d, cell->slide, true);
        find_error(&d);
        node->residual = d.error;
        node->iterations += 1;
        if (has_converged(d.error, limit, share2, previous)) {
            settle(&d, cell->slide, point->uv, &point->jet);
            node->residual = d.error;
            struct surface_point own;
            bool regular = surface_point_complete(surface, point);
            if (regular && surface_point_in_frame(cursor, point, &own))
                *point = own;
            return regular;
        }
        if (d.error < previous) {
            if (!newton_step(&d, &point->jet, cell->slide, true, step))
                return false;
            previous = d.error;
            halvings = 0;
            from[0] = point->uv[0];
            from[1] = point->uv[1];
            from_r = point->jet.r;
            from_surface = surface;
            double size2 = spatial_size2(&point->jet, step);
            share2 = size2 / (least * least);
            if (size2 > longest * longest) {
                scale_step(step, longest / sqrt(size2));
                share2 = 0;
            }
        } else {
            if (++halvings > HALVINGS_MAX)
                return is_root_but_for_rounding(from_surface, cursor, from, previous, node);
            scale_step(step, 0.5);
            share2 = 0;
            point->uv[0] = from[0];
            point->uv[1] = from[1];
        }
        surface = move_by(surface, cursor, from_r, step, longest, point->uv);
        limit = enough;
    }
    return false;
}

/* D if the surface were the tangent plane at B: the intersection of the two circles away from A,
 * or where they come closest. */
static struct vec3 planar_corner(const struct fishnet_cell *cell) {
    struct vec3 b = cell->b->jet.r, base = vec3_sub(cell->c->jet.r, b);
    double length = vec3_norm(base);
    struct vec3 along = vec3_unit(base), up = vec3_cross(cell->b->normal, along);
    double x = (length * length + cell->bd * cell->bd - cell->cd * cell->cd) / (2 * length);
    double height = sqrt(fmax(0, cell->bd * cell->bd - x * x));
    double side = vec3_dot(vec3_sub(cell->a->jet.r, b), up) > 0 ? -1 : 1;
    return vec3_axpy(side * height, up, vec3_axpy(x, along, b));
}

/* Places nearer to each other than this share of an edge lead Newton to the same end. */
static const double same_place = 1e-6;

/* The k-th place to start Newton from: the guess, then the parallelogram and the planar corner,
 * seen from C and from B. False when it cannot be had, or is the same as another. */
static bool predict(struct surface_cursor *cursor, const struct fishnet_cell *cell, int k,
                    struct surface_place *begin) {
    const struct surface_point *from = k % 2 ? cell->b : cell->c;
    if (k == 0 && cell->guess_uv) {
        *begin = (struct surface_place){from->surface, {cell->guess_uv[0], cell->guess_uv[1]}};
        return true;
    }
    struct vec3 opposite = vec3_sub(vec3_add(cell->b->jet.r, cell->c->jet.r), cell->a->jet.r);
    struct vec3 target = k == 0 ? cell->guess : k < 3 ? opposite : planar_corner(cell);
    if (k >= 3 && vec3_distance(target, opposite) < same_place * cell->bd)
        return false;
    return surface_point_pull(cursor, from, vec3_sub(target, from->jet.r), begin);
}

/* ---- from face to face of a shell ---- */

/* The same as `predict` on a shell: the point on the continuation of the face of C or B; after
 * those, what is nearest to the last ones. */
static bool predict_on_shell(struct surface_cursor *cursor, const struct fishnet_cell *cell, int k,
                             struct surface_place *begin) {
    if (k >= PREDICTORS) {
        const struct shell *shell = cell->c->surface->shell;
        struct vec3 opposite = vec3_sub(vec3_add(cell->b->jet.r, cell->c->jet.r), cell->a->jet.r);
        struct shell_point nearest;
        double distance;
        shell_nearest(shell, k == PREDICTORS ? planar_corner(cell) : opposite,
                      shell_component(shell, cell->c->surface->face), &nearest, &distance);
        begin->surface = shell_surface(shell, nearest.face);
        begin->uv[0] = nearest.inner[0];
        begin->uv[1] = nearest.inner[1];
        return distance < cell->bd + cell->cd;
    }
    return predict(cursor, cell, k, begin);
}

/* Carries a place on the continuation of a face to where it belongs. */
static bool settle_place(struct surface_cursor *cursor, struct surface_place *place) {
    struct surface_point point;
    if (!surface_point_at(place->surface, cursor, place->uv, &point) ||
        !crossing_settle(cursor, &point))
        return false;
    *place = (struct surface_place){point.surface, {point.uv[0], point.uv[1]}};
    return true;
}

/* A continuation over a hole comes to the other side of it: this near to a face, as a share of the
 * shorter edge, it has. */
static const double landing = 0.05;

/* Newton on a face; where it ends outside its region beyond a joint, on the next one. A point that
 * either face of a joint carries to the other is taken as it is. */
static bool newton_on_shell(struct surface_cursor *cursor, const struct fishnet_cell *cell,
                            struct surface_place *begin, struct fishnet_node *node) {
    const struct surface *last = NULL;
    const struct shell *shell = cell->c->surface->shell;
    double least = fmin(cell->bd, cell->cd);
    bool landed = false;
    struct crossing *crossing = &node->crossing;
    for (int hop = 0; hop < HOPS_MAX; hop++) {
        if (!find_root(begin->surface, cursor, cell, begin->uv, node))
            return false;
        crossing_find(&node->point, last, crossing);
        node->looked = !last;
        /* Beyond a free edge it may lie over a face on the other side of a hole. */
        if (crossing->kind == CROSSING_FREE && !landed) {
            const struct surface_point *point = &node->point;
            struct shell_point over;
            if (shell_may_close(shell, point->surface->face) &&
                shell_over(shell, point->jet.r, point->surface->face, landing * least, &over)) {
                *begin = (struct surface_place){shell_surface(shell, over.face),
                                                {over.inner[0], over.inner[1]}};
                landed = true;
                continue;
            }
        }
        if (crossing->kind != CROSSING_JOINT)
            return true;
        if (crossing->beyond == last)
            return true;
        last = node->point.surface;
        if (!crossing_carry(crossing, cursor, &node->point, 0, begin))
            return false;
    }
    return false;
}

/* D by the k-th place to start from. Beyond the boundary, where most places outside their face are,
 * it belongs to the face that they are on: from there it is looked for, over joints where it lies
 * past them, before the place is carried anywhere. */
static bool solve_on_shell(struct surface_cursor *cursor, const struct fishnet_cell *cell, int k,
                           struct fishnet_node *node) {
    struct surface_place begin;
    if (!predict_on_shell(cursor, cell, k, &begin))
        return false;
    if (k < PREDICTORS && !crossing_within(begin.surface, begin.uv)) {
        struct surface_place own = begin;
        const int before = node->iterations;
        if (newton_on_shell(cursor, cell, &own, node) && fishnet_right_root(cell, &node->point))
            return true;
        node->iterations = before;
        if (!settle_place(cursor, &begin))
            return false;
    }
    return newton_on_shell(cursor, cell, &begin, node);
}

bool fishnet_has_collapsed(const struct fishnet_cell *cell) {
    struct vec3 ab = vec3_sub(cell->b->jet.r, cell->a->jet.r);
    struct vec3 ac = vec3_sub(cell->c->jet.r, cell->a->jet.r);
    struct vec3 normal = turning_normal(cell);
    if (!(vec3_norm2(normal) > 0) || !(vec3_dot(normal, cell->a->normal) < folded))
        normal = cell->a->normal;
    double sine =
        cell->orientation * vec3_dot(vec3_cross(ac, ab), normal) / (vec3_norm(ab) * vec3_norm(ac));
    double apart = vec3_distance(cell->b->jet.r, cell->c->jet.r);
    return sine < collapsed_sine || apart > (1 - collapsed_sine / 10) * (cell->bd + cell->cd);
}

/* Whether D lies beyond the boundary where the continuation has turned over, seen from B and C:
 * there it has roots that are not the cloth's. */
static bool is_turned_over(const struct fishnet_cell *cell, const struct surface_point *d) {
    return vec3_dot(cell->b->normal, d->normal) < folded &&
           vec3_dot(cell->c->normal, d->normal) < folded &&
           surface_point_is_beyond(d, SURFACE_POINT_BOUNDARY_WIDTH);
}

/* Of several roots the first that is not turned over; if all are, the first. */
enum fishnet_end fishnet_solve(const struct surface *surface, struct surface_cursor *cursor,
                               const struct fishnet_cell *cell, struct fishnet_node *node) {
    struct fishnet_node turned;
    bool has_turned = false;
    node->iterations = 0;
    node->looked = false;
    if (!(cell->bd > 0) || !(cell->cd > 0) || !(vec3_norm2(turning_normal(cell)) > 0))
        return FISHNET_COLLAPSED;
    const bool shell = surface->shell;
    for (int k = 0; k < PREDICTORS + (shell ? 2 : 0); k++) {
        struct surface_place begin;
        bool found = shell ? solve_on_shell(cursor, cell, k, node)
                           : predict(cursor, cell, k, &begin) &&
                                 find_root(surface, cursor, cell, begin.uv, node);
        if (!found || !fishnet_right_root(cell, &node->point))
            continue;
        if (!is_turned_over(cell, &node->point))
            return FISHNET_FOUND;
        if (!has_turned)
            turned = *node;
        has_turned = true;
    }
    if (has_turned) {
        *node = turned;
        return FISHNET_FOUND;
    }
    return fishnet_has_collapsed(cell) ? FISHNET_COLLAPSED : FISHNET_NO_CONVERGENCE;
}
