/* SPDX-License-Identifier: MIT */
/*
 * What becomes of a running job whose attempt ended without an end of the job: the rules about
 * attempts, the same for every backend. An attempt counts against the job unless it was given back
 * in good order, or the whole service died; without attempts left the job fails. `store_crashed`
 * and `store_release` are here, too.
 */
#ifndef SERVER_STORE_RECOVERY_H
#define SERVER_STORE_RECOVERY_H

#include "backend.h"

/* Gives back the jobs whose lease has ended or whose process is gone. */
enum store_answer recovery_sweep(struct store *store, struct store_sweep *sweep) STORE_MUST_USE;

#endif
