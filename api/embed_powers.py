#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The powers of ten that api/json/shortest.c multiplies by: g(k) = ceil(10^k 2^(127 - floor(log2 10^k))),
128 bits each, for k = -292 .. 324. Usage: embed_powers.py HEADER"""

import sys

FIRST, LAST = -292, 324


def power(k):
    up, down = 10 ** max(k, 0), 10 ** max(-k, 0)
    shift = 128 - up.bit_length() + down.bit_length()
    while True:  # at most twice: until the quotient has 128 bits
        g = -(-(up << shift) // down) if shift >= 0 else -(-up // (down << -shift))
        if g.bit_length() <= 128:
            return g
        shift -= 1


with open(sys.argv[1], "w", encoding="ascii") as header:
    header.write(f"enum {{ POWERS_FIRST = {FIRST}, POWERS_LAST = {LAST} }};\n")
    header.write("static const uint64_t powers[][2] = {\n")
    for k in range(FIRST, LAST + 1):
        g = power(k)
        assert g.bit_length() == 128
        header.write(f"    {{{g >> 64:#x}, {g & (1 << 64) - 1:#x}}},\n")
    header.write("};\n")
