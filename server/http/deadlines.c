/* SPDX-License-Identifier: MIT */
#include "deadlines.h"
#include "reply.h"
#include "request.h"
#include "server/id.h"
#include "server/log.h"
#include "server/resources/routes.h"
#include <pthread.h>
#include <stdlib.h>
#include <sys/socket.h>

enum { PACE_LINGER_MS = 2000 }; /* to read the 408 before the connection is closed */

struct pace {
    pthread_mutex_t lock;
    struct pace_client *clients; /* a list */
};

struct pace *pace_new(void) {
    struct pace *pace = calloc(1, sizeof *pace);
    if (pace)
        pthread_mutex_init(&pace->lock, NULL);
    return pace;
}

void pace_free(struct pace *pace) {
    if (!pace)
        return;
    pthread_mutex_destroy(&pace->lock);
    free(pace);
}

void pace_enter(struct pace *pace, struct pace_client *client, int socket) {
    *client = (struct pace_client){.socket = socket, .due = request_clock_ms() + PACE_HEAD_MS};
    pthread_mutex_lock(&pace->lock);
    client->next = pace->clients;
    if (client->next)
        client->next->previous = client;
    pace->clients = client;
    pthread_mutex_unlock(&pace->lock);
}

void pace_leave(struct pace *pace, struct pace_client *client) {
    pthread_mutex_lock(&pace->lock);
    *(client->previous ? &client->previous->next : &pace->clients) = client->next;
    if (client->next)
        client->next->previous = client->previous;
    pthread_mutex_unlock(&pace->lock);
}

/* `most` bounds the new time when `more` is added to the old one; without, it is the new one. */
static bool set(struct pace *pace, struct pace_client *client, bool replying, int64_t more,
                int64_t most) {
    pthread_mutex_lock(&pace->lock);
    bool good = !client->cut;
    if (good) {
        client->replying = replying;
        client->due = more && client->due + more < most ? client->due + more : most;
    }
    pthread_mutex_unlock(&pace->lock);
    return good;
}

bool pace_idle(struct pace *pace, struct pace_client *client) {
    return set(pace, client, false, 0, request_clock_ms() + PACE_IDLE_MS + PACE_HEAD_MS);
}

bool pace_body(struct pace *pace, struct pace_client *client) {
    return set(pace, client, false, 0, request_clock_ms() + PACE_BODY_MS);
}

/* What comes fast earns no right to dawdle later: the time left never exceeds the first one. */
bool pace_received(struct pace *pace, struct pace_client *client, size_t length) {
    int64_t more = (int64_t)length * 1000 / PACE_BODY_RATE;
    return set(pace, client, false, more, request_clock_ms() + PACE_BODY_MS);
}

bool pace_hold(struct pace *pace, struct pace_client *client) {
    return set(pace, client, true, 0, INT64_MAX);
}

bool pace_reply(struct pace *pace, struct pace_client *client, size_t length) {
    int64_t due = request_clock_ms() + PACE_REPLY_MS + (int64_t)length * 1000 / PACE_BODY_RATE;
    return set(pace, client, true, 0, due);
}

static void say_timeout(int socket) {
    char id[ID_SIZE];
    id_make(id);
    int status = reply_on_socket(socket, id, API_TIMEOUT, "the request did not arrive in time");
    log_info(log_event("request_timeout"), log_text("request_id", id));
    routes_count(NULL, status, 0);
}

/* With the lock. The second time, or in the midst of a reply, at once. */
static void cut(struct pace_client *client, int64_t now) {
    bool at_once = client->cut || client->replying;
    if (!at_once)
        say_timeout(client->socket);
    shutdown(client->socket, at_once ? SHUT_RDWR : SHUT_WR);
    client->due = at_once ? INT64_MAX : now + PACE_LINGER_MS;
    client->cut = true;
}

int pace_reap(struct pace *pace, int64_t now) {
    int count = 0;
    pthread_mutex_lock(&pace->lock);
    for (struct pace_client *client = pace->clients; client; client = client->next) {
        if (client->due > now)
            continue;
        count += !client->cut;
        cut(client, now);
    }
    pthread_mutex_unlock(&pace->lock);
    return count;
}
