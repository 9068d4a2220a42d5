/* SPDX-License-Identifier: MIT */
#include "client.h"
#include "interpose.h"
#include "lingering_close.h"
#include "owner.h"
#include "server/config.h"
#include "server/id.h"
#include "server/log.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

struct client *client_open(struct http *http, int socket, const struct sockaddr *peer) {
    char owner[REQUEST_CALLER_SIZE];
    struct client *client = calloc(1, sizeof *client);
    if (!client)
        return NULL;
    client->http = http;
    wire_init(&client->wire);
    if (peer && (peer->sa_family == AF_INET || peer->sa_family == AF_INET6))
        memcpy(&client->peer, peer,
               peer->sa_family == AF_INET ? sizeof(struct sockaddr_in)
                                          : sizeof(struct sockaddr_in6));
    peer = (const struct sockaddr *)&client->peer;
    owner_of_address(peer, owner);
    if (!interpose_watch(socket, client) ||
        !admission_enter(http->admissions, &client->admission, owner,
                         owner_trusts(http->settings.config->trusted_proxy, peer), socket)) {
        interpose_watch(socket, NULL);
        shutdown(socket, SHUT_RDWR);
        free(client);
        return NULL;
    }
    deadlines_add(http->deadlines, &client->deadline, socket,
                  client->admission.how == ADMISSION_SERVED ? DEADLINES_HEAD_MS
                                                            : DEADLINES_RESERVE_MS);
    return client;
}

void client_close(struct client *client) {
    interpose_watch(client->deadline.socket, NULL);
    deadlines_remove(client->http->deadlines, &client->deadline);
    admission_leave(client->http->admissions, &client->admission);
    free(client);
}

ssize_t client_received(void *context, const char *bytes, size_t length) {
    struct client *client = context;
    struct wire *wire = &client->wire;
    admission_heard(&client->admission);
    size_t begun, good = client->refused ? 0 : wire_check(wire, bytes, length, &begun);
    if (!client->refused && wire->problem == API_OK)
        return (ssize_t)good;
    if (!client->refused && client->ended < wire->messages && begun > 0)
        return (ssize_t)begun; /* those before it are answered first */
    client_refuse(client, wire->problem, wire->detail);
    errno = ECONNRESET;
    return -1;
}

bool client_checked(const struct client *client, bool whole) {
    const struct wire *wire = &client->wire;
    return client->ended < wire->messages || (!whole && !wire_between(wire));
}

void client_ended(struct client *client) {
    client->ended++;
    admission_busy(client->http->admissions, &client->admission, false);
    if (client->wire.problem == API_OK || client->ended < client->wire.messages)
        return;
    if (!client->wire.closing)
        client_refuse(client, client->wire.problem, client->wire.detail);
    client->refused = true;
    deadlines_cut(client->http->deadlines, &client->deadline);
}

void client_refuse(struct client *client, enum api_problem_id problem, const char *detail) {
    const struct http_handler *handler = &client->http->settings.handler;
    struct exchange *exchange = client->exchange;
    if (client->refused)
        return;
    char made[ID_SIZE];
    const char *id = exchange && exchange->request->id[0] ? exchange->request->id : made;
    id_make(made);
    client->refused = true;
    int status = reply_on_socket(client->deadline.socket, id, problem, detail);
    lingering_close_add(client->http->linger, client->deadline.socket);
    shutdown(client->deadline.socket, SHUT_WR);
    if (exchange)
        exchange->reply.status = status;
    log_info(log_event("request_refused"), log_text("request_id", id), log_int("status", status),
             log_text("why", detail));
    if (!exchange)
        handler->count(handler->context, NULL, status, 0);
}

void client_refuse_status(struct client *client, unsigned status) {
    static const struct {
        unsigned status;
        enum api_problem_id problem;
        const char *of_head, *of_body; /* NULL: the same */
    } answers[] = {
        {413, API_TOO_LARGE, "the body is too large", "a chunk of the body is too large"},
        {414, API_TARGET_TOO_LONG, "the request line is too long", NULL},
        {431, API_HEADERS_TOO_LARGE, "the headers are too long", NULL},
        {500, API_UNAVAILABLE, "there is no memory for the request now", NULL},
        {505, API_HTTP_VERSION, "the request uses another version of HTTP than 1.1 and 1.0", NULL},
        {400, API_BAD_REQUEST, "the request line or a header is malformed",
         "the chunks of the body are malformed"},
    };
    const size_t last = sizeof answers / sizeof *answers - 1; /* stands for all others */
    bool body = client->exchange && client->exchange->known;
    size_t k = 0;
    while (k < last && answers[k].status != status)
        k++;
    client_refuse(client, answers[k].problem,
                  body && answers[k].of_body ? answers[k].of_body : answers[k].of_head);
}

void client_refuse_late(void *context, int socket) {
    const struct http_handler *handler = &((struct http *)context)->settings.handler;
    char id[ID_SIZE];
    id_make(id);
    int status = reply_on_socket(socket, id, API_TIMEOUT, "the request did not arrive in time");
    log_info(log_event("request_timeout"), log_text("request_id", id));
    handler->count(handler->context, NULL, status, 0);
}
