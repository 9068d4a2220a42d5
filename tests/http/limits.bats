# SPDX-License-Identifier: MIT
# Limits that hold, parts of results, times, other origins, and streams that are taken up again.

load helper
bats_require_minimum_version 1.5.0

setup_file() { start_shared_daemon --workers 1 --cors-origin https://a.example,https://b.example; }
teardown_file() { end_file; }

# result FACTOR: a drape that is done; sets id.
result() {
    quick "$1" | submit
    wait_for "$id" succeeded
}

# Of --check-config what is a limit, as /v1/limits names it.
limits_of_check_config() {
    "$DRAPED" --check-config "$@" |
        awk -F ' = ' '$2 ~ /^[0-9]+$/ && $1 !~ /^(workers|allow-anonymous|lease|drain-timeout)$/ {
            gsub("-", "_", $1)
            unit = $1 ~ /_timeout$/ ? "_seconds" : $1 ~ /^retention(_jobs)?$/ ? "_hours" : ""
            print $1 unit, $2
        }' | sort
}

@test "limits: GET /v1/limits has every limit of --check-config with its value" {
    limits_of_check_config >"$BATS_TEST_TMPDIR/config"
    [ "$(wc -l <"$BATS_TEST_TMPDIR/config")" -ge 20 ]
    call GET /v1/limits
    expect 200
    jq -r 'to_entries[] | "\(.key) \(.value)"' "$body" | sort | diff "$BATS_TEST_TMPDIR/config" -
    field '.max_control_points == 512 * 512' # the most that any surface has
}

@test "limits: every call caps bodies where its description says so" {
    DRAPED_PORT=$PORT python3 - <<'END'
import http.client, json, os
limits, calls = {}, 0
def get(path):
    link = http.client.HTTPConnection("127.0.0.1", int(os.environ["DRAPED_PORT"]), timeout=20)
    link.request("GET", path)
    return json.load(link.getresponse())
limits = get("/v1/limits")
for path, item in get("/v1/openapi.json")["paths"].items():
    for method in {"post", "put"} & item.keys():
        if "requestBody" not in item[method]:
            continue
        name = item[method].get("x-body-limit", "max_body")
        link = http.client.HTTPConnection("127.0.0.1", int(os.environ["DRAPED_PORT"]), timeout=20)
        link.putrequest(method.upper(), path.replace("{id}", "0" * 32))
        link.putheader("Content-Type", "application/json")
        link.putheader("Expect", "100-continue")
        link.putheader("Content-Length", str(limits[name] + 1))
        link.endheaders()
        answer = link.getresponse()
        detail = json.load(answer)["detail"]
        assert answer.status == 413 and f"(--{name.replace('_', '-')})" in detail, (path, detail)
        calls += 1
assert calls >= 3, calls
END
}

gone_by_now() { call GET "/v1/drapes/$1/result"; [ "$status" = 410 ]; }

@test "limits: beyond --retention-bytes the oldest results are 410" {
    local first
    start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1 --retention-bytes 300K
    result 1
    first=$id
    for factor in 1.01 1.02 1.03 1.04 1.05 1.06; do result $factor; done
    wait_until 10 gone_by_now "$first"
    expect_problem 410 gone
    call GET "/v1/drapes/$first"
    expect 200
    [ "$(field .status)" = succeeded ]
    call GET "/v1/drapes/$id/result"
    expect 200
    stop_daemon
}

@test "limits: beyond the queue limit 429 says when to come back" {
    start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1 --queue-limit 1 --owner-queue 9
    stop_workers
    quick 1 | submit
    wait_until 10 has_status "$id" running
    quick 1.01 | submit
    quick 1.02 | post /v1/drapes -
    expect_problem 429 queue-full
    [ "$(header Retry-After)" -ge 1 ]
    [ "$(header Retry-After)" -le 600 ]
    kill -CONT $(workers)
    stop_daemon
}

@test "limits: all bodies together have a budget, and what is refused leaves room" {
    start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1 --max-bodies 8K --max-body 8K --max-mesh 8K \
        --owner-bodies 8K
    # One of another owner that has come in part, and stays.
    mkfifo "$BATS_TEST_TMPDIR/slow"
    curl -sS -o "$BATS_TEST_TMPDIR/answer" -H "$JSON" -T "$BATS_TEST_TMPDIR/slow" -X POST \
        --interface 127.0.0.2 "$URL/v1/drapes" 3>&- &
    local slow=$!
    exec 8>"$BATS_TEST_TMPDIR/slow"
    jq -c 'tojson + (" " * 5000)' -r $EXAMPLES/saddle.json >&8
    budget_is_taken() { post /v1/drapes "$BATS_TEST_TMPDIR/large"; [ "$status" = 503 ]; }
    jq -c 'tojson + (" " * 4000)' -r $EXAMPLES/saddle.json >"$BATS_TEST_TMPDIR/large"
    wait_until 30 budget_is_taken
    quick 1 | post /v1/drapes -
    expect 202
    jq -c 'tojson + (" " * 4000)' -r $EXAMPLES/saddle.json >"$BATS_TEST_TMPDIR/large"
    for how in 'Expect: 100-continue' 'Expect:' 'Transfer-Encoding: chunked'; do
        post /v1/drapes "$BATS_TEST_TMPDIR/large" -H "$how"
        expect_problem 503 unavailable
        not grep -q '^HTTP/1.1 100' "$headers" # who asks is not told to send it first
        [ "$(header Retry-After)" = 1 ]
    done
    exec 8>&-
    wait "$slow"
    jq -e '.status == "queued" or .status == "running" or .status == "succeeded"' "$BATS_TEST_TMPDIR/answer"
    post /v1/drapes "$BATS_TEST_TMPDIR/large"
    expect 202
    quick 1.1 | post /v1/drapes -
    expect 202
    stop_daemon
}

@test "limits: a part of a result is the same bytes" {
    local whole=$BATS_TEST_TMPDIR/whole part=$BATS_TEST_TMPDIR/part size etag
    result 0.2
    for format in json csv vtp glb npz; do
        call GET "/v1/drapes/$id/result?format=$format"
        expect 200
        cp "$body" "$whole"
        size=$(stat -c %s "$whole") etag=$(header ETag)
        [ -n "$(header Content-Length)" ] || continue
        [ "$(header Accept-Ranges)" = bytes ]
        for range in "0 9" "5 5" "100 $((size - 1))" "$((size - 1)) $((size - 1))"; do
            call GET "/v1/drapes/$id/result?format=$format" -H "Range: bytes=${range/ /-}"
            expect 206
            [ "$(header Content-Range)" = "bytes ${range/ /-}/$size" ]
            [ "$(header ETag)" = "$etag" ]
            tail -c +$((${range% *} + 1)) "$whole" | head -c $((${range#* } - ${range% *} + 1)) >"$part"
            cmp "$part" "$body"
        done
        call GET "/v1/drapes/$id/result?format=$format" -H 'Range: bytes=-7'
        expect 206
        tail -c 7 "$whole" | cmp - "$body"
        call GET "/v1/drapes/$id/result?format=$format" -H "Range: bytes=$((size - 3))-"
        expect 206
        tail -c 3 "$whole" | cmp - "$body"
        call GET "/v1/drapes/$id/result?format=$format" -H "Range: bytes=$size-"
        expect_problem 416 range-not-satisfiable
        [ "$(header Content-Range)" = "bytes */$size" ]
        call GET "/v1/drapes/$id/result?format=$format" -H 'Range: bytes=0-1' -H "If-Range: $etag"
        expect 206
        call GET "/v1/drapes/$id/result?format=$format" -H 'Range: bytes=0-1' -H 'If-Range: "old"'
        expect 200
        cmp "$whole" "$body"
        ranged=$((${ranged:-0} + 1))
    done
    [ "$ranged" -ge 3 ]
}

@test "limits: several ranges, other units and compressed answers are whole" {
    result 0.3
    for range in 'bytes=0-1,3-4' 'lines=0-1' 'bytes=9-1' 'bytes=a-b' 'bytes=-' 'bytes=1'; do
        call GET "/v1/drapes/$id/result?format=npz" -H "Range: $range"
        expect 200
    done
    call GET "/v1/drapes/$id/result?format=npz" -H 'Range: bytes=0-1' -H 'Accept-Encoding: gzip'
    expect 200
}

@test "limits: a result tells how long it waited, was solved and encoded" {
    result 0.5
    call GET "/v1/drapes/$id/result"
    [[ "$(header Server-Timing)" =~ ^queue\;dur=[0-9.]+,\ solve\;dur=[0-9.]+,\ encode\;dur=[0-9.]+$ ]]
}

@test "limits: the counters tell of waiting, solving, encoding, refusals and memory" {
    local scrape=$BATS_TEST_TMPDIR/scrape queued solved encoded refused
    queued=$(metric draped_queue_seconds_count) solved=$(metric draped_solve_seconds_count)
    encoded=$(metric draped_encode_seconds_count)
    result 0.7
    call GET "/v1/drapes/$id/result"
    call GET "/v1/drapes/$id/result" -H 'Accept: image/png'
    expect 406
    [ "$(metric draped_queue_seconds_count)" = $((queued + 1)) ]
    [ "$(metric draped_solve_seconds_count)" = $((solved + 1)) ]
    [ "$(metric draped_encode_seconds_count)" = $((encoded + 1)) ]
    [ "$(metric 'draped_rejections_total{reason="not-acceptable"}')" -ge 1 ]
    [ "$(metric 'draped_store_errors_total{kind="down"}')" = 0 ]
    [ "$(metric process_resident_memory_bytes)" -gt 1000000 ]
    [ "$(metric process_open_fds)" -gt 5 ]
    [ "$(metric draped_queue_age_seconds)" = 0.000 ]
    curl -sS --max-time 20 "$URL/metrics" >"$scrape"
    # Buckets grow, and the last one is all.
    awk -F'[ {}]' '/_bucket/ {
        series = $0; sub(/,?le=.*/, "", series)
        if (series == last && $NF < count) bad = 1
        last = series; count = $NF
        if (/\+Inf/) all[series] = $NF
    } END { exit bad || length(all) < 4 }' "$scrape"
    grep -qF 'draped_http_request_seconds_count{method="POST",route="/v1/drapes"} ' "$scrape"
    [ ! -x build/tools/promtool ] || build/tools/promtool check metrics <"$scrape"
}

@test "limits: the age of the queue is that of who waits longest" {
    start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1
    stop_workers
    quick 1 | submit
    wait_until 10 has_status "$id" running
    quick 1.01 | submit
    [ "$(metric draped_queue_depth)" = 1 ]
    older() { [ "$(metric draped_queue_age_seconds | tr -d .)" -ge 100 ]; }
    wait_until 10 older
    kill -CONT $(workers)
    stop_daemon
}

@test "limits: web pages of the named origins may call, others may not" {
    for origin in https://a.example https://b.example; do
        call GET /v1/limits -H "Origin: $origin"
        [ "$(header Access-Control-Allow-Origin)" = "$origin" ]
        [ "$(header Vary)" = Origin ]
        call GET /nothing -H "Origin: $origin"
        expect_problem 404 not-found
        [ "$(header Access-Control-Allow-Origin)" = "$origin" ]
    done
    for origin in https://a.example.org https://c.example null http://a.example ''; do
        call GET /v1/limits -H "Origin: $origin"
        expect 200
        [ -z "$(header Access-Control-Allow-Origin)" ]
    done
    call OPTIONS /v1/drapes -H 'Origin: https://a.example' -H 'Access-Control-Request-Method: POST' \
        -H 'Access-Control-Request-Headers: authorization,content-type'
    expect 204
    [[ "$(header Access-Control-Allow-Methods)" == *POST* ]]
    [[ "$(header Access-Control-Allow-Headers)" == *Authorization*Content-Type* ]]
}

@test "limits: without --cors-origin no page of another origin may call" {
    start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1
    call OPTIONS /v1/drapes -H 'Origin: https://a.example' -H 'Access-Control-Request-Method: POST'
    expect 204
    not grep -qi '^Access-Control' "$headers"
    stop_daemon
}

@test "limits: a stream of events is taken up where it broke" {
    result 0.6
    call GET "/v1/drapes/$id/events"
    expect 200
    grep -q '^event: end' "$body"
    local last
    last=$(sed -n 's/^id: //p' "$body" | tail -1)
    [ -n "$last" ]
    call GET "/v1/drapes/$id/events" -H "Last-Event-ID: $last"
    expect 204
    call GET "/v1/drapes/$id/events" -H 'Last-Event-ID: 1-running-500'
    expect 200
    grep -q '^event: end' "$body"
}

# How long it takes then, two minutes at most, is the kernel's affair.
@test "limits: a stream of events that has no news says that it is there" {
    local events=$BATS_TEST_TMPDIR/events
    start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1
    stop_workers
    quick 1 | submit
    wait_until 10 has_status "$id" running
    curl -sSN --max-time 60 "$URL/v1/drapes/$id/events" >"$events" &
    local stream=$!
    wait_until 40 grep -qx ': still here' "$events"
    kill "$stream"
    kill -CONT $(workers)
    stop_daemon
}

@test "limits: a client that falls silent is asked whether it is there" {
    exec {silent}<>"/dev/tcp/127.0.0.1/$PORT"
    asked() { ss -Htno state established "sport = :$PORT" | grep -q 'timer:(keepalive'; }
    wait_until 5 asked
    exec {silent}>&-
}
