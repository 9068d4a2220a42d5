#!/bin/bash
# SPDX-License-Identifier: MIT
# How a build of the daemon stands to another, an older one say: durable submissions and looks at a
# drape that has ended, by turns within one run, because what else the machine does changes both
# alike. Prints the quartiles of the ratios of PAIRS (15) pairs, of rates and of the processor time
# that the daemon and its children take a call: more than 1 is a higher rate, or more time, than the
# other's.
# Usage: tests/load/pairs.sh BUILD OTHER
set -eu
cd "$(dirname "$0")/../.."
pairs=${PAIRS:-15}
ulimit -n "$(ulimit -Hn)"
work=$(mktemp -d)
declare -A daemon url id
trap 'kill "${daemon[@]}" 2>/dev/null; wait; rm -rf "$work"' EXIT

# start NAME BUILD FLAG...: with an empty store, and the limits that this build knows out of the way.
start() {
    local name=$1 build=$2 known flags=()
    shift 2
    known=$("$build/draped" --help)
    for flag in --owner-queue --owner-connections; do
        [[ $known != *" $flag "* ]] || flags+=("$flag" 1000000)
    done
    [ -z "${daemon[$name]:-}" ] || { kill "${daemon[$name]}"; wait "${daemon[$name]}" || true; }
    rm -rf "$work/$name" "$work/$name.out"
    "$build/draped" --listen 127.0.0.1:0 --data "$work/$name" --queue-limit 10000000 \
        --log-level warning "${flags[@]}" "$@" >"$work/$name.out" 2>>"$work/log" &
    daemon[$name]=$!
    until grep -qs listening "$work/$name.out"; do
        kill -0 "${daemon[$name]}" || { tail -3 "$work/log"; exit 1; }
        sleep 0.05
    done
    url[$name]=$(sed -n 's/^draped listening on //p' "$work/$name.out")
}

# Microseconds of a processor that the daemon and its children have taken.
processor() {
    cat /proc/"$1"/task/*/children | tr ' ' '\n' | sed -n 's:..*:/proc/&/schedstat:p' |
        cat - <(ls -d /proc/"$1"/task/*/schedstat) | xargs cat 2>/dev/null | awk '{t += $1} END {printf "%d", t / 1000}'
}

# The calls by wrk with these arguments: their number, rate, and the processor's time for each.
calls() {
    local name=$1 before
    shift
    before=$(processor "${daemon[$name]}")
    wrk --timeout 30 --latency "$@" >"$work/wrk"
    ! grep -q 'Non-2xx\|Socket errors' "$work/wrk" || { cat "$work/wrk" >&2; exit 1; }
    awk -v before="$before" -v after="$(processor "${daemon[$name]}")" '/requests in/ {n = $1}
        /^Requests\/sec/ {rate = $2} END {print rate, (after - before) / n}' "$work/wrk"
}

looks() { calls "$1" -t1 -c16 -d1 "${url[$1]}/v1/drapes/${id[$1]}"; }

submits() { DRAPE=$work/drape.json SEED=$2 calls "$1" -t1 -c32 -d1 -s tests/load/submit.lua "${url[$1]}"; }

# Runs what is measured on both, each first in every other pair: the quartiles of the ratios.
compare() {
    local a b
    for ((k = 1; k <= pairs; k++)); do
        if ((k % 2)); then
            a=$("$1" new "$k") b=$("$1" old "$k")
        else
            b=$("$1" old "$k") a=$("$1" new "$k")
        fi
        echo "$a $b"
    done >"$work/pairs"
    for what in 'rate 1 3' 'processor 2 4'; do
        read -r name i j <<<"$what"
        awk -v i="$i" -v j="$j" '{print $i / $j, $i, $j}' "$work/pairs" | sort -n | awk -v name="$1, $name" '
            {ratio[NR] = $1; own[NR] = $2; other[NR] = $3}
            function at(share) {return int(1 + share * (NR - 1) + 0.5)}
            END {m = at(0.5); printf "%-20s %.3f (%.3f to %.3f)   %.1f against %.1f in the median pair\n",
                 name, ratio[m], ratio[at(0.25)], ratio[at(0.75)], own[m], other[m]}'
    done
}

jq -c '.extent = {warp: [-15, 15], weft: [-15, 15]}' api/examples/saddle.json >"$work/drape.json"
start new "$1"
start old "$2"
for name in new old; do
    id[$name]=$(curl -sS -H 'Content-Type: application/json' --data-binary "@$work/drape.json" \
        "${url[$name]}/v1/drapes" | jq -r .id)
    until curl -sS "${url[$name]}/v1/drapes/${id[$name]}" | grep -q '"succeeded"'; do sleep 0.05; done
done
compare looks
start new "$1" --role api
start old "$2" --role api
compare submits
