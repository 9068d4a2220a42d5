# SPDX-License-Identifier: MIT
# Requests whose parts are cut as CAD systems cut them, by the command line: as the whole.
bats_require_minimum_version 1.5.0
load helper

# drape NAME: the summary of tests/requests/NAME.json.
drape() { "$DRAPE" "tests/requests/$1.json" 2>/dev/null | jq -c .summary; }

# holds JSON CONDITION: of a summary.
holds() { jq -e "$2" <<<"$1" >/dev/null || { echo "$1"; return 1; }; }

# alike A B SHARE: as many nodes, and areas and shear angles the same to that share.
alike() {
    jq -e -n --argjson a "$1" --argjson b "$2" --argjson share "$3" '$a.nodes == $b.nodes and
        ([["coverage", "cloth_area", "flat_area", "p95_shear_deg", "max_shear_deg"][]
            | ($a[.] / $b[.] - 1) | fabs] | max) <= $share' >/dev/null || { echo "$1" "$2"; return 1; }
}

@test "cut: a dome whose faces meet in its apex is covered, from there too" {
    holds "$(drape dome_in_faces)" '.outcome == "complete" and .front_reasons.fold == 0 and .cloth_coverage > 0.999'
    holds "$(drape dome_from_its_pole)" '.outcome == "complete" and .front_reasons.fold == 0 and .cloth_coverage > 0.999'
}

@test "cut: faces a gap apart are draped by geodesics to the end" {
    holds "$(drape faces_apart)" '.outcome == "complete" and .front_reasons.no_convergence == 0'
}

@test "cut: the area of a trimmed part is that of its cloth" {
    holds "$(drape trims_of_a_t)" '(.part_area - 5072.538839 | fabs) < 1e-3 and .outcome == "complete"'
}

@test "cut: trims that overlap by less than the tolerance are joined at their corners" {
    holds "$(drape trims_overlapping)" '.outcome == "complete" and .cloth_coverage == 1 and .max_shear_deg < 1'
}

@test "cut: the line that closes a trim is a joint as others are" {
    holds "$(drape closing_line)" '.nodes == 503 and .outcome == "complete"'
}

@test "cut: a net with nodes on a sharp fold goes on over it" {
    for fold in fold_of_120 fold_of_140; do
        holds "$(drape $fold)" '.nodes == 14641 and .coverage == 1 and .max_shear_deg < 1e-9'
    done
}

@test "cut: a knot that is inserted moves no node" {
    alike "$(drape knot_inserted)" "$(drape knot_not_inserted)" 1e-9
}

@test "cut: a part that is turned has the same net" {
    alike "$(drape revolved)" "$(drape revolved_and_turned)" 1e-9
}

@test "cut: parameters that are swapped change no shear, at the edge neither" {
    alike "$(drape hat_of_5_radii)" "$(drape hat_of_5_radii_swapped)" 1e-5
}

@test "cut: a cell of which a corner lies on the edge, but for rounding, is cloth" {
    holds "$(drape corner_on_the_rim)" '.cloth_coverage == 1 and (.cloth_area / .part_area - 1 | fabs) < 1e-4'
}

@test "cut: an edge of many pieces is followed all along" {
    holds "$(drape trims_of_degree_5)" '.cloth_coverage == 1 and .warnings == [] and
        (.cloth_area / .part_area - 1 | fabs) < 1e-4 and (.flat_area / .part_area - 1 | fabs) < 1e-4'
}

@test "cut: cloth beyond the ends of narrow faces is that of the whole" {
    holds "$(drape strips)" '.outcome == "complete" and .max_shear_deg < 1e-3 and .error_estimate_max < 1e-3'
}

@test "cut: a node past a joint lies on the face there, no yarn longer than its spacing" {
    "$DRAPE" tests/requests/swept_in_faces.json 2>/dev/null | jq -e '
        [.nodes | [.i, .j, .x, .y, .z] | transpose] as [$nodes] |
        ($nodes | map({key: "\(.[0]) \(.[1])", value: .[2:]}) | from_entries) as $at |
        [$nodes[] | . as [$i, $j, $x, $y, $z] | ($at["\($i + 1) \($j)"], $at["\($i) \($j + 1)"]) |
            select(.) | [$x - .[0], $y - .[1], $z - .[2]] | map(. * .) | add | sqrt] |
        length == 673 and max < 4.5356'
}

@test "cut: all cells at the edge are cloth, whatever the part" {
    for part in rim_of_revolved rim_of_swept rim_of_freeform; do
        holds "$(drape cut/$part)" '.cloth_coverage == 1 and (.cloth_area / .part_area - 1 | fabs) < 3e-4'
    done
}

@test "cut: a trimmed part is that of faces in its shape" {
    local whole faces
    whole=$(drape trims_of_a_t) faces=$(drape cut/faces_of_a_t)
    jq -e -n --argjson a "$whole" --argjson b "$faces" '[$a, $b | .cloth_coverage == 1] == [true, true] and
        ($a.part_area / $b.part_area - 1 | fabs) < 1e-10 and ($a.max_shear_deg - $b.max_shear_deg | fabs) < 0.05' ||
        { echo "$whole" "$faces"; return 1; }
}

@test "cut: a polyline closes alike by a line of its own and by the one understood" {
    alike "$(drape closing_line)" "$(drape cut/closed_polyline)" 1e-9
}

@test "cut: a part far from the origin has the same net" {
    local far
    far=$(jq '.surface.control_points.points |= map(map(. + 1e4)) |
        if .start.point then .start.point |= map(. + 1e4) else . end' tests/requests/revolved.json |
        "$DRAPE" - 2>/dev/null | jq -c .summary)
    alike "$(drape revolved)" "$far" 1e-8
}

@test "cut: basic goes on over a sharp fold with nodes on it" {
    holds "$(jq '.method = "basic"' tests/requests/fold_of_140.json | "$DRAPE" - 2>/dev/null | jq -c .summary)" \
        '.nodes == 14641 and .coverage == 1 and .max_shear_deg < 1e-9'
}

@test "cut: mosaic covers a sharp fold" {
    for part in roof fold fold_of_120 fold_of_140; do
        holds "$(jq '.method = "mosaic"' tests/requests/$part.json | "$DRAPE" - 2>/dev/null | jq -c .summary)" \
            '.outcome == "complete" and .max_shear_deg < 1e-6'
    done
}

# square X0 X1: a flat face of 80 beside others, as JSON.
square() {
    echo '{"degree_u":1,"degree_v":1,"knotvector_u":[0,0,1,1],"knotvector_v":[0,0,1,1],"size_u":2,"size_v":2,' \
        '"control_points":[['"$1"',0,0],['"$1"',80,0],['"$2"',0,0],['"$2"',80,0]]}'
}

# overlapping BY: two flat faces that overlap by that much, draped.
overlapping() {
    echo '{"surface":{"faces":['"$(square 0 "$(jq -n "50 + $1")")"','"$(square 50 100)"']},
        "fabric":{"spacing":4}}' | "$DRAPE" - 2>/dev/null
}

@test "cut: faces that overlap by more than the tolerance are apart, and it is said" {
    for by in 0.01 0.1 1 5; do
        overlapping $by | jq -e '(.summary.warnings | map(.code) | index("components")) != null and
            .summary.outcome == "complete" and .summary.max_shear_deg < 1e-9 and
            any(.summary.warnings[].detail; contains("Face 1 overlaps it at (50, 0, 0)"))' || { overlapping $by; return 1; }
    done
    overlapping -0.1 | jq -e 'any(.summary.warnings[].detail; contains("Face 0 is 0.1 from it at (49.9, 0, 0)"))'
    overlapping 0.0005 | jq -e '.summary | .cloth_coverage == 1 and (.warnings | map(.code) | index("components")) == null'
}

@test "cut: a trim that does not close is refused with its place" {
    run --separate-stderr "$DRAPE" - <<<"{\"surface\":$(square 0 100 | jq -c '.trims = [{"degree": 1,
        "knotvector": [0, 0, 1, 2, 3, 4, 4], "reversed": true,
        "control_points": [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9], [0.1, 0.101]]}]'),\"fabric\":{\"spacing\":4}}"
    [ "$status" -ne 0 ]
    [[ "$stderr" == *"/surface/trims/0: trim 0 of the surface is open"* ]]
}

# spread_pole BY FACES: a cone of revolution, 20 high, whose tip is a circle of that radius, in 1 or 4 faces, as a
# request.
spread_pole() {
    jq -n --argjson e "$1" --argjson faces "$2" '
        [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]] as $ring | (8 / $faces) as $n |
        {surface: {faces: [range($faces) | $ring[. * $n:(. + 1) * $n + 1] | {degree_u: 2, degree_v: 1, size_u: length,
            size_v: 2, knotvector_v: [0, 0, 1, 1],
            knotvector_u: ([0, 0, 0] + [range(1; $n / 2) | ., .] + [$n / 2 | ., ., .]), control_points: {
                points: [.[] | [50 * .[0], 50 * .[1], 0], [$e * .[0], $e * .[1], 20]],
                weights: [range(length) | if . % 2 == 1 then 0.5 | sqrt else 1 end | ., .]}}]},
         start: {point: [20, 5, 11.7538]}, fabric: {spacing: 4}}'
}

@test "cut: a pole that is no point is told with its face" {
    for spread in 1e-3 0.05; do
        spread_pole $spread 1 | "$DRAPE" - 2>/dev/null | jq -e '.summary.warnings |
            map(select(.code == "hole" and .pointer == "/surface/faces/0")) | length == 1'
    done
    for faces in 1 4; do
        spread_pole 0 $faces | "$DRAPE" - 2>/dev/null | jq -e '.summary | .cloth_coverage == 1 and
            (.warnings | map(select(.code == "hole")) | length) == 0'
    done
}

@test "cut: a hole that is all but a point, between four faces, is told with one of them and its width" {
    spread_pole 0.05 4 | "$DRAPE" - 2>/dev/null | jq -e '.summary.warnings | map(select(.code == "hole")) |
        length == 1 and (.[0].pointer | test("^/surface/faces/[0-3]$")) and (.[0].detail | contains("0.1 m wide at "))'
    spread_pole 0.5 4 | "$DRAPE" - 2>/dev/null | jq -e '.summary.warnings | all(.code != "hole")'
}
