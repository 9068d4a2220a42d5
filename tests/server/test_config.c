/* SPDX-License-Identifier: MIT */
/* The table of flags: each flag, its variable, which of the two wins, and what is said of a value
 * that cannot be. */
#include "server/config.h"
#include "server/log.h"
#include "solver/surface/nurbs.h"
#include "tests/store/capture.h"
#include "tests/store/scratch.h"
#include <arpa/inet.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static struct capture out, err;

/* Parses up to four arguments; what was written is in `out` and `err`. */
static enum config_verdict parse(struct config *config, const char *a, const char *b, const char *c,
                                 const char *d) {
    char copies[4][200];
    char *argv[6] = {copies[0]};
    const char *const arguments[] = {a, b, c, d};
    static char name[] = "draped";
    int argc = 1;
    argv[0] = name;
    for (int k = 0; k < 4 && arguments[k]; k++) {
        snprintf(copies[k], sizeof copies[k], "%s", arguments[k]);
        argv[argc++] = copies[k];
    }
    capture_begin(&out, STDOUT_FILENO);
    capture_begin(&err, STDERR_FILENO);
    enum config_verdict verdict = config_parse(argc, argv, config);
    capture_end(&err);
    capture_end(&out);
    return verdict;
}

static enum config_verdict parse_one(struct config *config, const char *argument) {
    return parse(config, argument, NULL, NULL, NULL);
}

static void expect_bad(const char *a, const char *b, const char *said) {
    struct config config;
    assert_int_equal(parse(&config, a, b, NULL, NULL), CONFIG_BAD);
    assert_string_equal(out.text, "");
    if (!strstr(err.text, said))
        fail_msg("'%s' does not say '%s'", err.text, said);
}

static void test_config_has_defaults(void **state) {
    struct config config;
    (void)state;
    assert_int_equal(parse(&config, NULL, NULL, NULL, NULL), CONFIG_RUN);
    assert_string_equal(config.listen, "127.0.0.1:8080");
    assert_string_equal(config.data, "./draped-data");
    assert_string_equal(config.store, "");
    assert_true(config.loopback);
    assert_int_equal(config.workers, sysconf(_SC_NPROCESSORS_ONLN));
    assert_int_equal(config.role, CONFIG_ROLE_ALL);
    assert_int_equal(config.max_body, 64 << 20);
    assert_int_equal(config.max_control_points, NURBS_SIZE_MAX * NURBS_SIZE_MAX);
    assert_int_equal(config.retention, 168);
    assert_string_equal(out.text, "");
    assert_string_equal(err.text, "");
}

/* What an operator may give at the least and at the most; one less or more is refused by the name
 * of the flag. */
static void test_config_numbers_have_bounds(void **state) {
    static const int64_t KIB = 1024, MIB = 1024 * KIB, GIB = 1024 * MIB;
    const struct {
        const char *flag;
        int64_t least, most;
    } bounds[] = {
        {"--workers", 1, 1024},
        {"--queue-limit", 1, 1000000000},
        {"--max-body", KIB, 900 * MIB},
        {"--max-mesh", KIB, 900 * MIB},
        {"--max-bodies", KIB, 1024 * GIB},
        {"--max-nodes", 1, 1000000000},
        {"--max-variants", 1, 10000000},
        {"--max-control-points", 4, 262144},
        {"--max-elements", 16, 1000000000},
        {"--threads-per-job", 1, 64},
        {"--max-depth", 8, 1000},
        {"--job-timeout", 1, 604800},
        {"--lease", 2, 3600},
        {"--job-memory", 16 * MIB, 1024 * GIB},
        {"--check-memory", 64 * MIB, 1024 * GIB},
        {"--import-timeout", 1, 86400},
        {"--check-timeout", 1, 3600},
        {"--max-result", MIB, 1024 * GIB},
        {"--retention", 1, 876000},
        {"--retention-jobs", 1, 3504000},
        {"--retention-bytes", 0, 1024 * 1024 * GIB},
        {"--max-connections", 16, 1000000},
        {"--owner-queue", 1, 1000000000},
        {"--owner-running", 0, 1000000},
        {"--owner-bytes", 0, 1024 * 1024 * GIB},
        {"--owner-connections", 1, 1000000},
        {"--owner-streams", 1, 1000000},
        {"--owner-bodies", KIB, 1024 * GIB},
        {"--drain-timeout", 0, 25},
    };
    (void)state;
    for (size_t k = 0; k < sizeof bounds / sizeof *bounds; k++)
        for (int side = 0; side < 4; side++) {
            struct config config;
            char text[32], said[128];
            int64_t value = side < 2 ? bounds[k].least : bounds[k].most;
            bool beyond = side == 0 || side == 3;
            value += (side == 3) - (side == 0);
            snprintf(text, sizeof text, "%lld", (long long)value);
            snprintf(said, sizeof said, "%s: %s is out of range; it takes %lld to %lld",
                     bounds[k].flag, text, (long long)bounds[k].least, (long long)bounds[k].most);
            /* together with others the least and the most may make no sense */
            bool refused = parse(&config, bounds[k].flag, text, NULL, NULL) == CONFIG_BAD &&
                           strstr(err.text, value < 0 ? "is not a number" : said);
            if (refused != beyond)
                fail_msg("%s %s: %s", bounds[k].flag, text, err.text);
        }
}

/* A store that is opened without more is as the daemon opens it without flags. */
static void test_config_of_the_store_is_its_own_defaults(void **state) {
    const struct store_options *options = &store_options_default;
    const int64_t second = 1000000, hour = 3600 * second;
    struct config config;
    (void)state;
    assert_int_equal(parse(&config, NULL, NULL, NULL, NULL), CONFIG_RUN);
    assert_int_equal(options->queue_limit, config.queue_limit);
    assert_int_equal(options->lease_us, config.lease * second);
    assert_int_equal(options->retention_us, config.retention * hour);
    assert_int_equal(options->records_us, config.retention_jobs * hour);
    assert_int_equal(options->retention_bytes, config.retention_bytes);
    assert_int_equal(options->owner_running, config.owner_running);
    assert_int_equal(options->max_attempts, 3);
    assert_int_equal(options->busy_ms, 5000);
    assert_int_equal(options->clock_trust_us, 300 * second);
}

/* A flag that holds a number or a choice, with a good value, its variable and a bad value. */
static const struct {
    const char *flag, *variable, *text;
    size_t offset;
    int64_t value;
    const char *bad;
} numbers[] = {
#define AT(member) offsetof(struct config, member)
    {"--workers", "DRAPED_WORKERS", "3", AT(workers), 3, "0"},
    {"--role", "DRAPED_ROLE", "worker", AT(role), CONFIG_ROLE_WORKER, "boss"},
    {"--queue-limit", "DRAPED_QUEUE_LIMIT", "7", AT(queue_limit), 7, "-1"},
    {"--max-body", "DRAPED_MAX_BODY", "2M", AT(max_body), 2 << 20, "2T"},
    {"--max-nodes", "DRAPED_MAX_NODES", "1000", AT(max_nodes), 1000, "1e3"},
    {"--max-control-points", "DRAPED_MAX_CONTROL_POINTS", "9", AT(max_control_points), 9, "262145"},
    {"--max-elements", "DRAPED_MAX_ELEMENTS", "999", AT(max_elements), 999, "many"},
    {"--max-depth", "DRAPED_MAX_DEPTH", "16", AT(max_depth), 16, "1001"},
    {"--job-timeout", "DRAPED_JOB_TIMEOUT", "60", AT(job_timeout), 60, "60s"},
    {"--import-timeout", "DRAPED_IMPORT_TIMEOUT", "90", AT(import_timeout), 90, "0"},
    {"--lease", "DRAPED_LEASE", "30", AT(lease), 30, "1"},
    {"--job-memory", "DRAPED_JOB_MEMORY", "1G", AT(job_memory), 1 << 30, "1k"},
    {"--max-result", "DRAPED_MAX_RESULT", "1M", AT(max_result), 1 << 20, "1"},
    {"--retention", "DRAPED_RETENTION", "24", AT(retention), 24, "0"},
    {"--max-connections", "DRAPED_MAX_CONNECTIONS", "16", AT(max_connections), 16, "15"},
    {"--drain-timeout", "DRAPED_DRAIN_TIMEOUT", "0", AT(drain_timeout), 0, "26"},
    {"--log-level", "DRAPED_LOG_LEVEL", "error", AT(log_level), LOG_LEVEL_ERROR, "loud"},
};

enum { NUMBERS = sizeof numbers / sizeof *numbers };

static int64_t value_of(const struct config *config, size_t k) {
    int64_t value = 0;
    memcpy(&value, (const char *)config + numbers[k].offset, sizeof value);
    return value;
}

static void test_config_takes_every_flag_in_both_spellings(void **state) {
    struct config config;
    (void)state;
    for (size_t k = 0; k < NUMBERS; k++) {
        char joined[100];
        assert_int_equal(parse(&config, numbers[k].flag, numbers[k].text, NULL, NULL), CONFIG_RUN);
        assert_int_equal(value_of(&config, k), numbers[k].value);
        snprintf(joined, sizeof joined, "%s=%s", numbers[k].flag, numbers[k].text);
        assert_int_equal(parse_one(&config, joined), CONFIG_RUN);
        assert_int_equal(value_of(&config, k), numbers[k].value);
    }
    assert_int_equal(parse(&config, "--data", "/x", "--store", "sqlite:y"), CONFIG_RUN);
    assert_string_equal(config.data, "/x");
    assert_string_equal(config.store, "sqlite:y");
}

static void test_config_takes_every_variable(void **state) {
    struct config config;
    (void)state;
    for (size_t k = 0; k < NUMBERS; k++) {
        setenv(numbers[k].variable, numbers[k].text, 1);
        assert_int_equal(parse(&config, NULL, NULL, NULL, NULL), CONFIG_RUN);
        assert_int_equal(value_of(&config, k), numbers[k].value);
        setenv(numbers[k].variable, "", 1); /* as good as none */
        assert_int_equal(parse(&config, NULL, NULL, NULL, NULL), CONFIG_RUN);
        unsetenv(numbers[k].variable);
    }
}

static void test_config_flag_wins_over_variable(void **state) {
    struct config config;
    (void)state;
    setenv("DRAPED_WORKERS", "5", 1);
    setenv("DRAPED_DATA", "/from-environment", 1);
    assert_int_equal(parse(&config, "--workers", "6", NULL, NULL), CONFIG_RUN);
    assert_int_equal(config.workers, 6);
    assert_string_equal(config.data, "/from-environment");
    unsetenv("DRAPED_WORKERS");
    unsetenv("DRAPED_DATA");
}

static void test_config_last_flag_wins(void **state) {
    struct config config;
    (void)state;
    assert_int_equal(parse(&config, "--workers", "6", "--workers", "7"), CONFIG_RUN);
    assert_int_equal(config.workers, 7);
}

static void test_config_names_a_bad_value(void **state) {
    struct config config;
    (void)state;
    for (size_t k = 0; k < NUMBERS; k++) {
        expect_bad(numbers[k].flag, numbers[k].bad, numbers[k].flag);
        expect_bad(numbers[k].flag, numbers[k].bad, numbers[k].bad);
        expect_bad(numbers[k].flag, "", numbers[k].flag);
        expect_bad(numbers[k].flag, NULL, "needs a value");
        setenv(numbers[k].variable, numbers[k].bad, 1);
        assert_int_equal(parse(&config, NULL, NULL, NULL, NULL), CONFIG_BAD);
        assert_non_null(strstr(err.text, numbers[k].variable));
        unsetenv(numbers[k].variable);
    }
    expect_bad("--workers", "99999999999999999999", "--workers");
    expect_bad("--max-body", "9223372036854775807G", "--max-body");
    expect_bad("--workers", " 3", "is not a number");
    expect_bad("--workers", "+3", "is not a number");
    expect_bad("--workers", "0x3", "is not a number");
    expect_bad("--allow-anonymous=yes", NULL, "neither 0 nor 1");
}

static void test_config_names_what_is_no_flag(void **state) {
    (void)state;
    expect_bad("--wrokers", "3", "'--wrokers'");
    expect_bad("workers", NULL, "'workers'");
    expect_bad("-w", NULL, "'-w'");
    expect_bad("--", NULL, "'--'");
}

static void test_config_reads_addresses(void **state) {
    struct config config;
    (void)state;
    static const char *const good[] = {"127.0.0.1:0", "127.9.9.9:65535", "localhost:8080",
                                       "[::1]:8080"};
    static const char *const bad[] = {"8080",           "127.0.0.1",       "127.0.0.1:",    ":8080",
                                      "127.0.0.1:x",    "127.0.0.1:65536", "::1:8080",      "[::1]",
                                      "example.org:80", "127.0.0.1:-1",    "127.0.0.1:80 ", ""};
    for (size_t k = 0; k < sizeof good / sizeof *good; k++) {
        assert_int_equal(parse(&config, "--listen", good[k], NULL, NULL), CONFIG_RUN);
        assert_true(config.loopback);
    }
    assert_int_equal(config.address.ss_family, AF_INET6);
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++)
        expect_bad("--listen", bad[k], "--listen");
}

static void test_config_keeps_strangers_out(void **state) {
    struct config config;
    (void)state;
    static const char *const open[] = {"0.0.0.0:80", "[::]:80", "192.168.0.1:80", "128.0.0.1:80"};
    for (size_t k = 0; k < sizeof open / sizeof *open; k++) {
        expect_bad("--listen", open[k], "--allow-anonymous");
        assert_int_equal(parse(&config, "--listen", open[k], "--allow-anonymous", NULL),
                         CONFIG_RUN);
        assert_false(config.loopback);
    }
    expect_bad("--tokens", "/nowhere", "/nowhere cannot be read: No such file");
    expect_bad("--store", "mysql://u:p@h/d", "give sqlite:PATH");
    assert_null(strstr(err.text, "u:p"));
    expect_bad("--store", "host=db user=u password=secret", "give sqlite:PATH");
    assert_null(strstr(err.text, "secret"));
    expect_bad("--store", "password = secret", "give sqlite:PATH");
    assert_int_equal(parse(&config, "--store", "./a=b.db", NULL, NULL), CONFIG_RUN);
    assert_int_equal(parse(&config, "--store", "sqlite:a.db", NULL, NULL), CONFIG_RUN);
    static const char *const stores[] = {"abc", "sqlite:", "a.db",
                                         "dbname=d host=/run password=secret",
                                         "POSTGRESQL://u:secret@h/d"};
    for (size_t k = 0; k < sizeof stores / sizeof *stores; k++) {
        expect_bad("--store", stores[k], "give sqlite:PATH");
        assert_null(strstr(err.text, "secret"));
    }
    expect_bad("postgresql://u:secret@h/d", NULL, "not a flag");
    assert_null(strstr(err.text, "secret"));
    expect_bad("--stroe=postgresql://u:secret@h/d", NULL, "not a flag");
    assert_null(strstr(err.text, "secret"));
    assert_int_equal(parse(&config, "--store", "postgresql://u:p@h/d", "--check-config", NULL),
                     CONFIG_DONE);
    assert_non_null(strstr(out.text, "store = (hidden)"));
    assert_null(strstr(out.text, "u:p"));
    expect_bad("--data=", NULL, "--data");
}

static void test_config_shares_no_store_of_an_empty_name(void **state) {
    struct config config;
    (void)state;
    setenv("DRAPED_STORE", "", 1);
    expect_bad("--role", "worker", "DRAPED_STORE is empty");
    expect_bad("--role", "api", "DRAPED_STORE is empty");
    assert_int_equal(parse(&config, "--role", "all", NULL, NULL), CONFIG_RUN);
    assert_int_equal(parse(&config, "--role=api", "--store=sqlite:a.db", NULL, NULL), CONFIG_RUN);
    unsetenv("DRAPED_STORE");
    assert_int_equal(parse(&config, "--listen", "*:80", "--allow-anonymous", NULL), CONFIG_RUN);
    assert_false(config.loopback);
    expect_bad("--listen", "*:80", "--allow-anonymous");
}

static void test_config_refuses_what_cannot_be(void **state) {
    struct config config;
    (void)state;
    static const char *const origins[] = {
        "https://a.example/",   "https://a.example/page", "a.example",           "https://",
        "https://a.example,,",  "https://a.example,b",    "https://a.example?q", "ftp://a.example",
        "https://a.example:1x", "https://u@a.example"};
    for (size_t k = 0; k < sizeof origins / sizeof *origins; k++)
        expect_bad("--cors-origin", origins[k], "--cors-origin");
    assert_int_equal(
        parse(&config, "--cors-origin", "https://a.example:8443,http://[::1]:80", NULL, NULL),
        CONFIG_RUN);
    assert_int_equal(parse(&config, "--cors-origin", "*", NULL, NULL), CONFIG_RUN);
    expect_bad("--max-bodies", "1K", "--max-bodies");
    expect_bad("--max-body=900M", "--max-bodies=899M", "than --max-body");
    expect_bad("--max-mesh=900M", "--max-bodies=899M", "than --max-mesh");
    expect_bad("--retention-jobs=9", "--retention=10", "--retention-jobs");
    assert_int_equal(parse(&config, "--retention-jobs=10", "--retention=10", NULL, NULL),
                     CONFIG_RUN);
}

static void test_config_answers_questions_on_stdout(void **state) {
    struct config config;
    (void)state;
    assert_int_equal(parse_one(&config, "--version"), CONFIG_DONE);
    assert_string_equal(out.text, "draped " DRAPE_VERSION "\n");
    assert_int_equal(parse(&config, "--workers", "bad", "--help", NULL), CONFIG_DONE);
    for (size_t k = 0; k < NUMBERS; k++) {
        assert_non_null(strstr(out.text, numbers[k].flag));
        assert_non_null(strstr(out.text, numbers[k].variable));
    }
    assert_int_equal(parse(&config, "--check-config", "--workers", "3", NULL), CONFIG_DONE);
    assert_non_null(strstr(out.text, "workers = 3\n"));
    assert_non_null(strstr(out.text, "role = all\n"));
    assert_string_equal(err.text, "");
    expect_bad("--check-config", "--workers=0", "--workers");
}

static void test_config_tells_its_limits_as_json(void **state) {
    struct config config;
    (void)state;
    assert_int_equal(parse(&config, "--max-body", "1M", NULL, NULL), CONFIG_RUN);
    char *text = config_limits_json(&config);
    json_t *json = json_loads(text, 0, NULL);
    assert_non_null(json);
    assert_int_equal(json_integer_value(json_object_get(json, "max_body")), 1 << 20);
    assert_true(json_is_integer(json_object_get(json, "max_nodes")));
    json_decref(json);
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_config_has_defaults),
        cmocka_unit_test(test_config_numbers_have_bounds),
        cmocka_unit_test(test_config_of_the_store_is_its_own_defaults),
        cmocka_unit_test(test_config_takes_every_flag_in_both_spellings),
        cmocka_unit_test(test_config_takes_every_variable),
        cmocka_unit_test(test_config_flag_wins_over_variable),
        cmocka_unit_test(test_config_last_flag_wins),
        cmocka_unit_test(test_config_names_a_bad_value),
        cmocka_unit_test(test_config_names_what_is_no_flag),
        cmocka_unit_test(test_config_reads_addresses),
        cmocka_unit_test(test_config_keeps_strangers_out),
        cmocka_unit_test(test_config_refuses_what_cannot_be),
        cmocka_unit_test(test_config_shares_no_store_of_an_empty_name),
        cmocka_unit_test(test_config_answers_questions_on_stdout),
        cmocka_unit_test(test_config_tells_its_limits_as_json),
    };
    for (size_t k = 0; k < NUMBERS; k++)
        unsetenv(numbers[k].variable);
    return cmocka_run_group_tests_name("config", tests, NULL, NULL);
}
