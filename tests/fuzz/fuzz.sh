#!/bin/bash
# SPDX-License-Identifier: MIT
# Fuzzes each target for some seconds, beginning with the committed corpus; what is found new stays
# in BUILD/corpus for the next time. An input that breaks something is left in BUILD as NAME-crash-*
# (or -timeout-, -oom-): fix it, give it a name and commit it to tests/fuzz/corpus/NAME.
# Usage: tests/fuzz/fuzz.sh BUILD SECONDS NAME...
set -u
build=$1 seconds=$2
shift 2
failed=0
for name in "$@"; do
    mkdir -p "$build/corpus/$name"
    "$build/tests/fuzz/run_$name" -max_total_time="$seconds" -timeout=30 -rss_limit_mb=1024 \
        -max_len=16384 -print_final_stats=1 -artifact_prefix="$build/$name-" \
        "$build/corpus/$name" "tests/fuzz/corpus/$name" >"$build/$name.log" 2>&1
    status=$?
    runs=$(awk '/^stat::number_of_executed_units/ {print $2}' "$build/$name.log")
    echo "$name: ${runs:-?} runs, $(ls "$build/corpus/$name" | wc -l) inputs, status $status"
    [ "$status" -eq 0 ] || { failed=1; tail -40 "$build/$name.log"; }
done
exit "$failed"
