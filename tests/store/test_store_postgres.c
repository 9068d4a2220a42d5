/* SPDX-License-Identifier: MIT */
/*
 * What only PostgreSQL can do to the store: refuse it, go away and come back, be a replica, stand
 * behind a pooler, have another clock. The program has its own clock_gettime, by which its clocks
 * can be set.
 */
#include "capture.h"
#include "scratch.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/store/postgres/pool.h"
#include <libpq-fe.h>
#include <netinet/in.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PATIENCE_MS = 30000 };

/* How far the wall clock of this process, and the other one, are ahead. */
static atomic_int wall_minutes, monotonic_minutes;

int clock_gettime(clockid_t id, struct timespec *now) {
    int code = (int)syscall(SYS_clock_gettime, id, now);
    now->tv_sec += 60 * atomic_load(id == CLOCK_REALTIME ? &wall_minutes : &monotonic_minutes);
    return code;
}

static int set_up(void **state) {
    struct scratch *scratch = malloc(sizeof *scratch);
    scratch_make(scratch);
    scratch->options.clock = NULL;
    scratch->options.monotonic_clock = NULL;
    *state = scratch;
    return 0;
}

/* ------------------------------------------------------------------ what is refused */

/* The sentence must say `wanted`, and nothing that is written may hold a piece of a password. */
static void expect_refused(struct scratch *scratch, const char *url, const char *wanted) {
    static const char *const secrets[] = {"se/cr", "se%2F", "cr@t", "cr%40", "hush", NULL};
    char why[STORE_WHY_SIZE] = "";
    struct job_events *events = job_events_new();
    struct capture *capture = malloc(sizeof *capture);
    capture_begin(capture, STDERR_FILENO);
    log_init(LOG_LEVEL_DEBUG);
    struct store *store = store_open(url, &scratch->options, events, why);
    log_init((enum log_level)(LOG_LEVEL_ERROR + 1));
    capture_end(capture);
    assert_null(store);
    if (!strstr(why, wanted))
        fail_msg("'%s' does not say '%s'", why, wanted);
    print_message("%s\n", why);
    for (size_t k = 0; secrets[k]; k++) {
        assert_null(strstr(why, secrets[k]));
        assert_null(strstr(capture->text, secrets[k]));
    }
    free(capture);
    job_events_free(events);
}

static void expect_user_refused(struct scratch *scratch, const char *user, const char *password,
                                const char *database, const char *wanted) {
    char url[CLUSTER_URL_SIZE];
    cluster_url(&scratch_cluster, user, password, database, url);
    expect_refused(scratch, url, wanted);
}

static void test_postgres_wrong_addresses_are_refused(void **state) {
    struct scratch *scratch = *state;
    expect_user_refused(scratch, "draped", "hush", "draped", "password authentication failed");
    expect_user_refused(scratch, "nobody", "hush", "draped", "password authentication failed");
    expect_user_refused(scratch, "draped", "se%2Fcr%40t%251", "nowhere", "\"nowhere\" does not");
    expect_refused(scratch, "postgresql://draped:hush@/draped?host=/nowhere", "cannot be used");
    expect_refused(scratch, "postgresql://draped:hush@127.0.0.1:1/draped", "Connection refused");
}

/* Where special characters were not escaped, what libpq would name is a piece of the password. */
static void test_postgres_urls_of_no_sense_are_refused(void **state) {
    static const char *const urls[] = {"postgresql://draped:a@hush@127.0.0.1/draped",
                                       "postgresql://draped:1/hush@127.0.0.1/draped",
                                       "postgresql://draped:hush/2@127.0.0.1/draped",
                                       "postgresql://draped:hush%zz@127.0.0.1/d",
                                       "postgresql://draped:hush@[::1/draped",
                                       "postgresql://127.0.0.1/d?hush",
                                       "postgresql://127.0.0.1/d?hush=1"};
    for (size_t k = 0; k < sizeof urls / sizeof *urls; k++)
        expect_refused(*state, urls[k], "the URL of the store cannot be read");
}

static void test_postgres_newer_schema_is_refused(void **state) {
    struct scratch *scratch = *state;
    scratch_start(scratch);
    scratch_stop(scratch);
    scratch_script(scratch, "INSERT INTO draped.schema_version VALUES (1000, now())");
    expect_refused(scratch, scratch->path, "schema 1000");
}

static void test_postgres_missing_rights_are_named(void **state) {
    struct scratch *scratch = *state;
    char url[CLUSTER_URL_SIZE];
    cluster_url(&scratch_cluster, "guest", "hush", "draped", url);
    scratch_script(scratch, "CREATE ROLE guest LOGIN PASSWORD 'hush'");
    expect_refused(scratch, url, "no privilege");
    scratch_start(scratch);
    scratch_stop(scratch);
    expect_refused(scratch, url, "no privilege");
    scratch_script(scratch, "GRANT USAGE ON SCHEMA draped TO guest;"
                            "GRANT SELECT ON ALL TABLES IN SCHEMA draped TO guest");
    expect_refused(scratch, url, "GRANT SELECT, INSERT, UPDATE, DELETE");
    scratch_script(scratch, "GRANT INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA draped TO guest;"
                            "GRANT USAGE ON ALL SEQUENCES IN SCHEMA draped TO guest");
    snprintf(scratch->path, sizeof scratch->path, "%s", url);
    scratch_start(scratch);
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    scratch_stop(scratch);
    snprintf(scratch->path, sizeof scratch->path, "%s", scratch_cluster.url);
    scratch_script(scratch, "DROP OWNED BY guest; DROP ROLE guest");
}

static void test_postgres_that_would_forget_is_refused(void **state) {
    struct scratch *scratch = *state;
    char url[CLUSTER_URL_SIZE];
    snprintf(url, sizeof url, "%.180s&options=-csynchronous_commit%%3Doff", scratch_cluster.url);
    expect_refused(scratch, url, "synchronous_commit");
}

static void test_postgres_missing_extension_is_named(void **state) {
    struct scratch *scratch = *state;
    scratch_script(scratch, "DROP EXTENSION plpgsql");
    expect_refused(scratch, scratch->path, "CREATE EXTENSION plpgsql");
    scratch_script(scratch, "CREATE EXTENSION plpgsql");
    scratch_start(scratch);
}

/* A server that says it is PostgreSQL 12, up to the point where it is sent away; Debian has none.
 */
static void *serve_version_12(void *context) {
    static const unsigned char hello[] = "R\0\0\0\10\0\0\0\0" /* no password needed */
                                         "S\0\0\0\30server_version\00012.9\0"
                                         "Z\0\0\0\5I";
    static const unsigned char done[] = "C\0\0\0\10SET\0Z\0\0\0\5I";
    char request[1024];
    int client = accept(*(const int *)context, NULL, NULL);
    if (read(client, request, sizeof request) > 0 &&
        write(client, hello, sizeof hello - 1) == sizeof hello - 1 &&
        read(client, request, sizeof request) > 0)
        (void)!write(client, done, sizeof done - 1);
    (void)!read(client, request, sizeof request);
    close(client);
    return NULL;
}

static void test_postgres_before_13_is_refused(void **state) {
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    socklen_t length = sizeof address;
    char url[CLUSTER_URL_SIZE];
    pthread_t thread;
    int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_int_equal(bind(listener, (struct sockaddr *)&address, length), 0);
    assert_int_equal(listen(listener, 1), 0);
    assert_int_equal(getsockname(listener, (struct sockaddr *)&address, &length), 0);
    assert_int_equal(pthread_create(&thread, NULL, serve_version_12, &listener), 0);
    snprintf(url, sizeof url,
             "postgresql://draped@127.0.0.1:%d/draped?sslmode=disable&gssencmode=disable",
             ntohs(address.sin_port));
    expect_refused(*state, url, "PostgreSQL 12");
    pthread_join(thread, NULL);
    close(listener);
}

/* ------------------------------------------------------------------ replicas */

static void wait_for_server(struct cluster *cluster) {
    char why[STORE_WHY_SIZE] = "";
    int64_t until = clock_ms() + PATIENCE_MS;
    struct pool *pool = NULL;
    /* A replica answers, by being refused for what it is. */
    while (!(pool = pool_open(cluster->url, POOL_PATIENCE_MS, why)) && !strstr(why, "replica") &&
           clock_ms() < until)
        scratch_sleep(50);
    pool_close(pool);
}

/* A real one, that follows the server; then it is made the primary. */
static void test_postgres_replica_is_refused_until_it_is_promoted(void **state) {
    struct scratch *scratch = *state;
    struct cluster replica = scratch_cluster;
    char id[ID_SIZE];
    scratch_start(scratch);
    scratch_submit(scratch, "kept", id);
    scratch_stop(scratch);
    const char *const copy[] = {"pg_basebackup", "-D", "replica",           "-R", "-c",
                                "fast",          "-d", scratch_cluster.url, NULL};
    const char *const serve[] = {
        "postgres",          "-D", "replica",   "-k", scratch_cluster.folder, "-p", "5433", "-c",
        "listen_addresses=", "-c", "fsync=off", NULL};
    const char *const promote[] = {"pg_ctl", "promote", "-D", "replica", NULL};
    cluster_run(&scratch_cluster, "pg_basebackup", copy);
    replica.pid = cluster_spawn(&scratch_cluster, "postgres", serve);
    snprintf(replica.url, sizeof replica.url, "%.200s&port=5433", scratch_cluster.url);
    wait_for_server(&replica);
    expect_refused(scratch, replica.url, "the database is a replica");
    cluster_run(&scratch_cluster, "pg_ctl", promote);
    snprintf(scratch->path, sizeof scratch->path, "%s", replica.url);
    scratch_start(scratch);
    assert_int_equal(scratch_status(scratch, id), STORE_QUEUED);
    scratch_stop(scratch);
    cluster_halt(&replica, 0);
    snprintf(scratch->path, sizeof scratch->path, "%s", scratch_cluster.url);
}

/* ------------------------------------------------------------------ it goes and comes back */

static void put_surface(struct scratch *scratch, const char *id) {
    static char text[] = "{}";
    bool created = false;
    struct store_item surface = {.definition = text, .definition_length = 2, .description = text};
    snprintf(surface.id, sizeof surface.id, "%s", id);
    assert_int_equal(store_item_put(scratch->store, STORE_SURFACES, &surface, &created), STORE_OK);
}

/* Claims do not wait for the disk: a server that crashes may forget the latest, but their holders,
 * on other machines, live on. Forgotten by hand here. */
static void test_postgres_forgotten_claim_is_not_mistaken_for_a_later_one(void **state) {
    struct scratch *scratch = *state;
    struct store_claim again;
    scratch_start(scratch);
    struct store_claim forgotten = scratch_claimed(scratch, "a");
    scratch_script(scratch, "UPDATE draped.jobs SET status = 0, started = 0, attempts = 0,"
                            " token = 0, lease = NULL");
    assert_int_equal(store_renew(scratch->store, &forgotten, 0.5), STORE_CONFLICT);
    assert_int_equal(store_claim(scratch->store, &again), STORE_OK);
    assert_string_equal(again.id, forgotten.id);
    assert_int_equal(store_renew(scratch->store, &forgotten, 0.5), STORE_CONFLICT);
    assert_int_equal(store_release(scratch->store, &forgotten), STORE_CONFLICT);
    assert_int_equal(scratch_commit(scratch, &forgotten, "old", 3), STORE_CONFLICT);
    assert_int_equal(scratch_commit(scratch, &again, "new", 3), STORE_OK);
}

static void test_postgres_restart_is_survived(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    scratch_start(scratch);
    for (int round = 0; round < 2; round++) {
        char body[32];
        snprintf(body, sizeof body, "round %d", round);
        struct store_claim claim = scratch_claimed(scratch, body);
        put_surface(scratch, body); /* with it on the disk is all that came before */
        cluster_halt(&scratch_cluster, round);
        assert_int_equal(store_renew(scratch->store, &claim, 0.5), STORE_DOWN);
        assert_int_equal(store_ping(scratch->store), STORE_DOWN);
        int64_t begun = clock_ms();
        assert_int_equal(scratch_commit(scratch, &claim, body, 7), STORE_DOWN);
        print_message("told after %lld ms\n", (long long)(clock_ms() - begun));
        cluster_resume(&scratch_cluster);
        int64_t until = clock_ms() + PATIENCE_MS;
        while (store_ping(scratch->store) != STORE_OK && clock_ms() < until)
            scratch_sleep(20);
        assert_int_equal(scratch_commit(scratch, &claim, body, 7), STORE_OK);
        scratch_expect_result(scratch, claim.id, body, 7, 7);
    }
    /* Restarted between two calls it is not even noticed. */
    cluster_halt(&scratch_cluster, 0);
    cluster_resume(&scratch_cluster);
    scratch_submit(scratch, "after", id);
}

/* A disk that is full for some tables: what the server says then stands in for it. A beat that can
 * be written over an old row does not end it, only one after which tables can grow. */
static void test_postgres_full_disk_is_over_when_tables_grow(void **state) {
    static const char fill[] =
        "CREATE FUNCTION draped.full_disk() RETURNS trigger LANGUAGE plpgsql AS"
        " 'BEGIN RAISE disk_full; END';"
        "CREATE TRIGGER full_disk BEFORE INSERT ON draped.hosts"
        " EXECUTE FUNCTION draped.full_disk();"
        "CREATE TRIGGER full_disk BEFORE INSERT ON draped.chunks"
        " EXECUTE FUNCTION draped.full_disk()";
    static const char size_sql[] = "SELECT pg_total_relation_size('draped.chunks')";
    enum { GROWN = 1000000 };
    const struct store_host host = {.host = "a", .role = "worker", .version = "1.2"};
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    scratch_start(scratch);
    store_introduce(scratch->store, &host);
    scratch_submit(scratch, "waits", id);
    assert_int_equal(store_beat(scratch->store), STORE_OK);
    assert_int_equal(scratch_status(scratch, id), STORE_QUEUED);
    assert_true(scratch_number(scratch, size_sql) < GROWN);
    scratch_script(scratch, fill);
    assert_int_equal(store_beat(scratch->store), STORE_NO_SPACE);
    scratch_script(scratch, "DROP TRIGGER full_disk ON draped.hosts");
    assert_int_equal(store_beat(scratch->store), STORE_NO_SPACE);
    assert_int_equal(store_health(scratch->store), STORE_NO_SPACE);
    scratch_script(scratch, "DROP TRIGGER full_disk ON draped.chunks");
    assert_int_equal(store_beat(scratch->store), STORE_OK);
    assert_int_equal(store_health(scratch->store), STORE_OK);
    assert_true(scratch_number(scratch, size_sql) > GROWN);
}

/* ------------------------------------------------------------------ connections */

static void expect_alive(struct scratch *scratch, int pid, bool alive) {
    char sql[80];
    snprintf(sql, sizeof sql, "SELECT count(*) FROM pg_stat_activity WHERE pid = %d", pid);
    int64_t until = clock_ms() + PATIENCE_MS;
    while (scratch_number(scratch, sql) != alive && clock_ms() < until)
        scratch_sleep(20);
    assert_int_equal(scratch_number(scratch, sql), alive);
}

/* The last that was given back is used next; when one is given back, that goes which was not used
 * for a minute. */
static void test_postgres_pool_closes_what_nobody_uses(void **state) {
    enum { COUNT = 3 };
    struct scratch *scratch = *state;
    struct pool_connection *taken[POOL_CONNECTIONS];
    enum store_answer answer;
    char why[STORE_WHY_SIZE] = "";
    int pid[COUNT];
    struct pool *pool = pool_open(scratch_cluster.url, POOL_PATIENCE_MS, why);
    assert_non_null(pool);
    for (int k = 0; k < COUNT; k++) {
        taken[k] = pool_take(pool, &answer);
        assert_non_null(taken[k]);
        pid[k] = PQbackendPID(taken[k]->libpq);
    }
    for (int k = 0; k < COUNT; k++)
        pool_give(pool, taken[k], false);
    for (int k = 0; k < COUNT; k++)
        expect_alive(scratch, pid[k], true);
    atomic_store(&monotonic_minutes, 1);
    for (int round = 0; round < COUNT; round++) {
        assert_ptr_equal(pool_take(pool, &answer), taken[COUNT - 1]);
        pool_give(pool, taken[COUNT - 1], false);
    }
    atomic_store(&monotonic_minutes, 0);
    for (int k = 0; k < COUNT; k++)
        expect_alive(scratch, pid[k], k == COUNT - 1);
    for (int k = 0; k < POOL_CONNECTIONS; k++) { /* all of which may be had again */
        taken[k] = pool_take(pool, &answer);
        assert_non_null(taken[k]);
    }
    for (int k = 0; k < POOL_CONNECTIONS; k++)
        pool_give(pool, taken[k], false);
    pool_close(pool);
}

/* ------------------------------------------------------------------ clocks and transactions */

static void test_postgres_leases_go_by_the_clock_of_the_database(void **state) {
    struct scratch *scratch = *state;
    static const int minutes[] = {600, -600};
    scratch_start(scratch);
    for (size_t k = 0; k < 2; k++) {
        struct store_job job;
        int64_t now = clock_utc_us();
        atomic_store(&wall_minutes, minutes[k]);
        assert_true(llabs(clock_utc_us() - now) > INT64_C(500) * 60 * 1000000);
        struct store_claim claim = scratch_claimed(scratch, k ? "behind" : "ahead");
        assert_int_equal(scratch_sweep(scratch).requeued, 0);
        assert_int_equal(store_check(scratch->store, &claim), STORE_OK);
        assert_int_equal(store_get(scratch->store, claim.id, &job), STORE_OK);
        assert_true(llabs(job.created - now) < INT64_C(60) * 1000000);
        store_job_clear(&job);
        atomic_store(&wall_minutes, 0);
        scratch_script(scratch, "UPDATE draped.jobs SET lease = 1 WHERE status = 1");
        assert_int_equal(scratch_sweep(scratch).requeued, 1);
        assert_int_equal(store_cancel(scratch->store, claim.id), STORE_OK);
    }
}

static int64_t open_transactions(struct scratch *scratch) {
    return scratch_number(scratch, "SELECT count(*) FROM pg_stat_activity WHERE datname = 'draped'"
                                   " AND backend_type = 'client backend'"
                                   " AND pid <> pg_backend_pid()"
                                   " AND (xact_start IS NOT NULL OR state <> 'idle')");
}

/* A connection that is being made, or listens, has a short one now and then; one of the writer
 * would be there as long as he is. */
static void test_postgres_no_transaction_is_open_while_a_job_runs(void **state) {
    struct scratch *scratch = *state;
    static unsigned char bytes[3000000];
    scratch_start(scratch);
    struct store_claim claim = scratch_claimed(scratch, "a");
    struct store_writer *writer = store_writer_new(scratch->store, &claim);
    assert_int_equal(store_writer_append(writer, bytes, sizeof bytes), STORE_OK);
    int64_t until = clock_ms() + PATIENCE_MS, left = 0;
    while ((left = open_transactions(scratch)) != 0 && clock_ms() < until)
        scratch_sleep(10);
    assert_int_equal(left, 0);
    assert_int_equal(store_writer_commit(writer, "{}"), STORE_OK);
    store_writer_free(writer);
}

/* ------------------------------------------------------------------ hints */

static void count_call(void *context) {
    atomic_fetch_add((atomic_int *)context, 1);
}

static void expect_call(atomic_int *calls) {
    int64_t begun = clock_ms();
    while (atomic_load(calls) == 0 && clock_ms() < begun + PATIENCE_MS)
        scratch_sleep(1);
    assert_true(atomic_exchange(calls, 0) > 0);
    print_message("told after %lld ms\n", (long long)(clock_ms() - begun));
}

/* The first is repeated: the other may not listen yet. */
static void test_postgres_tells_other_processes(void **state) {
    struct scratch *scratch = *state;
    struct job_watch queue, job;
    atomic_int queued = 0, changed = 0;
    char id[ID_SIZE];
    scratch_start(scratch);
    struct scratch other = *scratch;
    scratch_start(&other);
    job_events_subscribe(other.events, &queue, job_events_queue, JOB_CHANGED, count_call, &queued);
    for (int k = 0; k < 1000 && atomic_load(&queued) == 0; k++) {
        char body[32];
        snprintf(body, sizeof body, "body %d", k);
        scratch_submit(scratch, body, id);
        scratch_sleep(10);
    }
    expect_call(&queued);
    scratch_submit(scratch, "one more", id);
    expect_call(&queued);
    job_events_subscribe(other.events, &job, id, JOB_CHANGED, count_call, &changed);
    assert_int_equal(store_cancel(scratch->store, id), STORE_OK);
    expect_call(&changed);
    job_events_unsubscribe(other.events, &job);
    job_events_unsubscribe(other.events, &queue);
    scratch_stop(&other);
}

/* What was received is not passed back: of a job that is submitted two processes say one or two
 * words, the queue's, and then nothing. */
static void test_postgres_does_not_echo_what_it_is_told(void **state) {
    struct scratch *scratch = *state;
    size_t words = 0;
    char id[ID_SIZE];
    PGnotify *received;
    scratch_start(scratch);
    struct scratch other = *scratch;
    scratch_start(&other);
    PGconn *listener = PQconnectdb(scratch_cluster.url);
    PQclear(PQexec(listener, "LISTEN draped"));
    assert_int_equal(PQstatus(listener), CONNECTION_OK);
    scratch_submit(scratch, "a", id);
    for (int64_t until = clock_ms() + 500; clock_ms() < until; scratch_sleep(20)) {
        assert_int_equal(PQconsumeInput(listener), 1);
        for (; (received = PQnotifies(listener)); PQfreemem(received), words++)
            assert_string_not_equal(received->extra, "");
    }
    PQfinish(listener);
    assert_in_range(words, 1, 4);
    scratch_stop(&other);
}

/* ------------------------------------------------------------------ a pooler by the transaction */

static void write_text(const char *folder, const char *name, const char *text) {
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    cluster_own(&scratch_cluster, name);
}

static pid_t start_pooler(void) {
    char text[1024];
    snprintf(text, sizeof text,
             "[databases]\ndraped = host=%s user=draped password='%s'\n"
             "[pgbouncer]\npool_mode = transaction\ndefault_pool_size = 3\nauth_type = any\n"
             "unix_socket_dir = %s\nlisten_port = 6432\nlogfile = pooler.log\n"
             "ignore_startup_parameters = extra_float_digits\n",
             scratch_cluster.folder, CLUSTER_PASSWORD, scratch_cluster.folder);
    write_text(scratch_cluster.folder, "pooler.ini", text);
    const char *const serve[] = {"pgbouncer", "pooler.ini", NULL};
    return cluster_spawn(&scratch_cluster, "/usr/sbin/pgbouncer", serve);
}

static void *work_through_pooler(void *context) {
    struct scratch *scratch = context;
    struct store_claim claim;
    for (int k = 0; k < 25; k++) {
        char body[32];
        struct store_receipt receipt;
        int length = snprintf(body, sizeof body, "%lx %d", (unsigned long)pthread_self(), k);
        struct store_submission submission = {
            .request = body, .request_length = (size_t)length, .digest = body};
        if (store_submit(scratch->store, &submission, &receipt) != STORE_OK)
            abort();
        if (store_claim(scratch->store, &claim) == STORE_OK &&
            (store_renew(scratch->store, &claim, 0.5) != STORE_OK ||
             scratch_commit(scratch, &claim, body, (size_t)length) != STORE_OK))
            abort();
    }
    return NULL;
}

static void test_postgres_works_behind_a_pooler(void **state) {
    enum { THREADS = 6 };
    struct scratch *scratch = *state;
    struct cluster pooler = scratch_cluster;
    struct store_counts counts;
    pthread_t threads[THREADS];
    snprintf(pooler.url, sizeof pooler.url, "%.200s&port=6432", scratch_cluster.url);
    pooler.pid = start_pooler();
    wait_for_server(&pooler);
    snprintf(scratch->path, sizeof scratch->path, "%s", pooler.url);
    scratch_start(scratch);
    struct scratch other = *scratch;
    scratch_start(&other);
    for (int k = 0; k < THREADS; k++)
        assert_int_equal(
            pthread_create(&threads[k], NULL, work_through_pooler, k % 2 ? scratch : &other), 0);
    for (int k = 0; k < THREADS; k++)
        pthread_join(threads[k], NULL);
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.jobs[STORE_QUEUED] + counts.jobs[STORE_SUCCEEDED], THREADS * 25);
    assert_int_equal(counts.jobs[STORE_RUNNING], 0);
    assert_true(counts.jobs[STORE_SUCCEEDED] >= THREADS * 25 - THREADS);
    scratch_stop(&other);
    scratch_stop(scratch);
    cluster_halt(&pooler, 0);
    snprintf(scratch->path, sizeof scratch->path, "%s", scratch_cluster.url);
}

#define WITH_DATABASE(name) cmocka_unit_test_setup_teardown(name, set_up, scratch_tear_down)

int main(void) {
    signal(SIGPIPE, SIG_IGN);
    const struct CMUnitTest tests[] = {
        WITH_DATABASE(test_postgres_wrong_addresses_are_refused),
        WITH_DATABASE(test_postgres_urls_of_no_sense_are_refused),
        WITH_DATABASE(test_postgres_newer_schema_is_refused),
        WITH_DATABASE(test_postgres_missing_rights_are_named),
        WITH_DATABASE(test_postgres_that_would_forget_is_refused),
        WITH_DATABASE(test_postgres_missing_extension_is_named),
        WITH_DATABASE(test_postgres_before_13_is_refused),
        WITH_DATABASE(test_postgres_replica_is_refused_until_it_is_promoted),
        WITH_DATABASE(test_postgres_forgotten_claim_is_not_mistaken_for_a_later_one),
        WITH_DATABASE(test_postgres_restart_is_survived),
        WITH_DATABASE(test_postgres_full_disk_is_over_when_tables_grow),
        WITH_DATABASE(test_postgres_pool_closes_what_nobody_uses),
        WITH_DATABASE(test_postgres_leases_go_by_the_clock_of_the_database),
        WITH_DATABASE(test_postgres_no_transaction_is_open_while_a_job_runs),
        WITH_DATABASE(test_postgres_tells_other_processes),
        WITH_DATABASE(test_postgres_does_not_echo_what_it_is_told),
        WITH_DATABASE(test_postgres_works_behind_a_pooler),
    };
    return cmocka_run_group_tests_name("store postgres", tests, scratch_start_cluster,
                                       scratch_remove_cluster);
}
