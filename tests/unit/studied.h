/* SPDX-License-Identifier: MIT */
/* Studies that have been made of small parts, read back: for the tests of studies. */
#ifndef TESTS_UNIT_STUDIED_H
#define TESTS_UNIT_STUDIED_H

#include "api/study/study.h"
#include "support.h"

struct studied {
    struct bytes text, container;
    struct api_columns columns;
    size_t rows;
};

/* A study of a drape, with `rest` behind it; as the input of the functions of studies. */
struct bytes studied_text(const char *drape, const char *rest);
struct api_input studied_input(const struct bytes *text);

/* Makes it, on some threads; and one that has to succeed, on two. */
enum api_problem_id studied_run(const struct bytes *text, int threads, struct bytes *container,
                                struct api_problem *problem);
struct studied studied_make(const char *drape, const char *rest);

/* Its table has the same bits on one thread and on many. */
void studied_check_threads(const char *drape, const char *rest);
void studied_free(struct studied *f);

/* A number of a variant, that of the best by it, which there has to be, and a variant's drape
 * request. */
double studied_value(struct studied *f, const char *name, size_t row);
double studied_best(struct studied *f, enum quantity_id id);
struct bytes studied_request(struct studied *f, size_t row);

/* A variant has the numbers of its drape, to the last bit. */
void studied_check_bits(struct studied *f, size_t row);

/* z = (x^2 - y^2) / 2 over [-2, 2]^2; z = x y over [0, 1]^2 as triangles. */
struct bytes studied_saddle(void);
struct bytes studied_mesh(void);

/* A roof of two plane faces that meet along x = 0, the second with its normal turned. */
extern const char studied_roof[];

/* z = (x^2 + y^2) / 2 over [-1, 1]^2. */
extern const char studied_bowl[];

#endif
