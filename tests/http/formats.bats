# SPDX-License-Identifier: MIT
# How formats and codings are chosen, and what the headers say about them.
load helper

setup_file() {
    start_shared_daemon
    quick 1.51 | curl -sS -H "$JSON" -H 'Prefer: wait=40' --data-binary @- \
        "$URL/v1/drapes" | jq -r .id >"$BATS_FILE_TMPDIR/id"
}
teardown_file() { end_file; }
setup() { id=$(<"$BATS_FILE_TMPDIR/id"); }

@test "formats: each is had by its name and by its media type" {
    while read -r format type; do
        call GET "/v1/drapes/$id/result?format=$format"
        expect 200
        [ "$(header Content-Type)" = "$type" ]
        cp "$body" "$BATS_TEST_TMPDIR/by_name"
        call GET "/v1/drapes/$id/result" -H "Accept: $type"
        expect 200
        cmp "$body" "$BATS_TEST_TMPDIR/by_name"
    done <<END
json application/json
csv text/csv
vtp application/vnd.vtk
glb model/gltf-binary
npz application/x-npz
END
    call GET "/v1/drapes/$id/result?format=doc"
    expect_problem 406 not-acceptable
    [[ $(field .detail) == *'json, csv, vtp, glb, npz' ]]
}

@test "formats: the pattern is svg or dxf" {
    call GET "/v1/drapes/$id/pattern"
    expect 200
    [ "$(header Content-Type)" = image/svg+xml ]
    call GET "/v1/drapes/$id/pattern" -H 'Accept: image/vnd.dxf'
    expect 200
    grep -q AC1009 "$body"
    call GET "/v1/drapes/$id/pattern?format=dxf&allowance=0.02&part=Wing&ply=3"
    expect 200
    grep -q ALLOWANCE "$body"
    grep -q "Wing, ply 3" "$body"
    for allowance in -1 1e3 wide; do
        call GET "/v1/drapes/$id/pattern?allowance=$allowance"
        expect_problem 422 invalid-request
    done
    call GET "/v1/drapes/$id/pattern?format=json"
    expect_problem 406 not-acceptable
    call GET "/v1/drapes/$id/pattern?fields=nodes.x"
    expect_problem 422 invalid-request
    call GET /v1/drapes/none/pattern
    expect_problem 404 not-found
}

@test "formats: the report is a page of its own, with names, inputs and an entity tag" {
    call GET "/v1/drapes/$id/report?part=Wing&ply=3&allowance=0.02"
    expect 200
    [ "$(header Content-Type)" = text/html ]
    grep -q '<title>Wing, ply 3</title>' "$body"
    grep -q 'method</th><td>&quot;gib&quot;' "$body"
    grep -q "Digest of the request</th><td>[0-9a-f]\{32\}<" "$body"
    grep -q 'Report by</th><td>draped [0-9.]*\(-rc[0-9]*\)\?<' "$body"
    grep -q "Finished</th><td>20[0-9-]*T[0-9:.]*Z<" "$body"
    call GET "/v1/drapes/$id/report" -H "Accept: text/html" -H "If-None-Match: $(header ETag)"
    expect 200
    grep -q "<title>Drape $id</title>" "$body"
    call GET "/v1/drapes/$id/report" -H "If-None-Match: $(header ETag)"
    expect 304
    call GET "/v1/drapes/$id/report" -r 0-14
    expect 206
    [ "$(<"$body")" = '<!doctype html>' ]
    call GET "/v1/drapes/$id/report?part=%3Cscript%3E"
    expect_problem 422 invalid-request
    call GET "/v1/drapes/$id/report" -H 'Accept: application/json'
    expect_problem 406 not-acceptable
    call GET /v1/drapes/none/report
    expect_problem 404 not-found
}

@test "formats: the report of a drape on a stored surface names that" {
    jq -c .surface api/examples/saddle.json >"$BATS_TEST_TMPDIR/surface.json"
    call POST /v1/surfaces -H "Content-Type: application/json" \
        --data-binary @"$BATS_TEST_TMPDIR/surface.json"
    local stored=$(field .id)
    jq -c --arg id "$stored" '.surface = {id: $id}' api/examples/saddle.json >"$BATS_TEST_TMPDIR/named.json"
    call POST /v1/drapes -H "Content-Type: application/json" -H "Prefer: wait=20" \
        --data-binary @"$BATS_TEST_TMPDIR/named.json"
    expect 200
    call GET "/v1/drapes/$(field .id)/report"
    expect 200
    grep -q "$stored" "$body"
}

@test "formats: what is long and of known length says so, and keeps it" {
    for format in vtp glb npz; do
        call GET "/v1/drapes/$id/result?format=$format"
        [ "$(header Content-Length)" -eq "$(stat -c %s "$body")" ]
        local length
        length=$(header Content-Length)
        call HEAD "/v1/drapes/$id/result?format=$format"
        expect 200
        [ "$(header Content-Length)" -eq "$length" ]
    done
}

@test "formats: zstd and gzip carry the same document" {
    for format in json csv vtp glb npz; do
        call GET "/v1/drapes/$id/result?format=$format"
        [ -z "$(header Content-Encoding)" ]
        local length
        length=$(stat -c %s "$body")
        cp "$body" "$BATS_TEST_TMPDIR/plain"
        for coding in zstd gzip; do
            call GET "/v1/drapes/$id/result?format=$format" -H "Accept-Encoding: $coding"
            [ "$(header Content-Encoding)" = "$coding" ]
            [ "$(stat -c %s "$body")" -lt "$length" ]
            call GET "/v1/drapes/$id/result?format=$format" --compressed \
                -H "Accept-Encoding: $coding"
            cmp "$body" "$BATS_TEST_TMPDIR/plain"
        done
    done
}

@test "formats: the coding is the one the caller wants most" {
    while read -r wanted coding; do
        call GET "/v1/drapes/$id/result" -H "Accept-Encoding: $wanted"
        [ "$(header Content-Encoding)" = "${coding#none}" ] ||
            { echo "$wanted: $(header Content-Encoding)"; return 1; }
    done <<END
gzip,zstd zstd
gzip;q=1,zstd;q=0.5 gzip
zstd;q=0,gzip gzip
* zstd
*;q=0 none
br,deflate none
identity,gzip;q=0.5 none
gzip;q=0 none
GZIP gzip
END
}

@test "formats: every format and coding has an entity tag of its own" {
    for format in json csv vtp glb npz; do
        for coding in identity zstd gzip; do
            call GET "/v1/drapes/$id/result?format=$format" -H "Accept-Encoding: $coding"
            header ETag >>"$BATS_TEST_TMPDIR/tags"
            [ "$(header Vary)" = 'Accept, Accept-Encoding' ]
            local tag
            tag=$(header ETag)
            call GET "/v1/drapes/$id/result?format=$format" -H "Accept-Encoding: $coding" \
                -H "If-None-Match: $tag"
            expect 304
            [ "$(header ETag)" = "$tag" ]
        done
    done
    [ "$(sort -u "$BATS_TEST_TMPDIR/tags" | wc -l)" -eq 15 ]
    not grep -q '^W/' "$BATS_TEST_TMPDIR/tags"
}

@test "formats: a list of headers may come in several lines" {
    call GET "/v1/drapes/$id/result" -H 'Accept: image/png' -H 'ACCEPT: text/csv' -H 'Accept:;'
    expect 200
    [ "$(header Content-Type)" = text/csv ]
    call GET "/v1/drapes/$id/result" -H 'Accept-Encoding: br' -H 'Accept-Encoding: gzip'
    [ "$(header Content-Encoding)" = gzip ]
    call GET "/v1/drapes/$id/result" -H 'Accept-Encoding: gzip' -H 'If-None-Match: "a"' \
        -H "If-None-Match: $(header ETag)" -H 'If-None-Match: "b"'
    expect 304
    quick 2.7 | post /v1/drapes - -H 'Prefer: handling=strict' -H 'Prefer: wait=20'
    expect 200
}

@test "formats: the same result has the same bytes each time" {
    for format in vtp glb npz; do
        call GET "/v1/drapes/$id/result?format=$format" -H 'Accept-Encoding: zstd'
        cp "$body" "$BATS_TEST_TMPDIR/first"
        call GET "/v1/drapes/$id/result?format=$format" -H 'Accept-Encoding: zstd'
        cmp "$body" "$BATS_TEST_TMPDIR/first"
    done
}

@test "formats: the command line gives the daemon's bytes" {
    for format in vtp glb npz; do
        call GET "/v1/drapes/$id/result?format=$format"
        quick 1.51 | "$DRAPE" --format $format -o "$BATS_TEST_TMPDIR/own"
        # glb carries the drape's id, which the command line does not have.
        [ $format = glb ] || cmp "$body" "$BATS_TEST_TMPDIR/own"
    done
}
