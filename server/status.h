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

#endif
