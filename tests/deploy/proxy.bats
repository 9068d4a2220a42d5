# SPDX-License-Identifier: MIT
# deploy/nginx.conf and deploy/Caddyfile in front of a running daemon, over TLS. What is changed for
# the test: names, ports and the certificate.
load helper

setup_file() {
    start_shared_daemon
    export CERT=$BATS_FILE_TMPDIR/cert.pem KEY=$BATS_FILE_TMPDIR/key.pem BACKEND=$PORT
    openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 \
        -subj /CN=localhost -addext subjectAltName=IP:127.0.0.1,DNS:localhost \
        -out "$CERT" -keyout "$KEY" 2>"$BATS_FILE_TMPDIR/openssl"
}
teardown_file() { stop_daemon; }

teardown() {
    [ -z "${WORKERS:-}" ] || kill -CONT $WORKERS 2>/dev/null || true
    [ -z "${PROXY:-}" ] || { kill -TERM "$PROXY"; wait "$PROXY" || true; }
}

answers() { curl -s --cacert "$CERT" -o /dev/null --max-time 5 "$URL/healthz"; }

# Waits until the proxy that was started answers; calls go through it from then on.
use_proxy() {
    PROXY=$!
    URL=https://localhost:$TLS
    export CURL_CA_BUNDLE=$CERT
    wait_until 20 answers || { cat "$PREFIX"/*log; return 1; }
}

start_nginx() {
    PREFIX=$BATS_TEST_TMPDIR/nginx TLS=$(free_port) PLAIN=$(free_port)
    mkdir -p "$PREFIX"
    {
        [ "$(id -u)" -ne 0 ] || echo "user $(id -un);"
        echo "daemon off; pid $PREFIX/pid; error_log $PREFIX/error.log;"
        echo "events {} http { access_log $PREFIX/access.log;"
        for kind in client_body proxy fastcgi uwsgi scgi; do
            echo "${kind}_temp_path $PREFIX/$kind;"
        done
        sed -e "s|127.0.0.1:8080|127.0.0.1:$BACKEND|" -e "s|/etc/ssl/draped/fullchain.pem|$CERT|" \
            -e "s|/etc/ssl/draped/key.pem|$KEY|" -e '/listen \[::\]/d' \
            -e "s|listen 443|listen 127.0.0.1:$TLS|" -e "s|listen 80|listen 127.0.0.1:$PLAIN|" \
            -e 's|draped\.example|localhost|' deploy/nginx.conf
        echo '}'
    } >"$PREFIX/nginx.conf"
    build/tools/nginx -p "$PREFIX" -e "$PREFIX/error.log" -c "$PREFIX/nginx.conf" 3>&- &
    use_proxy
}

start_caddy() {
    PREFIX=$BATS_TEST_TMPDIR/caddy TLS=$(free_port)
    mkdir -p "$PREFIX"
    sed -e "s|127.0.0.1:8080|127.0.0.1:$BACKEND|" \
        -e "s|^draped.example {|https://localhost:$TLS {\n\ttls $CERT $KEY|" \
        -e '0,/^{/s//{\n\tadmin off\n\tauto_https disable_redirects/' \
        deploy/Caddyfile >"$PREFIX/Caddyfile"
    HOME=$PREFIX XDG_DATA_HOME=$PREFIX XDG_CONFIG_HOME=$PREFIX build/tools/caddy run \
        --adapter caddyfile --config "$PREFIX/Caddyfile" 2>"$PREFIX/caddy.log" 3>&- &
    use_proxy
}

# A drape goes through, with the same bytes as without the proxy.
expect_drape() {
    post /v1/drapes $EXAMPLES/saddle.json -H 'Prefer: wait=30'
    expect 200
    id=$(field .id)
    call GET "/v1/drapes/$id/result?format=csv" -H 'Accept-Encoding: identity'
    expect 200
    curl -sS "http://127.0.0.1:$BACKEND/v1/drapes/$id/result?format=csv" | cmp - "$body"
}

# The first event arrives while the drape cannot end, since its worker stands still.
expect_events() {
    WORKERS=$(workers)
    kill -STOP $WORKERS
    quick "1.0$RANDOM" | submit
    curl -sSN --max-time 60 "$URL/v1/drapes/$id/events" >"$BATS_TEST_TMPDIR/events" 3>&- &
    local reader=$!
    wait_until 20 grep -q '^event: progress' "$BATS_TEST_TMPDIR/events"
    not grep -q '^event: end' "$BATS_TEST_TMPDIR/events"
    kill -CONT $WORKERS
    wait "$reader"
    grep -q '^event: end' "$BATS_TEST_TMPDIR/events"
}

# What the daemon itself has refused.
refusals() {
    curl -sS --fail -o "$BATS_TEST_TMPDIR/metrics" "http://127.0.0.1:$BACKEND/metrics"
    sed -n '/status="413"/p' "$BATS_TEST_TMPDIR/metrics"
}

# A mesh of more than --max-body reaches the daemon, which reads all of it.
expect_mesh() {
    truncate -s $((64 * 1024 * 1024 + 1)) "$BATS_TEST_TMPDIR/mesh"
    call POST "/v1/drapes/$id/map" -H 'Content-Type: text/x-nastran' --data-binary "@$BATS_TEST_TMPDIR/mesh"
    expect 422
    truncate -s $((256 * 1024 * 1024 + 1)) "$BATS_TEST_TMPDIR/mesh"
    call POST "/v1/drapes/$id/map" -H 'Content-Type: text/x-nastran' --data-binary "@$BATS_TEST_TMPDIR/mesh"
    expect 413
}

# One byte more than --max-body: the proxy itself refuses it.
expect_cap() {
    local before=$BATS_TEST_TMPDIR/before after=$BATS_TEST_TMPDIR/after
    refusals >"$before"
    truncate -s $((64 * 1024 * 1024 + 1)) "$BATS_TEST_TMPDIR/large"
    post /v1/drapes "$BATS_TEST_TMPDIR/large"
    expect 413
    refusals >"$after"
    cmp "$before" "$after"
}

@test "deploy: nginx passes drapes over TLS, and plain calls to it" {
    start_nginx
    expect_drape
    [[ "$(header Strict-Transport-Security)" == max-age=* ]]
    status=$(curl -sS -o /dev/null -D "$headers" -w '%{http_code}' "http://127.0.0.1:$PLAIN/v1/drapes")
    [ "$status" = 308 ]
    [[ "$(header Location)" == https://*/v1/drapes ]]
}

@test "deploy: nginx and Caddy pass the page, and meshes of more than --max-body" {
    for proxy in nginx caddy; do
        start_$proxy
        expect_drape
        expect_mesh
        call GET /
        expect 200
        file=$(grep -oE 'viewer/[0-9a-f]+/main\.js' "$body" | head -1)
        [ -n "$file" ]
        call GET "/$file"
        expect 200
        kill "$PROXY" && wait "$PROXY" || true
    done
}

@test "deploy: nginx serves draped under a path by the block of the guide" {
    start_nginx
    kill "$PROXY" && wait "$PROXY" || true
    sed -n '/^```nginx$/,/^```$/p' docs/operations.md | sed '1d;$d' >"$PREFIX/block"
    [ -s "$PREFIX/block" ]
    # In place of the server's own locations.
    sed -i -e "/location \/ {/,/^    }/d" -e "/server_name localhost;/r $PREFIX/block" "$PREFIX/nginx.conf"
    sed -i "s|127.0.0.1:8080|127.0.0.1:$BACKEND|" "$PREFIX/nginx.conf"
    build/tools/nginx -p "$PREFIX" -e "$PREFIX/error.log" -c "$PREFIX/nginx.conf" 3>&- &
    PROXY=$!
    below() { call GET /draped/; [ "$status" = 200 ]; }
    wait_until 20 below
    grep -q '<html' "$body"
    post /draped/v1/drapes $EXAMPLES/saddle.json -H 'Prefer: wait=30'
    expect 200
}

@test "deploy: nginx does not hold events back" {
    start_nginx
    expect_events
}

@test "deploy: nginx refuses large bodies, and a backend that is away, as problems" {
    start_nginx
    expect_cap
    jq -e '.type == "/problems/too-large" and .status == 413 and (.request_id | length) > 0' "$body"
    kill "$PROXY" && wait "$PROXY" || true
    BACKEND=1 start_nginx
    call GET /v1/drapes
    expect 503
    [ "$(header Content-Type)" = application/problem+json ]
    jq -e '.type == "/problems/unavailable"' "$body"
}

@test "deploy: nginx closes on headers that do not come" {
    start_nginx
    # The configuration's time-out, made short: what is tested is that it is in force.
    kill "$PROXY" && wait "$PROXY" || true
    sed -i 's/client_header_timeout 10s/client_header_timeout 1s/' "$PREFIX/nginx.conf"
    build/tools/nginx -p "$PREFIX" -e "$PREFIX/error.log" -c "$PREFIX/nginx.conf" 3>&- &
    use_proxy
    run timeout 20 python3 - "$TLS" "$CERT" <<'END'
import socket, ssl, sys
context = ssl.create_default_context(cafile=sys.argv[2])
with socket.create_connection(("127.0.0.1", int(sys.argv[1])), 15) as plain:
    with context.wrap_socket(plain, server_hostname="localhost") as client:
        client.sendall(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nX-Slow: ")
        sys.exit(1 if b" 200 " in client.recv(1000) else 0)
END
    [ "$status" = 0 ]
}

@test "deploy: Caddy passes drapes over TLS, holds no events back, refuses large bodies" {
    build/tools/caddy validate --adapter caddyfile --config deploy/Caddyfile
    start_caddy
    expect_drape
    expect_events
    truncate -s $((64 * 1024 * 1024 + 1)) "$BATS_TEST_TMPDIR/large"
    post /v1/drapes "$BATS_TEST_TMPDIR/large"
    expect 413
}
