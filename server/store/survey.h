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

/* The same by a reader, by the time `survey->now`; when `why` is empty the database has failed. */
struct reader;
bool survey_read(const struct reader *reader, struct survey *survey,
                 char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* Of each backend. */
bool sqlite_survey(const char *path, struct survey *survey, char why[STORE_WHY_SIZE]);
bool postgres_survey(const char *url, struct survey *survey, char why[STORE_WHY_SIZE]);

#endif
