/* SPDX-License-Identifier: MIT */
/* Results: chunks, sharing among equal requests, remains, retention. */
#include "scratch.h"
#include "server/store/backend.h"
#include "server/store/clock_check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static const int64_t hour = INT64_C(3600) * 1000000;

static unsigned char *random_bytes(uint64_t *state, size_t length) {
    unsigned char *bytes = malloc(length + 1);
    assert_non_null(bytes);
    for (size_t k = 0; k < length; k++)
        bytes[k] = (unsigned char)scratch_random(state);
    return bytes;
}

#define CHUNKS "SELECT count(*) FROM draped.chunks"
#define RESULTS "SELECT count(*) FROM draped.results"

/* ------------------------------------------------------------------ bytes */

static void test_store_result_of_every_size_reads_back(void **state) {
    struct scratch *scratch = *state;
    static const size_t chunk = STORE_CHUNK_BYTES, part = STORE_SEGMENT_BYTES;
    const size_t sizes[] = {1,        chunk - 1,    chunk,    chunk + 1,           part,
                            part + 1, 2 * part - 1, 2 * part, 2 * part + chunk + 5};
    uint64_t seed = check_seed(1);
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
        char body[32];
        snprintf(body, sizeof body, "size %zu", sizes[k]);
        unsigned char *bytes = random_bytes(&seed, sizes[k]);
        struct store_claim claim = scratch_claimed(scratch, body);
        assert_int_equal(scratch_commit(scratch, &claim, bytes, sizes[k]), STORE_OK);
        scratch_expect_result(scratch, claim.id, bytes, sizes[k], chunk);
        scratch_stop(scratch); /* and without what is in memory */
        scratch_start(scratch);
        scratch_expect_result(scratch, claim.id, bytes, sizes[k], sizes[k] + 1);
        scratch_expect_result(scratch, claim.id, bytes, sizes[k], 10007);
        free(bytes);
    }
}

static void test_store_result_appended_in_pieces_reads_back(void **state) {
    struct scratch *scratch = *state;
    enum { LENGTH = 3 * STORE_SEGMENT_BYTES + 12345 };
    uint64_t seed = check_seed(1);
    unsigned char *bytes = random_bytes(&seed, LENGTH);
    struct store_claim claim = scratch_claimed(scratch, "pieces");
    struct store_writer *writer = store_writer_new(scratch->store, &claim);
    for (size_t at = 0, piece = 0; at < LENGTH; at += piece) {
        piece = scratch_random(&seed) % 300000;
        piece = piece < LENGTH - at ? piece : LENGTH - at;
        assert_int_equal(store_writer_append(writer, bytes + at, piece), STORE_OK);
    }
    assert_int_equal(store_writer_commit(writer, "{\"nodes\":7}"), STORE_OK);
    store_writer_free(writer);
    scratch_expect_result(scratch, claim.id, bytes, LENGTH, 65521);
    struct store_job job;
    assert_int_equal(store_get(scratch->store, claim.id, &job), STORE_OK);
    assert_int_equal(job.status, STORE_SUCCEEDED);
    assert_string_equal(job.summary, "{\"nodes\":7}");
    assert_true(job.progress == 1.0);
    store_job_clear(&job);
    free(bytes);
}

static void test_store_result_is_there_only_when_the_job_succeeded(void **state) {
    struct scratch *scratch = *state;
    struct store_result result;
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(store_result_find(scratch->store, claim.id, &result), STORE_EMPTY);
    assert_int_equal(store_fail(scratch->store, &claim, "{}"), STORE_OK);
    assert_int_equal(store_result_find(scratch->store, claim.id, &result), STORE_EMPTY);
}

/* ------------------------------------------------------------------ sharing */

static void test_store_equal_requests_share_one_result(void **state) {
    struct scratch *scratch = *state;
    struct store_claim waiting;
    char queued[ID_SIZE], later[ID_SIZE];
    struct store_claim claim = scratch_claimed(scratch, "same");
    scratch_submit(scratch, "same", queued);
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);

    assert_int_equal(store_claim(scratch->store, &waiting), STORE_OK);
    assert_true(waiting.reused); /* it was in the queue before the result was there */
    assert_string_equal(waiting.id, queued);
    scratch_submit(scratch, "same", later);
    assert_int_equal(scratch_status(scratch, later), STORE_SUCCEEDED); /* never queued */
    const char *const ids[] = {claim.id, queued, later};
    for (size_t k = 0; k < 3; k++) {
        assert_int_equal(scratch_status(scratch, ids[k]), STORE_SUCCEEDED);
        scratch_expect_result(scratch, ids[k], "result", 6, 6);
    }
    assert_int_equal(scratch_number(scratch, CHUNKS), 1);
    for (size_t k = 0; k < 3; k++) {
        assert_int_equal(scratch_number(scratch, CHUNKS), 1);
        assert_int_equal(store_delete(scratch->store, ids[k]), STORE_OK);
        (void)scratch_sweep(scratch);
    }
    assert_int_equal(scratch_number(scratch, CHUNKS), 0);
    assert_int_equal(scratch_number(scratch, RESULTS), 0);
}

static void test_store_second_result_of_a_digest_is_dropped(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_claim first, second;
    unsigned char *large = calloc(1, STORE_SEGMENT_BYTES + 1);
    struct store_result one, two;
    scratch_submit(scratch, "same", id);
    scratch_submit(scratch, "same", id);
    assert_int_equal(store_claim(scratch->store, &first), STORE_OK);
    assert_int_equal(store_claim(scratch->store, &second), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &first, "result", 6), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &second, large, STORE_SEGMENT_BYTES + 1), STORE_OK);
    assert_int_equal(store_result_find(scratch->store, first.id, &one), STORE_OK);
    assert_int_equal(store_result_find(scratch->store, second.id, &two), STORE_OK);
    assert_int_equal(one.number, two.number);
    scratch_expect_result(scratch, second.id, "result", 6, 6);
    (void)scratch_sweep(scratch);
    assert_int_equal(scratch_number(scratch, CHUNKS), 1);
    free(large);
}

/* ------------------------------------------------------------------ uncommitted results */

/* One who waits for a job, and takes the uncommitted result when told of it. */
struct early_reader {
    struct scratch *scratch;
    const char *id;
    struct store_uncommitted *uncommitted;
    bool early; /* it was not kept yet */
};

static void take_uncommitted(void *context) {
    struct early_reader *reader = context;
    if (reader->uncommitted)
        return;
    reader->uncommitted = store_uncommitted_take(reader->scratch->store, reader->id);
    reader->early = reader->uncommitted && !store_uncommitted_kept(reader->uncommitted);
}

/* Commits while the reader waits; its answer. */
static enum store_answer commit_before(struct early_reader *reader, const struct store_claim *claim,
                                       const void *bytes, size_t length) {
    struct job_watch watch;
    reader->id = claim->id;
    job_events_subscribe(reader->scratch->events, &watch, claim->id, JOB_RESULT_READABLE,
                         take_uncommitted, reader);
    enum store_answer answer = scratch_commit(reader->scratch, claim, bytes, length);
    job_events_unsubscribe(reader->scratch->events, &watch);
    assert_null(store_uncommitted_take(reader->scratch->store, claim->id));
    return answer;
}

static void test_store_draft_is_what_the_commit_keeps(void **state) {
    struct scratch *scratch = *state;
    enum { LENGTH = 2 * STORE_CHUNK_BYTES + 777 };
    static const size_t places[][2] = {{0, LENGTH},
                                       {STORE_CHUNK_BYTES - 1, 2},
                                       {STORE_CHUNK_BYTES - 3, STORE_CHUNK_BYTES + 9},
                                       {LENGTH - 1, 1},
                                       {LENGTH, 0}};
    uint64_t seed = check_seed(1);
    unsigned char *bytes = random_bytes(&seed, LENGTH), *read = malloc(LENGTH);
    struct early_reader reader = {.scratch = scratch};
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(commit_before(&reader, &claim, bytes, LENGTH), STORE_OK);
    assert_non_null(reader.uncommitted);
    assert_true(reader.early && store_uncommitted_kept(reader.uncommitted));
    assert_int_equal(store_uncommitted_length(reader.uncommitted), LENGTH);
    for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
        size_t at = places[k][0], length = places[k][1];
        assert_true(store_uncommitted_read(reader.uncommitted, at, read, length));
        assert_memory_equal(read, bytes + at, length);
        assert_false(store_uncommitted_read(reader.uncommitted, at, read, LENGTH - at + 1));
    }
    assert_false(store_uncommitted_read(reader.uncommitted, LENGTH + 1, read, 0));
    scratch_expect_result(scratch, claim.id, bytes, LENGTH, LENGTH);
    store_uncommitted_drop(reader.uncommitted);
    struct store_result result;
    assert_int_equal(store_result_find(scratch->store, claim.id, &result), STORE_OK);
    for (int64_t k = 0; k < 4; k++) { /* its chunks are read from memory, and no more of them */
        struct store_cache *cache = scratch->store->cache;
        size_t length = k < 2 ? STORE_CHUNK_BYTES : k == 2 ? LENGTH % STORE_CHUNK_BYTES : 0;
        assert_int_equal(store_cache_read(cache, result.number, k, 0, read, length), length > 0);
        assert_false(store_cache_read(cache, result.number, k, 0, read, length + 1));
    }
    scratch_expect_result(scratch, claim.id, bytes, LENGTH, LENGTH);
    free(bytes);
    free(read);
}

/* Of a lost claim, of a job that takes another's result, and of what is longer than a part. */
static void test_store_draft_that_is_not_the_result_is_not_kept(void **state) {
    struct scratch *scratch = *state;
    struct store_claim lost = scratch_claimed(scratch, "a"), first, second;
    struct early_reader reader = {.scratch = scratch};
    assert_int_equal(store_cancel(scratch->store, lost.id), STORE_OK);
    assert_int_equal(commit_before(&reader, &lost, "result", 6), STORE_CONFLICT);
    assert_true(reader.early && !store_uncommitted_kept(reader.uncommitted));
    store_uncommitted_drop(reader.uncommitted);

    char id[ID_SIZE];
    scratch_submit(scratch, "same", id);
    scratch_submit(scratch, "same", id);
    assert_int_equal(store_claim(scratch->store, &first), STORE_OK);
    assert_int_equal(store_claim(scratch->store, &second), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &first, "result", 6), STORE_OK);
    reader = (struct early_reader){.scratch = scratch};
    assert_int_equal(commit_before(&reader, &second, "others", 6), STORE_OK);
    assert_true(reader.early && !store_uncommitted_kept(reader.uncommitted));
    store_uncommitted_drop(reader.uncommitted);
    scratch_expect_result(scratch, second.id, "result", 6, 6);

    unsigned char *large = calloc(1, STORE_SEGMENT_BYTES + 1);
    struct store_claim claim = scratch_claimed(scratch, "large");
    reader = (struct early_reader){.scratch = scratch};
    assert_int_equal(commit_before(&reader, &claim, large, STORE_SEGMENT_BYTES + 1), STORE_OK);
    assert_null(reader.uncommitted);
    free(large);
}

/* ------------------------------------------------------------------ remains */

static void test_store_writer_of_a_lost_claim_leaves_nothing(void **state) {
    struct scratch *scratch = *state;
    unsigned char *bytes = calloc(2, STORE_SEGMENT_BYTES);
    struct store_claim claim = scratch_claimed(scratch, "a");
    struct store_writer *writer = store_writer_new(scratch->store, &claim);
    assert_int_equal(store_writer_append(writer, bytes, STORE_SEGMENT_BYTES + 1), STORE_OK);
    assert_true(scratch_number(scratch, CHUNKS) > 0);
    assert_int_equal(store_cancel(scratch->store, claim.id), STORE_OK);
    assert_int_equal(store_writer_append(writer, bytes, STORE_SEGMENT_BYTES), STORE_CONFLICT);
    assert_int_equal(store_writer_commit(writer, "{}"), STORE_CONFLICT);
    store_writer_free(writer);
    (void)scratch_sweep(scratch);
    assert_int_equal(scratch_number(scratch, CHUNKS), 0);
    assert_int_equal(scratch_number(scratch, RESULTS), 0);
    free(bytes);
}

/* Claims a job, begins its result and is gone. */
static void die_while_writing(struct scratch *scratch) {
    static unsigned char bytes[STORE_SEGMENT_BYTES + 1];
    struct store_claim claim;
    scratch_start(scratch);
    bool good = store_claim(scratch->store, &claim) == STORE_OK &&
                store_writer_append(store_writer_new(scratch->store, &claim), bytes,
                                    sizeof bytes) == STORE_OK;
    _exit(good ? 0 : 1);
}

static void test_store_sweep_clears_what_a_dead_process_began(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    int status = 0;
    scratch_submit(scratch, "a", id);
    scratch_stop(scratch);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0)
        die_while_writing(scratch);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_int_equal(status, 0);
    scratch_start(scratch);
    assert_int_equal(scratch_status(scratch, id), STORE_RUNNING);
    assert_true(scratch_number(scratch, CHUNKS) > 0);
    if (scratch->remote)
        scratch_now += 61 * INT64_C(1000000);
    (void)scratch_sweep(scratch);
    assert_int_equal(scratch_number(scratch, CHUNKS), 0);
    assert_int_equal(scratch_status(scratch, id), STORE_QUEUED);
}

static off_t size_of(const char *path) {
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    return info.st_size;
}

static void test_store_sweep_takes_the_log_into_the_database(void **state) {
    struct scratch *scratch = *state;
    enum { LENGTH = 300000 };
    unsigned char *bytes = calloc(1, LENGTH);
    off_t before = size_of(scratch->path);
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &claim, bytes, LENGTH), STORE_OK);
    assert_int_equal(size_of(scratch->path), before);
    (void)scratch_sweep(scratch);
    assert_true(size_of(scratch->path) >= before + LENGTH);
    free(bytes);
}

static void test_store_deleted_results_give_their_room_back(void **state) {
    struct scratch *scratch = *state;
    enum { LENGTH = 64 << 20 };
    unsigned char *bytes = calloc(1, LENGTH);
    struct store_claim claim = scratch_claimed(scratch, "large");
    assert_int_equal(scratch_commit(scratch, &claim, bytes, LENGTH), STORE_OK);
    int64_t before = scratch_number(scratch, "SELECT page_count FROM pragma_page_count");
    assert_int_equal(store_delete(scratch->store, claim.id), STORE_OK);
    for (int k = 0; k < 100 && scratch_sweep(scratch).more; k++)
        continue;
    int64_t after = scratch_number(scratch, "SELECT page_count FROM pragma_page_count");
    assert_true(after < before / 2);
    free(bytes);
}

/* ------------------------------------------------------------------ retention */

static void expect_expired(struct scratch *scratch, const char *id) {
    struct store_job job;
    struct store_result result;
    char *request = NULL;
    size_t length = 0;
    assert_int_equal(store_get(scratch->store, id, &job), STORE_OK);
    assert_true(job.expired);
    assert_int_equal(job.status, STORE_SUCCEEDED);
    assert_string_equal(job.summary, "{\"nodes\":1}"); /* small, and still of interest */
    store_job_clear(&job);
    assert_int_equal(store_result_find(scratch->store, id, &result), STORE_EMPTY);
    assert_int_equal(store_request(scratch->store, id, &request, &length), STORE_EMPTY);
}

static void test_store_results_expire_after_the_retention(void **state) {
    struct scratch *scratch = *state;
    struct store_job job;
    char late[ID_SIZE];
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    scratch_now += 100 * hour;
    scratch_submit(scratch, "a", late); /* shares the result, and keeps it longer */
    scratch_now += 67 * hour;
    assert_int_equal(scratch_sweep(scratch).expired, 0);
    scratch_now += 2 * hour;
    assert_int_equal(scratch_sweep(scratch).expired, 1);
    expect_expired(scratch, claim.id);
    scratch_expect_result(scratch, late, "result", 6, 6);
    scratch_now += 100 * hour;
    assert_int_equal(scratch_sweep(scratch).expired, 1);
    expect_expired(scratch, late);
    assert_int_equal(scratch_number(scratch, CHUNKS), 0);
    scratch_now += 4 * 168 * hour;
    assert_int_equal(scratch_sweep(scratch).removed, 2);
    assert_int_equal(store_get(scratch->store, late, &job), STORE_EMPTY);
}

/* A record may go together with its result, or stay for as long as is wanted. */
static void test_store_records_have_a_retention_of_their_own(void **state) {
    struct scratch *scratch = *state;
    struct store_job job;
    scratch_stop(scratch);
    scratch->options.records_us = scratch->options.retention_us;
    scratch_start(scratch);
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    scratch_now += 167 * hour;
    assert_int_equal(scratch_sweep(scratch).removed, 0);
    assert_int_equal(store_get(scratch->store, claim.id, &job), STORE_OK);
    store_job_clear(&job);
    scratch_now += 2 * hour;
    int removed = scratch_sweep(scratch).removed;
    removed += scratch_sweep(scratch).removed;
    assert_int_equal(removed, 1);
    assert_int_equal(store_get(scratch->store, claim.id, &job), STORE_EMPTY);
}

/* What has ended is counted for good, and each host that gave a sign of life for a while. */
static void test_store_counts_what_ended_and_who_is_there(void **state) {
    struct scratch *scratch = *state;
    const struct store_host host = {
        .host = "a", .role = "worker", .version = "1", .workers = 4, .busy = 3};
    struct store_counts counts;
    char id[ID_SIZE];
    scratch->options.max_attempts = 1;
    scratch_stop(scratch);
    scratch_start(scratch);
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    claim = scratch_claimed(scratch, "b");
    assert_int_equal(store_fail(scratch->store, &claim, "{\"type\":\"/problems/job-timeout\"}"),
                     STORE_OK);
    claim = scratch_claimed(scratch, "c");
    assert_int_equal(store_crashed(scratch->store, &claim, "signal 11"), STORE_OK);
    scratch_submit(scratch, "d", id);
    assert_int_equal(store_cancel(scratch->store, id), STORE_OK);
    scratch_submit(scratch, "a", id); /* there already: it succeeds at once */
    assert_int_equal(store_delete(scratch->store, id), STORE_OK);
    store_introduce(scratch->store, &host);
    assert_int_equal(store_beat(scratch->store), STORE_OK);
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.ended[STORE_SUCCEEDED], 2);
    assert_int_equal(counts.jobs[STORE_SUCCEEDED], 1);
    assert_int_equal(counts.ended[STORE_FAILED], 2);
    assert_int_equal(counts.crashed, 1);
    assert_int_equal(counts.ended[STORE_CANCELLED], 1);
    assert_true(counts.hosts == 1 && counts.workers == 4 && counts.busy == 3);
    scratch_now += hour / 60;
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_true(counts.hosts == 0 && counts.workers == 0 && counts.busy == 0);
    assert_int_equal(store_beat(scratch->store), STORE_OK);
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.hosts, 1);
    scratch_now -=
        hour; /* it was there later than that, as is seen when the clock is right again */
    assert_int_equal(store_beat(scratch->store), STORE_OK);
    scratch_now += hour;
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.hosts, 1);
    scratch_stop(scratch); /* it takes its row along */
    scratch_start(scratch);
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.hosts, 0);
}

/* Beyond the bound of bytes the oldest go, and no more than it takes. */
static void test_store_results_expire_beyond_a_bound_of_bytes(void **state) {
    struct scratch *scratch = *state;
    enum { JOBS = 6, BYTES = 1000 };
    static char bytes[BYTES];
    char ids[JOBS][ID_SIZE], waiting[ID_SIZE], body[16];
    scratch_stop(scratch);
    scratch->options.retention_bytes = 3 * BYTES + 1;
    scratch_start(scratch);
    for (int k = 0; k < JOBS; k++) {
        snprintf(body, sizeof body, "%d", k);
        struct store_claim claim = scratch_claimed(scratch, body);
        assert_int_equal(scratch_commit(scratch, &claim, bytes, BYTES), STORE_OK);
        memcpy(ids[k], claim.id, sizeof ids[k]);
        scratch_now += hour;
    }
    scratch_submit(scratch, "waiting", waiting);
    assert_int_equal(scratch_sweep(scratch).expired, JOBS - 3);
    for (int k = 0; k < JOBS - 3; k++)
        expect_expired(scratch, ids[k]);
    for (int k = JOBS - 3; k < JOBS; k++)
        scratch_expect_result(scratch, ids[k], bytes, BYTES, BYTES);
    assert_int_equal(scratch_sweep(scratch).expired, 0);
    assert_int_equal(scratch_number(scratch, RESULTS), 3);
    assert_int_equal(scratch_status(scratch, waiting), STORE_QUEUED);
    assert_int_equal(store_delete(scratch->store, ids[JOBS - 1]), STORE_OK); /* makes room */
    struct store_claim claim;
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &claim, bytes, BYTES), STORE_OK);
    assert_int_equal(scratch_sweep(scratch).expired, 0);
}

/* Set forward or back, the clock has jumped; slewed or late by a little, it has not. */
static void test_store_steady_notices_a_clock_that_is_set(void **state) {
    (void)state;
    const int64_t second = 1000000;
    struct clock_check clocks = {0};
    clock_check_compare(&clocks, 1000 * second, second);
    clock_check_compare(&clocks, 1060 * second, 61 * second);
    assert_int_equal(clock_check_agreed_us(&clocks), 60 * second);
    clock_check_compare(&clocks, 1121 * second, 121 * second); /* a second too much */
    assert_int_equal(clock_check_agreed_us(&clocks), 120 * second);
    assert_int_equal(clocks.jumps, 0);
    clock_check_compare(&clocks, 1000 * second, 181 * second);
    assert_int_equal(clocks.jumps, 1);
    assert_int_equal(clock_check_agreed_us(&clocks), 0);
    clock_check_compare(&clocks, 5000 * second, 241 * second);
    assert_int_equal(clocks.jumps, 2);
    clock_check_compare(&clocks, 5060 * second, 301 * second);
    assert_int_equal(clock_check_agreed_us(&clocks), 60 * second);
}

/* A record, too, is removed only by a time that lasts. */
static void test_store_records_survive_a_clock_that_is_set(void **state) {
    struct scratch *scratch = *state;
    const int64_t minute = hour / 60;
    scratch_stop(scratch);
    scratch->options.clock_trust_us = 5 * minute;
    scratch_start(scratch);
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    scratch_sweep(scratch);
    scratch_now += 169 * hour;
    assert_int_equal(scratch_sweep(scratch).expired, 1);
    scratch_jump = 1000 * 24 * hour;
    for (int k = 0; k < 5; k++) {
        assert_int_equal(scratch_sweep(scratch).removed, 0);
        scratch_now += minute;
    }
    assert_int_equal(scratch_sweep(scratch).removed, 1);
}

/* Eight days forward, and back again: nothing is lost. Forward for good: gone after a while. */
static void test_store_results_survive_a_clock_that_is_set(void **state) {
    struct scratch *scratch = *state;
    const int64_t minute = hour / 60;
    scratch_stop(scratch);
    scratch->options.clock_trust_us = 5 * minute;
    scratch_start(scratch);
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    for (int k = 0; k < 40; k++) {
        scratch_jump = k % 4 == 0 ? 8 * 24 * hour : k % 4 == 3 ? 0 : scratch_jump;
        assert_int_equal(scratch_sweep(scratch).expired, 0);
        scratch_now += minute;
    }
    scratch_expect_result(scratch, claim.id, "result", 6, 6);
    scratch_jump = 8 * 24 * hour;
    for (int k = 0; k < 5; k++) {
        assert_int_equal(scratch_sweep(scratch).expired, 0);
        scratch_now += minute;
    }
    assert_int_equal(scratch_sweep(scratch).expired, 1);
}

/* Also the first look of a process is one look. */
static void test_store_results_do_not_expire_at_the_start(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    scratch_stop(scratch);
    scratch->options.clock_trust_us = hour;
    scratch_now += 169 * hour;
    scratch_start(scratch);
    assert_int_equal(scratch_sweep(scratch).expired, 0);
    scratch_now += hour;
    assert_int_equal(scratch_sweep(scratch).expired, 1);
}

static void commit_as(struct scratch *scratch, const char *owner, const char *body,
                      char id[ID_SIZE]) {
    static const char bytes[1000];
    struct store_receipt receipt;
    struct store_claim claim;
    struct store_submission submission = {
        .request = body, .request_length = strlen(body), .digest = body, .owner = owner};
    scratch_now += hour;
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
    assert_int_equal(receipt.status, STORE_QUEUED);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &claim, bytes, sizeof bytes), STORE_OK);
    memcpy(id, claim.id, ID_SIZE);
}

/* Bert's are the oldest, but anna has more than her share. */
static void test_store_bytes_of_one_owner_do_not_expire_anothers(void **state) {
    struct scratch *scratch = *state;
    char bert[2][ID_SIZE], anna[5][ID_SIZE];
    struct store_result result;
    scratch_stop(scratch);
    scratch->options.retention_bytes = 5000;
    scratch_start(scratch);
    for (int k = 0; k < 2; k++)
        commit_as(scratch, "bert", k ? "y" : "x", bert[k]);
    for (int k = 0; k < 5; k++)
        commit_as(scratch, "anna", (const char *[]){"1", "2", "3", "4", "5"}[k], anna[k]);
    int expired = 0;
    for (int k = 0; k < 5; k++)
        expired += scratch_sweep(scratch).expired;
    assert_int_equal(expired, 2);
    for (int k = 0; k < 2; k++)
        assert_int_equal(store_result_find(scratch->store, bert[k], &result), STORE_OK);
    for (int k = 0; k < 5; k++)
        assert_int_equal(store_result_find(scratch->store, anna[k], &result),
                         k < 2 ? STORE_EMPTY : STORE_OK);
}

static void test_store_equal_requests_of_two_owners_share_nothing(void **state) {
    struct scratch *scratch = *state;
    char anna[ID_SIZE], bert[ID_SIZE];
    struct store_result annas, berts;
    commit_as(scratch, "anna", "the same", anna);
    commit_as(scratch, "bert", "the same", bert);
    assert_int_equal(store_result_find(scratch->store, anna, &annas), STORE_OK);
    assert_int_equal(store_result_find(scratch->store, bert, &berts), STORE_OK);
    assert_true(annas.number != berts.number);
    assert_int_equal(store_delete(scratch->store, anna), STORE_OK);
    scratch_expect_result(scratch, bert, (char[1000]){0}, 1000, 1000);
}

static void test_store_jobs_that_wait_do_not_expire(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    scratch_submit(scratch, "a", id);
    scratch_now += 10000 * hour;
    struct store_sweep sweep = scratch_sweep(scratch);
    assert_int_equal(sweep.expired + sweep.removed, 0);
    assert_int_equal(scratch_status(scratch, id), STORE_QUEUED);
}

static void test_store_many_results_expire_in_steps(void **state) {
    struct scratch *scratch = *state;
    enum { JOBS = 200 };
    char body[32];
    for (int k = 0; k < JOBS; k++) {
        snprintf(body, sizeof body, "job %d", k);
        struct store_claim claim = scratch_claimed(scratch, body);
        assert_int_equal(scratch_commit(scratch, &claim, "x", 1), STORE_OK);
    }
    scratch_now += 169 * hour;
    struct store_sweep sweep = scratch_sweep(scratch);
    int sweeps = 1;
    assert_int_equal(sweep.expired, JOBS);
    for (; sweeps < 100 && sweep.more; sweeps++)
        sweep = scratch_sweep(scratch);
    assert_int_equal(sweeps,
                     scratch->remote ? 1 : 3); /* SQLite clears a result in each of 100 steps */
    assert_int_equal(scratch_number(scratch, RESULTS), 0);
    assert_int_equal(scratch_number(scratch, "SELECT count(*) FROM draped.requests"), 0);
}

#define WITH_STORE(name) cmocka_unit_test_setup_teardown(name, scratch_set_up, scratch_tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_STORE(test_store_result_of_every_size_reads_back),
        WITH_STORE(test_store_result_appended_in_pieces_reads_back),
        WITH_STORE(test_store_result_is_there_only_when_the_job_succeeded),
        WITH_STORE(test_store_equal_requests_share_one_result),
        WITH_STORE(test_store_second_result_of_a_digest_is_dropped),
        WITH_STORE(test_store_draft_is_what_the_commit_keeps),
        WITH_STORE(test_store_draft_that_is_not_the_result_is_not_kept),
        WITH_STORE(test_store_writer_of_a_lost_claim_leaves_nothing),
        WITH_STORE(test_store_sweep_clears_what_a_dead_process_began),
        WITH_STORE(test_store_results_expire_after_the_retention),
        WITH_STORE(test_store_records_have_a_retention_of_their_own),
        WITH_STORE(test_store_counts_what_ended_and_who_is_there),
        WITH_STORE(test_store_results_expire_beyond_a_bound_of_bytes),
        WITH_STORE(test_store_steady_notices_a_clock_that_is_set),
        WITH_STORE(test_store_records_survive_a_clock_that_is_set),
        WITH_STORE(test_store_results_survive_a_clock_that_is_set),
        WITH_STORE(test_store_results_do_not_expire_at_the_start),
        WITH_STORE(test_store_bytes_of_one_owner_do_not_expire_anothers),
        WITH_STORE(test_store_equal_requests_of_two_owners_share_nothing),
        WITH_STORE(test_store_jobs_that_wait_do_not_expire),
        WITH_STORE(test_store_many_results_expire_in_steps),
    };
    const struct CMUnitTest only_sqlite[] = {
        WITH_STORE(test_store_sweep_takes_the_log_into_the_database),
        WITH_STORE(test_store_deleted_results_give_their_room_back),
    };
    return scratch_run("store results", tests, only_sqlite,
                       sizeof only_sqlite / sizeof *only_sqlite);
}
