# SPDX-License-Identifier: MIT
# What web pages of other origins, and names that were made to point here, can do: nothing.

load helper

setup_file() {
    start_shared_daemon --workers 1 --public-name draped.example,drape.inner \
        --cors-origin https://a.example
}
teardown_file() { end_file; }

# with_host NAME: GET /version under that name.
with_host() { call GET /version -H "Host: $1"; }

@test "origin: loopback names, the address of --listen and public names are answered" {
    for name in localhost "localhost:$PORT" LOCALHOST 127.0.0.1 "127.0.0.1:$PORT" 127.1.2.3 '[::1]' '[::1]:80' \
        draped.example draped.example:8443 DRAPED.example drape.inner; do
        with_host "$name"
        expect 200
    done
    call GET /version -0 -H 'Host:'
    expect 200
}

@test "origin: any other name is 403, for every route and method" {
    for name in attacker.example "attacker.example:$PORT" localhost.attacker.example example \
        draped.example.attacker.example xdraped.example 10.0.0.1 '[::2]' 128.0.0.1 0.0.0.0; do
        with_host "$name"
        expect_problem 403 forbidden
    done
    for path in / /v1/drapes /v1/limits /metrics /nothing; do
        call GET "$path" -H 'Host: attacker.example'
        expect_problem 403 forbidden
    done
    for method in POST DELETE OPTIONS HEAD; do
        call $method /v1/drapes -H 'Host: attacker.example'
        expect 403
    done
    call GET /version -0 -H 'Host: attacker.example'
    expect_problem 403 forbidden
}

@test "origin: the host of an absolute target counts, not the header" {
    call GET /version --request-target http://attacker.example/version
    expect_problem 403 forbidden
    call GET /version --request-target http://localhost/version -H 'Host: attacker.example'
    expect 200
}

@test "origin: probes answer under any name" {
    for path in /healthz /readyz; do
        call GET $path -H 'Host: attacker.example'
        expect 200
    done
}

@test "origin: pages of other origins make, cancel and delete nothing" {
    quick 1 | submit
    for origin in https://b.example http://localhost:1 null "https://127.0.0.1" http://127.0.0.1.b.example \
        "https://draped.example.b.example" https://a.example.b.example; do
        quick 1.1 | post /v1/drapes - -H "Origin: $origin"
        expect_problem 403 forbidden
        call POST "/v1/drapes/$id/cancel" -H "Origin: $origin"
        expect_problem 403 forbidden
        call DELETE "/v1/drapes/$id" -H "Origin: $origin"
        expect_problem 403 forbidden
        post "/v1/drapes/$id/map" /dev/null -H "Origin: $origin"
        expect_problem 403 forbidden
        post /v1/surfaces /dev/null -H "Origin: $origin"
        expect_problem 403 forbidden
    done
    for site in cross-site same-site nonsense; do
        quick 1.1 | post /v1/drapes - -H "Sec-Fetch-Site: $site"
        expect_problem 403 forbidden
    done
    wait_for "$id" succeeded
}

@test "origin: pages of the own origin, public names and --cors-origin do" {
    for origin in "http://127.0.0.1:$PORT" "https://draped.example" https://DRAPED.example:8443 https://a.example; do
        quick 1.2 | post /v1/drapes - -H "Origin: $origin"
        expect 202
    done
    for site in same-origin none; do
        quick 1.2 | post /v1/drapes - -H "Sec-Fetch-Site: $site"
        expect 202
    done
    quick 1.2 | post /v1/drapes - -H 'Sec-Fetch-Site: cross-site' -H 'Origin: https://a.example'
    expect 202
}

@test "origin: a page sends no body without a Content-Type" {
    quick 1.3 >"$BATS_TEST_TMPDIR/request"
    call POST /v1/drapes --data-binary "@$BATS_TEST_TMPDIR/request" -H 'Content-Type:' \
        -H "Origin: http://127.0.0.1:$PORT"
    expect_problem 415 unsupported-media-type
    call POST /v1/drapes --data-binary "@$BATS_TEST_TMPDIR/request" -H 'Content-Type:'
    expect 202
}

@test "origin: a page sends no CAD file in the types of forms" {
    for type in text/plain 'multipart/form-data; boundary=x' application/x-www-form-urlencoded ''; do
        call POST '/v1/surfaces?format=stl' --data-binary solid -H "Content-Type:$type" \
            -H "Origin: http://127.0.0.1:$PORT"
        expect_problem 415 unsupported-media-type
    done
    call POST '/v1/surfaces?format=stl' --data-binary solid -H Content-Type: -H 'Sec-Fetch-Site: none'
    expect_problem 422 unreadable-file
}

@test "origin: bodies with a Content-Encoding are 415" {
    quick 1.4 | gzip >"$BATS_TEST_TMPDIR/packed"
    post /v1/drapes "$BATS_TEST_TMPDIR/packed" -H 'Content-Encoding: gzip'
    expect_problem 415 unsupported-media-type
    [ "$(header Accept-Encoding)" = identity ]
}

@test "origin: --public-name '*' takes any name, and lets no other page write" {
    start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1 --public-name '*'
    with_host anything.example
    expect 200
    quick 1 | post /v1/drapes - -H 'Origin: https://b.example'
    expect_problem 403 forbidden
    stop_daemon
}

@test "origin: on all addresses any address is a name of the service" {
    start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1 --listen 0.0.0.0:0 --allow-anonymous
    URL=http://127.0.0.1:$PORT
    with_host 10.1.2.3:80
    expect 200
    with_host attacker.example
    expect_problem 403 forbidden
    stop_daemon
}

@test "origin: --public-name takes names without ports, and '*' alone" {
    for names in 'a b' 'a,' 'a:80' 'http://a' , '*,a' 'a,*' '*.example'; do
        run "$DRAPED" --check-config --public-name "$names"
        [ "$status" = 2 ]
        [[ "$output" == *--public-name*"* alone for any"* ]]
    done
    run "$DRAPED" --check-config --cors-origin 'https://*.example'
    [ "$status" = 2 ]
    [[ "$output" == *--cors-origin*"* alone for any"* ]]
    run "$DRAPED" --check-config --public-name 'a.example,b-c.example'
    [ "$status" = 0 ]
}
