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

enum file { MESH, PARTS, PARAMETERS, DENSE, README, FILES };

static const char *const file_names[FILES] = {"mesh.bdf", "part_description.csv",
                                              "simulation_params.csv", "dense_elements.csv",
                                              "README.txt"};

struct state {
    struct lcmsim_source source;
    struct lcmsim_bins bins;
    struct zip_entry entry[FILES]; /* of those that are there */
    int entries;
    uint64_t position;
    enum file file;
    bool open, complete;           /* the entry is begun; its text is whole */
    size_t vertex, element, dense; /* where mesh.bdf and the list of dense elements are */
    uint32_t number;               /* of the last triangle */
    z_stream deflate;
    bool deflating;
    char buffer[TEXT_BYTES]; /* what is being compressed */
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

/* Plain decimals come first: an exponent has to be closer by half. */
void lcmsim_field(double value, char field[8]) {
    double size = fabs(value), error = INFINITY;
    char text[64], mantissa[48];
    if (size == 0 || (size >= 0.01 && size < 99999)) {
        write_decimal(size == 0 ? 0 : value, field);
        return;
    }
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

/* A float as Julia reads one: with a point, or an exponent. */
static void write_julia_float(struct api_text *text, double value) {
    char number[API_NUMBER_SIZE + 1];
    size_t length = api_number_rounded(number, value, 9);
    number[length] = '\0';
    api_text_raw(text, number);
    if (!strpbrk(number, ".e"))
        api_text_raw(text, ".0");
}

/* ---- mesh.bdf ---- */

/* A piece of the mesh. Quadrilaterals are split along the first diagonal; both halves are of one
 * part. What cannot be filled is not there. */
static bool write_bulk_data(struct api_text *text, const struct map_fields *fields,
                            struct state *state) {
    if (state->vertex == 0)
        api_text_raw(text, "BEGIN BULK\n");
    for (int k = 0; k < LINES && state->vertex < fields->vertex_count; k++) {
        struct vec3 v = vec3_scale(fields->unit->metres, fields->vertices[state->vertex++]);
        char x[FIELD], y[FIELD], z[FIELD];
        lcmsim_field(v.x, x);
        lcmsim_field(v.y, y);
        lcmsim_field(v.z, z);
        api_text_format(text, "GRID    %8zu        %.8s%.8s%.8s\n", state->vertex, x, y, z);
    }
    if (state->vertex < fields->vertex_count)
        return false;
    for (int k = 0; k < LINES / 2 && state->element < fields->element_count; k++) {
        int part = state->bins.part[state->element];
        const int32_t *corner = fields->elements[state->element++];
        for (int half = 0; part != 0 && half < (corner[3] < 0 ? 1 : 2); half++)
            api_text_format(text, "CTRIA3  %8u%8d%8d%8d%8d\n", ++state->number, part, corner[0] + 1,
                            corner[half + 1] + 1, corner[half + 2] + 1);
    }
    if (state->element < fields->element_count)
        return false;
    api_text_raw(text, "ENDDATA\n");
    return true;
}

/* ---- the tables ---- */

/* Of the columns of a part, version 2 has the first. */
enum { PART_NAMES = 3, PART_NUMBERS = 19, PART_NUMBERS_2 = 14 - PART_NAMES };

static const char part_names_2[] =
    "name,type,part_id,thickness,porosity,porosity_noise,permeability,permeability_noise,alpha,"
    "refdir1,refdir2,refdir3,porosity_1,p_1";
static const char part_names_3[] = ",porosity_2,p_2,n_CK,permeability_Z,thickness_DM,porosity_DM,"
                                   "permeability_DM,permeability_DM_Z";

static int version_of(const struct encoder *encoder) {
    return encoder->options.lcmsim_version ? encoder->options.lcmsim_version : 3;
}

/* How a part gives way to the pressure p of the resin. LCMsim has the parabola of its porosity e
 * through p = 0 and two other pressures, and the permeability K e^(n + 1) / (1 - e)^n, with n = 2
 * that of Kozeny and Carman; with n = 0 neither changes (v3, model_3.jl). */
struct compaction {
    double porosity[MAP_RELIEFS], pressure[MAP_RELIEFS], n, factor; /* factor: of K at p = 0 */
};

/* LCMsim refuses a part whose porosity it takes to be more than LCMSIM_POROSITY_MAX at 1e5 Pa. */
static struct compaction compaction_of(const struct map_fields *fields,
                                       const struct lcmsim_inputs *in) {
    double porosity = fmin(in->porosity, LCMSIM_POROSITY_MAX);
    const double *e = in->relieved, p1 = fields->relief[0], p2 = fields->relief[1], p = 1e5;
    struct compaction rigid = {{porosity, porosity}, {0.9e5, 1.0e5}, 0, 1}, own = rigid;
    if (!fields->relieved[0] || !(e[0] > porosity))
        return rigid;
    double first = (e[0] - in->porosity) / p1, second = (e[1] - e[0]) / (p2 - p1);
    if (in->porosity + first * p + (second - first) / p2 * p * (p - p1) > LCMSIM_POROSITY_MAX)
        return rigid;
    memcpy(own.porosity, in->relieved, sizeof own.porosity);
    memcpy(own.pressure, fields->relief, sizeof own.pressure);
    own.n = 2;
    own.factor = (1 - porosity) * (1 - porosity) / (porosity * porosity * porosity);
    return own;
}

static void write_part(struct api_text *text, const struct encoder *encoder, const char *type,
                       int part, const struct lcmsim_inputs *in) {
    int version = version_of(encoder);
    double porosity = fmin(in->porosity, LCMSIM_POROSITY_MAX);
    double alpha = in->k1 > 0 ? in->k2 / in->k1 : 1;
    const struct map_fields none = {.unit = NULL};
    const struct compaction c =
        compaction_of(version == 2 || part == LCMSIM_CHANNEL_PART ? &none : &encoder->fields, in);
    const struct vec3 d = in->direction;
    const double k1 = c.factor * in->k1, k3 = c.factor * in->k3, *e = c.porosity, *p = c.pressure;
    const double values[PART_NUMBERS] = {in->thickness, porosity, 0,    k1,   0,    alpha, d.x, d.y,
                                         d.z,           e[0],     p[0], e[1], p[1], c.n,   k3,  0,
                                         0.5,           9.5e-10,  1e-13};
    api_text_format(text, "%s%d,%s,%d", type, part, type, part);
    for (int k = 0; k < (version == 2 ? PART_NUMBERS_2 : PART_NUMBERS); k++) {
        api_text_raw(text, ",");
        write_julia_float(text, values[k]);
    }
    api_text_raw(text, "\n");
}

static bool has_dense(const struct state *state) {
    return state->bins.left_out + state->bins.capped > 0;
}

/* ---- the readme ---- */

static const char parameters[] = "p_ref,rho_ref,gamma,mu_resin,p_a,p_init,rho_0_air,rho_0_oil\n"
                                 "1.01325e5,1.225,1.4,0.06,1.35e5,1.0e5,1.2,960\n";

static const struct {
    const char *name, *key, *unit;
    double factor;
} differences[LCMSIM_DIFFERENCES] = {
    [LCMSIM_DIRECTION] = {"direction of k1", "direction_deg", "deg", 1},
    [LCMSIM_K1] = {"k1", "k1", "%", 100},
    [LCMSIM_K2] = {"k2", "k2", "%", 100},
    [LCMSIM_THICKNESS] = {"thickness", "thickness", "%", 100},
    [LCMSIM_POROSITY] = {"porosity", "porosity", "", 1},
};

static void write_readme(struct api_text *text, const struct encoder *encoder) {
    const struct state *state = encoder->state;
    const struct lcmsim_bins *bins = &state->bins;
    bool inlet = bins->role_count[MAP_INLET] > 0;
    char origin[ENCODER_NOTE_SIZE];
    encoder_origin(encoder, origin);
    api_text_format(text,
                    "A case for LCMsim v%d, made from %s. SI units.\n\n"
                    "mesh.bdf               %zu nodes, %u triangles (quadrilaterals are split)\n"
                    "part_description.csv   %zu parts of fabric, ids from %d on; ",
                    version_of(encoder), origin, encoder->fields.vertex_count,
                    (unsigned)state->number, bins->count, LCMSIM_FIRST_PART);
    api_text_format(text, inlet ? "part %d is the inlet" : "no inlet is given", LCMSIM_INLET_PART);
    if (bins->role_count[MAP_OUTLET])
        api_text_format(text, ",\n                       part %d the outlet", LCMSIM_OUTLET_PART);
    api_text_raw(
        text, "\n"
              "simulation_params.csv  pressures and resin: typical values, to be replaced\n\n"
              "LCMsim takes properties by part. Elements alike in k1 direction, k1, k2, thickness\n"
              "and porosity share a part, which has their area-weighted mean. An element differs\n"
              "from its part by\n");
    api_text_format(text, "  %-16s%10s  %s\n", "", "at most", "on 95 % of the area");
    for (int k = 0; k < LCMSIM_DIFFERENCES; k++)
        api_text_format(text, "  %-16s%10.3g  %.3g %s\n", differences[k].name,
                        differences[k].factor * bins->largest[k],
                        differences[k].factor * bins->most[k], differences[k].unit);
    api_text_format(
        text,
        "The direction is compared where k2/k1 is below %g.\n\n"
        "permeability is k1 along refdir, which LCMsim projects on each element; alpha is\n"
        "k2/k1; porosities over %g are written as %g.\n",
        LCMSIM_ISOTROPIC, LCMSIM_POROSITY_MAX, LCMSIM_POROSITY_MAX);
    if (encoder->fields.relieved[0] && version_of(encoder) == 3)
        api_text_raw(
            text,
            "\nThe stack gives way to the resin: porosity is that under the whole pressure,\n"
            "porosity_1 and porosity_2 those where the resin carries p_1 and p_2 of it. With\n"
            "n_CK 2 LCMsim multiplies permeability and permeability_Z by e^3 / (1 - e)^2 of its\n"
            "porosity e; what is written is so much smaller. n_CK is 0 in parts that do not\n"
            "give way, or that would have a porosity of more than 0.99 at 1e5 Pa.\n");
    if (bins->role_count[MAP_CHANNEL] > 0)
        api_text_format(
            text,
            "\nPart %d is the channel along the rim of the cloth: %zu elements, which have\n"
            "the thickness and porosity of their fabric and a permeability of %g m^2.\n",
            LCMSIM_CHANNEL_PART, bins->role_count[MAP_CHANNEL],
            encoder->fields.channel_permeability);
    if (bins->capped > 0)
        api_text_format(
            text,
            "\n%zu elements are denser than a fibre volume fraction of %g and are taken to\n"
            "have that, and the permeability of the densest element below it, scaled by\n"
            "Kozeny and Carman: dense_elements.csv.\n",
            bins->capped, state->source.cap);
    if (bins->left_out > 0)
        api_text_format(text,
                        "\n%zu elements are packed too densely to be filled and are left out of\n"
                        "mesh.bdf, as walls to the flow: dense_elements.csv.\n",
                        bins->left_out);
}

/* Appends the next piece of the current file; whether it is the last. */
static bool write_file_text(struct encoder *encoder, struct api_text *text) {
    struct state *state = encoder->state;
    const struct lcmsim_bins *bins = &state->bins;
    const struct map_fields *fields = &encoder->fields;
    const struct api_column_source *ids;
    struct lcmsim_inputs in;
    switch (state->file) {
    case MESH:
        return write_bulk_data(text, fields, state);
    case PARTS:
        api_text_format(text, "%s%s\n", part_names_2, version_of(encoder) == 2 ? "" : part_names_3);
        if (bins->role_count[MAP_INLET])
            write_part(text, encoder, "inlet", LCMSIM_INLET_PART, &bins->role[MAP_INLET]);
        for (size_t k = 0; k < bins->count; k++)
            write_part(text, encoder, "base", LCMSIM_FIRST_PART + (int)k, &bins->bin[k]);
        if (bins->role_count[MAP_CHANNEL])
            write_part(text, encoder, "patch", LCMSIM_CHANNEL_PART, &bins->role[MAP_CHANNEL]);
        if (bins->role_count[MAP_OUTLET])
            write_part(text, encoder, "outlet", LCMSIM_OUTLET_PART, &bins->role[MAP_OUTLET]);
        return true;
    case DENSE: /* a piece of the list, by the ids of the map's column */
        ids = encoder_find(fields->columns, fields->column_count, API_TABLE_CELLS,
                           column_specs[COLUMN_CELLS_id].name);
        if (state->dense == 0)
            api_text_raw(text, "id,fiber_volume_fraction,treatment\n");
        for (int k = 0; k < LINES && state->dense < fields->element_count; k++) {
            size_t element = state->dense++;
            double id = (double)element;
            enum lcmsim_state how = lcmsim_read(&state->source, element, &in);
            if (how == LCMSIM_AS_IT_IS)
                continue;
            if (ids)
                ids->fill(ids->context, element, 1, &id);
            api_text_format(text, "%lld,", (long long)id);
            write_julia_float(text, lcmsim_fraction(&state->source, element));
            api_text_raw(text, how == LCMSIM_CAPPED ? ",capped\n" : ",left out\n");
        }
        return state->dense == fields->element_count;
    case PARAMETERS:
        api_text_raw(text, parameters);
        return true;
    default:
        write_readme(text, encoder);
        return true;
    }
}

/* ---- the archive ---- */

/* A text is packed at once: the piece has room for it and for what zlib holds back. */
static void next_lcmsim(struct encoder *encoder) {
    struct state *state = encoder->state;
    struct api_text *piece = &encoder->piece;
    z_stream *z = &state->deflate;
    if (state->file == FILES) {
        zip_end(piece, state->entry, (size_t)state->entries, state->position);
        encoder->ended = true;
        return;
    }
    struct zip_entry *entry = &state->entry[state->entries];
    if (!state->open) {
        *entry = (struct zip_entry){.method = ZIP_DEFLATED, .trailed = true};
        strcpy(entry->name, file_names[state->file]);
        entry->offset = state->position;
        entry->crc = (uint32_t)crc32(0, NULL, 0);
        zip_begin_entry(piece, entry);
        encoder->failed = deflateReset(z) != Z_OK;
        state->open = true;
        state->complete = false;
    }
    struct api_text text = api_text_over(state->buffer, sizeof state->buffer);
    if (!state->complete)
        state->complete = write_file_text(encoder, &text);
    entry->size += text.length;
    entry->crc = (uint32_t)crc32_z(entry->crc, (const Bytef *)state->buffer, text.length);
    size_t room = piece->capacity - piece->length - ZIP_HEADER_MAX;
    z->next_in = (Bytef *)state->buffer;
    z->avail_in = (uInt)text.length;
    z->next_out = (Bytef *)piece->bytes + piece->length;
    z->avail_out = (uInt)room;
    int answer = deflate(z, state->complete ? Z_FINISH : Z_NO_FLUSH);
    piece->length += room - z->avail_out;
    entry->packed += room - z->avail_out;
    encoder->failed = encoder->failed || text.failed || answer == Z_STREAM_ERROR || z->avail_in > 0;
    if (answer == Z_STREAM_END) { /* the entry is complete */
        zip_end_entry(piece, &state->entry[state->entries++]);
        state->open = false;
        state->file++;
        state->file += state->file == DENSE && !has_dense(state);
    }
    state->position += piece->length;
}

/* ---- the beginning ---- */

/* The note is "bins=125; direction_deg=0.6; k1=0.002; ...", the bounds of 95 % of the area behind.
 */
static bool begin_lcmsim(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    struct lcmsim_bins *bins = &state->bins;
    enum { RAW = -15 }; /* zlib's way to say: without a header of its own */
    if (!lcmsim_open(&state->source, &encoder->fields, encoder->options.fiber_volume_fraction,
                     problem))
        return false;
    state->deflating =
        deflateInit2(&state->deflate, LEVEL, Z_DEFLATED, RAW, 8, Z_DEFAULT_STRATEGY) == Z_OK;
    if (!state->deflating || !lcmsim_make_bins(bins, &state->source))
        return !api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to bin the elements");
    struct api_text note = api_text_over(encoder->binning, sizeof encoder->binning - 1);
    api_text_format(&note, "bins=%zu", bins->count);
    for (int k = 0; k < LCMSIM_DIFFERENCES; k++)
        api_text_format(&note, "; %s=%.3g", differences[k].key, bins->largest[k]);
    for (int k = 0; k < LCMSIM_DIFFERENCES; k++)
        api_text_format(&note, "; %s_95=%.3g", differences[k].key, bins->most[k]);
    if (has_dense(state))
        api_text_format(&note, "; left_out=%zu; capped=%zu", bins->left_out, bins->capped);
    encoder->binning[note.length] = '\0';
    return true;
}

static void end_lcmsim(struct encoder *encoder) {
    struct state *state = encoder->state;
    lcmsim_free_bins(&state->bins);
    if (state->deflating)
        deflateEnd(&state->deflate);
}

const struct format format_lcmsim = {
    .uses = FORMAT_MAP,
    .flow = true,
    .elements = true,
    .name = "lcmsim",
    .media_type = "application/zip",
    .about = "a zip with a case for LCMsim",
    .exact = "elements in at most 125 parts; coordinates of 8 characters; values of 9 digits",
    .state_size = sizeof(struct state),
    .begin = begin_lcmsim,
    .next = next_lcmsim,
    .end = end_lcmsim};
