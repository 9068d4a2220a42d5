# SPDX-License-Identifier: MIT
"""How drapes are shown, where there is a display."""
from __future__ import annotations

from typing import Any

import FreeCADGui

from . import icon


class View:
    """Of a document object; nothing of it is kept with the document."""

    def __init__(self, vobj: Any) -> None:
        vobj.Proxy = self

    def attach(self, vobj: Any) -> None:
        self.obj = vobj.Object

    def getIcon(self) -> str:
        return icon("drape")

    def __getstate__(self) -> None:
        return None

    def __setstate__(self, state: Any) -> None:
        return None

    dumps, loads = __getstate__, __setstate__


class DrapeView(View):
    """Cloth and pattern are below the drape in the tree; a double click opens its panel."""

    def claimChildren(self) -> list[Any]:
        return [other for other in self.obj.InList if hasattr(other, "Drape")]

    def setEdit(self, vobj: Any, mode: int = 0) -> bool:
        from .panel import DrapePanel

        FreeCADGui.Control.showDialog(DrapePanel(vobj.Object))
        return True

    def unsetEdit(self, vobj: Any, mode: int = 0) -> bool:
        FreeCADGui.Control.closeDialog()
        return True

    def doubleClicked(self, vobj: Any) -> bool:
        return vobj.Document.setEdit(vobj.Object.Name)


class ClothView(View):
    """In the colours of its triangles."""

    def updateData(self, obj: Any, name: str) -> None:
        if name == "FaceColors" and len(obj.FaceColors) == obj.Mesh.CountFacets:
            obj.ViewObject.Coloring = False  # what is set again is drawn again
            obj.ViewObject.Coloring = bool(obj.FaceColors)


def show(drape: Any) -> None:
    """Gives a new drape and what follows it their views."""
    DrapeView(drape.ViewObject)
    drape.ViewObject.LineWidth = 1
    drape.ViewObject.LineColor = (0.25, 0.25, 0.25)
    for other in drape.InList:
        if other.Proxy.Type == "Draped::Cloth":
            ClothView(other.ViewObject)
            other.ViewObject.Lighting = "Two side"
        else:
            View(other.ViewObject)
            other.ViewObject.LineColor = other.ViewObject.PointColor = (0.1, 0.1, 0.1)
            other.ViewObject.PointSize = 1
