/* SPDX-License-Identifier: MIT */
#include "element_frame.h"

#include "solver/angle.h"

/* A direction nearer to the normal than this, as a sine, has no projection to speak of. */
static const double sine_min = 1e-6;

struct vec3 element_middle(const struct vec3 *vertices, const int32_t corners[4]) {
    struct vec3 sum = {0, 0, 0};
    int count = element_corner_count(corners);
    for (int k = 0; k < count; k++)
        sum = vec3_add(sum, vertices[corners[k]]);
    return vec3_scale(1.0 / count, sum);
}

/* v - (v . n) n, made unit; false when next to nothing is left of it. */
static bool project_on_plane(struct vec3 v, struct vec3 normal, struct vec3 *projected) {
    struct vec3 unit = vec3_unit(v), flat = vec3_axpy(-vec3_dot(unit, normal), normal, unit);
    *projected = vec3_unit(flat);
    return vec3_norm(flat) > sine_min;
}

enum element_fault element_frame_make(const struct vec3 *vertices, const int32_t corners[4],
                                      const struct vec3 *reference, struct element_frame *frame) {
    const struct vec3 p = vertices[corners[0]];
    struct vec3 edge = vec3_sub(vertices[corners[1]], p), one = edge;
    struct vec3 other = vec3_sub(vertices[corners[2]], p);
    if (corners[3] >= 0) {
        one = other;
        other = vec3_sub(vertices[corners[3]], vertices[corners[1]]);
    }
    struct vec3 area = vec3_cross(one, other);
    *frame = (struct element_frame){.normal = vec3_unit(area)};
    if (!(vec3_norm(area) > sine_min * vec3_norm(one) * vec3_norm(other)) ||
        !project_on_plane(edge, frame->normal, &frame->reference))
        return ELEMENT_FLAT;
    frame->across = vec3_cross(frame->normal, frame->reference);
    if (!reference)
        return ELEMENT_SOUND;
    frame->edge_deg = element_angle_deg(frame, *reference);
    if (!project_on_plane(*reference, frame->normal, &frame->reference))
        return ELEMENT_PERPENDICULAR;
    frame->across = vec3_cross(frame->normal, frame->reference);
    return ELEMENT_SOUND;
}

double element_angle_deg(const struct element_frame *frame, struct vec3 direction) {
    return angle_atan2_deg(vec3_dot(frame->across, direction),
                           vec3_dot(frame->reference, direction));
}

struct vec3 element_direction(const struct element_frame *frame, double angle_deg) {
    double sine, cosine;
    angle_sincos_deg(angle_deg, &sine, &cosine);
    return vec3_axpy(sine, frame->across, vec3_scale(cosine, frame->reference));
}

void element_lay(const struct element_frame *frame, struct vec3 warp, struct vec3 weft,
                 struct map_ply_row *row) {
    row->angle_deg = element_angle_deg(frame, warp);
    row->mirrored = vec3_dot(frame->normal, vec3_cross(warp, weft)) < 0;
}

double element_weft_deg(const struct map_ply_row *row) {
    double between = 90 - row->shear_deg;
    return row->mirrored ? row->angle_deg - between : row->angle_deg + between;
}

double element_fold_deg(double angle_deg) {
    while (angle_deg > 90)
        angle_deg -= 180;
    while (angle_deg <= -90)
        angle_deg += 180;
    return angle_deg;
}

int element_edge_compare(const void *x, const void *y) {
    const struct element_edge *p = x, *q = y;
    return p->a != q->a ? (p->a > q->a) - (p->a < q->a) : (p->b > q->b) - (p->b < q->b);
}
