/* SPDX-License-Identifier: MIT */
/* The prepared forms that a worker process is given: mapped for one job, and of stored surfaces the
 * last ones opened, for the jobs that follow. */
#ifndef SERVER_WORK_FORMS_H
#define SERVER_WORK_FORMS_H

#include "api/request/prepared_form.h"
#include <stdbool.h>

enum {
    FORMS_KEPT = 8,             /* opened, at the most */
    FORMS_KEPT_BYTES = 64 << 20 /* likewise, of memory */
};

struct forms_mapped {
    const void *bytes; /* NULL: none */
    size_t length;
};

/* Maps the file, which is closed; with a length of 0 none. False when it cannot be mapped. */
bool forms_map(int file, size_t length, struct forms_mapped *form);
void forms_unmap(struct forms_mapped *form);

/* The form, opened now or before; lives until a later one takes its place. NULL where it is not
 * sound, or too long to be kept, or without memory. */
const struct prepared_form *forms_open(const struct forms_mapped *form);

#endif
