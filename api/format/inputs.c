/* SPDX-License-Identifier: MIT */
#include "inputs.h"

#include <stdio.h>
#include <string.h>

enum { SHOWN_MAX = 6 }; /* numbers of an array */

struct inputs inputs_of(const char *text) {
    return (struct inputs){.at = text};
}

/* Behind the string that begins at a quote. */
static const char *pass_string(const char *at) {
    for (at++; *at && *at != '"'; at++)
        at += at[0] == '\\' && at[1];
    return *at ? at + 1 : at;
}

/* Up to the next member of an object: enters and leaves these. */
static bool go_to_member(struct inputs *inputs) {
    for (; *inputs->at && *inputs->at != '"'; inputs->at++) {
        if (*inputs->at == '{' && inputs->depth < INPUTS_DEPTH)
            inputs->length[inputs->depth++] = strlen(inputs->name);
        else if (*inputs->at == '}' && inputs->depth > 0)
            inputs->depth--;
        else if (*inputs->at != ',')
            return false;
        inputs->name[inputs->depth ? inputs->length[inputs->depth - 1] : 0] = '\0';
    }
    return inputs->depth > 0 && *inputs->at;
}

bool inputs_next(struct inputs *inputs, struct inputs_row *row) {
    if (inputs->depth)
        inputs->name[inputs->length[inputs->depth - 1]] = '\0';
    while (go_to_member(inputs)) { /* its key onto the name; no more when there is no room for it */
        const char *end = pass_string(inputs->at);
        size_t used = strlen(inputs->name), length = (size_t)(end - inputs->at) - 2;
        if (*inputs->at != '"' || *end != ':' || used + length + 2 > sizeof inputs->name)
            return false;
        snprintf(inputs->name + used, sizeof inputs->name - used, "%s%.*s", used ? "." : "",
                 (int)length, inputs->at + 1);
        inputs->at = end + 1;
        if (*inputs->at == '{')
            continue;
        row->name = inputs->name;
        row->value = inputs->at;
        /* Behind the value; of an array its elements, 0 if it is short and flat. */
        int depth = 0;
        bool deep = false;
        const char *at = inputs->at;
        row->count = *at == '[' && at[1] != ']';
        for (; *at && (depth > 0 || (*at != ',' && *at != '}')); at++) {
            if (*at == '"') {
                at = pass_string(at) - 1;
            } else if (*at == '[' || *at == '{') {
                deep = deep || depth > 0;
                depth++;
            } else if (*at == ']' || *at == '}') {
                depth--;
            } else if (*at == ',') {
                row->count += depth == 1;
            }
        }
        if (!deep && row->count <= SHOWN_MAX)
            row->count = 0;
        inputs->at = at;
        row->length = (size_t)(at - row->value);
        return true;
    }
    return false;
}
