/* SPDX-License-Identifier: MIT */
/* The bytes of a connection: the first one says how they are split. The verdict does not depend on
 * that, and what a message takes is never more than there is. */
#include "fuzz.h"

#include "server/http/wire.h"
#include <string.h>

/* Fed in pieces of `piece` bytes; how many were good. */
static size_t feed(struct wire *wire, const char *bytes, size_t length, size_t piece) {
    size_t at = 0, begun;
    wire_init(wire);
    while (at < length && wire->problem == API_OK) {
        size_t most = piece < length - at ? piece : length - at;
        size_t good = wire_check(wire, bytes + at, most, &begun);
        FUZZ_PROMISE(good <= most && begun <= good);
        FUZZ_PROMISE((good == most) == (wire->problem == API_OK));
        at += good;
    }
    return at;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct wire whole, pieces;
    if (!size)
        return 0;
    const char *bytes = (const char *)data + 1;
    size_t good = feed(&whole, bytes, size - 1, size);
    FUZZ_PROMISE(feed(&pieces, bytes, size - 1, 1 + data[0] % 16) == good);
    FUZZ_PROMISE(pieces.messages == whole.messages && pieces.problem == whole.problem);
    FUZZ_PROMISE(pieces.detail == whole.detail && pieces.closing == whole.closing);
    FUZZ_PROMISE((whole.detail != NULL) == (whole.problem != API_OK));
    FUZZ_PROMISE(whole.messages <= size / 16); /* the shortest one is "A / HTTP/1.0\r\n\r\n" */
    if (whole.problem != API_OK)
        FUZZ_PROMISE(wire_check(&whole, bytes, 1, NULL) == 0);
    return 0;
}
