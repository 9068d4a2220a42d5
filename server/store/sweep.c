/* SPDX-License-Identifier: MIT */
#include "backend.h"
#include "recovery.h"
#include <string.h>

enum { STEPS_A_SWEEP = 100 }; /* of each kind: then `more` is set */

/* Repeats a step until it finds nothing more; adds what it did to `*done`. */
static enum store_answer repeat(struct store *store, enum store_step step,
                                struct store_sweep *sweep, int *done) {
    for (int n = 0; n < STEPS_A_SWEEP; n++) {
        int64_t count = 0;
        enum store_answer answer = store->ops->step(store, step, &count);
        if (answer != STORE_OK)
            return answer == STORE_EMPTY ? STORE_OK : answer;
        *done += (int)count;
    }
    sweep->more = true;
    return STORE_OK;
}

/* What is due is found by reading, so that an idle store is not written to. A step makes work for
 * those after it: claims that ended leave results half written, what expires leaves results to
 * clear, what is cleared leaves free pages. */
enum store_answer store_sweep(struct store *store, struct store_sweep *sweep) {
    bool due[STORE_STEP_COUNT] = {false};
    int done[STORE_STEP_COUNT] = {0};
    memset(sweep, 0, sizeof *sweep);
    enum store_answer answer = recovery_sweep(store, sweep);
    if (answer == STORE_OK)
        answer = store->ops->find_due(store, due);
    due[STORE_STEP_DOOM] = due[STORE_STEP_DOOM] || sweep->requeued + sweep->failed > 0;
    for (int step = 0; step < STORE_STEP_COUNT && answer == STORE_OK; step++) {
        if (!due[step])
            continue;
        answer = repeat(store, (enum store_step)step, sweep, &done[step]);
        if (step < STORE_STEP_CLEAR && step != STORE_STEP_REMOVE)
            due[STORE_STEP_CLEAR] = true;
        if (step == STORE_STEP_CLEAR)
            due[STORE_STEP_SHRINK] = true;
    }
    sweep->expired = done[STORE_STEP_EXPIRE] + done[STORE_STEP_EXPIRE_EXCESS];
    sweep->removed = done[STORE_STEP_REMOVE];
    return answer == STORE_OK && store->ops->checkpoint ? store->ops->checkpoint(store) : answer;
}
