# SPDX-License-Identifier: MIT
"""The scorer of the open benchmark: nets whose scores are known, however they are written; nets that are
none; the cases themselves, whose nets keep their edges and start where the task says; and what is published of the
methods here, which the program must still be worth. Usage: test_score.py BUILD"""
import json
import math
import os
import subprocess
import sys
import tempfile
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "faults"), str(ROOT / "benchmark"), str(ROOT / "tests" / "benchmark")]
from daemon import Tap, expect  # noqa: E402
import run as published  # noqa: E402
import score  # noqa: E402

CASES = ROOT / "benchmark" / "cases"
SCORER = ROOT / "benchmark" / "score.py"


def net_of(case):
    """The rows (i, j, x, y, z, shear) of a case's exact net."""
    lines = (CASES / case / "net.csv").read_text().splitlines()[1:]
    return [(int(r[0]), int(r[1]), *map(float, r[2:])) for r in (line.split(",") for line in lines)]


def scored(case, rows, head="i,j,x,y,z,shear_deg", options=()):
    """Scores of rows as a dictionary, or the refusal as text. Numbers are written with all digits."""
    lines = [head] + [row if isinstance(row, str) else ",".join(map(repr, row)) for row in rows]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "net.csv")
        pathlib.Path(path).write_text("\n".join(lines))
        done = subprocess.run([sys.executable, SCORER, CASES / case, path, "--json", *options],
                              capture_output=True, text=True, timeout=60)
    return json.loads(done.stdout) if done.returncode == 0 else (done.returncode, done.stderr)


def changed(rows, change):
    return [change(*row) for row in rows]


def expect_near(value, wanted, share=1e-6):
    expect(abs(value - wanted) <= share * abs(wanted), f"{value}, not {wanted}")


def expect_exact(result, said):
    """The exact net in another dress: no distance, no error of shear, and these words among the assumed."""
    expect(isinstance(result, dict), result)
    expect(result["distance_max_spacings"] < 1e-9, result)
    expect(result["shear_error_max_deg"] < 1e-6, result)
    expect(result["coverage"] == 1 and result["missing"] == 0, result)
    expect(len(result["assumed"]) == len(said), result["assumed"])
    for words in said:
        expect(any(words in line for line in result["assumed"]), (words, result["assumed"]))


def test_plain():
    expect_exact(scored("rational", net_of("rational")), [])


def test_displaced():
    """Every node 0.25 mm along z: that is each distance, and edges stay."""
    moved = changed(net_of("rational"), lambda i, j, x, y, z, s: (i, j, x, y, z + 0.25, s - 0.5))
    result = scored("rational", moved, options=("--seconds", "1.5"))
    for key in "distance_median", "distance_p95", "distance_max":
        expect_near(result[key], 0.25)
    expect_near(result["distance_max_spacings"], 0.1)
    expect_near(result["shear_error_median_deg"], 0.5)
    expect(result["seconds"] == 1.5, result)


def test_largest():
    """One node of all is 1 mm away: the largest distance, and nothing else."""
    rows = net_of("rational")
    i, j, x, y, z, s = rows[100]
    rows[100] = i, j, x, y, z + 1, s
    result = scored("rational", rows)
    expect_near(result["distance_max"], 1)
    expect(result["distance_p95"] == 0 and result["distance_median"] == 0, result)


def test_edges():
    """Warp edges 1 % too long about the start, on the plane parts of a sheet: told as such."""
    start = json.loads((CASES / "cylinder" / "task.json").read_text())["start"]
    grown = changed(net_of("cylinder"), lambda i, j, *r: (i, j, *(a + 1.01 * (b - a) for a, b in zip(start, r)), r[3]))
    plain, result = scored("cylinder", net_of("cylinder")), scored("cylinder", grown)
    expect(plain["edge_max_percent"] < 0.001 and plain["edge_min_percent"] > -0.02, plain)
    expect(0.97 < result["edge_max_percent"] < 1.03, result)


def test_signs():
    for si, sj, words in ((-1, 1, ["i counts the other way"]), (1, -1, ["j counts the other way"]),
                          (-1, -1, ["i counts the other way", "j counts the other way"])):
        # turning one family round turns the sign of shear
        dress = changed(net_of("rational"), lambda i, j, x, y, z, s: (si * i, sj * j, x, y, z, si * sj * s))
        expect_exact(scored("rational", dress), words)


def test_swapped():
    dress = changed(net_of("rational"), lambda i, j, *rest: (j, i, *rest))
    expect_exact(scored("rational", dress), ["along weft"])
    both = changed(net_of("rational"), lambda i, j, x, y, z, s: (-j, i, x, y, z, -s))
    expect_exact(scored("rational", both), ["along weft", "the other way"])


def test_counting():
    dress = changed(net_of("blade"), lambda i, j, *rest: (i + 1, j + 7, *rest))
    expect_exact(scored("blade", dress), ["(1, 7) is the start"])


def test_units():
    for case, own in (("rational", 1e-3), ("mould", 1.0)):
        for name, unit in (("mm", 1e-3), ("cm", 1e-2), ("m", 1.0), ("in", 0.0254), ("ft", 0.3048)):
            if unit != own:
                dress = changed(net_of(case), lambda i, j, x, y, z, s: (i, j, *(c * own / unit for c in (x, y, z)), s))
                expect_exact(scored(case, dress), [f"lengths are in {name},"])


def test_shear():
    rows = net_of("rational")
    radians = changed(rows, lambda i, j, x, y, z, s: (i, j, x, y, z, math.radians(s)))
    expect_exact(scored("rational", radians, "i,j,x,y,z,shear_rad"), [])
    expect_exact(scored("rational", radians, "i,j,x,y,z,shear"), ["radians"])
    expect_exact(scored("rational", changed(rows, lambda *r: (*r[:5], -r[5]))), ["other sign"])
    expect_exact(scored("rational", changed(rows, lambda *r: (*r[:5], abs(r[5])))), ["no sign"])
    bare = scored("rational", changed(rows, lambda *r: r[:5]), "i,j,x,y,z")
    expect(bare["shear_error_max_deg"] < 0.05 and "has no shear" in bare["assumed"][0], bare)


def test_all_at_once():
    """Swapped, turned, in inches, counted from a corner, blanks between columns in another order."""
    rows = [f"{z / 25.4!r} {-j + 3} {i + 2} {x / 25.4!r} {y / 25.4!r}" for i, j, x, y, z, s in net_of("rational")]
    result = scored("rational", rows, "# a comment\nZ I J X Y")
    expect(result["distance_max_spacings"] < 1e-9 and len(result["assumed"]) == 5, result)


def test_missing():
    rows = net_of("rational")
    half = scored("rational", [r for r in rows if r[0] >= 0])
    expect(half["missing"] == 20 * 41 and half["distance_max"] == 0, half)
    expect_near(half["coverage"], 0.5)
    blank = scored("rational", [r if r[0] >= 0 else f"{r[0]},{r[1]},nan,,," for r in rows])
    expect(blank["missing"] == 20 * 41 and "820 nodes without a place" in blank["assumed"][0], blank)
    hole = scored("rational", [r for r in rows if r[:2] != (3, 4)])
    expect(hole["missing"] == 1, hole)
    expect_near(hole["coverage"], 1 - 4 / 1600)
    more = scored("rational", [*rows, (21, 0, 0.0, 0.0, 0.0, 0.0)])
    expect(more["beyond"] == 1 and more["missing"] == 0 and more["coverage"] == 1, more)


def test_refused():
    rows = net_of("rational")
    task = json.loads((CASES / "rational" / "task.json").read_text())
    for made, head, words in (
            ([], "i,j,x,y,z", "no node"),
            (rows, "a,b,c,d,e,f", "no column i, j, x, y, z"),
            (rows, "i,j,x,y,w,s", "no column z"),
            (["1,2,3,4"], "i,j,x,y,z", "line 2: 4 values for 5 columns"),
            (["0,0,1,2,three"], "i,j,x,y,z", "line 2: z is 'three', not a number"),
            (["0.5,0,1,2,3"], "i,j,x,y,z", "not a whole number"),
            (["inf,0,1,2,3"], "i,j,x,y,z", "not a whole number"),
            ([rows[0], rows[0]], "i,j,x,y,z,shear_deg", "is there twice"),
            ([rows[840]], "i,j,x,y,z,shear_deg", "no two nodes are neighbours"),
            (changed(rows, lambda i, j, x, y, z, s: (i, j, 3 * x, 3 * y, 3 * z, s)), "i,j,x,y,z,shear_deg",
             "is no unit's factor"),
            (changed(rows, lambda i, j, x, y, z, s: (i, j, x + 500, y, z, s)), "i,j,x,y,z,shear_deg",
             "no node lies at the start")):
        result = scored("rational", made, head)
        expect(isinstance(result, tuple) and result[0] == 1 and words in result[1], (words, result))
        expect("Traceback" not in result[1], result)
    expect(task["spacing"] == 2.5, task)


def test_another_net():
    """The same start, another direction: scored, and doubted aloud."""
    start = json.loads((CASES / "saddle" / "task.json").read_text())["start"]
    c = math.sqrt(0.5)
    turned = changed(net_of("saddle"), lambda i, j, x, y, z, s: (
        i, j, start[0] + c * (x - y), start[1] + c * (x + y), z, s))
    result = scored("saddle", turned)
    expect(any("WARNING" in line for line in result["assumed"]), result)


def test_cases():
    """Twelve, of three kinds; each net starts at its task's start, along its warp and weft, with edges no
    longer than the spacing, and is what score.py says of it: itself."""
    folders = sorted(CASES.iterdir())
    tasks = [json.loads((folder / "task.json").read_text()) for folder in folders]
    expect(len(folders) == 12 and {t["geometry"] for t in tasks} == {"surface.json", "surface.step", "surface.stl"}, tasks)
    for folder, task in zip(folders, tasks):
        rows = {r[:2]: r[2:5] for r in net_of(folder.name)}
        expect(len(rows) == task["net"]["nodes"], folder)
        expect(math.dist(rows[0, 0], task["start"]) < 1e-9 * task["spacing"] + task["net"]["error"], folder)
        for key, name in (((1, 0), "warp"), ((0, 1), "weft")):
            if key in rows:  # the second difference over two steps is what the chord bends away
                step = [a - b for a, b in zip(rows[key], rows[0, 0])]
                along = sum(a * b for a, b in zip(step, task[name])) / math.hypot(*step)
                expect(along > math.cos(math.radians(5)), (folder, name, along))
        result = scored(folder.name, net_of(folder.name))
        expect(result["edge_max_percent"] < 1e-4 and result["assumed"] == [], result)


def test_published():
    """The tables of the page are those of results.csv; and nets of both methods on two cases, draped now, score so."""
    known = published.kept()
    expect(published.tables(known) in (ROOT / "benchmark" / "README.md").read_text(), "run tests/benchmark/run.py")
    for case in ("sphere", "freeform"):
        folder = CASES / case
        task = json.loads((folder / "task.json").read_text())
        for method in ("gib", "gib4"):
            text, _ = published.drape(sys.argv[1] + "/drape", published.request(folder, task, method))
            rows = [tuple(map(float, line.split(","))) for line in text.splitlines()[1:]]
            found = scored(case, [(int(r[0]), int(r[1]), *r[2:]) for r in rows])
            for column in ("nodes", "coverage", "distance_max", "shear_error_max_deg"):
                expect_near(found[column], known[case, method][column], 0.01)


def test_command():
    done = subprocess.run([sys.executable, SCORER, CASES, "net.csv"], capture_output=True, text=True)
    expect(done.returncode == 2 and "is no case" in done.stderr, done.stderr)
    done = subprocess.run([sys.executable, SCORER, CASES / "saddle", "nowhere.csv"], capture_output=True, text=True)
    expect(done.returncode == 1 and "cannot be read" in done.stderr, done.stderr)
    done = subprocess.run([sys.executable, SCORER, CASES / "saddle", CASES / "saddle" / "net.csv"],
                          capture_output=True, text=True)
    expect(done.returncode == 0 and "coverage   100.00 %" in done.stdout, done.stdout)


def main():
    tap = Tap()
    for name, function in list(globals().items()):
        if name.startswith("test_"):
            tap.run(f"benchmark {name[5:]}", function)
    tap.finish()


if __name__ == "__main__":
    main()
