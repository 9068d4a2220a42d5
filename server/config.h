/* SPDX-License-Identifier: MIT */
/*
 * The configuration: flags of the command line, else environment variables DRAPED_*, else defaults.
 * One table (flags.c) drives parsing, --help, --check-config and GET /v1/limits, so that they
 * cannot differ.
 */
#ifndef SERVER_CONFIG_H
#define SERVER_CONFIG_H

#include "api/limits.h"
#include "solver/version.h"
#include <limits.h>
#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/socket.h>

enum config_role { CONFIG_ROLE_ALL, CONFIG_ROLE_API, CONFIG_ROLE_WORKER };

/* Read-only once parsed. The strings live as long as argv, the environment and the struct. */
struct config {
    const char *listen;              /* as written, ADDR:PORT */
    struct sockaddr_storage address; /* of `listen`; port 0: any free one */
    socklen_t address_length;
    char listen_name[INET6_ADDRSTRLEN + 8]; /* of a socket handed over, or of "*" */
    int inherited;              /* the socket the service manager handed over; -1: none */
    bool loopback;              /* whether only this machine can reach it */
    const char *data;           /* folder of the embedded store; created when missing */
    const char *store;          /* URL; empty: SQLite in `data` */
    int64_t workers;            /* worker processes, 1..1024 */
    int64_t role;               /* enum config_role */
    const char *tokens;         /* empty: none */
    bool allow_anonymous;       /* may listen beyond loopback without tokens */
    int64_t queue_limit;        /* queued jobs */
    int64_t max_body;           /* bytes of a request's body */
    int64_t max_mesh;           /* bytes of the body of a map */
    int64_t max_bodies;         /* bytes of all bodies that are being received */
    const char *public_name;    /* names of the service, split by commas; "*": any */
    const char *cors_origin;    /* origins of web pages, split by commas; empty: none; "*": all */
    int64_t max_nodes;          /* nodes of one drape */
    int64_t max_variants;       /* of one study */
    int64_t max_control_points; /* of one surface */
    int64_t max_elements;       /* JSON values of one body */
    int64_t threads_per_job;    /* threads of one drape */
    int64_t max_depth;          /* JSON nesting */
    int64_t job_timeout;        /* seconds one attempt may take */
    int64_t lease;              /* seconds a claim holds without renewal */
    int64_t job_memory;         /* bytes one job may hold */
    int64_t check_memory;       /* bytes that all bodies being read may take together */
    int64_t check_timeout;      /* seconds that reading one body may take */
    int64_t import_timeout;     /* seconds that importing one CAD file may take */
    int64_t max_result;         /* bytes of one stored result */
    int64_t retention;          /* hours a result is kept after its job ended */
    int64_t retention_jobs;     /* hours a record of a job is kept after it ended */
    int64_t retention_bytes;    /* of all results together; 0: no bound */
    int64_t max_connections;
    const char *trusted_proxy; /* addresses, split by commas, whose Forwarded counts; empty: none */
    /* What one owner may have of what is there for all. */
    int64_t owner_queue;   /* queued jobs */
    int64_t owner_running; /* running jobs; 0: no bound */
    int64_t owner_bytes;   /* stored; 0: no bound */
    int64_t owner_connections;
    int64_t owner_streams; /* event streams and calls that wait */
    int64_t owner_bodies;  /* bytes of bodies that are being received or read */
    int64_t drain_timeout; /* seconds running jobs get at SIGTERM */
    int64_t log_level;     /* enum log_level */
};

/* What to do after parsing. */
enum config_verdict {
    CONFIG_RUN,   /* go on */
    CONFIG_DONE,  /* --help, --version, --check-config were answered on stdout: exit 0 */
    CONFIG_PROBE, /* --healthcheck: ask the daemon that runs with this configuration */
    CONFIG_BAD    /* a message is on stderr: exit 2 */
};

/* Fills `config` from the arguments (argv[0] is skipped) and the environment. A socket that the
 * service manager handed over goes before --listen. */
enum config_verdict config_parse(int argc, char **argv, struct config *config);

/* For commands that use the store alone: takes --data and --store from the arguments, else from the
 * environment, and puts the other arguments into `rest`, which has room for all. How many those
 * are; -1 with a message on stderr. */
int config_parse_store(int argc, char **argv, struct config *config, char **rest);

/* The store's URL or path: as configured, else a file in the data folder. False with a message on
 * stderr when it is too long. */
bool config_store_url(const struct config *config, char url[PATH_MAX]);

/* What one job may cost, on so many threads. */
struct api_limits config_limits(const struct config *config, int threads);

/* Writes the --help text. */
void config_help(FILE *out);

/* The limits callers may want to know, a JSON object {"max_body": 67108864, ...}; malloc'ed, NULL
 * without memory. */
char *config_limits_json(const struct config *config);

#endif
