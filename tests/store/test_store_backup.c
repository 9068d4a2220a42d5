/* SPDX-License-Identifier: MIT */
/* Copies of stores are put back as they were, whatever was there is kept, and what is no copy
 * changes nothing; what is seen of a store from outside. */
#include "capture.h"
#include "scratch.h"
#include "server/store/backend.h"
#include "server/store/backup.h"
#include "server/store/survey.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { COPY_SIZE = SCRATCH_PATH_SIZE + 16 };

/* Two results, a job that failed, one that waits, and a surface. */
static void fill(struct scratch *scratch, char failed[ID_SIZE]) {
    char id[ID_SIZE], definition[] = "definition", description[] = "{}";
    const struct store_item surface = {.id = "s",
                                       .owner = "anna",
                                       .definition = definition,
                                       .definition_length = 10,
                                       .description = description};
    bool created;
    for (int k = 0; k < 2; k++) {
        const struct store_claim claim = scratch_claimed(scratch, k ? "b" : "a");
        assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    }
    struct store_claim claim = scratch_claimed(scratch, "c");
    scratch_now += 1000000;
    assert_int_equal(store_fail(scratch->store, &claim, "{\"type\":\"late\"}"), STORE_OK);
    memcpy(failed, claim.id, ID_SIZE);
    scratch_submit(scratch, "d", id);
    assert_int_equal(store_item_put(scratch->store, STORE_SURFACES, &surface, &created), STORE_OK);
}

static void name_copy(const struct scratch *scratch, const char *name, char path[COPY_SIZE]) {
    snprintf(path, COPY_SIZE, "%s/%s", scratch->folder, name);
}

/* That it is refused, and what is said. */
static void expect_refusal(const struct scratch *scratch, const char *path, const char *said) {
    struct backup_contents contents;
    char kept[BACKUP_KEPT_SIZE], why[STORE_WHY_SIZE] = "";
    assert_false(backup_restore(scratch->path, path, &contents, kept, why));
    if (!strstr(why, said))
        fail_msg("\"%s\" lacks \"%s\"", why, said);
    assert_string_equal(kept, "");
}

static void test_backup_is_put_back_as_it_was(void **state) {
    struct scratch *scratch = *state;
    char path[COPY_SIZE], other[COPY_SIZE], kept[BACKUP_KEPT_SIZE], why[STORE_WHY_SIZE] = "";
    char failed[ID_SIZE], later[ID_SIZE];
    struct backup_contents made, again, back;
    struct store_job job;
    fill(scratch, failed);
    name_copy(scratch, "copy", path);
    name_copy(scratch, "other", other);
    assert_true(backup_make(scratch->path, path, &made, why));
    assert_int_equal(made.schema, STORE_SCHEMA);
    assert_int_equal(backup_rows(&made, "jobs"), 4);
    assert_int_equal(backup_rows(&made, "results"), 2);
    assert_int_equal(backup_rows(&made, "surfaces"), 1);
    assert_int_equal(backup_rows(&made, "tables"), 0);
    assert_true(backup_make(scratch->path, other, &again, why));
    assert_true(backup_same(&again, &made, why));
    expect_refusal(scratch, path, scratch->remote ? "psql has failed" : "in use by another draped");

    scratch_submit(scratch, "e", later);
    scratch_stop(scratch);
    struct capture *capture = malloc(sizeof *capture);
    assert_non_null(capture);
    capture_begin(capture, STDOUT_FILENO);
    bool restored = backup_restore(scratch->path, path, &back, kept, why);
    capture_end(capture);
    assert_true(restored);
    assert_string_equal(capture->text, "");
    free(capture);
    assert_true(backup_same(&back, &made, why));
    if (scratch->remote) {
        assert_memory_equal(kept, "schema draped_before_20", 23);
    } else {
        unlink(other);
        assert_true(backup_make(kept, other, &again, why));
        assert_int_equal(backup_rows(&again, "jobs"), 5);
        assert_false(backup_same(&again, &made, why));
        assert_non_null(strstr(why, "of the copy differs from that of the store"));
    }
    scratch_start(scratch);
    assert_int_equal(store_get(scratch->store, later, &job), STORE_EMPTY);
    assert_int_equal(scratch_status(scratch, failed), STORE_FAILED);
    scratch_stop(scratch);

    scratch_forget(scratch); /* and where there is none */
    assert_true(backup_restore(scratch->path, path, &back, kept, why));
    assert_true(backup_same(&back, &made, why));
    assert_string_equal(kept, "");
    scratch_start(scratch);
    assert_int_equal(scratch_status(scratch, failed), STORE_FAILED);
}

/* A database that was changed by hand, one without the list of its contents, another program's, one
 * that ends early, no file; and the store is as it was. */
static void test_backup_that_is_none_is_refused(void **state) {
    static const struct {
        const char *sql, *said;
    } rows[] = {
        {"UPDATE jobs SET created = created + 1 WHERE sequence = 2", "the table 'jobs'"},
        {"DELETE FROM surfaces",
         "the table 'owners' of the copy differs from that of the store: it has 1 of 2 rows"},
        {"UPDATE backup SET rows = rows + 1 WHERE name = 'results'", "it has 2 of 3 rows"},
        {"DELETE FROM backup WHERE name = 'jobs'", "tables of the store"},
        {"DROP TABLE backup", "not a back-up"},
        {"PRAGMA application_id = 1", "not a database of draped"},
    };
    struct scratch *scratch = *state;
    char path[COPY_SIZE], command[3 * COPY_SIZE], why[STORE_WHY_SIZE] = "", failed[ID_SIZE];
    struct backup_contents made;
    fill(scratch, failed);
    scratch_stop(scratch);
    name_copy(scratch, "copy", path);
    expect_refusal(scratch, path, "cannot be read");
    for (size_t k = 0; k < sizeof rows / sizeof *rows && !scratch->remote; k++) {
        struct scratch copy = *scratch;
        unlink(path);
        assert_true(backup_make(scratch->path, path, &made, why));
        snprintf(copy.path, sizeof copy.path, "%.240s", path);
        scratch_script(&copy, rows[k].sql);
        expect_refusal(scratch, path, rows[k].said);
    }
    unlink(path);
    assert_true(backup_make(scratch->path, path, &made, why));
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    assert_int_equal(truncate(path, status.st_size / 2), 0);
    expect_refusal(scratch, path, scratch->remote ? "pg_restore has failed" : "");
    snprintf(command, sizeof command, "printf 'SQLite format 3\\0 and no more' >%s", path);
    assert_int_equal(system(command), 0);
    expect_refusal(scratch, path, scratch->remote ? "is of an SQLite store" : "");
    snprintf(command, sizeof command, "echo words >%s", path);
    assert_int_equal(system(command), 0);
    expect_refusal(scratch, path, scratch->remote ? "not a back-up of a PostgreSQL store" : "");
    assert_true(unlink(path) == 0);
    scratch_start(scratch);
    assert_int_equal(scratch_status(scratch, failed), STORE_FAILED);
}

/* Jobs by their status, the last that failed and why, and the hosts, the latest first. */
static void test_survey_sees_what_is_there(void **state) {
    const struct store_host host = {
        .host = "a", .role = "worker", .version = "1.2", .workers = 4, .busy = 3};
    struct scratch *scratch = *state;
    struct survey *survey = malloc(sizeof *survey);
    char failed[ID_SIZE], why[STORE_WHY_SIZE] = "", nowhere[COPY_SIZE];
    assert_non_null(survey);
    assert_true(survey_store(scratch->path, survey, why));
    assert_int_equal(survey->host_count, 0);
    assert_string_equal(survey->failed, "");
    fill(scratch, failed);
    store_introduce(scratch->store, &host);
    assert_int_equal(store_beat(scratch->store), STORE_OK);
    assert_true(survey_store(scratch->path, survey, why));
    assert_int_equal(survey->schema, STORE_SCHEMA);
    assert_int_equal(survey->counts.jobs[STORE_SUCCEEDED], 2);
    assert_int_equal(survey->counts.jobs[STORE_FAILED], 1);
    assert_int_equal(survey->counts.jobs[STORE_QUEUED], 1);
    assert_int_equal(survey->host_count, 1);
    assert_string_equal(survey->hosts[0].host.role, "worker");
    assert_string_equal(survey->hosts[0].host.version, "1.2");
    assert_true(survey->hosts[0].host.workers == 4 && survey->hosts[0].host.busy == 3);
    assert_int_equal(survey->hosts[0].seen, scratch_now);
    assert_string_equal(survey->failed, failed);
    assert_int_equal(survey->failed_at, scratch_now);
    assert_string_equal(survey->error, "{\"type\":\"late\"}");
    name_copy(scratch, "nowhere", nowhere);
    assert_false(survey_store(nowhere, survey, why));
    assert_non_null(strstr(why, "nowhere"));
    assert_int_equal(access(nowhere, F_OK), -1);
    scratch_stop(scratch);
    scratch_forget(scratch);
    assert_false(survey_store(scratch->path, survey, why));
    assert_non_null(strstr(why, scratch->remote ? "has no store of draped" : "No such file"));
    free(survey);
}

static bool look_and_fail(const struct reader *reader, int64_t now, void *context,
                          char why[STORE_WHY_SIZE]) {
    const char *said = context;
    (void)reader;
    (void)now;
    snprintf(why, STORE_WHY_SIZE, "%s", said ? said : "");
    return false;
}

static bool look_and_see(const struct reader *reader, int64_t now, void *context,
                         char why[STORE_WHY_SIZE]) {
    int64_t schema = 0;
    (void)now;
    (void)context;
    return survey_schema(reader, &schema, why) && schema == STORE_SCHEMA;
}

/* What a look says itself, or else the database; and nothing where it has succeeded. */
static void test_survey_says_why_it_failed(void **state) {
    struct scratch *scratch = *state;
    char why[STORE_WHY_SIZE] = "of another time", said[] = "the look's own reason";
    assert_true(survey_by(scratch->path, look_and_see, NULL, why));
    assert_string_equal(why, "");
    assert_false(survey_by(scratch->path, look_and_fail, said, why));
    assert_string_equal(why, said);
    assert_false(survey_by(scratch->path, look_and_fail, NULL, why));
    assert_string_not_equal(why, "");
    assert_string_not_equal(why, said);
}

#define WITH_STORE(name) cmocka_unit_test_setup_teardown(name, scratch_set_up, scratch_tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_STORE(test_backup_is_put_back_as_it_was),
        WITH_STORE(test_backup_that_is_none_is_refused),
        WITH_STORE(test_survey_sees_what_is_there),
        WITH_STORE(test_survey_says_why_it_failed),
    };
    return scratch_run("store backup", tests, NULL, 0);
}
