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
enum { GRACE_US = 100 * 1000, OWNERS = 64 };

/* The lists are walked only when connections are short, and those of an owner no more often than
 * one of them can have become idle: else whoever has busy ones alone, and goes on connecting, would
 * keep all threads waiting for the lock. */
struct admissions {
    struct quotas *quotas;
    pthread_mutex_t lock;
    int64_t owner_most;
    int64_t reserved, closing;
    struct {
        struct admission_client *first, *last;
    } clients[2]; /* lists: in reserve, served; who came, or ended a request, before others first */
    struct findings {
        char owner[REQUEST_CALLER_SIZE]; /* "": any */
        int64_t busy_until_us;           /* none that is served is idle before */
        int64_t most_until_us;           /* nobody had more, and is looked at before */
    } findings[OWNERS];
};

struct admissions *admissions_new(struct quotas *quotas, int64_t owner_most) {
    struct admissions *admissions = calloc(1, sizeof *admissions);
    if (!admissions)
        return NULL;
    admissions->quotas = quotas;
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
static int64_t count_served(const struct admissions *admissions, const char *owner) {
    return quotas_of(admissions->quotas, owner, QUOTAS_CONNECTIONS);
}

static void give_back(struct admissions *admissions, const struct admission_client *client) {
    if (client->closing) {
        admissions->closing--;
    } else if (client->how == ADMISSION_SERVED) {
        quotas_give(admissions->quotas, client->owner, QUOTAS_CONNECTIONS, 1);
    } else {
        admissions->reserved--;
    }
}

static void append_client(struct admissions *admissions, struct admission_client *client) {
    bool served = client->how == ADMISSION_SERVED;
    struct admission_client *last = admissions->clients[served].last;
    client->next = NULL;
    client->previous = last;
    *(last ? &last->next : &admissions->clients[served].first) = client;
    admissions->clients[served].last = client;
}

static void withdraw_client(struct admissions *admissions, struct admission_client *client) {
    bool served = client->how == ADMISSION_SERVED;
    struct admission_client *next = client->next, *previous = client->previous;
    *(previous ? &previous->next : &admissions->clients[served].first) = next;
    *(next ? &next->previous : &admissions->clients[served].last) = previous;
}

/* ------------------------------------------------------------------ making room */

/* Whether a request may be on its way up from the socket: its thread has not come to read it. It
 * counts as heard now, so that the system is not asked again at once. */
static bool has_unread(struct admission_client *client, int64_t now) {
    int bytes = 0;
    bool unread = ioctl(client->socket, FIONREAD, &bytes) == 0 && bytes > 0;
    if (unread)
        atomic_store(&client->active_us, now);
    return unread;
}

/* Since when it has been idle, or from when it may be, at the earliest. */
static int64_t idle_since(const struct admission_client *client, int64_t now) {
    bool served = client->how == ADMISSION_SERVED;
    return client->busy ? now + GRACE_US
                        : atomic_load(&client->active_us) + (served ? GRACE_US : 0);
}

static bool idle_longer(const struct admission_client *client,
                        const struct admission_client *than) {
    return !than || atomic_load(&client->active_us) < atomic_load(&than->active_us);
}

/* What was found for the owner; two with the same number are walked for more often. */
static struct findings *findings_of(struct admissions *admissions, const char *owner) {
    struct findings *findings = &admissions->findings[id_hash(owner) % OWNERS];
    if (strcmp(findings->owner, owner) != 0) {
        memset(findings, 0, sizeof *findings);
        snprintf(findings->owner, sizeof findings->owner, "%s", owner);
    }
    return findings;
}

/* The one that has been idle longest, of the owner ("": of the one who has most, among those with
 * idle ones). NULL: there is none, or no more may be closed now. */
static struct admission_client *find_idle(struct admissions *admissions, const char *owner) {
    struct admission_client *found = NULL;
    int64_t now = clock_us(), next = now + GRACE_US, most = 0;
    struct findings *findings = findings_of(admissions, owner);
    if (admissions->closing >= ADMISSION_CLOSING || now < findings->busy_until_us)
        return NULL;
    for (struct admission_client *client = admissions->clients[1].first; client;
         client = client->next) {
        if (client->closing || (*owner && strcmp(client->owner, owner) != 0))
            continue;
        int64_t since = idle_since(client, now);
        if (since > now) {
            next = since < next ? since : next;
            continue;
        }
        bool same = *owner || (found && !strcmp(found->owner, client->owner));
        int64_t has = same ? most : count_served(admissions, client->owner);
        if ((has > most || (has == most && idle_longer(client, found))) &&
            !has_unread(client, now)) {
            most = has;
            found = client;
        }
    }
    if (!found)
        findings->busy_until_us = next;
    return found;
}

/* The one that was heard longest ago, busy or not, of the owner who has most, if that is more than
 * the `least` of this owner. Those of proxies are of many owners, and left alone. */
static struct admission_client *find_any(struct admissions *admissions, const char *owner,
                                         int64_t least) {
    struct findings *findings = findings_of(admissions, owner);
    struct admission_client *found = NULL, *last = NULL;
    int64_t now = clock_us(), most = least, has = 0;
    if (now < findings->most_until_us)
        return NULL;
    for (struct admission_client *client = admissions->clients[1].first; client;
         client = client->next) {
        if (client->closing || client->shared)
            continue;
        if (!last || strcmp(last->owner, client->owner) != 0)
            has = count_served(admissions, client->owner);
        last = client;
        if (has > most || (found && has == most && idle_longer(client, found))) {
            most = has;
            found = client;
        }
    }
    if (!found)
        findings->most_until_us = now + GRACE_US;
    return found;
}

/* Its thread notices and lets it go. False: there was none. */
static bool close_client(struct admissions *admissions, struct admission_client *client) {
    if (!client || admissions->closing >= ADMISSION_CLOSING)
        return false;
    give_back(admissions, client);
    client->closing = true;
    admissions->closing++;
    shutdown(client->socket, SHUT_RDWR);
    return true;
}

/* ------------------------------------------------------------------ coming and going */

/* While an owner has less than is left it gets one more, beyond that as long as another has more.
 * The last ones are taken from who has most: idle ones, or else any. */
static enum admission admit(struct admissions *admissions, const struct admission_client *client) {
    const char *owner = client->owner;
    const int64_t held = count_served(admissions, owner), most = admissions->owner_most;
    bool left = quotas_left(admissions->quotas, QUOTAS_CONNECTIONS) > 0;
    bool good = left && (client->shared ||
                         quotas_fit(admissions->quotas, owner, QUOTAS_CONNECTIONS, 1, most));
    if (!good && !left && held < most) {
        /* in place of one of an owner who has more than the new one's; for a proxy, of anybody */
        struct admission_client *idle = find_idle(admissions, "");
        good = idle && (client->shared || count_served(admissions, idle->owner) > held) &&
               close_client(admissions, idle);
    }
    if (!good && held > 0)
        good = close_client(admissions, find_idle(admissions, owner));
    if (!good && held < most) {
        /* in place of any one of the owner who has most, if that leaves it no fewer than the new
         * one's; where some are left, it need not go */
        struct admission_client *any = find_any(admissions, owner, held + 1);
        good = any && (left || close_client(admissions, any));
    }
    return good                          ? ADMISSION_SERVED
           : held > 0 && !client->shared ? ADMISSION_OWNER_FULL
                                         : ADMISSION_FULL;
}

bool admission_enter(struct admissions *admissions, struct admission_client *client,
                     const char *owner, bool shared, int socket) {
    *client =
        (struct admission_client){.socket = socket, .shared = shared, .active_us = clock_us()};
    snprintf(client->owner, sizeof client->owner, "%s", owner);
    pthread_mutex_lock(&admissions->lock);
    client->how = admit(admissions, client);
    bool served = client->how == ADMISSION_SERVED;
    bool good = served ? quotas_add(admissions->quotas, client->owner, QUOTAS_CONNECTIONS, 1)
                       : admissions->reserved < ADMISSION_RESERVE;
    if (!good && !served) {
        /* in place of the one in reserve that has been idle longest */
        struct admission_client *found = NULL;
        int64_t now = clock_us();
        for (struct admission_client *one = admissions->clients[0].first; one; one = one->next)
            if (!one->closing && idle_since(one, now) <= now && idle_longer(one, found) &&
                !has_unread(one, now))
                found = one;
        good = close_client(admissions, found);
    }
    admissions->reserved += good && !served;
    if (good)
        append_client(admissions, client);
    pthread_mutex_unlock(&admissions->lock);
    return good;
}

void admission_leave(struct admissions *admissions, struct admission_client *client) {
    pthread_mutex_lock(&admissions->lock);
    give_back(admissions, client);
    withdraw_client(admissions, client);
    pthread_mutex_unlock(&admissions->lock);
}

void admission_busy(struct admissions *admissions, struct admission_client *client, bool busy) {
    pthread_mutex_lock(&admissions->lock);
    client->busy = busy;
    atomic_store(&client->active_us, clock_us());
    if (!busy) {
        withdraw_client(admissions, client);
        append_client(admissions, client);
    }
    pthread_mutex_unlock(&admissions->lock);
}

void admission_heard(struct admission_client *client) {
    atomic_store(&client->active_us, clock_us());
}
