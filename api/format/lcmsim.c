/* SPDX-License-Identifier: MIT */
#include "lcmsim.h"

#include "api/json/number.h"
#include "encoder.h"
#include "zip.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum {
    TEXT_BYTES = 64 * 1024, /* of one piece before it is compressed */
    LINES = 512,            /* of mesh.bdf in one piece; none is longer than 96 bytes */
    LEVEL = 1,              /* the case is large, and unpacked at once */
    FIELD = 8
};

/* LCMsim refuses more. */
static const double porosity_max = 0.99;

enum file { MESH, PARTS, PARAMETERS, README, FILES };

static const char *const file_names[FILES] = {"mesh.bdf", "part_description.csv",
                                              "simulation_params.csv", "README.txt"};

struct state {
    struct lcmsim_bins bins;
    struct zip_entry entry[FILES];
    uint64_t position;
    enum file file;
    bool open, complete;         /* the entry is begun; its text is whole */
    size_t vertex, element, row; /* where mesh.bdf and the parts are */
    uint32_t number;             /* of the last triangle */
    z_stream deflate;
    bool deflating;
    struct api_text text; /* what is being compressed, from `taken` on */
    size_t taken;
    char buffer[TEXT_BYTES];
};

/* ---- numbers ---- */

/* Keeps the candidate if it fits and reads back closer than the best so far. */
static void try_field(double value, const char *candidate, double reads, double *error,
                      char field[8]) {
    size_t length = strlen(candidate);
    double own = fabs(reads - value);
    if (length > FIELD || own >= *error)
        return;
    *error = own;
    memset(field, ' ', FIELD);
    memcpy(field + FIELD - length, candidate, length);
}

/* Plain decimals come first: an exponent has to be closer by half. */
static void search_field(double value, char field[8]) {
    double error = INFINITY;
    char text[64], mantissa[48];
    for (int digits = 1; digits <= 6; digits++) {
        snprintf(text, sizeof text, "%.*f", digits, value);
        try_field(value, text, strtod(text, NULL), &error, field);
    }
    error /= 2;
    for (int digits = 1; digits <= 5; digits++) {
        snprintf(mantissa, sizeof mantissa, "%.*e", digits, value);
        char *e = strchr(mantissa, 'e');
        double reads = strtod(mantissa, NULL);
        snprintf(text, sizeof text, "%.*s%+d", (int)(e - mantissa), mantissa, atoi(e + 1));
        try_field(value, text, reads, &error, field);
    }
}

/* Between a hundredth and a hundred thousand, where most coordinates are, no exponent is closer
 * than the decimals that fit: rounded as a whole number, without zeros at the end. */
static void write_decimal(double value, char field[8]) {
    double size = fabs(value);
    int places = 6 - (value < 0), before = 1;
    for (double limit = 10; size >= limit; limit *= 10, before++)
        places--;
    double scale = 1;
    for (int k = 0; k < places; k++)
        scale *= 10;
    long long whole = llround(size * scale);
    while (places > 1 && whole % 10 == 0) {
        whole /= 10;
        places--;
    }
    int at = FIELD;
    memset(field, ' ', FIELD);
    for (int k = 0; k < places; k++, whole /= 10)
        field[--at] = (char)('0' + whole % 10);
    field[--at] = '.';
    do {
        field[--at] = (char)('0' + whole % 10);
        whole /= 10;
    } while (whole > 0);
    if (value < 0)
        field[--at] = '-';
}

void lcmsim_field(double value, char field[8]) {
    double size = fabs(value);
    if (size == 0 || (size >= 0.01 && size < 99999))
        write_decimal(size == 0 ? 0 : value, field);
    else
        search_field(value, field);
}

static void put_field(struct api_text *text, double value) {
    char field[8];
    lcmsim_field(value, field);
    api_text_bytes(text, field, FIELD);
}

static void put_integer(struct api_text *text, size_t value) {
    char field[24];
    int length = snprintf(field, sizeof field, "%8zu", value);
    api_text_bytes(text, field, (size_t)length);
}

/* A float as Julia reads one: with a point, or an exponent. */
static void put_float(struct api_text *text, double value) {
    char number[API_NUMBER_SIZE + 1];
    size_t length = api_number_rounded(number, value, 9);
    number[length] = '\0';
    api_text_raw(text, number);
    if (!strpbrk(number, ".e"))
        api_text_raw(text, ".0");
}

/* ---- mesh.bdf ---- */

static void put_vertex(struct api_text *text, const struct map_fields *fields, size_t k) {
    struct vec3 v = fields->vertices[k];
    double metres = fields->unit->metres;
    api_text_raw(text, "GRID    ");
    put_integer(text, k + 1);
    api_text_raw(text, "        ");
    put_field(text, v.x * metres);
    put_field(text, v.y * metres);
    put_field(text, v.z * metres);
    api_text_raw(text, "\n");
}

static void put_triangle(struct api_text *text, struct state *state, int part, int32_t a, int32_t b,
                         int32_t c) {
    api_text_raw(text, "CTRIA3  ");
    put_integer(text, ++state->number);
    put_integer(text, (size_t)part);
    put_integer(text, (size_t)a + 1);
    put_integer(text, (size_t)b + 1);
    put_integer(text, (size_t)c + 1);
    api_text_raw(text, "\n");
}

/* Quadrilaterals are split along the first diagonal; both halves are of one part. */
static void put_element(struct api_text *text, const struct map_fields *fields,
                        struct state *state) {
    int part = state->bins.part[state->element];
    const int32_t *corner = fields->elements[state->element++];
    put_triangle(text, state, part, corner[0], corner[1], corner[2]);
    if (corner[3] >= 0)
        put_triangle(text, state, part, corner[0], corner[2], corner[3]);
}

static bool write_mesh(struct api_text *text, const struct map_fields *fields,
                       struct state *state) {
    if (state->vertex == 0)
        api_text_raw(text, "BEGIN BULK\n");
    for (int k = 0; k < LINES && state->vertex < fields->vertex_count; k++)
        put_vertex(text, fields, state->vertex++);
    if (state->vertex < fields->vertex_count)
        return false;
    for (int k = 0; k < LINES / 2 && state->element < fields->element_count; k++)
        put_element(text, fields, state);
    if (state->element < fields->element_count)
        return false;
    api_text_raw(text, "ENDDATA\n");
    return true;
}

/* ---- the tables ---- */

static const char part_names[] =
    "name,type,part_id,thickness,porosity,porosity_noise,permeability,permeability_noise,alpha,"
    "refdir1,refdir2,refdir3,porosity_1,p_1,porosity_2,p_2,n_CK,permeability_Z,thickness_DM,"
    "porosity_DM,permeability_DM,permeability_DM_Z\n";

static void put_numbers(struct api_text *text, const double *values, size_t count) {
    for (size_t k = 0; k < count; k++) {
        api_text_raw(text, ",");
        put_float(text, values[k]);
    }
}

static void write_part(struct api_text *text, const char *type, int part,
                       const struct lcmsim_inputs *in) {
    double porosity = fmin(in->porosity, porosity_max);
    double alpha = in->k1 > 0 ? in->k2 / in->k1 : 1;
    api_text_raw(text, type);
    api_text_integer(text, part);
    api_text_raw(text, ",");
    api_text_raw(text, type);
    api_text_raw(text, ",");
    api_text_integer(text, part);
    put_numbers(text,
                (const double[]){in->thickness, porosity, 0, in->k1, 0, alpha, in->direction.x,
                                 in->direction.y, in->direction.z, porosity, 0.9e5, porosity, 1.0e5,
                                 0, in->k3, 0, 0.5, 9.5e-10, 1e-13},
                19);
    api_text_raw(text, "\n");
}

static bool write_parts(struct api_text *text, struct state *state) {
    const struct lcmsim_bins *bins = &state->bins;
    api_text_raw(text, part_names);
    if (bins->has_inlet)
        write_part(text, "inlet", LCMSIM_INLET_PART, &bins->inlet);
    for (size_t k = 0; k < bins->count; k++)
        write_part(text, "base", LCMSIM_FIRST_PART + (int)k, &bins->bin[k]);
    return true;
}

static const char parameters[] = "p_ref,rho_ref,gamma,mu_resin,p_a,p_init,rho_0_air,rho_0_oil\n"
                                 "1.01325e5,1.225,1.4,0.06,1.35e5,1.0e5,1.2,960\n";

static void write_readme(struct api_text *text, const struct encoder *encoder) {
    const struct state *state = encoder->state;
    const struct lcmsim_bins *bins = &state->bins;
    char line[1200];
    snprintf(line, sizeof line,
             "A case for LCMsim, made from drape %s. SI units.\n\n"
             "mesh.bdf               %zu nodes, %u triangles (quadrilaterals are split)\n"
             "part_description.csv   %zu parts of fabric, ids from %d on%s\n"
             "simulation_params.csv  pressures and resin: typical values, to be replaced\n\n"
             "LCMsim takes properties by part. Elements alike in k1 direction, k1, thickness and\n"
             "porosity share a part, which has their area-weighted mean. An element differs from\n"
             "its part by at most\n"
             "  direction of k1  %.3g deg (where k2/k1 is below %g)\n"
             "  k1               %.3g %%\n"
             "  thickness        %.3g %%\n\n"
             "permeability is k1 along refdir, which LCMsim projects on each element; alpha is\n"
             "k2/k1; porosities over %g are written as %g.\n",
             encoder->id, encoder->fields.vertex_count, (unsigned)state->number, bins->count,
             LCMSIM_FIRST_PART, bins->has_inlet ? "; part 1 is the inlet" : "; no inlet is given",
             bins->direction_deg, LCMSIM_ISOTROPIC, 100 * bins->k1, 100 * bins->thickness,
             porosity_max, porosity_max);
    api_text_raw(text, line);
}

/* Appends the next piece of the current file; whether it is the last. */
static bool write_text(struct encoder *encoder, struct api_text *text) {
    struct state *state = encoder->state;
    switch (state->file) {
    case MESH:
        return write_mesh(text, &encoder->fields, state);
    case PARTS:
        return write_parts(text, state);
    case PARAMETERS:
        api_text_raw(text, parameters);
        return true;
    default:
        write_readme(text, encoder);
        return true;
    }
}

/* ---- the archive ---- */

static void open_entry(struct encoder *encoder) {
    struct state *state = encoder->state;
    struct zip_entry *entry = &state->entry[state->file];
    *entry = (struct zip_entry){.method = ZIP_DEFLATED, .trailed = true};
    strcpy(entry->name, file_names[state->file]);
    entry->offset = state->position;
    entry->crc = (uint32_t)crc32(0, NULL, 0);
    zip_begin_entry(&encoder->piece, entry);
    encoder->failed = deflateReset(&state->deflate) != Z_OK;
    state->open = true;
    state->complete = false;
}

/* Takes more text when the last is compressed. */
static void take_text(struct encoder *encoder) {
    struct state *state = encoder->state;
    struct zip_entry *entry = &state->entry[state->file];
    if (state->taken < state->text.length || state->complete)
        return;
    state->text = api_text_over(state->buffer, sizeof state->buffer);
    state->taken = 0;
    state->complete = write_text(encoder, &state->text);
    encoder->failed = encoder->failed || state->text.failed;
    entry->size += state->text.length;
    entry->crc = (uint32_t)crc32_z(entry->crc, (const Bytef *)state->buffer, state->text.length);
}

/* Compresses what there is into the piece; whether the entry is complete. */
static bool compress_text(struct encoder *encoder) {
    struct state *state = encoder->state;
    struct api_text *piece = &encoder->piece;
    z_stream *z = &state->deflate;
    size_t room = piece->capacity - piece->length - ZIP_HEADER_MAX;
    z->next_in = (Bytef *)state->buffer + state->taken;
    z->avail_in = (uInt)(state->text.length - state->taken);
    z->next_out = (Bytef *)piece->bytes + piece->length;
    z->avail_out = (uInt)room;
    int answer = deflate(z, state->complete ? Z_FINISH : Z_NO_FLUSH);
    state->taken = state->text.length - z->avail_in;
    piece->length += room - z->avail_out;
    state->entry[state->file].packed += room - z->avail_out;
    encoder->failed = encoder->failed || answer == Z_STREAM_ERROR;
    return answer == Z_STREAM_END;
}

static void write_directory(struct encoder *encoder) {
    struct state *state = encoder->state;
    for (int k = 0; k < FILES; k++)
        zip_list_entry(&encoder->piece, &state->entry[k]);
    zip_end(&encoder->piece, FILES, state->position, encoder->piece.length);
    encoder->ended = true;
}

static void next(struct encoder *encoder) {
    struct state *state = encoder->state;
    if (state->file == FILES) {
        write_directory(encoder);
        return;
    }
    if (!state->open)
        open_entry(encoder);
    take_text(encoder);
    if (compress_text(encoder)) {
        zip_end_entry(&encoder->piece, &state->entry[state->file]);
        state->open = false;
        state->text.length = state->taken = 0;
        state->file++;
    }
    state->position += encoder->piece.length;
}

/* ---- the beginning ---- */

static bool begin(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    struct lcmsim_bins *bins = &state->bins;
    enum { RAW = -15 }; /* zlib's way to say: without a header of its own */
    if (!lcmsim_check(&encoder->fields, problem))
        return false;
    state->deflating =
        deflateInit2(&state->deflate, LEVEL, Z_DEFLATED, RAW, 8, Z_DEFAULT_STRATEGY) == Z_OK;
    if (!state->deflating || !lcmsim_make_bins(bins, &encoder->fields)) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to bin the elements");
        return false;
    }
    snprintf(encoder->binning, sizeof encoder->binning,
             "bins=%zu; direction_deg=%.3g; k1=%.3g; thickness=%.3g", bins->count,
             bins->direction_deg, bins->k1, bins->thickness);
    return true;
}

static void end(struct encoder *encoder) {
    struct state *state = encoder->state;
    lcmsim_free_bins(&state->bins);
    if (state->deflating)
        deflateEnd(&state->deflate);
}

const struct format format_lcmsim = {
    .uses = FORMAT_MAP,
    .elements = true,
    .name = "lcmsim",
    .media_type = "application/zip",
    .about = "a zip with a case for LCMsim",
    .exact = "elements in at most 125 parts; coordinates of 8 characters; values of 9 digits",
    .state_size = sizeof(struct state),
    .begin = begin,
    .next = next,
    .end = end};
