#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs every test and counts: checks of the source, cmocka programs, fuzz inputs, Python and bats files, first as
# built for use, then built with sanitizers; then the page in Chromium and what is in deploy/. Prints
# what fails in full, for the rest one line a program. The last line is "N passed, N failed"; the
# exit status says the same.
# Usage: tests/run.sh BUILD SANITIZED_BUILD
set -u
cd "$(dirname "$0")/.." || exit 1
build=$1 sanitized=$2
limit=900 # seconds one program may take
log=$(mktemp -d)
trap 'rm -rf "$log"' EXIT
: >"$log/counts"

# run NAME COMMAND...: runs a command that speaks TAP and notes what it says.
run() {
    local name=$1 begun=$SECONDS status good bad out
    shift
    out=$(mktemp "$log/out.XXXXXX")
    timeout -k 10 "$limit" "$@" >"$out" 2>&1 </dev/null
    status=$?
    good=$(grep -c '^ok ' "$out")
    bad=$(grep '^not ok ' "$out" | grep -cv '# SKIP') # cmocka's word for skipped
    # A program that ended badly without saying so has failed once more.
    [ "$status" -ne 0 ] && [ "$bad" -eq 0 ] && bad=1
    [ "$status" -eq 0 ] && [ "$good" -eq 0 ] && bad=1
    {
        flock 9
        echo "$good $bad" >>"$log/counts"
        printf '%-48s %4d passed %3d failed %5d s\n' "$name" "$good" "$bad" $((SECONDS - begun))
        [ "$bad" -eq 0 ] || cat "$out"
    } 9>>"$log/lock"
    rm -f "$out"
}

# The same, as many at a time as there are processors: for what only computes. `wait` ends it.
beside() {
    while [ "$(jobs -pr | wc -l)" -ge "$(nproc)" ]; do wait -n; done
    run "$@" &
}

# One check of the source is one test.
check() {
    run "$1" bash -c '"$0" "$@" && echo "ok 1 - $0" || { echo "not ok 1 - $0"; exit 1; }' "$@"
}

for script in tests/checks/*.sh; do
    check "$script" "$build"
done
for b in "$build" "$sanitized"; do
    for source in tests/exact/test_*.c tests/unit/test_*.c tests/store/test_*.c; do
        [ -e "$source" ] || continue
        beside "$b/${source%.c}" env CMOCKA_MESSAGE_OUTPUT=TAP "$b/${source%.c}"
    done
    for source in tests/fuzz/fuzz_*.c; do
        name=${source#tests/fuzz/fuzz_}
        beside "$b/${source%.c}" "$b/${source%.c}" "tests/fuzz/corpus/${name%.c}"
    done
    wait
    for file in tests/faults/test_*.py; do
        run "$b $file" env BUILD="$b" python3 "$file"
    done
    for file in tests/http/*.bats; do
        [ -e "$file" ] || continue
        run "$b $file" env BUILD="$b" bats --tap "$file"
    done
done
# The page runs in the browser, not in the daemon: once is enough. So it is for what runs the daemon
# as users install it.
for file in tests/browser/*.test.mjs; do
    run "$file" env BUILD="$build" node --test-reporter=tap "$file"
done
for file in tests/deploy/*.bats; do
    run "$file" env BUILD="$build" bats --tap "$file"
done
run tests/hosts/hosts.sh tests/hosts/hosts.sh "$build" 200
awk '{p += $1; f += $2} END {print p + 0 " passed, " f + 0 " failed"; exit f > 0}' "$log/counts"
