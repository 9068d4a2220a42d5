/* SPDX-License-Identifier: MIT */
#include "backup.h"
#include "server/clock.h"
#include "store.h"
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

bool backup_fail(char why[STORE_WHY_SIZE], const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, STORE_WHY_SIZE, format, arguments);
    va_end(arguments);
    return false;
}

static const struct backup_table *find_table(const struct backup_contents *contents,
                                             const char *name) {
    for (size_t k = 0; k < contents->count; k++)
        if (!strcmp(contents->tables[k].name, name))
            return &contents->tables[k];
    return NULL;
}

int64_t backup_rows(const struct backup_contents *contents, const char *table) {
    const struct backup_table *found = find_table(contents, table);
    return found ? found->rows : 0;
}

bool backup_same(const struct backup_contents *found, const struct backup_contents *expected,
                 char why[STORE_WHY_SIZE]) {
    if (found->schema != expected->schema || found->count != expected->count)
        return backup_fail(why, "the copy does not have the tables of the store");
    for (size_t k = 0; k < expected->count; k++) {
        const struct backup_table *wanted = &expected->tables[k];
        const struct backup_table *table = find_table(found, wanted->name);
        if (table && table->rows == wanted->rows && !strcmp(table->checksum, wanted->checksum))
            continue;
        return backup_fail(
            why,
            "the table '%s' of the copy differs from that of the store: it has %" PRId64
            " of %" PRId64 " rows, or different ones",
            wanted->name, table ? table->rows : 0, wanted->rows);
    }
    return true;
}

void backup_time(char text[BACKUP_TIME_SIZE]) {
    int64_t now = clock_utc_us();
    time_t seconds = (time_t)(now / 1000000);
    struct tm parts;
    gmtime_r(&seconds, &parts);
    size_t length = strftime(text, BACKUP_TIME_SIZE, "%Y%m%dT%H%M%S", &parts);
    snprintf(text + length, BACKUP_TIME_SIZE - length, ".%03dZ", (int)(now / 1000 % 1000));
}

bool backup_sync(const char *path, char why[STORE_WHY_SIZE]) {
    int file = open(path, O_RDONLY | O_CLOEXEC);
    bool good = file >= 0 && fsync(file) == 0;
    if (!good)
        backup_fail(why, "%s cannot be written to the disk: %s", path, strerror(errno));
    /* What is read back then comes from there. */
    if (good)
        (void)posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED);
    if (file >= 0)
        close(file);
    return good;
}

bool backup_make(const char *url, const char *path, struct backup_contents *contents,
                 char why[STORE_WHY_SIZE]) {
    memset(contents, 0, sizeof *contents);
    return store_url_remote(url) ? postgres_backup_make(url, path, contents, why)
                                 : sqlite_backup_make(store_url_path(url), path, contents, why);
}

bool backup_restore(const char *url, const char *path, struct backup_contents *contents,
                    char kept[BACKUP_KEPT_SIZE], char why[STORE_WHY_SIZE]) {
    static const char sqlite[16] = "SQLite format 3"; /* its first bytes */
    char start[sizeof sqlite] = "";
    memset(contents, 0, sizeof *contents);
    kept[0] = '\0';
    int file = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t got = file < 0 ? -1 : read(file, start, sizeof start);
    if (got < 0)
        backup_fail(why, "%s cannot be read: %s", path, strerror(errno));
    if (file >= 0)
        close(file);
    if (got < 0)
        return false;
    if (!memcmp(start, sqlite, sizeof sqlite) && store_url_remote(url))
        return backup_fail(why, "%s is of an SQLite store, and this one is PostgreSQL", path);
    return store_url_remote(url)
               ? postgres_backup_restore(url, path, contents, kept, why)
               : sqlite_backup_restore(store_url_path(url), path, contents, kept, why);
}
