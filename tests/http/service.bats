# SPDX-License-Identifier: MIT
# The service about itself: how it starts, what it tells, what it counts.
load helper

setup_file() { start_shared_daemon --max-nodes 123456; }
teardown_file() { end_file; }

@test "http: the daemon prints one line on stdout, logs JSON lines, and ends with 0" {
    start_daemon "$BATS_TEST_TMPDIR/own"
    call GET /version
    expect 200
    stop_daemon
    [ "$(wc -l <"$HOME_DIR/out")" = 1 ]
    grep -qE '^draped listening on http://127\.0\.0\.1:[0-9]+$' "$HOME_DIR/out"
    jq -e 'has("time") and has("level") and has("event")' "$HOME_DIR/log" >/dev/null
    grep -q '"event":"request".*"target":"/version"' "$HOME_DIR/log"
}

@test "http: beyond loopback it does not start without tokens or --allow-anonymous" {
    for address in 0.0.0.0:0 '[::]:0'; do
        run timeout 10 "$DRAPED" --listen "$address" --data "$BATS_TEST_TMPDIR/data"
        [ "$status" -eq 2 ]
        [[ "$output" == *tokens* ]]
    done
    timeout 10 "$DRAPED" --listen 0.0.0.0:0 --data "$BATS_TEST_TMPDIR/data" --allow-anonymous \
        --check-config
}

@test "http: flags that make no sense are refused, --help and --version answered" {
    for flag in --nonsense --workers=0 --workers=x --queue-limit=-1 --max-body=1 --role=king \
        --listen=nowhere --job-timeout=0 --store=mysql://x; do
        run timeout 10 "$DRAPED" "$flag" --data "$BATS_TEST_TMPDIR/data"
        [ "$status" -eq 2 ]
        [ -n "$output" ]
    done
    "$DRAPED" --help | grep -q -- --queue-limit
    "$DRAPED" --version | grep -q draped
    DRAPED_WORKERS=7 "$DRAPED" --check-config | grep -qE '^workers = 7$'
    DRAPED_WORKERS=7 "$DRAPED" --workers 3 --check-config | grep -qE '^workers = 3$'
}

@test "http: a port that is taken is told" {
    run timeout 10 "$DRAPED" --listen "127.0.0.1:$PORT" --data "$BATS_TEST_TMPDIR/data"
    [ "$status" -eq 1 ]
    [[ "$output" == *"in use"* ]]
    [[ "$output" != *http_failed* ]] # that is for threads
}

@test "http: liveness, readiness, version, limits" {
    for path in /healthz /readyz /version /v1/limits /v1/openapi.json; do
        call GET "$path"
        expect 200
        [ "$(header Content-Type)" = application/json ]
        jq -e 'type == "object"' "$body" >/dev/null
    done
    call GET /version
    version=$(deploy/version.py)
    jq -e --arg version "$version" '. == {name: "draped", $version, solver_version: $version}' "$body"
    call GET /v1/openapi.json
    [ "$(field .info.version)" = "$version" ]
    for program in "$DRAPED" "$DRAPE" "${DRAPE%/*}/drape-import"; do
        [ "$("$program" --version)" = "${program##*/} $version" ]
    done
    [ "$(cd clients/python && python3 -c 'import draped; print(draped.__version__)')" = "$version" ]
    call GET /v1/limits
    jq -e '.max_nodes == 123456 and .max_body > 0 and .queue_limit > 0' "$body"
}

@test "http: the front page is HTML that loads nothing from elsewhere" {
    call GET /
    expect 200
    [[ "$(header Content-Type)" == text/html* ]]
    [[ "$(header Content-Security-Policy)" == *"default-src 'none'"* ]] ||
        [[ "$(header Content-Security-Policy)" == *"default-src 'self'"* ]]
    [ "$(header X-Content-Type-Options)" = nosniff ]
}

@test "http: the files of the page are kept for good, as they are and packed, and only at their address" {
    call GET /
    script=$(grep -o '[^"]*main\.js' "$body")
    etag=$(header ETag)
    call GET / -H "If-None-Match: $etag"
    expect 304
    call GET "/$script"
    expect 200
    cp "$body" "$BATS_TEST_TMPDIR/plain"
    [ "$(header Cache-Control)" = 'public, max-age=31536000, immutable' ]
    [[ "$(header Content-Security-Policy)" == *"default-src 'none'"* ]]
    [ -z "$(header Content-Encoding)" ]
    plain=$(header ETag)
    call GET "/$script" -H 'Accept-Encoding: gzip'
    [ "$(header Content-Encoding)" = gzip ]
    [ "$(header ETag)" != "$plain" ]
    gunzip <"$body" | cmp - "$BATS_TEST_TMPDIR/plain"
    cmp "$BATS_TEST_TMPDIR/plain" server/viewer/main.js
    call GET "/${script%main.js}saddle.json"
    cmp "$body" $EXAMPLES/saddle.json
    call GET "/${script%main.js}other.js"
    expect_problem 404 not-found
    call GET /viewer/0123456789abcdef/main.js
    expect_problem 404 not-found
}

@test "http: metrics are Prometheus text and count" {
    before=$(metric 'draped_http_requests_total{method="GET",route="/version",status="200"}')
    call GET /version
    call GET /version
    after=$(metric 'draped_http_requests_total{method="GET",route="/version",status="200"}')
    [ $((after - ${before:-0})) = 2 ]
    call GET /metrics
    [[ "$(header Content-Type)" == text/plain* ]]
    # Every sample has its HELP and TYPE, and a number; those of a histogram share theirs.
    awk '/^# TYPE/ {type[$3] = $4} !/^#/ {split($0, name, /[{ ]/); base = name[1]
         if (sub(/_(bucket|sum|count)$/, "", base) && type[base] == "histogram") name[1] = base
         if (!type[name[1]] ||
         $NF !~ /^[0-9.e+-]+$/) {print; bad = 1}} END {exit bad}' "$body"
    grep -q '^draped_queue_depth 0$' "$body"
}

# ---- the description

openapi() {
    call GET /v1/openapi.json
    expect 200
}

@test "http: the description is OpenAPI 3.1 and its references lead somewhere" {
    openapi
    jq -e '(.openapi | startswith("3.1")) and (.info.version | length) > 0' "$body"
    jq -e '. as $all | [.. | objects | ."$ref"? // empty] | length > 20 and
           all(. as $ref | ($ref | startswith("#/")) and
               ($all | getpath($ref | ltrimstr("#/") | split("/"))) != null)' "$body"
    # Nothing is described that nobody refers to (ways to authenticate are named, not referred to).
    jq -e '([.. | objects | .security[]? | keys[]] | unique) == (.components.securitySchemes | keys)' \
        "$body"
    jq -r '.components | del(.securitySchemes) | to_entries[] | .key as $kind | .value | keys[] |
           "#/components/\($kind)/\(.)"' "$body" | sort >"$BATS_TEST_TMPDIR/there"
    jq -r '[.. | objects | ."$ref"? // empty] | unique[]' "$body" | sort |
        comm -13 - "$BATS_TEST_TMPDIR/there" >"$BATS_TEST_TMPDIR/unused"
    [ ! -s "$BATS_TEST_TMPDIR/unused" ] || { cat "$BATS_TEST_TMPDIR/unused"; false; }
}

@test "http: every operation of the description has an id, a summary and sound responses" {
    openapi
    jq -e '[.paths[] | to_entries[] | select(.key != "parameters") | .value] |
           ([.[].operationId] | length == (unique | length)) and
           all((.summary | length) > 0 and (.responses | length) > 0 and
               (.responses | keys | all(test("^[1-5][0-9][0-9]$"))))' "$body"
    # Every {id} of a path is one of its parameters; what else all calls of a path need is required.
    jq -e '.components.parameters as $all | .paths | to_entries | map(select(.key | contains("{id}")))
           | length > 5 and all(.value.parameters | map($all[."$ref" | split("/")[-1]]) |
                                any(.in == "path" and .name == "id") and
                                all(.required and (.in == "query" or .name == "id" or .name == "k")))' "$body"
}

@test "http: what is described is there, and what is there is described" {
    openapi
    cp "$body" "$BATS_TEST_TMPDIR/openapi"
    jq -r '.paths | to_entries[] | .key as $path | .value | keys[] | select(. != "parameters") |
           "\(ascii_upcase) \($path)"' "$BATS_TEST_TMPDIR/openapi" | sort \
        >"$BATS_TEST_TMPDIR/described"
    # OPTIONS tells what a path takes; a path that is not there has no methods.
    jq -r '.paths | keys[]' "$BATS_TEST_TMPDIR/openapi" | while read -r path; do
        call OPTIONS "${path//\{id\}/x}"
        header Allow | tr -d ' ' | tr ',' '\n' | grep -vxE 'HEAD|OPTIONS' | sed "s|\$| $path|"
    done | sort >"$BATS_TEST_TMPDIR/answered"
    diff "$BATS_TEST_TMPDIR/described" "$BATS_TEST_TMPDIR/answered"
    # And no route of the daemon's table is missing.
    tr '\n' ' ' <server/resources/routes.c | grep -oE '\{"[A-Z]+", +"/[^"]*"' |
        sed -E 's/\{"([A-Z]+)", +"([^"]*)"/\1 \2/' | sort |
        diff - "$BATS_TEST_TMPDIR/described"
}

@test "http: query parameters are those of the description" {
    openapi
    jq -r '.components.parameters as $all | .paths | to_entries[] | select(.key | startswith("/v1/"))
           | .key as $path | .value.get // empty | (.parameters // [])[] |
           (if ."$ref" then $all[."$ref" | split("/")[-1]] else . end) | select(.in == "query") |
           "\($path)?\(.name)="' "$body" >"$BATS_TEST_TMPDIR/parameters"
    [ "$(wc -l <"$BATS_TEST_TMPDIR/parameters")" -ge 8 ]
    while read -r target; do
        call GET "${target//\{id\}/0123456789abcdef0123456789abcdef}"
        [ "$status" != 422 ] || ! grep -q 'has no query parameter' "$body" || { cat "$body"; false; }
    done <"$BATS_TEST_TMPDIR/parameters"
}

# As everybody makes them: without flags that change what is required.
@test "http: types made of the description need no more keys than the daemon does" {
    manifests=$PWD/tests/manifests
    openapi
    cp "$body" "$BATS_TEST_TMPDIR/openapi.json"
    cp "$manifests/requests.ts" "$BATS_TEST_TMPDIR"
    cd "$BATS_TEST_TMPDIR"
    node "$manifests/node_modules/.bin/openapi-typescript" openapi.json -o draped.d.ts
    node "$manifests/node_modules/.bin/tsc" --noEmit --strict --exactOptionalPropertyTypes \
        requests.ts draped.d.ts
}

@test "http: the description names every kind of problem" {
    openapi
    # Without tokens nobody is unauthorized.
    sed -n 's/^    X([A-Z_]*, "\([a-z0-9-]*\)", [0-9]*,.*/\1/p' api/problem.h |
        grep -vxE 'unauthorized|forbidden' >"$BATS_TEST_TMPDIR/slugs"
    [ "$(wc -l <"$BATS_TEST_TMPDIR/slugs")" -gt 20 ]
    jq -r .components.schemas.Problem.properties.type.description "$body" |
        grep -oE '[a-z][a-z0-9-]+' >"$BATS_TEST_TMPDIR/words"
    while read -r slug; do
        grep -qx -- "$slug" "$BATS_TEST_TMPDIR/words" || { echo "$slug"; false; }
    done <"$BATS_TEST_TMPDIR/slugs"
}

@test "http: every method of the description is drapeable or says that it is not available" {
    openapi
    jq -r '.components.schemas.DrapeRequest | .properties.method.enum[]' "$body" \
        >"$BATS_TEST_TMPDIR/methods"
    cp "$body" "$BATS_TEST_TMPDIR/openapi"
    while read -r method; do
        jq --arg method "$method" '. + {$method}' "$EXAMPLES/saddle.json" |
            post /v1/drapes - -H 'Prefer: wait=40'
        [ "$status" != 200 ] || continue
        expect_problem 422 invalid-request
        field .detail | grep -q 'not available in this version'
        jq -e --arg method "$method" '.components.schemas.DrapeRequest.description |
            contains($method)' "$BATS_TEST_TMPDIR/openapi" >/dev/null
    done <"$BATS_TEST_TMPDIR/methods"
}

@test "http: the examples of the description are what it says" {
    openapi
    jq -c '.paths."/v1/drapes".post.requestBody.content."application/json".examples[].value' \
        "$body" >"$BATS_TEST_TMPDIR/examples"
    [ "$(wc -l <"$BATS_TEST_TMPDIR/examples")" -ge 1 ]
    while read -r example; do
        printf '%s' "$example" | post /v1/drapes - -H 'Prefer: wait=20'
        expect 200
    done <"$BATS_TEST_TMPDIR/examples"
    openapi
    jq -c '.paths."/v1/surfaces".post.requestBody.content."application/json".examples[].value' \
        "$body" >"$BATS_TEST_TMPDIR/examples"
    [ "$(wc -l <"$BATS_TEST_TMPDIR/examples")" -ge 1 ]
    while read -r example; do
        printf '%s' "$example" | post /v1/surfaces -
        expect 201
    done <"$BATS_TEST_TMPDIR/examples"
}

@test "http: answers have the members that the description requires" {
    openapi
    cp "$body" "$BATS_TEST_TMPDIR/openapi"
    # has_required SCHEMA: of the body.
    has_required() {
        jq -e --slurpfile all "$BATS_TEST_TMPDIR/openapi" --arg schema "$1" \
            '. as $answer | $all[0].components.schemas[$schema] |
             (.required - ($answer | keys) | length) == 0 and
             (($answer | keys) - (.properties | keys) | length) == 0' "$body" >/dev/null ||
            { echo "not a $1:"; head -c 1000 "$body"; return 1; }
    }
    quick 1.5 | submit
    has_required Status
    wait_for "$id" succeeded
    has_required Status
    call GET "/v1/drapes/$id/result"
    has_required Result
    jq .summary "$body" >"$BATS_TEST_TMPDIR/summary"
    call GET "/v1/drapes/$id/request"
    has_required DrapeRequest
    call GET /v1/drapes/x
    has_required Problem
    jq .surface "$EXAMPLES/saddle.json" | post /v1/surfaces -
    has_required StoredSurface
    call GET "$(header Location)"
    has_required NurbsSurface
    body=$BATS_TEST_TMPDIR/summary
    has_required Summary
}

@test "http: --listen *:PORT answers by IPv4 and by IPv6" {
    [ -e /proc/net/if_inet6 ] || skip "this system has no IPv6"
    start_daemon "$BATS_TEST_TMPDIR/daemon" --listen "*:0" --allow-anonymous
    for host in 127.0.0.1 "[::1]"; do
        URL=http://$host:$PORT
        call GET /healthz
        expect 200
    done
    stop_daemon
}

@test "http: SIGUSR1 neither ends the daemon nor changes anything" {
    start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1
    kill -USR1 "$DAEMON"
    call GET /healthz
    expect 200
    quick 1 | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
    stop_daemon
}

@test "materials: the library is listed with its sources, and a drape takes one by name" {
    call GET /v1/materials
    expect 200
    jq -e '.materials | length >= 3 and all(.name and .about and .source and (.example | type ==
        "boolean"))' "$body"
    call GET /v1/materials/example-glass-plain-800
    expect 200
    jq -e '.fabric.thickness == 0.000625 and .example' "$body"
    call GET /v1/materials/silk
    expect_problem 404 not-found
    jq -c '.fabric = {spacing: 0.2, material: "example-glass-plain-800"}' "$EXAMPLES/saddle.json" \
        >"$BATS_TEST_TMPDIR/request"
    call POST '/v1/drapes?fields=cells.thickness,cells.k1' -H "$JSON" -H 'Prefer: wait=40' \
        --data-binary "@$BATS_TEST_TMPDIR/request"
    expect 200
    jq -e '(.cells.thickness | min) >= 0.000625 and (.cells.k1 | min) > 0' "$body"
    call GET "/v1/drapes/$(field .id)/request"
    jq -e '.fabric.thickness == 0.000625 and .permeability.k1 == 2e-10' "$body"
    # Of a stored surface in mm the thickness is in mm.
    jq -c '{vertices: [[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]], triangles: [[0, 1, 2], [0, 2, 3]],
        length_unit: "mm"}' <<<null >"$BATS_TEST_TMPDIR/surface"
    call POST /v1/surfaces -H "$JSON" --data-binary "@$BATS_TEST_TMPDIR/surface"
    expect 201
    call POST '/v1/drapes?fields=cells.thickness' -H "$JSON" -H 'Prefer: wait=40' --data-binary \
        '{"surface": {"id": "'"$(field .id)"'"}, "method": "mosaic",
          "fabric": {"spacing": 1, "material": "example-glass-plain-800"}}'
    expect 200
    jq -e '(.cells.thickness | min) > 0.6249 and (.cells.thickness | max) < 0.6251' "$body"
}

@test "materials: one of one's own is kept, and what names it has its figures for good" {
    local own='{"name": "own", "areal_weight": 0.4, "fabric": {"thickness": 0.0004,
        "fiber_volume_fraction": 0.5}, "compaction": {"a": 0.25, "b": 0.05}, "permeability": {"model":
        "gebart", "fiber_radius": 4e-6, "packing": "hexagonal"}}'
    call POST /v1/materials -H "$JSON" --data-binary "$own"
    expect 201
    grep -qi '^location: /v1/materials/own' "$headers"
    call POST /v1/materials -H "$JSON" --data-binary "$own"
    expect 200
    call POST /v1/materials -H "$JSON" --data-binary "${own/0.25/0.24}"
    expect_problem 409 conflict
    call POST /v1/materials -H "$JSON" --data-binary "${own/0.0004/0.4}"
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /areal_weight ]
    call POST /v1/materials -H "$JSON" --data-binary '{"name": "lcmsim-test-case", "fabric": {}}'
    expect_problem 422 invalid-request
    call GET /v1/materials/own
    expect 200
    jq -e '.fabric.thickness == 4e-4 and .compaction == {a: 0.25, b: 0.05}' "$body"
    call GET '/v1/materials?limit=1'
    jq -e '[.materials[] | select(.own) | .name] == ["own"] and (.materials | length) >= 4' "$body"

    jq -c '.fabric = {spacing: 0.2, material: "own"}' "$EXAMPLES/saddle.json" \
        >"$BATS_TEST_TMPDIR/drape"
    jq -c '{drape: ., vary: {angle_deg: [0, 45]}, objectives: ["max_shear_deg"], search: "grid"}' \
        "$BATS_TEST_TMPDIR/drape" >"$BATS_TEST_TMPDIR/study"
    jq -c '{surface, cavity: {pressure: 1e5}, plies: [{fabric}, {fabric, direction: {angle_deg: 45}}]}' \
        "$BATS_TEST_TMPDIR/drape" >"$BATS_TEST_TMPDIR/stack"
    local -A place
    local kind
    for kind in drapes study stack; do
        local path=${kind/study/studies}
        call POST "/v1/${path/stack/laminates}" -H "$JSON" -H 'Prefer: wait=40' \
            --data-binary "@$BATS_TEST_TMPDIR/${kind%s}"
        expect 200
        place[$kind]=$(sed -n 's/^[Ll]ocation: *\([^\r]*\).*/\1/p' "$headers")
    done
    call DELETE /v1/materials/own
    expect 204
    call DELETE /v1/materials/own
    expect_problem 404 not-found
    call DELETE /v1/materials/lcmsim-test-case
    expect_problem 403 forbidden
    call POST /v1/drapes -H "$JSON" --data-binary "@$BATS_TEST_TMPDIR/drape"
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /fabric/material ]
    call GET "${place[drapes]}/request"
    jq -e '.fabric.thickness == 4e-4 and .permeability.model == "gebart"' "$body"
    call GET "${place[study]}/request"
    jq -e '.drape.fabric.thickness == 4e-4' "$body"
    call GET "${place[stack]}/request"
    jq -e 'all(.plies[]; .areal_weight == 0.4 and .compaction.b == 0.05)' "$body"
    call POST "${place[stack]}/map?fields=fiber_volume_fraction" -H "$JSON" \
        --data-binary '{"points": [[0.1, 0.1, 0]]}'
    expect 200
    # Vf = a p^b
    jq -e '.cells.fiber_volume_fraction[0] - 0.25 * pow(1e5; 0.05) | fabs < 1e-9' "$body"
}
