/* SPDX-License-Identifier: MIT */
/* The threads that one drape may use: the solver takes them from here, because it starts none. */
#ifndef API_THREADS_H
#define API_THREADS_H

#include "solver/drape.h"

/* `count` threads, the calling one among them; they live for the time of one `run`. Tasks of one
 * that cannot be started are done by the others. */
struct api_threads {
    struct drape_team team; /* for drape_settings; valid as long as this is not moved */
    int count;
};

/* Returns &threads->team; NULL for a count of 1 and less, because a drape on the calling thread
 * alone takes no team. */
const struct drape_team *api_threads_make(struct api_threads *threads, int count);

#endif
