# SPDX-License-Identifier: MIT
"""The task panel of a drape, and the commands of the workbench."""
from __future__ import annotations

from typing import Any, Callable

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from . import feature, icon, view

LINES = 8  # for what is told
PAUSE_MS = 400  # after a change, until it is draped again


class DrapePanel:
    """Parameters of a drape, which is draped again when one has changed; what went wrong is told below them. OK keeps
    what is shown, Cancel what was there before."""

    def __init__(self, drape: Any) -> None:
        self.drape = drape
        drape.Document.openTransaction("Drape")
        self.form = QtGui.QWidget()
        self.form.setWindowTitle("Drape")
        self.rows = QtGui.QFormLayout(self.form)
        self.timer = QtCore.QTimer(self.form)
        self.timer.setSingleShot(True)
        self.timer.timeout.connect(self.apply)
        self.waiting: dict[str, Any] = {}
        self._number("Spacing", "Spacing", " mm", 0, 1e5, "automatic")
        self._number("Angle", "Warp at", " deg", -360, 360)
        self._number("Locking", "Locking angle", " deg", 0, 89, "not known")
        self._number("UpTo", "Folds up to", " deg", 0, 180, "chosen alone")
        self._choice("Method", feature.METHODS)
        self._text("Material", "Fabric", "none of the library")
        self._start()
        self._text("Service", "Daemon", "by the preferences")
        self._number("Limit", "At most", " s", 1, 3600)
        self.told = QtGui.QLabel()
        self.told.setWordWrap(True)
        self.told.setAlignment(QtCore.Qt.AlignTop)
        self.told.setMinimumHeight(LINES * self.told.fontMetrics().lineSpacing())
        self.told.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
        self.rows.addRow(self.told)
        self.tell()

    def _number(self, name: str, label: str, unit: str, least: float, most: float, at_least: str = "") -> None:
        box = QtGui.QDoubleSpinBox()
        box.setRange(least, most)
        box.setDecimals(3 if unit == " mm" else 1)
        box.setSuffix(unit)
        box.setSpecialValueText(at_least)
        box.setKeyboardTracking(False)
        box.setValue(float(getattr(self.drape, name)))
        box.valueChanged.connect(lambda value: self.change(name, value))
        self._row(name, label, box)

    def _choice(self, name: str, words: list[str]) -> None:
        box = QtGui.QComboBox()
        box.addItems(words)
        box.setCurrentText(getattr(self.drape, name))
        box.currentTextChanged.connect(lambda word: self.change(name, word))
        self._row(name, name, box)

    def _text(self, name: str, label: str, none: str) -> None:
        box = QtGui.QLineEdit(getattr(self.drape, name))
        box.setPlaceholderText(none)
        box.editingFinished.connect(lambda: self.change(name, box.text().strip()))
        self._row(name, label, box)

    def _row(self, name: str, label: str, box: Any) -> None:
        box.setObjectName(name)
        box.setToolTip(self.drape.getDocumentationOfProperty(name))
        self.rows.addRow(label, box)

    def _start(self) -> None:
        pick, middle = QtGui.QPushButton("Picked"), QtGui.QPushButton("Middle")
        pick.setObjectName("PickStart")
        pick.clicked.connect(self.start_at_picked)
        middle.clicked.connect(lambda: self.change("OwnStart", False))
        both = QtGui.QHBoxLayout()
        both.addWidget(pick)
        both.addWidget(middle)
        self.rows.addRow("Start at", both)

    def start_at_picked(self) -> None:
        picked = [point for each in FreeCADGui.Selection.getSelectionEx() for point in each.PickedPoints]
        if not picked:
            self.told.setText("No point is picked: click on the part, then here.")
            return
        self.change("OwnStart", True)
        self.change("Start", picked[-1])

    def change(self, name: str, value: Any) -> None:
        """What has not changed is not draped again."""
        kept = getattr(self.drape, name)
        if (float(kept) if isinstance(value, float) else kept) != value or name in self.waiting:
            self.waiting[name] = value
            self.timer.start(PAUSE_MS)

    def apply(self) -> None:
        """Drapes with what has changed."""
        for name, value in self.waiting.items():
            setattr(self.drape, name, value)
        self.waiting = {}
        self.told.setText("draping ...")
        QtGui.QApplication.processEvents()
        self.drape.Document.recompute()
        self.tell()

    def tell(self) -> None:
        self.told.setText(self.drape.Outcome)

    def accept(self) -> bool:
        if self.waiting:
            self.apply()
        return self._leave(self.drape.Document.commitTransaction)

    def reject(self) -> bool:
        return self._leave(self.drape.Document.abortTransaction)

    def _leave(self, end: Callable[[], None]) -> bool:
        self.timer.stop()
        document = self.drape.Document
        end()
        FreeCADGui.getDocument(document.Name).resetEdit()
        document.recompute()
        return True


class DrapeCommand:
    """Drapes the chosen faces of one body and opens the panel."""

    def GetResources(self) -> dict[str, str]:
        return {"Pixmap": icon("drape"), "MenuText": "Drape faces",
                "ToolTip": "Lays woven fabric on the chosen faces of a body; a chosen coordinate system is its rosette"}

    def IsActive(self) -> bool:
        return FreeCAD.ActiveDocument is not None

    def Activated(self) -> None:
        chosen = FreeCADGui.Selection.getSelectionEx()
        bodies = [(each.Object, [name for name in each.SubElementNames if name.startswith("Face")]) for each in chosen]
        bodies = [(body, names) for body, names in bodies if names]
        rosettes = [each.Object for each in chosen if not each.SubElementNames and hasattr(each.Object, "Placement")]
        if len(bodies) != 1:
            QtGui.QMessageBox.information(FreeCADGui.getMainWindow(), "Drape", "Choose faces of one body first, those "
                                          "of its tool side, by clicks with Ctrl.")
            return
        document = bodies[0][0].Document
        document.openTransaction("Drape")
        drape = feature.make_drape(bodies[0])
        if rosettes:
            drape.Rosette = rosettes[0]
        view.show(drape)
        document.recompute()
        document.commitTransaction()
        FreeCADGui.getDocument(document.Name).setEdit(drape.Name)


class CompositesCommand:
    """Has shells of the Composites workbench draped by draped."""

    def GetResources(self) -> dict[str, str]:
        return {"Pixmap": icon("drape"), "MenuText": "Drape shells of Composites",
                "ToolTip": "Until FreeCAD is closed, shells of the Composites workbench are draped by draped"}

    def IsActive(self) -> bool:
        return True

    def Activated(self) -> None:
        from . import composites

        try:
            composites.use_in_composites()
        except ImportError as error:
            QtGui.QMessageBox.warning(FreeCADGui.getMainWindow(), "Draped", "The Composites workbench cannot be loaded ("
                                      f"{error}): install it with the addon manager.")


COMMANDS = ["Draped_Drape", "Draped_Composites"]
FreeCADGui.addCommand("Draped_Drape", DrapeCommand())
FreeCADGui.addCommand("Draped_Composites", CompositesCommand())
