/* SPDX-License-Identifier: MIT */
#include "quantity.h"

const struct quantity quantities[QUANTITY_COUNT] = {
#define X(id, name, role, least, most) {name, QUANTITY_##role, least, most},
    QUANTITY_LIST(X)
#undef X
};

const char *const failure_names[FAILURE_COUNT] = {
#define X(id, name) name,
    FAILURE_LIST(X)
#undef X
};
