#!/bin/bash
# SPDX-License-Identifier: MIT
# Random tests begin with the same seed in every run; here with others, which nobody has tried. What
# fails is said with its seed, and what it printed; the cut parts that have another net than the whole,
# each by a seed of its own; and of what tests count, the shares of all seeds ("share: N of M WHAT" in
# their output). Ten rounds cut 1,000 parts. Usage: tests/seeds.sh BUILD ROUNDS
set -u
cd "$(dirname "$0")/.." || exit 1
build=$1 rounds=$2 failed=0
output=$(mktemp) shares=$(mktemp)
trap 'rm -f "$output" "$shares"' EXIT
export BUILD=$build CMOCKA_MESSAGE_OUTPUT=TAP DRAPED_SEED DRAPED_TEST_SIZE=0.1
for ((round = 1; round <= rounds; round++)); do
    DRAPED_SEED=$((RANDOM << 15 | RANDOM))
    for source in $(grep -lE 'random_begin|check_seed|check_rounds|DRAPED_SEED' tests/{unit,exact,store}/test_*.c) \
        tests/import/test_splits.py; do
        test=$build/${source%.c}
        [ "$source" = "${source%.py}" ] || test=$source
        "$test" >"$output" 2>&1
        status=$?
        grep '^ *share: ' "$output" >>"$shares"
        [ $status -eq 0 ] && grep '^ *part of seed' "$output"
        [ $status -eq 0 ] && continue
        failed=$((failed + 1))
        echo "DRAPED_SEED=$DRAPED_SEED DRAPED_TEST_SIZE=$DRAPED_TEST_SIZE BUILD=$build $test"
        grep -v '^ok' "$output"
    done
done
awk '{ what = $0; sub(/.* of [0-9]+ /, "", what); some[what] += $2; all[what] += $4 }
    END { for (what in all) printf "%d of %d (%.2f %%) %s\n", some[what], all[what],
            100 * some[what] / all[what], what }' "$shares" | sort -k 6
echo "$rounds seeds, $failed failures"
[ $failed -eq 0 ]
