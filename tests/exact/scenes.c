/* SPDX-License-Identifier: MIT */
#include "scenes.h"
#include "tests/check.h"
#include <string.h>

static const double DEG = M_PI / 180;
static const double RIGHT = M_PI / 2;
static const double SPHERE_RADIUS = 50, TORUS_MAJOR = 3, TORUS_MINOR = 1, CONE_SLOPE = 0.6;
/* Half the angle of the one-span charts: as wide as the nets here need. */
static const double REACH = 2.3;

static void place_start(struct scene *scene, double u, double v, double angle_deg, double side) {
    scene->start_uv[0] = u;
    scene->start_uv[1] = v;
    scene->angle_deg = angle_deg;
    scene->side = side;
}

static void make_sphere(struct scene *scene, enum scene_id id) {
    static const double cap[2] = {-0.6, 0.6}, half[2] = {0, 0.7}, low[2] = {-0.7, 0.7};
    const double turn[2] = {-80 * DEG, 80 * DEG}, latitude[2] = {-65 * DEG, 65 * DEG};
    const double full[2] = {0, 360 * DEG}, poles[2] = {-90 * DEG, 90 * DEG};
    if (id == SCENE_SPHERE_PATCH) {
        shape_sphere(&scene->shape, SPHERE_RADIUS, turn, latitude, RIGHT);
        scene->motion = motion_similar(1, vec3_make(1, 2, -1), 0.7, vec3_make(10, -20, 5));
        place_start(scene, 0.5, 0.5, 33, 30);
        scene->by_vector = true;
    } else if (id == SCENE_SPHERE_FULL) {
        shape_sphere(&scene->shape, SPHERE_RADIUS, full, poles, RIGHT);
        place_start(scene, 0.01, 0.55, 15, 30);
    } else if (id == SCENE_SPHERE_EDGE) {
        shape_stereographic(&scene->shape, SPHERE_RADIUS, half, low);
        place_start(scene, 0, 0.05, -40, 30);
        scene->by_point = true;
        scene->one_quadrant = true;
    } else {
        shape_stereographic(&scene->shape, SPHERE_RADIUS, cap, cap);
        place_start(scene, 0.05, -0.08, 20, 30);
        scene->aspect = id == SCENE_SPHERE_UNEQUAL ? 0.6 : 1;
        scene->pre_shear_deg = id == SCENE_SPHERE_SHEARED ? 20 : 0;
    }
}

/* z = (x^2 + b y^2) / 2 */
static void make_quadric(struct scene *scene, enum scene_id id) {
    static const double wide[2] = {-1.5, 1.5}, corner[2] = {0, 1.5}, tall[2] = {-1.9, 1.9};
    static const double knots[] = {-1.1, -0.2, 0.13, 0.9};
    bool mirrored = id == SCENE_PARABOLOID_SMALL;
    double b = id == SCENE_PARABOLOID || mirrored ? 1 : -1;
    const double *x = id == SCENE_SADDLE_CORNER ? corner : wide;
    const double *y = id == SCENE_SADDLE_UNEQUAL ? tall : x;
    shape_quadric(&scene->shape, 1, b, x, y);
    place_start(scene, 0, 0, 0, 1.2);
    scene->one_quadrant = id == SCENE_SADDLE_CORNER;
    scene->aspect = id == SCENE_SADDLE_UNEQUAL ? 1.5 : 1;
    if (id == SCENE_SADDLE_SPLIT) {
        for (int i = 0; i < 4; i++) {
            shape_insert_knot(&scene->shape, 0, knots[i]);
            shape_insert_knot(&scene->shape, 1, -knots[i] / 2);
        }
        scene->motion = motion_similar(10, vec3_make(0, 1, 3), 2.5, vec3_make(3, 4, 50));
        scene->side = 12;
    }
    if (mirrored) {
        scene->motion = motion_stretch(-1e-3, 1e-3, 1e-3);
        scene->side = 1.2e-3;
    }
}

static void make_developable(struct scene *scene, enum scene_id id) {
    static const double square[2] = {-1, 1}, low[2] = {1, -1}, high[2] = {1, 1};
    static const double narrow[2] = {CONE_SLOPE * 1, 1}, wide[2] = {CONE_SLOPE * 3.5, 3.5};
    const double patch[2] = {-100 * DEG, 100 * DEG}, full[2] = {0, 360 * DEG};
    if (id == SCENE_PLANE) {
        shape_plane(&scene->shape, square, square);
        place_start(scene, 0.02, -0.03, 30, 1.2);
    } else if (id == SCENE_CYLINDER || id == SCENE_CYLINDER_FULL) {
        shape_frustum(&scene->shape, id == SCENE_CYLINDER ? patch : full, low, high, RIGHT);
        place_start(scene, id == SCENE_CYLINDER ? 0.5 : 0.02, 0.5, 30, 1.4);
    } else {
        shape_frustum(&scene->shape, id == SCENE_CONE ? patch : full, narrow, wide, RIGHT);
        place_start(scene, id == SCENE_CONE ? 0.5 : 0.97, 0.5, 35, 1.8);
    }
    scene->motion = motion_similar(2, vec3_make(1, 1, 0), -1, vec3_make(-1, 0, 2));
}

static void make_general(struct scene *scene, enum scene_id id) {
    static const double cap[2] = {-0.6, 0.6}, wide[2] = {-1.5, 1.5};
    const double quarter[2] = {0, 90 * DEG}, full[2] = {0, 360 * DEG};
    switch (id) {
    case SCENE_TORUS:
        shape_torus(&scene->shape, TORUS_MAJOR, TORUS_MINOR, quarter, full, RIGHT);
        place_start(scene, 0.45, 0.2, 25, 0.8);
        break;
    case SCENE_TORUS_FULL:
        shape_torus(&scene->shape, TORUS_MAJOR, TORUS_MINOR, full, full, RIGHT);
        place_start(scene, 0.02, 0.97, -50, 0.9);
        break;
    case SCENE_ELLIPSOID:
        shape_stereographic(&scene->shape, 1, cap, cap);
        scene->motion = motion_stretch(1.5, 1, 0.7);
        place_start(scene, 0.1, 0.05, 17, 0.55);
        break;
    case SCENE_SADDLE_OBLIQUE:
        shape_quadric(&scene->shape, 1, -1, wide, wide);
        place_start(scene, 0.1, 0.2, 28, 0.8);
        break;
    case SCENE_BEZIER:
        shape_bezier(&scene->shape);
        place_start(scene, 0.5, 0.5, 10, 0.5);
        break;
    default:
        shape_freeform(&scene->shape);
        place_start(scene, 0.5, 0.5, 20, 0.5);
        break;
    }
}

/* Surfaces of revolution: one span about the longitude (and latitude) of the start, whose middle is
 * the start. All others are analytic as they are, or must stay as they are. */
static void make_smooth(struct scene *scene, enum scene_id id) {
    struct vec3 r = shape_point(&scene->shape, scene->start_uv);
    double turn = atan2(r.y, r.x), rho = hypot(r.x, r.y);
    double up = id <= SCENE_SPHERE_SHEARED ? atan2(r.z, rho) : atan2(r.z, rho - TORUS_MAJOR);
    double turns[2] = {turn - REACH, turn + REACH}, ups[2] = {up - REACH, up + REACH};
    double around[2] = {up - 1.4, up + 1.4}, low[2] = {1, -1}, high[2] = {1, 1};
    double narrow[2] = {CONE_SLOPE * 1, 1}, wide[2] = {CONE_SLOPE * 3.5, 3.5};
    scene->smooth_uv[0] = 0.5;
    scene->smooth_uv[1] = 0.5;
    switch (id) {
    case SCENE_SPHERE_PATCH:
    case SCENE_SPHERE_FULL:
        shape_sphere(&scene->smooth, SPHERE_RADIUS, turns, around, 2 * M_PI);
        break;
    case SCENE_CYLINDER:
    case SCENE_CYLINDER_FULL:
        shape_frustum(&scene->smooth, turns, low, high, 2 * M_PI);
        break;
    case SCENE_CONE:
    case SCENE_CONE_FULL:
        shape_frustum(&scene->smooth, turns, narrow, wide, 2 * M_PI);
        break;
    case SCENE_TORUS:
    case SCENE_TORUS_FULL:
        shape_torus(&scene->smooth, TORUS_MAJOR, TORUS_MINOR, turns, ups, 2 * M_PI);
        break;
    default:
        scene->smooth = scene->shape;
        scene->smooth_uv[0] = scene->start_uv[0];
        scene->smooth_uv[1] = scene->start_uv[1];
        break;
    }
}

/* Across the knots of the C2 surface many small blocks are taken; elsewhere a few of high order. */
static struct reference *refer_general(const struct scene *scene, enum scene_id id) {
    bool analytic = id != SCENE_FREEFORM;
    struct exact_net_setup setup = {
        .shape = &scene->smooth,
        .uv = {scene->smooth_uv[0], scene->smooth_uv[1]},
        .warp = scene->start.warp,
        .weft = scene->start.weft,
        .length = {scene->length[0], scene->length[1]},
        .blocks = analytic ? 3 : 48,
        .order = analytic ? 20 : 8,
    };
    return reference_net(&setup);
}

static struct reference *refer(const struct scene *scene, enum scene_id id) {
    const struct frame *start = &scene->start;
    bool up = id == SCENE_PARABOLOID || id == SCENE_PARABOLOID_SMALL;
    if (id <= SCENE_SPHERE_SHEARED) {
        return reference_sphere(scene->motion.shift, SPHERE_RADIUS, start, scene->length);
    }
    if (id <= SCENE_PARABOLOID_SMALL) {
        return reference_translation(&scene->motion, 1, up ? 1 : -1);
    }
    switch (id) {
    case SCENE_PLANE:
        return reference_plane(start);
    case SCENE_CYLINDER:
    case SCENE_CYLINDER_FULL:
        return reference_cylinder(&scene->motion, 1, start);
    case SCENE_CONE:
    case SCENE_CONE_FULL:
        return reference_cone(&scene->motion, atan(CONE_SLOPE), start);
    default:
        return refer_general(scene, id);
    }
}

void scene_make(struct scene *scene, enum scene_id id) {
    static const char *const names[] = {
#define X(id, name) name,
        SCENE_LIST(X)
#undef X
    };
    memset(scene, 0, sizeof *scene);
    scene->id = id;
    scene->name = names[id];
    scene->motion = motion_identity();
    scene->aspect = 1;
    if (id <= SCENE_SPHERE_SHEARED) {
        make_sphere(scene, id);
    } else if (id <= SCENE_PARABOLOID_SMALL) {
        make_quadric(scene, id);
    } else if (id <= SCENE_CONE_FULL) {
        make_developable(scene, id);
    } else {
        make_general(scene, id);
    }
    make_smooth(scene, id);
    shape_move(&scene->shape, &scene->motion);
    shape_move(&scene->smooth, &scene->motion);
    scene->length[0] = scene->side;
    scene->length[1] = scene->side * scene->aspect;
    scene->start.r = shape_point(&scene->shape, scene->start_uv);
    shape_frame(&scene->shape, scene->start_uv, scene->angle_deg, scene->pre_shear_deg,
                &scene->start.warp, &scene->start.weft);
}

const struct reference *scene_reference(struct scene *scene) {
    if (!scene->reference) {
        scene->reference = refer(scene, scene->id);
    }
    return scene->reference;
}

void scene_free(struct scene *scene) {
    reference_free(scene->reference);
    scene->reference = NULL;
}

struct drape_settings scene_settings(const struct scene *scene, enum drape_method method, int n) {
    int low = scene->one_quadrant ? 0 : -n;
    struct drape_settings settings = {
        .method = method,
        .spacing = {scene->length[0] / n, scene->length[1] / n},
        .start_kind = scene->by_point ? DRAPE_START_POINT : DRAPE_START_UV,
        .start_uv = {scene->start_uv[0], scene->start_uv[1]},
        .start_point = scene->start.r,
        .direction_kind = scene->by_vector ? DRAPE_DIRECTION_VECTOR : DRAPE_DIRECTION_ANGLE,
        .direction_deg = scene->angle_deg,
        .direction_vector = scene->start.warp,
        .pre_shear_deg = scene->pre_shear_deg,
        .has_extent = {true, true},
        .extent = {{low, n}, {low, n}},
        .max_nodes = 1000000,
    };
    return settings;
}
