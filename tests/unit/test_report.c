/* SPDX-License-Identifier: MIT */
/* The report: what it says, that nothing in it can act, and its picture pixel by pixel. */
#include "api/format/format.h"
#include "api/format/inputs.h"
#include "api/format/part_picture.h"
#include "api/format/png.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

static const char plane[] =
    "{\"surface\":{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,"
    "\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"control_points\":[[5,7,3],[5,9,3],[7,7,3],[7,9,3]]},\"fabric\":{\"spacing\":%g}}";

/* `more` members in front of the request's own. */
static struct bytes drape_plane_with(const char *more, double spacing) {
    struct api_problem problem = {0};
    struct bytes own = {0}, request = {0}, container = {0};
    bytes_format(&own, plane, spacing);
    bytes_format(&request, "{%s%s", more, own.data + 1);
    bytes_free(&own);
    if (run_text(request.data, &container, &problem) != API_OK)
        fail_msg("%s", problem.error[0].detail);
    bytes_free(&request);
    return container;
}

static struct bytes drape_plane(double spacing) {
    return drape_plane_with("", spacing);
}

static struct bytes report_of(struct bytes *container, const char *inputs, size_t piece) {
    struct api_reader reader = reader_over(container);
    struct api_problem problem = {0};
    struct bytes page = {0};
    char buffer[4096];
    ssize_t length;
    const struct format_source source = {.id = "abc",
                                         .reader = &reader,
                                         .record = {.inputs = inputs,
                                                    .digest = "d<1>",
                                                    .finished = "2026-01-02T03:04:05Z",
                                                    .program = "draped & co"}};
    struct format_options options = {.part = "Wing", .ply = "3"};
    struct encoder *encoder = encoder_new(format_at(FORMAT_REPORT, 0), &source, &options, &problem);
    if (!encoder)
        fail_msg("%s", problem.error[0].detail);
    while ((length = encoder_read(encoder, buffer, piece)) > 0)
        bytes_add(&page, buffer, (size_t)length);
    assert_int_equal(length, 0);
    encoder_free(encoder);
    return page;
}

/* Every element is closed in its turn, but for those of HTML that are empty. */
static void check_closed(const char *page) {
    char open[32][16];
    size_t depth = 0;
    for (const char *at = strchr(page, '<'); at; at = strchr(at + 1, '<')) {
        const char *end = strchr(at, '>');
        char name[16] = "";
        size_t length = strcspn(at + 1, " >\n");
        assert_non_null(end);
        assert_true(length < sizeof name);
        memcpy(name, at + 1, length);
        if (*name == '!' || end[-1] == '/' || !strcmp(name, "meta"))
            continue;
        if (*name == '/') {
            assert_true(depth > 0);
            assert_string_equal(open[--depth], name + 1);
            continue;
        }
        assert_true(depth < sizeof open / sizeof *open);
        strcpy(open[depth++], name);
    }
    assert_int_equal(depth, 0);
}

static void test_report_says_it_all_and_can_do_nothing(void **state) {
    static const char inputs[] =
        "{\"surface\":{\"name\":\"</td><script>alert('1')</script>\\\"\",\"knotvector_u\":"
        "[0,0,0,1,1,1,1],\"points\":[[1,2],[3,4]]},\"empty\":[],\"fabric\":{\"spacing\":[0.25,0.5]}"
        ","
        "\"method\":\"gib\"}";
    static const char *const said[] = {"<title>Wing, ply 3</title>",
                                       "Complete: 100 % of the part",
                                       "&lt;/td&gt;&lt;script&gt;alert(&#39;1&#39;)",
                                       "surface.knotvector_u</th><td>7 entries",
                                       "surface.points</th><td>2 entries",
                                       "fabric.spacing</th><td>[0.25,0.5]",
                                       "method</th><td>&quot;gib&quot;",
                                       "d&lt;1&gt;",
                                       "draped &amp; co",
                                       "2026-01-02T03:04:05Z",
                                       DRAPE_VERSION,
                                       "<p>None.</p>",
                                       ">2000 mm</text>",
                                       "Area of the part</th><td>4 m²"};
    static const char *const never[] = {"<script", "http:", "https:", "src=", "url(\"", "onload"};
    struct bytes container = drape_plane(0.125);
    struct bytes page = report_of(&container, inputs, 4096);
    (void)state;
    for (size_t k = 0; k < sizeof said / sizeof *said; k++)
        if (!strstr(page.data, said[k]))
            fail_msg("the report does not say %s", said[k]);
    for (size_t k = 0; k < sizeof never / sizeof *never; k++)
        if (strstr(page.data, never[k]))
            fail_msg("the report has %s", never[k]);
    check_closed(page.data);
    struct bytes again = report_of(&container, inputs, 7);
    assert_int_equal(again.length, page.length);
    assert_memory_equal(again.data, page.data, page.length);
    bytes_free(&again);
    bytes_free(&page);
    bytes_free(&container);
}

static void test_report_of_a_net_without_a_cell(void **state) {
    struct bytes container = drape_plane_with("\"extent\":{\"warp\":[0,0],\"weft\":[0,0]},", 0.125);
    struct bytes page = report_of(&container, NULL, 4096);
    (void)state;
    check_closed(page.data);
    assert_non_null(strstr(page.data, "class=\"partial\""));
    assert_null(strstr(page.data, "<p>None.</p>"));
    assert_null(strstr(page.data, "nan"));
    assert_null(strstr(page.data, "inf "));
    bytes_free(&page);
    bytes_free(&container);
}

/* 200 bytes of a value are shown, less those of a character that would be cut in two. */
static void test_report_cuts_no_character_in_two(void **state) {
    struct bytes container = drape_plane(1);
    (void)state;
    for (int before = 0; before < 2; before++) {
        struct bytes inputs = {0}, shown = {0};
        bytes_format(&inputs, "{\"name\":\"%s", before ? "-" : "");
        bytes_format(&shown, "name</th><td>&quot;%s", before ? "-" : "");
        for (int k = 0; k < 120; k++) {
            bytes_format(&inputs, "é");
            bytes_format(&shown, "%s", k < 99 ? "é" : "");
        }
        bytes_format(&inputs, "\"}");
        bytes_format(&shown, " …</td>");
        struct bytes page = report_of(&container, inputs.data, 4096);
        if (!strstr(page.data, shown.data))
            fail_msg("not %s", shown.data);
        bytes_free(&page);
        bytes_free(&shown);
        bytes_free(&inputs);
    }
    bytes_free(&container);
}

static void test_inputs_end_where_the_text_is_cut(void **state) {
    static const char text[] = "{\"a\":{\"b\":[[1,\"]\"],2],\"c\":\"x\\\"}\"},\"d\":[1,2]}";
    (void)state;
    for (size_t length = 0; length < sizeof text; length++) {
        char cut[sizeof text] = "";
        struct inputs inputs = inputs_of(cut);
        struct inputs_row row;
        int rows = 0;
        memcpy(cut, text, length);
        while (inputs_next(&inputs, &row)) {
            assert_true(row.value >= cut && row.value + row.length <= cut + length);
            rows++;
        }
        check_at_most(rows, 3);
        if (length == sizeof text - 1)
            assert_int_equal(rows, 3);
    }
}

/* Seen from (0.35, -0.7, 1) a plane shows 1 / |that| of its area, in pixels of the scale; lines
 * make its edge a pixel wider. The shear is nothing, so that all has the first colour, or the one
 * below yarns, or a line's. */
static void test_portrait_shows_the_area_of_a_plane(void **state) {
    struct bytes container = drape_plane(0.125);
    struct api_reader reader = reader_over(&container);
    struct api_columns *columns = malloc(sizeof *columns);
    struct api_problem problem = {0};
    struct part_picture picture = {0};
    size_t drawn = 0, plain = 0;
    (void)state;
    assert_int_equal(api_columns_open(&reader, columns, &problem), API_OK);
    assert_int_equal(part_picture_draw(&picture, &reader, columns, &problem), API_OK);
    const struct raster *raster = &picture.raster;
    for (size_t k = 0; k < (size_t)raster->width * (size_t)raster->height; k++) {
        drawn += raster->pixels[k] != 0;
        plain += raster->pixels[k] == 1;
    }
    double expected = 4 * picture.scale * picture.scale / sqrt(1 + 0.35 * 0.35 + 0.7 * 0.7);
    check_below(fabs((double)drawn / expected - 1), 0.01);
    check_below((double)plain, (double)drawn);
    check_below(0.85, (double)plain / expected);
    assert_int_equal(picture.yarns, 1);
    check_below(fabs(picture.start[0] - raster->width / 2.0), 1);
    check_below(picture.start[0], picture.end[0][0]); /* warp to the right, weft upwards */
    check_below(picture.end[1][1], picture.start[1]);
    raster_free(&picture.raster);
    free(columns);
    bytes_free(&container);
}

/* Of two triangles the nearer is seen, whichever comes first; a line as far as it is not behind. */
static void test_raster_shows_what_is_nearest(void **state) {
    const double low[3][3] = {{0, 0, 1}, {20, 0, 1}, {0, 20, 1}};
    const double high[3][3] = {{0, 0, 2}, {10, 0, 2}, {0, 10, 2}};
    const double from[3] = {0, 3.5, 1.5}, to[3] = {20, 3.5, 1.5};
    (void)state;
    for (int first = 0; first < 2; first++) {
        uint8_t over[RASTER_COLOURS] = {[0] = 9, [1] = 3, [2] = 4};
        struct raster raster;
        assert_true(raster_begin(&raster, 20, 20));
        for (int k = 0; k < 2; k++) {
            const double(*corner)[3] = k == first ? low : high;
            raster_triangle(&raster, corner[0], corner[1], corner[2], k == first ? 1 : 2, 0);
        }
        raster_line(&raster, from, to, 1, 0, over);
        assert_int_equal(raster.pixels[2 * 20 + 2], 2);
        assert_int_equal(raster.pixels[2 * 20 + 12], 1);
        assert_int_equal(raster.pixels[3 * 20 + 2], 2); /* the line is behind it */
        assert_int_equal(raster.pixels[3 * 20 + 12], 3);
        assert_int_equal(raster.pixels[3 * 20 + 19], 9);
        assert_int_equal(raster.pixels[19 * 20 + 19], 0);
        raster_free(&raster);
    }
}

static uint32_t number_at(const uint8_t *bytes) {
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

/* Its chunks, their checksums, and the pixels that are packed in it. */
static void test_png_holds_the_pixels(void **state) {
    enum { WIDTH = 37, HEIGHT = 11 };
    struct raster raster;
    size_t length;
    uint8_t plain[HEIGHT][WIDTH + 1];
    uLongf size = sizeof plain;
    (void)state;
    assert_true(raster_begin(&raster, WIDTH, HEIGHT));
    for (int k = 0; k < WIDTH * HEIGHT; k++)
        raster.pixels[k] = (uint8_t)(k * 7);
    uint8_t *file = png_encode(&raster, &length);
    assert_non_null(file);
    assert_memory_equal(file, "\x89PNG\r\n\x1a\n", 8);
    const char *const names[] = {"IHDR", "PLTE", "IDAT", "IEND"};
    const uint8_t *at = file + 8;
    for (int k = 0; k < 4; k++) {
        uint32_t count = number_at(at);
        assert_memory_equal(at + 4, names[k], 4);
        assert_int_equal(crc32(0, at + 4, count + 4), number_at(at + 8 + count));
        if (k == 0)
            assert_memory_equal(at + 8, "\0\0\0\x25\0\0\0\x0b\x08\x03\0\0\0", 13);
        if (k == 2)
            assert_int_equal(uncompress(plain[0], &size, at + 8, count), Z_OK);
        at += count + 12;
    }
    assert_ptr_equal(at, file + length);
    assert_int_equal(size, sizeof plain);
    for (int row = 0; row < HEIGHT; row++) {
        assert_int_equal(plain[row][0], 0);
        assert_memory_equal(plain[row] + 1, raster.pixels + row * WIDTH, WIDTH);
    }
    free(file);
    raster_free(&raster);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_report_says_it_all_and_can_do_nothing),
        cmocka_unit_test(test_report_of_a_net_without_a_cell),
        cmocka_unit_test(test_report_cuts_no_character_in_two),
        cmocka_unit_test(test_inputs_end_where_the_text_is_cut),
        cmocka_unit_test(test_portrait_shows_the_area_of_a_plane),
        cmocka_unit_test(test_raster_shows_what_is_nearest),
        cmocka_unit_test(test_png_holds_the_pixels),
    };
    prepare();
    return cmocka_run_group_tests_name("report", tests, NULL, NULL);
}
