/* SPDX-License-Identifier: MIT */
#include "problem.h"

#include "api/json/text.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    const char *slug, *title;
    int status;
} problems[API_PROBLEM_COUNT] = {[API_OK] = {"ok", "Nothing is wrong", 200},
#define X(id, slug, status, title) [API_##id] = {slug, title, status},
                                 API_PROBLEM_LIST(X)
#undef X
};

const char *api_problem_slug(enum api_problem_id id) {
    return problems[id].slug;
}

const char *api_problem_title(enum api_problem_id id) {
    return problems[id].title;
}

int api_problem_status(enum api_problem_id id) {
    return problems[id].status;
}

enum api_problem_id api_problem_from_slug(const char *slug) {
    for (int id = API_OK + 1; id < API_PROBLEM_COUNT; id++)
        if (strcmp(slug, problems[id].slug) == 0)
            return (enum api_problem_id)id;
    return API_INTERNAL;
}

/* Replaces what is not UTF-8, also a sequence that was cut at the end. */
static void make_utf8(char *string) {
    for (size_t left = strlen(string), length; left > 0; left -= length, string += length) {
        length = api_text_character(string, left);
        if (length == 0)
            *string = '?';
        length += length == 0;
    }
}

__attribute__((format(printf, 3, 0))) static void
set_error(struct api_problem_error *error, const char *pointer, const char *format, va_list list) {
    snprintf(error->pointer, sizeof error->pointer, "%s", pointer);
    vsnprintf(error->detail, sizeof error->detail, format, list);
    make_utf8(error->pointer);
    make_utf8(error->detail);
}

/* `pointer` NULL: the problem has none, and no more errors. */
__attribute__((format(printf, 4, 0))) static void set_problem(struct api_problem *problem,
                                                              enum api_problem_id id,
                                                              const char *pointer,
                                                              const char *detail, va_list list) {
    if (problem->id == API_OK) {
        problem->id = id;
        problem->has_pointer = pointer != NULL;
        problem->count = 1;
        set_error(&problem->error[0], pointer ? pointer : "", detail, list);
    }
}

enum api_problem_id api_problem_set(struct api_problem *problem, enum api_problem_id id,
                                    const char *detail, ...) {
    va_list list;
    va_start(list, detail);
    set_problem(problem, id, NULL, detail, list);
    va_end(list);
    return problem->id;
}

enum api_problem_id api_problem_set_at(struct api_problem *problem, enum api_problem_id id,
                                       const char *pointer, const char *detail, ...) {
    va_list list;
    va_start(list, detail);
    set_problem(problem, id, pointer, detail, list);
    va_end(list);
    return problem->id;
}

enum api_problem_id api_problem_add(struct api_problem *problem, const char *pointer,
                                    const char *detail, ...) {
    va_list list;
    va_start(list, detail);
    if (problem->id == API_OK)
        set_problem(problem, API_INVALID_REQUEST, pointer, detail, list);
    else if (problem->has_pointer && problem->count < API_ERRORS_MAX)
        set_error(&problem->error[problem->count++], pointer, detail, list);
    va_end(list);
    return problem->id;
}

enum api_problem_id api_problem_no_memory(struct api_problem *problem, const char *what) {
    return api_problem_set(problem, API_OUT_OF_MEMORY, "not enough memory for %s", what);
}

char *api_problem_json(const struct api_problem *problem, const char *request_id) {
    /* Every byte of an error may need six in JSON; the first error is written twice. */
    size_t capacity = 6 * (API_ERRORS_MAX + 1) * sizeof(struct api_problem_error) + 1024 +
                      (request_id ? 6 * strlen(request_id) : 0);
    char *buffer = malloc(capacity);
    if (!buffer)
        return NULL;
    struct api_text text = api_text_over(buffer, capacity);
    api_text_raw(&text, "{\"type\":\"/problems/");
    api_text_raw(&text, api_problem_slug(problem->id));
    api_text_raw(&text, "\"");
    api_text_key_string(&text, "title", api_problem_title(problem->id));
    api_text_key_integer(&text, "status", api_problem_status(problem->id));
    api_text_key_string(&text, "detail", problem->error[0].detail);
    if (problem->has_pointer) {
        api_text_key_string(&text, "pointer", problem->error[0].pointer);
        api_text_key(&text, "errors");
        api_text_raw(&text, "[");
        for (size_t i = 0; i < problem->count; i++) {
            api_text_raw(&text, i ? ",{" : "{");
            api_text_key_string(&text, "pointer", problem->error[i].pointer);
            api_text_key_string(&text, "detail", problem->error[i].detail);
            api_text_raw(&text, "}");
        }
        api_text_raw(&text, "]");
    }
    if (request_id)
        api_text_key_string(&text, "request_id", request_id);
    api_text_raw(&text, "}");
    if (api_text_finish(&text))
        return buffer;
    free(buffer);
    return NULL;
}
