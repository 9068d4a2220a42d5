/* SPDX-License-Identifier: MIT */
/* Where a result goes as it is made. */
#ifndef API_SINK_H
#define API_SINK_H

#include <stdbool.h>
#include <stddef.h>

/* Takes the result's bytes (the container of `columns.h`) in order; false stops the run. */
struct api_sink {
    bool (*write)(void *context, const void *bytes, size_t length);
    void *context;
    /* Takes the result's summary object, as JSON with no time of waiting, when its head is written;
     * false stops the run. NULL: not wanted. */
    bool (*summary)(void *context, const char *json);
};

#endif
