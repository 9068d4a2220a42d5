# SPDX-License-Identifier: MIT
# What angles of the warp are counted from: a rosette, or by default an axis or the u-tangent.
load helper

setup_file() { start_shared_daemon; }
teardown_file() { end_file; }

# box EXPRESSION: a drape request, changed by jq, of a floor in two faces, whose parameters run
# differently and whose sides are opposite, and of two walls.
box() {
    jq -nc "def plane(p; a; b): {degree_u: 1, degree_v: 1, knotvector_u: [0, 0, 1, 1],
                knotvector_v: [0, 0, 1, 1], size_u: 2, size_v: 2, control_points:
                    [p, [p, b], [p, a], [p, a, b] | if type == \"array\" and (.[0] | type) == \"array\"
                     then (transpose | map(add)) else . end]};
            {surface: {faces: [plane([0, 0, 0]; [1, 0, 0]; [0, 1.2, 0]),
                               plane([1, 0, 0]; [0, 1.2, 0]; [1, 0, 0]),
                               plane([0, 0, 0]; [0, 0, 0.4]; [2, 0, 0]),
                               plane([0, 1.2, 0]; [2, 0, 0]; [0, 0, 0.4])]},
             fabric: {spacing: 0.05}, start: {point: [0.7, 0.6, 0]}} | $1"
}

# The unit direction of the first step of the warp of a request, in thousandths.
first_step() {
    "$DRAPE" | jq -c '.nodes as $n | [range($n.i | length)
        | select($n.j[.] == 0 and ($n.i[.] == 0 or $n.i[.] == 1)) | [$n.i[.], $n.x[.], $n.y[.], $n.z[.]]]
        | sort | [range(1; 4) as $k | (.[1][$k] - .[0][$k]) / 0.05 * 1000 | round | . + 0]'
}

warp_of() { box "$1" | first_step; }

@test "a rosette gives 0 degrees on every face, and z the sense of angles" {
    local r='.rosette = {origin: [0, 0, 0], x: [1, 1, 0.2]}'
    local up='.rosette.z = [0.1, 0, 1]' down='.rosette.z = [0, 0, -1]'
    for place in '[0.7, 0.6, 0]' '[1.3, 0.6, 0]'; do
        local at=".start.point = $place | $r"
        [ "$(warp_of "$at")" = '[707,707,0]' ]
        [ "$(warp_of "$at | .direction.angle_deg = 30")" = '[259,966,0]' ]
        [ "$(warp_of "$at | .direction.angle_deg = 30 | $up")" = '[259,966,0]' ]
        [ "$(warp_of "$at | .direction.angle_deg = 30 | $down")" = '[966,259,0]' ]
        [ "$(warp_of "$at | .direction.vector = [0, 1, 0]")" = '[0,1000,0]' ]
    done
    [ "$(warp_of ".start.point = [1, 1.2, 0.2] | $r")" = '[981,0,196]' ]
}

@test "without a rosette 0 degrees do not depend on the face with the start" {
    for place in '[0.7, 0.6, 0]' '[1.3, 0.6, 0]'; do
        [ "$(warp_of ".start.point = $place")" = '[1000,0,0]' ]
        [ "$(warp_of ".start.point = $place | .direction.angle_deg = 30")" = '[866,500,0]' ]
        [ "$(warp_of ".start.point = $place | .surface.faces |= reverse")" = '[1000,0,0]' ]
    done
    [ "$(warp_of '.start.point = [1, 1.2, 0.2]')" = '[1000,0,0]' ]
    [ "$(warp_of '.surface = .surface.faces[1] | .start.point = [1.3, 0.6, 0]')" = '[0,1000,0]' ]
}

@test "what is wrong with a rosette is said at its place" {
    local rosette='{origin: [0, 0, 0], x: [0, 0, 1]}'
    refused() {
        box "$1" | "$DRAPE" >"$BATS_TEST_TMPDIR/out" 2>"$BATS_TEST_TMPDIR/stderr" && return 1
        grep -qF "$2" "$BATS_TEST_TMPDIR/stderr"
    }
    refused ".rosette = $rosette" '/rosette/x: must not be at right angles to the surface at the start'
    refused ".rosette = ($rosette | del(.x))" '/rosette/x: '
    refused ".rosette = ($rosette | del(.origin))" '/rosette/origin: '
    refused ".rosette = ($rosette + {x: [0, 0, 0]})" '/rosette/x: must be longer'
    refused ".rosette = ($rosette + {z: [0, 0, -2]})" '/rosette/z: must not be parallel to x'
    refused ".rosette = ($rosette + {y: [0, 1, 0]})" '/rosette/y: '
    refused '.rosette = [1, 0, 0]' '/rosette: '
}

@test "a request keeps its rosette, and a drape of another rosette is another" {
    box '.rosette = {origin: [1, 2, 3], x: [1, 1, 0], z: [0, 0, 2]}' >"$BATS_TEST_TMPDIR/box.json"
    post /v1/drapes "$BATS_TEST_TMPDIR/box.json" -H 'Prefer: wait=20'
    local id=$(field .id)
    call GET "/v1/drapes/$id/request"
    [ "$(jq -c .rosette "$body")" = '{"origin":[1,2,3],"x":[1,1,0],"z":[0,0,2]}' ]
    call GET "/v1/drapes/$id/result"
    local tag=$(header ETag)
    box '.rosette = {origin: [0, 0, 0], x: [1, 0, 0]}' >"$BATS_TEST_TMPDIR/other.json"
    post /v1/drapes "$BATS_TEST_TMPDIR/other.json" -H 'Prefer: wait=20'
    call GET "/v1/drapes/$(field .id)/result"
    expect 200
    [ "$(header ETag)" != "$tag" ]
}

@test "a laminate's plies turn about the normal on the side that they lie on" {
    stack() {
        box "{surface, rosette: {origin: [0, 0, 0], x: [1, 0, 0]}, plies: [
            {direction: {angle_deg: 30}, start, fabric: (.fabric + {thickness: 0.001})}]} | $1"
    }
    first_warp() { # of the first ply, by the drape request that it is
        stack "$1" >"$BATS_TEST_TMPDIR/stack.json"
        post /v1/laminates "$BATS_TEST_TMPDIR/stack.json" -H 'Prefer: wait=20'
        stack_id=$(field .id)
        call GET "/v1/drapes/$(field '.plies[0].id')/request"
        direction=$(jq -c '[.direction.angle_deg, .rosette.x]' "$body")
    }
    first_warp .
    [ "$direction" = '[30,[1,0,0]]' ]
    first_warp '.side = -1 | .rosette.z = [0, 0, 1]'
    [ "$direction" = '[30,[1,0,0]]' ]
    first_warp '.side = -1'
    [ "$direction" = '[-30,[1,0,0]]' ]
    call GET "/v1/laminates/$stack_id/request"
    [ "$(jq -c '[.side, .rosette, .plies[0].direction.angle_deg]' "$body")" = \
        '[-1,{"origin":[0,0,0],"x":[1,0,0]},30]' ]
    stack '.rosette.x = [0, 0, 1]' | "$DRAPE" 2>&1 | grep -F '/rosette/x: ply 1 ("ply_1"): must not be'
}

@test "a study varies the angle from its drape's rosette" {
    box '{drape: (. + {rosette: {origin: [0, 0, 0], x: [1, 1, 0]}}), objectives: ["max_shear_deg"],
          vary: {start: {points: [[0.7, 0.6, 0], [1.3, 0.6, 0]]}, angle_deg: [0, 30]}}' \
        >"$BATS_TEST_TMPDIR/study.json"
    for k in 0 1 2 3; do
        "$DRAPE" "$BATS_TEST_TMPDIR/study.json" --variant $k 2>/dev/null | first_step
    done >"$BATS_TEST_TMPDIR/warps"
    [ "$(tr '\n' ' ' <"$BATS_TEST_TMPDIR/warps")" = '[707,707,0] [259,966,0] [707,707,0] [259,966,0] ' ]
}

@test "patterns and the ply book show 0 degrees of the rosette, at minus the angle from the warp" {
    local out=$BATS_TEST_TMPDIR
    box '.rosette = {origin: [0, 0, 0], x: [1, 1, 0]} | .direction.angle_deg = 30' >"$out/box.json"
    "$DRAPE" "$out/box.json" --format svg -o "$out/box.svg"
    python3 - "$out/box.svg" <<'PYTHON'
import math, re, sys
text = open(sys.argv[1]).read()
x, y = map(float, re.search(r'id="rosette"[^>]* d="M0 0L(\S+) ([^"]+)"', text).groups())
assert abs(math.degrees(math.atan2(y, x)) + 30) < 1e-6, (x, y)
PYTHON
    "$DRAPE" "$out/box.json" --format dxf | grep -q '^ROSETTE'
    box . | "$DRAPE" --format svg | not grep -q rosette
    box '{surface, plies: [{fabric, start}], rosette: {origin: [1, 2, 3], x: [1, 0, 0]}}' |
        "$DRAPE" --format html >"$out/book.html"
    grep -q 'the rosette at (1, 2, 3), x along (1, 0, 0)' "$out/book.html"
    grep -q '>0°</text>' "$out/book.html"
}

@test "decks have the rosette as a coordinate system" {
    local out=$BATS_TEST_TMPDIR format
    echo '{"mesh": {"vertices": [[0.2, 0.2, 0], [0.3, 0.2, 0], [0.3, 0.3, 0]], "triangles": [[0, 1, 2]]}}' \
        >"$out/mesh.json"
    local rosette='rosette: {origin: [1, 2, 3], x: [0, 2, 0], z: [0, 1, 5]}'
    for side in 1 -1; do
        box "{surface, side: $side, plies: [{fabric: (.fabric + {thickness: 0.001}), start}], $rosette}" \
            >"$out/stack-$side.json"
        jq 'del(.rosette.z)' "$out/stack-$side.json" >"$out/free-$side.json"
    done
    box "(. + {$rosette}) | .fabric.thickness = 0.001" >"$out/drape.json"
    deck() { "$DRAPE" "$out/$1.json" --map "$out/mesh.json" --reference 1,0,0 --format "$2" | tr -s ' \n' ' '; }
    for request in drape stack-1 stack--1; do
        for format in nastran optistruct; do
            [[ $(deck $request $format) == *'CORD2R* 4 0 1. 2. * 3. 1. 2. 4. * 1. 3. 3. '* ]]
        done
        [[ $(deck $request lsdyna) == *'*DEFINE_COORDINATE_SYSTEM 4 1. 2. 3. 1. 3. 3. 0. 2. 3. *NODE'* ]]
        [[ $(deck $request abaqus) == *'NAME=ROSETTE, SYSTEM=RECTANGULAR 1., 3., 3., 0., 2., 3., 1., 2., 3. '* ]]
        [[ $(deck $request calculix) == *'*ORIENTATION, NAME=ROSETTE 0., 1., 0., -1., 0., 0. '* ]]
        [[ $(deck $request radioss) == *'/SKEW/FIX/4 rosette 1. 2. 3. -1. 0. 0. 0. 0. 1. '* ]]
    done
    [[ $(deck free-1 nastran) == *'CORD2R* 4 0 1. 2. * 3. 1. 2. 4. * 1. 3. 3. '* ]]
    [[ $(deck free--1 nastran) == *'CORD2R* 4 0 1. 2. * 3. 1. 2. 2. * 1. 3. 3. '* ]]
    box '.fabric.thickness = 0.001' >"$out/plain.json"
    [[ $(deck plain nastran) != *CORD2R* ]]
}
