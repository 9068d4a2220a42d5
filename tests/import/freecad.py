# SPDX-License-Identifier: MIT
"""Parts that FreeCAD wrote (freecad_parts.py), as STEP and IGES: every face's area is FreeCAD's own,
edges are joined, and what is smooth from the largest face is draped. `make freecad` runs it."""
import json
import os
import subprocess
import sys
import tempfile

sys.path.append(os.path.join(os.path.dirname(__file__), "..", "faults"))
sys.path.append(os.path.dirname(__file__))
from area import area  # noqa: E402
from daemon import BUILD, Tap, expect  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
FREE = {"lofted_duct": 2, "swept_rail": 12}  # edges that are no others'; solids have none


def run(program, *arguments, text=None):
    done = subprocess.run([f"{BUILD}/{program}", *arguments], input=text, capture_output=True,
                          text=True, timeout=300)
    expect(done.returncode == 0, done.stderr)
    return json.loads(done.stdout)


def test_areas(path, areas):
    surface = run("drape-import", path)
    expect(surface["length_unit"] == "mm", surface["length_unit"])
    expect(len(surface["faces"]) == len(areas), f"{len(surface['faces'])} of {len(areas)} faces")
    for k, (face, wanted) in enumerate(zip(surface["faces"], areas)):
        expect(abs(area(face) - wanted) <= 1e-6 * wanted, f"face {k}: {area(face)}, not {wanted}")


def test_edges(path, name):
    edges = run("drape-import", "--list", path)["edges"]
    expect(edges["faulty"] == 0 and edges["free"] == FREE.get(name, 0), edges)
    expect(edges["largest_gap"] < 1e-5, edges)


def test_drape(path, areas):
    face = areas.index(max(areas))
    request = {"surface": {"file": path, "grow_from": face, "up_to_deg": 20},
               "fabric": {"spacing": sum(areas)**0.5 / 40}}
    summary = run("drape", text=json.dumps(request))["summary"]
    expect(summary["nodes"] > 100, summary)
    least = 0.9 if "box" in path else 0.999  # rounded all over, a box has no cloth that covers it
    expect(summary["cloth_coverage"] >= least, summary)


def main():
    tap = Tap()
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(["freecadcmd", os.path.join(HERE, "freecad_parts.py")],
                              env={**os.environ, "PARTS": folder}, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, timeout=300)
        if not os.path.exists(os.path.join(folder, "parts.json")):
            sys.exit(f"freecadcmd wrote no parts:\n{done.stdout}{done.stderr}")
        for name, areas in json.load(open(os.path.join(folder, "parts.json"))).items():
            for form in ("step", "igs"):
                path = os.path.join(folder, f"{name}.{form}")
                tap.run(f"freecad: areas of {name}.{form}", test_areas, path, areas)
                tap.run(f"freecad: edges of {name}.{form}", test_edges, path, name)
                tap.run(f"freecad: drape of {name}.{form}", test_drape, path, areas)
    tap.finish()


if __name__ == "__main__":
    main()
