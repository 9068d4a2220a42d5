/* SPDX-License-Identifier: MIT */
#include "faulty_vfs.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <sqlite3.h>
#include <stdlib.h>
#include <string.h>

/* SQLite allocates szOsFile bytes: ours, and then the real one. */
struct faulty_file {
    sqlite3_file base;
    sqlite3_file *real;
};

static sqlite3_vfs *system_vfs;
static _Atomic enum faulty_kind chosen;
static atomic_long fail_at, calls, failures;
static atomic_bool goes_on;

void faulty_set(enum faulty_kind kind, long n, bool lasting) {
    atomic_store(&fail_at, 0);
    atomic_store(&chosen, kind);
    atomic_store(&goes_on, lasting);
    atomic_store(&calls, 0);
    atomic_store(&failures, 0);
    atomic_store(&fail_at, n);
}

long faulty_failures(void) {
    return atomic_load(&failures);
}

/* Whether this call fails; `grows`: a full disk would refuse it. */
static bool fails(bool grows) {
    long n = atomic_load(&fail_at);
    if (!n || (atomic_load(&chosen) == FAULTY_DISK_FULL && !grows))
        return false;
    long call = atomic_fetch_add(&calls, 1) + 1;
    bool bad = atomic_load(&goes_on) ? call >= n : call == n;
    atomic_fetch_add(&failures, bad);
    return bad;
}

static int error_of(int code) {
    return atomic_load(&chosen) == FAULTY_DISK_FULL ? SQLITE_FULL : code;
}

static sqlite3_file *real_of(sqlite3_file *file) {
    return ((struct faulty_file *)file)->real;
}

static int faulty_close(sqlite3_file *file) {
    return real_of(file)->pMethods->xClose(real_of(file));
}

static int faulty_read(sqlite3_file *file, void *to, int length, sqlite3_int64 at) {
    return fails(false) ? SQLITE_IOERR_READ
                        : real_of(file)->pMethods->xRead(real_of(file), to, length, at);
}

/* A write that fails has written a part, as a disk does. */
static int faulty_write(sqlite3_file *file, const void *from, int length, sqlite3_int64 at) {
    if (!fails(true))
        return real_of(file)->pMethods->xWrite(real_of(file), from, length, at);
    (void)real_of(file)->pMethods->xWrite(real_of(file), from, length / 2, at);
    return error_of(SQLITE_IOERR_WRITE);
}

static int faulty_truncate(sqlite3_file *file, sqlite3_int64 size) {
    return fails(false) ? SQLITE_IOERR_TRUNCATE
                        : real_of(file)->pMethods->xTruncate(real_of(file), size);
}

/* Synchronising is counted but left out: no power is cut here, and a slow disk would make minutes
 * of thousands of lives. */
static int faulty_sync(sqlite3_file *file, int flags) {
    (void)file;
    (void)flags;
    return fails(false) ? SQLITE_IOERR_FSYNC : SQLITE_OK;
}

static int faulty_file_size(sqlite3_file *file, sqlite3_int64 *size) {
    return fails(false) ? SQLITE_IOERR_FSTAT
                        : real_of(file)->pMethods->xFileSize(real_of(file), size);
}

static int faulty_lock(sqlite3_file *file, int level) {
    return fails(false) ? SQLITE_IOERR_LOCK : real_of(file)->pMethods->xLock(real_of(file), level);
}

static int faulty_unlock(sqlite3_file *file, int level) {
    return real_of(file)->pMethods->xUnlock(real_of(file), level);
}

static int faulty_check_lock(sqlite3_file *file, int *out) {
    return real_of(file)->pMethods->xCheckReservedLock(real_of(file), out);
}

static int faulty_control(sqlite3_file *file, int what, void *argument) {
    return real_of(file)->pMethods->xFileControl(real_of(file), what, argument);
}

static int faulty_sector_size(sqlite3_file *file) {
    return real_of(file)->pMethods->xSectorSize(real_of(file));
}

static int faulty_characteristics(sqlite3_file *file) {
    return real_of(file)->pMethods->xDeviceCharacteristics(real_of(file));
}

static int faulty_shm_map(sqlite3_file *file, int page, int size, int extend,
                          void volatile **memory) {
    return fails(extend != 0)
               ? error_of(SQLITE_IOERR_SHMMAP)
               : real_of(file)->pMethods->xShmMap(real_of(file), page, size, extend, memory);
}

static int faulty_shm_lock(sqlite3_file *file, int offset, int n, int flags) {
    return real_of(file)->pMethods->xShmLock(real_of(file), offset, n, flags);
}

static void faulty_shm_barrier(sqlite3_file *file) {
    real_of(file)->pMethods->xShmBarrier(real_of(file));
}

static int faulty_shm_unmap(sqlite3_file *file, int remove) {
    return real_of(file)->pMethods->xShmUnmap(real_of(file), remove);
}

static const sqlite3_io_methods methods = {
    .iVersion = 2,
    .xClose = faulty_close,
    .xRead = faulty_read,
    .xWrite = faulty_write,
    .xTruncate = faulty_truncate,
    .xSync = faulty_sync,
    .xFileSize = faulty_file_size,
    .xLock = faulty_lock,
    .xUnlock = faulty_unlock,
    .xCheckReservedLock = faulty_check_lock,
    .xFileControl = faulty_control,
    .xSectorSize = faulty_sector_size,
    .xDeviceCharacteristics = faulty_characteristics,
    .xShmMap = faulty_shm_map,
    .xShmLock = faulty_shm_lock,
    .xShmBarrier = faulty_shm_barrier,
    .xShmUnmap = faulty_shm_unmap,
};

static int faulty_open(sqlite3_vfs *vfs, const char *name, sqlite3_file *base, int flags,
                       int *out_flags) {
    struct faulty_file *file = (struct faulty_file *)base;
    (void)vfs;
    base->pMethods = NULL;
    if (fails(true))
        return atomic_load(&chosen) == FAULTY_DISK_FULL ? SQLITE_FULL : SQLITE_CANTOPEN;
    file->real = (sqlite3_file *)(file + 1);
    int code = system_vfs->xOpen(system_vfs, name, file->real, flags, out_flags);
    if (code == SQLITE_OK)
        base->pMethods = &methods;
    return code;
}

static int faulty_delete(sqlite3_vfs *vfs, const char *name, int sync) {
    (void)vfs;
    (void)sync;
    return fails(false) ? SQLITE_IOERR_DELETE : system_vfs->xDelete(system_vfs, name, 0);
}

void faulty_install(void) {
    static sqlite3_vfs vfs;
    system_vfs = sqlite3_vfs_find(NULL);
    assert_non_null(system_vfs);
    vfs = *system_vfs;
    vfs.zName = "faulty";
    vfs.pNext = NULL;
    vfs.szOsFile = (int)sizeof(struct faulty_file) + system_vfs->szOsFile;
    vfs.xOpen = faulty_open;
    vfs.xDelete = faulty_delete;
    assert_int_equal(sqlite3_vfs_register(&vfs, 1), SQLITE_OK);
}
