/* SPDX-License-Identifier: MIT */
/*
 * What one owner may have of what there is for all: no more than is left. This is the dynamic
 * threshold of A. K. Choudhury and E. L. Hahne, "Dynamic queue length thresholds for shared-memory
 * packet switches", IEEE/ACM Transactions on Networking 6 (1998) 130-140. An owner alone may have
 * half; of n that take all they can, and use it up, each comes to 1 / (n + 1), and as much is left,
 * so that whoever comes then finds a place. Nothing is taken back: who has more when others come
 * gets no more until it has less than is left.
 *
 * Queued jobs (`server/store/`), connections, streams and bodies (`server/http/quotas.h`).
 */
#ifndef SERVER_SHARE_H
#define SERVER_SHARE_H

#include <stdbool.h>
#include <stdint.h>

/* Whether an owner who has `held` of the `taken` by all, of `limit`, may have `more` > 0 besides:
 * one after the other, each as long as it has less than is left. */
static inline bool share_fits(int64_t held, int64_t taken, int64_t limit, int64_t more) {
    int64_t before_last = more - 1;
    return held + before_last < limit - taken - before_last;
}

#endif
