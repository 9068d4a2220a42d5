# SPDX-License-Identifier: MIT
# Prepared forms of stored surfaces: another way to the same result, and never one that is damaged.
load helper

teardown() { stop_daemon; }

PART=tests/requests/dome_in_faces.json

# Coordinates of the drape of the stored surface, to $BATS_TEST_TMPDIR/$1: a direction that no drape
# had before, so that its result is not one that is stored.
drape_stored() {
    jq --arg id "$id" --argjson angle "$2" '.surface = {$id} | .direction = {angle_deg: $angle}' $PART |
        post '/v1/drapes?fields=nodes.x,nodes.y,nodes.z' - -H 'Prefer: wait=40'
    expect 200
    jq -c .nodes "$body" >"$BATS_TEST_TMPDIR/$1"
}

# The same of a request with the faces inside.
drape_inline() {
    jq --argjson angle "$2" '.direction = {angle_deg: $angle}' $PART |
        post '/v1/drapes?fields=nodes.x,nodes.y,nodes.z' - -H 'Prefer: wait=40'
    expect 200
    jq -c .nodes "$body" >"$BATS_TEST_TMPDIR/$1"
}

# Runs a statement on the store of the daemon that has ended, and prints what it gives.
on_store() {
    python3 - "$HOME_DIR/data/draped.db" "$1" <<'END'
import sqlite3, sys
with sqlite3.connect(sys.argv[1]) as store:
    for row in store.execute(sys.argv[2]):
        print(*row)
END
}

@test "http: a stored surface is draped by its form, and one that is damaged is made anew" {
    start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
    jq -c .surface $PART | post /v1/surfaces -
    expect 201
    id=$(field .id)
    drape_stored stored 10
    stop_daemon
    [ "$(on_store 'SELECT length(form) > 10000 FROM surfaces')" = 1 ]
    # in its head, which names the build; in its middle; cut short; none
    n=10
    for form in "cast(substr(form, 1, 40) || 'X' || substr(form, 42) AS BLOB)" \
        "cast(substr(form, 1, 5000) || 'X' || substr(form, 5002) AS BLOB)" \
        'substr(form, 1, length(form) - 8)' NULL; do
        on_store "UPDATE surfaces SET form = $form"
        damaged=$(on_store 'SELECT hex(form) FROM surfaces' | sha256sum)
        start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
        n=$((n + 1))
        drape_stored stored $n
        drape_inline inline $n
        cmp "$BATS_TEST_TMPDIR/stored" "$BATS_TEST_TMPDIR/inline"
        stop_daemon
        renewed=$(on_store 'SELECT hex(form) FROM surfaces' | sha256sum)
        [ "$renewed" != "$damaged" ]
        [ "$(on_store 'SELECT length(form) > 10000 FROM surfaces')" = 1 ]
        # which is sound: the next drape leaves it as it is
        start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
        drape_stored stored $((n + 20))
        stop_daemon
        [ "$(on_store 'SELECT hex(form) FROM surfaces' | sha256sum)" = "$renewed" ]
    done
}

@test "http: faces of a stored surface are chosen again, moved, and deleted with it" {
    start_daemon "$BATS_TEST_TMPDIR/home" --workers 1
    jq -c .surface $PART | post /v1/surfaces -
    id=$(field .id)
    for angle in 1 2; do
        for more in '{faces: [0, 1]}' '{grow_from: 1}' '{}'; do
            jq --arg id "$id" --argjson angle $angle \
                ".surface = {\$id} + $more | .direction = {angle_deg: \$angle}" $PART |
                post '/v1/drapes?fields=nodes.x' - -H 'Prefer: wait=40'
            expect 200
            [ "$(field '.nodes.x | length')" -gt 50 ]
        done
    done
    call DELETE "/v1/surfaces/$id"
    expect 204
    jq --arg id "$id" '.surface = {$id} | .direction = {angle_deg: 3}' $PART | post /v1/drapes -
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /surface/id ]
}
