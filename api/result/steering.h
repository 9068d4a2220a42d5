/* SPDX-License-Identifier: MIT */
/* What a summary says of generators that were sought. */
#ifndef API_RESULT_STEERING_H
#define API_RESULT_STEERING_H

#include "solver/result.h"

struct api_text;
struct json_value;

/* Writes it under the key, with generators as they can be posted; nothing where none was sought. */
void steering_write(struct api_text *text, const char *key, const struct drape_steering *steering);

/* Reads it; what was not given is of no generator. */
void steering_read(const struct json_value *json, struct drape_steering *steering);

#endif
