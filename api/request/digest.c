/* SPDX-License-Identifier: MIT */
#include "digest.h"

#include "normalise.h"
#include <sodium.h>
#include <string.h>

enum { ID_BYTES = API_ID_LENGTH / 2 };

bool api_digest_prepare(void) {
    return sodium_init() >= 0;
}

void api_digest_bytes(const void *bytes, size_t length, char id[API_ID_SIZE]) {
    unsigned char hash[ID_BYTES];
    crypto_generichash(hash, sizeof hash, bytes, length, NULL, 0);
    sodium_bin2hex(id, API_ID_SIZE, hash, sizeof hash);
}

void api_digest_pieces(const void *head, size_t head_length, const void *bytes, size_t length,
                       unsigned char digest[API_DIGEST_BYTES]) {
    crypto_generichash_state state;
    crypto_generichash_init(&state, NULL, 0, API_DIGEST_BYTES);
    crypto_generichash_update(&state, head, head_length);
    crypto_generichash_update(&state, bytes, length);
    crypto_generichash_final(&state, digest, API_DIGEST_BYTES);
}

_Static_assert(sizeof(crypto_hash_sha256_state) <= API_SHA256_STATE, "it fits");

void api_sha256_begin(struct api_sha256 *hash) {
    crypto_hash_sha256_init((void *)hash->state);
}

void api_sha256_add(struct api_sha256 *hash, const void *bytes, size_t length) {
    crypto_hash_sha256_update((void *)hash->state, bytes, length);
}

void api_sha256_end(struct api_sha256 *hash, char digits[API_SHA256_SIZE]) {
    unsigned char bytes[crypto_hash_sha256_BYTES];
    crypto_hash_sha256_final((void *)hash->state, bytes);
    sodium_bin2hex(digits, API_SHA256_SIZE, bytes, sizeof bytes);
}

bool api_digest_surface(const struct api_surface *surface, struct arena *arena,
                        char id[API_ID_SIZE]) {
    if (surface->id[0]) {
        memcpy(id, surface->id, API_ID_SIZE);
        return true;
    }
    struct arena_mark mark = arena_mark(arena);
    const char *definition = api_normalise_surface(surface, arena);
    if (definition)
        api_digest_bytes(definition, strlen(definition), id);
    arena_rewind(arena, mark);
    return definition != NULL;
}

bool api_digest_ground(const struct api_request *request, struct arena *arena,
                       char id[API_ID_SIZE]) {
    const struct api_surface *surface = &request->surface;
    struct api_surface named = {.kind = API_SURFACE_NAMED, .selection = surface->selection};
    memcpy(id, surface->id, API_ID_SIZE);
    if (surface->selection.kind == API_SELECT_ALL && request->offset == 0)
        return true;
    memcpy(named.id, surface->id, API_ID_SIZE);
    struct arena_mark mark = arena_mark(arena);
    struct api_text text = api_text_growing(arena);
    api_normalise_ground(&text, &named, NULL);
    api_text_number(&text, request->offset);
    const char *bytes = api_text_finish(&text);
    if (bytes)
        api_digest_bytes(bytes, strlen(bytes), id);
    arena_rewind(arena, mark);
    return bytes != NULL;
}

/* The request is written down with its surface by id, and the solver's version after the final
 * zero. */
bool api_digest_request(const struct api_request *request, struct arena *arena,
                        char id[API_ID_SIZE]) {
    struct api_request named = *request;
    named.unit_of_surface = false;
    if (!api_digest_surface(&request->surface, arena, named.surface.id))
        return false;
    struct arena_mark mark = arena_mark(arena);
    const char *text = api_normalise(&named, NULL, arena);
    if (text) {
        unsigned char hash[ID_BYTES];
        crypto_generichash_state state;
        crypto_generichash_init(&state, NULL, 0, sizeof hash);
        crypto_generichash_update(&state, (const void *)text, strlen(text) + 1);
        crypto_generichash_update(&state, (const void *)DRAPE_VERSION, strlen(DRAPE_VERSION));
        crypto_generichash_final(&state, hash, sizeof hash);
        sodium_bin2hex(id, API_ID_SIZE, hash, sizeof hash);
    }
    arena_rewind(arena, mark);
    return text != NULL;
}
