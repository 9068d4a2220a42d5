#!/bin/bash
# SPDX-License-Identifier: MIT
# What CAD parts cost: the six that FreeCAD makes (where it is installed: make freecad), and the example
# and five that Open CASCADE makes for the tests of the importer; and studies of 500 variants of about
# 900 nodes on them, on two threads: seconds of processor time, and until the result is there.
# Usage: tests/bench/bench_parts.sh BUILD [NODES...]     default: 700 and 50000
set -eu
cd "$(dirname "$0")/../.."
build=$1
shift
work=$(mktemp -d /tmp/draped-bench-XXXXXX)
trap 'rm -rf "$work"' EXIT
"$build/tests/import/make_parts" "$work" >"$work/areas"
cp api/examples/dome.step "$work"
parts=(dome cover wing rounded hat bowl)
if command -v freecadcmd >/dev/null; then
    PARTS=$work freecadcmd tests/import/freecad_parts.py </dev/null >"$work/log" 2>&1
    parts+=(filleted_box shelled_tray united_dome cut_bracket lofted_duct swept_rail)
else
    echo "without the six parts of FreeCAD, which is not installed: deploy/setup.sh freecad"
fi
surfaces=()
for part in "${parts[@]}"; do
    "$build/drape-import" "$work/$part.step" >"$work/$part.json" 2>>"$work/log"
    surfaces+=("$work/$part.json")
done
for nodes in ${*:-700 50000}; do
    "$build/tests/bench/bench_parts" "$nodes" "${surfaces[@]}"
done

# study PART SEED: the faces that hang together smoothly with that one
study() {
    jq -n --arg file "$work/$1.step" --argjson seed "$2" \
        '{surface: {file: $file, grow_from: $seed, up_to_deg: 20}, fabric: {spacing: 8}}' >"$work/drape.json"
    area=$("$build/drape" "$work/drape.json" --fields nodes.i 2>>"$work/log" | jq .summary.part_area)
    jq --argjson area "$area" '.fabric.spacing = ($area / 900 | sqrt) |
        {drape: ., vary: {start: {grid: 50}, angle_deg: {from: 0, to: 81, step: 9}},
         objectives: ["max_shear_deg"]}' "$work/drape.json" >"$work/study.json"
    { time "$build/drape" --threads 2 "$work/study.json" -o "$work/out.json" 2>>"$work/log" >&2; } 2>&1 |
        awk -v part="$1" '{printf "%-16s %8.2f %8.2f\n", part, $1, $2}'
}
TIMEFORMAT='%U %R'
echo "studies of 500 variants
part                 cpu s  until s"
seeds=(0 0 0 0 0 0 0 10 1 0 0 1)
for k in "${!parts[@]}"; do study "${parts[k]}" "${seeds[k]}"; done
