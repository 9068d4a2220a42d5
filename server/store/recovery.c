/* SPDX-License-Identifier: MIT */
#include "recovery.h"
#include "api/problem.h"
#include "server/log.h"
#include <stdlib.h>

enum {
    /* How often the death of the whole daemon is not held against the job. Beyond it the attempt
     * is, so that a job which brings the daemon down cannot do so for ever. */
    INTERRUPTIONS_EXCUSED = 20,
    CLAIMS_A_LOOK = 64
};

/* What ended the attempt. */
enum cause {
    CAUSE_CRASHED,    /* its worker died, or its lease was not renewed */
    CAUSE_RELEASED,   /* it was given back in good order */
    CAUSE_YIELDED,    /* so that others have their turns */
    CAUSE_INTERRUPTED /* the process that held it is gone */
};

/* Puts the job back into the queue at its old place or, without attempts left, fails it as
 * `solver-crashed` with `detail`; `*failed` says which. STORE_CONFLICT when the claim is lost. As
 * long as the claim holds, the attempts that are read here do not change. */
static enum store_answer give_job_back(struct store *store, const struct store_claim *claim,
                                       enum cause cause, const char *detail, bool *failed) {
    int64_t attempts = 0, excuses = 0;
    *failed = false;
    if (cause == CAUSE_RELEASED || cause == CAUSE_YIELDED)
        return store->ops->requeue(store, claim, true,
                                   cause == CAUSE_YIELDED ? STORE_LATER_TURNS : 0);
    enum store_answer answer = reads_attempts(store, claim, &attempts, &excuses);
    if (answer != STORE_OK)
        return answer;
    bool excused = cause == CAUSE_INTERRUPTED && excuses < INTERRUPTIONS_EXCUSED;
    *failed = !excused && attempts - excuses >= store->options.max_attempts;
    if (!*failed)
        return store->ops->requeue(store, claim, excused, 0);
    struct api_problem problem = {0};
    api_problem_set(&problem, API_SOLVER_CRASHED,
                    "The solver died in all %lld attempts; the last time: %s.",
                    (long long)(attempts - excuses), detail);
    char *json = api_problem_json(&problem, NULL);
    answer = json ? store->ops->fail(store, claim, json) : STORE_DOWN;
    free(json);
    return answer;
}

/* It may be claimed again. */
static void tell_again(struct store *store, const char *id) {
    store_tell(store, id);
    store_tell(store, job_events_queue);
}

static enum store_answer return_it(struct store *store, const struct store_claim *claim,
                                   enum cause cause, const char *detail) {
    bool failed = false;
    enum store_answer answer = give_job_back(store, claim, cause, detail, &failed);
    if (answer == STORE_OK)
        tell_again(store, claim->id);
    return answer;
}

enum store_answer store_crashed(struct store *store, const struct store_claim *claim,
                                const char *detail) {
    return return_it(store, claim, CAUSE_CRASHED, detail);
}

enum store_answer store_release(struct store *store, const struct store_claim *claim) {
    return return_it(store, claim, CAUSE_RELEASED, "");
}

enum store_answer store_yield(struct store *store, const struct store_claim *claim) {
    return return_it(store, claim, CAUSE_YIELDED, "");
}

/* Other processes sweep as well: a conflict means that one of them was first, or that the lease was
 * renewed after all. */
enum store_answer recovery_sweep(struct store *store, struct store_sweep *sweep) {
    struct store_ended ended[CLAIMS_A_LOOK];
    size_t count = 0;
    enum store_answer answer = store->ops->find_ended(store, ended, CLAIMS_A_LOOK, &count);
    for (size_t k = 0; k < count && answer == STORE_OK; k++) {
        const bool gone = ended[k].holder_gone;
        struct store_claim claim = ended[k].claim;
        bool failed = false;
        answer = store->ops->take_over(store, &ended[k], &claim.token);
        if (answer == STORE_OK)
            answer = give_job_back(store, &claim, gone ? CAUSE_INTERRUPTED : CAUSE_CRASHED,
                                   gone ? "the service itself died each time"
                                        : "its dispatcher did not renew the lease",
                                   &failed);
        if (answer == STORE_OK) {
            sweep->failed += failed;
            sweep->requeued += !failed;
            log_warning(log_event("claim_ended"), log_text("drape", claim.id),
                        log_text("cause", gone ? "process gone" : "lease"),
                        log_text("then", failed ? "failed" : "queued"));
            tell_again(store, claim.id);
        } else if (answer == STORE_CONFLICT) {
            answer = STORE_OK;
        }
    }
    sweep->more = sweep->more || count == CLAIMS_A_LOOK;
    return answer;
}
