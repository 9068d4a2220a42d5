/* SPDX-License-Identifier: MIT */
#include "file_identity.h"
#include "server/log.h"
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

/* The database, its log, and the index of that which processes share. */
static const char *const suffixes[] = {"", "-wal", "-shm"};
enum { FILES = sizeof suffixes / sizeof *suffixes };

struct file_identity {
    struct {
        char path[PATH_MAX];
        dev_t device;
        ino_t inode;
    } files[FILES];
    atomic_bool gone;
};

/* SQLite has the log beside the file itself, wherever the path leads. */
struct file_identity *file_identity_new(const char *path) {
    char resolved[PATH_MAX];
    struct stat status = {0};
    struct file_identity *identity = calloc(1, sizeof *identity);
    bool good = identity && realpath(path, resolved);
    for (int k = 0; k < FILES && good; k++) {
        int length =
            snprintf(identity->files[k].path, PATH_MAX, "%s%s", k ? resolved : path, suffixes[k]);
        good = length < PATH_MAX && stat(identity->files[k].path, &status) == 0;
        identity->files[k].device = status.st_dev;
        identity->files[k].inode = status.st_ino;
    }
    if (good)
        return identity;
    free(identity);
    return NULL;
}

void file_identity_free(struct file_identity *identity) {
    free(identity);
}

bool file_identity_check(struct file_identity *identity) {
    struct stat status;
    int k = 0;
    while (k < FILES && stat(identity->files[k].path, &status) == 0 &&
           status.st_dev == identity->files[k].device && status.st_ino == identity->files[k].inode)
        k++;
    bool gone = k < FILES;
    if (atomic_exchange(&identity->gone, gone) == gone)
        return !gone;
    if (gone)
        log_error(log_event("store_file_gone"), log_text("file", identity->files[k].path),
                  log_text("why", "it was removed, moved or replaced: the service accepts nothing "
                                  "until the same file is back or the service is restarted"));
    else
        log_info(log_event("store_file_back"), log_text("file", identity->files[0].path));
    return !gone;
}
