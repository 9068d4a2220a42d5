/* SPDX-License-Identifier: MIT */
/*
 * What a dispatcher and its worker process say to each other over a socketpair: frames of a type, a
 * length and that many bytes. Both ends are the same binary on the same machine, so numbers are in
 * native order; but the worker is the sandbox of hostile input, so the dispatcher believes no
 * length beyond FRAME_MAX_BYTES and no type out of place.
 *
 *   dispatcher -> worker   JOB: a struct frame_job, after the frame the bytes of the work, the
 *                          request and the surface
 *   worker -> dispatcher   PROGRESS: a double; RESULT: the next bytes of the container, or numbers
 *                          of a task; TASKS: some struct frame_task; at last DONE: the summary
 *                          object, ROUND: a struct frame_round, or PROBLEM: the problem document
 *
 * The worker's functions block; the dispatcher's never do, it polls the socket beside its other
 * duties. No function raises SIGPIPE.
 */
#ifndef SERVER_WORK_FRAME_H
#define SERVER_WORK_FRAME_H

#include "api/input.h"
#include "api/limits.h"
#include "api/result/quantity.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/uio.h>

enum { FRAME_MAX_BYTES = 256 * 1024 }; /* of a frame after its head */

enum frame_type {
    FRAME_JOB = 1,
    FRAME_PROGRESS,
    FRAME_RESULT,
    FRAME_TASKS,
    FRAME_ROUND,
    FRAME_DONE,
    FRAME_PROBLEM
};

struct frame_head {
    uint32_t type;
    uint32_t length;
};

/* What is to be done with the request. */
enum frame_kind {
    FRAME_DRAPE, /* a result: without bytes */
    FRAME_STEP,  /* the next step of a study; the bytes are the numbers of its rounds so far */
    FRAME_TASK,  /* one of its tasks: the bytes */
    FRAME_KINDS
};

struct frame_work {
    enum frame_kind kind;
    bool careful;    /* of a task: PROGRESS before each variant, which it is; else not often */
    double spent_ms; /* of a step: the time of all tasks */
    const void *bytes;
    size_t length;
};

struct frame_job {
    struct api_limits limits;
    uint32_t kind, careful;
    double spent_ms;
    uint64_t length;
    uint64_t request_length;
    uint64_t surface_length;
};

/* A task of the round that a step begins, and how many variants it looks at. */
enum { FRAME_TASK_BYTES = 512 };
struct frame_task {
    uint64_t variants, length; /* the same length for all tasks of a round */
    unsigned char bytes[FRAME_TASK_BYTES];
};

/* That all tasks of the round have been sent; and the variants of the study, those of the rounds
 * before and altogether, and the best of each objective so far, NaN for none. */
struct frame_round {
    uint64_t done, total;
    double best[QUANTITY_COUNT];
};

/* ------------------------------------------------------------------ blocking: the worker */

/* Sends all of it; false when the other end is gone. */
bool frame_send(int fd, enum frame_type type, const void *bytes, size_t length);

/* Receives exactly `length` bytes; false when the other end is gone. */
bool frame_receive(int fd, void *bytes, size_t length);

/* ------------------------------------------------------------------ polling: the dispatcher */

enum frame_state {
    FRAME_READY,  /* a frame is whole; everything has been sent */
    FRAME_LATER,  /* poll and call again */
    FRAME_CLOSED, /* the other end is gone */
    FRAME_BROKEN  /* the other end sent an invalid frame */
};

/* The frame being received; zero-initialised before the first. */
struct frame_inbox {
    struct frame_head head;
    size_t have; /* bytes of head and payload so far */
    unsigned char bytes[FRAME_MAX_BYTES];
};

/* Receives what is there. After FRAME_READY `head` and `bytes` hold the frame until the next call.
 */
enum frame_state frame_poll(int fd, struct frame_inbox *inbox);

/* A job being sent; refers to the caller's bytes. */
struct frame_outbox {
    struct frame_head head;
    struct frame_job job;
    struct iovec parts[5]; /* what is left to send */
};

/* `input` and the bytes of `work` must live until all is sent; `outbox` must not be moved. */
void frame_outbox_fill(struct frame_outbox *outbox, const struct frame_work *work,
                       const struct api_input *input, const struct api_limits *limits);

/* Sends what the socket takes. FRAME_READY, FRAME_LATER or FRAME_CLOSED. */
enum frame_state frame_push(int fd, struct frame_outbox *outbox);

#endif
