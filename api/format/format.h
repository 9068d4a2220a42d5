/* SPDX-License-Identifier: MIT */
/*
 * The formats in which documents are sent, and a document while it is being sent: an encoder gives
 * its bytes as they are asked for, in bounded memory, as an HTTP server sends them. Results, maps
 * and patterns share both. A format is one file that defines a `struct format` (`encoder.h` is for
 * its author) and one name in the registry of `format.c`.
 */
#ifndef API_FORMAT_FORMAT_H
#define API_FORMAT_FORMAT_H

#include "api/problem.h"
#include "api/request/request.h"
#include "api/result/columns.h"
#include "solver/lamina.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

struct encoder;

/* What a document shows; a format may serve several. */
enum format_use {
    FORMAT_RESULT = 1,  /* a stored result, all of it or a selection of columns */
    FORMAT_MAP = 2,     /* fields at the caller's points or elements */
    FORMAT_PATTERN = 4, /* the flat cut pattern of a stored result */
    FORMAT_REPORT = 8,  /* a page that says all about a stored result */
    FORMAT_LASER = 16,  /* of a laminate: what projectors draw; no encoder writes it */
    FORMAT_BUNDLE = 32, /* of a laminate: all of it; likewise */
    FORMAT_BOOK = 64,   /* of a laminate: what became of its plies; likewise */
};

struct format {
    const char *name;       /* in `?format=`; unique within a use */
    const char *media_type; /* without parameters; unique within a use */
    const char *about;      /* one line for documentation: what it is */
    const char *exact;      /* and how exactly it holds the values */
    unsigned uses;          /* enum format_use, or-ed */
    bool one_table;         /* of a result: holds the table of the options alone */
    bool elements;          /* of a map: needs elements, so cannot show points */
    bool flow;              /* of a map: shows inlet, outlet and the channel along the rim */
    bool yarns;             /* of a map: has to know what its plies are made of */
    bool outlines;          /* of a map: shows the edges of the plies of a laminate */
    bool tables;            /* of a result: shows any tables there are, those of a study too */
    const void *own;        /* data that formats sharing their functions differ by */
    size_t state_size;      /* bytes of `encoder->state`; 0: it keeps none */
    /* Prepares the state, which is zero, once the columns are selected; NULL when there is nothing
     * to prepare. False with the problem set. */
    bool (*begin)(struct encoder *encoder, struct api_problem *problem);
    /* Appends the next piece to `encoder->piece`, which is empty and has ENCODER_PIECE bytes of
     * room; sets `ended` with the last one, or `failed` when the source cannot be read. */
    void (*next)(struct encoder *encoder);
    /* Frees what the state holds; NULL when it holds nothing. Also called when `begin` failed. */
    void (*end)(struct encoder *encoder);
};

/* The formats of a use: walked, the default first (NULL after the last); by name; by media type
 * without parameters, in any case. NULL when there is none. */
const struct format *format_at(enum format_use use, size_t index);
const struct format *format_named(enum format_use use, const char *name);
const struct format *format_for_media_type(enum format_use use, const char *media_type);

/* How the caller wants the document. Zero-initialised: the defaults. By default stacks are grouped
 * within FORMAT_WITHIN degrees and percent: less than cloth lies off its place on a tool, and some
 * hundred groups for thousands of elements. */
enum { FORMAT_NAME_SIZE = 64, FORMAT_WITHIN = 2 };

/* As what a deck has a woven ply, whose warp and weft are not square (`yarn_plies.h`). */
enum format_plies_as {
    PLIES_AS_DEFAULT, /* what suits the format */
    PLIES_AS_WARP,    /* one layer along the warp, as if it were square */
    PLIES_AS_YARNS,   /* two unidirectional layers, along warp and along weft */
    PLIES_AS_BISECTOR /* one layer along the bisector of both, with the constants of the two */
};

struct format_options {
    int precision;      /* significant digits, 1..17; 0: the shortest that reads back the same */
    const char *fields; /* "nodes.x,cells.k1": only these columns; of a map also "k1"; NULL or
                           "": all */
    enum api_table
        table;        /* for formats that hold one table: nodes, cells or cuts, of a study
                         variants or bands; of a map cells (what nodes means as well) or plies */
    bool table_given; /* not: the first of these */
    double within;    /* of formats that group stacks: how far an element's may be from the group's,
                         in degrees and in percent of thickness; 0: not at all */
    bool within_given; /* not: FORMAT_WITHIN */
    enum format_plies_as plies_as;
    /* of lcmsim */
    int lcmsim_version;           /* 2 or 3; 0: 3 */
    double fiber_volume_fraction; /* what denser elements are taken to have; 0: they are left out */
    /* of patterns and reports */
    double allowance; /* in the drape's unit; 0: none */
    bool partial;     /* dxf of cloth that leaves some bare, too */
    char part[FORMAT_NAME_SIZE], ply[FORMAT_NAME_SIZE]; /* for the title; "": not given */
};

/* Sets the option that a query parameter or command-line flag `name` (precision, fields, table,
 * within, plies_as, lcmsim_version, at_most_fiber_volume_fraction, allowance, partial, part, ply)
 * stands for; `fields` is kept as a pointer to `value`. False with `problem` set (invalid-request,
 * naming the option) when `value` is not in its range; false with `problem` unset when there is no
 * option of that name. */
bool format_option(struct format_options *options, const char *name, const char *value,
                   struct api_problem *problem);

/* How far stacks are grouped. */
double format_within(const struct format_options *options);

enum { MAP_WARNINGS_MAX = 8, MAP_RELIEFS = 2 };

/* What an element is to the flow beside fabric: where resin comes in and goes out, and the gap
 * along the rim of the cloth in which it runs ahead (race-tracking). */
enum map_role { MAP_FABRIC, MAP_INLET, MAP_OUTLET, MAP_CHANNEL, MAP_ROLES };

/* A ply at an element. */
struct map_ply_row {
    int32_t element;  /* from 0 */
    int16_t ply;      /* from 0, the first on the tool */
    bool mirrored;    /* the element's normal and the cloth's look to different sides */
    double angle_deg; /* from the element's reference direction to the warp (`element_frame.h`) */
    double shear_deg; /* positive where the quadrant between warp and weft closes */
    double thickness; /* 0: not known */
    double fiber_volume_fraction; /* 0: not known */
};

enum { MAP_PLIES_MAX = INT16_MAX };

/* What a ply is made of. */
struct map_ply_kind {
    double warp_share;    /* of its yarns, 0..1; 1: it is unidirectional, along warp */
    struct lamina lamina; /* a unidirectional layer of its yarns, Pa; e1 is 0: not known */
};

/* The edge of a ply on the part, in space: the last point is the first. */
struct map_outline {
    const struct vec3 *points;
    size_t count; /* 0: it has holes, or is of several parts */
};

/* The stack of plies on a mesh, which of a single drape has one ply. All arrays are the caller's.
 */
struct map_plies {
    size_t ply_count;         /* 1..MAP_PLIES_MAX */
    int side;                 /* they follow each other along warp x weft, 1, or against, -1 */
    const char *const *names; /* of each ply, ASCII, not empty */
    const int (*numbers)[2];  /* pieces count as plies: of each its ply, from 1, and its number in
                                 that, 0 where the ply is of one; NULL: all are */
    const struct map_ply_row *rows; /* by element, then ply; none where the ply does not reach */
    size_t row_count;
    const size_t *first;              /* `element_count` + 1: the rows of element e are first[e] to
                                         first[e + 1] - 1, none of a bare one */
    bool thickness, fraction;         /* whether the rows know them; then all do */
    const struct vec3 *reference;     /* the caller's direction; NULL: each element's first edge */
    const struct map_ply_kind *kinds; /* of each ply; NULL: not asked for */
    const struct map_outline *outlines; /* likewise; NULL also of a single drape */
};

/* A set of elements that the caller's mesh names, and the number of their property. */
struct map_set {
    const char *name; /* ASCII */
    int32_t property;
};

/* Fields on a mesh or at points. All arrays are the caller's and outlive the encoder. */
struct map_fields {
    const struct api_unit *unit; /* of the vertices and of all lengths */
    const struct vec3 *vertices;
    size_t vertex_count;
    const int32_t (*elements)[4]; /* vertices from 0, in order; the fourth of a triangle is -1 */
    size_t element_count;
    const int32_t *ids, *vertex_ids; /* positive, as the caller numbers elements and vertices; NULL:
                                        from 1 in their order */
    const int32_t *pids; /* the property of each element, 0 or positive; NULL: there are none */
    const struct map_set *sets;
    size_t set_count;
    const struct api_column_source *columns; /* of the table cells, one row an element, named as in
                                                a result; and of the table plies */
    size_t column_count;
    const struct map_plies *plies; /* NULL: points */
    const uint8_t *roles;          /* of each element, enum map_role; NULL: there are none */
    double channel_permeability;   /* m^2, of the elements that are MAP_CHANNEL */
    /* Of a stack that is pressed with a pressure and gives way: its porosity at each element where
     * the resin carries so many Pa of that; NULL: its porosity does not depend on the resin. */
    const double *relieved[MAP_RELIEFS];
    double relief[MAP_RELIEFS];
    const struct api_rosette *rosette; /* NULL: angles have none */
    const char *revision; /* of a laminate, which every format has that has a place; else NULL */
    const char *warnings[MAP_WARNINGS_MAX]; /* what the caller should know about them */
    size_t warning_count;
};

/* Where a result comes from, for a report; each may be NULL. */
struct format_record {
    const char *inputs;   /* the request as `api_normalise` writes it */
    const char *digest;   /* of the request */
    const char *finished; /* when, RFC 3339 */
    const char *program;  /* that writes the report, and its version */
};

/* Bytes of what a document says that it is of, with the 0: the id of a drape, or for one of a study
 * STUDY/variants/K. */
enum { FORMAT_ID_SIZE = API_ID_SIZE + 32 };

/* What a document is made from; all of it outlives the encoder, but for `id`. */
struct format_source {
    const char *id;                  /* of the drape; NULL: "" */
    const struct api_reader *reader; /* of a result or pattern: the stored result */
    double queue_ms;                 /* how long it waited, for summary.timing_ms */
    const struct map_fields *fields; /* of a map */
    struct format_record record;     /* of a report */
};

/*
 * A new encoder; `source`, `options` and `source->fields` are copied, what these point to is not.
 * `format` serves the use that `source` is of. NULL with `problem` set: API_INVALID_REQUEST for a
 * field that is not there or a column that is missing, API_TOO_LARGE for a document that the format
 * cannot hold, API_INTERNAL for a damaged result, API_OUT_OF_MEMORY. The caller owns it.
 */
struct encoder *encoder_new(const struct format *format, const struct format_source *source,
                            const struct format_options *options, struct api_problem *problem);

/* The next bytes of the document, at most `size`: how many; 0 at its end; -1 when the source could
 * not be read (what was sent so far is then no document). */
ssize_t encoder_read(struct encoder *encoder, char *buffer, size_t size);

/* The length of the whole document, 0 when it is only known at its end. */
uint64_t encoder_length(const struct encoder *encoder);

/* For the header `Draped-Binning`: what the binning of `lcmsim` costs, as in
 * "bins=125; direction_deg=2.1; k1=0.03; ..."; "" for other formats. Lives as long as the encoder.
 */
const char *encoder_binning(const struct encoder *encoder);

/* NULL is allowed. */
void encoder_free(struct encoder *encoder);

#endif
