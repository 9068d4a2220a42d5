/* SPDX-License-Identifier: MIT */
#include "api/request/digest.h"
#include "documents.h"
#include "resources.h"
#include "server/clock.h"
#include "server/http/negotiate.h"
#include "server/http/stream.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------ choosing the format */

bool results_choose(const struct request *request, struct reply *reply, enum format_use use,
                    struct results_choice *choice) {
    struct api_problem problem = {0};
    *choice = (struct results_choice){.format = resources_format(request, reply, use)};
    if (!choice->format)
        return false;
    for (size_t k = 0; k < request->query_count; k++)
        format_option(&choice->options, request->query[k].name, request->query[k].value, &problem);
    if (problem.id == API_OK)
        return true;
    reply_problem(reply, request->id, &problem);
    return false;
}

/* The entity tag: the bytes of a drape's result depend on nothing but its id, the choice and the
 * coding. */
static void make_etag(const struct store_job *job, const struct results_choice *choice,
                      enum compress_coding coding, char etag[96]) {
    char text[512], digest[API_ID_SIZE];
    const struct format_options *options = &choice->options;
    const char *fields = options->fields ? options->fields : "";
    api_digest_bytes(fields, strlen(fields), digest);
    snprintf(text, sizeof text, "%s %d %d %s", choice->format->name, (int)options->table,
             options->precision, digest);
    api_digest_bytes(text, strlen(text), digest);
    snprintf(etag, 96, "\"%s-%.8s%s%s\"", job->id, digest, coding ? "-" : "",
             coding ? compress_name(coding) : "");
}

/* ------------------------------------------------------------------ the stream */

/* An encoder over a stored result. */
struct source {
    struct store *store;
    struct store_result result;
    struct api_reader reader;
    struct encoder *encoder;
};

static bool source_read_at(void *context, uint64_t offset, void *buffer, size_t length) {
    struct source *source = context;
    uint64_t end = (uint64_t)source->result.length;
    return offset <= end && length <= end - offset &&
           store_result_read(source->store, &source->result, (int64_t)offset, buffer, length) ==
               STORE_OK;
}

static void source_free(void *context) {
    struct source *source = context;
    encoder_free(source->encoder);
    free(source);
}

static ssize_t source_read(void *context, char *buffer, size_t size) {
    struct source *source = context;
    return encoder_read(source->encoder, buffer, size);
}

static struct source *source_new(struct store *store, const struct store_result *result,
                                 const struct store_job *job, const struct results_choice *choice,
                                 struct api_problem *problem) {
    struct source *source = calloc(1, sizeof *source);
    if (!source) {
        api_problem_set(problem, API_UNAVAILABLE, "there is no memory for this now");
        return NULL;
    }
    source->store = store;
    source->result = *result;
    source->reader = (struct api_reader){source_read_at, source};
    const struct format_source stored = {
        .id = job->id, .reader = &source->reader, .queue_ms = documents_queue_ms(job)};
    source->encoder = encoder_new(choice->format, &stored, &choice->options, problem);
    if (source->encoder)
        return source;
    source_free(source);
    return NULL;
}

/* ------------------------------------------------------------------ the answer */

/* Of the encoder the time to the first bytes, or to the last if the answer is short. */
static void tell_times(struct reply *reply, const struct store_job *job, int64_t encode_us) {
    int64_t solve_us = job->finished > job->started ? job->finished - job->started : 0;
    reply_header(reply, "Server-Timing", "queue;dur=%.3f, solve;dur=%.3f, encode;dur=%.3f",
                 documents_queue_ms(job), (double)solve_us / 1e3, (double)encode_us / 1e3);
}

static void reply_result(const struct http_services *services, const struct request *request,
                         const struct store_job *job, const struct results_choice *choice,
                         enum compress_coding coding, const char *etag, struct reply *reply) {
    struct store_result result;
    enum store_answer answer = store_result_find(services->store, job->id, &result);
    if (answer == STORE_EMPTY) {
        reply_refuse(reply, request->id, API_GONE, "the result has been removed");
        return;
    }
    if (answer != STORE_OK) {
        resources_store_failed(request, reply, answer);
        return;
    }
    struct api_problem problem = {0};
    struct source *source = source_new(services->store, &result, job, choice, &problem);
    if (!source) {
        reply_problem(reply, request->id, &problem);
        return;
    }
    int64_t begun = clock_us();
    const struct stream_source stream = {source_read, source_free, source, etag,
                                         encoder_length(source->encoder)};
    stream_reply(request, reply, choice->format->media_type, coding, &stream);
    tell_times(reply, job, clock_us() - begun);
}

static void reply_failure(const struct request *request, const struct store_job *job,
                          struct reply *reply) {
    int status;
    char *text = documents_job_problem(job, request->id, &status);
    reply_text(reply, status, "application/problem+json", text);
}

bool results_ready(const struct request *request, const struct store_job *job,
                   struct reply *reply) {
    if (!store_status_ended(job->status))
        reply_refuse(reply, request->id, API_RESULT_NOT_READY, "the drape is %s",
                     store_status_name(job->status));
    else if (job->status == STORE_FAILED)
        reply_failure(request, job, reply);
    else if (job->status == STORE_CANCELLED)
        reply_refuse(reply, request->id, API_CANCELLED, "the drape was cancelled: no result");
    else if (job->expired)
        reply_refuse(reply, request->id, API_GONE,
                     "the result has been removed (--retention, --retention-bytes)");
    return reply->status == 0;
}

void results_reply(const struct http_services *services, const struct request *request,
                   const struct store_job *job, const struct results_choice *choice,
                   struct reply *reply) {
    char etag[96];
    if (!results_ready(request, job, reply))
        return;
    enum compress_coding coding = compress_choose(request_header(request, "Accept-Encoding"));
    make_etag(job, choice, coding, etag);
    if (!strcmp(request->method, "POST") ||
        !negotiate_etag_matches(request_header(request, "If-None-Match"), etag))
        reply_result(services, request, job, choice, coding, etag, reply);
    else
        reply_empty(reply, 304);
    if (reply->status < 400) {
        reply_header(reply, "ETag", "%s", etag);
        reply_header(reply, "Vary", "Accept, Accept-Encoding");
        reply_header(reply, "Cache-Control", "private, no-cache");
    }
}

static enum routes_next reply_ended(const struct http_services *services, struct request *request,
                                    const struct results_choice *choice, struct reply *reply) {
    struct store_job job = {0};
    if (resources_job(services, request, reply, &job))
        results_reply(services, request, &job, choice, reply);
    store_job_clear(&job);
    return ROUTES_DONE;
}

enum routes_next results_get(const struct http_services *services, struct request *request,
                             struct reply *reply) {
    struct results_choice choice;
    if (!results_choose(request, reply, FORMAT_RESULT, &choice))
        return ROUTES_DONE;
    return reply_ended(services, request, &choice, reply);
}

enum routes_next results_pattern(const struct http_services *services, struct request *request,
                                 struct reply *reply) {
    struct results_choice choice;
    if (!results_choose(request, reply, FORMAT_PATTERN, &choice))
        return ROUTES_DONE;
    return reply_ended(services, request, &choice, reply);
}
