/* SPDX-License-Identifier: MIT */
/* Whether the store can do what it is for: told by writing, since what can be read may be a disk
 * that is full, a database that has become read-only, or tables that somebody has changed. */
#include "backend.h"
#include "server/clock.h"
#include "server/log.h"
#include <string.h>

enum { FRESH_MS = 2000 }; /* for so long a beat answers for the next moment */

static void keep_health(struct store *store, enum store_answer answer) {
    struct store_health *health = &store->health;
    pthread_mutex_lock(&health->lock);
    enum store_answer before = health->answer;
    health->answer = answer;
    health->at_ms = clock_ms();
    pthread_mutex_unlock(&health->lock);
    if (store_failed(answer) && !store_failed(before))
        log_error(log_event("store_unusable"), log_text("answer", store_answer_name(answer)));
    else if (store_failed(before) && !store_failed(answer))
        log_info(log_event("store_usable"));
}

enum store_answer store_note(struct store *store, enum store_answer answer) {
    if (store->ops->fails_late && (answer == STORE_NO_SPACE || answer == STORE_READ_ONLY))
        keep_health(store, answer);
    return answer;
}

/* Of two at the same time either may be the last. */
enum store_answer store_beat(struct store *store) {
    struct store_host host;
    pthread_mutex_lock(&store->health.lock);
    host = store->health.host;
    pthread_mutex_unlock(&store->health.lock);
    enum store_answer answer = store->ops->beat(store, &host);
    keep_health(store, answer);
    return answer;
}

void store_introduce(struct store *store, const struct store_host *host) {
    char name[ID_SIZE];
    pthread_mutex_lock(&store->health.lock);
    memcpy(name, store->health.host.name, sizeof name);
    store->health.host = *host;
    memcpy(store->health.host.name, name, sizeof name);
    pthread_mutex_unlock(&store->health.lock);
}

enum store_answer store_health(struct store *store) {
    pthread_mutex_lock(&store->health.lock);
    enum store_answer answer = store->health.answer;
    pthread_mutex_unlock(&store->health.lock);
    return answer;
}

/* A failure is looked at anew, so that its end is seen at once. */
enum store_answer store_ping(struct store *store) {
    struct store_health *health = &store->health;
    enum store_answer answer = store->ops->ping(store);
    if (answer != STORE_OK)
        return answer;
    pthread_mutex_lock(&health->lock);
    bool fresh =
        health->at_ms && health->answer == STORE_OK && clock_ms() - health->at_ms < FRESH_MS;
    pthread_mutex_unlock(&health->lock);
    return fresh ? STORE_OK : store_beat(store);
}
