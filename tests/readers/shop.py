# SPDX-License-Identifier: MIT
"""What the shop floor gets, read by other programs' readers or by the formats' own rules.

shop.py astm FILE              ezdxf opens it without an error; of each piece a line of JSON: name,
                               quantity, area in mm2, notches, the length of its grain line
shop.py bundle FILE            the names of its files, those without the revision, what is left out
shop.py hpgl FILE              as JSON: area in mm2, and the box that the knife keeps to in mm"""
import json
import re
import sys


def shoelace(points):
    return sum(x * v - u * y for (x, y), (u, v) in zip(points, points[1:] + points[:1])) / 2


def distance(at, line):
    """Of a point from a closed line."""
    least = float("inf")
    for (x, y), (u, v) in zip(line, line[1:] + line[:1]):
        dx, dy = u - x, v - y
        share = ((at[0] - x) * dx + (at[1] - y) * dy) / (dx * dx + dy * dy or 1)
        share = min(max(share, 0), 1)
        least = min(least, ((at[0] - x - share * dx) ** 2 + (at[1] - y - share * dy) ** 2) ** 0.5)
    return least


def inside(at, lines):
    count = 0
    for line in lines:
        for (x, y), (u, v) in zip(line, line[1:] + line[:1]):
            if (y <= at[1]) != (v <= at[1]) and x + (at[1] - y) / (v - y) * (u - x) <= at[0]:
                count += 1
    return count % 2 == 1


def read_piece(block, revision):
    def lines(layer):
        found = block.query(f"POLYLINE[layer=='{layer}']")
        assert all(line.is_closed for line in found)
        return [[tuple(v.dxf.location)[:2] for v in line.vertices] for line in found]

    outer, holes = lines("1"), lines("11")
    assert outer and lines("84") == outer and lines("86") == holes
    corners = {tuple(p.dxf.location)[:2] for layer in "23"
               for p in block.query(f"POINT[layer=='{layer}']")}
    assert corners == {at for line in outer + holes for at in line}
    area = sum(shoelace(line) for line in outer)
    assert all(shoelace(line) > 0 for line in outer) and all(shoelace(line) < 0 for line in holes)
    notches = block.query("POINT[layer=='4']")
    for notch in notches:
        at = tuple(notch.dxf.location)
        assert min(distance(at, line) for line in outer + holes) < 1e-3 * area ** 0.5
        assert at[2] == 5  # its depth
    grain, = block.query("LINE[layer=='7']")
    start, end = grain.dxf.start, grain.dxf.end
    assert start.y == end.y and end.x > start.x, "the warp is along x"
    for share in (0, 0.25, 0.5, 0.75, 1):
        assert inside((start.x + share * (end.x - start.x), start.y), outer + holes)
    said = dict(text.dxf.text.split(": ", 1) for text in block.query("TEXT[layer=='1']"))
    assert len(said["Piece Name"]) <= 20 and said["Annotation"].endswith(f"revision {revision}")
    assert any(text.dxf.text == f"revision {revision}" for text in block.query("TEXT[layer=='15']"))
    for drill in block.query("POINT[layer=='13']"):
        assert inside(tuple(drill.dxf.location), outer + holes)
    return {"name": said["Piece Name"], "quantity": said["Quantity"], "notches": len(notches),
            "area": round(area + sum(shoelace(line) for line in holes), 3),
            "material": said.get("Material"), "grain": end.x - start.x}


def read_astm(path):
    import ezdxf

    document = ezdxf.readfile(path)
    assert not document.audit().errors and document.dxfversion == "AC1009"
    model = document.modelspace()
    said = dict(text.dxf.text.split(": ", 1) for text in model.query("TEXT[layer=='1']"))
    assert said["Units"] == "METRIC" and said["ASTM/D13Proposal 1 Version"] == "D6673-10"
    assert 1 <= len(said["Style Name"]) <= 20
    with open(path, encoding="ascii") as file:
        revisions = set(re.findall(r"revision ([0-9a-f]{32})", file.read()))
    assert len(revisions) == 1
    inserts = model.query("INSERT")
    assert len({insert.dxf.name for insert in inserts}) == len(inserts)
    for insert in inserts:
        assert insert.dxf.rotation in (0, 180)
        print(json.dumps(read_piece(document.blocks[insert.dxf.name], *revisions)))


def read_hpgl(path):
    with open(path, encoding="ascii") as file:
        text = file.read()
    revisions = set(re.findall(r"revision ([0-9a-f]{32})", text))
    assert len(revisions) == 1 and text.startswith("IN;")
    area, pen, at, path, box = 0, 0, None, [], []
    labels = re.findall("LB([^\003]*)\003", text)
    for name, arguments in re.findall(r"([A-Z]{2})([-0-9.,]*);", re.sub("LB[^\003]*\003", "", text)):
        numbers = [float(n) for n in arguments.split(",") if n]
        assert name in ("IN", "PA", "SP", "SI", "PU", "PD"), name
        if name in ("PU", "SP") and path:
            assert path[0] == path[-1], "the knife goes all the way round"
            area += shoelace(path[:-1]) / 1600
            path = []
        pen = int(numbers[0]) if name == "SP" else pen
        if name in ("PU", "PD") and numbers:
            at = tuple(numbers)
            if pen == 1:
                path = [at] if name == "PU" else path + [at]
                box.append(at)
    assert pen == 0 and not path
    low, high = [[f(p[k] for p in box) / 40 for k in (0, 1)] for f in (min, max)]
    print(json.dumps({"area": area, "low": low, "high": high, "labels": labels}))


def read_bundle(path):
    """Every file has the size and the digest of the manifest, and bears its revision."""
    import hashlib
    import io
    import zipfile

    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        names = archive.namelist()
        manifest = json.loads(archive.read("manifest.json"))
        assert names == [file["name"] for file in manifest["files"]] + ["manifest.json"]
        without = []
        for file in manifest["files"]:
            content = archive.read(file["name"])
            assert len(content) == file["bytes"] > 0
            assert hashlib.sha256(content).hexdigest() == file["sha256"]
            if file["name"].endswith("lcmsim.zip"):
                content = zipfile.ZipFile(io.BytesIO(content)).read("README.txt")
            if manifest["revision"].encode() not in content:
                without.append(file["name"])
    print(json.dumps({"names": names, "left_out": manifest["left_out"], "without": without,
                      "plies": manifest["plies"], "revision": manifest["revision"]}))


if __name__ == "__main__":
    {"astm": read_astm, "hpgl": read_hpgl, "bundle": read_bundle}[sys.argv[1]](*sys.argv[2:])
