#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What cloth.c does, by ctypes: drapes a request, says how far the cloth shears, and writes the
fields at the nodes of a mesh of one's own.
Usage: cloth.py REQUEST.json MESH.bdf FIELDS.vtu"""
import ctypes
import json
import sys

lib = ctypes.CDLL("libdrape.so.1")
size = ctypes.POINTER(ctypes.c_size_t)
progress = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double)
text, handle = ctypes.c_char_p, ctypes.c_void_p
for name, result, arguments in (
        ("drape_run", handle, (text, ctypes.c_size_t, text, progress, handle)),
        ("drape_free", None, (handle,)),
        ("drape_problem", text, (handle,)),
        ("drape_column", ctypes.POINTER(ctypes.c_double), (handle, text, size)),
        ("drape_map", handle, (handle, text, ctypes.c_size_t, text, text, text, size)),
        ("drape_free_document", None, (handle,))):
    getattr(lib, name).restype = result
    getattr(lib, name).argtypes = arguments


class Problem(Exception):
    """What could not be done: the members of the problem document, of which the detail is shown."""

    def __init__(self, problem):
        super().__init__(problem["detail"])
        self.problem = problem


class Drape:
    def __init__(self, request):
        request = json.dumps(request).encode()
        self.handle = lib.drape_run(request, len(request), None, progress(), None)
        self._check(self.handle and not lib.drape_problem(self.handle))

    def _check(self, good):
        if not good:
            problem = lib.drape_problem(self.handle) if self.handle else b'{"detail": "no memory"}'
            raise Problem(json.loads(problem))

    def column(self, name):
        """A column's values; `numpy.ctypeslib.as_array` takes them as well."""
        count = ctypes.c_size_t()
        values = lib.drape_column(self.handle, name.encode(), ctypes.byref(count))
        self._check(values)
        return values[:count.value]

    def map(self, mesh, mesh_format, result_format, options=""):
        """The document with the fields on a mesh, as bytes."""
        length = ctypes.c_size_t()
        document = lib.drape_map(self.handle, mesh, len(mesh), mesh_format.encode(),
                                 result_format.encode(), options.encode(), ctypes.byref(length))
        self._check(document)
        try:
            return ctypes.string_at(document, length.value)
        finally:
            lib.drape_free_document(document)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        lib.drape_free(self.handle)


if __name__ == "__main__":
    request_file, mesh_file, fields_file = sys.argv[1:]
    with open(request_file, encoding="utf-8") as request, open(mesh_file, "rb") as mesh:
        try:
            with Drape(json.load(request)) as drape:
                fields = drape.map(mesh.read(), "nastran", "vtu")
                shear = max(map(abs, drape.column("cells.shear_deg")))
        except Problem as problem:
            sys.exit(str(problem))
    with open(fields_file, "wb") as file:
        file.write(fields)
    print(f"sheared by up to {shear:.2f} degrees")
