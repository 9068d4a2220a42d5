# SPDX-License-Identifier: MIT
# Whether /readyz, draped_store_up and POST say what a store can do that answers but is of no use: read-only,
# full, without a table or a column. On PostgreSQL, in two roles, and on SQLite.
load helper
load ../postgres

setup_file() {
    CLUSTER=$(mktemp -d /tmp/draped-health-XXXXXX)
    SERVER_PORT=$(free_port)
    export CLUSTER SERVER_PORT
    chmod 755 "$CLUSTER"
    postgres_make "$CLUSTER"
    echo "port = $SERVER_PORT" | as_postgres tee -a "$CLUSTER/data/postgresql.conf" >"$BATS_FILE_TMPDIR/tee"
    PGPORT=$SERVER_PORT postgres_start "$CLUSTER" 127.0.0.1
    export POSTGRES
}
teardown_file() {
    postgres_stop
    rm -rf "${CLUSTER:-/nonexistent}"
}

# ask DATABASE SQL...
ask() {
    local database=$1
    shift
    psql -XqAt -h "$CLUSTER" -p "$SERVER_PORT" -U draped -d "$database" "${@/#/-c}"
}

start_api() {
    ask postgres 'DROP DATABASE IF EXISTS draped WITH (FORCE)' "CREATE DATABASE draped ${1:-}"
    start_daemon "$BATS_TEST_TMPDIR/daemon" --role api \
        --store "postgresql://draped@127.0.0.1:$SERVER_PORT/draped"
    ready
    metric draped_store_up | grep -qx 1
}
teardown() {
    local failed=0
    stop_daemon || failed=1
    [ -z "${SMALL:-}" ] || { ask postgres 'DROP DATABASE draped WITH (FORCE)' 'DROP TABLESPACE small'; umount "$SMALL"; }
    return $failed
}

ready() { call GET /readyz; [ "$status" = 200 ]; }
unready() { call GET /readyz; [ "$status" = 503 ]; }
refused() {
    quick "1.$RANDOM$RANDOM" | post /v1/drapes -
    expect 503
}

# It is of no use now: everybody is told, and errors are counted.
useless() {
    refused
    wait_until 30 unready
    [ "$(metric draped_store_up)" = 0 ]
    refused
    [ "$(curl -sS "$URL/metrics" | awk '/^draped_store_errors_total/ {n += $2} END {print n}')" -gt 0 ]
    [ "$(grep -c '"event":"store_unusable"' "$HOME_DIR/log")" -ge 1 ]
}
# And now it is of use again.
useful() {
    wait_until 30 ready
    [ "$(metric draped_store_up)" = 1 ]
    quick "2.$RANDOM" | submit
}

@test "deploy: PostgreSQL that has become read-only is not ready, and takes nothing" {
    start_api
    ask postgres 'ALTER SYSTEM SET default_transaction_read_only = on' 'SELECT pg_reload_conf()'
    read_only() { [ "$(ask draped 'SHOW default_transaction_read_only')" = on ]; }
    wait_until 30 read_only
    wait_until 30 unready # each of its connections hears of it by itself
    useless
    ask postgres 'SET default_transaction_read_only = off; ALTER SYSTEM RESET default_transaction_read_only' \
        2>"$BATS_TEST_TMPDIR/alter" || PGOPTIONS='-c default_transaction_read_only=off' \
        ask postgres 'ALTER SYSTEM RESET default_transaction_read_only'
    PGOPTIONS='-c default_transaction_read_only=off' ask postgres 'SELECT pg_reload_conf()'
    useful
}

@test "deploy: PostgreSQL without a table or a column that claims need takes nothing, from the first call on" {
    start_api
    for change in 'TABLE draped.chunks RENAME TO lumps' 'TABLE draped.results RENAME TO outcomes' \
        'TABLE draped.owners RENAME COLUMN turn TO shift' 'TABLE draped.jobs RENAME COLUMN lease TO loan'; do
        ask draped "ALTER $change"
        useless
        case $change in
        *COLUMN*) ask draped "ALTER $(sed -E 's/COLUMN (.*) TO (.*)/COLUMN \2 TO \1/' <<<"$change")" ;;
        *) ask draped "ALTER $(sed -E 's/draped\.(.*) RENAME TO (.*)/draped.\2 RENAME TO \1/' <<<"$change")" ;;
        esac
        useful
    done
}

@test "deploy: PostgreSQL whose disk is full is not ready until there is room" {
    [ "$(id -u)" = 0 ] || skip 'only root can make a small disk'
    SMALL=$CLUSTER/small
    mkdir "$SMALL"
    mount -t tmpfs -o size=16m tmpfs "$SMALL" || skip 'this system lets nobody mount'
    chown postgres "$SMALL"
    chmod 700 "$SMALL"
    ask postgres "CREATE TABLESPACE small LOCATION '$SMALL'"
    start_api 'TABLESPACE small'
    head -c 20000000 /dev/zero 2>&- | as_postgres dd of="$SMALL/filler" status=none 2>"$BATS_TEST_TMPDIR/dd" || true
    fills() { quick "1.$RANDOM$RANDOM" | jq -c '.surface.name = ("x" * 30000)' | post /v1/drapes -; [ "$status" = 503 ]; }
    wait_until 30 fills
    wait_until 30 unready
    [ "$(metric draped_store_up)" = 0 ]
    sleep 3 # one beat and more: it does not take a row written over for room
    unready
    refused
    as_postgres rm "$SMALL/filler"
    useful
}

@test "deploy: SQLite with a column that claims need renamed is not ready, and takes nothing" {
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    for change in 'jobs lease loan' 'chunks bytes lump' 'owners turn shift'; do
        set -- $change
        sqlite3 "$HOME_DIR/data/draped.db" "PRAGMA legacy_alter_table = ON; ALTER TABLE $1 RENAME COLUMN $2 TO $3"
        wait_until 30 unready
        refused
        [ "$(metric draped_store_up)" = 0 ]
        sqlite3 "$HOME_DIR/data/draped.db" "PRAGMA legacy_alter_table = ON; ALTER TABLE $1 RENAME COLUMN $3 TO $2"
        wait_until 30 ready
    done
    quick 3 | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
}
