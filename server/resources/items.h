/* SPDX-License-Identifier: MIT */
/* What owners keep beside jobs, surfaces and materials, for the handlers of jobs. */
#ifndef SERVER_RESOURCES_ITEMS_H
#define SERVER_RESOURCES_ITEMS_H

#include "call.h"
#include "server/store/store.h"

/* The item of that kind that the caller keeps under that name, or, for callers who see that, others
 * do. STORE_EMPTY as well for a name that none can have. To be cleared in any case. */
enum store_answer items_find(struct call *call, enum store_item_kind kind, const char *name,
                             struct store_item *item) STORE_MUST_USE;

/* Those of the names of materials, a line each, that there are: the documents of CHECKER_MATERIALS,
 * malloc'ed; never empty. Cuts the names apart. NULL: the reply says why. */
char *items_collect_materials(struct call *call, char *names, size_t *length);

#endif
