# SPDX-License-Identifier: MIT
"""What of the FreeCAD workbench needs no FreeCAD: who drapes, and the net as it is shown. By the command, the first
argument, and a daemon at the second."""
import os
import sys
import tempfile

import numpy as np

sys.path[:0] = ["clients/freecad", "tests/faults"]
from daemon import Tap, expect  # noqa: E402
from draped_workbench import net as nets  # noqa: E402
from draped_workbench import service as services  # noqa: E402

PROGRAM, URL = sys.argv[1:]
DOME = "api/examples/dome.step"
FACES = {"faces": [0, 1, 6]}  # flange, fillet, dome


def drape(spacing=5.0, address="", chosen=None, limit=60, part=DOME, **request):
    service = services.service(address, PROGRAM, limit=limit)
    return service.drape({"fabric": {"spacing": spacing}, **request}, part, chosen or FACES)


def test_same_by_both():
    (one, drawn), (other, other_drawn) = drape(), drape(address=URL)
    for column in ("x", "y", "z", "i", "j"):
        expect(list(one["nodes"][column]) == list(other["nodes"][column]), column)
    cut, other_cut = (list(nets.Net(*each).pattern("cut"))[0][0] for each in ((one, drawn), (other, other_drawn)))
    expect(np.array_equal(cut, other_cut), "cut")


def test_net():
    net = nets.Net(*drape())
    yarns = list(net.yarns())
    edges = sum(len(points) - 1 for _, points in yarns)
    expect(edges >= 2 * len(net.corners), f"{edges} edges of {len(net.corners)} cells")
    lengths = np.concatenate([np.linalg.norm(np.diff(points, axis=0), axis=1) for _, points in yarns])
    expect(4.7 < lengths.min() and lengths.max() < 5 + 1e-9, f"chords {lengths.min()} to {lengths.max()}")
    expect(len(list(net.yarns(1000))) == 2, "the two through the start")
    area = 0.0
    for points, closed in net.pattern("cut"):
        expect(closed, "an open cut")
        x, y = points.T
        area += (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
    expect(abs(area / net.summary["flat_area"] - 1) < 1e-6, f"{area}, not {net.summary['flat_area']}")
    expect(len(list(net.pattern("notches"))) >= 4 and not any(closed for _, closed in net.pattern("notches")), "notches")
    colours = net.colours(45)
    flat, worst = np.argmin(np.abs(net.shear)), np.argmax(net.shear)
    expect(colours[flat].min() > 0.95 and colours[worst].tolist() == [1, 0, 0], colours[[flat, worst]])
    expect(np.array_equal(net.triangles().reshape(-1, 6)[:, [0, 1, 2, 5]], net.corners), "triangles")


def test_locate():
    net = nets.Net(*drape())
    places = net.locate(net.points)
    expect(np.abs(places.flat - net.flat).max() < 1e-9 and places.distance.max() < 1e-9, "nodes")
    lifted = net.locate([[0, 0, 67.0]])
    expect(np.abs(lifted.flat).max() < 1e-6 and abs(lifted.distance[0] - 7) < 1e-6, lifted)
    far = net.locate([[1000.0, 0, 0]])
    expect(far.beyond[0] > 10, far)


def test_locate_order():
    """On the dome of radius 60 the yarn through the pole is a meridian: at the angle t its place is 60 t, and a point of
    it between nodes is placed with an error that falls with the square of the spacing."""
    errors = []
    for spacing in (8.0, 4.0, 2.0):
        net = nets.Net(*drape(spacing, chosen={"faces": [6]}, start={"point": [0, 0, 60]}))
        t = np.linspace(0.05, 1.1, 40)
        on = np.column_stack([60 * np.sin(t), 0 * t, 60 * np.cos(t)])
        errors.append(np.abs(net.locate(on).flat - np.column_stack([60 * t, 0 * t])).max())
    rates = [np.log2(a / b) for a, b in zip(errors, errors[1:])]
    expect(errors[0] < 0.05 and min(rates) > 1.8, f"{errors} {rates}")


def failure(reason, words, call, *arguments, **options):
    try:
        call(*arguments, **options)
    except services.Failure as error:
        expect(error.reason == reason, f"{error.reason}: {error}")
        expect(all(word in str(error) for word in words), str(error))
        return
    expect(False, "nothing failed")


def test_failures():
    part = {"fabric": {"spacing": 5}}
    for program, reason, words in (("/no/such", "no-program", ["/no/such", "install draped"]),
                                   ("/bin/true", "other-version", ["/bin/true", "same version"])):
        failure(reason, words, services.service("", program).drape, part, DOME, FACES)
    failure("time-limit", ["0.01 s", "larger spacing"], drape, limit=0.01)
    failure("start-off-surface", ["/start", "nearest point"], drape, start={"point": [0, 0, 200]})
    failure("invalid-request", ["/fabric/spacing"], drape, -1)
    failure("invalid-request", ["/fabric/spacing"], drape, -1, address=URL)
    failure("unreachable", ["http://127.0.0.1:1", "Check the address"], drape, address="http://127.0.0.1:1")
    failure("other-version", ["nowhere", "Check the address"], drape, address="nowhere")
    with tempfile.TemporaryDirectory() as folder:
        broken = os.path.join(folder, "part.step")
        with open(broken, "wb") as file:
            file.write(b"ISO-10303-21;\nHEADER;\n" + bytes(100))
        failure("drape-failed", ["part.step"], drape, part=broken)
        failure("unreadable-file", [URL], drape, part=broken, address=URL)
        with open(broken, "wb") as file:
            file.write(bytes(2 << 20))
        failure("too-large", ["1048576", "Send less"], drape, part=broken, address=URL)


def main():
    tap = Tap()
    tap.run("workbench: command and daemon give the same net and pattern", test_same_by_both)
    tap.run("workbench: yarns, pattern, colours and triangles of a net", test_net)
    tap.run("workbench: places in the cloth", test_locate)
    tap.run("workbench: places between nodes are right to second order", test_locate_order)
    tap.run("workbench: each failure has its reason and a remedy", test_failures)
    tap.finish()


main()
