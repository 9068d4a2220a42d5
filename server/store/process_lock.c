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

struct process_lock {
    char *path; /* of the database */
    char name[ID_SIZE];
    int store_lock; /* shared or exclusive; -1: not held */
    int own_lock;
};

static bool lock_path(const struct process_lock *lock, const char *name, const char *suffix,
                      char path[PATH_MAX]) {
    int length = snprintf(path, PATH_MAX, "%s%s%s%s", lock->path, infix, name, suffix);
    return length > 0 && length < PATH_MAX;
}

const char *process_lock_name(const struct process_lock *lock) {
    return lock->name;
}

bool process_lock_gone(const struct process_lock *lock, const char *name) {
    char path[PATH_MAX];
    if (!strcmp(name, lock->name))
        return false;
    if (!id_valid(name) || !lock_path(lock, name, "", path))
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

/* Removes the files of the dead; without this every kill would leave one for ever. */
static void clear_away(const struct process_lock *lock) {
    char folder[PATH_MAX], file[PATH_MAX];
    snprintf(folder, sizeof folder, "%s", lock->path);
    snprintf(file, sizeof file, "%s", lock->path);
    DIR *entries = opendir(dirname(folder));
    const char *base = basename(file);
    size_t length = strlen(base);
    struct dirent *entry = NULL;
    while (entries && (entry = readdir(entries)) != NULL) {
        const char *rest = entry->d_name + length;
        if (!strncmp(entry->d_name, base, length) && !strncmp(rest, infix, sizeof infix - 1))
            (void)process_lock_gone(lock, rest + sizeof infix - 1);
    }
    if (entries)
        closedir(entries);
}

struct process_lock *process_lock_take(const char *path, bool shared, char why[STORE_WHY_SIZE]) {
    char beside[PATH_MAX], unlocked[PATH_MAX];
    struct process_lock *lock = calloc(1, sizeof *lock);
    if (!lock || !(lock->path = strdup(path))) {
        snprintf(why, STORE_WHY_SIZE, "no memory for the database");
        free(lock);
        return NULL;
    }
    lock->store_lock = lock->own_lock = -1;
    int length = snprintf(beside, sizeof beside, "%s-lock", path);
    if (length > 0 && (size_t)length < sizeof beside)
        lock->store_lock = open(beside, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    bool writes = lock->store_lock >= 0;
    if (writes && flock(lock->store_lock, (shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0) {
        snprintf(why, STORE_WHY_SIZE, "the database %s is in use by another draped", path);
        process_lock_free(lock);
        return NULL;
    }
    if (writes) {
        /* The file gets its name when it is locked, so that no process can find it unlocked and
         * take this one for dead. */
        id_make(lock->name);
        if (lock_path(lock, lock->name, ".new", unlocked) &&
            lock_path(lock, lock->name, "", beside))
            lock->own_lock = open(unlocked, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
        writes = lock->own_lock >= 0 && flock(lock->own_lock, LOCK_EX | LOCK_NB) == 0 &&
                 rename(unlocked, beside) == 0;
    }
    if (writes) {
        clear_away(lock);
        return lock;
    }
    snprintf(why, STORE_WHY_SIZE, "cannot write beside the database %s: %s", path, strerror(errno));
    if (lock->own_lock >= 0)
        unlink(unlocked);
    process_lock_free(lock);
    return NULL;
}

void process_lock_free(struct process_lock *lock) {
    char path[PATH_MAX];
    if (!lock)
        return;
    if (lock->own_lock >= 0) {
        if (lock_path(lock, lock->name, "", path))
            unlink(path);
        close(lock->own_lock);
    }
    if (lock->store_lock >= 0)
        close(lock->store_lock);
    free(lock->path);
    free(lock);
}
