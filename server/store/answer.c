/* SPDX-License-Identifier: MIT */
#include "answer.h"

const char *store_answer_name(enum store_answer answer) {
    static const char *const names[] = {"ok",
                                        "empty",
                                        "conflict",
                                        "full",
                                        "altered",
                                        "busy",
                                        "down",
                                        "out of disk space",
                                        "read-only",
                                        "damaged",
                                        "missing from its path"};
    return names[answer];
}
