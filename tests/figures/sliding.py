#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws docs/figures/sliding.svg: the hemisphere laid from its pole with a weave, with a slide of a
half and with parallel fibres, each net seen from above in colours of its shear, fibres drawn
heavier than weft. Usage: sliding.py DRAPE OUT"""
import json

from study import DRAPE, MARGIN, MOST, OUT, PALETTE, colour, run  # the same arguments

SPACING, SCALE, RADIUS = 16, 1.15, 100
FABRICS = (("a weave", "pin_jointed"), ("slide 0.5", {"slide": 0.5}),
           ("parallel fibres", "parallel_fibers"))


def path(places, style):
    return f'<path d="M{"L".join("%.1f %.1f" % place for place in places)}{style}/>'


def net(result, left):
    nodes, cells = result["nodes"], result["cells"]
    middle = left + SCALE * RADIUS, MARGIN + SCALE * RADIUS
    at = {(i, j): (middle[0] + SCALE * x, middle[1] - SCALE * y)
          for i, j, x, y in zip(nodes["i"], nodes["j"], nodes["x"], nodes["y"])}
    filled = {}
    for i, j, shear in zip(cells["i"], cells["j"], cells["shear_deg"]):
        corners = [at[i + a, j + b] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
        filled.setdefault(colour(shear), []).append("L".join("%.1f %.1f" % at for at in corners))
    for fill, places in filled.items():
        yield f'<path d="M{"ZM".join(places)}Z" stroke="none" fill="{fill}"/>'
    for (a, b), width in (((1, 0), 0.9), ((0, 1), 0.35)):
        for i, j in [first for first in at if (first[0] - a, first[1] - b) not in at]:
            yarn = []
            while (i, j) in at:
                yarn.append(at[i, j])
                i, j = i + a, j + b
            if len(yarn) > 1:
                yield path(yarn, f'" stroke-width="{width}"')
    yield (f'<circle cx="{middle[0]:.1f}" cy="{middle[1]:.1f}" r="{SCALE * RADIUS:.1f}" '
           'stroke="#0072B2"/>')


def main():
    drape = json.load(open("api/examples/hemisphere.json"))
    del drape["permeability"]
    step = 2 * SCALE * RADIUS + 2 * MARGIN
    height = 2 * SCALE * RADIUS + 2 * MARGIN + 12
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{3 * step:.0f}" '
             f'height="{height + 26:.0f}" font-family="Helvetica,Arial,sans-serif" font-size="12">',
             '<rect width="100%" height="100%" fill="white"/><g fill="none" stroke="#404040">']
    words = []
    for k, (name, kinematics) in enumerate(FABRICS):
        drape["fabric"] = {"spacing": SPACING, "kinematics": kinematics}
        result = run(drape)
        summary = result["summary"]
        parts += net(result, k * step + MARGIN)
        words.append(f'<text x="{(k + 0.5) * step:.0f}" y="{height}" text-anchor="middle">{name}: '
                     f'mean {summary["mean_shear_deg"]:.1f}°, most {summary["max_shear_deg"]:.0f}°</text>')
        print(f"sliding.svg: {name}: {summary['cloth_coverage']:.4f} covered, largest shear "
              f"{summary['max_shear_deg']:.2f} degrees, mean {summary['mean_shear_deg']:.2f}")
    left = 1.5 * step - 15 * len(PALETTE)
    for k, fill in enumerate(PALETTE):
        words.append(f'<rect x="{left + 30 * k:.0f}" y="{height + 10:.0f}" width="30" height="8" '
                     f'fill="{fill}"/>')
    words.append(f'<text x="{left - 15:.0f}" y="{height + 19:.0f}">0</text><text '
                 f'x="{left + 30 * len(PALETTE) + 8:.0f}" y="{height + 19:.0f}">{MOST}° and more'
                 '</text>')
    with open(OUT, "w") as out:
        out.write("\n".join([*parts, "</g>", *words, "</svg>"]) + "\n")


if __name__ == "__main__":
    main()
