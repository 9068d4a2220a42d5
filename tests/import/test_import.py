# SPDX-License-Identifier: MIT
"""The importer of CAD files: faces, areas, units, instances, edges, what is wrong with a file. The
files are written by make_parts, which prints the areas that Open CASCADE has for its own shapes."""
import gzip
import json
import math
import os
import re
import resource
import subprocess
import sys
import tempfile

sys.path.append(os.path.join(os.path.dirname(__file__), "..", "faults"))
sys.path.append(os.path.dirname(__file__))
from area import area  # noqa: E402
from daemon import BUILD, LONG, Tap, expect, seed  # noqa: E402

IMPORT = f"{BUILD}/drape-import"
DRAPE = f"{BUILD}/drape"
INCH = 25.4
DRAPES = 200 if LONG else 8
DAMAGED = 1000 if LONG else 16  # files
DAMAGED_SECONDS = 3  # of processor time, for one: some make the reader run on and on


def run(*arguments):
    return subprocess.run([IMPORT, *arguments], capture_output=True, text=True, timeout=300)


class Parts:
    def __init__(self, folder):
        self.folder = folder
        written = subprocess.run([f"{BUILD}/tests/import/make_parts", folder], capture_output=True,
                                 text=True, check=True)
        rows = [line.split() for line in written.stdout.splitlines()]
        self.size = {row[0]: (int(row[1]), float(row[2])) for row in rows if len(row) == 3}

    def path(self, name):
        return os.path.join(self.folder, name + (".igs" if name.endswith("_iges") else ".step"))

    def read(self, name, *arguments):
        done = run(self.path(name), *arguments)
        expect(done.returncode == 0, done.stderr)
        return json.loads(done.stdout)

    def refuse(self, name, words, *arguments):
        done = run(self.path(name), *arguments)
        expect(done.returncode == 1, f"status {done.returncode}")
        expect(words in done.stderr, done.stderr)
        expect(done.stdout == "", "a document of a file that was refused")


def near(got, wanted, share):
    return abs(got - wanted) <= share * abs(wanted)


def test_areas(parts, name, scale):
    """Each face's area from its NURBS and trims is Open CASCADE's, and so is the sum."""
    surface, listed = parts.read(name), parts.read(name, "--list")
    count, whole = parts.size[name]
    expect(len(surface["faces"]) == len(listed["faces"]) == count, len(surface["faces"]))
    for face, row in zip(surface["faces"], listed["faces"]):
        expect(near(area(face), row["area"], 1e-6), f"face {row['index']} {row['kind']}: "
               f"{area(face)!r} and {row['area']!r}")
    expect(near(listed["area"] * scale**2, whole, 1e-6), f"{listed['area']} of {whole}")


def test_unit(parts, name, unit):
    expect(parts.read(name)["length_unit"] == unit, "another unit")
    asked = parts.read(name, "--unit", "ft")
    expect(asked["length_unit"] == unit, "the file's own unit was not kept")
    expect(any("unit=ft was ignored" in note for note in asked["notes"]), asked["notes"])


def test_kinds(parts):
    kinds = [face["kind"] for face in parts.read("rounded", "--list")["faces"]]
    expect({kind: kinds.count(kind) for kind in set(kinds)}
           == {"plane": 6, "cylinder": 12, "sphere": 8}, kinds)


def test_normals(parts):
    """They point out of the body."""
    for row in parts.read("rounded", "--list")["faces"]:
        outward = [a - b for a, b in zip(row["centre"], (30, 20, 15))]
        expect(sum(a * b for a, b in zip(outward, row["normal"])) > 0, row)
        expect(near(sum(a * a for a in row["normal"]), 1, 1e-12), row["normal"])


def test_edges(parts, name, shared, free, faulty):
    edges = parts.read(name, "--list")["edges"]
    expect((edges["shared"], edges["free"], edges["faulty"]) == (shared, free, faulty), edges)


def test_instances(parts):
    """Each in its place, with its part's name and colour."""
    rows = parts.read("assembly", "--list")["faces"]
    expect([row["name"] for row in rows] == ["bracket"] * 12, rows)
    expect([row["colour"] for row in rows] == ["#ff0000"] * 12, rows)
    for first, second in zip(rows[:6], rows[6:]):
        moved = [b - a for a, b in zip(first["centre"], second["centre"])]
        expect(max(abs(a - b) for a, b in zip(moved, (100, 0, 0))) < 1e-9, moved)


def test_selection(parts):
    rows = parts.read("rounded", "--list", "--faces", "25,3,7-9")["faces"]
    expect([row["index"] for row in rows] == [3, 7, 8, 9, 25], rows)
    expect(len(parts.read("rounded", "--faces", "25,3,7-9")["faces"]) == 5, "another number")
    parts.refuse("rounded", "face 26 was asked for, but the file has 26", "--faces", "26")
    for wrong in ("", "1,", "3-1", "-1", "a"):
        done = run(parts.path("rounded"), "--faces", wrong)
        expect(done.returncode == 2, f"{wrong!r}: {done.returncode}")


def test_notes(parts):
    words = {"box": "a solid", "assembly": "2 bodies", "loose": "joined: 2 edges",
             "fin": "3 faces meet at one edge: face 0", "dome": "degree above 9",
             "mixed": "left out: 1 edge that no face has",
             "open": "a trim is open and was closed by a straight line, by up to 10 mm: face 0",
             "crossed": "a trim crosses itself, and the face was cut there: faces 0, 1"}
    for name, word in words.items():
        notes = parts.read(name)["notes"]
        expect(any(word in note for note in notes), f"{name}: {notes}")


def test_exact(parts):
    """Turns that begin beside the seam are carried over in closed form, too, and files that name
    nothing get no names."""
    for name in ("turned", "cuts", "pillar"):
        surface = parts.read(name)
        expect(not any("fitted" in note for note in surface["notes"]), surface["notes"])
        expect(not any("name" in face for face in surface["faces"]), surface["faces"][0].get("name"))


def test_pinched(parts):
    """A trim that nearly touches itself goes round it in the order of the file."""
    surface = parts.read("pinched")
    expect(not any("trim" in note for note in surface["notes"]), surface["notes"])
    points = [curve["control_points"]["points"] for loop in surface["faces"][0]["trims"]
              for curve in loop["data"]]
    for before, after in zip(points, points[1:] + points[:1]):
        expect(max(abs(a - b) for a, b in zip(before[-1], after[0])) < 1e-3, points)


def test_apart(parts):
    """Faces that the file leaves apart stay as they are in it, over a gap as well."""
    alone = [parts.read("wing", "--faces", str(k))["faces"][0] for k in range(3)]
    expect(parts.read("wing")["faces"] == alone, "a face was changed for its neighbours")
    expect(any("over gaps" in note for note in parts.read("wing")["notes"]), "no note")


def test_lost(parts):
    """Faces of which nothing can be made are told by the file's own name for them."""
    with open(parts.path("box"), encoding="ascii") as file:
        text = file.read()
    for name, count in (("one_lost", 1), ("all_lost", -1)):
        with open(parts.path(name), "w", encoding="ascii") as file:
            file.write(text.replace(" PLANE(", " PLAIN(", count))
    surface = parts.read("one_lost")
    expect(len(surface["faces"]) == 5, len(surface["faces"]))
    expect(any("left out: 1 face of the file that cannot be read, the first is #" in note
               for note in surface["notes"]), surface["notes"])
    parts.refuse("all_lost", "none of the file's 6 faces can be read, the first is #")


def test_far(parts):
    """A control point out of all bounds takes its face with it, not the file."""
    with open(parts.path("wing"), encoding="ascii") as file:
        text = file.read()
    pole = re.search(r"B_SPLINE_SURFACE\s*\([^(]*\(\s*\(\s*#\d+,(#\d+)", text)[1]
    with open(parts.path("far"), "w", encoding="ascii") as file:
        file.write(re.sub(rf"({pole} = CARTESIAN_POINT\('',\()[^,]+", r"\g<1>1.E15", text))
    surface = parts.read("far")
    expect(len(surface["faces"]) == 2, len(surface["faces"]))
    expect(any("numbers that are too large or not finite: face 0" in note for note in surface["notes"]),
           surface["notes"])


def test_marked(parts):
    """The mark of UTF-8 before a file is passed over."""
    with open(parts.path("box"), "rb") as file:
        bytes_ = file.read()
    with open(parts.path("marked"), "wb") as file:
        file.write(b"\xef\xbb\xbf" + bytes_)
    expect(len(parts.read("marked")["faces"]) == 6, "other faces")


def test_refusals(parts):
    """What is no CAD file is told by what it is."""
    parts.refuse("wires", "only curves, 3 edges and no face")
    parts.refuse("apart", "an assembly of parts in other files")
    with open(parts.path("box"), "rb") as file:
        step = file.read()
    with open(parts.path("cuts_iges"), "rb") as file:
        iges = file.read()
    kinds = {b"": "it is empty", b"this is a text": "it does not begin with ISO-10303-21",
             gzip.compress(step): "compressed by gzip; decompress it", iges: "it is an IGES file",
             b"PK\3\4" + step: "a zip archive; unpack it", b"<html>": "XML or a web page",
             step.decode("ascii").encode("utf-16"): "UTF-16", b"solid box\n": "an STL mesh"}
    for bytes_, words in kinds.items():
        with open(parts.path("other"), "wb") as file:
            file.write(bytes_)
        parts.refuse("other", words)
    holdings = {b"TRIANGULATED_FACE('',#20,4,(),$,(),())": "or the triangles as STL",
                b"SURFACE_3D_ELEMENT_REPRESENTATION('1',())": "its shell elements as Nastran"}
    for entity, words in holdings.items():
        with open(parts.path("other"), "wb") as file:
            file.write(step[:step.index(b"DATA;")] + b"DATA;\n#1=" + entity +
                       b";\nENDSEC;\nEND-ISO-10303-21;\n")
        parts.refuse("other", words)
    parts.refuse("rounded", "this is not an IGES file: it is a STEP file", "--format", "iges")
    expect(run("--frobnicate").returncode == 2, "an unknown option")


def test_limits(parts):
    """Too little memory or time is an answer."""
    done = run(parts.path("many"), "--memory", "1")
    sanitized = "sanitized" in BUILD
    expect(done.returncode == (0 if sanitized else 1), done.stderr)
    done = run(parts.path("many"), "--memory", "4096", "-o", os.path.join(parts.folder, "many.json"))
    expect(done.returncode == 0, done.stderr)
    expect(json.load(open(os.path.join(parts.folder, "many.json")))["faces"], "no faces")


def test_drape(parts, name, least, choice={}):
    """The net covers the part as far as cloth can, not less, and nothing twice."""
    surface = {"file": parts.path(name)} | choice
    low, high = zip(*[row["bounding_box"] for row in parts.read(name, "--list")["faces"]])
    size = sum((max(b) - min(a))**2 for a, b in zip(zip(*low), zip(*high)))**0.5
    request = {"surface": surface, "fabric": {"spacing": size / 60}}
    done = subprocess.run([DRAPE], input=json.dumps(request), capture_output=True, text=True,
                          timeout=300)
    expect(done.returncode == 0, done.stderr)
    summary = json.loads(done.stdout)["summary"]
    expect(summary["cloth_coverage"] >= least, summary)
    expect(summary["coverage"] <= summary["cloth_coverage"], summary)


def longest_yarn(result, spacing):
    """The longest straight way between neighbours of the net, in spacings."""
    nodes = result["nodes"]
    places = list(zip(nodes["x"], nodes["y"], nodes["z"]))
    at = dict(zip(zip(nodes["i"], nodes["j"]), places))
    beside = [(at[i, j], at.get(other)) for i, j in at for other in ((i + 1, j), (i, j + 1))]
    return max([math.dist(a, b) / spacing for a, b in beside if b], default=0)


def test_unstretched(parts):
    """Cloth does not stretch, wherever it begins and however far it is sheared."""
    chance = seed()
    rows = {name: parts.read(name, "--list")["faces"] for name in ("cover", "rounded", "cup", "neck")}
    drapes = [("cover", 27, 20.573, 65.3, "gib4")]
    for _ in range(DRAPES):
        name = chance.choice(sorted(rows))
        spacing = sum(row["area"] for row in rows[name])**0.5 / chance.uniform(16, 50)
        drapes.append((name, chance.randrange(len(rows[name])), spacing, chance.uniform(0, 90),
                       chance.choice(("gib", "gib4", "geodesic"))))
    for name, face, spacing, angle, method in drapes:
        request = {"surface": {"file": parts.path(name), "grow_from": face, "up_to_deg": 100},
                   "fabric": {"spacing": spacing}, "method": method,
                   "start": {"point": rows[name][face]["centre"]}, "direction": {"angle_deg": angle}}
        done = subprocess.run([DRAPE], input=json.dumps(request), capture_output=True, text=True,
                              timeout=300)
        if done.returncode == 1:
            expect("start-" in done.stderr, done.stderr)
            continue
        expect(done.returncode == 0, done.stderr)
        longest = longest_yarn(json.loads(done.stdout), spacing)
        expect(longest < 1.001, f"{longest} spacings: {name} {face} {spacing} {angle} {method}")


def highest(parts, name):
    rows = parts.read(name, "--list")["faces"]
    return max(rows, key=lambda row: row["centre"][2])["index"]


def damage(bytes_, chance):
    """A file cut short, or with bytes, numbers or lines changed, left out or repeated."""
    kind = chance.randrange(5)
    if kind == 0 or not bytes_:
        return bytes_[: chance.randrange(len(bytes_) + 1)]
    if kind == 1:
        changed = bytearray(bytes_)
        for _ in range(chance.randrange(1, 40)):
            changed[chance.randrange(len(changed))] = chance.randrange(256)
        return bytes(changed)
    lines = bytes_.split(b"\n")
    for _ in range(chance.randrange(1, min(20, len(lines) + 1))):
        at = chance.randrange(len(lines))
        if kind == 2:
            del lines[at]
        elif kind == 3:
            lines[at] = lines[chance.randrange(len(lines))]
        else:
            digits = [k for k, c in enumerate(lines[at]) if chr(c).isdigit()]
            if digits:
                line = bytearray(lines[at])
                line[chance.choice(digits)] = ord(chance.choice("0123456789.E-"))
                lines[at] = bytes(line)
    return b"\n".join(lines)


def own_words(stderr):
    """What the importer says. The child that reads may crash within Open CASCADE (libTK...), of which
    a sanitizer prints its own account first; one of a fault of the importer's is not left out."""
    crash = stderr.partition(b"==ERROR: AddressSanitizer: SEGV")[2]
    if re.search(rb"\n *#0 [^\n]*/libTK\w+\.so", crash):
        return stderr.rstrip().rpartition(b"\n")[2]
    return stderr


def test_damaged(parts):
    """A document or a reason, in bounded time: never a crash that anybody sees."""
    chance = seed()
    names = ["rounded", "dome", "cuts", "assembly", "cuts_iges", "loose"]
    ends = {0: 0, 1: 0}
    for k in range(DAMAGED):
        name = chance.choice(names)
        with open(parts.path(name), "rb") as file:
            bytes_ = damage(file.read(), chance)
        path = parts.path("damaged_iges" if name.endswith("_iges") else "damaged")
        with open(path, "wb") as file:
            file.write(bytes_)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([IMPORT, "--time", str(DAMAGED_SECONDS), path], capture_output=True,
                              timeout=600)
        expect(done.returncode in ends, f"file {k} of {name}: {done.returncode} {done.stderr}")
        ends[done.returncode] += 1
        if done.returncode == 0:
            json.loads(done.stdout)
        else:
            expect(own_words(done.stderr).startswith(b"drape-import: "), done.stderr)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        expect(after.ru_utime - before.ru_utime <= DAMAGED_SECONDS + 2, f"file {k} of {name}")
    print(f"# {ends[0]} imported, {ends[1]} refused, at most "
          f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024} MiB")


def main():
    tap = Tap()
    with tempfile.TemporaryDirectory() as folder:
        parts = Parts(folder)
        scales = {"rounded_inch": INCH, "rounded_iges": INCH, "sphere": 1000}
        for name in ("box", "rounded", "rounded_inch", "rounded_iges", "sphere", "torus", "dome",
                     "wing", "neck", "turned", "pillar", "cover", "cuts", "loose", "assembly",
                     "high", "hat", "bowl"):
            tap.run(f"import: areas of {name}", test_areas, parts, name, scales.get(name, 1))
        for name, unit in (("box", "mm"), ("rounded_inch", "in"), ("rounded_iges", "in"), ("sphere", "m")):
            tap.run(f"import: unit of {name}", test_unit, parts, name, unit)
        tap.run("import: kinds", test_kinds, parts)
        tap.run("import: normals", test_normals, parts)
        for name, *counts in (("box", 12, 0, 0), ("loose", 2, 8, 0), ("fin", 1, 11, 1),
                              ("row_iges", 5, 8, 0)):
            tap.run(f"import: edges of {name}", test_edges, parts, name, *counts)
        tap.run("import: drape of wing", test_drape, parts, "wing", 0.999)
        tap.run("import: drape of cup", test_drape, parts, "cup", 0.96, {"grow_from": 0, "up_to_deg": 25})
        tap.run("import: drape of pillar", test_drape, parts, "pillar", 0.98,
                {"grow_from": highest(parts, "pillar"), "up_to_deg": 20})
        tap.run("import: drape of cover", test_drape, parts, "cover", 0.9999,
                {"grow_from": highest(parts, "cover"), "up_to_deg": 20})
        tap.run("import: cloth that does not stretch", test_unstretched, parts)
        tap.run("import: instances of an assembly", test_instances, parts)
        tap.run("import: chosen faces", test_selection, parts)
        tap.run("import: notes", test_notes, parts)
        tap.run("import: exact turns", test_exact, parts)
        tap.run("import: a trim that nearly touches itself", test_pinched, parts)
        tap.run("import: faces that the file leaves apart", test_apart, parts)
        tap.run("import: faces that cannot be read", test_lost, parts)
        tap.run("import: numbers out of all bounds", test_far, parts)
        tap.run("import: the mark of UTF-8", test_marked, parts)
        tap.run("import: refusals", test_refusals, parts)
        tap.run("import: limits", test_limits, parts)
        tap.run("import: damaged files", test_damaged, parts)
    tap.finish()


if __name__ == "__main__":
    main()
