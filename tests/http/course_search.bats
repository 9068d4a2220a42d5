# SPDX-License-Identifier: MIT
# Studies that vary the courses of a ply (docs/studies.md), on a plane of 4 by 3 along its edge of 4.
bats_require_minimum_version 1.5.0
load helper

setup_file() {
    jq -nc '{drape: {surface: {degree_u: 1, degree_v: 1, size_u: 2, size_v: 2, knotvector_u: [0, 0, 1, 1],
            knotvector_v: [0, 0, 1, 1], control_points: [[0, 0, 0], [0, 3, 0], [4, 0, 0], [4, 3, 0]]},
            fabric: {spacing: 0.1}}, courses: {width: 0.8, along: {edge: [2, 0, 0]}},
        vary: {courses: {offsets: {from: -0.2, to: 0}}}, objectives: ["waste_area"], budget: 145}' \
        >"$BATS_FILE_TMPDIR/plane.json"
    start_shared_daemon
}
teardown_file() { end_file; }

# search EXPRESSION: the study changed so, in study.json; its result in found.json, its best laid in laid.json.
search() {
    DRAPE=$(realpath "$DRAPE")
    jq -c --slurpfile blade tests/validation/blade.json "$1" "$BATS_FILE_TMPDIR/plane.json" >"$BATS_TEST_TMPDIR/study.json"
    cd "$BATS_TEST_TMPDIR"
    "$DRAPE" study.json -o found.json >/dev/null 2>&1
    "$DRAPE" --variant best study.json >best.json 2>/dev/null
    "$DRAPE" best.json >laid.json 2>/dev/null
}

# found EXPRESSION: of the best variant (b) and of the courses that were laid (c).
found() {
    jq -e --slurpfile laid laid.json '.best[] as $row | (.variants | map_values(.[$row])) as $b |
        $laid[0].plies[0].courses as $c | '"$1" found.json >/dev/null || { jq -c '.best, .summary.verdict' found.json laid.json; return 1; }
}

@test "four courses of 0.8 overlap by 0.2 / 3 where nothing of them is wasted" {
    search '.budget = 305'
    # waste(g) = 4 (3.2 + 3 g - 3): the least is that of the last course ending at the edge. Chance finds 0.003.
    found '$b.waste_area < 0.001 and $b.feasible == 1 and $b.cloth_coverage > 0.999'
    jq -e '.plies[0].courses.gap[0][0] + 0.2 / 3 | fabs < 0.002' best.json
    # The figures of a variant are those of its laminate, to the last bit.
    found '$c.trim_area == $b.waste_area and $c.cloth_coverage == $b.cloth_coverage'
    # Variant 0 is the study's own: 3.2 of 3 are laid.
    jq -e '.variants | (.waste_area[0] - 0.8 | fabs < 1e-6) and .coarseness[0] == 1' found.json
}

@test "of the widths there are the one that fits is found" {
    search '.vary.courses = {width: [0.7, 0.75, 0.9]}'
    found '($b.waste_area | fabs < 1e-6) and $c.count == 4'
    jq -e '.plies[0].courses.width | unique == [0.75]' best.json
    jq -e '.courses | [.width, .variant] | transpose | map(.[0]) | unique == [0.7, 0.75, 0.9]' found.json
}

@test "a gap that may be 0.02 wide is used, and no more" {
    search '.objectives = ["waste_area"] | .courses.width = 0.74 | .vary.courses.offsets = {from: 0, to: 0.1} |
        .limits = {gap_width: {max: 0.02}}'
    # Four courses and three gaps g are 2.96 + 3 g wide, all of the part where g = 0.04 / 3.
    found '$b.gap_width <= 0.02 and $b.gap_width > 0.012 and $b.waste_area < 0.05 and $b.laid_coverage > 0.999 and
        (($b.laid_coverage - $b.cloth_coverage) * 12 - $c.gap_area | fabs < 1e-9)'
}

@test "distances between courses that vary turn them towards the wanted direction" {
    # Courses from an edge at 1 in 40 to the direction that is wanted: a distance that grows by as much turns all.
    search '.courses.most = 3 | .courses.width = 0.5 | .wanted_direction = [40, 1, 0] | .objectives = ["angle_deviation_max_deg"] |
        .limits = {laid_coverage: {min: 0.3}} | .vary.courses = {first_offset: {from: 0, to: 0.2, points: 2}} | .budget = 305'
    jq -e '.variants.angle_deviation_max_deg[0] - 1.4320962 | fabs < 1e-6' found.json # atan(1 / 40)
    found '$b.angle_deviation_max_deg < 0.1'
    jq -e '.plies[0].courses.first_offset | length == 2 and (.[1] - .[0] - 0.1 | fabs < 0.01)' best.json
}

@test "the norm of deviations grows from their mean towards the greatest" {
    local norm
    for norm in 1 4 64; do
        (
            search ".drape = (\$blade[0] | {surface, length_unit, fabric: {spacing: 0.1}}) |
                .courses = {width: 0.4, along: {edge: [0.6801, 2, -0.7458]}} | .wanted_direction = [0, 1, 0] |
                .objectives = [\"angle_deviation_deg\"] | .budget = 45 | .deviation_norm = $norm |
                .limits = {laid_coverage: {min: 0.9}, angle_deviation_max_deg: {max: 90}} |
                .vary.courses = {offsets: {from: -0.05, to: 0}}"
            jq '.variants | .angle_deviation_deg[0], .angle_deviation_max_deg[0]' found.json >"norm_$norm"
        )
    done
    cd "$BATS_TEST_TMPDIR"
    jq -es '. as [$mean, $most, $four, $_, $high] | $mean > 0.1 and $mean < 0.9 * $four and $four < $high and
        $high > 0.8 * $most and $high < $most' norm_1 norm_4 norm_64
}

@test "a study of courses has the same bits on any number of threads, and over HTTP" {
    search '.budget = 85'
    "$DRAPE" --threads 3 study.json -o other.json >/dev/null 2>&1
    for file in found other; do jq -S 'del(.summary.timing_ms, .id)' "$file.json" >"$file.txt"; done
    cmp found.txt other.txt
    post /v1/studies study.json -H 'Prefer: wait=60' && expect 200
    id=$(field .id)
    call GET "/v1/studies/$id/result" && expect 200
    jq -S 'del(.summary.timing_ms, .id)' "$body" | cmp - found.txt
    call GET "/v1/studies/$id/result?format=csv&table=courses" && expect 200
    [ "$(head -1 "$body" | tr -d '\r')" = variant,course,point,distance,width,origin ]
    row=$(jq .best.waste_area found.json)
    call GET "/v1/studies/$id/variants/$row/request" && expect 200
    jq -S . best.json | cmp - <(jq -S . "$body")
    cp "$body" layer.json
    post /v1/laminates layer.json -H 'Prefer: wait=40' && expect 200
    call GET "/v1/studies/$id/result?sample=$row" && expect 406
    [[ $(field .detail) == *'is a laminate'* ]]
    # What was understood is the same study.
    call GET "/v1/studies/$id/request" && expect 200
    cp "$body" understood.json
    [ "$(field '[.vary.courses.count, .budget, .limits.laid_coverage.min, .courses.width[0]] | tojson')" = '[1,85,0.999,0.8]' ]
    post /v1/studies understood.json -H 'Prefer: wait=60' && expect 200
    call GET "/v1/studies/$(field .id)/request" && expect 200
    cmp understood.json "$body"
}

# refused EXPRESSION POINTER WORDS
refused() {
    jq -c "$1" "$BATS_FILE_TMPDIR/plane.json" >"$BATS_TEST_TMPDIR/refused.json"
    post /v1/studies "$BATS_TEST_TMPDIR/refused.json" && expect 422
    jq -e --arg pointer "$2" --arg words "$3" 'any(.errors[]; .pointer == $pointer and (.detail | contains($words)))' \
        "$body" >/dev/null || { cat "$body"; return 1; }
}

@test "what cannot be varied of courses is refused where it is said" {
    refused 'del(.courses)' /courses 'the courses of a ply'
    refused '.vary = {angle_deg: [0, 10]}' /vary/courses 'is required with "courses"'
    refused '.vary.angle_deg = [0, 10]' /vary/courses 'must be alone'
    refused '.vary.courses = {}' /vary/courses 'has nothing to vary'
    refused '.vary.courses = {count: 4}' /vary/courses 'has nothing to vary'
    refused '.vary.courses.gap = 1' /vary/courses/gap ''
    refused '.vary.courses.count = 33' /vary/courses/count ''
    refused '.vary.courses = {count: 30, offsets: {from: 0, to: 1, points: 2}}' /vary/courses '58 values to vary, and 56 are allowed'
    refused '.vary.courses.offsets.to = -0.3' /vary/courses/offsets/to 'must not be less'
    refused '.vary.courses.offsets.from = -0.8' /vary/courses/offsets/from 'by its whole width'
    refused '.vary.courses.offsets.points = 17' /vary/courses/offsets/points ''
    refused '.vary.courses.origin = {from: 0, to: 1, points: 2}' /vary/courses/origin/points 'must be left out'
    refused '.vary.courses.origin = {from: 0, to: 2}' /vary/courses/origin/to ''
    refused '.vary.courses.width = [0.8, 0]' /vary/courses/width/1 ''
    refused '.vary.courses.width = {from: 1, to: 9}' /courses/width 'is wider than the part'
    refused '.vary.courses.first_offset = {from: 0, to: 9}' /courses/first_offset 'must be less than'
    refused '.courses.wanted_direction = [1, 0, 0]' /courses/wanted_direction 'that of the study'
    refused '.courses.stagger = 0.1' /courses/stagger 'one ply'
    refused '.courses.most = 0' /courses/most ''
    refused '.courses.along = {path: [[0, 1, 0], [4, 1, 0], [0, 1, 0]]}' /courses/along/path 'crosses itself'
    refused '.drape.cuts = [{path: [[0, 1, 0], [1, 1, 0]]}]' /drape/cuts 'must be left out'
    refused '.objectives = ["waste_area", "max_shear_deg"]' /objectives 'must have one alone'
    refused '.objectives = ["p95_shear_deg"]' /courses 'which is not known of courses'
    refused '.objectives = ["angle_deviation_max_deg"]' /wanted_direction 'is required'
    refused 'del(.courses, .vary.courses) | .vary.angle_deg = [0, 1] | .limits = {gap_width: {max: 1}}' /courses 'is required for gap_width'
    refused '.search = "optimise"' /search 'must be left out'
    refused '.budget = 30' /budget 'at least 45'
    refused '.deviation_norm = 0.5' /deviation_norm ''
}
