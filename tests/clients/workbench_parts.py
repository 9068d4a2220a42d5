# SPDX-License-Identifier: MIT
"""Parts of both tests of the FreeCAD workbench."""
import FreeCAD
import Part


def dome():
    """A half sphere on a plate, with a fillet round its foot."""
    flange = Part.makeBox(180, 180, 6, FreeCAD.Vector(-90, -90, -6))
    part = flange.fuse(Part.makeSphere(50, FreeCAD.Vector(), FreeCAD.Vector(0, 0, 1), 0, 90)).removeSplitter()
    foot = [edge for edge in part.Edges if abs(edge.BoundBox.ZMin) < 1e-6 and edge.BoundBox.ZLength < 1e-6
            and abs(edge.BoundBox.XLength - 100) < 1]
    return part.makeFillet(10, foot)
