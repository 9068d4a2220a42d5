/* SPDX-License-Identifier: MIT */
#include "mapper.h"
#include "api/map/map.h"
#include "server/clock.h"
#include "stored_result.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

struct map_task {
    struct mapper *mapper;
    struct map_task *next; /* that waits */
    char subject[ID_SIZE], id[ID_SIZE];
    struct store_result result;
    const struct format *format;
    char *body, *inlet, *fields;
    size_t length;
    bool nastran;
    struct format_options options; /* its fields are `fields` */

    atomic_bool dropped;
    int64_t deadline;
    bool done, taken; /* under the lock: taken by a thread */

    struct arena *arena;
    struct map_target mesh;
    struct api_map map;
    struct encoder *encoder;
    struct api_problem problem;
};

struct mapper {
    struct store *store;
    struct hub *hub;
    struct mapper_settings settings;
    pthread_t threads[MAPPER_THREADS];
    int thread_count;

    pthread_mutex_t lock; /* what is below */
    pthread_cond_t changed;
    struct map_task *first, *last; /* that wait */
    int count;                     /* of all tasks */
    bool stopping;
};

/* ------------------------------------------------------------------ one map */

static bool go_on(void *context, double fraction) {
    struct map_task *task = context;
    (void)fraction;
    return !atomic_load(&task->dropped) && clock_ms() < task->deadline;
}

/* Reads the mesh. Its text is not needed any more then. */
static bool read_mesh(struct map_task *task) {
    struct api_problem *problem = &task->problem;
    enum api_problem_id (*read)(const char *, size_t, struct arena *, struct map_target *,
                                struct api_problem *) =
        task->nastran ? map_target_nastran : map_target_json;
    const char *body = task->body ? task->body : "";
    enum api_problem_id result = read(body, task->length, task->arena, &task->mesh, problem);
    free(task->body);
    task->body = NULL;
    if (result == API_OK && task->inlet)
        result = map_target_inlet(&task->mesh, task->inlet, task->arena, problem);
    if (result == API_OK && !task->mesh.elements && task->format->elements)
        api_problem_set(problem, API_NOT_ACCEPTABLE,
                        "%s is of elements; a map onto points is available as json, csv",
                        task->format->name);
    return problem->id == API_OK;
}

/* What a map ends with is not what a drape does. */
static void explain(struct map_task *task) {
    const struct mapper_settings *settings = &task->mapper->settings;
    enum api_problem_id id = task->problem.id;
    if (id != API_CANCELLED && id != API_OUT_OF_MEMORY)
        return;
    task->problem = (struct api_problem){0};
    if (id == API_CANCELLED)
        api_problem_set(&task->problem, API_JOB_TIMEOUT,
                        "the map took longer than %lld s (--job-timeout)",
                        (long long)settings->timeout_ms / 1000);
    else
        api_problem_set(&task->problem, API_TOO_LARGE,
                        "the map needs more memory than %zu bytes (--job-memory)",
                        settings->memory);
}

static void make_map(struct map_task *task) {
    struct stored_result stored = {task->mapper->store, task->result};
    const struct api_reader reader = stored_result_reader(&stored);
    const struct drape_monitor monitor = {go_on, task};
    struct api_problem *problem = &task->problem;
    task->deadline = clock_ms() + task->mapper->settings.timeout_ms;
    task->arena = arena_new(task->mapper->settings.memory);
    if (!task->arena)
        api_problem_set(problem, API_UNAVAILABLE, "there is no memory for this now");
    else if (read_mesh(task) && api_map_make(&reader, &task->mesh, &monitor, task->arena,
                                             &task->map, problem) == API_OK) {
        const struct format_source source = {.id = task->id, .fields = &task->map.fields};
        task->encoder = encoder_new(task->format, &source, &task->options, problem);
    }
    explain(task);
}

static void free_task(struct map_task *task) {
    encoder_free(task->encoder);
    arena_free(task->arena);
    free(task->body);
    free(task->inlet);
    free(task->fields);
    free(task);
}

/* ------------------------------------------------------------------ the threads */

/* With the lock: the next task, or NULL at the end. */
static struct map_task *wait_for_task(struct mapper *mapper) {
    while (!mapper->first && !mapper->stopping)
        pthread_cond_wait(&mapper->changed, &mapper->lock);
    struct map_task *task = mapper->stopping ? NULL : mapper->first;
    if (task) {
        mapper->first = task->next;
        task->taken = true;
    }
    return task;
}

static void *work(void *context) {
    struct mapper *mapper = context;
    struct map_task *task;
    pthread_mutex_lock(&mapper->lock);
    while ((task = wait_for_task(mapper))) {
        char subject[ID_SIZE];
        memcpy(subject, task->subject, sizeof subject);
        pthread_mutex_unlock(&mapper->lock);
        make_map(task);
        pthread_mutex_lock(&mapper->lock);
        task->done = true;
        if (atomic_load(&task->dropped)) {
            mapper->count--;
            free_task(task);
            continue;
        }
        pthread_mutex_unlock(&mapper->lock);
        hub_notify(mapper->hub, subject);
        pthread_mutex_lock(&mapper->lock);
    }
    pthread_mutex_unlock(&mapper->lock);
    return NULL;
}

struct mapper *mapper_start(struct store *store, struct hub *hub,
                            const struct mapper_settings *settings) {
    struct mapper *mapper = calloc(1, sizeof *mapper);
    if (!mapper)
        return NULL;
    mapper->store = store;
    mapper->hub = hub;
    mapper->settings = *settings;
    pthread_mutex_init(&mapper->lock, NULL);
    pthread_cond_init(&mapper->changed, NULL);
    while (mapper->thread_count < MAPPER_THREADS &&
           pthread_create(&mapper->threads[mapper->thread_count], NULL, work, mapper) == 0)
        mapper->thread_count++;
    if (mapper->thread_count == MAPPER_THREADS)
        return mapper;
    mapper_stop(mapper);
    return NULL;
}

void mapper_stop(struct mapper *mapper) {
    if (!mapper)
        return;
    pthread_mutex_lock(&mapper->lock);
    mapper->stopping = true;
    pthread_cond_broadcast(&mapper->changed);
    pthread_mutex_unlock(&mapper->lock);
    for (int k = 0; k < mapper->thread_count; k++)
        pthread_join(mapper->threads[k], NULL);
    pthread_cond_destroy(&mapper->changed);
    pthread_mutex_destroy(&mapper->lock);
    free(mapper);
}

/* ------------------------------------------------------------------ the callers */

static struct map_task *new_task(struct mapper *mapper, const struct mapper_order *order,
                                 const char *subject) {
    struct map_task *task = calloc(1, sizeof *task);
    if (!task)
        return NULL;
    task->mapper = mapper;
    memcpy(task->subject, subject, sizeof task->subject);
    memcpy(task->id, order->id, sizeof task->id);
    task->result = order->result;
    task->format = order->format;
    task->nastran = order->nastran;
    task->options = order->options;
    task->inlet = order->inlet ? strdup(order->inlet) : NULL;
    task->options.fields = task->fields =
        order->options.fields ? strdup(order->options.fields) : NULL;
    if ((!order->inlet || task->inlet) && (!order->options.fields || task->fields))
        return task;
    free_task(task);
    return NULL;
}

struct map_task *mapper_begin(struct mapper *mapper, const struct mapper_order *order, char **body,
                              size_t length, const char *subject) {
    struct map_task *task = new_task(mapper, order, subject);
    if (!task)
        return NULL;
    pthread_mutex_lock(&mapper->lock);
    bool room = mapper->count < MAPPER_MAPS_MAX;
    if (room) {
        task->body = *body;
        task->length = length;
        *body = NULL;
        *(mapper->first ? &mapper->last->next : &mapper->first) = task;
        mapper->last = task;
        mapper->count++;
        pthread_cond_signal(&mapper->changed);
    }
    pthread_mutex_unlock(&mapper->lock);
    if (room)
        return task;
    free_task(task);
    return NULL;
}

bool mapper_done(struct map_task *task) {
    pthread_mutex_lock(&task->mapper->lock);
    bool done = task->done;
    pthread_mutex_unlock(&task->mapper->lock);
    return done;
}

const struct format *mapper_format(const struct map_task *task) {
    return task->format;
}

struct encoder *mapper_result(struct map_task *task, struct api_problem *problem) {
    *problem = task->problem;
    return task->encoder;
}

/* With the lock: takes it out of those that wait. */
static void withdraw(struct mapper *mapper, struct map_task *task) {
    struct map_task *before = NULL;
    for (struct map_task *at = mapper->first; at != task; at = at->next)
        before = at;
    *(before ? &before->next : &mapper->first) = task->next;
    if (mapper->last == task)
        mapper->last = before;
}

void mapper_drop(struct map_task *task) {
    struct mapper *mapper = task->mapper;
    pthread_mutex_lock(&mapper->lock);
    bool free_here = task->done || !task->taken; /* else the thread that makes it does */
    atomic_store(&task->dropped, true);
    if (!task->taken)
        withdraw(mapper, task);
    mapper->count -= free_here;
    pthread_mutex_unlock(&mapper->lock);
    if (free_here)
        free_task(task);
}
