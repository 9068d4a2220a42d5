/* SPDX-License-Identifier: MIT */
/*
 * A look at the bytes of a JSON document before they are parsed, so that a small hostile body
 * cannot become a large tree: one pass, no recursion, no memory. It counts what the parser would
 * have to make (values, a member of an object as eight) and how deep it would have to go; whether
 * it is JSON is the parser's business.
 */
#ifndef API_JSON_PRESCAN_H
#define API_JSON_PRESCAN_H

#include "api/limits.h"
#include "api/problem.h"
#include "solver/status.h"
#include <stddef.h>

/* API_OK, or API_TOO_LARGE with `problem` naming the limit that was passed and its value. */
enum api_problem_id api_prescan(const char *bytes, size_t length, const struct api_limits *limits,
                                struct api_problem *problem) STATUS_MUST_USE;

#endif
