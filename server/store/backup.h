/* SPDX-License-Identifier: MIT */
/*
 * Copies of a whole store in one file, made while daemons use it, and put back.
 *
 * A copy is of one moment: SQLite's is a database again, made by its online back-up from one read
 * transaction, with the number of rows and a checksum of every table, by which it is compared when
 * it is made and before it is put back; PostgreSQL's is made by `pg_dump` and read back to its end.
 *
 * Putting back never destroys: what the store held until then stays under another name, and until
 * everything has arrived whole, nothing has changed.
 */
#ifndef SERVER_STORE_BACKUP_H
#define SERVER_STORE_BACKUP_H

#include "answer.h"
#include "api/checksum.h"
#include <stddef.h>
#include <stdint.h>

enum { BACKUP_TABLES = 32, BACKUP_NAME_SIZE = 64, BACKUP_KEPT_SIZE = 4096 };

struct backup_table {
    char name[BACKUP_NAME_SIZE];
    int64_t rows;
    char checksum[CHECKSUM_SIZE];
};

/* What a copy holds. */
struct backup_contents {
    int64_t schema; /* the version of the tables */
    size_t count;
    struct backup_table tables[BACKUP_TABLES];
};

/* Rows of a table; 0 for one that is not there. */
int64_t backup_rows(const struct backup_contents *contents, const char *table);

/* Whether both hold the same; else `why` names the table. */
bool backup_same(const struct backup_contents *found, const struct backup_contents *expected,
                 char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* Copies the store at `url` (as in `store_open`) into the new file `path`, which is on disk and
 * has been read back when this is true. False with a sentence in `why`, without any password; then
 * the caller removes what is there of the file. */
bool backup_make(const char *url, const char *path, struct backup_contents *contents,
                 char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* Puts the copy `path` in the place of what the store at `url` holds, if anything; `kept` says
 * where that is now ("": there was nothing). No daemon may use the store: false if one does, if the
 * copy is not whole or of a newer version, or of the other kind of database. False with `why` has
 * changed nothing. */
bool backup_restore(const char *url, const char *path, struct backup_contents *contents,
                    char kept[BACKUP_KEPT_SIZE], char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* ------------------------------------------------------------------ of each backend */

bool sqlite_backup_make(const char *database, const char *path, struct backup_contents *contents,
                        char why[STORE_WHY_SIZE]) STORE_MUST_USE;
bool sqlite_backup_restore(const char *database, const char *path, struct backup_contents *contents,
                           char kept[BACKUP_KEPT_SIZE], char why[STORE_WHY_SIZE]) STORE_MUST_USE;
bool postgres_backup_make(const char *url, const char *path, struct backup_contents *contents,
                          char why[STORE_WHY_SIZE]) STORE_MUST_USE;
bool postgres_backup_restore(const char *url, const char *path, struct backup_contents *contents,
                             char kept[BACKUP_KEPT_SIZE], char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* Formats `why`, cut to its size; always false. */
bool backup_fail(char why[STORE_WHY_SIZE], const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The UTC time as names have it, 20250102T030405.678Z. */
enum { BACKUP_TIME_SIZE = 21 };
void backup_time(char text[BACKUP_TIME_SIZE]);

/* Sees to it that a file, or a folder with its names, is on disk. */
bool backup_sync(const char *path, char why[STORE_WHY_SIZE]) STORE_MUST_USE;

#endif
