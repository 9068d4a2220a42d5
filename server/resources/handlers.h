/* SPDX-License-Identifier: MIT */
/* The handlers of the table in `routes.c`, one file a resource, and what these files share. */
#ifndef SERVER_RESOURCES_HANDLERS_H
#define SERVER_RESOURCES_HANDLERS_H

#include "call.h"

/* jobs.c */
call_handler jobs_create, jobs_list, jobs_status, jobs_request, jobs_end;
/* events.c */
call_handler events_stream;
/* results.c */
call_handler results_get, results_pattern, results_report;
/* studies.c */
call_handler studies_variant, studies_sample;
/* laminates.c */
call_handler laminates_request, laminates_pattern, laminates_patterns, laminates_report,
    laminates_laser, laminates_bundle;
/* maps.c */
call_handler maps_create;
/* items.c */
call_handler items_create, items_list, items_get, items_preview, items_delete;
/* Whether the body of `POST /v1/surfaces` is said to be a file of CAD or mesh, by `?format=` or its
 * type; the reply then says why it is not taken, if so. */
bool items_check_file(struct call *call);
/* links.c */
call_handler links_create;
/* meta.c */
call_handler meta_openapi, meta_limits, meta_health, meta_ready, meta_version, meta_metrics;
/* viewer.c */
call_handler viewer_page, viewer_file;

/* Whether there is a result. False: the reply says why not, with the drape's own problem if it
 * failed. */
bool results_ready(struct call *call, const struct store_job *job);

/* The document of a result that is being stored, as far as it is made ready meanwhile. */
struct results_early;

/* NULL when the result is not there yet, is stored already, or there is no room for more. */
struct results_early *results_begin_early(const struct call *call, const struct store_job *job,
                                          const struct call_choice *choice);

/* When the request is over. NULL is allowed. */
void results_free_early(struct results_early *early);

/* Answers with the result of a job that has ended, or with the problem it ended with. What was made
 * ready of the same choice is sent if it is the job's result; NULL is allowed. */
void results_reply(struct call *call, const struct store_job *job, const struct call_choice *choice,
                   struct results_early *early);

#endif
