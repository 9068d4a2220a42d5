/* SPDX-License-Identifier: MIT */
/* GET /v1/drapes/{id}/events: server-sent events, `progress` at every change, then `end`. */
#include "event_cache.h"
#include "handlers.h"
#include "links.h"
#include "server/clock.h"
#include "server/http/access.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A comment this often keeps proxies from closing the stream and finds clients that are gone. */
enum { EVENTS_KEEP_ALIVE_MS = 15000, EVENTS_ID_SIZE = 48 };

/* Most events are less than this; thousands of streams that wait have a buffer each. */
enum { EVENTS_BLOCK_BYTES = 2048 };

struct events {
    struct store *store;
    struct tokens *tokens; /* NULL without */
    int64_t reloads;       /* of them, when the caller's was looked at */
    struct request *request;
    char id[ID_SIZE];
    char *text; /* what is being sent */
    size_t length, sent;
    bool ended;
    int64_t begun, sent_at; /* when the stream and its last message began */
    enum store_status status;
    double progress;
    int attempts;               /* of the last event; -1 before the first */
    char known[EVENTS_ID_SIZE]; /* what the client had before it came back; "" */
};

static void send_text(struct events *events, char *text) {
    free(events->text);
    events->text = text;
    events->length = text ? strlen(text) : 0;
    events->sent = 0;
    events->sent_at = clock_ms();
}

/* Names a state of the job: attempt, status and progress in thousandths. */
static void name_state(const struct store_job *job, char name[EVENTS_ID_SIZE]) {
    snprintf(name, EVENTS_ID_SIZE, "%d-%s-%d", job->attempts, store_status_name(job->status),
             (int)(job->progress * 1000));
}

/* Looks for something to send. False when there is nothing now. A stream outlives its token no
 * longer than to the next look after SIGHUP, its link no longer than to the next look. */
static bool look_for_news(struct events *events) {
    struct store_job job;
    char *document = NULL, *text = NULL, state[EVENTS_ID_SIZE];
    int64_t now = clock_ms(), reloads = events->tokens ? tokens_reloads(events->tokens) : 0;
    bool looked = reloads == events->reloads, news = false;
    events->reloads = reloads;
    const char *link = events->request->link;
    if ((!looked && !access_holds(events->tokens, events->request)) ||
        (link && !links_hold(events->store, link))) {
        events->ended = true;
        return false;
    }
    enum store_answer answer =
        event_cache_look(events->store, events->id, events->request->woken_us, &job, &document);
    if (answer == STORE_OK) {
        name_state(&job, state);
        news = events->attempts < 0
                   ? strcmp(state, events->known) != 0
                   : job.status != events->status || job.progress > events->progress ||
                         job.attempts != events->attempts;
    }
    if (news) {
        events->ended = store_status_ended(job.status);
        events->status = job.status;
        events->progress = job.progress;
        events->attempts = job.attempts;
        if (document && asprintf(&text, "event: %s\nid: %s\ndata: %s\n\n",
                                 events->ended ? "end" : "progress", state, document) < 0)
            text = NULL;
        send_text(events, text);
        events->ended = events->ended || !text; /* without memory the stream ends early */
    } else if (answer == STORE_EMPTY) {         /* deleted */
        events->ended = true;
    } else if (now - events->sent_at >= EVENTS_KEEP_ALIVE_MS) {
        send_text(events, strdup(": still here\n\n"));
        news = true;
    }
    free(document);
    events->request->wake_at = call_poll_at(events->begun, now);
    return news;
}

static ssize_t events_next(void *context, char *buffer, size_t size) {
    struct events *events = context;
    if (events->sent == events->length) {
        if (events->ended || events->request->stopping)
            return REPLY_END;
        if (!look_for_news(events))
            return events->ended ? REPLY_END : REPLY_WAIT;
        if (!events->length)
            return REPLY_BROKEN; /* no memory */
    }
    size_t left = events->length - events->sent, length = left < size ? left : size;
    memcpy(buffer, events->text + events->sent, length);
    events->sent += length;
    return (ssize_t)length;
}

static void events_free(void *context) {
    struct events *events = context;
    free(events->text);
    free(events);
}

enum http_next events_stream(struct call *call) {
    struct request *request = call->request;
    struct reply *reply = call->reply;
    struct store_job job = {0};
    if (!http_take_stream(request, reply) || !call_find_job(call, &job))
        return HTTP_DONE;
    const char *known = request_header(request, "Last-Event-ID"); /* what the client saw last */
    char state[EVENTS_ID_SIZE];
    name_state(&job, state);
    struct events *events = calloc(1, sizeof *events);
    if (known && store_status_ended(job.status) && !strcmp(known, state)) {
        free(events);
        reply_empty(reply, 204); /* so that the client does not come back again */
    } else if (events) {
        events->store = call->services->store;
        events->tokens = call->services->tokens;
        events->reloads = events->tokens ? tokens_reloads(events->tokens) : 0;
        events->request = request;
        events->begun = events->sent_at = clock_ms();
        events->attempts = -1;
        snprintf(events->known, sizeof events->known, "%s", known ? known : "");
        memcpy(events->id, job.id, sizeof events->id);
        http_watch(request, job.id, JOB_PROGRESSED);
        struct reply_stream stream = {events_next, events_free, events, EVENTS_BLOCK_BYTES};
        reply_stream(reply, 200, "text/event-stream", stream, 0);
        reply_header(reply, "Cache-Control", "no-store");
        reply_header(reply, "X-Accel-Buffering", "no"); /* nginx would hold events back */
    } else {
        reply_no_memory(reply);
    }
    store_job_clear(&job);
    return HTTP_DONE;
}
