/* SPDX-License-Identifier: MIT */
#include "studied.h"

#include "tests/check.h"
#include <string.h>

/* ---- studies as text ---- */

struct bytes studied_text(const char *drape, const char *rest) {
    struct bytes text = {0};
    bytes_format(&text, "{\"drape\":");
    bytes_add(&text, drape, strlen(drape));
    bytes_format(&text, ",%s}", rest);
    return text;
}

struct api_input studied_input(const struct bytes *text) {
    return (struct api_input){.request = text->data, .request_length = text->length};
}

enum api_problem_id studied_run(const struct bytes *text, int threads, struct bytes *container,
                                struct api_problem *problem) {
    const struct api_input input = studied_input(text);
    const struct api_sink sink = sink_into(container);
    struct api_limits limits = api_limits_default;
    prepare();
    *problem = (struct api_problem){0};
    limits.threads = threads;
    struct api_study *study = api_study_open(&input, &limits, problem);
    if (study)
        (void)!api_study_run(study, &limits, NULL, &sink, problem);
    api_study_close(study);
    return problem->id;
}

struct studied studied_make(const char *drape, const char *rest) {
    struct studied f = {.text = studied_text(drape, rest)};
    struct api_problem problem;
    if (studied_run(&f.text, 2, &f.container, &problem) != API_OK)
        fail_msg("%s: %s", problem.error[0].pointer, problem.error[0].detail);
    struct api_reader reader = reader_over(&f.container);
    assert_int_equal(api_columns_open(&reader, &f.columns, &problem), API_OK);
    assert_int_equal(f.columns.document, API_DOCUMENT_STUDY);
    f.rows = api_columns_rows(&f.columns, API_TABLE_VARIANTS);
    assert_int_equal(f.rows, f.columns.study.variants);
    return f;
}

/* All but the header, which has the time. */
void studied_check_threads(const char *drape, const char *rest) {
    struct bytes study = studied_text(drape, rest), container[2] = {{0}, {0}};
    size_t first[2];
    for (int k = 0; k < 2; k++) {
        struct api_problem problem;
        struct api_columns columns;
        assert_int_equal(studied_run(&study, k ? 5 : 1, &container[k], &problem), API_OK);
        struct api_reader reader = reader_over(&container[k]);
        assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
        first[k] = (size_t)columns.column[0].offset;
    }
    assert_int_equal(container[0].length - first[0], container[1].length - first[1]);
    assert_memory_equal(container[0].data + first[0], container[1].data + first[1],
                        container[0].length - first[0]);
    bytes_free(&container[0]);
    bytes_free(&container[1]);
    bytes_free(&study);
}

void studied_free(struct studied *f) {
    bytes_free(&f->text);
    bytes_free(&f->container);
}

double studied_value(struct studied *f, const char *name, size_t row) {
    struct api_reader reader = reader_over(&f->container);
    const struct api_column *column = api_columns_find(&f->columns, API_TABLE_VARIANTS, name);
    double value;
    if (!column)
        fail_msg("no column %s", name);
    assert_true(api_columns_read(&reader, column, row, 1, &value));
    return value;
}

double studied_best(struct studied *f, enum quantity_id id) {
    assert_true(f->columns.study.best[id] >= 0);
    return studied_value(f, quantities[id].name, (size_t)f->columns.study.best[id]);
}

struct bytes studied_request(struct studied *f, size_t row) {
    struct bytes request = {0};
    struct api_problem problem = {0};
    const struct api_input input = studied_input(&f->text);
    const struct api_sink sink = sink_into(&request);
    struct api_reader reader = reader_over(&f->container);
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    struct arena *arena = arena_new((size_t)1 << 30);
    assert_non_null(study);
    assert_int_equal(api_study_variant_request(study, &reader, row, arena, &sink, &problem),
                     API_OK);
    bytes_add(&request, "", 1);
    arena_free(arena);
    api_study_close(study);
    return request;
}

static struct api_summary summary_of(const char *request) {
    struct bytes container = {0};
    struct api_problem problem;
    struct api_columns columns;
    assert_int_equal(run_text(request, &container, &problem), API_OK);
    struct api_reader reader = reader_over(&container);
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    bytes_free(&container);
    return columns.summary;
}

/* ---- parts ---- */

static const char saddle_with[] =
    "\"fabric\":{\"spacing\":0.25,\"thickness\":0.01,\"fiber_volume_fraction\":0.5,"
    "\"locking_angle_deg\":20},\"cavity\":{\"height\":0.012},"
    "\"permeability\":{\"model\":\"gebart\",\"fiber_radius\":1e-5,\"packing\":\"hexagonal\"}";

struct bytes studied_saddle(void) {
    struct bytes text = {0};
    bytes_format(&text, "{\"surface\":%s,%s}", request_text("saddle_surface"), saddle_with);
    return text;
}

const char studied_roof[] =
    "{\"surface\":{\"faces\":["
    "{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"size_u\":2,\"size_v\":2,\"control_points\":[[-1,0,0],[-1,2,0],[0,0,1],[0,2,1]]},"
    "{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"size_u\":2,\"size_v\":2,\"control_points\":[[1,0,0],[1,2,0],[0,0,1],[0,2,1]]}]},"
    "\"fabric\":{\"spacing\":0.2}}";

const char studied_bowl[] =
    "{\"surface\":{\"degree_u\":2,\"degree_v\":2,\"knotvector_u\":[0,0,0,1,1,1],"
    "\"knotvector_v\":[0,0,0,1,1,1],\"size_u\":3,\"size_v\":3,\"control_points\":["
    "[-1,-1,1],[-1,0,0],[-1,1,1],[0,-1,0],[0,0,-1],[0,1,0],[1,-1,1],[1,0,0],[1,1,1]]},"
    "\"fabric\":{\"spacing\":0.1}}";

struct bytes studied_mesh(void) {
    enum { N = 12 };
    struct bytes text = {0};
    bytes_format(&text, "{\"surface\":{\"vertices\":[");
    for (int k = 0; k < (N + 1) * (N + 1); k++) {
        double x = (double)(k % (N + 1)) / N, y = k / (N + 1) / (double)N;
        bytes_format(&text, "%s[%.17g,%.17g,%.17g]", k ? "," : "", x, y, x * y);
    }
    bytes_format(&text, "],\"triangles\":[");
    for (int k = 0; k < N * N; k++) {
        int a = k / N * (N + 1) + k % N;
        bytes_format(&text, "%s[%d,%d,%d],[%d,%d,%d]", k ? "," : "", a, a + 1, a + N + 2, a,
                     a + N + 2, a + N + 1);
    }
    bytes_format(&text, "]},\"fabric\":{\"spacing\":0.1}}");
    return text;
}

void studied_check_bits(struct studied *f, size_t row) {
    struct bytes request = studied_request(f, row);
    struct api_summary s = summary_of(request.data);
    assert_true(studied_value(f, "failure", row) == 0);
    assert_true(studied_value(f, "max_shear_deg", row) == s.max_shear_deg);
    if (f->columns.study.objective[QUANTITY_P95_SHEAR])
        assert_true(studied_value(f, "p95_shear_deg", row) == s.p95_shear_deg);
    assert_true(studied_value(f, "cloth_coverage", row) == s.cloth_coverage);
    bytes_free(&request);
}
