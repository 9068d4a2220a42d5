/* SPDX-License-Identifier: MIT */
#include "walk.h"

#include <string.h>

const char *walk_string_end(const char *at, const char *end) {
    while (at < end && *at != '"')
        at += *at == '\\' && at + 1 < end ? 2 : 1;
    return at;
}

bool walk_span_is(struct walk_span span, const char *text) {
    size_t length = strlen(text);
    return (size_t)(span.to - span.from) == length && memcmp(span.from, text, length) == 0;
}

const struct walk_level *walk_level(const struct walk *walk, size_t up) {
    bool known = walk->depth > up && walk->depth - up <= WALK_LEVELS_MAX;
    return known ? &walk->level[walk->depth - up - 1] : NULL;
}

bool walk_next_string(struct walk *walk, struct walk_span *string) {
    while (walk->at < walk->end) {
        bool known = walk->depth > 0 && walk->depth <= WALK_LEVELS_MAX;
        struct walk_level *level = known ? &walk->level[walk->depth - 1] : NULL;
        char c = *walk->at++;
        switch (c) {
        case '"':
            *string = (struct walk_span){walk->at, walk_string_end(walk->at, walk->end)};
            walk->at = string->to < walk->end ? string->to + 1 : walk->end;
            if (level && level->object && !level->in_value && string->to < walk->end)
                level->key = *string;
            return true;
        case '[':
        case '{':
            if (walk->depth < WALK_LEVELS_MAX)
                walk->level[walk->depth] = (struct walk_level){.object = c == '{'};
            walk->depth++;
            break;
        case ']':
        case '}':
            walk->depth -= walk->depth > 0;
            break;
        case ',':
        case ':':
            if (level) {
                level->in_value = c == ':';
                level->index += c == ',';
            }
            break;
        }
    }
    return false;
}
