# SPDX-License-Identifier: MIT
"""Drapes woven fabric on faces of a body, by draped. `net` and `service` need no FreeCAD, `feature` and `composites` no
display."""
import os


def icon(name: str) -> str:
    return os.path.join(os.path.dirname(os.path.abspath(__file__)), "icons", f"{name}.svg")
