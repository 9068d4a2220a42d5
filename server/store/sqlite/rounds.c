/* SPDX-License-Identifier: MIT */
/* The rounds of a study: its tasks, and the numbers they give. */
#include "server/store/seal.h"
#include "server/store/sql.h"
#include "sqlite.h"

/* A change under a claim. */
struct step {
    const struct store_claim *claim;
    const struct store_round *round;
    const void *numbers;
    size_t length;
    int64_t spent;
};

/* ------------------------------------------------------------------ begin */

/* The tasks' rank is the study's: after the tasks of the studies before. */
static enum store_answer begin_operation(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    const struct step *step = context;
    const struct store_round *round = step->round;
    struct query query = db_query(
        db, "UPDATE jobs SET status = " SQL_WAITING ", round = round + 1, open = ?,"
            " done = ?, total = ?, summary = ?, summary_seal = ?, attempts = 0, excused = 0,"
            " lease = NULL, holder = NULL"
            " WHERE sequence = ? AND token = ? AND status = " SQL_RUNNING);
    query_bind(&query, of_int((int64_t)round->count), of_int(round->done), of_int(round->total),
               of_text(round->best), of_int(seal_of_text(round->best)),
               of_int(step->claim->sequence), of_int(step->claim->token));
    enum store_answer answer = db_change(&query, STORE_CONFLICT);
    for (size_t k = 0; k < round->count && answer == STORE_OK; k++) {
        char id[ID_SIZE];
        id_make(id);
        query = db_query(
            db, "INSERT INTO jobs (id, status, rank, priority, owner, digest, surface, origin,"
                " created, kind, parent, round, position, total, task)"
                " SELECT ?, " SQL_QUEUED ", rank, priority, owner, '', surface, origin, created,"
                " " SQL_TASK ", sequence, round, ?, ?, ? FROM jobs WHERE sequence = ?");
        query_bind(&query, of_text(id), of_int((int64_t)k), of_int(round->variants[k]),
                   of_bytes((const char *)round->tasks + k * round->length, round->length),
                   of_int(step->claim->sequence));
        answer = query_run(&query);
    }
    return answer;
}

/* Not worth waiting for the disk: without it the step is done again. */
enum store_answer sqlite_begin_round(struct store *store, const struct store_claim *claim,
                                     const struct store_round *round) {
    struct step step = {.claim = claim, .round = round};
    enum store_answer room = sqlite_room_for(store, round->count * round->length);
    return room == STORE_OK ? sqlite_write(store, DB_LAZY, begin_operation, &step) : room;
}

/* ------------------------------------------------------------------ end */

static enum store_answer end_operation(struct sqlite_store *store, struct db *db, void *context) {
    const struct step *step = context;
    struct query query =
        db_query(db, "INSERT INTO task_numbers (parent, round, position, seal, bytes)"
                     " SELECT parent, round, position, ?, ? FROM jobs WHERE sequence "
                     "= ? AND token = ? AND status = " SQL_RUNNING);
    query_bind(&query, of_int(seal_of_numbers(step->claim->parent, step->numbers, step->length)),
               of_bytes(step->numbers, step->length), of_int(step->claim->sequence),
               of_int(step->claim->token));
    enum store_answer answer = db_change(&query, STORE_CONFLICT);
    if (answer != STORE_OK)
        return answer;
    query = db_query(db, "UPDATE jobs SET status = " SQL_SUCCEEDED ", finished = ?, spent = ?,"
                         " lease = NULL, holder = NULL, task = NULL WHERE sequence = ?");
    query_bind(&query, of_int(sqlite_now(store)), of_int(step->spent),
               of_int(step->claim->sequence));
    return query_run(&query);
}

enum store_answer sqlite_end_task(struct store *store, const struct store_claim *claim,
                                  const void *numbers, size_t length, int64_t spent) {
    struct step step = {.claim = claim, .numbers = numbers, .length = length, .spent = spent};
    enum store_answer room = sqlite_room_for(store, length);
    return room == STORE_OK ? sqlite_write(store, DB_LAZY, end_operation, &step) : room;
}
