/* SPDX-License-Identifier: MIT */
/*
 * The prepared forms (`api/request/prepared_form.h`) that checks have made and stored surfaces
 * have, as sealed memory files: a check hands the job that follows it what it has made, and a
 * surface that is draped again is not made again. What was used longest ago goes first. A form is
 * found by its owner, so that none learns of another's or gets what another's document made, and by
 * a key: the digest of a request's text, or of what it drapes on (`api_digest_ground`).
 *
 * Every function may be called from any thread.
 */
#ifndef SERVER_WORK_FORM_CACHE_H
#define SERVER_WORK_FORM_CACHE_H

#include <stddef.h>

struct form_cache;

enum {
    FORM_CACHE_FILES = 64,      /* at the most */
    FORM_CACHE_BYTES = 64 << 20 /* likewise */
};

/* NULL without memory, which the others take for one that is always empty. */
struct form_cache *form_cache_new(void);
void form_cache_free(struct form_cache *cache);

/* Keeps the file, sealed and of that length, which stays the caller's. Not one that is longer than
 * all may be, nor one without a key. */
void form_cache_put(struct form_cache *cache, const char *owner, const char *key, int file,
                    size_t length);

/* A descriptor of the file, which the caller closes, and its length; -1: there is none. */
int form_cache_get(struct form_cache *cache, const char *owner, const char *key, size_t *length);

#endif
