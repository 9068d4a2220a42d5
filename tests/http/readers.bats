# SPDX-License-Identifier: MIT
# Results in the hands of others: programs that read the formats and share no line with this
# project, and the client with its examples.
load helper

PYTHON=${PYTHON:-/usr/bin/python3} # Debian's own, which has the modules of its packages
READ="$PYTHON tests/readers/read.py"
CLIENTS=clients

# Two drapes: the saddle in metres, some of it locked, and the sphere in millimetres.
setup_file() {
    start_shared_daemon
    for name in saddle sphere; do
        curl -sS --max-time 50 -H "$JSON" --data-binary "@$EXAMPLES/$name.json" \
            "$URL/v1/drapes" | jq -r .id >"$BATS_FILE_TMPDIR/$name"
        curl -sS --max-time 50 -o "$BATS_FILE_TMPDIR/status" \
            "$URL/v1/drapes/$(<"$BATS_FILE_TMPDIR/$name")?wait=40"
        fetch "$name" result json
    done
}
teardown_file() { end_file; }

# fetch NAME WHAT FORMAT [QUERY]: to $BATS_FILE_TMPDIR/NAME.FORMAT, which becomes `file`.
fetch() {
    file=$BATS_FILE_TMPDIR/$1.$3
    curl -sS --fail --max-time 50 -o "$file" \
        "$URL/v1/drapes/$(<"$BATS_FILE_TMPDIR/$1")/$2?format=$3${4:-}"
}

# compare NAME KIND [ARGUMENT]: the file with the result as JSON.
compare() { $READ "$2" "$file" "$BATS_FILE_TMPDIR/$1.json" ${3:-}; }

@test "readers: VTK opens vtp and finds every column, vector and cell" {
    for name in saddle sphere; do
        fetch $name result vtp
        compare $name vtp
    done
}

@test "readers: VTK opens vtu and finds every column, vector and tensor" {
    $READ vtu tests/unit/golden/small.vtu
}

@test "readers: NumPy opens npz, and unzip finds its checksums right" {
    for name in saddle sphere; do
        fetch $name result npz
        compare $name npz
        unzip -tqq "$file"
    done
}

@test "readers: Python's csv reads both tables" {
    for table in nodes cells; do
        fetch saddle result csv "&table=$table"
        compare saddle csv
    done
}

@test "readers: the Khronos validator finds no fault in glb, and the numbers are the net's" {
    for name in saddle sphere; do
        fetch $name result glb
        node tests/readers/gltf.mjs "$file"
        compare $name glb
    done
    jq -c '.extent = {warp: [0, 0], weft: [0, 3]}' "$EXAMPLES/saddle.json" |
        "$DRAPE" --format glb -o "$BATS_TEST_TMPDIR/row.glb"
    node tests/readers/gltf.mjs "$BATS_TEST_TMPDIR/row.glb"
}

@test "readers: the svg pattern is drawn, to scale, with the area of the cells" {
    fetch saddle pattern svg
    compare saddle svg 1
    rsvg-convert -w 300 "$file" -o "$BATS_TEST_TMPDIR/saddle.png"
    fetch sphere pattern svg
    compare sphere svg 0.001
}

@test "readers: ezdxf opens the dxf pattern without an error, with the area of the cells" {
    for name in saddle sphere; do
        fetch $name pattern dxf
        compare $name dxf
    done
}

@test "readers: an LCMsim case follows the rules of LCMsim's readers, and meshio opens its mesh" {
    $READ lcmsim tests/unit/golden/lcmsim
    $READ lcmsim tests/unit/golden/lcmsim_inlet
    $READ lcmsim tests/unit/golden/lcmsim_dense
    $READ lcmsim tests/unit/golden/lcmsim_capped
}

# stack UNIT LENGTH: a saddle in that unit with a thickness, and a mesh of all kinds of elements on
# it, with its map as JSON.
stack() {
    folder=$BATS_TEST_TMPDIR/$1
    mkdir "$folder"
    jq -c --arg unit "$1" --argjson l "$2" '.length_unit = $unit | .fabric.spacing *= $l |
        .fabric += {thickness: (0.003 * $l), fiber_volume_fraction: 0.4} |
        .surface.control_points.points |= map(map(. * $l))' "$EXAMPLES/saddle.json" \
        >"$folder/request.json"
    $PYTHON tests/readers/mixed_mesh.py "$2" 10 >"$folder/mesh.json"
    write_map json "$folder/map.json"
}

# write_map FORMAT FILE [FLAG...], without rounding unless FLAG says otherwise
write_map() {
    "$DRAPE" "$folder/request.json" --map "$folder/mesh.json" --format "$1" -o "$2" --within 0 "${@:3}" \
        2>"$BATS_TEST_TMPDIR/warnings"
}

@test "readers: decks hold every ply's fibre within 1e-6 degrees, in m and in mm" {
    for unit in 'm 1' 'mm 1000'; do
        stack $unit
        for format in nastran optistruct lsdyna abaqus calculix; do
            write_map $format "$folder/deck"
            $PYTHON tests/readers/cards.py $format "$folder/mesh.json" "$folder/map.json" "$folder/deck"
        done
        write_map acp "$folder/table.csv"
        $PYTHON tests/readers/cards.py acp "$folder/mesh.json" "$folder/map.json" "$folder/table.csv" - 0 0 yarns
        write_map json "$folder/map.json" --reference 1,0.2,0
        for format in nastran optistruct radioss lsdyna abaqus calculix; do
            write_map $format "$folder/deck" --reference 1,0.2,0
            $PYTHON tests/readers/cards.py $format "$folder/mesh.json" "$folder/map.json" \
                "$folder/deck" 1,0.2,0
            [[ $format =~ optistruct|radioss ]] && continue # one sequence, on one side
            write_map $format "$folder/deck" --reference 1,0.2,0 --plies-as yarns
            $PYTHON tests/readers/cards.py $format "$folder/mesh.json" "$folder/map.json" \
                "$folder/deck" 1,0.2,0 0 0 yarns
        done
    done
}

@test "readers: decks of a laminate hold every ply's fibre, and its layers from each element's bottom" {
    stack m 1
    for side in 1 -1; do
        jq -c --argjson side $side '{surface, length_unit, side: $side, plies: [
            {name: "a", fabric: (.fabric + {thickness: 0.003}), direction: {angle_deg: 0}},
            {name: "b", fabric: (.fabric + {thickness: 0.002}), direction: {angle_deg: 45}},
            {name: "c", repeat: 2, fabric: (.fabric + {thickness: 0.001}), direction: {angle_deg: -30},
             boundary: {polygon: [[-1, -1, 0], [0.2, -1, 0], [0.2, 1, 0], [-1, 1, 0]]}}]}' \
            "$EXAMPLES/saddle.json" >"$folder/request.json"
        write_map json "$folder/map.json"
        for format in nastran lsdyna abaqus calculix; do
            write_map $format "$folder/deck"
            $PYTHON tests/readers/cards.py $format "$folder/mesh.json" "$folder/map.json" \
                "$folder/deck" - $side
        done
    done
    write_map vtu "$folder/map.vtu"
    $READ vtu-plies "$folder/map.vtu" "$folder/map.json"
}

@test "readers: meshes of Gmsh and universal files have every field of elements and plies, under the mesh's numbers" {
    for unit in 'm 1' 'mm 1000'; do
        stack $unit
        jq -c '{surface, length_unit, plies: [0, 45 | . as $a | {direction: {angle_deg: $a}} as $p | $p],
            fabric, permeability: {model: "kozeny_carman", k1: 1.63e-10, k2: 5e-11, k3: 1e-12,
            at_fiber_volume_fraction: 0.4}} | .plies[] += {fabric, permeability} | del(.fabric, .permeability) |
            .plies[1].boundary = {polygon: (.surface.control_points.points | map(.[0]) | max as $r |
                [[-$r, -$r, 0], [0, -$r, 0], [0, $r, 0], [-$r, $r, 0]])}' \
            "$folder/request.json" >"$folder/new.json"
        mv "$folder/new.json" "$folder/request.json"
        inlet=$(jq '.mesh.ids[3]' "$folder/mesh.json")
        write_map json "$folder/map.json" --inlet "$inlet"
        for format in gmsh unv; do
            write_map $format "$folder/mesh.$format" --inlet "$inlet"
            $PYTHON tests/readers/field_mesh.py $format "$folder/mesh.$format" "$folder/mesh.json" "$folder/map.json"
        done
    done
    # meshio, which cannot split fields over kinds of elements, reads a mesh of triangles.
    jq -c '.mesh |= ((.triangles | length) as $n | .ids |= .[:$n] | del(.quads))' "$folder/mesh.json" \
        >"$folder/triangles.json"
    "$DRAPE" "$folder/request.json" --map "$folder/triangles.json" --format json -o "$folder/map.json"
    "$DRAPE" "$folder/request.json" --map "$folder/triangles.json" --format gmsh -o "$folder/mesh.msh"
    $PYTHON - "$folder/mesh.msh" "$folder/map.json" <<'END'
import json, sys, meshio, numpy
mesh = meshio.read(sys.argv[1], "gmsh")
cells = json.load(open(sys.argv[2]))["cells"]
assert numpy.array_equal(mesh.cell_data["k1"][0], cells["k1"])
assert numpy.array_equal(mesh.cell_data["permeability"][0][:, 1], cells["kxy"])
END
}

@test "readers: what goes out as a mesh of Gmsh or a universal file comes in again, sets and all" {
    for kind in gmsh unv; do
        "$DRAPE" "$EXAMPLES/saddle.json" --map tests/unit/meshes/sets.inp --format $kind \
            -o "$BATS_TEST_TMPDIR/mesh.${kind/gmsh/msh}"
        for format in json csv; do
            "$DRAPE" "$EXAMPLES/saddle.json" --map tests/unit/meshes/sets.inp --format $format --inlet set:tip \
                -o "$BATS_TEST_TMPDIR/wanted"
            "$DRAPE" "$EXAMPLES/saddle.json" --map "$BATS_TEST_TMPDIR/mesh.${kind/gmsh/msh}" --format $format \
                --inlet set:TIP -o "$BATS_TEST_TMPDIR/found"
            cmp "$BATS_TEST_TMPDIR/wanted" "$BATS_TEST_TMPDIR/found"
        done
    done
}

@test "readers: meshes that VTK writes, in all its ways, are the mesh; so are the maps that go out" {
    stack m 1
    mkdir "$folder/vtu"
    $PYTHON tests/readers/vtu_mesh.py "$folder/mesh.json" "$folder/vtu"
    write_map csv "$folder/wanted"
    for file in "$folder"/vtu/*.vtu; do
        "$DRAPE" "$folder/request.json" --map "$file" --format csv --fields "$(head -n 1 "$folder/wanted")" \
            -o "$folder/found" 2>"$BATS_TEST_TMPDIR/warnings"
        cmp "$folder/wanted" "$folder/found"
        grep -q '1 cells that are no triangles or quadrilaterals are ignored' "$BATS_TEST_TMPDIR/warnings"
    done
    write_map vtu "$folder/out.vtu"
    "$DRAPE" "$folder/request.json" --map "$folder/out.vtu" --format csv -o "$folder/found"
    cmp "$folder/wanted" "$folder/found"
    # What a program packs otherwise, or cuts off, is refused in words.
    for change in 's/vtkZLibDataCompressor/vtkLZ4DataCompressor/' 's/type="UnstructuredGrid"/type="PolyData"/' \
        's/NumberOfCells="[0-9]*"/NumberOfCells="99"/'; do
        sed "$change" "$folder/vtu/raw-zlib.vtu" >"$folder/wrong.vtu"
        "$DRAPE" "$folder/request.json" --map "$folder/wrong.vtu" -o "$folder/found" 2>&1 | tee -a "$folder/words" || true
    done
    head -c 4000 "$folder/vtu/raw.vtu" >"$folder/wrong.vtu"
    "$DRAPE" "$folder/request.json" --map "$folder/wrong.vtu" -o "$folder/found" 2>&1 | tee -a "$folder/words" || true
    for words in 'packed by vtkLZ4DataCompressor: save it with zlib' 'this VTK file is a PolyData' \
        '99 cells have 15[0-9] offsets' 'the array [A-Za-z]* is damaged or cut short'; do
        grep -q "$words" "$folder/words" || { cat "$folder/words"; return 1; }
    done
}

# Without `within` a deck is for people and solvers to read: few stacks for many elements, and what
# that costs is in its head.
@test "readers: decks round to few stacks by default, and tell by how much" {
    stack m 1
    jq -c '{surface, length_unit, plies: [0, 45, -45, 90 | . as $a | {direction: {angle_deg: $a},
        fabric: {spacing: 0.1, thickness: 0.0005}}]}' "$EXAMPLES/saddle.json" >"$folder/request.json"
    $PYTHON tests/readers/mixed_mesh.py 1 38 >"$folder/mesh.json"
    write_map json "$folder/map.json"
    for format in nastran abaqus; do
        "$DRAPE" "$folder/request.json" --map "$folder/mesh.json" --format $format -o "$folder/deck"
        read -r elements stacks < <(sed -nE 's/.*Rounded: ([0-9]+) elements share ([0-9]+) stacks.*/\1 \2/p' \
            "$folder/deck")
        echo "$format: $elements elements, $stacks stacks"
        [ "$elements" -gt 1000 ] && [ $((3 * stacks)) -lt "$elements" ]
        $PYTHON tests/readers/cards.py $format "$folder/mesh.json" "$folder/map.json" "$folder/deck" - 0 \
            "$(tr -d '\n' <"$folder/deck" | grep -oE '(percent. *.. *Angles|off by at most)[^0-9]*[0-9.]+' |
                grep -oE '[0-9.]+$' | sort -g | tail -1)"
    done
}

@test "readers: vtu has the plies by ply" {
    stack m 1
    write_map vtu "$folder/map.vtu"
    $READ vtu-plies "$folder/map.vtu" "$folder/map.json"
}

@test "readers: h5py finds what LCMsim reads, by name, type and shape, and each cell's own values" {
    stack m 1
    jq -c '.permeability = {model: "kozeny_carman", k1: 1.63e-10, k2: 5e-11, k3: 1e-12,
        at_fiber_volume_fraction: 0.4}' "$folder/request.json" >"$folder/new.json"
    mv "$folder/new.json" "$folder/request.json"
    set -- --edge-channel 1.2,1e-8 --inlet "$(jq '.mesh.ids[3]' "$folder/mesh.json")" \
        --outlet "$(jq '.mesh.ids[9]' "$folder/mesh.json")"
    write_map json "$folder/map.json" "$@"
    [ "$(jq -c '.cells.role | unique' "$folder/map.json")" = '[0,1,2,3]' ]
    write_map lcmsim-h5 "$folder/mesh.h5" "$@"
    $READ lcmsim-h5 "$folder/mesh.h5" "$folder/map.json" "$folder/mesh.json"
    write_map vtu "$folder/map.vtu" "$@"
    jq .cells "$folder/map.json" >"$folder/cells.json"
    $READ vtu "$folder/map.vtu" "$folder/cells.json"
}

@test "readers: a reader by the page of LIMS finds each element's tensor, its gates and its channel" {
    for unit in 'm 1 1' 'mm 1000 0.001'; do
        read -r name length metres <<<"$unit"
        stack $name $length
        jq -c '.permeability = {model: "kozeny_carman", k1: 1.63e-10, k2: 5e-11, k3: 1e-12,
            at_fiber_volume_fraction: 0.4}' "$folder/request.json" >"$folder/new.json"
        mv "$folder/new.json" "$folder/request.json"
        set -- --edge-channel "$((12 * length))e-1,1e-8" --inlet "$(jq '.mesh.ids[3]' "$folder/mesh.json")" \
            --outlet "$(jq '.mesh.ids[9]' "$folder/mesh.json")"
        write_map json "$folder/map.json" "$@"
        for reference in '' 1,0.2,0; do
            write_map lims "$folder/mesh.dmp" "$@" ${reference:+--reference $reference}
            $READ lims "$folder/mesh.dmp" "$folder/map.json" "$folder/mesh.json" $metres $reference
        done
    done
    # Cloth that is too dense in the corners: left out by name, or capped.
    jq -c '.cavity = {height: 3.2} | .fabric.fiber_volume_fraction = 0.85' "$folder/request.json" >"$folder/new.json"
    mv "$folder/new.json" "$folder/request.json"
    write_map json "$folder/map.json"
    write_map lims "$folder/mesh.dmp"
    dense=$(jq '.cells.packing_exceeded | add' "$folder/map.json")
    [ "$dense" -gt 5 ]
    [ "$(grep -c '^# left out: ' "$folder/mesh.dmp")" = "$dense" ]
    $READ lims "$folder/mesh.dmp" "$folder/map.json" "$folder/mesh.json" 0.001
    write_map lims "$folder/mesh.dmp" --at-most-fiber-volume-fraction 0.85
    ! grep -q '^# left out' "$folder/mesh.dmp"
}

@test "readers: CompoST's classes have the fields, and each ply of a stack its own mesh and shear" {
    stack mm 1000
    jq -c '.permeability = {model: "kozeny_carman", k1: 1.63e-10, k2: 5e-11, k3: 1e-12,
        at_fiber_volume_fraction: 0.4}' "$folder/request.json" >"$folder/one.json"
    jq -c '{surface, length_unit, plies: [
        {name: "a \"1\"", fabric, permeability, direction: {angle_deg: 0}},
        {name: "b", fabric, permeability, direction: {angle_deg: 45},
         boundary: {polygon: [[-1000, -1000, 0], [200, -1000, 0], [200, 1000, 0], [-1000, 1000, 0]]}}]}' \
        "$folder/one.json" >"$folder/two.json"
    for request in one two; do
        mv "$folder/$request.json" "$folder/request.json"
        write_map json "$folder/map.json"
        write_map compost "$folder/compost.json"
        $READ compost "$folder/compost.json" "$folder/map.json" "$folder/mesh.json"
    done
}

# Its mesh is a coarser net of another direction, whose nodes the plies do not share.
@test "readers: a STEP part goes from its file through a pressed stack to decks and a filling mesh" {
    folder=$BATS_TEST_TMPDIR
    part='{"file": "'$PWD/$EXAMPLES'/dome.step", "grow_from": 1, "up_to_deg": 20}'
    jq -n --argjson part "$part" \
        '{surface: $part, fabric: {spacing: 12}, direction: {angle_deg: 30}}' |
        "$DRAPE" 2>"$folder/notes" | jq -c '.nodes as $n |
        ([range($n.i | length)] | map({key: "\($n.i[.]),\($n.j[.])", value: .}) | from_entries) as $at |
        {mesh: {vertices: [$n.x, $n.y, $n.z] | transpose, vertex_ids: [range($n.i | length) | . + 11],
                ids: [range(.cells.i | length) | 2 * . + 1],
                quads: ([.cells.i, .cells.j] | transpose | map(. as [$i, $j] |
                    [$at["\($i),\($j)"], $at["\($i + 1),\($j)"],
                     $at["\($i + 1),\($j + 1)"], $at["\($i),\($j + 1)"]]))}}' >"$folder/mesh.json"
    jq -n --argjson part "$part" '{surface: $part, offset: "nominal", cavity: {height: 0.95},
        plies: [0, 45 | {direction: {angle_deg: .}, compaction: {a: 0.2, b: 0.08},
            fabric: {spacing: 5, thickness: 0.5, fiber_volume_fraction: 0.5},
            permeability: {model: "kozeny_carman", k1: 3e-10, k2: 1e-10, k3: 2e-11,
                           at_fiber_volume_fraction: 0.5}}]}' >"$folder/request.json"
    write_map json "$folder/map.json"
    [ "$(jq '.cells.ply_count | length > 100 and all(. == 2)' "$folder/map.json")" = true ]
    [ "$(jq '.cells.thickness | all(. - 0.95 | fabs < 1e-12)' "$folder/map.json")" = true ]
    for format in nastran lsdyna abaqus calculix; do
        write_map $format "$folder/deck"
        $PYTHON tests/readers/cards.py $format "$folder/mesh.json" "$folder/map.json" "$folder/deck" - 1
    done
    set -- --inlet 1 --outlet 201
    write_map json "$folder/map.json" "$@"
    write_map lcmsim-h5 "$folder/mesh.h5" "$@"
    $READ lcmsim-h5 "$folder/mesh.h5" "$folder/map.json" "$folder/mesh.json" 0.001
}

@test "readers: CalculiX runs its deck, with the stresses that the angles give and the volumes" {
    folder=$BATS_TEST_TMPDIR
    jq -c '.surface.control_points.points |= map([.[0], .[1], 0]) | .direction = {angle_deg: 30} |
        .fabric.thickness = 0.003' "$EXAMPLES/saddle.json" >"$folder/request.json"
    $PYTHON tests/readers/mixed_mesh.py 1 6 0 >"$folder/mesh.json"
    write_map json "$folder/map.json"
    write_map calculix "$folder/flat.inp"
    mkdir "$folder/run"
    $PYTHON tests/readers/patch.py "$folder/map.json" "$folder/flat.inp" "$folder/run"
}

@test "readers: CalculiX runs a deck of five plies, each layer with the stress of its own angle" {
    folder=$BATS_TEST_TMPDIR
    jq -c '{surface, length_unit, plies: [[30, 3], [-45, 1], [0, 2], [-45, 1], [30, 3] |
            {direction: {angle_deg: .[0]}, fabric: {spacing: 0.2, thickness: (.[1] / 1000)}}]} |
        .surface.control_points.points |= map([.[0], .[1], 0])' "$EXAMPLES/saddle.json" >"$folder/request.json"
    $PYTHON tests/readers/mixed_mesh.py 1 4 0 >"$folder/mesh.json"
    write_map json "$folder/map.json"
    write_map calculix "$folder/flat.inp"
    mkdir "$folder/run"
    $PYTHON tests/readers/patch.py "$folder/map.json" "$folder/flat.inp" "$folder/run"
}

@test "readers: CalculiX runs decks of one ply and of four on a saddle, layers turned as the map says" {
    folder=$BATS_TEST_TMPDIR
    $PYTHON tests/readers/mixed_mesh.py 1 6 >"$folder/mesh.json"
    for plies in '[[30, 3]]' '[[30, 3], [-45, 1], [0, 2], [70, 1.5]]'; do
        for side in 1 -1; do
            jq -c --argjson plies "$plies" --argjson side $side '{surface, length_unit, side: $side, plies: [
                $plies[] | {direction: {angle_deg: .[0]}, fabric: {spacing: 0.2, thickness: (.[1] / 1000)}}]}' \
                "$EXAMPLES/saddle.json" >"$folder/request.json"
            write_map json "$folder/map.json"
            write_map calculix "$folder/deck.inp"
            rm -rf "$folder/run"
            mkdir "$folder/run"
            $PYTHON tests/readers/curved.py "$folder/mesh.json" "$folder/map.json" "$folder/deck.inp" \
                "$folder/run" $side
        done
    done
}

# sheet UNIT_PLIES: a request of those plies on a flat sheet of 70 x 210 mm.
sheet() {
    jq -n --argjson plies "$1" '{length_unit: "mm", surface: {degree_u: 1, degree_v: 1, size_u: 2, size_v: 2,
        knotvector_u: [0, 0, 1, 1], knotvector_v: [0, 0, 1, 1],
        control_points: {points: [[0, 0, 0], [0, 70, 0], [210, 0, 0], [210, 70, 0]]}}, plies: $plies}' \
        >"$folder/request.json"
}

# ply ANGLE SHEAR THICKNESS LAMINA [FABRIC]
ply() {
    jq -nc --argjson lamina "$4" --argjson more "${5:-{\}}" '{direction: {angle_deg: '"$1"'},
        fabric: ({spacing: 10, thickness: '"$3"', lamina: $lamina} + $more)} |
        if '"$2"' != 0 then .fabric.pre_shear_deg = '"$2"' else . end'
}
CARBON='{"e1": 110e9, "e2": 6e9, "nu12": 0.3, "g12": 2e9}'
GLASS='{"e1": 45e9, "e2": 12e9, "nu12": 0.28, "g12": 5e9}'

@test "readers: a sheet whose yarns are turned to 57 degrees is 5 times as stiff in CalculiX" {
    folder=$BATS_TEST_TMPDIR
    mkdir "$folder/run"
    $PYTHON tests/readers/lamination.py mesh 210 70 10 >"$folder/mesh.json"
    for shear in 0 33; do
        sheet "[$(ply "(-(90 - $shear) / 2)" $shear 0.2 "$CARBON")]"
        for as in warp yarns bisector; do
            write_map calculix "$folder/deck.inp" --plies-as $as
            declare $as$shear="$($PYTHON tests/readers/lamination.py stretch "$folder/deck.inp" "$folder/run")"
        done
    done
    echo "square $warp0 $yarns0 $bisector0 N/mm, sheared $warp33 $yarns33 $bisector33"
    awk "BEGIN { exit !($yarns33 / $yarns0 > 4 && $yarns33 / $yarns0 < 6 && $warp33 < 2 * $warp0 &&
        ($yarns33 / $bisector33 - 1)^2 < 1e-4 && ($yarns0 / $warp0 - 1)^2 < 1e-4 && $warp0 == $bisector0) }"
}

@test "readers: CalculiX has the A, B and D of abd, with yarns, on the bisector and along the warp" {
    folder=$BATS_TEST_TMPDIR
    mkdir "$folder/run"
    $PYTHON tests/readers/lamination.py mesh 210 70 35 turned >"$folder/mesh.json"
    uni=$(ply -20 0 0.035 "$GLASS" '{"kinematics": "parallel_fibers"}')
    for as in yarns warp bisector; do
        balance=$([ $as = bisector ] || echo '{"balance": 0.6}')
        sheet "[$(ply 10 33 0.045 "$CARBON" "${balance:-{\}}"), $(ply 50 -20 0.025 "$GLASS"), $uni]"
        write_map calculix "$folder/deck.inp" --plies-as $as
        write_map abd "$folder/abd" --reference 1,0,0 $([ $as = bisector ] || echo --plies-as $as)
        $PYTHON tests/readers/lamination.py abd "$folder/deck.inp" "$folder/abd" "$folder/run"
    done
}

# A square of triangles over the saddle's middle, as a bulk-data file.
write_mesh() {
    awk 'BEGIN {
        n = 9
        for (j = 0; j < n; j++) for (i = 0; i < n; i++) {
            x = -1 + 0.25 * i; y = -1 + 0.25 * j
            printf "GRID,%d,,%.4f,%.4f,%.5f\n", 1 + i + n * j, x, y, (x * x - y * y) / 2
        }
        for (j = 0; j < n - 1; j++) for (i = 0; i < n - 1; i++) {
            a = 1 + i + n * j
            printf "CTRIA3,%d,1,%d,%d,%d\n", ++e, a, a + 1, a + n + 1
            printf "CTRIA3,%d,1,%d,%d,%d\n", ++e, a, a + n + 1, a + n
        }
        print "ENDDATA"
    }' >"$1"
}

permeable_saddle() {
    jq '.fabric += {thickness: 0.003, fiber_volume_fraction: 0.4} |
        .permeability = {model: "kozeny_carman", k1: 1.63e-10, k2: 5e-11, k3: 1e-12,
                         at_fiber_volume_fraction: 0.4}' "$EXAMPLES/saddle.json"
}

@test "client: submits, waits, and gives the result as arrays, with NumPy and without" {
    cat >"$BATS_TEST_TMPDIR/use.py" <<'END'
import json, sys
if sys.argv[3] == "plain":
    sys.modules["numpy"] = None
sys.path.insert(0, "clients/python")
import draped
client = draped.Client(sys.argv[1])
with open(sys.argv[2], encoding="utf-8") as file:
    drape = client.submit(json.load(file))
seen = []
status = client.wait(drape, progress=seen.append)
assert status["status"] == "succeeded" and seen[-1] == status
result = client.result(drape)
assert isinstance(result["nodes"]["x"], list) == (sys.argv[3] == "plain")
assert len(result["nodes"]["x"]) == result["summary"]["nodes"]
assert len(result["cells"]["i"]) == result["summary"]["cells"]
assert set(result["front"]["reason"]) <= {"boundary"} and result["grid"]["spacing"] == [0.1, 0.1]
some = client.result(drape, ["nodes.x"])
assert list(some["nodes"]) == ["x"] and list(some["nodes"]["x"]) == list(result["nodes"]["x"])
try:
    client.submit({"surface": {}, "fabric": {"spacing": -1}})
    raise AssertionError("accepted")
except draped.DrapedError as error:
    assert error.slug == "invalid-request" and error.status == 422
    assert any(e["pointer"] == "/fabric/spacing" for e in error.errors)
client.delete(drape)
try:
    client.status(drape)
    raise AssertionError("still there")
except draped.DrapedError as error:
    assert error.status == 404
END
    for way in arrays plain; do
        $PYTHON "$BATS_TEST_TMPDIR/use.py" "$URL" "$EXAMPLES/saddle.json" $way
    done
}

@test "client: uploads files, and drapes requests whose surface is one" {
    cp "$EXAMPLES/dome.step" "$BATS_TEST_TMPDIR/part.step"
    printf 'v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n' >"$BATS_TEST_TMPDIR/a.obj"
    $PYTHON - "$URL" "$BATS_TEST_TMPDIR" <<-'END'
	import json, os, sys
	sys.path.insert(0, "clients/python")
	import draped
	client, folder = draped.Client(sys.argv[1]), sys.argv[2]
	part = client.upload(os.path.join(folder, "part.step"))
	assert part["length_unit"] == "mm" and len(part["faces"]) == 9, part
	assert client.surface(part["id"])["faces"][6]["kind"] == "sphere"
	request = {"surface": {"id": part["id"], "grow_from": 6}, "fabric": {"spacing": 4}}
	file = {**request, "surface": {"file": "part.step", "grow_from": 6}}
	one, other = client.submit(request), client.submit(file, folder)
	assert client.wait(one)["summary"]["nodes"] == client.wait(other)["summary"]["nodes"] > 3000
	study = client.study({"drape": {"surface": {"file": os.path.join(folder, "a.obj"), "unit": "in"},
	                                "fabric": {"spacing": 0.2}}, "vary": {"angle_deg": [0, 45]}, "objectives": ["max_shear_deg"]})
	assert client.variant(study["id"], 0)["length_unit"] == "in"
	stored = client.upload({"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 2]]})
	client.delete_surface(stored["id"])
	for path, kind in (("a.off", ValueError), ("b.step", OSError)):
	    try:
	        client.upload(os.path.join(folder, path))
	        sys.exit("no error")
	    except kind:
	        pass
	json.dump(file, open(os.path.join(folder, "request.json"), "w"))
	END
    $PYTHON $CLIENTS/python/draped.py "$BATS_TEST_TMPDIR/request.json" -o "$BATS_TEST_TMPDIR/net.csv" \
        --url "$URL"
    [ "$(wc -l <"$BATS_TEST_TMPDIR/net.csv")" -gt 3000 ]
}

@test "client: does a study, and drapes the best of its variants" {
    cat >"$BATS_TEST_TMPDIR/study.py" <<'END'
import json, sys
sys.path.insert(0, "clients/python")
import draped
client = draped.Client(sys.argv[1])
with open(sys.argv[2], encoding="utf-8") as file:
    drape = json.load(file)
drape["fabric"]["spacing"] = 0.4
request = {"drape": drape, "vary": {"start": {"grid": 4}, "angle_deg": [0, 30]},
           "objectives": ["max_shear_deg"]}
seen = []
study = client.study(request, progress=seen.append)
assert seen[-1]["status"] == "succeeded" and seen[-1]["variants"] == {"done": 8, "total": 8}
best = study["best"]["max_shear_deg"]
shear = study["variants"]["max_shear_deg"]
assert len(shear) == 8 and shear[best] == min(shear)
again = client.submit(client.variant(study["id"], best))
assert client.wait(again)["summary"]["max_shear_deg"] == shear[best]
assert client.sample(study["id"], best)["summary"]["max_shear_deg"] == shear[best]
places = {"points": [[0.1, 0.2, 0], [-1, 1, 0]]}
assert client.map_sample(study["id"], best, places)["cells"].keys() == client.map(again, places)["cells"].keys()
assert client.cancel_study(study["id"])["status"] == "succeeded"
client.delete_study(study["id"])
try:
    client.variant(study["id"], best)
    raise AssertionError("still there")
except draped.DrapedError as error:
    assert error.status == 404
END
    $PYTHON "$BATS_TEST_TMPDIR/study.py" "$URL" "$EXAMPLES/saddle.json"
}

@test "client: drapes a laminate, maps the stack and saves what it is made by" {
    cat >"$BATS_TEST_TMPDIR/laminate.py" <<'END'
import json, os, sys, zipfile
import ezdxf
sys.path.insert(0, "clients/python")
import draped
client, folder = draped.Client(sys.argv[1]), sys.argv[3]
with open(sys.argv[2], encoding="utf-8") as file:
    surface = json.load(file)["surface"]
fabric = {"spacing": 0.2, "thickness": 0.001, "fiber_volume_fraction": 0.5}
stack = client.submit_laminate({"surface": surface, "plies": [
    {"fabric": fabric, "direction": {"angle_deg": angle}} for angle in (0, 45, 0)]})
while client.laminate(stack, wait=10)["status"] in ("queued", "running"):
    pass
plies = client.laminate(stack)["plies"]
assert [ply["status"] for ply in plies] == 3 * ["succeeded"]
assert plies[0]["id"] == plies[2]["id"] != plies[1]["id"]
mesh = {"mesh": {"vertices": [[0, 0, 0], [1, 0, 0.5], [0, 1, -0.5]], "triangles": [[0, 1, 2]]}}
answer = client.map_laminate(stack, mesh, cavity_height=0.0027)
assert abs(answer["cells"]["thickness"][0] - 0.0027) < 1e-15
assert [int(ply) for ply in answer["plies"]["ply"]] == [1, 2, 3]
assert abs(sum(answer["plies"]["thickness"]) - 0.0027) < 1e-15
for name in ("stack.svg", "stack.dxf", "stack.html"):
    client.save_patterns(stack, os.path.join(folder, name))
client.save_laser(stack, os.path.join(folder, "laser.json"))
with open(os.path.join(folder, "laser.json"), encoding="ascii") as file:
    assert [layer["ply"] for layer in json.load(file)["layers"]] == [1, 2, 3]
client.save_bundle(stack, os.path.join(folder, "stack.zip"), width=9)
with zipfile.ZipFile(os.path.join(folder, "stack.zip")) as bundle:
    assert b" x 9 m of roll" in bundle.read("patterns/rolls.svg")
client.save_laminate_map(stack, mesh, os.path.join(folder, "deck.inp"), format="calculix")
with open(os.path.join(folder, "deck.inp"), encoding="ascii") as file:
    assert "*SHELL SECTION, COMPOSITE" in file.read()
with open(os.path.join(folder, "stack.html"), encoding="utf-8") as file:
    assert "Ply book" in file.read()

nested = ezdxf.readfile(os.path.join(folder, "stack.dxf"))
assert not nested.audit().errors and nested.header["$INSUNITS"] == 6
cuts = nested.modelspace().query("POLYLINE[layer=='CUT']")
assert len(cuts) == 3 and all(line.is_closed for line in cuts)
assert {entity.dxf.layer for entity in nested.modelspace()} == {"CUT", "NAME"}
corners = [v.dxf.location for line in cuts for v in line.vertices]
low, high = nested.header["$EXTMIN"], nested.header["$EXTMAX"]
assert all(low[k] <= at[k] <= high[k] + 1e-9 for at in corners for k in (0, 1))

own = {"name": "own", "fabric": {"thickness": 0.002, "fiber_volume_fraction": 0.5}}
assert client.keep_material(own)["fabric"] == own["fabric"] == client.material("own")["fabric"]
assert [m["name"] for m in client.materials() if m["own"]] == ["own"]
drape = client.submit({"surface": surface, "fabric": {"spacing": 0.2, "material": "own"}})
client.delete_material("own")
client.wait(drape)
assert min(client.result(drape)["cells"]["thickness"]) >= 0.002
assert not any(m["own"] for m in client.materials())
END
    $PYTHON "$BATS_TEST_TMPDIR/laminate.py" "$URL" "$EXAMPLES/saddle.json" "$BATS_TEST_TMPDIR"
}

@test "client: as a program it saves any format by the file's name" {
    for ending in json csv vtp glb npz svg dxf; do
        $PYTHON $CLIENTS/python/draped.py "$EXAMPLES/saddle.json" --url "$URL" \
            -o "$BATS_TEST_TMPDIR/net.$ending"
        [ -s "$BATS_TEST_TMPDIR/net.$ending" ]
    done
    $READ vtp "$BATS_TEST_TMPDIR/net.vtp" "$BATS_TEST_TMPDIR/net.json"
    run $PYTHON $CLIENTS/python/draped.py "$EXAMPLES/saddle.json" --url "$URL" -o net.doc
    [ "$status" -eq 1 ]
    [[ $output == *"'doc' is no format"* ]]
}

@test "client: shows a bar on a terminal alone" {
    script -qec "$PYTHON $CLIENTS/python/draped.py $EXAMPLES/saddle.json --url $URL \
        -o $BATS_TEST_TMPDIR/net.json" /dev/null >"$BATS_TEST_TMPDIR/shown"
    grep -q '\[##*\] 100 % succeeded' "$BATS_TEST_TMPDIR/shown"
    $PYTHON $CLIENTS/python/draped.py "$EXAMPLES/saddle.json" --url "$URL" \
        -o "$BATS_TEST_TMPDIR/net.json" 2>"$BATS_TEST_TMPDIR/silent"
    [ ! -s "$BATS_TEST_TMPDIR/silent" ]
}

@test "examples: pipeline.sh goes the whole way with curl and jq" {
    run env DRAPED_URL="$URL" $CLIENTS/examples/pipeline.sh "$EXAMPLES/saddle.json" \
        "$BATS_TEST_TMPDIR/out"
    [ "$status" -eq 0 ]
    [[ ${lines[0]} == "complete: "*" nodes, shear up to "*" deg, "* ]]
    [ "${#lines[@]}" -eq 11 ]
    for file in net.vtp net.glb cells.csv pattern.svg; do
        [ -s "$BATS_TEST_TMPDIR/out/$file" ]
    done
    echo '{"fabric": {}}' >"$BATS_TEST_TMPDIR/bad.json"
    run env DRAPED_URL="$URL" $CLIENTS/examples/pipeline.sh "$BATS_TEST_TMPDIR/bad.json" \
        "$BATS_TEST_TMPDIR/out"
    [ "$status" -ne 0 ]
    [[ $output == */fabric/spacing* ]]
}

@test "examples: lcmsim_case.py goes from request and mesh to a case" {
    permeable_saddle >"$BATS_TEST_TMPDIR/request.json"
    write_mesh "$BATS_TEST_TMPDIR/mould.bdf"
    DRAPED_URL=$URL $PYTHON $CLIENTS/examples/lcmsim_case.py "$BATS_TEST_TMPDIR/request.json" \
        "$BATS_TEST_TMPDIR/mould.bdf" "$BATS_TEST_TMPDIR/case" --inlet 1,17 \
        >"$BATS_TEST_TMPDIR/said"
    grep -qE 'case: shear up to [0-9.]+ deg; bins=[0-9]+; direction_deg=' "$BATS_TEST_TMPDIR/said"
    $READ lcmsim "$BATS_TEST_TMPDIR/case"
    grep -q '^inlet1,inlet,1,' "$BATS_TEST_TMPDIR/case/part_description.csv"
}

@test "client: maps a mesh file, and VTK opens the fields on it" {
    permeable_saddle >"$BATS_TEST_TMPDIR/request.json"
    write_mesh "$BATS_TEST_TMPDIR/mould.bdf"
    cat >"$BATS_TEST_TMPDIR/map.py" <<'END'
import json, os, sys
sys.path.insert(0, "clients/python")
import draped
client, folder = draped.Client(sys.argv[1]), sys.argv[2]
with open(os.path.join(folder, "request.json"), encoding="utf-8") as file:
    drape = client.submit(json.load(file))
client.wait(drape)
mesh = os.path.join(folder, "mould.bdf")
client.save_map(drape, mesh, os.path.join(folder, "mapped.vtu"))
case = os.path.join(folder, "case.zip")
assert client.save_map(drape, mesh, case, format="lcmsim", inlet_elements=[5]).startswith("bins=")
fields = client.map(drape, mesh)
cells = fields["cells"]
assert fields["id"] and fields["warnings"] == [] and list(cells["id"]) == list(range(1, 129))
assert len(cells["k1"]) == 128 and max(cells["distance"]) < 0.05
with open(os.path.join(folder, "mapped.json"), "w", encoding="utf-8") as file:
    json.dump({name: [float(v) for v in values] for name, values in cells.items()}, file)
square = {"mesh": {"vertices": [[0, 0, 0], [1, 0, 0.5], [0, 1, -0.5]], "triangles": [[0, 1, 2]]}}
some = client.map(drape, square, fields="k1,distance", inlet_elements=[0])
assert list(some["cells"]) == ["k1", "distance"] and len(some["cells"]["k1"]) == 1
far = client.map(drape, {"points": [[0, 0, 100]]})
assert "1 of 1 points" in far["warnings"][0]
try:
    client.map(drape, {"points": [[0, 0]]})
    raise AssertionError("accepted")
except draped.DrapedError as error:
    assert error.slug == "invalid-request" and error.pointer == "/points/0"
END
    $PYTHON "$BATS_TEST_TMPDIR/map.py" "$URL" "$BATS_TEST_TMPDIR"
    $READ vtu "$BATS_TEST_TMPDIR/mapped.vtu" "$BATS_TEST_TMPDIR/mapped.json"
    unzip -tqq "$BATS_TEST_TMPDIR/case.zip"
}

@test "readers: VTK finds the permeability of a drape as a tensor" {
    permeable_saddle >"$BATS_TEST_TMPDIR/request.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/request.json" -o "$BATS_TEST_TMPDIR/net.json"
    "$DRAPE" "$BATS_TEST_TMPDIR/request.json" --format vtp -o "$BATS_TEST_TMPDIR/net.vtp"
    $READ vtp "$BATS_TEST_TMPDIR/net.vtp" "$BATS_TEST_TMPDIR/net.json"
}
