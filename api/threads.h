/* SPDX-License-Identifier: MIT */
/* The threads that one drape may use: the solver asks for them, this makes them. */
#ifndef API_THREADS_H
#define API_THREADS_H

#include "solver/drape.h"

/* A team of `threads` threads, the calling one among them; they live for the time of one `run`. One
 * that cannot be had is made up for by the others. */
struct api_team {
    struct drape_team team; /* for drape_settings; valid as long as this is not moved */
    int threads;
};

/* For 1 thread and less the solver should get no team: returns NULL, else &team->team. */
const struct drape_team *api_team_make(struct api_team *team, int threads);

#endif
