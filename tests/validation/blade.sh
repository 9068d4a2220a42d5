#!/bin/bash
# SPDX-License-Identifier: MIT
# A layer of five courses on the blade-like mould, by three studies: for the least shear, the least cloth
# that is trimmed off, and the least angle between warp and the blade's axis. Beside each what
# KinDrapeMAX has published of the same mould (docs/validation.md). Seconds are of the processor, of each of
# two threads. Usage: blade.sh DRAPE SURFACE.json
set -euo pipefail
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

# Without trimming the first course follows the edge, and courses overlap where the part is narrow.
study() {
    jq -c --arg objective "$1" --argjson first "$2" --argjson gap "$3" --argjson width "$4" '{
        drape: (. + {fabric: {spacing: 0.0125}, method: "gib"}), wanted_direction: [0, 1, 0],
        courses: {width: $width, along: {edge: [0.6801, 2, -0.7458]}, first_offset: $first,
                  gap: [[0, $gap, 0]], most: 5},
        vary: {courses: {count: 5, first_offset: {from: -0.2, to: 0.05, points: 5},
                         offsets: {from: -0.07, to: 0.012, points: 3}, origin: {from: 0, to: 1},
                         width: {from: 0.3, to: 0.45}}},
        objectives: [$objective]}' "$surface" >"$work/study.json"
    { time "$drape" --threads 2 "$work/study.json" -o "$work/found.json" >"$work/said" 2>&1; } 2>"$work/seconds"
    jq -r --arg objective "$1" --arg unit "$5" --arg theirs "$6" --arg seconds "$7" '
        .best[$objective] as $row | .variants | [$objective, $unit, $theirs, .[$objective][$row], $seconds,
         .cloth_coverage[$row], .laid_coverage[$row] - .cloth_coverage[$row]] | @tsv' "$work/found.json" |
        awk -F'\t' -v own="$(<"$work/seconds")" \
            '{printf "%-24s %-8s %8s %8.3f %9s %8.1f %9.4f %9.4f\n", $1, $2, $3, $4, $5, own / 2, $6, $7}'
}

drape=$1 surface=$2 TIMEFORMAT=%U
echo "least                          KinDrapeMAX     here   seconds  seconds   covered   in gaps"
study max_shear_deg -0.1 -0.02 0.35 degrees 2.70 1039
study waste_area 0 -0.05 0.335 m^2 0.101 932
study angle_deviation_max_deg 0 -0.02 0.35 degrees 12.3 976
