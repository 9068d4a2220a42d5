/* SPDX-License-Identifier: MIT */
#include "mesh_text.h"
#include "own_arena.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static enum api_problem_id read_bytes(const char *text, size_t length, struct map_target *mesh,
                                      struct api_problem *problem) {
    return mesh_text_read(map_target_nastran, text, length, arena, mesh, problem);
}

static struct map_target read_good(const char *text) {
    return mesh_text_good(map_target_nastran, text, arena);
}

/* ---- what is read ---- */

/* The same unit square with a triangle to its right, in all ways of writing. */
static const char small_fields[] =
    "$ a comment\n"
    "GRID           1              0.      0.     0.0       0\n"
    "GRID           2              1.      0.      0.\n"
    "GRID           3             1.0    1.+0      0.               0\n"
    "GRID          40              0.      1.      0.\n"
    "GRID           5             2.0      .5  -1.5-3\n"
    "CQUAD4       901       1       1       2       3      40\n"
    "CTRIA3        17       2       2       5       3      0.\n";

static const char large_fields[] =
    "GRID*                  1                             0.0             0.0\n"
    "*                    0.0               0\n"
    "GRID*                  2                            1.D0          0.0E+0\n"
    "*       0.0\n"
    "GRID*                  3                             1.0             1.0+GRID3\n"
    "*GRID3               0.0\n"
    "GRID*                 40                             0.0             1.0\n"
    "*                    0.0\n"
    "GRID*                  5                             2.0             0.5\n"
    "*            -1.500000-3\n"
    "CQUAD4*              901               1               1               2\n"
    "*                      3              40\n"
    "CTRIA3*               17               2               2               5\n"
    "*                      3\n";

static const char free_fields[] = "grid,1,,0.,0.,0.\n"
                                  "Grid, 2, 0, 1., 0., 0., , ,\n"
                                  "GRID,3,,1.,1.,0.\r\n"
                                  "GRID*,40,,0.,1.,\n"
                                  "*,0.\n"
                                  "GRID,5,,2.,.5,-.0015 $ to the right\n"
                                  "cquad4*,901,1,1,2\n"
                                  "\n"
                                  "$ between\n"
                                  "*,3,40\n"
                                  "CTRIA3,17,2,2,5,3";

/* Small fields are parted by tabs as well; and the order of the cards means nothing. */
static const char tabs[] = "CTRIA3\t17\t2\t2\t5\t3\n"
                           "CQUAD4\t901\t1\t1\t2\t3\t40\n"
                           "GRID\t1\t\t0.\t0.\t0.\n"
                           "GRID\t2\t\t1.\t0.\t0.\n"
                           "GRID\t3\t\t1.\t1.\t0.\n"
                           "GRID\t40\t\t\t1.\t0.\n"
                           "GRID\t5\t\t2.\t.5\t-1.5E-3\n";

static const char whole_deck[] = "SOL 101\n"
                                 "CEND\n"
                                 "TITLE = a mould, GRID and all\n"
                                 "begin bulk\n"
                                 "PARAM,POST,-1\n"
                                 "MAT1,1,7.+10,,.3\n"
                                 "PSHELL         1       1    .002       1               1\n"
                                 "PCOMP          2\n"
                                 "               1    .001     45.\n"
                                 "GRID,5,,2.,.5,-1.5e-3\n"
                                 "GRID,1,,,,\n"
                                 "GRID,2,,1.,,\n"
                                 "GRID,3,,1.,1.,\n"
                                 "GRID,40,,,1.,\n"
                                 "CTRIA3,17,2,2,5,3\n"
                                 "CQUAD4,901,1,1,2,3,40\n"
                                 "ENDDATA\n"
                                 "whatever comes behind it\n";

/* The index of the vertex with these coordinates. */
static int32_t vertex_at(const struct map_target *mesh, double x, double y, double z) {
    for (size_t k = 0; k < mesh->vertex_count; k++)
        if (mesh->vertices[k].x == x && mesh->vertices[k].y == y && mesh->vertices[k].z == z)
            return (int32_t)k;
    fail_msg("no vertex at %g, %g, %g", x, y, z);
    return -1;
}

static void test_map_nastran_reads_all_ways_of_writing(void **state) {
    (void)state;
    static const char *const texts[] = {small_fields, large_fields, free_fields, tabs, whole_deck};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        struct map_target mesh = read_good(texts[k]);
        assert_int_equal(mesh.vertex_count, 5);
        assert_int_equal(mesh.element_count, 2);
        const int32_t a = vertex_at(&mesh, 0, 0, 0), b = vertex_at(&mesh, 1, 0, 0);
        const int32_t c = vertex_at(&mesh, 1, 1, 0), d = vertex_at(&mesh, 0, 1, 0);
        const int32_t e = vertex_at(&mesh, 2, 0.5, -0.0015);
        size_t quad = mesh.ids[0] == 901 ? 0 : 1;
        assert_int_equal(mesh.ids[quad], 901);
        assert_int_equal(mesh.ids[1 - quad], 17);
        assert_memory_equal(mesh.elements[quad], ((int32_t[]){a, b, c, d}), 16);
        assert_memory_equal(mesh.elements[1 - quad], ((int32_t[]){b, e, c, -1}), 16);
        assert_null(mesh.roles);
    }
}

static void test_map_nastran_reads_its_reals(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double value;
    } reals[] = {{"1.5", 1.5},      {"-1.5+3", -1500},  {"+1.5-3", 0.0015}, {"1.5E3", 1500},
                 {"1.5e+03", 1500}, {"1.5D-3", 0.0015}, {".5", 0.5},        {"7", 7},
                 {"-.5d0", -0.5},   {"1.-12", 1e-12},   {"5.E-400", 0}};
    for (size_t k = 0; k < sizeof reals / sizeof *reals; k++) {
        struct bytes text = {0};
        bytes_format(&text,
                     "GRID,1,,%s,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n"
                     "CTRIA3,1,1,1,2,3\n",
                     reals[k].text);
        struct map_target mesh = read_good(text.data);
        assert_true(mesh.vertices[0].x == reals[k].value);
        bytes_free(&text);
    }
}

/* ---- what is not ---- */

#define GRIDS "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n"
#define TRIANGLE "CTRIA3,1,1,1,2,3\n"

struct wrong {
    const char *text, *detail;
};

static const struct wrong wrongs[] = {
    {"", "no shell elements"},
    {GRIDS, "no shell elements (CTRIA3, CQUAD4, ...); beside 3 GRIDs it has no cards"},
    {"$ nothing\n\n", "no shell elements"},
    {GRIDS "CHEXA,2,1,1,2,3,4,5,6,\n+,7,8\nCBAR,1,1,1,2\nCBAR,2,1,2,3\n",
     "beside 3 GRIDs it has 1 CHEXA, 2 CBAR"},
    {TRIANGLE, "line 1: element 1 has the corner 1, but there is no GRID 1"},
    {GRIDS "CTRIA3,1,1,1,2,4\n", "line 4: element 1 has the corner 4, but there is no GRID 4"},
    {GRIDS TRIANGLE "CQUAD4,1,1,1,2,3,1\n", "line 5: element 1 is defined twice"},
    {GRIDS TRIANGLE "$\nGRID,2,,5.,5.,5.\n", "line 6: GRID 2 is defined twice"},
    {GRIDS TRIANGLE "INCLUDE 'more.bdf'\n", "line 5: the file that INCLUDE names is not read"},
    {"{\"points\":[[1,2,3]]}", "line 1:"},
    {GRIDS "GRID,4,7,0.,0.,0.\n" TRIANGLE,
     "line 4: a GRID is in the coordinate system 7, which the file does not define"},
    {GRIDS "GRID,4,x,0.,0.,0.\n" TRIANGLE, "line 4: the coordinate system of GRID is 'x'"},
    {GRIDS "GRID,4,7,0.,0.,0.\nCORD2R,7,,0.,0.,0.,0.,0.,1.\n+,0.,0.,2.\n" TRIANGLE,
     "line 5: the three points of CORD2R 7 lie on one line"},
    {GRIDS "GRID,4,7,0.,0.,0.\nCORD2R,7,7,0.,0.,0.,0.,0.,1.\n+,0.,1.,2.\n" TRIANGLE,
     "line 5: CORD2R 7 refers to itself"},
    {GRIDS "GRID,4,7,0.,0.,0.\nCORD1R,7,1,2,4\n" TRIANGLE, "line 5: CORD1R 7 refers to itself"},
    {GRIDS "GRID,4,7,0.,0.,0.\nCORD1R,7,1,2,9\n" TRIANGLE,
     "line 5: CORD1R 7 names the grid 9, which does not exist"},
    {GRIDS "GRID,4,7,0.,0.,0.\nCORD2R,7,8,0.,0.,0.,0.,0.,1.\n+,0.,1.,2.\n" TRIANGLE,
     "line 5: CORD2R is in the coordinate system 8, which the file does not define"},
    {GRIDS "CORD1R,7,1,2,3\nCORD1R,7,1,2,3\n" TRIANGLE,
     "line 5: coordinate system 7 is defined twice"},
    {GRIDS "CORD2R,7,,0.,0.\n" TRIANGLE, "line 4: CORD2R ends before its coordinate z"},
    {GRIDS "CTRIA3,1,x,1,2,3\n", "line 4: the property of CTRIA3 is 'x'"},
    {GRIDS "GRID,x,,0.,0.,0.\n", "line 4: the id of GRID is 'x'"},
    {GRIDS "GRID,0,,0.,0.,0.\n", "line 4: the id of GRID is '0'"},
    {GRIDS "GRID,-4,,0.,0.,0.\n", "line 4: the id of GRID is '-4'"},
    {GRIDS "GRID,100000000,,0.,0.,0.\n", "line 4: the id of GRID is '100000000'"},
    {GRIDS "GRID,99999999999999999999,,0.,0.,0.\n", "line 4: the id of GRID"},
    {GRIDS "GRID,4,,NaN,0.,0.\n", "line 4: coordinate x of GRID is 'NaN'"},
    {GRIDS "GRID,4,,0.,inf,0.\n", "line 4: coordinate y of GRID is 'inf'"},
    {GRIDS "GRID,4,,0.,0.,1.e13\n", "line 4: coordinate z of GRID is '1.e13'"},
    {GRIDS "GRID,4,,0.,0.,1.e999\n", "line 4: coordinate z of GRID is '1.e999'"},
    {GRIDS "GRID,4,,0.,0.,1.2.3\n", "line 4: coordinate z of GRID is '1.2.3'"},
    {GRIDS "GRID,4,,0.,0.,1+2+3\n", "line 4: coordinate z of GRID is '1+2+3'"},
    {GRIDS "GRID,4,,0.,0.,1.-\n", "line 4: coordinate z of GRID is '1.-'"},
    {GRIDS "GRID,4,,0.,0.\n" TRIANGLE, "line 4: GRID ends before its coordinate z"},
    {GRIDS "GRID           4              0.\n", "line 4: GRID ends before its coordinate y"},
    {GRIDS "GRID*                  4                             0.0             0.0\n" TRIANGLE,
     "line 4: GRID ends before its coordinate z"},
    {GRIDS "CTRIA3,1,1,1,2\n", "line 4: a corner of CTRIA3 is ''"},
    {GRIDS "CQUAD4,1,1,1,2,3\n", "line 4: a corner of CQUAD4 is ''"},
    {GRIDS "CTRIA3,1,1,1,2,3.\n", "line 4: a corner of CTRIA3 is '3.'"},
    {"+,1\n" GRIDS TRIANGLE, "line 1: this continuation follows no card"},
    {"** a comment\n*Node, NSET=Nall\n1, 0, 0, 0\n",
     "line 1: this continuation follows no card; decks"},
    {"    -1\n    15\n", "line 1: this is not a card but a universal file"},
    {"BEGIN BULK\n" GRIDS TRIANGLE, "line 5: the file ends without ENDDATA"},
    {GRIDS "\x80\x81\x82\n", "line 4: this is not a card"},
    {GRIDS "GRID,4,,0.,0.,0.00000000000000000000000000000001\n",
     "line 4: a field is longer than 31 characters"},
    {GRIDS "AVERYLONGNAMEINDEED,1\n", "line 4: this is not a card"},
};

static void test_map_nastran_says_what_is_wrong_and_in_which_line(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof wrongs / sizeof *wrongs; k++) {
        struct map_target mesh;
        struct api_problem problem;
        enum api_problem_id id =
            read_bytes(wrongs[k].text, strlen(wrongs[k].text), &mesh, &problem);
        if (id != API_INVALID_REQUEST || !strstr(problem.error[0].detail, wrongs[k].detail))
            fail_msg("%s: %s: %s", wrongs[k].text, api_problem_slug(id), problem.error[0].detail);
    }
}

/* ---- what pre-processors write ---- */

static double area_of(const struct map_target *mesh) {
    double area = 0;
    for (size_t row = 0; row < mesh->element_count; row++) {
        const int32_t *corner = mesh->elements[row];
        const struct vec3 *v = mesh->vertices;
        struct vec3 last = v[corner[3] < 0 ? corner[2] : corner[3]];
        struct vec3 a = vec3_sub(v[corner[2]], v[corner[0]]);
        struct vec3 b = vec3_sub(last, v[corner[1]]);
        area += vec3_norm(vec3_cross(a, b)) / 2;
    }
    return area;
}

/* A plate of 100 x 60 in two properties, bars along one edge; of first and of second order. */
static void test_map_nastran_reads_files_of_gmsh(void **state) {
    (void)state;
    static const struct {
        const char *path, *warning;
        size_t vertices;
    } files[] = {{"tests/unit/meshes/gmsh_plate.bdf", "ignored: 3 CBAR (", 49},
                 {"tests/unit/meshes/gmsh_plate_second_order.bdf", "ignored: 3 CBAR (", 172}};
    for (size_t k = 0; k < sizeof files / sizeof *files; k++) {
        struct bytes text = file_read(files[k].path);
        struct map_target mesh;
        struct api_problem problem;
        assert_int_equal(read_bytes(text.data, text.length, &mesh, &problem), API_OK);
        assert_int_equal(mesh.vertex_count, files[k].vertices);
        assert_int_equal(mesh.element_count, 31 + 22);
        for (size_t row = 0; row < mesh.element_count; row++)
            assert_int_equal(mesh.pids[row], mesh.elements[row][3] < 0 ? 1 : 2);
        assert_true(fabs(area_of(&mesh) - 6000) < 1e-3);
        assert_ptr_equal(strstr(mesh.warning, files[k].warning), mesh.warning);
        bytes_free(&text);
    }
}

/* A deck of many other cards, some of them with continuations of words and numbers. */
/* As its mesh workbench writes them: three decimals, the property 0, no end of the last line. */
static void test_map_nastran_reads_files_of_freecad(void **state) {
    (void)state;
    struct map_target mesh = read_good("GRID           1          -1.500  -1.500   0.000\n"
                                       "GRID           2          -1.350  -1.500  -0.043\n"
                                       "GRID           3          -1.350  -1.350   0.000\n"
                                       "GRID           4          -1.500  -1.350   0.043\n"
                                       "CTRIA3         1       0       1       2       3\n"
                                       "CTRIA3         2       0       1       3       4\n"
                                       "ENDDATA");
    assert_int_equal(mesh.vertex_count, 4);
    assert_int_equal(mesh.element_count, 2);
    vertex_at(&mesh, -1.35, -1.5, -0.043);
    assert_int_equal(mesh.pids[0], 0);
    assert_int_equal(mesh.pids[1], 0);
}

static void test_map_nastran_passes_over_what_is_no_shell(void **state) {
    (void)state;
    struct map_target mesh = read_good(
        "SOL 101\nCEND\nSPC = 1\nSET 1 = 1 THRU 20\nBEGIN BULK\n" GRIDS
        "CBAR           1       1       1       2      0.      0.      1.\n"
        "CBEAM,2,1,1,2,0.,0.,1.\nCROD,3,1,1,2\nPLOTEL,9,1,2\nPLOTEL,10,2,3\n"
        "RBE2          11       1  123456       2       3\n"
        "RBE3,12,,1,123,1.,123,2,3\n"
        "SPC1           1  123456       1    THRU       3\n"
        "SET3           1    ELEM       1       2       3       4       5       6+\n"
        "+              7       8\n"
        "FORCE          1       1       0      1.      0.      0.     -1.\n"
        "PLOAD4         1       1      1.                            THRU       2\n"
        "PBARL          1       1             BAR\n             10.      2.\n"
        "PSHELL         1       1      2.       1\nMAT1           1  70000.              .3\n"
        "CORD2R         5       0      0.      0.      0.      0.      0.      1.\n"
        "              1.      0.      0.\n"
        "CTRIAR        40       7       1       2       3\n"
        "CONM2         13       1       0      1.\nENDDATA\n");
    assert_int_equal(mesh.element_count, 1);
    assert_int_equal(mesh.ids[0], 40);
    assert_int_equal(mesh.pids[0], 7);
    assert_string_equal(mesh.warning,
                        "ignored: 1 CBAR, 1 CBEAM, 1 CROD, 2 PLOTEL, 1 RBE2, 1 RBE3, 1 SPC1, "
                        "1 SET3, 1 FORCE, 1 PLOAD4, 1 PBARL, 1 PSHELL, 1 MAT1, 1 CONM2, 1 CORD2R "
                        "(only GRIDs and shell elements are read)");
    mesh = read_good(GRIDS TRIANGLE);
    assert_null(mesh.warning);
    mesh = read_good(GRIDS "GRID,7,,.5,0.,0.\nCTRIA6,1,1,1,2,3,7\nCTRIA6,2,1,1,2,3\n");
    assert_string_equal(mesh.warning, "1 elements are read by their corners, without the nodes in "
                                      "the middle of their edges");
    mesh = read_good(GRIDS "CTRIA3,6,,1,2,3\n");
    assert_int_equal(mesh.pids[0], 6);
}

/* The same three corners in all kinds of systems, one in another, defined before and behind. */
static void test_map_nastran_reads_grids_in_systems(void **state) {
    (void)state;
    static const char systems[] =
        "CORD2R,1,,10.,0.,0.,10.,0.,5.\n+,10.,3.,0.\n" /* x' = y, y' = -x, from (10,0,0) */
        "CORD2C,2,1,0.,0.,1.,0.,0.,2.\n+,1.,0.,1.\n"   /* about its z axis, 1 up */
        "CORD2S,3,,0.,0.,0.,0.,0.,1.\n+,1.,0.,0.\n"
        "CORD1R,4,100,101,102,5,100,102,101\n"
        "GRID,100,,1.,1.,1.\nGRID,101,,1.,1.,2.\nGRID,102,3,2.,90.,0.\n";
    static const struct {
        const char *grid;
        struct vec3 basic;
    } cases[] = {{"GRID,1,1,2.,3.,4.\n", {7, 2, 4}},
                 {"GRID,1,2,2.,90.,1.\n", {8, 0, 2}},
                 {"GRID,1,3,2.,90.,90.\n", {0, 2, 0}},
                 {"GRID,1,3,2.,0.,30.\n", {0, 0, 2}},
                 {"GRDSET,,1\nGRID,1,,2.,3.,4.\n", {7, 2, 4}},
                 {" grid ,1,,2.,3.,4.\n\rgrdset,,1\n", {7, 2, 4}},
                 {"GRDSET,,1\nGRID,1,0,2.,3.,4.\n", {2, 3, 4}}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct bytes text = {0};
        bytes_format(&text, "CTRIA3,1,1,1,2,3\nGRID,2,0,0.,0.,0.\nGRID,3,0,0.,1.,0.\n%s%s",
                     k < 4 ? systems : "CORD2R,1,,10.,0.,0.,10.,0.,5.\n+,10.,3.,0.\n",
                     cases[k].grid);
        struct map_target mesh = read_good(text.data);
        bool found = false;
        for (size_t v = 0; v < mesh.vertex_count; v++)
            found = found || vec3_distance(mesh.vertices[v], cases[k].basic) < 1e-14 * 10;
        if (!found)
            fail_msg("%s is not there", cases[k].grid);
        bytes_free(&text);
    }
}

/* A grid in a system of grids, of which one is in a system of its own. */
static void test_map_nastran_reads_systems_of_grids(void **state) {
    (void)state;
    struct map_target mesh = read_good("GRID,1,4,1.,2.,3.\nGRID,2,,0.,0.,0.\nGRID,3,,0.,1.,0.\n"
                                       "CTRIA3,1,1,1,2,3\n"
                                       "CORD1R,9,2,3,100,4,100,101,102\n"
                                       "GRID,100,,1.,1.,1.\nGRID,101,,1.,1.,2.\n"
                                       "GRID,102,3,2.,90.,0.\n"
                                       "CORD2S,3,,0.,1.,1.,0.,1.,2.\n+,1.,1.,1.\n");
    assert_true(vec3_distance(mesh.vertices[0], vec3_make(2, 3, 4)) < 1e-14);
}

static void test_map_nastran_bounds_the_depth_of_systems(void **state) {
    (void)state;
    struct bytes text = {0};
    struct map_target mesh;
    struct api_problem problem;
    bytes_format(&text, "GRID,1,1000,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n" TRIANGLE);
    for (int k = 1; k <= 1000; k++)
        bytes_format(&text, "CORD2R,%d,%d,0.,0.,0.,0.,0.,1.\n+,1.,0.,0.\n", k, k - 1);
    assert_int_equal(read_bytes(text.data, text.length, &mesh, &problem), API_INVALID_REQUEST);
    assert_non_null(strstr(problem.error[0].detail, "more than 64 systems depend on each other"));
    bytes_free(&text);
}

static void test_map_nastran_refuses_lines_that_it_would_have_to_cut(void **state) {
    (void)state;
    struct map_target mesh;
    struct api_problem problem;
    struct bytes text = {0};
    bytes_format(&text, "%sGRID,4,,0.,0.,%250s1.5\n%s", GRIDS, "", TRIANGLE);
    assert_int_equal(read_bytes(text.data, text.length, &mesh, &problem), API_INVALID_REQUEST);
    assert_non_null(strstr(problem.error[0].detail, "line 4 is longer than 255 columns"));
    text.length = 0;
    bytes_format(&text, "%sGRID,4,,0.,0.,1.5%250s$ a comment\n%s", GRIDS, "", TRIANGLE);
    assert_int_equal(read_bytes(text.data, text.length, &mesh, &problem), API_OK);
    bytes_free(&text);
}

/* Cut before its last line ends, a file is refused; the only other cuts that can be read are those
 * that leave a smaller mesh, or that of the last number. */
static void test_map_nastran_takes_any_bytes(void **state) {
    (void)state;
    static const char *const texts[] = {small_fields, large_fields, free_fields, whole_deck};
    struct random random = random_begin("bytes");
    struct map_target mesh;
    struct api_problem problem;
    size_t deck = strlen(whole_deck) - strlen("whatever comes behind it\n") - 1;
    for (size_t length = strlen("SOL 101\nCEND\nTITLE"); length < deck; length++)
        assert_int_equal(read_bytes(whole_deck, length, &mesh, &problem), API_INVALID_REQUEST);
    for (int trial = 0; trial < 20000; trial++) {
        static const char some[] = "$*+,-.0123456789DEGRID \n\r\t\xff";
        const char *text = texts[trial % 4];
        size_t length = strlen(text);
        char *changed = malloc(length);
        assert_non_null(changed);
        memcpy(changed, text, length);
        for (int k = random_index(&random, 3); k >= 0; k--)
            changed[random_index(&random, (int)length)] = some[random_index(&random, sizeof some)];
        size_t kept = trial % 2 ? length : (size_t)random_index(&random, (int)length);
        struct arena_mark mark = arena_mark(arena);
        enum api_problem_id id = read_bytes(changed, kept, &mesh, &problem);
        assert_true(id == problem.id && (id == API_OK || id == API_INVALID_REQUEST));
        for (size_t k = 0; id == API_OK && k < mesh.element_count; k++)
            for (int c = 0; c < 4; c++)
                assert_true(mesh.elements[k][c] < (int32_t)mesh.vertex_count &&
                            mesh.elements[k][c] >= (c == 3 ? -1 : 0));
        arena_rewind(arena, mark);
        free(changed);
    }
}

static void test_map_nastran_finds_scattered_ids(void **state) {
    (void)state;
    struct bytes text = {0};
    struct random random = random_begin("ids");
    enum { COUNT = 500 };
    int32_t ids[COUNT];
    for (int k = 0; k < COUNT; k++) {
        ids[k] = 1 + (k * 7919 % COUNT) * 1000 + random_index(&random, 1000);
        bytes_format(&text, "GRID,%d,,%d.,0.,0.\n", ids[k], k);
    }
    for (int k = 0; k + 2 < COUNT; k++)
        bytes_format(&text, "CTRIA3,%d,1,%d,%d,%d\n", COUNT - k, ids[k + 2], ids[k], ids[k + 1]);
    struct map_target mesh = read_good(text.data);
    for (int k = 0; k + 2 < COUNT; k++) {
        assert_int_equal(mesh.ids[k], COUNT - k);
        assert_memory_equal(mesh.elements[k], ((int32_t[]){k + 2, k, k + 1, -1}), 16);
    }
    bytes_free(&text);
}

static void test_map_nastran_without_memory_is_a_problem(void **state) {
    (void)state;
    struct map_target mesh;
    struct api_problem problem;
    for (size_t n = 1; n <= 13; n++) {
        arena_fail_at(arena, n);
        assert_int_equal(read_bytes(small_fields, strlen(small_fields), &mesh, &problem),
                         API_OUT_OF_MEMORY);
    }
    arena_fail_at(arena, 14);
    assert_int_equal(read_bytes(small_fields, strlen(small_fields), &mesh, &problem), API_OK);
    arena_fail_at(arena, 0);
}

/* ---- gates ---- */

/* Sets an option of small_fields' mesh (ids 901 and 17, properties 1 and 2). */
static enum api_problem_id set_option(struct map_target *mesh, const char *name, const char *list) {
    struct api_problem problem = {0};
    bool good = map_target_option(mesh, name, list, arena, &problem);
    assert_int_equal(good, problem.id == API_OK);
    return problem.id;
}

static void test_map_gates_are_by_the_ids_of_the_file_or_by_property(void **state) {
    (void)state;
    static const struct {
        const char *inlet, *outlet;
        uint8_t roles[2];
    } cases[] = {
        {"17", NULL, {0, MAP_INLET}},           {"17,901", NULL, {MAP_INLET, MAP_INLET}},
        {"pid:1", NULL, {MAP_INLET, 0}},        {NULL, "pid:2", {0, MAP_OUTLET}},
        {"901", "17", {MAP_INLET, MAP_OUTLET}}, {"17,pid:2", "pid:1", {MAP_OUTLET, MAP_INLET}}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct map_target mesh = read_good(small_fields);
        if (cases[k].inlet)
            assert_int_equal(set_option(&mesh, k % 2 ? "inlet" : "inlet_elements", cases[k].inlet),
                             API_OK);
        if (cases[k].outlet)
            assert_int_equal(set_option(&mesh, "outlet", cases[k].outlet), API_OK);
        assert_memory_equal(mesh.roles, cases[k].roles, 2);
    }
    struct map_target mesh = read_good(small_fields);
    mesh.ids = NULL;
    assert_int_equal(set_option(&mesh, "inlet", "0"), API_OK);
    assert_int_equal(mesh.roles[0], MAP_INLET);
    assert_int_equal(mesh.roles[1], MAP_FABRIC);
}

/* The first element is the punch: what is behind it moves up with all that is known of it. */
static void test_map_gates_stay_with_their_elements_under_a_punch(void **state) {
    (void)state;
    for (int role = MAP_INLET; role <= MAP_OUTLET; role++) {
        struct map_target mesh = read_good(small_fields);
        assert_int_equal(set_option(&mesh, role == MAP_INLET ? "inlet" : "outlet", "17"), API_OK);
        assert_int_equal(set_option(&mesh, "punch", "pid:1"), API_OK);
        assert_int_equal(mesh.punch_count, 1);
        assert_int_equal(mesh.element_count, 1);
        assert_int_equal(mesh.ids[0], 17);
        assert_int_equal(mesh.pids[0], 2);
        assert_int_equal(mesh.roles[0], role);
    }
}

static void test_map_gates_of_no_element_are_a_problem(void **state) {
    (void)state;
    static const char *const lists[] = {"18",         "",       ",",    "17,",
                                        "a",          "17 901", "-17",  "99999999999",
                                        "4294967313", "pid:3",  "pid:", "pid:x"};
    struct api_problem problem = {0};
    for (size_t k = 0; k < sizeof lists / sizeof *lists; k++) {
        struct map_target mesh = read_good(small_fields);
        assert_int_equal(set_option(&mesh, "inlet", lists[k]), API_INVALID_REQUEST);
    }
    struct map_target mesh = read_good(small_fields);
    assert_int_equal(set_option(&mesh, "inlet", "17"), API_OK);
    assert_int_equal(set_option(&mesh, "inlet_elements", "17"), API_INVALID_REQUEST); /* twice */
    assert_int_equal(set_option(&mesh, "outlet", "901,17"), API_INVALID_REQUEST);     /* both */
    assert_false(map_target_option(&mesh, "precision", "3", arena, &problem));
    assert_int_equal(problem.id, API_OK);
    mesh = read_good(small_fields);
    mesh.ids = NULL;
    assert_int_equal(set_option(&mesh, "inlet", "2"), API_INVALID_REQUEST);
    mesh = read_good(small_fields);
    mesh.pids = NULL;
    assert_int_equal(set_option(&mesh, "inlet", "pid:1"), API_INVALID_REQUEST);
    mesh = read_good(small_fields);
    mesh.elements = NULL;
    assert_int_equal(set_option(&mesh, "inlet", "0"), API_INVALID_REQUEST);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_map_nastran_reads_all_ways_of_writing),
        cmocka_unit_test(test_map_nastran_reads_its_reals),
        cmocka_unit_test(test_map_nastran_says_what_is_wrong_and_in_which_line),
        cmocka_unit_test(test_map_nastran_reads_files_of_gmsh),
        cmocka_unit_test(test_map_nastran_reads_files_of_freecad),
        cmocka_unit_test(test_map_nastran_passes_over_what_is_no_shell),
        cmocka_unit_test(test_map_nastran_reads_grids_in_systems),
        cmocka_unit_test(test_map_nastran_reads_systems_of_grids),
        cmocka_unit_test(test_map_nastran_bounds_the_depth_of_systems),
        cmocka_unit_test(test_map_nastran_refuses_lines_that_it_would_have_to_cut),
        cmocka_unit_test(test_map_nastran_takes_any_bytes),
        cmocka_unit_test(test_map_nastran_finds_scattered_ids),
        cmocka_unit_test(test_map_nastran_without_memory_is_a_problem),
        cmocka_unit_test(test_map_gates_are_by_the_ids_of_the_file_or_by_property),
        cmocka_unit_test(test_map_gates_stay_with_their_elements_under_a_punch),
        cmocka_unit_test(test_map_gates_of_no_element_are_a_problem),
    };
    return cmocka_run_group_tests_name("map_nastran", tests, set_up, tear_down);
}
