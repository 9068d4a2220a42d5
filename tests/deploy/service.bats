# SPDX-License-Identifier: MIT
# What the daemon has to do with a service manager: readiness, signs of life, an inherited socket,
# the health check; and the units themselves, checked by systemd's own tools.
load helper

teardown() {
    local failed=0
    stop_daemon || failed=1
    [ -z "${LISTENER:-}" ] || { kill "$LISTENER"; wait "$LISTENER" || true; }
    return $failed
}

# listen_for_notices ADDRESS: writes what the daemon tells into $NOTICES, a notice a line.
listen_for_notices() {
    NOTICES=$BATS_TEST_TMPDIR/notices
    : >"$NOTICES"
    python3 - "$1" >"$NOTICES" 3>&- <<'END' &
import socket, sys
server = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
server.bind(sys.argv[1].replace("@", "\0", 1))
print("listening", flush=True)
while True:
    print(server.recv(4096).decode().replace("\n", " "), flush=True)
END
    LISTENER=$!
    wait_until 10 grep -q listening "$NOTICES"
}

told() { grep -q "$1" "$NOTICES"; }
told_times() { [ "$(grep -c "$1" "$NOTICES")" -ge "$2" ]; }

@test "deploy: the daemon tells when it is ready, alive and stopping" {
    listen_for_notices "$BATS_TEST_TMPDIR/socket"
    NOTIFY_SOCKET=$BATS_TEST_TMPDIR/socket WATCHDOG_USEC=200000 \
        start_daemon "$BATS_TEST_TMPDIR/daemon"
    wait_until 10 told '^READY=1'
    wait_until 10 told_times '^WATCHDOG=1$' 3
    stop_daemon
    wait_until 10 told '^STOPPING=1'
    # Ready first, stopping last.
    [[ "$(sed -n 2p "$NOTICES")" == READY=1* ]]
    [[ "$(tail -1 "$NOTICES")" == STOPPING=1* ]]
}

@test "deploy: the daemon tells of a reload, whatever becomes of it" {
    listen_for_notices "$BATS_TEST_TMPDIR/socket"
    "$DRAPED" hash-token anna write --generate >"$BATS_TEST_TMPDIR/tokens" 2>/dev/null
    NOTIFY_SOCKET=$BATS_TEST_TMPDIR/socket \
        start_daemon "$BATS_TEST_TMPDIR/daemon" --tokens "$BATS_TEST_TMPDIR/tokens"
    wait_until 10 told_times '^READY=1' 1
    kill -HUP "$DAEMON"
    wait_until 10 told_times '^READY=1' 2
    echo nonsense >"$BATS_TEST_TMPDIR/tokens"
    kill -HUP "$DAEMON"
    wait_until 10 told_times '^READY=1' 3
    # By the clock that began with the machine, as systemd reads it.
    [[ "$(sed -n 3p "$NOTICES")" =~ ^RELOADING=1\ MONOTONIC_USEC=([0-9]+)\  ]]
    local since_boot
    since_boot=$(python3 -c 'import time; print(int(time.monotonic()))')
    [ "$((BASH_REMATCH[1] / 1000000))" -le "$((since_boot + 1))" ]
    [ "$((BASH_REMATCH[1] / 1000000))" -ge "$((since_boot - 60))" ]
    [[ "$(sed -n 4p "$NOTICES")" == READY=1* ]]
    [[ "$(sed -n 5p "$NOTICES")" == RELOADING=1* ]]
    [[ "$(sed -n 6p "$NOTICES")" == READY=1* ]]
    stop_daemon
}

@test "deploy: a daemon that stands still gives no sign of life" {
    listen_for_notices "@draped-test-$$-$BATS_TEST_NUMBER"
    NOTIFY_SOCKET=@draped-test-$$-$BATS_TEST_NUMBER WATCHDOG_USEC=100000 \
        start_daemon "$BATS_TEST_TMPDIR/daemon"
    wait_until 10 told '^WATCHDOG=1$'
    kill -STOP "$DAEMON"
    sleep 0.3 # what was under way has arrived
    before=$(wc -l <"$NOTICES")
    sleep 0.6
    after=$(wc -l <"$NOTICES")
    kill -CONT "$DAEMON"
    [ "$before" = "$after" ]
    wait_until 10 told_times '^WATCHDOG=1$' "$((before + 1))"
}

# The socket is shared with the process that opened it: when that shuts it down, all threads of the
# daemon live, and nobody can call it.
@test "deploy: a daemon that cannot be called gives no sign of life" {
    listen_for_notices "$BATS_TEST_TMPDIR/socket"
    python3 - "$DRAPED" "$BATS_TEST_TMPDIR" "$NOTICES" <<'END'
import os, re, signal, socket, subprocess, sys, time
draped, folder, notices = sys.argv[1:]
door = socket.socket()
door.bind(("127.0.0.1", 0))
door.listen()
def hand_over():
    os.dup2(door.fileno(), 3)
    os.environ.update(LISTEN_FDS="1", LISTEN_PID=str(os.getpid()), WATCHDOG_USEC="200000",
                      NOTIFY_SOCKET=folder + "/socket")
pid = os.fork()
if pid == 0:
    hand_over()
    os.dup2(os.open(folder + "/log", os.O_WRONLY | os.O_CREAT | os.O_APPEND), 2)
    os.execv(draped, [draped, "--data", folder + "/data", "--workers", "1"])
def signs():
    with open(notices) as file:
        return len(re.findall("^WATCHDOG=1$", file.read(), re.M))
def soon(done):
    end = time.monotonic() + 40
    while not done() and time.monotonic() < end:
        time.sleep(0.05)
    assert done()
soon(lambda: signs() >= 3)
door.shutdown(socket.SHUT_RDWR)
soon(lambda: '"event":"no_answer"' in open(folder + "/log").read())
before = signs()
time.sleep(1)
assert signs() == before, "it shows life"
os.kill(pid, signal.SIGTERM)
assert os.waitpid(pid, 0)[1] == 0
END
}

@test "deploy: without a watchdog for this process there are no signs of life" {
    listen_for_notices "$BATS_TEST_TMPDIR/socket"
    NOTIFY_SOCKET=$BATS_TEST_TMPDIR/socket WATCHDOG_USEC=100000 WATCHDOG_PID=1 \
        start_daemon "$BATS_TEST_TMPDIR/daemon"
    wait_until 10 told '^READY=1'
    sleep 0.4
    not told WATCHDOG
}

@test "deploy: a manager that cannot be told costs a line in the log, not the service" {
    for address in "$BATS_TEST_TMPDIR/nobody" relative; do
        NOTIFY_SOCKET=$address start_daemon "$BATS_TEST_TMPDIR/daemon"
        call GET /healthz
        expect 200
        stop_daemon
    done
    [ "$(grep -c '"event":"notify_failed"' "$HOME_DIR/log")" -ge 2 ]
}

# activate ADDRESS [FLAG...]: a daemon on a socket that systemd's own tool opens; it starts with the
# first caller.
activate() {
    local address=$1
    shift
    HOME_DIR=$BATS_TEST_TMPDIR/activated
    mkdir -p "$HOME_DIR"
    systemd-socket-activate -E DRAPED_DATA="$HOME_DIR/data" --listen="$address" "$DRAPED" "$@" \
        >"$HOME_DIR/out" 2>"$HOME_DIR/log" 3>&- &
    DAEMON=$!
    wait_until 10 grep -q 'Listening on' "$HOME_DIR/log"
}

@test "deploy: an inherited socket goes before --listen" {
    PORT=$(free_port)
    activate "127.0.0.1:$PORT" --listen 127.0.0.1:1
    URL=http://127.0.0.1:$PORT
    post /v1/drapes $EXAMPLES/saddle.json -H 'Prefer: wait=30'
    expect 200
    grep -qx "draped listening on http://127.0.0.1:$PORT" "$HOME_DIR/out"
    stop_daemon
}

@test "deploy: callers wait in an inherited socket for the next daemon" {
    # The holder of the socket starts one daemon after the other on it, as systemd does.
    cat >"$BATS_TEST_TMPDIR/holder.py" <<'END'
import os, socket, subprocess, sys
held = socket.socket()
held.bind(("127.0.0.1", 0))
held.listen(16)
os.dup2(held.fileno(), 3, inheritable=True)
print(held.getsockname()[1], flush=True)
for line in sys.stdin: # a line starts a daemon, the next one ends it
    daemon = subprocess.Popen(["sh", "-c", "LISTEN_PID=$$ LISTEN_FDS=1 exec \"$@\"", "sh"] + sys.argv[1:],
                              pass_fds=(3,), stdout=subprocess.PIPE, text=True)
    print(daemon.stdout.readline().strip(), flush=True)
    sys.stdin.readline()
    daemon.terminate()
    print(daemon.wait(40), flush=True)
END
    mkfifo "$BATS_TEST_TMPDIR/orders"
    python3 -u "$BATS_TEST_TMPDIR/holder.py" "$DRAPED" --data "$BATS_TEST_TMPDIR/data" \
        <"$BATS_TEST_TMPDIR/orders" >"$BATS_TEST_TMPDIR/answers" 2>"$BATS_TEST_TMPDIR/log" 3>&- &
    LISTENER=$!
    exec 8>"$BATS_TEST_TMPDIR/orders"
    answers() { [ "$(wc -l <"$BATS_TEST_TMPDIR/answers")" -ge "$1" ]; }
    wait_until 10 answers 1
    PORT=$(head -1 "$BATS_TEST_TMPDIR/answers") URL=http://127.0.0.1:$PORT
    echo start >&8
    wait_until 20 answers 2
    call GET /healthz
    expect 200
    echo stop >&8
    wait_until 40 answers 3
    [ "$(sed -n 3p "$BATS_TEST_TMPDIR/answers")" = 0 ]
    # Nobody serves now: the call waits, and is answered.
    curl -sS --max-time 50 -o "$BATS_TEST_TMPDIR/late" "$URL/healthz" 3>&- &
    local caller=$!
    echo start >&8
    wait "$caller"
    grep -q ok "$BATS_TEST_TMPDIR/late"
    echo stop >&8
    wait_until 40 answers 5
    [ "$(sed -n 5p "$BATS_TEST_TMPDIR/answers")" = 0 ]
    exec 8>&-
    wait "$LISTENER"
    LISTENER=
}

@test "deploy: an inherited socket beyond loopback asks for tokens, others are refused" {
    PORT=$(free_port)
    activate "0.0.0.0:$PORT"
    run curl -sS --max-time 10 "http://127.0.0.1:$PORT/healthz"
    [ "$status" -ne 0 ]
    status=0
    join_daemon || status=$? # not by `run`, whose shell did not start it
    [ "$status" = 2 ]
    grep -q 'tokens' "$HOME_DIR/log"
    # More than one socket, and one that is not TCP.
    run sh -c 'LISTEN_PID=$$ LISTEN_FDS=2 exec "$@" 3</dev/null' sh "$DRAPED" --check-config
    [ "$status" = 2 ]
    [[ "$output" == *"one socket"* ]]
    run sh -c 'LISTEN_PID=$$ LISTEN_FDS=1 exec "$@" 3</dev/null' sh "$DRAPED" --check-config
    [ "$status" = 2 ]
    [[ "$output" == *"not a listening TCP socket"* ]]
    # Meant for another process.
    LISTEN_PID=1 LISTEN_FDS=1 "$DRAPED" --check-config | grep -qx 'listen = 127.0.0.1:8080'
}

@test "deploy: the health check asks the daemon" {
    start_daemon "$BATS_TEST_TMPDIR/daemon"
    "$DRAPED" --listen "127.0.0.1:$PORT" --healthcheck
    DRAPED_LISTEN=127.0.0.1:$PORT "$DRAPED" --healthcheck
    stop_daemon
    run "$DRAPED" --listen "127.0.0.1:$PORT" --healthcheck
    [ "$status" = 1 ]
    [[ "$output" == *refused* ]]
    # Somebody else's server, which does not answer as draped does.
    PORT=$(free_port)
    python3 -m http.server --bind 127.0.0.1 --directory "$BATS_TEST_TMPDIR" "$PORT" \
        >"$BATS_TEST_TMPDIR/other" 2>&1 3>&- &
    LISTENER=$!
    other_answers() { curl -s -o /dev/null "http://127.0.0.1:$PORT/"; }
    wait_until 10 other_answers
    run "$DRAPED" --listen "127.0.0.1:$PORT" --healthcheck
    [ "$status" = 1 ]
    [[ "$output" == *"not 200"* ]]
}

# ---- units

@test "deploy: make install puts programs, units and pages below DESTDIR" {
    make -s install B="${BUILD:-build}" DESTDIR="$BATS_TEST_TMPDIR/root" PREFIX=/opt/draped
    cd "$BATS_TEST_TMPDIR/root"
    [ -z "$(find . -type f -not -path './opt/draped/*')" ]
    opt/draped/bin/draped --version
    opt/draped/bin/drape --version
    grep -qx 'ExecStart=/opt/draped/bin/draped' opt/draped/lib/systemd/system/draped.service
    # Every flag is on the page, and the pages are sound.
    opt/draped/bin/draped --help | grep -oE '^  --[a-z-]+' | while read -r flag; do
        grep -qF -- "${flag//-/\\-}" opt/draped/share/man/man1/draped.1 || { echo "$flag"; false; }
    done
    for page in opt/draped/share/man/man1/*.1; do
        [ -z "$(LC_ALL=C.UTF-8 MANROFFSEQ= man --warnings -E UTF-8 -l "$page" 2>&1 >/dev/null)" ]
    done
}

@test "deploy: systemd takes the units, and finds them well locked in" {
    root=$BATS_TEST_TMPDIR/root
    make -s install B="${BUILD:-build}" DESTDIR="$root" PREFIX=/usr
    mkdir -p "$root/etc/systemd/system/draped.service.d"
    cp deploy/systemd/drop-ins/*.conf "$root/etc/systemd/system/draped.service.d"
    install -D -t "$root/bin" /bin/kill
    for target in sysinit basic network network-online multi-user sockets shutdown; do
        printf '[Unit]\nDescription=%s\n' "$target" >"$root/usr/lib/systemd/system/$target.target"
    done
    run systemd-analyze verify --man=no --root="$root" draped.service draped.socket
    echo "$output"
    [ "$status" = 0 ]
    [ -z "$output" ]
    # 1.5 of 10, where 10 is all doors open; also with the drop-ins.
    systemd-analyze security --no-pager --offline=true --threshold=15 \
        deploy/systemd/draped.service
    systemd-analyze security --no-pager --offline=true --threshold=15 --root="$root" \
        draped.service
}

@test "deploy: sysusers makes the account" {
    root=$BATS_TEST_TMPDIR/root
    mkdir -p "$root/etc"
    systemd-sysusers --root="$root" "$PWD/deploy/systemd/draped.sysusers"
    grep -qE '^draped:x?!?\*?:[0-9]+:[0-9]+:draping of woven fabric:/var/lib/draped:/usr/sbin/nologin$' \
        "$root/etc/passwd"
}
