#!/bin/bash
# SPDX-License-Identifier: MIT
# Runs every test and counts: checks of the source, cmocka programs, Python and bats files, first as
# built for use, then built with sanitizers. Prints what fails in full, for the rest one line a
# program. The last line is "N passed, N failed"; the exit status says the same.
# Usage: tests/run.sh BUILD SANITIZED_BUILD
set -u
cd "$(dirname "$0")/.." || exit 1
build=$1 sanitized=$2
limit=900 # seconds one program may take
log=$(mktemp -d)
trap 'rm -rf "$log"' EXIT
passed=0 failed=0

# run NAME COMMAND...: runs a command that speaks TAP and adds what it says.
run() {
    local name=$1 begun=$SECONDS status good bad
    shift
    timeout -k 10 "$limit" "$@" >"$log/out" 2>&1 </dev/null
    status=$?
    good=$(grep -c '^ok ' "$log/out")
    bad=$(grep '^not ok ' "$log/out" | grep -cv '# SKIP') # cmocka's word for skipped
    # A program that ended badly without saying so has failed once more.
    [ "$status" -ne 0 ] && [ "$bad" -eq 0 ] && bad=1
    [ "$status" -eq 0 ] && [ "$good" -eq 0 ] && bad=1
    passed=$((passed + good)) failed=$((failed + bad))
    printf '%-48s %4d passed %3d failed %5d s\n' "$name" "$good" "$bad" $((SECONDS - begun))
    [ "$bad" -eq 0 ] || cat "$log/out"
}

# One check of the source is one test.
check() {
    run "$1" bash -c '"$0" "$@" && echo "ok 1 - $0" || { echo "not ok 1 - $0"; exit 1; }' "$@"
}

for script in tests/checks/*.sh; do
    check "$script" "$build"
done
for b in "$build" "$sanitized"; do
    for source in tests/unit/test_*.c tests/exact/test_*.c tests/store/test_*.c; do
        [ -e "$source" ] || continue
        run "$b/${source%.c}" env CMOCKA_MESSAGE_OUTPUT=TAP "$b/${source%.c}"
    done
    for source in tests/fuzz/fuzz_*.c; do
        name=${source#tests/fuzz/fuzz_}
        run "$b/${source%.c}" "$b/${source%.c}" "tests/fuzz/corpus/${name%.c}"
    done
    for file in tests/faults/test_*.py; do
        run "$b $file" env BUILD="$b" python3 "$file"
    done
    for file in tests/http/*.bats; do
        [ -e "$file" ] || continue
        run "$b $file" env BUILD="$b" bats --tap "$file"
    done
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
