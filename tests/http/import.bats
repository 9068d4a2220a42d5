# SPDX-License-Identifier: MIT
# Surfaces from files of CAD and mesh.
load helper

setup_file() {
    export PARTS=$BATS_FILE_TMPDIR/parts
    mkdir "$PARTS"
    "${BUILD:-build}/tests/import/make_parts" "$PARTS" >/dev/null
    start_shared_daemon --workers 1
}
teardown_file() { end_file; }

# send TYPE FILE [QUERY]
send() { call POST "/v1/surfaces$3" -H "Content-Type: $1" --data-binary @"$2"; }

@test "http: a STEP file is stored as its faces, in its own unit" {
    send model/step "$PARTS/rounded.step" '?unit=m'
    expect 201
    id=$(field .id)
    [ "$(header Location)" = "/v1/surfaces/$id" ]
    jq -e '.length_unit == "mm" and (.area - 9420.1058553662 | fabs) < 1e-5 and .components == 1 and
           (.edges | .shared == 48 and .free == 0 and .faulty == 0) and (.faces | length) == 26 and
           (.faces[25] | .index == 25 and (.normal | length) == 3 and (.bounding_box | length) == 2) and
           (.notes | any(test("unit=m was ignored")) and any(test("a solid")))' "$body"
    send application/octet-stream "$PARTS/rounded.step" '?format=step&unit=m'
    expect 200
    [ "$(field .id)" = "$id" ]
    send model/iges "$PARTS/rounded_iges.igs"
    expect 201
    jq -e '.length_unit == "in" and (.faces | length) == 26' "$body"
}

@test "http: chosen faces of a STEP file are draped, in the file's unit" {
    send model/step "$PARTS/rounded.step"
    id=$(field .id)
    # The largest face and the fillets round it are smooth from there, so is all of the box.
    jq '[.faces[] | {index, area}] | max_by(.area).index' "$body" | read -r top
    cat >"$BATS_TEST_TMPDIR/request" <<-END
	{"surface": {"id": "$id", "faces": [$top]}, "fabric": {"spacing": 2}}
	END
    call POST '/v1/drapes?fields=nodes.face,nodes.x' -H "$JSON" -H 'Prefer: wait=20' \
        --data-binary @"$BATS_TEST_TMPDIR/request"
    expect 200
    jq -e --argjson top "$top" '.summary.outcome == "complete" and
        (.nodes.face | unique == [$top]) and (.nodes.x | length) > 50' "$body"
    call GET "/v1/drapes/$(field .id)/request"
    jq -e --argjson top "$top" '.length_unit == "mm" and .start.face == $top and
        .surface.faces == [$top]' "$body"
    sed 's/"faces": .*}, "fabric"/"grow_from": 0, "up_to_deg": 1}, "fabric"/
         s/}}$/, "pre_shear_deg": 0}, "length_unit": "m"}/' "$BATS_TEST_TMPDIR/request" | post /v1/drapes -
    expect_problem 422 invalid-request
    [ "$(field .pointer)" = /length_unit ]
}

# refuse POINTER WORDS: the drape on standard input is invalid there, and the detail has the words.
refuse() {
    post /v1/drapes -
    expect 422
    jq -e --arg at "$1" --arg words "$2" '.pointer == $at and (.detail | test($words))' "$body"
}

# off WORDS: the drape on standard input starts off its surface, and the detail has the words.
off() {
    call POST /v1/drapes -H "$JSON" -H 'Prefer: wait=20' --data-binary @-
    expect_problem 422 start-off-surface
    jq -e --arg words "$1" '.pointer == "/start" and (.detail | test($words))' "$body"
}

@test "http: bad choices of faces, starts and tolerances are told with their place" {
    send model/step "$PARTS/rounded.step"
    id=$(field .id)
    some="{\"surface\": {\"id\": \"$id\", \"faces\": [3, 4]}, \"fabric\": {\"spacing\": 2}, \"start\": "
    echo "$some {\"face\": 7, \"uv\": [20, 7]}}" | refuse /start/face "face 7 is not among those chosen"
    echo "{\"surface\": {\"id\": \"$id\", \"faces\": [3, 26]}, \"fabric\": {\"spacing\": 2}}" |
        refuse /surface/faces/1 "less than 26"
    echo "$some {\"face\": 3, \"uv\": [-1, 7]}}" | refuse /start/uv "in the domain of face 3, between"
    echo "$some {\"point\": [0, 20, 15]}}" | off "on face 0, which is not among those chosen"
    echo "$some {\"point\": [0, 20, -15]}}" | off "must be on the surface"
    "${BUILD:-build}/drape-import" "$PARTS/rounded.step" 2>/dev/null >"$BATS_TEST_TMPDIR/part"
    within() {
        jq -c --argjson t "$1" '{surface: {faces, tolerance: $t}, length_unit: "mm", fabric: {spacing: 2}}' \
            "$BATS_TEST_TMPDIR/part"
    }
    within 0 | refuse /surface/tolerance "must be a number between"
    within 20 | refuse /surface/faces "meet at one edge, within the tolerance of 20"
    within 1e9 | refuse /surface/tolerance "as large as the part"
}

@test "http: three faces at an edge are a note of the file and a fault of the drape" {
    send model/step "$PARTS/fin.step"
    expect 201
    jq -e '.edges.faulty == 1 and (.notes | any(test("3 faces meet at one edge")))' "$body"
    id=$(field .id)
    echo "{\"surface\": {\"id\": \"$id\"}, \"fabric\": {\"spacing\": 1}}" | post /v1/drapes -
    expect_problem 422 invalid-request
    jq -e '.pointer == "/surface/faces" and (.detail | test("faces 0, 1 and 3 meet"))' "$body"
    echo "{\"surface\": {\"id\": \"$id\", \"faces\": [0, 1, 2]}, \"fabric\": {\"spacing\": 1}}" |
        post /v1/drapes -
    expect 202
}

@test "http: files that cannot be imported get their reason" {
    send model/step "$PARTS/wires.step"
    expect_problem 422 unreadable-file
    jq -e '.detail | test("3 edges and no face")' "$body"
    send model/step "$EXAMPLES/saddle.json"
    expect_problem 422 unreadable-file
    head -c 20000 "$PARTS/cuts.step" >"$BATS_TEST_TMPDIR/cut"
    send model/step "$BATS_TEST_TMPDIR/cut"
    expect_problem 422 unreadable-file
    { echo 'ISO-10303-21;'; seq -f '#%.0f = ADVANCED_FACE(' 20001; } >"$BATS_TEST_TMPDIR/many"
    send model/step "$BATS_TEST_TMPDIR/many"
    expect_problem 422 unreadable-file
    jq -e '.detail | test("20001 faces, but at most 20000")' "$body"
    { printf '%-72sS%7d\n' many 1; seq 40002 | awk '{printf "     144%-64sD%7d\n", "", $1}'; } \
        >"$BATS_TEST_TMPDIR/many"
    send model/iges "$BATS_TEST_TMPDIR/many"
    expect_problem 422 unreadable-file
    jq -e '.detail | test("20001 faces, but at most 20000")' "$body"
    send model/stl "$EXAMPLES/saddle.json"
    expect_problem 422 unreadable-file
    send model/step "$PARTS/box.step" '?format=parasolid'
    expect_problem 422 invalid-request
    send model/step "$PARTS/box.step" '?unit=mile'
    expect_problem 422 invalid-request
    send model/parasolid "$PARTS/box.step"
    expect_problem 415 unsupported-media-type
}

@test "http: an import that takes too long is told so, and holds up no other" {
    local many=$PARTS/many.step long=$BATS_TEST_TMPDIR/long.step copy
    sed '/^DATA;/q' "$many" >"$long"
    for copy in 1 2 3 4 5 6 7 8 9; do
        sed -E -e '1,/^DATA;/d' -e '/^ENDSEC;/,$d' -e "s/#([0-9])/#$copy\1/g" "$many" >>"$long"
    done
    printf 'ENDSEC;\nEND-ISO-10303-21;\n' >>"$long"
    start_daemon "$BATS_TEST_TMPDIR/other" --workers 1 --import-timeout 1
    send model/step "$long"
    expect_problem 422 unreadable-file
    jq -e '.detail | test("longer than 1 s \\(--import-timeout\\)")' "$body"
    # Of another kind: with sanitizers, on a busy machine, no import is sure to end within a second.
    jq .surface $EXAMPLES/saddle.json | post /v1/surfaces -
    expect 201
    stop_daemon
}

@test "http: meshes of STL, OBJ and Nastran files are welded" {
    cat >"$BATS_TEST_TMPDIR/a.obj" <<-'END'
	# a square, and a part of it once more
	v 0 0 0
	v 2 0 0
	v 2 2 0
	v 0 2 0
	v 2 0 1e-9
	f 1/1 2/2 3/3 4/4
	f -4 1 -3
	f 2 5 3
	END
    send model/obj "$BATS_TEST_TMPDIR/a.obj" '?unit=mm'
    expect 201
    jq -e '.vertices == 4 and .triangles == 2 and .area == 4 and .length_unit == "mm" and
           .edges == {shared: 1, free: 4, faulty: 0, largest_gap: 0} and
           .faces[0].kind == "mesh" and (.notes | length) == 2' "$body"
    id=$(field .id)
    cat >"$BATS_TEST_TMPDIR/a.stl" <<-'END'
	solid a
	facet normal 0 0 1
	outer loop
	vertex 0 0 0
	vertex 2 0 0
	vertex 2 2 0
	endloop
	endfacet
	facet normal 0 0 1
	outer loop
	vertex 0 0 0
	vertex 2 2 0
	vertex 0 2 0
	endloop
	endfacet
	endsolid
	END
    send model/stl "$BATS_TEST_TMPDIR/a.stl" '?unit=mm'
    expect 201
    jq -e '.vertices == 4 and .triangles == 2 and .area == 4' "$body"
    send text/x-nastran "$EXAMPLES/mould.bdf"
    expect 201
    jq -e '.triangles > 10 and .components == 1' "$body"
    echo "{\"surface\": {\"id\": \"$id\"}, \"method\": \"mosaic\", \"fabric\": {\"spacing\": 0.1}}" |
        post /v1/drapes -
    expect 202
}

@test "http: without the importer a STEP file is 415 and says what to install" {
    mkdir -p "$BATS_TEST_TMPDIR/alone"
    cp "$DRAPED" "$BATS_TEST_TMPDIR/alone/draped"
    shared=$DAEMON url=$URL
    DRAPED=$BATS_TEST_TMPDIR/alone/draped start_daemon "$BATS_TEST_TMPDIR/daemon" --workers 1
    send model/step "$PARTS/box.step"
    expect_problem 415 unsupported-media-type
    jq -e '.detail | test("apt install draped-import")' "$body"
    stop_daemon
    DAEMON=$shared URL=$url
}

@test "cli: the surface of a request may be a file, and the result is the service's" {
    send model/step "$PARTS/rounded.step"
    id=$(field .id)
    cat >"$BATS_TEST_TMPDIR/request" <<-END
	{"fabric": {"spacing": 2}, "surface": {"id": "$id", "grow_from": 3, "up_to_deg": 5},
	 "start": {"face": 3, "uv": [1, 20]}, "method": "gib4"}
	END
    sed "s|\"id\": \"$id\"|\"file\": \"$PARTS/rounded.step\"|" "$BATS_TEST_TMPDIR/request" |
        "$DRAPE" --fields nodes.face,nodes.x,nodes.y 2>/dev/null >"$BATS_TEST_TMPDIR/mine"
    call POST '/v1/drapes?fields=nodes.face,nodes.x,nodes.y' -H "$JSON" -H 'Prefer: wait=20' \
        --data-binary @"$BATS_TEST_TMPDIR/request"
    expect 200
    diff <(jq -c .nodes "$BATS_TEST_TMPDIR/mine") <(jq -c .nodes "$body")
    run "$DRAPE" <<<'{"surface": {"file": "'"$PARTS"'/wires.step"}, "fabric": {"spacing": 1}}'
    [ "$status" -eq 1 ]
    [[ $output == *"3 edges and no face"* ]]
    run "$DRAPE" <<<'{"surface": {"file": "part.doc"}, "fabric": {"spacing": 1}}'
    [ "$status" -eq 1 ]
    [[ $output == *"/surface/file: must end in .step"* ]]
}

@test "http: a preview has one primitive a face, cut along its trims" {
    for part in rounded cuts; do
        send model/step "$PARTS/$part.step"
        id=$(field .id)
        area=$(field .area)
        faces=$(field '.faces | length')
        call GET "/v1/surfaces/$id/preview?format=glb"
        expect 200
        [ "$(header Content-Type)" = model/gltf-binary ]
        python3 - "$body" "$faces" "$area" <<'END'
import json, struct, sys

glb = open(sys.argv[1], "rb").read()
magic, version, length, json_length = struct.unpack_from("<4I", glb)
assert (magic, version, length) == (0x46546C67, 2, len(glb))
gltf = json.loads(glb[20 : 20 + json_length])
data = glb[28 + json_length :]
assert gltf["buffers"] == [{"byteLength": len(data)}]
primitives = gltf["meshes"][0]["primitives"]
assert [p["extras"]["face"] for p in primitives] == list(range(int(sys.argv[2])))


def values(accessor, kind):
    a = gltf["accessors"][accessor]
    size = a["count"] * (3 if a["type"] == "VEC3" else 1)
    return struct.unpack_from(f"<{size}{kind}", data, gltf["bufferViews"][a["bufferView"]]["byteOffset"])


total = 0
for p in primitives:
    r, index = values(p["attributes"]["POSITION"], "f"), values(p["indices"], "I")
    points = [r[k : k + 3] for k in range(0, len(r), 3)]
    for k in range(0, len(index), 3):
        a, b, c = (points[i] for i in index[k : k + 3])
        u, v = [y - x for x, y in zip(a, b)], [y - x for x, y in zip(a, c)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        total += sum(x * x for x in n) ** 0.5 / 2
assert abs(total / float(sys.argv[3]) - 1) < 0.01, total
END
    done
    call GET "/v1/surfaces/$id/preview?format=stl"
    expect_problem 406 not-acceptable
    call GET "/v1/surfaces/0123456789abcdef0123456789abcdef/preview"
    expect 404
}
