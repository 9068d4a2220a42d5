/* SPDX-License-Identifier: MIT */
#include "id.h"
#include <sodium.h>
#include <string.h>

enum { ID_BYTES = (ID_SIZE - 1) / 2 };

bool id_init(void) {
    return sodium_init() >= 0;
}

void id_make(char id[ID_SIZE]) {
    unsigned char bytes[ID_BYTES];
    randombytes_buf(bytes, sizeof bytes);
    sodium_bin2hex(id, ID_SIZE, bytes, sizeof bytes);
}

uint32_t id_hash(const char *name) {
    uint32_t hash = 2166136261u; /* FNV-1a */
    for (; *name; name++)
        hash = (hash ^ (unsigned char)*name) * 16777619u;
    return hash;
}

bool id_valid(const char *text) {
    return strlen(text) == ID_SIZE - 1 && strspn(text, "0123456789abcdef") == ID_SIZE - 1;
}
