/* SPDX-License-Identifier: MIT */
/* The same mesh, a unit square with a triangle to its right, as other programs write it. */
#include "mesh_text.h"
#include "own_arena.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <string.h>

static const char abaqus[] =
    "*HEADING\n a part\n** a comment\n*Node, nset=all\n"
    " 1, 0., 0., 0.\n 2, 1., 0.\n3,1.,1.D0,0.\n40 ,0. ,1.,0.\n5,2.,.5,-1.5e-3\n"
    "*Element, type=S4R, elset=\"SKIN\"\n901, 1, 2, 3, 40\n"
    "*ELEMENT, TYPE=S3\n17, 2, 5, 3\n"
    "*ELEMENT, TYPE=B31\n18, 2, 5\n"
    "*Elset, elset=edge, generate\n 17, 21, 2\n"
    "*ELSET, ELSET=all\n901, 17,\nSKIN\n"
    "*Step\n*Static\n 0.1, 1.\n";
static const char lsdyna[] =
    "*KEYWORD\n$ a comment\n*NODE\n"
    "       1              0.              0.              0.       0       0\n"
    "       2              1.              0.              0.\n"
    "       3              1.              1.              0.\n"
    "40,0.,1.,0.\n"
    "       5              2.              .5         -1.5E-3\n"
    "*ELEMENT_SHELL_THICKNESS\n"
    "     901       1       1       2       3      40\n"
    "             .01             .01             .01             .01\n"
    "      17       2       2       5       3       3\n"
    "             .01             .01             .01             .01\n"
    "*ELEMENT_BEAM\n      18       2       2       5       3\n*END\nnot read\n";
static const char gmsh2[] =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n2\n1 7 \"rim\"\n2 1 \"a skin\"\n$EndPhysicalNames\n"
    "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n40 0 1 0\n5 2 .5 -1.5e-3\n"
    "$EndNodes\n$Elements\n3\n"
    "18 1 2 7 1 2 5\n901 3 2 1 1 1 2 3 40\n17 2 2 2 4 2 5 3\n$EndElements\n";
static const char gmsh4[] =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 1 \"a skin\"\n$EndPhysicalNames\n"
    "$Entities\n1 1 2 0\n1 0 0 0 0\n1 0 0 0 1 0 0 1 7 0\n"
    "1 0 0 0 1 1 0 1 1 4 1 2 3 4\n8 1 0 -1 2 1 0 1 -2 3 1 2 3\n$EndEntities\n"
    "$Nodes\n2 5 1 40\n1 1 0 2\n1\n2\n0 0 0\n1 0 0\n2 1 0 3\n3\n40\n5\n1 1 0\n0 1 0\n2 .5 -1.5e-3\n"
    "$EndNodes\n$Elements\n3 4 1 901\n1 1 1 2\n18 2 5\n19 5 3\n2 1 3 1\n901 1 2 3 40\n2 8 2 1\n17 "
    "2 5 3\n"
    "$EndElements\n";
static const char universal[] =
    "    -1\n   151\na title\n    -1\n    -1\n  2411\n"
    "         1         1         1        11\n   0.0D+00   0.0D+00   0.0D+00\n"
    "         2         1         1        11\n   1.0D+00   0.0D+00   0.0D+00\n"
    "         3         1         1        11\n   1.0D+00   1.0D+00   0.0D+00\n"
    "        40         1         1        11\n   0.0D+00   1.0D+00   0.0D+00\n"
    "         5         1         1        11\n   2.0D+00   5.0D-01  -1.5D-03\n    -1\n"
    "    -1\n  2412\n        18        11         2         1         7         2\n"
    "         0         1         1\n         2         5\n"
    "       901        94         7         1         7         4\n"
    "         1         2         3        40\n"
    "        17        92         7         1         7         6\n"
    "         2         2         5         5         3         3\n    -1\n"
    "    -1\n  2467\n"
    "         1         0         0         0         0         0         0         1\nSKIN\n"
    "         8       901         0         0\n"
    "         2         0         0         0         0         0         0         2\nedge\n"
    "         8        17         0         0         7         5         0         0\n    -1\n";

static const char vtu[] =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
    "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
    "<Piece NumberOfPoints=\"5\" NumberOfCells=\"3\">\n<CellData>"
    "<DataArray type=\"Int32\" Name=\"id\" format=\"ascii\">18 901 17</DataArray>"
    "<DataArray type=\"Float64\" Name=\"pid\" format=\"ascii\">no number</DataArray>"
    "<DataArray type=\"UInt8\" Name=\"pid\" format=\"binary\">AwAAAAABAg==</DataArray></CellData>\n"
    "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">"
    "0 0 0 1 0 0\n1 1 0 0 1 0 <InformationKey name=\"L2\">3 </InformationKey>2 .5 -1.5e-3\n"
    "</DataArray></Points>\n<Cells>"
    "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">1 4 0 1 2 3 1 4 "
    "2</DataArray>\n"
    "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">2 6 9</DataArray>\n"
    "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">3 7 22</DataArray>\n"
    "</Cells></Piece></UnstructuredGrid></VTKFile>\n";

static const struct {
    const char *what, *text, *warning;
    map_target_reader *read;
} files[] = {
    {"abaqus", abaqus, "1 SKIN, 2 edge", map_target_abaqus},
    {"lsdyna", lsdyna, "1 ELEMENT_BEAM", map_target_lsdyna},
    {"gmsh 2.2", gmsh2, "properties: 1 a skin", map_target_gmsh},
    {"gmsh 4.1", gmsh4, "properties: 1 a skin", map_target_gmsh},
    {"unv", universal, "1 SKIN, 2 edge", map_target_universal},
    {"vtu", vtu, "1 cells that are no triangles or quadrilaterals are ignored, and 1",
     map_target_vtu},
};
enum { FILES = sizeof files / sizeof *files };

static void test_map_files_all_give_the_same_mesh(void **state) {
    (void)state;
    static const struct vec3 points[] = {
        {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0.5, -1.5e-3}};
    static const int32_t vertex_ids[] = {1, 2, 3, 40, 5}, ids[] = {901, 17}, pids[] = {1, 2},
                         elements[][4] = {{0, 1, 2, 3}, {1, 4, 2, -1}};
    for (int k = 0; k < FILES; k++) {
        print_message("# %s\n", files[k].what);
        struct map_target mesh = mesh_text_good(files[k].read, files[k].text, arena);
        assert_int_equal(mesh.vertex_count, 5);
        assert_int_equal(mesh.element_count, 2);
        assert_memory_equal(mesh.vertices, points, sizeof points);
        if (mesh.vertex_ids) /* VTK has no numbers for points */
            assert_memory_equal(mesh.vertex_ids, vertex_ids, sizeof vertex_ids);
        assert_true(mesh.vertex_ids || files[k].read == map_target_vtu);
        assert_memory_equal(mesh.elements, elements, sizeof elements);
        assert_memory_equal(mesh.ids, ids, sizeof ids);
        assert_memory_equal(mesh.pids, pids, sizeof pids);
        assert_non_null(mesh.warning);
        if (!strstr(mesh.warning, files[k].warning))
            fail_msg("%s: %s", files[k].what, mesh.warning);
    }
}

static void test_map_files_say_the_line_of_what_is_wrong(void **state) {
    (void)state;
    static const struct {
        int file;
        const char *from, *to, *says;
    } wrong[] = {
        {0, "17, 2, 5, 3", "901, 2, 5, 3", "line 13: element 901 is defined twice"},
        {0, "40 ,0. ,1.", "2,0.,1.", "line 8: node 2 is defined twice"},
        {0, "17, 2, 5, 3", "17, 2, 6, 3", "there is no node 6"},
        {0, "17, 2, 5, 3", "17, 2, 5", "has less than 3 nodes"},
        {0, "*Step", "*INCLUDE, INPUT=a.inp", "line 21: the file that *INCLUDE names"},
        {0, "2, 1., 0.", "2, 1e13, 0.", "line 6: a coordinate must be a number of at most 1e12"},
        {0, "*HEADING", "*ELGEN", "line 1: *ELGEN is not read"},
        {0, " a part", "*INSTANCE, NAME=a\n1., 0., 0.", "line 3: an instance that is moved"},
        {0, "*HEADING", "*ELGEN\n*INCLUDE, INPUT=a.inp", "line 1: *ELGEN is not read"},
        {1, "_THICKNESS", "_COMPOSITE", "*ELEMENT_SHELL_COMPOSITE is not read"},
        {1, "40,0.", "&id,0.", "line 7: the id of a node must be a whole number"},
        {1, "*KEYWORD", "*INCLUDE", "line 1: the file that *INCLUDE names"},
        {2, "2.2 0 8", "2.2 1 8", "line 2: the file is binary"},
        {2, "2.2 0 8", "4.0 0 8", "line 2: version 4.0 is not read"},
        {2, "$MeshFormat", "MeshFormat", "this is not a mesh of Gmsh"},
        {2, "$Elements\n3\n", "$Elements\n99\n", "must have at least 4 numbers"},
        {3, "901 1 2 3 40", "901 1 2 3", "the element has less than 4 nodes"},
        {4, "    -1\n   151", "     1\n   151", "line 1: this is not a universal file"},
        {4, "  2411", "   781", "dataset 781 is not read"},
        {4, "         8       901         0         0\n",
         "         x       901         0         0\n    -1\n    -1\n   781\n",
         "line 32: a code must be a whole number"},
        {5, "<VTKFile type", "<VTKFile kind", "this VTK file is a file without a type"},
        {5, "Grid\"", "Grid\" compressor=\"vtkLZ4\"", "packed by vtkLZ4: save it with zlib"},
        {5, "</Piece>", "", "line 12: this is not a VTK XML file: mismatched tag"},
        {5, "<?xml version=\"1.0\"?>\n",
         "<?xml version=\"1.0\"?>\n<!DOCTYPE a [<!ENTITY b \"c\">]>\n", "defines entities"},
        {5, "AwAAAAAB", "BAAAAAAB", "the array pid is damaged or cut short"},
        {5, "18 901 17", "18 901 901", "the id 901 is defined twice"},
        {5, "18 901 17", "18 901 -1", "cell 2: its id is -1"},
        {5, "2 6 9", "2 6 10", "cell 2 ends at 10 in a list of 9 points"},
        {5, "2 6 9", "2 6", "3 cells have 2 offsets"},
        {5, "3 7 22", "3 9 9", "cell 2 has 3 points, not 4"},
        {5, "3 7 22", "3 3 3", "no triangles or quadrilaterals; beside 5 points it has 3 other"},
        {5, "1 4 0 1 2 3", "1 4 0 1 2 5", "cell 1 has the corner 5, but there are 5 points"},
        {5, "2 .5 -1.5e-3", "2 .5 nan", "the array Points must be numbers, not 'nan'"},
        {5, "2 .5 -1.5e-3", "2 .5 1e13", "point 4: a coordinate must be a number of at most 1e12"},
        {5, "2 .5 -1.5e-3", "2 .5", "5 points have 14 coordinates"},
        {5, "\"5\"", "\"-5\"", "NumberOfPoints of the piece must be a number from 0"},
        {5, "</Piece>", "</Piece><Piece/>", "the file has several pieces: merge them into one"},
        {5, "Name=\"types\"", "Name=\"kinds\"", "the file has no array of types"},
    };
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        struct bytes text = text_replace(files[wrong[k].file].text, wrong[k].from, wrong[k].to);
        struct map_target mesh;
        struct api_problem problem = {0};
        assert_int_equal(mesh_text_read(files[wrong[k].file].read, text.data, text.length, arena,
                                        &mesh, &problem),
                         API_INVALID_REQUEST);
        assert_int_equal(problem.count, 1);
        if (!strstr(problem.error[0].detail, wrong[k].says))
            fail_msg("%s is not in: %s", wrong[k].says, problem.error[0].detail);
        bytes_free(&text);
    }
}

/* Solids beside beams, each kind once. */
static void test_map_files_count_what_is_no_shell(void **state) {
    (void)state;
    struct bytes text =
        text_replace(universal, "       901        94",
                     "        19       111         2         1         7         4\n"
                     "         1         2         3        40\n"
                     "       901        94");
    struct map_target mesh = mesh_text_good(map_target_universal, text.data, arena);
    assert_int_equal(mesh.element_count, 2);
    assert_non_null(strstr(mesh.warning, "ignored: 1 beams, 1 elements of other kinds (only"));
    bytes_free(&text);
}

/* A keyword that ends in + has fields of 20 characters, in - of 8; others as *KEYWORD says. */
static void test_map_files_of_dyna_have_fields_of_8_or_20(void **state) {
    (void)state;
    static const struct {
        const char *file, *end;
        bool wide;
    } rows[] = {{"", "", false},          {"", "+", true},         {"", " +", true},
                {"", " -", false},        {" LONG=Y", "", true},   {" LONG=Y", "-", false},
                {" LONG=Y", " -", false}, {" LONG=Y", " +", true}, {" ID=a LONG=K", "", true},
                {" LONG=S", "", false}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const int width = rows[k].wide ? 20 : 8, real = rows[k].wide ? 20 : 16;
        struct bytes text = {0};
        bytes_format(&text, "*KEYWORD%s\n*NODE%s\n", rows[k].file, rows[k].end);
        for (int n = 0; n < 3; n++)
            bytes_format(&text, "%*d%*g%*g%*g\n", width, n + 1, real, n == 1 ? 1.5 : 0, real,
                         n == 2 ? 2.5 : 0, real, 0.5);
        bytes_format(&text, "*ELEMENT_SHELL%s\n%*d%*d%*d%*d%*d%*d\n*END\n", rows[k].end, width, 7,
                     width, 3, width, 1, width, 2, width, 3, width, 3);
        struct map_target mesh = mesh_text_good(map_target_lsdyna, text.data, arena);
        assert_int_equal(mesh.vertex_count, 3);
        assert_int_equal(mesh.ids[0], 7);
        assert_int_equal(mesh.pids[0], 3);
        assert_true(mesh.vertices[1].x == 1.5 && mesh.vertices[2].y == 2.5);
        assert_true(mesh.vertices[0].z == 0.5);
        bytes_free(&text);
    }
}

/* Sets beside the one that is an element's property, in any case of letters, and of all options. */
static void test_map_files_name_sets_in_lists(void **state) {
    (void)state;
    static const struct {
        int file;
        const char *list;
        uint8_t roles[2];
    } good[] = {
        {0, "set:skin", {MAP_INLET, 0}},        {0, "set:EDGE", {0, MAP_INLET}},
        {0, "set:all", {MAP_INLET, MAP_INLET}}, {0, "901,set:edge", {MAP_INLET, MAP_INLET}},
        {2, "set:a skin", {MAP_INLET, 0}},      {4, "set:edge,pid:1", {MAP_INLET, MAP_INLET}}};
    static const struct {
        const char *option, *list, *says;
    } wrong[] = {
        {"inlet", "set:ski", "inlet: the mesh has no set ski; its sets are: SKIN, edge, all"},
        {"outlet", "set:", "outlet: the mesh has no set ; its sets are"},
        {"outlet", "set:skin:1", "outlet must list elements, properties, sets or regions"},
        {"punch", "set:skin,set:none", "punch: the mesh has no set none"},
        {"punch", "set:all", "punch: the mesh has no elements besides the punch"},
        {"cavity_height", "set:skin", "cavity_height must be a positive height"},
        {"cavity_height", "set:skin:0", "cavity_height must be a positive height"}};
    struct api_problem problem = {0};
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
        struct map_target mesh =
            mesh_text_good(files[good[k].file].read, files[good[k].file].text, arena);
        assert_true(map_target_option(&mesh, "inlet", good[k].list, arena, &problem));
        assert_memory_equal(mesh.roles, good[k].roles, 2);
    }
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        struct map_target mesh = mesh_text_good(map_target_abaqus, abaqus, arena);
        problem = (struct api_problem){0};
        assert_false(map_target_option(&mesh, wrong[k].option, wrong[k].list, arena, &problem));
        if (!strstr(problem.error[0].detail, wrong[k].says))
            fail_msg("%s is not in: %s", wrong[k].says, problem.error[0].detail);
    }
    struct map_target mesh = mesh_text_good(map_target_abaqus, abaqus, arena);
    problem = (struct api_problem){0};
    assert_true(map_target_option(&mesh, "cavity_height", "3,set:edge:4", arena, &problem));
    assert_memory_equal(mesh.heights, ((double[]){3, 4}), 2 * sizeof(double));
    mesh = mesh_text_good(map_target_abaqus, abaqus, arena);
    assert_true(map_target_option(&mesh, "inlet", "set:all", arena, &problem));
    assert_true(map_target_option(&mesh, "punch", "set:edge", arena, &problem));
    assert_int_equal(mesh.element_count, 1);
    assert_int_equal(mesh.ids[0], 901);
    assert_true(map_target_option(&mesh, "outlet", "set:edge", arena, &problem) == false);
}

/* However a file is cut off, it is read or refused. */
static void test_map_files_cut_anywhere_are_read_or_refused(void **state) {
    (void)state;
    size_t refused = 0, tried = 0;
    for (int k = 0; k < FILES; k++)
        for (size_t length = 0; length < strlen(files[k].text); length++, tried++) {
            struct map_target mesh;
            struct api_problem problem = {0};
            struct arena_mark mark = arena_mark(arena);
            refused += mesh_text_read(files[k].read, files[k].text, length, arena, &mesh,
                                      &problem) == API_INVALID_REQUEST;
            assert_true(problem.id == API_OK || problem.id == API_INVALID_REQUEST);
            arena_rewind(arena, mark);
        }
    check_above(refused, tried / 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_map_files_all_give_the_same_mesh),
        cmocka_unit_test(test_map_files_say_the_line_of_what_is_wrong),
        cmocka_unit_test(test_map_files_count_what_is_no_shell),
        cmocka_unit_test(test_map_files_of_dyna_have_fields_of_8_or_20),
        cmocka_unit_test(test_map_files_name_sets_in_lists),
        cmocka_unit_test(test_map_files_cut_anywhere_are_read_or_refused),
    };
    return cmocka_run_group_tests_name("map_files", tests, set_up, tear_down);
}
