/* SPDX-License-Identifier: MIT */
/*
 * Random calls against a model of a few lines: after each of them the store and the model must
 * agree on the answer, and every now and then on every job there is.
 */
#include "scratch.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { JOBS_MAX = 400, DIGESTS = 40, OPERATIONS = 6000, LOOK_EVERY = 100, ATTEMPTS = 3 };

static const int64_t second = 1000000;
static const int64_t retention = INT64_C(168) * 3600 * 1000000;

struct model_job {
    char id[ID_SIZE];
    enum store_status status;
    int digest;
    int attempts, excused;
    bool expired, has_result;
    int64_t finished;
    struct store_claim claim, stale; /* the latest, and the one before */
};

struct model {
    struct scratch *scratch;
    uint64_t random;
    struct model_job jobs[JOBS_MAX]; /* in the order of submission */
    size_t count;
    char result[DIGESTS][ID_SIZE]; /* the job whose id is the content; "" without a result */
    int64_t expired, removed;
};

static size_t draw(struct model *model, size_t below) {
    return (size_t)(scratch_random(&model->random) % below);
}

/* ------------------------------------------------------------------ the model's own moves */

static void forget_result(struct model *model, struct model_job *job) {
    bool had = job->has_result;
    job->has_result = false;
    for (size_t k = 0; k < model->count; k++)
        if (model->jobs[k].has_result && model->jobs[k].digest == job->digest)
            return;
    if (had)
        model->result[job->digest][0] = '\0';
}

static void finish(struct model_job *job, enum store_status status) {
    job->status = status;
    job->finished = scratch_now;
}

static void give_back(struct model_job *job, bool excused) {
    if (!excused && job->attempts - job->excused >= ATTEMPTS) {
        finish(job, STORE_FAILED);
        return;
    }
    job->status = STORE_QUEUED;
    job->excused += excused;
}

static void forget_job(struct model *model, struct model_job *job) {
    forget_result(model, job);
    size_t after = (size_t)(model->jobs + model->count - (job + 1));
    memmove(job, job + 1, after * sizeof *job);
    model->count--;
}

/* ------------------------------------------------------------------ moves of both */

static void submit(struct model *model) {
    if (model->count == JOBS_MAX)
        return;
    struct model_job *job = &model->jobs[model->count++];
    char body[32];
    *job = (struct model_job){.digest = (int)draw(model, DIGESTS)};
    snprintf(body, sizeof body, "d%d", job->digest);
    scratch_submit(model->scratch, body, job->id);
    if (model->result[job->digest][0]) {
        job->has_result = true;
        finish(job, STORE_SUCCEEDED);
    }
}

static struct model_job *first_queued(struct model *model) {
    for (size_t k = 0; k < model->count; k++)
        if (model->jobs[k].status == STORE_QUEUED)
            return &model->jobs[k];
    return NULL;
}

static void claim(struct model *model) {
    struct store_claim claim;
    struct model_job *job = first_queued(model);
    enum store_answer answer = store_claim(model->scratch->store, &claim);
    assert_int_equal(answer, job ? STORE_OK : STORE_EMPTY);
    if (!job)
        return;
    assert_string_equal(claim.id, job->id);
    assert_int_equal(claim.reused, model->result[job->digest][0] != '\0');
    job->stale = job->claim;
    job->claim = claim;
    job->has_result = claim.reused;
    if (claim.reused) {
        finish(job, STORE_SUCCEEDED);
    } else {
        job->status = STORE_RUNNING;
        job->attempts++;
    }
}

static void commit(struct model *model, struct model_job *job) {
    assert_int_equal(scratch_commit(model->scratch, &job->claim, job->id, ID_SIZE), STORE_OK);
    if (!model->result[job->digest][0])
        memcpy(model->result[job->digest], job->id, ID_SIZE);
    job->has_result = true;
    finish(job, STORE_SUCCEEDED);
}

static void end_attempt(struct model *model, struct model_job *job) {
    struct store *store = model->scratch->store;
    switch (draw(model, 6)) {
    case 0:
        assert_int_equal(store_crashed(store, &job->claim, "signal 11"), STORE_OK);
        give_back(job, false);
        break;
    case 1:
        assert_int_equal(store_release(store, &job->claim), STORE_OK);
        give_back(job, true);
        break;
    case 2:
        assert_int_equal(store_fail(store, &job->claim, "{}"), STORE_OK);
        finish(job, STORE_FAILED);
        break;
    case 3:
        assert_int_equal(store_renew(store, &job->claim, 0.5), STORE_OK);
        break;
    default:
        commit(model, job);
    }
}

/* A holder of an old claim tries its luck. */
static void intrude(struct model *model, struct model_job *job) {
    struct store *store = model->scratch->store;
    const struct store_claim *stale = job->status == STORE_RUNNING ? &job->stale : &job->claim;
    if (stale->token == 0)
        return;
    assert_int_equal(store_check(store, stale), STORE_CONFLICT);
    assert_int_equal(store_renew(store, stale, 1), STORE_CONFLICT);
    assert_int_equal(store_crashed(store, stale, "x"), STORE_CONFLICT);
    assert_int_equal(scratch_commit(model->scratch, stale, "stale", 5), STORE_CONFLICT);
}

static void touch_job(struct model *model) {
    struct store *store = model->scratch->store;
    if (model->count == 0)
        return;
    struct model_job *job = &model->jobs[draw(model, model->count)];
    size_t what = draw(model, 10);
    if (what == 0) {
        bool ended = store_status_ended(job->status);
        assert_int_equal(store_cancel(store, job->id), ended ? STORE_CONFLICT : STORE_OK);
        if (!ended)
            finish(job, STORE_CANCELLED);
    } else if (what == 1) {
        assert_int_equal(store_delete(store, job->id), STORE_OK);
        forget_job(model, job);
    } else if (what < 5) {
        intrude(model, job);
    } else if (job->status == STORE_RUNNING) {
        end_attempt(model, job);
    }
}

/* ------------------------------------------------------------------ time and restarts */

static void sweep_all(struct model *model) {
    struct store_sweep sweep;
    int64_t expired = 0, removed = 0;
    for (int k = 0; k < 100; k++) {
        sweep = scratch_sweep(model->scratch);
        expired += sweep.expired;
        removed += sweep.removed;
        if (!sweep.more)
            break;
    }
    for (size_t k = 0; k < model->count; k++) {
        struct model_job *job = &model->jobs[k];
        if (!store_status_ended(job->status) || job->finished >= scratch_now - retention)
            continue;
        expired -= !job->expired;
        job->expired = true;
        forget_result(model, job);
        if (job->finished < scratch_now - 4 * retention) {
            removed--;
            forget_job(model, job);
            k--;
        }
    }
    assert_int_equal(expired, 0);
    assert_int_equal(removed, 0);
}

static void pass_time(struct model *model) {
    int64_t hours = (int64_t)draw(model, 300) * 3600;
    scratch_now += (61 + (draw(model, 3) == 0 ? hours : 0)) * second;
    for (size_t k = 0; k < model->count; k++)
        if (model->jobs[k].status == STORE_RUNNING)
            give_back(&model->jobs[k], false);
    sweep_all(model);
}

static void restart(struct model *model) {
    scratch_stop(model->scratch);
    scratch_start(model->scratch);
    if (model->scratch->remote)
        scratch_now += 61 * second; /* it cannot be known that the holder is gone */
    for (size_t k = 0; k < model->count; k++)
        if (model->jobs[k].status == STORE_RUNNING)
            give_back(&model->jobs[k], !model->scratch->remote && model->jobs[k].excused < 20);
    sweep_all(model);
}

/* ------------------------------------------------------------------ agreement */

static void expect_job(struct model *model, const struct model_job *job) {
    struct store_job found;
    struct store_result result;
    assert_int_equal(store_get(model->scratch->store, job->id, &found), STORE_OK);
    assert_int_equal(found.status, job->status);
    assert_int_equal(found.attempts, job->attempts);
    assert_int_equal(found.expired, job->expired);
    assert_true((found.error != NULL) == (job->status == STORE_FAILED));
    assert_true((found.summary != NULL) == (job->status == STORE_SUCCEEDED));
    assert_true(found.finished == (store_status_ended(job->status) ? job->finished : 0));
    store_job_clear(&found);
    if (job->has_result)
        scratch_expect_result(model->scratch, job->id, model->result[job->digest], ID_SIZE, 7);
    else
        assert_int_equal(store_result_find(model->scratch->store, job->id, &result), STORE_EMPTY);
}

static void expect_agreement(struct model *model) {
    int64_t jobs[STORE_STATUS_COUNT] = {0};
    struct store_counts counts;
    for (size_t k = 0; k < model->count; k++) {
        expect_job(model, &model->jobs[k]);
        jobs[model->jobs[k].status]++;
    }
    assert_int_equal(store_counts(model->scratch->store, &counts), STORE_OK);
    assert_memory_equal(jobs, counts.jobs, sizeof jobs);
}

static void test_store_agrees_with_its_model(void **state) {
    (void)state;
    struct scratch scratch;
    struct model *model = calloc(1, sizeof *model);
    model->scratch = &scratch;
    model->random = check_seed(1);
    scratch_open(&scratch);
    for (int k = 0; k < OPERATIONS; k++) {
        size_t what = draw(model, 1000);
        scratch_now += 1000;
        if (what < 250)
            submit(model);
        else if (what < 450)
            claim(model);
        else if (what < 990)
            touch_job(model);
        else if (what < 995)
            pass_time(model);
        else
            restart(model);
        if (k % LOOK_EVERY == 0)
            expect_agreement(model);
    }
    expect_agreement(model);
    scratch_remove(&scratch);
    free(model);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_store_agrees_with_its_model),
    };
    return scratch_run("store model", tests, NULL, 0);
}
