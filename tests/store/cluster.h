/* SPDX-License-Identifier: MIT */
/*
 * A PostgreSQL server of the test program's own: in a temporary folder, on a socket in there alone,
 * run as the user `postgres` when the tests run as root. It ends with the program, however that
 * ends.
 */
#ifndef TESTS_CLUSTER_H
#define TESTS_CLUSTER_H

#include <sys/types.h>

enum { CLUSTER_URL_SIZE = 256 };

#define CLUSTER_PASSWORD "se/cr@t%1" /* in URLs se%2Fcr%40t%251 */

struct cluster {
    char folder[64];
    char url[CLUSTER_URL_SIZE]; /* of its database `draped`, for the superuser `draped` */
    pid_t pid;                  /* of the server; 0: it does not run */
};

/* Makes it and starts it. Fails the test where that cannot be done. */
void cluster_start(struct cluster *cluster);

/* Ends the server as by SIGINT or, `hard`, as a power cut would; and starts it again. */
void cluster_halt(struct cluster *cluster, int hard);
void cluster_resume(struct cluster *cluster);

/* Ends it and removes the folder. */
void cluster_remove(struct cluster *cluster);

/* The URL of the same server with another user, password and database. */
void cluster_url(const struct cluster *cluster, const char *user, const char *password,
                 const char *database, char url[CLUSTER_URL_SIZE]);

/* Starts a program of PostgreSQL or another in the cluster's folder, as the server's user, with its
 * output in a file there; it gets SIGINT when this program ends. */
pid_t cluster_spawn(const struct cluster *cluster, const char *name, const char *const *arguments);

/* The same, and waits for its success. */
void cluster_run(const struct cluster *cluster, const char *name, const char *const *arguments);

/* Gives a file in the folder to the server's user. */
void cluster_own(const struct cluster *cluster, const char *name);

#endif
