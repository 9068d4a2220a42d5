/* SPDX-License-Identifier: MIT */
#include "profile.h"

#include <string.h>

const struct profile_method profile_methods[PROFILE_METHODS] = {
    {"geodesic", DRAPE_GEODESIC, 1e-8},
    {"gib", DRAPE_GIB, 1e-4},
    {"gib4", DRAPE_GIB4, 1e-4},
};

const struct profile_method profile_basic = {"basic", DRAPE_BASIC, 1e-4};

/* Nodes nearer than this to the rim may be missing: rounding. */
static const double RIM = 1e-6;

static double radians(double degrees) {
    return degrees * M_PI / 180;
}

static double fillet_length(const struct profile_part *part) {
    return part->radius * fabs(radians(part->turn_deg));
}

/* Where the profile goes, in the plane (x, z). */
struct pen {
    double x, z, angle;
};

static struct pen pen_forward(struct pen pen, double length) {
    pen.x += length * cos(pen.angle);
    pen.z += length * sin(pen.angle);
    return pen;
}

/* Along an arc of signed angle `turn`: its chord lies half way between the tangents. */
static struct pen pen_turn(struct pen pen, double radius, double turn) {
    pen.angle += turn / 2;
    pen = pen_forward(pen, 2 * radius * fabs(sin(turn / 2)));
    pen.angle += turn / 2;
    return pen;
}

static void add_point(struct shape *shape, struct pen pen, double width, double weight) {
    for (int side = 0; side < 2; side++) {
        double h[4] = {weight * pen.x, weight * width * side, weight * pen.z, weight};
        memcpy(shape->h[2 * shape->size[0] + side], h, sizeof h);
    }
    shape->size[0]++;
}

/* A piece by its middle and last control point, and the knot at its end. */
static void add_piece(struct profile_sheet *sheet, struct pen middle, double weight, struct pen end,
                      double length) {
    struct shape *shape = &sheet->shape;
    add_point(shape, middle, sheet->width, weight);
    add_point(shape, end, sheet->width, 1);
    sheet->total += length;
    shape->knots[0][shape->size[0]] = shape->knots[0][shape->size[0] + 1] = sheet->total;
}

void profile_make(struct profile_sheet *sheet, const struct profile_part *parts, int count,
                  double width) {
    struct pen pen = {0, 0, 0};
    struct shape *shape = &sheet->shape;
    *sheet = (struct profile_sheet){.parts = parts, .count = count, .width = width};
    *shape = (struct shape){.degree = {2, 1}, .size = {0, 2}, .knots[1] = {0, 0, width, width}};
    add_point(shape, pen, width, 1);
    for (int k = 0; k < count; k++) {
        double turn = radians(parts[k].turn_deg), half = turn / 2;
        if (parts[k].radius > 0) {
            struct pen middle = pen_forward(pen, parts[k].radius * fabs(tan(half)));
            pen = pen_turn(pen, parts[k].radius, turn);
            add_piece(sheet, middle, cos(half), pen, fillet_length(&parts[k]));
        } else {
            pen.angle += turn;
        }
        struct pen end = pen_forward(pen, parts[k].length);
        add_piece(sheet, pen_forward(pen, parts[k].length / 2), 1, end, parts[k].length);
        pen = end;
    }
    shape->knots[0][shape->size[0] + 2] = sheet->total;
}

void profile_carry(const struct profile_sheet *sheet, const double along[3][2],
                   struct shape *shape) {
    *shape = sheet->shape;
    shape->degree[1] = 2;
    shape->size[1] = 3;
    for (int k = 0; k < 6; k++) {
        shape->knots[1][k] = k / 3;
    }
    for (int i = 0; i < shape->size[0]; i++) {
        for (int j = 0; j < 3; j++) {
            const double *of = sheet->shape.h[2 * i];
            double h[4] = {of[0], of[3] * along[j][0], of[2] + of[3] * along[j][1], of[3]};
            memcpy(shape->h[3 * i + j], h, sizeof h);
        }
    }
}

struct vec3 profile_point(const struct profile_sheet *sheet, double s, double t,
                          struct vec3 *tangent) {
    struct pen pen = {0, 0, 0};
    for (int k = 0; k < sheet->count; k++) {
        const struct profile_part *part = &sheet->parts[k];
        double arc = fillet_length(part), turn = radians(part->turn_deg);
        double share = part->radius > 0 ? fmin(s / arc, 1) : 1;
        if (part->radius > 0) {
            pen = pen_turn(pen, part->radius, turn * share);
        } else {
            pen.angle += turn;
        }
        s -= arc;
        if (share < 1) {
            break;
        }
        bool last = k == sheet->count - 1 || s < part->length;
        pen = pen_forward(pen, last ? s : part->length);
        s -= part->length;
        if (last) {
            break;
        }
    }
    if (tangent) {
        *tangent = vec3_make(cos(pen.angle), 0, sin(pen.angle));
    }
    return vec3_make(pen.x, t, pen.z);
}

void profile_drape(struct profile_sheet *sheet, enum drape_method method, double d,
                   const double start[2], double angle_deg, struct drape_run *run) {
    struct vec3 along;
    double a = radians(angle_deg);
    struct drape_settings settings = {.method = method,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_UV,
                                      .direction_kind = DRAPE_DIRECTION_VECTOR,
                                      .max_nodes = 1000000};
    (void)profile_point(sheet, start[0], start[1], &along);
    settings.direction_vector = vec3_add(vec3_scale(cos(a), along), vec3_make(0, sin(a), 0));
    /* The parameter of an arc is not its length: the start lies on a straight piece or a fold. */
    settings.start_uv[0] = start[0];
    settings.start_uv[1] = start[1];
    drape_begin(run, &sheet->shape, &settings);
}

static double largest(const double *column, size_t count) {
    double most = 0;
    for (size_t k = 0; k < count; k++) {
        most = fmax(most, fabs(column[k]));
    }
    return most;
}

struct profile_error profile_measure(const struct profile_sheet *sheet, double d,
                                     const double start[2], double angle_deg,
                                     const struct drape_run *run) {
    const struct drape_nodes *nodes = &run->result.nodes;
    double c = d * cos(radians(angle_deg)), s = d * sin(radians(angle_deg));
    int reach = (int)((sheet->total + sheet->width) / d) + 1;
    struct profile_error error = {.node_shear_deg = largest(nodes->shear_deg, nodes->count),
                                  .cell_shear_deg =
                                      largest(run->result.cells.shear_deg, run->result.cells.count),
                                  .most_shear_deg = run->result.summary.max_shear_deg};
    for (int j = -reach; j <= reach; j++) {
        for (int i = -reach; i <= reach; i++) {
            double x = start[0] + c * i - s * j, y = start[1] + s * i + c * j;
            int at = grid_find(&run->grid, i, j);
            if (x < RIM || y < RIM || x > sheet->total - RIM || y > sheet->width - RIM) {
                continue;
            }
            error.missing += at < 0;
            struct vec3 exact = profile_point(sheet, x, y, NULL);
            if (at >= 0) {
                error.position =
                    fmax(error.position, vec3_distance(exact, node_point(nodes, at)) / d);
            }
        }
    }
    return error;
}
