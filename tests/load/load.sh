#!/bin/bash
# SPDX-License-Identifier: MIT
# What the daemon bears on this machine, each figure with its target. Rates stand next to that of
# libmicrohttpd alone in the same run, because what else the machine does changes both. Only answers
# of the wrong kind make it fail: a missed target on a busy machine says nothing.
# LOAD_SECONDS is the length of the soak, in seconds of processor time of the daemon and its workers (60).
# Usage: tests/load/load.sh BUILD
set -eu
cd "$(dirname "$0")/../.."
build=$1
soak=${LOAD_SECONDS:-60}
ulimit -n "$(ulimit -Hn)" # a descriptor a stream
work=$(mktemp -d)
daemon=
url=

stop() {
    [ -z "$daemon" ] || { kill "$daemon"; wait "$daemon" || true; }
    daemon=
    rm -rf "$work/data" "$work/out"
}
trap 'stop; rm -rf "$work"' EXIT

# start FLAG...: a daemon with an empty store; sets daemon and url.
start() {
    stop
    "$build/draped" --listen 127.0.0.1:0 --data "$work/data" --queue-limit 10000000 \
        --owner-queue 10000000 --max-connections 6400 --owner-streams 4096 \
        --log-level warning "$@" >"$work/out" 2>>"$work/log" &
    daemon=$!
    wait_listening "$work/out"
    url=$(sed -n 's/^draped listening on //p' "$work/out")
}

wait_listening() { until grep -qs listening "$1"; do sleep 0.05; done; }

# say NAME FIGURE UNIT RELATION TARGET [NOTE]
say() {
    awk -v name="$1" -v f="$2" -v unit="$3" -v rel="$4" -v target="$5" -v note="${6:-}" 'BEGIN {
        met = rel == ">=" ? f >= target : f <= target
        printf "%-28s %10.1f %-12s target %s %-7s %-6s %s\n",
            name, f, unit, rel, target, met ? "met" : "missed", note}'
}

# post FILE: submits the drape; prints its id.
post() {
    curl -sS -H 'Content-Type: application/json' --data-binary "@$1" "$url/v1/drapes" | jq -r .id
}

# Processor time of the daemon, of its workers too, in seconds.
processor() {
    local workers
    workers=$(cat /proc/"$daemon"/task/*/children | sed -E 's:[0-9]+:/proc/&/stat:g')
    cat /proc/"$daemon"/stat $workers | awk -v hz="$(getconf CLK_TCK)" '{t += $14 + $15} END {print t / hz}'
}

resident() { awk '/^VmRSS/ {print $2}' "/proc/$daemon/status"; }

# Open files, but for the socket of each process: checkers are started as they are needed, up to a
# bound (`document_pool.h`), so that there may be one more at the end.
descriptors() {
    local processes
    processes=$(cat /proc/"$daemon"/task/*/children | wc -w)
    echo $(($(ls "/proc/$daemon/fd" | wc -l) - processes))
}

# submits SECONDS CONNECTIONS SEED [WAIT]: sets rate, good, median (ms); fails on an answer of
# another kind.
submits() {
    env DRAPE="$work/drape.json" SEED="$3" ${4:+WAIT="$4"} wrk -t$(($2 > 1 ? 2 : 1)) -c"$2" -d"$1" --timeout 30 --latency \
        -s tests/load/submit.lua "$url" >"$work/wrk"
    read -r good other seconds median < <(awk '/^good/ {print $2, $4, $6, $8}' "$work/wrk")
    [ "$other" = 0 ] || { cat "$work/wrk"; tail -5 "$work/log"; exit 1; }
    rate=$(awk -v n="$good" -v s="$seconds" 'BEGIN {print n / s}')
}

gets() { wrk -t1 -c16 -d3 "$1" | awk '/^Requests\/sec/ {print $2}'; }

# cells HALF: the drapes have twice as many cells a side.
cells() {
    jq -c --argjson n "$1" '.extent = {warp: [-$n, $n], weft: [-$n, $n]}' api/examples/saddle.json \
        >"$work/drape.json"
}

cells 15

# Status of a drape that has ended, against the same bytes from the bare handler: the median of five
# pairs.
start
id=$(post "$work/drape.json")
curl -sS "$url/v1/drapes/$id?wait=20" >"$work/status.json"
coproc bare { "$build/tests/load/bare" "$work/status.json"; }
bare_process=$bare_PID
read -r -u "${bare[0]}" line
bare_url=${line##* }
for _ in 1 2 3 4 5; do
    echo "$(gets "$url/v1/drapes/$id") $(gets "$bare_url")"
done | awk '{print 100 * $1 / $2, $1, $2}' | sort -n >"$work/ratios"
kill "$bare_process"
read -r ratio own bare_rate < <(sed -n 3p "$work/ratios")
say 'status GET' "$ratio" '% of bare' '>=' 60 "$own/s, bare handler $bare_rate/s"

start --role api
submits 5 64 1
say 'durable submits' "$rate" /s '>=' 2000

start
submits 2 16 1 20
before=$(processor)
submits 8 16 2 20
note=$(awk -v b="$before" -v a="$(processor)" -v n="$good" \
    'BEGIN {printf "%.2f ms of a core each, workers included", 1000 * (a - b) / n}')
say 'drapes of 30 x 30, with result' "$rate" /s '>=' 500 "$note"

# What one caller waits for, one drape after the other.
cells 25
submits 4 1 3 20
say 'a drape of 50 x 50' "$median" ms '<=' 3 "median of $good"
cells 15

# Drapes of some seconds for every worker.
start
for factor in 1 2 3 4 5 6 7 8 9 10 11 12; do
    jq -c --argjson f "$factor" '.fabric.spacing = 0.003 + 1e-7 * $f' api/examples/saddle.json \
        >"$work/slow.json"
    post "$work/slow.json" >/dev/null
done
sleep 1
p99=$(wrk -t1 -c8 -d5 --latency "$url/healthz" | awk '$1 == "99%" {
    print $2 ~ /us$/ ? $2 / 1000 : $2 ~ /ms$/ ? $2 + 0 : $2 * 1000}')
busy=$(curl -sS "$url/metrics" | awk '$1 == "draped_workers_busy" {print $2}')
say 'healthz p99, workers busy' "$p99" ms '<=' 50 "$busy workers busy"

start --role api
id=$(post "$work/drape.json")
read -r _ streams _ bytes < <(python3 tests/load/streams.py "${url##*:}" "$id" "$daemon" 3000)
[ "$streams" = 3000 ] || { echo "only $streams of 3000 streams"; exit 1; }
say 'memory of an event stream' "$(awk -v b="$bytes" 'BEGIN {print b / 1000}')" kB '<=' 45 \
    "$streams idle streams"

# As many requests as a day has at one a second: drapes with their results, and looking at them. What
# the store's caches take they have taken in the first half; what grows in the second is lost. Old
# results are removed on the way, so what is looked at is posted anew each turn.
start --retention-bytes 4G
wrk -t1 -c4 -d5 "$url/v1/drapes?limit=20" >/dev/null
total=0 looks=0 turn=0 half=
until spent=$(processor) && [ "${spent%.*}" -ge "$soak" ]; do
    [ -n "$half" ] || [ "${spent%.*}" -lt $((soak / 2)) ] || half="$(resident) $(descriptors)"
    turn=$((turn + 1))
    id=$(post "$work/drape.json")
    curl -sS "$url/v1/drapes/$id?wait=20" >/dev/null
    wrk -t1 -c4 -d10 "$url/v1/drapes/$id" >"$work/looks" &
    looker=$!
    submits 10 16 "$turn" 20
    wait "$looker"
    ! grep -q 'Non-2xx\|Socket errors' "$work/looks" || { cat "$work/looks"; exit 1; }
    total=$((total + good)) looks=$((looks + $(awk '/requests in/ {print $1}' "$work/looks")))
done
read -r memory files <<<"${half:?LOAD_SECONDS is too few for two turns}"
say 'soak: requests' "$((total + looks))" '' '>=' 86400 \
    "$total drapes and $looks looks in $spent s of processor time"
say 'soak: memory' "$(awk -v a="$(resident)" -v b="$memory" 'BEGIN {print 100 * a / b}')" \
    '% of half' '<=' 110 "$memory KiB after the first half, $(resident) KiB at the end"
say 'soak: descriptors' "$(($(descriptors) - files))" more '<=' 0 "$files after the first half"
