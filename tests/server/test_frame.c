/* SPDX-License-Identifier: MIT */
/* Frames: cut in two anywhere, too long, of no known kind, into a socket that is full. */
#include "engine.h"
#include "server/work/frame.h"
#include "server/work/worker.h"
#include "tests/store/scratch.h"
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

struct pair {
    int ours, theirs;
    struct frame_inbox inbox;
};

static int set_up(void **state) {
    struct pair *pair = calloc(1, sizeof *pair);
    int ends[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
    pair->ours = ends[0];
    pair->theirs = ends[1];
    *state = pair;
    return 0;
}

static int tear_down(void **state) {
    struct pair *pair = *state;
    close(pair->ours);
    if (pair->theirs >= 0)
        close(pair->theirs);
    free(pair);
    return 0;
}

static void hang_up(struct pair *pair) {
    close(pair->theirs);
    pair->theirs = -1;
}

static void write_all(int fd, const void *bytes, size_t length) {
    assert_int_equal(write(fd, bytes, length), length);
}

/* ------------------------------------------------------------------ receiving */

static void test_frame_arrives_whole(void **state) {
    struct pair *pair = *state;
    assert_int_equal(frame_poll(pair->ours, &pair->inbox), FRAME_LATER);
    assert_true(frame_send(pair->theirs, FRAME_RESULT, "abc", 3));
    assert_true(frame_send(pair->theirs, FRAME_DONE, NULL, 0));
    assert_int_equal(frame_poll(pair->ours, &pair->inbox), FRAME_READY);
    assert_int_equal(pair->inbox.head.type, FRAME_RESULT);
    assert_int_equal(pair->inbox.head.length, 3);
    assert_memory_equal(pair->inbox.bytes, "abc", 3);
    assert_int_equal(frame_poll(pair->ours, &pair->inbox), FRAME_READY);
    assert_int_equal(pair->inbox.head.type, FRAME_DONE);
    assert_int_equal(pair->inbox.head.length, 0);
    assert_int_equal(frame_poll(pair->ours, &pair->inbox), FRAME_LATER);
}

static void test_frame_arrives_byte_by_byte(void **state) {
    struct pair *pair = *state;
    unsigned char bytes[sizeof(struct frame_head) + 5];
    struct frame_head head = {.type = FRAME_PROBLEM, .length = 5};
    memcpy(bytes, &head, sizeof head);
    memcpy(bytes + sizeof head, "hello", 5);
    for (int frame = 0; frame < 3; frame++) {
        for (size_t k = 0; k < sizeof bytes; k++) {
            write_all(pair->theirs, bytes + k, 1);
            assert_int_equal(frame_poll(pair->ours, &pair->inbox),
                             k + 1 < sizeof bytes ? FRAME_LATER : FRAME_READY);
        }
        assert_memory_equal(pair->inbox.bytes, "hello", 5);
    }
}

/* Whatever was received before the end: a frame that is not whole is none. */
static void test_frame_cut_off_is_closed(void **state) {
    struct pair *pair = *state;
    unsigned char bytes[sizeof(struct frame_head) + 5] = {0};
    struct frame_head head = {.type = FRAME_DONE, .length = 5};
    memcpy(bytes, &head, sizeof head);
    for (size_t cut = 0; cut < sizeof bytes; cut++) {
        int ends[2];
        assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
        write_all(ends[1], bytes, cut);
        close(ends[1]);
        pair->inbox.have = 0;
        assert_int_equal(frame_poll(ends[0], &pair->inbox), FRAME_CLOSED);
        close(ends[0]);
    }
}

static void test_frame_beyond_the_limit_is_broken(void **state) {
    struct pair *pair = *state;
    struct frame_head head = {.type = FRAME_RESULT, .length = FRAME_MAX_BYTES + 1};
    write_all(pair->theirs, &head, sizeof head);
    assert_int_equal(frame_poll(pair->ours, &pair->inbox), FRAME_BROKEN);
    head.length = UINT32_MAX;
    pair->inbox.have = 0;
    write_all(pair->theirs, &head, sizeof head);
    assert_int_equal(frame_poll(pair->ours, &pair->inbox), FRAME_BROKEN);
}

static void test_frame_of_no_known_kind_is_broken(void **state) {
    struct pair *pair = *state;
    static const uint32_t types[] = {0, FRAME_JOB, FRAME_PROBLEM + 1, UINT32_MAX};
    for (size_t k = 0; k < sizeof types / sizeof *types; k++) {
        struct frame_head head = {.type = types[k], .length = 0};
        pair->inbox.have = 0;
        write_all(pair->theirs, &head, sizeof head);
        assert_int_equal(frame_poll(pair->ours, &pair->inbox), FRAME_BROKEN);
    }
}

static void *send_largest(void *context) {
    static unsigned char bytes[FRAME_MAX_BYTES];
    struct pair *pair = context;
    for (size_t k = 0; k < sizeof bytes; k++)
        bytes[k] = engine_byte(k);
    bool sent = frame_send(pair->theirs, FRAME_RESULT, bytes, sizeof bytes);
    return sent ? context : NULL;
}

static void test_frame_of_the_largest_size_arrives(void **state) {
    struct pair *pair = *state;
    pthread_t thread;
    void *sent = NULL;
    enum frame_state got = FRAME_LATER;
    assert_int_equal(pthread_create(&thread, NULL, send_largest, pair), 0);
    for (int k = 0; k < 10000 && got == FRAME_LATER; k++) {
        got = frame_poll(pair->ours, &pair->inbox);
        if (got == FRAME_LATER)
            scratch_sleep(1);
    }
    pthread_join(thread, &sent);
    assert_non_null(sent);
    assert_int_equal(got, FRAME_READY);
    assert_int_equal(pair->inbox.head.length, FRAME_MAX_BYTES);
    for (size_t k = 0; k < FRAME_MAX_BYTES; k++)
        assert_int_equal(pair->inbox.bytes[k], engine_byte(k));
}

/* Random bytes: any answer, but never a frame beyond the limit. */
static void test_frame_poll_survives_noise(void **state) {
    struct pair *pair = *state;
    uint64_t random = check_seed(1);
    for (unsigned round = 0; round < 2000; round++) {
        unsigned char bytes[64];
        int ends[2];
        size_t length = scratch_random(&random) % sizeof bytes;
        for (size_t k = 0; k < length; k++) /* small numbers are more often good heads */
            bytes[k] = (unsigned char)(scratch_random(&random) % (k % 4 == 0 ? 8 : 1 + round % 3));
        assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
        write_all(ends[1], bytes, length);
        close(ends[1]);
        pair->inbox.have = 0;
        enum frame_state got = FRAME_READY;
        for (int k = 0; k < 100 && got == FRAME_READY; k++) {
            got = frame_poll(ends[0], &pair->inbox);
            assert_true(got != FRAME_READY || pair->inbox.head.length <= FRAME_MAX_BYTES);
        }
        assert_true(got == FRAME_CLOSED || got == FRAME_BROKEN);
        close(ends[0]);
    }
}

/* ------------------------------------------------------------------ sending */

static void test_frame_send_to_nobody_is_false(void **state) {
    struct pair *pair = *state;
    struct frame_outbox outbox;
    const struct api_input input = {.request = "x", .request_length = 1};
    char byte = 0;
    hang_up(pair);
    assert_false(frame_send(pair->ours, FRAME_DONE, "x", 1));
    frame_outbox_fill(&outbox, &(struct frame_job){.limits = api_limits_default}, NULL, &input,
                      NULL);
    assert_int_equal(frame_push(pair->ours, &outbox), FRAME_CLOSED);
    assert_false(frame_receive(pair->ours, &byte, 1));
}

struct receiver {
    int fd;
    size_t length;
    char *bytes; /* NULL: it did not come */
};

static void *receive_job(void *context) {
    struct receiver *receiver = context;
    struct frame_head head;
    struct frame_job job;
    if (!frame_receive(receiver->fd, &head, sizeof head) || head.type != FRAME_JOB ||
        !frame_receive(receiver->fd, &job, sizeof job))
        return NULL;
    receiver->length = job.request_length + job.surface_length;
    char *bytes = malloc(receiver->length);
    if (frame_receive(receiver->fd, bytes, receiver->length))
        receiver->bytes = bytes;
    else
        free(bytes);
    return NULL;
}

static void test_frame_outbox_fills_a_full_socket_piecemeal(void **state) {
    struct pair *pair = *state;
    enum { REQUEST = 3000001, SURFACE = 1000003 };
    char *documents = malloc(REQUEST + SURFACE);
    struct frame_outbox outbox;
    struct receiver receiver = {.fd = pair->theirs};
    pthread_t thread;
    int small = 4096;
    for (size_t k = 0; k < REQUEST + SURFACE; k++)
        documents[k] = (char)engine_byte(k);
    const struct api_input input = {.request = documents,
                                    .request_length = REQUEST,
                                    .surface = documents + REQUEST,
                                    .surface_length = SURFACE};
    setsockopt(pair->ours, SOL_SOCKET, SO_SNDBUF, &small, sizeof small);
    frame_outbox_fill(&outbox, &(struct frame_job){.limits = api_limits_default}, NULL, &input,
                      NULL);
    assert_int_equal(frame_push(pair->ours, &outbox), FRAME_LATER);
    assert_int_equal(pthread_create(&thread, NULL, receive_job, &receiver), 0);
    enum frame_state pushed = FRAME_LATER;
    for (int k = 0; k < 100000 && pushed == FRAME_LATER; k++) {
        pushed = frame_push(pair->ours, &outbox);
        sched_yield();
    }
    assert_int_equal(pushed, FRAME_READY);
    pthread_join(thread, NULL);
    assert_non_null(receiver.bytes);
    assert_int_equal(receiver.length, REQUEST + SURFACE);
    assert_memory_equal(receiver.bytes, documents, REQUEST + SURFACE);
    free(receiver.bytes);
    free(documents);
}

/* ------------------------------------------------------------------ the worker's side */

/* The exit code of a worker whose socket holds these bytes and then ends; -1 if it was killed. */
static int worker_after(const void *bytes, size_t length) {
    int ends[2];
    int status = 0;
    static const struct worker_engine engine = {0}; /* never gets that far */
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    write_all(ends[0], bytes, length);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        alarm(20);
        close(ends[0]);
        dup2(ends[1], WORKER_FD);
        _exit(worker_serve(&engine));
    }
    close(ends[0]);
    close(ends[1]);
    waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void test_worker_ends_when_its_socket_closes(void **state) {
    (void)state;
    assert_int_equal(worker_after("", 0), 0);
}

static void test_worker_ends_at_what_is_no_job(void **state) {
    (void)state;
    struct frame_head head = {.type = FRAME_RESULT, .length = 0};
    assert_int_equal(worker_after(&head, sizeof head), 1);
    head = (struct frame_head){.type = FRAME_JOB, .length = 3};
    assert_int_equal(worker_after(&head, sizeof head), 1);
    struct {
        struct frame_head head;
        struct frame_job job;
    } cut = {.head = {.type = FRAME_JOB, .length = sizeof(struct frame_job)},
             .job = {.request_length = 100, .limits = {.max_memory = 1 << 20}}};
    assert_int_equal(worker_after(&cut, sizeof cut), 1);
}

#define WITH_PAIR(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_PAIR(test_frame_arrives_whole),
        WITH_PAIR(test_frame_arrives_byte_by_byte),
        WITH_PAIR(test_frame_cut_off_is_closed),
        WITH_PAIR(test_frame_beyond_the_limit_is_broken),
        WITH_PAIR(test_frame_of_no_known_kind_is_broken),
        WITH_PAIR(test_frame_of_the_largest_size_arrives),
        WITH_PAIR(test_frame_poll_survives_noise),
        WITH_PAIR(test_frame_send_to_nobody_is_false),
        WITH_PAIR(test_frame_outbox_fills_a_full_socket_piecemeal),
        cmocka_unit_test(test_worker_ends_when_its_socket_closes),
        cmocka_unit_test(test_worker_ends_at_what_is_no_job),
    };
    return cmocka_run_group_tests_name("frames", tests, NULL, NULL);
}
