#!/bin/bash
# SPDX-License-Identifier: MIT
# What the solver library needs from outside: arithmetic, memory, sorting, and nothing else.
set -u
library=$1/libdrape.a
allowed='aligned_alloc|calloc|madvise|free|memchr|memcpy|memmove|memset|qsort|sqrt|floor|ceil|fmin|fmax|nearbyint|frexp|ldexp'
compiler='__popcount[sd]i2|__cpu_model|__cpu_indicator_init|_GLOBAL_OFFSET_TABLE_|__stack_chk_fail|__mem(cpy|move|set)_chk'
own=$(nm --defined-only "$library" | awk 'NF == 3 && $2 ~ /[A-Zi]/ {print $3}' | sort -u)
needed=$(nm -u "$library" | awk '$1 == "U" {print $2}' | sort -u)
foreign=$(comm -13 <(echo "$own") <(echo "$needed") | grep -vxE "$allowed|$compiler")
[ -z "$foreign" ] || { echo "libdrape.a needs:" $foreign; exit 1; }
