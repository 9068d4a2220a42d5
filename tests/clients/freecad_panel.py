# SPDX-License-Identifier: MIT
"""The FreeCAD workbench in its window, run by `freecad` (tests/clients/freecad.py): the command, the panel and the
views. What it finds goes to the file TAP, pictures to the folder PICTURES if that is given."""
import os
import sys

sys.path[:0] = ["clients/freecad", "tests/clients", "tests/faults"]
import FreeCAD
import FreeCADGui
import Part
from daemon import Tap, expect
from PySide import QtCore, QtGui
from workbench_parts import dome

PICTURES = os.environ.get("PICTURES")


def until(what, seconds=30):
    """Has the window run until `what` is so."""
    loop, left = QtCore.QEventLoop(), int(seconds * 20)
    while not what() and left:
        QtCore.QTimer.singleShot(50, loop.quit)
        loop.exec_()
        left -= 1
    expect(left, "it takes too long")


def picture(name, whole=False):
    if not PICTURES:
        return
    FreeCADGui.updateGui()
    path = os.path.join(PICTURES, f"freecad_{name}.png")
    if whole:
        window = FreeCADGui.getMainWindow()
        window.findChild(QtGui.QDockWidget, "Combo View").setMinimumWidth(330)
        window.showMaximized()
        FreeCADGui.ActiveDocument.ActiveView.fitAll()
        begun = QtCore.QTime.currentTime()
        until(lambda: begun.msecsTo(QtCore.QTime.currentTime()) > 1500)
        window.screen().grabWindow(0).save(path)  # with what OpenGL drew
    else:
        FreeCADGui.ActiveDocument.ActiveView.saveImage(path, 900, 600, "White")


def chosen():
    """A document with the dome, its upper faces selected, and its window."""
    FreeCADGui.Selection.clearSelection()
    document = FreeCAD.newDocument()
    body = document.addObject("Part::Feature", "Body")
    body.Shape = dome()
    document.recompute()
    for k, face in enumerate(body.Shape.Faces):
        if not isinstance(face.Surface, Part.Plane) or abs(face.CenterOfMass.z) < 1e-6:
            FreeCADGui.Selection.addSelection(document.Name, body.Name, f"Face{k + 1}")
    return document


def panel():
    """The form of the task panel that is open, by the names of its boxes."""
    form = next(widget for widget in FreeCADGui.getMainWindow().findChildren(QtGui.QWidget)
                if widget.windowTitle() == "Drape" and widget.findChild(QtGui.QDoubleSpinBox, "Spacing"))
    return form, lambda kind, name: form.findChild(kind, name)


def test_workbench():
    import InitGui  # noqa: F401

    FreeCADGui.activateWorkbench("DrapedWorkbench")
    expect("Draped_Drape" in FreeCADGui.listCommands(), "no command")
    expect(FreeCADGui.activeWorkbench().MenuText == "Draped", "another workbench")


def test_command():
    document = chosen()
    FreeCADGui.runCommand("Draped_Drape")
    drape, cloth = document.Drape, document.DrapeCloth
    expect(drape.Outcome.startswith("complete"), drape.Outcome)
    expect(len(drape.Faces[1]) == 3, drape.Faces)
    expect([each.Name for each in drape.ViewObject.Proxy.claimChildren()] == ["DrapeCloth", "DrapePattern"], "children")
    expect(cloth.ViewObject.Coloring and len(set(cloth.FaceColors)) > 100, "no colours")
    expect(FreeCADGui.Control.activeDialog(), "no panel")
    document.Body.Visibility = False
    view = FreeCADGui.ActiveDocument.ActiveView
    view.viewIsometric()
    view.fitAll()
    form, _ = panel()
    label = form.findChildren(QtGui.QLabel)[-1]
    expect(label.text() == drape.Outcome, label.text())


def test_panel():
    document = FreeCAD.ActiveDocument
    drape, (form, box) = document.Drape, panel()
    before, facets = drape.Outcome, document.DrapeCloth.Mesh.CountFacets
    box(QtGui.QDoubleSpinBox, "Spacing").setValue(3)
    box(QtGui.QDoubleSpinBox, "Locking").setValue(40)
    until(lambda: document.DrapeCloth.Mesh.CountFacets > 1.5 * facets)
    expect(float(drape.Spacing) == 3 and float(drape.Locking) == 40 and drape.Outcome != before, drape.Outcome)
    picture("panel", whole=True)
    box(QtGui.QDoubleSpinBox, "Spacing").setValue(1e4)
    label = form.findChildren(QtGui.QLabel)[-1]
    until(lambda: "/fabric/spacing" in label.text())
    expect(document.DrapeCloth.Mesh.CountFacets == 0, "old cloth beside an error")
    service = box(QtGui.QLineEdit, "Service")
    service.setText("http://127.0.0.1:1")
    service.editingFinished.emit()
    until(lambda: "Check the address" in label.text())
    service.setText(os.environ["URL"])
    service.editingFinished.emit()
    box(QtGui.QDoubleSpinBox, "Spacing").setValue(3)
    until(lambda: label.text().startswith("complete"))


def test_start():
    document = FreeCAD.ActiveDocument
    drape, (form, box) = document.Drape, panel()
    FreeCADGui.Selection.clearSelection()
    FreeCADGui.Selection.addSelection(document.Name, "Body", "Face1", 60, 60, 0)
    box(QtGui.QPushButton, "PickStart").click()
    until(lambda: drape.OwnStart and (drape.Proxy.net is not None)
          and abs(drape.Proxy.net.points[(drape.Proxy.net.index == 0).all(axis=1)][0] - [60, 60, 0]).max() < 1e-6)


def press(which):
    """A button of the task panel, which is closed by it."""
    for each in FreeCADGui.getMainWindow().findChildren(QtGui.QDialogButtonBox):
        if each.button(which):
            each.button(which).click()
            break
    until(lambda: not FreeCADGui.Control.activeDialog())


def test_leave():
    """Cancel takes away a drape that was new; later it gives what was there before the panel, and OK keeps what is
    shown."""
    document = FreeCAD.ActiveDocument
    press(QtGui.QDialogButtonBox.Cancel)
    expect([each.Name for each in document.Objects] == ["Body"], document.Objects)
    document = chosen()
    FreeCADGui.runCommand("Draped_Drape")
    panel()[1](QtGui.QDoubleSpinBox, "Angle").setValue(30)
    press(QtGui.QDialogButtonBox.Ok)
    drape = document.Drape
    expect(float(drape.Angle) == 30 and drape.Outcome.startswith("complete"), drape.Outcome)
    kept, facets = drape.Outcome, document.DrapeCloth.Mesh.CountFacets
    FreeCADGui.ActiveDocument.setEdit("Drape")
    panel()[1](QtGui.QDoubleSpinBox, "Spacing").setValue(3)
    until(lambda: document.DrapeCloth.Mesh.CountFacets > facets)
    press(QtGui.QDialogButtonBox.Cancel)
    expect(float(drape.Spacing) == 0 and float(drape.Angle) == 30 and drape.Outcome == kept, drape.Outcome)
    expect(document.DrapeCloth.Mesh.CountFacets == facets, "another cloth")


def test_pattern():
    document = FreeCAD.ActiveDocument
    for each in document.Objects:
        each.Visibility = each.Name == "DrapePattern"
    view = FreeCADGui.ActiveDocument.ActiveView
    view.viewTop()
    view.fitAll()
    picture("pattern")
    expect(document.DrapePattern.Shape.Wires[0].isClosed(), "an open pattern")


def test_nothing_chosen():
    chosen()
    FreeCADGui.Selection.clearSelection()
    said = []
    kept, QtGui.QMessageBox.information = QtGui.QMessageBox.information, lambda *words: said.append(words[-1])
    FreeCADGui.runCommand("Draped_Drape")
    QtGui.QMessageBox.information = kept
    expect(len(said) == 1 and said[0].startswith("Choose faces of one body"), said)
    expect(not FreeCAD.ActiveDocument.getObject("Drape"), "a drape of nothing")


def main():
    tap = Tap()
    for name, test in (("the workbench is there", test_workbench), ("the command drapes chosen faces", test_command),
                       ("the panel drapes again, and says what is wrong", test_panel),
                       ("the start at a picked point", test_start), ("cancel and OK", test_leave),
                       ("the pattern is a sketch", test_pattern), ("nothing chosen", test_nothing_chosen)):
        tap.run(f"freecad's window: {name}", test)
    tap.finish()


def begin():
    with open(os.environ["TAP"], "w", buffering=1) as sys.stdout:
        try:
            main()
        except SystemExit:
            pass
    os._exit(0)


QtCore.QTimer.singleShot(2000, begin)
