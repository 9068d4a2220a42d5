# SPDX-License-Identifier: MIT
# Plies laid in courses of a roll's width: what becomes of them in reports, patterns, maps, statuses.
load helper

setup_file() { start_shared_daemon; }
teardown_file() { end_file; }

# A plane of 4 by 3; warp runs along x.
plane='{"surface": {"degree_u": 1, "degree_v": 1, "size_u": 2, "size_v": 2,
    "knotvector_u": [0, 0, 1, 1], "knotvector_v": [0, 0, 1, 1],
    "control_points": [[0, 0, 0], [0, 3, 0], [4, 0, 0], [4, 3, 0]]},
    "plies": [{"name": "skin", "fabric": {"spacing": 0.1, "thickness": 0.001, "locking_angle_deg": 40},
        "areal_weight": 0.5, "courses": {"width": 0.8, "along": {"edge": [2, 0, 0]}}}]}'

# A flat plate whose parameters are so uneven that its continuation runs away 70 mm beyond its end.
plate='{"surface": {"degree_u": 4, "degree_v": 4, "size_u": 5, "size_v": 5,
    "knotvector_u": [0, 0, 0, 0, 0, 1, 1, 1, 1, 1], "knotvector_v": [0, 0, 0, 0, 0, 1, 1, 1, 1, 1],
    "control_points": {"points": [[0, 0, 0], [0, 18, 0], [0, 39, 0], [0, 59, 0], [0, 80, 0],
        [23, 0, 0], [25, 19, 0], [24, 42, 0], [24, 60, 0], [27, 80, 0],
        [49, 0, 0], [48, 21, 0], [51, 39, 0], [51, 59, 0], [49, 80, 0],
        [74, 0, 0], [76, 22, 0], [77, 41, 0], [74, 60, 0], [76, 80, 0],
        [100, 0, 0], [100, 20, 0], [100, 42, 0], [100, 61, 0], [100, 80, 0]]}},
    "plies": [{"name": "skin", "fabric": {"spacing": 5, "thickness": 0.3}, "courses": {"width": 19.275,
        "overlap": 1.772, "along": {"path": [[63.6, 0, 0], [64.6, 10.3, 0], [65.5, 20.5, 0], [66.3, 30.5, 0],
            [67, 40.5, 0], [67.6, 50.4, 0], [68.1, 60.2, 0], [68.7, 70.1, 0], [69.4, 80, 0]]}}}]}'

@test "courses end where the continuation of the part runs away" {
    output=$("$BUILD/drape" - <<<"$plate" 2>/dev/null)
    number .courses.count 7
    jq -e '.plies[0].cloth_coverage > 0.999' <<<"$output"
}

@test "courses from an edge cover a plane, and the last one is trimmed" {
    drape_plane .
    [ "$(jq -c '[.plies[0].pieces[].name]' <<<"$output")" = '["course_1","course_2","course_3","course_4"]' ]
    number .cloth_coverage 1
    number .courses.count 4
    number .courses.area 12.8
    number .courses.net_area 12
    number .courses.trim_area 0.8
    number .courses.max_shear_deg 0
    number '.pieces[0].course.cut_length' 4
    number '.pieces[0].area' 3.2
    number '.pieces[0].mass' 1.6
    number '.pieces[3].course.net_area' 2.4
    number '.pieces[3].course.trim_area' 0.8
    jq -e '.plies[0].pieces[0].course.trim_area == 0' <<<"$output" # no rounding in the ply book
    number '[.pieces[] | select(.outcome == "complete")] | length' 4
}

@test "gaps, overlaps and first offsets have their areas, on both sides of a line" {
    drape_plane '.plies[0].courses += {gap: 0.05, first_offset: -0.2}'
    number '.courses.gap_area' 0.6
    number '.cloth_coverage' 0.95
    number '.pieces[0].course.net_area' 2.4
    number '.pieces[1].course | .gap_least, .gap_greatest | [.] | add' 0.05
    drape_plane '.plies[0].courses += {overlap: 0.05}'
    number '.courses.overlap_area' 0.6
    number '.courses.area' 12.8
    number '.cloth_coverage' 1
    drape_plane '.plies[0].courses += {gap: [[0, 0.1], [0.1, 0], [0]]}'
    number '.courses.gap_area' '0.2 * (1 + (1.000625 | sqrt))' # the second is slanted itself
    drape_plane '.plies[0].courses = {width: 0.8, gap: 0.02}' # from the middle to both sides
    number .courses.count 4
    number .cloth_coverage 0.98
    number '.courses.gap_area' 0.24
    drape_plane '.plies[0].courses = {width: [0.8, 0.5], order: "left"}'
    number .courses.count 3
    number .cloth_coverage 0.5
    drape_plane '.plies[0].courses = {width: 0.8, order: "right", along: {path: [[0.5, 2, 0], [3.5, 2, 0]]}}'
    number .courses.count 3
    number .cloth_coverage '2 / 3'
    drape_plane '.plies[0].courses += {ends: 0.1, wanted_direction: [1, 1, 0]}'
    number '.pieces[0].course.cut_length' 4.2
    number '.pieces[0].course.trim_area' 0.16
    number '.courses.angle_deviation_max_deg' 45
}

@test "a corner of the part that holds no whole cell is a course, with its cloth" {
    drape_plane '.plies[0].direction = {angle_deg: 45} | .plies[0].courses = {width: 0.8}'
    number .courses.count 8
    number .cloth_coverage 1
    number '.pieces[3].course.net_area' '((3.5 / (2 | sqrt)) - 2.4) | . * .'
    number '.pieces[3].nodes' 1
}

@test "the stagger is asked for, and measured against the ply below" {
    drape_plane '.plies[1] = .plies[0] | .plies[1].name = "core" | .plies[2] = .plies[1] |
        .plies[2].name = "top" | .plies[].courses.stagger = 0.3'
    number '.courses | has("stagger") | if . then 1 else 0 end' 0
    output=$(jq -c '.plies |= .[1:]' <<<"$output")
    number '.courses.stagger' 0.3
    number '.pieces[0].course.net_area' 2
    number '.cloth_coverage' 1
    output=$(jq -c '.plies |= .[1:]' <<<"$output")
    number '.courses.stagger' 0.3
    number '.pieces[0].course.net_area' 0.8
}

# A quarter of a cylinder of radius 2 about z, and of a cone to half of that, 3 high.
quarter() {
    jq -nc --argjson top "$1" '(0.5 | sqrt) as $w |
        def circle($r; $z): [[$r, 0, $z, 1], [$r, $r, $z, $w], [0, $r, $z, 1]] |
            map([(.[:3][] * .[3]), .[3]] | .[0:3] + [.[3]]);
        [circle(2; 0), circle($top; 3)] | transpose as $rows |
        {degree_u: 2, degree_v: 1, size_u: 3, size_v: 2, knotvector_u: [0, 0, 0, 1, 1, 1],
         knotvector_v: [0, 0, 1, 1],
         control_points: {points: [$rows[][] | [.[0] / .[3], .[1] / .[3], .[2] / .[3]]],
                          weights: [$rows[][] | .[3]]}}'
}

@test "courses on a cylinder and on a cone are rectangles, sheared by less than 0.01 degrees" {
    local top
    for top in 2 1; do
        quarter "$top" >"$BATS_TEST_TMPDIR/quarter.json"
        plane=$(jq -c --slurpfile s "$BATS_TEST_TMPDIR/quarter.json" '.surface = $s[0]' <<<"$plane") \
            drape_plane '.plies[0].fabric.spacing = 0.05 | .plies[0].courses =
                {width: 0.4} | .plies[0].method = "geodesic" | .plies[0].direction = {angle_deg: 30}'
        number '.courses.max_shear_deg' 0 0.01
        number '[.pieces[].course | select(.trim_area < 0) ] | length' 0
    done
}

@test "an element under an overlap of courses has two rows, in the order of laying" {
    local mesh=$BATS_TEST_TMPDIR/mesh.json
    echo '{"mesh": {"vertices": [[1, 0.3, 0], [1.2, 0.3, 0], [1, 0.4, 0], [1, 0.7, 0], [1.2, 0.7, 0],
           [1, 0.71, 0]], "triangles": [[0, 1, 2], [3, 4, 5]]}}' >"$mesh"
    drape_plane '.plies[0].courses.overlap = 0.2' --map "$mesh"
    [ "$(jq -c '.plies | [.element, .ply, .piece]' <<<"$output")" = '[[0,1,1],[1,1,1],[1,1,2]]' ]
    [ "$(jq -c '[.cells.thickness[] * 1e6 | round]' <<<"$output")" = '[1000,2000]' ]
    drape_plane . --map "$mesh" --format nastran
    grep -q 'PCOMP' <<<"$output"
}

@test "patterns and the ply book have every course" {
    drape_plane . --format dxf
    [ "$(grep -cE '^1 skin, course_[1-4]$' <<<"$output")" -eq 4 ]
    drape_plane . --format html
    [[ $output == *'1  skin, course_4'* && $output == *'<h2>Courses</h2>'* && $output == *'<th>Width</th>'* && $output == *'<td>12.8</td>'* ]]
}

@test "over HTTP every course is a drape with its id, and what was understood is the same laminate" {
    local figures
    jq -c '.plies[0].courses += {overlap: 0.05, wanted_direction: [1, 0, 0]}' <<<"$plane" \
        >"$BATS_TEST_TMPDIR/stack.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/stack.json" -H 'Prefer: wait=40' && expect 200
    id=$(field .id)
    [ "$(field '[.plies[0].pieces[] | .name + "," + .status] | tojson')" = \
        '["course_1,succeeded","course_2,succeeded","course_3,succeeded","course_4,succeeded"]' ]
    course=$(field '.plies[0].pieces[1].id')
    call GET "/v1/drapes/$course/request" && expect 200
    cp "$body" "$BATS_TEST_TMPDIR/course.json"
    [ "$(field '.generators.warp.places | length > 40 and length < 60')" = true ]
    [ "$(field 'has("start")')" = false ]
    output=$("$DRAPE" "$BATS_TEST_TMPDIR/course.json")
    jq -e '.summary | .max_shear_deg < 1e-9 and (.flat_area - 3.2 | fabs < 1e-9)' <<<"$output"
    call GET "/v1/laminates/$id/report?format=json" && expect 200
    [ "$(field '.plies[0].courses | [.count, .area, .overlap_area, .angle_deviation_max_deg] |
        map(. * 1e9 | round / 1e9) | tojson')" = '[4,12.8,0.6,0]' ]
    call GET "/v1/laminates/$id/plies/0/pattern" && expect 200
    grep -q 'skin, course_4' "$body"
    call GET "/v1/laminates/$id/request" && expect 200
    cp "$body" "$BATS_TEST_TMPDIR/understood.json"
    figures=$(field '.plies[0].pieces[1].course | [.overlap_area, .cut_length, .angle_deviation_deg] | map(. * 1e9 | round) | tojson')
    [ "$figures" = '[200000000,4000000000,0]' ]
    post /v1/laminates "$BATS_TEST_TMPDIR/understood.json" -H 'Prefer: wait=40' && expect 200
    id=$(field .id)
    call GET "/v1/drapes/$(field '.plies[0].pieces[1].id')/request" && expect 200
    cmp "$body" "$BATS_TEST_TMPDIR/course.json"
    call GET "/v1/laminates/$id/request" && expect 200
    cmp "$body" "$BATS_TEST_TMPDIR/understood.json"
    # Of a stored surface likewise, whose courses are known without it.
    jq -c .surface <<<"$plane" >"$BATS_TEST_TMPDIR/surface.json"
    post /v1/surfaces "$BATS_TEST_TMPDIR/surface.json"
    jq -c --arg id "$(field .id)" '.surface = {id: $id}' <<<"$plane" >"$BATS_TEST_TMPDIR/named.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/named.json" -H 'Prefer: wait=40' && expect 200
    [ "$(field '.plies[0].pieces | length')" -eq 4 ]
    call GET "/v1/laminates/$(field .id)/patterns?format=svg" && expect 200
    grep -q 'cloth 12 m2' "$body"
}

@test "courses on some faces of a part have the numbers of its faces" {
    jq -nc 'def face($x): {degree_u: 1, degree_v: 1, size_u: 2, size_v: 2, knotvector_u: [0, 0, 1, 1],
            knotvector_v: [0, 0, 1, 1],
            control_points: [[$x, 0, 0], [$x, 3, 0], [$x + 1, 0, 0], [$x + 1, 3, 0]]};
        {faces: [face(7), face(0), face(1), face(2), face(3)]}' >"$BATS_TEST_TMPDIR/faces.json"
    post /v1/surfaces "$BATS_TEST_TMPDIR/faces.json"
    jq -c --arg id "$(field .id)" '.surface = {id: $id, faces: [1, 2, 3, 4]}' <<<"$plane" \
        >"$BATS_TEST_TMPDIR/some.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/some.json" -H 'Prefer: wait=40' && expect 200
    [ "$(field '[.plies[0].pieces[].status] | unique | tojson')" = '["succeeded"]' ]
    call GET "/v1/laminates/$(field .id)/request" && expect 200
    [ "$(field '[.plies[0].pieces[0].generators.warp.places[][0]] | unique | tojson')" = '[1,2,3,4]' ]
    [ "$(field '[.plies[0].pieces[].course.net_area] | add * 1e6 | round')" = 12000000 ]
}

# refused EXPRESSION POINTER
refused() {
    drape_plane "$1"
    [ "$status" -eq 1 ]
    [[ $stderr == *"  $2: "* ]] || { echo "$stderr" && false; }
}

@test "what cannot be laid is refused where it is said" {
    local c='.plies[0].courses'
    refused "$c.width = 0" /plies/0/courses/width
    refused "$c.width = 6" /plies/0/courses/width
    refused "$c.width = [0.5, 6]" /plies/0/courses/width/1
    refused "$c.width = [1e-9, 0.5]" /plies/0/courses/width/0
    refused "del($c.width)" /plies/0/courses/width
    refused "$c += {gap: 0.1, overlap: 0.1}" /plies/0/courses/overlap
    refused "$c += {overlap: 0.8}" /plies/0/courses/overlap
    refused "$c.gap = [[0, -0.9]]" /plies/0/courses/gap
    refused "$c.gap = 20" /plies/0/courses/gap
    refused "$c.first_offset = 100" /plies/0/courses/first_offset
    refused "$c.first_offset = [range(17)]" /plies/0/courses/first_offset
    refused "$c.along = {edge: [2, 1, 0]}" /plies/0/courses/along/edge
    refused "$c.along = {path: [[1, 1, 0], [2, 1, 0], [5, 1, 0]]}" /plies/0/courses/along/path/2
    refused "$c.along = {path: [[1, 1, 0]]}" /plies/0/courses/along/path
    refused "$c.along = {edge: [2, 0, 0], path: [[1, 1, 0], [2, 1, 0]]}" /plies/0/courses/along
    refused "$c.order = \"right\"" /plies/0/courses
    refused "$c.order = \"up\"" /plies/0/courses/order
    refused "$c.origin = 2" /plies/0/courses/origin
    refused "$c.ends = -1" /plies/0/courses/ends
    refused "$c.stagger = -1" /plies/0/courses/stagger
    refused "$c.wanted_direction = [0, 0, 0]" /plies/0/courses/wanted_direction
    refused "$c.weave = 1" /plies/0/courses/weave
    refused "$c.width = 0.001 | .plies[0].fabric.spacing = 0.4" /plies/0/courses/width
    refused '.plies[0].start = {uv: [0.5, 0.5]}' /plies/0/start
    refused '.plies[0].courses.along = {path: [[0, 1, 0], [3, 1, 0], [3, 2, 0], [1, 2, 0], [1, 0, 0]]}' /plies/0/courses/along/path
    [[ $stderr == *'crosses itself'* ]]
    refused '.plies[0].courses.along = {path: [[0, 1, 0], [4, 1, 0], [0, 1, 0]]}' /plies/0/courses/along/path
    refused '.plies[0].fabric.pre_shear_deg = 5' /plies/0/fabric/pre_shear_deg
    refused '.plies[0].fabric.spacing = 1e-5' /plies/0/fabric/spacing
    refused '.plies[0].fabric.spacing = 10' /plies/0/fabric/spacing
    refused '.plies[0].generators = {warp: {plane: [0, 1, 0]}}' /plies/0/generators
    for key in splits seam boundary cuts extent; do
        refused ".plies[0].$key = {}" "/plies/0/$key"
    done
    refused '.surface = {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]]}' \
        /plies/0/courses
}

@test "a generator of places is refused where it is none" {
    local wide='[range(9) | [0, 0.1 + 0.05 * ., 0.5, 1, 0, 0]]'
    place() {
        jq -c "{surface, fabric: {spacing: 0.2}, generators: {warp: {places: $wide, start: 4}}} | $1" \
            <<<"$plane" >"$BATS_TEST_TMPDIR/place.json"
        status=0
        stderr=$("$DRAPE" "$BATS_TEST_TMPDIR/place.json" 2>&1 >"$BATS_TEST_TMPDIR/placed.json") || status=$?
    }
    place .
    [ "$status" -eq 0 ]
    jq -e '.summary | (.cloth_coverage > 0.99) and .max_shear_deg < 1e-9' "$BATS_TEST_TMPDIR/placed.json"
    local p='.generators.warp.places'
    while IFS='|' read -r change pointer; do
        place "$change"
        [ "$status" -eq 1 ]
        [[ $stderr == *"  $pointer: "* ]] || { echo "$change: $stderr" && false; }
    done <<END
$p = []|/generators/warp/places
$p[2][0] = 1|/generators/warp/places/2
$p[2][0] = 0.5|/generators/warp/places/2
$p[2][1] = 0.9|/generators/warp/places
$p[2] = [1, 2]|/generators/warp/places/2
.generators.warp.start = 9|/generators/warp/start
.generators.weft = .generators.warp|/generators/weft
.start = {uv: [0.5, 0.5]}|/start
.surface = {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]]}|/generators/warp
END
}
