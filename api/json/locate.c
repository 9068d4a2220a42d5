/* SPDX-License-Identifier: MIT */
#include "locate.h"

#include "walk.h"
#include <stdio.h>

void api_locate(const char *bytes, size_t position, char pointer[API_POINTER_MAX]) {
    struct walk walk = {.at = bytes, .end = bytes + position};
    struct walk_span string;
    size_t length = 0;
    while (walk_next_string(&walk, &string))
        continue;
    size_t depth = walk.depth < WALK_LEVELS_MAX ? walk.depth : WALK_LEVELS_MAX;
    pointer[0] = '\0';
    for (size_t k = 0; k < depth && length < API_POINTER_MAX; k++) {
        const struct walk_level *level = &walk.level[k];
        size_t room = API_POINTER_MAX - length, key = (size_t)(level->key.to - level->key.from);
        length += (size_t)(level->object ? snprintf(pointer + length, room, "/%.*s",
                                                    (int)(key < room ? key : room),
                                                    level->key.from ? level->key.from : "")
                                         : snprintf(pointer + length, room, "/%zu", level->index));
    }
}
