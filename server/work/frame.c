/* SPDX-License-Identifier: MIT */
#include "frame.h"
#include <errno.h>
#include <string.h>
#include <sys/socket.h>

/* Takes `sent` bytes off the front of `count` parts. */
static void advance(struct iovec *parts, size_t count, size_t sent) {
    for (size_t k = 0; k < count && sent > 0; k++) {
        size_t part = parts[k].iov_len < sent ? parts[k].iov_len : sent;
        parts[k].iov_base = (char *)parts[k].iov_base + part;
        parts[k].iov_len -= part;
        sent -= part;
    }
}

static bool all_sent(const struct iovec *parts, size_t count) {
    for (size_t k = 0; k < count; k++)
        if (parts[k].iov_len > 0)
            return false;
    return true;
}

/* One sendmsg; -1 with errno. */
static ssize_t send_parts(int fd, struct iovec *parts, size_t count, int flags) {
    struct msghdr message = {.msg_iov = parts, .msg_iovlen = count};
    ssize_t sent = 0;
    do
        sent = sendmsg(fd, &message, flags | MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    if (sent > 0)
        advance(parts, count, (size_t)sent);
    return sent;
}

/* An iovec is not const, but sendmsg only reads. */
static struct iovec part_of(const void *bytes, size_t length) {
    struct iovec part = {.iov_len = length};
    memcpy(&part.iov_base, &bytes, sizeof bytes);
    return part;
}

bool frame_send(int fd, enum frame_type type, const void *bytes, size_t length) {
    struct frame_head head = {.type = type, .length = (uint32_t)length};
    struct iovec parts[2] = {part_of(&head, sizeof head), part_of(bytes, length)};
    while (!all_sent(parts, 2))
        if (send_parts(fd, parts, 2, 0) < 0)
            return false;
    return true;
}

bool frame_receive(int fd, void *bytes, size_t length) {
    char *to = bytes;
    while (length > 0) {
        ssize_t got = recv(fd, to, length, MSG_WAITALL);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return false;
        to += got;
        length -= (size_t)got;
    }
    return true;
}

/* Where the next bytes of the frame go, and how many are missing there. */
static size_t missing(struct frame_inbox *inbox, void **to) {
    if (inbox->have < sizeof inbox->head) {
        *to = (char *)&inbox->head + inbox->have;
        return sizeof inbox->head - inbox->have;
    }
    size_t of_payload = inbox->have - sizeof inbox->head;
    *to = inbox->bytes + of_payload;
    return inbox->head.length - of_payload;
}

static bool sensible(const struct frame_head *head) {
    return head->type >= FRAME_PROGRESS && head->type <= FRAME_PROBLEM &&
           head->length <= FRAME_MAX_BYTES;
}

static bool whole(const struct frame_inbox *inbox) {
    return inbox->have >= sizeof inbox->head &&
           inbox->have == sizeof inbox->head + inbox->head.length;
}

enum frame_state frame_poll(int fd, struct frame_inbox *inbox) {
    if (whole(inbox))
        inbox->have = 0;
    do {
        void *to = NULL;
        size_t length = missing(inbox, &to);
        ssize_t got = recv(fd, to, length, MSG_DONTWAIT);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK))
            return FRAME_LATER;
        if (got <= 0)
            return FRAME_CLOSED;
        inbox->have += (size_t)got;
        if (inbox->have >= sizeof inbox->head && !sensible(&inbox->head))
            return FRAME_BROKEN;
    } while (!whole(inbox));
    return FRAME_READY;
}

void frame_outbox_fill(struct frame_outbox *outbox, const struct frame_work *work,
                       const struct api_input *input, const struct api_limits *limits) {
    memset(outbox, 0, sizeof *outbox);
    outbox->head = (struct frame_head){.type = FRAME_JOB, .length = sizeof outbox->job};
    outbox->job.limits = *limits;
    outbox->job.kind = work->kind;
    outbox->job.careful = work->careful;
    outbox->job.spent_ms = work->spent_ms;
    outbox->job.length = work->length;
    outbox->job.request_length = input->request_length;
    outbox->job.surface_length = input->surface_length;
    outbox->parts[0] = part_of(&outbox->head, sizeof outbox->head);
    outbox->parts[1] = part_of(&outbox->job, sizeof outbox->job);
    outbox->parts[2] = part_of(work->bytes, work->length);
    outbox->parts[3] = part_of(input->request, input->request_length);
    outbox->parts[4] = part_of(input->surface, input->surface_length);
}

enum frame_state frame_push(int fd, struct frame_outbox *outbox) {
    while (!all_sent(outbox->parts, 5)) {
        if (send_parts(fd, outbox->parts, 5, MSG_DONTWAIT) >= 0)
            continue;
        return errno == EAGAIN || errno == EWOULDBLOCK ? FRAME_LATER : FRAME_CLOSED;
    }
    return FRAME_READY;
}
