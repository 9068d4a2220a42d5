#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws docs/figures/best_start.svg: the free-form example laid from its own start and from the best
that a study finds, each net seen from above in colours of its shear. Usage: study.py DRAPE OUT"""
import json
import subprocess
import sys

DRAPE, OUT = sys.argv[1:]
SPACING, SCALE, MARGIN, MOST = 10, 0.8, 12, 50
# Crameri's lajolla, reversed: even to the eye, safe for the colour-blind.
PALETTE = ["#FFFECB", "#F9E591", "#EFBB60", "#E58F54", "#D5654F", "#A34545", "#6B3736", "#3B2A24"]


def run(document, *options):
    done = subprocess.run([DRAPE, "-", *options], input=json.dumps(document), capture_output=True,
                          text=True, check=True)
    return json.loads(done.stdout)


def colour(shear):
    return PALETTE[min(int(abs(shear) / MOST * len(PALETTE)), len(PALETTE) - 1)]


def net(result, left):
    nodes, cells = result["nodes"], result["cells"]
    at = {(i, j): (left + SCALE * x, MARGIN + SCALE * (305 - y))
          for i, j, x, y in zip(nodes["i"], nodes["j"], nodes["x"], nodes["y"])}
    for i, j, shear in zip(cells["i"], cells["j"], cells["shear_deg"]):
        corners = [at[i + a, j + b] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
        yield (f'<path d="M{"L".join(f"{x:.1f} {y:.1f}" for x, y in corners)}Z" '
               f'fill="{colour(shear)}"/>')
    x, y = at[0, 0]
    yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="none" stroke="#0072B2" stroke-width="2"/>'


def main():
    drape = json.load(open("api/examples/freeform.json"))
    drape["fabric"]["spacing"] = SPACING
    study = {"drape": drape, "objectives": ["max_shear_deg"], "search": "optimise", "budget": 500,
             "limits": {"cloth_coverage": {"min": 0.999}},
             "vary": {"start": {"grid": 40}, "angle_deg": {"from": 0, "to": 80, "step": 10}}}
    best = run(run(study, "--variant", "best"))
    width, height = 720, 305
    step = SCALE * 390 + 3 * MARGIN
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height + 30}" '
             'font-family="Helvetica,Arial,sans-serif" font-size="14">',
             '<rect width="100%" height="100%" fill="white"/><g stroke="#808080" stroke-width="0.3">']
    words = []
    for k, (name, result) in enumerate((("its own start", run(drape)), ("the best start", best))):
        shear = result["summary"]["max_shear_deg"]
        parts += net(result, 2 * MARGIN + k * step)
        words.append(f'<text x="{2 * MARGIN + k * step + 100:.0f}" y="{height}">{name}: at most '
                     f'{shear:.1f}°</text>')
        print(f"best_start.svg: {name}: largest shear {shear:.2f} degrees, 95 % below "
              f"{result['summary']['p95_shear_deg']:.2f}")
    for k, fill in enumerate(PALETTE):
        words.append(f'<rect x="{220 + 30 * k}" y="{height + 10}" width="30" height="8" '
                     f'fill="{fill}"/>')
    words.append(f'<text x="205" y="{height + 18}">0</text>'
                 f'<text x="{225 + 30 * len(PALETTE)}" y="{height + 18}">{MOST}° shear</text>')
    open(OUT, "w").write("\n".join(parts + ["</g>"] + words + ["</svg>\n"]))


if __name__ == "__main__":
    main()
