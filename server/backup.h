/* SPDX-License-Identifier: MIT */
/*
 * `draped backup` and `draped restore`: copies of the store in a folder, named by their time.
 *
 * A copy is written under another name, brought to the disk, read back and compared, and only then
 * gets its name; whatever happens, the copies that were there before are there. One copy is made at
 * a time in a folder; what one that was killed has left is removed by the next. When a new copy is
 * whole, the oldest beyond --keep are removed.
 */
#ifndef SERVER_BACKUP_H
#define SERVER_BACKUP_H

/* draped backup FOLDER [--keep N] [--data DIR] [--store URL] */
int backup_command(int argc, char **argv);

/* draped restore FILE|FOLDER [--data DIR] [--store URL]: of a folder the newest copy. */
int restore_command(int argc, char **argv);

/* Both return the exit status: 0; 1 when it did not succeed, with the reason on stderr; 2 for
 * arguments that make no sense. */

#endif
