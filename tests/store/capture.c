/* SPDX-License-Identifier: MIT */
#include "capture.h"
#include "scratch.h"
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

void capture_begin(struct capture *capture, int target) {
    fflush(stdout);
    capture->target = target;
    capture->saved = dup(target);
    capture->file = memfd_create("capture", 0);
    assert_true(capture->saved >= 0 && capture->file >= 0);
    assert_true(dup2(capture->file, target) >= 0);
}

void capture_end(struct capture *capture) {
    fflush(stdout);
    assert_true(dup2(capture->saved, capture->target) >= 0);
    ssize_t length = pread(capture->file, capture->text, sizeof capture->text - 1, 0);
    assert_true(length >= 0);
    capture->text[length] = '\0';
    close(capture->saved);
    close(capture->file);
}
