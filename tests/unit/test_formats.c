/* SPDX-License-Identifier: MIT */
/* The binary formats, the pattern and the meshes byte by byte against files in golden/, which the
 * readers of tests/readers open as well. DRAPE_GOLDEN=write writes them anew. */
#include "api/format/colour.h"
#include "api/format/dxf_writer.h"
#include "api/format/format.h"
#include "api/format/lcmsim.h"
#include "api/format/pattern.h"
#include "api/format/stack.h"
#include "api/result/fieldset.h"
#include "api/result/outline.h"

#include "mesh_text.h"
#include "small.h"
#include "tests/check.h"
#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

/* ---- helpers ---- */

static void compare_golden(const char *name, const void *data, size_t length) {
    char path[128];
    snprintf(path, sizeof path, "tests/unit/golden/%s", name);
    const char *mode = getenv("DRAPE_GOLDEN");
    if (mode && strcmp(mode, "write") == 0) {
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(data, 1, length, file), length);
        fclose(file);
    }
    struct bytes golden = file_read(path);
    assert_int_equal(golden.length, length);
    assert_memory_equal(golden.data, data, length);
    bytes_free(&golden);
}

static struct bytes encode_source(const struct format *format, const struct format_source *source,
                                  const struct format_options *options) {
    struct api_problem problem = {0};
    struct bytes text = {0};
    char piece[1000];
    ssize_t length;
    struct encoder *encoder = encoder_new(format, source, options, &problem);
    assert_non_null(encoder);
    uint64_t promised = encoder_length(encoder);
    while ((length = encoder_read(encoder, piece, sizeof piece)) > 0)
        bytes_add(&text, piece, (size_t)length);
    assert_int_equal(length, 0);
    if (promised)
        assert_int_equal(text.length, promised);
    encoder_free(encoder);
    return text;
}

static struct bytes encode(const struct format *format, struct bytes *container) {
    struct api_reader reader = reader_over(container);
    return encode_source(format, &(struct format_source){.id = "small", .reader = &reader},
                         &(struct format_options){0});
}

static struct bytes encode_mesh(const char *name, const struct map_fields *fields) {
    return encode_source(format_named(FORMAT_MAP, name),
                         &(struct format_source){.id = "small", .fields = fields},
                         &(struct format_options){0});
}

static uint32_t number_at(const char *bytes, int size) {
    uint32_t value = 0;
    for (int k = size - 1; k >= 0; k--)
        value = value << 8 | (unsigned char)bytes[k];
    return value;
}

/* The content of a member of a zip, found by the directory, its checksum compared. */
static struct bytes unzip(const struct bytes *zip, const char *name) {
    const char *end = zip->data + zip->length - 22;
    assert_int_equal(number_at(end, 4), 0x06054b50);
    const char *entry = zip->data + number_at(end + 16, 4);
    for (uint32_t count = number_at(end + 8, 2); count > 0; count--) {
        uint32_t packed = number_at(entry + 20, 4), size = number_at(entry + 24, 4);
        uint32_t name_length = number_at(entry + 28, 2), extra = number_at(entry + 30, 2);
        const char *local = zip->data + number_at(entry + 42, 4);
        if (name_length != strlen(name) || memcmp(entry + 46, name, name_length) != 0) {
            entry += 46 + name_length + extra;
            continue;
        }
        struct bytes content = {calloc(1, size + 1), size, size + 1};
        z_stream z = {.next_in = (Bytef *)(uintptr_t)(local + 30 + number_at(local + 26, 2)),
                      .avail_in = packed,
                      .next_out = (Bytef *)content.data,
                      .avail_out = size};
        assert_int_equal(inflateInit2(&z, -15), Z_OK);
        assert_int_equal(inflate(&z, Z_FINISH), Z_STREAM_END);
        inflateEnd(&z);
        assert_int_equal(crc32(0, (const Bytef *)content.data, size), number_at(entry + 16, 4));
        return content;
    }
    fail_msg("%s is not in the archive", name);
    return (struct bytes){0};
}

/* ---- drawings ---- */

/* Zero as a sum of warp and weft points where that sum does on the cloth, whose yarns are square.
 */
static void test_pattern_shows_zero_as_before_the_shear(void **state) {
    static const double sums[][2] = {{1, 0}, {0, 1}, {0, -1}, {1, 2}, {-3, 4}};
    struct api_start start = {.warp = {1, 0, 0}, .weft = {0.5, sqrt(0.75), 0}};
    double flat[2];
    (void)state;
    for (size_t k = 0; k < sizeof sums / sizeof *sums; k++) {
        const double length = hypot(sums[k][0], sums[k][1]);
        start.zero = vec3_axpy(7 * sums[k][0], start.warp, vec3_scale(7 * sums[k][1], start.weft));
        pattern_flat_zero(&start, flat);
        check_at_most(fabs(flat[0] - sums[k][0] / length), 1e-14);
        check_at_most(fabs(flat[1] - sums[k][1] / length), 1e-14);
    }
    start.zero = vec3_make(0, 0, 0);
    pattern_flat_zero(&start, flat);
    assert_true(flat[0] == 0 && flat[1] == 0);
}

/* $INSUNITS and $MEASUREMENT as the reference of DXF has them; 0 where it has no such unit. */
static void test_dxf_says_its_unit(void **state) {
    static const struct {
        const char *unit;
        int number, metric;
    } rows[] = {{"in", 1, 0}, {"ft", 2, 0},  {"mm", 4, 1}, {"cm", 5, 1},
                {"m", 6, 1},  {"um", 13, 1}, {"ell", 0, 0}};
    static const double low[2] = {0, 0}, high[2] = {1, 1};
    static const struct dxf_layer layers[] = {{"1", DXF_WHITE}};
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        char bytes[4096], wanted[80];
        struct api_text text = api_text_over(bytes, sizeof bytes);
        dxf_head(&text, rows[k].unit, low, high, layers, 1);
        const char *said = api_text_finish(&text);
        snprintf(wanted, sizeof wanted, "$INSUNITS\n70\n%d\n9\n$MEASUREMENT\n70\n%d\n",
                 rows[k].number, rows[k].metric);
        assert_non_null(said);
        if (!strstr(said, wanted))
            fail_msg("%s: %s", rows[k].unit, said);
    }
}

/* ---- results ---- */

static void check_golden(enum format_use use) {
    struct bytes container = small_result();
    const struct format *format;
    assert_non_null(format_at(use, 0));
    for (size_t k = 0; (format = format_at(use, k)); k++) {
        char name[32];
        struct bytes text = encode(format, &container);
        snprintf(name, sizeof name, "small.%s", format->name);
        compare_golden(name, text.data, text.length);
        bytes_free(&text);
    }
    bytes_free(&container);
}

static void test_formats_of_results_are_golden(void **state) {
    (void)state;
    check_golden(FORMAT_RESULT);
}

static void test_formats_of_patterns_are_golden(void **state) {
    (void)state;
    check_golden(FORMAT_PATTERN);
}

/* Names and media types are unique within a use, and what each use has. */
static void test_formats_are_found_within_their_use_alone(void **state) {
    static const enum format_use uses[] = {FORMAT_RESULT, FORMAT_MAP, FORMAT_PATTERN,
                                           FORMAT_REPORT};
    const struct format *format;
    (void)state;
    for (size_t u = 0; u < sizeof uses / sizeof *uses; u++)
        for (size_t k = 0; (format = format_at(uses[u], k)); k++) {
            assert_ptr_equal(format_named(uses[u], format->name), format);
            assert_ptr_equal(format_for_media_type(uses[u], format->media_type), format);
        }
    assert_null(format_named(FORMAT_PATTERN, "json"));
    assert_null(format_named(FORMAT_RESULT, "svg"));
    assert_null(format_named(FORMAT_MAP, "vtp"));
    assert_null(format_named(FORMAT_RESULT, "vtu"));
}

static void test_formats_refuse_cells_without_corners(void **state) {
    (void)state;
    struct bytes container = small_result();
    struct api_reader reader = reader_over(&container);
    struct api_problem problem = {0};
    struct api_columns columns;
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    const struct api_column *j = api_columns_find(&columns, API_TABLE_CELLS, "j");
    assert_int_equal(j->form, API_FORM_INT8);
    container.data[j->offset + 2] = 9;
    static const char *const names[] = {"vtp", "glb"};
    for (size_t k = 0; k < 2; k++) {
        char piece[100000];
        const struct format_source source = {.id = "small", .reader = &reader};
        struct encoder *encoder = encoder_new(format_named(FORMAT_RESULT, names[k]), &source,
                                              &(struct format_options){0}, &problem);
        assert_non_null(encoder);
        ssize_t length = 1;
        while (length > 0)
            length = encoder_read(encoder, piece, sizeof piece);
        assert_int_equal(length, -1);
        encoder_free(encoder);
    }
    bytes_free(&container);
}

static void test_formats_glb_of_no_nodes_is_refused(void **state) {
    (void)state;
    struct bytes container = small_result_of(NULL, 0, "mm");
    struct api_reader reader = reader_over(&container);
    struct api_problem problem = {0};
    const struct format_source source = {.id = "small", .reader = &reader};
    assert_null(encoder_new(format_named(FORMAT_RESULT, "glb"), &source,
                            &(struct format_options){0}, &problem));
    assert_int_equal(problem.id, API_INTERNAL);
    bytes_free(&container);
}

/* ---- drapes ---- */

static const char dome[] =
    "{\"surface\":{\"degree_u\":2,\"degree_v\":2,\"size_u\":3,\"size_v\":3,"
    "\"knotvector_u\":[0,0,0,1,1,1],\"knotvector_v\":[0,0,0,1,1,1],\"control_points\":"
    "[[-2,-2,0],[-2,0,1],[-2,2,0],[0,-2,1],[0,0,2],[0,2,1],[2,-2,0],[2,0,1],[2,2,0]],\"trims\":{"
    "\"count\":1,\"data\":[{\"type\":\"freeform\",\"points\":[[0.1,0.1],[0.3,0.1],[0.2,0.3]]}]}},"
    "\"fabric\":{\"spacing\":[0.5,0.4],\"thickness\":0.0005,\"fiber_volume_fraction\":0.5,"
    "\"locking_angle_deg\":8},\"start\":{\"uv\":[0.4,0.45]},\"direction\":{\"angle_deg\":10},"
    "\"rosette\":{\"origin\":[0,0,0],\"x\":[1,0,0],\"z\":[0,0,1]},%s}";

static struct bytes drape_dome(const char *more, struct bytes *request) {
    struct api_problem problem = {0};
    struct bytes container = {0};
    bytes_format(request, dome, more);
    if (run_text(request->data, &container, &problem) != API_OK)
        fail_msg("%s", problem.error[0].detail);
    return container;
}

/* What a hole, a cut, a part left bare, cells that are locked, warnings and errors add: whole
 * documents, of which the report is all that the drape has to say. */
static void test_formats_of_drapes_are_golden(void **state) {
    static const struct {
        const char *name, *more, *part, *ply;
        double allowance;
        enum api_table table;
    } drapes[] = {{"cut",
                   "\"method\":\"gib4\",\"cuts\":[{\"path\":[[2,0.2,0.5],[0.7,0.1,0.9]],"
                   "\"name\":\"<a>, \\\"b\\\" & c\",\"allowance\":0.005}]",
                   "Wing", "", 0.05, API_TABLE_CUTS},
                  {"bare", "\"length_unit\":\"mm\",\"extent\":{\"warp\":[-3,4],\"weft\":[-2,3]}",
                   "", "7", 0, API_TABLE_CELLS}};
    static const struct {
        enum format_use use;
        const char *name;
    } documents[] = {{FORMAT_PATTERN, "svg"},
                     {FORMAT_PATTERN, "dxf"},
                     {FORMAT_REPORT, "html"},
                     {FORMAT_RESULT, "csv"}};
    (void)state;
    for (size_t d = 0; d < sizeof drapes / sizeof *drapes; d++) {
        struct bytes request = {0}, container = drape_dome(drapes[d].more, &request);
        struct api_reader reader = reader_over(&container);
        struct format_options options = {.allowance = drapes[d].allowance,
                                         .partial = true,
                                         .table = drapes[d].table,
                                         .table_given = true};
        strcpy(options.part, drapes[d].part);
        strcpy(options.ply, drapes[d].ply);
        const struct format_source source = {
            .id = "small", .reader = &reader, .record = {.inputs = request.data, .digest = "d"}};
        for (size_t k = 0; k < sizeof documents / sizeof *documents; k++) {
            char name[32];
            struct bytes text =
                encode_source(format_named(documents[k].use, documents[k].name), &source, &options);
            snprintf(name, sizeof name, "%s.%s", drapes[d].name, documents[k].name);
            compare_golden(name, text.data, text.length);
            bytes_free(&text);
        }
        bytes_free(&request);
        bytes_free(&container);
    }
}

/* Cloth that leaves some of the part bare is cut only on demand; drawn it is in any case. */
static void test_formats_to_cut_by_are_of_whole_parts(void **state) {
    struct bytes request = {0}, container = drape_dome("\"extent\":{\"warp\":[-3,4]}", &request);
    struct api_reader reader = reader_over(&container);
    const struct format_source source = {.id = "small", .reader = &reader};
    const struct format *format;
    (void)state;
    for (size_t k = 0; (format = format_at(FORMAT_PATTERN, k)); k++)
        for (int partial = 0; partial < 2; partial++) {
            struct api_problem problem = {0};
            struct encoder *encoder = encoder_new(
                format, &source, &(struct format_options){.partial = partial}, &problem);
            if ((encoder != NULL) != (partial || strcmp(format->name, "svg") == 0))
                fail_msg("%s, %d: %s", format->name, partial, encoder ? "is made" : "is refused");
            encoder_free(encoder);
        }
    bytes_free(&request);
    bytes_free(&container);
}

/* What a piece had before its columns could not be read stays unsent, wherever it was made. */
static void test_formats_send_nothing_of_a_piece_that_failed(void **state) {
    enum { LARGE = 1 << 20 };
    static char document[LARGE];
    static const size_t sizes[] = {100, LARGE};
    (void)state;
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        struct bytes container = small_result();
        struct api_reader reader = reader_over(&container);
        struct api_problem problem = {0};
        const struct format_source source = {.id = "small", .reader = &reader};
        struct encoder *encoder = encoder_new(format_named(FORMAT_RESULT, "csv"), &source,
                                              &(struct format_options){0}, &problem);
        assert_non_null(encoder);
        container.length = 16;
        for (int again = 0; again < 2; again++)
            assert_int_equal(encoder_read(encoder, document, sizes[k]), -1);
        encoder_free(encoder);
        bytes_free(&container);
    }
}

/* ---- the outline ---- */

static struct outline outline_of(const int (*cells)[2], size_t count) {
    struct bytes container = small_result_of(cells, count, "m");
    struct api_reader reader = reader_over(&container);
    struct api_problem problem = {0};
    struct api_columns columns;
    struct outline outline = {0};
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    assert_int_equal(outline_make(&reader, &columns, &(struct outline_rim){0}, &outline, &problem),
                     API_OK);
    bytes_free(&container);
    return outline;
}

/* The area that the polygons enclose, holes counted negative; every corner is one. */
static long check_polygons(const struct polygons *outline, size_t *polygons) {
    long twice = 0;
    *polygons = 0;
    for (size_t first = 0, last; first < outline->count; first = last + 1) {
        for (last = first; !outline->points[last].last;)
            last++;
        size_t length = last - first + 1;
        check_at_least(length, 4);
        for (size_t k = 0; k < length; k++) {
            const struct polygons_point *p = &outline->points[first + k];
            const struct polygons_point *q = &outline->points[first + (k + 1) % length];
            const struct polygons_point *r = &outline->points[first + (k + 2) % length];
            assert_true((p->x == q->x) != (p->y == q->y));
            assert_true((p->x == q->x) != (q->x == r->x));
            twice += (long)(p->x * q->y - q->x * p->y);
        }
        ++*polygons;
    }
    return twice / 2;
}

static void test_outline_goes_round_cells_and_holes(void **state) {
    (void)state;
    static const int ring[][2] = {{0, 0}, {1, 0}, {2, 0}, {0, 1}, {2, 1}, {0, 2}, {1, 2}, {2, 2}};
    static const int touching[][2] = {{0, 0}, {1, 1}};
    size_t polygons;
    struct outline outline = outline_of(ring, 8);
    assert_int_equal(check_polygons(&outline.polygons, &polygons), 8);
    assert_int_equal(polygons, 2);
    assert_int_equal(outline.polygons.count, 8);
    assert_int_equal(outline.count, 16);
    outline_free(&outline);
    outline = outline_of(touching, 2);
    assert_int_equal(check_polygons(&outline.polygons, &polygons), 2);
    assert_int_equal(polygons, 2);
    outline_free(&outline);
}

static void test_outline_encloses_the_area_of_random_cells(void **state) {
    (void)state;
    enum { SIZE = 12, ROUNDS = 200 };
    struct random random = random_begin("outline");
    for (int round = 0; round < ROUNDS; round++) {
        int cells[SIZE * SIZE][2];
        size_t count = 0, polygons;
        int density = 1 + random_index(&random, 9);
        for (int j = 0; j < SIZE; j++)
            for (int i = 0; i < SIZE; i++)
                if (random_index(&random, 10) < density && (j != 5 || round % 2)) {
                    cells[count][0] = i - 6;
                    cells[count++][1] = j - 6;
                }
        if (count == 0)
            continue;
        struct outline outline = outline_of((const int(*)[2])cells, count);
        assert_int_equal(check_polygons(&outline.polygons, &polygons), count);
        outline_free(&outline);
    }
}

/* ---- parts ---- */

static void test_fieldset_groups_vectors_and_tensors(void **state) {
    (void)state;
    static const char *const names[] = {"k1",  "k1_x", "k1_y", "k1_z", "kxx",    "kyy",
                                        "kzz", "kxy",  "kyz",  "kxz",  "warp_x", "warp_y"};
    static const struct {
        const char *name;
        int components;
    } expected[] = {
        {"k1", 1}, {"k1_direction", 3}, {"permeability", 6}, {"warp_x", 1}, {"warp_y", 1}};
    enum { NAMES = sizeof names / sizeof *names };
    struct api_column_source columns[NAMES];
    size_t at = 0;
    for (size_t k = 0; k < NAMES; k++)
        columns[k] = (struct api_column_source){.table = API_TABLE_CELLS, .name = names[k]};
    for (size_t k = 0; k < sizeof expected / sizeof *expected; k++) {
        struct fieldset_field field = fieldset_first(columns + at, NAMES - at);
        assert_string_equal(field.name, expected[k].name);
        assert_int_equal(field.components, expected[k].components);
        at += (size_t)field.components;
    }
    assert_int_equal(at, NAMES);
}

static void test_fieldset_tensor_has_the_given_principal_values(void **state) {
    (void)state;
    double c = cos(0.3), s = sin(0.3), tensor[6];
    const double values[FIELDSET_TENSOR_COLUMNS] = {5, 2, 1, c, s, 0, 1, 0, 0, 0.5, 1, 0};
    const double expected[6] = {5 * c * c + 2 * s * s, 5 * s * s + 2 * c * c, 1, 3 * c * s, 0, 0};
    fieldset_tensor(values, tensor);
    for (int k = 0; k < 6; k++)
        check_below(fabs(tensor[k] - expected[k]), 1e-14);
}

static void test_colour_grows_lighter_evenly(void **state) {
    (void)state;
    double before = -1;
    for (int k = 0; k <= 100; k++) {
        double srgb[3];
        colour_viridis(k / 100.0, srgb);
        double luminance = 0.2126 * colour_linear(srgb[0]) + 0.7152 * colour_linear(srgb[1]) +
                           0.0722 * colour_linear(srgb[2]);
        double lightness = 116 * cbrt(luminance) - 16; /* CIE L*, here above its linear part */
        assert_true(k == 0 || (lightness > before && lightness < before + 1.6));
        before = lightness;
    }
}

/* ---- meshes ---- */

static void test_formats_vtu_is_golden(void **state) {
    (void)state;
    struct map_fields fields = small_mesh();
    struct bytes text = encode_mesh("vtu", &fields);
    compare_golden("small.vtu", text.data, text.length);
    bytes_free(&text);
}

/* As it is; a quadrilateral that ends at the first vertex; and one too dense to be filled. The
 * bytes are those of Debian's libhdf5 1.10. */
static void test_formats_lcmsim_h5_is_golden(void **state) {
    static const uint8_t roles[] = {MAP_FABRIC, MAP_INLET};
    static const int32_t turned[][4] = {{1, 2, 3, 0}, {1, 4, 2, -1}};
    static const char *const names[] = {"small", "turned", "dense"};
    (void)state;
    for (int k = 0; k < 3; k++) {
        struct map_fields fields = small_mesh();
        char name[32];
        if (k == 2)
            small_mesh_set("porosity", 0, -0.25);
        fields.elements = k == 1 ? turned : fields.elements;
        fields.roles = roles;
        struct bytes text = encode_mesh("lcmsim-h5", &fields);
        snprintf(name, sizeof name, "%s.lcmsim-h5", names[k]);
        compare_golden(name, text.data, text.length);
        bytes_free(&text);
    }
}

/* What a document had open in HDF5's library is closed: each takes as much memory as the last. (It
 * is not counted under a sanitizer.) */
static void test_formats_lcmsim_h5_closes_all(void **state) {
    enum { FIRST = 10, DOCUMENTS = 60 };
    static const uint8_t roles[] = {MAP_FABRIC, MAP_INLET};
    size_t used = 0;
    (void)state;
    for (int k = 0; k < DOCUMENTS; k++) {
        struct map_fields fields = small_mesh();
        fields.roles = roles;
        fields.revision = "r";
        struct bytes text = encode_mesh("lcmsim-h5", &fields);
        bytes_free(&text);
        used = k < FIRST ? mallinfo2().uordblks : used;
    }
    check_at_most((double)mallinfo2().uordblks - (double)used, 0);
}

/* Two plies, of which the second has the second's one piece. */
static void test_formats_compost_is_golden(void **state) {
    (void)state;
    struct map_fields fields = small_stack();
    struct map_plies plies = *fields.plies;
    static const int numbers[][2] = {{1, 0}, {2, 1}};
    plies.numbers = numbers;
    fields.plies = &plies;
    struct bytes text = encode_mesh("compost", &fields);
    compare_golden("small.compost", text.data, text.length);
    bytes_free(&text);
}

static void test_formats_lims_is_golden(void **state) {
    (void)state;
    static const uint8_t roles[] = {MAP_FABRIC, MAP_INLET};
    struct map_fields fields = small_stack();
    fields.roles = roles;
    struct bytes text = encode_mesh("lims", &fields);
    compare_golden("small.lims", text.data, text.length);
    bytes_free(&text);
}

/* ---- decks ---- */

/* A, B and D are stiffness by the first, second and third power of the length: the same numbers in
 * another unit are others by its powers. */
static void test_format_abd_is_in_units_of_metres(void **state) {
    static const struct lamina carbon = {110e9, 6e9, 0.3, 2e9};
    const struct map_ply_kind kinds[] = {{1, carbon}, {0.6, carbon}};
    double values[2][3 * LAMINA_ENTRIES];
    (void)state;
    for (int k = 0; k < 2; k++) {
        struct map_fields fields = small_stack();
        struct map_plies plies = *fields.plies;
        struct api_unit unit = *fields.unit;
        unit.metres = k ? 1e-3 : 1;
        plies.kinds = kinds;
        fields.plies = &plies;
        fields.unit = &unit;
        struct bytes text = encode_mesh("abd", &fields);
        const char *at = strstr(text.data, "\n17,");
        assert_non_null(at);
        at += 3;
        for (int n = 0; n < 3 * LAMINA_ENTRIES; n++) {
            char *end;
            assert_int_equal(*at, ',');
            values[k][n] = strtod(at + 1, &end);
            at = end;
        }
        bytes_free(&text);
    }
    for (int n = 0; n < 3 * LAMINA_ENTRIES; n++)
        check_at_most(fabs(values[1][n] - values[0][n] * pow(1e-3, 1 + n / LAMINA_ENTRIES)),
                      1e-12 * fabs(values[1][0]));
    check_above(values[0][0], 1e9);
}

/* Meshes with sets are read as they were written, by the readers of such files. */
static void test_formats_of_meshes_are_read_back(void **state) {
    enum { ELEMENTS = 7 };
    static const int32_t pids[ELEMENTS] = {1, 1, 2, 1, 2, 1, 1};
    static const struct map_set sets[] = {{"SKIN", 1}, {"edge", 2}, {"nowhere", 9}};
    static const struct {
        const char *format;
        mesh_reader *read;
    } rows[] = {{"gmsh", map_target_gmsh}, {"unv", map_target_universal}};
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        struct map_fields fields = small_strip(ELEMENTS, 10);
        struct arena *arena = arena_new((size_t)1 << 26);
        char name[32];
        fields.pids = pids;
        fields.sets = sets;
        fields.set_count = 3;
        struct bytes text = encode_mesh(rows[k].format, &fields);
        struct map_target mesh = mesh_text_good(rows[k].read, text.data, arena);
        assert_int_equal(mesh.vertex_count, fields.vertex_count);
        assert_int_equal(mesh.element_count, ELEMENTS);
        assert_memory_equal(mesh.elements, fields.elements, ELEMENTS * sizeof *mesh.elements);
        assert_memory_equal(mesh.pids, pids, sizeof pids);
        for (size_t v = 0; v < mesh.vertex_count; v++)
            assert_true(vec3_distance(mesh.vertices[v], fields.vertices[v]) < 1e-9);
        assert_non_null(mesh.warning);
        assert_non_null(strstr(mesh.warning, "properties: 1 SKIN, 2 edge"));
        assert_null(strstr(mesh.warning, "nowhere"));
        snprintf(name, sizeof name, "sets.%s", rows[k].format);
        compare_golden(name, text.data, text.length);
        bytes_free(&text);
        small_strip_free(&fields);
        arena_free(arena);
    }
}

static const char *const decks[] = {"nastran", "optistruct", "radioss",
                                    "lsdyna",  "abaqus",     "calculix"};
enum { DECKS = sizeof decks / sizeof *decks };

/* As they are, and with constants and a rosette. Those of one sequence for all elements are of
 * elements that look to one side. */
static void test_formats_of_decks_are_golden(void **state) {
    static const struct lamina carbon = {110e9, 6e9, 0.3, 2e9};
    static const struct map_ply_kind kinds[] = {{1, carbon}, {0.6, carbon}};
    static const struct api_rosette rosette = {{1, 2, 3}, {2, 0, 0}, {1, 0, 3}};
    (void)state;
    for (size_t k = 0; k < 2 * DECKS; k++) {
        struct map_fields fields = small_stack();
        struct map_plies plies = *fields.plies;
        struct map_ply_row rows[3];
        const char *deck = decks[k / 2];
        bool full = k % 2;
        char name[32];
        if (strcmp(deck, "optistruct") == 0 || strcmp(deck, "radioss") == 0) {
            memcpy(rows, plies.rows, sizeof rows);
            rows[2].mirrored = false;
            plies.rows = rows;
        }
        plies.kinds = full ? kinds : NULL;
        fields.rosette = full ? &rosette : NULL;
        fields.plies = &plies;
        struct bytes text = encode_mesh(deck, &fields);
        snprintf(name, sizeof name, "%s.%s", full ? "full" : "small", deck);
        compare_golden(name, text.data, text.length);
        bytes_free(&text);
    }
}

static void check_refused(const char *name, const struct map_fields *fields, enum api_problem_id id,
                          const char *detail) {
    struct api_problem problem = {0};
    const struct format_source source = {.id = "small", .fields = fields};
    assert_null(encoder_new(format_named(FORMAT_MAP, name), &source, &(struct format_options){0},
                            &problem));
    assert_int_equal(problem.id, id);
    if (!strstr(problem.error[0].detail, detail))
        fail_msg("%s: %s", name, problem.error[0].detail);
}

static void test_formats_of_decks_say_what_they_cannot_hold(void **state) {
    (void)state;
    struct map_fields fields = small_stack();
    struct map_plies plies = *fields.plies;
    static const int32_t large[] = {17, 100000000};
    check_refused("optistruct", &fields, API_INVALID_REQUEST,
                  "1 elements face one side and 1, such");
    check_refused("radioss", &fields, API_INVALID_REQUEST, "1 elements face one side and 1, such");
    fields.ids = large;
    check_refused("lsdyna", &fields, API_TOO_LARGE, "100000000");
    struct map_ply_row rows[3];
    memcpy(rows, plies.rows, sizeof rows);
    rows[2].mirrored = false;
    plies.rows = rows;
    fields.plies = &plies;
    plies.reference = NULL;
    check_refused("radioss", &fields, API_INVALID_REQUEST, "reference=x,y,z");
    plies.ply_count = 201;
    check_refused("calculix", &fields, API_TOO_LARGE, "at most 200");
    plies.thickness = false;
    for (size_t k = 0; k < DECKS; k++)
        check_refused(decks[k], &fields, API_INVALID_REQUEST, "fabric.thickness");
    plies.row_count = 0;
    for (size_t k = 0; k < DECKS; k++)
        check_refused(decks[k], &fields, API_INVALID_REQUEST, "none of the 2 elements");
}

/* What may be asked of a map, and each format's answer: h, it is in the document; r, it is refused,
 * in words that name the format and another one. (These maps have no columns of plies, of which vtu
 * takes 80.) */
enum { ASK_GATES, ASK_YARNS, ASK_SIDES, ASK_NO_THICKNESS, ASK_MANY_PLIES, ASKED };
static const struct {
    const char *name, *answers;
} answers[] = {{"json", "hrhhh"},       {"csv", "hrhhh"},       {"vtu", "hrhhh"},
               {"gmsh", "hrhhh"},       {"unv", "hrhhh"},       {"lcmsim", "hrhhh"},
               {"lims", "hrhhh"},       {"lcmsim-h5", "hrhhh"}, {"nastran", "rhhrr"},
               {"lsdyna", "rhhrr"},     {"abaqus", "rhhrr"},    {"calculix", "rhhrr"},
               {"acp", "rrhhr"},        {"compost", "rrhhh"},   {"abd", "rhhrh"},
               {"optistruct", "rhrrr"}, {"radioss", "rhrrr"}};

static void check_answer(const struct format *format, int asked, char answer,
                         const struct map_fields *fields) {
    struct api_problem problem = {0};
    const struct format_source source = {.id = "small", .fields = fields};
    const struct format_options options = {.plies_as = asked == ASK_YARNS ? PLIES_AS_YARNS : 0};
    struct encoder *encoder = encoder_new(format, &source, &options, &problem);
    encoder_free(encoder);
    if ((encoder != NULL) != (answer == 'h'))
        fail_msg("%s, %d: %s", format->name, asked, encoder ? "made" : problem.error[0].detail);
    bool other = false;
    for (size_t k = 0; k < sizeof answers / sizeof *answers; k++)
        other = other || (strcmp(answers[k].name, format->name) != 0 && !encoder &&
                          strstr(problem.error[0].detail, answers[k].name));
    if (!encoder && !(other && strstr(problem.error[0].detail, format->name)))
        fail_msg("%s, %d: %s", format->name, asked, problem.error[0].detail);
}

static void test_formats_hold_what_is_asked_or_name_one_that_does(void **state) {
    (void)state;
    static const struct map_ply_kind kind = {0.5, {110e9, 6e9, 0.3, 2e9}};
    static struct map_ply_kind kinds[MAP_PLIES_MAX];
    static const char *names[MAP_PLIES_MAX];
    static const uint8_t roles[] = {MAP_INLET, MAP_CHANNEL};
    const struct format *format;
    for (size_t k = 0; k < MAP_PLIES_MAX; k++) {
        kinds[k] = kind;
        names[k] = "ply";
    }
    for (size_t k = 0; (format = format_at(FORMAT_MAP, k)); k++) {
        const char *own = NULL;
        for (size_t n = 0; n < sizeof answers / sizeof *answers; n++)
            own = strcmp(answers[n].name, format->name) == 0 ? answers[n].answers : own;
        assert_non_null(own);
        for (int asked = 0; asked < ASKED; asked++) {
            struct map_fields fields = small_stack();
            struct map_plies plies = *fields.plies;
            struct map_ply_row rows[3];
            memcpy(rows, plies.rows, sizeof rows);
            rows[2].mirrored = rows[2].mirrored && asked == ASK_SIDES;
            plies.rows = rows;
            plies.kinds = kinds;
            plies.names = names;
            plies.thickness = asked != ASK_NO_THICKNESS;
            plies.ply_count = asked == ASK_MANY_PLIES ? 300 : plies.ply_count;
            fields.roles = asked == ASK_GATES ? roles : NULL;
            fields.channel_permeability = 1e-8;
            fields.plies = &plies;
            check_answer(format, asked, own[asked], &fields);
        }
    }
}

/* From an element's bottom along its normal: on the quadrilateral the plies go against it, on the
 * flipped triangle along it. */
static void test_stack_layers_follow_the_normal_of_the_element(void **state) {
    (void)state;
    struct map_fields fields = small_stack();
    struct map_plies plies = *fields.plies;
    for (int side = -1; side <= 1; side += 2)
        for (int mirrored = 0; mirrored < 2; mirrored++) {
            struct map_ply_row rows[3];
            memcpy(rows, small_stack().plies->rows, sizeof rows);
            rows[0].mirrored = rows[1].mirrored = mirrored;
            plies.rows = rows;
            plies.side = side;
            fields.plies = &plies;
            bool along = (side > 0) != mirrored;
            assert_int_equal(stack_layers(&fields, 0), 2);
            assert_int_equal(stack_layer(&fields, 0, 0)->ply, along ? 0 : 1);
            assert_int_equal(stack_layer(&fields, 0, 1)->ply, along ? 1 : 0);
        }
}

/* Like stacks are one group; angles count from the bottom ply, as fibres. */
static void test_stacks_are_grouped_within_what_is_asked(void **state) {
    (void)state;
    enum { COUNT = 100 };
    static struct map_ply_row rows[2 * COUNT];
    static size_t first[COUNT + 1];
    struct map_plies plies = *small_stack().plies;
    struct map_fields fields = {.element_count = COUNT, .plies = &plies};
    for (int32_t e = 0; e < COUNT; e++) {
        rows[2 * e] = (struct map_ply_row){e, 0, true, 7 * e, 0, 0.5 * (1 + 1e-4 * (e % 10)), 0};
        rows[2 * e + 1] =
            (struct map_ply_row){e, 1, true, 7 * e + 90 + 0.01 * (e / 50), 0, 0.25, 0};
        first[e + 1] = 2 * (size_t)e + 2;
    }
    plies.rows = rows;
    plies.first = first;
    static const struct {
        bool angles;
        double within;
        size_t count;
    } cases[] = {{true, 0, 20}, {false, 0, 10}, {true, 10, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct stack_groups groups;
        size_t seen = 0;
        assert_true(stack_groups_make(&groups, &fields, cases[k].angles, cases[k].within));
        assert_int_equal(groups.count, cases[k].count);
        for (size_t g = 0; g < groups.count; g++)
            for (size_t m = groups.start[g]; m < groups.start[g + 1]; m++, seen++) {
                const struct map_ply_row *row = &rows[2 * groups.member[m]];
                const struct stack_layer *layer = &groups.layer[groups.first[g]];
                assert_int_equal(groups.group[groups.member[m]], g);
                double turn = row[1].angle_deg - row[0].angle_deg - layer[1].angle_deg;
                check_below(fabs(row[0].thickness / layer[0].thickness - 1),
                            groups.thickness_percent / 100 + 1e-12);
                check_below(fabs(element_fold_deg(turn)),
                            cases[k].angles ? groups.angle_deg + 1e-9 : 91);
            }
        check_below(groups.thickness_percent, fmax(cases[k].within, 1e-7) + 1e-9);
        check_below(groups.angle_deg, cases[k].angles ? fmax(cases[k].within, 1e-7) + 1e-9 : 1);
        assert_int_equal(seen, COUNT);
        stack_groups_free(&groups);
    }
}

/* The mesh as a case. */
static struct bytes encode_case(const struct map_fields *fields, int version, double cap) {
    struct format_options options = {0};
    options.lcmsim_version = version;
    options.fiber_volume_fraction = cap;
    return encode_source(format_named(FORMAT_MAP, "lcmsim"),
                         &(struct format_source){.id = "small", .fields = fields}, &options);
}

/* As it is; with an inlet and an outlet for version 2; with a channel; of elements that are too
 * dense, capped. */
static void test_formats_lcmsim_is_golden(void **state) {
    (void)state;
    static const char *const names[] = {"mesh.bdf", "part_description.csv", "simulation_params.csv",
                                        "README.txt", "dense_elements.csv"};
    static const uint8_t inlet[] = {MAP_FABRIC, MAP_INLET}, both[] = {MAP_OUTLET, MAP_INLET},
                         channel[] = {MAP_INLET, MAP_CHANNEL};
    static const struct {
        const char *folder;
        int version;
        const uint8_t *roles;
        double porosity, cap; /* the first element's */
    } cases[] = {{"lcmsim", 0, NULL, 0.604, 0},       {"lcmsim_inlet", 0, inlet, 0.604, 0},
                 {"lcmsim_gates", 2, both, 0.604, 0}, {"lcmsim_channel", 3, channel, 0.604, 0},
                 {"lcmsim_dense", 3, NULL, -0.25, 0}, {"lcmsim_capped", 3, NULL, -0.25, 0.7}};
    for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
        struct map_fields fields = small_mesh();
        small_mesh_set("porosity", 0, cases[c].porosity);
        fields.roles = cases[c].roles;
        fields.channel_permeability = 1e-8;
        struct bytes zip = encode_case(&fields, cases[c].version, cases[c].cap);
        for (size_t k = 0; k < (cases[c].porosity < 0 ? 5 : 4); k++) {
            char name[64];
            struct bytes text = unzip(&zip, names[k]);
            snprintf(name, sizeof name, "%s/%s", cases[c].folder, names[k]);
            compare_golden(name, text.data, text.length);
            bytes_free(&text);
        }
        bytes_free(&zip);
    }
}

/* A quadrilateral whose last corner is the first vertex is two triangles as any other. */
static void test_lcmsim_halves_quadrilaterals_that_end_at_the_first_vertex(void **state) {
    static const int32_t turned[][4] = {{1, 2, 3, 0}, {1, 4, 2, -1}};
    struct map_fields fields = small_mesh();
    struct bytes as_it_is = encode_mesh("lcmsim-h5", &fields);
    size_t triangles = 0;
    (void)state;
    fields.elements = turned;
    struct bytes zip = encode_case(&fields, 3, 0), mesh = unzip(&zip, "mesh.bdf");
    for (const char *at = mesh.data; (at = strstr(at, "CTRIA3")); at++)
        triangles++;
    assert_int_equal(triangles, 3);
    struct bytes other = encode_mesh("lcmsim-h5", &fields);
    assert_int_equal(other.length, as_it_is.length);
    bytes_free(&as_it_is);
    bytes_free(&other);
    bytes_free(&mesh);
    bytes_free(&zip);
}

/* Elements at the cap have 1 - cap for a porosity, and Kozeny and Carman's permeability there. */
static void test_lcmsim_caps_dense_elements(void **state) {
    (void)state;
    struct map_fields fields = small_mesh();
    struct lcmsim_source source;
    struct lcmsim_inputs own, capped;
    struct api_problem problem = {0};
    small_mesh_set("porosity", 0, 0.1);
    assert_true(lcmsim_open(&source, &fields, 0.5, &problem));
    assert_int_equal(lcmsim_read(&source, 1, &own), LCMSIM_AS_IT_IS);
    assert_int_equal(lcmsim_read(&source, 0, &capped), LCMSIM_CAPPED);
    check_at_most(fabs(lcmsim_fraction(&source, 0) - 0.9), 1e-15);
    check_at_most(fabs(capped.porosity - 0.5), 1e-15);
    double ratio = (pow(0.5, 3) / pow(0.5, 2)) / (pow(0.604, 3) / pow(0.396, 2));
    check_at_most(fabs(capped.k1 / own.k1 / ratio - 1), 1e-14);
    check_at_most(fabs(capped.k2 / own.k2 / ratio - 1), 1e-14);
    check_at_most(fabs(capped.k3 / own.k3 / ratio - 1), 1e-14);
    check_at_most(fabs(capped.thickness - 3e-3), 1e-15); /* its own */
    check_at_most(fabs(capped.direction.x - 1), 1e-15);
}

/* More than a piece of the archive holds, packed: nothing is lost between pieces. */
static void test_lcmsim_of_many_elements_is_whole(void **state) {
    enum { MANY = 20000 };
    struct map_fields fields = small_strip(MANY, 1);
    struct bytes zip = encode_case(&fields, 3, 0), mesh = unzip(&zip, "mesh.bdf");
    size_t triangles = 0;
    (void)state;
    for (const char *at = mesh.data; (at = strstr(at, "CTRIA3")); at++)
        triangles++;
    assert_int_equal(triangles, 2 * MANY);
    assert_memory_equal(mesh.data + mesh.length - 8, "ENDDATA\n", 8);
    bytes_free(&mesh);
    bytes_free(&zip);
    small_strip_free(&fields);
}

/* A stack that is pressed gives way to the resin unless that is more than LCMsim takes, or it would
 * not grow, or version 2 or a channel is to: the porosities and pressures of its parts, the
 * exponent of its permeability and the factor of that, by K e^3 / (1 - e)^2. */
static void test_lcmsim_parts_give_way_as_the_stack_does(void **state) {
    static const struct {
        double porosity, relieved[MAP_RELIEFS];
        int version;
        bool own;
    } rows[] = {{0.6, {0.62, 0.63}, 3, true},     {0.6, {0.6 + 1e-9, 0.63}, 3, true},
                {0.6, {0.6, 0.63}, 3, false},     {0.9, {0.94, 0.97466}, 3, true},
                {0.9, {0.94, 0.97467}, 3, false}, {0.995, {0, 0}, 3, false},
                {0.6, {0.62, 0.63}, 2, false}};
    static const double relief[MAP_RELIEFS] = {4e4, 8e4};
    static const uint8_t roles[] = {MAP_FABRIC, MAP_CHANNEL};
    enum { NUMBERS = 15, FIRST_E = 9, EXPONENT = 13 };
    (void)state;
    for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
        const double e0 = fmin(rows[r].porosity, 0.99),
                     relieved[MAP_RELIEFS][2] = {{rows[r].relieved[0], rows[r].relieved[0]},
                                                 {rows[r].relieved[1], rows[r].relieved[1]}};
        struct map_fields fields = small_mesh();
        for (size_t k = 0; k < 2; k++) {
            small_mesh_set("porosity", k, rows[r].porosity);
            fields.relief[k] = relief[k];
            fields.relieved[k] = rows[r].relieved[k] > 0 ? relieved[k] : NULL;
        }
        fields.roles = roles;
        fields.channel_permeability = 1e-8;
        struct bytes zip = encode_case(&fields, rows[r].version, 0);
        struct bytes text = unzip(&zip, "part_description.csv");
        for (int channel = 0; channel < 2; channel++) {
            char *at = strstr(text.data, channel ? ",patch," : ",base,");
            double v[NUMBERS] = {0};
            bool own = rows[r].own && !channel;
            for (int skip = 0; skip < 2 && at; skip++)
                at = strchr(at + 1, ',');
            assert_non_null(at);
            for (int n = 0; n < NUMBERS && at && *at == ','; n++)
                v[n] = strtod(at + 1, &at);
            check_at_most(fabs(v[1] - e0), 1e-9);
            check_at_most(fabs(v[FIRST_E] - (own ? rows[r].relieved[0] : e0)), 1e-8);
            check_at_most(fabs(v[FIRST_E + 1] - (own ? relief[0] : 0.9e5)), 1e-3);
            if (rows[r].version == 3) {
                check_at_most(fabs(v[FIRST_E + 2] - (own ? rows[r].relieved[1] : e0)), 1e-8);
                check_at_most(fabs(v[FIRST_E + 3] - (own ? relief[1] : 1e5)), 1e-3);
                assert_true(v[EXPONENT] == (own ? 2 : 0));
                assert_true(channel || fabs(v[EXPONENT + 1] / v[3] - 1e-12 / 1.63e-10) < 1e-9);
            }
            double k1 = channel ? 1e-8 : 1.63e-10;
            k1 *= own ? pow(1 - e0, 2) / pow(e0, 3) : 1;
            check_at_most(fabs(v[3] / k1 - 1), 1e-8);
        }
        bytes_free(&text);
        bytes_free(&zip);
    }
}

/* One more than numbers have room for is refused before anything of it is read. */
static void test_lcmsim_of_too_much_is_refused(void **state) {
    (void)state;
    for (int elements = 0; elements < 2; elements++) {
        struct map_fields fields = small_mesh();
        struct lcmsim_source source;
        struct api_problem problem = {0};
        if (elements)
            fields.element_count = LCMSIM_NUMBER_MAX / 2 + 1;
        else
            fields.vertex_count = (size_t)LCMSIM_NUMBER_MAX + 1;
        assert_false(lcmsim_open(&source, &fields, 0, &problem));
        assert_int_equal(problem.id, API_TOO_LARGE);
    }
}

static void test_lcmsim_of_nothing_to_fill_is_refused(void **state) {
    (void)state;
    struct map_fields fields = small_mesh();
    struct lcmsim_source source;
    for (int capped = 0; capped < 2; capped++) {
        struct api_problem problem = {0};
        small_mesh_set("porosity", 0, -0.1);
        small_mesh_set("k1", 1, 0);
        assert_false(lcmsim_open(&source, &fields, capped ? 0.6 : 0, &problem));
        assert_int_equal(problem.id, API_INVALID_REQUEST);
        assert_non_null(strstr(problem.error[0].detail, "none of the 2 elements can be filled"));
    }
    (void)small_mesh();
}

/* 95 % of the area keep to the bound; 90 % of them to a smaller one. */
static void test_lcmsim_tells_how_far_most_elements_differ(void **state) {
    (void)state;
    struct map_fields fields = small_strip(5000, 0.036);
    struct lcmsim_source source;
    struct lcmsim_bins bins;
    struct api_problem problem = {0};
    struct lcmsim_inputs in;
    assert_true(lcmsim_open(&source, &fields, 0, &problem) && lcmsim_make_bins(&bins, &source));
    size_t within = 0, well_within = 0;
    for (size_t k = 0; k < fields.element_count; k++) {
        lcmsim_read(&source, k, &in);
        double mean = bins.bin[bins.part[k] - LCMSIM_FIRST_PART].thickness;
        double difference = fabs(in.thickness / mean - 1);
        check_at_most(difference, 1.000001 * bins.largest[LCMSIM_THICKNESS]);
        within += difference <= 1.000001 * bins.most[LCMSIM_THICKNESS];
        well_within += difference <= 0.97 * bins.most[LCMSIM_THICKNESS];
    }
    check_above((double)within, 0.95 * 5000 - 1);
    check_below((double)well_within, 0.95 * 5000);
    lcmsim_free_bins(&bins);
    small_strip_free(&fields);
}

static void test_formats_lcmsim_says_what_it_lacks(void **state) {
    (void)state;
    struct map_fields fields = small_mesh();
    struct api_problem problem = {0};
    fields.column_count = 3;
    const struct format_source source = {.id = "small", .fields = &fields};
    assert_null(encoder_new(format_named(FORMAT_MAP, "lcmsim"), &source,
                            &(struct format_options){0}, &problem));
    assert_int_equal(problem.id, API_INVALID_REQUEST);
    assert_non_null(strstr(problem.error[0].detail, "no k1"));
}

static void test_lcmsim_fields_are_the_closest_of_eight_characters(void **state) {
    (void)state;
    static const struct {
        double value;
        const char *field;
    } cases[] = {{0, "     0.0"},           {1.5, "     1.5"},         {-1.23456789, "-1.23457"},
                 {123456.789, "123456.8"},  {1234567.891, "1.2346+6"}, {1.23456e-4, "1.2346-4"},
                 {-1.23456e-10, "-1.23-10"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char field[9] = "";
        lcmsim_field(cases[k].value, field);
        assert_string_equal(field, cases[k].field);
    }
}

/* Reads a field as LCMsim does: no E, a sign within begins the exponent. */
static double read_field(const char *field) {
    char text[32];
    size_t length = 0;
    for (int k = 0; k < 8; k++) {
        bool exponent = (field[k] == '-' || field[k] == '+') && length > 0;
        if (exponent)
            text[length++] = 'e';
        if (field[k] != ' ' && field[k] != 'e' && field[k] != 'E')
            text[length++] = field[k];
    }
    text[length] = '\0';
    return strtod(text, NULL);
}

static void test_lcmsim_fields_read_back(void **state) {
    (void)state;
    struct random random = random_begin("lcmsim");
    for (int k = 0; k < 20000; k++) {
        double value = random_between(&random, -1, 1) * pow(10, random_between(&random, -12, 7));
        char field[9] = "";
        lcmsim_field(value, field);
        assert_int_equal(strlen(field), 8);
        check_at_most(fabs(read_field(field) - value), 6e-3 * fabs(value));
        if (fabs(value) > 1e-3 && fabs(value) < 1e5)
            check_at_most(fabs(read_field(field) - value), 1.2e-3 * fabs(value));
    }
}

static void make_bins(struct lcmsim_bins *bins, const struct map_fields *fields) {
    struct lcmsim_source source;
    struct api_problem problem = {0};
    assert_true(lcmsim_open(&source, fields, 0, &problem));
    assert_true(lcmsim_make_bins(bins, &source));
}

static void test_lcmsim_bins_are_at_most_125_and_alike(void **state) {
    (void)state;
    struct map_fields fields = small_strip(5000, 0.036); /* half a turn */
    struct lcmsim_bins bins;
    bool used[256] = {false};
    make_bins(&bins, &fields);
    assert_int_equal(bins.count, LCMSIM_BINS_MAX);
    check_below(bins.largest[LCMSIM_DIRECTION], 2);
    check_below(bins.largest[LCMSIM_THICKNESS], 0.03);
    for (size_t k = 0; k < fields.element_count; k++)
        used[bins.part[k]] = true;
    for (size_t part = 0; part < 256; part++)
        assert_int_equal(used[part], part >= 2 && part < 2 + bins.count);
    lcmsim_free_bins(&bins);
    small_strip_free(&fields);
}

static void test_lcmsim_bins_of_like_elements_are_one(void **state) {
    (void)state;
    struct map_fields fields = small_strip(300, 0);
    struct lcmsim_bins bins;
    make_bins(&bins, &fields);
    assert_int_equal(bins.count, 1);
    check_below(bins.largest[LCMSIM_DIRECTION], 1e-6);
    check_below(bins.largest[LCMSIM_K1], 1e-12);
    check_below(bins.largest[LCMSIM_THICKNESS], 1e-12);
    lcmsim_free_bins(&bins);
    small_strip_free(&fields);
}

/* Directions that differ by half a turn are the same. */
static void test_lcmsim_bins_know_no_sign_of_direction(void **state) {
    (void)state;
    struct map_fields fields = small_strip(4, 180);
    struct lcmsim_bins bins;
    make_bins(&bins, &fields);
    assert_int_equal(bins.count, 1);
    check_above(fabs(bins.bin[0].direction.x), 1 - 1e-12);
    lcmsim_free_bins(&bins);
    small_strip_free(&fields);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pattern_shows_zero_as_before_the_shear),
        cmocka_unit_test(test_dxf_says_its_unit),
        cmocka_unit_test(test_formats_of_results_are_golden),
        cmocka_unit_test(test_formats_of_patterns_are_golden),
        cmocka_unit_test(test_formats_are_found_within_their_use_alone),
        cmocka_unit_test(test_formats_refuse_cells_without_corners),
        cmocka_unit_test(test_formats_glb_of_no_nodes_is_refused),
        cmocka_unit_test(test_formats_of_drapes_are_golden),
        cmocka_unit_test(test_formats_to_cut_by_are_of_whole_parts),
        cmocka_unit_test(test_formats_send_nothing_of_a_piece_that_failed),
        cmocka_unit_test(test_outline_goes_round_cells_and_holes),
        cmocka_unit_test(test_outline_encloses_the_area_of_random_cells),
        cmocka_unit_test(test_fieldset_groups_vectors_and_tensors),
        cmocka_unit_test(test_fieldset_tensor_has_the_given_principal_values),
        cmocka_unit_test(test_colour_grows_lighter_evenly),
        cmocka_unit_test(test_formats_vtu_is_golden),
        cmocka_unit_test(test_formats_lcmsim_h5_is_golden),
        cmocka_unit_test(test_formats_lcmsim_h5_closes_all),
        cmocka_unit_test(test_formats_compost_is_golden),
        cmocka_unit_test(test_formats_lims_is_golden),
        cmocka_unit_test(test_format_abd_is_in_units_of_metres),
        cmocka_unit_test(test_formats_of_meshes_are_read_back),
        cmocka_unit_test(test_formats_of_decks_are_golden),
        cmocka_unit_test(test_formats_of_decks_say_what_they_cannot_hold),
        cmocka_unit_test(test_formats_hold_what_is_asked_or_name_one_that_does),
        cmocka_unit_test(test_stack_layers_follow_the_normal_of_the_element),
        cmocka_unit_test(test_stacks_are_grouped_within_what_is_asked),
        cmocka_unit_test(test_formats_lcmsim_is_golden),
        cmocka_unit_test(test_formats_lcmsim_says_what_it_lacks),
        cmocka_unit_test(test_lcmsim_fields_are_the_closest_of_eight_characters),
        cmocka_unit_test(test_lcmsim_fields_read_back),
        cmocka_unit_test(test_lcmsim_halves_quadrilaterals_that_end_at_the_first_vertex),
        cmocka_unit_test(test_lcmsim_caps_dense_elements),
        cmocka_unit_test(test_lcmsim_of_many_elements_is_whole),
        cmocka_unit_test(test_lcmsim_parts_give_way_as_the_stack_does),
        cmocka_unit_test(test_lcmsim_of_too_much_is_refused),
        cmocka_unit_test(test_lcmsim_of_nothing_to_fill_is_refused),
        cmocka_unit_test(test_lcmsim_tells_how_far_most_elements_differ),
        cmocka_unit_test(test_lcmsim_bins_are_at_most_125_and_alike),
        cmocka_unit_test(test_lcmsim_bins_of_like_elements_are_one),
        cmocka_unit_test(test_lcmsim_bins_know_no_sign_of_direction),
    };
    prepare();
    return cmocka_run_group_tests_name("formats", tests, NULL, NULL);
}
