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
} drain = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void add(struct sample sample) {
    pthread_mutex_lock(&drain.lock);
    drain.latest = sample;
    if (!drain.base.at_ms)
        drain.base = drain.middle = sample;
    if (sample.at_ms - drain.middle.at_ms >= WINDOW_MS) {
        drain.base = drain.middle;
        drain.middle = sample;
    }
    pthread_mutex_unlock(&drain.lock);
}

static bool is_time(int64_t now) {
    pthread_mutex_lock(&drain.lock);
    bool look = now >= drain.look_at_ms;
    if (look)
        drain.look_at_ms = now + LOOK_MS;
    pthread_mutex_unlock(&drain.lock);
    return look;
}

void drain_watch(struct store *store) {
    struct store_counts counts;
    int64_t now = clock_ms();
    if (!is_time(now) || store_counts(store, &counts) != STORE_OK)
        return;
    add((struct sample){now, counts.jobs[STORE_SUCCEEDED] + counts.jobs[STORE_FAILED] +
                                 counts.jobs[STORE_CANCELLED]});
}

int drain_estimate(int64_t queue, int64_t ended, int64_t ms) {
    int64_t wanted = queue / SHARE > 1 ? queue / SHARE : 1;
    if (ms <= 0 || ended < 0) /* retention may remove more than ends */
        return DRAIN_UNKNOWN_SECONDS;
    double seconds = ended ? (double)wanted * (double)ms / 1000 / (double)ended : DRAIN_MAX_SECONDS;
    return seconds >= DRAIN_MAX_SECONDS ? DRAIN_MAX_SECONDS : (int)seconds + 1;
}

int drain_seconds(int64_t queue) {
    pthread_mutex_lock(&drain.lock);
    int64_t ended = drain.latest.ended - drain.base.ended;
    int64_t ms = drain.latest.at_ms - drain.base.at_ms;
    pthread_mutex_unlock(&drain.lock);
    return drain_estimate(queue, ended, ms);
}
