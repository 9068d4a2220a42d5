/* SPDX-License-Identifier: MIT */
/* Angles of yarns on elements: of both windings, flipped, warped, long and thin, in mm and in m. */
#include "api/format/element_frame.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <string.h>

static const double deg = 3.14159265358979323846 / 180;

/* v turned about the unit axis by an angle, by Rodrigues' formula. */
static struct vec3 turned(struct vec3 v, struct vec3 axis, double degrees) {
    double c = cos(degrees * deg), s = sin(degrees * deg);
    struct vec3 along = vec3_scale(vec3_dot(v, axis) * (1 - c), axis);
    return vec3_add(vec3_add(vec3_scale(c, v), vec3_scale(s, vec3_cross(axis, v))), along);
}

static struct vec3 random_direction(struct random *random) {
    struct vec3 v;
    do
        v = vec3_make(random_between(random, -1, 1), random_between(random, -1, 1),
                      random_between(random, -1, 1));
    while (vec3_norm(v) < 0.1);
    return vec3_unit(v);
}

/* A plane with two directions, and a convex element in it; `warp` moves its corners off the plane
 * by turns, which leaves the plane of a quadrilateral's diagonals where it is. */
struct scene {
    struct vec3 normal, along, across;
    struct vec3 vertices[4];
    int32_t corners[4];
    bool flipped; /* the corners go round against the normal */
};

static struct scene random_scene(struct random *random, double size, double warp) {
    struct scene scene = {.normal = random_direction(random)};
    bool quad = random_index(random, 2);
    int count = quad ? 4 : 3, turn = random_index(random, 4);
    struct vec3 origin = vec3_scale(10 * size, random_direction(random));
    scene.along = vec3_unit(vec3_cross(scene.normal, random_direction(random)));
    scene.across = vec3_cross(scene.normal, scene.along);
    scene.flipped = random_index(random, 2);
    for (int k = 0; k < 4; k++) {
        double angle = (360.0 / count * k + random_between(random, -20, 20)) * deg;
        double height = quad ? (k % 2 ? warp : -warp) * size : 0;
        scene.vertices[k] = vec3_axpy(size * cos(angle), scene.along,
                                      vec3_axpy(0.3 * size * sin(angle), scene.across,
                                                vec3_axpy(height, scene.normal, origin)));
    }
    for (int k = 0; k < count; k++)
        scene.corners[k] = (turn + (scene.flipped ? count - k : k)) % count;
    if (!quad)
        scene.corners[3] = -1;
    return scene;
}

/* Yarns in the scene's plane, `angle` from its first direction and `shear` apart from square. */
static void random_yarns(const struct scene *scene, struct random *random, struct vec3 *warp,
                         struct vec3 *weft, double *shear) {
    *shear = random_between(random, -60, 60);
    *warp = turned(scene->along, scene->normal, random_between(random, -180, 180));
    *weft = turned(*warp, scene->normal, 90 - *shear);
}

static void check_direction(struct vec3 is, struct vec3 expected) {
    check_at_most(vec3_angle(is, expected) / deg, 1e-6);
}

/* Who knows the element and the angles alone finds both yarns again, turning the first edge about
 * the normal as the page says. */
static void test_element_angles_lead_back_to_the_yarns(void **state) {
    (void)state;
    struct random random = random_begin("angles");
    for (int round = 0; round < 4000; round++) {
        struct scene scene = random_scene(&random, round % 2 ? 1e-3 : 1e3, round % 3 ? 0 : 0.05);
        struct element_frame frame;
        struct map_ply_row row = {0};
        struct vec3 warp, weft, own = random_direction(&random);
        bool given = random_index(&random, 2);
        random_yarns(&scene, &random, &warp, &weft, &row.shear_deg);
        assert_int_equal(
            element_frame_make(scene.vertices, scene.corners, given ? &own : NULL, &frame),
            ELEMENT_SOUND);
        element_lay(&frame, warp, weft, &row);
        assert_int_equal(row.mirrored, scene.flipped);
        struct vec3 normal = scene.flipped ? vec3_scale(-1, scene.normal) : scene.normal;
        struct vec3 edge =
            vec3_sub(scene.vertices[scene.corners[1]], scene.vertices[scene.corners[0]]);
        edge = vec3_unit(vec3_axpy(-vec3_dot(edge, normal), normal, edge));
        struct vec3 reference = turned(edge, normal, frame.edge_deg);
        if (given)
            check_direction(reference, vec3_axpy(-vec3_dot(own, normal), normal, own));
        else
            assert_true(frame.edge_deg == 0);
        check_direction(turned(reference, normal, row.angle_deg), warp);
        check_direction(turned(reference, normal, element_weft_deg(&row)), weft);
        check_direction(element_direction(&frame, row.angle_deg), warp);
    }
}

/* The same cloth seen from the other side: angles change their sign, the yarns stay. */
static void test_element_flipped_sees_angles_of_the_other_sign(void **state) {
    (void)state;
    static const struct vec3 vertices[] = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
    static const int32_t up[] = {0, 1, 2, 3}, down[] = {1, 0, 3, 2};
    struct element_frame frame;
    struct map_ply_row row = {.shear_deg = 20};
    struct vec3 warp = vec3_make(cos(30 * deg), sin(30 * deg), 0);
    struct vec3 weft = vec3_make(cos(100 * deg), sin(100 * deg), 0), axis = {1, 0, 0};
    assert_int_equal(element_frame_make(vertices, up, &axis, &frame), ELEMENT_SOUND);
    element_lay(&frame, warp, weft, &row);
    check_at_most(fabs(row.angle_deg - 30), 1e-12);
    check_at_most(fabs(element_weft_deg(&row) - 100), 1e-12);
    assert_int_equal(element_frame_make(vertices, down, &axis, &frame), ELEMENT_SOUND);
    element_lay(&frame, warp, weft, &row);
    check_at_most(fabs(row.angle_deg + 30), 1e-12);
    check_at_most(fabs(element_weft_deg(&row) + 100), 1e-12);
    check_at_most(fabs(fabs(frame.edge_deg) - 180), 1e-12);
}

static void test_element_without_a_direction_is_told(void **state) {
    (void)state;
    static const struct vec3 vertices[] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {0, 0, 0}};
    static const int32_t line[] = {0, 1, 2, -1}, fold[] = {0, 1, 4, -1}, sound[] = {0, 1, 3, -1};
    static const int32_t first[] = {0, 4, 1, 3}; /* its first edge is a point */
    struct element_frame frame;
    struct vec3 up = {0, 0, -3};
    assert_int_equal(element_frame_make(vertices, line, NULL, &frame), ELEMENT_FLAT);
    assert_int_equal(element_frame_make(vertices, fold, NULL, &frame), ELEMENT_FLAT);
    assert_int_equal(element_frame_make(vertices, first, NULL, &frame), ELEMENT_FLAT);
    assert_int_equal(element_frame_make(vertices, sound, &up, &frame), ELEMENT_PERPENDICULAR);
    assert_int_equal(element_frame_make(vertices, sound, NULL, &frame), ELEMENT_SOUND);
}

/* Sides that are next to parallel span no plane, and what is next to the normal has no direction in
 * it: by less than a millionth. */
static void test_element_limits_are_a_millionth(void **state) {
    static const int32_t corners[] = {0, 1, 2, -1};
    static const struct {
        double sine;
        enum element_fault thin, steep;
    } rows[] = {{0.9e-6, ELEMENT_FLAT, ELEMENT_PERPENDICULAR},
                {1.1e-6, ELEMENT_SOUND, ELEMENT_SOUND}};
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        struct element_frame frame;
        const struct vec3 thin[] = {{0, 0, 0}, {1, 0, 0}, {1, rows[k].sine, 0}};
        const struct vec3 square[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        const struct vec3 steep = {rows[k].sine, 0, 1};
        assert_int_equal(element_frame_make(thin, corners, NULL, &frame), rows[k].thin);
        assert_int_equal(element_frame_make(square, corners, &steep, &frame), rows[k].steep);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_element_angles_lead_back_to_the_yarns),
        cmocka_unit_test(test_element_flipped_sees_angles_of_the_other_sign),
        cmocka_unit_test(test_element_without_a_direction_is_told),
        cmocka_unit_test(test_element_limits_are_a_millionth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
