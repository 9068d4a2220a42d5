/* SPDX-License-Identifier: MIT */
/*
 * Reads all that is stored, by the functions that callers' requests are answered with: a page of
 * names after the other, and of each name everything.
 */
#include "backend.h"
#include "sql.h"
#include "survey.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PAGE_NAMES = 256 };

struct walk {
    struct store store; /* its reader and its memory alone */
    store_audit_tell *tell;
    struct store_audit *audit;
};

/* Where a page begins, and the rows it has. */
struct page_of_names {
    size_t count;
    struct name {
        int64_t sequence;
        char id[STORE_DIGEST_SIZE], owner[STORE_OWNER_SIZE];
    } names[PAGE_NAMES];
};

static enum store_answer read_names(struct walk *walk, const char *sql,
                                    struct page_of_names *page) {
    const struct reader *reader = &walk->store.reader;
    int64_t after = page->count > 0 ? page->names[page->count - 1].sequence : 0;
    struct query query = reader->query(reader->of, sql);
    query_bind(&query, of_int(after), of_int(PAGE_NAMES));
    for (page->count = 0; page->count < PAGE_NAMES && query_row(&query); page->count++) {
        struct name *name = &page->names[page->count];
        name->sequence = query_int(&query, 0);
        query_copy(&query, 1, name->id, sizeof name->id);
        query_copy(&query, 2, name->owner, sizeof name->owner);
    }
    return query_end(&query);
}

/* Takes note of how a part of something was read. Whether to go on. */
static bool note_part(struct walk *walk, enum store_answer answer, const char *kind, const char *id,
                      const char *what) {
    if (answer == STORE_ALTERED) {
        walk->tell(kind, id, what);
        walk->audit->damaged++;
    }
    return !store_failed(answer);
}

/* ------------------------------------------------------------------ jobs */

static enum store_answer read_result(struct walk *walk, const char *id) {
    struct store_result result;
    char *bytes = malloc(STORE_CHUNK_BYTES);
    enum store_answer answer = bytes ? store_result_find(&walk->store, id, &result) : STORE_DOWN;
    for (int64_t at = 0; answer == STORE_OK && at < result.length; at += STORE_CHUNK_BYTES) {
        int64_t left = result.length - at;
        answer = store_result_read(&walk->store, &result, at, bytes,
                                   left < STORE_CHUNK_BYTES ? (size_t)left : STORE_CHUNK_BYTES);
    }
    if (answer == STORE_OK) {
        walk->audit->results++;
        walk->audit->bytes += result.length;
    }
    free(bytes);
    return answer;
}

/* A part of a job that is not there is lost, unless the job has been removed meanwhile. */
static bool note_job_part(struct walk *walk, enum store_answer answer, const struct store_job *job,
                          const char *what) {
    struct store_job now = {0};
    if (answer == STORE_EMPTY && store_get(&walk->store, job->id, &now) == STORE_OK && !now.expired)
        answer = STORE_ALTERED;
    store_job_clear(&now);
    return note_part(walk, answer, store_kind_name(job->kind), job->id, what);
}

/* A study's numbers are read with it; a task has nothing else, and a laminate no result. */
static bool audit_job(struct walk *walk, const struct name *name) {
    struct store_job job = {0};
    struct store_claim study = {0};
    char *bytes = NULL;
    void *numbers = NULL;
    size_t length = 0;
    enum store_answer answer = store_get(&walk->store, name->id, &job);
    const bool there = answer == STORE_OK && !job.expired && job.kind != STORE_TASK;
    bool good = note_part(walk, answer == STORE_OK && job.altered ? STORE_ALTERED : answer,
                          store_kind_name(job.kind), name->id, "its summary or its error");
    walk->audit->jobs += answer == STORE_OK;
    if (good && there) {
        answer = store_request(&walk->store, name->id, &bytes, &length);
        good = note_job_part(walk, answer, &job, "its request");
        walk->audit->bytes += (int64_t)length;
    }
    if (good && there && job.kind == STORE_STUDY) {
        memcpy(study.id, job.id, sizeof study.id);
        study.sequence = job.sequence;
        answer = store_numbers(&walk->store, &study, &numbers, &length);
        good = note_job_part(walk, answer, &job, "the numbers of its variants");
    }
    if (good && there && job.status == STORE_SUCCEEDED && job.kind != STORE_LAMINATE) {
        answer = read_result(walk, name->id);
        good = note_job_part(walk, answer, &job, "its result");
    }
    free(bytes);
    free(numbers);
    store_job_clear(&job);
    return good;
}

/* ------------------------------------------------------------------ items */

static bool audit_item(struct walk *walk, enum store_item_kind kind, const struct name *name) {
    struct store_item item = {0};
    enum store_answer answer = store_item_get(&walk->store, kind, name->owner, name->id, &item);
    walk->audit->items[kind] += answer == STORE_OK;
    walk->audit->bytes += (int64_t)item.definition_length;
    store_item_clear(&item);
    return note_part(walk, answer, store_item_kind_name(kind), name->id, "its definition");
}

/* ------------------------------------------------------------------ all of it */

/* What SQLite finds wrong with its file, a sentence a row. */
static bool check_file(struct walk *walk) {
    const struct reader *reader = &walk->store.reader;
    if (!reader->dialect->check)
        return true;
    struct query query = reader->query(reader->of, reader->dialect->check);
    for (const char *verdict; query_row(&query);)
        if (verdict = query_text(&query, 0), strcmp(verdict ? verdict : "", "ok") != 0) {
            walk->tell("database", "", verdict ? verdict : "");
            walk->audit->damaged++;
        }
    return query_end(&query) == STORE_OK;
}

static bool read_all(const struct reader *reader, int64_t now, void *context,
                     char why[STORE_WHY_SIZE]) {
    static const char *const lists[] = {
        "SELECT sequence, id, owner FROM draped.jobs WHERE sequence > $1 ORDER BY sequence LIMIT "
        "$2",
        "SELECT sequence, id, owner FROM draped.surfaces WHERE sequence > $1 ORDER BY sequence "
        "LIMIT $2",
        "SELECT sequence, id, owner FROM draped.materials WHERE sequence > $1 ORDER BY sequence "
        "LIMIT $2",
        "SELECT sequence, id, owner FROM draped.links WHERE sequence > $1 ORDER BY sequence "
        "LIMIT $2"}; /* jobs, and behind them every kind of items */
    struct walk *walk = context;
    int64_t schema;
    (void)now;
    walk->store.reader = *reader;
    if (!survey_schema(reader, &schema, why))
        return false;
    bool good = check_file(walk);
    struct page_of_names *page = calloc(1, sizeof *page);
    for (size_t list = 0; page && good && list < sizeof lists / sizeof *lists; list++) {
        page->count = 0;
        do {
            good = read_names(walk, lists[list], page) == STORE_OK;
            for (size_t k = 0; good && k < page->count; k++)
                good = list == 0
                           ? audit_job(walk, &page->names[k])
                           : audit_item(walk, (enum store_item_kind)(list - 1), &page->names[k]);
        } while (good && page->count == PAGE_NAMES);
    }
    good = good && page;
    free(page);
    return good;
}

bool audit_store(const char *url, store_audit_tell *tell, struct store_audit *audit,
                 char why[STORE_WHY_SIZE]) {
    struct walk *walk = calloc(1, sizeof *walk);
    *audit = (struct store_audit){0};
    snprintf(why, STORE_WHY_SIZE, "there is no memory for it");
    if (!walk || !(walk->store.cache = store_cache_new())) {
        free(walk);
        return false;
    }
    walk->tell = tell;
    walk->audit = audit;
    bool good = survey_by(url, read_all, walk, why);
    store_cache_free(walk->store.cache);
    free(walk);
    return good;
}
