/* SPDX-License-Identifier: MIT */
/* What the handlers of jobs need of materials and files. */
#ifndef SERVER_RESOURCES_ITEMS_H
#define SERVER_RESOURCES_ITEMS_H

#include "api/files/files.h"
#include "call.h"

/* The file of that media type; NULL: none, or no type. */
const struct file_format *items_file_of(const char *type);

/* Those of the names of materials, a line each, that there are: the documents of CHECKER_MATERIALS,
 * malloc'ed; never empty. Cuts the names apart. NULL: the reply says why. */
char *items_collect_materials(struct call *call, char *names, size_t *length);

#endif
