# SPDX-License-Identifier: MIT
# draped backup and draped restore with PostgreSQL, on a server of the test's own that asks for
# passwords.
load helper

PROGRAMS=$(ls -d /usr/lib/postgresql/*/bin 2>/dev/null | tail -1)

# PostgreSQL does not run as root.
as_server() {
    if [ "$(id -u)" = 0 ]; then
        setpriv --reuid nobody --regid nogroup --clear-groups "$@"
    else
        "$@"
    fi
}

setup_file() {
    [ -n "$PROGRAMS" ]
    # Unix sockets and their owner are of short paths and known users.
    SERVER=$(mktemp -d /tmp/draped-backup-XXXXXX)
    SERVER_PORT=$(free_port)
    export SERVER SERVER_PORT
    echo SECRET >"$SERVER/password"
    [ "$(id -u)" != 0 ] || chown -R nobody "$SERVER"
    as_server "$PROGRAMS/initdb" -D "$SERVER/data" -U draped --auth-local=trust \
        --auth-host=scram-sha-256 --pwfile="$SERVER/password" >"$BATS_FILE_TMPDIR/initdb"
    as_server "$PROGRAMS/pg_ctl" -D "$SERVER/data" -l "$SERVER/log" -w start \
        -o "-p $SERVER_PORT -k $SERVER -c listen_addresses=127.0.0.1 -c fsync=off" \
        >"$BATS_FILE_TMPDIR/start" 3>&-
}

teardown_file() {
    [ -z "${SERVER:-}" ] || {
        as_server "$PROGRAMS/pg_ctl" -D "$SERVER/data" -m immediate stop >"$BATS_FILE_TMPDIR/stop" || true
        rm -rf "$SERVER"
    }
}

setup() {
    COPIES=$BATS_TEST_TMPDIR/copies
    ask postgres 'DROP DATABASE IF EXISTS draped'
    ask postgres 'CREATE DATABASE draped'
    export DRAPED_STORE="postgresql://draped:SECRET@127.0.0.1:$SERVER_PORT/draped"
}

teardown() { stop_daemon; }

# ask DATABASE SQL
ask() { psql -XqAt -h "$SERVER" -p "$SERVER_PORT" -U draped -d "$1" -c "$2"; }

# Everything of the store, but when versions were applied.
contents() {
    pg_dump -h "$SERVER" -p "$SERVER_PORT" -U draped -d draped --schema=draped |
        sed -E '/^-- (Dumped|Started|Completed)/d; /^\\(un)?restrict/d'
}

@test "deploy: a PostgreSQL store is backed up while drapes run, and put back with the same rows" {
    start_daemon "$BATS_TEST_TMPDIR/daemon" --lease 3
    call POST /v1/surfaces -H "$JSON" --data-binary "$(jq -c .surface $EXAMPLES/saddle.json)"
    expect 201
    drape 1.0
    kept=$id
    stop_workers
    quick 1.1 | submit
    queued=$id
    "$DRAPED" backup "$COPIES" >"$BATS_TEST_TMPDIR/said"
    grep -q ': schema [0-9]*, 2 drapes, 1 results, 1 surfaces' "$BATS_TEST_TMPDIR/said"
    # Nobody else's hands meanwhile.
    run "$DRAPED" restore "$COPIES"
    [ "$status" = 1 ]
    [[ "$output" == *"stop all of its processes"* ]]
    kill_daemon
    nobody_is_there() { [ "$(ask draped "SELECT count(*) FROM pg_stat_activity WHERE application_name = 'draped'")" = 0 ]; }
    wait_until 20 nobody_is_there
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    drape 1.5
    later=$id
    stop_daemon
    "$DRAPED" restore "$COPIES" >"$BATS_TEST_TMPDIR/said"
    old=$(sed -n 's/^the old store is kept as schema //p' "$BATS_TEST_TMPDIR/said")
    [ "$(ask draped "SELECT count(*) FROM $old.jobs WHERE id = '$later'")" = 1 ]
    # What is there is as it was made, byte for byte, with all that counts.
    contents >"$BATS_TEST_TMPDIR/restored"
    "$DRAPED" backup "$BATS_TEST_TMPDIR/again"
    ask draped "DROP SCHEMA draped CASCADE; DROP SCHEMA $old CASCADE"
    "$DRAPED" restore "$BATS_TEST_TMPDIR/again"
    contents | diff "$BATS_TEST_TMPDIR/restored" - | grep '^[<>]' | not grep -v SEQUENCE
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    result "$kept"
    cmp "$body" "$BATS_TEST_TMPDIR/1.0"
    wait_for "$queued" succeeded
    call GET "/v1/drapes/$later"
    expect 404
    drape 1.5 # counters, sequences and triggers go on
    not grep -E '"event":"store_(error|failed)"' "$HOME_DIR/log"
}

@test "deploy: PostgreSQL with a wrong password, without room, or away: the copies of before stay" {
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    jq -c '.fabric.spacing = 0.05' $EXAMPLES/saddle.json | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
    "$DRAPED" backup "$COPIES"
    before=$(cd "$COPIES" && sha256sum *)
    unharmed() {
        echo "$output"
        [ "$status" = 1 ]
        [[ "$output" != *SECRET* && "$output" != *wr0ng* ]]
        [ "$(cd "$COPIES" && sha256sum *)" = "$before" ]
    }
    for url in "${DRAPED_STORE/SECRET/wr0ng}" "postgresql://draped@127.0.0.1:1/draped" \
        "${DRAPED_STORE%/draped}/nowhere" "${DRAPED_STORE%/draped}/postgres"; do
        DRAPED_STORE=$url run "$DRAPED" backup --keep 1 "$COPIES"
        unharmed
    done
    run bash -c "ulimit -f 1024; exec $DRAPED backup --keep 1 $COPIES"
    unharmed
    stop_daemon
    contents >"$BATS_TEST_TMPDIR/before"
    good=$COPIES/$(copies) bad=$BATS_TEST_TMPDIR/bad
    size=$(stat -c %s "$good")
    damages=("head -c $((size / 2))" "head -c $((size - 4))" "sed s/PGDMP/PGDUM/")
    for damage in "${damages[@]}"; do
        LC_ALL=C $damage "$good" >"$bad"
        run "$DRAPED" restore "$bad"
        unharmed
        contents | cmp - "$BATS_TEST_TMPDIR/before"
    done
    cp "$good" "$bad"
    printf 'draped' | dd of="$bad" bs=1 seek=$((size / 2)) conv=notrunc status=none
    run "$DRAPED" restore "$bad"
    unharmed
    contents | cmp - "$BATS_TEST_TMPDIR/before"
    # A copy of another version's tables.
    ask draped 'UPDATE draped.schema_version SET version = 99'
    "$DRAPED" backup "$BATS_TEST_TMPDIR/strange"
    ask draped 'UPDATE draped.schema_version SET version = 13'
    run "$DRAPED" restore "$BATS_TEST_TMPDIR/strange"
    unharmed
    [[ "$output" == *"made by another version of draped"* ]]
    contents | cmp - "$BATS_TEST_TMPDIR/before"
    # One kind of store is not the other.
    run "$DRAPED" restore --store "$BATS_TEST_TMPDIR/some.db" "$good"
    unharmed
}

@test "deploy: without PostgreSQL's programs it is said what to install, and of the password nothing" {
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    PATH=$BATS_TEST_TMPDIR run "$DRAPED" backup "$COPIES"
    [ "$status" = 1 ]
    [[ "$output" == *"pg_dump cannot be started: install PostgreSQL's client programs"* ]]
    [ -z "$(ls "$COPIES")" ]
    # What everybody can read of a program that runs.
    mkdir "$BATS_TEST_TMPDIR/spy"
    printf '#!/bin/sh\necho "$0 $*" >"%s/arguments"\nexit 1\n' "$BATS_TEST_TMPDIR" >"$BATS_TEST_TMPDIR/spy/pg_dump"
    chmod +x "$BATS_TEST_TMPDIR/spy/pg_dump"
    PATH=$BATS_TEST_TMPDIR/spy:$PATH run "$DRAPED" backup "$COPIES"
    [ "$status" = 1 ]
    grep -q -- '--format=custom' "$BATS_TEST_TMPDIR/arguments"
    not grep SECRET "$BATS_TEST_TMPDIR/arguments"
}

@test "deploy: a restore into PostgreSQL that is killed at any moment leaves the old store or the new one" {
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    jq -c '.fabric.spacing = 0.03' $EXAMPLES/saddle.json | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
    "$DRAPED" backup "$COPIES"
    drape 1.0
    stop_daemon
    from=$(date +%s%N)
    "$DRAPED" restore "$COPIES"
    to=$(date +%s%N)
    for k in 1 2 3 4 5 6; do
        "$DRAPED" restore "$COPIES" >"$BATS_TEST_TMPDIR/said" 2>&1 3>&- &
        sleep "$(((to - from) * k / 6 / 1000000))e-3"
        kill -KILL $! 2>/dev/null || true
        wait $! || true
        [ "$(ask draped 'SELECT count(*) FROM draped.jobs')" = 1 ]
        [ "$(ask draped 'SELECT sum(length) = (SELECT sum(octet_length(bytes)) FROM draped.chunks) FROM draped.results')" = t ]
    done
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    drape 1.0
}
