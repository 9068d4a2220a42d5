/* SPDX-License-Identifier: MIT */
/*
 * From a byte of a JSON document to the JSON pointer of the value there, for what the parser finds
 * wrong with a value before there is a tree to point into.
 */
#ifndef API_JSON_LOCATE_H
#define API_JSON_LOCATE_H

#include "api/problem.h"
#include <stddef.h>

/* Writes the pointer of the value that the byte before `position` belongs to. The bytes up to there
 * must be the beginning of a JSON document; keys are taken as they are spelled. Nesting beyond 64
 * levels is cut off. */
void api_locate(const char *bytes, size_t position, char pointer[API_POINTER_MAX]);

#endif
