/* SPDX-License-Identifier: MIT */
/* What of the store needs no database: cursors, the cache of chunks, the comparison of clocks,
 * seals, what a query does of its own, names, URLs and versions, and what two copies hold. */
#include "server/store/backend.h"
#include "server/store/backup.h"
#include "server/store/cache.h"
#include "server/store/clock_check.h"
#include "server/store/cursor.h"
#include "server/store/postgres/notify.h"
#include "server/store/query.h"
#include "server/store/seal.h"
#include "tests/check.h"
#include <stdbool.h>
#include <string.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* ------------------------------------------------------------------ cursors */

static void make_secret(unsigned char secret[CURSOR_SECRET_BYTES]) {
    for (int k = 0; k < CURSOR_SECRET_BYTES; k++)
        secret[k] = (unsigned char)k;
}

/* A Feistel network over SipHash-2-4 and BLAKE2b that was written for this table alone, in Python.
 */
static void test_cursor_is_the_network_that_it_says(void **state) {
    static const struct {
        const char *owner;
        int64_t position, cursor;
    } rows[] = {
        {NULL, 1, 620189898130933815},
        {NULL, 2, 718416242101918621},
        {NULL, 1000, 4052496789145405697},
        {NULL, (INT64_C(1) << 62) - 1, 2998414940318759257},
        {"", 1, 3556515334057039357},
        {"", (INT64_C(1) << 62) - 1, 2918115231740385944},
        {"anna", 1, 1482747412306364263},
        {"anna", 2, 3867868975936125960},
        {"anna", (INT64_C(1) << 62) - 1, 705789912586027830},
    };
    unsigned char secret[CURSOR_SECRET_BYTES];
    (void)state;
    make_secret(secret);
    for (size_t k = 0; k < COUNT(rows); k++) {
        assert_true(cursor_seal(secret, rows[k].owner, rows[k].position) == rows[k].cursor);
        assert_true(cursor_open(secret, rows[k].owner, rows[k].cursor) == rows[k].position);
    }
}

static void test_cursor_opens_what_it_sealed(void **state) {
    static const int64_t none[] = {0, -1, INT64_MIN, INT64_C(1) << 62, INT64_MAX};
    static const int64_t no_cursor[] = {0, -1, INT64_MIN, (INT64_C(1) << 62) + 1, INT64_MAX};
    unsigned char secret[CURSOR_SECRET_BYTES];
    (void)state;
    make_secret(secret);
    for (int64_t step = 1; step < INT64_C(1) << 62; step += step / 3 + 1) {
        int64_t cursor = cursor_seal(secret, "bert", step);
        assert_true(cursor >= 1 && cursor <= INT64_C(1) << 62);
        assert_true(cursor_open(secret, "bert", cursor) == step);
        assert_false(cursor_open(secret, "anna", cursor) == step);
    }
    for (size_t k = 0; k < COUNT(none); k++) {
        assert_int_equal(cursor_seal(secret, "bert", none[k]), 0);
        assert_int_equal(cursor_open(secret, "bert", no_cursor[k]), 0);
    }
    assert_true(cursor_open(secret, "bert", INT64_C(1) << 62) >= 0); /* some other position */
}

/* ------------------------------------------------------------------ tries to connect */

static void test_tries_to_listen_are_ever_further_apart(void **state) {
    static const int pauses[] = {250, 500, 1000, 2000, 4000, 8000, 8000, 8000};
    (void)state;
    for (size_t k = 0; k < COUNT(pauses); k++)
        assert_int_equal(notify_pause_ms((int)k), pauses[k]);
}

/* ------------------------------------------------------------------ the cache */

enum { LENGTH = 10, ALL = 64 };

static void put_chunk(struct store_cache *cache, int64_t number, int64_t index, int letter) {
    unsigned char *bytes = malloc(LENGTH);
    assert_non_null(bytes);
    for (int k = 0; k < LENGTH; k++)
        bytes[k] = (unsigned char)(letter + k);
    store_cache_put(cache, number, index, bytes, LENGTH);
}

/* The first byte of a chunk that is there; -1 without. */
static int first_of(struct store_cache *cache, int64_t number, int64_t index) {
    unsigned char bytes[LENGTH];
    return store_cache_read(cache, number, index, 0, bytes, LENGTH) ? bytes[0] : -1;
}

static void test_cache_reads_parts_within_a_chunk(void **state) {
    static const struct {
        size_t offset, length;
        bool within;
    } rows[] = {{0, LENGTH, true},  {0, LENGTH + 1, false}, {LENGTH, 0, true},
                {LENGTH, 1, false}, {LENGTH + 1, 0, false}, {LENGTH - 1, 1, true},
                {3, 4, true},       {3, SIZE_MAX, false},   {SIZE_MAX, 1, false}};
    struct store_cache *cache = store_cache_new();
    (void)state;
    put_chunk(cache, 1, 0, 'a');
    for (size_t k = 0; k < COUNT(rows); k++) {
        char bytes[LENGTH] = "";
        assert_int_equal(store_cache_read(cache, 1, 0, rows[k].offset, bytes, rows[k].length),
                         rows[k].within);
        if (rows[k].within)
            assert_memory_equal(bytes, "abcdefghij" + rows[k].offset, rows[k].length);
    }
    assert_int_equal(first_of(cache, 1, 1), -1);
    assert_int_equal(first_of(cache, 2, 0), -1);
    put_chunk(cache, 1, 0, 'b'); /* in its own place */
    assert_int_equal(first_of(cache, 1, 0), 'b');
    store_cache_free(cache);
    store_cache_free(NULL);
}

/* As many as it holds, of one result and of results one after the other; then that goes which was
 * used longest ago. */
static void test_cache_keeps_what_was_used_last(void **state) {
    (void)state;
    for (int of_one = 0; of_one < 2; of_one++) {
        struct store_cache *cache = store_cache_new();
        for (int k = 0; k < ALL; k++)
            put_chunk(cache, of_one ? 1 : 1 + k, of_one ? k : 0, k);
        for (int k = 0; k < ALL; k++)
            assert_int_equal(first_of(cache, of_one ? 1 : 1 + k, of_one ? k : 0), k);
        store_cache_free(cache);
    }
    struct store_cache *cache = store_cache_new();
    for (int k = 0; k < ALL; k++)
        put_chunk(cache, 1, k, k);
    assert_int_equal(first_of(cache, 1, 0), 0);
    assert_int_equal(first_of(cache, 1, 16), 16);
    static const int gone[] = {8, 24, 32, 40, 48, 56, 0, 16}; /* all of one set, in this order */
    for (int k = 0; k < 8; k++) {
        put_chunk(cache, 1, ALL + 8 * k, ALL);
        assert_int_equal(first_of(cache, 1, gone[k]), -1);
    }
    for (int k = 0; k < ALL; k++)
        assert_int_equal(first_of(cache, 1, k), k % 8 ? k : -1);
    for (int k = 0; k < 8; k++)
        assert_int_equal(first_of(cache, 1, ALL + 8 * k), ALL);
    store_cache_free(cache);
}

/* ------------------------------------------------------------------ clocks */

static void test_clocks_that_part_have_jumped(void **state) {
    static const struct {
        int64_t wall, own, jumps, agreed;
    } looks[] = {
        {5000000, 100, 0, 0},               /* the first look */
        {6000000, 1000100, 0, 1000000},     /* both a second on */
        {9000000, 2000100, 0, 2000000},     /* two seconds apart: slow to answer */
        {9000001 + 3000000, 3000100, 1, 0}, /* beyond that: set forward */
        {13000001, 4000100, 1, 1000000},
        {12000001, 5000100, 1, 2000000}, /* back by two seconds */
        {11000000, 6000100, 2, 0},       /* by more */
        {12000000, 7000100, 2, 1000000},
    };
    struct clock_check clocks = {0};
    (void)state;
    for (size_t k = 0; k < COUNT(looks); k++) {
        clock_check_compare(&clocks, looks[k].wall, looks[k].own);
        if (clocks.jumps != looks[k].jumps || clock_check_agreed_us(&clocks) != looks[k].agreed)
            fail_msg("look %zu: %d jumps, agreed for %d us", k, (int)clocks.jumps,
                     (int)clock_check_agreed_us(&clocks));
        assert_true(clocks.wall_us == looks[k].wall && clocks.own_us == looks[k].own);
    }
}

/* ------------------------------------------------------------------ seals */

/* What is stored must be known for what it was by later versions: XXH3, each part's hash the seed
 * of the next, by a program that called the library itself. */
static void test_seals_stay_as_they_are(void **state) {
    const struct seal_chunk chunk = {7, 11, 3, true};
    char definition[] = "def", about[] = "about";
    const struct store_item item = {
        .id = "item", .definition = definition, .definition_length = 3, .description = about};
    (void)state;
    assert_true(seal_of_chunk(&chunk, "bytes", 5) == 4409371145879860111);
    assert_true(seal_of_request("id", "bytes", 5) == 5686041697031069912);
    assert_true(seal_of_numbers("id", "bytes", 5) == 5686041697031069912);
    assert_true(seal_of_text("text") == 5145922347574273553);
    assert_true(seal_of_item(&item) == 3852158523131370618);
}

/* ------------------------------------------------------------------ queries */

/* The sanitizers' allocators say no as others do. */
const char *__asan_default_options(void), *__tsan_default_options(void);
const char *__asan_default_options(void) {
    return "allocator_may_return_null=1";
}
const char *__tsan_default_options(void) {
    return "allocator_may_return_null=1";
}

/* Null, a text, and one that no memory has room for. */
static struct query_value column_of_three(const struct query *query, int column) {
    const struct query_value columns[] = {of_text(NULL), of_text("text"),
                                          of_bytes("", SIZE_MAX / 2)};
    (void)query;
    return columns[column];
}

static bool there_is_a_row(struct query *query) {
    (void)query;
    return true;
}

static enum store_answer ends_well(struct query *query) {
    (void)query;
    return STORE_OK;
}

/* And then it goes no further, whatever can be copied after it. */
static void test_query_fails_without_memory(void **state) {
    const struct query_driver driver = {there_is_a_row, column_of_three, ends_well};
    (void)state;
    for (int column = 0; column < 3; column++) {
        struct query query = {.driver = &driver};
        const bool good = column < 2;
        char *copy = NULL, *text = NULL;
        size_t length = 0;
        query_duplicate(&query, column, &copy, &length);
        query_duplicate(&query, 1, &text, &length);
        assert_int_equal(copy != NULL, column == 1);
        assert_string_equal(text, "text");
        assert_int_equal(length, 4);
        assert_int_equal(query_row(&query), good);
        assert_int_equal(query_end(&query), good ? STORE_OK : STORE_DOWN);
        free(copy);
        free(text);
    }
}

/* ------------------------------------------------------------------ names, URLs, versions */

static void test_store_urls_name_their_kind(void **state) {
    static const struct {
        const char *url, *path;
        bool remote;
    } rows[] = {{"postgresql://a/b", "postgresql://a/b", true},
                {"postgres://a", "postgres://a", true},
                {"postgres:/a", "postgres:/a", false},
                {"postgresql:a", "postgresql:a", false},
                {"sqlite:a/b.db", "a/b.db", false},
                {"sqlite:", "", false},
                {"sqlite", "sqlite", false},
                {"/a/b.db", "/a/b.db", false}};
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        assert_int_equal(store_url_remote(rows[k].url), rows[k].remote);
        assert_string_equal(store_url_path(rows[k].url), rows[k].path);
    }
    assert_string_equal(store_answer_name(STORE_OK), "ok");
    assert_string_equal(store_answer_name(STORE_FULL), "full");
    assert_string_equal(store_answer_name(STORE_ALTERED), "altered");
    assert_string_equal(store_answer_name(STORE_NO_SPACE), "out of disk space");
}

static void test_store_schema_has_one_version(void **state) {
    char why[STORE_WHY_SIZE] = "";
    (void)state;
    assert_true(store_schema_known("it", STORE_SCHEMA, why));
    assert_string_equal(why, "");
    assert_false(store_schema_known("it", STORE_SCHEMA + 1, why));
    assert_non_null(strstr(why, "use a newer one"));
    assert_false(store_schema_known("it", STORE_SCHEMA - 1, why));
    assert_non_null(strstr(why, "older version that made it"));
}

/* A week for results, four for records, and a minute for claims, in microseconds. */
static void test_store_options_have_their_defaults(void **state) {
    const struct store_options *own = &store_options_default;
    const int64_t day = INT64_C(86400000000);
    (void)state;
    assert_int_equal(own->retention_us, 7 * day);
    assert_int_equal(own->records_us, 28 * day);
    assert_int_equal(own->lease_us, 60000000);
    assert_int_equal(own->clock_trust_us, 300000000);
    assert_int_equal(own->queue_limit, 10000);
    assert_int_equal(own->max_attempts, 3);
    assert_int_equal(own->busy_ms, 5000);
}

/* ------------------------------------------------------------------ copies */

/* Tables in any order; which differs is said. */
static void test_backup_contents_are_compared(void **state) {
    const struct backup_contents own = {
        .schema = 3, .count = 2, .tables = {{"a", 1, "sum of a"}, {"b", 2, "sum of b"}}};
    struct backup_contents other = {
        .schema = 3, .count = 2, .tables = {{"b", 2, "sum of b"}, {"a", 1, "sum of a"}}};
    char why[STORE_WHY_SIZE] = "", time[BACKUP_TIME_SIZE];
    (void)state;
    assert_true(backup_same(&other, &own, why));
    assert_int_equal(backup_rows(&other, "a"), 1);
    assert_int_equal(backup_rows(&other, "b"), 2);
    assert_int_equal(backup_rows(&other, "c"), 0);
    other.tables[0].rows = 3;
    assert_false(backup_same(&other, &own, why));
    assert_non_null(strstr(why, "'b' of the copy differs from that of the store: it has 3 of 2"));
    other.tables[0].rows = 2;
    other.tables[1].checksum[0] = 'S';
    assert_false(backup_same(&other, &own, why));
    assert_non_null(strstr(why, "'a'"));
    other.tables[1] = (struct backup_table){"c", 1, "sum of a"};
    assert_false(backup_same(&other, &own, why));
    assert_non_null(strstr(why, "'a' of the copy differs from that of the store: it has 0 of 1"));
    other = own;
    other.count = 1;
    assert_false(backup_same(&other, &own, why));
    other = own;
    other.schema = 4;
    assert_false(backup_same(&other, &own, why));
    assert_string_equal(why, "the copy does not have the tables of the store");
    backup_time(time);
    assert_int_equal(strlen(time), 20);
    assert_true(time[8] == 'T' && time[15] == '.' && time[19] == 'Z');
    assert_int_equal(strspn(time, "0123456789"), 8);
}

/* ------------------------------------------------------------------ segments */

/* Its chunks are full but the last; that is sealed as the last one if the segment is. */
static void test_segments_have_full_chunks_but_the_last(void **state) {
    enum { CHUNK = STORE_CHUNK_BYTES };
    static const struct {
        size_t length, lengths[3];
        size_t last; /* the chunk that is the last one */
    } rows[] = {{1, {1, 0, 0}, 0},
                {CHUNK - 1, {CHUNK - 1, 0, 0}, 0},
                {CHUNK, {CHUNK, 0, 0}, 0},
                {CHUNK + 1, {CHUNK, 1, 0}, 1},
                {2 * CHUNK, {CHUNK, CHUNK, 0}, 1}};
    static unsigned char bytes[CHUNK];
    const struct store_claim claim = {.sequence = 7, .token = 11};
    unsigned char *chunks[] = {bytes, bytes, bytes};
    (void)state;
    for (size_t k = 0; k < COUNT(rows); k++) {
        struct store_segment segment = {
            .claim = &claim, .index = 32, .chunks = chunks, .length = rows[k].length, .last = true};
        for (size_t n = 0; n < 3; n++) {
            const size_t length = rows[k].lengths[n];
            assert_int_equal(segment_chunk_length(&segment, n), length);
            struct seal_chunk chunk = {7, 11, 32 + (int64_t)n, n >= rows[k].last};
            segment.last = true;
            assert_true(segment_seal(&segment, n) == seal_of_chunk(&chunk, bytes, length));
            segment.last = chunk.last = false;
            assert_true(segment_seal(&segment, n) == seal_of_chunk(&chunk, bytes, length));
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cursor_is_the_network_that_it_says),
        cmocka_unit_test(test_cursor_opens_what_it_sealed),
        cmocka_unit_test(test_tries_to_listen_are_ever_further_apart),
        cmocka_unit_test(test_cache_reads_parts_within_a_chunk),
        cmocka_unit_test(test_cache_keeps_what_was_used_last),
        cmocka_unit_test(test_clocks_that_part_have_jumped),
        cmocka_unit_test(test_seals_stay_as_they_are),
        cmocka_unit_test(test_query_fails_without_memory),
        cmocka_unit_test(test_store_urls_name_their_kind),
        cmocka_unit_test(test_store_schema_has_one_version),
        cmocka_unit_test(test_store_options_have_their_defaults),
        cmocka_unit_test(test_backup_contents_are_compared),
        cmocka_unit_test(test_segments_have_full_chunks_but_the_last),
    };
    return cmocka_run_group_tests_name("store parts", tests, NULL, NULL);
}
