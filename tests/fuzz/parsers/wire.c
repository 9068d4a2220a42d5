/* SPDX-License-Identifier: MIT */
/* How server/http/wire.h reads inputs of standard input, for parsers.py: each is its length in four
 * bytes, most significant first, and its bytes; a line is printed for each: where its messages end,
 * then "ok" (nothing is left over), "more" (the last message is incomplete) or what is wrong. */
#include "server/http/wire.h"
#include <stdio.h>
#include <stdlib.h>

static void print_verdict(const char *bytes, size_t length) {
    struct wire wire;
    wire_init(&wire);
    for (size_t at = 0; at < length; at++) {
        uint64_t messages = wire.messages;
        if (wire_check(&wire, bytes + at, 1, NULL) == 0)
            break;
        if (wire.messages > messages)
            printf("%zu ", at + 1);
    }
    puts(wire.detail ? wire.detail : wire_between(&wire) ? "ok" : "more");
}

int main(void) {
    unsigned char head[4];
    while (fread(head, 1, 4, stdin) == 4) {
        size_t length =
            (size_t)head[0] << 24 | (size_t)head[1] << 16 | (size_t)head[2] << 8 | head[3];
        char *bytes = malloc(length + 1);
        if (!bytes || fread(bytes, 1, length, stdin) != length)
            return 1;
        print_verdict(bytes, length);
        fflush(stdout);
        free(bytes);
    }
    return 0;
}
