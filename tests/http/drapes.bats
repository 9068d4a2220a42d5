# SPDX-License-Identifier: MIT
# A drape from request to result.
load helper

setup_file() { start_shared_daemon; }
teardown_file() { end_file; }

# drape_example NAME: its result becomes the body.
drape_example() {
    post /v1/drapes "$EXAMPLES/$1.json" -H 'Prefer: wait=40'
    expect 200
}

# Every table's columns have one length, the one that the summary tells.
check_columns() {
    jq -e '
        .summary as $summary |
        ([.nodes[] | length] | unique) == [$summary.nodes] and
        ([.cells[] | length] | unique) == [$summary.cells] and
        ([.front[] | length] | unique | length) == 1 and
        ([.. | numbers | select(isnan or isinfinite)] | length) == 0' "$1" >/dev/null
}

@test "http: each example gives a result with whole columns and a sensible summary" {
    # All are covered but the corner, which locks without a dart.
    for file in "$EXAMPLES"/*.json; do
        name=$(basename "$file" .json)
        drape_example "$name"
        check_columns "$body"
        jq -e --arg name "$name" '.status == "succeeded" and
               .summary.outcome == (if $name == "corner" then "partial" else "complete" end) and
               .summary.coverage > 0.88 and .summary.coverage <= 1 and
               .summary.residual_max < 1e-9 and .summary.locked_cells <= .summary.cells and
               .summary.solver_version != null and .summary.timing_ms.solve >= 0 and
               (.summary.front_reasons | add) == (.front.reason | length)' "$body" >/dev/null
    done
}

@test "http: the saddle's shear is the one of the closed form" {
    post /v1/drapes "$EXAMPLES/saddle.json" -H 'Prefer: wait=40'
    # sin(shear) = -x y / sqrt((1 + x^2) (1 + y^2)); the start lies at (0, 0).
    jq -e '[.nodes as $n | range($n.i | length) | $n.x[.] as $x | $n.y[.] as $y |
            $n.shear_deg[.] * 0.017453292519943295 | sin as $sine |
            ($sine + $x * $y / ((1 + $x * $x) * (1 + $y * $y) | sqrt)) | fabs] |
           max < 0.002' "$body" >/dev/null
    jq -e '.nodes as $n | [range($n.i | length) | select($n.i[.] == 0 and $n.j[.] == 0)] as $s |
           ($s | length) == 1 and ($n.shear_deg[$s[0]] | fabs) < 1e-9' "$body" >/dev/null
}

# node NAME I J: of the body.
node() {
    jq --arg name "$1" --argjson i "$2" --argjson j "$3" '.nodes as $n |
        [range($n.i | length) | select($n.i[.] == $i and $n.j[.] == $j)][0] as $k |
        $n[$name][$k]' "$body"
}

# near A B TOLERANCE
near() { jq -ne "($1) - ($2) | fabs < $3" >/dev/null || { echo "$1 is not $2"; return 1; }; }

@test "http: the sphere and the free form give the shear that their README tells" {
    drape_example sphere
    near "$(node shear_deg 12 12)" 14.27443 0.02 # s t / 48^2 = 0.25
    near "$(node shear_deg 18 16)" 28.25682 0.04 # 0.5
    near "$(node shear_deg -12 12)" -14.27443 0.02
    drape_example freeform
    near "$(node shear_deg 20 20)" -19.9897 0.1 # the limit for ever finer nodes
    near "$(node x -20 -20)" 76.79671 0.05
}

@test "http: without Prefer the answer is 202, then the status, then the result" {
    quick 1.01 | submit
    [ "$(header Location)" = "/v1/drapes/$id" ]
    jq -e '.attempts >= 0 and (.created | test("^[0-9-]+T[0-9:.]+Z$")) and
           .links.result == "/v1/drapes/\(.id)/result"' "$body" >/dev/null
    wait_for "$id" succeeded
    jq -e '.progress == 1 and .finished >= .started and .started >= .created and
           .summary.nodes > 0 and .attempts == 1 and (has("error") | not)' "$body" >/dev/null
    call GET "/v1/drapes/$id/result"
    expect 200
    [ "$(header Content-Type)" = application/json ]
    [ "$(field .id)" = "$id" ]
    check_columns "$body"
}

@test "http: Prefer: wait may have blanks and quotes" {
    for prefer in 'wait = 40' 'wait="40"' 'respond-async, WAIT= "40"; x=y'; do
        quick 1.03 | post /v1/drapes - -H "Prefer: $prefer"
        expect 200
        [ "$(header Preference-Applied)" = wait ]
    done
    for prefer in wait 'wait=' 'wait=-1' 'waits=40' 'wait 40'; do
        quick 1.031 | post /v1/drapes - -H "Prefer: $prefer"
        expect 202
    done
}

@test "http: the times of a drape are those of the clock" {
    local before after created
    before=$(date +%s)
    quick 1.032 | submit
    after=$(date +%s)
    wait_for "$id" succeeded
    for time in created started finished; do
        [[ "$(field ".$time")" =~ ^[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}\.[0-9]{6}Z$ ]]
    done
    created=$(date -d "$(field .created)" +%s)
    [ "$created" -ge "$before" ]
    [ "$created" -le "$after" ]
}

@test "http: with Prefer: wait the result comes at once and says so" {
    quick 1.02 | post /v1/drapes - -H 'Prefer: respond-async, wait=40'
    expect 200
    [ "$(header Preference-Applied)" = wait ]
    id=$(field .id)
    [ "$(header Location)" = "/v1/drapes/$id" ]
    [ "$(header Content-Location)" = "/v1/drapes/$id/result" ]
    [ -n "$(header ETag)" ]
}

# Of a result that is made ready while it is stored: one that is short, one that is not so any more.
@test "http: who waits gets the bytes that are stored" {
    local factor=1.021 coding etag
    for spacing in 1 0.28; do
        for format in json csv vtp glb npz; do
            for coding in identity gzip; do
                factor=$(jq -n "$factor + 0.0001")
                quick "$(jq -n "$factor * $spacing")" | post "/v1/drapes?format=$format" - \
                    -H 'Prefer: wait=40' -H "Accept-Encoding: $coding"
                expect 200
                etag=$(header ETag)
                cp "$body" "$BATS_TEST_TMPDIR/waited"
                call GET "$(header Content-Location)?format=$format" -H "Accept-Encoding: $coding"
                expect 200
                [ "$(header ETag)" = "$etag" ]
                cmp "$body" "$BATS_TEST_TMPDIR/waited"
            done
        done
    done
}

# Both are solved; the times of one of them are kept.
@test "http: who waits for a result that another has stored first gets that" {
    local request="$BATS_TEST_TMPDIR/request" waits=()
    quick 0.41 | jq '.method = "geodesic"' >"$request"
    for k in 1 2; do
        curl -sS --max-time 50 -H "$JSON" -H 'Prefer: wait=40' --data-binary "@$request" \
            -o "$BATS_TEST_TMPDIR/$k" "$URL/v1/drapes" 3>&- &
        waits+=($!)
    done
    wait "${waits[@]}"
    for k in 1 2; do
        call GET "/v1/drapes/$(jq -r .id "$BATS_TEST_TMPDIR/$k")/result"
        expect 200
        cmp "$body" "$BATS_TEST_TMPDIR/$k"
    done
}

@test "http: the entity tag of a result changes with what encodes it" {
    local digest
    digest=$(cat $(printf '%s\n' api/format/*.[ch] api/json/*.[ch] api/json/*.cc api/result/*.[ch] |
        LC_ALL=C sort) api/embed_powers.py | sha256sum | cut -c1-8)
    quick 1.029 | submit
    call GET "/v1/drapes/$id?wait=40"
    call GET "/v1/drapes/$id/result"
    expect 200
    [[ "$(header ETag)" == *"-$digest-"* ]]
}

@test "http: an identical request shares the result and keeps its own id" {
    quick 1.03 | submit
    first=$id
    wait_for "$first" succeeded
    quick 1.03 | jq '{method: "gib"} + .' | submit
    [ "$id" != "$first" ]
    wait_for "$id" succeeded
    call GET "/v1/drapes/$id/result?fields=nodes.x"
    jq -S 'del(.id, .summary.timing_ms)' "$body" >"$BATS_TEST_TMPDIR/second"
    call GET "/v1/drapes/$first/result?fields=nodes.x"
    jq -S 'del(.id, .summary.timing_ms)' "$body" | cmp - "$BATS_TEST_TMPDIR/second"
}

@test "http: the command line gives the same numbers as the daemon" {
    for name in saddle sphere freeform; do
        drape_example "$name"
        "$DRAPE" "$EXAMPLES/$name.json" >"$BATS_TEST_TMPDIR/alone"
        for file in "$body" "$BATS_TEST_TMPDIR/alone"; do
            jq -S 'del(.id, .summary.timing_ms)' "$file" >"$file.numbers"
        done
        cmp "$body.numbers" "$BATS_TEST_TMPDIR/alone.numbers"
    done
}

@test "http: the request as it was understood can be posted again" {
    jq '{surface, fabric: {spacing: 0.21}}' "$EXAMPLES/saddle.json" | submit
    wait_for "$id" succeeded
    call GET "/v1/drapes/$id/request"
    expect 200
    jq -e '.method == "gib" and .yarn_path == "chord" and .cavity == "flexible" and
           .length_unit == "m" and .direction.angle_deg == 0 and (.start | length) > 0' "$body"
    cp "$body" "$BATS_TEST_TMPDIR/understood"
    post /v1/drapes "$BATS_TEST_TMPDIR/understood" -H 'Prefer: wait=40'
    expect 200
    again=$(field .id)
    call GET "/v1/drapes/$again/request"
    cmp "$body" "$BATS_TEST_TMPDIR/understood"
}

@test "http: csv holds one table, the fields asked for, at the precision asked for" {
    quick 1.04 | post /v1/drapes - -H 'Prefer: wait=40'
    id=$(field .id)
    rows=$(field .summary.cells)
    call GET "/v1/drapes/$id/result?format=csv&table=cells&fields=cells.i,cells.shear_deg"
    expect 200
    [[ "$(header Content-Type)" == text/csv* ]]
    [ "$(head -1 "$body" | tr -d '\r')" = i,shear_deg ]
    [ "$(wc -l <"$body")" -eq $((rows + 1)) ]
    call GET "/v1/drapes/$id/result?precision=3&fields=nodes.x" -H 'Accept: text/csv'
    expect 200
    [ "$(head -1 "$body" | tr -d '\r')" = x ]
    [ "$(tr -d '\r\n.-' <<<"$(sed -n 2p "$body")" | sed 's/^0*//' | wc -c)" -le 4 ]
}

@test "http: fields and precision select and round json too" {
    quick 1.05 | post '/v1/drapes?fields=nodes.x,cells.shear_deg&precision=2' - -H 'Prefer: wait=40'
    expect 200
    jq -e '(.nodes | keys) == ["x"] and (.cells | keys) == ["shear_deg"] and
           (.nodes.x | all(tostring | length < 8))' "$body" >/dev/null
}

@test "http: wrong result options are problems" {
    quick 1.06 | submit
    wait_for "$id" succeeded
    call GET "/v1/drapes/$id/result?precision=18"
    expect_problem 422 invalid-request
    call GET "/v1/drapes/$id/result?table=front"
    expect_problem 422 invalid-request
    call GET "/v1/drapes/$id/result?fields=nodes.nothing"
    expect_problem 422 invalid-request
    call GET "/v1/drapes/$id/result?feilds=nodes.x"
    expect_problem 422 invalid-request
    call GET "/v1/drapes/$id/result?format=stl"
    expect_problem 406 not-acceptable
    call GET "/v1/drapes/$id/result" -H 'Accept: image/png'
    expect_problem 406 not-acceptable
    call GET "/v1/drapes/$id/result" -H 'Accept: image/png, */*;q=0.1'
    expect 200
}

@test "http: the entity tag is strong, differs by representation and gives 304" {
    quick 1.07 | submit
    wait_for "$id" succeeded
    call GET "/v1/drapes/$id/result"
    tag=$(header ETag)
    [[ "$tag" == \"*\" ]]
    call GET "/v1/drapes/$id/result" -H "If-None-Match: \"x\", $tag"
    expect 304
    [ ! -s "$body" ]
    [ "$(header ETag)" = "$tag" ]
    call GET "/v1/drapes/$id/result" -H "If-None-Match: W/$tag"
    expect 304
    call GET "/v1/drapes/$id/result?format=csv" -H "If-None-Match: $tag"
    expect 200
    call GET "/v1/drapes/$id/result?precision=4" -H "If-None-Match: $tag"
    expect 200
    call GET "/v1/drapes/$id/result" -H "If-None-Match: *"
    expect 304
}

@test "http: HEAD tells what GET would, without a body" {
    quick 1.08 | submit
    wait_for "$id" succeeded
    for path in "/v1/drapes/$id" "/v1/drapes/$id/result" "/v1/drapes/$id/request" /v1/drapes \
        /v1/surfaces /v1/limits /v1/openapi.json / /healthz /readyz /version /metrics; do
        call GET "$path"
        type=$(header Content-Type) tag=$(header ETag)
        call HEAD "$path"
        expect 200
        [ "$(header Content-Type)" = "$type" ]
        [ "$(header ETag)" = "$tag" ]
    done
    call HEAD /v1/drapes/00000000000000000000000000000000
    expect 404
}

@test "http: the list is newest first, filtered by status, and pages without gaps" {
    ids=()
    for factor in 1.11 1.12 1.13 1.14 1.15; do
        quick "$factor" | submit
        ids=("$id" "${ids[@]}")
        wait_for "$id" succeeded
    done
    call GET '/v1/drapes?limit=2&status=succeeded'
    expect 200
    seen=$(field '.drapes[].id')
    cursor=$(field .next)
    call GET "/v1/drapes?limit=3&status=succeeded&cursor=$cursor"
    seen+=$'\n'$(field '.drapes[].id')
    [ "$seen" = "$(printf '%s\n' "${ids[@]}")" ]
    call GET '/v1/drapes?status=running'
    [ "$(field '.drapes | length')" = 0 ]
    jq -e '.next == null' "$body"
    for query in limit=0 limit=1001 limit=x status=done cursor=abc cursor=-1 cursor= page=2; do
        call GET "/v1/drapes?$query"
        expect_problem 422 invalid-request
    done
}

@test "http: a drape that is deleted is gone with its result" {
    quick 1.2 | submit
    wait_for "$id" succeeded
    call DELETE "/v1/drapes/$id"
    expect 204
    [ ! -s "$body" ]
    for path in "/v1/drapes/$id" "/v1/drapes/$id/result" "/v1/drapes/$id/request" \
        "/v1/drapes/$id/events"; do
        call GET "$path"
        expect_problem 404 not-found
    done
    call DELETE "/v1/drapes/$id"
    expect_problem 404 not-found
}

@test "http: unknown ids and paths are 404" {
    for path in /v1/drapes/0123456789abcdef0123456789abcdef /v1/drapes/x \
        /v1/drapes/0123456789abcdef0123456789abcdef/result "/v1/drapes/%27%20or%201=1" \
        /v1/surfaces/0123456789abcdef0123456789abcdef /v1/surfaces/x /v1 /v1/ /v1/drapes/ /v2/drapes \
        /v1/drapes/a/b/c/d/e/f/g/h/i/j /v1/drapes/x/nothing /favicon.txt; do
        call GET "$path"
        expect_problem 404 not-found
    done
    call POST /v1/drapes/0123456789abcdef0123456789abcdef/cancel
    expect_problem 404 not-found
}

@test "http: a spacing that makes no cell is refused, with one that does" {
    jq '.fabric.spacing = 50' "$EXAMPLES/saddle.json" | post /v1/drapes - -H 'Prefer: wait=40'
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /fabric/spacing ]
    spacing=$(field .detail | grep -oE 'a spacing of [0-9.]+' | grep -oE '[0-9.]+$')
    jq --argjson spacing "$spacing" '.fabric.spacing = $spacing' "$EXAMPLES/saddle.json" |
        post '/v1/drapes?fields=cells.i' - -H 'Prefer: wait=40'
    expect 200
    [ "$(field .summary.cells)" -gt 100 ]
}

@test "http: where no spacing makes a cell, as on a strip like a hair, that is said at once" {
    echo '{"surface": {"degree_u": 1, "degree_v": 1, "size_u": 2, "size_v": 2, "knotvector_u": [0, 0, 1, 1],
           "knotvector_v": [0, 0, 1, 1], "control_points": [[0, 0, 0], [0, 1e-6, 0], [1, 0, 0], [1, 1e-6, 0]]},
           "fabric": {"spacing": 0.5}}' | post /v1/drapes - -H 'Prefer: wait=40'
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /fabric/spacing ]
    [[ "$(field .detail)" = *'without a cell, and so does one of '*'move the start, or turn'* ]]
}

@test "http: a start off the surface is the drape's own problem" {
    jq '.start = {"point": [100, 100, 100]}' "$EXAMPLES/saddle.json" | submit
    wait_for "$id" failed
    jq -e '.error.type == "/problems/start-off-surface" and .error.status == 422 and
           .error.pointer == "/start" and
           (.error.detail | test("^must be on .* it is 170.6 m away from .(2, .*.), the nearest point"))' "$body"
    call GET "/v1/drapes/$id/result"
    expect_problem 422 start-off-surface
    jq '.start = {"point": [100, 100, 101]}' "$EXAMPLES/saddle.json" |
        post /v1/drapes - -H 'Prefer: wait=40'
    expect_problem 422 start-off-surface
}
