#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""From a drape request and a mesh of the mould to a case for LCMsim.

    python3 lcmsim_case.py request.json mould.bdf case [--url URL] [--inlet 17,18,19]

`request.json` needs a fabric with thickness and fiber_volume_fraction, and a permeability; the mesh
is a Nastran bulk-data file in the same unit as the surface. The folder `case` then has mesh.bdf,
part_description.csv, simulation_params.csv and README.txt, ready for LCMsim.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import zipfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "python"))
import draped  # noqa: E402


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("request")
    parser.add_argument("mesh")
    parser.add_argument("case")
    parser.add_argument("--url", default=os.environ.get("DRAPED_URL", "http://127.0.0.1:8080"))
    parser.add_argument("--inlet", help="ids of the elements at the inlet: 17,18,19")
    arguments = parser.parse_args()
    client = draped.Client(arguments.url)
    options = {"inlet_elements": arguments.inlet.split(",")} if arguments.inlet else {}
    try:
        with open(arguments.request, encoding="utf-8") as file:
            drape = client.submit(json.load(file))
        status = client.wait(drape)
        with tempfile.TemporaryDirectory() as folder:
            archive = os.path.join(folder, "case.zip")
            binning = client.save_map(drape, arguments.mesh, archive, format="lcmsim", **options)
            with zipfile.ZipFile(archive) as files:
                files.extractall(arguments.case)
    except (draped.DrapedError, OSError, ValueError) as error:
        print(f"lcmsim_case: {error}", file=sys.stderr)
        return 1
    print(f"{arguments.case}: shear up to {status['summary']['max_shear_deg']:.2f} deg; {binning}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
