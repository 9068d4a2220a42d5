/* SPDX-License-Identifier: MIT */
#include "admission.h"
#include "server/clock.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

/* A new connection looks idle until its first request arrives. */
enum { GRACE_US = 100 * 1000 };

/* The list is walked only when places are short. */
struct admissions {
    struct shares *shares;
    pthread_mutex_t lock;
    int64_t most, owner_most;
    int64_t served, reserved, closing;
    struct admission_client *clients; /* a list */
};

struct admissions *admissions_new(struct shares *shares, int64_t most, int64_t owner_most) {
    struct admissions *admissions = calloc(1, sizeof *admissions);
    if (!admissions)
        return NULL;
    admissions->shares = shares;
    admissions->most = most;
    admissions->owner_most = owner_most;
    pthread_mutex_init(&admissions->lock, NULL);
    return admissions;
}

void admissions_free(struct admissions *admissions) {
    if (!admissions)
        return;
    pthread_mutex_destroy(&admissions->lock);
    free(admissions);
}

/* ------------------------------------------------------------------ counting */

/* How many connections of the owner are served. */
static int64_t count(const struct admissions *admissions, const char *owner) {
    return shares_of(admissions->shares, owner, SHARES_CONNECTIONS);
}

/* False without memory. */
static bool take_place(struct admissions *admissions, const struct admission_client *client) {
    if (client->how != ADMISSION_SERVED)
        admissions->reserved++;
    else if (shares_take(admissions->shares, client->owner, SHARES_CONNECTIONS, 1, INT64_MAX))
        admissions->served++;
    else
        return false;
    return true;
}

static void leave_place(struct admissions *admissions, const struct admission_client *client) {
    if (client->closing) {
        admissions->closing--;
    } else if (client->how == ADMISSION_SERVED) {
        admissions->served--;
        shares_give(admissions->shares, client->owner, SHARES_CONNECTIONS, 1);
    } else {
        admissions->reserved--;
    }
}

/* ------------------------------------------------------------------ making room */

/* Whether a request may be on its way up from the socket: its thread has not come to read it. */
static bool has_unread(const struct admission_client *client) {
    int bytes = 0;
    return ioctl(client->socket, FIONREAD, &bytes) == 0 && bytes > 0;
}

/* Whether it may be closed for another, as far as is known without asking the system. */
static bool looks_idle(const struct admission_client *client, bool served) {
    int64_t latest = clock_us() - (served ? GRACE_US : 0);
    return !client->busy && !client->closing && served == (client->how == ADMISSION_SERVED) &&
           atomic_load(&client->active_us) <= latest;
}

static bool idle_longer(const struct admission_client *client,
                        const struct admission_client *than) {
    return !than || atomic_load(&client->active_us) < atomic_load(&than->active_us);
}

/* The one that has been idle longest, of the owner (NULL: of any), served or in reserve. */
static struct admission_client *find_idle(const struct admissions *admissions, const char *owner,
                                          bool served) {
    struct admission_client *found = NULL;
    for (struct admission_client *client = admissions->clients; client; client = client->next)
        if (looks_idle(client, served) && (!owner || !strcmp(client->owner, owner)) &&
            idle_longer(client, found) && !has_unread(client))
            found = client;
    return found;
}

/* The one that has been idle longest of the owner who has most, among those with idle ones. */
static struct admission_client *find_idle_of_most(const struct admissions *admissions) {
    struct admission_client *found = NULL;
    int64_t most = 0;
    for (struct admission_client *client = admissions->clients; client; client = client->next) {
        if (!looks_idle(client, true))
            continue;
        bool same = found && !strcmp(found->owner, client->owner);
        int64_t has = same ? most : count(admissions, client->owner);
        if ((has > most || (has == most && idle_longer(client, found))) && !has_unread(client)) {
            most = has;
            found = client;
        }
    }
    return found;
}

/* Its thread notices and lets it go. False: there was none. */
static bool close_idle(struct admissions *admissions, struct admission_client *client) {
    if (!client || admissions->closing >= ADMISSION_CLOSING)
        return false;
    leave_place(admissions, client);
    client->closing = true;
    admissions->closing++;
    shutdown(client->socket, SHUT_RDWR);
    return true;
}

/* ------------------------------------------------------------------ coming and going */

static enum admission place(struct admissions *admissions, const struct admission_client *client) {
    bool bounded = !client->shared && admissions->owner_most < admissions->most;
    if (admissions->served >= admissions->owner_most && bounded &&
        count(admissions, client->owner) >= admissions->owner_most &&
        !close_idle(admissions, find_idle(admissions, client->owner, true)))
        return ADMISSION_OWNER_FULL;
    if (admissions->served >= admissions->most &&
        !close_idle(admissions, find_idle_of_most(admissions)))
        return ADMISSION_FULL;
    return ADMISSION_SERVED;
}

bool admission_enter(struct admissions *admissions, struct admission_client *client,
                     const char *owner, bool shared, int socket) {
    *client =
        (struct admission_client){.socket = socket, .shared = shared, .active_us = clock_us()};
    snprintf(client->owner, sizeof client->owner, "%s", owner);
    pthread_mutex_lock(&admissions->lock);
    client->how = place(admissions, client);
    bool good = client->how == ADMISSION_SERVED || admissions->reserved < ADMISSION_RESERVE ||
                close_idle(admissions, find_idle(admissions, NULL, false));
    good = good && take_place(admissions, client);
    if (good) {
        client->next = admissions->clients;
        if (client->next)
            client->next->previous = client;
        admissions->clients = client;
    }
    pthread_mutex_unlock(&admissions->lock);
    return good;
}

void admission_leave(struct admissions *admissions, struct admission_client *client) {
    pthread_mutex_lock(&admissions->lock);
    leave_place(admissions, client);
    *(client->previous ? &client->previous->next : &admissions->clients) = client->next;
    if (client->next)
        client->next->previous = client->previous;
    pthread_mutex_unlock(&admissions->lock);
}

void admission_busy(struct admissions *admissions, struct admission_client *client, bool busy) {
    pthread_mutex_lock(&admissions->lock);
    client->busy = busy;
    atomic_store(&client->active_us, clock_us());
    pthread_mutex_unlock(&admissions->lock);
}

void admission_heard(struct admission_client *client) {
    atomic_store(&client->active_us, clock_us());
}
