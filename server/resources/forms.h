/* SPDX-License-Identifier: MIT */
/* The prepared form of the stored surface that a request names: looked for, and kept for the jobs
 * and checks that follow. */
#ifndef SERVER_RESOURCES_FORMS_H
#define SERVER_RESOURCES_FORMS_H

#include "call.h"
#include "server/work/document_pool.h"

struct forms_found {
    int file; /* sealed; -1: none */
    size_t length;
};

/* Closes it, if there is one. */
void forms_close(struct forms_found *form);

/* A form of the surface that the check found to be needed, as near to what the request drapes on as
 * there is one; where there is none the surface itself. STORE_EMPTY: it is not stored. `form` and
 * `surface` are empty before, and the caller's afterwards. */
enum store_answer forms_find(struct call *call, const struct api_check *check,
                             struct forms_found *form, struct store_item *surface) STORE_MUST_USE;

/* Of the check of a surface that is posted: the bytes of its form, malloc'ed, which are kept for
 * the checks that follow, too; NULL: there is none. */
char *forms_posted(struct call *call, struct check *check, size_t *length);

/* Of a check that has passed, with the form that it was given: keeps what it has made, or else what
 * it was given, for the job; and in the store where the surface had no sound one. */
void forms_keep(struct call *call, struct check *check, struct forms_found *given);

#endif
