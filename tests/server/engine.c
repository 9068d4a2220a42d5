/* SPDX-License-Identifier: MIT */
#include "engine.h"
#include "api/study/study.h"
#include "server/work/frame.h"
#include "server/work/worker.h"
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

unsigned char engine_byte(size_t k) {
    return (unsigned char)(k * 2654435761U >> 13);
}

/* One job's arguments, as the engine got them. */
struct job {
    const struct api_input *input;
    const struct drape_monitor *monitor;
    const struct api_sink *sink;
    struct api_problem *problem;
    long number; /* behind the word */
};

static int jobs_before; /* in this process */

static enum api_problem_id write_text(const struct job *job, const char *text, size_t length) {
    return job->sink->write(job->sink->context, text, length) ? API_OK : API_CANCELLED;
}

/* That of a container is who wrote it. */
static bool give_summary(const struct api_sink *sink, const char *act) {
    char text[64];
    snprintf(text, sizeof text, "{\"act\":\"%s\"}", act);
    return sink->summary(sink->context, text);
}

static enum api_problem_id echo(const struct job *job) {
    return write_text(job, job->input->request, job->input->request_length);
}

static void pause_ms(long ms) {
    nanosleep(&(struct timespec){ms / 1000, ms % 1000 * 1000000}, NULL);
}

static enum api_problem_id tell_pid(const struct job *job) {
    char text[32];
    int length = snprintf(text, sizeof text, "%d", getpid());
    return write_text(job, text, (size_t)length);
}

static enum api_problem_id sleep_and_echo(const struct job *job) {
    for (long ms = 0; ms < job->number; ms += 5) {
        pause_ms(5);
        if (!job->monitor->progress(job->monitor->context, (double)ms / (double)job->number))
            return API_CANCELLED;
    }
    return echo(job);
}

static enum api_problem_id write_large(const struct job *job) {
    char bytes[10007];
    size_t length = (size_t)job->number;
    for (size_t at = 0; at < length;) {
        size_t part = length - at < sizeof bytes ? length - at : sizeof bytes;
        for (size_t k = 0; k < part; k++)
            bytes[k] = (char)engine_byte(at + k);
        if (write_text(job, bytes, part) != API_OK)
            return API_CANCELLED;
        at += part;
    }
    return API_OK;
}

/* Not through a bad pointer: sanitizers would report it as a bug of ours. */
static enum api_problem_id crash(const struct job *job) {
    (void)job;
    signal(SIGSEGV, SIG_DFL);
    raise(SIGSEGV);
    return API_INTERNAL;
}

static enum api_problem_id crash_used(const struct job *job) {
    return jobs_before > 0 ? crash(job) : echo(job);
}

static enum api_problem_id leave(const struct job *job) {
    _exit((int)job->number);
}

static enum api_problem_id hang(const struct job *job) {
    (void)job;
    for (int k = 0; k < 600; k++)
        pause_ms(1000);
    return API_INTERNAL;
}

static enum api_problem_id spin(const struct job *job) {
    (void)job;
    for (volatile unsigned long k = 0; k < ~0UL;)
        k++;
    return API_INTERNAL;
}

static enum api_problem_id have_problem(const struct job *job) {
    api_problem_set_at(job->problem, API_START_OFF_SURFACE, "/start", "too far away");
    return job->problem->id;
}

static enum api_problem_id eat_memory(const struct job *job) {
    enum { PIECE = 64 << 20, MOST = 1024 };
    void *pieces[MOST];
    int count = 0;
    while (count < MOST && (pieces[count] = malloc(PIECE)) != NULL)
        count++;
    for (int k = 0; k < count; k++)
        free(pieces[k]);
    api_problem_set(job->problem, API_OUT_OF_MEMORY, "after %d pieces", count);
    return count < MOST ? API_OUT_OF_MEMORY : API_INTERNAL;
}

static enum api_problem_id be_headless(const struct job *job) {
    return write_text(job, "headless", 8);
}

static enum api_problem_id babble(const struct job *job) {
    (void)job;
    (void)!frame_send(WORKER_FD, FRAME_JOB, "babble", 6);
    pause_ms(10000);
    return API_OK;
}

static enum api_problem_id be_oversized(const struct job *job) {
    struct frame_head head = {.type = FRAME_RESULT, .length = FRAME_MAX_BYTES + 1};
    (void)job;
    (void)!send(WORKER_FD, &head, sizeof head, MSG_NOSIGNAL);
    pause_ms(10000);
    return API_OK;
}

static bool is_open(int fd) {
    struct pollfd file = {.fd = fd, .events = POLLIN};
    return poll(&file, 1, 0) >= 0 && !(file.revents & POLLNVAL);
}

/* Open descriptors, variables of the environment, and whether files and sockets can be had. */
static enum api_problem_id look_inside(const struct job *job) {
    char text[256];
    int files = 0, variables = 0;
    for (int fd = 0; fd < 1024; fd++)
        files += is_open(fd);
    for (char **variable = environ; variable && *variable; variable++)
        variables++;
    int length = snprintf(text, sizeof text, "files %d variables %d open %s socket %s", files,
                          variables, open("/etc/passwd", O_RDONLY) >= 0 ? "yes" : "no",
                          socket(AF_INET, SOCK_STREAM, 0) >= 0 ? "yes" : "no");
    return write_text(job, text, (size_t)length);
}

static enum api_problem_id give_surface(const struct job *job) {
    return write_text(job, job->input->surface, job->input->surface_length);
}

static const struct {
    const char *word;
    enum api_problem_id (*act)(const struct job *job);
} acts[] = {
    {"echo", echo},
    {"pid", tell_pid},
    {"sleep", sleep_and_echo},
    {"large", write_large},
    {"crash", crash},
    {"crash-used", crash_used},
    {"exit", leave},
    {"hang", hang},
    {"spin", spin},
    {"problem", have_problem},
    {"memory", eat_memory},
    {"headless", be_headless},
    {"babble", babble},
    {"oversized", be_oversized},
    {"inside", look_inside},
    {"surface", give_surface},
};

static enum api_problem_id run(const struct api_input *input, const struct api_limits *limits,
                               const struct drape_monitor *monitor, const struct api_sink *sink,
                               struct api_problem *problem) {
    char request[128];
    (void)limits;
    snprintf(request, sizeof request, "%.*s", (int)input->request_length, input->request);
    size_t word = strcspn(request, " ");
    struct job job = {input, monitor, sink, problem, atol(request + word)};
    for (size_t k = 0; k < sizeof acts / sizeof *acts; k++) {
        if (strlen(acts[k].word) == word && !strncmp(acts[k].word, request, word)) {
            enum api_problem_id id = acts[k].act(&job);
            jobs_before++;
            bool told =
                id != API_OK || acts[k].act == be_headless || give_summary(sink, acts[k].word);
            return told ? id : API_CANCELLED;
        }
    }
    api_problem_set(problem, API_INTERNAL, "no such act: %s", request);
    return problem->id;
}

/* ------------------------------------------------------------------ studies */

enum { TASK_NUMBERS = 2 + ENGINE_VARIANTS };

static enum api_problem_id step(const struct worker_order *order, struct worker_round *round,
                                const struct api_sink *sink, struct api_problem *problem) {
    size_t given = order->length / sizeof(double) / TASK_NUMBERS;
    (void)problem;
    if (given == (size_t)ENGINE_ROUNDS * ENGINE_TASKS)
        return sink->write(sink->context, order->bytes, order->length) && give_summary(sink, "step")
                   ? API_OK
                   : API_CANCELLED;
    for (int k = 0; k < ENGINE_TASKS; k++) {
        struct api_study_task task = {0};
        task.round = (int32_t)(given / ENGINE_TASKS);
        task.first = k;
        if (!round->add(round->context, &task, sizeof task, ENGINE_VARIANTS))
            return API_CANCELLED;
    }
    round->count = ENGINE_TASKS;
    round->done = given * ENGINE_VARIANTS;
    round->total = (size_t)ENGINE_ROUNDS * ENGINE_TASKS * ENGINE_VARIANTS;
    return API_OK;
}

static bool blamed(const struct api_study_task *task, int variant) {
    for (int k = 0; k < task->crash_count; k++)
        if (task->crashed[k] == variant)
            return true;
    return false;
}

static enum api_problem_id do_task(const struct worker_order *order,
                                   const struct drape_monitor *monitor, const struct api_sink *sink,
                                   struct api_problem *problem) {
    struct api_study_task task;
    double numbers[TASK_NUMBERS];
    char text[64], act[32];
    int k = 0;
    memcpy(&task, order->bytes, sizeof task);
    snprintf(text, sizeof text, "%.*s", (int)order->input->request_length, order->input->request);
    sscanf(text, "%31s %d", act, &k);
    bool chosen = task.round == 1 && task.first == 0;
    if (chosen && !strcmp(act, "die-early"))
        crash(NULL);
    if (chosen && !strcmp(act, "fail"))
        api_problem_set(problem, API_OUT_OF_MEMORY, "not even one variant");
    if (!strcmp(act, "slow"))
        pause_ms(k);
    numbers[0] = task.round;
    numbers[1] = (double)task.first;
    for (int variant = 0; variant < ENGINE_VARIANTS; variant++) {
        monitor->progress(monitor->context, variant);
        numbers[2 + variant] = !blamed(&task, variant);
        if (chosen && variant == k && !blamed(&task, k) && !strcmp(act, "die"))
            crash(NULL);
        if (chosen && variant == k && !blamed(&task, k) && !strcmp(act, "stall"))
            hang(NULL);
    }
    if (problem->id != API_OK)
        return problem->id;
    return sink->write(sink->context, numbers, sizeof numbers) ? API_OK : API_CANCELLED;
}

void engine_serve_if_worker(int argc, char **argv) {
    static const struct worker_engine engine = {.run = run, .step = step, .task = do_task};
    if (argc == 2 && !strcmp(argv[1], WORKER_ARGUMENT))
        exit(worker_serve(&engine));
}
