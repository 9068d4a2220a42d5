# SPDX-License-Identifier: MIT
# For the tests of the daemon: each file loads this. The daemon is $DRAPED, by default the one in
# the folder $BUILD (by default build); every daemon has a port and a data folder of its own.

# The last part of a pipe runs in this shell, so that it can set variables.
shopt -s lastpipe

cd "$BATS_TEST_DIRNAME/../.." || exit 1
DRAPED=${DRAPED:-${BUILD:-build}/draped}
DRAPE=${DRAPE:-${BUILD:-build}/drape}
EXAMPLES=api/examples
JSON='Content-Type: application/json'

# not COMMAND...: as `!`, which by itself never fails a test.
not() { ! "$@"; }

# wait_until SECONDS COMMAND...: until the command succeeds; false when the time is up.
wait_until() {
    local end=$((SECONDS + $1))
    shift
    until "$@"; do
        [ "$SECONDS" -lt "$end" ] || return 1
        sleep 0.05
    done
}

says_where() {
    grep -q '^draped listening on http://' "$HOME_DIR/out" || ! kill -0 "$DAEMON" 2>/dev/null
}

# start_daemon FOLDER [FLAG...]: sets DAEMON (the process), URL and PORT.
start_daemon() {
    HOME_DIR=$1
    shift
    mkdir -p "$HOME_DIR"
    : >"$HOME_DIR/out"
    "$DRAPED" --listen 127.0.0.1:0 --data "$HOME_DIR/data" "$@" \
        >"$HOME_DIR/out" 2>>"$HOME_DIR/log" 3>&- &
    DAEMON=$!
    wait_until 20 says_where
    URL=$(sed -n 's/^draped listening on //p' "$HOME_DIR/out")
    PORT=${URL##*:}
    [ -n "$URL" ] || { tail -5 "$HOME_DIR/log"; return 1; }
}

gone() { ! kill -0 "$1" 2>/dev/null; }

# join_daemon: waits for its end; the exit status. After 30 s it is killed and has failed.
join_daemon() {
    local process=$DAEMON
    DAEMON=
    wait_until 30 gone "$process" || kill -KILL "$process"
    wait "$process"
}

stop_daemon() {
    [ -n "${DAEMON:-}" ] || return 0
    kill -TERM "$DAEMON" 2>/dev/null
    join_daemon || {
        local status=$?
        echo "the daemon ended with status $status; its log ends:"
        tail -30 "$HOME_DIR/log"
        return "$status"
    }
}

kill_daemon() {
    kill -KILL "$DAEMON"
    wait "$DAEMON" 2>/dev/null || true
    DAEMON=
}

# Most files share one daemon among their tests.
start_shared_daemon() {
    start_daemon "$BATS_FILE_TMPDIR/daemon" "$@"
    export DAEMON URL PORT HOME_DIR
}

# keep_answer METHOD PATH: sets body and headers, the files of an answer that is kept until the file
# of tests ends, where `keep_contract` holds all of them to the contract. Large ones are dropped.
keep_answer() {
    local name=${BATS_TEST_NUMBER:-0}-$BASHPID-$((ANSWERS += 1)) folder=$BATS_FILE_TMPDIR/answers
    [ -d "$folder" ] || mkdir -p "$folder"
    [ ! -f "${body:-}" ] || [ "$(stat -c %s "$body")" -lt 3000000 ] || rm "$body"
    echo "$1 $2" >"$folder/$name"
    body=$folder/$name.body headers=$folder/$name.headers
}

# The answers of this file of tests are those of api/openapi.yaml.
keep_contract() {
    [ ! -d "$BATS_FILE_TMPDIR/answers" ] || command node tests/http/contract.mjs "$BATS_FILE_TMPDIR/answers"
}

# Of files with a daemon of their own; others say it themselves.
end_file() {
    local failed=0
    keep_contract || failed=1
    stop_daemon || failed=1
    return $failed
}

# call METHOD PATH [CURL OPTION...]: sets status, body (a file), headers (a file).
call() {
    local method=$1 path=$2
    shift 2
    keep_answer "$method" "$path"
    : >"$body"
    : >"$headers"
    local arguments=(-X "$method")
    [ "$method" != HEAD ] || arguments=(--head)
    status=$(curl -sS --max-time 50 -o "$body" -D "$headers" -w '%{http_code}' \
        "${arguments[@]}" "$@" "$URL$path")
}

# post PATH FILE [CURL OPTION...]: a JSON document; - is the standard input.
post() {
    local path=$1 file=$2
    shift 2
    call POST "$path" -H "$JSON" --data-binary "@$file" "$@"
}

# header NAME: its value in the last answer.
header() {
    tr -d '\r' <"$headers" | awk -F': ' -v name="$1" \
        'tolower($1) == tolower(name) {print substr($0, length($1) + 3); exit}'
}

# field FILTER: of the JSON body.
field() { jq -er "$1" "$body"; }

# expect STATUS: of the last answer; shows it when it is another.
expect() {
    [ "$status" = "$1" ] || { echo "status $status, not $1:"; head -c 2000 "$body"; return 1; }
}

# expect_problem STATUS SLUG: the whole of what a problem has to be.
expect_problem() {
    expect "$1"
    [ "$(header Content-Type)" = application/problem+json ]
    jq -e --arg type "/problems/$2" --argjson status "$1" --arg id "$(header X-Request-Id)" \
        '.type == $type and .status == $status and (.title | length > 0) and
         (.detail | length > 0) and .request_id == $id' "$body" >/dev/null ||
        { cat "$body"; return 1; }
}

# drape_plane EXPRESSION [ARGUMENT...]: the laminate $plane, changed by jq, by the command.
drape_plane() {
    jq -c "$1" <<<"$plane" >"$BATS_TEST_TMPDIR/laminate.json"
    shift
    status=0
    output=$("$DRAPE" "$BATS_TEST_TMPDIR/laminate.json" "$@" 2>"$BATS_TEST_TMPDIR/stderr") || status=$?
    stderr=$(<"$BATS_TEST_TMPDIR/stderr")
}

# number EXPRESSION VALUE [WITHIN]: of the first ply of its output.
number() {
    jq -e ".plies[0] | ($1) - ($2) | fabs < ${3:-1e-9}" <<<"$output" >/dev/null ||
        { jq -c ".plies[0] | $1" <<<"$output" && false; }
}

# A drape of a few milliseconds; another FACTOR is another request.
quick() { jq -c --argjson factor "$1" '.fabric.spacing = 0.2 * $factor' $EXAMPLES/saddle.json; }

# A drape of some seconds and two million nodes.
slow() { jq -c --argjson factor "$1" '.fabric.spacing = 0.004 * $factor' $EXAMPLES/saddle.json; }

# The worker processes of the daemon. One that is stopped by a signal makes a drape that runs for
# as long as a test wants.
workers() {
    local pid
    for pid in $(cat /proc/"$DAEMON"/task/*/children); do
        [[ "$(tr -s '\0' ' ' 2>/dev/null </proc/"$pid"/cmdline)" != 'draped worker '* ]] || echo "$pid"
    done
}
# Whether so many connections to the daemon are open.
connected() { [ "$(grep -ci " 0100007F:$(printf %04X "$PORT") [0-9A-F:]* 01 " /proc/net/tcp)" -ge "$1" ]; }
# Whether so many of its checkers are at work.
checking() {
    local pid busy=0
    for pid in $(cat /proc/"$DAEMON"/task/*/children); do
        if [ "$(tr -s '\0' ' ' 2>/dev/null </proc/"$pid"/cmdline)" = "draped checker " ] &&
            grep -q ') R ' "/proc/$pid/stat"; then
            busy=$((busy + 1))
        fi
    done
    [ "$busy" -ge "$1" ]
}
a_worker() { [ -n "$(workers)" ]; }
stop_workers() {
    wait_until 10 a_worker
    kill -STOP $(workers)
}

# submit: a drape from the standard input; sets id.
submit() {
    post /v1/drapes - "$@"
    expect 202
    id=$(field .id)
}

# wait_for ID STATUS: at most 40 s.
wait_for() {
    call GET "/v1/drapes/$1?wait=40"
    expect 200
    [ "$(field .status)" = "$2" ] || { cat "$body"; return 1; }
}

# Whether the drape has that status now.
has_status() {
    call GET "/v1/drapes/$1"
    [ "$(field .status)" = "$2" ]
}

# metric NAME: its value.
metric() { curl -sS --max-time 20 "$URL/metrics" | awk -v name="$1" '$1 == name {print $2}'; }
