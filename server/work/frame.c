/* SPDX-License-Identifier: MIT */
#include "frame.h"
#include <errno.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* The descriptors of a message. */
union frame_control {
    struct cmsghdr head;
    char bytes[CMSG_SPACE(FRAME_FILES_MAX * sizeof(int))];
};

/* ------------------------------------------------------------------ sending */

void frame_outbox_add(struct frame_outbox *outbox, const void *bytes, size_t length) {
    struct iovec *part = &outbox->parts[outbox->part_count++];
    part->iov_len = length;
    memcpy(&part->iov_base, &bytes, sizeof bytes); /* it is not const, but sendmsg only reads */
}

void frame_outbox_begin(struct frame_outbox *outbox, enum frame_type type, const void *body,
                        size_t length) {
    *outbox = (struct frame_outbox){.head = {.type = type, .length = (uint32_t)length}};
    frame_outbox_add(outbox, &outbox->head, sizeof outbox->head);
    frame_outbox_add(outbox, body, length);
}

void frame_outbox_fill(struct frame_outbox *outbox, struct frame_job *job, const void *bytes,
                       const struct api_input *input, const int *form) {
    job->request_length = input->request_length;
    job->surface_length = input->surface_length;
    frame_outbox_begin(outbox, FRAME_JOB, job, sizeof *job);
    frame_outbox_add(outbox, bytes, job->length);
    frame_outbox_add(outbox, input->request, input->request_length);
    frame_outbox_add(outbox, input->surface, input->surface_length);
    outbox->files = form;
    outbox->file_count = job->form_length > 0;
}

/* The files go before the first byte. */
static enum frame_state send_all(int fd, struct frame_outbox *outbox, int flags) {
    for (size_t k = 0; k < outbox->part_count;) {
        if (outbox->parts[k].iov_len == 0) {
            k++;
            continue;
        }
        union frame_control control = {0};
        struct msghdr message = {.msg_iov = outbox->parts, .msg_iovlen = outbox->part_count};
        size_t length = outbox->file_count * sizeof(int);
        if (length > 0) {
            control.head.cmsg_level = SOL_SOCKET;
            control.head.cmsg_type = SCM_RIGHTS;
            control.head.cmsg_len = CMSG_LEN(length);
            memcpy(CMSG_DATA(&control.head), outbox->files, length);
            message.msg_control = control.bytes;
            message.msg_controllen = CMSG_SPACE(length);
        }
        ssize_t sent = TEMP_FAILURE_RETRY(sendmsg(fd, &message, flags | MSG_NOSIGNAL));
        if (sent < 0)
            return errno == EAGAIN || errno == EWOULDBLOCK ? FRAME_LATER : FRAME_CLOSED;
        outbox->file_count = 0;
        /* What was taken is off the parts. */
        for (size_t n = k, left = (size_t)sent; n < outbox->part_count && left > 0; n++) {
            struct iovec *part = &outbox->parts[n];
            size_t taken = part->iov_len < left ? part->iov_len : left;
            part->iov_base = (char *)part->iov_base + taken;
            part->iov_len -= taken;
            left -= taken;
        }
    }
    return FRAME_READY;
}

bool frame_send(int fd, enum frame_type type, const void *bytes, size_t length) {
    struct frame_outbox outbox;
    frame_outbox_begin(&outbox, type, bytes, length);
    return send_all(fd, &outbox, 0) == FRAME_READY;
}

enum frame_state frame_push(int fd, struct frame_outbox *outbox) {
    return send_all(fd, outbox, MSG_DONTWAIT);
}

/* ------------------------------------------------------------------ receiving */

bool frame_receive(int fd, void *bytes, size_t length) {
    char *to = bytes;
    while (length > 0) {
        ssize_t got = TEMP_FAILURE_RETRY(recv(fd, to, length, MSG_WAITALL));
        if (got <= 0)
            return false;
        to += got;
        length -= (size_t)got;
    }
    return true;
}

enum frame_state frame_expect(int fd, enum frame_type type, void *body, size_t length, int *files,
                              int *file_count) {
    struct frame_head head;
    union frame_control control;
    struct iovec parts[] = {{&head, sizeof head}, {body, length}};
    struct msghdr message = {.msg_iov = parts,
                             .msg_iovlen = 2,
                             .msg_control = files ? control.bytes : NULL,
                             .msg_controllen = files ? sizeof control.bytes : 0};
    ssize_t got = TEMP_FAILURE_RETRY(recvmsg(fd, &message, MSG_CMSG_CLOEXEC | MSG_WAITALL));
    if (got <= 0)
        return FRAME_CLOSED;
    const struct cmsghdr *sent = CMSG_FIRSTHDR(&message);
    if (files) {
        *file_count = sent ? (int)((sent->cmsg_len - CMSG_LEN(0)) / sizeof(int)) : 0;
        memcpy(files, sent ? CMSG_DATA(sent) : (unsigned char *)"",
               (size_t)*file_count * sizeof(int));
    }
    size_t have = (size_t)got, of_body = have > sizeof head ? have - sizeof head : 0;
    bool good = have >= sizeof head || frame_receive(fd, (char *)&head + have, sizeof head - have);
    if (!good || message.msg_flags & MSG_CTRUNC || head.type != type || head.length != length)
        return FRAME_BROKEN;
    return frame_receive(fd, (char *)body + of_body, length - of_body) ? FRAME_READY : FRAME_BROKEN;
}

/* Whether it is all there. */
static bool frame_is_whole(const struct frame_inbox *inbox) {
    return inbox->have >= sizeof inbox->head &&
           inbox->have == sizeof inbox->head + inbox->head.length;
}

enum frame_state frame_poll(int fd, struct frame_inbox *inbox) {
    if (frame_is_whole(inbox))
        inbox->have = 0;
    do {
        bool of_head = inbox->have < sizeof inbox->head;
        size_t at = of_head ? inbox->have : inbox->have - sizeof inbox->head;
        char *to = of_head ? (char *)&inbox->head : (char *)inbox->bytes;
        size_t length = of_head ? sizeof inbox->head : inbox->head.length;
        ssize_t got = TEMP_FAILURE_RETRY(recv(fd, to + at, length - at, MSG_DONTWAIT));
        if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK))
            return FRAME_LATER;
        if (got <= 0)
            return FRAME_CLOSED;
        inbox->have += (size_t)got;
        if (inbox->have >= sizeof inbox->head &&
            (inbox->head.type < FRAME_HELLO || inbox->head.type > FRAME_PROBLEM ||
             inbox->head.length > FRAME_MAX_BYTES))
            return FRAME_BROKEN;
    } while (!frame_is_whole(inbox));
    return FRAME_READY;
}
