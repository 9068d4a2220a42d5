/* SPDX-License-Identifier: MIT */
#include "reason.h"

const char *drape_reason_name(enum drape_reason reason) {
    static const char *const names[] = {
#define X(id, name) name,
        DRAPE_REASON_LIST(X)
#undef X
    };
    return names[reason];
}
