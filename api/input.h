/* SPDX-License-Identifier: MIT */
/* What one job is given. */
#ifndef API_INPUT_H
#define API_INPUT_H

#include <stddef.h>

struct prepared_form;

/* The documents of one job, not zero-terminated, owned by the caller. `surface` is the stored
 * surface the request names by id; length 0 when the request carries its own. `form` is the
 * prepared form of that surface or of the request (`request/prepared_form.h`), which is read in
 * their place where it is sound; length 0 without one. `opened` is one that the caller has opened
 * already, and is looked at before `form`; NULL: none. */
struct api_input {
    const char *request;
    size_t request_length;
    const char *surface;
    size_t surface_length;
    const void *form;
    size_t form_length;
    const struct prepared_form *opened;
};

#endif
