#!/bin/bash
# SPDX-License-Identifier: MIT
# How long a map of a million elements on a net of a million nodes takes over loopback, from bulk
# data and from JSON, in every format, and how much memory the daemon holds at the most. The time is
# that of the whole call: sending the mesh, reading it, mapping, and fetching the answer.
# Usage: tests/bench/bench_map.sh BUILD
set -eu
cd "$(dirname "$0")/../.."
. tests/bench/million.bash
# With all fields.
start_million "$1" '.fabric += {thickness: 0.003, fiber_volume_fraction: 0.4} |
    .permeability = {model: "kozeny_carman", k1: 1.63e-10, k2: 5e-11, k3: 1e-12,
                     at_fiber_volume_fraction: 0.4}'

# 707 by 707 squares over [-1.9, 1.9]^2, each two triangles, a millimetre off the surface.
awk -v json="$work/mesh.json" -v bulk="$work/mesh.bdf" 'BEGIN {
    n = 708
    printf "{\"mesh\":{\"vertices\":[" >json
    for (j = 0; j < n; j++) for (i = 0; i < n; i++) {
        x = -1.9 + 3.8 * i / (n - 1); y = -1.9 + 3.8 * j / (n - 1); z = (x * x - y * y) / 2 + 0.001
        printf "GRID,%d,,%.7f,%.7f,%.7f\n", ++k, x, y, z >bulk
        printf "%s[%.7f,%.7f,%.7f]", (k > 1 ? "," : ""), x, y, z >json
    }
    printf "],\"triangles\":[" >json
    for (j = 0; j < n - 1; j++) for (i = 0; i < n - 1; i++) {
        a = i + n * j
        printf "CTRIA3,%d,1,%d,%d,%d\n", ++e, a + 1, a + 2, a + n + 2 >bulk
        printf "%s[%d,%d,%d]", (e > 1 ? "," : ""), a, a + 1, a + n + 1 >json
        printf "CTRIA3,%d,1,%d,%d,%d\n", ++e, a + 1, a + n + 2, a + n + 1 >bulk
        printf ",[%d,%d,%d]", a, a + n + 1, a + n >json
    }
    print "]}}" >json
    print "ENDDATA" >bulk
    print e " elements"
}'

# time_one TYPE FILE FORMAT
time_one() {
    echo 5 >"/proc/$daemon/clear_refs" # the peak begins anew
    curl -sS -o "$work/answer" -H "Content-Type: $1" --data-binary "@$work/$2" \
        -w '%{http_code} %{time_starttransfer} %{time_total} %{size_upload} %{size_download}\n' \
        "$url/v1/drapes/$id/map?format=$3" |
        awk -v from="$2" -v to="$3" '{printf "%-9s -> %-7s %d  %6.2f s, %6.2f s to" \
            " the first byte; %4.0f MB in, %4.0f MB out\n", from, to, $1, $3, $2, $4 / 1e6, $5 / 1e6}'
    sleep 0.5
    awk '/^VmHWM/ {most = $2} /^VmRSS/ {now = $2}
        END {printf "    %d MiB at the most, %d MiB afterwards\n", most / 1024, now / 1024}' \
        "/proc/$daemon/status"
}

for format in json csv vtu lcmsim; do
    time_one text/x-nastran mesh.bdf "$format"
done
time_one application/json mesh.json vtu
