# SPDX-License-Identifier: MIT
# Fabrics that slide, in all that is made of a drape: thickness and fibres, patterns, laminates,
# studies and cuts, on the free-form part, all of which they cover.
load helper

# slide KINEMATICS: the free-form part as a request with this fabric.
slide() {
    jq --argjson kinematics "$1" '.fabric = {spacing: 10, thickness: 0.5, fiber_volume_fraction: 0.5,
        kinematics: $kinematics}' api/examples/freeform.json
}

@test "slides: cloth has the area of the part, and its thickness and fibres are those of the pattern" {
    for kinematics in '"pin_jointed"' '{"slide": 0.5}' '"parallel_fibers"'; do
        slide "$kinematics" | "$DRAPE" - 2>/dev/null >"$BATS_TEST_TMPDIR/out"
        jq -e --argjson kinematics "$kinematics" '
            ($kinematics | if type == "object" then .slide elif . == "pin_jointed" then 0 else 1 end) as $c |
            def near($x; $y): ($x / $y - 1 | fabs) < 1e-9;
            .summary.cloth_coverage == 1 and
            (.summary | .cloth_area / .part_area - 1 | fabs) < 2e-4 and
            near(.summary.fiber_volume; 0.25 * .summary.flat_area) and
            ([.cells.shear_deg, .cells.thickness] | transpose | all(
                near(.[1]; 0.5 * pow(.[0] * 3.141592653589793 / 180 | cos; $c - 1)))) and
            ($c < 1 or near(.summary.cloth_area; .summary.flat_area))' "$BATS_TEST_TMPDIR/out"
    done
}

@test "slides: patterns, laminates and studies are of the net that slides" {
    slide '"parallel_fibers"' >"$BATS_TEST_TMPDIR/request.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/request.json" 2>/dev/null >"$BATS_TEST_TMPDIR/out"
    area=$(jq '.summary.flat_area | round' "$BATS_TEST_TMPDIR/out")
    "$DRAPE" --format svg "$BATS_TEST_TMPDIR/request.json" 2>/dev/null | grep -q "area $area mm2"
    most=$(jq .summary.max_shear_deg "$BATS_TEST_TMPDIR/out")
    jq '{drape: ., vary: {angle_deg: [.direction.angle_deg // 0]}, objectives: ["max_shear_deg"]}' \
        "$BATS_TEST_TMPDIR/request.json" | "$DRAPE" - 2>/dev/null |
        jq -e --argjson most "$most" '.variants.max_shear_deg[0] - $most | fabs < 1e-9'
    jq '{surface, length_unit, plies: [{fabric, start, direction}]}' \
        "$BATS_TEST_TMPDIR/request.json" | "$DRAPE" - 2>/dev/null |
        jq -e --argjson most "$most" '.plies[0].max_shear_deg - $most | fabs < 1e-9'
}

@test "slides: flat cloth is flat beside a dart, whatever slides" {
    jq '.fabric.kinematics = "parallel_fibers" |
        .cuts = [{path: [[0, 0, -60], [0, 0, 0]], name: "edge"}]' api/examples/corner.json |
        "$DRAPE" - 2>/dev/null | jq -e '.summary | .cloth_coverage == 1 and .max_shear_deg < 1e-6'
}
