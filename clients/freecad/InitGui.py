# SPDX-License-Identifier: MIT
# FreeCAD runs this at its start where there is a display.
import FreeCADGui


class DrapedWorkbench(FreeCADGui.Workbench):
    """Woven fabric on faces of a body."""

    MenuText = "Draped"
    ToolTip = "Lays woven fabric on faces of a body"

    def __init__(self):
        from draped_workbench import icon

        self.__class__.Icon = icon("drape")

    def Initialize(self):
        from draped_workbench.panel import COMMANDS

        self.appendToolbar("Draped", COMMANDS)
        self.appendMenu("Draped", COMMANDS)

    def GetClassName(self):
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(DrapedWorkbench())
