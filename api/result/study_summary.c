/* SPDX-License-Identifier: MIT */
#include "study_summary.h"

#include "api/json/text.h"
#include "api/json/value.h"
#include <limits.h>
#include <math.h>
#include <string.h>

static const struct {
    const char *key;
    size_t offset;
} counts[] = {{"variants", offsetof(struct api_study_summary, variants)},
              {"coarse", offsetof(struct api_study_summary, coarse)},
              {"failed", offsetof(struct api_study_summary, failed)},
              {"feasible", offsetof(struct api_study_summary, feasible)},
              {"pareto", offsetof(struct api_study_summary, pareto)}};
enum { COUNTS = sizeof counts / sizeof *counts };

void study_summary_write(struct api_text *text, const struct api_study_summary *summary,
                         double queue_ms) {
    api_text_raw(text, "{");
    for (int k = 0; k < COUNTS; k++)
        api_text_key_integer(
            text, counts[k].key,
            (int64_t) * (const size_t *)(const void *)((const char *)summary + counts[k].offset));
    api_text_key(text, "hardest_limit");
    if (summary->hardest >= 0)
        api_text_string(text, quantities[summary->hardest].name);
    else
        api_text_raw(text, "null");
    api_text_key(text, "verdict");
    verdict_write(text, &summary->verdict, true);
    api_text_key(text, "warnings");
    summary_write_warnings(text, &summary->warnings);
    api_text_key(text, "timing_ms");
    summary_write_timing(text, summary->solve_ms, queue_ms);
    api_text_key_string(text, "solver_version", summary->solver_version);
    api_text_raw(text, "}");
}

void study_summary_write_best(struct api_text *text, const struct api_study_summary *summary) {
    api_text_raw(text, "{");
    for (int k = 0; k < QUANTITY_COUNT; k++)
        if (summary->objective[k])
            api_text_key_number(text, quantities[k].name,
                                summary->best[k] >= 0 ? summary->best[k] : (double)NAN);
    api_text_raw(text, "}");
}

void study_summary_read(const struct json_value *json, struct api_study_summary *study) {
    static const struct value_range whole = {0, 0x1p53, false}, times = {0, 1e300, false};
    struct json_value summary = value_member(json, "summary"), best = value_member(json, "best");
    struct json_value hardest = value_member(&summary, "hardest_limit");
    struct json_value verdict = value_member(&summary, "verdict");
    struct json_value warnings = value_member(&summary, "warnings");
    struct json_value timing = value_member(&summary, "timing_ms");
    struct json_value solve = value_member(&timing, "solve");
    struct json_value version = value_member(&summary, "solver_version");
    const char *names[QUANTITY_COUNT], *text;
    for (int k = 0; k < COUNTS; k++) {
        struct json_value own = value_member(&summary, counts[k].key);
        double value = 0;
        value_number(&own, whole, &value);
        *(size_t *)(void *)((char *)study + counts[k].offset) = (size_t)value;
    }
    for (int k = 0; k < QUANTITY_COUNT; k++) {
        struct json_value own = value_member(&best, quantities[k].name);
        names[k] = quantities[k].name;
        study->objective[k] = value_given(&own);
        study->best[k] = -1;
        if (value_type(&own) == VALUE_NUMBER)
            value_integer(&own, 0, INT_MAX, &study->best[k]);
    }
    study->hardest = -1;
    if (value_type(&hardest) == VALUE_STRING)
        value_choice(&hardest, names, QUANTITY_COUNT, &study->hardest);
    verdict_read(&verdict, &study->verdict);
    summary_read_warnings(&warnings, &study->warnings);
    value_number(&solve, times, &study->solve_ms);
    if (value_string(&version, &text))
        strncpy(study->solver_version, text, API_VERSION_SIZE - 1);
}
