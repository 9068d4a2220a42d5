# SPDX-License-Identifier: MIT
# Who may call, what each role may, and whose drapes and surfaces are whose.

load helper
bats_require_minimum_version 1.5.0

# token NAME ROLE: a new token, whose line goes into the file.
token() {
    "$DRAPED" hash-token "$1" "$2" --generate 2>&1 >>"$TOKENS" | sed -n 's/^the token: //p'
}

setup_file() {
    export TOKENS=$BATS_FILE_TMPDIR/tokens
    printf '# who may call\n\n' >"$TOKENS"
    export ANNA BERT READER BOSS
    ANNA=$(token anna write) BERT=$(token bert write)
    READER=$(token anna read) BOSS=$(token boss admin)
    start_shared_daemon --tokens "$TOKENS" --workers 1
}

teardown_file() { end_file; }

# as TOKEN COMMAND METHOD-OR-PATH...: call or post with a token.
as() {
    local token=$1
    shift
    "$@" -H "Authorization: Bearer $token"
}

# A surface that no other test has.
surface() { jq -c --argjson z "$1" '.surface | .control_points.points[0][2] += $z' $EXAMPLES/saddle.json; }

@test "tokens: without one all but the open paths are 401 and say how to do it" {
    for path in /v1/drapes /v1/surfaces /metrics /v1/drapes/00000000000000000000000000000000; do
        call GET "$path"
        expect_problem 401 unauthorized
        [ "$(header WWW-Authenticate)" = 'Bearer realm="draped"' ]
        [ "$(header Cache-Control)" = private ]
        [ "$(header Vary)" = Authorization ]
    done
    quick 1 | post /v1/drapes -
    expect_problem 401 unauthorized
    for path in / /healthz /readyz /version /v1/openapi.json /v1/limits; do
        call GET "$path"
        expect 200
        [ -z "$(header Vary | grep Authorization)" ]
    done
}

@test "tokens: one that is not known, or another scheme, is 401" {
    for credentials in "Bearer ${ANNA}x" "Bearer ${ANNA%?}" "Bearer" "Bearer " "Basic $ANNA" "$ANNA"; do
        call GET /v1/drapes -H "Authorization: $credentials"
        expect_problem 401 unauthorized
    done
    call GET /v1/drapes -H "Authorization: Bearer wrong"
    [[ "$(header WWW-Authenticate)" == *'error="invalid_token"'* ]]
    call GET /v1/drapes -H "authorization: bEaReR   $ANNA"
    expect 200
    call GET /v1/drapes -H "Authorization: Bearer $ANNA" -H "Authorization: Bearer $BERT"
    expect_problem 400 bad-request
}

@test "tokens: metrics that a proxy passes on are for administrators" {
    for from in 'X-Forwarded-For: 192.0.2.1' 'Forwarded: for=192.0.2.1' 'Via: 1.1 proxy'; do
        as "$READER" call GET /metrics -H "$from"
        expect_problem 403 forbidden
        as "$BOSS" call GET /metrics -H "$from"
        expect 200
    done
}

@test "tokens: the role read sees and does nothing else" {
    quick 1.1 | as "$ANNA" submit
    for path in "/v1/drapes/$id?wait=40" /v1/drapes/$id/result /v1/drapes /v1/limits /metrics; do
        as "$READER" call GET "$path"
        expect 200
    done
    quick 1 | as "$READER" post /v1/drapes -
    expect_problem 403 forbidden
    [[ "$(header WWW-Authenticate)" == *'error="insufficient_scope"'* ]]
    surface 1.1 | as "$READER" post /v1/surfaces -
    expect_problem 403 forbidden
    as "$READER" call POST /v1/drapes/$id/cancel
    expect_problem 403 forbidden
    as "$READER" call DELETE /v1/drapes/$id
    expect_problem 403 forbidden
    as "$READER" call GET /v1/drapes/$id
    expect 200
    jq -n '{points: [[0, 0, 0]]}' | as "$READER" post "/v1/drapes/$id/map" -
    expect 200
}

@test "tokens: a drape is its owner's and the administrator's alone" {
    quick 1.2 | as "$ANNA" submit
    as "$ANNA" call GET "/v1/drapes/$id?wait=40"
    [ "$(field .status)" = succeeded ]
    [ "$(field .owner)" = anna ]
    for what in "" /result /request /events /pattern; do
        as "$BERT" call GET "/v1/drapes/$id$what"
        expect_problem 404 not-found
        as "$BOSS" call GET "/v1/drapes/$id$what"
        expect 200
    done
    for other in "POST /v1/drapes/$id/cancel" "DELETE /v1/drapes/$id"; do
        as "$BERT" call ${other% *} ${other#* }
        expect_problem 404 not-found
    done
    jq -n '{points: [[0, 0, 0]]}' | as "$BERT" post "/v1/drapes/$id/map" -
    expect_problem 404 not-found
    as "$BERT" call GET "/v1/drapes?limit=1000"
    field "[.drapes[] | select(.owner != \"bert\")] == []"
    as "$BOSS" call GET "/v1/drapes?limit=1000"
    field "[.drapes[].id] | index(\"$id\") != null"
    as "$BOSS" call DELETE "/v1/drapes/$id"
    expect 204
}

@test "tokens: the same drape of two callers is solved for each and each has his own" {
    quick 1.3 | as "$ANNA" submit
    local first=$id
    as "$ANNA" call GET "/v1/drapes/$first?wait=40"
    quick 1.3 | as "$BERT" submit
    [ "$id" != "$first" ]
    as "$BERT" call GET "/v1/drapes/$id?wait=40"
    [ "$(field .status)" = succeeded ]
    # Nothing tells him that she has asked before; a second time he is answered from his own.
    [ "$(field .attempts)" = 1 ]
    quick 1.3 | as "$BERT" submit
    as "$BERT" call GET "/v1/drapes/$id"
    [ "$(field .attempts)" = 0 ]
    as "$ANNA" call DELETE "/v1/drapes/$first"
    expect 204
    as "$BERT" call GET "/v1/drapes/$id/result"
    expect 200
}

@test "tokens: an Idempotency-Key is its owner's" {
    quick 1.4 | as "$ANNA" submit -H 'Idempotency-Key: k'
    local first=$id
    quick 1.4 | as "$ANNA" submit -H 'Idempotency-Key: k'
    [ "$id" = "$first" ]
    quick 1.5 | as "$BERT" submit -H 'Idempotency-Key: k'
    [ "$id" != "$first" ]
}

@test "tokens: two callers who store the same surface have one each" {
    surface 1.2 | as "$ANNA" post /v1/surfaces -
    expect 201
    local s
    s=$(field .id)
    as "$BERT" call GET "/v1/surfaces/$s"
    expect_problem 404 not-found
    as "$BERT" call DELETE "/v1/surfaces/$s"
    expect_problem 404 not-found
    jq -n --arg id "$s" '{surface: {id: $id}, fabric: {spacing: 0.2}}' >"$BATS_TEST_TMPDIR/named"
    as "$BERT" post /v1/drapes "$BATS_TEST_TMPDIR/named"
    expect_problem 422 invalid-request
    surface 1.2 | as "$BERT" post /v1/surfaces -
    expect 201
    [ "$(field .id)" = "$s" ]
    surface 1.2 | as "$BERT" post /v1/surfaces -
    expect 200
    as "$ANNA" call DELETE "/v1/surfaces/$s"
    expect 204
    as "$ANNA" call GET "/v1/surfaces/$s"
    expect_problem 404 not-found
    as "$BERT" call GET /v1/surfaces
    [ "$(field '.surfaces | length')" = 1 ]
    as "$BERT" submit_file "$BATS_TEST_TMPDIR/named"
    as "$BERT" call GET "/v1/drapes/$id?wait=40"
    [ "$(field .status)" = succeeded ]
    as "$BOSS" call DELETE "/v1/surfaces/$s"
    expect 204
    as "$BERT" call GET "/v1/surfaces/$s"
    expect_problem 404 not-found
}

submit_file() {
    local file=$1
    shift
    submit "$@" <"$file"
}

@test "tokens: a refused body is not read and an answer is for its caller alone" {
    quick 1 | as wrong post /v1/drapes - -H 'Expect: 100-continue'
    expect_problem 401 unauthorized
    not grep -q 'HTTP/1.1 100' "$headers"
    quick 1.6 | as "$ANNA" submit
    as "$ANNA" call GET "/v1/drapes/$id?wait=40"
    as "$ANNA" call GET "/v1/drapes/$id/result"
    expect 200
    grep -qi '^Vary: Authorization' "$headers"
    [[ "$(header Cache-Control)" == *private* ]]
}

read_again() { grep -q '"event":"tokens_read"' "$HOME_DIR/log"; }
kept() { grep -q '"event":"tokens_kept".*line 2 ' "$HOME_DIR/log"; }

@test "tokens: SIGHUP reads the file again, and a bad one changes nothing" {
    local TOKENS=$BATS_TEST_TMPDIR/tokens first second
    first=$(token carl write)
    start_daemon "$BATS_TEST_TMPDIR/daemon" --tokens "$TOKENS"
    as "$first" call GET /v1/drapes
    expect 200
    echo 'dora:write' >>"$TOKENS"
    kill -HUP "$DAEMON"
    wait_until 10 kept
    as "$first" call GET /v1/drapes
    expect 200
    rm "$TOKENS"
    second=$(token dora write)
    kill -HUP "$DAEMON"
    wait_until 10 read_again
    as "$first" call GET /v1/drapes
    expect_problem 401 unauthorized
    as "$second" call GET /v1/drapes
    expect 200
    stop_daemon
}

@test "tokens: a file that is wrong keeps the daemon from starting and names the line" {
    local bad=$BATS_TEST_TMPDIR/bad hash
    hash=$(printf '%064d' 7)
    for line in "anna:write" "anna:owner:$hash" "an na:write:$hash" "anna:write:${hash}0" \
        ":write:$hash" "anna:write:${hash%?}g" "secret-token-here"; do
        printf '# a comment\n\n%s\n' "$line" >"$bad"
        run -2 timeout 10 "$DRAPED" --tokens "$bad" --check-config
        [[ "$output" == *"line 3 "* ]]
        [[ "$output" != *secret* ]]
    done
    printf 'a:read:%s\nb:write:%s\n' "$hash" "$hash" >"$bad"
    run -2 timeout 10 "$DRAPED" --tokens "$bad" --check-config
    [[ "$output" == *"line 2 has the hash of an earlier line"* ]]
    : >"$bad"
    run -2 timeout 10 "$DRAPED" --tokens "$bad" --check-config
    run -2 timeout 10 "$DRAPED" --tokens "$bad/none" --check-config
}

@test "tokens: hash-token makes the line of a token that is given" {
    # b2sum is another implementation of BLAKE2b.
    local token=Zm9vYmFyYmF6cXV4MDEyMzQ1Njc4OQ
    run -0 "$DRAPED" hash-token anna write <<<"$token"
    [ "$output" = "anna:write:$(printf %s $token | b2sum -l 256 | cut -d' ' -f1)" ]
    run -2 "$DRAPED" hash-token anna write <<<"two words"
    run -2 "$DRAPED" hash-token anna write </dev/null
    run -2 "$DRAPED" hash-token anna owner --generate
    run -2 "$DRAPED" hash-token 'an:na' write --generate
    run -2 "$DRAPED" hash-token anna
}

@test "tokens: with them it may listen beyond this machine" {
    run -0 timeout 10 "$DRAPED" --listen 0.0.0.0:0 --tokens "$TOKENS" --check-config
    run -2 timeout 10 "$DRAPED" --listen 0.0.0.0:0 --check-config
}

@test "tokens: no log has one, nor the database" {
    for token in "$ANNA" "$BERT" "$READER" "$BOSS"; do
        not grep -rqF "$token" "$HOME_DIR"
    done
    grep -q '"caller":"bert"' "$HOME_DIR/log"
}

@test "tokens: a token that is revoked ends its event streams, and others go on" {
    local TOKENS=$BATS_TEST_TMPDIR/tokens gone kept
    kept=$(token dora write) gone=$(token dora write)
    start_daemon "$BATS_TEST_TMPDIR/daemon" --tokens "$TOKENS" --workers 1
    # Far more than the one worker does while this runs.
    jq -c '.fabric.spacing = 0.003' "$EXAMPLES/saddle.json" | as "$kept" submit
    curl -sSN --max-time 60 -H "Authorization: Bearer $gone" \
        "$URL/v1/drapes/$id/events" >"$BATS_TEST_TMPDIR/gone" 3>&- &
    local stream=$!
    curl -sSN --max-time 60 -H "Authorization: Bearer $kept" \
        "$URL/v1/drapes/$id/events" >"$BATS_TEST_TMPDIR/kept" 3>&- &
    local other=$!
    wait_until 10 grep -q '^event: progress' "$BATS_TEST_TMPDIR/gone"
    wait_until 10 grep -q '^event: progress' "$BATS_TEST_TMPDIR/kept"
    sed -i 2d "$TOKENS"
    kill -HUP "$DAEMON"
    wait "$stream"
    run ! grep -q '^event: end' "$BATS_TEST_TMPDIR/gone"
    kill -0 "$other"
    as "$gone" call GET "/v1/drapes/$id/events"
    expect_problem 401 unauthorized
    as "$kept" call DELETE "/v1/drapes/$id"
    expect 204
    wait "$other"
    stop_daemon
}
