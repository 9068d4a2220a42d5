/* SPDX-License-Identifier: MIT */
/* The tasks of a drape, by the caller's threads or by its own alone. */
#ifndef SOLVER_TEAM_H
#define SOLVER_TEAM_H

#include "drape.h"

/* Has task(data, k) called for k = 0 .. count - 1: by the team, or one after the other if it is
 * NULL. */
static inline void team_run(const struct drape_team *team, int count,
                            void (*task)(void *data, int k), void *data) {
    if (team)
        team->run(team->context, count, task, data);
    for (int k = 0; !team && k < count; k++)
        task(data, k);
}

#endif
