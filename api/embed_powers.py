#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The powers of ten that api/json/shortest.c multiplies by: g(k) = ceil(10^k 2^(127 - floor(log2 10^k))),
128 bits each, for k = -292 .. 324; and for api/json/digits.h the rows of digits_scales, by binary exponent.
Usage: embed_powers.py HEADER"""

import sys
from fractions import Fraction

FIRST, LAST = -292, 324
SCALES_FIRST, SCALES_LAST, BIAS = 890, 1079, 1075


def power(k):
    up, down = 10 ** max(k, 0), 10 ** max(-k, 0)
    shift = 128 - up.bit_length() + down.bit_length()
    while True:  # at most twice: until the quotient has 128 bits
        g = -(-(up << shift) // down) if shift >= 0 else -(-up // (down << -shift))
        if g.bit_length() <= 128:
            return g
        shift -= 1


def scale(exponent):
    """10^-k as the sum of two doubles, and 17 + k; 10^k <= 2^e < 10^(k + 1), e the unit's exponent."""
    e, k = exponent - BIAS, -60
    while Fraction(10) ** (k + 1) <= Fraction(2) ** e:
        k += 1
    power = Fraction(10) ** -k
    high = float(power)
    return high, float(power - Fraction(high)), 17 + k


with open(sys.argv[1], "w", encoding="ascii") as header:
    header.write(f"enum {{ POWERS_FIRST = {FIRST}, POWERS_LAST = {LAST} }};\n")
    header.write("static const uint64_t powers[][2] = {\n")
    for k in range(FIRST, LAST + 1):
        g = power(k)
        assert g.bit_length() == 128
        header.write(f"    {{{g >> 64:#x}, {g & (1 << 64) - 1:#x}}},\n")
    header.write("};\n")
    header.write("#define POWERS_SCALES \\\n")
    for e in range(SCALES_FIRST, SCALES_LAST + 1):
        high, low, point = scale(e)
        header.write(f"    {{{high.hex()}, {low.hex()}, {point}}}, \\\n")
    header.write("    {0, 0, 0}\n")
