/* SPDX-License-Identifier: MIT */
#include "backup.h"
#include "config.h"
#include "log.h"
#include "server/store/backup.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FAILED = 1, USAGE = 2, KEEP = 7, KEEP_MOST = 100000, ARGUMENTS = 64 };

/* A copy is NAME_START, its time, NAME_END; one that is being made has PART_END. */
#define NAME_START "draped-"
#define NAME_END ".backup"
#define PART_END ".part"

static const char usage[] =
    "usage: draped backup FOLDER [--keep N] [--data DIR] [--store URL]\n"
    "       draped restore FILE|FOLDER [--data DIR] [--store URL]\n\n"
    "backup copies the store into a new file draped-TIME.backup of FOLDER, while draped runs. The\n"
    "file gets its name when it is on disk and was read back and compared; of such files the\n"
    "newest N (7; 0 for all) are kept. Run it where draped runs or, with PostgreSQL, anywhere "
    "with\n"
    "the URL of the database: then by pg_dump, of the server's version or newer.\n\n"
    "restore puts FILE, or the newest such file of FOLDER, in the place of the store, once\nit is "
    "copied completely. The old store is kept, and its new name is shown. First stop every\ndraped "
    "of that store. With PostgreSQL it calls pg_restore and psql.\n\n"
    "The store is given as for the daemon, by --data or --store or by DRAPED_DATA or\n"
    "DRAPED_STORE. Exit status: 0; 1 when it did not succeed, and then nothing has changed; 2 for\n"
    "invalid arguments.\n";

/* One command and where it works. */
struct command {
    struct config config;
    char url[PATH_MAX];
    const char *place; /* the argument: a folder, or a file */
    long keep;
};

static int report_failure(const char *why) {
    fprintf(stderr, "draped: %s\n", why);
    return FAILED;
}

static int misuse(const char *why) {
    fprintf(stderr, "draped: %s; see draped backup --help\n", why);
    return USAGE;
}

/* Reads it, and sets up the process. 0, or the exit status with a message; `done`: help was asked
 * for. */
static int parse_command(int argc, char **argv, struct command *command, bool *done) {
    char *rest[ARGUMENTS];
    *done = false;
    command->keep = KEEP;
    if (argc > ARGUMENTS)
        return misuse("too many arguments");
    int count = config_parse_store(argc - 2, argv + 2, &command->config, rest);
    for (int k = 0; k < count; k++) {
        char *end = NULL;
        if (!strcmp(rest[k], "--help")) {
            fputs(usage, stdout);
            *done = true;
            return 0;
        }
        if (!strcmp(rest[k], "--keep") && k + 1 < count && !strcmp(argv[1], "backup")) {
            command->keep = strtol(rest[++k], &end, 10);
            if (*end || !*rest[k] || command->keep < 0 || command->keep > KEEP_MOST)
                return misuse("--keep takes a number of files, 0 for all");
        } else if (rest[k][0] == '-' || command->place) {
            return misuse("invalid arguments");
        } else {
            command->place = rest[k];
        }
    }
    if (count < 0 || !config_store_url(&command->config, command->url))
        return USAGE;
    if (!command->place || !command->place[0])
        return misuse("it needs a folder");
    /* As the daemon: a full disk is told by errno, and what customers sent is for this account
     * alone. */
    log_init(LOG_LEVEL_ERROR);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    umask(077);
    return 0;
}

/* ------------------------------------------------------------------ copies in a folder */

static int is_copy(const struct dirent *entry) {
    size_t end = strlen(NAME_START) + BACKUP_TIME_SIZE - 1;
    return !strncmp(entry->d_name, NAME_START, strlen(NAME_START)) && strlen(entry->d_name) > end &&
           !strcmp(entry->d_name + end, NAME_END);
}

/* With SQLite's journal, log and index of the log beside it. */
static int is_part(const struct dirent *entry) {
    return !strncmp(entry->d_name, NAME_START, sizeof NAME_START - 1) &&
           strstr(entry->d_name, NAME_END PART_END) != NULL;
}

/* Removes what the filter finds, but for the last `keep` by name, which are the newest. */
static void remove_all(int folder, int (*filter)(const struct dirent *), long keep) {
    struct dirent **entries = NULL;
    int count = scandirat(folder, ".", &entries, filter, alphasort);
    for (int k = 0; k < count; k++) {
        if (k + keep < count && unlinkat(folder, entries[k]->d_name, 0) == 0 && filter == is_copy)
            printf("removed %s\n", entries[k]->d_name);
        free(entries[k]);
    }
    free(entries);
}

static bool join_path(char path[PATH_MAX], const char *folder, const char *name) {
    return snprintf(path, PATH_MAX, "%s/%s", folder, name) < PATH_MAX;
}

static void print_contents(const char *what, const struct backup_contents *contents,
                           const char *path) {
    struct stat status = {0};
    (void)stat(path, &status);
    printf("%s %s: schema %" PRId64 ", %" PRId64 " drapes, %" PRId64 " results, %" PRId64
           " surfaces, %lld bytes\n",
           what, path, contents->schema, backup_rows(contents, "jobs"),
           backup_rows(contents, "results"), backup_rows(contents, "surfaces"),
           (long long)status.st_size);
}

/* ------------------------------------------------------------------ backup */

int backup_command(int argc, char **argv) {
    struct command command = {0};
    char name[64], path[PATH_MAX], part[PATH_MAX], time[BACKUP_TIME_SIZE], why[STORE_WHY_SIZE];
    struct backup_contents contents;
    bool done = false;
    int code = parse_command(argc, argv, &command, &done);
    if (code != 0 || done)
        return code;
    /* The folder is for this command alone. */
    int folder = mkdir(command.place, 0700) != 0 && errno != EEXIST
                     ? -1
                     : open(command.place, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) {
        fprintf(stderr, "draped: %s: %s\n", command.place, strerror(errno));
        return FAILED;
    }
    if (flock(folder, LOCK_EX | LOCK_NB) != 0) {
        fprintf(stderr, "draped: %s: another back-up is being made there\n", command.place);
        close(folder);
        return FAILED;
    }
    backup_time(time);
    snprintf(name, sizeof name, NAME_START "%s" NAME_END, time);
    snprintf(why, sizeof why, "the name of the folder is too long");
    bool fits = join_path(path, command.place, name) &&
                snprintf(part, sizeof part, "%s" PART_END, path) < PATH_MAX;
    if (fits)
        remove_all(folder, is_part, 0);
    bool good = fits && backup_make(command.url, part, &contents, why);
    if (good && renameat2(AT_FDCWD, part, AT_FDCWD, path, RENAME_NOREPLACE) != 0) {
        snprintf(why, sizeof why, "the copy cannot be renamed: %s", strerror(errno));
        good = false;
    }
    if (fits && !good)
        remove_all(folder, is_part, 0);
    good = good && backup_sync(command.place, why);
    if (good)
        print_contents("backed up to", &contents, path);
    if (good && command.keep > 0)
        remove_all(folder, is_copy, command.keep);
    close(folder);
    if (!good)
        return report_failure(why);
    return fflush(stdout) != 0 ? FAILED : 0;
}

/* ------------------------------------------------------------------ restore */

int restore_command(int argc, char **argv) {
    struct command command = {0};
    char path[PATH_MAX], kept[BACKUP_KEPT_SIZE], why[STORE_WHY_SIZE];
    struct backup_contents contents;
    struct stat status;
    struct dirent **entries = NULL;
    bool done = false;
    int code = parse_command(argc, argv, &command, &done);
    if (code != 0 || done)
        return code;
    /* the file itself, or the newest copy of the folder */
    if (stat(command.place, &status) != 0) {
        fprintf(stderr, "draped: %s: %s\n", command.place, strerror(errno));
        return FAILED;
    }
    bool folder = S_ISDIR(status.st_mode);
    int count = folder ? scandir(command.place, &entries, is_copy, alphasort) : 0;
    bool found = folder ? count > 0 && join_path(path, command.place, entries[count - 1]->d_name)
                        : snprintf(path, PATH_MAX, "%s", command.place) < PATH_MAX;
    while (count > 0)
        free(entries[--count]);
    free(entries);
    if (folder && !found)
        fprintf(stderr, "draped: %s: there is no back-up in this folder\n", command.place);
    if (!found)
        return FAILED;
    if (!backup_restore(command.url, path, &contents, kept, why))
        return report_failure(why);
    print_contents("restored", &contents, path);
    if (kept[0])
        printf("the old store is kept as %s\n", kept);
    return fflush(stdout) != 0 ? FAILED : 0;
}
