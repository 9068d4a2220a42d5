# SPDX-License-Identifier: MIT
# Maps: the fields of a drape at the caller's points and on their mesh.
load helper

NASTRAN='Content-Type: text/x-nastran'

# The saddle with all fields, its map and its id; and the sphere, whose middle is as near to all of
# it, so that a map of points there takes long.
setup_file() {
    start_shared_daemon --max-mesh 9M --max-body 1M
    jq -c '.fabric += {thickness: 0.003, fiber_volume_fraction: 0.4} |
        .permeability = {model: "kozeny_carman", k1: 1.63e-10, k2: 5e-11, k3: 1e-12,
                         at_fiber_volume_fraction: 0.4}' "$EXAMPLES/saddle.json" \
        >"$BATS_FILE_TMPDIR/request.json"
    for name in request sphere; do
        file=$BATS_FILE_TMPDIR/request.json
        [ $name = request ] || file=$EXAMPLES/sphere.json
        curl -sS --max-time 50 -H "$JSON" -H 'Prefer: wait=40' --data-binary "@$file" \
            "$URL/v1/drapes?fields=nodes.i" | jq -r .id >"$BATS_FILE_TMPDIR/$name"
    done
    cat >"$BATS_FILE_TMPDIR/mesh.bdf" <<'END'
$ a unit square over the start
GRID           1             -1.     -1.      0.
GRID           2              1.     -1.      0.
GRID,3,,1.,1.,0.
GRID*                  4                             -1.              1.
*                     0.
CQUAD4        17       1       1       2       3       4
CTRIA3,5,1,1,2,3
ENDDATA
END
    awk 'BEGIN {printf "{\"points\":[[0,0,0]"; for (k = 1; k < 1000000; k++) printf ",[0,0,0]";
                print "]}"}' >"$BATS_FILE_TMPDIR/long.json"
}
teardown_file() { end_file; }
setup() {
    id=$(<"$BATS_FILE_TMPDIR/request")
    sphere=$(<"$BATS_FILE_TMPDIR/sphere")
    mesh=$BATS_FILE_TMPDIR/mesh.bdf
    pids=
}
teardown() {
    for pid in $pids; do
        kill "$pid" 2>/dev/null || true
        wait "$pid" 2>/dev/null || true
    done
    [ -z "${DAEMON:-}" ] || { call GET /healthz && expect 200; }
}

# map BODY [QUERY [CURL OPTION...]]: JSON onto the saddle.
map() {
    local text=$1 query=${2:-}
    shift; [ $# -eq 0 ] || shift
    call POST "/v1/drapes/$id/map$query" -H "$JSON" --data-binary "$text" "$@"
}

# map_bulk QUERY [CURL OPTION...]: the bulk-data file onto the saddle.
map_bulk() {
    local query=$1
    shift
    call POST "/v1/drapes/$id/map$query" -H "$NASTRAN" --data-binary "@$mesh" "$@"
}

# long_map: one that takes minutes, in the background.
long_map() {
    curl -sS --max-time 300 -o /dev/null -H "$JSON" --data-binary "@$BATS_FILE_TMPDIR/long.json" \
        "$URL/v1/drapes/$sphere/map" 2>/dev/null 3>&- &
    pids+=" $!"
}

POINTS='{"points": [[0, 0, 0], [1, 0.5, 0.375], [1, 0.5, 1.375]]}'

@test "map: points get the columns of cells, in their order, with distance and extrapolated" {
    map "$POINTS"
    expect 200
    [ "$(header Content-Type)" = application/json ]
    jq -e --arg id "$id" '.id == $id and .warnings == [] and
        (.cells | all(.[]; length == 3)) and .cells.id == [0, 1, 2] and
        .cells.extrapolated == [false, false, false] and
        .cells.distance[0] < 1e-3 and (.cells.distance[2] | . > 0.6 and . < 0.61) and
        (.cells.shear_deg[1] | . < -15 and . > -20) and
        (.cells.thickness[1] * (.cells.shear_deg[1] * 3.141592653589793 / 180 | cos) / 0.003
         | . > 0.999 and . < 1.001)' "$body"
    jq -r '.cells | keys_unsorted[]' "$body" | grep -vxE 'id|k[xyz][xyz]|distance|extrapolated' \
        >"$BATS_TEST_TMPDIR/mapped"
    call GET "/v1/drapes/$id/result"
    jq -r '.cells | keys_unsorted[]' "$body" | diff - "$BATS_TEST_TMPDIR/mapped"
}

@test "map: the middle of a cell gets the cell's own values" {
    call GET "/v1/drapes/$id/result"
    cp "$body" "$BATS_TEST_TMPDIR/result"
    jq -c '.nodes as $n | .cells as $c |
        ([range($n.i | length)] | map({key: "\($n.i[.]),\($n.j[.])", value: .}) | from_entries)
            as $at |
        {points: [range(0; $c.i | length; 37) | [$c.i[.], $c.j[.]] as [$i, $j] |
            [$at["\($i),\($j)"], $at["\($i + 1),\($j)"], $at["\($i + 1),\($j + 1)"],
             $at["\($i),\($j + 1)"]] as $q |
            [$n.x, $n.y, $n.z] | map(. as $x | [$q[] | $x[.]] | add / 4)]}' "$body" \
        >"$BATS_TEST_TMPDIR/points"
    call POST "/v1/drapes/$id/map" -H "$JSON" --data-binary "@$BATS_TEST_TMPDIR/points"
    expect 200
    jq -e --slurpfile result "$BATS_TEST_TMPDIR/result" '
        .cells as $m | $result[0].cells as $c |
        [range(0; $c.i | length; 37)] as $rows | ($rows | length) > 50 and
        ($c | keys | all(. as $name | ($c[$name] | map(fabs) | max) as $scale |
            [range($rows | length)] |
            all(($m[$name][.] - $c[$name][$rows[.]] | fabs) <= 1e-9 * $scale)))' "$body"
}

@test "map: each format is had by its name and by its media type" {
    while read -r format type; do
        map_bulk "?format=$format"
        expect 200
        [ "$(header Content-Type)" = "$type" ]
        cp "$body" "$BATS_TEST_TMPDIR/by_name"
        map_bulk '' -H "Accept: $type"
        expect 200
        cmp "$body" "$BATS_TEST_TMPDIR/by_name"
    done <<END
json application/json
csv text/csv
vtu application/vnd.vtk
gmsh text/x-gmsh
unv text/x-unv
lcmsim application/zip
lcmsim-h5 application/x-lcmsim
lims text/x-lims
nastran text/x-nastran
optistruct text/x-optistruct
lsdyna text/x-lsdyna
abaqus text/x-abaqus
calculix text/x-calculix
compost application/x-compost+json
END
    map_bulk '?format=glb'
    expect_problem 406 not-acceptable
    [[ $(field .detail) == *'json, csv, vtu, gmsh, unv, lcmsim, lcmsim-h5, lims, nastran, optistruct, radioss, lsdyna, abaqus, calculix, abd, acp, compost' ]]
    map_bulk '' -H 'Accept: image/png'
    expect_problem 406 not-acceptable
    for format in vtu lcmsim nastran calculix abd; do
        map "$POINTS" "?format=$format"
        expect_problem 406 not-acceptable
        [[ $(field .detail) == *'json, csv' ]]
    done
}

@test "map: the ids of bulk data come back, and its inlet goes into the case" {
    map_bulk '?fields=id,cells.k1,distance'
    expect 200
    jq -e '.cells | keys_unsorted == ["id", "k1", "distance"] and .id == [17, 5]' "$body"
    map_bulk '?format=lcmsim&inlet_elements=5'
    expect 200
    [[ $(header Draped-Binning) =~ ^bins=1\;\ direction_deg=[0-9.e-]+\;\ k1=.*\;\ thickness= ]]
    unzip -p "$body" part_description.csv | grep -q '^inlet1,inlet,1,'
    map '{"mesh": {"vertices": [[0,0,0],[1,0,0.5],[0,1,-0.5]], "triangles": [[0,1,2]]},
          "inlet_elements": [0]}' '?format=lcmsim'
    expect 200
    unzip -p "$body" part_description.csv | grep -q '^inlet1,inlet,1,'
    map_bulk '?inlet_elements=6'
    expect_problem 422 invalid-request
    map_bulk '?inlet_elements=5;17'
    expect_problem 422 invalid-request
    map "$POINTS" '?inlet_elements=0'
    expect_problem 422 invalid-request
}

@test "map: precision and fields are those of results, anything else is refused" {
    map "$POINTS" '?precision=3&format=csv&fields=shear_deg'
    expect 200
    [ "$(wc -l <"$body")" -eq 4 ]
    not grep -qE '[0-9]{5}' "$body"
    for query in precision=0 precision=18 fields=nodes.x fields=k9 table=cells colour=red \
        'precision=3&precision=4'; do
        map "$POINTS" "?$query"
        expect_problem 422 invalid-request
    done
}

@test "map: on a mesh there are plies, their angles from a direction of the caller's" {
    map_bulk '?fields=id,plies.element,plies.ply,plies.angle_deg&reference=0,1,0'
    expect 200
    jq -e '.cells.id == [17, 5] and .plies.element == [17, 5] and .plies.ply == [1, 1] and
        (.plies.angle_deg | all(. > -91 and . < -85))' "$body"
    map_bulk '?format=csv&table=plies&precision=6'
    expect 200
    [ "$(head -1 "$body")" = element,ply,angle_deg,shear_deg,thickness,fiber_volume_fraction ]
    [ "$(wc -l <"$body")" -eq 3 ]
    map_bulk '?reference=0,0,1'
    expect_problem 422 invalid-request
    [[ $(field .detail) == 'reference is normal to element 17'* ]]
    for wrong in 1,0 0,0,0 1,0,x 1,0,0,0; do
        map_bulk "?reference=$wrong"
        expect_problem 422 invalid-request
    done
    map '{"mesh": {"vertices": [[0,0,0],[1,0,0],[1,1,0],[0,1,0]], "quads": [[0,1,2,3]],
          "ids": [40]}}' '?fields=plies.element,plies.angle_deg'
    expect 200
    jq -e '.plies.element == [40]' "$body"
}

@test "map: decks say what they need" {
    map_bulk '?format=radioss'
    expect_problem 422 invalid-request
    [[ $(field .detail) == *'reference=x,y,z'* ]]
    map_bulk '?format=radioss&reference=1,0,0'
    expect 200
    [ "$(header Content-Type)" = text/x-radioss ]
    map_bulk '?format=nastran&within=0.5'
    expect 200
    grep -qE '^\$ Rounded: 2 elements share [12] stacks \(within=0.5;' "$body"
    map_bulk '?format=nastran'
    expect 200
    grep -qE '^\$ Rounded: 2 elements share [12] stacks \(within=2;' "$body"
    for wrong in within=-1 within=11 within=a; do
        map_bulk "?format=nastran&$wrong"
        expect_problem 422 invalid-request
    done
}

@test "map: zstd and gzip carry the same document" {
    for format in json csv vtu lcmsim; do
        map_bulk "?format=$format"
        cp "$body" "$BATS_TEST_TMPDIR/plain"
        for coding in zstd gzip; do
            map_bulk "?format=$format" --compressed -H "Accept-Encoding: $coding"
            [ "$(header Content-Encoding)" = "$coding" ]
            cmp "$body" "$BATS_TEST_TMPDIR/plain"
        done
    done
}

@test "map: the command line gives the daemon's bytes" {
    for format in csv vtu lcmsim; do
        map_bulk "?format=$format&inlet_elements=17"
        "$DRAPE" "$BATS_FILE_TMPDIR/request.json" --map "$mesh" --inlet 17 --format $format \
            -o "$BATS_TEST_TMPDIR/own"
        [ $format = lcmsim ] || cmp "$body" "$BATS_TEST_TMPDIR/own"
        # README.txt in the zip names the drape.
        [ $format != lcmsim ] || for file in mesh.bdf part_description.csv simulation_params.csv; do
            cmp <(unzip -p "$body" $file) <(unzip -p "$BATS_TEST_TMPDIR/own" $file)
        done
    done
}

@test "map: a drape in a rigid cavity is pressed like one by a height of the map" {
    local rigid=$BATS_TEST_TMPDIR/rigid.json pressed=$BATS_TEST_TMPDIR/pressed.csv
    jq '.cavity = {height: 0.0035}' "$BATS_FILE_TMPDIR/request.json" >"$rigid"
    map_bulk '?format=csv&cavity_height=0.0035' && expect 200
    cp "$body" "$pressed"
    [ "$(awk -F, 'NR == 1 {for (k = 1; $k != "thickness"; k++); next} {print $k}' "$pressed" |
        sort -u)" = 0.0035 ]
    "$DRAPE" "$rigid" --map "$mesh" --format csv | cmp - "$pressed"
    post /v1/drapes "$rigid" -H 'Prefer: wait=40' && expect 200
    id=$(field .id)
    map_bulk '?format=csv' && expect 200
    cmp "$body" "$pressed"
}

@test "map: a mesh far away is answered, with a warning" {
    map '{"points": [[0, 0, 50], [0, 0, 60], [0, 0, 0]]}'
    expect 200
    [[ $(field '.warnings[0]') == '2 of 3 points are further'* ]]
    jq -e '.cells.distance[1] > 40' "$body"
    map '{"points": [[0, 0, 50], [0, 0, 0]]}'
    jq -e '.warnings == []' "$body"
}

@test "map: what is wrong with a JSON mesh is told with its place" {
    # wrong BODY STATUS SLUG POINTER DETAIL
    wrong() {
        map "$1"
        expect_problem "$2" "$3"
        [ -z "$4" ] || [ "$(field .pointer)" = "$4" ] || { cat "$body"; return 1; }
        [[ $(field .detail) == *"$5"* ]] || { cat "$body"; return 1; }
    }
    wrong '' 400 malformed-json '' empty
    wrong '{"points": [[0, 0, NaN]]}' 400 malformed-json '' 'line 1, column 20'
    wrong '{"points": [[0, 0, 0]' 400 malformed-json '' 'ends early'
    wrong '{"points": []}' 422 invalid-request /points 'empty'
    wrong '{"points": [[0, 0, null]]}' 422 invalid-request /points/0/2 'number'
    wrong '{"points": [[0, 0, 0], [0, 0]]}' 422 invalid-request /points/1 'three numbers'
    wrong '{"mesh": {"vertices": [[0,0,0]], "triangles": []}}' 422 invalid-request \
        /mesh/triangles 'empty'
    wrong '{"mesh": {"vertices": [[0,0,0]], "triangles": [[0,0,1]]}}' 422 invalid-request \
        /mesh/triangles/0/2 'less than 1'
    wrong '{"mesh": {}, "point": 1}' 422 invalid-request /point 'not known'
    wrong '{}' 422 invalid-request '' 'either'
}

@test "map: a file of Gmsh goes through, with its properties and a word on what was passed over" {
    sed 's/^CTRIA3,5,1/CTRIA3,5,9/; s/^ENDDATA/CBAR,30,1,1,2\nSPC1,1,123,1\nENDDATA/' "$mesh" |
        call POST "/v1/drapes/$id/map" -H "$NASTRAN" --data-binary @-
    expect 200
    jq -e '.cells.id == [17, 5] and .cells.pid == [1, 9] and
        .warnings == ["ignored: 1 CBAR, 1 SPC1 (only GRIDs and shell elements are read)"]' "$body"
    call POST "/v1/drapes/$id/map?fields=pid" -H "$NASTRAN" \
        --data-binary @tests/unit/meshes/gmsh_plate.bdf
    expect 200
    jq -e '(.cells.pid | length) == 53 and (.warnings | length) == 2' "$body"
}

@test "map: what is wrong with bulk data is told with its line" {
    # wrong DETAIL: the bulk data is on the standard input.
    wrong() {
        call POST "/v1/drapes/$id/map" -H "$NASTRAN" --data-binary @-
        expect_problem 422 invalid-request
        [[ $(field .detail) == *"$1"* ]] || { cat "$body"; return 1; }
    }
    grep -v '^C' "$mesh" | wrong 'no shell elements'
    sed 's/^CTRIA3,5/CTRIA3,17/' "$mesh" | wrong 'line 8: element 17 is defined twice'
    { cat "$mesh"; echo "INCLUDE 'more.bdf'"; } | sed '/ENDDATA/d' | wrong 'send one file'
    sed 's/^GRID,3,,1./GRID,3,,NaN/' "$mesh" | wrong "line 4: coordinate x of GRID is 'NaN'"
    sed 's/^GRID,3,/GRID,3,9/' "$mesh" | wrong 'line 4: a GRID is in the coordinate system 9, which'
    head -c 400 "$mesh" | head -n 6 | wrong 'no shell elements'
    { echo 'BEGIN BULK'; head -n 7 "$mesh"; } | wrong 'line 8: the file ends without ENDDATA'
    head -c $(($(wc -c <"$mesh") - 11)) "$mesh" | wrong "line 8: a corner of CTRIA3 is ''"
}

@test "map: the shells of decks and meshers get their fields under their own numbers, as by bulk data" {
    printf '%s\n' 'GRID,1,,0.,0.,0.' 'GRID,2,,1.,0.,0.' 'GRID,3,,1.,1.,0.' 'GRID,40,,0.,1.,0.' \
        'GRID,5,,2.,.5,-1.5e-3' 'CQUAD4,901,1,1,2,3,40' 'CTRIA3,17,2,2,5,3' >"$BATS_TEST_TMPDIR/mesh"
    call POST "/v1/drapes/$id/map" -H "$NASTRAN" --data-binary "@$BATS_TEST_TMPDIR/mesh"
    expect 200
    jq -cS '.cells | del(.id)' "$body" >"$BATS_TEST_TMPDIR/wanted"
    for format in abaqus lsdyna gmsh2 gmsh4 universal vtu; do
        case $format in
            gmsh*) type=text/x-gmsh ;;
            universal) type=text/x-unv ;;
            vtu) type=application/vnd.vtk ;;
            *) type=text/x-$format ;;
        esac
        tail -c +2 tests/fuzz/corpus/mesh_files/$format >"$BATS_TEST_TMPDIR/mesh"
        call POST "/v1/drapes/$id/map" -H "Content-Type: $type" --data-binary "@$BATS_TEST_TMPDIR/mesh"
        expect 200
        [ "$(field '.cells.id | sort | join(" ")')" = '17 901' ]
        [ "$(field '.cells.k1 | add * 1e16 | round')" = "$(jq '.k1 | add * 1e16 | round' "$BATS_TEST_TMPDIR/wanted")" ]
    done
    call POST "/v1/drapes/$id/map" -H 'Content-Type: text/x-gmsh' --data 'not a mesh'
    expect_problem 422 invalid-request
}

@test "map: a missing, waiting, cancelled or wrongly typed drape answers like its result" {
    call POST /v1/drapes/none/map -H "$JSON" --data "$POINTS"
    expect_problem 404 not-found
    call POST "/v1/drapes/$id/map" -H 'Content-Type: text/plain' --data "$POINTS"
    expect_problem 415 unsupported-media-type
    [ "$(header Accept)" = 'application/json, text/x-nastran, text/x-abaqus, text/x-lsdyna, text/x-gmsh, text/x-unv, application/vnd.vtk, model/stl, model/obj' ]
    call POST "/v1/drapes/$id/map" -H 'Content-Type:' --data "$POINTS"
    expect 200
    call GET "/v1/drapes/$id/map"
    expect_problem 405 method-not-allowed
    [ "$(header Allow)" = 'POST, OPTIONS' ]
    stop_workers
    quick 1.77 | submit
    call POST "/v1/drapes/$id/map" -H "$JSON" --data "$POINTS"
    kill -CONT $(workers)
    expect_problem 404 result-not-ready
    wait_for "$id" succeeded
    slow 1.77 | submit
    call POST "/v1/drapes/$id/cancel" --data ''
    wait_for "$id" cancelled
    call POST "/v1/drapes/$id/map" -H "$JSON" --data "$POINTS"
    expect_problem 409 cancelled
}

@test "map: lcmsim says what a drape lacks" {
    post '/v1/drapes?fields=nodes.i' "$EXAMPLES/saddle.json" -H 'Prefer: wait=40'
    id=$(field .id)
    map_bulk '?format=lcmsim'
    expect_problem 422 invalid-request
    map_bulk '?format=csv'
    expect 200
    head -1 "$body" | not grep -q k1
    # A cavity thinner than the fabric: cells are flagged and counted, but there is no case.
    jq '.cavity = {height: 0.0011} | .fabric.spacing = 0.2' "$BATS_FILE_TMPDIR/request.json" |
        post /v1/drapes - -H 'Prefer: wait=40'
    expect 200
    jq -e '.summary.packing_exceeded_cells > 0 and
           .summary.packing_exceeded_cells == (.cells.packing_exceeded | add) and
           (.cells.porosity | min) < 0' "$body"
    id=$(field .id)
    map_bulk '?format=json'
    expect 200
    jq -e '.cells.packing_exceeded == [1, 1]' "$body"
    map_bulk '?format=lcmsim'
    expect_problem 422 invalid-request
    [[ $(field .detail) == 'none of the 2 elements can be filled'* ]]
    map_bulk '?format=lcmsim&at_most_fiber_volume_fraction=0.7'
    expect_problem 422 invalid-request # there is none to scale from
}

@test "map: lcmsim has gates, either table, and what is too dense by name" {
    map_bulk '?format=lcmsim&inlet=pid:1&lcmsim_version=2'
    expect 200
    unzip -p "$body" part_description.csv >"$BATS_TEST_TMPDIR/parts"
    awk -F, 'NF != 14 {exit 1}' "$BATS_TEST_TMPDIR/parts"
    grep -q '^inlet1,inlet,1,' "$BATS_TEST_TMPDIR/parts"
    map_bulk '?format=lcmsim&inlet=17&outlet=5'
    expect 200
    unzip -p "$body" part_description.csv | cut -d, -f1-3 | grep -qx 'outlet127,outlet,127'
    map_bulk '?format=lcmsim&inlet=sphere:0:0:0:0.1&edge_channel=30,1e-8'
    expect 200
    unzip -p "$body" part_description.csv | cut -d, -f1-3,7,9 | grep -qx 'patch126,patch,126,1e-08,1.0'
    map_bulk '?inlet=17&edge_channel=30,1e-8'
    jq -e '.cells | .role == [1, 3] and .k1[0] < 1e-8 and .k1[1] == 1e-8 and .kzz[1] == 1e-8' "$body"
    map_bulk '?format=csv&inlet=17&edge_channel=30,1e-8&fields=id,role,k2,kxy'
    grep -qxE '5,3,1e-0?8,0' "$body"
    # A cavity in which the corners of the saddle are too dense, its middle is not.
    jq '.cavity = {height: 0.002} | .fabric.spacing = 0.2' "$BATS_FILE_TMPDIR/request.json" |
        post '/v1/drapes?fields=nodes.i' - -H 'Prefer: wait=40'
    expect 200
    id=$(field .id)
    sed 's/^ENDDATA//' "$mesh" >"$BATS_TEST_TMPDIR/corner.bdf"
    printf 'GRID,11,,1.9,1.9,0.\nGRID,12,,2.,1.9,.195\nGRID,13,,2.,2.,0.\nCTRIA3,30,2,11,12,13\nENDDATA\n' \
        >>"$BATS_TEST_TMPDIR/corner.bdf"
    call POST "/v1/drapes/$id/map?fields=id,fiber_volume_fraction" -H "$NASTRAN" \
        --data-binary "@$BATS_TEST_TMPDIR/corner.bdf"
    jq -e '.cells.fiber_volume_fraction | .[0] < 0.7 and .[2] > 0.9' "$body"
    for query in '' '&at_most_fiber_volume_fraction=0.8'; do
        call POST "/v1/drapes/$id/map?format=lcmsim$query" -H "$NASTRAN" \
            --data-binary "@$BATS_TEST_TMPDIR/corner.bdf"
        expect 200
        unzip -p "$body" dense_elements.csv >"$BATS_TEST_TMPDIR/dense"
        unzip -p "$body" mesh.bdf >"$BATS_TEST_TMPDIR/case.bdf"
        if [ -z "$query" ]; then
            grep -qE '^30,(0\.9|1\.).*,left out$' "$BATS_TEST_TMPDIR/dense"
            [ "$(grep -c ^CTRIA3 "$BATS_TEST_TMPDIR/case.bdf")" = 3 ]
            [[ $(header Draped-Binning) == *'; left_out=1; capped=0' ]]
        else
            grep -q '^30,.*,capped$' "$BATS_TEST_TMPDIR/dense"
            [ "$(grep -c ^CTRIA3 "$BATS_TEST_TMPDIR/case.bdf")" = 4 ]
            [[ $(header Draped-Binning) == *'; left_out=0; capped=1' ]]
        fi
    done
    for query in lcmsim_version=4 at_most_fiber_volume_fraction=1 at_most_fiber_volume_fraction=x \
        inlet=pid:77 'inlet=17&outlet=17'; do
        map_bulk "?format=lcmsim&$query"
        expect_problem 422 invalid-request
    done
}

@test "map: a mesh may be larger than other bodies, but not than --max-mesh" {
    [ "$(stat -c %s "$BATS_FILE_TMPDIR/long.json")" -lt 9000100 ]
    { cat "$mesh"; head -c 2000000 /dev/zero | tr '\0' '$'; } >"$BATS_TEST_TMPDIR/large.bdf"
    call POST "/v1/drapes/$id/map" -H "$NASTRAN" --data-binary "@$BATS_TEST_TMPDIR/large.bdf"
    expect 200
    head -c 9500000 /dev/zero | tr '\0' ' ' >"$BATS_TEST_TMPDIR/too_large"
    call POST "/v1/drapes/$id/map" -H "$JSON" --data-binary "@$BATS_TEST_TMPDIR/too_large"
    expect_problem 413 too-large
    [[ $(field .detail) == *'(--max-mesh)'* ]]
    call POST "/v1/drapes/$id/map" -H "$JSON" -H 'Transfer-Encoding: chunked' \
        --data-binary "@$BATS_TEST_TMPDIR/too_large"
    expect_problem 413 too-large
    call GET /v1/limits
    [ "$(field .max_mesh)" -eq 9437184 ]
    DRAPED_MAX_MESH=2M "$DRAPED" --check-config | grep -qx 'max-mesh = 2097152'
    "$DRAPED" --help | grep -q -- --max-mesh
}

@test "map: long ones hold up nobody, and are given up when their callers go" {
    long_map
    long_map
    long_map
    wait_until 30 checking 1
    for _ in 1 2 3 4 5 6 7 8; do
        call GET "/v1/drapes/$id/result?format=npz" --max-time 10
        expect 200
    done
    for pid in $pids; do
        not gone "$pid" # still being made
        kill "$pid"
    done
    map "$POINTS" '' --max-time 20
    expect 200
}

@test "map: of one caller only so many long ones wait, and short ones pass them" {
    for _ in $(seq 36); do long_map; done
    # The one that takes the last place is given up again; another has to have it.
    refused() {
        call POST "/v1/drapes/$sphere/map" -H "$JSON" --max-time 2 \
            --data-binary "@$BATS_FILE_TMPDIR/long.json" 2>/dev/null && [ "$status" = 429 ] &&
            return
        long_map
        return 1
    }
    wait_until 90 refused
    expect_problem 429 quota-exceeded
    [ "$(header Retry-After)" -ge 1 ]
    map "$POINTS" '' --max-time 10
    expect 200
    for pid in $pids; do kill "$pid" || true; done # some have been refused themselves
}

@test "map: one that takes too long is told so, and one under way does not keep the daemon" {
    start_daemon "$BATS_TEST_TMPDIR/other" --job-timeout 1
    curl -sS --max-time 50 -H "$JSON" -H 'Prefer: wait=40' --data-binary "@$EXAMPLES/sphere.json" \
        -o /dev/null "$URL/v1/drapes?fields=nodes.i"
    call GET /v1/drapes
    sphere=$(field '.drapes[0].id')
    call POST "/v1/drapes/$sphere/map" -H "$JSON" --data-binary "@$BATS_FILE_TMPDIR/long.json"
    expect_problem 500 job-timeout
    stop_daemon
    start_daemon "$BATS_TEST_TMPDIR/other"
    wait_until 10 not checking 1 # one that is just beginning would be taken for the map's
    curl -sS --max-time 50 -o "$BATS_TEST_TMPDIR/cut" -w '%{http_code}' -H "$JSON" \
        --data-binary "@$BATS_FILE_TMPDIR/long.json" "$URL/v1/drapes/$sphere/map" \
        >"$BATS_TEST_TMPDIR/code" 3>&- &
    pids=$!
    wait_until 30 connected 1
    wait_until 30 checking 1
    stop_daemon
    wait "$pids"
    pids=
    [ "$(<"$BATS_TEST_TMPDIR/code")" = 503 ]
    jq -e '.type == "/problems/unavailable"' "$BATS_TEST_TMPDIR/cut"
}

@test "map: plies_as is for decks, which say what they lack" {
    map_bulk '?format=nastran&plies_as=yarns'
    expect 200
    grep -q 'Ply 2: ply_1, weft' "$body"
    map_bulk '?format=nastran&plies_as=bisector'
    expect_problem 422 invalid-request
    [[ $(field .detail) == *'needs fabric.lamina'*'plies_as=yarns needs none' ]]
    map_bulk '?format=vtu&plies_as=yarns'
    expect_problem 422 invalid-request
    [[ $(field .detail) == *'it is for decks, such as calculix'* ]]
    map_bulk '?format=nastran&plies_as=weft'
    expect_problem 422 invalid-request
    map_bulk '?format=abd'
    expect_problem 422 invalid-request
    [[ $(field .detail) == *'fabric.lamina of ply_1' ]]
}
