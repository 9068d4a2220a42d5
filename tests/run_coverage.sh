#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs the tests of a build with --coverage and prints the share of lines they ran: of each folder,
# of all, and of each file below 80 %. A daemon that is killed leaves no counts, so the figures are a
# lower bound; workers leave theirs (watched.c). Of tests/exact those that are short without
# optimization.
# Usage: tests/run_coverage.sh BUILD
set -eu
cd "$(dirname "$0")/.."
build=$1
find "$build" -name '*.gcda' -delete
failed=0
fail() {
    echo "$1 failed"
    failed=1
}
gcc -shared -fPIC -D_GNU_SOURCE -Wall -Werror -o "$build/watched.so" tests/watched.c
preload=$(realpath "$build/watched.so")
for source in tests/unit/test_*.c \
    tests/exact/test_exact_{limits,parts,path}.c tests/store/test_*.c tests/server/test_*.c; do
    timeout 600 "$build/${source%.c}" >"$build/test.log" 2>&1 ||
        { tail -20 "$build/test.log"; fail "$source"; }
done
for file in tests/http/*.bats tests/deploy/service.bats; do
    # There libraries are counted for the bill of materials.
    [ "$file" != tests/deploy/service.bats ] || preload=
    BUILD=$build LD_PRELOAD=$preload timeout 600 bats --tap "$file" >"$build/test.log" 2>&1 ||
        { grep -A20 '^not ok' "$build/test.log"; fail "$file"; }
done
gcovr --root . --object-directory "$build" --filter 'solver/' --filter 'api/' --filter 'cli/' --filter 'import/' --filter 'server/' \
    --csv - "$build" | awk -F, 'NR > 1 {
        split($1, part, "/")
        lines[part[1]] += $2; hit[part[1]] += $3; lines["all"] += $2; hit["all"] += $3
        if ($3 < 0.8 * $2) printf "%-32s %5.1f %% of %d lines\n", $1, 100 * $3 / $2, $2
    } END {
        for (k in lines) printf "%-32s %5.1f %% of %d lines\n", k, 100 * hit[k] / lines[k], lines[k]
    }'
exit "$failed"
