# SPDX-License-Identifier: MIT
# Links: what an owner shows to who has no token, that it is that alone, and that it can be taken
# back.

load helper
bats_require_minimum_version 1.5.0

# token NAME ROLE: a new token, whose line goes into the file.
token() {
    "$DRAPED" hash-token "$1" "$2" --generate 2>&1 >>"$TOKENS" | sed -n 's/^the token: //p'
}

# as TOKEN COMMAND METHOD-OR-PATH...: call or post with a token.
as() {
    local token=$1
    shift
    "$@" -H "Authorization: Bearer $token"
}

# A stored saddle of anna's, a drape and a laminate of it; and a drape of bert's.
setup_file() {
    export TOKENS=$BATS_FILE_TMPDIR/tokens ANNA BERT READER BOSS SURFACE DRAPE_ID STACK PLY OTHER STUDY
    ANNA=$(token anna write) BERT=$(token bert write)
    READER=$(token anna read) BOSS=$(token boss admin)
    start_shared_daemon --tokens "$TOKENS" --workers 1
    jq .surface $EXAMPLES/saddle.json | as "$ANNA" post /v1/surfaces -
    SURFACE=$(field .id)
    quick 1 | jq --arg id "$SURFACE" '.surface = {id: $id}' |
        as "$ANNA" post /v1/drapes - -H 'Prefer: wait=40'
    DRAPE_ID=$(field .id)
    jq -n --arg id "$SURFACE" '{surface: {id: $id}, plies: [
        {name: "a", fabric: {spacing: 0.3, thickness: 0.01}, direction: {angle_deg: 10}}]}' |
        as "$ANNA" post /v1/laminates - -H 'Prefer: wait=40'
    STACK=$(field .id) PLY=$(field .plies[0].id)
    quick 2 | jq '{drape: ., vary: {angle_deg: [0, 30]}, objectives: ["max_shear_deg"]}' |
        as "$ANNA" post /v1/studies - -H 'Prefer: wait=40'
    STUDY=$(field .id)
    quick 1 | as "$BERT" post /v1/drapes - -H 'Prefer: wait=40'
    OTHER=$(field .id)
}

teardown_file() { end_file; }

# link IDS [QUERY]: a link of anna's; sets link (its id) and shown (its token).
link() {
    as "$ANNA" call POST "/v1/links?of=$1$2"
    expect 201
    link=$(field .id) shown=$(field .token)
}

# on_store SQL: what it says.
on_store() { sqlite3 "$HOME_DIR/data/draped.db" "$1"; }

@test "links: one of a drape shows that drape, its files and its surface" {
    link "$DRAPE_ID"
    [ "$(header Location)" = "/v1/links/$link" ]
    field ".of == [\"/v1/drapes/$DRAPE_ID\"] and .expires == null"
    for path in "drapes/$DRAPE_ID" "drapes/$DRAPE_ID?wait=1" "drapes/$DRAPE_ID/result?format=npz" \
        "drapes/$DRAPE_ID/request" "drapes/$DRAPE_ID/events" "drapes/$DRAPE_ID/pattern" \
        "drapes/$DRAPE_ID/report" "surfaces/$SURFACE" "surfaces/$SURFACE/preview"; do
        as "$shown" call GET "/v1/$path"
        expect 200
        grep -qi '^Vary: .*Authorization' "$headers"
    done
    jq -n '{points: [[0, 0, 0]]}' | as "$shown" post "/v1/drapes/$DRAPE_ID/map" -
    expect 200
}

@test "links: one of a laminate shows its plies, and one may show several" {
    link "$STACK,$DRAPE_ID,$STUDY"
    field ".of == [\"/v1/laminates/$STACK\", \"/v1/drapes/$DRAPE_ID\", \"/v1/studies/$STUDY\"]"
    for path in "laminates/$STACK" "laminates/$STACK/request" "laminates/$STACK/patterns" \
        "laminates/$STACK/report?format=html" "drapes/$PLY/result" "drapes/$DRAPE_ID" \
        "surfaces/$SURFACE" "studies/$STUDY" "studies/$STUDY/result" \
        "studies/$STUDY/variants/1/request"; do
        as "$shown" call GET "/v1/$path"
        expect 200
    done
    link "$PLY"
    as "$shown" call GET "/v1/laminates/$STACK"
    expect_problem 404 not-found
}

@test "links: what else there is, of whomever, is 404" {
    link "$DRAPE_ID"
    jq '.surface | .control_points.points[0][2] += 1' $EXAMPLES/saddle.json |
        as "$ANNA" post /v1/surfaces -
    for path in "drapes/$OTHER" "drapes/$PLY" "drapes/$PLY/result" "laminates/$STACK" \
        "studies/$DRAPE_ID" "laminates/$DRAPE_ID" "surfaces/$(field .id)" "surfaces/$DRAPE_ID" \
        "drapes/$SURFACE" "drapes/x" "drapes/$link"; do
        as "$shown" call GET "/v1/$path"
        expect_problem 404 not-found
    done
    jq -n '{points: [[0, 0, 0]]}' | as "$shown" post "/v1/drapes/$OTHER/map" -
    expect_problem 404 not-found
}

@test "links: lists, links, materials and whatever writes are 403" {
    link "$DRAPE_ID"
    for path in drapes studies laminates surfaces materials links "links/$link" \
        materials/example-glass-plain-800; do
        as "$shown" call GET "/v1/$path"
        expect_problem 403 forbidden
        [[ "$(header WWW-Authenticate)" == *'error="insufficient_scope", scope="read"'* ]]
    done
    for path in "DELETE /v1/drapes/$DRAPE_ID" "POST /v1/drapes/$DRAPE_ID/cancel" \
        "DELETE /v1/surfaces/$SURFACE" "DELETE /v1/links/$link" "POST /v1/links?of=$DRAPE_ID"; do
        as "$shown" call ${path% *} "${path#* }"
        expect_problem 403 forbidden
    done
    quick 1 | as "$shown" post /v1/drapes -
    expect_problem 403 forbidden
    as "$shown" call GET /v1/limits
    expect 200
}

@test "links: one that is taken back is 401, and so is one that never was" {
    link "$DRAPE_ID"
    local first=$shown
    link "$DRAPE_ID"
    [ "$first" != "$shown" ]
    as "$BERT" call DELETE "/v1/links/$link"
    expect_problem 404 not-found
    as "$READER" call DELETE "/v1/links/$link"
    expect_problem 403 forbidden
    as "$ANNA" call DELETE "/v1/links/$link"
    expect 204
    for token in "$shown" "${first%?}" "${first}x" draped-link- "draped-link-$link"; do
        as "$token" call GET "/v1/drapes/$DRAPE_ID"
        expect_problem 401 unauthorized
        [[ "$(header WWW-Authenticate)" == *'error="invalid_token"'* ]]
    done
    as "$first" call GET "/v1/drapes/$DRAPE_ID"
    expect 200
}

is_refused() { as "$shown" call GET "/v1/drapes/$DRAPE_ID"; [ "$status" = 401 ]; }

@test "links: one ends with its time, and what it shows with the drape" {
    link "$DRAPE_ID" '&expires_in=2'
    field '(.expires[:19] + "Z" | fromdate) - (.created[:19] + "Z" | fromdate) == 2'
    as "$shown" call GET "/v1/drapes/$DRAPE_ID"
    expect 200
    wait_until 10 is_refused
    as "$ANNA" call GET "/v1/links/$link"
    expect 200
    quick 1.1 | as "$ANNA" post /v1/drapes - -H 'Prefer: wait=40'
    local gone=$(field .id)
    link "$gone"
    as "$ANNA" call DELETE "/v1/drapes/$gone"
    as "$shown" call GET "/v1/drapes/$gone"
    expect_problem 404 not-found
}

@test "links: a stream of events ends when its link is taken back" {
    slow 1 | as "$ANNA" submit
    link "$id"
    curl -sSN --max-time 30 "$URL/v1/drapes/$id/events" -H "Authorization: Bearer $shown" \
        >"$BATS_TEST_TMPDIR/events" 3>&- &
    local stream=$!
    wait_until 20 grep -q progress "$BATS_TEST_TMPDIR/events"
    as "$ANNA" call DELETE "/v1/links/$link"
    wait "$stream"
    not grep -q 'event: end' "$BATS_TEST_TMPDIR/events"
    as "$ANNA" call DELETE "/v1/drapes/$id"
}

@test "links: an owner lists its own, without their tokens, of which the store has none either" {
    link "$DRAPE_ID"
    as "$ANNA" call GET /v1/links
    expect 200
    field "[.links[] | select(.id == \"$link\")][0] | .of == [\"/v1/drapes/$DRAPE_ID\"]"
    not grep -q "$shown" "$body"
    as "$READER" call GET "/v1/links/$link"
    field ".of == [\"/v1/drapes/$DRAPE_ID\"] and (has(\"token\") | not)"
    as "$BERT" call GET "/v1/links/$link"
    expect_problem 404 not-found
    as "$BERT" call GET /v1/links
    field '.links == []'
    as "$BOSS" call GET /v1/links
    field "[.links[].id] | index(\"$link\") != null"
    not grep -rqa "${shown#draped-link-}" "$HOME_DIR/data" "$HOME_DIR/log"
}

@test "links: of nothing, of another's, of too much, for no time are 422" {
    as "$ANNA" call POST /v1/links
    expect_problem 422 invalid-request
    for of in "" x "$OTHER" "$DRAPE_ID,$OTHER" "$DRAPE_ID," "${DRAPE_ID}0" "$SURFACE" \
        "$DRAPE_ID$(printf ",$DRAPE_ID%.0s" {1..16})"; do
        as "$ANNA" call POST "/v1/links?of=$of"
        expect_problem 422 invalid-request
        [[ "$(field .detail)" == *"'of'"* ]]
    done
    for seconds in 0 x 1e3 100000000; do
        as "$ANNA" call POST "/v1/links?of=$DRAPE_ID&expires_in=$seconds"
        expect_problem 422 invalid-request
    done
    as "$READER" call POST "/v1/links?of=$DRAPE_ID"
    expect_problem 403 forbidden
    as "$BOSS" call POST "/v1/links?of=$DRAPE_ID,$OTHER"
    expect 201
}

@test "links: without tokens a link shows no more than it was made for" {
    start_daemon "$BATS_TEST_TMPDIR/open" --workers 1
    quick 1 | post /v1/drapes - -H 'Prefer: wait=40'
    local one=$(field .id)
    quick 1.2 | post /v1/drapes - -H 'Prefer: wait=40'
    local two=$(field .id)
    call POST "/v1/links?of=$one"
    expect 201
    local shown=$(field .token) link=$(field .id)
    as "$shown" call GET "/v1/drapes/$one"
    expect 200
    [ "$(header Cache-Control)" = no-store ]
    [ "$(header Vary)" = Authorization ]
    as "$shown" call GET "/v1/drapes/$two"
    expect_problem 404 not-found
    as "$shown" call DELETE "/v1/drapes/$one"
    expect_problem 403 forbidden
    call DELETE "/v1/links/$link"
    as "$shown" call GET "/v1/drapes/$one"
    expect_problem 401 unauthorized
    stop_daemon
}
