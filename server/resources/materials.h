/* SPDX-License-Identifier: MIT */
/* What handlers of jobs leave to materials. */
#ifndef SERVER_RESOURCES_MATERIALS_H
#define SERVER_RESOURCES_MATERIALS_H

#include "call.h"
#include "checking.h"
#include "server/store/store.h"

/* The material that the caller, or else who the caller may see, keeps under that name. */
enum store_answer materials_find(struct call *call, const char *name,
                                 struct store_item *item) STORE_MUST_USE;

/* Those of the names, a line each, that there are: the documents of CHECKER_MATERIALS, malloc'ed;
 * never empty. Cuts the names apart. NULL: the reply says why. */
char *materials_collect(struct call *call, char *names, size_t *length);

#endif
