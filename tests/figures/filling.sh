#!/bin/bash
# SPDX-License-Identifier: MIT
# The figures of docs/filling.md: fabric laid from a corner of the free-form example at 45 degrees, in
# a mould of constant height, filled with its draped fields and with those of the flat fabric.
# Usage: filling.sh BUILD
set -eu
fill() { /usr/bin/python3 clients/examples/filling.py "$@"; }
request=$(mktemp)
trap 'rm -f "$request"' EXIT
jq '.fabric += {thickness: 3, fiber_volume_fraction: 0.4} | .cavity = {height: 3} |
    .permeability = {model: "kozeny_carman", k1: 1.63e-10, k2: 5.05e-11, k3: 1e-12,
                     at_fiber_volume_fraction: 0.4} |
    .start.uv = [0.05, 0.05] | .direction.angle_deg = 45' api/examples/freeform.json >"$request"
fill --check
fill --drape "$1/drape" "$request" -o docs/figures/filling.png
