/* SPDX-License-Identifier: MIT */
#include "backend.h"
#include "recovery.h"
#include "server/log.h"
#include <pthread.h>
#include <string.h>

enum { STEPS_A_SWEEP = 100 }; /* of each kind: then `more` is set */

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER; /* of `store->clocks` */

struct clock_check store_clocks(const struct store *store) {
    pthread_mutex_lock(&lock);
    const struct clock_check clocks = store->clocks;
    pthread_mutex_unlock(&lock);
    return clocks;
}

/* What is due is found by reading, so that an idle store is not written to. A step makes work for
 * those after it: claims that ended leave results half written, what expires leaves results to
 * clear, what is cleared leaves free pages. A clock that is wrong for a while must not delete
 * anything for good: what is old has to be old by a later look as well. Where leases are counted by
 * a clock that has jumped, live holders renew theirs within a lease's time. */
enum store_answer store_sweep(struct store *store, struct store_sweep *sweep) {
    int64_t now = 0;
    bool trusted = false;
    bool due[STORE_STEP_COUNT] = {false};
    int done[STORE_STEP_COUNT] = {0};
    memset(sweep, 0, sizeof *sweep);
    enum store_answer answer = store->ops->find_due(store, due, &now);
    if (answer == STORE_OK) {
        pthread_mutex_lock(&lock);
        const struct clock_check before = store->clocks;
        clock_check_compare(&store->clocks, now, store_monotonic_us(store));
        const struct clock_check clocks = store->clocks;
        pthread_mutex_unlock(&lock);
        if (clocks.jumps > before.jumps)
            log_warning(log_event("clock_jumped"),
                        log_int("seconds", (now - before.wall_us) / 1000000));
        trusted = clock_check_agreed_us(&clocks) >= store->options.clock_trust_us;
        if (!store->ops->wall_leases || clocks.jumps == 0 ||
            clock_check_agreed_us(&clocks) > store->options.lease_us)
            answer = recovery_sweep(store, sweep);
    }
    due[STORE_STEP_DOOM] = due[STORE_STEP_DOOM] || sweep->requeued + sweep->failed > 0;
    for (int step = 0; step < STORE_STEP_COUNT && answer == STORE_OK; step++) {
        if (!due[step] || (!trusted && (step == STORE_STEP_EXPIRE || step == STORE_STEP_REMOVE)))
            continue;
        for (int n = 0; n < STEPS_A_SWEEP && answer == STORE_OK; n++) {
            int64_t count = 0;
            answer = store->ops->step(store, (enum store_step)step, &count);
            done[step] += answer == STORE_OK ? (int)count : 0;
        }
        sweep->more = sweep->more || answer == STORE_OK;
        if (answer == STORE_EMPTY)
            answer = STORE_OK;
        if (step < STORE_STEP_CLEAR && step != STORE_STEP_REMOVE)
            due[STORE_STEP_CLEAR] = true;
        if (step == STORE_STEP_CLEAR)
            due[STORE_STEP_SHRINK] = true;
    }
    sweep->expired = done[STORE_STEP_EXPIRE] + done[STORE_STEP_EXPIRE_EXCESS];
    sweep->removed = done[STORE_STEP_REMOVE];
    return answer == STORE_OK && store->ops->checkpoint ? store->ops->checkpoint(store) : answer;
}
