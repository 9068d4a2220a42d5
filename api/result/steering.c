/* SPDX-License-Identifier: MIT */
#include "steering.h"

#include "api/json/text.h"
#include "api/json/value.h"
#include "api/request/normalise.h"

static const char *const names[2] = {"warp", "weft"};
static const struct value_range any = {-1e300, 1e300, false};

void steering_write(struct api_text *text, const char *key, const struct drape_steering *s) {
    if (!s->sought[0] && !s->sought[1])
        return;
    api_text_key_object(text, key);
    api_text_key_number(text, "energy_before", s->energy[0]);
    api_text_key_number(text, "energy_after", s->energy[1]);
    api_text_key(text, "fell");
    api_text_raw(text, s->fell ? "true" : "false");
    api_text_key_integer(text, "iterations", s->iterations);
    api_text_key_object(text, "generators");
    for (int k = 0; k < 2; k++)
        if (s->sought[k]) {
            api_text_key(text, names[k]);
            api_normalise_steered(text, &s->curvature[k], true);
        }
    api_text_raw(text, "}}");
}

static void read_curvature(const struct json_value *json, struct drape_curvature *curvature) {
    struct json_value points = value_member(json, "points"), values = value_member(json, "values");
    struct json_value length = value_member(json, "length");
    if (value_integer(&points, 1, DRAPE_CURVATURE_POINTS, &curvature->points) &&
        value_vector(&values, any, 2 * (size_t)curvature->points, curvature->value))
        value_vector(&length, any, 2, curvature->length);
}

void steering_read(const struct json_value *json, struct drape_steering *s) {
    struct json_value before = value_member(json, "energy_before");
    struct json_value after = value_member(json, "energy_after");
    struct json_value fell = value_member(json, "fell"), rounds = value_member(json, "iterations");
    struct json_value generators = value_member(json, "generators");
    *s = (struct drape_steering){0};
    if (!value_given(json))
        return;
    value_number(&before, any, &s->energy[0]);
    value_number(&after, any, &s->energy[1]);
    value_boolean(&fell, &s->fell);
    value_integer(&rounds, 0, 1 << 20, &s->iterations);
    for (int k = 0; k < 2; k++) {
        struct json_value own = value_member(&generators, names[k]);
        struct json_value steered = value_member(&own, "steered");
        s->sought[k] = value_given(&own);
        if (s->sought[k])
            read_curvature(&steered, &s->curvature[k]);
    }
}
