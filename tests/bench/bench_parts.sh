#!/bin/bash
# SPDX-License-Identifier: MIT
# What CAD parts cost: the six that FreeCAD makes (where it is installed: make freecad), and the example
# and five that Open CASCADE makes for the tests of the importer.
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
