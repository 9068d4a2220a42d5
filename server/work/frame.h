/* SPDX-License-Identifier: MIT */
/*
 * What the daemon and its child processes say to each other over a socketpair: frames of a type, a
 * length and that many bytes. Files may come with a frame, and longer bytes may follow it. Both
 * ends run on the same machine from one build, so numbers and structs are in native order. But
 * children read hostile input: the daemon accepts no length beyond FRAME_MAX_BYTES and no type out
 * of place.
 *
 *   daemon -> worker        JOB: a struct frame_job; the bytes of the work, the request and the
 *                           surface follow
 *   worker -> daemon        PROGRESS: a double; RESULT: the next bytes of the container, or the
 *                           numbers of a task; TASKS: some struct frame_task; at last DONE: the
 *                           summary object, ROUND: a struct frame_round, or PROBLEM: the problem
 *                           document
 *   daemon -> checker       ORDER: a struct checker_order with the files of its documents; short
 *                           documents follow
 *   checker -> daemon       HELLO: a struct checker_hello, once; ANSWER: a struct checker_answer
 *   daemon -> fork server   FORK: what the copy is to do, with the copy's socket
 *   fork server -> daemon   FORKED: the process's id, or -1
 *
 * The functions of children block. Those of the daemon never do: it polls the socket beside its
 * other duties. No function raises SIGPIPE.
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

enum {
    FRAME_MAX_BYTES = 256 * 1024, /* of a frame after its head */
    FRAME_FILES_MAX = 10,         /* that come with one */
    FRAME_PARTS_MAX = 5           /* of an outbox: head, body and what follows */
};

enum frame_type {
    FRAME_JOB = 1,
    FRAME_ORDER,
    FRAME_FORK,

    FRAME_HELLO, /* from here on: what the daemon may receive */
    FRAME_ANSWER,
    FRAME_FORKED,
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
    FRAME_TASK   /* one of its tasks: the bytes */
};

struct frame_job {
    struct api_limits limits;
    uint32_t kind;
    uint32_t careful; /* of a task: PROGRESS before each variant, which it is; else not often */
    double spent_ms;  /* of a step: the time of all tasks */
    uint64_t length;  /* of its bytes */
    uint64_t request_length;
    uint64_t surface_length;
    uint64_t form_length; /* of the prepared form, a file that comes with the job; 0: none does */
    uint32_t form_kept;   /* it is of a stored surface, which other jobs may be of, too */
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

enum frame_state {
    FRAME_READY,  /* a frame is whole; everything has been sent */
    FRAME_LATER,  /* poll and call again */
    FRAME_CLOSED, /* the other end is gone */
    FRAME_BROKEN  /* the other end sent an invalid frame */
};

/* ------------------------------------------------------------------ blocking: the children */

/* Sends all of it; false when the other end is gone. */
bool frame_send(int fd, enum frame_type type, const void *bytes, size_t length);

/* Receives exactly `length` bytes; false when the other end is gone. */
bool frame_receive(int fd, void *bytes, size_t length);

/* Receives a frame of that type and length, and the files that come with it: at most
 * FRAME_FILES_MAX, which the caller closes; NULL: none are taken. FRAME_CLOSED when the other end
 * is gone before the frame, FRAME_BROKEN for any other frame. */
enum frame_state frame_expect(int fd, enum frame_type type, void *body, size_t length, int *files,
                              int *file_count);

/* ------------------------------------------------------------------ polling: the daemon */

/* The frame being received; zero-initialised before the first. */
struct frame_inbox {
    struct frame_head head;
    size_t have; /* bytes of head and payload so far */
    unsigned char bytes[FRAME_MAX_BYTES];
};

/* Receives what is there. After FRAME_READY `head` and `bytes` hold the frame until the next call.
 */
enum frame_state frame_poll(int fd, struct frame_inbox *inbox);

/* A frame being sent; refers to the caller's bytes and files. */
struct frame_outbox {
    struct frame_head head;
    struct iovec parts[FRAME_PARTS_MAX]; /* what is left to send */
    size_t part_count;
    const int *files; /* go with the first byte */
    size_t file_count;
};

/* Begins a frame with that body. What the outbox refers to must live until all is sent; `outbox`
 * must not be moved. */
void frame_outbox_begin(struct frame_outbox *outbox, enum frame_type type, const void *body,
                        size_t length);

/* Has these bytes follow. */
void frame_outbox_add(struct frame_outbox *outbox, const void *bytes, size_t length);

/* The whole of a JOB, with its bytes and the documents, whose lengths it sets; `form`, where
 * `job->form_length` is not 0, is the file with the prepared form. */
void frame_outbox_fill(struct frame_outbox *outbox, struct frame_job *job, const void *bytes,
                       const struct api_input *input, const int *form);

/* Sends what the socket takes. FRAME_READY, FRAME_LATER or FRAME_CLOSED. */
enum frame_state frame_push(int fd, struct frame_outbox *outbox);

#endif
