/* SPDX-License-Identifier: MIT */
/* A store whose bytes have changed on the disk: what is read is what was written, or it is told. */
#include "scratch.h"
#include "server/store/backend.h"
#include "server/store/survey.h"
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ------------------------------------------------------------------ a store with all there is */

enum { RESULTS = 4, LARGEST = 3 * STORE_CHUNK_BYTES + 100 };

static const size_t result_lengths[RESULTS] = {10, STORE_CHUNK_BYTES, STORE_CHUNK_BYTES + 7,
                                               LARGEST};

/* What was written, of jobs by their number: succeeded ones, then one that failed and a study. */
struct written {
    char drape[RESULTS][ID_SIZE], failed[ID_SIZE], study[ID_SIZE];
    unsigned char result[LARGEST]; /* each result is the first bytes of it, its number added */
};

static const char definition[] = "{\"type\":\"nurbs\",\"points\":[[0,0,0]]}";
static const char description[] = "{\"faces\":1}", summary[] = "{\"nodes\":1}";
static const char problem[] = "{\"type\":\"/problems/start-off-surface\"}";
static const char numbers[] = "1 2 3 4 5", item_name[] = "item";

static void result_of(const struct written *written, size_t k, unsigned char bytes[LARGEST]) {
    for (size_t at = 0; at < result_lengths[k]; at++)
        bytes[at] = (unsigned char)(written->result[at] + k);
}

static struct store_item item_of(void) {
    struct store_item item = {.definition = strdup(definition),
                              .definition_length = strlen(definition),
                              .description = strdup(description)};
    snprintf(item.id, sizeof item.id, "%s", item_name);
    return item;
}

static void fill_study(struct scratch *scratch, struct written *written) {
    const int64_t variants = 3;
    const struct store_submission study = {.kind = STORE_STUDY,
                                           .total = 3,
                                           .request = "study",
                                           .request_length = strlen("study"),
                                           .digest = "study"};
    const struct store_round round = {
        .tasks = "task", .variants = &variants, .length = 4, .count = 1, .total = 3};
    struct store_receipt receipt;
    struct store_claim claim;
    assert_int_equal(store_submit(scratch->store, &study, &receipt), STORE_OK);
    memcpy(written->study, receipt.id, ID_SIZE);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(store_begin_round(scratch->store, &claim, &round), STORE_OK);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(store_end_task(scratch->store, &claim, numbers, strlen(numbers), 1), STORE_OK);
}

static void fill(struct scratch *scratch, struct written *written) {
    unsigned char bytes[LARGEST];
    uint64_t seed = 1;
    for (size_t k = 0; k < LARGEST; k++)
        written->result[k] = (unsigned char)scratch_random(&seed);
    for (size_t k = 0; k < RESULTS; k++) {
        char body[32];
        snprintf(body, sizeof body, "request %zu", k);
        struct store_claim claim = scratch_claimed(scratch, body);
        memcpy(written->drape[k], claim.id, ID_SIZE);
        result_of(written, k, bytes);
        assert_int_equal(scratch_commit(scratch, &claim, bytes, result_lengths[k]), STORE_OK);
    }
    struct store_claim claim = scratch_claimed(scratch, "request that fails");
    memcpy(written->failed, claim.id, ID_SIZE);
    assert_int_equal(store_fail(scratch->store, &claim, problem), STORE_OK);
    fill_study(scratch, written);
    for (int kind = STORE_SURFACES; kind < STORE_ITEM_KINDS; kind++) {
        struct store_item item = item_of();
        bool created;
        assert_int_equal(
            store_item_put(scratch->store, (enum store_item_kind)kind, &item, &created), STORE_OK);
        store_item_clear(&item);
    }
}

/* ------------------------------------------------------------------ reading all of it */

/* How often what was read is what was written, was told to be altered, is not there, or the
 * database failed. What is anything else fails the test. */
struct seen {
    int sound, altered, gone, failed;
};

static void see(struct seen *seen, enum store_answer answer, bool same) {
    if (answer == STORE_OK && !same)
        fail_msg("what was read is not what was written");
    seen->sound += answer == STORE_OK;
    seen->altered += answer == STORE_ALTERED;
    seen->gone += answer == STORE_EMPTY;
    seen->failed += store_failed(answer);
}

static bool is_text(const char *bytes, size_t length, const char *text) {
    return bytes && length == strlen(text) && !memcmp(bytes, text, length);
}

static bool text_is(const char *text, const char *wanted) {
    return wanted ? text && !strcmp(text, wanted) : !text;
}

static void see_request(struct store *store, const char *id, const char *body, struct seen *seen) {
    char *bytes;
    size_t length;
    enum store_answer answer = store_request(store, id, &bytes, &length);
    see(seen, answer, is_text(bytes, length, body));
    free(bytes);
}

/* The texts that callers see. */
static void see_job(struct store *store, const char *id, const char *error, const char *told,
                    struct seen *seen) {
    struct store_job job;
    enum store_answer answer = store_get(store, id, &job);
    if (answer == STORE_OK && job.altered)
        answer = STORE_ALTERED;
    see(seen, answer, text_is(job.error, error) && text_is(job.summary, told));
    store_job_clear(&job);
}

static void see_result(struct store *store, const struct written *written, size_t k,
                       struct seen *seen) {
    struct store_result result;
    unsigned char wanted[LARGEST], got[LARGEST];
    result_of(written, k, wanted);
    enum store_answer answer = store_result_find(store, written->drape[k], &result);
    bool fits = answer == STORE_OK && result.length >= 0 && result.length <= LARGEST;
    if (answer == STORE_OK && !fits) { /* as a caller does, chunk by chunk */
        answer = store_result_read(store, &result, LARGEST / STORE_CHUNK_BYTES * STORE_CHUNK_BYTES,
                                   got, 1);
        assert_int_not_equal(answer, STORE_OK);
    } else if (fits) {
        answer = store_result_read(store, &result, 0, got, (size_t)result.length);
    }
    see(seen, answer,
        fits && (size_t)result.length == result_lengths[k] &&
            !memcmp(got, wanted, result_lengths[k]));
}

static void see_item(struct store *store, enum store_item_kind kind, struct seen *seen) {
    struct store_item item;
    enum store_answer answer = store_item_get(store, kind, "", item_name, &item);
    see(seen, answer,
        is_text(item.definition, item.definition_length, definition) &&
            text_is(item.description, description));
    store_item_clear(&item);
}

static struct seen see_all(struct store *store, const struct written *written) {
    struct seen seen = {0};
    struct store_claim study = {0};
    void *bytes;
    size_t length;
    for (size_t k = 0; k < RESULTS; k++) {
        char body[32];
        snprintf(body, sizeof body, "request %zu", k);
        see_request(store, written->drape[k], body, &seen);
        see_job(store, written->drape[k], NULL, summary, &seen);
        see_result(store, written, k, &seen);
    }
    see_request(store, written->failed, "request that fails", &seen);
    see_job(store, written->failed, problem, NULL, &seen);
    for (int kind = STORE_SURFACES; kind < STORE_ITEM_KINDS; kind++)
        see_item(store, (enum store_item_kind)kind, &seen);
    struct store_job job;
    if (store_get(store, written->study, &job) == STORE_OK) {
        memcpy(study.id, job.id, sizeof study.id);
        study.sequence = job.sequence;
        enum store_answer answer = store_numbers(store, &study, &bytes, &length);
        see(&seen, answer, length == 0 || is_text(bytes, length, numbers));
        free(bytes);
    }
    store_job_clear(&job);
    return seen;
}

enum { PARTS = 3 * RESULTS + 3 + STORE_ITEM_KINDS }; /* that `see_all` looks at */

/* ------------------------------------------------------------------ statements */

static int told;
static void count_told(const char *kind, const char *id, const char *what) {
    assert_true(*kind && *what);
    (void)id;
    told++;
}

/* Both see that: readers, and who checks all. */
static void test_store_changed_rows_are_told(void **state) {
    struct scratch *scratch = *state;
    static const char *const changes[] = {
        "UPDATE draped.requests SET bytes = bytes || bytes WHERE job = 2",
        "UPDATE draped.requests SET seal = seal + 1 WHERE job = 1",
        "UPDATE draped.requests SET bytes = (SELECT o.bytes FROM draped.requests o"
        " WHERE o.job = 2), seal = (SELECT o.seal FROM draped.requests o WHERE o.job = 2)"
        " WHERE job = 1",
        "UPDATE draped.results SET summary = '{\"nodes\":2}' WHERE job = 1",
        "UPDATE draped.results SET length = length - 1 WHERE job = 1",
        "UPDATE draped.results SET length = 65536 WHERE job = 3",
        "UPDATE draped.results SET length = length + 65536 WHERE job = 2",
        "UPDATE draped.results SET token = token + 1 WHERE job = 1",
        "UPDATE draped.jobs SET result = (SELECT number FROM draped.results WHERE job = 2)"
        " WHERE sequence = 1",
        "UPDATE draped.jobs SET error = '{\"type\":\"/problems/internal\"}' WHERE sequence = 5",
        "UPDATE draped.jobs SET error = NULL WHERE sequence = 5",
        "UPDATE draped.surfaces SET description = '{\"faces\":2}'",
        "UPDATE draped.surfaces SET definition = (SELECT bytes FROM draped.requests WHERE job = 1)",
        "UPDATE draped.materials SET seal = 0",
        "UPDATE draped.links SET definition = definition || definition",
        "UPDATE draped.task_numbers SET bytes = bytes || bytes",
    };
    for (size_t k = 0; k < sizeof changes / sizeof *changes; k++) {
        struct written *written = calloc(1, sizeof *written);
        struct store_audit audit;
        char why[STORE_WHY_SIZE];
        fill(scratch, written);
        scratch_stop(scratch);
        scratch_script(scratch, changes[k]);
        scratch_start(scratch);
        struct seen seen = see_all(scratch->store, written);
        if (seen.altered != 1 || seen.sound != PARTS - 1)
            fail_msg("%s: %d altered, %d sound", changes[k], seen.altered, seen.sound);
        scratch_stop(scratch);
        told = 0;
        assert_true(audit_store(scratch->path, count_told, &audit, why));
        if (told != 1 || audit.damaged != 1)
            fail_msg("%s: %d told of by the check", changes[k], told);
        scratch_forget(scratch);
        scratch_start(scratch);
        free(written);
    }
}

/* Chunks that change places, are lost, or are one of another result. */
static void test_store_changed_chunks_are_told(void **state) {
    struct scratch *scratch = *state;
    const char *own = scratch->remote ? "result = (SELECT number FROM draped.results WHERE job = 4)"
                                      : "id >> 24 = (SELECT number FROM results WHERE job = 4)";
    const char *index = scratch->remote ? "index" : "(id & 16777215)";
    /* the chunk before it */
    const char *copy =
        scratch->remote
            ? "UPDATE draped.chunks SET (bytes, seal) = (SELECT o.bytes, o.seal FROM draped.chunks"
              " o WHERE o.result = chunks.result AND o.index = chunks.index - 1)"
            : "UPDATE chunks SET (bytes, seal) ="
              " (SELECT o.bytes, o.seal FROM chunks o WHERE o.id = chunks.id - 1)";
    const struct {
        const char *sql;
        int index;
    } changes[] = {
        {"DELETE FROM draped.chunks", 1},
        {"UPDATE draped.chunks SET bytes = bytes || bytes", 1},
        {"UPDATE draped.chunks SET seal = seal + 1", 3},
        {copy, 2},
    };
    for (size_t k = 0; k < sizeof changes / sizeof *changes; k++) {
        struct written *written = calloc(1, sizeof *written);
        char sql[512];
        fill(scratch, written);
        scratch_stop(scratch);
        snprintf(sql, sizeof sql, "%s WHERE %s AND %s = %d", changes[k].sql, own, index,
                 changes[k].index);
        scratch_script(scratch, sql);
        scratch_start(scratch);
        struct seen seen = see_all(scratch->store, written);
        if (seen.altered != 1 || seen.sound != PARTS - 1)
            fail_msg("%s: %d altered, %d sound", sql, seen.altered, seen.sound);
        struct store_result result; /* found once, it is told before the first byte */
        assert_int_equal(store_result_find(scratch->store, written->drape[3], &result),
                         STORE_ALTERED);
        scratch_stop(scratch);
        scratch_forget(scratch);
        scratch_start(scratch);
        free(written);
    }
}

static void test_store_sound_store_is_told_well(void **state) {
    struct scratch *scratch = *state;
    struct written *written = calloc(1, sizeof *written);
    struct store_audit audit;
    char why[STORE_WHY_SIZE];
    fill(scratch, written);
    struct seen seen = see_all(scratch->store, written);
    assert_int_equal(seen.sound, PARTS);
    scratch_stop(scratch);
    told = 0;
    assert_true(audit_store(scratch->path, count_told, &audit, why));
    assert_int_equal(told, 0);
    assert_int_equal(audit.jobs, RESULTS + 3);
    assert_int_equal(audit.results, RESULTS);
    for (int kind = 0; kind < STORE_ITEM_KINDS; kind++)
        assert_int_equal(audit.items[kind], 1);
    scratch_start(scratch);
    free(written);
}

/* ------------------------------------------------------------------ the file */

static unsigned char *read_file(const char *path, size_t *length) {
    struct stat about;
    int file = open(path, O_RDONLY);
    assert_true(file >= 0 && fstat(file, &about) == 0);
    *length = (size_t)about.st_size;
    unsigned char *bytes = malloc(*length + 1);
    assert_non_null(bytes);
    assert_int_equal(read(file, bytes, *length), (ssize_t)*length);
    close(file);
    return bytes;
}

static void write_file(const char *path, const unsigned char *bytes, size_t length) {
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    assert_true(file >= 0);
    assert_int_equal(write(file, bytes, length), (ssize_t)length);
    close(file);
}

/* Flips bits, swaps or repeats blocks, or cuts the end off. */
static size_t damage(unsigned char *bytes, size_t length, uint64_t *seed) {
    enum { BLOCK = 512 };
    const size_t one = scratch_random(seed) % (length - BLOCK);
    const size_t other = scratch_random(seed) % (length - BLOCK);
    unsigned char block[BLOCK];
    switch (scratch_random(seed) % 4) {
    case 0:
        for (uint64_t left = 1 + scratch_random(seed) % 8; left > 0; left--)
            bytes[scratch_random(seed) % length] ^= (unsigned char)(1 << scratch_random(seed) % 8);
        break;
    case 1:
        memcpy(block, bytes + one, BLOCK);
        memmove(bytes + one, bytes + other, BLOCK);
        memcpy(bytes + other, block, BLOCK);
        break;
    case 2:
        memmove(bytes + one, bytes + other, BLOCK);
        break;
    default:
        return one;
    }
    return length;
}

static void test_store_damaged_file_gives_nothing_else(void **state) {
    enum { TRIALS = 300 };
    struct scratch *scratch = *state;
    struct written *written = calloc(1, sizeof *written);
    uint64_t seed = check_seed(1);
    struct seen all = {0};
    int refused = 0;
    fill(scratch, written);
    scratch_stop(scratch); /* which leaves no log beside the file */
    size_t length;
    unsigned char *sound = read_file(scratch->path, &length), *bytes = malloc(length);
    for (int k = 0; k < TRIALS; k++) {
        char why[STORE_WHY_SIZE], log[SCRATCH_PATH_SIZE + 8];
        struct job_events *events = job_events_new();
        struct store_audit audit;
        memcpy(bytes, sound, length);
        write_file(scratch->path, bytes, damage(bytes, length, &seed));
        struct store *store = store_open(scratch->path, &scratch->options, events, why);
        refused += !store;
        if (store) {
            struct seen seen = see_all(store, written);
            all.sound += seen.sound;
            all.altered += seen.altered;
            all.gone += seen.gone;
            all.failed += seen.failed;
        }
        store_close(store);
        job_events_free(events);
        write_file(scratch->path, bytes, length);
        (void)!audit_store(scratch->path, count_told, &audit, why); /* comes to an end */
        for (int which = 0; which < 2; which++) {
            snprintf(log, sizeof log, "%s%s", scratch->path, which ? "-wal" : "-shm");
            unlink(log);
        }
    }
    print_message("%d stores refused; of the others %d parts sound, %d altered, %d gone, %d in "
                  "what cannot be read\n",
                  refused, all.sound, all.altered, all.gone, all.failed);
    assert_true(all.altered > 0 && all.sound > 0);
    write_file(scratch->path, sound, length);
    scratch_start(scratch);
    free(sound);
    free(bytes);
    free(written);
}

#define WITH_STORE(name) cmocka_unit_test_setup_teardown(name, scratch_set_up, scratch_tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_STORE(test_store_sound_store_is_told_well),
        WITH_STORE(test_store_changed_rows_are_told),
        WITH_STORE(test_store_changed_chunks_are_told),
    };
    const struct CMUnitTest only_sqlite[] = {
        WITH_STORE(test_store_damaged_file_gives_nothing_else),
    };
    return scratch_run("store damage", tests, only_sqlite,
                       sizeof only_sqlite / sizeof *only_sqlite);
}
