# SPDX-License-Identifier: MIT
# FreeCAD runs this at its start, with and without a display. Nothing is needed then.
