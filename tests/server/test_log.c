/* SPDX-License-Identifier: MIT */
/* The log: whatever it is given, each event is one line of JSON. */
#include "server/log.h"
#include "tests/store/capture.h"
#include "tests/store/scratch.h"
#include <jansson.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

static struct capture err;

/* The only line that was written, which must be JSON. */
static json_t *the_line(void) {
    capture_end(&err);
    char *end = strchr(err.text, '\n');
    assert_non_null(end);
    assert_int_equal(end[1], '\0');
    json_error_t error;
    json_t *json = json_loads(err.text, JSON_REJECT_DUPLICATES, &error);
    if (!json)
        fail_msg("%s in %s", error.text, err.text);
    return json;
}

static void test_log_writes_fields_in_order(void **state) {
    (void)state;
    capture_begin(&err, STDERR_FILENO);
    log_warning(log_event("job_failed"), log_text("job", "x"), log_int("attempts", 3),
                log_real("ms", 1.5), log_text("none", NULL), log_real("nan", (double)NAN));
    json_t *line = the_line();
    static const char *const names[] = {"time",     "level", "event", "job",
                                        "attempts", "ms",    "none",  "nan"};
    const char *key = NULL;
    json_t *value = NULL;
    size_t k = 0;
    json_object_foreach(line, key, value) assert_string_equal(key, names[k++]);
    assert_int_equal(k, 8);
    assert_string_equal(json_string_value(json_object_get(line, "level")), "warning");
    assert_string_equal(json_string_value(json_object_get(line, "event")), "job_failed");
    assert_int_equal(json_integer_value(json_object_get(line, "attempts")), 3);
    assert_true(json_real_value(json_object_get(line, "ms")) == 1.5);
    assert_true(json_is_null(json_object_get(line, "none")));
    assert_true(json_is_null(json_object_get(line, "nan")));
    json_decref(line);
}

static void test_log_escapes_any_bytes(void **state) {
    (void)state;
    uint64_t random = check_seed(1);
    for (int round = 0; round < 500; round++) {
        char text[700];
        size_t length = scratch_random(&random) % sizeof text;
        uint64_t few = round % 4 == 0 ? 40 : 255; /* mostly control characters, or anything */
        for (size_t k = 0; k < length; k++)
            text[k] = (char)(1 + scratch_random(&random) % few);
        text[length > 0 ? length - 1 : 0] = '\0';
        capture_begin(&err, STDERR_FILENO);
        log_error(log_event("noise"), log_text("text", text), log_int("after", round));
        json_t *line = the_line();
        assert_int_equal(json_integer_value(json_object_get(line, "after")), round);
        json_decref(line);
    }
}

static void test_log_keeps_what_is_readable(void **state) {
    (void)state;
    static const char text[] = "\"quoted\" back\\slash tab\t gr\xc3\xbc\xc3\x9f";
    capture_begin(&err, STDERR_FILENO);
    log_error(log_event("e"), log_text("text", text));
    json_t *line = the_line();
    assert_string_equal(json_string_value(json_object_get(line, "text")), text);
    json_decref(line);
}

static void test_log_cuts_long_lines(void **state) {
    (void)state;
    char text[1000];
    memset(text, 1, sizeof text - 1); /* six characters each when escaped */
    text[sizeof text - 1] = '\0';
    capture_begin(&err, STDERR_FILENO);
    log_error(log_event("e"), log_text("a", text), log_text("b", text), log_text("c", text),
              log_int("d", 1));
    json_t *line = the_line();
    assert_true(strlen(err.text) <= 4096);
    json_decref(line);
}

static void test_log_omits_what_is_below_the_level(void **state) {
    (void)state;
    log_init(LOG_LEVEL_WARNING);
    capture_begin(&err, STDERR_FILENO);
    log_debug(log_event("e"));
    log_info(log_event("e"));
    capture_end(&err);
    assert_string_equal(err.text, "");
    log_init(LOG_LEVEL_INFO);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_log_writes_fields_in_order),
        cmocka_unit_test(test_log_escapes_any_bytes),
        cmocka_unit_test(test_log_keeps_what_is_readable),
        cmocka_unit_test(test_log_cuts_long_lines),
        cmocka_unit_test(test_log_omits_what_is_below_the_level),
    };
    return cmocka_run_group_tests_name("log", tests, NULL, NULL);
}
