/* SPDX-License-Identifier: MIT */
/*
 * A look at a store from outside, by reading alone: beside the daemons that use it, or without any.
 * Nothing is made, changed or locked.
 */
#ifndef SERVER_STORE_SURVEY_H
#define SERVER_STORE_SURVEY_H

#include "store.h"

enum { SURVEY_HOSTS = 256, SURVEY_ERROR_SIZE = 512 };

struct survey {
    int64_t schema;
    int64_t now; /* by the database's clock, or this machine's for SQLite */
    struct store_counts counts;
    size_t host_count; /* at most SURVEY_HOSTS, the latest first */
    struct {
        struct store_host host;
        int64_t seen; /* when it wrote to the store last */
    } hosts[SURVEY_HOSTS];
    char failed[ID_SIZE]; /* the drape that failed last; "" for none */
    int64_t failed_at;
    char error[SURVEY_ERROR_SIZE]; /* its problem document, cut to this size */
};

/* Fills it from the store at `url`. False with a sentence in `why`, without any password: it cannot
 * be read, is none of ours, or has the tables of another version. */
bool survey_store(const char *url, struct survey *survey, char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* What is stored and was read: jobs with their requests and results, and items by their kind. */
struct store_audit {
    int64_t jobs, results, items[STORE_ITEM_KINDS];
    int64_t bytes;   /* of all */
    int64_t damaged; /* of them, as told */
};

/* Reads everything and tells each thing that is not what was written: "drape", its id and "the
 * result". What is removed meanwhile is none. False with a sentence in `why`, as above, or when the
 * database itself finds its file damaged, which has then been told of as well. */
typedef void store_audit_tell(const char *kind, const char *id, const char *what);
bool audit_store(const char *url, store_audit_tell *tell, struct store_audit *audit,
                 char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* Of each backend: has `look` read the store, by the time `now`. When it fails and `why` is empty
 * the database has failed. */
struct reader;
typedef bool survey_look(const struct reader *reader, int64_t now, void *context,
                         char why[STORE_WHY_SIZE]);
bool sqlite_survey(const char *path, survey_look *look, void *context, char why[STORE_WHY_SIZE]);
bool postgres_survey(const char *url, survey_look *look, void *context, char why[STORE_WHY_SIZE]);

/* Whether the tables are those of this version; else `why` says what to do. */
bool survey_schema(const struct reader *reader, int64_t *schema, char why[STORE_WHY_SIZE]);

/* By `look`, with the backend of the URL. */
bool survey_by(const char *url, survey_look *look, void *context, char why[STORE_WHY_SIZE]);

#endif
