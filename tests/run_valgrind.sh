#!/bin/bash
# SPDX-License-Identifier: MIT
# A drape by the command and the same by the daemon and its worker, from start to SIGTERM, under
# valgrind: no use of memory that is not there or not set, and nothing lost. In its sandbox valgrind
# could not work, and a worker starts as /proc/self/exe, which here is valgrind: watched.c changes
# both. Usage: tests/run_valgrind.sh BUILD
set -eu
cd "$(dirname "$0")/.."
build=$1
work=$(mktemp -d)
daemon=
clean_up() {
    [ -z "$daemon" ] || { kill -KILL "$daemon"; tail -20 "$work/log"; }
    rm -rf "$work"
}
trap clean_up EXIT
check=(valgrind --quiet --error-exitcode=99 --leak-check=full --show-leak-kinds=definite
    --errors-for-leak-kinds=definite)

jq -c '.fabric.spacing = 0.2' api/examples/saddle.json >"$work/request.json"
for format in json csv vtp glb npz; do
    "${check[@]}" "$build/drape" "$work/request.json" --format "$format" -o "$work/result"
    [ -s "$work/result" ]
done
echo 'drape: no errors, no leaks'

# Every process has a log of its own; what valgrind finds is in lines that begin with ==. (That it
# does not know the system call seccomp is in others.)
gcc -shared -fPIC -D_GNU_SOURCE -Wall -Werror -o "$work/watched.so" tests/watched.c
LD_PRELOAD=$work/watched.so "${check[@]}" --trace-children=yes --log-file="$work/valgrind.%p" \
    "$build/draped" --listen 127.0.0.1:0 --data "$work/data" --workers 1 \
    >"$work/out" 2>"$work/log" &
daemon=$!
for _ in $(seq 300); do
    ! grep -q listening "$work/out" || break
    sleep 0.1
done
url=$(sed -n 's/^draped listening on //p' "$work/out")
ask() { curl -sS --fail --max-time 60 -o "$work/answer" "$@"; }
ask -H 'Content-Type: application/json' -H 'Prefer: wait=50' --data-binary "@$work/request.json" \
    "$url/v1/drapes"
id=$(jq -r .id "$work/answer")
for path in "" /request /events /result "/result?format=csv" "/result?format=npz" /pattern; do
    ask "$url/v1/drapes/$id$path"
done
ask --compressed "$url/v1/drapes/$id/result?format=vtp"
ask -H 'Content-Type: application/json' -d '{"points": [[0, 0, 0], [1, 1, 0]]}' \
    "$url/v1/drapes/$id/map"
for path in / /healthz /readyz /metrics /v1/limits /v1/openapi.json /v1/drapes; do
    ask "$url$path"
done
if ask -H 'Content-Type: application/json' -d '{"surface"' "$url/v1/drapes" 2>/dev/null; then exit 1; fi
ask -X DELETE "$url/v1/drapes/$id"
kill -TERM "$daemon"
status=0
wait "$daemon" || status=$?
daemon=
[ "$status" = 0 ] || { cat "$work/log"; exit 1; }
processes=$(find "$work" -name 'valgrind.*' | wc -l)
[ "$processes" -ge 2 ] || { echo 'the worker was not watched'; exit 1; }
if grep -h '^==' "$work"/valgrind.*; then exit 1; fi
echo "draped, $processes processes: no errors, no leaks"
