# SPDX-License-Identifier: MIT
# Flat patterns of cloth that ends within its part, and what lies within the boundaries of plies: on a
# box with rounded edges whose corners stay bare, draped at 45 degrees.
load helper

BOX=tests/requests/box_at_45.json

setup_file() { start_shared_daemon; }
teardown_file() { end_file; }

# area FILE: of the cut of an SVG, mm².
area() {
    python3 - "$1" <<'PYTHON'
import re, sys
path = re.search(r'id="cut"[^>]* d="([^"]*)"', open(sys.argv[1]).read())[1]
total = 0
for loop in path.split("Z"):
    numbers = [float(n) for n in re.findall(r"-?[0-9.]+(?:e-?\d+)?", loop)]
    points = list(zip(numbers[::2], numbers[1::2]))
    total += sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(points, points[1:] + points[:1])) / 2
print(total)
PYTHON
}

# bare: the per cent of the box that its cloth leaves bare.
bare() {
    "$DRAPE" "$BOX" 2>/dev/null | jq '(1 - .summary.cloth_coverage) * 1000 | round / 10'
}

# stack EXPRESSION: two plies on the box, one of them a patch on its top; changed by jq.
stack() {
    jq -c "{surface, length_unit, plies: [({name: \"skin\"}, {name: \"patch\", boundary: {polygon:
                [[-50, -30, 0], [50, -30, 0], [50, 30, 0], [-50, 30, 0]]}}) as \$ply
            | \$ply + {fabric, start, direction, areal_weight: 0.2}]} | $1" "$BOX"
}

@test "the pattern of a partial drape has the area of its cloth, says what is bare and marks it" {
    local out=$BATS_TEST_TMPDIR
    "$DRAPE" "$BOX" -o "$out/box.json" 2>/dev/null
    "$DRAPE" "$BOX" --format svg -o "$out/box.svg" 2>/dev/null
    jq -e --argjson area "$(area "$out/box.svg")" \
        '.summary.outcome == "partial" and ($area / .summary.flat_area - 1 | fabs) < 3e-5' "$out/box.json"
    grep -q "<title>$(bare) % of the part is bare. " "$out/box.svg"
    for id in bare collapsed; do
        grep -q "id=\"$id\"[^>]* d=\"M[^\"]*L" "$out/box.svg"
    done
    "$DRAPE" "$EXAMPLES/saddle.json" --format svg -o "$out/whole.svg"
    not grep -q 'is bare\|id="bare"[^>]* d="M' "$out/whole.svg"
}

@test "the four corners of a box without shear are covered alike, and no cell at their ends is lost" {
    # Nodes lie at the vertices of faces, and yarns go on from there along joints.
    jq '.direction.angle_deg = 0 | .fabric.spacing = 2' "$BOX" >"$BATS_TEST_TMPDIR/box.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/box.json" --format svg -o "$BATS_TEST_TMPDIR/box.svg" 2>/dev/null
    "$DRAPE" "$BATS_TEST_TMPDIR/box.json" 2>/dev/null >"$BATS_TEST_TMPDIR/out.json"
    jq -e '[.nodes.i, .nodes.j] | transpose |
        map(select(.[0] != 0 and .[1] != 0) | [.[0] > 0, .[1] > 0]) | group_by(.) | map(length) |
        length == 4 and (unique | length) == 1' "$BATS_TEST_TMPDIR/out.json"
    # A cell is 6e-5 of the pattern.
    jq -e --argjson area "$(area "$BATS_TEST_TMPDIR/box.svg")" \
        '.summary | .cloth_coverage > 0.999 and ($area / .flat_area - 1 | fabs) < 1e-6' "$BATS_TEST_TMPDIR/out.json"
}

@test "machines get no pattern that leaves some bare, unless it is asked for" {
    "$DRAPE" "$BOX" --format dxf >"$BATS_TEST_TMPDIR/out" 2>"$BATS_TEST_TMPDIR/err" && return 1
    grep -q "the cloth leaves $(bare) % of the part bare" "$BATS_TEST_TMPDIR/err"
    "$DRAPE" "$BOX" --format dxf --partial 2>/dev/null | grep -c '^BARE\|^COLLAPSED' >"$BATS_TEST_TMPDIR/marks"
    [ "$(cat "$BATS_TEST_TMPDIR/marks")" -gt 40 ]
    post /v1/drapes "$BOX" -H 'Prefer: wait=30'
    local id=$(field .id)
    call GET "/v1/drapes/$id/pattern?format=dxf"
    expect_problem 422 invalid-request
    call GET "/v1/drapes/$id/pattern?format=dxf&partial=1" && expect 200
    call GET "/v1/drapes/$id/pattern?format=dxf&partial=yes"
    expect_problem 422 invalid-request
    call GET "/v1/drapes/$id/pattern?format=svg" && expect 200
    stack . >"$BATS_TEST_TMPDIR/stack.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/stack.json" -H 'Prefer: wait=30'
    id=$(field .id)
    call GET "/v1/laminates/$id/patterns?format=dxf"
    expect_problem 422 invalid-request
    [[ $(field .detail) == *"ply 1 (\"skin\") leaves $(bare) % bare"* ]]
    call GET "/v1/laminates/$id/patterns?format=dxf&partial=1" && expect 200
    call GET "/v1/laminates/$id/plies/0/pattern?format=dxf"
    expect_problem 422 invalid-request
    call GET "/v1/laminates/$id/plies/1/pattern?format=dxf" && expect 200
}

@test "a ply with a boundary reports what lies inside it" {
    stack . >"$BATS_TEST_TMPDIR/stack.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/stack.json" 2>/dev/null >"$BATS_TEST_TMPDIR/out.json"
    jq -e '.plies[1] | .outcome == "complete" and .cloth_coverage == 1 and .max_shear_deg < 1e-9
        and .locked_cells == 0 and (.area - 6000 | fabs) < 1e-6 and (.mass - 0.0012 | fabs) < 1e-12
        and .warnings == []' "$BATS_TEST_TMPDIR/out.json"
    "$DRAPE" "$BOX" 2>/dev/null | jq -e --slurpfile out "$BATS_TEST_TMPDIR/out.json" '.summary as $s
        | $out[0].plies[0] | .area == $s.flat_area and .locked_cells == $s.locked_cells
        and .max_shear_deg == $s.max_shear_deg and .cloth_coverage == $s.cloth_coverage'
    stack '.plies[1].boundary.polygon |= map(.[0] *= 1.9)' >"$BATS_TEST_TMPDIR/wide.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/wide.json" 2>/dev/null | jq -e '.plies[1].area - 11400 | fabs < 1e-6'
}

@test "the ply book has the areas, masses and shears of the plies, not of their drapes" {
    stack . >"$BATS_TEST_TMPDIR/stack.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/stack.json" --format html 2>/dev/null | sed 's/<[^>]*>/ /g' \
        >"$BATS_TEST_TMPDIR/book"
    grep -qE '2 +patch +.* its own +0.006 +0.2 +0.0012 +0.0°' "$BATS_TEST_TMPDIR/book"
    grep -qE '1 +skin +.* the part +0.0637[0-9] +0.2 +0.01274[0-9] +84' "$BATS_TEST_TMPDIR/book"
    grep -q '100 % of its boundary is covered, the greatest shear is 0.0°.' "$BATS_TEST_TMPDIR/book"
    [ "$(grep -c 'locked: ' "$BATS_TEST_TMPDIR/book")" -eq 1 ]
}
