# SPDX-License-Identifier: MIT
# What the database has and draped did not write is told with its id, and nothing else suffers.
load helper

setup() {
    start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
    post /v1/drapes $EXAMPLES/sphere.json -H 'Prefer: wait=20'
    expect 200
    drape=$(field .id)
    post '/v1/drapes' $EXAMPLES/saddle.json -H 'Prefer: wait=20'
    other=$(field .id)
    jq -c .surface $EXAMPLES/saddle.json | post /v1/surfaces -
    expect 201
    surface=$(field .id)
    stop_daemon
}
teardown() { stop_daemon; keep_contract; }

# Runs a statement on the store of the daemon that has ended.
on_store() {
    python3 - "$HOME_DIR/data/draped.db" "$1" <<'END'
import sqlite3, sys
with sqlite3.connect(sys.argv[1]) as store:
    assert store.execute(sys.argv[2]).rowcount > 0
END
}

altered() { curl -sS "$URL/metrics" | sed -n 's/^draped_store_altered_total //p'; }

# damaged ID: the last answer is 500 and names it.
damaged() {
    expect 500
    [ "$(field .type)" = /problems/damaged ]
    field .detail | grep -q "$1"
}

# What has nothing to do with it is as before; the damage is counted, logged and listed.
told_of() {
    call GET "/v1/drapes/$other/result"
    expect 200
    [ "$(altered)" -ge 1 ]
    grep '"event":"store_altered"' "$HOME_DIR/log" | grep -q "\"id\":\"$2\""
    not "$DRAPED" check --data "$HOME_DIR/data" >"$BATS_TEST_TMPDIR/check" 2>"$BATS_TEST_TMPDIR/errors"
    [ "$(grep -c ^damaged "$BATS_TEST_TMPDIR/check")" = 1 ]
    grep -qx "damaged  $1 $2: $3" "$BATS_TEST_TMPDIR/check"
}

@test "http: a damaged result is 500 with its id, and the drape can be deleted and posted again" {
    on_store "UPDATE chunks SET bytes = cast(substr(bytes, 1, 500) || 'X' || substr(bytes, 502) AS BLOB)
        WHERE id >> 24 = (SELECT result FROM jobs WHERE id = '$drape')"
    start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
    for format in json csv npz pattern; do
        path=result?format=$format
        [ "$format" != pattern ] || path=pattern
        call GET "/v1/drapes/$drape/$path"
        damaged "$drape"
    done
    echo '{"points": [[0, 0, 1]]}' | post "/v1/drapes/$drape/map" -
    [ "$status" -ge 500 ]
    told_of drape "$drape" 'its result'
    call DELETE "/v1/drapes/$drape"
    expect 204
    post /v1/drapes $EXAMPLES/sphere.json -H 'Prefer: wait=20'
    expect 200
    "$DRAPED" check --data "$HOME_DIR/data" | grep -qx 'verdict  well'
}

@test "http: a damaged request, summary or error is told, and its list goes on" {
    on_store "UPDATE requests SET bytes = cast(bytes || ' ' AS BLOB)
        WHERE job = (SELECT sequence FROM jobs WHERE id = '$drape')"
    start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
    call GET "/v1/drapes/$drape/request"
    damaged "$drape"
    call GET "/v1/drapes/$drape/result"
    expect 200
    told_of drape "$drape" 'its request'
    call DELETE "/v1/drapes/$drape"
    stop_daemon
    on_store "UPDATE results SET summary = replace(summary, 'nodes', 'modes')
        WHERE number = (SELECT result FROM jobs WHERE id = '$other')"
    start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
    call GET "/v1/drapes/$other"
    expect 200
    [ "$(jq -c '[.status, .damaged, .summary]' "$body")" = '["succeeded",true,null]' ]
    call GET /v1/drapes
    expect 200
    [ "$(jq '.drapes | length' "$body")" = 1 ]
}

@test "http: a damaged surface fails what needs it, with its id" {
    on_store "UPDATE surfaces SET definition = cast(replace(definition, '1', '2') AS BLOB), form = NULL"
    start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
    call GET "/v1/surfaces/$surface"
    damaged "$surface"
    jq --arg id "$surface" '.surface = {$id}' $EXAMPLES/saddle.json | post /v1/drapes -
    damaged "$surface"
    told_of surface "$surface" 'its definition'
}

@test "http: a drape whose request is damaged while it waits fails once, and names it" {
    start_daemon "$BATS_TEST_TMPDIR/home" --role api
    jq '.direction = {angle_deg: 7}' $EXAMPLES/saddle.json | post /v1/drapes -
    expect 202
    waiting=$(field .id)
    stop_daemon
    on_store "UPDATE requests SET seal = seal + 1 WHERE job = (SELECT max(sequence) FROM jobs)"
    start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
    ended() { call GET "/v1/drapes/$waiting"; [ "$(field .status)" = failed ]; }
    wait_until 20 ended
    [ "$(field .error.type)" = /problems/damaged ]
    [ "$(field .attempts)" = 1 ]
}

@test "http: a store of an older version is refused with what to do, and nothing of it is touched" {
    mkdir "$BATS_TEST_TMPDIR/old"
    gunzip -c tests/store/stores/0.10.0-schema-11.db.gz >"$BATS_TEST_TMPDIR/old/draped.db"
    sum=$(sha256sum <"$BATS_TEST_TMPDIR/old/draped.db")
    run timeout 20 "$DRAPED" --listen 127.0.0.1:0 --data "$BATS_TEST_TMPDIR/old"
    [ "$status" = 1 ]
    [[ $output == *'"event":"start_failed"'*'has schema 11'*'name an empty store'* ]]
    for command in status check; do
        run "$DRAPED" $command --data "$BATS_TEST_TMPDIR/old"
        [ "$status" = 1 ]
        [[ $output == *'schema 11'* ]]
    done
    [ "$(sha256sum <"$BATS_TEST_TMPDIR/old/draped.db")" = "$sum" ]
    [ "$(find "$BATS_TEST_TMPDIR/old" -name '*.db*' ! -name '*-lock' | wc -l)" = 1 ]
}
