/* SPDX-License-Identifier: MIT */
/* The names of materials in the text of a request, and the documents that take their place. */
#include "material.h"

#include "api/json/text.h"
#include "api/json/walk.h"
#include "members.h"
#include <string.h>

enum { WANTED_MAX = 256 };

/* The next string that is the member `material` of a member `fabric`. */
static bool next_material(struct walk *walk, struct walk_span *name) {
    while (walk_next_string(walk, name)) {
        const struct walk_level *fabric = walk_level(walk, 0), *outer = walk_level(walk, 1);
        if (fabric && fabric->object && fabric->in_value && fabric->key.from &&
            walk_span_is(fabric->key, "material") && outer && outer->object && outer->key.from &&
            walk_span_is(outer->key, "fabric"))
            return true;
    }
    return false;
}

bool api_material_mentioned(const char *request, size_t length) {
    static const char key[] = "\"material\"";
    return memmem(request, length, key, strlen(key)) != NULL;
}

const char *api_material_wanted(const char *request, size_t length, struct arena *arena) {
    struct walk walk = {.at = request, .end = request + length};
    struct api_text lines = api_text_growing(arena);
    struct walk_span name;
    for (int count = 0; count < WANTED_MAX && next_material(&walk, &name);) {
        size_t size = (size_t)(name.to - name.from);
        bool done = !material_is_name(name.from, size) || material_find(name.from, size);
        for (size_t at = 0; !done && at < lines.length;) {
            const char *line = lines.bytes + at;
            size_t own = (size_t)((const char *)memchr(line, '\n', lines.length - at) - line);
            done = own == size && memcmp(line, name.from, size) == 0;
            at += own + 1;
        }
        if (done)
            continue;
        api_text_bytes(&lines, name.from, size);
        api_text_raw(&lines, "\n");
        count++;
    }
    return api_text_finish(&lines);
}

/* The document of that name; empty when there is none. */
static struct walk_span document_of(struct walk_span name, const char *own, size_t own_length) {
    static const char head[] = "{\"name\":\"";
    const size_t before = strlen(head), size = (size_t)(name.to - name.from);
    const struct api_material *material = material_find(name.from, size);
    if (material)
        return (struct walk_span){material->json, material->json + material->length};
    for (const char *at = own, *end = own + own_length; at < end;) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        if ((size_t)(stop - at) > before + size && memcmp(at, head, before) == 0 &&
            memcmp(at + before, name.from, size) == 0 && at[before + size] == '"')
            return (struct walk_span){at, stop};
        at = stop + (stop < end);
    }
    return (struct walk_span){own, own};
}

const char *api_material_fill(const char *request, size_t length, const char *own,
                              size_t own_length, struct arena *arena, size_t *filled) {
    struct walk walk = {.at = request, .end = request + length};
    struct api_text text = api_text_growing(arena);
    const char *done = request;
    struct walk_span name;
    while (next_material(&walk, &name)) {
        struct walk_span document = document_of(name, own, own_length);
        if (document.from == document.to || walk.at <= name.to)
            continue;
        api_text_bytes(&text, done, (size_t)(name.from - 1 - done));
        api_text_bytes(&text, document.from, (size_t)(document.to - document.from));
        done = walk.at;
    }
    api_text_bytes(&text, done, (size_t)(request + length - done));
    *filled = text.length;
    return api_text_finish(&text);
}
