/* SPDX-License-Identifier: MIT */
/*
 * The edges of a shell's faces and what joins them. Curves are sampled, and cut at the ends of all
 * curves that come within the tolerance of them, and at their own corners. Two edges are joined
 * when their ends coincide and each passes all samples of the other, within the tolerance.
 */
#include "joints.h"

enum {
    MATES_MAX = 8,
    GAP_PLACES = 128, /* of an edge, beside its ends */
    GAP_SECTIONS = 6, /* by each of which a stretch of it is 0.62 as long */
    GAP_RISE = 4      /* times what the gap is at the places it may be between them */
};

/* Two faces at an edge are folded on each other when the cosine of their angle is more. */
static const double turned_back = 0.9994;

struct mates {
    struct join *join;
    const struct face_edge *edge;
    struct vec3 sample[JOIN_SAMPLES];
    int32_t found[MATES_MAX];
    bool reversed[MATES_MAX];
    double gap[MATES_MAX];
    int count;
};

/* So much of its length from a corner at its end an edge has derivatives of its own, and not those
 * of what follows it on its curve. */
static const double off_corner = 1e-10;

/* How far a point is from an edge, looked for from *from first, then from elsewhere; *from gets
 * where it is nearest. */
static double distance_from_edge(const struct shell *shell, struct vec3 point,
                                 const struct face_edge *edge, double *from) {
    const struct face_curve *curve = &shell->curves[edge->curve];
    struct curve_place place, other;
    double least = curve_nearest(shell, curve, point, *from, edge->t, &place);
    double length = edge->t[1] - edge->t[0], off = off_corner * length;
    const double within[2] = {edge->t[0] + off, edge->t[1] - off};
    for (int quarter = 0; quarter <= 4 && least > shell->tolerance; quarter++) {
        double t = edge->t[0] + quarter * length / 4;
        double distance = curve_nearest(shell, curve, point, t, within, &other);
        if (distance < least) {
            least = distance;
            place = other;
        }
    }
    *from = place.t;
    return least;
}

/* Whether the two edges coincide; `gap` gets by how much they miss each other. */
static bool coincide(const struct mates *mates, const struct face_edge *other, double middle,
                     bool *reversed, double *gap) {
    const struct shell *shell = mates->join->shell;
    const struct face_edge *edge = mates->edge;
    double near[2], slack = 3 * shell->tolerance, first = middle, last = middle;
    *gap = 0;
    for (int k = 0; k < 2; k++)
        near[k] = fmax(vec3_distance(edge->end[0], other->end[k]),
                       vec3_distance(edge->end[1], other->end[1 - k]));
    if (!(fmin(near[0], near[1]) <= slack))
        return false;
    for (int k = 0; k < JOIN_SAMPLES; k++) {
        double distance = distance_from_edge(shell, mates->sample[k], other, &last);
        if (!(distance <= shell->tolerance * (1 + 1e-9)))
            return false;
        *gap = fmax(*gap, distance);
        first = k == 0 ? last : first;
    }
    *reversed = near[1] < near[0];
    if (fmax(near[0], near[1]) <= slack) /* closed: by the order of the samples */
        *reversed = last < first;
    return true;
}

/* Takes the edge that a step belongs to, if it coincides with the one that mates are looked for. */
static bool try_mate(void *context, int32_t step) {
    struct mates *mates = context;
    struct join *join = mates->join;
    const struct shell *shell = join->shell;
    int32_t number = join->curve_of[step];
    struct curve_place place;
    const struct face_curve *curve = &shell->curves[number];
    struct vec3 middle = mates->sample[JOIN_SAMPLES / 2];
    if (!(join_nearest(join, (uint32_t)step, middle, curve->range, &place) <=
          shell->tolerance * (1 + 1e-9)))
        return true;
    int32_t e = join->edge_of[number], end = join->edge_of[number + 1];
    while (e < end && !(place.t >= shell->edges[e].t[0] && place.t <= shell->edges[e].t[1]))
        e++;
    if (e == end || &shell->edges[e] == mates->edge || shell->edges[e].bare)
        return true;
    for (int k = 0; k < mates->count; k++)
        if (mates->found[k] == e)
            return true;
    if (coincide(mates, &shell->edges[e], place.t, &mates->reversed[mates->count],
                 &mates->gap[mates->count]))
        mates->found[mates->count++] = e;
    return mates->count < MATES_MAX;
}

static void find_mates(struct join *join, const struct face_edge *edge, struct mates *mates) {
    *mates = (struct mates){.join = join, .edge = edge};
    for (int k = 0; k < JOIN_SAMPLES; k++) {
        struct curve_place place;
        edge_at_share(join->shell, edge, (k + 1.0) / (JOIN_SAMPLES + 1), &place);
        mates->sample[k] = place.r;
    }
    struct vec3 middle = mates->sample[JOIN_SAMPLES / 2];
    struct box box = box_round(middle, middle, join->shell->tolerance);
    boxes_visit(join->boxes, &box, try_mate, mates);
}

/* Whether each edge of a face, but those that are no boundary, coincides with one of another. */
static bool has_edges_of(struct join *join, int32_t face, int32_t other) {
    bool any = false;
    for (size_t e = 0; e < join->shell->edge_count; e++) {
        struct mates mates;
        const struct face_edge *edge = &join->shell->edges[e];
        bool found = false;
        if (edge_face(join->shell, e) != face || edge->bare)
            continue;
        find_mates(join, edge, &mates);
        for (int k = 0; k < mates.count; k++)
            found = found || edge_face(join->shell, (size_t)mates.found[k]) == other;
        if (!found)
            return false;
        any = true;
    }
    return any;
}

/* Whether a place well inside a face lies on another. */
static bool middle_lies_on(const struct shell *shell, int32_t face, int32_t other) {
    const struct face *f = &shell->faces[face];
    struct surface_cursor cursor = {0, 0};
    struct surface_jet jet;
    double uv[2], distance;
    for (int k = 0; k < 2; k++)
        uv[k] =
            (surface_axis_lower(&f->surface.axis[k]) + surface_axis_upper(&f->surface.axis[k])) / 2;
    if (f->trim) {
        trim_middle(f->trim, uv);
        surface_inner(&f->surface, uv, uv);
    }
    surface_jet_at(&f->surface, &cursor, uv[0], uv[1], &jet);
    surface_nearest_at(&shell->faces[other].surface, jet.r, uv, &distance);
    return distance <= 2 * shell->tolerance;
}

/* Makes an edge no boundary any more. */
static void take_out(struct shell *shell, struct face_edge *edge) {
    if (edge->mate != EDGE_FREE) {
        shell->edges[edge->mate].mate = EDGE_FREE;
        shell->found.joined--;
    }
    edge->mate = EDGE_FREE;
    edge->bare = true;
}

/* The unit vector at the middle of an edge that lies in its face and points into it. */
static struct vec3 inward_at(const struct shell *shell, const struct face_edge *edge) {
    struct curve_place place;
    curve_at(shell, &shell->curves[edge->curve], (edge->t[0] + edge->t[1]) / 2, &place);
    struct vec3 normal = vec3_cross(place.jet.u, place.jet.v);
    return vec3_unit(vec3_scale(edge->inside, vec3_cross(normal, place.tangent)));
}

/* Of two faces at an edge of three that are one and the same, leaves the later out: its edges are
 * no boundary any more. Whether there were such. */
static bool leave_duplicate_out(struct join *join, int32_t edge, const struct mates *mates) {
    struct shell *shell = join->shell;
    int32_t face[MATES_MAX + 1] = {edge_face(shell, (size_t)edge)};
    for (int k = 0; k < mates->count; k++)
        face[k + 1] = edge_face(shell, (size_t)mates->found[k]);
    for (int a = 0; a <= mates->count; a++)
        for (int b = 0; b <= mates->count; b++) {
            if (face[a] <= face[b] || !has_edges_of(join, face[a], face[b]) ||
                !has_edges_of(join, face[b], face[a]) || !middle_lies_on(shell, face[a], face[b]))
                continue;
            shell->faces[face[a]].duplicate = true;
            shell->faces[face[a]].twin = face[b];
            shell->found.duplicates++;
            for (size_t e = 0; e < shell->edge_count; e++)
                if (edge_face(shell, e) == face[a])
                    take_out(shell, &shell->edges[e]);
            return true;
        }
    return false;
}

/* Whether two edges that all but coincide are the sides of one face that is hardly wider there than
 * the tolerance: each has it on the side of the other, and what lies between them is as near. */
static bool is_thin_between(const struct shell *shell, int32_t first, int32_t second) {
    const struct face_edge *edges[2] = {&shell->edges[first], &shell->edges[second]};
    struct curve_place place[2];
    struct surface_cursor cursor = {0, 0};
    struct surface_jet jet;
    double way[2], middle[2];
    if (edge_face(shell, (size_t)first) != edge_face(shell, (size_t)second))
        return false;
    curve_at(shell, &shell->curves[edges[0]->curve], (edges[0]->t[0] + edges[0]->t[1]) / 2,
             &place[0]);
    (void)curve_nearest(shell, &shell->curves[edges[1]->curve], place[0].r,
                        (edges[1]->t[0] + edges[1]->t[1]) / 2, edges[1]->t, &place[1]);
    for (int k = 0; k < 2; k++) {
        way[k] = place[1].uv[k] - place[0].uv[k];
        middle[k] = (place[0].uv[k] + place[1].uv[k]) / 2;
    }
    for (int k = 0; k < 2; k++) {
        double left = place[k].rate[0] * way[1] - place[k].rate[1] * way[0];
        if (!(edges[k]->inside * (k ? -left : left) > 0))
            return false;
    }
    surface_jet_at(&shell->faces[edge_face(shell, (size_t)first)].surface, &cursor, middle[0],
                   middle[1], &jet);
    return vec3_distance(jet.r, place[0].r) <= 2 * shell->tolerance;
}

static void forget_mate(struct mates *mates, int k) {
    mates->count--;
    mates->found[k] = mates->found[mates->count];
    mates->reversed[k] = mates->reversed[mates->count];
    mates->gap[k] = mates->gap[mates->count];
}

/* A face is a sliver where it is no wider than the tolerance, as long as that is a small share of
 * the part: not the fillets of a part that is to be joined within their width. */
static const double sliver_share = 1e-3;

static bool have_slivers(const struct shell *shell) {
    return shell->tolerance <= sliver_share * shell->size;
}

static bool is_sliver(const struct shell *shell, int32_t edge) {
    return have_slivers(shell) && join_is_sliver(shell, &shell->edges[edge], 0.5, shell->tolerance);
}

/* Faces of two edges that lie on each other there: cloth does not turn back upon itself. */
static bool turn_back(const struct shell *shell, int32_t first, int32_t second) {
    return vec3_dot(inward_at(shell, &shell->edges[first]),
                    inward_at(shell, &shell->edges[second])) > turned_back;
}

/* What may speak against one of several mates of an edge. */
typedef bool objection(const struct shell *shell, int32_t edge, int32_t mate);

static bool is_of_sliver(const struct shell *shell, int32_t edge, int32_t mate) {
    (void)edge;
    return is_sliver(shell, mate);
}

/* Forgets the mates with an objection, unless all have it. */
static void prefer(const struct shell *shell, int32_t edge, objection *to, struct mates *mates) {
    bool against[MATES_MAX];
    int count = 0;
    for (int k = 0; k < mates->count; k++)
        count += against[k] = to(shell, edge, mates->found[k]);
    for (int k = mates->count - 1; k >= 0 && count < mates->count; k--)
        if (against[k]) {
            forget_mate(mates, k);
            count--;
        }
}

/* Leaves the nearest of the mates. */
static void keep_nearest(struct mates *mates) {
    while (mates->count > 1)
        forget_mate(mates, mates->gap[0] < mates->gap[mates->count - 1] ? mates->count - 1 : 0);
}

/* Beside a face that is no wider than the tolerance its neighbours coincide with both its sides,
 * and with each other: they are joined to each other, or else to the side that is theirs. */
static void choose_mate(const struct shell *shell, int32_t edge, struct mates *mates) {
    if (mates->count < 2 || !have_slivers(shell))
        return;
    bool thin = false; /* both sides of a thin face are among the mates */
    for (int a = 0; a < mates->count; a++)
        for (int b = a + 1; b < mates->count; b++)
            thin = thin || is_thin_between(shell, mates->found[a], mates->found[b]);
    prefer(shell, edge, is_thin_between, mates);
    prefer(shell, edge, turn_back, mates);
    prefer(shell, edge, is_of_sliver, mates);
    if (thin || is_sliver(shell, mates->found[0]))
        keep_nearest(mates);
}

/* How far the place at t of an edge is from its mate's curve, looked for from *from; *from gets
 * where that is nearest. */
static double gap_to_mate(const struct shell *shell, const struct face_edge *edge, double t,
                          double *from) {
    const struct face_edge *mate = &shell->edges[edge->mate];
    const struct face_curve *curve = &shell->curves[mate->curve];
    struct curve_place place, nearest;
    curve_at(shell, &shell->curves[edge->curve], t, &place);
    double gap = curve_nearest(shell, curve, place.r, *from, curve->range, &nearest);
    *from = nearest.t;
    return gap > shell->tolerance ? fmin(gap, distance_from_edge(shell, place.r, mate, from)) : gap;
}

/* Places of an edge: its ends and the middles of some steps between its points, which are dense
 * where it bends; how many. At the points themselves curves meet that were laid through them. */
static int spread_places(const struct join *join, const struct face_edge *edge,
                         double t[GAP_PLACES + 2]) {
    const struct face_curve *curve = &join->shell->curves[edge->curve];
    const struct join_point *points = join->points + curve->first;
    uint32_t begin = 0, end = curve->count - 1; /* steps */
    while (begin < end && !(points[begin + 1].t > edge->t[0]))
        begin++;
    while (end > begin && !(points[end - 1].t < edge->t[1]))
        end--;
    uint32_t count = end - begin, places = count < GAP_PLACES ? count : GAP_PLACES;
    t[0] = edge->t[0];
    for (uint32_t k = 0; k < places; k++) {
        const struct join_point *step = &points[begin + (2 * k + 1) * count / (2 * places)];
        t[k + 1] = fmin(fmax((step[0].t + step[1].t) / 2, edge->t[0]), edge->t[1]);
    }
    t[places + 1] = edge->t[1];
    return (int)places + 2;
}

/* The largest gap between a joined edge, the one with more points, and its mate's curve: among some
 * places, and by golden sections beside the one where it is largest, where it may be more than what
 * is known. */
static double largest_gap_along(const struct join *join, const struct face_edge *edge,
                                double known) {
    const struct shell *shell = join->shell;
    const double golden = 0.61803398874989485;
    double t[GAP_PLACES + 2], largest = 0, from = shell->edges[edge->mate].t[edge->reversed];
    int count = spread_places(join, edge, t), at = 0;
    double beside = from;
    for (int k = 0; k < count; k++) {
        double gap = gap_to_mate(shell, edge, t[k], &from);
        if (gap > largest) {
            largest = gap;
            at = k;
            beside = from;
        }
    }
    double low = t[at > 0 ? at - 1 : 0], high = t[at + 1 < count ? at + 1 : at];
    for (int k = 0; k < GAP_SECTIONS && largest > known / GAP_RISE; k++) {
        double by = golden * (high - low), start[2] = {beside, beside};
        double gap[2] = {gap_to_mate(shell, edge, high - by, &start[0]),
                         gap_to_mate(shell, edge, low + by, &start[1])};
        largest = fmax(largest, fmax(gap[0], gap[1]));
        if (gap[0] > gap[1])
            high = low + by;
        else
            low = high - by;
    }
    return largest;
}

static void join_pair(struct join *join, int32_t edge, const struct mates *mates) {
    struct shell *shell = join->shell;
    struct face_edge *first = &shell->edges[edge], *second = &shell->edges[mates->found[0]];
    double *largest = &shell->found.largest_gap;
    first->mate = mates->found[0];
    second->mate = edge;
    first->reversed = second->reversed = mates->reversed[0];
    shell->found.joined++;
    const struct face_edge *finer =
        shell->curves[second->curve].count > shell->curves[first->curve].count ? second : first;
    *largest = fmax(*largest, largest_gap_along(join, finer, *largest));
}

/* Joins an edge to its mate, if there is one. */
static enum status join_edge(struct join *join, int32_t number, struct shell_fault *fault) {
    struct mates mates;
    struct shell *shell = join->shell;
    struct face_edge *edge = &shell->edges[number];
    find_mates(join, edge, &mates);
    /* More than two faces meet there, or two that turn back on each other. */
    while ((mates.count > 1 || (mates.count == 1 && turn_back(shell, number, mates.found[0]))) &&
           !edge->bare && leave_duplicate_out(join, number, &mates))
        find_mates(join, edge, &mates);
    choose_mate(shell, number, &mates);
    bool alone = mates.count == 1 && turn_back(shell, number, mates.found[0]);
    if (edge->bare || mates.count == 0 || alone)
        return STATUS_OK;
    if (mates.count == 1 && shell->edges[mates.found[0]].mate != EDGE_FREE)
        mates.found[mates.count++] = shell->edges[mates.found[0]].mate;
    if (mates.count > 1 && !shell->lenient) {
        int32_t face[3] = {edge_face(shell, (size_t)number),
                           edge_face(shell, (size_t)mates.found[0]),
                           edge_face(shell, (size_t)mates.found[1])};
        for (int a = 0; a < 2; a++)
            for (int b = 0; b < 2; b++)
                if (face[b] > face[b + 1]) {
                    int32_t swap = face[b];
                    face[b] = face[b + 1];
                    face[b + 1] = swap;
                }
        if (fault)
            *fault = (struct shell_fault){.kind = SHELL_THREE_FACES,
                                          .face_count = 3,
                                          .face = {face[0], face[1], face[2]},
                                          .at = mates.sample[JOIN_SAMPLES / 2]};
        return STATUS_INVALID;
    }
    if (mates.count == 1) {
        join_pair(join, number, &mates);
        return STATUS_OK;
    }
    bool first = true; /* of all that meet there: the fault is counted once */
    for (int k = 0; k < mates.count; k++)
        first = first && mates.found[k] > number;
    shell->found.faulty += first;
    return STATUS_OK;
}

/* Joins a side of a sliver to the edge that it is nearest to, if that is not joined: else its
 * neighbours have been joined to each other, and it is no boundary any more. */
static void join_sliver(struct join *join, int32_t number) {
    struct mates mates;
    struct shell *shell = join->shell;
    find_mates(join, &shell->edges[number], &mates);
    bool any = mates.count > 0;
    for (int k = mates.count - 1; k >= 0; k--)
        if (shell->edges[mates.found[k]].mate != EDGE_FREE ||
            is_thin_between(shell, number, mates.found[k]) ||
            turn_back(shell, number, mates.found[k]))
            forget_mate(&mates, k);
    keep_nearest(&mates);
    if (mates.count)
        join_pair(join, number, &mates);
    else if (any)
        take_out(shell, &shell->edges[number]);
}

/* Joins the edges; those of slivers last: they take what the others leave. */
static enum status join_all_edges(struct join *join, struct shell_fault *fault) {
    struct shell *shell = join->shell;
    enum status status = STATUS_OK;
    join->edge_of = arena_alloc(join->scratch, shell->curve_count + 1, sizeof *join->edge_of);
    if (!join->edge_of)
        return STATUS_OUT_OF_MEMORY;
    /* the first edge of each curve */
    for (size_t e = shell->edge_count; e > 0; e--)
        join->edge_of[shell->edges[e - 1].curve] = (int32_t)(e - 1);
    join->edge_of[shell->curve_count] = (int32_t)shell->edge_count;
    for (size_t c = shell->curve_count; c > 0; c--) {
        int32_t first = join->edge_of[c - 1];
        bool none =
            first >= (int32_t)shell->edge_count || shell->edges[first].curve != (int32_t)(c - 1);
        if (none)
            join->edge_of[c - 1] = join->edge_of[c];
    }
    for (int slivers = 0; slivers < 2; slivers++)
        for (size_t e = 0; e < shell->edge_count && status == STATUS_OK; e++) {
            const struct face_edge *edge = &shell->edges[e];
            if (edge->bare || edge->mate != EDGE_FREE || is_sliver(shell, (int32_t)e) != slivers)
                continue;
            if (slivers)
                join_sliver(join, (int32_t)e);
            else
                status = join_edge(join, (int32_t)e, fault);
        }
    for (size_t e = 0; e < shell->edge_count; e++)
        shell->found.free += !shell->edges[e].bare && shell->edges[e].mate == EDGE_FREE;
    return status;
}

/* ---- segments ---- */

/* The steps of an edge's curve within it, its own ends put in; counted, and noted where there is
 * room. */
static uint32_t make_segments(const struct join *join, int32_t number, struct face_segment *to) {
    const struct shell *shell = join->shell;
    const struct face_edge *edge = &shell->edges[number];
    const struct face_curve *curve = &shell->curves[edge->curve];
    const struct join_point *points = join->points + curve->first;
    struct join_point from = join_sample(shell, curve, edge->t[0]);
    uint32_t count = 0;
    for (uint32_t k = 0; k < curve->count && from.t < edge->t[1]; k++) {
        if (!(points[k].t > from.t))
            continue;
        struct join_point end =
            points[k].t < edge->t[1] ? points[k] : join_sample(shell, curve, edge->t[1]);
        if (to)
            to[count] = (struct face_segment){.a = {from.uv[0], from.uv[1]},
                                              .b = {end.uv[0], end.uv[1]},
                                              .t = {from.t, end.t},
                                              .r = from.r,
                                              .edge = number};
        count++;
        from = end;
    }
    return count;
}

static enum status gather_segments(struct join *join, struct arena *arena) {
    struct shell *shell = join->shell;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t e = 0; e < shell->edge_count; e++) {
            struct face *face = &shell->faces[edge_face(shell, e)];
            if (!shell->edges[e].bare)
                face->segment_count += make_segments(
                    join, (int32_t)e, pass ? face->segments + face->segment_count : NULL);
        }
        for (size_t k = 0; k < shell->face_count && pass == 0; k++) {
            struct face *face = &shell->faces[k];
            face->segments = arena_alloc(arena, face->segment_count, sizeof *face->segments);
            if (!face->segments)
                return STATUS_OUT_OF_MEMORY;
            face->segment_count = 0;
        }
    }
    return STATUS_OK;
}

enum status faces_join(struct shell *shell, const struct shell_patch *patches, struct arena *arena,
                       struct shell_fault *fault) {
    struct arena *own[3] = {arena_child(arena), arena_child(arena), arena_child(arena)};
    struct join join = {
        .shell = shell, .arena = arena, .scratch = own[0], .pool = {own[1], own[2]}};
    enum status status = STATUS_OUT_OF_MEMORY;
    join.failed = !own[0] || !own[1] || !own[2];
    if (!join.failed)
        join_gather_curves(&join, patches);
    for (size_t c = 0; c < shell->curve_count && !join.failed; c++)
        join_sample_curve(&join, (int32_t)c);
    if (!join.failed)
        status = join_make_boxes(&join, shell->tolerance);
    if (status == STATUS_OK) {
        join_cut_curves(&join);
        status = join.failed ? STATUS_OUT_OF_MEMORY : join_make_edges(&join);
    }
    if (status == STATUS_OK)
        status = join_all_edges(&join, fault);
    if (status == STATUS_OK)
        status = gather_segments(&join, arena);
    for (int k = 0; k < 3; k++)
        if (own[k])
            arena_rewind(own[k], (struct arena_mark){0});
    for (size_t k = 0; k < shell->face_count && status == STATUS_OK; k++) {
        status = face_make_runs(&shell->faces[k], arena);
        if (status == STATUS_OK)
            status = face_make_grid(&shell->faces[k], arena);
    }
    return status;
}
