/* SPDX-License-Identifier: MIT */
/* VTK XML files as other programs write them: every shape of a shell, and every way in which bytes
 * can stand in a file, written here from the format's own description. */
#include "mesh_text.h"
#include "own_arena.h"
#include "support.h"
#include "tests/check.h"
#include <sodium.h>
#include <string.h>
#include <zlib.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* ---- shapes ---- */

/* Cells of one shape over the same four points; those with nodes in the middle of edges have them
 * behind their corners. */
static void test_vtu_has_these_shapes(void **state) {
    static const struct {
        int type;
        const char *points;
        int count;
        int32_t corners[4]; /* the first < 0: it is none of a shell */
        bool curved;
    } rows[] = {
        {5, "0 1 2", 3, {0, 1, 2, -1}, false},
        {7, "2 1 0", 3, {2, 1, 0, -1}, false},
        {7, "0 1 2 3", 4, {0, 1, 2, 3}, false},
        {7, "0 1 2 3 0", 5, {-1}, false},
        {8, "0 1 3 2", 4, {0, 1, 2, 3}, false},
        {9, "3 0 1 2", 4, {3, 0, 1, 2}, false},
        {22, "0 1 2 3 3 3", 6, {0, 1, 2, -1}, true},
        {34, "0 1 2 3 3 3 3", 7, {0, 1, 2, -1}, true},
        {23, "0 1 2 3 0 0 0 0", 8, {0, 1, 2, 3}, true},
        {28, "0 1 2 3 0 0 0 0 0", 9, {0, 1, 2, 3}, true},
        {1, "0", 1, {-1}, false},
        {3, "0 1", 2, {-1}, false},
        {6, "0 1 2", 3, {-1}, false},
        {29, "0 1 2 3", 4, {-1}, false},
    };
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct bytes text = {0};
        bytes_format(
            &text,
            "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" "
            "NumberOfCells=\"2\"><Points><DataArray type=\"Float64\" format=\"ascii\">0 0 0 1 0 0 "
            "1 1 0 0 1 0</DataArray></Points><CellData><DataArray type=\"Int32\" Name=\"id\" "
            "format=\"ascii\">2 1</DataArray></CellData><Cells><DataArray type=\"Int32\" "
            "Name=\"connectivity\" format=\"ascii\">%s 0 1 3</DataArray><DataArray type=\"Int32\" "
            "Name=\"offsets\" format=\"ascii\">%d %d</DataArray><DataArray type=\"UInt8\" "
            "Name=\"types\" format=\"ascii\">%d 5</DataArray></Cells></Piece></UnstructuredGrid>"
            "</VTKFile>",
            rows[k].points, rows[k].count, rows[k].count + 3, rows[k].type);
        struct map_target mesh = mesh_text_good(map_target_vtu, text.data, arena);
        const bool shell = rows[k].corners[0] >= 0;
        assert_int_equal(mesh.element_count, 1 + shell);
        assert_int_equal(mesh.ids[shell], 1);
        if (shell)
            assert_memory_equal(mesh.elements[0], rows[k].corners, sizeof rows[k].corners);
        if (shell && !rows[k].curved)
            assert_null(mesh.warning);
        else
            assert_non_null(strstr(mesh.warning, shell ? "1 are read by" : "1 cells that are no"));
        bytes_free(&text);
    }
}

/* ---- bytes ---- */

/* How numbers stand in a file. */
struct form {
    bool appended, base64, packed, wide, big;
    const char *real, *whole;
};

static void put_whole(struct bytes *out, const struct form *form, uint64_t value, size_t size) {
    unsigned char bytes[8];
    for (size_t k = 0; k < size; k++)
        bytes[form->big ? size - 1 - k : k] = (unsigned char)(value >> 8 * k);
    bytes_add(out, bytes, size);
}

static void put_base64(struct bytes *out, const struct bytes *raw) {
    char text[4096];
    assert_non_null(sodium_bin2base64(text, sizeof text, (const unsigned char *)raw->data,
                                      raw->length, sodium_base64_VARIANT_ORIGINAL));
    bytes_add(out, text, strlen(text));
}

/* With its header: the length, or in blocks of 16 bytes that are packed one by one. */
static void put_block(struct bytes *out, const struct form *form, const struct bytes *raw) {
    enum { BLOCK = 16 };
    const size_t word = form->wide ? 8 : 4, last = raw->length % BLOCK;
    const size_t blocks = (raw->length + BLOCK - 1) / BLOCK;
    struct bytes head = {0}, body = {0};
    put_whole(&head, form, form->packed ? blocks : raw->length, word);
    if (form->packed) {
        put_whole(&head, form, BLOCK, word);
        put_whole(&head, form, last, word);
    } else {
        bytes_add(&head, raw->data, raw->length);
    }
    for (size_t k = 0; k < blocks && form->packed; k++) {
        unsigned char packed[128];
        uLongf length = sizeof packed;
        const size_t own = k + 1 == blocks && last ? last : BLOCK;
        assert_int_equal(
            compress(packed, &length, (const Bytef *)raw->data + k * BLOCK, (uLong)own), Z_OK);
        put_whole(&head, form, length, word);
        bytes_add(&body, packed, length);
    }
    if (form->base64) {
        put_base64(out, &head);
        if (body.length)
            put_base64(out, &body);
    } else {
        bytes_add(out, head.data, head.length);
        if (body.length)
            bytes_add(out, body.data, body.length);
    }
    bytes_free(&head);
    bytes_free(&body);
}

static size_t size_of(const char *type) {
    return strchr(type, '8') ? 1 : strstr(type, "16") ? 2 : strstr(type, "32") ? 4 : 8;
}

/* An array's element, and its bytes in it or behind what is appended. */
static void put_array(struct bytes *text, struct bytes *appended, const struct form *form,
                      const char *name, const double *values, size_t count) {
    const bool real = strcmp(name, "Points") == 0;
    const char *type = real ? form->real : form->whole;
    struct bytes raw = {0};
    for (size_t k = 0; k < count; k++) {
        const float narrow = (float)values[k];
        uint64_t wide = (uint64_t)(int64_t)values[k];
        uint32_t half;
        if (real && size_of(type) == 8)
            memcpy(&wide, &values[k], sizeof wide);
        if (real && size_of(type) == 4) {
            memcpy(&half, &narrow, sizeof half);
            wide = half;
        }
        put_whole(&raw, form, wide, size_of(type));
    }
    bytes_format(text, "<DataArray type=\"%s\" Name=\"%s\" format=\"%s\"", type, name,
                 form->appended ? "appended" : "binary");
    if (form->appended) {
        bytes_format(text, " offset=\"%zu\"/>\n", appended->length);
        put_block(appended, form, &raw);
    } else {
        bytes_add(text, ">\n ", 3);
        put_block(text, form, &raw);
        bytes_add(text, "\n</DataArray>\n", 14);
    }
    bytes_free(&raw);
}

static const double points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0.5, -1.5};
static const double corners[] = {0, 1, 2, 3, 1, 4, 2}, ends[] = {4, 7}, types[] = {9, 5};

static struct bytes vtu_of(const struct form *form, const double ids[2]) {
    struct bytes text = {0}, appended = {0};
    bytes_format(&text,
                 "<VTKFile type=\"UnstructuredGrid\" byte_order=\"%s\" header_type=\"%s\"%s>"
                 "<UnstructuredGrid><Piece NumberOfPoints=\"5\" NumberOfCells=\"2\">\n<CellData>",
                 form->big ? "BigEndian" : "LittleEndian", form->wide ? "UInt64" : "UInt32",
                 form->packed ? " compressor=\"vtkZLibDataCompressor\"" : "");
    put_array(&text, &appended, form, "id", ids, 2);
    bytes_format(&text, "</CellData><Points>");
    put_array(&text, &appended, form, "Points", points, COUNT(points));
    bytes_format(&text, "</Points><Cells>");
    put_array(&text, &appended, form, "connectivity", corners, COUNT(corners));
    put_array(&text, &appended, form, "offsets", ends, COUNT(ends));
    put_array(&text, &appended, form, "types", types, COUNT(types));
    bytes_format(&text, "</Cells></Piece></UnstructuredGrid>");
    if (form->appended) {
        bytes_format(&text, "<AppendedData encoding=\"%s\">\n _", form->base64 ? "base64" : "raw");
        bytes_add(&text, appended.data, appended.length);
        bytes_format(&text, "\n</AppendedData>");
    }
    bytes_format(&text, "</VTKFile>\n");
    bytes_free(&appended);
    return text;
}

static void check_form(const struct form *form) {
    static const int32_t wanted[][4] = {{0, 1, 2, 3}, {1, 4, 2, -1}};
    static const double ids[] = {117, 3}, wrong[] = {117, -1};
    struct map_target mesh;
    struct api_problem problem = {0};
    struct bytes text = vtu_of(form, ids);
    if (map_target_vtu(text.data, text.length, arena, &mesh, &problem) != API_OK)
        fail_msg("%s %s %s %s %s %s %s: %s", form->appended ? "appended" : "inline",
                 form->base64 ? "base64" : "raw", form->packed ? "packed" : "as it is",
                 form->wide ? "wide" : "narrow", form->big ? "big" : "little", form->real,
                 form->whole, problem.error[0].detail);
    assert_int_equal(mesh.vertex_count, 5);
    assert_int_equal(mesh.element_count, 2);
    assert_memory_equal(mesh.vertices, points, sizeof points);
    assert_memory_equal(mesh.elements, wanted, sizeof wanted);
    assert_true(mesh.ids[0] == 117 && mesh.ids[1] == 3);
    bytes_free(&text);
    if (form->whole[0] == 'U')
        return;
    text = vtu_of(form, wrong);
    problem = (struct api_problem){0};
    assert_int_equal(map_target_vtu(text.data, text.length, arena, &mesh, &problem),
                     API_INVALID_REQUEST);
    assert_non_null(strstr(problem.error[0].detail, "cell 1: its id is -1"));
    bytes_free(&text);
}

static void test_vtu_in_bytes_of_every_form(void **state) {
    static const char *const whole[] = {"Int8",  "Int16",  "Int32",  "Int64",
                                        "UInt8", "UInt16", "UInt32", "UInt64"};
    (void)state;
    for (unsigned k = 0; k < 32; k++) {
        struct form form = {.appended = k & 1,
                            .base64 = k & 2 || !(k & 1),
                            .packed = k & 4,
                            .wide = k & 8,
                            .big = k & 16,
                            .real = k & 1 ? "Float64" : "Float32",
                            .whole = whole[k % COUNT(whole)]};
        check_form(&form);
        form.whole = whole[(k + 3) % COUNT(whole)];
        check_form(&form);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_vtu_has_these_shapes),
        cmocka_unit_test(test_vtu_in_bytes_of_every_form),
    };
    return cmocka_run_group_tests_name("map_vtu", tests, set_up, tear_down);
}
