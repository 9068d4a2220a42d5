# SPDX-License-Identifier: MIT
# Plies of several pieces: splits, seams, what becomes of them in patterns, maps and statuses.
bats_require_minimum_version 1.5.0
load helper

setup_file() { start_shared_daemon; }
teardown_file() { end_file; }

# A plane of 4 by 3 that is split at x = 2, the right piece turned by 30 degrees.
plane='{"surface": {"degree_u": 1, "degree_v": 1, "size_u": 2, "size_v": 2,
    "knotvector_u": [0, 0, 1, 1], "knotvector_v": [0, 0, 1, 1],
    "control_points": [[0, 0, 0], [0, 3, 0], [4, 0, 0], [4, 3, 0]]},
    "plies": [{"name": "skin", "fabric": {"spacing": 0.1, "thickness": 0.001},
        "splits": [{"path": [[2, 0, 0], [2, 3, 0]]}],
        "pieces": [{"at": [3, 1, 0], "name": "right", "direction": {"angle_deg": 30}}]}]}'

@test "two pieces of a plane cover it, and their seam is as wide as asked for" {
    drape_plane .
    [ "$(jq -c '[.plies[0].pieces[].name]' <<<"$output")" = '["right","piece_2"]' ]
    number .cloth_coverage 1
    number '.pieces[0].area' 6
    number '.pieces[1].area' 6
    number '[.pieces[].max_shear_deg] | max' 0
    number '.seams[0].length' 3
    number '.seams[0].mean_angle_deg' 30
    number '.seams[0].greatest_angle_deg' 30
    number '.seams[0].overlap_area + .seams[0].gap_area' 0
    drape_plane '.plies[0].seam = {overlap: 0.25}'
    number '.pieces[0].area' 6.375
    number '.pieces[1].area' 6.375
    number '.seams[0].overlap_area' 0.75
    number .cloth_coverage 1
    drape_plane '.plies[0].seam = {overlap: 0.25, over: "first"}'
    number '.pieces[0].area' 6
    number '.pieces[1].area' 6.75
    drape_plane '.plies[0].seam = {overlap: 0.25, over: "last"}'
    number '.pieces[0].area' 6.75
    drape_plane '.plies[0].seam = {gap: 0.04}'
    number '.pieces[0].area' 5.94
    number '.seams[0].gap_area' 0.12
    number .cloth_coverage '11.88 / 12'
}

@test "the warps of two pieces of a gentle bump are as good as parallel, wherever cloth goes on at the rim" {
    for split in '40,52,0.4,0.2' '62,63,0.5,-0.5' '66,57,0.8,0.8' '30,34,0.5,0.4'; do
        run -0 --separate-stderr "$BUILD/drape" - <<<"$(jq -nc --argjson s "[$split]" '{surface: {degree_u: 2,
            degree_v: 2, knotvector_u: [0,0,0,1,1,1], knotvector_v: [0,0,0,1,1,1], size_u: 3, size_v: 3,
            control_points: {points: [range(9) | [(. / 3 | floor) * 50, . % 3 * 40, if . == 4 then 12 else 0 end]]}},
            plies: [{name: "skin", fabric: {spacing: 4, thickness: 0.5}, direction: {vector: [$s[2], $s[3], 0]},
            splits: [{path: [[$s[0], 0, 0], [$s[1], 80, 0]]}], seam: {overlap: 8}}]}')"
        jq -e '.plies[0].seams[0] | .mean_angle_deg < 0.5 and .greatest_angle_deg < 1' <<<"$output"
    done
}

@test "a closed split cuts out an island, and splits may end at splits" {
    drape_plane '.plies[0] |= (.splits = [{path: [[1, 1, 0], [3, 1, 0], [3, 2, 0], [1, 2, 0], [1, 1, 0]]},
        {path: [[2, 1, 0], [2, 2, 0]]}] | .pieces = [{at: [0.5, 0.5, 0], name: "frame"},
        {at: [1.5, 1.5, 0], name: "left"}, {at: [2.5, 1.5, 0], name: "right"}])'
    number '.pieces[0].area' 10
    number '.pieces[1].area' 1
    number '.pieces[2].area' 1
    number .cloth_coverage 1
    [ "$(jq -c '[.plies[0].seams[] | .pieces + [.length * 1e6 | round]]' <<<"$output")" = \
        '[["frame","left",3000000],["frame","right",3000000],["left","right",1000000]]' ]
}

# box: five faces of 0.2 by 0.15 by 0.06, each a piece of its own: four corners of three pieces.
box() {
    jq -nc 'def face($a; $b; $c; $d): {degree_u: 1, degree_v: 1, size_u: 2, size_v: 2,
            knotvector_u: [0, 0, 1, 1], knotvector_v: [0, 0, 1, 1], control_points: [$a, $d, $b, $c]};
        [[0, 0, 0], [0.2, 0, 0], [0.2, 0.15, 0], [0, 0.15, 0]] as $g | ($g | map(.[2] = 0.06)) as $t |
        {surface: {faces: [face($t[0]; $t[1]; $t[2]; $t[3]),
                           (range(4) | face($g[.]; $g[(. + 1) % 4]; $t[(. + 1) % 4]; $t[.]))]},
         plies: [{fabric: {spacing: 0.01}, splits: [{path: ($t + [$t[0]])},
             (range(4) | {path: [$g[.], $t[.]]})], pieces: [{at: [0.1, 0.075, 0.06], name: "top"}]}]}'
}

@test "a box of five pieces is covered without shear" {
    box >"$BATS_TEST_TMPDIR/box.json"
    output=$("$DRAPE" "$BATS_TEST_TMPDIR/box.json")
    number .cloth_coverage 1
    number '[.pieces[].max_shear_deg] | max' 0
    number '.pieces[0].area' 0.03
    number '[.pieces[1:][].area] | add' 0.042
    [ "$(jq '.plies[0].seams | length' <<<"$output")" -eq 8 ]
    number '[.seams[].length] | add' 0.94
    [ "$(jq '[.plies[0].pieces[] | select(.outcome == "complete")] | length' <<<"$output")" -eq 5 ]
}

# sphere SPACING SEAM: the patch of a sphere halved by a great circle, a mirror of it.
sphere() {
    jq -c --argjson spacing "$1" --argjson seam "$2" '{surface, length_unit, plies: [{method, direction,
            fabric: (.fabric | .spacing = $spacing), splits: [{path: [[32, 32, 16], [-32, -32, 16]]}],
            seam: $seam}]}' api/examples/sphere.json >"$BATS_TEST_TMPDIR/sphere.json"
    output=$("$DRAPE" "$BATS_TEST_TMPDIR/sphere.json")
}

@test "pieces of a sphere lose nothing at their seam, and the overlap is as wide as asked for" {
    for spacing in 8 4 2; do
        sphere "$spacing" '{"overlap": 4}'
        number .cloth_coverage 1
        number '.seams[0].gap_area' 0
        # The arc is 2 48 acos(1 / 3) = 118.174 long; at its ends the corners of the part, of about
        # 100 degrees, are narrower than the overlap: 4 - 4 2^2 / 2 / tan(50 degrees) / 118.
        jq -e --argjson spacing "$spacing" '.plies[0] | (.pieces | map(.area)) as [$a, $b] |
            ($a - $b | fabs) < 1e-6 * $a and (.seams[0] | (.length - 118.174 | fabs) < 0.05 * $spacing and
            (.overlap_width - 3.943 | fabs) < 0.01 * $spacing)' <<<"$output"
        regions=$(jq '.plies[0] | ([.pieces[].area] | add) - .seams[0].overlap_area' <<<"$output")
        sphere "$spacing" '{"gap": 1e-6}'
        jq -e --argjson regions "$regions" '.plies[0] | .cloth_coverage > 0.99 and
            (([.pieces[].area] | add) - $regions | fabs) < 1e-3' <<<"$output"
    done
}

@test "four quarters of a hemisphere are alike" {
    jq -c '{surface, length_unit, plies: [{fabric: (.fabric | .spacing = 5), method, direction, seam: {overlap: 4},
        splits: [{path: [[100, 0, 0], [0, 0, 100], [-100, 0, 0]]}, {path: [[0, 100, 0], [0, 0, 100]]},
                 {path: [[0, -100, 0], [0, 0, 100]]}]}]}' api/examples/hemisphere.json >"$BATS_TEST_TMPDIR/q.json"
    output=$("$DRAPE" "$BATS_TEST_TMPDIR/q.json")
    jq -e '.plies[0] | .cloth_coverage == 1 and ([.pieces[].area] | (max - min) < 1e-6 * max) and (.seams | length == 4 and
        all(.gap_area == 0 and (.length - 157.0796 | fabs) < 0.2 and (.overlap_width - 4 | fabs) < 0.08))' <<<"$output"
}

# octant SPACING: the octant of a sphere of radius 100, with a gap of 8 along its parallel of 45 degrees.
octant() {
    jq -c --argjson spacing "$1" '{surface, length_unit, plies: [{fabric: {$spacing}, method: "gib", seam: {gap: 8},
            splits: [{path: [range(91) / 180 * 3.141592653589793 | [70.710678118655 * cos, 70.710678118655 * sin,
                      70.710678118655]]}]}]}' api/examples/octant.json >"$BATS_TEST_TMPDIR/octant.json"
    output=$("$DRAPE" "$BATS_TEST_TMPDIR/octant.json" 2>/dev/null)
}

@test "what pieces cover beside a gap of a sphere is right to second order in the spacing" {
    # Between two parallels lies R^2 pi / 2 (sin - sin) of the octant, whose area is R^2 pi / 2.
    local exact='(1 - 2 * (0.04 | sin) * 0.7071067811865476)' coarse
    octant 8
    number .cloth_coverage "$exact" 7e-4
    number '.seams[0].gap_width' 8 0.02
    coarse=$(jq ".plies[0].cloth_coverage - $exact | fabs" <<<"$output")
    octant 4
    number .cloth_coverage "$exact" "$coarse / 3"
}

@test "splits at random on a cylinder and a saddle lose nothing, and have their closed forms" {
    python3 tests/http/split_cases.py "$DRAPE" 8 "${DRAPED_SEED:-1}"
}

@test "an element under an overlap has two rows of the ply" {
    local mesh=$BATS_TEST_TMPDIR/mesh.json
    echo '{"mesh": {"vertices": [[1, 1, 0], [1.2, 1, 0], [1, 1.2, 0], [1.9, 1, 0], [2.1, 1, 0],
           [1.98, 1.2, 0], [3, 1, 0], [3.2, 1, 0], [3, 1.2, 0]],
           "triangles": [[0, 1, 2], [3, 4, 5], [6, 7, 8]]}}' >"$mesh"
    drape_plane '.plies[0].seam = {overlap: 0.25} | .plies[1] = (.plies[0] | del(.splits, .seam, .pieces))' \
        --map "$mesh"
    [ "$(jq -c '.plies | [.element, .ply, .piece]' <<<"$output")" = \
        '[[0,0,1,1,1,2,2],[1,2,1,1,2,1,2],[2,0,1,2,0,1,0]]' ]
    [ "$(jq -c '[.cells.thickness[] * 1e6 | round]' <<<"$output")" = '[2000,3000,2000]' ]
    drape_plane . --map "$mesh" --format nastran
    grep -q 'PCOMP' <<<"$output"
}

@test "patterns and the ply book have every piece" {
    drape_plane '.plies[0].seam = {overlap: 0.25}' --format dxf
    [ "$(grep -cE '^1 skin, (right|piece_2)$' <<<"$output")" -eq 2 ]
    drape_plane '.plies[0].seam = {overlap: 0.25}' --format html
    [[ $output == *'1  skin, right'* && $output == *'<h2>Seams</h2>'* && $output == *'0.75'* ]]
}

@test "over HTTP every piece is a drape with its id" {
    jq -c '.plies[1] = (.plies[0] | del(.splits, .pieces))' <<<"$plane" >"$BATS_TEST_TMPDIR/stack.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/stack.json" -H 'Prefer: wait=40' && expect 200
    id=$(field .id)
    [ "$(field '[.plies[] | [.name, (.pieces // [] | map(.name + "," + .status))]] | tojson')" = \
        '[["skin",["right,succeeded","piece_2,succeeded"]],["skin",[]]]' ]
    piece=$(field '.plies[0].pieces[0].id')
    call GET "/v1/drapes/$piece" && expect 200
    call GET "/v1/laminates/$id/plies/1/pattern" && expect 200
    call GET "/v1/laminates/$id/plies/2/pattern" && expect 404
    call GET "/v1/laminates/$id/plies/0/pattern" && expect 200
    grep -q 'skin, piece_2' "$body"
    # What was understood is the same laminate.
    call GET "/v1/laminates/$id/request" && expect 200
    [ "$(field '.plies[0].pieces | length')" -eq 2 ]
    cp "$body" "$BATS_TEST_TMPDIR/understood.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/understood.json" -H 'Prefer: wait=40' && expect 200
    [ "$(field '.plies[0].pieces[0].status')" = succeeded ]
}

@test "what became of pieces is the same over HTTP, by the command, and in the ply book" {
    jq -c '.plies[0].seam = {overlap: 0.25} | .plies[1] = (.plies[0] | del(.splits, .seam, .pieces)) |
        .plies[2] = (.plies[1] | .start = {point: [9, 9, 9]})' <<<"$plane" >"$BATS_TEST_TMPDIR/stack.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/stack.json" -H 'Prefer: wait=40' && expect 200
    id=$(field .id)
    call GET "/v1/laminates/$id/report?format=json" && expect 200
    [[ $(header Content-Type) == application/json* ]]
    [ "$(field '[.plies[] | .status // (.pieces | length)] | tojson')" = '[2,"succeeded","failed"]' ]
    [ "$(field '.plies[0] | [.cloth_coverage, (.seams[0].overlap_width * 1e9 | round)] | tojson')" = '[1,250000000]' ]
    run --separate-stderr "$DRAPE" "$BATS_TEST_TMPDIR/stack.json"
    jq -S 'del(.plies[2].error)' <<<"$output" >"$BATS_TEST_TMPDIR/said"
    jq -S 'del(.plies[2].error)' "$body" | cmp - "$BATS_TEST_TMPDIR/said"
    [[ $stderr == *'ply: skin, 2 pieces cover 100 % of the part'* ]]
    [[ $stderr == *'seam: skin, right to piece_2, 3 m long, overlap 0.25 wide, gap 0, warps at 30 degrees'* ]]
    call GET "/v1/laminates/$id/report" && expect 200
    [[ $(header Content-Type) == text/html* && $(<"$body") == *'<td>right, piece_2</td><td>3</td>'* ]]
    call GET "/v1/laminates/$id/report?format=csv" && expect 406
}

@test "patterns that lack a ply say so, and machines get them when asked for" {
    local book='.plies[1] = (.plies[0] | del(.splits, .pieces) | .start = {point: [9, 9, 9]} | .name = "top")'
    for format in dxf astm hpgl laser; do
        drape_plane "$book" --format "$format"
        [[ $status -eq 1 && $stderr == *'ply 2 ("top") could not be draped and would be lacking'* ]]
    done
    drape_plane "$book" --format dxf --partial
    [[ $status -eq 0 && $output == *'; without "top", which could not be draped'* ]]
    drape_plane "$book" --format svg
    [[ $status -eq 0 && $output == *'; without &quot;top&quot;, which could not be draped'* ]]
    drape_plane "$book | .plies[2] = .plies[1] | .plies[2].name = \"last\"" --format svg
    [[ $output == *'; without 2 plies that could not be draped, the first of them &quot;top&quot;'* ]]
}

@test "pieces of a stored surface are known without it" {
    jq -c .surface <<<"$plane" >"$BATS_TEST_TMPDIR/surface.json"
    post /v1/surfaces "$BATS_TEST_TMPDIR/surface.json"
    jq -c --arg id "$(field .id)" '.surface = {id: $id} | .plies[0].seam = {overlap: 0.25, over: "last"}' \
        <<<"$plane" >"$BATS_TEST_TMPDIR/named.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/named.json" -H 'Prefer: wait=40' && expect 200
    [ "$(field '.plies[0].pieces | length')" -eq 2 ]
    call GET "/v1/laminates/$(field .id)/patterns?format=svg" && expect 200
    grep -q 'cloth 12.75 m2' "$body"
}

# refused EXPRESSION POINTER
refused() {
    drape_plane "$1"
    [ "$status" -eq 1 ]
    [[ $stderr == *"$2: "* ]] || { echo "$stderr" && false; }
}

@test "what is wrong with a split, a seam or a piece says which" {
    refused '.plies[0].splits[0].path = [[2, 0, 0], [2, 2, 0]]' '/plies/0/splits/0'
    refused '.plies[0].splits[1].path = [[1, 1, 0], [1.5, 2, 0]]' '/plies/0/splits/1'
    refused '.plies[0].splits[1] = .plies[0].splits[0]' '/plies/0/splits/1: lies on splits before it'
    refused '.plies[0].splits[1].path = [[2, 3, 0], [2, 1, 0]]' '/plies/0/splits/1: lies on splits before it'
    refused '.plies[0].splits[1].path = [[2.02, 0, 0], [2.02, 3, 0]]' '/plies/0/splits/1: lies on splits before it'
    refused '.plies[0].splits[0].path[1][2] = 1' '/plies/0/splits/0'
    refused '.plies[0].splits[0].path = [[2, 0, 0]]' '/plies/0/splits/0/path'
    refused '.plies[0].splits = []' '/plies/0/splits'
    refused '.plies[0].splits[0].knot = 1' '/plies/0/splits/0/knot'
    refused '.plies[0].seam = {overlap: 5}' '/plies/0/pieces/0'
    refused 'del(.plies[0].pieces) | .plies[0].seam = {gap: 5}' '/plies/0/seam'
    refused '.plies[0].seam = {overlap: 0.1, gap: 0.1}' '/plies/0/seam'
    refused '.plies[0].seam = {gap: 0.1, over: "first"}' '/plies/0/seam/over'
    refused '.plies[0].seam = {overlap: 0.1, over: "left"}' '/plies/0/seam/over'
    refused '.plies[0].pieces[1] = {at: [3.5, 1, 0]}' '/plies/0/pieces/1/at'
    refused '.plies[0].pieces[0].at = [9, 9, 9]' '/plies/0/pieces/0/at: is further from the part than the spacing, 0.1'
    refused '.plies[0].pieces[0].at = "here"' '/plies/0/pieces/0/at'
    refused '.plies[0].pieces[0].start = {uv: [0.1, 0.5]}' '/plies/0/pieces/0/start'
    refused '.plies[0].pieces[0].cuts = [{path: [[4, 1.5, 0], [2.5, 1.5, 0]]}]' '/plies/0/pieces/0/cuts/0: ply 1 ("skin, right")'
    post /v1/laminates "$BATS_TEST_TMPDIR/laminate.json" && expect 422
    [ "$(field '.errors[0].pointer')" = /plies/0/pieces/0/cuts/0 ]
    refused '.plies[0].pieces[0].fabric = {spacing: -1}' '/plies/0/pieces/0/fabric/spacing'
    refused '.plies[0].start = {uv: [0.1, 0.5]}' '/plies/0/start'
    refused 'del(.plies[0].splits)' '/plies/0/pieces'
}
