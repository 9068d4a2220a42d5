/* SPDX-License-Identifier: MIT */
#include "shell_cut.h"

#include "solver/surface/boxes.h"
#include "solver/surface/spans.h"
#include <string.h>

/* A way passes a line where it comes as near to it as this share of its length: arcs rise less
 * over their chords, and folds hardly more. */
static const double nearness = 0.5;

/* A piece of a line shorter than this share of the ways, such as rounding leaves between faces, has
 * no direction. */
static const double least_ribbon = 1e-6;

/* Ribbons that tell which way a line leaves the shell. */
enum { RIBBONS_AT_END = 4 };

/* A straight piece of a line, and the directions to its left at both ends. */
struct ribbon {
    struct vec3 from, to;
    struct vec3 left[2];
};

struct shell_cut {
    const struct shell_cut_part *parts;
    size_t part_count;
    struct ribbon *ribbons;
    size_t count;
    struct boxes *boxes;
    double reach; /* points further from all lines are on no side */
};

/* The left of a piece between two places, by the normals there. */
static struct vec3 left_of(struct vec3 from, struct vec3 to, struct vec3 normal) {
    return vec3_unit(vec3_cross(normal, vec3_sub(to, from)));
}

static void add_ribbon(struct shell_cut *cut, struct vec3 from, struct vec3 to,
                       struct vec3 normal) {
    struct vec3 left = left_of(from, to, normal);
    if (vec3_distance(from, to) > least_ribbon * cut->reach)
        cut->ribbons[cut->count++] = (struct ribbon){from, to, {left, left}};
}

/* Goes straight on by a length where the last ribbons lead, or the first ones come from. */
static void extend(struct shell_cut *cut, double beyond, bool behind) {
    size_t few = cut->count < RIBBONS_AT_END ? cut->count : RIBBONS_AT_END;
    const struct ribbon *last = &cut->ribbons[behind ? cut->count - 1 : 0];
    const struct ribbon *other = &cut->ribbons[behind ? cut->count - few : few - 1];
    struct vec3 end = behind ? last->to : last->from;
    struct vec3 along = vec3_unit(vec3_sub(end, behind ? other->from : other->to));
    struct vec3 far = vec3_axpy(beyond, along, end), left = last->left[0];
    cut->ribbons[cut->count++] =
        behind ? (struct ribbon){end, far, {left, left}} : (struct ribbon){far, end, {left, left}};
}

/* Where two pieces meet left is the mean of theirs. */
static void smooth(struct shell_cut *cut) {
    for (size_t k = 1; k < cut->count; k++) {
        struct ribbon *last = &cut->ribbons[k - 1], *next = &cut->ribbons[k];
        struct vec3 mean = vec3_unit(vec3_add(last->left[1], next->left[0]));
        last->left[1] = next->left[0] = mean;
    }
}

static void add_part(struct shell_cut *cut, const struct shell *shell,
                     const struct shell_cut_part *part) {
    const struct surface *surface = shell_surface(shell, part->face);
    struct surface_cursor cursor = {0};
    struct surface_jet jet, next;
    surface_jet_at(surface, &cursor, part->uv[0][0], part->uv[0][1], &jet);
    if (cut->count > 0) /* over a hole, or the gap of a joint */
        add_ribbon(cut, cut->ribbons[cut->count - 1].to, jet.r,
                   vec3_scale(surface->side, vec3_cross(jet.u, jet.v)));
    for (size_t k = 1; k < part->count; k++, jet = next) {
        surface_jet_at(surface, &cursor, part->uv[k][0], part->uv[k][1], &next);
        struct vec3 normal =
            vec3_add(vec3_unit(vec3_cross(jet.u, jet.v)), vec3_unit(vec3_cross(next.u, next.v)));
        add_ribbon(cut, jet.r, next.r, vec3_scale(surface->side, normal));
    }
}

/* The continuation before the first ribbon comes last until they are put in order. */
static void extend_both(struct shell_cut *cut, double beyond) {
    extend(cut, beyond, true);
    extend(cut, beyond, false);
    struct ribbon first = cut->ribbons[cut->count - 1];
    memmove(cut->ribbons + 1, cut->ribbons, (cut->count - 1) * sizeof *cut->ribbons);
    cut->ribbons[0] = first;
    smooth(cut);
}

enum status shell_cut_make(const struct shell *shell, const struct shell_cut_part *parts,
                           size_t count, double beyond, double reach, struct arena *arena,
                           struct shell_cut **made) {
    size_t pieces = 2;
    for (size_t k = 0; k < count; k++)
        pieces += parts[k].count;
    struct shell_cut *cut = arena_alloc(arena, 1, sizeof *cut);
    struct ribbon *ribbons = arena_alloc(arena, pieces, sizeof *ribbons);
    struct box *boxes = arena_alloc(arena, pieces, sizeof *boxes);
    if (!cut || !ribbons || !boxes)
        return STATUS_OUT_OF_MEMORY;
    *cut = (struct shell_cut){
        .parts = parts, .part_count = count, .ribbons = ribbons, .reach = 2 * reach};
    for (size_t k = 0; k < count; k++)
        add_part(cut, shell, &parts[k]);
    if (cut->count > 0)
        extend_both(cut, beyond);
    for (size_t k = 0; k < cut->count; k++)
        boxes[k] = box_round(ribbons[k].from, ribbons[k].to, 0);
    *made = cut;
    return boxes_make(boxes, cut->count, arena, &cut->boxes);
}

const struct shell_cut_part *shell_cut_parts(const struct shell_cut *cut, size_t *count) {
    *count = cut->part_count;
    return cut->parts;
}

/* The nearest place of the lines to a point, among the ribbons visited: its distance squared, how
 * far left of it the point is, and the normal of the shell there. */
struct search {
    const struct shell_cut *cut;
    struct vec3 point, normal;
    double distance2, left;
};

static bool visit(void *context, int32_t number) {
    struct search *s = context;
    const struct ribbon *ribbon = &s->cut->ribbons[number];
    struct vec3 along = vec3_sub(ribbon->to, ribbon->from), to = vec3_sub(s->point, ribbon->from);
    double share = vec3_dot(to, along) / vec3_norm2(along);
    share = share < 0 ? 0 : share > 1 ? 1 : share;
    struct vec3 off = vec3_axpy(-share, along, to);
    double distance2 = vec3_norm2(off);
    if (!(distance2 < s->distance2))
        return true;
    struct vec3 turn = vec3_sub(ribbon->left[1], ribbon->left[0]);
    struct vec3 left = vec3_axpy(share, turn, ribbon->left[0]);
    s->distance2 = distance2;
    s->left = vec3_dot(off, left);
    s->normal = vec3_cross(along, left);
    return true;
}

/* A function of the point alone, so that whatever way the net goes round a place on a line, it
 * passes the line as often. */
static struct search seek(const struct shell_cut *cut, struct vec3 point) {
    struct search s = {.cut = cut, .point = point, .distance2 = HUGE_VAL};
    struct box box = box_round(point, point, cut->reach);
    boxes_visit(cut->boxes, &box, visit, &s);
    return s;
}

int shell_cut_passes(const struct shell_cut *cut, const struct shell_cut_place *from,
                     const struct shell_cut_place *to) {
    struct search begin = seek(cut, from->r);
    struct vec3 way = vec3_sub(to->r, from->r);
    double margin = nearness * vec3_norm(way);
    if (!(begin.distance2 < HUGE_VAL))
        return 0;
    struct search end = seek(cut, to->r);
    bool begins_left = begin.left >= 0, ends_left = end.left >= 0;
    if (!(end.distance2 < HUGE_VAL) || begins_left == ends_left)
        return 0;
    double share = begin.left / (begin.left - end.left);
    struct search middle = seek(cut, vec3_axpy(share, way, from->r));
    struct vec3 turn = vec3_sub(to->normal, from->normal);
    bool other_skin = vec3_dot(vec3_axpy(share, turn, from->normal), middle.normal) < 0;
    if (!(middle.distance2 <= margin * margin) || other_skin)
        return 0;
    return ends_left ? 1 : -1;
}
