# SPDX-License-Identifier: MIT
# Studies: many variants of a drape as tasks, their result, their end, and what is lost on the way.
load helper

teardown_file() { keep_contract; }

teardown() {
    [ -z "${DAEMON:-}" ] || kill -CONT $(workers) 2>/dev/null || true
    stop_daemon
}

start() { start_daemon "$BATS_TEST_TMPDIR/daemon" "$@"; }

# study SPACING STARTS: on the saddle, at each start four directions.
study() {
    jq -c --argjson spacing "$1" --argjson starts "$2" '{drape: (.fabric.spacing = $spacing),
        vary: {start: {grid: $starts}, angle_deg: [0, 20, 40, 60]},
        objectives: ["max_shear_deg", "uncovered_area"]}' $EXAMPLES/saddle.json
}

submit_study() {
    post /v1/studies - "$@"
    expect 202
    id=$(field .id)
}

# wait_study ID STATUS: for as long as variants are done.
wait_study() {
    local before=-1 now=0
    while [ "$now" -gt "$before" ]; do
        call GET "/v1/studies/$1?wait=40"
        expect 200
        [ "$(field .status)" != "$2" ] || return 0
        before=$now
        now=$(field .variants.done)
    done
    cat "$body"
    return 1
}

begun() {
    call GET "/v1/studies/$1"
    [ "$(field .variants.done)" -ge "$2" ]
}

tasks() { echo $(($(metric 'draped_store_tasks{status="queued"}') + $(metric 'draped_store_tasks{status="running"}'))); }
has_tasks() { [ "$(metric 'draped_store_tasks{status="running"}')" -gt 0 ]; }
no_tasks() { [ "$(tasks)" = 0 ]; }
idle() { [ "$(metric draped_workers_busy)" = 0 ]; }

# columns ID: all numbers of a study, without its id and times.
columns() {
    curl -sS "$URL/v1/studies/$1/result" | jq -cS '[.best, .variants]' | sha256sum
}

@test "http: a study gives the numbers of the drapes it stands for" {
    local begun=$SECONDS
    start --workers 2
    study 0.4 6 | submit_study
    [ "$(field .variants.total)" = 24 ]
    [ "$(header Location)" = "/v1/studies/$id" ]
    wait_study "$id" succeeded
    [ "$(field '[.progress, .variants.done, .summary.variants, .attempts] | join(" ")')" = "1 24 24 1" ]
    jq -e ".summary.timing_ms.solve > 0 and .summary.timing_ms.solve <= 2000 * (1 + $SECONDS - $begun)" "$body"
    call GET "/v1/studies/$id/result"
    expect 200
    best=$(field .best.max_shear_deg)
    shear=$(field ".variants.max_shear_deg[$best]")
    [ "$shear" = "$(field '.variants.max_shear_deg | min')" ]
    etag=$(header ETag)
    call GET "/v1/studies/$id/result" -H "If-None-Match: $etag"
    expect 304
    call GET "/v1/studies/$id/variants/$best/request"
    expect 200
    post /v1/drapes "$body" -H 'Prefer: wait=20'
    expect 200
    [ "$(field .summary.max_shear_deg)" = "$shear" ]
    no_tasks
}

@test "http: a study steers each variant, as its own request does, and the values can be posted" {
    start --workers 2
    jq '{drape: ., vary: {angle_deg: [0, 30], steering: {points: 2}}, objectives: ["max_shear_deg"]}' \
        $EXAMPLES/freeform.json | submit_study
    wait_study "$id" succeeded
    call GET "/v1/studies/$id/result"
    shear=$(field '.variants.max_shear_deg[1]')
    call GET "/v1/studies/$id/variants/1/request"
    expect 200
    jq -c .generators "$body" | grep -q '"steered":{"points":2}'
    post /v1/drapes "$body" -H 'Prefer: wait=20'
    expect 200
    [ "$(field .summary.max_shear_deg)" = "$shear" ]
    [ "$(field '.summary.steering | .fell and .energy_after < .energy_before')" = true ]
    jq -c .nodes.x "$body" >"$BATS_TEST_TMPDIR/sought"
    generators=$(field .summary.steering.generators)
    jq --argjson generators "$generators" '.direction = {angle_deg: 30} | .generators = $generators' \
        $EXAMPLES/freeform.json | post /v1/drapes - -H 'Prefer: wait=20'
    expect 200
    jq -c .nodes.x "$body" | cmp - "$BATS_TEST_TMPDIR/sought"
}

@test "http: the result of a study is json, csv and npz, in ranges and compressed" {
    start --workers 2
    study 0.4 3 | post /v1/studies - -H 'Prefer: wait=30'
    expect 200
    [ "$(header Preference-Applied)" = wait ]
    id=$(header Location)
    id=${id##*/}
    [ "$(header Content-Location)" = "/v1/studies/$id/result" ]
    call GET "/v1/studies/$id/result?format=csv"
    expect 200
    [ "$(wc -l <"$body")" = 13 ]
    head -1 "$body" | grep -q '^start_u,start_v,x,y,z,angle_deg,pre_shear_deg,'
    call GET "/v1/studies/$id/result?fields=variants.x,variants.max_shear_deg" -H 'Accept: application/x-npz'
    expect 200
    python3 -c 'import sys, zipfile; assert sorted(zipfile.ZipFile(sys.argv[1]).namelist()) == ["variants.max_shear_deg.npy", "variants.x.npy"]' "$body"
    call GET "/v1/studies/$id/result?format=npz" -H 'Range: bytes=0-3'
    expect 206
    [ "$(stat -c %s "$body")" = 4 ]
    curl -sS -H 'Accept-Encoding: zstd' "$URL/v1/studies/$id/result" | zstd -dq | jq -e '.variants.x | length == 12'
    call GET "/v1/studies/$id/result?format=vtp"
    expect_problem 406 not-acceptable
    call GET "/v1/studies/$id/result?format=csv&table=variants"
    expect 200
    for format in csv json npz; do
        call GET "/v1/studies/$id/result?format=$format&table=nodes"
        expect_problem 422 invalid-request
        field .detail | grep -q 'variants and bands'
    done
    call GET "/v1/studies/$id/result?sample=0&format=csv&table=nodes"
    expect 200
    call GET "/v1/studies/$id/request"
    expect 200
    field '.drape.method' >/dev/null
    post /v1/studies "$body"
    expect 202
    [ "$(field .status)" = succeeded ]
}

@test "http: searches and samples give the bytes that the command gives" {
    start --workers 2
    study 0.3 9 | jq -c '.search = "optimise" | .budget = 60' >"$BATS_TEST_TMPDIR/search.json"
    study 0.3 1 | jq -c '.vary = {start: {radius: 0.2}, angle_deg: {normal: 2}} | .sample = 30 |
        .seed = 7' >"$BATS_TEST_TMPDIR/sample.json"
    for name in search sample; do
        post /v1/studies "$BATS_TEST_TMPDIR/$name.json" -H 'Prefer: wait=40'
        expect 200
        id=$(field .id)
        rows=$(field '.variants.x | length')
        call GET "/v1/studies/$id"
        [ "$(field '.variants | "\(.done) \(.total)"')" = "$rows $rows" ]
        for table in variants bands; do
            [ $name$table != searchbands ] || continue
            call GET "/v1/studies/$id/result?format=csv&table=$table"
            expect 200
            "$DRAPE" "$BATS_TEST_TMPDIR/$name.json" --format csv --table $table 2>/dev/null | cmp - "$body"
        done
    done
}

@test "http: the drape of a sample, and its map, are those of its own request" {
    start --workers 1
    study 0.5 1 | jq -c '.vary = {start: {radius: 0.2}, angle_deg: {normal: 3}} | .sample = 5' |
        post /v1/studies - -H 'Prefer: wait=40'
    expect 200
    id=$(field .id)
    jq -n '{points: [[0.1, 0.2, 0], [-1, 1, 0], [1.5, 1.9, 0]]}' >"$BATS_TEST_TMPDIR/points.json"
    for k in 0 4; do
        call GET "/v1/studies/$id/variants/$k/request"
        post /v1/drapes "$body" -H 'Prefer: wait=40'
        expect 200
        drape=$(field .id)
        for query in 'format=csv&table=cells' 'format=npz&fields=nodes.x,rim.p' 'format=vtp'; do
            call GET "/v1/drapes/$drape/result?$query"
            expect 200
            cp "$body" "$BATS_TEST_TMPDIR/own"
            call GET "/v1/studies/$id/result?sample=$k&$query"
            expect 200
            cmp "$BATS_TEST_TMPDIR/own" "$body"
        done
        post "/v1/drapes/$drape/map?format=csv&cavity_height=0.0004" "$BATS_TEST_TMPDIR/points.json"
        expect 200
        cp "$body" "$BATS_TEST_TMPDIR/own"
        post "/v1/studies/$id/map?format=csv&sample=$k&cavity_height=0.0004" "$BATS_TEST_TMPDIR/points.json"
        expect 200
        cmp "$BATS_TEST_TMPDIR/own" "$body"
    done
    call GET "/v1/studies/$id/result?sample=0"
    expect 200
    [ "$(field '.nodes.x | length')" -gt 10 ]
    [ "$(field .id)" = "$id/variants/0" ]
    call GET "/v1/studies/$id/result?sample=5"
    expect_problem 404 not-found
    call GET "/v1/studies/$id/result?sample=-1"
    expect_problem 422 invalid-request
    post "/v1/studies/$id/map" "$BATS_TEST_TMPDIR/points.json"
    expect_problem 422 invalid-request
    call GET "/v1/drapes/$drape/result?sample=0"
    expect_problem 422 invalid-request
}

@test "http: the drape of a sample says when it needs more memory than there is" {
    start --workers 1 --check-memory 64M
    jq '{drape: (.fabric.spacing = 0.02), vary: {angle_deg: [0]}, objectives: ["max_shear_deg"]}' \
        "$EXAMPLES/saddle.json" | post /v1/studies - -H 'Prefer: wait=50'
    expect 200
    id=$(field .id)
    call GET "/v1/studies/$id/result?sample=0"
    expect_problem 413 too-large
    field .detail | grep -q -- '--check-memory'
}

@test "http: what is wrong with a study is said before any work" {
    start --workers 1 --max-variants 20
    study 0.4 6 | post /v1/studies -
    expect_problem 422 invalid-request
    [ "$(field .errors[0].pointer)" = /vary ]
    call GET /v1/limits
    [ "$(field .max_variants)" = 20 ]
    study 0.4 2 | jq -c '.vary = {}' | post /v1/studies -
    expect_problem 422 invalid-request
    study 0.4 2 | jq -c '.drape.surface = {id: "00000000000000000000000000000000"}' | post /v1/studies -
    expect_problem 422 invalid-request
    [ "$(field .errors[0].pointer)" = /drape/surface/id ]
    study 0.4 2 | jq -c '.drape.fabric.spacing = -1' | post /v1/studies -
    expect_problem 422 invalid-request
    [ "$(field .errors[0].pointer)" = /drape/fabric/spacing ]
}

@test "http: studies and drapes are not found under each other's paths" {
    start --workers 1
    study 0.4 1 | submit_study -H 'Idempotency-Key: one'
    study 0.4 1 | submit_study -H 'Idempotency-Key: one'
    study=$id
    study 0.4 1 | post /v1/drapes - -H 'Idempotency-Key: one'
    expect 422
    quick 1 | submit
    wait_study "$study" succeeded
    for path in "/drapes/$study" "/drapes/$study/result" "/studies/$id" "/studies/$id/events" \
        "/studies/$id/result" "/studies/$id/variants/0/request" "/studies/$study/variants/4/request"; do
        call GET "/v1$path"
        expect_problem 404 not-found
    done
    call POST "/v1/drapes/$study/cancel"
    expect_problem 404 not-found
    call DELETE "/v1/studies/$id"
    expect_problem 404 not-found
    call GET /v1/drapes
    [ "$(field '.drapes | length')" = 1 ]
    call GET '/v1/studies?status=succeeded'
    [ "$(field '.studies | map(.id) | join(" ")')" = "$study" ]
    call GET '/v1/studies?status=running'
    [ "$(field '.studies | length')" = 0 ]
    call DELETE "/v1/studies/$study"
    expect 204
    call GET "/v1/studies/$study"
    expect_problem 404 not-found
}

@test "http: the events of a study tell how many variants are done" {
    start --workers 1
    study 0.06 40 | submit_study
    curl -sSN --max-time 110 "$URL/v1/studies/$id/events" >"$BATS_TEST_TMPDIR/events"
    grep -c '^event: progress' "$BATS_TEST_TMPDIR/events"
    [ "$(grep -c '^event: progress' "$BATS_TEST_TMPDIR/events")" -ge 3 ]
    grep '^data: ' "$BATS_TEST_TMPDIR/events" | cut -c7- | jq -es '[.[].variants.done] as $done
        | ($done | sort) == $done and $done[-1] == 160 and .[-1].status == "succeeded"
        and .[-1].best_so_far == null'
    # A search tells after each round the best so far, which never grows; the last is that of the result.
    study 0.2 9 | jq -c '.drape.start = {uv: [0.2, 0.3]} | .search = "optimise" | .budget = 200' |
        submit_study
    curl -sSN --max-time 110 "$URL/v1/studies/$id/events" >"$BATS_TEST_TMPDIR/events"
    call GET "/v1/studies/$id/result"
    least=$(field '.variants.max_shear_deg[.best.max_shear_deg]')
    grep '^data: ' "$BATS_TEST_TMPDIR/events" | cut -c7- | jq -es --argjson least "$least" '
        [.[].best_so_far | select(.) | .max_shear_deg] | length >= 3 and (sort | reverse) == . and
        .[-1] >= $least and .[-1] < .[0]'
}

@test "http: a study that is cancelled or deleted stops within a second" {
    start --workers 2
    for way in cancel delete; do
        study 0.004 "$([ $way = cancel ] && echo 50 || echo 51)" | submit_study
        wait_until 20 has_tasks
        if [ $way = cancel ]; then
            call POST "/v1/studies/$id/cancel"
            expect 202
            [ "$(field .status)" = cancelled ]
        else
            call DELETE "/v1/studies/$id"
            expect 204
        fi
        no_tasks
        wait_until 2 idle
    done
    call GET /v1/studies
    [ "$(field '.studies | map(.status) | join(" ")')" = cancelled ]
    call POST "/v1/studies/$(field '.studies[0].id')/cancel"
    expect 200
}

@test "http: a study has the same bits with one worker and with three, killed workers and daemons" {
    start --workers 1
    study 0.06 30 | submit_study
    wait_study "$id" succeeded
    undisturbed=$(columns "$id")
    stop_daemon
    rm -r "$BATS_TEST_TMPDIR/daemon/data"
    start --workers 3
    study 0.06 30 | submit_study
    wait_until 20 begun "$id" 1
    kill -KILL $(workers)
    done=$(field .variants.done)
    wait_until 20 begun "$id" $((done + 1))
    kill_daemon
    start --workers 3
    wait_study "$id" succeeded
    [ "$(columns "$id")" = "$undisturbed" ]
    [ "$(field .summary.failed)" = 0 ]
    no_tasks
}

@test "http: a drape beside studies waits for no more than a task" {
    start --workers 1
    for k in {1..30}; do
        study "0.0$((10 + k))" 50 | submit_study
    done
    wait_until 20 begun "$id" 0
    quick 1.5 | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
    call GET '/v1/studies?status=succeeded'
    [ "$(field '.studies | length')" -lt 5 ]
    quick 1.6 | post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
}
