/* SPDX-License-Identifier: MIT */
/* What the store has of a link: as its definition a record "UNTIL ID ID ...", microseconds since
 * 1970 or 0 for ever, and the ids of its jobs; as its description what callers see. */
#include "links.h"
#include "documents.h"
#include "handlers.h"
#include "server/clock.h"
#include "server/http/access.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    LINK_JOBS = 16,
    LINK_SECONDS = 3600 * 24 * 366,
    LINK_TEXT = LINK_JOBS * 64,
    LINK_TOKEN_SIZE = sizeof ACCESS_LINK - 1 + TOKENS_RANDOM_SIZE
};

/* ------------------------------------------------------------------ what a link shows */

/* The link of that token; STORE_EMPTY as well when its time is over. To be cleared in any case. */
static enum store_answer find_link(struct store *store, const char *token,
                                   struct store_item *link) {
    char id[ID_SIZE];
    tokens_name(token, id);
    enum store_answer answer = store_item_get(store, STORE_LINKS, NULL, id, link);
    int64_t until = answer == STORE_OK ? strtoll(link->definition, NULL, 10) : 0;
    return until && until <= clock_utc_us() ? STORE_EMPTY : answer;
}

bool links_hold(struct store *store, const char *token) {
    struct store_item link;
    enum store_answer answer = find_link(store, token, &link);
    store_item_clear(&link);
    return answer != STORE_EMPTY;
}

/* Whether the path names a surface, and no job. */
static bool is_surface(const struct call *call) {
    return !strcmp(call->request->segments[1], "surfaces");
}

/* STORE_OK: the job of a link shows what the path names, which is not the job itself: its surface,
 * or one of its drapes. STORE_EMPTY: it does not. */
static enum store_answer job_shows(const struct call *call, const char *id) {
    struct store *store = call->services->store;
    const char *wanted = call->request->parameter;
    struct store_job job;
    struct store_page members = {0};
    enum store_answer answer = store_get(store, id, &job);
    bool shows = answer == STORE_OK && is_surface(call) && !strcmp(job.surface, wanted);
    if (answer == STORE_OK && job.kind == STORE_LAMINATE && !is_surface(call))
        answer = store_members(store, id, &members);
    for (size_t k = 0; answer == STORE_OK && k < members.count; k++)
        shows = shows || !strcmp(members.jobs[k].id, wanted);
    store_page_clear(&members);
    store_job_clear(&job);
    return answer == STORE_OK && !shows ? STORE_EMPTY : answer;
}

/* The same of a whole link. Cuts its record apart. */
static enum store_answer link_shows(const struct call *call, char *record) {
    enum store_answer answer = STORE_EMPTY;
    char *rest = NULL;
    (void)strtok_r(record, " ", &rest); /* until when */
    for (char *id; answer == STORE_EMPTY && (id = strtok_r(NULL, " ", &rest));)
        answer = !is_surface(call) && !strcmp(id, call->request->parameter) ? STORE_OK
                                                                            : job_shows(call, id);
    return answer;
}

bool links_admit(struct call *call) {
    struct request *request = call->request;
    struct store_item link;
    enum store_answer answer = find_link(call->services->store, request->link, &link);
    bool there = answer != STORE_EMPTY;
    if (answer == STORE_OK)
        answer = link_shows(call, link.definition);
    store_item_clear(&link);
    request->sees_all = answer == STORE_OK; /* the path names nothing else */
    if (!there) {
        reply_header(call->reply, "WWW-Authenticate",
                     "Bearer realm=\"draped\", error=\"invalid_token\"");
        reply_refuse(call->reply, API_UNAUTHORIZED,
                     "the link has been taken back or its time is over: ask its owner for another");
    } else if (answer == STORE_EMPTY) {
        call_not_found(call, is_surface(call) ? "surface" : store_kind_name(call->kind));
    } else if (answer != STORE_OK) {
        call_store_failed(call, answer);
    }
    return request->sees_all;
}

/* ------------------------------------------------------------------ a new link */

/* Writes the jobs of `?of=`, all of which the caller sees: ids with a blank before each, and paths
 * as elements of JSON. False: the reply says which not. */
static bool take_jobs(struct call *call, const char *list, char ids[LINK_TEXT],
                      char paths[LINK_TEXT]) {
    size_t count = 0, used = 0, written = 0;
    for (const char *at = list; at; at = strchr(at, ','), at += at != NULL, count++) {
        struct store_job job = {0};
        char id[ID_SIZE + 1]; /* longer ones are no ids */
        snprintf(id, sizeof id, "%.*s", (int)strcspn(at, ","), at);
        enum store_answer answer =
            count < LINK_JOBS ? call_see_job(call, id, &job) : STORE_CONFLICT;
        if (answer == STORE_OK) {
            used += (size_t)snprintf(ids + used, LINK_TEXT - used, " %s", id);
            written += (size_t)snprintf(paths + written, LINK_TEXT - written, "%s\"/v1/%s/%s\"",
                                        count ? "," : "", documents_collection(job.kind), id);
        } else if (answer == STORE_EMPTY) {
            reply_refuse(call->reply, API_INVALID_REQUEST,
                         "you have no drape, study or laminate with the id '%s' of the query "
                         "parameter 'of': give ids with commas between them",
                         id);
        } else if (answer == STORE_CONFLICT) {
            reply_refuse(call->reply, API_INVALID_REQUEST,
                         "the query parameter 'of' may have %d ids: make another link for the rest",
                         LINK_JOBS);
        } else {
            call_store_failed(call, answer);
        }
        store_job_clear(&job);
        if (answer != STORE_OK)
            return false;
    }
    return true;
}

/* Stores the link of a new token and answers with both. */
static void store_link(struct call *call, int64_t seconds, const char *ids, const char *paths) {
    const int64_t now = clock_utc_us(), until = seconds ? now + seconds * 1000000 : 0;
    char token[LINK_TOKEN_SIZE] = ACCESS_LINK, created[DOCUMENTS_TIME_SIZE],
         expires[DOCUMENTS_TIME_SIZE], definition[LINK_TEXT + 32], description[LINK_TEXT + 256],
         shown[LINK_TEXT + 512];
    struct store_item link = {.definition = definition, .description = description};
    const char *quote = until ? "\"" : "";
    bool fresh;
    tokens_make(token + strlen(ACCESS_LINK));
    tokens_name(token, link.id);
    memcpy(link.owner, call->request->owner, sizeof link.owner);
    documents_time(created, now);
    documents_time(expires, until);
    link.definition_length =
        (size_t)snprintf(definition, sizeof definition, "%lld%s", (long long)until, ids);
    snprintf(description, sizeof description,
             "{\"id\":\"%s\",\"of\":[%s],\"created\":\"%s\",\"expires\":%s%s%s}", link.id, paths,
             created, quote, until ? expires : "null", quote);
    snprintf(shown, sizeof shown, "{\"token\":\"%s\",%s", token, description + 1);
    if (call_has_room(call, link.definition_length)) {
        enum store_answer answer =
            store_item_put(call->services->store, STORE_LINKS, &link, &fresh);
        if (answer != STORE_OK)
            call_store_failed(call, answer);
    }
    if (!call->reply->status) {
        reply_text(call->reply, 201, "application/json", strdup(shown));
        reply_header(call->reply, "Location", "/v1/links/%s", link.id);
        reply_header(call->reply, "Cache-Control", "no-store");
    }
    explicit_bzero(token, sizeof token);
    explicit_bzero(shown, sizeof shown);
}

enum http_next links_create(struct call *call) {
    const char *list = request_query(call->request, "of"),
               *text = request_query(call->request, "expires_in");
    char ids[LINK_TEXT], paths[LINK_TEXT];
    int64_t seconds = 0;
    if (!list)
        reply_refuse(call->reply, API_INVALID_REQUEST,
                     "the query parameter 'of' is missing: ids of the drapes, studies and "
                     "laminates that the link is to show, with commas between them");
    else if (text && !request_parse_int(text, 1, LINK_SECONDS, &seconds))
        reply_refuse(
            call->reply, API_INVALID_REQUEST,
            "the query parameter 'expires_in' must be a whole number of seconds from 1 to %d",
            LINK_SECONDS);
    else if (take_jobs(call, list, ids, paths))
        store_link(call, seconds, ids, paths);
    return HTTP_DONE;
}
