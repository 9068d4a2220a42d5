# SPDX-License-Identifier: MIT
# A PostgreSQL server for tests in bash, in a folder of its own. As root it runs as the user
# `postgres`, because it refuses to be root.

PG_BIN=$(printf '%s\n' /usr/lib/postgresql/*/bin | tail -n 1)

# as_postgres COMMAND...
as_postgres() {
    if [ "$(id -u)" -eq 0 ]; then
        setpriv --reuid=postgres --regid=postgres --clear-groups "$@"
    else
        "$@"
    fi
}

# postgres_make FOLDER: a cluster with the user `draped` (who needs no password) in FOLDER/data.
postgres_make() {
    mkdir -p "$1"
    [ "$(id -u)" -ne 0 ] || chown postgres "$1"
    (cd "$1" && LC_ALL=C.UTF-8 as_postgres "$PG_BIN/initdb" -D "$1/data" -U draped -A trust -E UTF8) \
        >"$1/initdb" 2>&1 || { cat "$1/initdb"; return 1; }
    echo 'host all all all trust' | as_postgres tee -a "$1/data/pg_hba.conf" >/dev/null
}

# postgres_start FOLDER ADDRESS [COMMAND...]: sets POSTGRES, its process; COMMAND runs it (somewhere
# else). With ADDRESS "" it listens on a socket in FOLDER alone.
postgres_start() {
    local folder=$1 address=$2
    shift 2
    (cd "$folder" && exec "$@" setpriv $([ "$(id -u)" -ne 0 ] ||
        echo --reuid=postgres --regid=postgres --clear-groups) --pdeathsig INT \
        "$PG_BIN/postgres" -D "$folder/data" -k "$folder" -c listen_addresses="$address" \
        -c max_connections=200) >>"$folder/log" 2>&1 3>&- &
    POSTGRES=$!
    local end=$((SECONDS + 60))
    until "$PG_BIN/pg_isready" -q -h "$folder" -d postgres; do
        kill -0 "$POSTGRES" 2>/dev/null && [ "$SECONDS" -lt "$end" ] ||
            { tail -5 "$folder/log"; return 1; }
        sleep 0.05
    done
}

# postgres_stop [SIGNAL]: INT sends everybody away; QUIT is a crash.
postgres_stop() {
    [ -n "${POSTGRES:-}" ] || return 0
    kill -"${1:-INT}" "$POSTGRES" 2>/dev/null || true
    wait "$POSTGRES" 2>/dev/null || true
    POSTGRES=
}
