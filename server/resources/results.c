/* SPDX-License-Identifier: MIT */
/* /v1/drapes/{id}/result, /pattern and /report: a stored result in the format asked for. */
#include "api/request/digest.h"
#include "checking.h"
#include "documents.h"
#include "encoders_digest.h"
#include "handlers.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/http/negotiate.h"
#include "server/http/stream.h"
#include "server/work/stored_result.h"
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    ETAG_SIZE = 96,
    EARLY_BYTES = 1000 << 10,  /* of a document that are made ready while its result is stored */
    EARLY_BYTES_ALL = 64 << 20 /* of all that are ready, with their results; not exceeded by more
                                  than one of each thread */
};

/* The entity tag: the bytes of a drape's result depend on nothing but its id, the encoders, the
 * choice and the coding. */
static void make_etag(const struct store_job *job, const struct call_choice *choice,
                      enum compress_coding coding, char etag[ETAG_SIZE]) {
    char text[512], digest[API_ID_SIZE];
    const struct format_options *options = &choice->options;
    const char *fields = options->fields ? options->fields : "";
    api_digest_bytes(fields, strlen(fields), digest);
    snprintf(text, sizeof text, "%s %s %d %d %s %.17g %d\n%s\n%s", DRAPE_VERSION,
             choice->format->name, (int)options->table, options->precision, digest,
             options->allowance, options->partial, options->part, options->ply);
    api_digest_bytes(text, strlen(text), digest);
    snprintf(etag, ETAG_SIZE, "\"%s-" ENCODERS_DIGEST "-%.8s%s%s\"", job->id, digest,
             coding ? "-" : "", coding ? compress_name(coding) : "");
}

/* ------------------------------------------------------------------ the stream */

/* An encoder over a stored result, or over an uncommitted one. */
struct source {
    struct stored_result stored;
    struct store_uncommitted *uncommitted; /* NULL: stored */
    struct api_reader reader;
    struct encoder *encoder;
};

static void source_free(void *context) {
    struct source *source = context;
    encoder_free(source->encoder);
    store_uncommitted_drop(source->uncommitted);
    free(source);
}

static bool read_uncommitted(void *context, uint64_t offset, void *buffer, size_t length) {
    return store_uncommitted_read(context, offset, buffer, length);
}

static ssize_t source_read(void *context, char *buffer, size_t size) {
    struct source *source = context;
    return encoder_read(source->encoder, buffer, size);
}

/* Of the uncommitted result, which it takes over, or of what is stored. NULL with the problem. */
static struct source *source_new(const struct stored_result *stored,
                                 struct store_uncommitted *uncommitted, const struct store_job *job,
                                 const struct call_choice *choice, struct api_problem *problem) {
    struct source *source = calloc(1, sizeof *source);
    if (!source) {
        api_problem_set(problem, API_UNAVAILABLE, "there is no memory for this now");
        store_uncommitted_drop(uncommitted);
        return NULL;
    }
    source->uncommitted = uncommitted;
    if (uncommitted) {
        source->reader = (struct api_reader){read_uncommitted, uncommitted};
    } else {
        source->stored = *stored;
        source->reader = stored_result_reader(&source->stored);
    }
    const struct format_source document = {
        .id = job->id, .reader = &source->reader, .queue_ms = documents_queue_ms(job)};
    source->encoder = encoder_new(choice->format, &document, &choice->options, problem);
    if (source->encoder)
        return source;
    source_free(source);
    return NULL;
}

/* ------------------------------------------------------------------ the answer */

static struct stream_source stream_source_of(struct source *source, const char *etag) {
    return (struct stream_source){source_read, source_free, source, etag,
                                  encoder_length(source->encoder)};
}

/* Of the encoder the time to the first bytes, or to the last if the answer is short. */
static void tell_times(struct call *call, const struct store_job *job, int64_t encode_us) {
    int64_t solve_us = job->finished > job->started ? job->finished - job->started : 0;
    reply_header(call->reply, "Server-Timing", "queue;dur=%.3f, solve;dur=%.3f, encode;dur=%.3f",
                 documents_queue_ms(job), (double)solve_us / 1e3, (double)encode_us / 1e3);
}

/* ------------------------------------------------------------------ made ready early */

struct results_early {
    struct store_uncommitted *uncommitted;
    struct stream *stream; /* NULL once it is sent */
    int64_t held, spent_us;
};

static atomic_int_fast64_t early_bytes;

struct results_early *results_begin_early(const struct call *call, const struct store_job *job,
                                          const struct call_choice *choice) {
    int64_t begun = clock_us();
    struct api_problem problem = {0};
    struct store_uncommitted *uncommitted = NULL;
    if (atomic_load(&early_bytes) < EARLY_BYTES_ALL)
        uncommitted = store_uncommitted_take(call->services->store, job->id);
    struct results_early *early = uncommitted ? calloc(1, sizeof *early) : NULL;
    struct source *source = NULL;
    if (early)
        source = source_new(NULL, store_uncommitted_share(uncommitted), job, choice, &problem);
    if (!source) {
        store_uncommitted_drop(uncommitted);
        free(early);
        return NULL;
    }
    const struct stream_source stream = stream_source_of(source, NULL);
    early->uncommitted = uncommitted;
    early->held = EARLY_BYTES + (int64_t)store_uncommitted_length(uncommitted);
    atomic_fetch_add(&early_bytes, (int_fast64_t)early->held);
    early->stream = stream_begin(&stream, EARLY_BYTES);
    early->spent_us = clock_us() - begun;
    return early;
}

void results_free_early(struct results_early *early) {
    if (!early)
        return;
    stream_free(early->stream);
    store_uncommitted_drop(early->uncommitted);
    atomic_fetch_sub(&early_bytes, (int_fast64_t)early->held);
    free(early);
}

bool results_ready(struct call *call, const struct store_job *job) {
    struct reply *reply = call->reply;
    if (!store_status_ended(job->status)) {
        reply_refuse(reply, API_RESULT_NOT_READY, "the %s is %s", store_kind_name(job->kind),
                     store_status_name(job->status));
    } else if (job->altered && job->status == STORE_FAILED) {
        call_altered(call, job->id);
    } else if (job->status == STORE_FAILED) {
        int status;
        char *text = documents_job_problem(job, call->request->id, &status);
        reply_text(reply, status, "application/problem+json", text);
    } else if (job->status == STORE_CANCELLED) {
        reply_refuse(reply, API_CANCELLED, "the %s was cancelled and has no result",
                     store_kind_name(job->kind));
    } else if (job->expired) {
        reply_refuse(reply, API_GONE,
                     "the result has been removed (--retention, --retention-bytes)");
    }
    return reply->status == 0;
}

/* Whether the caller has that document already: 304. */
static bool is_held(struct call *call, const char *etag) {
    const struct request *request = call->request;
    bool held = strcmp(request->method, "POST") != 0 &&
                negotiate_etag_matches(request_header(request, "If-None-Match"), etag);
    if (held)
        reply_empty(call->reply, 304);
    return held;
}

/* What caches are told of a document, once the reply is there. */
static void tell_caches(struct call *call, const char *etag) {
    if (call->reply->status >= 400)
        return;
    reply_header(call->reply, "ETag", "%s", etag);
    reply_header(call->reply, "Vary", "Accept, Accept-Encoding");
    reply_header(call->reply, "Cache-Control", "private, no-cache");
}

void results_reply(struct call *call, const struct store_job *job, const struct call_choice *choice,
                   struct results_early *early) {
    struct stored_result stored;
    struct api_problem problem = {0};
    if (!results_ready(call, job))
        return;
    enum compress_coding coding = compress_choose(request_header(call->request, "Accept-Encoding"));
    char etag[ETAG_SIZE];
    make_etag(job, choice, coding, etag);
    bool held = is_held(call, etag);
    if (!held && early && early->stream && store_uncommitted_kept(early->uncommitted)) {
        stream_send(call->request, call->reply, choice->format->media_type, coding, early->stream);
        early->stream = NULL;
        tell_times(call, job, early->spent_us);
    } else if (!held) { /* 200, or 206 for a part */
        int64_t begun = clock_us();
        bool found = call_stored_result(call, job->id, &stored);
        struct source *source = found ? source_new(&stored, NULL, job, choice, &problem) : NULL;
        if (source) {
            const struct stream_source stream = stream_source_of(source, etag);
            stream_reply(call->request, call->reply, choice->format->media_type, coding, &stream);
            tell_times(call, job, clock_us() - begun);
        } else if (found) {
            reply_problem(call->reply, &problem);
        }
    }
    tell_caches(call, etag);
}

/* GET of a stored result as a document of that use. */
static enum http_next get_document(struct call *call, enum format_use use) {
    struct call_choice choice;
    struct store_job job = {0};
    if (call_choose(call, use, &choice) && call_find_job(call, &job))
        results_reply(call, &job, &choice, NULL);
    store_job_clear(&job);
    return HTTP_DONE;
}

enum http_next results_get(struct call *call) {
    if (request_query(call->request, "sample"))
        return studies_sample(call);
    return get_document(call, FORMAT_RESULT);
}

enum http_next results_pattern(struct call *call) {
    return get_document(call, FORMAT_PATTERN);
}

/* ------------------------------------------------------------------ the report */

enum http_next results_report(struct call *call) {
    struct call_choice choice;
    struct store_job job = {0};
    char etag[ETAG_SIZE];
    enum http_next next = HTTP_DONE;
    if (call_choose(call, FORMAT_REPORT, &choice) && call_find_job(call, &job) &&
        results_ready(call, &job)) {
        make_etag(&job, &choice, compress_choose(request_header(call->request, "Accept-Encoding")),
                  etag);
        if (!call->request->state && !is_held(call, etag)) { /* the first call begins it */
            struct document_pool_order order = checking_order(call, CHECKER_REPORT);
            char record[STORE_DIGEST_SIZE + DOCUMENTS_TIME_SIZE] = "";
            char *bytes = call_stored_request(call, job.id, &order.length[CHECKER_BODY]);
            if (bytes && maps_take_columns(call, &order, NULL)) {
                size_t end = (size_t)snprintf(record, STORE_DIGEST_SIZE, "%s", job.digest) + 1;
                documents_time(record + end, job.finished);
                order.document[CHECKER_BODY] = bytes;
                order.body_file = -1;
                order.document[CHECKER_SECOND] = record;
                order.length[CHECKER_SECOND] = sizeof record;
                order.id = job.id;
                order.format = choice.format->name;
                maps_begin(call, &order, NULL);
            }
            free(bytes);
        }
        if (call->request->state)
            next = maps_answer(call, choice.format, etag);
        if (next == HTTP_DONE)
            tell_caches(call, etag);
    }
    store_job_clear(&job);
    return next;
}
