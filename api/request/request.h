/* SPDX-License-Identifier: MIT */
/*
 * A drape request as it was understood: every key of the document decoded, checked and with its
 * default filled in. The arrays it points to lie in the arena it was decoded with.
 */
#ifndef API_REQUEST_REQUEST_H
#define API_REQUEST_REQUEST_H

#include "solver/drape.h"
#include "solver/lamina.h"
#include "solver/surface/nurbs.h"
#include "solver/surface/trim.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    API_ID_LENGTH = 32,             /* lower-case hex digits of a content id: 128 bits */
    API_ID_SIZE = API_ID_LENGTH + 1 /* with its terminating zero */
};

struct api_mesh {
    const struct vec3 *vertices;
    size_t vertex_count;
    const int32_t (*triangles)[3]; /* indices into `vertices`, from 0 */
    size_t triangle_count;
};

enum api_surface_kind {
    API_SURFACE_NURBS,
    API_SURFACE_MESH,
    API_SURFACE_SHELL,
    API_SURFACE_NAMED /* by its id alone: the definition was not among the input */
};

struct api_unit {
    const char *name; /* as in `length_unit` */
    double metres;
};

/* A part of the faces of a stored shell, by their numbers there. */
enum api_selection_kind {
    API_SELECT_ALL,
    API_SELECT_LIST, /* `faces` */
    API_SELECT_GROWN /* `grow_from` and all reached from it across edges that fold by no more than
                        `up_to_deg` */
};

enum api_seed { API_SEED_FACE, API_SEED_ELEMENT, API_SEED_POINT };

struct api_selection {
    enum api_selection_kind kind;
    const int *faces;
    size_t count;
    enum api_seed
        seed; /* the face or, of a mesh, the triangle `grow_from`, or that nearest `point` */
    int grow_from;
    struct vec3 point;
    double up_to_deg; /* 0..180 */
};

struct prepared_form;

struct api_surface {
    enum api_surface_kind kind;
    char id[API_ID_SIZE]; /* the id the request gave; "" when it carries the definition */
    struct nurbs nurbs;   /* API_SURFACE_NURBS; weights NULL when all are 1 */
    const struct trim_loop *trims;
    size_t trim_count;
    struct api_mesh mesh;            /* API_SURFACE_MESH */
    const struct api_surface *faces; /* API_SURFACE_SHELL: each API_SURFACE_NURBS */
    size_t face_count;
    double tolerance; /* within which edges of faces are joined; 0: the solver's default */
    struct api_selection selection;
    const char *face_name, *face_kind, *face_colour; /* of a face; NULL: not given */
    const struct api_unit *length_unit;              /* that a file is in; NULL: not given */
    const char *const *notes;                        /* what was noted when it was imported */
    size_t note_count;
    const struct prepared_form *form; /* of it, where it has been made ready before; or NULL */
};

enum { API_UNIT_COUNT = 6, API_UP_TO_DEG = 20 /* the default of `up_to_deg` */ };
extern const struct api_unit api_units[API_UNIT_COUNT]; /* the default first */

/* Vf = a p^b under a pressure of p Pa; a is 0 without one. */
struct api_compaction {
    double a, b;
};

/* How severe a shear is, 0..1. The angles rise, -90..90, and the severity does with the absolute
 * angle. */
struct api_limit_curve {
    size_t rows; /* 0: not given, else 2 or more */
    const double *shear_deg, *severity;
};

struct api_fabric {
    double thickness;             /* of one ply before shear; 0: not given */
    double fiber_volume_fraction; /* before shear, 0..1; 0: not given */
    double locking_angle_deg[2]; /* of positive and of negative shear, 0..90; negative: not given */
    struct api_limit_curve limit;
    int plies;
    double areal_weight; /* of one ply, kg/m^2, as the material says; 0: not known. Nothing is
                            solved  with it */
    double price;        /* of a m^2, in any currency, likewise */
    struct api_compaction compaction; /* as the material says, for laminates */
    double balance;       /* the share of warp in the yarns, 0..1; 0: not given. For solvers of
                             structures, as the next */
    struct lamina lamina; /* a unidirectional layer of its yarns with their resin, Pa; e1 is 0: not
                             given */
    const char *material; /* whose thickness it is, in the request's unit, as JSON: a name of the
                             library in quotes, or a document; NULL: its own */
};

struct api_cavity {
    bool rigid;    /* else flexible: thickness follows shear */
    double height; /* of a rigid cavity */
};

enum api_permeability_model {
    API_PERMEABILITY_KOZENY_CARMAN,
    API_PERMEABILITY_GEBART,
    API_PERMEABILITY_TABLE,
    API_PERMEABILITY_COUNT,
    API_PERMEABILITY_NONE
};

enum api_packing { API_PACKING_QUADRATIC, API_PACKING_HEXAGONAL, API_PACKING_COUNT };

struct api_permeability {
    enum api_permeability_model model;
    /* Kozeny-Carman: of the unsheared fabric, m^2, along warp, weft and through it */
    double k1, k2, k3;
    double at_fiber_volume_fraction;
    /* Gebart */
    double fiber_radius; /* m */
    enum api_packing packing;
    /* Table against the absolute shear angle: columns of `rows` values; over the fibre volume
     * fraction as well, of `rows` times `fractions`, the fraction running fastest */
    size_t rows, fractions;        /* fractions: 0 without that axis, else 2 or more */
    const double *table_fractions; /* increasing, within 0..1 */
    const double *shear_deg;       /* increasing, 0..90 */
    const double *table_k1, *table_k2, *table_k3; /* m^2 */
    const double *angle_deg;                      /* of k1 from the acute bisector; NULL: all 0 */
};

/* Cuts of a drape at the most, points of the path of one, and characters of its name. */
enum { API_CUTS_MAX = 64, API_CUT_POINTS_MAX = 1000, API_CUT_NAME_MAX = 40 };

struct api_request {
    struct vec3 rosette_origin; /* where the rosette of settings.zero is drawn */
    struct api_surface surface;
    const struct api_unit *length_unit;
    bool unit_of_surface; /* it is what the stored surface says, which was not among the input */
    struct api_fabric fabric;
    struct drape_settings settings; /* max_nodes comes from the limits */
    double offset; /* the surface is moved by so much along its normal (`solver/shell/offset.h`);
                      that of a shell along its first face's */
    bool start_on_face; /* the start's u and v are those of face settings.start_face */
    struct api_cavity cavity;
    struct api_permeability permeability;
    const char (*cut_names)[API_CUT_NAME_MAX + 1]; /* of the settings' cuts; NULL without them */
    const double *cut_allowances; /* of cloth beyond both lips in patterns, for each of them */
};

/* The names that the document uses, in the order of the enumerations. */
extern const char *const api_yarn_path_names[DRAPE_PATH_RELAXATION + 1];
extern const char *const api_permeability_names[API_PERMEABILITY_COUNT];
extern const char *const api_packing_names[API_PACKING_COUNT];

#endif
