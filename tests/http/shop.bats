# SPDX-License-Identifier: MIT
# What the shop floor gets of a laminate: patterns for cutters, lines for laser projectors, the ply
# book, and all of it in one bundle, under one revision.
load helper

SHOP="/usr/bin/python3 tests/readers/shop.py"
LASER="/usr/bin/python3 tests/readers/laser.py"

setup_file() { start_shared_daemon; }
teardown_file() { end_file; }

# stack EXPRESSION: two layers of a frame of 3 m by 2 m less 1 m by 1 m on a plane of 4 m, and all of
# the plane, of one cloth; changed by jq.
stack() {
    jq -nc "{surface: {degree_u: 1, degree_v: 1, size_u: 2, size_v: 2, knotvector_u: [0, 0, 1, 1],
                 knotvector_v: [0, 0, 1, 1],
                 control_points: [[0, 0, 0], [0, 4, 0], [4, 0, 0], [4, 4, 0]]},
             plies: [{name: \"frame\", repeat: 2, direction: {angle_deg: 30}, boundary: {polygons: [
                        [[0.5, 1, 0], [3.5, 1, 0], [3.5, 3, 0], [0.5, 3, 0]],
                        [[1.5, 1.5, 0], [2.5, 1.5, 0], [2.5, 2.5, 0], [1.5, 2.5, 0]]]}},
                     {name: \"skin\"}]}
            | .plies[].fabric = {spacing: 0.2, thickness: 0.002, fiber_volume_fraction: 0.5}
            | $1" >"$BATS_TEST_TMPDIR/stack.json"
}

# write EXPRESSION FORMAT [ARGUMENT...]: by the command, into the file `out`.
write() {
    stack "$1"
    local format=$2
    shift 2
    out=$BATS_TEST_TMPDIR/out.$format
    "$DRAPE" "$BATS_TEST_TMPDIR/stack.json" --format "$format" -o "$out" "$@" 2>"$BATS_TEST_TMPDIR/err"
}

# refused TEXT ARGUMENT...: `write` with these fails and says that.
refused() {
    local text=$1
    shift
    not write "$@"
    grep -qF "$text" "$BATS_TEST_TMPDIR/err"
}

@test "ezdxf reads pieces by ASTM D6673: layers, grain, notches, names, quantities, areas" {
    write . astm
    $SHOP astm "$out" | jq -cs 'sort_by(.name) | map([.name, .quantity, (.area / 1e4 | round)])' \
        >"$BATS_TEST_TMPDIR/pieces"
    [ "$(cat "$BATS_TEST_TMPDIR/pieces")" = '[["1 frame","2,0",500],["2 skin","1,0",1600]]' ]
    $SHOP astm "$out" | jq -se 'sort_by(.name) | map(.notches) == [8, 4]'
    # The sewn pieces of a ply, and a dart with the notches of its lips.
    write '.plies |= [.[1]] | .plies[0] += {splits: [{path: [[2, 0, 0], [2, 4, 0]]}],
        seam: {overlap: 0.1}, pieces: [{at: [3, 1, 0], name: "right"}]}' astm
    $SHOP astm "$out" | jq -es 'map(.name) | sort == ["1.1 piece_1", "1.2 right"] or
        sort == ["1.1 right", "1.2 piece_2"]'
    $SHOP astm "$out" | jq -es 'map(.area / 1e4 | round) == [820, 820]'
    "$DRAPE" "$EXAMPLES/tray.json" --format astm --partial -o "$BATS_TEST_TMPDIR/tray.dxf" 2>/dev/null
    $SHOP astm "$BATS_TEST_TMPDIR/tray.dxf" | jq -e '.quantity == "1,0"'
}

@test "the knife of HP-GL goes round every pattern, on the roll" {
    write . hpgl --width 5
    $SHOP hpgl "$out" | jq -e '(.area / 1e4 | round) == 2600 and .low[0] > -0.1 and .low[1] > -0.1 and
        .high[1] < 5000.1 and any(.labels[]; . == "1 frame (2 of 2)") and
        any(.labels[]; test("utilisation [0-9.]+ %"))'
    write . hpgl --width 5 --turn 0 --gap 0.1
    $SHOP hpgl "$out" | jq -e '(.area / 1e4 | round) == 2600'
    "$DRAPE" "$EXAMPLES/saddle.json" --format hpgl -o "$BATS_TEST_TMPDIR/saddle.plt"
    "$DRAPE" "$EXAMPLES/saddle.json" -o "$BATS_TEST_TMPDIR/saddle.json"
    $SHOP hpgl "$BATS_TEST_TMPDIR/saddle.plt" |
        jq -e --slurpfile drape "$BATS_TEST_TMPDIR/saddle.json" \
            '(.area / 1e6 / $drape[0].summary.flat_area - 1 | fabs) < 1e-3'
}

@test "every cloth has a roll of its own" {
    local two='.plies[1].fabric.thickness = 0.003'
    write "$two" svg
    grep -q ' on 2 rolls, ' "$out"
    grep -q '>0.003 m<' "$out"
    refused 'the plies are of 2 cloths: ask for roll=1 to roll=2' "$two" hpgl
    refused 'roll: there are 2' "$two" hpgl --roll 3
    write "$two" hpgl --roll 2
    $SHOP hpgl "$out" | jq -e '(.area / 1e4 | round) == 1600'
    write "$two" astm
    $SHOP astm "$out" | jq -es 'map(.material) == ["0.002 m", "0.003 m"]'
    # How its net is spaced does not make another cloth.
    write '.plies[1].fabric.spacing = 0.1' svg
    not grep -q ' on 2 rolls, ' "$out"
}

@test "lasers draw at the height of the sheared stack below, on exact surfaces" {
    $LASER plane "$DRAPE" | jq -e '.layers == 5 and .wrong < 1e-12 and .edge < 1e-10'
    $LASER cylinder "$DRAPE" | jq -e '.wrong < 1e-10 and .edge < 1e-6 and .chord < 2e-4 and .chord > 2e-5 and
        .points < 700 and .["1"] == -.["-1"]'
    $LASER sphere "$DRAPE" | jq -e '.wrong < 1e-10 and .shear > 8 and .height < 4e-5 and .chord < 0.1'
    $LASER fibres "$DRAPE" | jq -e '.wrong < 1e-10 and .height < 1e-5 and .chord < 0.1'
}

@test "formats for lasers agree, pieces lie on each other, and unknown heights are refused" {
    write . laser
    $LASER read "$out" >"$BATS_TEST_TMPDIR/lines"
    local points='[.layers[].lines[] | [.kind, (.points | map(.[:6]))]]'
    write . laser-csv
    $LASER read "$out" | jq -e --slurpfile lines "$BATS_TEST_TMPDIR/lines" "$points == (\$lines[0] | $points)"
    write . virtek
    $LASER read "$out" | jq -e --slurpfile lines "$BATS_TEST_TMPDIR/lines" "
        def flat: $points | flatten | map(numbers);
        [flat, (\$lines[0] | flat)] | transpose | length > 100 and
            (to_entries | all((.value[0] * (if .key % 6 < 3 then 0.001 else 1 end) - .value[1] | fabs) < 1e-6))"
    # The first of two pieces lies on the second, layer by layer.
    write '.plies |= [.[1]] | .plies[0] += {splits: [{path: [[2, 0, 0], [2, 4, 0]]}], repeat: 2,
        seam: {overlap: 0.2, over: "first"}, pieces: [{at: [3, 1, 0], name: "right"}]}' laser
    jq -e '[.layers[] | .piece] == [2, 1, 2, 1] and
        [.layers[] | [.lines[0].points[] | select(.[0] > 2.05 | not) | .[6]] | max * 1e6 | round] ==
            [0, 2000, 2000, 6000]' "$out"
    refused 'the thickness of ply 1 ("frame") is not known' 'del(.plies[0].fabric.thickness)' laser
    refused 'laser is of a laminate' '{surface, fabric: .plies[0].fabric}' laser
    refused 'ply 2 ("skin") could not be draped' '.plies[1].start = {point: [9, 9, 9]}' virtek
}

@test "what a machine cannot do is refused, and the command and the service agree" {
    refused 'width: a roll of 1' . hpgl --width 1
    not write . hpgl --width wide
    not write . hpgl --turn 90
    refused 'hpgl holds 209.715 m of roll' '.plies[0].repeat = 400' hpgl
    stack .
    post /v1/laminates "$BATS_TEST_TMPDIR/stack.json" -H 'Prefer: wait=40' && expect 200
    local id=$(field .id)
    for format in svg dxf astm hpgl; do
        "$DRAPE" "$BATS_TEST_TMPDIR/stack.json" --format "$format" --width 5 -o "$BATS_TEST_TMPDIR/file"
        call GET "/v1/laminates/$id/patterns?format=$format&width=5" && expect 200
        cmp "$body" "$BATS_TEST_TMPDIR/file"
    done
    for format in laser laser-csv virtek; do
        "$DRAPE" "$BATS_TEST_TMPDIR/stack.json" --format $format --tolerance 0.01 -o "$BATS_TEST_TMPDIR/file"
        call GET "/v1/laminates/$id/laser?format=$format&tolerance=0.01" && expect 200
        cmp "$body" "$BATS_TEST_TMPDIR/file"
    done
    call GET "/v1/laminates/$id/laser?tolerance=0"
    expect_problem 422 invalid-request
    call GET "/v1/laminates/$id/patterns?turn=90"
    expect_problem 422 invalid-request
    call GET "/v1/laminates/$id/patterns?roll=0"
    expect_problem 422 invalid-request
    call GET "/v1/laminates/$id/patterns?format=hpgl&roll=2"
    expect_problem 422 invalid-request
    call GET "/v1/laminates/$id/plies/1/pattern?format=hpgl" && expect 200
    $SHOP hpgl "$body" | jq -e '(.area / 1e4 | round) == 1600'
}

@test "every page of the ply book, every pattern and every piece bear one revision" {
    write . html
    local revision=$(grep -o 'Revision [0-9a-f]*' "$out" | sort | uniq -c)
    [[ $revision =~ ^\ *2\ Revision\ ([0-9a-f]{32})$ ]]
    revision=${BASH_REMATCH[1]}
    for format in html svg dxf astm hpgl virtek; do
        write . $format --width 5
        [ "$(grep -ao 'revision [0-9a-f]*' "$out" | sort -u)" = "revision $revision" ]
    done
    for format in laser laser-csv; do
        write . $format
        $LASER read "$out" | jq -e ".revision == \"$revision\""
    done
    write '.plies[1].direction.angle_deg = 1' svg
    not grep -q "$revision" "$out"
}

@test "the bundle has all of it, with digests, and every file with a place for it bears the revision" {
    local whole='.plies[].fabric.lamina = {e1: 1e11, e2: 6e9, nu12: 0.3, g12: 2e9} |
        .rosette = {origin: [0, 0, 0], x: [1, 0, 0]} | .plies[1].fabric.thickness = 0.003 |
        .plies[].permeability = {model: "kozeny_carman", k1: 3e-10, k2: 1e-10, k3: 2e-11,
            at_fiber_volume_fraction: 0.5}'
    write "$whole" bundle
    $SHOP bundle "$out" >"$BATS_TEST_TMPDIR/bundle"
    jq -e '.left_out == [] and (.plies | map(.drape)) == [1, 2]' "$BATS_TEST_TMPDIR/bundle"
    # The request is what the revision is of; tables and results have no place for it.
    jq -r '.without[]' "$BATS_TEST_TMPDIR/bundle" | sort >"$BATS_TEST_TMPDIR/without"
    diff "$BATS_TEST_TMPDIR/without" <(printf '%s\n' decks/abd.csv decks/acp.csv decks/elements.csv \
        drapes/1_request.json drapes/1_result.npz drapes/2_request.json drapes/2_result.npz request.json)
    # Of every format of maps and of every roll a file.
    [ "$(jq '[.names[] | select(startswith("decks/"))] | length' "$BATS_TEST_TMPDIR/bundle")" = \
        "$(sed -n '/^| map |/p' docs/formats.md | wc -l)" ]
    jq -e '[.names[] | select(endswith(".plt"))] == ["patterns/roll_1.plt", "patterns/roll_2.plt"]' \
        "$BATS_TEST_TMPDIR/bundle"
    # The same bytes again, and from the service; its parts are what is got one by one.
    cp "$out" "$BATS_TEST_TMPDIR/first.zip"
    write "$whole" bundle
    cmp "$out" "$BATS_TEST_TMPDIR/first.zip"
    post /v1/laminates "$BATS_TEST_TMPDIR/stack.json" -H 'Prefer: wait=40' && expect 200
    local id=$(field .id)
    call GET "/v1/laminates/$id/bundle.zip" && expect 200
    cmp "$body" "$BATS_TEST_TMPDIR/first.zip"
    echo '{"mesh": {"vertices": [[1, 1, 0], [2, 1, 0], [1, 2, 0]], "triangles": [[0, 1, 2]]}}' \
        >"$BATS_TEST_TMPDIR/mesh.json"
    post "/v1/laminates/$id/map?format=nastran" "$BATS_TEST_TMPDIR/mesh.json" && expect 200
    tr -d '$\n' <"$body" | grep -q "Laminate $id, *revision *$(jq -r .revision "$BATS_TEST_TMPDIR/bundle")"
    call GET "/v1/laminates/$id/patterns?format=astm" && expect 200
    unzip -p "$BATS_TEST_TMPDIR/first.zip" patterns/pieces_astm.dxf | cmp - "$body"
    unzip -p "$BATS_TEST_TMPDIR/first.zip" request.json >"$BATS_TEST_TMPDIR/again.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/again.json" --format virtek | cmp - <(unzip -p "$out" laser/virtek.ply)
}

@test "the bundle says what it lacks, and why" {
    write . bundle
    $SHOP bundle "$out" | jq -e '(.left_out | map(.name)) ==
        ["decks/lcmsim.zip", "decks/lcmsim.h5", "decks/lims.dmp", "decks/radioss.inc", "decks/abd.csv"] and
        all(.left_out[]; .reason | length > 20)'
    # A ply that ends before the part does is no work for machines.
    write '.plies[1].extent = {warp: [-1, 1], weft: [-1, 1]}' bundle
    $SHOP bundle "$out" | jq -e '.left_out | map(select(.reason | test("bare")) | .name) ==
        ["patterns/rolls.dxf", "patterns/pieces_astm.dxf", "laser/lines.json", "laser/lines.csv",
         "laser/virtek.ply", "patterns/roll_1.plt"]'
}

# rows FILE N: the cells of the table of sectors of ply N, a row a line.
rows() {
    /usr/bin/python3 - "$1" "$2" <<'END'
import re
import sys

section = open(sys.argv[1], encoding="utf-8").read().split("<section>")[int(sys.argv[2])]
for row in re.findall("<tr><td>(.*?)</td></tr>", section):
    print("|".join(re.split("</td><td>", row)))
END
}

@test "the ply book says where to begin, which way to go on, and what shear is where" {
    jq '{surface, length_unit, plies: [{name: "skin", repeat: 2, fabric: (.fabric + {locking_angle_deg: 15}),
            start: {uv: [0.5, 0.4]}},
        {name: "patch", fabric, start: {uv: [0.5, 0.4]}, boundary: {polygon: [[90, 20, 30], [80, 50, 20],
            [60, 60, 30], [80, 20, 40]]}}]}' "$EXAMPLES/octant.json" >"$BATS_TEST_TMPDIR/ball.json"
    out=$BATS_TEST_TMPDIR/ball.html
    "$DRAPE" "$BATS_TEST_TMPDIR/ball.json" --format html --partial -o "$out"
    # Along the weft it is a quarter of a great circle, along the warp the same to both sides.
    grep -oE 'along the warp, [0-9.]+ back and [0-9.]+ ahead, then along the weft, [0-9.]+ back and [0-9.]+' "$out" |
        head -n 1 | awk '{gsub(",", ""); a = $4; b = $7; c = $13 + $16; exit !(a == b && c > 157.07 && c < 157.09)}'
    # Sectors as mirrors, those with the least shear first; each is drawn out away from the start.
    rows "$out" 1 >"$BATS_TEST_TMPDIR/rows"
    cat "$BATS_TEST_TMPDIR/rows"
    [ "$(cut -d'|' -f1 "$BATS_TEST_TMPDIR/rows" | tr '\n' ' ')" = '1 2 3 4 ' ]
    [ "$(cut -d'|' -f4 "$BATS_TEST_TMPDIR/rows" | uniq | wc -l)" = 2 ]
    [ "$(cut -d'|' -f4 "$BATS_TEST_TMPDIR/rows" | sort -g | tr '\n' ' ')" = \
        "$(cut -d'|' -f4 "$BATS_TEST_TMPDIR/rows" | tr '\n' ' ')" ]
    awk -F'|' '{same = $2 == "+warp, +weft" || $2 == "-warp, -weft"
        bad += $6 != (same ? "+warp +weft" : "+warp -weft")} END {exit bad > 0}' "$BATS_TEST_TMPDIR/rows"
    # The cells that lock are those of the drape, and the greatest shear lies on the sphere.
    "$DRAPE" "$BATS_TEST_TMPDIR/ball.json" | jq -e --argjson locked \
        "$(cut -d'|' -f7 "$BATS_TEST_TMPDIR/rows" | paste -sd+ | bc)" \
        '$locked > 20 and .plies[0].locked_cells == $locked'
    cut -d'|' -f5 "$BATS_TEST_TMPDIR/rows" | tr -d ',' |
        awk '{r = sqrt($1 * $1 + $2 * $2 + $3 * $3); bad += r < 99.9 || r > 100.1} END {exit bad > 0}'
    # The patch does not have the start on it.
    grep -q 'Fix it at the middle of its longest line along the warp' "$out"
    write . html
    [ "$(grep -c 'nothing is to be sheared' "$out")" = 2 ]
}

@test "plies cost their share of the roll, and what a material costs a ply of it does" {
    write '.plies[].areal_weight = 0.5 | .plies[].price = 20' html --width 5
    grep -oE 'utilisation [0-9.]+ %|It costs [0-9.]+|<tr><td>[12]</td>.*' "$out" >"$BATS_TEST_TMPDIR/costs"
    cat "$BATS_TEST_TMPDIR/costs"
    # Both plies together have 26 m2.
    awk '/utilisation/ {used = $2} /It costs/ {cost = $3} END {exit !((cost * used / 100 / 520 - 1) ^ 2 < 1e-6)}' \
        "$BATS_TEST_TMPDIR/costs"
    sed -n 's|.*<td>\([0-9.]*\)</td><td>0.0°</td>.*|\1|p' "$BATS_TEST_TMPDIR/costs" | paste -sd' ' |
        awk '{exit !(($1 / $2 - 10 / 16) ^ 2 < 1e-6)}'
    write '.plies[0].fabric += {material: {name: "m", fabric: {thickness: 0.002}, price: 7}}' html
    [ "$(grep -c 'It costs' "$out")" = 1 ]
    refused '/plies/0/price' '.plies[0].price = -1' html
}

@test "the ply book prints as one PDF, a page for each ply" {
    write '.plies[].fabric += {locking_angle_deg: 40}' html
    local chromium=$(command -v chromium chromium-browser | head -n 1)
    timeout 100 "$chromium" --headless --no-sandbox --disable-gpu --no-pdf-header-footer \
        --user-data-dir="$BATS_TEST_TMPDIR/profile" --print-to-pdf="$BATS_TEST_TMPDIR/book.pdf" "file://$out" 2>/dev/null
    # The pages that the tree of pages counts: the sequence, and one for each ply.
    head -c 5 "$BATS_TEST_TMPDIR/book.pdf" | grep -q '%PDF-'
    [ "$(grep -ac '/Type /Page$' "$BATS_TEST_TMPDIR/book.pdf")" = 3 ]
}

@test "CompoST has the edges of plies on the part as splines, broken at their corners" {
    jq '{surface, length_unit, plies: [{name: "skin", fabric, start: {uv: [0.5, 0.4]}},
        {name: "patch", fabric, boundary: {polygon: [[90, 20, 30], [60, 70, 30], [50, 40, 75], [70, 15, 70]]}},
        {name: "frame", fabric, boundary: {polygons: [[[90, 20, 30], [60, 70, 30], [50, 40, 75]],
            [[80, 40, 40], [70, 50, 40], [70, 45, 50]]]}}]}' "$EXAMPLES/octant.json" >"$BATS_TEST_TMPDIR/ball.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/ball.json" --bundle --partial -o "$BATS_TEST_TMPDIR/ball.zip" 2>/dev/null
    unzip -p "$BATS_TEST_TMPDIR/ball.zip" decks/compost.json >"$BATS_TEST_TMPDIR/compost.json"
    # The edge of a ply with a hole is no one spline.
    jq -e '[.allGeometry[] | [.memberName, (.breaks | length)]] == [["skin", 3], ["patch", 4]] and
        [.allComposite[0].subComponents[] | .splineRelimitationRef] ==
            [.allGeometry[0].ID, .allGeometry[1].ID, null] and
        all(.allGeometry[].points; .[0] == .[-1] and
            all(.[]; (.x * .x + .y * .y + .z * .z | sqrt) - 100 | fabs < 1e-9))' "$BATS_TEST_TMPDIR/compost.json"
    # Corners of the boundary are breaks.
    jq -e '.allGeometry[1] | [.points[.breaks[]] | [.x, .y, .z]] | length == 4 and
        all(.[]; . as $p | any([90, 20, 30], [60, 70, 30], [50, 40, 75], [70, 15, 70];
            . as $q | ([0, 1, 2] | map($p[.] * $q[.]) | add) /
                (([0, 1, 2] | map($q[.] * $q[.]) | add | sqrt) * 100) > 1 - 1e-5))' "$BATS_TEST_TMPDIR/compost.json"
}
