# SPDX-License-Identifier: MIT
# The Python client as others have it: installed, in a notebook, and when something goes wrong.

load helper
PYTHON=${PYTHON:-/usr/bin/python3} # Debian's own, which has the modules of its packages

setup_file() { start_shared_daemon --workers 2 --max-body 64K; }
teardown_file() { end_file; }

@test "python: the package installs where nothing else is and drapes there" {
    local folder=$BATS_TEST_TMPDIR
    cp -r clients/python "$folder/source"
    cp $EXAMPLES/saddle.json "$folder"
    $PYTHON -m pip wheel -q --no-build-isolation --no-deps --no-index -w "$folder" "$folder/source"
    $PYTHON -m venv --without-pip "$folder/bare"
    $PYTHON -m pip -q --python "$folder/bare/bin/python3" install --no-index "$folder"/draped-*.whl
    cd "$folder"
    [ "$(bare/bin/python3 -c 'import importlib.metadata as m, draped; print(draped.__version__.replace("-rc", "rc") == m.version("draped"))')" = True ]
    bare/bin/python3 -m draped saddle.json -o net.csv --url "$URL"
    [ "$(wc -l <net.csv)" -gt 1000 ]
    [ "$(bare/bin/python3 -c 'import draped; print(draped.numpy)')" = None ]
}

@test "python: the notebook says what it says" {
    DRAPED_URL=$URL $PYTHON tests/clients/notebook.py clients/python/dome.ipynb
    $PYTHON - <<-'END'
	import json
	book = json.load(open("clients/python/dome.ipynb"))
	assert (book["nbformat"], book["nbformat_minor"]) == (4, 5)
	ids = [cell["id"] for cell in book["cells"]]
	assert len(set(ids)) == len(ids)
	kinds = {"markdown": {"cell_type", "id", "metadata", "source"},
	         "code": {"cell_type", "id", "metadata", "source", "outputs", "execution_count"}}
	assert all(set(cell) == kinds[cell["cell_type"]] for cell in book["cells"])
	assert sum("image/svg+xml" in o.get("data", {}) for c in book["cells"] for o in c.get("outputs", [])) == 2
	END
}

@test "python: a map is a mesh of meshio, with the numbers of the map" {
    $PYTHON - "$URL" <<-'END'
	import json, sys
	sys.path.insert(0, "clients/python")
	import draped, numpy
	client = draped.Client(sys.argv[1])
	drape = client.submit(json.load(open("api/examples/saddle.json")))
	client.wait(drape)
	mesh = client.map_meshio(drape, "api/examples/mould.bdf")
	cells = client.map(drape, "api/examples/mould.bdf")["cells"]
	assert [(block.type, len(block.data)) for block in mesh.cells] == [("quad", 144)], mesh.cells
	assert numpy.abs(cells["shear_deg"]).max() > 20, cells
	assert numpy.array_equal(mesh.cell_data["shear_deg"][0], cells["shear_deg"])
	assert numpy.array_equal(mesh.cell_data["distance"][0], cells["distance"])
	END
}

@test "python: each failure has its type, the place and a remedy, and ends in time" {
    mkdir "$BATS_TEST_TMPDIR/files"
    $PYTHON tests/clients/failures.py "$URL" "$BATS_TEST_TMPDIR/files"
}

@test "python: as a program it says what is wrong where, and writes nothing" {
    local net=$BATS_TEST_TMPDIR/net.csv
    "$DRAPED" hash-token anna read --generate 2>/dev/null >"$BATS_TEST_TMPDIR/tokens"
    start_daemon "$BATS_TEST_TMPDIR/closed" --tokens "$BATS_TEST_TMPDIR/tokens"
    run $PYTHON clients/python/draped.py $EXAMPLES/saddle.json -o "$net" --url "$URL" --token wrong
    stop_daemon
    [ "$status" -eq 1 ]
    [ "$output" = "draped: unauthorized: the token is unknown to this service ($URL). Give the client a token that the service knows." ]
    run $PYTHON clients/python/draped.py $EXAMPLES/saddle.json -o "$net" --url "$URL"
    [ "$status" -eq 1 ]
    [[ $output == "draped: unreachable: the service cannot be reached: "*"Connection refused ($URL). Check the address, and that draped runs there." ]]
    not ls "$net"*
}
