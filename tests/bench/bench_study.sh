#!/bin/bash
# SPDX-License-Identifier: MIT
# Studies over loopback, and what they cost others: how long 500 variants of about 900 nodes take from
# the request to the last byte of the result, by the number of workers, and on both stores how long a
# drape takes alone, beside studies of its owner and beside studies of another. The least, the median and
# the most of some.
# Usage: tests/bench/bench_study.sh BUILD [STUDIES]
set -eu
cd "$(dirname "$0")/../.."
build=$1 studies=${2:-1000}
work=$(mktemp -d /tmp/draped-bench-XXXXXX)
chmod 755 "$work" # for the user of PostgreSQL
. tests/postgres.bash
trap 'kill "$daemon" 2>/dev/null; wait 2>/dev/null; postgres_stop; rm -rf "$work"' EXIT

start() { # start FLAG...
    rm -rf "$work/data"
    "$build/draped" --listen 127.0.0.1:0 --data "$work/data" --owner-queue 1000000 \
        --queue-limit 1000000 "$@" >"$work/out" 2>"$work/log" &
    daemon=$!
    until url=$(sed -n 's/^draped listening on //p' "$work/out") && [ -n "$url" ]; do
        kill -0 $daemon
        sleep 0.05
    done
}
stop() { kill $daemon && wait $daemon || true; }

# The saddle with K percent more than the spacing of 900 nodes, so that no two are equal.
request() { jq -c --argjson k "$1" '.fabric.spacing = 0.186 * (1 + $k * 1e-6)' api/examples/saddle.json; }
study() {
    request "$1" | jq -c '{drape: ., vary: {start: {grid: 50}, angle_deg: {from: 0, to: 81, step: 9}},
        objectives: ["max_shear_deg", "waste_area"]}'
}

# post PATH: the standard input; seconds to the last byte of the answer
post() {
    curl -sS --fail -o "$work/answer" -w '%{time_total}\n' -H 'Content-Type: application/json' \
        -H "Prefer: wait=${2:-0}" ${3:+-H "X-Forwarded-For: $3"} --data-binary @- "$url/v1/$1"
}
spread() { sort -n | awk '{t[NR] = $1} END {
    printf "%7.1f %7.1f %7.1f ms", 1e3 * t[1], 1e3 * t[int((NR + 1) / 2)], 1e3 * t[NR]}'; }

for workers in ${BENCH_WORKERS-1 2 4}; do
    start --workers $workers
    for k in {1..7}; do study "$k" | post studies 60; done | spread >"$work/times"
    echo "500 variants, $workers worker(s) on $(nproc) cores: $(cat "$work/times")"
    stop
done

drapes() { for k in {1..15}; do request "$1$k" | post drapes 60 "${2:-}"; done | spread; }
beside_studies() { # beside_studies FLAG...
    start --workers 2 --trusted-proxy 127.0.0.1 "$@"
    echo "a drape alone:                         $(drapes 1)"
    for ((k = 0; k < studies; k++)); do study $((1000 + k)) | post studies 0 10.0.0.1 >/dev/null; done
    echo "a drape beside $studies studies of its owner: $(drapes 2 10.0.0.1)"
    echo "a drape beside $studies studies of another:   $(drapes 3 10.0.0.2)"
    curl -sS "$url/v1/studies?status=succeeded&limit=1000" -H 'X-Forwarded-For: 10.0.0.1' |
        jq -r '"studies that had ended by then: \(.studies | length)"'
    stop
}
echo SQLite
beside_studies
echo PostgreSQL
postgres_make "$work/pg"
postgres_start "$work/pg" ''
beside_studies --store "postgresql://draped@/postgres?host=$work/pg"
