# SPDX-License-Identifier: MIT
# The FreeCAD workbench as far as it needs no FreeCAD; `make freecad` tests the rest.

load helper
PYTHON=${PYTHON:-/usr/bin/python3}

setup_file() { start_shared_daemon --workers 2 --max-body 1M; }
teardown_file() { end_file; }

@test "workbench: who drapes, and the net as FreeCAD gets it" {
    $PYTHON tests/clients/workbench.py "$DRAPE" "$URL"
}

@test "workbench: it has the client, and its package has what FreeCAD looks for" {
    cmp clients/freecad/draped.py clients/python/draped.py
    $PYTHON - <<-'END'
	import os
	from xml.etree import ElementTree
	name = "{https://wiki.freecad.org/Package_Metadata}"
	root = ElementTree.parse("clients/freecad/package.xml").getroot()
	bench = root.find(f"{name}content/{name}workbench")
	script = open("clients/freecad/InitGui.py").read()
	assert f"class {bench.find(f'{name}classname').text}(" in script
	assert os.path.exists("clients/freecad/" + root.find(f"{name}icon").text)
	END
}
