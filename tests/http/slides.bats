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

# bits FABRIC FILE: all that a request of the file with this fabric gives, but for its time.
bits() {
    jq --argjson more "$1" '.fabric += $more' "$2" | "$DRAPE" - 2>/dev/null | jq 'del(.. | .timing_ms?)'
}

@test "slides: a slide of 0 is the weave, to the last bit, by every method, on a patch, faces and triangles" {
    jq '.fabric = {spacing: 10, thickness: 0.5}' api/examples/freeform.json >"$BATS_TEST_TMPDIR/patch.json"
    jq 'del(.permeability) | .fabric = {spacing: 8}' api/examples/corner.json >"$BATS_TEST_TMPDIR/faces.json"
    jq . tests/requests/triangles_from_corner.json >"$BATS_TEST_TMPDIR/triangles.json"
    for part in patch faces triangles; do
        for method in basic gib gib4 geodesic mosaic; do
            [ $part$method != trianglesgib4 ] || continue
            jq --arg method $method '.method = $method' "$BATS_TEST_TMPDIR/$part.json" \
                >"$BATS_TEST_TMPDIR/request.json"
            bits '{}' "$BATS_TEST_TMPDIR/request.json" >"$BATS_TEST_TMPDIR/weave"
            jq -e '.nodes.x | length > 20' "$BATS_TEST_TMPDIR/weave"
            for kinematics in '{"slide": 0}' '"pin_jointed"'; do
                bits "{\"kinematics\": $kinematics}" "$BATS_TEST_TMPDIR/request.json" |
                    cmp - "$BATS_TEST_TMPDIR/weave"
            done
        done
    done
}

@test "slides: a map of parallel fibres has their thickness and fibre fraction, and k1 along them" {
    slide '"parallel_fibers"' | jq '.permeability = {model: "kozeny_carman", k1: 3e-10, k2: 5e-11,
        k3: 1e-11, at_fiber_volume_fraction: 0.5}' >"$BATS_TEST_TMPDIR/request.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/request.json" 2>/dev/null >"$BATS_TEST_TMPDIR/out"
    jq '{points: [.nodes | [.x, .y, .z] | transpose[]]}' "$BATS_TEST_TMPDIR/out" \
        >"$BATS_TEST_TMPDIR/points.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/request.json" --map "$BATS_TEST_TMPDIR/points.json" 2>/dev/null \
        >"$BATS_TEST_TMPDIR/map"
    for file in out map; do
        jq -e 'def near($x; $y): ($x / $y - 1 | fabs) < 1e-9;
            .cells | (.shear_deg | map(fabs) | max > 20) and (.k1 | length > 1000) and
            ([.thickness, .fiber_volume_fraction, .k1, .k2] | transpose | all(
                near(.[0]; 0.5) and near(.[1]; 0.5) and near(.[2]; 3e-10) and near(.[3]; 5e-11))) and
            ([.k1_x, .k1_y, .k1_z, .warp_x, .warp_y, .warp_z] | transpose | all(
                .[0] * .[3] + .[1] * .[4] + .[2] * .[5] | fabs - 1 | fabs < 1e-12))' \
            "$BATS_TEST_TMPDIR/$file"
    done
}

@test "slides: the outline of the flat pattern of parallel fibres holds the area of the part" {
    slide '"parallel_fibers"' | "$DRAPE" - 2>/dev/null |
        jq -e '([.rim.p, .rim.q] | transpose) as $at | ($at | length) as $n |
            ([range($n) as $k | $at[$k] as $a | $at[($k + 1) % $n] as $b |
                $a[0] * $b[1] - $b[0] * $a[1]] | add / 2) as $cells |
            100 * $cells / .summary.part_area - 1 | fabs < 2e-4'
}

@test "drape: says what the generators cost that were found, and how severe the shear is" {
    jq '.fabric = {spacing: 20, limit_curve: {shear_deg: [0, 20, 50], severity: [0, 0.2, 1]}} |
        .generators = {warp: "least_energy", weft: "least_energy"}' api/examples/freeform.json |
        "$DRAPE" - 2>"$BATS_TEST_TMPDIR/said" >"$BATS_TEST_TMPDIR/out"
    before=$(printf %.5g "$(jq .summary.steering.energy_before "$BATS_TEST_TMPDIR/out")")
    after=$(printf %.5g "$(jq .summary.steering.energy_after "$BATS_TEST_TMPDIR/out")")
    grep "^drape: generators: energy $before with geodesics, $after with those found, in " "$BATS_TEST_TMPDIR/said"
    severity=$(printf %.3g "$(jq .summary.severity_max "$BATS_TEST_TMPDIR/out")")
    grep "^drape: severity: $severity at the most, by the limit curve" "$BATS_TEST_TMPDIR/said"
}

@test "drape: generators that are said once are those of warp and of weft; of a fabric that slides of the warp" {
    same() {
        jq "$1 | .generators = $2" api/examples/freeform.json | "$DRAPE" - 2>/dev/null | jq 'del(.id, .summary.timing_ms)'
    }
    local spacing='.fabric = {spacing: 20}' bent='{steered: [0, 5e-4, 2e-4, 0]}'
    for each in '"least_energy"' "$bent" '"geodesic"'; do
        [ "$(same "$spacing" "$each")" = "$(same "$spacing" "{warp: $each, weft: $each}")" ]
    done
    local slides="$spacing | .fabric.kinematics = \"parallel_fibers\""
    [ "$(same "$slides" "$bent")" = "$(same "$slides" "{warp: $bent}")" ]
}

@test "drape: generators of eight points a side are written, and read again" {
    for points in 8 16; do
        jq --argjson points $points '.fabric = {spacing: 20} |
            .generators = {warp: {steered: {points: $points}}}' api/examples/freeform.json |
            "$DRAPE" - 2>/dev/null | jq -e --argjson points $points '.summary.steering |
                .fell and (.generators.warp.steered.values | length == 2 * $points)'
    done
}
