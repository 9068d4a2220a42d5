/* SPDX-License-Identifier: MIT */
#include "deadlines.h"
#include "server/clock.h"
#include <linux/sockios.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

enum { DEADLINES_LINGER_MS = 2000 }; /* to read the 408 before the connection is closed */

struct deadlines {
    deadlines_late *late;
    void *context;
    pthread_mutex_t lock;
    struct deadlines_client *clients; /* a list */
};

struct deadlines *deadlines_new(deadlines_late *late, void *context) {
    struct deadlines *deadlines = calloc(1, sizeof *deadlines);
    if (!deadlines)
        return NULL;
    deadlines->late = late;
    deadlines->context = context;
    pthread_mutex_init(&deadlines->lock, NULL);
    return deadlines;
}

void deadlines_free(struct deadlines *deadlines) {
    if (!deadlines)
        return;
    pthread_mutex_destroy(&deadlines->lock);
    free(deadlines);
}

void deadlines_add(struct deadlines *deadlines, struct deadlines_client *client, int socket,
                   int64_t ms) {
    *client = (struct deadlines_client){.socket = socket, .due = clock_ms() + ms};
    pthread_mutex_lock(&deadlines->lock);
    client->next = deadlines->clients;
    if (client->next)
        client->next->previous = client;
    deadlines->clients = client;
    pthread_mutex_unlock(&deadlines->lock);
}

void deadlines_remove(struct deadlines *deadlines, struct deadlines_client *client) {
    pthread_mutex_lock(&deadlines->lock);
    *(client->previous ? &client->previous->next : &deadlines->clients) = client->next;
    if (client->next)
        client->next->previous = client->previous;
    pthread_mutex_unlock(&deadlines->lock);
}

/* `most` bounds the new time when `more` is added to the old one; without, it is the new one. */
static bool set_due(struct deadlines *deadlines, struct deadlines_client *client, bool replying,
                    int64_t more, int64_t most) {
    pthread_mutex_lock(&deadlines->lock);
    bool good = !client->cut;
    if (good) {
        client->replying = replying;
        client->due = more && client->due + more < most ? client->due + more : most;
    }
    pthread_mutex_unlock(&deadlines->lock);
    return good;
}

bool deadlines_idle(struct deadlines *deadlines, struct deadlines_client *client) {
    return set_due(deadlines, client, false, 0, clock_ms() + DEADLINES_IDLE_MS + DEADLINES_HEAD_MS);
}

bool deadlines_body(struct deadlines *deadlines, struct deadlines_client *client) {
    return set_due(deadlines, client, false, 0, clock_ms() + DEADLINES_BODY_MS);
}

/* What comes fast earns no right to dawdle later: the time left never exceeds the first one. */
bool deadlines_received(struct deadlines *deadlines, struct deadlines_client *client,
                        size_t length) {
    int64_t more = (int64_t)length * 1000 / DEADLINES_BODY_RATE;
    return set_due(deadlines, client, false, more, clock_ms() + DEADLINES_BODY_MS);
}

bool deadlines_suspend(struct deadlines *deadlines, struct deadlines_client *client) {
    return set_due(deadlines, client, true, 0, INT64_MAX);
}

bool deadlines_reply(struct deadlines *deadlines, struct deadlines_client *client, size_t length) {
    int64_t due = clock_ms() + DEADLINES_REPLY_MS + (int64_t)length * 1000 / DEADLINES_BODY_RATE;
    return set_due(deadlines, client, true, 0, due);
}

void deadlines_cut(struct deadlines *deadlines, struct deadlines_client *client) {
    pthread_mutex_lock(&deadlines->lock);
    client->due = clock_ms() + DEADLINES_LINGER_MS;
    client->cut = true;
    pthread_mutex_unlock(&deadlines->lock);
}

/* While the client has sent what we have not read, or fetched all that it was given of a reply, it
 * is our turn. The second time, or in the midst of a reply, it is cut off at once. */
int deadlines_reap(struct deadlines *deadlines, int64_t now) {
    int count = 0;
    pthread_mutex_lock(&deadlines->lock);
    for (struct deadlines_client *client = deadlines->clients; client; client = client->next) {
        bool at_once = client->cut || client->replying;
        int unread = 0, unfetched = 0;
        if (client->due > now)
            continue;
        if (!client->cut &&
            (client->replying ? !ioctl(client->socket, SIOCOUTQ, &unfetched) && !unfetched
                              : !ioctl(client->socket, SIOCINQ, &unread) && unread > 0))
            continue;
        count += !client->cut;
        if (!at_once)
            deadlines->late(deadlines->context, client->socket);
        shutdown(client->socket, at_once ? SHUT_RDWR : SHUT_WR);
        client->due = at_once ? INT64_MAX : now + DEADLINES_LINGER_MS;
        client->cut = true;
    }
    pthread_mutex_unlock(&deadlines->lock);
    return count;
}
