/* SPDX-License-Identifier: MIT */
#include "threads.h"

#include <pthread.h>
#include <stdatomic.h>

enum { THREADS_MAX = 64 };

struct work {
    void (*task)(void *data, int k);
    void *data;
    int count;
    _Atomic int next;
};

static void *take_tasks(void *context) {
    struct work *work = context;
    for (int k; (k = atomic_fetch_add(&work->next, 1)) < work->count;)
        work->task(work->data, k);
    return NULL;
}

static void run(void *context, int count, void (*task)(void *data, int k), void *data) {
    const struct api_threads *threads = context;
    struct work work = {.task = task, .data = data, .count = count};
    pthread_t thread[THREADS_MAX];
    int wanted = (threads->count < count ? threads->count : count) - 1, started = 0;
    while (started < wanted && started < THREADS_MAX &&
           pthread_create(&thread[started], NULL, take_tasks, &work) == 0)
        started++;
    take_tasks(&work);
    while (started > 0)
        pthread_join(thread[--started], NULL);
}

const struct drape_team *api_threads_make(struct api_threads *threads, int count) {
    *threads = (struct api_threads){.team = {.run = run, .context = threads}, .count = count};
    return count > 1 ? &threads->team : NULL;
}
