#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs the tests of a build with --coverage and prints the share of lines they ran: of each folder,
# of all, and of each file below 80 %. A worker or daemon that is killed leaves no counts, so the
# figures are a lower bound. Of tests/exact those that are short without optimization.
# Usage: tests/run_coverage.sh BUILD
set -eu
cd "$(dirname "$0")/.."
build=$1
find "$build" -name '*.gcda' -delete
for source in tests/unit/test_*.c \
    tests/exact/test_exact_{limits,parts,path}.c tests/store/test_*.c; do
    timeout 600 "$build/${source%.c}" >"$build/test.log" 2>&1 ||
        { tail -20 "$build/test.log"; echo "$source failed"; }
done
for file in tests/http/*.bats; do
    BUILD=$build timeout 600 bats --tap "$file" >"$build/test.log" 2>&1 ||
        { grep -A20 '^not ok' "$build/test.log"; echo "$file failed"; }
done
gcovr --root . --object-directory "$build" --filter 'solver/' --filter 'api/' --filter 'server/' \
    --csv - "$build" | awk -F, 'NR > 1 {
        split($1, part, "/")
        lines[part[1]] += $2; hit[part[1]] += $3; lines["all"] += $2; hit["all"] += $3
        if ($3 < 0.8 * $2) printf "%-32s %5.1f %% of %d lines\n", $1, 100 * $3 / $2, $2
    } END {
        for (k in lines) printf "%-32s %5.1f %% of %d lines\n", k, 100 * hit[k] / lines[k], lines[k]
    }'
