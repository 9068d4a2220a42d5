/* SPDX-License-Identifier: MIT */
/*
 * What libmicrohttpd alone can do on this machine at this moment: a daemon with the flags, threads
 * and limits of server/http/http.c, whose handler answers every request with the file it is given.
 * Says where it listens as draped does, and ends with its standard input. Usage: bare FILE
 */
#include <arpa/inet.h>
#include <microhttpd.h>
#include <stdio.h>
#include <unistd.h>

enum {
    DOCUMENT_BYTES = 64 * 1024,
    POOL_BYTES = 48 * 1024,
    CONNECTIONS = 4096,
    IDLE_SECONDS = 60,
    THREADS_PER_CORE = 4,
    THREADS_MAX = 16
};

static char document[DOCUMENT_BYTES];
static size_t length;

static enum MHD_Result handle(void *context, struct MHD_Connection *connection, const char *url,
                              const char *method, const char *version, const char *data,
                              size_t *size, void **state) {
    (void)context, (void)url, (void)method, (void)version, (void)data, (void)size;
    if (!*state) { /* as draped does: the first call is for the headers */
        *state = connection;
        return MHD_YES;
    }
    struct MHD_Response *response =
        MHD_create_response_from_buffer(length, document, MHD_RESPMEM_PERSISTENT);
    if (!response)
        return MHD_NO;
    MHD_add_response_header(response, "Content-Type", "application/json");
    enum MHD_Result result = MHD_queue_response(connection, MHD_HTTP_OK, response);
    MHD_destroy_response(response);
    return result;
}

int main(int argc, char **argv) {
    FILE *file = argc == 2 ? fopen(argv[1], "r") : NULL;
    if (!file)
        return 2;
    length = fread(document, 1, sizeof document, file);
    fclose(file);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    long wanted = cores < 1 ? 1 : cores * THREADS_PER_CORE;
    unsigned threads = (unsigned)(wanted < THREADS_MAX ? wanted : THREADS_MAX);
    struct sockaddr_in address = {.sin_family = AF_INET,
                                  .sin_addr = {.s_addr = htonl(INADDR_LOOPBACK)}};
    struct MHD_Daemon *daemon = MHD_start_daemon(
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_ITC | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG,
        0, NULL, NULL, handle, NULL, MHD_OPTION_SOCK_ADDR, &address, MHD_OPTION_THREAD_POOL_SIZE,
        threads, MHD_OPTION_CONNECTION_LIMIT, (unsigned)CONNECTIONS, MHD_OPTION_CONNECTION_TIMEOUT,
        (unsigned)IDLE_SECONDS, MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)POOL_BYTES,
        MHD_OPTION_END);
    const union MHD_DaemonInfo *info =
        daemon ? MHD_get_daemon_info(daemon, MHD_DAEMON_INFO_BIND_PORT) : NULL;
    if (!info)
        return 1;
    printf("bare listening on http://127.0.0.1:%u\n", info->port);
    fflush(stdout);
    char byte;
    while (read(STDIN_FILENO, &byte, 1) > 0)
        continue;
    MHD_stop_daemon(daemon);
    return 0;
}
