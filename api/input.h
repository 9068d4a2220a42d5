/* SPDX-License-Identifier: MIT */
/* What one job is given. */
#ifndef API_INPUT_H
#define API_INPUT_H

#include <stddef.h>

/* The documents of one job, not zero-terminated, owned by the caller. `surface` is the stored
 * surface the request names by id; length 0 when the request carries its own. */
struct api_input {
    const char *request;
    size_t request_length;
    const char *surface;
    size_t surface_length;
};

#endif
