/* SPDX-License-Identifier: MIT */
#include "shell_slit.h"

#include "solver/surface/boxes.h"
#include "solver/surface/spans.h"
#include <string.h>

/* A way passes a line where it comes as near to it as this share of its length: arcs rise less
 * over their chords, and folds hardly more. */
static const double nearness = 0.5;

/* A piece of a line shorter than this share of the ways has no direction; nor has one between the
 * ends of two faces, which are off their joint by the tolerance of the part. */
static const double least_ribbon = 1e-6, least_bridge = 1e-3;

/* What lies ahead of an end is seen from there within 26 degrees of where the line leads: of the
 * border of a round hole the other side. */
static const double ahead_cosine = 0.9;

/* Ribbons that tell which way a line leaves the shell. */
enum { RIBBONS_AT_END = 4 };

/* A piece of a line, and the directions to its left at both ends, by which it bends. */
struct ribbon {
    struct vec3 from, to;
    struct vec3 left[2];
};

struct shell_slit {
    const struct shell_slit_piece *pieces;
    size_t piece_count;
    struct ribbon *ribbons;
    size_t count;
    struct boxes *boxes;
    double reach; /* points further from all lines are on no side */
};

static void add_ribbon(struct shell_slit *slit, struct vec3 from, struct vec3 to,
                       struct vec3 normal, double least) {
    struct vec3 left = vec3_unit(vec3_cross(normal, vec3_sub(to, from)));
    if (vec3_distance(from, to) > least * slit->reach)
        slit->ribbons[slit->count++] = (struct ribbon){from, to, {left, left}};
}

/* How far a slit goes straight on at an end: at a hole not as far as to the part's other side. */
static double way_beyond(const struct shell_slit_lines *lines, struct vec3 end, struct vec3 along) {
    double way = lines->beyond;
    for (size_t k = 0; k < lines->ahead_count; k++) {
        struct vec3 to = vec3_sub(lines->ahead[k], end);
        double distance = vec3_norm(to);
        if (vec3_dot(to, along) > ahead_cosine * distance)
            way = fmin(way, distance / 2);
    }
    return way;
}

/* Goes straight on where the last ribbons lead, or the first ones come from. */
static void extend(struct shell_slit *slit, const struct shell_slit_lines *lines, bool behind) {
    size_t few = slit->count < RIBBONS_AT_END ? slit->count : RIBBONS_AT_END;
    const struct ribbon *last = &slit->ribbons[behind ? slit->count - 1 : 0];
    const struct ribbon *other = &slit->ribbons[behind ? slit->count - few : few - 1];
    struct vec3 end = behind ? last->to : last->from;
    struct vec3 along = vec3_unit(vec3_sub(end, behind ? other->from : other->to));
    struct vec3 far = vec3_axpy(way_beyond(lines, end, along), along, end), left = last->left[0];
    slit->ribbons[slit->count++] =
        behind ? (struct ribbon){end, far, {left, left}} : (struct ribbon){far, end, {left, left}};
}

enum status shell_slit_make(const struct shell *shell, const struct shell_slit_lines *lines,
                            struct arena *arena, struct shell_slit **made) {
    const struct shell_slit_piece *pieces = lines->pieces;
    size_t room = 2, count = lines->count;
    for (size_t k = 0; k < count; k++)
        room += pieces[k].count;
    struct shell_slit *slit = arena_alloc(arena, 1, sizeof *slit);
    struct ribbon *ribbons = arena_alloc(arena, room, sizeof *ribbons);
    struct box *boxes = arena_alloc(arena, room, sizeof *boxes);
    if (!slit || !ribbons || !boxes)
        return STATUS_OUT_OF_MEMORY;
    *slit = (struct shell_slit){
        .pieces = pieces, .piece_count = count, .ribbons = ribbons, .reach = 2 * lines->reach};
    for (size_t p = 0; p < count; p++) {
        const struct shell_slit_piece *piece = &pieces[p];
        const struct surface *surface = shell_surface(shell, piece->face);
        struct surface_cursor cursor = {0};
        struct surface_jet jet, next;
        surface_jet_at(surface, &cursor, piece->uv[0][0], piece->uv[0][1], &jet);
        if (slit->count > 0) /* over a hole */
            add_ribbon(slit, ribbons[slit->count - 1].to, piece->r[0],
                       vec3_scale(surface->side, vec3_cross(jet.u, jet.v)), least_bridge);
        for (size_t k = 1; k < piece->count; k++, jet = next) {
            surface_jet_at(surface, &cursor, piece->uv[k][0], piece->uv[k][1], &next);
            struct vec3 normal = vec3_add(vec3_unit(vec3_cross(jet.u, jet.v)),
                                          vec3_unit(vec3_cross(next.u, next.v)));
            add_ribbon(slit, piece->r[k - 1], piece->r[k], vec3_scale(surface->side, normal),
                       least_ribbon);
        }
    }
    if (slit->count > 0 && !lines->closed) {
        extend(slit, lines, true);
        extend(slit, lines, false);
        /* The continuation before the first ribbon comes last until they are put in order. */
        struct ribbon first = ribbons[slit->count - 1];
        memmove(ribbons + 1, ribbons, (slit->count - 1) * sizeof *ribbons);
        ribbons[0] = first;
    }
    for (size_t k = !lines->closed; k < slit->count; k++) {
        /* where two meet, as of a circle through both */
        struct ribbon *last = &ribbons[k > 0 ? k - 1 : slit->count - 1], *next = &ribbons[k];
        double a = vec3_distance(last->from, last->to), b = vec3_distance(next->from, next->to);
        last->left[1] = next->left[0] =
            vec3_unit(vec3_axpy(a, next->left[0], vec3_scale(b, last->left[1])));
    }
    for (size_t k = 0; k < slit->count; k++)
        boxes[k] = box_round(ribbons[k].from, ribbons[k].to, 0);
    *made = slit;
    return boxes_make(boxes, slit->count, arena, &slit->boxes);
}

const struct shell_slit_piece *shell_slit_pieces(const struct shell_slit *slit, size_t *count) {
    *count = slit->piece_count;
    return slit->pieces;
}

/* The nearest place of the lines to a point, among the ribbons visited: its distance squared, how
 * far left of it the point is, and the normal of the shell there. */
struct search {
    const struct shell_slit *slit;
    struct vec3 point, normal;
    double distance2, left;
};

static bool visit(void *context, int32_t number) {
    struct search *s = context;
    const struct ribbon *ribbon = &s->slit->ribbons[number];
    struct vec3 along = vec3_sub(ribbon->to, ribbon->from), to = vec3_sub(s->point, ribbon->from);
    double share = vec3_dot(to, along) / vec3_norm2(along);
    share = share < 0 ? 0 : share > 1 ? 1 : share;
    struct vec3 off = vec3_axpy(-share, along, to);
    double distance2 = vec3_norm2(off);
    if (!(distance2 < s->distance2))
        return true;
    /* by how much the cubic at right angles to `left` at both ends is left of its chord */
    double bulge =
        share * (1 - share) *
        (share * vec3_dot(along, ribbon->left[1]) - (1 - share) * vec3_dot(along, ribbon->left[0]));
    struct vec3 turn = vec3_sub(ribbon->left[1], ribbon->left[0]);
    struct vec3 left = vec3_axpy(share, turn, ribbon->left[0]);
    s->distance2 = distance2;
    s->left = vec3_dot(off, left) - bulge;
    s->normal = vec3_cross(along, left);
    return true;
}

/* A function of the point alone, so that whatever way the net goes round a place on a line, it
 * passes the line as often. */
static struct search seek(const struct shell_slit *slit, struct vec3 point) {
    struct search s = {.slit = slit, .point = point, .distance2 = HUGE_VAL};
    struct box box = box_round(point, point, slit->reach);
    boxes_visit(slit->boxes, &box, visit, &s);
    return s;
}

int shell_slit_passes(const struct shell_slit *slit, const struct shell_slit_point *from,
                      const struct shell_slit_point *to) {
    struct search begin = seek(slit, from->r);
    struct vec3 way = vec3_sub(to->r, from->r);
    double margin = nearness * vec3_norm(way);
    if (!(begin.distance2 < HUGE_VAL))
        return 0;
    struct search end = seek(slit, to->r);
    bool begins_left = begin.left >= 0, ends_left = end.left >= 0;
    if (!(end.distance2 < HUGE_VAL) || begins_left == ends_left)
        return 0;
    double share = begin.left / (begin.left - end.left);
    struct search middle = seek(slit, vec3_axpy(share, way, from->r));
    struct vec3 turn = vec3_sub(to->normal, from->normal);
    bool other_skin = vec3_dot(vec3_axpy(share, turn, from->normal), middle.normal) < 0;
    if (!(middle.distance2 <= margin * margin) || other_skin)
        return 0;
    return ends_left ? 1 : -1;
}

bool shell_slits_part(const struct shell_slit *const slit[2], const struct shell_slit_point *from,
                      const struct shell_slit_point *to) {
    return (slit[0] && shell_slit_passes(slit[0], from, to) != 0) ||
           (slit[1] && shell_slit_passes(slit[1], from, to) != 0);
}
