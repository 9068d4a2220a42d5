#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""How good the search `optimise` is: on random free-form surfaces, the examples and CAD parts with fillets,
the best largest shear that it finds with 500 variants, against what others find on the same nets.

  optimise  500 variants, as anybody has it
  long      the best of searches of 1,500, 1,700 and 1,900 variants, each with other starts and angles
  brute     the best of a grid of so many variants (--brute), 46 angles at each of its starts

A CAD part is FILE:FACE, what joins that face smoothly, or FILE:FACE,FACE,.. those faces.

Every figure is written to --keep FILE as it is found, a JSON object a line, and not measured again
when it is there from the same program: so a run can be stopped and taken up. Then it says of each part by how much the
search is above the least of all that is known, and in how many it is within --near degrees."""
import argparse
import glob
import hashlib
import json
import math
import os
import random
import subprocess
import sys

EXAMPLES = ["freeform", "octant", "saddle", "torus", "hemisphere", "tray"]
BUDGET = 500
LONG = [1500, 1700, 1900]


def drape_tool(build, document, fields):
    done = subprocess.run([f"{build}/drape", "-", "--fields", fields], input=json.dumps(document),
                          capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def study(build, drape, search, starts, angles, budget=BUDGET, first_angle=0):
    """The best variant: its largest shear, direction and start; and how many there were."""
    step = 90 / angles
    result = drape_tool(build, {
        "drape": drape, "objectives": ["max_shear_deg"], "search": search,
        **({"budget": budget} if search == "optimise" else {}),
        "limits": {"cloth_coverage": {"min": 0.99}},
        "vary": {"start": {"grid": starts}, "angle_deg": {
            "from": first_angle, "to": first_angle + 90 - step, "step": step}}},
        ",".join("variants." + name for name in ["max_shear_deg", "x", "y", "z", "angle_deg"]))
    best, rows = result["best"]["max_shear_deg"], result["variants"]
    return {"shear": rows["max_shear_deg"][best], "angle": rows["angle_deg"][best],
            "start": [rows[axis][best] for axis in "xyz"],
            "variants": result["summary"]["variants"]}


def measure(build, drape, what, brute):
    if what == "optimise":
        return study(build, drape, "optimise", 1, 46)
    if what == "brute":
        return study(build, drape, "grid", max(brute // 46, 1), 46)
    found = [study(build, drape, "optimise", 1, 46, budget, 11 * k) for k, budget in enumerate(LONG)]
    return min(found, key=lambda one: one["shear"]) | {"variants": sum(x["variants"] for x in found)}


def random_surface(number):
    """A bicubic over [0, 1] x [0, 0.5..1] whose control points are up to 0.05 to 0.2 high."""
    rng, n = random.Random(number), 6
    width, height = rng.uniform(0.5, 1), rng.uniform(0.05, 0.2)
    points = [[i / (n - 1), width * j / (n - 1), height * rng.random()]
              for i in range(n) for j in range(n)]
    return {"degree_u": 3, "degree_v": 3, "size_u": n, "size_v": n,
            "knotvector_u": [0, 0, 0, 0, 0.3, 0.6, 1, 1, 1, 1],
            "knotvector_v": [0, 0, 0, 0, 0.4, 0.7, 1, 1, 1, 1], "control_points": points}


def cad_surface(part):
    path, faces = part.rsplit(":", 1)
    faces = [int(face) for face in faces.split(",")]
    return {"file": os.path.abspath(path),
            **({"faces": faces} if len(faces) > 1 else {"grow_from": faces[0]})}


def top_of(build, path):
    """The highest plane face of a mould; all that joins it smoothly is the tool side."""
    done = subprocess.run([f"{build}/drape-import", "--list", path], capture_output=True, text=True)
    planes = [face for face in json.loads(done.stdout)["faces"] if face["kind"] == "plane"]
    return max(planes, key=lambda face: (round(face["bounding_box"][0][2], 3), face["area"]))["index"]


def request(build, part, nodes):
    """The drape request of a part, with the spacing that gives about as many nodes."""
    if part.startswith("random "):
        drape = {"surface": random_surface(int(part.split()[1])), "fabric": {"spacing": 0.05}}
    elif ":" in part:
        drape = {"surface": cad_surface(part), "fabric": {"spacing": 8}}
    else:
        with open(f"api/examples/{part}.json", encoding="utf-8") as file:
            drape = json.load(file)
    drape = {key: value for key, value in drape.items() if key not in ("permeability", "extent")}
    drape["fabric"] = {"spacing": drape["fabric"]["spacing"]}
    area = drape_tool(build, drape, "nodes.i")["summary"]["part_area"]
    drape["fabric"]["spacing"] = math.sqrt(area / nodes)
    return drape


def digest_of(program):
    with open(program, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()[:16]


def read_kept(path, program):
    kept = {}
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            for line in file:
                one = json.loads(line)
                if one["program"] == program:
                    kept[one["part"], one["nodes"], one["what"]] = one
    return kept


def report(kept, parts, nodes, near):
    above, lower = {}, {}
    for part in parts:
        own = {what: kept[part, nodes, what]["shear"] for what in ("optimise", "long", "brute")
               if (part, nodes, what) in kept}
        print(f"{os.path.basename(part)[:20]:20}", *(f"{what} {shear:8.4f}" for what, shear in own.items()))
        for what in own.keys() - {"optimise"} if "optimise" in own else ():
            above.setdefault(what, []).append(own["optimise"] - own[what])
        if len(own) > 1 and "optimise" in own:
            above.setdefault("least of all", []).append(own["optimise"] - min(own.values()))
        if "long" in own and "brute" in own:
            name = "long" if own["long"] <= own["brute"] else "brute"
            lower[name] = lower.get(name, 0) + 1
    for than, by in sorted(above.items()):
        print(f"within {near} degrees of {than}, or below: {sum(x <= near for x in by)} of {len(by)}; "
              f"above by {max(by):.4f} degrees at the most, "
              f"{sum(max(x, 0) for x in by) / len(by):.4f} on the mean")
    if lower:
        print("the lower of long and brute:", ", ".join(f"{k} on {n}" for k, n in sorted(lower.items())))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--parts", default="0:20", help="numbers of random parts, FIRST:END (0:20)")
    parser.add_argument("--cad", nargs="*", default=[], help="and these CAD parts, FILE:FACES")
    parser.add_argument("--moulds", default="", help="and all of this folder, from the highest plane face")
    parser.add_argument("--near", type=float, default=0.1, help="degrees (0.1)")
    parser.add_argument("--examples", action="store_true", help="and the examples")
    parser.add_argument("--nodes", type=int, default=900, help="of a net (900)")
    parser.add_argument("--measure", default="optimise,long", help="optimise,long,brute")
    parser.add_argument("--brute", type=int, default=100000, help="variants of a grid (100000)")
    parser.add_argument("--keep", default=os.devnull, help="figures known, and to be known")
    given = parser.parse_args()
    first, end = map(int, given.parts.split(":"))
    moulds = sorted(glob.glob(os.path.join(given.moulds, "*.step"))) if given.moulds else []
    parts = ([f"random {k}" for k in range(first, end)] + (EXAMPLES if given.examples else []) +
             given.cad + [f"{path}:{top_of(given.build, path)}" for path in moulds])
    program = digest_of(f"{given.build}/drape")
    kept = read_kept(given.keep, program)
    with open(given.keep, "a", encoding="utf-8") as file:
        for part in parts:
            wanted = [what for what in given.measure.split(",") if (part, given.nodes, what) not in kept]
            drape = request(given.build, part, given.nodes) if wanted else None
            for what in wanted:
                one = {"program": program, "part": part, "nodes": given.nodes, "what": what,
                       **measure(given.build, drape, what, given.brute)}
                kept[part, given.nodes, what] = one
                print(json.dumps(one), file=file, flush=True)
    report(kept, parts, given.nodes, given.near)


main()
