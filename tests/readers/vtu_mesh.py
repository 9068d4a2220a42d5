#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Writes a JSON mesh as VTK XML files in every way that VTK has: as text, in base64, appended raw and in base64, as it
is and packed by zlib in small blocks, with lengths of 4 and of 8 bytes, of both byte orders.
usage: vtu_mesh.py MESH.json FOLDER"""

import json
import sys

import vtk

with open(sys.argv[1], encoding="ascii") as file:
    mesh = json.load(file)["mesh"]
points, grid = vtk.vtkPoints(), vtk.vtkUnstructuredGrid()
points.SetDataTypeToDouble()
for place in mesh["vertices"]:
    points.InsertNextPoint(place)
grid.SetPoints(points)
ids, pids = vtk.vtkIntArray(), vtk.vtkShortArray()
ids.SetName("id")
pids.SetName("pid")
elements = mesh["triangles"] + mesh["quads"]
grid.InsertNextCell(vtk.VTK_LINE, 2, [0, 1])
ids.InsertNextValue(-1)  # what is no shell needs no number
pids.InsertNextValue(-1)
for element, number in zip(elements, mesh["ids"]):
    grid.InsertNextCell({3: vtk.VTK_TRIANGLE, 4: vtk.VTK_QUAD}[len(element)], len(element), element)
    ids.InsertNextValue(number)
    pids.InsertNextValue(1 + number % 2)
grid.GetCellData().AddArray(ids)
grid.GetCellData().AddArray(pids)
modes = {"ascii": (0, 0), "binary": (1, 0), "raw": (2, 0), "base64": (2, 1)}
for name, (mode, encode) in modes.items():
    for pack in (False, True):
        for wide in (False, True):
            for big in (False, True):
                writer = vtk.vtkXMLUnstructuredGridWriter()
                writer.SetInputData(grid)
                writer.SetDataMode(mode)
                writer.SetEncodeAppendedData(encode)
                writer.SetCompressorTypeToZLib() if pack else writer.SetCompressorTypeToNone()
                writer.SetBlockSize(1024)
                writer.SetHeaderTypeToUInt64() if wide else writer.SetHeaderTypeToUInt32()
                writer.SetByteOrderToBigEndian() if big else writer.SetByteOrderToLittleEndian()
                writer.SetFileName(f"{sys.argv[2]}/{name}{'-zlib' * pack}{'-64' * wide}{'-big' * big}.vtu")
                assert writer.Write() == 1
