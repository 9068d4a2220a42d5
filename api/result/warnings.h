/* SPDX-License-Identifier: MIT */
/*
 * What a careful engineer would say aloud of a drape that worked: `warnings` of its summary. Each
 * has a code, a sentence with the numbers that it rests on, and mostly the place in the request
 * that would change it.
 */
#ifndef API_RESULT_WARNINGS_H
#define API_RESULT_WARNINGS_H

#include "api/request/prepared_part.h"
#include "summary.h"

/* The drape and what was draped. */
struct warnings_subject {
    const struct api_request *request;
    const struct drape_result *result;
    struct prepared_part *prepared;
    size_t components; /* of the mesh or shell: parts that are not connected; 1 for a surface */
    const struct shell_apart *apart; /* of faces; `face` by its number in the request */
};

/* Sets summary->warnings from the subject and the other members of `summary`. */
void warnings_make(const struct warnings_subject *subject, struct api_summary *summary);

/* A spacing of some hundred cells on an area; and a positive value rounded down to two digits, as
 * one is told. */
double warnings_fine_spacing(double area);
double warnings_two_digits(double value);

/* Adds one, as long as there is room. */
void warnings_add(struct api_warnings *warnings, const char *code, const char *pointer,
                  const char *detail, ...) __attribute__((format(printf, 4, 5)));

#endif
