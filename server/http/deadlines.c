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

/* What comes fast earns no right to dawdle later: the time left for a body never exceeds the first
 * one. */
bool deadlines_turn(struct deadlines *deadlines, struct deadlines_client *client,
                    enum deadlines_turn turn, size_t length) {
    const int64_t now = clock_ms(), more = (int64_t)length * 1000 / DEADLINES_BODY_RATE;
    const int64_t due[] = {[DEADLINES_IDLE] = now + DEADLINES_IDLE_MS + DEADLINES_HEAD_MS,
                           [DEADLINES_BODY] = now + DEADLINES_BODY_MS,
                           [DEADLINES_RECEIVED] = now + DEADLINES_BODY_MS,
                           [DEADLINES_OURS] = INT64_MAX,
                           [DEADLINES_REPLY] = now + DEADLINES_REPLY_MS + more};
    pthread_mutex_lock(&deadlines->lock);
    bool good = !client->cut;
    bool added = turn == DEADLINES_RECEIVED && more && client->due + more < due[turn];
    if (good) {
        client->replying = turn >= DEADLINES_OURS;
        client->due = added ? client->due + more : due[turn];
    }
    pthread_mutex_unlock(&deadlines->lock);
    return good;
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
