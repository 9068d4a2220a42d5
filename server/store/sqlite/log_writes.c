/* SPDX-License-Identifier: MIT */
#include "log_writes.h"
#include <pthread.h>
#include <sqlite3.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum {
    HELD_MOST = (1 << 17) - 1, /* SQLite's layer of the system writes no more by one call */
    FRAME_HEAD = 24,           /* before each page in the log; its second word is not zero... */
    COMMIT_AT = 4,             /* ...in the last frame of a transaction */
    COMMIT_BYTES = 4
};

/* A log: the real file lies behind it in the memory that SQLite allocates. */
struct log_file {
    sqlite3_file base;
    sqlite3_file *real;
    unsigned char *held; /* malloc'ed at the first write: only one connection writes */
    size_t length;
    sqlite3_int64 at; /* where what is held begins */
};

static sqlite3_vfs *below;

static struct log_file *log_of(sqlite3_file *file) {
    return (struct log_file *)file;
}

static const sqlite3_io_methods *real_methods(const struct log_file *log) {
    return log->real->pMethods;
}

/* What cannot be written is dropped: who is told gives the transaction up. */
static int let_go(struct log_file *log) {
    size_t length = log->length;
    log->length = 0;
    return length == 0 ? SQLITE_OK
                       : real_methods(log)->xWrite(log->real, log->held, (int)length, log->at);
}

/* ------------------------------------------------------------------ writing */

static bool is_last_frame(const void *bytes, size_t length) {
    static const unsigned char none[COMMIT_BYTES] = {0};
    return length == FRAME_HEAD &&
           memcmp((const unsigned char *)bytes + COMMIT_AT, none, COMMIT_BYTES) != 0;
}

/* Whether the bytes go behind those that are held, or begin anew with a frame that is not the last.
 */
static bool can_hold(struct log_file *log, const void *bytes, size_t length, sqlite3_int64 at) {
    bool follows = log->length > 0 && at == log->at + (sqlite3_int64)log->length;
    bool begins = log->length == 0 && length == FRAME_HEAD;
    if (is_last_frame(bytes, length) || !(follows || begins) || length > HELD_MOST - log->length)
        return false;
    if (!log->held)
        log->held = malloc(HELD_MOST);
    return log->held != NULL;
}

/* The last frame of a transaction, and what stands elsewhere, goes to the file with all before it.
 */
static int log_write(sqlite3_file *file, const void *bytes, int length, sqlite3_int64 at) {
    struct log_file *log = log_of(file);
    int code = SQLITE_OK;
    if (!can_hold(log, bytes, (size_t)length, at))
        code = let_go(log);
    if (code != SQLITE_OK)
        return code;
    if (!can_hold(log, bytes, (size_t)length, at))
        return real_methods(log)->xWrite(log->real, bytes, length, at);
    if (log->length == 0)
        log->at = at;
    memcpy(log->held + log->length, bytes, (size_t)length);
    log->length += (size_t)length;
    return SQLITE_OK;
}

/* ------------------------------------------------------------------ everything else */

/* What is still held belongs to a transaction that was not committed. */
static int log_close(sqlite3_file *file) {
    struct log_file *log = log_of(file);
    free(log->held);
    return real_methods(log)->xClose(log->real);
}

static int log_read(sqlite3_file *file, void *to, int length, sqlite3_int64 at) {
    struct log_file *log = log_of(file);
    int code = let_go(log);
    return code == SQLITE_OK ? real_methods(log)->xRead(log->real, to, length, at) : code;
}

static int log_truncate(sqlite3_file *file, sqlite3_int64 size) {
    struct log_file *log = log_of(file);
    int code = let_go(log);
    return code == SQLITE_OK ? real_methods(log)->xTruncate(log->real, size) : code;
}

static int log_sync(sqlite3_file *file, int flags) {
    struct log_file *log = log_of(file);
    int code = let_go(log);
    return code == SQLITE_OK ? real_methods(log)->xSync(log->real, flags) : code;
}

static int log_size(sqlite3_file *file, sqlite3_int64 *size) {
    struct log_file *log = log_of(file);
    int code = let_go(log);
    return code == SQLITE_OK ? real_methods(log)->xFileSize(log->real, size) : code;
}

static int log_lock(sqlite3_file *file, int level) {
    return real_methods(log_of(file))->xLock(log_of(file)->real, level);
}

static int log_unlock(sqlite3_file *file, int level) {
    return real_methods(log_of(file))->xUnlock(log_of(file)->real, level);
}

static int log_check_lock(sqlite3_file *file, int *out) {
    return real_methods(log_of(file))->xCheckReservedLock(log_of(file)->real, out);
}

static int log_control(sqlite3_file *file, int what, void *argument) {
    return real_methods(log_of(file))->xFileControl(log_of(file)->real, what, argument);
}

static int log_sector_size(sqlite3_file *file) {
    return real_methods(log_of(file))->xSectorSize(log_of(file)->real);
}

static int log_characteristics(sqlite3_file *file) {
    return real_methods(log_of(file))->xDeviceCharacteristics(log_of(file)->real);
}

static const sqlite3_io_methods methods = {.iVersion = 1,
                                           .xClose = log_close,
                                           .xRead = log_read,
                                           .xWrite = log_write,
                                           .xTruncate = log_truncate,
                                           .xSync = log_sync,
                                           .xFileSize = log_size,
                                           .xLock = log_lock,
                                           .xUnlock = log_unlock,
                                           .xCheckReservedLock = log_check_lock,
                                           .xFileControl = log_control,
                                           .xSectorSize = log_sector_size,
                                           .xDeviceCharacteristics = log_characteristics};

/* ------------------------------------------------------------------ the layer */

/* Files other than logs are those of the layer below, without us. */
static int layer_open(sqlite3_vfs *vfs, const char *name, sqlite3_file *file, int flags,
                      int *out_flags) {
    (void)vfs;
    if (!(flags & SQLITE_OPEN_WAL))
        return below->xOpen(below, name, file, flags, out_flags);
    struct log_file *log = log_of(file);
    *log = (struct log_file){.real = (sqlite3_file *)(log + 1)};
    int code = below->xOpen(below, name, log->real, flags, out_flags);
    if (code == SQLITE_OK)
        log->base.pMethods = &methods;
    else if (log->real->pMethods)
        (void)log->real->pMethods->xClose(log->real);
    return code;
}

static sqlite3_vfs layer;

static void install(void) {
    below = sqlite3_vfs_find(NULL);
    if (!below)
        return;
    layer = *below;
    layer.pNext = NULL;
    layer.zName = "draped-log";
    layer.szOsFile = (int)sizeof(struct log_file) + below->szOsFile;
    layer.xOpen = layer_open;
    if (sqlite3_vfs_register(&layer, 0) != SQLITE_OK)
        below = NULL;
}

/* Another connection may write next, at the same places. */
static void forget(void *context) {
    sqlite3_file *file = NULL;
    if (sqlite3_file_control(context, "main", SQLITE_FCNTL_JOURNAL_POINTER, &file) == SQLITE_OK &&
        file && file->pMethods == &methods)
        log_of(file)->length = 0;
}

int log_writes_open(const char *path, sqlite3 **db, int flags) {
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, install);
    int code = sqlite3_open_v2(path, db, flags, below ? layer.zName : NULL);
    if (code == SQLITE_OK)
        (void)sqlite3_rollback_hook(*db, forget, *db);
    return code;
}
