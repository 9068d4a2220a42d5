/* SPDX-License-Identifier: MIT */
/* Opening: what is refused, and whether the sentence says why. */
#include "scratch.h"
#include "server/store/sqlite/db.h"
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int set_up(void **state) {
    struct scratch *scratch = malloc(sizeof *scratch);
    scratch_make(scratch);
    *state = scratch;
    return 0;
}

static void expect_refused(const char *url, const struct store_options *options,
                           const char *why_wanted) {
    char why[STORE_WHY_SIZE] = "";
    struct job_events *events = job_events_new();
    struct store *store = store_open(url, options, events, why);
    assert_null(store);
    if (!strstr(why, why_wanted))
        fail_msg("'%s' does not say '%s'", why, why_wanted);
    job_events_free(events);
}

static void write_file(const char *path, const void *bytes, size_t length) {
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    assert_true(file >= 0);
    assert_int_equal(write(file, bytes, length), length);
    close(file);
}

static void run_sql(const char *path, const char *sql) {
    char why[STORE_WHY_SIZE] = "";
    struct db *db = db_open(path, 1000, why);
    assert_non_null(db);
    assert_int_equal(db_script(db, sql), STORE_OK);
    db_close(db);
}

static void test_store_open_refuses_what_is_no_file(void **state) {
    struct scratch *scratch = *state;
    expect_refused("mysql://user:secret@host/db", &scratch->options, "unknown kind");
    expect_refused(":memory:", &scratch->options, "does not name a file");
    expect_refused("sqlite:", &scratch->options, "does not name a file");
    expect_refused("/nowhere/at/all/store.db", &scratch->options, "No such file or directory");
    expect_refused(scratch->folder, &scratch->options, "cannot be opened");
    char lock[SCRATCH_PATH_SIZE + 8];
    snprintf(lock, sizeof lock, "%s-lock", scratch->folder);
    unlink(lock);
}

static void test_store_open_hides_the_password(void **state) {
    struct scratch *scratch = *state;
    char why[STORE_WHY_SIZE] = "";
    assert_null(store_open("mysql://user:secret@host/db", &scratch->options, NULL, why));
    assert_null(strstr(why, "secret"));
}

static void test_store_open_takes_an_url(void **state) {
    struct scratch *scratch = *state;
    char url[SCRATCH_PATH_SIZE + 8];
    char why[STORE_WHY_SIZE] = "";
    snprintf(url, sizeof url, "sqlite:%s", scratch->path);
    struct job_events *events = job_events_new();
    struct store *store = store_open(url, &scratch->options, events, why);
    assert_non_null(store);
    store_close(store);
    job_events_free(events);
    assert_int_equal(access(scratch->path, F_OK), 0);
}

static void test_store_open_refuses_what_is_not_a_database(void **state) {
    struct scratch *scratch = *state;
    char text[2000];
    memset(text, 'x', sizeof text);
    write_file(scratch->path, text, sizeof text);
    expect_refused(scratch->path, &scratch->options, "is not a database");
}

static void test_store_open_refuses_the_database_of_another_program(void **state) {
    struct scratch *scratch = *state;
    run_sql(scratch->path, "CREATE TABLE recipes (name TEXT)");
    expect_refused(scratch->path, &scratch->options, "another program");
}

static void test_store_open_refuses_a_newer_schema(void **state) {
    struct scratch *scratch = *state;
    scratch_start(scratch);
    scratch_stop(scratch);
    run_sql(scratch->path, "INSERT INTO schema_version VALUES (1000, 0)");
    expect_refused(scratch->path, &scratch->options, "schema 1000");
}

/* Damages the pages of the jobs table: loss there would be silent. */
static void test_store_open_finds_damage(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    char body[32];
    scratch_start(scratch);
    for (int k = 0; k < 500; k++) {
        snprintf(body, sizeof body, "body %d", k);
        scratch_submit(scratch, body, id);
    }
    scratch_stop(scratch);
    struct stat info;
    unsigned char noise[4096];
    memset(noise, 0xa5, sizeof noise);
    assert_int_equal(stat(scratch->path, &info), 0);
    int file = open(scratch->path, O_WRONLY);
    for (off_t at = 16384; at + 4096 <= info.st_size; at += 8192)
        assert_int_equal(pwrite(file, noise, sizeof noise, at), sizeof noise);
    close(file);
    expect_refused(scratch->path, &scratch->options, "damaged");
}

static void test_store_open_refuses_a_second_process(void **state) {
    struct scratch *scratch = *state;
    struct store_options shared = scratch->options;
    shared.shared = true;
    scratch_start(scratch);
    expect_refused(scratch->path, &scratch->options, "in use by another draped");
    expect_refused(scratch->path, &shared, "in use by another draped");
    scratch_stop(scratch);
    scratch->options.shared = true;
    scratch_start(scratch);
    shared.shared = false;
    expect_refused(scratch->path, &shared, "in use by another draped");
}

/* Root may write anywhere, so it becomes nobody for a moment. */
static void test_store_open_refuses_a_folder_it_cannot_write(void **state) {
    enum { NOBODY = 65534 };
    struct scratch *scratch = *state;
    bool root = geteuid() == 0;
    assert_int_equal(chmod(scratch->folder, 0555), 0);
    assert_int_equal(root ? seteuid(NOBODY) : 0, 0);
    expect_refused(scratch->path, &scratch->options, "Permission denied");
    assert_int_equal(root ? seteuid(0) : 0, 0);
    assert_int_equal(chmod(scratch->folder, 0700), 0);
}

static void test_store_open_clears_away_the_files_of_the_dead(void **state) {
    struct scratch *scratch = *state;
    char dead[SCRATCH_PATH_SIZE + 64];
    snprintf(dead, sizeof dead, "%s-holder-00112233445566778899aabbccddeeff", scratch->path);
    write_file(dead, "", 0);
    scratch_start(scratch);
    assert_int_not_equal(access(dead, F_OK), 0);
}

static void test_store_reopens_with_everything(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    scratch_start(scratch);
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    scratch_submit(scratch, "b", id);
    scratch_stop(scratch);
    scratch_start(scratch);
    assert_int_equal(scratch_status(scratch, claim.id), STORE_SUCCEEDED);
    assert_int_equal(scratch_status(scratch, id), STORE_QUEUED);
    scratch_expect_result(scratch, claim.id, "result", 6, 6);
    assert_int_equal(store_ping(scratch->store), STORE_OK);
}

/* ------------------------------------------------------------------ the files while it is open */

static void move(const struct scratch *scratch, const char *suffix, bool away) {
    char here[SCRATCH_PATH_SIZE + 16], there[SCRATCH_PATH_SIZE + 16];
    snprintf(here, sizeof here, "%s%s", scratch->path, suffix);
    snprintf(there, sizeof there, "%s%s.away", scratch->path, suffix);
    assert_int_equal(away ? rename(here, there) : rename(there, here), 0);
}

static enum store_answer submit_one(struct scratch *scratch, const char *body) {
    struct store_receipt receipt;
    struct store_submission submission = {.request = body, .request_length = 1, .digest = body};
    return store_submit(scratch->store, &submission, &receipt);
}

/* Nothing is accepted, nor claimed, nor ended, into files that nobody will find again; what was
 * accepted goes on when they are back. */
static void expect_refusal_while_away(struct scratch *scratch, const char *suffix) {
    char id[ID_SIZE];
    struct store_sweep sweep;
    struct store_claim held, other;
    scratch_start(scratch);
    held = scratch_claimed(scratch, "held");
    scratch_submit(scratch, "waits", id);
    move(scratch, suffix, true);
    assert_int_equal(submit_one(scratch, "new"), STORE_MISSING);
    assert_int_equal(store_ping(scratch->store), STORE_MISSING);
    assert_int_equal(store_sweep(scratch->store, &sweep), STORE_MISSING);
    assert_int_equal(store_claim(scratch->store, &other), STORE_MISSING);
    assert_int_equal(scratch_commit(scratch, &held, "r", 1), STORE_MISSING);
    move(scratch, suffix, false);
    assert_int_equal(store_ping(scratch->store), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &held, "r", 1), STORE_OK);
    assert_int_equal(submit_one(scratch, "new"), STORE_OK);
    scratch_stop(scratch);
    scratch_start(scratch);
    assert_int_equal(scratch_status(scratch, held.id), STORE_SUCCEEDED);
    assert_int_equal(scratch_number(scratch, "SELECT n FROM counts WHERE status = 0"), 2);
    scratch_stop(scratch);
    scratch_forget(scratch);
}

static void test_store_refuses_while_its_files_are_away(void **state) {
    static const char *const suffixes[] = {"", "-wal", "-shm"};
    for (size_t k = 0; k < 3; k++)
        expect_refusal_while_away(*state, suffixes[k]);
    scratch_start(*state);
}

/* Such as a backup that is put in its place: this process must not go on with the old one. */
static void test_store_refuses_while_another_file_is_in_its_place(void **state) {
    struct scratch *scratch = *state;
    scratch_start(scratch);
    assert_int_equal(submit_one(scratch, "a"), STORE_OK);
    move(scratch, "", true);
    write_file(scratch->path, "x", 1);
    assert_int_equal(submit_one(scratch, "b"), STORE_MISSING);
    assert_int_equal(store_ping(scratch->store), STORE_MISSING);
    move(scratch, "", false);
    assert_int_equal(submit_one(scratch, "b"), STORE_OK);
}

#define WITH_FOLDER(name) cmocka_unit_test_setup_teardown(name, set_up, scratch_tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(test_store_open_refuses_what_is_no_file),
        WITH_FOLDER(test_store_open_hides_the_password),
        WITH_FOLDER(test_store_open_takes_an_url),
        WITH_FOLDER(test_store_open_refuses_what_is_not_a_database),
        WITH_FOLDER(test_store_open_refuses_the_database_of_another_program),
        WITH_FOLDER(test_store_open_refuses_a_newer_schema),
        WITH_FOLDER(test_store_open_finds_damage),
        WITH_FOLDER(test_store_open_refuses_a_second_process),
        WITH_FOLDER(test_store_open_refuses_a_folder_it_cannot_write),
        WITH_FOLDER(test_store_open_clears_away_the_files_of_the_dead),
        WITH_FOLDER(test_store_reopens_with_everything),
        WITH_FOLDER(test_store_refuses_while_its_files_are_away),
        WITH_FOLDER(test_store_refuses_while_another_file_is_in_its_place),
    };
    return cmocka_run_group_tests_name("store open", tests, NULL, NULL);
}
