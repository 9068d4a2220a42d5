/* SPDX-License-Identifier: MIT */
/* Pictures with depth, pixel by pixel: what triangles and lines have, and nothing beside. */
#include "api/format/raster.h"
#include "support.h"
#include "tests/check.h"
#include <string.h>

enum { WIDTH = 8, HEIGHT = 6 };

/* A row a line, a dot where nothing was drawn, else the number of the colour. */
static void check_pixels(const struct raster *raster, const char *const wanted[HEIGHT]) {
    for (int row = 0; row < HEIGHT; row++) {
        char found[WIDTH + 1] = "";
        for (int column = 0; column < WIDTH; column++) {
            uint8_t colour = raster->pixels[row * WIDTH + column];
            found[column] = colour ? (char)('0' + colour) : '.';
        }
        assert_string_equal(found, wanted[row]);
    }
}

static void draw_flat(struct raster *raster, double ax, double ay, double bx, double by, double cx,
                      double cy, double z, uint8_t colour) {
    const double a[3] = {ax, ay, z}, b[3] = {bx, by, z}, c[3] = {cx, cy, z};
    raster_triangle(raster, a, b, c, colour, 0);
}

/* Pixels whose middles a triangle has: of one that is smaller than a pixel one or none, with its
 * edges; of one that reaches beyond the picture what is in it; the nearer hides the farther. */
static void test_raster_triangles_have_their_pixels(void **state) {
    static const char *const wanted[HEIGHT] = {"11177777", "6611....", "66661...",
                                               "..2.....", "....3333", "........"};
    struct raster raster;
    (void)state;
    assert_true(raster_begin(&raster, WIDTH, HEIGHT));
    draw_flat(&raster, -5, 0.5, 4.5, 0.5, 4.5, 0.5, 1, 5);      /* without an area */
    draw_flat(&raster, 2.2, 3.2, 2.9, 3.2, 2.5, 3.9, 1, 2);     /* with a middle */
    draw_flat(&raster, 5.6, 3.6, 5.9, 3.6, 5.9, 3.9, 1, 4);     /* without */
    draw_flat(&raster, 4.5, 4.5, 20, 4.5, 12, 4.9, 1, 3);       /* its upper edge has middles */
    draw_flat(&raster, -4, -1.5, 0.75, -1.5, 5.75, 3.25, 1, 1); /* cut off on two sides */
    draw_flat(&raster, -4, -1.5, 5.75, 3.25, -0.25, 3.25, 0, 6);
    draw_flat(&raster, -5, 0.5, 20, 0.5, 8, 0.9, 0, 7);
    check_pixels(&raster, wanted);
    raster_free(&raster);
}

/* Of lines that lie along the picture's edges what is in it, and nothing at the other edge. */
static void test_raster_lines_end_at_the_edges(void **state) {
    static const struct {
        double from[3], to[3];
        const char *rows[HEIGHT];
    } lines[] = {
        {{7.5, -3, 0},
         {7.5, 9, 0},
         {"......11", "......11", "......11", "......11", "......11", "......11"}},
        {{0.5, -3, 0},
         {0.5, 9, 0},
         {"11......", "11......", "11......", "11......", "11......", "11......"}},
        {{-3, 5.5, 0},
         {9, 5.5, 0},
         {"........", "........", "........", "........", "11111111", "11111111"}},
        {{-3, 0.5, 0},
         {9, 0.5, 0},
         {"11111111", "11111111", "........", "........", "........", "........"}},
        {{2.5, 2.5, 0},
         {4.5, 2.5, 0},
         {"........", "..111...", "..111...", "..111...", "........", "........"}},
    };
    static const uint8_t over[RASTER_COLOURS] = {1, 2};
    (void)state;
    for (size_t k = 0; k < sizeof lines / sizeof *lines; k++) {
        struct raster raster;
        assert_true(raster_begin(&raster, WIDTH, HEIGHT));
        raster_line(&raster, lines[k].from, lines[k].to, 3, 0, over);
        check_pixels(&raster, lines[k].rows);
        raster_free(&raster);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_raster_triangles_have_their_pixels),
        cmocka_unit_test(test_raster_lines_end_at_the_edges),
    };
    return cmocka_run_group_tests_name("raster", tests, NULL, NULL);
}
