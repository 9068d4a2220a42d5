#!/bin/bash
# SPDX-License-Identifier: MIT
# Variants of a study for a second of processor time, on nets of about 900 nodes, against some of the
# same drapes one by one, by the solver's clock: on a busy machine the latter are too long. Usage:
# bench_variants.sh BUILD
set -eu
TIMEFORMAT=%U
drape=$1/drape
scratch=$(mktemp -d)
trap 'rm -r "$scratch"' EXIT
echo 'part        nodes  variants/s  us a variant  of a drape by itself'
for part in freeform saddle torus octant; do
    request="$scratch/$part.json"
    area=$("$drape" "api/examples/$part.json" --fields nodes.i 2>/dev/null | jq .summary.part_area)
    jq --argjson d "$(jq -n "$area / 900 | sqrt")" \
        'del(.permeability, .extent) | .fabric = {spacing: $d}' "api/examples/$part.json" >"$request"
    jq '{drape: ., vary: {start: {grid: 30}, angle_deg: {from: 0, to: 80, step: 10}},
         objectives: ["max_shear_deg"]}' "$request" >"$scratch/study.json"
    seconds=$({ time "$drape" "$scratch/study.json" >"$scratch/out.json" 2>/dev/null; } 2>&1)
    for k in 0 40 80 120 160 200 240; do # the same drapes, by the solver's own clock
        jq --argjson k "$k" --slurpfile out "$scratch/out.json" '$out[0].variants as $v |
            .start = {uv: [$v.start_u[$k], $v.start_v[$k]]} | .direction = {angle_deg: $v.angle_deg[$k]}' \
            "$request" | "$drape" - --fields nodes.i 2>/dev/null | jq .summary.timing_ms.solve
    done >"$scratch/single"
    jq -r --arg part "$part" --argjson seconds "$seconds" --slurpfile single "$scratch/single" '
        ($seconds * 1e6 / .summary.variants) as $each |
        ($single | add / length * 1000) as $alone |
        [$part, 900, 1e6 / $each, $each, $each / $alone] | @tsv' "$scratch/out.json" |
        awk '{printf "%-10s %6d %11.0f %13.0f %21.2f\n", $1, $2, $3, $4, $5}'
done
