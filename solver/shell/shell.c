/* SPDX-License-Identifier: MIT */
#include "faces.h"

#include "solver/surface/bounds.h"
#include "surface_point.h"
#include <string.h>

static enum status shell_fail(struct shell_fault *fault, enum shell_fault_kind kind, int32_t face) {
    if (fault)
        *fault = (struct shell_fault){.kind = kind, .face_count = face >= 0, .face = {face}};
    return kind == SHELL_NOTHING_LEFT ? STATUS_DEGENERATE_SURFACE : STATUS_INVALID;
}

static enum status check_loops(const struct shell *shell, const struct shell_patch *patches,
                               struct arena *arena, struct shell_fault *fault) {
    struct loop_fault loop;
    for (size_t k = 0; k < shell->face_count; k++) {
        if (!shell->faces[k].trim)
            continue;
        enum status status = loops_check(patches[k].loops, shell->faces[k].trim, patches[k].surface,
                                         shell->tolerance, arena, &loop);
        if (status == STATUS_OK && loop.kind != LOOP_SOUND) {
            status = shell_fail(fault, SHELL_LOOP_BAD, (int32_t)k);
            if (fault)
                fault->loop = loop;
        }
        if (status != STATUS_OK)
            return status;
    }
    return STATUS_OK;
}

/* ---- components and sides ---- */

/* The face beyond an edge, and whether that has to be turned round to face like this one; -1 where
 * there is none. */
static int32_t face_beyond(const struct shell *shell, const struct face_edge *edge, bool *turn) {
    if (edge->bare || edge->mate == EDGE_FREE)
        return -1;
    const struct face_edge *mate = &shell->edges[edge->mate];
    *turn = (edge->inside == mate->inside) != edge->reversed;
    return edge_face(shell, (size_t)edge->mate);
}

/* Takes the joint of an edge and its mate apart: both are free. */
static void open_joint(struct shell *shell, struct face_edge *edge) {
    shell->edges[edge->mate].mate = EDGE_FREE;
    edge->mate = EDGE_FREE;
    shell->found.joined--;
    shell->found.free += 2;
}

/* The edges of each face: those of face k are list[first[k]] .. list[first[k + 1] - 1]. */
struct edge_lists {
    size_t *first;
    int32_t *list;
};

static enum status list_edges_of_faces(const struct shell *shell, struct arena *arena,
                                       struct edge_lists *lists) {
    lists->first = arena_alloc(arena, shell->face_count + 2, sizeof *lists->first);
    lists->list = arena_alloc(arena, shell->edge_count, sizeof *lists->list);
    if (!lists->first || !lists->list)
        return STATUS_OUT_OF_MEMORY;
    for (size_t e = 0; e < shell->edge_count; e++)
        lists->first[edge_face(shell, e) + 2]++;
    for (size_t k = 0; k < shell->face_count; k++)
        lists->first[k + 2] += lists->first[k + 1];
    for (size_t e = 0; e < shell->edge_count; e++)
        lists->list[lists->first[edge_face(shell, e) + 1]++] = (int32_t)e;
    return STATUS_OK;
}

static enum status one_sided(const struct shell *shell, const struct face_edge *edge, int32_t a,
                             int32_t b, struct shell_fault *fault) {
    struct curve_place place;
    curve_at(shell, &shell->curves[edge->curve], (edge->t[0] + edge->t[1]) / 2, &place);
    if (fault)
        *fault = (struct shell_fault){.kind = SHELL_ONE_SIDED,
                                      .face_count = 2,
                                      .face = {a < b ? a : b, a < b ? b : a},
                                      .at = place.r};
    return STATUS_INVALID;
}

/* Visits what hangs together, from the first face of each component on. */
static enum status find_components(struct shell *shell, struct arena *arena,
                                   struct shell_fault *fault) {
    struct edge_lists lists;
    int32_t *queue = arena_alloc(arena, shell->face_count, sizeof *queue);
    /* A face that would have to be turned against itself is not joined there: a band with one side
     * ends at its seam. */
    for (size_t e = 0; e < shell->edge_count; e++) {
        bool turn = false;
        struct face_edge *edge = &shell->edges[e];
        if (face_beyond(shell, edge, &turn) == edge_face(shell, e) && turn)
            open_joint(shell, edge);
    }
    enum status status = list_edges_of_faces(shell, arena, &lists);
    if (status != STATUS_OK || !queue)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < shell->face_count; k++)
        shell->faces[k].component = -1;
    for (size_t k = 0; k < shell->face_count; k++) {
        if (shell->faces[k].component >= 0 || shell->faces[k].duplicate)
            continue;
        size_t head = 0, length = 0;
        queue[length++] = (int32_t)k;
        shell->faces[k].component = (int32_t)shell->component_count;
        for (; head < length; head++) {
            struct face *face = &shell->faces[queue[head]];
            for (size_t at = lists.first[queue[head]]; at < lists.first[queue[head] + 1]; at++) {
                bool turn = false;
                struct face_edge *edge = &shell->edges[lists.list[at]];
                int32_t number = face_beyond(shell, edge, &turn);
                if (number < 0)
                    continue;
                struct face *next = &shell->faces[number];
                int8_t side = (int8_t)(turn ? -face->side : face->side);
                if (next->component < 0) {
                    next->component = (int32_t)shell->component_count;
                    next->side = side;
                    queue[length++] = number;
                } else if (next->side != side && !shell->lenient) {
                    return one_sided(shell, edge, queue[head], number, fault);
                } else if (next->side != side) {
                    open_joint(shell, edge);
                    shell->found.faulty++;
                }
            }
        }
        shell->component_count++;
    }
    for (size_t k = 0; k < shell->face_count; k++)
        if (shell->faces[k].duplicate)
            shell->faces[k].component = shell->faces[shell->faces[k].twin].component;
    return STATUS_OK;
}

/* ---- boundaries ---- */

/* Free edges by number, each with the root of those it hangs together with. */
struct chains {
    struct shell *shell;
    int32_t *edge, *root;
    struct vec3 end;
    int32_t number, from; /* the end that is looked at, and its edge's chain */
};

static int32_t root_of_chain(const struct chains *chains, int32_t k) {
    while (chains->root[k] != k)
        k = chains->root[k] = chains->root[chains->root[k]];
    return k;
}

/* Two edges that end at one place are of one chain. */
static bool link_chains(void *context, int32_t number) {
    struct chains *chains = context;
    const struct face_edge *edge = &chains->shell->edges[chains->edge[number / 2]];
    if (vec3_distance(edge->end[number % 2], chains->end) > 3 * chains->shell->tolerance)
        return true;
    if (number != chains->number)
        chains->shell->edges[chains->edge[chains->from]].follow[chains->number % 2] =
            (struct face_edge_end){chains->edge[number / 2], (int8_t)(number % 2)};
    int32_t a = root_of_chain(chains, chains->from), b = root_of_chain(chains, number / 2);
    chains->root[a > b ? a : b] = a > b ? b : a;
    return true;
}

/* So much of its length from its end an edge has the direction that it has at the end. */
static const double inside_end = 1e-10;

/* Faces meet smoothly where their normals differ by less than this, as a cosine. */
static const double smooth = 0.98;

/* What is this close to a side of the domain, as a share of it, is on it. */
static const double on_side = 1e-9;

/* A joint runs out of a side of the domain that it is at an angle to, of which this is less than
 * the sine; else it runs along it. */
static const double runs_out = 0.01;

/* Notes at a joint's end that a free edge of its face ends there, too. */
struct corner {
    const struct chains *chains;
    struct face_edge *joint;
    int end;
};

/* In which line a joint goes on beyond an end on the boundary. That of a crease is where both faces
 * go on to meet. Over a smooth joint they are one surface, and any line will do that both know: the
 * parameter line that leaves a side of the domain, between the spans that the surface has there,
 * where the joint runs out of one that the boundary runs along; else the joint's own direction. */
static void lead_beyond(const struct shell *shell, struct face_edge *joint, int end,
                        const struct face_edge *border) {
    const struct face_curve *curve = &shell->curves[joint->curve];
    const struct surface *surface = &shell->faces[curve->face].surface;
    struct curve_place place, other;
    struct vec3 normal[2], at;
    double within = inside_end * (joint->t[1] - joint->t[0]);
    curve_at(shell, curve, end ? joint->t[1] - within : joint->t[0] + within, &place);
    memcpy(joint->beyond[end], place.rate, sizeof place.rate);
    edge_normals(shell, joint, end, normal, &at);
    joint->straight[end] = vec3_dot(normal[0], normal[1]) > smooth;
    curve_at(shell, curve, joint->t[end], &other);
    memcpy(joint->tip[end], other.uv, sizeof other.uv);
    for (int k = 0; k < 2 && joint->straight[end]; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        const double ends[2] = {surface_axis_lower(axis), surface_axis_upper(axis)};
        int side = fabs(place.uv[k] - ends[1]) < fabs(place.uv[k] - ends[0]);
        bool along = !axis->closed;
        for (int n = 0; n <= 2 && along; n++) {
            edge_at_share(shell, border, 0.5 * n, &other);
            along = fabs(other.uv[k] - ends[side]) <= on_side * (ends[1] - ends[0]);
        }
        double speed = vec3_norm(k ? place.jet.v : place.jet.u), length = vec3_norm(place.tangent);
        int sense = side == end ? 1 : -1;
        if (!along || !(speed * speed > surface->least_tangent2[k]) ||
            !(sense * place.rate[k] * speed > runs_out * length))
            continue;
        joint->beyond[end][1 - k] = 0;
        joint->beyond[end][k] = sense * length / speed;
    }
}

static bool open_end(void *context, int32_t number) {
    struct corner *corner = context;
    const struct shell *shell = corner->chains->shell;
    const struct face_edge *edge = &shell->edges[corner->chains->edge[number / 2]];
    bool same = shell->curves[edge->curve].face == shell->curves[corner->joint->curve].face;
    double apart = vec3_distance(edge->end[number % 2], corner->joint->end[corner->end]);
    corner->joint->open[corner->end] = same && apart <= 3 * shell->tolerance;
    if (corner->joint->open[corner->end]) {
        corner->joint->follow[corner->end] =
            (struct face_edge_end){corner->chains->edge[number / 2], (int8_t)(number % 2)};
        lead_beyond(shell, corner->joint, corner->end, edge);
    }
    return !corner->joint->open[corner->end];
}

/* What tells the end of a tube from the edge of a plate and that of a hole: the area that a piece
 * of boundary runs round, as a vector, its length, and the mean normal along it, times that. */
struct round {
    struct vec3 area, normal;
    double length;
};

enum { SAMPLES_OF_EDGE = 16 };

/* Of a plate's edge the share of the area that lies across the mean normal is more than this: that
 * share is 1 for a flat one, -1 for a hole's and, for a cone's, the sine of half its angle. */
static const double plate_share = 0.8;

static void add_to_round(const struct shell *shell, const struct face_edge *edge,
                         struct round *round) {
    const struct face_curve *curve = &shell->curves[edge->curve];
    double side = shell->faces[curve->face].side, sense = edge->inside * side;
    struct curve_place place;
    struct vec3 last = {0, 0, 0};
    for (int k = 0; k <= SAMPLES_OF_EDGE; k++) {
        curve_at(shell, curve, edge->t[0] + (edge->t[1] - edge->t[0]) * k / SAMPLES_OF_EDGE,
                 &place);
        struct vec3 r = vec3_sub(place.r, shell->lower);
        struct vec3 normal = vec3_unit(vec3_cross(place.jet.u, place.jet.v));
        double length = k > 0 ? vec3_distance(r, last) : 0;
        if (k > 0)
            round->area = vec3_axpy(sense / 2, vec3_cross(last, r), round->area);
        round->normal = vec3_axpy(side * length, normal, round->normal);
        round->length += length;
        last = r;
    }
}

/* Notes a piece of the boundary with this edge, if it is the shortest so far. */
static void note_shortest(struct shell_edges *found, const struct shell *shell, int32_t edge,
                          double length) {
    if (found->shortest > 0 && found->shortest <= length)
        return;
    found->shortest = length;
    found->shortest_face = edge_face(shell, (size_t)edge);
    found->shortest_at = shell->edges[edge].end[0];
}

/* How many pieces the boundary of each component consists of, how many of them are edges of plates,
 * and the area that they run round together, which by Stokes' theorem is the integral of the normal
 * over the component. */
static enum status count_boundaries(struct shell *shell, struct arena *arena) {
    struct chains chains = {.shell = shell};
    size_t count = 0, room = shell->edge_count;
    struct boxes *boxes;
    struct box *box = arena_take(arena, 2 * room, sizeof *box);
    chains.edge = arena_take(arena, room, sizeof *chains.edge);
    chains.root = arena_take(arena, room, sizeof *chains.root);
    struct round *rounds = arena_alloc(arena, room, sizeof *rounds);
    shell->boundaries = arena_alloc(arena, shell->component_count, sizeof *shell->boundaries);
    shell->plates = arena_alloc(arena, shell->component_count, sizeof *shell->plates);
    shell->rounded = arena_alloc(arena, shell->component_count, sizeof *shell->rounded);
    if (!box || !chains.edge || !chains.root || !rounds || !shell->boundaries || !shell->plates ||
        !shell->rounded)
        return STATUS_OUT_OF_MEMORY;
    for (size_t e = 0; e < shell->edge_count; e++) {
        const struct face_edge *edge = &shell->edges[e];
        if (edge->bare || edge->mate != EDGE_FREE)
            continue;
        for (int k = 0; k < 2; k++)
            box[2 * count + (size_t)k] =
                box_round(edge->end[k], edge->end[k], 3 * shell->tolerance);
        chains.edge[count] = (int32_t)e;
        chains.root[count] = (int32_t)count;
        shell->edges[e].follow[0].edge = shell->edges[e].follow[1].edge = EDGE_FREE;
        count++;
    }
    enum status status = boxes_make(box, 2 * count, arena, &boxes);
    for (size_t k = 0; k < 2 * count && status == STATUS_OK; k++) {
        chains.from = (int32_t)(k / 2);
        chains.number = (int32_t)k;
        chains.end = shell->edges[chains.edge[k / 2]].end[k % 2];
        boxes_visit(boxes, &box[k], link_chains, &chains);
    }
    for (size_t e = 0; e < shell->edge_count && status == STATUS_OK; e++) {
        struct corner corner = {&chains, &shell->edges[e], 0};
        for (; corner.joint->mate != EDGE_FREE && corner.end < 2; corner.end++) {
            struct vec3 r = corner.joint->end[corner.end];
            corner.joint->follow[corner.end].edge = EDGE_FREE;
            struct box at = box_round(r, r, 0);
            boxes_visit(boxes, &at, open_end, &corner);
        }
    }
    for (size_t k = 0; k < count && status == STATUS_OK; k++)
        add_to_round(shell, &shell->edges[chains.edge[k]],
                     &rounds[root_of_chain(&chains, (int32_t)k)]);
    for (size_t k = 0; k < count && status == STATUS_OK; k++)
        if (chains.root[k] == (int32_t)k) {
            int32_t component = shell->faces[edge_face(shell, (size_t)chains.edge[k])].component;
            shell->boundaries[component]++;
            note_shortest(&shell->found, shell, chains.edge[k], rounds[k].length);
            shell->rounded[component] = vec3_add(shell->rounded[component], rounds[k].area);
            double across = vec3_dot(rounds[k].area, rounds[k].normal);
            shell->plates[component] +=
                across > plate_share * rounds[k].length * vec3_norm(rounds[k].area);
        }
    return status;
}

enum status shell_orient(const struct shell *shell, int32_t face, struct arena *arena,
                         struct shell **oriented) {
    struct shell *made = arena_alloc(arena, 1, sizeof *made);
    struct face *faces = arena_alloc(arena, shell->face_count, sizeof *faces);
    if (!made || !faces)
        return STATUS_OUT_OF_MEMORY;
    *made = *shell;
    made->faces = faces;
    memcpy(faces, shell->faces, shell->face_count * sizeof *faces);
    for (size_t k = 0; k < shell->face_count; k++) {
        bool against = faces[k].side != shell->faces[face].side;
        faces[k].surface.shell = made;
        faces[k].surface.side = against ? -1 : 1;
    }
    *oriented = made;
    return STATUS_OK;
}

/* ---- the nearest place ---- */

static struct shell_point shell_point_of(const struct face *face, const double uv[2]) {
    struct shell_point place = {.face = face->surface.face, .inner = {uv[0], uv[1]}};
    surface_outer(&face->surface, uv, place.uv);
    return place;
}

/* Where on an edge, whose segments are a run, a chord of one comes nearest to `point`. */
static double nearest_chord(const struct shell *shell, const struct face *face,
                            const struct face_run *run, struct vec3 point) {
    double least2 = HUGE_VAL, nearest = shell->edges[run->edge].t[0];
    for (uint32_t k = run->first; k < run->first + run->count; k++) {
        const struct face_segment *segment = &face->segments[k];
        bool last = k + 1 == run->first + run->count;
        struct vec3 to = last ? shell->edges[run->edge].end[1] : segment[1].r;
        struct vec3 chord = vec3_sub(to, segment->r), way = vec3_sub(point, segment->r);
        double length2 = vec3_norm2(chord);
        double share = length2 > 0 ? fmin(fmax(vec3_dot(way, chord) / length2, 0), 1) : 0;
        double away2 = vec3_norm2(vec3_axpy(-share, chord, way));
        if (!(away2 < least2))
            continue;
        least2 = away2;
        nearest = segment->t[0] + share * (segment->t[1] - segment->t[0]);
    }
    return nearest;
}

/* The place of a face nearest to `point`, if it is nearer than `*distance`. On an edge it is looked
 * for from where the segments' chords come nearest, which leave it by next to nothing. */
static void nearest_of_face(const struct shell *shell, const struct face *face, struct vec3 point,
                            struct shell_point *place, double *distance) {
    double uv[2], away;
    struct curve_place at;
    surface_nearest_at(&face->surface, point, uv, &away);
    if (!(away < *distance))
        return;
    if (face_contains(face, uv)) {
        *distance = away;
        *place = shell_point_of(face, uv);
        return;
    }
    for (uint32_t r = 0; r < face->run_count; r = face->runs[r].next) {
        const struct face_edge *edge = &shell->edges[face->runs[r].edge];
        double from = nearest_chord(shell, face, &face->runs[r], point);
        away = curve_nearest(shell, &shell->curves[edge->curve], point, from, edge->t, &at);
        if (!(away < *distance))
            continue;
        *distance = away;
        *place = shell_point_of(face, at.uv);
    }
}

static bool face_is_of(const struct face *face, int32_t component) {
    return !face->duplicate && (component == SHELL_ANY || face->component == component);
}

/* Of the faces but the first one, whose place is known: they may be nearer. */
static void nearest_of_others(const struct shell *shell, struct vec3 point, int32_t component,
                              int32_t first, struct shell_point *place, double *distance) {
    for (size_t k = 0; k < shell->face_count; k++) {
        const struct face *face = &shell->faces[k];
        if ((int32_t)k != first && face_is_of(face, component) &&
            box_distance2(&face->box, point) < *distance * *distance)
            nearest_of_face(shell, face, point, place, distance);
    }
}

void shell_nearest(const struct shell *shell, struct vec3 point, int32_t component,
                   struct shell_point *place, double *distance) {
    int32_t first = -1;
    double least = HUGE_VAL;
    *distance = HUGE_VAL;
    for (size_t k = 0; k < shell->face_count; k++) {
        const struct face *face = &shell->faces[k];
        double away = box_distance2(&face->box, point);
        if (face_is_of(face, component) && away < least) {
            least = away;
            first = (int32_t)k;
        }
    }
    if (first < 0)
        return;
    nearest_of_face(shell, &shell->faces[first], point, place, distance);
    nearest_of_others(shell, point, component, first, place, distance);
}

void shell_nearest_from(const struct shell *shell, struct vec3 point, struct shell_point *place,
                        double *distance) {
    const struct face *face = &shell->faces[place->face];
    double uv[2] = {place->inner[0], place->inner[1]};
    *distance = surface_nearest_from(&face->surface, point, uv);
    if (!face->surface.has_folds && face_contains(face, uv)) {
        *place = shell_point_of(face, uv);
    } else {
        *distance = HUGE_VAL;
        nearest_of_face(shell, face, point, place, distance);
    }
    nearest_of_others(shell, point, face->component, place->face, place, distance);
}

static enum status make_shell(const struct shell_patch *patches, size_t count, double tolerance,
                              bool lenient, struct arena *arena, struct shell **shell,
                              struct shell_fault *fault) {
    struct shell *made = arena_alloc(arena, 1, sizeof *made);
    if (fault)
        *fault = (struct shell_fault){.kind = SHELL_FAULTLESS};
    if (count == 0 || count > SHELL_FACES_MAX)
        return shell_fail(fault, SHELL_TOO_MANY, -1);
    if (!made || !(made->faces = arena_alloc(arena, count, sizeof *made->faces)))
        return STATUS_OUT_OF_MEMORY;
    made->face_count = count;
    made->lenient = lenient;
    for (size_t k = 0; k < count; k++) {
        const struct surface *surface = patches[k].surface;
        struct face *face = &made->faces[k];
        struct vec3 low, high;
        struct trim *trim = NULL;
        enum status status = STATUS_OK;
        if (patches[k].loop_count > 0 && !patches[k].trim)
            status = trim_make(surface, patches[k].loops, patches[k].loop_count, arena, &trim);
        if (status == STATUS_DEGENERATE_SURFACE)
            return shell_fail(fault, SHELL_NOTHING_LEFT, (int32_t)k);
        if (status != STATUS_OK)
            return status;
        face->trim = trim ? trim : patches[k].trim;
        face->plain = surface;
        face->surface = *surface;
        face->side = 1;
        face->area = face->trim ? trim_area(face->trim, &face->centroid)
                                : surface_area(surface, &face->centroid);
        face->gyration2 = face->trim ? trim_gyration2(face->trim) : surface_gyration2(surface);
        bounds_tight(&face->surface, &low, &high);
        face->box = (struct box){low, high};
        made->lower = k > 0 ? vec3_min(made->lower, low) : low;
        made->upper = k > 0 ? vec3_max(made->upper, high) : high;
    }
    made->size = vec3_distance(made->lower, made->upper);
    made->tolerance = tolerance == 0 ? SHELL_TOLERANCE * made->size : tolerance;
    if (!(made->tolerance > 0 && made->tolerance < made->size))
        return shell_fail(fault, SHELL_TOLERANCE_BAD, -1);
    for (size_t k = 0; k < count; k++) {
        made->faces[k].surface.shell = made;
        made->faces[k].surface.face = (int32_t)k;
    }
    enum status status = lenient ? STATUS_OK : check_loops(made, patches, arena, fault);
    if (status == STATUS_OK)
        status = faces_join(made, patches, arena, fault);
    if (status == STATUS_OK)
        status = find_components(made, arena, fault);
    if (status == STATUS_OK)
        status = count_boundaries(made, arena);
    if (status == STATUS_OK)
        status = faces_round_poles(made, arena);
    *shell = made;
    return status;
}

enum status shell_make(const struct shell_patch *patches, size_t count, double tolerance,
                       struct arena *arena, struct shell **shell, struct shell_fault *fault) {
    return make_shell(patches, count, tolerance, false, arena, shell, fault);
}

enum status shell_make_lenient(const struct shell_patch *patches, size_t count, double tolerance,
                               struct arena *arena, struct shell **shell) {
    return make_shell(patches, count, tolerance, true, arena, shell, NULL);
}

static void relocate_face(struct relocation *relocation, struct face *face) {
    surface_relocate(relocation, &face->plain);
    surface_relocate_inside(relocation, &face->surface);
    trim_relocate(relocation, &face->trim);
    relocate(relocation, &face->segments, face->segment_count, sizeof *face->segments);
    relocate(relocation, &face->runs, face->run_count, sizeof *face->runs);
    for (int end = 0; end < 4; end++)
        relocate(relocation, &face->round_pole[end], face->round_pole_count[end],
                 sizeof *face->round_pole[end]);
    relocate(relocation, &face->cells, (size_t)FACE_GRID * FACE_GRID, sizeof *face->cells);
}

void shell_relocate(struct relocation *relocation, void *field) {
    struct shell *shell = relocate_once(relocation, field, 1, sizeof *shell);
    if (!shell)
        return;
    struct face *face = relocate(relocation, &shell->faces, shell->face_count, sizeof *face);
    for (size_t k = 0; face && k < shell->face_count; k++)
        relocate_face(relocation, &face[k]);
    struct face_curve *curve =
        relocate(relocation, &shell->curves, shell->curve_count, sizeof *curve);
    for (size_t k = 0; curve && k < shell->curve_count; k++)
        trim_curve_relocate(relocation, &curve[k].trim);
    size_t components = shell->component_count;
    relocate(relocation, &shell->edges, shell->edge_count, sizeof *shell->edges);
    relocate(relocation, &shell->boundaries, components, sizeof *shell->boundaries);
    relocate(relocation, &shell->plates, components, sizeof *shell->plates);
    relocate(relocation, &shell->rounded, components, sizeof *shell->rounded);
}

size_t shell_face_count(const struct shell *shell) {
    return shell->face_count;
}

const struct surface *shell_surface(const struct shell *shell, int32_t face) {
    return &shell->faces[face].surface;
}

const struct surface *shell_plain_surface(const struct shell *shell, int32_t face) {
    return shell->faces[face].plain;
}

const struct trim *shell_trim(const struct shell *shell, int32_t face) {
    return shell->faces[face].trim;
}

int32_t shell_component(const struct shell *shell, int32_t face) {
    return shell->faces[face].component;
}

int shell_side(const struct shell *shell, int32_t face) {
    return shell->faces[face].side;
}

size_t shell_component_count(const struct shell *shell) {
    return shell->component_count;
}

bool shell_is_duplicate(const struct shell *shell, int32_t face) {
    return shell->faces[face].duplicate;
}

struct shell_edges shell_edges(const struct shell *shell) {
    return shell->found;
}

double shell_tolerance(const struct shell *shell) {
    return shell->tolerance;
}

void shell_bounds(const struct shell *shell, struct vec3 *lower, struct vec3 *upper) {
    *lower = shell->lower;
    *upper = shell->upper;
}

double shell_size(const struct shell *shell) {
    return shell->size;
}

double shell_joint_width(const struct shell *shell) {
    return SURFACE_POINT_BOUNDARY_WIDTH * shell->size + 2 * shell->found.largest_gap;
}

double shell_area(const struct shell *shell, int32_t component, struct vec3 *centroid) {
    double area = 0;
    struct vec3 moment = {0, 0, 0};
    for (size_t k = 0; k < shell->face_count; k++) {
        const struct face *face = &shell->faces[k];
        if (face->component != component || face->duplicate)
            continue;
        area += face->area;
        moment = vec3_axpy(face->area, face->centroid, moment);
    }
    if (centroid)
        *centroid = vec3_scale(1 / area, moment);
    return area;
}

double shell_gyration2(const struct shell *shell, int32_t component) {
    struct vec3 centroid;
    double area = shell_area(shell, component, &centroid), sum = 0;
    for (size_t k = 0; k < shell->face_count; k++) {
        const struct face *face = &shell->faces[k];
        if (face->component == component && !face->duplicate)
            sum += face->area * (face->gyration2 + vec3_norm2(vec3_sub(face->centroid, centroid)));
    }
    return sum / area;
}

int32_t shell_largest_component(const struct shell *shell) {
    int32_t largest = 0, count = (int32_t)shell_component_count(shell);
    for (int32_t k = 1; k < count; k++)
        if (shell_area(shell, k, NULL) > shell_area(shell, largest, NULL))
            largest = k;
    return largest;
}

bool shell_is_closed(const struct shell *shell, int32_t face) {
    for (size_t e = 0; e < shell->edge_count; e++) {
        const struct face_edge *edge = &shell->edges[e];
        if (!edge->bare && edge->mate == EDGE_FREE &&
            shell->faces[edge_face(shell, e)].component == shell->faces[face].component)
            return false;
    }
    return true;
}

bool shell_may_close(const struct shell *shell, int32_t face) {
    return shell->boundaries[shell->faces[face].component] != 1;
}

bool shell_may_be_tube(const struct shell *shell, int32_t face) {
    int32_t component = shell->faces[face].component;
    uint32_t boundaries = shell->boundaries[component], plates = shell->plates[component];
    return boundaries >= 2 && (plates == 0 || (plates == 2 && boundaries == 2));
}

double shell_flatness(const struct shell *shell, int32_t face) {
    int32_t component = shell->faces[face].component;
    return vec3_norm(shell->rounded[component]) / shell_area(shell, component, NULL);
}

bool shell_over(const struct shell *shell, struct vec3 point, int32_t face, double reach,
                struct shell_point *place) {
    double least = reach;
    bool found = false;
    for (size_t k = 0; k < shell->face_count; k++) {
        const struct face *other = &shell->faces[k];
        double uv[2], distance;
        if ((int32_t)k == face || !face_is_of(other, shell->faces[face].component) ||
            box_distance2(&other->box, point) > least * least)
            continue;
        surface_nearest_at(&other->surface, point, uv, &distance);
        if (!(distance < least) || !face_contains(other, uv))
            continue;
        least = distance;
        *place = shell_point_of(other, uv);
        found = true;
    }
    return found;
}
