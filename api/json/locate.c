/* SPDX-License-Identifier: MIT */
#include "locate.h"

#include <stdbool.h>
#include <stdio.h>

enum { LEVELS_MAX = 64 };

/* An open array or object, and the member of it that was reached. */
struct level {
    bool object, in_value; /* of an object: behind the colon */
    size_t index;          /* of an array */
    const char *key;       /* of an object, as spelled, without its quotes */
    size_t key_length;
};

struct path {
    struct level level[LEVELS_MAX];
    size_t depth;
};

static void open_level(struct path *path, bool object) {
    if (path->depth < LEVELS_MAX)
        path->level[path->depth] = (struct level){.object = object};
    path->depth++;
}

static struct level *innermost(struct path *path) {
    bool known = path->depth > 0 && path->depth <= LEVELS_MAX;
    return known ? &path->level[path->depth - 1] : NULL;
}

/* Takes the string opened at `start`, as the key if it is one; returns the index of its last
 * byte. */
static size_t take_string(struct path *path, const char *bytes, size_t start, size_t position) {
    size_t end = start + 1;
    while (end < position && bytes[end] != '"')
        end += bytes[end] == '\\' ? 2 : 1;
    struct level *level = innermost(path);
    if (level && level->object && !level->in_value && end < position) {
        level->key = bytes + start + 1;
        level->key_length = end - start - 1;
    }
    return end;
}

static void take_separator(struct path *path, char separator) {
    struct level *level = innermost(path);
    if (!level)
        return;
    level->in_value = separator == ':';
    level->index += separator == ',';
}

static void write_pointer(const struct path *path, char *pointer) {
    size_t length = 0, depth = path->depth < LEVELS_MAX ? path->depth : LEVELS_MAX;
    pointer[0] = '\0';
    for (size_t k = 0; k < depth && length < API_POINTER_MAX; k++) {
        const struct level *level = &path->level[k];
        size_t room = API_POINTER_MAX - length;
        int key_length = level->key_length < room ? (int)level->key_length : (int)room;
        length += (size_t)(level->object ? snprintf(pointer + length, room, "/%.*s", key_length,
                                                    level->key ? level->key : "")
                                         : snprintf(pointer + length, room, "/%zu", level->index));
    }
}

void api_locate(const char *bytes, size_t position, char pointer[API_POINTER_MAX]) {
    struct path path;
    path.depth = 0;
    for (size_t i = 0; i < position; i++) {
        switch (bytes[i]) {
        case '"':
            i = take_string(&path, bytes, i, position);
            break;
        case '[':
        case '{':
            open_level(&path, bytes[i] == '{');
            break;
        case ']':
        case '}':
            path.depth -= path.depth > 0;
            break;
        case ',':
        case ':':
            take_separator(&path, bytes[i]);
            break;
        }
    }
    write_pointer(&path, pointer);
}
