/* SPDX-License-Identifier: MIT */
/* Job events and the cache of chunks: small, but used by all threads at once. */
#include "server/job_events.h"
#include "server/store/cache.h"
#include "tests/store/scratch.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static void count_call(void *context) {
    atomic_fetch_add((atomic_int *)context, 1);
}

static void test_hub_wakes_those_who_watch_the_subject(void **state) {
    (void)state;
    struct job_events *events = job_events_new();
    struct job_watch first, second, other;
    atomic_int calls[3] = {0};
    job_events_notify(events, "a", JOB_CHANGED);
    job_events_subscribe(events, &first, "a", JOB_CHANGED, count_call, &calls[0]);
    job_events_subscribe(events, &second, "a", JOB_CHANGED, count_call, &calls[1]);
    job_events_subscribe(events, &other, "b", JOB_CHANGED, count_call, &calls[2]);
    job_events_notify(events, "a", JOB_CHANGED);
    job_events_unsubscribe(events, &first);
    job_events_notify(events, "a", JOB_CHANGED);
    job_events_unsubscribe(events, &second);
    job_events_unsubscribe(events, &other);
    job_events_notify(events, "a", JOB_CHANGED);
    assert_int_equal(calls[0], 1);
    assert_int_equal(calls[1], 2);
    assert_int_equal(calls[2], 0);
    job_events_free(events);
}

/* In every order of leaving, the list stays whole. */
static void test_hub_list_survives_any_order(void **state) {
    (void)state;
    enum { WATCHES = 40 };
    struct job_events *events = job_events_new();
    struct job_watch watches[WATCHES];
    atomic_int calls = 0;
    bool there[WATCHES] = {false};
    uint64_t random = check_seed(1);
    int expected = 0;
    for (int round = 0; round < 5000; round++) {
        size_t k = scratch_random(&random) % WATCHES;
        if (there[k])
            job_events_unsubscribe(events, &watches[k]);
        else
            job_events_subscribe(events, &watches[k], "same", JOB_CHANGED, count_call, &calls);
        there[k] = !there[k];
        for (size_t n = 0; n < WATCHES; n++)
            expected += there[n];
        job_events_notify(events, "same", JOB_CHANGED);
        assert_int_equal(calls, expected);
    }
    for (size_t k = 0; k < WATCHES; k++)
        if (there[k])
            job_events_unsubscribe(events, &watches[k]);
    job_events_free(events);
}

/* Each is told of what it asked for and of all that is listed before that. */
static void test_hub_tells_news_to_those_who_asked(void **state) {
    (void)state;
    struct job_events *events = job_events_new();
    struct job_watch watches[JOB_PROGRESSED + 1];
    atomic_int calls[JOB_PROGRESSED + 1] = {0};
    for (int least = JOB_CHANGED; least <= JOB_PROGRESSED; least++)
        job_events_subscribe(events, &watches[least], "a", (enum job_event)least, count_call,
                             &calls[least]);
    for (int news = JOB_CHANGED; news <= JOB_PROGRESSED; news++) {
        job_events_notify(events, "a", (enum job_event)news);
        for (int least = JOB_CHANGED; least <= JOB_PROGRESSED; least++)
            assert_int_equal(atomic_exchange(&calls[least], 0), least >= news);
    }
    for (int least = JOB_CHANGED; least <= JOB_PROGRESSED; least++)
        job_events_unsubscribe(events, &watches[least]);
    job_events_free(events);
}

struct noise {
    struct job_events *events;
    atomic_bool stop;
};

static void *notify_all_the_time(void *context) {
    struct noise *noise = context;
    while (!atomic_load(&noise->stop))
        job_events_notify(noise->events, "x", JOB_CHANGED);
    return NULL;
}

/* After unsubscribing nobody touches the watch: its memory is used for something else at once. */
static void test_hub_does_not_wake_after_unsubscribe(void **state) {
    (void)state;
    struct noise noise = {.events = job_events_new()};
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, notify_all_the_time, &noise), 0);
    for (int k = 0; k < 2000; k++) {
        struct job_watch watch;
        atomic_int *calls = calloc(1, sizeof *calls);
        job_events_subscribe(noise.events, &watch, "x", JOB_CHANGED, count_call, calls);
        job_events_unsubscribe(noise.events, &watch);
        memset(&watch, 0xff, sizeof watch);
        free(calls);
    }
    atomic_store(&noise.stop, true);
    pthread_join(thread, NULL);
    job_events_free(noise.events);
}

/* ------------------------------------------------------------------ the cache */

static void put(struct store_cache *cache, int64_t number, int64_t index) {
    unsigned char *bytes = malloc(100);
    memset(bytes, (int)(number * 16 + index), 100);
    store_cache_put(cache, number, index, bytes, 100);
}

static bool here(struct store_cache *cache, int64_t number, int64_t index) {
    unsigned char bytes[100];
    if (!store_cache_read(cache, number, index, 0, bytes, 100))
        return false;
    for (size_t k = 0; k < sizeof bytes; k++)
        assert_int_equal(bytes[k], (unsigned char)(number * 16 + index));
    return true;
}

static void test_store_cache_keeps_the_chunks_used_last(void **state) {
    (void)state;
    struct store_cache *cache = store_cache_new();
    assert_false(here(cache, 1, 0));
    for (int64_t k = 0; k < 10000; k++) {
        put(cache, 1, 0); /* again: takes no further room */
        put(cache, 2, k);
        assert_true(here(cache, 1, 0));
        assert_true(here(cache, 2, k));
    }
    int kept = 0;
    for (int64_t k = 0; k < 10000; k++)
        kept += here(cache, 2, k);
    assert_in_range(kept, 25, 64);
    store_cache_free(cache);
}

static void test_store_cache_reads_within_the_chunk_only(void **state) {
    (void)state;
    struct store_cache *cache = store_cache_new();
    unsigned char bytes[200];
    put(cache, 1, 0);
    assert_true(store_cache_read(cache, 1, 0, 100, bytes, 0));
    assert_true(store_cache_read(cache, 1, 0, 99, bytes, 1));
    assert_false(store_cache_read(cache, 1, 0, 99, bytes, 2));
    assert_false(store_cache_read(cache, 1, 0, 101, bytes, 0));
    assert_false(store_cache_read(cache, 1, 0, 1, bytes, SIZE_MAX));
    store_cache_free(cache);
}

static void *use_cache(void *context) {
    uint64_t random = (uint64_t)(uintptr_t)pthread_self();
    for (int k = 0; k < 20000; k++) {
        int64_t index = (int64_t)(scratch_random(&random) % 1000);
        if (!here(context, 3, index))
            put(context, 3, index);
    }
    return NULL;
}

static void test_store_cache_is_safe_from_any_thread(void **state) {
    (void)state;
    struct store_cache *cache = store_cache_new();
    pthread_t threads[4];
    for (int k = 0; k < 4; k++)
        assert_int_equal(pthread_create(&threads[k], NULL, use_cache, cache), 0);
    for (int k = 0; k < 4; k++)
        pthread_join(threads[k], NULL);
    store_cache_free(cache);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_hub_wakes_those_who_watch_the_subject),
        cmocka_unit_test(test_hub_list_survives_any_order),
        cmocka_unit_test(test_hub_tells_news_to_those_who_asked),
        cmocka_unit_test(test_hub_does_not_wake_after_unsubscribe),
        cmocka_unit_test(test_store_cache_keeps_the_chunks_used_last),
        cmocka_unit_test(test_store_cache_reads_within_the_chunk_only),
        cmocka_unit_test(test_store_cache_is_safe_from_any_thread),
    };
    return cmocka_run_group_tests_name("job events and cache", tests, NULL, NULL);
}
