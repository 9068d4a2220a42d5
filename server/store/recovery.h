/* SPDX-License-Identifier: MIT */
/*
 * What becomes of a running job whose attempt ended without an end of the job: the rules about
 * attempts, the same for every backend. An attempt counts against the job unless it was given back
 * in good order, or the whole service died; without attempts left the job fails.
 */
#ifndef SERVER_STORE_RECOVERY_H
#define SERVER_STORE_RECOVERY_H

#include "backend.h"

enum recovery_cause {
    RECOVERY_CRASHED,    /* its worker died, or its lease was not renewed */
    RECOVERY_RELEASED,   /* it was given back in good order */
    RECOVERY_INTERRUPTED /* the process that held it is gone */
};

/* Puts the job back into the queue at its old place or, without attempts left, fails it as
 * `solver-crashed` with `detail`; `*failed` says which. STORE_CONFLICT when the claim is lost. */
enum store_answer recovery_give_back(struct store *store, const struct store_claim *claim,
                                     enum recovery_cause cause, const char *detail,
                                     bool *failed) STORE_MUST_USE;

/* Gives back the jobs whose lease has ended or whose process is gone. */
enum store_answer recovery_sweep(struct store *store, struct store_sweep *sweep) STORE_MUST_USE;

#endif
