/* SPDX-License-Identifier: MIT */
/* The rounds of a study: its tasks, and the numbers they give. */
#include "postgres.h"
#include "server/store/seal.h"
#include "server/store/sql.h"
#include <stdio.h>
#include <stdlib.h>

/* ------------------------------------------------------------------ begin */

/* $4 tasks, of as many bytes each in $5; $6 and $7, lists with commas, have their ids and variants;
 * $10 is what was found so far, with its seal. */
static const char begin_sql[] =
    "WITH waits AS (UPDATE draped.jobs SET status = " SQL_WAITING ", round = round + 1,"
    "  open = $4::integer, done = $8, total = $9, summary = $10, summary_seal = $11,"
    "  attempts = 0, excused = 0, lease = NULL WHERE $1::bigint IS DISTINCT FROM 0 "
    "AND" POSTGRES_HELD
    "  RETURNING sequence, rank, priority, owner, surface, origin, created, round),"
    " lists AS MATERIALIZED (SELECT string_to_array($6, ',') AS ids,"
    "  ('{' || $7 || '}')::bigint[] AS variants, (octet_length($5) / $4)::integer AS size),"
    " made AS (INSERT INTO draped.jobs (id, status, rank, priority, owner, digest, surface,"
    "   origin, created, kind, parent, round, position, total, task)"
    "  SELECT ids[k], " SQL_QUEUED ", rank, priority, owner, '', surface, origin, created,"
    "   " SQL_TASK ", sequence, round, k - 1, variants[k],"
    "   substring($5 FROM (k - 1) * size + 1 FOR size)"
    "  FROM waits, lists, generate_series(1, $4::integer) k)"
    " SELECT 1, " POSTGRES_LAZY " FROM waits";

enum store_answer postgres_begin_round(struct store *store, const struct store_claim *claim,
                                       const struct store_round *round) {
    enum { NUMBER_SIZE = 21 };
    char *ids = malloc(round->count * ID_SIZE), *variants = malloc(round->count * NUMBER_SIZE);
    char *next = variants;
    for (size_t k = 0; ids && variants && k < round->count; k++) {
        const char *comma = k + 1 < round->count ? "," : "";
        id_make(ids + k * ID_SIZE);
        ids[k * ID_SIZE + ID_SIZE - 1] = *comma;
        next += snprintf(next, NUMBER_SIZE, "%lld%s", (long long)round->variants[k], comma);
    }
    struct query query = postgres_held_query(store, begin_sql, claim);
    query_bind(&query, of_int((int64_t)round->count),
               of_bytes(round->tasks, round->count * round->length), of_text(ids),
               of_text(variants), of_int(round->done), of_int(round->total), of_text(round->best),
               of_int(seal_of_text(round->best)));
    enum store_answer answer = ids && variants ? query_find(&query, STORE_CONFLICT) : STORE_DOWN;
    free(ids);
    free(variants);
    return answer;
}

/* ------------------------------------------------------------------ end */

enum store_answer postgres_end_task(struct store *store, const struct store_claim *claim,
                                    const void *numbers, size_t length, int64_t spent) {
    struct query query = postgres_held_query(
        store,
        "WITH ended AS (UPDATE draped.jobs SET status = " SQL_SUCCEEDED ", finished ="
        " " POSTGRES_NOW ", spent = $5, lease = NULL, task = NULL WHERE" POSTGRES_HELD
        " RETURNING parent, round, position),"
        " kept AS (INSERT INTO draped.task_numbers (parent, round, position, seal, bytes)"
        "  SELECT parent, round, position, $6, $4 FROM ended)"
        " SELECT 1, " POSTGRES_LAZY " FROM ended",
        claim);
    query_bind(&query, of_bytes(numbers, length), of_int(spent),
               of_int(seal_of_numbers(claim->parent, numbers, length)));
    return query_find(&query, STORE_CONFLICT);
}
