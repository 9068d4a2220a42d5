#!/bin/bash
# SPDX-License-Identifier: MIT
# How fast results leave the daemon over loopback: a net of a million nodes in every format, with
# and without compression, and how much its memory grows meanwhile. Each figure is the best of five.
# Usage: tests/bench/bench_formats.sh BUILD
set -eu
cd "$(dirname "$0")/../.."
. tests/bench/million.bash
start_million "$1" .

resident() { awk '/^VmRSS/ {print $2}' "/proc/$daemon/status"; }
peak() { awk '/^VmHWM/ {print $2}' "/proc/$daemon/status"; }

# time_one NAME PATH [CODING]
time_one() {
    local best=
    for _ in 1 2 3 4 5; do
        best=$(curl -sS -o /dev/null ${3:+-H "Accept-Encoding: $3"} \
            -w '%{time_total} %{size_download}\n' "$url/v1/drapes/$id/$2" |
            cat - <(echo "$best") | awk 'NF == 2 && (!t || $1 < t) {t = $1; s = $2} END {print t, s}')
    done
    echo "$1 $best $(peak)" | awk '{printf "%-12s %7.3f s %8.1f MB %7.0f MB/s, %d KiB at the most\n",
        $1, $2, $3 / 1e6, $3 / 1e6 / $2, $4}'
}

time_one warm-up 'result?format=npz'
echo 5 >"/proc/$daemon/clear_refs" # the peak begins anew
before=$(resident)
for format in json csv vtp glb npz; do
    time_one "$format" "result?format=$format"
done
time_one json+zstd 'result?format=json' zstd
time_one json+gzip 'result?format=json' gzip
time_one vtp+zstd 'result?format=vtp' zstd
time_one svg 'pattern?format=svg'
time_one dxf 'pattern?format=dxf'
echo "memory: $before KiB before, $(($(peak) - before)) KiB more at the most"
