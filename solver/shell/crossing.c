/* SPDX-License-Identifier: MIT */
#include "crossing.h"

#include "faces.h"
#include <string.h>

enum { HOPS_MAX = 16, END_ROUNDS = 3, BORDER_ROUNDS = 12 };

/* Halves of halves of an edge: of fewer than 2^32 segments. */
enum { RUN_DEPTH_MAX = 32 };

/* A joint is preferred to a free edge that is no nearer than this. */
static const double as_near = 1e-9;

/* At a vertex the joints that meet there are equally near, but for this share of the distance. */
static const double at_vertex = 1e-6;

/* So much of its length from its end an edge has the derivatives that it has at the end. */
static const double inside_end = 1e-10;

/* Where the curves of two faces are no further apart than this share of the way from the joint's
 * end, they go on as one. */
static const double alike = 1e-3;

/* Places beyond a free edge may be past a joint whose end is no further than so many times as far.
 */
static const double end_reach = 4;

/* The place of an edge that is nearest to a point is known to this share of the edge. */
static const double border_accuracy = 1e-4;

/* Nor do they where a face has turned by more than this, as a cosine: two creases of a strip have
 * met there, and it is inside out beyond. */
static const double turned = 0.5;

/* Two faces meet smoothly where their normals differ by less than this, as a cosine. */
static const double smooth = 0.98;

/* A place past such a line is carried to within this share of its way. */
static const double carried_off = 0.1;

/* Beyond the domain by this share of it, a place is far. */
static const double far_beyond = 0.25;

bool crossing_within(const struct surface *surface, const double uv[2]) {
    return face_contains(face_of_surface(surface), uv);
}

/* Puts parameters into the turn of a near place. */
static void put_near(const struct surface *surface, const double near[2], double uv[2]) {
    for (int k = 0; k < 2; k++)
        if (surface->axis[k].closed)
            uv[k] = near[k] + face_way(&surface->axis[k], near[k], uv[k]);
}

/* A place on a segment. */
struct hit {
    const struct face_segment *segment;
    double share, distance2, offset[2]; /* from the place to it */
};

/* The nearest places by what lies beyond: nothing, another face, the face one came from. */
enum { TO_NOTHING, TO_FACE, TO_BEFORE, BEYONDS };

/* A search for the edges nearest to a place of a face, by the metric there. */
struct edge_search {
    const struct surface *surface, *beyond, *before;
    const double *metric;
    double at[2];
    double least[2]; /* what a way dx or dy, to whatever, measures at least, over its square; */
    double share;    /* and a way (dx, dy), of E dx^2 + G dy^2 */
    const struct face_run *likely[BEYONDS]; /* edges that may be nearest; looked into first */
    struct hit hit[BEYONDS];
};

/* What lies beyond the edge of a run; BEYONDS where that is not looked for. */
static int beyond_run(const struct edge_search *search, const struct face_run *run) {
    const struct shell *shell = search->surface->shell;
    int32_t mate = shell->edges[run->edge].mate;
    if (mate == EDGE_FREE)
        return search->beyond ? BEYONDS : TO_NOTHING;
    const struct surface *to = &shell->faces[edge_face(shell, (size_t)mate)].surface;
    if (search->beyond && to != search->beyond)
        return BEYONDS;
    return search->before && to == search->before ? TO_BEFORE : TO_FACE;
}

/* A square of the distance that no segment of a run falls short of: with dx and dy to its
 * rectangle, E x^2 + 2 F x y + G y^2 >= (E - F^2 / G) dx^2, and (G - F^2 / E) dy^2, and
 * (1 - |F| / sqrt(E G)) (E dx^2 + G dy^2). */
static double least_to_run(const struct edge_search *search, const struct face_run *run) {
    double least = 0, sum = 0;
    for (int k = 0; k < 2; k++) {
        double off = fabs(face_way(&search->surface->axis[k], search->at[k], run->centre[k]));
        off = off > run->half[k] ? off - run->half[k] : 0;
        double bound = search->least[k] * off * off;
        least = bound > least ? bound : least;
        sum += search->metric[2 * k] * off * off;
    }
    return search->share * sum > least ? search->share * sum : least;
}

/* Takes the place of a run that is nearest, the first of equals. */
static void try_run(struct edge_search *search, const struct face_run *run, int beyond) {
    const struct face_segment *segment = face_of_surface(search->surface)->segments + run->first;
    const double *metric = search->metric;
    struct hit *best = &search->hit[beyond];
    for (const struct face_segment *end = segment + run->count; segment < end; segment++) {
        double p[2], e[2];
        for (int k = 0; k < 2; k++) {
            p[k] = face_way(&search->surface->axis[k], search->at[k], segment->a[k]);
            e[k] = (p[k] + segment->b[k] - segment->a[k]) - p[k];
        }
        double ee = surface_point_form(metric, e);
        double pe = metric[0] * p[0] * e[0] + metric[1] * (p[0] * e[1] + p[1] * e[0]) +
                    metric[2] * p[1] * e[1];
        double share = -pe > 0 ? (-pe < ee ? -pe / ee : 1) : 0; /* 0..1 */
        const double offset[2] = {p[0] + share * e[0], p[1] + share * e[1]};
        double distance2 = surface_point_form(metric, offset);
        if (distance2 < best->distance2 ||
            (distance2 == best->distance2 && segment < best->segment))
            *best = (struct hit){segment, share, distance2, {offset[0], offset[1]}};
    }
}

/* Whether a run may have what decides: something of its own kind that is nearer, and about as near
 * as what is known of the others. */
static bool may_decide(const struct edge_search *search, double least, int to) {
    double nearest = HUGE_VAL;
    for (int b = 0; b < BEYONDS; b++)
        nearest = search->hit[b].distance2 < nearest ? search->hit[b].distance2 : nearest;
    return !(least > search->hit[to].distance2) && !(least * (1 - 2 * at_vertex) > nearest);
}

static bool is_leaf(const struct face *face, const struct face_run *run) {
    return run->next == (uint32_t)(run - face->runs) + 1;
}

/* A run that is still to be looked into, and what it falls short of by no segment. */
struct waiting_run {
    const struct face_run *run;
    double least;
};

/* Looks into all of an edge that may decide: of two halves first into that which may be nearer. */
static void try_edge(struct edge_search *search, const struct face_run *whole, double least,
                     int to) {
    const struct face *face = face_of_surface(search->surface);
    struct waiting_run stack[RUN_DEPTH_MAX];
    int count = 1;
    stack[0] = (struct waiting_run){whole, least};
    while (count > 0) {
        struct waiting_run at = stack[--count];
        while (may_decide(search, at.least, to)) {
            if (is_leaf(face, at.run)) {
                try_run(search, at.run, to);
                break;
            }
            struct waiting_run half = {at.run + 1, 0}, other = {&face->runs[at.run[1].next], 0};
            half.least = least_to_run(search, half.run);
            other.least = least_to_run(search, other.run);
            bool second = other.least < half.least;
            stack[count++] = second ? half : other;
            at = second ? other : half;
        }
    }
}

/* The nearest places on joints and on free edges of the point's face; on joints to the face
 * `beyond` alone unless that is NULL, and preferably to others than `before`. Of what is further
 * than what decides, the one or the other, nothing is told. */
static void nearest_edges(const struct surface_point *point, const double metric[3],
                          const struct surface *beyond, const struct surface *before,
                          struct hit *joint, struct hit *free) {
    const struct face *face = face_of_surface(point->surface);
    double determinant = metric[0] * metric[2] - metric[1] * metric[1];
    struct edge_search search = {
        .surface = point->surface, .beyond = beyond, .before = before, .metric = metric};
    for (int k = 0; k < 2; k++) {
        search.at[k] = surface_axis_wrap(&point->surface->axis[k], point->uv[k]);
        search.least[k] = determinant > 0 ? (1 - as_near) * determinant / metric[2 - 2 * k] : 0;
    }
    if (determinant > 0)
        search.share = 1 - as_near - fabs(metric[1]) / sqrt(metric[0] * metric[2]);
    for (int b = 0; b < BEYONDS; b++)
        search.hit[b] = (struct hit){.distance2 = HUGE_VAL};
    /* first the edge of each kind that may be nearest, the nearest of them first */
    double least[BEYONDS] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    for (uint32_t r = 0; r < face->run_count; r = face->runs[r].next) {
        int to = beyond_run(&search, &face->runs[r]);
        double bound = to == BEYONDS ? HUGE_VAL : least_to_run(&search, &face->runs[r]);
        if (to != BEYONDS && bound < least[to]) {
            least[to] = bound;
            search.likely[to] = &face->runs[r];
        }
    }
    for (int round = 0; round < BEYONDS; round++) {
        int first = 0;
        for (int b = 1; b < BEYONDS; b++)
            first = least[b] < least[first] ? b : first;
        if (search.likely[first])
            try_edge(&search, search.likely[first], least[first], first);
        least[first] = HUGE_VAL;
    }
    for (uint32_t r = 0; r < face->run_count; r = face->runs[r].next) {
        const struct face_run *run = &face->runs[r];
        int to = beyond_run(&search, run);
        if (to != BEYONDS && run != search.likely[to])
            try_edge(&search, run, least_to_run(&search, run), to);
    }
    *free = search.hit[TO_NOTHING];
    *joint = search.hit[TO_FACE];
    if (search.hit[TO_BEFORE].distance2 < joint->distance2 * (1 - at_vertex))
        *joint = search.hit[TO_BEFORE];
}

/* The free edge that is nearest to a point by its metric or, far beyond the domain, where that says
 * little, by the metric of the domain next to it. */
static struct hit nearest_free(const struct surface_point *point, struct hit free) {
    struct surface_cursor cursor = {0, 0};
    struct surface_point next;
    struct hit joint, nearest;
    bool far = false;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &point->surface->axis[k];
        double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
        double at = axis->closed ? point->uv[k] : fmin(fmax(point->uv[k], low), high);
        far = far || fabs(point->uv[k] - at) > far_beyond * (high - low);
        next.uv[k] = at;
    }
    if (!far || !surface_point_at(point->surface, &cursor, next.uv, &next))
        return free;
    nearest_edges(point, next.first, NULL, NULL, &joint, &nearest);
    return nearest.segment ? nearest : free;
}

static double inside_edge(const struct face_edge *edge, double t) {
    double within = inside_end * (edge->t[1] - edge->t[0]);
    return fmin(fmax(t, edge->t[0] + within), edge->t[1] - within);
}

/* The place at t of an edge, or of the line in which it goes on beyond an end, with the derivatives
 * that it has at the end: that may be a corner of its curve. */
static void edge_continued_at(const struct shell *shell, const struct face_edge *edge, double t,
                              struct curve_place *place) {
    struct surface_cursor cursor = {0, 0};
    const struct face_curve *curve = &shell->curves[edge->curve];
    double from = inside_edge(edge, t);
    int end = t > from;
    if (!edge->straight[end] || (t >= edge->t[0] && t <= edge->t[1])) {
        curve_beyond(shell, curve, from, t, place);
        return;
    }
    for (int k = 0; k < 2; k++) {
        place->rate[k] = edge->beyond[end][k];
        place->uv[k] = edge->tip[end][k] + (t - edge->t[end]) * place->rate[k];
    }
    place->t = t;
    surface_jet_at(&shell->faces[curve->face].surface, &cursor, place->uv[0], place->uv[1],
                   &place->jet);
    place->r = place->jet.r;
    place->tangent =
        vec3_axpy(place->rate[1], place->jet.v, vec3_scale(place->rate[0], place->jet.u));
}

static bool edge_frame(const struct shell *shell, const struct face_edge *edge,
                       const struct curve_place *place, struct vec3 along, bool out,
                       struct crossing_frame *frame) {
    const struct surface *surface = &shell->faces[shell->curves[edge->curve].face].surface;
    struct surface_point point = {.uv = {place->uv[0], place->uv[1]}, .jet = place->jet};
    if (!surface_point_complete(surface, &point))
        return false;
    struct vec3 tangent = surface_point_tangent(&point, place->tangent);
    struct vec3 inward =
        vec3_scale(edge->inside * surface->side, vec3_cross(point.normal, tangent));
    frame->at = place->r;
    frame->along =
        vec3_norm2(along) > 0 && vec3_dot(along, tangent) < 0 ? vec3_scale(-1, tangent) : tangent;
    frame->across = vec3_scale(out ? -1 : 1, inward);
    frame->normal = point.normal;
    return vec3_norm2(tangent) > 0;
}

/* The place of an edge, or of its curve beyond an end, nearest to a point, from the place at t. */
static double go_near(const struct shell *shell, const struct face_edge *edge, struct vec3 point,
                      double t) {
    struct curve_place place;
    for (int round = 0; round < END_ROUNDS; round++) {
        edge_continued_at(shell, edge, t, &place);
        t += vec3_dot(vec3_sub(point, place.r), place.tangent) / vec3_norm2(place.tangent);
    }
    return t;
}

/* The parameter of an edge where its mate has t. */
static double mate_parameter(const struct face_edge *edge, const struct face_edge *mate, double t) {
    double share = (t - edge->t[0]) / (edge->t[1] - edge->t[0]);
    return edge->reversed ? mate->t[1] - share * (mate->t[1] - mate->t[0])
                          : mate->t[0] + share * (mate->t[1] - mate->t[0]);
}

/* Enters the next face where it is nearest to the place that is left: over a smooth joint, whose
 * lines on both faces need not meet beyond the end. False where that leads nowhere. */
static bool enter_nearest(const struct surface *beyond, struct crossing *on) {
    struct surface_cursor cursor = {0, 0};
    struct surface_point there;
    struct crossing_frame *to = &on->to;
    if (!surface_point_at(beyond, &cursor, on->entry, &there))
        return false;
    for (int round = 0; round < END_ROUNDS; round++)
        if (!surface_point_move(&cursor, &there, vec3_sub(on->from.at, there.jet.r), &there) ||
            there.surface != beyond)
            return false;
    memcpy(on->entry, there.uv, sizeof there.uv);
    to->at = there.jet.r;
    to->normal = there.normal;
    to->along = surface_point_tangent(&there, on->from.along);
    struct vec3 left = vec3_cross(to->normal, to->along);
    to->across = vec3_scale(vec3_dot(left, to->across) < 0 ? -1 : 1, left);
    return true;
}

/* The frames of a joint beyond its open end, where both faces' curves go on alike. */
static bool continue_joint(const struct surface *surface, double t, struct crossing *crossing) {
    const struct shell *shell = surface->shell;
    const struct face_edge *edge = &shell->edges[crossing->number],
                           *mate = &shell->edges[edge->mate];
    struct crossing on = *crossing;
    struct curve_place here, beyond;
    edge_continued_at(shell, edge, t, &here);
    if (!edge_frame(shell, edge, &here, crossing->from.along, true, &on.from))
        return false;
    double there = go_near(shell, mate, on.from.at, mate_parameter(edge, mate, t));
    /* what the faces leave between them is not to take it back onto the mate itself */
    bool after = (t > edge->t[1]) != edge->reversed;
    double least = inside_end * (mate->t[1] - mate->t[0]);
    there = after ? fmax(there, mate->t[1] + least) : fmin(there, mate->t[0] - least);
    double far = vec3_distance(on.from.at, crossing->from.at);
    if (!isfinite(there))
        return false;
    edge_continued_at(shell, mate, there, &beyond);
    memcpy(on.edge, here.uv, sizeof on.edge);
    memcpy(on.rate, here.rate, sizeof on.rate);
    memcpy(on.entry, beyond.uv, sizeof on.entry);
    if (!edge_frame(shell, mate, &beyond, on.from.along, false, &on.to) ||
        (edge->straight[t > edge->t[1]] && !enter_nearest(crossing->beyond, &on)) ||
        !(vec3_dot(on.from.normal, crossing->from.normal) > turned) ||
        !(vec3_dot(on.to.normal, crossing->to.normal) > turned) ||
        !(vec3_distance(on.from.at, on.to.at) <= alike * far + 2 * shell->found.largest_gap))
        return false;
    on.continued = true;
    *crossing = on;
    return true;
}

/* The same where they do not: on in the line of the face that is left, as long as the other face is
 * near to that, with the frames of the end. */
static bool continue_alone(const struct surface *surface, double t, struct crossing *crossing) {
    const struct shell *shell = surface->shell;
    struct surface_cursor cursor = {0, 0};
    struct curve_place on;
    struct surface_point place;
    struct surface_place entry;
    edge_continued_at(shell, &shell->edges[crossing->number], t, &on);
    memcpy(crossing->edge, on.uv, sizeof on.uv);
    if (!surface_point_at(surface, &cursor, on.uv, &place) ||
        !crossing_carry(crossing, &cursor, &place, END_ROUNDS, &entry))
        return false;
    double far = vec3_distance(on.r, crossing->from.at);
    crossing->from.at = on.r;
    if (!surface_point_at(entry.surface, &cursor, entry.uv, &place) ||
        !(vec3_distance(on.r, place.jet.r) <= alike * far + 2 * shell->found.largest_gap))
        return false;
    crossing->beyond = entry.surface;
    memcpy(crossing->entry, entry.uv, sizeof entry.uv);
    crossing->to.at = place.jet.r;
    return true;
}

/* The joint at a place t of an edge, or beyond an open end of it. */
static bool joint_at(const struct surface *surface, int32_t number, double t,
                     struct crossing *crossing) {
    const struct shell *shell = surface->shell;
    const struct face_edge *edge = &shell->edges[number], *mate = &shell->edges[edge->mate];
    const struct face_curve *curve = &shell->curves[mate->curve];
    struct curve_place here, there;
    double on_edge = fmin(fmax(t, edge->t[0]), edge->t[1]);
    edge_continued_at(shell, edge, on_edge, &here);
    if (!edge_frame(shell, edge, &here, vec3_make(0, 0, 0), true, &crossing->from))
        return false;
    (void)curve_nearest(shell, curve, crossing->from.at, mate_parameter(edge, mate, t), mate->t,
                        &there);
    if (there.t != inside_edge(mate, there.t))
        edge_continued_at(shell, mate, there.t, &there);
    memcpy(crossing->edge, here.uv, sizeof crossing->edge);
    memcpy(crossing->rate, here.rate, sizeof crossing->rate);
    memcpy(crossing->entry, there.uv, sizeof crossing->entry);
    crossing->kind = CROSSING_JOINT;
    crossing->continued = false;
    crossing->number = number;
    crossing->t = t;
    crossing->beyond = &shell->faces[curve->face].surface;
    return edge_frame(shell, mate, &there, crossing->from.along, false, &crossing->to) &&
           (t == on_edge || continue_joint(surface, t, crossing) ||
            continue_alone(surface, t, crossing));
}

/* Whether a place of a joint is an end of it that lies on the boundary of the shell. */
static bool at_open_end(const struct shell *shell, const struct hit *hit) {
    const struct face_edge *edge = &shell->edges[hit->segment->edge];
    return (edge->open[0] && hit->share == 0 && hit->segment->t[0] == edge->t[0]) ||
           (edge->open[1] && hit->share == 1 && hit->segment->t[1] == edge->t[1]);
}

/* The joint at a hit or, from an open end, at the place of its continuation that is nearest to the
 * point. */
static bool joint_near(const struct surface_point *point, const struct hit *hit,
                       struct crossing *crossing) {
    const struct surface *surface = point->surface;
    const struct face_segment *segment = hit->segment;
    const struct face_edge *edge = &surface->shell->edges[segment->edge];
    double t = segment->t[0] + hit->share * (segment->t[1] - segment->t[0]);
    if (at_open_end(surface->shell, hit)) {
        struct crossing continued = *crossing;
        double on = go_near(surface->shell, edge, point->jet.r, t);
        if ((hit->share > 0 ? on > t : on < t) &&
            joint_at(surface, segment->edge, on, &continued) && continued.continued) {
            *crossing = continued;
            return true;
        }
    }
    return joint_at(surface, segment->edge, t, crossing);
}

/* Whether a place lies on the face's own side of the line in which a joint goes on beyond an end,
 * as far as its parameters, in which that is straight, tell. */
static bool is_before_line(const struct surface_point *point, const struct face_edge *edge,
                           int end) {
    const double *rate = edge->beyond[end];
    double way[2];
    for (int k = 0; k < 2; k++)
        way[k] = face_way(&point->surface->axis[k], edge->tip[end][k], point->uv[k]);
    return edge->straight[end] && edge->inside * (rate[0] * way[1] - rate[1] * way[0]) > 0;
}

/* The joint that a place beyond a free edge, so far away, is past by that: of those with an open
 * end not much further, beyond which it lies past the line in which the joint goes on. */
static bool past_open_end(const struct surface_point *point, double distance,
                          struct crossing *crossing) {
    const struct shell *shell = point->surface->shell;
    const struct face *face = face_of_surface(point->surface);
    double nearest = end_reach * distance;
    for (uint32_t r = 0; r < face->run_count; r = face->runs[r].next) {
        int32_t number = face->runs[r].edge;
        const struct face_edge *edge = &shell->edges[number];
        for (int k = 0; k < 2 && edge->mate != EDGE_FREE; k++) {
            struct crossing past = *crossing;
            struct crossing_frame line;
            struct curve_place on;
            double far = vec3_distance(edge->end[k], point->jet.r);
            if (!edge->open[k] || !(far < nearest) || is_before_line(point, edge, k))
                continue;
            double t = go_near(shell, edge, point->jet.r, edge->t[k]);
            if (k ? !(t > edge->t[1]) : !(t < edge->t[0]))
                continue;
            edge_continued_at(shell, edge, t, &on);
            if (edge_frame(shell, edge, &on, vec3_make(0, 0, 0), true, &line) &&
                vec3_dot(vec3_sub(point->jet.r, line.at), line.across) > 0 &&
                joint_at(point->surface, number, t, &past) && past.continued) {
                *crossing = past;
                nearest = far;
            }
        }
    }
    return nearest < end_reach * distance;
}

/* Whether a place past the end of a joint, or the line in which that goes on, is one of the face
 * beyond, too. Where both faces bend alike they are one surface, and carried to the other a place
 * is near to where that leads, or parameters mean nothing there. */
static bool goes_over(const struct surface_point *point, const struct crossing *crossing) {
    struct surface_cursor cursor = {0, 0};
    struct surface_place place;
    struct surface_point from, to, there;
    if (!surface_point_at(point->surface, &cursor, crossing->edge, &from) ||
        !surface_point_at(crossing->beyond, &cursor, crossing->entry, &to))
        return true;
    struct vec3 offset = crossing_turn(crossing, vec3_sub(point->jet.r, crossing->from.at));
    double bends = surface_point_normal_curvature(&from, crossing->from.across) -
                   surface_point_normal_curvature(&to, crossing->to.across);
    if (fabs(bends) * vec3_norm(offset) > carried_off)
        return true;
    return crossing_carry(crossing, &cursor, point, END_ROUNDS, &place) &&
           surface_point_at(place.surface, &cursor, place.uv, &there) &&
           vec3_dot(there.normal, crossing_turn(crossing, point->normal)) > turned &&
           vec3_distance(there.jet.r, vec3_add(crossing->to.at, offset)) <=
               carried_off * vec3_norm(offset) + 2 * shell_joint_width(point->surface->shell);
}

void crossing_find(const struct surface_point *point, const struct surface *before,
                   struct crossing *crossing) {
    const struct surface *surface = point->surface;
    struct hit joint, free;
    crossing->kind = CROSSING_NONE;
    crossing->distance = 0;
    if (crossing_within(surface, point->uv))
        return;
    nearest_edges(point, point->first, NULL, before, &joint, &free);
    bool over = joint.segment && !(free.distance2 < joint.distance2 * (1 - as_near));
    if (!over)
        free = nearest_free(point, free);
    const struct hit *hit = over ? &joint : &free;
    bool open = over && at_open_end(surface->shell, hit);
    crossing->kind = CROSSING_FREE;
    crossing->distance = sqrt(hit->distance2);
    crossing->at_corner = open || (over && !(free.distance2 > joint.distance2 * (1 + as_near)));
    crossing->nearest = hit->segment ? hit->segment->edge : -1;
    if (hit->segment)
        crossing->nearest_t =
            hit->segment->t[0] + hit->share * (hit->segment->t[1] - hit->segment->t[0]);
    const double near[2] = {point->uv[0] + (hit->segment ? hit->offset[0] : 0),
                            point->uv[1] + (hit->segment ? hit->offset[1] : 0)};
    if (over && joint_near(point, hit, crossing)) {
        struct vec3 off = vec3_sub(point->jet.r, crossing->from.at);
        put_near(surface, near, crossing->edge);
        bool past = !crossing->continued || vec3_dot(off, crossing->from.across) > 0;
        if (past && (!open || goes_over(point, crossing)))
            return;
    }
    /* past one with another open end, no nearer: joints of a narrow strip end one beside another */
    if ((!over || open) && past_open_end(point, crossing->distance, crossing) &&
        goes_over(point, crossing)) {
        crossing->at_corner = true;
        put_near(surface, near, crossing->edge);
        return;
    }
    crossing->kind = CROSSING_FREE;
    memcpy(crossing->edge, near, sizeof near);
}

/* The unit normal at an end of an edge, on the edge's own face; zero where there is none. */
static struct vec3 normal_at_end(const struct shell *shell, struct face_edge_end at) {
    const struct face_edge *edge = &shell->edges[at.edge];
    struct curve_place place;
    curve_at(shell, &shell->curves[edge->curve], edge->t[at.end], &place);
    struct surface_point point = {.uv = {place.uv[0], place.uv[1]}, .jet = place.jet};
    const struct surface *surface = &shell->faces[edge_face(shell, (size_t)at.edge)].surface;
    return surface_point_complete(surface, &point) ? point.normal : vec3_make(0, 0, 0);
}

/* Whether a normal before and one after the end of an edge are those of a crease. */
static bool is_crease(struct vec3 before, struct vec3 after) {
    return !(vec3_dot(before, after) > smooth);
}

/* The place of the boundary nearest to a point that has been found; past a crease with the normal
 * from before it. */
struct border_search {
    const struct shell *shell;
    struct vec3 r;
    double least;
    int32_t edge; /* -1: none */
    struct curve_place place;
    struct vec3 normal; /* zero: there was no crease */
};

/* Walks along the boundary, from `at` on the edge there, to the place nearest to the point: takes
 * it where it is nearer. `from` is the end of the edge that it comes from. */
static void walk_border(struct border_search *search, struct face_edge_end from,
                        struct face_edge_end to, double t) {
    const struct shell *shell = search->shell;
    struct vec3 normal = {0, 0, 0};
    for (int hop = 0; hop < HOPS_MAX && to.edge != EDGE_FREE; hop++) {
        const struct face_edge *edge = &shell->edges[to.edge];
        struct curve_place place;
        double step = HUGE_VAL, enough = border_accuracy * (edge->t[1] - edge->t[0]);
        if (from.edge != EDGE_FREE && vec3_norm2(normal) == 0 &&
            is_crease(normal_at_end(shell, from), normal_at_end(shell, to)))
            normal = normal_at_end(shell, from);
        for (int round = 0; round < BORDER_ROUNDS && fabs(step) > enough; round++) {
            curve_at(shell, &shell->curves[edge->curve], t, &place);
            struct vec3 way = vec3_sub(search->r, place.r);
            double next = t + vec3_dot(way, place.tangent) / vec3_norm2(place.tangent);
            next = fmin(fmax(next, edge->t[0]), edge->t[1]);
            step = next - t;
            t = next;
        }
        double distance = vec3_distance(place.r, search->r);
        if (distance < search->least) {
            search->least = distance;
            search->edge = to.edge;
            search->place = place;
            search->normal = normal;
        } else if (hop > 0) {
            break;
        }
        int8_t end = t == edge->t[1];
        if (t != edge->t[end])
            break;
        from = (struct face_edge_end){to.edge, end};
        to = edge->follow[end];
        t = to.edge != EDGE_FREE ? shell->edges[to.edge].t[to.end] : 0;
    }
}

bool crossing_border(const struct surface_point *point, const struct crossing *crossing,
                     struct surface_point *border, struct vec3 derivative[2]) {
    const struct shell *shell = point->surface->shell;
    struct border_search search = {
        .shell = shell, .r = point->jet.r, .least = HUGE_VAL, .edge = -1};
    const struct curve_place *place = &search.place;
    if (crossing->nearest < 0)
        return false;
    const struct face_edge *edge = &shell->edges[crossing->nearest];
    int8_t end = crossing->nearest_t > (edge->t[0] + edge->t[1]) / 2;
    struct face_edge_end none = {EDGE_FREE, 0}, here = {crossing->nearest, end};
    if (edge->mate == EDGE_FREE)
        walk_border(&search, none, here, crossing->nearest_t);
    for (int k = 0; k < 2 && edge->mate != EDGE_FREE; k++) { /* both sides of a joint's end */
        const struct face_edge *side = k ? &shell->edges[edge->mate] : edge;
        struct face_edge_end next = side->follow[k && edge->reversed ? 1 - end : end];
        if (next.edge != EDGE_FREE)
            walk_border(&search, here, next, shell->edges[next.edge].t[next.end]);
    }
    if (search.edge < 0)
        return false;
    const struct face_edge *found = &shell->edges[search.edge];
    const struct face_curve *curve = &shell->curves[found->curve];
    derivative[0] = place->tangent;
    derivative[1] = curve_second(shell, curve, place);
    *border = (struct surface_point){.uv = {place->uv[0], place->uv[1]}, .jet = place->jet};
    if (!surface_point_complete(&shell->faces[curve->face].surface, border))
        return false;
    if (vec3_norm2(search.normal) > 0)
        border->normal = search.normal;
    return true;
}

bool crossing_move(const struct surface *surface, double t, struct crossing *crossing) {
    const struct face_edge *edge = &surface->shell->edges[crossing->number];
    const double before[2] = {crossing->edge[0], crossing->edge[1]};
    t = edge->open[0] ? t : fmax(t, edge->t[0]);
    t = edge->open[1] ? t : fmin(t, edge->t[1]);
    if (!joint_at(surface, crossing->number, t, crossing))
        return false;
    put_near(surface, before, crossing->edge);
    return true;
}

bool crossing_between(const struct surface_point *point, const struct surface *beyond,
                      struct crossing *crossing) {
    struct hit joint, free;
    nearest_edges(point, point->first, beyond, NULL, &joint, &free);
    if (!joint.segment)
        return false;
    crossing->distance = sqrt(joint.distance2);
    crossing->at_corner = at_open_end(point->surface->shell, &joint);
    return joint_near(point, &joint, crossing);
}

struct vec3 crossing_turn(const struct crossing *crossing, struct vec3 v) {
    const struct crossing_frame *from = &crossing->from, *to = &crossing->to;
    struct vec3 sum = vec3_scale(vec3_dot(v, from->along), to->along);
    sum = vec3_axpy(vec3_dot(v, from->across), to->across, sum);
    return vec3_axpy(vec3_dot(v, from->normal), to->normal, sum);
}

bool crossing_carry(const struct crossing *crossing, struct surface_cursor *cursor,
                    const struct surface_point *point, int rounds, struct surface_place *place) {
    struct surface_point there;
    if (!surface_point_at(crossing->beyond, cursor, crossing->entry, &there))
        return false;
    struct vec3 offset = crossing_turn(crossing, vec3_sub(point->jet.r, crossing->from.at));
    struct vec3 target = vec3_add(there.jet.r, offset);
    if (!surface_point_pull(cursor, &there, offset, place))
        return false;
    for (int round = 0; round < rounds; round++)
        if (!surface_point_at(place->surface, cursor, place->uv, &there) ||
            !surface_point_pull(cursor, &there, vec3_sub(target, there.jet.r), place))
            return false;
    return true;
}

bool crossing_settle(struct surface_cursor *cursor, struct surface_point *point) {
    const struct surface *last = NULL;
    for (int hop = 0; hop < HOPS_MAX; hop++) {
        struct crossing crossing;
        struct surface_place place;
        crossing_find(point, last, &crossing);
        if (crossing.kind != CROSSING_JOINT || crossing.beyond == last)
            return true;
        last = point->surface;
        if (!crossing_carry(&crossing, cursor, point, 0, &place) ||
            !surface_point_at(place.surface, cursor, place.uv, point))
            return false;
    }
    return false;
}
