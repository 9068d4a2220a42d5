#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs what is threaded under ThreadSanitizer: the tests of the store and of what works on it and,
# over HTTP, the files that have many calls at a time. A race ends the program, and so fails its
# test. The libraries are not instrumented; nothing they do has had to be suppressed.
# Usage: tests/run_tsan.sh BUILD
set -u
cd "$(dirname "$0")/.." || exit 1
build=$1
export TSAN_OPTIONS=halt_on_error=1
log=$(mktemp)
trap 'rm -f "$log"' EXIT
failed=0
LONGEST=1800 # seconds of one: test_store_faults takes two minutes of a processor

# run NAME COMMAND...
run() {
    local name=$1 begun=$SECONDS status=0
    shift
    timeout -k 10 "$LONGEST" "$@" >"$log" 2>&1 </dev/null || status=$?
    [ "$status" -eq 0 ] || { cat "$log"; failed=$((failed + 1)); }
    printf '%-40s status %d, %d s\n' "$name" "$status" $((SECONDS - begun))
}

for source in tests/store/test_*.c tests/server/test_*.c; do
    run "$source" "$build/${source%.c}"
done
for file in tests/http/drapes.bats tests/http/jobs.bats tests/http/framing.bats; do
    run "$file" env BUILD="$build" bats --tap "$file"
done
echo "$failed failed"
[ "$failed" -eq 0 ]
