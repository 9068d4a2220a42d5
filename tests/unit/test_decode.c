/* SPDX-License-Identifier: MIT */
#include "api/request/decode.h"

#include "api/request/material.h"
#include "api/request/normalise.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define KNOTS "\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1]"
#define SIZES "\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2"
#define POINTS "[[0,0,0],[0,1,0],[1,0,0],[1,1,0.5]]"
#define PATCH "{" SIZES "," KNOTS ",\"control_points\":{\"points\":" POINTS "}}"

/* One decoded request and where it lies. */
struct decoded {
    struct arena *arena;
    struct api_request request;
    struct api_problem problem;
};

static int begin(void **state) {
    struct decoded *decoded = calloc(1, sizeof *decoded);
    assert_non_null(decoded);
    decoded->arena = arena_new((size_t)1 << 30);
    *state = decoded;
    return 0;
}

static int end(void **state) {
    struct decoded *decoded = *state;
    arena_free(decoded->arena);
    free(decoded);
    return 0;
}

/* Decodes a request with this surface and, between the braces, these other members. */
static void decode(struct decoded *decoded, const char *surface, const char *members) {
    struct bytes text = {0};
    bytes_format(&text, "{\"surface\":%s,\"fabric\":{\"spacing\":0.5}%s}", surface, members);
    decode_text(text.data, decoded->arena, &decoded->request, &decoded->problem);
    if (decoded->problem.id != API_OK)
        fail_msg("%s: %s", decoded->problem.error[0].pointer, decoded->problem.error[0].detail);
    bytes_free(&text);
}

static void assert_patch(const struct nurbs *nurbs) {
    assert_int_equal(nurbs->u.degree, 1);
    assert_int_equal(nurbs->v.size, 2);
    assert_int_equal(nurbs->u.knot_count, 4);
    assert_int_equal(nurbs->point_count, 4);
    assert_true(nurbs->points[1].y == 1 && nurbs->points[2].x == 1 && nurbs->points[3].z == 0.5);
}

static void test_decode_fills_in_every_default(void **state) {
    struct decoded *d = *state;
    decode(d, PATCH, "");
    const struct api_request *r = &d->request;
    assert_patch(&r->surface.nurbs);
    assert_null(r->surface.nurbs.weights);
    assert_string_equal(r->surface.id, "");
    assert_string_equal(r->length_unit->name, "m");
    assert_true(r->length_unit->metres == 1);
    assert_true(r->settings.spacing[0] == 0.5 && r->settings.spacing[1] == 0.5);
    assert_int_equal(r->settings.method, DRAPE_GIB);
    assert_int_equal(r->settings.yarn_path, DRAPE_PATH_CHORD);
    assert_int_equal(r->settings.start_kind, DRAPE_START_CENTROID);
    assert_int_equal(r->settings.direction_kind, DRAPE_DIRECTION_ANGLE);
    assert_true(r->settings.direction_deg == 0 && r->settings.pre_shear_deg == 0);
    assert_int_equal(r->settings.generator[0].kind, DRAPE_GENERATOR_GEODESIC);
    assert_false(r->settings.has_extent[0] || r->settings.has_extent[1]);
    assert_int_equal(r->settings.max_nodes, api_limits_default.max_nodes);
    assert_true(r->fabric.thickness == 0 && r->fabric.fiber_volume_fraction == 0);
    assert_true(r->fabric.locking_angle_deg[0] < 0 && r->fabric.plies == 1);
    assert_false(r->cavity.rigid);
    assert_int_equal(r->permeability.model, API_PERMEABILITY_NONE);
}

static void test_decode_takes_every_setting(void **state) {
    struct decoded *d = *state;
    struct bytes text = {0};
    bytes_format(&text,
                 "{\"surface\":%s,\"length_unit\":\"mm\",\"fabric\":{\"spacing\":[0.1,0.2],"
                 "\"thickness\":0.3,\"fiber_volume_fraction\":0.55,\"locking_angle_deg\":42,"
                 "\"pre_shear_deg\":-5,\"plies\":3},\"start\":{\"uv\":[0.25,1]},"
                 "\"direction\":{\"vector\":[1,2,3]},\"method\":\"basic\","
                 "\"generators\":{\"warp\":\"geodesic\"},\"extent\":{\"weft\":[-3,4]},"
                 "\"cavity\":{\"height\":2.5},\"yarn_path\":\"chord\"}",
                 PATCH);
    assert_int_equal(decode_text(text.data, d->arena, &d->request, &d->problem), API_OK);
    const struct api_request *r = &d->request;
    assert_true(r->length_unit->metres == 1e-3);
    assert_true(r->settings.spacing[0] == 0.1 && r->settings.spacing[1] == 0.2);
    assert_true(r->fabric.thickness == 0.3 && r->fabric.fiber_volume_fraction == 0.55);
    assert_true(r->fabric.locking_angle_deg[1] == 42 && r->fabric.plies == 3);
    assert_true(r->settings.pre_shear_deg == -5);
    assert_int_equal(r->settings.start_kind, DRAPE_START_UV);
    assert_true(r->settings.start_uv[0] == 0.25 && r->settings.start_uv[1] == 1);
    assert_int_equal(r->settings.direction_kind, DRAPE_DIRECTION_VECTOR);
    assert_true(r->settings.direction_vector.z == 3);
    assert_int_equal(r->settings.method, DRAPE_BASIC);
    assert_false(r->settings.has_extent[0]);
    assert_true(r->settings.has_extent[1]);
    assert_true(r->settings.extent[1][0] == -3 && r->settings.extent[1][1] == 4);
    assert_true(r->cavity.rigid && r->cavity.height == 2.5);
    bytes_free(&text);
}

/* The kinematics come through to the solver and back; 0 is what is not said. */
static void test_decode_kinematics(void **state) {
    struct decoded *d = *state;
    static const struct {
        const char *text;
        double slide;
        const char *normalised; /* NULL: it has no such member */
    } fine[] = {{"\"pin_jointed\"", 0, NULL},
                {"{\"slide\":0}", 0, NULL},
                {"{\"slide\":0.25}", 0.25, "\"kinematics\":{\"slide\":0.25}"},
                {"{\"slide\":1}", 1, "\"kinematics\":\"parallel_fibers\""},
                {"\"parallel_fibers\"", 1, "\"kinematics\":\"parallel_fibers\""}};
    static const struct {
        const char *members, *pointer;
    } bad[] = {{"\"kinematics\":\"tape\"}", "/fabric/kinematics"},
               {"\"kinematics\":0.5}", "/fabric/kinematics"},
               {"\"kinematics\":{}}", "/fabric/kinematics/slide"},
               {"\"kinematics\":{\"slide\":1.1}}", "/fabric/kinematics/slide"},
               {"\"kinematics\":{\"slide\":-0.1}}", "/fabric/kinematics/slide"},
               {"\"pre_shear_deg\":5,\"kinematics\":{\"slide\":0.1}}", "/fabric/pre_shear_deg"},
               {"\"kinematics\":\"parallel_fibers\"},\"generators\":{\"weft\":{\"plane\":[1,0,0]}}",
                "/generators/weft"}};
    for (size_t k = 0; k < sizeof fine / sizeof *fine; k++) {
        struct bytes text = {0};
        bytes_format(&text,
                     "{\"surface\":" PATCH ",\"fabric\":{\"spacing\":0.5,\"kinematics\":%s}}",
                     fine[k].text);
        assert_int_equal(decode_text(text.data, d->arena, &d->request, &d->problem), API_OK);
        assert_true(d->request.settings.slide == fine[k].slide);
        const char *normalised = api_normalise(&d->request, NULL, d->arena);
        const char *found = strstr(normalised, "\"kinematics\"");
        assert_true(fine[k].normalised ? strstr(normalised, fine[k].normalised) != NULL : !found);
        bytes_free(&text);
    }
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        struct bytes text = {0};
        d->problem = (struct api_problem){0};
        bytes_format(&text, "{\"surface\":" PATCH ",\"fabric\":{\"spacing\":0.5,%s}",
                     bad[k].members);
        assert_int_equal(decode_text(text.data, d->arena, &d->request, &d->problem),
                         API_INVALID_REQUEST);
        assert_string_equal(d->problem.error[0].pointer, bad[k].pointer);
        bytes_free(&text);
    }
}

/* A request whose fabric names a material, and says these members beside it. */
static void decode_material(struct decoded *decoded, const char *name, const char *beside,
                            const char *members) {
    struct bytes text = {0};
    decoded->problem = (struct api_problem){0};
    bytes_format(&text,
                 "{\"surface\":" PATCH ",\"fabric\":{\"spacing\":0.5,\"material\":\"%s\"%s}%s}",
                 name, beside, members);
    decode_text(text.data, decoded->arena, &decoded->request, &decoded->problem);
    if (decoded->problem.id != API_OK)
        fail_msg("%s: %s: %s", name, decoded->problem.error[0].pointer,
                 decoded->problem.error[0].detail);
    bytes_free(&text);
}

static void test_decode_material_fills_in_what_is_not_said(void **state) {
    struct decoded *d = *state;
    const struct api_fabric *fabric = &d->request.fabric;
    const struct api_permeability *k = &d->request.permeability;
    decode_material(d, "example-glass-plain-800", "", "");
    assert_true(fabric->thickness == 0.000625 && fabric->fiber_volume_fraction == 0.5);
    assert_true(fabric->locking_angle_deg[0] == 45 && k->k2 == 1.6e-10);
    decode_material(d, "example-glass-plain-800", "", ",\"length_unit\":\"mm\"");
    check_at_most(fabs(fabric->thickness / 0.625 - 1), 1e-15);
    decode_material(d, "example-glass-plain-800",
                    ",\"thickness\":0.7,\"fiber_volume_fraction\":0.6,\"locking_angle_deg\":30",
                    ",\"length_unit\":\"mm\",\"permeability\":{\"model\":\"gebart\","
                    "\"fiber_radius\":5e-6,\"packing\":\"quadratic\"}");
    assert_true(fabric->thickness == 0.7 && fabric->fiber_volume_fraction == 0.6);
    assert_true(fabric->locking_angle_deg[0] == 30);
    assert_true(k->model == API_PERMEABILITY_GEBART && k->k1 == 0 && k->fiber_radius == 5e-6);
    decode_material(d, "nrel-glass-uni-1858", "", "");
    assert_true(d->request.settings.slide == 1);
    decode_material(d, "nrel-glass-uni-1858", ",\"kinematics\":{\"slide\":0.5}", "");
    assert_true(d->request.settings.slide == 0.5);
    decode_material(d, "nrel-glass-uni-1858", ",\"kinematics\":\"pin_jointed\"", "");
    assert_true(d->request.settings.slide == 0);
}

/* Named or said, the request is the same. */
static void test_decode_material_is_its_figures(void **state) {
    struct decoded *d = *state;
    decode_material(d, "lcmsim-test-case", "", "");
    char *named = strdup(api_normalise(&d->request, NULL, d->arena));
    decode_text("{\"surface\":" PATCH ",\"fabric\":{\"spacing\":0.5,\"thickness\":0.003,"
                "\"fiber_volume_fraction\":0.3},\"permeability\":{\"model\":\"kozeny_carman\","
                "\"k1\":3e-10,\"k2\":3e-10,\"k3\":3e-10,\"at_fiber_volume_fraction\":0.3}}",
                d->arena, &d->request, &d->problem);
    assert_int_equal(d->problem.id, API_OK);
    assert_string_equal(named, api_normalise(&d->request, NULL, d->arena));
    free(named);
}

/* Of a stored surface whose unit is not known yet, the material's thickness waits for it. */
static void test_decode_material_waits_for_the_unit_of_a_stored_surface(void **state) {
    struct decoded *d = *state;
    decode_text("{\"surface\":{\"id\":\"0123456789abcdef0123456789abcdef\"},\"fabric\":{"
                "\"spacing\":0.5,\"material\":\"lcmsim-test-case\"}}",
                d->arena, &d->request, &d->problem);
    assert_int_equal(d->problem.id, API_OK);
    const char *text = api_normalise(&d->request, NULL, d->arena);
    assert_non_null(strstr(text, "\"material\":\"lcmsim-test-case\""));
    assert_null(strstr(text, "\"thickness\""));
    decode_text("{\"surface\":{\"id\":\"0123456789abcdef0123456789abcdef\"},\"fabric\":{"
                "\"spacing\":0.5,\"material\":\"lcmsim-test-case\",\"thickness\":2}}",
                d->arena, &d->request, &d->problem);
    text = api_normalise(&d->request, NULL, d->arena);
    assert_null(strstr(text, "\"material\""));
    assert_non_null(strstr(text, "\"thickness\":2"));
}

/* Each can be draped with, says where its figures come from, and has the weight that they give. */
static void test_decode_every_material_of_the_library(void **state) {
    struct decoded *d = *state;
    const struct api_material *material;
    for (size_t k = 0; (material = api_material_at(k)); k++) {
        decode_material(d, material->name, "", ",\"cavity\":{\"height\":0.01}");
        assert_ptr_equal(api_material_named(material->name), material);
        assert_int_equal(strlen(material->json), material->length);
        assert_non_null(strstr(material->json, "\"source\":\""));
        assert_non_null(strstr(api_materials_heads(), material->name));
    }
    assert_null(api_material_named("silk"));
}

static void test_decode_start_by_point(void **state) {
    struct decoded *d = *state;
    decode(d, PATCH, ",\"start\":{\"point\":[0.5,0.25,-1]}");
    assert_int_equal(d->request.settings.start_kind, DRAPE_START_POINT);
    assert_true(d->request.settings.start_point.z == -1);
}

static void test_decode_bare_list_of_points(void **state) {
    struct decoded *d = *state;
    decode(d, "{" SIZES "," KNOTS ",\"control_points\":" POINTS "}", "");
    assert_patch(&d->request.surface.nurbs);
    assert_null(d->request.surface.nurbs.weights);
}

static void test_decode_weights_beside_the_bare_list(void **state) {
    struct decoded *d = *state;
    decode(d, "{" SIZES "," KNOTS ",\"control_points\":" POINTS ",\"weights\":[1,2,3,0.5]}", "");
    assert_patch(&d->request.surface.nurbs);
    assert_int_equal(d->request.surface.nurbs.weight_count, 4);
    assert_true(d->request.surface.nurbs.weights[3] == 0.5);
}

static void test_decode_weights_in_control_points(void **state) {
    struct decoded *d = *state;
    decode(d,
           "{" SIZES "," KNOTS ",\"control_points\":{\"weights\":[1,2,3,4],\"points\":" POINTS "}}",
           "");
    assert_patch(&d->request.surface.nurbs);
    assert_true(d->request.surface.nurbs.weights[2] == 3);
}

static void test_decode_weights_that_are_all_one_say_nothing(void **state) {
    struct decoded *d = *state;
    decode(d, "{" SIZES "," KNOTS ",\"control_points\":" POINTS ",\"weights\":[1,1.0,1e0,1]}", "");
    assert_null(d->request.surface.nurbs.weights);
    assert_int_equal(d->request.surface.nurbs.weight_count, 0);
}

static void test_decode_whole_export_file(void **state) {
    struct decoded *d = *state;
    decode(d, "{\"shape\":{\"type\":\"surface\",\"count\":1,\"data\":[" PATCH "]}}", "");
    assert_patch(&d->request.surface.nurbs);
    decode(d, "{\"shape\":{\"data\":[" PATCH "]}}", "");
    assert_patch(&d->request.surface.nurbs);
}

static void test_decode_ignores_the_other_keys_of_the_format(void **state) {
    struct decoded *d = *state;
    decode(d,
           "{" SIZES "," KNOTS ",\"control_points\":" POINTS ",\"type\":\"spline\","
           "\"rational\":true,\"dimension\":3,\"pdimension\":2,\"delta\":[0.05,0.05],"
           "\"sample_size\":[30,30],\"name\":\"wing\",\"id\":7,\"bbox\":[[0,0,0],[1,1,1]],"
           "\"reversed\":0,\"precision\":18}",
           "");
    assert_patch(&d->request.surface.nurbs);
}

static void test_decode_empty_trims_are_none(void **state) {
    struct decoded *d = *state;
    decode(d,
           "{" SIZES "," KNOTS ",\"control_points\":" POINTS
           ",\"trims\":{\"count\":0,\"data\":[]}}",
           "");
    assert_int_equal(d->request.surface.trim_count, 0);
}

#define TRIMMED                                                                                    \
    "{" SIZES "," KNOTS ",\"control_points\":" POINTS ",\"trims\":{\"count\":3,\"data\":["         \
    "{\"type\":\"freeform\",\"dimension\":2,\"name\":\"a\",\"points\":[[0.1,0.1],[0.2,0.1],[0.1,"  \
    "0.2]]},"                                                                                      \
    "{\"type\":\"spline\",\"rational\":true,\"dimension\":2,\"degree\":1,\"knotvector\":[0,0,1,2," \
    "2],"                                                                                          \
    "\"control_points\":{\"points\":[[0.5,0.5],[0.6,0.5],[0.5,0.5]],\"weights\":[1,2,1]},"         \
    "\"delta\":0.01,\"reversed\":1},"                                                              \
    "{\"type\":\"container\",\"count\":1,\"reversed\":true,\"data\":["                             \
    "{\"type\":\"freeform\",\"points\":[[0.7,0.7],[0.8,0.7],[0.7,0.8],[0.7,0.7]]}]}]}}"

static void test_decode_trims_of_every_kind(void **state) {
    struct decoded *d = *state;
    decode(d, TRIMMED, "");
    const struct api_surface *surface = &d->request.surface;
    assert_int_equal(surface->trim_count, 3);
    assert_false(surface->trims[0].reversed);
    assert_true(surface->trims[1].reversed && surface->trims[2].reversed);
    assert_null(surface->trims[0].curves[0].knots);
    assert_int_equal(surface->trims[1].curves[0].degree, 1);
    assert_true(surface->trims[1].curves[0].weights[1] == 2);
    assert_int_equal(surface->trims[2].curves[0].count, 4);
    const char *first = api_normalise(&d->request, NULL, d->arena);
    struct api_request again;
    assert_int_equal(decode_text(first, d->arena, &again, &d->problem), API_OK);
    assert_string_equal(api_normalise(&again, NULL, d->arena), first);
}

#define STORED_ID "0123456789abcdef0123456789abcdef"

static void test_decode_surface_by_id(void **state) {
    struct decoded *d = *state;
    static const char text[] = "{\"surface\":{\"id\":\"" STORED_ID "\"},\"fabric\":{\"spacing\":1},"
                               "\"start\":{\"uv\":[0.5,0.5]}}";
    assert_int_equal(decode_text(text, d->arena, &d->request, &d->problem), API_OK);
    assert_int_equal(d->request.surface.kind, API_SURFACE_NAMED);
    assert_string_equal(d->request.surface.id, STORED_ID);
    const struct api_input input = {.request = text,
                                    .request_length = sizeof text - 1,
                                    .surface = PATCH,
                                    .surface_length = sizeof PATCH - 1};
    assert_int_equal(api_decode(&input, &api_limits_default, d->arena, &d->request, &d->problem),
                     API_OK);
    assert_int_equal(d->request.surface.kind, API_SURFACE_NURBS);
    assert_string_equal(d->request.surface.id, STORED_ID);
    assert_patch(&d->request.surface.nurbs);
}

/* The domain of a stored surface is known only once it is there. */
static void test_decode_checks_the_start_against_the_stored_surface(void **state) {
    struct decoded *d = *state;
    static const char text[] = "{\"surface\":{\"id\":\"" STORED_ID "\"},\"fabric\":{\"spacing\":1},"
                               "\"start\":{\"uv\":[0.5,1.5]}}";
    assert_int_equal(decode_text(text, d->arena, &d->request, &d->problem), API_OK);
    const struct api_input input = {.request = text,
                                    .request_length = sizeof text - 1,
                                    .surface = PATCH,
                                    .surface_length = sizeof PATCH - 1};
    assert_int_equal(api_decode(&input, &api_limits_default, d->arena, &d->request, &d->problem),
                     API_INVALID_REQUEST);
    assert_string_equal(d->problem.error[0].pointer, "/start/uv");
}

/* A stored surface that cannot be read is not the caller's fault. */
static void test_decode_damaged_stored_surface_is_internal(void **state) {
    struct decoded *d = *state;
    static const char text[] =
        "{\"surface\":{\"id\":\"" STORED_ID "\"},\"fabric\":{\"spacing\":1}}";
    static const char *const damaged[] = {"{", "{}", "[]", "{\"id\":\"" STORED_ID "\"}"};
    for (size_t i = 0; i < sizeof damaged / sizeof *damaged; i++) {
        const struct api_input input = {.request = text,
                                        .request_length = sizeof text - 1,
                                        .surface = damaged[i],
                                        .surface_length = strlen(damaged[i])};
        d->problem = (struct api_problem){0};
        assert_int_equal(
            api_decode(&input, &api_limits_default, d->arena, &d->request, &d->problem),
            API_INTERNAL);
    }
}

static void test_decode_surface_alone(void **state) {
    struct decoded *d = *state;
    struct api_surface surface;
    assert_int_equal(api_decode_surface(PATCH, sizeof PATCH - 1, &api_limits_default, d->arena,
                                        &surface, &d->problem),
                     API_OK);
    assert_patch(&surface.nurbs);
    static const char named[] = "{\"id\":\"" STORED_ID "\"}";
    assert_int_equal(api_decode_surface(named, sizeof named - 1, &api_limits_default, d->arena,
                                        &surface, &d->problem),
                     API_INVALID_REQUEST);
    assert_string_equal(d->problem.error[0].pointer, "/degree_u");
}

/* What is written down as understood decodes to the same again, and is written the same. */
static void test_decode_of_a_normalised_request_changes_nothing(void **state) {
    struct decoded *d = *state;
    static const char *const members[] = {
        "", ",\"start\":{\"uv\":[0.1,0.9]},\"direction\":{\"angle_deg\":33.3}",
        ",\"start\":{\"point\":[0.1,0.2,0.3]},\"direction\":{\"vector\":[0,0.1,2]}",
        ",\"extent\":{\"warp\":[-1,2],\"weft\":[0,0]},\"cavity\":{\"height\":0.1}",
        ",\"extent\":{\"warp\":[0,3]},\"length_unit\":\"in\",\"method\":\"basic\""};
    for (size_t i = 0; i < sizeof members / sizeof *members; i++) {
        struct api_request again;
        decode(d, PATCH, members[i]);
        const char *first = api_normalise(&d->request, NULL, d->arena);
        assert_non_null(first);
        assert_int_equal(decode_text(first, d->arena, &again, &d->problem), API_OK);
        assert_string_equal(api_normalise(&again, NULL, d->arena), first);
    }
}

static void test_decode_normalised_start_is_what_was_chosen(void **state) {
    struct decoded *d = *state;
    const struct api_start chosen = {.uv = {0.125, 0.5}};
    decode(d, PATCH, "");
    const char *text = api_normalise(&d->request, &chosen, d->arena);
    assert_non_null(strstr(text, "\"start\":{\"uv\":[0.125,0.5]}"));
    decode(d, PATCH, ",\"start\":{\"uv\":[1,0]}");
    text = api_normalise(&d->request, &chosen, d->arena);
    assert_non_null(strstr(text, "\"start\":{\"uv\":[1,0]}"));
}

static void test_decode_limits_are_too_large(void **state) {
    struct decoded *d = *state;
    struct api_limits limits = api_limits_default;
    const struct api_input input = {.request = request_text("saddle"),
                                    .request_length = strlen(request_text("saddle"))};
    limits.max_elements = 20;
    assert_int_equal(api_decode(&input, &limits, d->arena, &d->request, &d->problem),
                     API_TOO_LARGE);
    limits.max_elements = 1000;
    limits.max_depth = 3;
    d->problem = (struct api_problem){0};
    assert_int_equal(api_decode(&input, &limits, d->arena, &d->request, &d->problem),
                     API_TOO_LARGE);
}

static void test_decode_has_too_many_control_points(void **state) {
    struct decoded *d = *state;
    struct api_limits limits = api_limits_default;
    const struct api_input input = {.request = request_text("saddle"),
                                    .request_length = strlen(request_text("saddle"))};
    limits.max_control_points = 9;
    assert_int_equal(api_decode(&input, &limits, d->arena, &d->request, &d->problem), API_OK);
    limits.max_control_points = 8;
    assert_int_equal(api_decode(&input, &limits, d->arena, &d->request, &d->problem),
                     API_INVALID_REQUEST);
    assert_string_equal(d->problem.error[0].pointer, "/surface/control_points");
}

/* ",[1,2,..]" with `count` knots, clamped as far as they reach. */
static void add_knots(struct bytes *text, const char *key, int degree, int count) {
    bytes_format(text, ",\"%s\":[", key);
    for (int k = 0; k < count; k++)
        bytes_format(text, "%s%d", k ? "," : "", k > degree ? k - degree : 0);
    bytes_format(text, "]");
}

/* A surface whose counts do not agree: degrees, sizes, knots and points. */
static void test_decode_guesses_why_counts_do_not_agree(void **state) {
    struct decoded *d = *state;
    static const struct {
        int degree[2], size[2], knots[2], points;
        const char *detail[2];
    } cases[] = {
        {{2, 2}, {9, 4}, {11, 7}, 36, {"the number of knots is 11; size_u + degree_u + 1 is 12"}},
        {{2, 2},
         {4, 9},
         {12, 7},
         36,
         {"the number of knots is 12; size_u + degree_u + 1 is 7; are size_u and size_v swapped?",
          "the number of knots is 7; size_v + degree_v + 1 is 12; are size_u and size_v swapped?"}},
        {{3, 1},
         {5, 7},
         {7, 11},
         35,
         {"the number of knots is 7; size_u + degree_u + 1 is 9; are degree_u and degree_v "
          "swapped?",
          "the number of knots is 11; size_v + degree_v + 1 is 9; are degree_u and degree_v "
          "swapped?"}},
        {{3, 1},
         {5, 4},
         {6, 9},
         20,
         {"the number of knots is 6; size_u + degree_u + 1 is 9; are knotvector_u and knotvector_v "
          "swapped?",
          "the number of knots is 9; size_v + degree_v + 1 is 6; are knotvector_u and knotvector_v "
          "swapped?"}},
        {{3, 2},
         {5, 6},
         {7, 7},
         30,
         {"the number of knots is 7; size_u + degree_u + 1 is 9; Rhino and openNURBS leave out the "
          "first and the last knot: repeat both ends once more",
          "the number of knots is 7; size_v + degree_v + 1 is 9; Rhino and openNURBS leave out the "
          "first and the last knot: repeat both ends once more"}},
        {{1, 1},
         {2, 3},
         {2, 3},
         6,
         {"the number of knots is 2; size_u + degree_u + 1 is 4; Rhino and openNURBS leave out the "
          "first and the last knot: repeat both ends once more",
          "the number of knots is 3; size_v + degree_v + 1 is 5; Rhino and openNURBS leave out the "
          "first and the last knot: repeat both ends once more"}},
        {{1, 1},
         {3, 4},
         {5, 6},
         11,
         {"the number of control points is 11; size_u * size_v is 3 * 4 = 12"}}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        struct bytes text = {0};
        bytes_format(&text,
                     "{\"fabric\":{\"spacing\":1},\"surface\":{\"degree_u\":%d,\"degree_v\":%d,"
                     "\"size_u\":%d,\"size_v\":%d",
                     cases[c].degree[0], cases[c].degree[1], cases[c].size[0], cases[c].size[1]);
        add_knots(&text, "knotvector_u", cases[c].degree[0], cases[c].knots[0]);
        add_knots(&text, "knotvector_v", cases[c].degree[1], cases[c].knots[1]);
        bytes_format(&text, ",\"control_points\":[");
        for (int k = 0; k < cases[c].points; k++)
            bytes_format(&text, "%s[%d,0,0]", k ? "," : "", k);
        bytes_format(&text, "]}}");
        d->problem = (struct api_problem){0};
        decode_text(text.data, d->arena, &d->request, &d->problem);
        assert_int_equal(d->problem.count, cases[c].detail[1] ? 2 : 1);
        for (size_t k = 0; k < d->problem.count; k++)
            assert_string_equal(d->problem.error[k].detail, cases[c].detail[k]);
        bytes_free(&text);
    }
}

/* Any damage to a document is answered, and never worse. */
static void test_decode_survives_damaged_documents(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    size_t length = strlen(request_text("saddle"));
    for (int round = 0; round < 20000; round++) {
        struct bytes copy = {0};
        struct api_request request;
        struct api_problem problem = {0};
        struct arena *arena = arena_new((size_t)1 << 24);
        bytes_add(&copy, request_text("saddle"), length);
        for (int hits = 1 + random_index(&random, 3); hits > 0; hits--)
            copy.data[random_index(&random, (int)length)] =
                random_index(&random, 4) ? "0123456789-.eE{}[],:\"\\aut"[random_index(&random, 25)]
                                         : (char)random_index(&random, 256);
        const struct api_input input = {.request = copy.data, .request_length = length};
        enum api_problem_id id = api_decode(&input, &api_limits_default, arena, &request, &problem);
        assert_true(id == API_OK || id == API_MALFORMED_JSON || id == API_INVALID_REQUEST);
        assert_true(id == API_OK || problem.count > 0);
        arena_free(arena);
        bytes_free(&copy);
    }
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)
    const struct CMUnitTest tests[] = {
        TEST(test_decode_fills_in_every_default),
        TEST(test_decode_takes_every_setting),
        TEST(test_decode_kinematics),
        TEST(test_decode_material_fills_in_what_is_not_said),
        TEST(test_decode_material_is_its_figures),
        TEST(test_decode_material_waits_for_the_unit_of_a_stored_surface),
        TEST(test_decode_every_material_of_the_library),
        TEST(test_decode_start_by_point),
        TEST(test_decode_bare_list_of_points),
        TEST(test_decode_weights_beside_the_bare_list),
        TEST(test_decode_weights_in_control_points),
        TEST(test_decode_weights_that_are_all_one_say_nothing),
        TEST(test_decode_whole_export_file),
        TEST(test_decode_ignores_the_other_keys_of_the_format),
        TEST(test_decode_empty_trims_are_none),
        TEST(test_decode_trims_of_every_kind),
        TEST(test_decode_surface_by_id),
        TEST(test_decode_checks_the_start_against_the_stored_surface),
        TEST(test_decode_damaged_stored_surface_is_internal),
        TEST(test_decode_surface_alone),
        TEST(test_decode_of_a_normalised_request_changes_nothing),
        TEST(test_decode_normalised_start_is_what_was_chosen),
        TEST(test_decode_limits_are_too_large),
        TEST(test_decode_has_too_many_control_points),
        TEST(test_decode_guesses_why_counts_do_not_agree),
        TEST(test_decode_survives_damaged_documents),
    };
    prepare();
    return cmocka_run_group_tests_name("decode", tests, NULL, NULL);
}
