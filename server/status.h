/* SPDX-License-Identifier: MIT */
/*
 * `draped status [--data DIR] [--store URL]`: what an operator asks first, read from the store
 * itself, whether a daemon runs or not: the queue, hosts and workers, the last error.
 */
#ifndef SERVER_STATUS_H
#define SERVER_STATUS_H

/* The exit status: 0 when the service can work; 1 when the store cannot be read, no host shows
 * life, or drapes wait without workers; 2 for arguments that make no sense. */
int status_command(int argc, char **argv);

/* `draped check [--data DIR] [--store URL]` reads everything in the store and lists what is
 * damaged. 0: nothing is; 1: something is, or the store cannot be read; 2 as above. */
int check_command(int argc, char **argv);

#endif
