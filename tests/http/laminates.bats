# SPDX-License-Identifier: MIT
# Laminates: stacks of plies, from the command line and over HTTP.
load helper

setup_file() { start_shared_daemon; }
teardown_file() { end_file; }

# stack EXPRESSION: a laminate of four plies on the saddle, changed by jq.
stack() {
    jq -c "{surface, length_unit,
            plies: [0, 45, 90, 0 | {direction: {angle_deg: .},
                fabric: {spacing: 0.2, thickness: 0.002, fiber_volume_fraction: 0.5},
                permeability: {model: \"kozeny_carman\", k1: 3e-10, k2: 1e-10, k3: 2e-11,
                               at_fiber_volume_fraction: 0.5}}]} | $1" "$EXAMPLES/saddle.json"
}

# drape_stack EXPRESSION [ARGUMENT...]: the same by the command.
drape_stack() {
    local expression=$1
    shift
    stack "$expression" >"$BATS_TEST_TMPDIR/stack.json"
    status=0
    output=$("$DRAPE" "$BATS_TEST_TMPDIR/stack.json" "$@" 2>"$BATS_TEST_TMPDIR/stderr") || status=$?
    stderr=$(<"$BATS_TEST_TMPDIR/stderr")
}

@test "the stack on a mesh is what its formulas say" {
    local drape=$(realpath "$DRAPE") cases=$(realpath tests/http/stack_cases.py)
    cd "$BATS_TEST_TMPDIR"
    run python3 "$cases" "$drape"
    echo "$output"
    [ "$status" -eq 0 ]
    [ "${#lines[@]}" -eq 11 ]
}

@test "plies lie on each other by their nominal thickness, and equal ones are draped once" {
    drape_stack '.offset = "nominal" | .side = -1 | .plies[1].repeat = 3'
    [ "$status" -eq 0 ]
    [ "$(jq -c '[.plies[].offset * 1e6 | round]' <<<"$output")" = '[-1000,-5000,-9000,-11000]' ]
    [ "$(jq '[.plies[].digest] | unique | length' <<<"$output")" -eq 4 ]
    drape_stack .
    [ "$(jq -c '[.plies[].offset]' <<<"$output")" = '[0,0,0,0]' ]
    [ "$(jq '[.plies[].digest] | unique | length' <<<"$output")" -eq 3 ]
    [ "$(jq '[.plies[] | select(.status == "succeeded")] | length' <<<"$output")" -eq 4 ]
}

@test "what is wrong with a ply says which" {
    drape_stack '.plies[2].fabric.spacing = -1'
    [ "$status" -eq 1 ]
    [[ $stderr == *"/plies/2/fabric/spacing: "* ]]
    drape_stack '.plies[1].cavity = "flexible" | .plies[3].compaction = {a: 1}'
    [[ $stderr == *"/plies/1/cavity: "* && $stderr == *"/plies/3/compaction/b: "* ]]
    drape_stack '.offset = "nominal" | del(.plies[0].fabric.thickness)'
    [[ $stderr == *"/plies/0/fabric/thickness: is required by the offset"* ]]
    drape_stack '.plies = []'
    [[ $stderr == *"/plies: "* ]]
    drape_stack '.side = 0'
    [[ $stderr == *"/side: must be 1 or -1"* ]]
    drape_stack '.cavity = {height: 1, pressure: 1}'
    [[ $stderr == *"/cavity: "* ]]
}

@test "a ply beyond the radius of curvature names its place, and the rest stands" {
    drape_stack '.offset = "nominal" | .plies[3].fabric.thickness = 8'
    [ "$status" -eq 0 ]
    [[ $stderr == *'ply 4 ("ply_4"): moves the surface by 4.'*'radius of curvature'* ]]
    [ "$(jq -c '[.plies[].status]' <<<"$output")" = \
        '["succeeded","succeeded","succeeded","failed"]' ]
}
