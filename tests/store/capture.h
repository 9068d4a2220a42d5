/* SPDX-License-Identifier: MIT */
/* Catches what is written to stdout or stderr between two calls. */
#ifndef TESTS_CAPTURE_H
#define TESTS_CAPTURE_H

#include <stddef.h>

struct capture {
    int target; /* the descriptor */
    int saved;
    int file;
    char text[65536]; /* after the end, zero-terminated */
};

void capture_begin(struct capture *capture, int target);
void capture_end(struct capture *capture);

#endif
