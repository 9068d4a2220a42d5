/* SPDX-License-Identifier: MIT */
/* One variant of a study: what is draped, and the numbers that come of it. */
#ifndef API_STUDY_VARIANT_H
#define API_STUDY_VARIANT_H

#include "shape.h"
#include "solver/arena.h"

/* What is draped. */
struct study_variant {
    struct spread_place start;
    double angle_deg, pre_shear_deg;
    double coarseness;     /* its spacing over the drape's own */
    enum failure hopeless; /* it is not draped, for this reason; FAILURE_NONE: it is */
};

/* As the numbers of tasks have it. */
struct study_row {
    struct study_variant variant; /* as it was draped */
    int round;
    enum failure failure;
    double quantity[QUANTITY_COUNT]; /* those that are judged; -1: none */
    double most[DRAPE_DIVISIONS];    /* the largest shear of each of the bench's divisions; 0 of a
                                        failure */
};

enum { STUDY_ROW_NUMBERS = 11 + QUANTITY_COUNT };
void study_row_store(const struct study_row *row, double numbers[STUDY_ROW_NUMBERS]);
/* False for numbers that no row has. `most` is not among them. */
bool study_row_load(const double numbers[STUDY_ROW_NUMBERS], struct study_row *row);

/* What is the same for all variants. */
struct study_bench {
    const struct study_request *request;
    const struct study_shape *shape;
    struct study_k1 {
        double ratio;          /* between k1 of this shear and unsheared, at least 1 */
        int bin;               /* of the shear */
    } * k1;                    /* all bins, by rising ratio; NULL: not judged */
    const struct vec3 *middle; /* of the divisions of the part (`struct drape_statistics`) */
    size_t divisions;          /* 0: the rows say nothing of them */
};

/* Prepares a bench in `arena`. Errors: STATUS_OUT_OF_MEMORY. */
enum status study_bench_make(const struct study_request *request, const struct study_shape *shape,
                             struct arena *arena, struct study_bench *bench) STATUS_MUST_USE;

/* The drape of a variant as settings; what the study does not vary stays as in its drape. */
struct drape_settings study_variant_settings(const struct study_bench *bench,
                                             const struct study_variant *variant);

/* Drapes a variant in `arena`, which is then as before, and fills the row but for its round.
 * Returns STATUS_CANCELLED when the monitor (may be NULL) said so, else STATUS_OK: a drape that
 * cannot be done is a row with a failure. */
enum status study_variant_drape(const struct study_bench *bench,
                                const struct study_variant *variant,
                                const struct drape_monitor *monitor, struct arena *arena,
                                struct study_row *row) STATUS_MUST_USE;

#endif
