/* SPDX-License-Identifier: MIT */
#include "summary.h"

#include "api/json/text.h"
#include "api/json/value.h"
#include "steering.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define MEMBER(KIND, name, key, meaning)                                                           \
    {SUMMARY_##KIND, key, meaning, offsetof(struct api_summary, name)},

const struct summary_member summary_members[] = {SUMMARY_LIST(MEMBER)};
const size_t summary_member_count = sizeof summary_members / sizeof *summary_members;

const char *const outcome_names[2] = {[DRAPE_COMPLETE] = "complete", [DRAPE_PARTIAL] = "partial"};

static const struct value_range any = {-1e300, 1e300, false};
static const struct value_range counts = {0, 0x1p53, false};

bool summary_finite(const struct api_summary *summary) {
    bool finite = true;
    for (size_t k = 0; k < summary_member_count; k++) {
        const struct summary_member *member = &summary_members[k];
        const double *value = (const void *)((const char *)summary + member->offset);
        int count = member->kind == SUMMARY_PLACE  ? SUMMARY_PLACE_SIZE
                    : member->kind == SUMMARY_AXES ? SUMMARY_AXES_SIZE
                    : member->kind == SUMMARY_NUMBER || member->kind == SUMMARY_POSITIVE ||
                            member->kind == SUMMARY_TIMING
                        ? 1
                        : 0;
        for (int i = 0; i < count; i++)
            finite &= isfinite(value[i]) != 0;
    }
    return finite;
}

/* ---- writing ---- */

static const char *const axes_names[2] = {"zero", "side"};
static const char *const place_names[SUMMARY_PLACE_SIZE] = {"p", "q", "x", "y", "z"};

void summary_write_warnings(struct api_text *text, const struct api_warnings *warnings) {
    api_text_raw(text, "[");
    for (size_t k = 0; k < warnings->count; k++) {
        const struct api_warning *warning = &warnings->list[k];
        api_text_raw(text, k ? ",{" : "{");
        api_text_key_string(text, "code", warning->code);
        api_text_key_string(text, "detail", warning->detail);
        if (*warning->pointer)
            api_text_key_string(text, "pointer", warning->pointer);
        api_text_raw(text, "}");
    }
    api_text_raw(text, "]");
}

void summary_write_timing(struct api_text *text, double solve_ms, double queue_ms) {
    api_text_raw(text, "{");
    if (queue_ms >= 0)
        api_text_key_number(text, "queue", queue_ms);
    api_text_key_number(text, "solve", solve_ms);
    api_text_raw(text, "}");
}

void summary_write(struct api_text *text, const struct api_summary *summary, double queue_ms) {
    api_text_raw(text, "{");
    for (size_t m = 0; m < summary_member_count; m++) {
        const struct summary_member *member = &summary_members[m];
        const void *value = (const char *)summary + member->offset;
        const double *number = value;
        if (member->kind == SUMMARY_STEERING) {
            steering_write(text, member->key, value);
            continue;
        }
        api_text_key(text, member->key);
        switch (member->kind) {
        case SUMMARY_OUTCOME:
            api_text_string(text, outcome_names[*(const enum drape_outcome *)value]);
            break;
        case SUMMARY_VERDICT:
            verdict_write(text, value, false);
            break;
        case SUMMARY_COUNT:
            api_text_integer(text, (int64_t) * (const size_t *)value);
            break;
        case SUMMARY_NUMBER:
            api_text_number(text, *number);
            break;
        case SUMMARY_POSITIVE:
            api_text_number(text, *number < 0 ? (double)NAN : *number);
            break;
        case SUMMARY_PLACE:
            api_text_raw(text, "{");
            for (int k = 0; k < SUMMARY_PLACE_SIZE; k++)
                api_text_key_number(text, place_names[k], number[k]);
            api_text_raw(text, "}");
            break;
        case SUMMARY_AXES:
            api_text_raw(text, "{");
            for (int k = 0; k < 2; k++)
                api_text_key_numbers(text, axes_names[k], number + (size_t)k * 3, 3);
            api_text_raw(text, "}");
            break;
        case SUMMARY_STEERING:
            break;
        case SUMMARY_REASONS:
            api_text_raw(text, "{");
            for (int k = 0; k < DRAPE_REASON_COUNT; k++)
                api_text_key_integer(text, drape_reason_name((enum drape_reason)k),
                                     (int64_t)((const size_t *)value)[k]);
            api_text_raw(text, "}");
            break;
        case SUMMARY_WARNINGS:
            summary_write_warnings(text, value);
            break;
        case SUMMARY_TIMING:
            summary_write_timing(text, *number, queue_ms);
            break;
        case SUMMARY_VERSION:
            api_text_string(text, value);
            break;
        }
    }
    api_text_raw(text, "}");
}

/* ---- reading ---- */

static size_t read_count(const struct json_value *json) {
    double value = 0;
    value_number(json, counts, &value);
    return (size_t)value;
}

static void read_any_number(const struct json_value *json, double *value) {
    *value = 0;
    value_number(json, any, value);
}

static void read_text(const struct json_value *object, const char *key, char *to, size_t size) {
    struct json_value json = value_member(object, key);
    const char *text;
    if (value_given(&json) && value_string(&json, &text))
        snprintf(to, size, "%s", text);
}

void summary_read_warnings(const struct json_value *json, struct api_warnings *warnings) {
    size_t count = value_length(json);
    warnings->count = count < API_WARNINGS_MAX ? count : API_WARNINGS_MAX;
    for (size_t k = 0; k < warnings->count; k++) {
        struct json_value own = value_element(json, k);
        struct api_warning *warning = &warnings->list[k];
        read_text(&own, "code", warning->code, sizeof warning->code);
        read_text(&own, "detail", warning->detail, sizeof warning->detail);
        read_text(&own, "pointer", warning->pointer, sizeof warning->pointer);
    }
}

void summary_read(const struct json_value *json, struct api_summary *summary) {
    for (size_t m = 0; m < summary_member_count; m++) {
        const struct summary_member *member = &summary_members[m];
        struct json_value own = value_member(json, member->key), part;
        void *value = (char *)summary + member->offset;
        int outcome = DRAPE_COMPLETE;
        const char *text;
        switch (member->kind) {
        case SUMMARY_OUTCOME:
            value_choice(&own, outcome_names, 2, &outcome);
            *(enum drape_outcome *)value = (enum drape_outcome)outcome;
            break;
        case SUMMARY_VERDICT:
            verdict_read(&own, value);
            break;
        case SUMMARY_COUNT:
            *(size_t *)value = read_count(&own);
            break;
        case SUMMARY_NUMBER:
            read_any_number(&own, value);
            break;
        case SUMMARY_POSITIVE:
            *(double *)value = -1;
            if (value_type(&own) == VALUE_NUMBER)
                value_number(&own, any, value);
            break;
        case SUMMARY_PLACE:
            for (int k = 0; k < SUMMARY_PLACE_SIZE; k++) {
                part = value_member(&own, place_names[k]);
                read_any_number(&part, (double *)value + k);
            }
            break;
        case SUMMARY_AXES:
            for (int k = 0; k < 2; k++) {
                part = value_member(&own, axes_names[k]);
                value_vector(&part, any, 3, (double *)value + (size_t)k * 3);
            }
            break;
        case SUMMARY_STEERING:
            steering_read(&own, value);
            break;
        case SUMMARY_REASONS:
            for (int k = 0; k < DRAPE_REASON_COUNT; k++) {
                part = value_member(&own, drape_reason_name((enum drape_reason)k));
                ((size_t *)value)[k] = read_count(&part);
            }
            break;
        case SUMMARY_WARNINGS:
            summary_read_warnings(&own, value);
            break;
        case SUMMARY_TIMING:
            part = value_member(&own, "solve");
            read_any_number(&part, value);
            break;
        case SUMMARY_VERSION:
            if (value_string(&own, &text))
                strncpy(value, text, API_VERSION_SIZE - 1);
            break;
        }
    }
}

/* ---- a stored text ---- */

/* Where the value of a member of the object at `at`, written without spaces, begins; NULL when
 * there is none. */
static const char *find_text_member(const char *at, const char *key) {
    size_t length = strlen(key);
    for (int depth = 0; at && *at; at++) {
        if (*at == '"') {
            const char *name = ++at;
            while (*at && *at != '"')
                at += *at == '\\' && at[1] ? 2 : 1;
            if (!*at)
                return NULL;
            if (depth == 1 && at[1] == ':' && (size_t)(at - name) == length &&
                memcmp(name, key, length) == 0)
                return at + 2;
        }
        depth += (*at == '{' || *at == '[') - (*at == '}' || *at == ']');
        if (depth <= 0)
            return NULL;
    }
    return NULL;
}

void api_summary_write_stored(struct api_text *text, const char *stored, double queue_ms) {
    const char *rest = find_text_member(find_text_member(stored, "timing_ms"), "queue");
    if (rest) {
        api_text_bytes(text, stored, (size_t)(rest - stored));
        api_text_number(text, queue_ms);
        rest += strcspn(rest, ",}");
    }
    api_text_raw(text, rest ? rest : stored);
}
