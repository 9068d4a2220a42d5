/* SPDX-License-Identifier: MIT */
#include "queue_rate.h"
#include "server/clock.h"
#include <pthread.h>

enum { LOOK_MS = 1000, WINDOW_MS = 10000, SHARE = 10 };

struct sample {
    int64_t at_ms; /* 0: none */
    int64_t ended;
};

/* `base` is one to two windows old, `middle` becomes the base next. */
static struct {
    pthread_mutex_t lock;
    int64_t look_at_ms;
    struct sample base, middle, latest;
} queue_rate = {.lock = PTHREAD_MUTEX_INITIALIZER};

void queue_rate_sample(struct store *store) {
    struct store_counts counts;
    int64_t now = clock_ms();
    pthread_mutex_lock(&queue_rate.lock);
    bool look = now >= queue_rate.look_at_ms;
    if (look)
        queue_rate.look_at_ms = now + LOOK_MS;
    pthread_mutex_unlock(&queue_rate.lock);
    if (!look || store_counts(store, &counts) != STORE_OK)
        return;
    const struct sample sample = {now, counts.jobs[STORE_SUCCEEDED] + counts.jobs[STORE_FAILED] +
                                           counts.jobs[STORE_CANCELLED]};
    pthread_mutex_lock(&queue_rate.lock);
    queue_rate.latest = sample;
    if (!queue_rate.base.at_ms)
        queue_rate.base = queue_rate.middle = sample;
    if (sample.at_ms - queue_rate.middle.at_ms >= WINDOW_MS) {
        queue_rate.base = queue_rate.middle;
        queue_rate.middle = sample;
    }
    pthread_mutex_unlock(&queue_rate.lock);
}

int queue_rate_retry_seconds(int64_t queue) {
    int64_t wanted = queue / SHARE > 1 ? queue / SHARE : 1;
    pthread_mutex_lock(&queue_rate.lock);
    int64_t ended = queue_rate.latest.ended - queue_rate.base.ended;
    int64_t ms = queue_rate.latest.at_ms - queue_rate.base.at_ms;
    pthread_mutex_unlock(&queue_rate.lock);
    if (ms <= 0 || ended < 0) /* retention may remove more than ends */
        return QUEUE_RATE_UNKNOWN_SECONDS;
    double seconds =
        ended ? (double)wanted * (double)ms / 1000 / (double)ended : QUEUE_RATE_MAX_SECONDS;
    return seconds >= QUEUE_RATE_MAX_SECONDS ? QUEUE_RATE_MAX_SECONDS : (int)seconds + 1;
}
