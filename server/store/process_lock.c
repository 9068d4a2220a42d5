/* SPDX-License-Identifier: MIT */
#include "process_lock.h"
#include "server/id.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

static const char infix[] = "-holder-";

struct holder {
    char *path; /* of the database */
    char name[ID_SIZE];
    int store_lock; /* shared or exclusive; -1: not held */
    int own_lock;
};

static bool path_of(const struct holder *holder, const char *name, const char *suffix,
                    char path[PATH_MAX]) {
    int length = snprintf(path, PATH_MAX, "%s%s%s%s", holder->path, infix, name, suffix);
    return length > 0 && length < PATH_MAX;
}

const char *holder_name(const struct holder *holder) {
    return holder->name;
}

bool holder_dead(const struct holder *holder, const char *name) {
    char path[PATH_MAX];
    if (!strcmp(name, holder->name))
        return false;
    if (!id_valid(name) || !path_of(holder, name, "", path))
        return true;
    int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return errno == ENOENT;
    bool dead = flock(file, LOCK_EX | LOCK_NB) == 0;
    if (dead)
        unlink(path);
    close(file);
    return dead;
}

/* ------------------------------------------------------------------ taking and freeing */

static bool lock_store(struct holder *holder, bool shared, char why[STORE_WHY_SIZE]) {
    char path[PATH_MAX];
    int length = snprintf(path, sizeof path, "%s-lock", holder->path);
    if (length > 0 && (size_t)length < sizeof path)
        holder->store_lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (holder->store_lock < 0) {
        snprintf(why, STORE_WHY_SIZE, "cannot write beside the database %s: %s", holder->path,
                 strerror(errno));
        return false;
    }
    if (flock(holder->store_lock, (shared ? LOCK_SH : LOCK_EX) | LOCK_NB) == 0)
        return true;
    snprintf(why, STORE_WHY_SIZE, "the database %s is in use by another draped", holder->path);
    return false;
}

/* The file gets its name when it is locked, so that nobody can find it unlocked and take us for
 * dead. */
static bool lock_own(struct holder *holder, char why[STORE_WHY_SIZE]) {
    char unlocked[PATH_MAX];
    char path[PATH_MAX];
    id_make(holder->name);
    if (path_of(holder, holder->name, ".new", unlocked) && path_of(holder, holder->name, "", path))
        holder->own_lock = open(unlocked, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (holder->own_lock >= 0 && flock(holder->own_lock, LOCK_EX | LOCK_NB) == 0 &&
        rename(unlocked, path) == 0)
        return true;
    snprintf(why, STORE_WHY_SIZE, "cannot write beside the database %s: %s", holder->path,
             strerror(errno));
    if (holder->own_lock >= 0)
        unlink(unlocked);
    return false;
}

/* Removes the files of the dead; without this every kill would leave one for ever. */
static void clear_away(const struct holder *holder) {
    char folder[PATH_MAX];
    char file[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", holder->path);
    snprintf(file, sizeof file, "%s", holder->path);
    DIR *entries = opendir(dirname(folder));
    const char *base = basename(file);
    size_t length = strlen(base);
    struct dirent *entry = NULL;
    while (entries && (entry = readdir(entries)) != NULL) {
        const char *rest = entry->d_name + length;
        if (!strncmp(entry->d_name, base, length) && !strncmp(rest, infix, sizeof infix - 1))
            (void)holder_dead(holder, rest + sizeof infix - 1);
    }
    if (entries)
        closedir(entries);
}

static struct holder *holder_new(const char *path) {
    struct holder *holder = calloc(1, sizeof *holder);
    if (!holder)
        return NULL;
    holder->store_lock = holder->own_lock = -1;
    holder->path = strdup(path);
    if (holder->path)
        return holder;
    free(holder);
    return NULL;
}

struct holder *holder_take(const char *path, bool shared, char why[STORE_WHY_SIZE]) {
    struct holder *holder = holder_new(path);
    if (!holder) {
        snprintf(why, STORE_WHY_SIZE, "no memory for the database");
        return NULL;
    }
    if (lock_store(holder, shared, why) && lock_own(holder, why)) {
        clear_away(holder);
        return holder;
    }
    holder_free(holder);
    return NULL;
}

void holder_free(struct holder *holder) {
    char path[PATH_MAX];
    if (!holder)
        return;
    if (holder->own_lock >= 0) {
        if (path_of(holder, holder->name, "", path))
            unlink(path);
        close(holder->own_lock);
    }
    if (holder->store_lock >= 0)
        close(holder->store_lock);
    free(holder->path);
    free(holder);
}
