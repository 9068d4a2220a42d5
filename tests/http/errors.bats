# SPDX-License-Identifier: MIT
# What is wrong with a request is told as a problem, with the place.
load helper

setup_file() { start_shared_daemon --max-body 2M --max-nodes 100000 --max-elements 200000; }
teardown_file() { end_file; }

teardown() {
    # Whatever was sent, the daemon is well.
    call GET /healthz
    expect 200
}

@test "http: every bad request of the decoder's tests is refused at its place" {
    count=$(python3 tests/http/bad_requests.py "$PORT") || { echo "$count"; false; }
    [ "$count" -ge 20 ]
}

# refused STATUS SLUG POINTER FILTER: the saddle, changed by a jq filter.
refused() {
    jq -c "$4" "$EXAMPLES/saddle.json" | post /v1/drapes -
    expect_problem "$1" "$2"
    [ -z "$3" ] || [ "$(field .pointer)" = "$3" ] || { cat "$body"; return 1; }
}

@test "http: an unknown key, a wrong type and a value out of range name their place" {
    refused 422 invalid-request /colour '.colour = 1'
    refused 422 invalid-request /fabric/spacin '.fabric.spacin = 1'
    refused 422 invalid-request /fabric/spacing '.fabric.spacing = "1"'
    refused 422 invalid-request /fabric/spacing '.fabric.spacing = 0'
    refused 422 invalid-request /fabric/spacing '.fabric.spacing = -1'
    refused 422 invalid-request /fabric/spacing 'del(.fabric.spacing)'
    refused 422 invalid-request /fabric 'del(.fabric)'
    refused 422 invalid-request /surface 'del(.surface)'
    refused 422 invalid-request /method '.method = "glue"'
    refused 422 invalid-request /length_unit '.length_unit = "parsec"'
    refused 422 invalid-request /surface/degree_u '.surface.degree_u = 0'
    refused 422 invalid-request /surface/knotvector_u '.surface.knotvector_u = [0, 0, 1, 1]'
    refused 422 invalid-request /surface/knotvector_v/3 '.surface.knotvector_v = [0, 0, 1, 0, 1, 1]'
    refused 422 invalid-request '' '.surface.size_u = 4'
    refused 422 invalid-request /start/uv '.start = {"uv": [2, 0.5]}'
    refused 422 invalid-request /start '.start = {"uv": [0.5, 0.5], "point": [0, 0, 0]}'
    refused 422 invalid-request /direction/vector '.direction = {"vector": [0, 0, 0]}'
    refused 422 invalid-request /fabric/pre_shear_deg '.fabric.pre_shear_deg = 100'
    refused 422 invalid-request /cavity/height '.cavity = {"height": 0}'
    refused 422 invalid-request /extent/warp/0 '.extent = {"warp": [1, 2]}'
    refused 422 invalid-request '' '.surface.control_points.weights[4] = 0'
}

@test "http: independent errors are reported together" {
    jq '.method = 1 | .fabric.spacing = -1 | .length_unit = "x"' "$EXAMPLES/saddle.json" |
        post /v1/drapes -
    expect_problem 422 invalid-request
    jq -e '[.errors[].pointer] | contains(["/method", "/fabric/spacing", "/length_unit"])' "$body"
}

@test "http: what is no JSON is told with line and column" {
    printf '{\n  "surface": {,}\n}' | post /v1/drapes -
    expect_problem 400 malformed-json
    field .detail | grep -E 'line 2.*column'
    for text in '' ' ' '[1,2' '{"a":1,}' 'nonsense' '{"a":NaN}' $'{"a":"\xff"}' '{"a":1,"a":2}'; do
        printf '%s' "$text" | post /v1/drapes -
        expect_problem 400 malformed-json
    done
    for text in '[]' '1' 'null' '"x"' '{}'; do
        printf '%s' "$text" | post /v1/drapes -
        [ "$status" = 422 ] || [ "$status" = 400 ]
        expect_problem "$status" "$(field '.type | split("/")[2]')"
    done
}

@test "http: a megabyte of garbage is refused at once" {
    head -c 1048576 /dev/urandom >"$BATS_TEST_TMPDIR/garbage"
    post /v1/drapes "$BATS_TEST_TMPDIR/garbage"
    [ "$status" = 400 ] || [ "$status" = 413 ]
    expect_problem "$status" "$(field '.type | split("/")[2]')"
    head -c 1048576 /dev/zero | tr '\0' '[' >"$BATS_TEST_TMPDIR/deep"
    post /v1/drapes "$BATS_TEST_TMPDIR/deep"
    expect_problem 413 too-large
    post /v1/surfaces "$BATS_TEST_TMPDIR/garbage"
    expect_problem "$status" "$(field '.type | split("/")[2]')"
    [ "$status" = 400 ] || [ "$status" = 413 ]
}

@test "http: more values than allowed are refused before parsing" {
    jq -n '[range(300000)]' -c | post /v1/drapes -
    expect_problem 413 too-large
}

@test "http: a body over the limit is 413, with Content-Length, without, and before it is sent" {
    head -c 3000000 /dev/zero >"$BATS_TEST_TMPDIR/large"
    post /v1/drapes "$BATS_TEST_TMPDIR/large" -H 'Expect:'
    expect_problem 413 too-large
    post /v1/drapes "$BATS_TEST_TMPDIR/large" -H 'Expect:' -H 'Transfer-Encoding: chunked'
    expect_problem 413 too-large
    sent=$(curl -sS --max-time 20 -o /dev/null -w '%{size_upload}' -H 'Expect: 100-continue' \
        --expect100-timeout 10 -H "$JSON" --data-binary "@$BATS_TEST_TMPDIR/large" \
        "$URL/v1/drapes")
    [ "$sent" -eq 0 ]
}

@test "http: a body of exactly the limit is taken, with Content-Length and without" {
    { cat "$EXAMPLES/saddle.json"; head -c 2097152 /dev/zero | tr '\0' ' '; } >"$BATS_TEST_TMPDIR/long"
    for how in Expect: 'Transfer-Encoding: chunked'; do
        head -c 2097152 "$BATS_TEST_TMPDIR/long" | post /v1/drapes - -H 'Expect:' -H "$how"
        expect 202
        head -c 2097153 "$BATS_TEST_TMPDIR/long" | post /v1/drapes - -H 'Expect:' -H "$how"
        expect_problem 413 too-large
    done
}

@test "http: a net over the limit of nodes is refused before it is queued" {
    refused 422 invalid-request /fabric/spacing '.fabric.spacing = 0.001'
    refused 422 invalid-request /fabric/spacing '.fabric.spacing = 1e-12'
}

@test "http: methods that a path does not take are 405 with Allow" {
    for pair in 'PUT /v1/drapes' 'DELETE /v1/drapes' 'PATCH /v1/drapes/x' 'POST /v1/drapes/x' \
        'GET /v1/drapes/x/cancel' 'POST /v1/drapes/x/result' 'PUT /v1/surfaces/x' \
        'DELETE /v1/limits' 'POST /healthz' 'POST /' 'TRACE /version' 'DELETE /metrics'; do
        call ${pair% *} "${pair#* }"
        expect_problem 405 method-not-allowed
        [ -n "$(header Allow)" ]
        [[ "$(header Allow)" != *"${pair% *}"* ]]
    done
    call PUT /v1/drapes
    [ "$(header Allow)" = 'POST, GET, HEAD, OPTIONS' ]
}

@test "http: OPTIONS tells the methods" {
    call OPTIONS /v1/drapes
    expect 204
    [ "$(header Allow)" = 'POST, GET, HEAD, OPTIONS' ]
    call OPTIONS /v1/nothing
    expect_problem 404 not-found
}

@test "http: a body that does not call itself JSON is 415" {
    for type in application/x-www-form-urlencoded 'multipart/form-data; boundary=x' text/plain \
        text/csv 'application/json; charset=latin1' application/jsonp; do
        call POST /v1/drapes -H "Content-Type: $type" --data-binary @"$EXAMPLES/saddle.json"
        expect_problem 415 unsupported-media-type
    done
    for type in 'application/json; charset=utf-8' application/vnd.draped+json APPLICATION/JSON; do
        call POST /v1/drapes -H "Content-Type: $type" --data-binary @"$EXAMPLES/saddle.json"
        expect 202
    done
    call POST /v1/drapes -H 'Content-Type:' --data-binary @"$EXAMPLES/saddle.json"
    expect 202
}

@test "http: an unknown or a repeated query parameter is refused" {
    call GET '/v1/drapes?colour=red'
    expect_problem 422 invalid-request
    call GET '/v1/drapes?limit=1&limit=2'
    expect_problem 422 invalid-request
    call GET '/healthz?probe=1'
    expect 200
}

@test "http: the caller's request id comes back, unless it is no id" {
    call GET /v1/drapes/x -H 'X-Request-Id: my-trace.1:2'
    expect_problem 404 not-found
    [ "$(field .request_id)" = my-trace.1:2 ]
    for id in 'a b' '"quoted"' '<script>' "$(printf 'x%.0s' {1..65})"; do
        call GET /v1/drapes/x -H "X-Request-Id: $id"
        expect_problem 404 not-found
        [[ "$(field .request_id)" =~ ^[0-9a-f]{32}$ ]]
    done
}

@test "http: an Idempotency-Key that is too long is refused" {
    post /v1/drapes "$EXAMPLES/saddle.json" -H "Idempotency-Key: $(printf 'k%.0s' {1..256})"
    expect_problem 422 invalid-request
}
