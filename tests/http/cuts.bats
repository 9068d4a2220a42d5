# SPDX-License-Identifier: MIT
# Cuts (docs/pieces.md): their table, warnings and refusals, in drapes, plies and studies. On the
# corner of a box, three planes of 90, 80 and 60, cut along the edge of 60: a dart of 90 degrees.
load helper

CORNER=$BATS_FILE_TMPDIR/dart.json

setup_file() {
    jq '.direction.vector = [1, 0.3, 0] | .cuts = [{path: [[0, 0, -60], [0, 0, 0]], name: "corner"}]' \
        "$EXAMPLES/corner.json" >"$BATS_FILE_TMPDIR/dart.json"
    start_shared_daemon
}
teardown_file() { end_file; }

# corner EXPRESSION: the request changed by jq, in a file.
corner() {
    jq -c "$1" "$CORNER" >"$BATS_TEST_TMPDIR/corner.json"
    echo "$BATS_TEST_TMPDIR/corner.json"
}

# refused EXPRESSION POINTER WORDS: the request changed so is a 422 there.
refused() {
    post /v1/drapes "$(corner "$1")" -H 'Prefer: wait=30'
    [ "$status" = 422 ] || { call GET "/v1/drapes/$(field .id)"; }
    jq -e --arg pointer "$2" --arg words "$3" '(.error // .).errors as $errors
        | any($errors[]; .pointer == $pointer and (.detail | contains($words)))' "$body" >/dev/null ||
        { cat "$body"; return 1; }
}

@test "a corner with a dart is flat: 90 degrees at the tip, and the wedge is half the square of the cut" {
    "$DRAPE" "$CORNER" >"$BATS_TEST_TMPDIR/out.json" 2>/dev/null
    jq -e '.summary.cloth_coverage == 1 and .summary.max_shear_deg < 1e-4 and .summary.warnings == []
        and (.cuts | .name == ["corner"] and .allowance == [0] and (.length[0] - 60 | fabs) < 0.01
            and (.tip_angle_deg[0] - 90 | fabs) < 1e-6 and (.mouth_width[0] - 60 * (2 | sqrt) | fabs) < 1e-4
            and (.area[0] - 1800 | fabs) < 1e-2)' "$BATS_TEST_TMPDIR/out.json"
    # The rim has both lips, one behind the other, each over the same line of the part.
    jq -e '.rim as $r | [range($r.cut | length) | select($r.cut[.] != 0)] | map($r.cut[.]) as $lips
        | ($lips | unique == [-1, 1]) and (($lips | index(-1)) == ($lips | map(select(. == 1)) | length))
        and all(.[]; $r.x[.] < 1e-5 and $r.y[.] < 1e-5 and $r.covered[.] == 1)' "$BATS_TEST_TMPDIR/out.json"
}

@test "the table cuts is there as csv, and not without cuts" {
    "$DRAPE" "$(corner '.cuts[0] |= (.name = "a \"b\", c" | .allowance = 3)')" --format csv --table cuts \
        >"$BATS_TEST_TMPDIR/out.csv" 2>/dev/null
    python3 - "$BATS_TEST_TMPDIR/out.csv" <<'PYTHON'
import csv, sys
rows = list(csv.DictReader(open(sys.argv[1])))
assert [r["name"] for r in rows] == ['a "b", c'] and float(rows[0]["allowance"]) == 3, rows
assert abs(float(rows[0]["tip_angle_deg"]) - 90) < 1e-6, rows
PYTHON
    not "$DRAPE" "$(corner 'del(.cuts)')" --format csv --table cuts 2>"$BATS_TEST_TMPDIR/err"
    grep -q 'with cuts the table cuts' "$BATS_TEST_TMPDIR/err"
    "$DRAPE" "$(corner 'del(.cuts)')" 2>/dev/null | jq -e 'has("cuts") | not'
}

@test "a cut in a saddle opens, and a warning says where and how wide; one in a plane does not" {
    jq '.cuts = [{path: [2, 1.6, 1.3, 1] | map([0.35, ., (0.35 * 0.35 - . * .) / 2])}]' "$EXAMPLES/saddle.json" |
        "$DRAPE" - 2>/dev/null >"$BATS_TEST_TMPDIR/out.json"
    jq -e '.cuts as $c | .summary.warnings | map(select(.code == "cut_opens")) | length == 1 and .[0].pointer == "/cuts/0"
        and (.[0].detail | contains("at (0.35002, 2, -1.9387)") and contains("overlap by 0.0879 m"))
        and ($c.mouth_width[0] + 0.0879 | fabs) < 1e-4 and $c.area[0] < -0.059' "$BATS_TEST_TMPDIR/out.json"
    "$DRAPE" "$(corner '.cuts = [{path: [[90, 40, 0], [60, 41, 0]]}]')" 2>/dev/null |
        jq -e '.cuts.name == ["cut_1"] and (.cuts.area[0] | fabs) < 1e-3 and all(.summary.warnings[]; .code != "cut_opens")'
}

@test "a net of few cells that ends within the part leaves some of it bare" {
    # Its cells seem to be 0.995 of the part. Where the net ends a quarter of a cell is bare at the least.
    jq '.fabric.spacing = 16 | .method = "basic"' "$EXAMPLES/corner.json" | "$DRAPE" - 2>/dev/null |
        jq -e '.summary | .outcome == "partial" and (.front_reasons | .collapsed + .no_convergence) as $ends | $ends > 0 and
            .cloth_coverage > 0.97 and .cloth_coverage < 1 - 0.2499 * $ends * 16 * 16 / .part_area'
}

@test "the request of a drape has its cuts, with names and allowances" {
    post /v1/drapes "$(corner '.cuts += [{path: [[90, 40, 0], [60, 41, 0]], allowance: 4}]')" -H 'Prefer: wait=30'
    local id=$(field .id)
    call GET "/v1/drapes/$id/request" && expect 200
    field '.cuts | map(.name) == ["corner", "cut_2"] and .[1].allowance == 4 and .[1].path[1] == [60, 41, 0]'
    call GET "/v1/drapes/$id/result?table=cuts&format=csv" && expect 200
    [ "$(wc -l <"$body")" -eq 3 ]
}

@test "what is wrong with a cut is said at its place" {
    refused '.cuts[0].path = [[200, 0, 0], [3, 3, 0]]' /cuts/0/path/0 'further from the part than a spacing'
    refused '.cuts += [{path: [[90, 40, 0], [60, 41, 0], [60, 41, 50]]}]' /cuts/1/path/2 'move its path onto the part'
    refused '.cuts[0].path = [[60, 60, 0], [40, 60, 0]]' /cuts/0/path/0 'begins inside the part'
    refused '.cuts[0].path = [[90, 50, 0], [40, 80, 0]]' /cuts/0/path/1 'divides the part'
    refused '.cuts[0].path = [[90, 27, 0], [20, 27, 0]]' /cuts/0 'passes the start'
    refused '.cuts = [{path: [[90, 40, 0], [60, 40, 0]]}, {path: [[80, 80, 0], [80, 20, 0]]}]' /cuts/1 'crosses another cut'
    refused '.cuts[0].path = [[90, 40, 0], [60, 40, 0], [60, 60, 0], [70, 60, 0], [70, 30, 0]]' /cuts/0 'crosses itself'
    [ "$status" = 422 ] # before anything is draped
    refused '.cuts[0].path = [[90, 40, 0], [89, 40, 0]]' /cuts/0 'shorter than a spacing'
    refused '.generators = {warp: "least_energy"} | .cuts[0].path[0] = [200, 0, 0]' /cuts/0/path/0 'further from the part'
    refused '.cuts[0].path = [[90, 40, 0]]' /cuts/0/path ''
    refused '.cuts[0].path[1] = .cuts[0].path[0]' /cuts/0/path/1 'same point'
    refused '.cuts[0].name = ""' /cuts/0/name '1 to 40'
    refused '.cuts[0].name = "\u00e9"' /cuts/0/name 'ASCII'
    refused '.cuts[0].allowance = -1' /cuts/0/allowance ''
    refused '.cuts[0].tip = 1' /cuts/0/tip ''
    refused '.cuts = {}' /cuts ''
    refused '.cuts = [range(65) | {path: [[90, ., 0], [60, ., 0]]}]' /cuts 'at most 64'
}

# drawn FILE EXPRESSION: Python over loops ({id: polygons or lines of an SVG}), area(points) in mm².
drawn() {
    python3 - "$1" "$2" <<'PYTHON'
import math, re, sys
loops = {}
for name, d in re.findall(r'<path id="([^"]*)"[^>]* d="([^"]*)"', open(sys.argv[1]).read()):
    numbers = [[float(n) for n in re.findall(r"-?[0-9.]+(?:e-?\d+)?", part)] for part in d.split("M")[1:]]
    loops[name] = [list(zip(n[::2], n[1::2])) for n in numbers]
def area(points):
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(points, points[1:] + points[:1])) / 2
def within(a, b, most):
    return abs(a - b) < most or sys.exit(f"{a} is not {b}")
assert eval(sys.argv[2]), {k: v for k, v in loops.items() if k != "grain"}
PYTHON
}

@test "the pattern has the wedge in its outline, and notches that meet when it is closed" {
    local out=$BATS_TEST_TMPDIR/out.svg
    "$DRAPE" "$CORNER" --format svg -o "$out" 2>/dev/null
    not grep -q 'crosses itself\|id="allowance"' "$out"
    # The walls of a corner, flat: 150 x 140 without 60 x 60. Of the two walls' notches three pairs.
    drawn "$out" 'len(loops["cut"]) == 1 and within(area(loops["cut"][0]), 150 * 140 - 60 * 60, 0.1)'
    drawn "$out" '(lambda tip: within(0, sum(abs(a - b) for a, b in zip(
        sorted(d for d in (math.dist(n[0], tip) for n in loops["notches"]) if min(abs(d - q) for q in (15, 30, 45)) < 0.05),
        (15, 15, 30, 30, 45, 45))), 0.1))(min(loops["cut"][0], key=lambda p: abs(math.hypot(p[0], p[1]) - math.hypot(33, 27))))'
    [ "$("$DRAPE" "$CORNER" --format dxf 2>/dev/null | grep -c '^NOTCH')" -gt 8 ]
}

@test "a pattern's allowance is outside the edge, that of a cut along its lips" {
    local out=$BATS_TEST_TMPDIR/out.svg
    # 460 of edge and three corners; the lips are 120.
    "$DRAPE" "$CORNER" --format svg --allowance 8 -o "$out" 2>/dev/null
    drawn "$out" 'within(area(loops["allowance"][0]), 17400 + 460 * 8 + 0.75 * math.pi * 64, 1)'
    "$DRAPE" "$(corner '.cuts[0].allowance = 5')" --format svg -o "$out" 2>/dev/null
    drawn "$out" 'within(area(loops["allowance"][0]), 17400 + 120 * 5 - 25, 1)'
    "$DRAPE" "$(corner '.cuts += [{path: [[90, 20, 0], [62, 25, 0]], allowance: 1}]')" --format svg -o "$out" 2>/dev/null
    grep -q '<title>1 of the cuts too narrow for an allowance. ' "$out"
    not grep -q 'id="allowance"' "$out"
    jq '.cuts = [{path: [2, 1.6, 1.3, 1] | map([0.35, ., (0.35 * 0.35 - . * .) / 2])}]' "$EXAMPLES/saddle.json" |
        "$DRAPE" - --format svg -o "$out" 2>/dev/null
    grep -q '<title>The outline crosses itself. ' "$out"
}

@test "plies and studies have cuts as drapes do" {
    jq -c '{surface, length_unit, plies: [{fabric, start, direction, cuts},
        {fabric, start, direction, cuts: (.cuts + [{path: [[90, 50, 0], [70, 50, 0]], name: "slit"}])}]}' "$CORNER" \
        >"$BATS_TEST_TMPDIR/stack.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/stack.json" -H 'Prefer: wait=30'
    local id=$(field .id) ply
    ply=$(field '.plies[1].drape // .plies[1].id')
    call GET "/v1/drapes/$ply/result" && expect 200
    field '.cuts.name == ["corner", "slit"] and (.cuts.tip_angle_deg[0] - 90 | fabs) < 1e-6'
    jq -c '.plies[1].cuts[1].path[0] = [300, 0, 0]' "$BATS_TEST_TMPDIR/stack.json" >"$BATS_TEST_TMPDIR/bad.json"
    post /v1/laminates "$BATS_TEST_TMPDIR/bad.json" -H 'Prefer: wait=30'
    grep -q '/plies/1/cuts/1/path/0\|/cuts/1/path/0' "$body"
    jq -c '{drape: ., vary: {angle_deg: {from: 0, to: 60, step: 30}}, objectives: ["max_shear_deg"]}' "$CORNER" |
        "$DRAPE" - 2>/dev/null |
        jq -e '.variants.max_shear_deg | length == 3 and max < 1e-3'
}
