/* SPDX-License-Identifier: MIT */
/*
 * A layer under SQLite that fails on purpose: it passes everything on to the system's own VFS, but
 * for the n-th call from now on. It becomes SQLite's default for the rest of the process.
 */
#ifndef TESTS_FAULTY_VFS_H
#define TESTS_FAULTY_VFS_H

#include <stdbool.h>

enum faulty_kind {
    FAULTY_IO_ERROR, /* reads, writes, synchronisations, ...: an error of the device */
    FAULTY_DISK_FULL /* writes and what makes files longer: no space; all else goes on */
};

/* To be called once, before the first connection. */
void faulty_install(void);

/* The n-th call of that kind (1 is the next one) fails, and with `lasting` all after it; 0: none.
 * The count begins anew. */
void faulty_set(enum faulty_kind kind, long n, bool lasting);

/* How many calls have failed since `faulty_set`. */
long faulty_failures(void);

#endif
