# SPDX-License-Identifier: MIT
# Stored surfaces.
load helper

setup_file() { start_shared_daemon --workers 1; }
teardown_file() { end_file; }

surface() { jq -c .surface "$EXAMPLES/$1.json"; }

@test "http: a surface is stored once, whatever its spelling" {
    surface saddle | post /v1/surfaces -
    expect 201
    id=$(field .id)
    [ "$(header Location)" = "/v1/surfaces/$id" ]
    jq -e '.degree_u == 2 and .degree_v == 2 and .size_u == 3 and .size_v == 3 and .area > 16 and
           (.bounding_box | flatten | length) == 6' "$body"
    jq '.surface' "$EXAMPLES/saddle.json" | jq '{name: "mine", delta: 0.1} + .' | post /v1/surfaces -
    expect 200
    [ "$(field .id)" = "$id" ]
    jq '{shape: {type: "surface", count: 1, data: [.surface]}}' "$EXAMPLES/saddle.json" |
        post /v1/surfaces -
    expect 200
    [ "$(field .id)" = "$id" ]
    [ "$(header Location)" = "/v1/surfaces/$id" ]
}

@test "http: the definition comes back and can be posted again" {
    surface sphere | post /v1/surfaces -
    expect 201
    id=$(field .id)
    call GET "/v1/surfaces/$id"
    expect 200
    jq -e '.degree_u == 2 and .size_u == 3 and (.knotvector_u | length) == 6' "$body"
    cp "$body" "$BATS_TEST_TMPDIR/again"
    post /v1/surfaces "$BATS_TEST_TMPDIR/again"
    expect 200
    [ "$(field .id)" = "$id" ]
}

@test "http: surfaces are listed in pages" {
    surface freeform | post /v1/surfaces -
    expect 201
    id=$(field .id)
    call GET '/v1/surfaces?limit=1'
    expect 200
    [ "$(field '.surfaces | length')" = 1 ]
    [ "$(field '.surfaces[0].id')" = "$id" ]
    call GET "/v1/surfaces?cursor=$(field .next)"
    [ "$(field '.surfaces | length')" = 2 ]
    jq -e '.next == null and all(.surfaces[]; .area > 0)' "$body"
    call GET '/v1/surfaces?limit=none'
    expect_problem 422 invalid-request
}

@test "http: a drape of a stored surface is the drape of that surface" {
    surface freeform | post /v1/surfaces -
    surface_id=$(field .id)
    jq --arg id "$surface_id" '.surface = {$id}' "$EXAMPLES/freeform.json" |
        post '/v1/drapes?fields=nodes.x' - -H 'Prefer: wait=40'
    expect 200
    id=$(field .id)
    jq -c .nodes "$body" >"$BATS_TEST_TMPDIR/stored"
    post '/v1/drapes?fields=nodes.x' "$EXAMPLES/freeform.json" -H 'Prefer: wait=40'
    expect 200
    jq -c .nodes "$body" | cmp - "$BATS_TEST_TMPDIR/stored"
    call GET "/v1/drapes/$id/request"
    [ "$(field .surface.id)" = "$surface_id" ]
}

@test "http: a surface that a drape waits for cannot be deleted" {
    jq -c '.surface.control_points.points[0][2] += 0.25 | .surface' "$EXAMPLES/saddle.json" |
        post /v1/surfaces -
    expect 201
    surface_id=$(field .id)
    stop_workers
    jq --arg id "$surface_id" '.surface = {$id}' "$EXAMPLES/saddle.json" | submit
    call DELETE "/v1/surfaces/$surface_id"
    expect_problem 409 conflict
    kill -CONT $(workers)
    wait_for "$id" succeeded
    call DELETE "/v1/surfaces/$surface_id"
    expect 204
    call GET "/v1/surfaces/$surface_id"
    expect_problem 404 not-found
    call DELETE "/v1/surfaces/$surface_id"
    expect_problem 404 not-found
    # The drape lives on without it.
    call GET "/v1/drapes/$id/result?fields=nodes.x"
    expect 200
}

@test "http: an unknown surface id is a problem at its place" {
    jq '.surface = {id: "0123456789abcdef0123456789abcdef"}' "$EXAMPLES/saddle.json" |
        post /v1/drapes -
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /surface/id ]
}

@test "http: bad surfaces are refused at their place" {
    surface saddle | jq '.degree_u = 12' | post /v1/surfaces -
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /degree_u ]
    surface saddle | jq '.colour = 12' | post /v1/surfaces -
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /colour ]
    surface saddle | jq '.control_points.points |= map([1, 1, 1])' | post /v1/surfaces -
    expect_problem 422 degenerate-surface
    jq -n '{vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 3]]}' |
        post /v1/surfaces -
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /triangles/0/2 ]
}
