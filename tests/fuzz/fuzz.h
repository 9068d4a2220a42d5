/* SPDX-License-Identifier: MIT */
/*
 * Fuzz targets: each file fuzz_NAME.c defines the function below, which libFuzzer calls with bytes
 * of its own (`make fuzz`) and replay.c with those of corpus/NAME (`make test`). Besides what the
 * sanitizers see, a target aborts when a promise of the header it tests is broken.
 */
#ifndef TESTS_FUZZ_H
#define TESTS_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

/* service.c: whether this process is one of the pool that reads bodies. */
int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define FUZZ_PROMISE(condition)                                                                    \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: broken promise: %s\n", __FILE__, __LINE__, #condition);        \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

#endif
