/* SPDX-License-Identifier: MIT */
/* The hub and the cache of chunks: small, but used by all threads at once. */
#include "scratch.h"
#include "server/hub.h"
#include "server/store/cache.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static void count_call(void *context) {
    atomic_fetch_add((atomic_int *)context, 1);
}

static void test_hub_wakes_those_who_watch_the_subject(void **state) {
    (void)state;
    struct hub *hub = hub_new();
    struct hub_watch first, second, other;
    atomic_int calls[3] = {0};
    hub_notify(hub, "a", HUB_CHANGE);
    hub_subscribe(hub, &first, "a", HUB_CHANGE, count_call, &calls[0]);
    hub_subscribe(hub, &second, "a", HUB_CHANGE, count_call, &calls[1]);
    hub_subscribe(hub, &other, "b", HUB_CHANGE, count_call, &calls[2]);
    hub_notify(hub, "a", HUB_CHANGE);
    hub_unsubscribe(hub, &first);
    hub_notify(hub, "a", HUB_CHANGE);
    hub_unsubscribe(hub, &second);
    hub_unsubscribe(hub, &other);
    hub_notify(hub, "a", HUB_CHANGE);
    assert_int_equal(calls[0], 1);
    assert_int_equal(calls[1], 2);
    assert_int_equal(calls[2], 0);
    hub_free(hub);
}

/* In every order of leaving, the list stays whole. */
static void test_hub_list_survives_any_order(void **state) {
    (void)state;
    enum { WATCHES = 40 };
    struct hub *hub = hub_new();
    struct hub_watch watches[WATCHES];
    atomic_int calls = 0;
    bool there[WATCHES] = {false};
    uint64_t random = check_seed(1);
    int expected = 0;
    for (int round = 0; round < 5000; round++) {
        size_t k = scratch_random(&random) % WATCHES;
        if (there[k])
            hub_unsubscribe(hub, &watches[k]);
        else
            hub_subscribe(hub, &watches[k], "same", HUB_CHANGE, count_call, &calls);
        there[k] = !there[k];
        for (size_t n = 0; n < WATCHES; n++)
            expected += there[n];
        hub_notify(hub, "same", HUB_CHANGE);
        assert_int_equal(calls, expected);
    }
    for (size_t k = 0; k < WATCHES; k++)
        if (there[k])
            hub_unsubscribe(hub, &watches[k]);
    hub_free(hub);
}

/* Each is told of what it asked for and of all that is listed before that. */
static void test_hub_tells_news_to_those_who_asked(void **state) {
    (void)state;
    struct hub *hub = hub_new();
    struct hub_watch watches[HUB_PROGRESS + 1];
    atomic_int calls[HUB_PROGRESS + 1] = {0};
    for (int least = HUB_CHANGE; least <= HUB_PROGRESS; least++)
        hub_subscribe(hub, &watches[least], "a", (enum hub_news)least, count_call, &calls[least]);
    for (int news = HUB_CHANGE; news <= HUB_PROGRESS; news++) {
        hub_notify(hub, "a", (enum hub_news)news);
        for (int least = HUB_CHANGE; least <= HUB_PROGRESS; least++)
            assert_int_equal(atomic_exchange(&calls[least], 0), least >= news);
    }
    for (int least = HUB_CHANGE; least <= HUB_PROGRESS; least++)
        hub_unsubscribe(hub, &watches[least]);
    hub_free(hub);
}

struct noise {
    struct hub *hub;
    atomic_bool stop;
};

static void *notify_all_the_time(void *context) {
    struct noise *noise = context;
    while (!atomic_load(&noise->stop))
        hub_notify(noise->hub, "x", HUB_CHANGE);
    return NULL;
}

/* After unsubscribing nobody touches the watch: its memory is used for something else at once. */
static void test_hub_does_not_wake_after_unsubscribe(void **state) {
    (void)state;
    struct noise noise = {.hub = hub_new()};
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, notify_all_the_time, &noise), 0);
    for (int k = 0; k < 2000; k++) {
        struct hub_watch watch;
        atomic_int *calls = calloc(1, sizeof *calls);
        hub_subscribe(noise.hub, &watch, "x", HUB_CHANGE, count_call, calls);
        hub_unsubscribe(noise.hub, &watch);
        memset(&watch, 0xff, sizeof watch);
        free(calls);
    }
    atomic_store(&noise.stop, true);
    pthread_join(thread, NULL);
    hub_free(noise.hub);
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
    return cmocka_run_group_tests_name("hub and cache", tests, NULL, NULL);
}
