/* SPDX-License-Identifier: MIT */
/*
 * Writes the cases of the open benchmark: make_cases FOLDER BLADE, FOLDER having one folder for
 * each case, BLADE the mould of tests/validation. A case is a surface (surface.json and surface.stl
 * are written here, surface.step by make_steps), a task (task.json) and the exact net (net.csv). No
 * net is the solver's: they are closed forms where there are any, elsewhere the net's equation
 * integrated (`goursat.h`). The error in task.json is the largest distance to the same net by
 * another way: integrated, where there is a closed form, else with other blocks and orders.
 */
#include "tests/exact/profile.h"
#include "tests/exact/reference.h"
#include <assert.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double DEG = M_PI / 180, RIGHT = M_PI / 2;
/* Rounding of the closed forms, relative to the size of the net: no error is said to be less. */
static const double ROUNDING = 1e-12;
/* Half the angle of a chart of one span about the start of a surface of revolution. */
static const double REACH = 2.3;

struct task {
    const char *name, *title, *unit, *geometry, *exact;
    const char *faceted;        /* what the geometry's own error is of; NULL: it has none */
    struct shape shape, smooth; /* the surface, and the same in an analytic chart about the start */
    double uv[2], smooth_uv[2], angle_deg, pre_shear_deg, spacing;
    int warp[2], weft[2]; /* the extent, in cells */
    struct frame start;
    struct reference *net, *other; /* none for a sheet */
    const struct profile_sheet *sheet;
    double sheet_start[2], error, geometry_error;
};

/* A node: on an unrolled sheet the square grid. */
static struct exact_net_point node_at(const struct task *task, const struct reference *net, int i,
                                      int j) {
    struct exact_net_point point = {.shear_deg = 0};
    double s = i * task->spacing, t = j * task->spacing;
    if (task->sheet) {
        double c = cos(task->angle_deg * DEG), d = sin(task->angle_deg * DEG);
        point.r = profile_point(task->sheet, task->sheet_start[0] + s * c - t * d,
                                task->sheet_start[1] + s * d + t * c, NULL);
    } else {
        reference_at(net, s, t, &point);
    }
    return point;
}

static void place_start(struct task *task, double u, double v, double angle_deg) {
    task->uv[0] = u;
    task->uv[1] = v;
    task->angle_deg = angle_deg;
    task->smooth = task->shape;
    memcpy(task->smooth_uv, task->uv, sizeof task->uv);
}

static void take_net(struct task *task, double spacing, int cells) {
    task->spacing = spacing;
    task->warp[0] = task->weft[0] = -cells;
    task->warp[1] = task->weft[1] = cells;
    task->start.r = shape_point(&task->shape, task->uv);
    shape_frame(&task->shape, task->uv, task->angle_deg, task->pre_shear_deg, &task->start.warp,
                &task->start.weft);
}

static struct reference *integrate(const struct task *task, int blocks, int order) {
    struct exact_net_setup setup = {
        .shape = &task->smooth,
        .uv = {task->smooth_uv[0], task->smooth_uv[1]},
        .warp = task->start.warp,
        .weft = task->start.weft,
        .length = {task->warp[1] * task->spacing, task->weft[1] * task->spacing},
        .blocks = blocks,
        .order = order,
        .one_quadrant = task->warp[0] == 0,
    };
    return reference_net(&setup);
}

static void make_cylinder(struct task *task) {
    const double turn[2] = {-100 * DEG, 100 * DEG}, low[2] = {60, -120}, high[2] = {60, 120};
    struct motion none = motion_identity();
    task->title = "Half a cylinder of radius 60 mm, warp at 30 degrees";
    task->geometry = "surface.step";
    task->exact = "a square grid on the unrolled cylinder";
    shape_frustum(&task->shape, turn, low, high, RIGHT);
    place_start(task, 0.5, 0.5, 30);
    shape_frustum(&task->smooth, turn, low, high, 2 * M_PI);
    take_net(task, 3.5, 20);
    task->net = reference_cylinder(&none, 60, &task->start);
    task->other = integrate(task, 3, 20);
}

static void make_cone(struct task *task) {
    const double turn[2] = {-100 * DEG, 100 * DEG}, low[2] = {36, 60}, high[2] = {126, 210};
    struct motion none = motion_identity();
    task->title = "A cone, 36 to 126 mm in radius, warp at 35 degrees";
    task->geometry = "surface.step";
    task->exact = "a square grid on the unrolled cone";
    shape_frustum(&task->shape, turn, low, high, RIGHT);
    place_start(task, 0.5, 0.5, 35);
    shape_frustum(&task->smooth, turn, low, high, 2 * M_PI);
    take_net(task, 3, 20);
    task->net = reference_cone(&none, atan(0.6), &task->start);
    task->other = integrate(task, 3, 20);
}

static void lay_sheet(struct task *task, const struct profile_sheet *sheet) {
    double a = task->angle_deg * DEG;
    struct vec3 along, across = vec3_make(0, 1, 0);
    task->sheet = sheet;
    task->sheet_start[0] = sheet->total / 2;
    task->sheet_start[1] = sheet->width / 2;
    task->start.r = profile_point(sheet, task->sheet_start[0], task->sheet_start[1], &along);
    task->start.warp = vec3_axpy(cos(a), along, vec3_scale(sin(a), across));
    task->start.weft = vec3_axpy(-sin(a), along, vec3_scale(cos(a), across));
}

static void make_hat(struct task *task) {
    static const struct profile_part parts[] = {
        {0, 0, 60}, {12, 70, 40}, {12, -70, 80}, {12, -70, 40}, {12, 70, 60}};
    static struct profile_sheet sheet;
    profile_make(&sheet, parts, 5, 240);
    task->title = "A hat profile with fillets of 12 mm, nine faces, warp at 45 degrees";
    task->geometry = "surface.step";
    task->exact = "a square grid on the unrolled sheet";
    task->shape = sheet.shape;
    task->angle_deg = 45;
    take_net(task, 4, 20);
    lay_sheet(task, &sheet);
}

static void make_folds(struct task *task) {
    static const struct profile_part parts[] = {{0, 0, 90}, {0, 40, 60}, {0, -75, 60}, {0, 50, 70}};
    static struct profile_sheet sheet;
    profile_make(&sheet, parts, 4, 280);
    task->title = "A sheet with three sharp folds, warp at 25 degrees";
    task->geometry = "surface.stl";
    task->exact = "a square grid on the unrolled sheet";
    task->shape = sheet.shape;
    task->angle_deg = 25;
    take_net(task, 5, 20);
    lay_sheet(task, &sheet);
}

static void make_torus(struct task *task) {
    const double quarter[2] = {0, 90 * DEG}, full[2] = {0, 360 * DEG};
    task->title = "A quarter of a torus, 90 and 30 mm in radius, warp at 25 degrees";
    task->geometry = "surface.step";
    task->exact = "the equation of the net, integrated";
    shape_torus(&task->shape, 90, 30, quarter, full, RIGHT);
    place_start(task, 0.45, 0.2, 25);
    struct vec3 r = shape_point(&task->shape, task->uv);
    double turn = atan2(r.y, r.x), up = atan2(r.z, hypot(r.x, r.y) - 90);
    double turns[2] = {turn - REACH, turn + REACH}, ups[2] = {up - REACH, up + REACH};
    shape_torus(&task->smooth, 90, 30, turns, ups, 2 * M_PI);
    task->smooth_uv[0] = task->smooth_uv[1] = 0.5;
    take_net(task, 1.5, 20);
    task->net = integrate(task, 3, 20);
    task->other = integrate(task, 4, 16);
}

static void make_sphere(struct task *task, double reach, double spacing, int cells) {
    const double range[2] = {-reach, reach};
    shape_stereographic(&task->shape, 50, range, range);
    place_start(task, task->uv[0], task->uv[1], task->angle_deg);
    take_net(task, spacing, cells);
    task->exact = "Chebyshev's equation of the yarns' angle, by its series";
    task->net = reference_sphere(vec3_make(0, 0, 0), 50, &task->start,
                                 (double[]){cells * spacing, cells * spacing});
    task->other = integrate(task, 3, 20);
}

static void make_dome(struct task *task) {
    task->title = "A dome of radius 50 mm as triangles, from its top";
    task->geometry = "surface.stl";
    task->faceted = "the sphere that the triangles stand for";
    make_sphere(task, 0.7, 2, 20);
}

static void make_sheared_sphere(struct task *task) {
    task->title = "A sphere of radius 50 mm, away from its top, cloth sheared by 20 degrees before";
    task->geometry = "surface.json";
    task->uv[0] = 0.05;
    task->uv[1] = -0.08;
    task->angle_deg = 20;
    task->pre_shear_deg = 20;
    make_sphere(task, 0.6, 1.5, 20);
}

static void make_saddle(struct task *task) {
    const double wide[2] = {-75, 75};
    struct motion none = motion_identity();
    task->title = "The saddle z = (x^2 - y^2) / 100 mm from its middle";
    task->geometry = "surface.json";
    task->exact = "r(s, t) = a(s) + b(t), a surface of translation";
    shape_quadric(&task->shape, 0.02, -0.02, wide, wide);
    place_start(task, 0, 0, 0);
    take_net(task, 3, 20);
    task->net = reference_translation(&none, 0.02, -0.02);
    task->other = integrate(task, 3, 20);
}

/* The polynomial mould of KinDrape's paper over [0, 0.5]^2 in metres, as a bicubic Bezier patch:
 * its coefficients of x^i y^j, for parameters in [0, 1], and b_i = sum_k binom(i, k) / binom(3, k)
 * a_k in each direction. */
static void make_mould(struct task *task) {
    static const double z[4][4] = {
        {0, 1.089, -3.75, 4.321}, {1.004, -4.4, 0, 0}, {-3.667, 8.889, 0, 0}, {3.086, 0, 0, 0}};
    static const double weight[4][4] = {
        {1, 0, 0, 0}, {1, 1.0 / 3, 0, 0}, {1, 2.0 / 3, 1.0 / 3, 0}, {1, 1, 1, 1}};
    task->title = "The polynomial mould of KinDrape's paper";
    task->unit = "m";
    task->geometry = "surface.json";
    task->exact = "the equation of the net, integrated";
    struct shape *shape = &task->shape;
    *shape = (struct shape){.degree = {3, 3}, .size = {4, 4}};
    for (int k = 0; k < 8; k++)
        shape->knots[0][k] = shape->knots[1][k] = k / 4;
    for (int at = 0; at < 16; at++) {
        double height = 0;
        for (int k = 0; k < 16; k++)
            height += weight[at / 4][k / 4] * weight[at % 4][k % 4] * z[k / 4][k % 4] *
                      pow(0.5, k / 4 + k % 4);
        double h[4] = {at / 4 / 6.0, at % 4 / 6.0, height, 1};
        memcpy(shape->h[at], h, sizeof h);
    }
    place_start(task, 0.5, 0.5, 0);
    take_net(task, 0.01, 20);
    task->net = integrate(task, 3, 20);
    task->other = integrate(task, 4, 16);
}

static void make_rational(struct task *task) {
    struct motion hundred = motion_stretch(100, 100, 100);
    task->title = "A rational bicubic patch, 200 mm wide, warp at 10 degrees";
    task->geometry = "surface.json";
    task->exact = "the equation of the net, integrated";
    shape_bezier(&task->shape);
    shape_move(&task->shape, &hundred);
    place_start(task, 0.5, 0.5, 10);
    take_net(task, 2.5, 20);
    task->net = integrate(task, 3, 20);
    task->other = integrate(task, 4, 16);
}

static void make_freeform(struct task *task) {
    struct motion hundred = motion_stretch(100, 100, 100);
    task->title = "A rational bicubic spline with knots inside, 200 mm wide, warp at 20 degrees";
    task->geometry = "surface.json";
    task->exact = "the equation of the net, integrated in small blocks";
    shape_freeform(&task->shape);
    shape_move(&task->shape, &hundred);
    place_start(task, 0.5, 0.5, 20);
    take_net(task, 2.5, 20);
    task->net = integrate(task, 48, 8);
    task->other = integrate(task, 40, 8);
}

static const char *blade;

static void read_blade(struct shape *shape) {
    json_error_t error;
    json_t *document = json_load_file(blade, 0, &error), *points = NULL;
    const char *const words[2][3] = {{"degree_u", "size_u", "knotvector_u"},
                                     {"degree_v", "size_v", "knotvector_v"}};
    json_t *surface = json_object_get(document, "surface");
    points = json_object_get(json_object_get(surface, "control_points"), "points");
    assert(points);
    for (int k = 0; k < 2; k++) {
        json_t *knots = json_object_get(surface, words[k][2]);
        shape->degree[k] = (int)json_integer_value(json_object_get(surface, words[k][0]));
        shape->size[k] = (int)json_integer_value(json_object_get(surface, words[k][1]));
        assert(shape->size[k] <= SHAPE_SIZE_MAX);
        for (size_t at = 0; at < json_array_size(knots); at++)
            shape->knots[k][at] = json_number_value(json_array_get(knots, at));
    }
    for (size_t at = 0; at < json_array_size(points); at++) {
        for (size_t k = 0; k < 3; k++)
            shape->h[at][k] = json_number_value(json_array_get(json_array_get(points, at), k));
        shape->h[at][3] = 1;
    }
    json_decref(document);
}

/* The course that Abaqus Composites Modeler has draped, from its corner along its first edge. */
static void make_blade(struct task *task) {
    const struct vec3 first = {0.6599, 0.000534018, -0.557122}, next = {0.6599, 0.0129579, -0.5585};
    struct surface_jet jet;
    task->title = "A geodesic course of 4 m by 0.5 m on a blade-like mould";
    task->unit = "m";
    task->geometry = "surface.json";
    task->exact = "the equation of the net, integrated in small blocks";
    read_blade(&task->shape);
    place_start(task, 0.001, 0.999, 0);
    for (int step = 0; step < 20; step++) {
        double duv[2];
        shape_evaluate(&task->shape, task->uv[0], task->uv[1], &jet);
        jet_pull_back(&jet, vec3_sub(first, jet.r), duv);
        task->uv[0] += duv[0];
        task->uv[1] += duv[1];
    }
    memcpy(task->smooth_uv, task->uv, sizeof task->uv);
    struct vec3 normal = jet_normal(&jet), along = vec3_sub(next, first);
    task->spacing = 0.0125;
    task->warp[1] = 320;
    task->weft[1] = 40;
    task->start.r = jet.r;
    task->start.warp = vec3_unit(vec3_axpy(-vec3_dot(along, normal), normal, along));
    task->start.weft = vec3_cross(task->start.warp, normal); /* the course is on that side */
    task->net = integrate(task, 40, 8);
    task->other = integrate(task, 32, 8);
}

static const struct entry {
    const char *name;
    void (*make)(struct task *task);
} entries[] = {{"cylinder", make_cylinder},     {"cone", make_cone},         {"hat", make_hat},
               {"folds", make_folds},           {"torus", make_torus},       {"dome", make_dome},
               {"sphere", make_sheared_sphere}, {"saddle", make_saddle},     {"mould", make_mould},
               {"rational", make_rational},     {"freeform", make_freeform}, {"blade", make_blade}};

static FILE *create(const char *folder, const struct task *task, const char *name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s/%s", folder, task->name, name);
    FILE *file = fopen(path, "wb");
    if (!file) {
        perror(path);
        exit(1);
    }
    return file;
}

static void write_numbers(FILE *file, const char *name, const double *values, int count) {
    fprintf(file, "  \"%s\": [", name);
    for (int k = 0; k < count; k++)
        fprintf(file, "%s%.17g", k ? ", " : "", values[k]);
    fprintf(file, "]");
}

static void write_json(FILE *file, const struct shape *shape) {
    int count = shape->size[0] * shape->size[1];
    fprintf(file, "{\n  \"degree_u\": %d, \"degree_v\": %d, \"size_u\": %d, \"size_v\": %d,\n",
            shape->degree[0], shape->degree[1], shape->size[0], shape->size[1]);
    for (int k = 0; k < 2; k++) {
        write_numbers(file, k ? "knotvector_v" : "knotvector_u", shape->knots[k],
                      shape->size[k] + shape->degree[k] + 1);
        fprintf(file, ",\n");
    }
    fprintf(file, "  \"control_points\": {\n    \"points\": [");
    for (int k = 0; k < count; k++)
        fprintf(file, "%s\n      [%.17g, %.17g, %.17g]", k ? "," : "",
                shape->h[k][0] / shape->h[k][3], shape->h[k][1] / shape->h[k][3],
                shape->h[k][2] / shape->h[k][3]);
    fprintf(file, "],\n    \"weights\": [");
    for (int k = 0; k < count; k++)
        fprintf(file, "%s%.17g", k ? ", " : "", shape->h[k][3]);
    fprintf(file, "]\n  }\n}\n");
}

static void write_triangle(FILE *file, const struct vec3 corner[3]) {
    struct vec3 normal =
        vec3_unit(vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0])));
    float values[12] = {(float)normal.x, (float)normal.y, (float)normal.z};
    for (int k = 0; k < 3; k++) {
        values[3 + 3 * k] = (float)corner[k].x;
        values[4 + 3 * k] = (float)corner[k].y;
        values[5 + 3 * k] = (float)corner[k].z;
    }
    fwrite(values, sizeof *values, 12, file);
    fwrite("\0\0", 1, 2, file);
}

/* Binary STL: m by n pairs of triangles, the first direction cut at the knots of a sheet. Returns
 * how far the middle of a pair is from the surface, at most. */
static double write_stl(FILE *file, const struct task *task) {
    const struct shape *shape = &task->shape;
    int n = task->sheet ? 1 : 64, m = task->sheet ? (shape->size[0] - 1) / 2 : n;
    double lower[2], upper[2], most = 0;
    char header[80] = "a case of the open benchmark of drapes";
    uint32_t count = (uint32_t)(2 * m * n);
    shape_domain(shape, lower, upper);
    fwrite(header, 1, sizeof header, file);
    fwrite(&count, sizeof count, 1, file);
    for (int at = 0; at < m * n; at++) {
        struct vec3 corner[4];
        double middle[2] = {0, 0};
        for (int k = 0; k < 4; k++) {
            int a = at / n + (k == 1 || k == 2), b = at % n + k / 2;
            double uv[2] = {task->sheet ? shape->knots[0][2 + 2 * a]
                                        : lower[0] + (upper[0] - lower[0]) * a / m,
                            lower[1] + (upper[1] - lower[1]) * b / n};
            corner[k] = shape_point(shape, uv);
            middle[0] += uv[0] / 4;
            middle[1] += uv[1] / 4;
        }
        write_triangle(file, corner);
        write_triangle(file, (struct vec3[]){corner[0], corner[2], corner[3]});
        struct vec3 chord = vec3_scale(0.5, vec3_add(corner[0], corner[2]));
        if (!task->sheet)
            most = fmax(most, vec3_distance(chord, shape_point(shape, middle)));
    }
    return most;
}

static bool is_inside(const struct task *task, const struct exact_net_point *point) {
    double lower[2], upper[2];
    shape_domain(&task->shape, lower, upper);
    bool inside = true;
    for (int k = 0; k < 2; k++)
        inside = inside && point->uv[k] >= lower[k] - 1e-9 && point->uv[k] <= upper[k] + 1e-9;
    return inside || task->warp[0] != 0; /* the other nets lie inside as a whole */
}

static int write_net(FILE *file, struct task *task) {
    int count = 0;
    fprintf(file, "i,j,x,y,z,shear_deg\n");
    for (int i = task->warp[0]; i <= task->warp[1]; i++) {
        for (int j = task->weft[0]; j <= task->weft[1]; j++) {
            struct exact_net_point point = node_at(task, task->net, i, j);
            if (!is_inside(task, &point))
                continue;
            if (task->other) {
                struct exact_net_point other = node_at(task, task->other, i, j);
                task->error = fmax(task->error, vec3_distance(point.r, other.r));
            }
            fprintf(file, "%d,%d,%.13g,%.13g,%.13g,%.8g\n", i, j, point.r.x, point.r.y, point.r.z,
                    fabs(point.shear_deg) < 1e-9 ? 0 : point.shear_deg);
            count++;
        }
    }
    double size = task->spacing * (task->warp[1] - task->warp[0]);
    task->error = fmax(task->error, ROUNDING * size);
    return count;
}

static void write_vector(FILE *file, const char *name, struct vec3 a) {
    write_numbers(file, name, (double[]){a.x, a.y, a.z}, 3);
    fprintf(file, ",\n");
}

static void write_task(FILE *file, const struct task *task, int count) {
    bool parameters = strcmp(task->geometry, "surface.json") == 0;
    fprintf(file, "{\n  \"title\": \"%s\",\n  \"geometry\": \"%s\",\n  \"length_unit\": \"%s\",\n",
            task->title, task->geometry, task->unit);
    write_vector(file, "start", task->start.r);
    if (parameters) {
        write_numbers(file, "start_uv", task->uv, 2);
        fprintf(file, ",\n");
    }
    write_vector(file, "warp", task->start.warp);
    write_vector(file, "weft", task->start.weft);
    fprintf(file, "  \"spacing\": %.17g,\n  \"pre_shear_deg\": %.17g,\n", task->spacing,
            task->pre_shear_deg);
    fprintf(file, "  \"fabric\": \"pin-jointed weave, equal spacing\",\n");
    fprintf(file, "  \"generators\": \"geodesics\",\n");
    fprintf(file, "  \"extent\": {\"warp\": [%d, %d], \"weft\": [%d, %d]},\n", task->warp[0],
            task->warp[1], task->weft[0], task->weft[1]);
    fprintf(file,
            "  \"net\": {\"file\": \"net.csv\", \"nodes\": %d, \"by\": \"%s\", \"error\": %.1e",
            count, task->exact, task->error);
    if (task->faceted)
        fprintf(file, ", \"of\": \"%s\", \"geometry_error\": %.1e", task->faceted,
                task->geometry_error);
    fprintf(file, "}\n}\n");
}

int main(int argc, char **argv) {
    static struct task task;
    assert(argc == 3 || argc == 4);
    blade = argv[2];
    for (size_t k = 0; k < sizeof entries / sizeof *entries; k++) {
        if (argc == 4 && strcmp(argv[3], entries[k].name) != 0)
            continue;
        task = (struct task){.name = entries[k].name, .unit = "mm"};
        entries[k].make(&task);
        FILE *net = create(argv[1], &task, "net.csv");
        int count = write_net(net, &task);
        fclose(net);
        if (strcmp(task.geometry, "surface.step") != 0) {
            FILE *geometry = create(argv[1], &task, task.geometry);
            if (strcmp(task.geometry, "surface.json") == 0)
                write_json(geometry, &task.shape);
            else
                task.geometry_error = write_stl(geometry, &task);
            fclose(geometry);
        }
        FILE *file = create(argv[1], &task, "task.json");
        write_task(file, &task, count);
        fclose(file);
        printf("%-10s %6d nodes, error %.1e %s\n", task.name, count, task.error, task.unit);
        reference_free(task.net);
        reference_free(task.other);
    }
    return 0;
}
