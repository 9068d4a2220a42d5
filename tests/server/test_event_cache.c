/* SPDX-License-Identifier: MIT */
/* What event streams share: a look serves those who need no later one, and nobody else. */
#include "server/clock.h"
#include "server/resources/event_cache.h"
#include "tests/store/scratch.h"
#include <stdlib.h>
#include <string.h>

static enum store_status status_since(struct scratch *scratch, const char *id, int64_t since) {
    struct store_job job;
    char *document = NULL;
    assert_int_equal(event_cache_look(scratch->store, id, since, &job, &document), STORE_OK);
    assert_non_null(document);
    assert_non_null(strstr(document, store_status_name(job.status)));
    assert_non_null(strstr(document, id));
    free(document);
    return job.status;
}

static void test_event_cache_shares_a_look(void **state) {
    struct scratch scratch;
    struct store_job job;
    char id[ID_SIZE], other[ID_SIZE], *document = NULL;
    (void)state;
    scratch_open(&scratch);
    scratch_submit(&scratch, "one", id);
    scratch_submit(&scratch, "other", other);
    int64_t before = clock_us();
    assert_int_equal(status_since(&scratch, id, before), STORE_QUEUED);
    assert_int_equal(store_cancel(scratch.store, id), STORE_OK);
    assert_int_equal(status_since(&scratch, id, before), STORE_QUEUED); /* the same look */
    assert_int_equal(status_since(&scratch, other, before), STORE_QUEUED);
    scratch_sleep(2);
    int64_t after = clock_us();
    assert_int_equal(status_since(&scratch, id, after), STORE_CANCELLED);
    assert_int_equal(status_since(&scratch, id, before), STORE_CANCELLED);
    assert_int_equal(store_delete(scratch.store, id), STORE_OK);
    scratch_sleep(2);
    assert_int_equal(event_cache_look(scratch.store, id, clock_us(), &job, &document), STORE_EMPTY);
    scratch_remove(&scratch);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_event_cache_shares_a_look)};
    return cmocka_run_group_tests_name("event cache", tests, NULL, NULL);
}
