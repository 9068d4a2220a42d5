# SPDX-License-Identifier: MIT
# Studies that propose cuts (docs/studies.md), on a box whose edges are rounded: its net locks at the
# four upright edges and leaves them bare.
load helper

BOX=$BATS_FILE_TMPDIR/box.json

setup_file() {
    python3 "$BATS_TEST_DIRNAME/rounded_box.py" 200 150 60 10 | jq -c '.fabric.spacing = 4' >"$BATS_FILE_TMPDIR/box.json"
    jq '{drape: ., vary: {splits: "proposed"}, budget: 70}' "$BATS_FILE_TMPDIR/box.json" >"$BATS_FILE_TMPDIR/study.json"
    start_shared_daemon
}
teardown_file() { end_file; }

@test "four cuts at the corners of a box bring it to full coverage within the locking angle" {
    "$DRAPE" "$BOX" 2>/dev/null | jq -e '.summary | .cloth_coverage < 0.999 and .max_shear_deg > 80'
    "$DRAPE" "$BATS_FILE_TMPDIR/study.json" -o "$BATS_TEST_TMPDIR/study.json"
    "$DRAPE" --variant best "$BATS_FILE_TMPDIR/study.json" >"$BATS_TEST_TMPDIR/best.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/best.json" >"$BATS_TEST_TMPDIR/drape.json" 2>/dev/null
    python3 - "$BATS_TEST_TMPDIR" <<'PYTHON'
import json, math, sys
study, best, drape = (json.load(open(f"{sys.argv[1]}/{n}.json")) for n in ("study", "best", "drape"))
row, v = study["best"]["cut_length"], study["variants"]
s = drape["summary"]
assert s["outcome"] == "complete" and s["cloth_coverage"] >= 0.999 and s["max_shear_deg"] <= 50, s
assert v["max_shear_deg"][row] == s["max_shear_deg"] and v["cloth_coverage"][row] == s["cloth_coverage"]
assert abs(sum(drape["cuts"]["length"]) - v["cut_length"][row]) < 1e-9
# The best is the shortest that keeps the limits, a twentieth shorter than what the nets ask for.
kept = [n for n, k in zip(v["cut_length"], v["feasible"]) if k]
assert min(kept) == v["cut_length"][row] < 0.95 * kept[0], kept
# One cut at each corner, from its foot up the rounded edge, 50 high, to near the eighth of a sphere.
corners = set()
for cut in best["cuts"]:
    (x, y, z), (tx, ty, tz) = cut["path"][0], cut["path"][-1]
    corners.add((x > 0, y > 0))
    assert abs(z) < 1e-6 and abs(math.hypot(abs(x) - 90, abs(y) - 65) - 10) < 0.05 and abs(x) > 90 and abs(y) > 65, cut
    assert abs(tx) > 85 and abs(ty) > 60 and 35 < tz < 58, cut
assert len(best["cuts"]) == 4 == len(corners)
# The angle between the yarns, from the places of the nodes alone: off the rounded edges these are
# straight from node to node; there the chords differ by a few degrees.
nodes = drape["nodes"]
at = {(i, j): (x, y, z) for i, j, x, y, z in zip(*(nodes[k] for k in "ijxyz"))}
def angle(a, b, c):
    u, w = ([q - p for p, q in zip(at[a], at[k])] for k in (b, c))
    return math.degrees(math.acos(sum(p * q for p, q in zip(u, w)) / math.hypot(*u) / math.hypot(*w)))
cells = list(zip(drape["cells"]["i"], drape["cells"]["j"]))
shears = [abs(90 - angle((i, j), (i + 1, j), (i, j + 1))) for i, j in cells]
assert 20 < max(shears) < 50 + 6, max(shears)
# Every place of the rounded upright edges is under a cell or within a spacing of a node or lip.
rim = drape["rim"]
known = list(at.values()) + [p for *p, c in zip(rim["x"], rim["y"], rim["z"], rim["covered"]) if c]
for sx in (1, -1):
    for sy in (1, -1):
        for z in range(0, 51, 5):
            for turn in range(0, 91, 15):
                p = (sx * (90 + 10 * math.cos(math.radians(turn))), sy * (65 + 10 * math.sin(math.radians(turn))), z)
                assert min(math.dist(p, k) for k in known) < 5, p
PYTHON
}

@test "the table proposed has the cuts, and over HTTP the study and its variants are the same" {
    post /v1/studies "$BATS_FILE_TMPDIR/study.json" -H 'Prefer: wait=60'
    local id=$(header Location)
    id=${id##*/}
    while call GET "/v1/studies/$id?wait=30" && [ "$(field .status)" = running ]; do :; done
    [ "$(field .status)" = succeeded ]
    [ "$(field '.variants | "\(.done) \(.total)"')" = "70 70" ]
    for table in variants proposed; do
        call GET "/v1/studies/$id/result?format=csv&table=$table" && expect 200
        "$DRAPE" "$BATS_FILE_TMPDIR/study.json" --format csv --table $table 2>/dev/null | cmp - "$body"
    done
    head -1 "$body" | grep -qx 'variant,cut,mouth_x,mouth_y,mouth_z,tip_x,tip_y,tip_z'
    call GET "/v1/studies/$id/variants/3/request" && expect 200
    "$DRAPE" --variant 3 "$BATS_FILE_TMPDIR/study.json" | jq -S . >"$BATS_TEST_TMPDIR/own.json"
    jq -S . "$body" | diff "$BATS_TEST_TMPDIR/own.json" -
    field '.cuts | map(.name) == ["proposed_1", "proposed_2", "proposed_3", "proposed_4"]'
    call GET "/v1/studies/$id/request" && expect 200
    field '.vary == {splits: {proposed: 8}} and .budget == 70 and .objectives == ["cut_length"]
        and .limits.max_shear_deg.max == 50 and .limits.cloth_coverage.min == 0.999'
}

@test "a drape that keeps the limits needs no cut; cuts that it has stay" {
    jq '{drape: (.start.point = [33, 27, 0] | .cuts = [{path: [[0, 0, -60], [0, 0, 0]], name: "own", allowance: 2}]),
        vary: {splits: {proposed: 2}}}' "$EXAMPLES/corner.json" >"$BATS_TEST_TMPDIR/study.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/study.json" -o "$BATS_TEST_TMPDIR/out.json"
    jq -e '.best.cut_length == 0 and (.variants.cut_length | length == 1 and (.[0] - 60 | fabs) < 0.01)
        and .proposed.variant == []' "$BATS_TEST_TMPDIR/out.json"
    "$DRAPE" --variant 0 "$BATS_TEST_TMPDIR/study.json" | jq -e '.cuts == [{name: "own", path: [[0, 0, -60], [0, 0, 0]], allowance: 2}]
        or (.cuts | length == 1 and .[0].name == "own" and .[0].allowance == 2)'
    # Without it the corner is found; no more cuts than are asked for.
    jq '.drape.cuts = [] | .vary.splits.proposed = 1' "$BATS_TEST_TMPDIR/study.json" >"$BATS_TEST_TMPDIR/one.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/one.json" -o "$BATS_TEST_TMPDIR/out.json"
    jq -e '.summary.verdict.drapable and (.proposed.cut | max) == 1
        and .variants.max_shear_deg[.best.cut_length] <= 45' "$BATS_TEST_TMPDIR/out.json"
}

@test "a variant whose cut cannot be made says so" {
    jq '{drape: (.cuts = [{path: [[90, 40, 0], [40, 40, 0]]}]), vary: {start: {points: [[60, 40, 0], [33, 20, 0]]}},
        objectives: ["max_shear_deg", "cut_length"]}' "$EXAMPLES/corner.json" >"$BATS_TEST_TMPDIR/study.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/study.json" -o "$BATS_TEST_TMPDIR/out.json" 2>/dev/null
    jq -e '.variants | .failure == ["cut", "none"] and .cut_length[0] == null and (.cut_length[1] - 50 | fabs) < 0.01' \
        "$BATS_TEST_TMPDIR/out.json"
}

# dome LIMIT BUDGET: a study of the dome on its flange, whose edges are its four straight sides.
dome() {
    jq -nc --arg file "$PWD/api/examples/dome.step" --argjson limit "$1" --argjson budget "$2" \
        '{drape: {surface: {$file, grow_from: 6, up_to_deg: 20}, fabric: {spacing: 4, locking_angle_deg: $limit}},
          vary: {splits: "proposed"}, $budget}' >"$BATS_TEST_TMPDIR/dome.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/dome.json" -o "$BATS_TEST_TMPDIR/dome.out" 2>/dev/null
}

@test "ridges that end before an edge are cut from where they lead: the corners of a flange" {
    dome 40 28
    jq -e '.best.cut_length as $row | .summary.verdict.drapable and .variants.max_shear_deg[$row] <= 40 and
        .variants.cloth_coverage[$row] >= 0.999 and (.proposed as $p |
        [range($p.variant | length) | select($p.variant[.] == $row) |
            [($p.mouth_x[.], $p.mouth_y[.] | fabs | . - 100 | fabs < 1e-6), $p.tip_z[.] > 20]] |
        length == 4 and all(all))' "$BATS_TEST_TMPDIR/dome.out"
}

@test "a search that finds no cuts ends, and says what it tried" {
    dome 12 24
    jq -e '.summary | .verdict.drapable | not' "$BATS_TEST_TMPDIR/dome.out"
    jq -r .summary.verdict.detail "$BATS_TEST_TMPDIR/dome.out" |
        grep -qE '24 nets with up to [4-8] cuts were tried, so divide the ply there'
}
