/* SPDX-License-Identifier: MIT */
#include "presence.h"
#include "server/log.h"
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

/* The database, its log, and the index of that which processes share. */
static const char *const suffixes[] = {"", "-wal", "-shm"};
enum { FILES = sizeof suffixes / sizeof *suffixes };

struct presence {
    struct {
        char path[PATH_MAX];
        dev_t device;
        ino_t inode;
    } files[FILES];
    atomic_bool gone;
};

/* SQLite has the log beside the file itself, wherever the path leads. */
struct presence *presence_new(const char *path) {
    char resolved[PATH_MAX];
    struct stat status = {0};
    struct presence *presence = calloc(1, sizeof *presence);
    bool good = presence && realpath(path, resolved);
    for (int k = 0; k < FILES && good; k++) {
        int length =
            snprintf(presence->files[k].path, PATH_MAX, "%s%s", k ? resolved : path, suffixes[k]);
        good = length < PATH_MAX && stat(presence->files[k].path, &status) == 0;
        presence->files[k].device = status.st_dev;
        presence->files[k].inode = status.st_ino;
    }
    if (good)
        return presence;
    free(presence);
    return NULL;
}

void presence_free(struct presence *presence) {
    free(presence);
}

bool presence_check(struct presence *presence) {
    struct stat status;
    int k = 0;
    while (k < FILES && stat(presence->files[k].path, &status) == 0 &&
           status.st_dev == presence->files[k].device && status.st_ino == presence->files[k].inode)
        k++;
    bool gone = k < FILES;
    if (atomic_exchange(&presence->gone, gone) == gone)
        return !gone;
    if (gone)
        log_error(log_event("store_file_gone"), log_text("file", presence->files[k].path),
                  log_text("why", "it was removed, moved or replaced: nothing is accepted until "
                                  "the same file is back, or the service is started anew"));
    else
        log_info(log_event("store_file_back"), log_text("file", presence->files[0].path));
    return !gone;
}
