/* SPDX-License-Identifier: MIT */
/*
 * Binary glTF 2.0: the cells as two triangles each, the nodes coloured by their absolute shear. The
 * file is a description in JSON and one buffer with the positions (float), the colours (linear
 * RGBA, 16 bits) and the indices; all lengths are known from the start. glTF counts in metres: the
 * drape's own unit is the scale of its node.
 */
#include "api/result/cell_corners.h"
#include "colour.h"
#include "encoder.h"
#include <endian.h>
#include <math.h>
#include <string.h>

enum {
    COLOURS = 256,
    POSITION = 12, /* bytes of a node's position, of its colour, of a cell's indices */
    COLOUR = 8,
    INDICES = 24,
    HEADER = 12, /* bytes before the chunks, and before each chunk's own */
    CHUNK = 8,
    ROWS = ENCODER_VALUES / 4, /* of one piece */
    ARRAY_BUFFER = 34962,      /* names of OpenGL that glTF uses */
    ELEMENT_BUFFER = 34963,
    UNSIGNED_SHORT = 5123,
    UNSIGNED_INT = 5125,
    FLOAT = 5126,
    POINTS = 0,
    TRIANGLES = 4
};

/* Below this greatest shear (degrees) the colours do not spread: it would be rounding that shows.
 */
static const double least_range_deg = 1;

struct state {
    const struct api_column *position[3], *shear;
    struct cell_corners quads;
    uint64_t nodes, cells;
    double range_deg; /* the shear that has the last colour */
    float low[3], high[3];
    uint16_t colour[COLOURS][4];
};

static void write_u32(struct api_text *text, uint64_t value) {
    uint32_t bits = htole32((uint32_t)value);
    api_text_bytes(text, &bits, sizeof bits);
}

static uint64_t buffer_length(const struct state *state) {
    return state->nodes * (POSITION + COLOUR) + state->cells * INDICES;
}

/* ---- the description ---- */

static void write_floats(struct api_text *text, const char *key, const float *values) {
    api_text_key(text, key);
    api_text_numbers(text, (const double[]){values[0], values[1], values[2]}, 3);
}

/* The views of the buffer, and the accessors that say what is in them. */
static void describe_buffer(struct api_text *json, const struct state *state) {
    const unsigned long long lengths[3] = {state->nodes * POSITION, state->nodes * COLOUR,
                                           state->cells * INDICES};
    unsigned long long offset = 0, nodes = state->nodes;
    api_text_format(json, ",\"buffers\":[{\"byteLength\":%llu}],\"bufferViews\":[",
                    (unsigned long long)buffer_length(state));
    for (int k = 0; k < (state->cells ? 3 : 2); offset += lengths[k++])
        api_text_format(json,
                        "%s{\"buffer\":0,\"byteOffset\":%llu,\"byteLength\":%llu,\"target\":%d}",
                        k ? "," : "", offset, lengths[k], k < 2 ? ARRAY_BUFFER : ELEMENT_BUFFER);
    api_text_format(json,
                    "],\"accessors\":[{\"bufferView\":0,\"componentType\":%d,\"count\":%llu,"
                    "\"type\":\"VEC3\"",
                    FLOAT, nodes);
    write_floats(json, "min", state->low);
    write_floats(json, "max", state->high);
    api_text_format(json,
                    "},{\"bufferView\":1,\"componentType\":%d,\"count\":%llu,\"type\":\"VEC4\","
                    "\"normalized\":true}",
                    UNSIGNED_SHORT, nodes);
    if (state->cells)
        api_text_format(
            json, ",{\"bufferView\":2,\"componentType\":%d,\"count\":%llu,\"type\":\"SCALAR\"}",
            UNSIGNED_INT, (unsigned long long)state->cells * 6);
    api_text_raw(json, "]");
}

/* All that comes before the buffer's bytes. */
static void write_description(const struct encoder *encoder, struct api_text *text) {
    const struct state *state = encoder->state;
    double scale = encoder->columns.unit->metres;
    char buffer[API_HEADER_MAX];
    struct api_text json = api_text_over(buffer, sizeof buffer);
    api_text_raw(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"draped\"},\"scene\":0,"
                        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0");
    if (scale != 1) {
        api_text_key(&json, "scale");
        api_text_numbers(&json, (const double[]){scale, scale, scale}, 3);
    }
    api_text_raw(&json, "}],\"meshes\":[{");
    api_text_key_string(&json, "name", encoder->id);
    api_text_format(&json,
                    ",\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":1}%s,"
                    "\"mode\":%d,\"material\":0}],"
                    "\"extras\":{\"colour\":\"absolute shear, viridis\"",
                    state->cells ? ",\"indices\":2" : "", state->cells ? TRIANGLES : POINTS);
    api_text_key(&json, "shear_deg");
    api_text_numbers(&json, (const double[]){0, state->range_deg}, 2);
    api_text_key_string(&json, "length_unit", encoder->columns.unit->name);
    api_text_raw(&json, "}}],\"materials\":[{\"doubleSided\":true,\"pbrMetallicRoughness\":"
                        "{\"metallicFactor\":0,\"roughnessFactor\":1}}]");
    describe_buffer(&json, state);
    api_text_raw(&json, "}");
    while (json.length % 4 != 0)
        api_text_raw(&json, " ");
    uint64_t length = HEADER + CHUNK + json.length + CHUNK + buffer_length(state);
    api_text_raw(text, "glTF");
    write_u32(text, 2);
    write_u32(text, length);
    write_u32(text, json.length);
    api_text_raw(text, "JSON");
    api_text_bytes(text, json.bytes, json.length);
    write_u32(text, buffer_length(state));
    api_text_bytes(text, "BIN", 4);
    text->failed = text->failed || json.failed || length > UINT32_MAX;
}

/* ---- the buffer ---- */

/* The encoder's column is the view that is being written: positions, colours, and of each cell the
 * indices of two triangles, both turning as warp turns to weft. */
static void next_glb(struct encoder *encoder) {
    static const int corner[6] = {0, 1, 2, 0, 2, 3};
    struct state *state = encoder->state;
    int32_t corners[ROWS][4];
    if (!encoder->begun)
        write_description(encoder, &encoder->piece);
    encoder->begun = true;
    size_t rows = (size_t)(encoder->column < 2 ? state->nodes : state->cells);
    size_t count = encoder_left(encoder, rows, ROWS);
    char *bytes = encoder->piece.bytes + encoder->piece.length;
    switch (encoder->column) {
    case 0:
        for (int k = 0; k < 3; k++) {
            if (!api_columns_read(encoder->reader, state->position[k], encoder->row, count,
                                  encoder->values))
                encoder->failed = true;
            for (size_t row = 0; row < count && !encoder->failed; row++) {
                float narrow = (float)encoder->values[row];
                uint32_t bits;
                memcpy(&bits, &narrow, sizeof bits);
                bits = htole32(bits);
                memcpy(bytes + row * POSITION + 4 * k, &bits, sizeof bits);
            }
        }
        encoder->piece.length += count * POSITION;
        break;
    case 1:
        if (!api_columns_read(encoder->reader, state->shear, encoder->row, count, encoder->values))
            encoder->failed = true;
        for (size_t row = 0; row < count && !encoder->failed; row++) {
            double t = fmin(fabs(encoder->values[row]) / state->range_deg, 1);
            memcpy(bytes + row * COLOUR, state->colour[(int)(t * (COLOURS - 1) + 0.5)], COLOUR);
        }
        encoder->piece.length += count * COLOUR;
        break;
    default:
        encoder->failed = !cell_corners_next(&state->quads, count, corners, NULL);
        for (size_t cell = 0; cell < count && !encoder->failed; cell++)
            for (int k = 0; k < 6; k++)
                write_u32(&encoder->piece, (uint64_t)corners[cell][corner[k]]);
    }
    encoder_advance(encoder, rows, count);
    encoder->ended = encoder->column == 3;
}

/* ---- the beginning ---- */

static bool begin_glb(struct encoder *encoder, struct api_problem *problem) {
    static const char *const names[] = {"x", "y", "z"};
    struct state *state = encoder->state;
    const struct api_columns *columns = &encoder->columns;
    state->nodes = api_columns_rows(columns, API_TABLE_NODES);
    state->cells = api_columns_rows(columns, API_TABLE_CELLS);
    state->shear = api_columns_find(columns, API_TABLE_NODES, "shear_deg");
    state->range_deg = fmax(columns->summary.max_shear_deg, least_range_deg);
    size_t rows = (size_t)state->nodes;
    bool whole =
        state->shear && cell_corners_begin(&state->quads, encoder->reader, columns) && rows > 0;
    /* The least and greatest of each coordinate, as the numbers that are written. */
    for (int k = 0; k < 3 && whole; k++) {
        state->position[k] = api_columns_find(columns, API_TABLE_NODES, names[k]);
        state->low[k] = INFINITY;
        state->high[k] = -INFINITY;
        whole = state->position[k] != NULL;
        for (size_t first = 0, count; first < rows && whole; first += count) {
            count = rows - first < ENCODER_VALUES ? rows - first : ENCODER_VALUES;
            whole = api_columns_read(encoder->reader, state->position[k], first, count,
                                     encoder->values);
            for (size_t row = 0; row < count && whole; row++) {
                float value = (float)encoder->values[row];
                state->low[k] = value < state->low[k] ? value : state->low[k];
                state->high[k] = value > state->high[k] ? value : state->high[k];
            }
        }
    }
    if (!whole)
        return encoder_damaged(problem);
    for (int k = 0; k < COLOURS; k++) {
        double srgb[3];
        colour_viridis((double)k / (COLOURS - 1), srgb);
        for (int c = 0; c < 4; c++) {
            double light = c < 3 ? colour_linear(srgb[c]) : 1;
            state->colour[k][c] = htole16((uint16_t)(light * UINT16_MAX + 0.5));
        }
    }
    struct api_text text = api_text_over(encoder->buffer, sizeof encoder->buffer);
    write_description(encoder, &text);
    if (text.failed)
        return !api_problem_set(problem, API_TOO_LARGE,
                                "the net is too large for glTF's 32-bit lengths");
    encoder->length = text.length + buffer_length(state);
    return true;
}

const struct format format_glb = {.name = "glb",
                                  .uses = FORMAT_RESULT,
                                  .media_type = "model/gltf-binary",
                                  .about =
                                      "binary glTF: the net coloured by its shear, for viewers",
                                  .exact = "positions as 32-bit floats, colours of 16 bits",
                                  .state_size = sizeof(struct state),
                                  .begin = begin_glb,
                                  .next = next_glb};
