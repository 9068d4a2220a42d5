#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A client for draped, in one file and with nothing but the standard library.

    import draped

    client = draped.Client("http://127.0.0.1:8080")
    drape = client.submit({"surface": ..., "fabric": {"spacing": 0.01}})
    client.wait(drape)                             # a progress bar, on a terminal
    result = client.result(drape)                  # {"summary", "grid", "nodes", "cells", "front", "rim", "cuts"}
    print(max(result["cells"]["shear_deg"]))       # NumPy arrays where NumPy is installed
    client.save(drape, "net.vtp")                  # the format by the name's ending
    fields = client.map(drape, "mould.bdf")        # the fields on your own mesh
    mesh = client.map_meshio(drape, "mould.bdf")   # the mesh with them, for meshio
    client.save_map(drape, "mould.bdf", "case.zip", format="lcmsim")

    part = client.upload("PART.step")              # {"id", "faces": [...], "length_unit", "notes", ...}
    client.submit({"surface": {"id": part["id"], "grow_from": 3}, "fabric": {"spacing": 4}})
    client.submit({"surface": {"file": "PART.stl", "unit": "mm"}, ...})  # both in one

    study = client.study({"drape": ..., "vary": {"start": {"grid": 50}}, "objectives": ["max_shear_deg"]})
    request = client.variant(study["id"], study["best"]["max_shear_deg"])  # to be submitted

What does not succeed is a `DrapedError` with the service's own words; `Unreachable`, `AccessRefused`, `TooLarge`,
`OtherVersion` and `WaitTimeout` are such errors. Files appear when they are complete, or not at all. As a program:

    python3 draped.py request.json -o net.vtp --url http://127.0.0.1:8080
"""

from __future__ import annotations

import argparse
import http.client
import io
import json
import os
import shutil
import sys
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request
import uuid
from typing import IO, Any, Callable, Mapping, Optional, Union

try:
    import numpy
except ImportError:
    numpy = None  # type: ignore[assignment]

__all__ = ["Client", "DrapedError", "Unreachable", "AccessRefused", "TooLarge", "OtherVersion", "WaitTimeout"]
__version__ = "1.0.0-rc1"  # of the daemon that it was made with

Json = dict[str, Any]
Mesh = Union[str, os.PathLike, Mapping[str, Any]]
Take = Callable[[http.client.HTTPResponse], Any]

FILE_FORMATS = {"step": "model/step", "iges": "model/iges", "stl": "model/stl", "obj": "model/obj",
                "nastran": "text/x-nastran", "abaqus": "text/x-abaqus", "lsdyna": "text/x-lsdyna",
                "gmsh": "text/x-gmsh", "unv": "text/x-unv", "vtu": "application/vnd.vtk"}
ENDINGS = {"stp": "step", "p21": "step", "igs": "iges", "bdf": "nastran", "nas": "nastran", "dat": "nastran",
           "inp": "abaqus", "k": "lsdyna", "key": "lsdyna", "msh": "gmsh"}  # where they are not the format's name
RESULT_FORMATS = ("json", "csv", "vtp", "glb", "npz")
PATTERN_FORMATS = ("svg", "dxf", "astm", "hpgl")
REPORT_FORMATS = ("html",)
RESULT_TABLES = ("nodes", "cells", "front", "rim", "cuts")
RETRIES = 4  # after a connection that failed or broke off, or an answer that asks to come later
HOUR = 3600.0
REMEDIES = {"unauthorized": "Give the client a token that the service knows.",
            "too-large": "Send less: fewer faces, a coarser mesh, or a larger spacing."}


class DrapedError(Exception):
    """What the service answered (RFC 9457), or a job that did not succeed.

    `slug` names the kind of problem ("invalid-request"), `status` is the HTTP status (0 without an answer),
    `detail` says what is wrong, `remedy` what to do if that is known, `url` is the service, `errors` the places in
    the request: [{"pointer", "detail"}]. `request_id` is what to look for in the service's log.
    """

    def __init__(self, status: int, problem: Mapping[str, Any], url: str = "") -> None:
        self.status = status
        self.slug = str(problem.get("type", "")).rpartition("/")[2] or "unknown"
        self.detail = str(problem.get("detail") or problem.get("title") or f"HTTP {status}")
        self.remedy = str(problem.get("remedy") or REMEDIES.get(self.slug, ""))
        self.url = url
        self.pointer: Optional[str] = problem.get("pointer")
        self.errors: list[Json] = list(problem.get("errors", []))
        self.request_id: Optional[str] = problem.get("request_id")
        places = "".join(f"\n  {e.get('pointer', '')}: {e.get('detail', '')}" for e in self.errors)
        where = (f" ({url})" if url else "") + (f". {self.remedy}" if self.remedy else "")
        super().__init__(f"{self.slug}: {self.detail}{where}{places}")


class Unreachable(DrapedError, ConnectionError):
    """No connection, none that lasted, or no answer within `timeout`."""


class AccessRefused(DrapedError):
    """The token is missing, unknown, or may not do this."""


class TooLarge(DrapedError):
    """A part, mesh or drape over a limit of the service."""


class OtherVersion(DrapedError):
    """The service's calls may differ from those known here, or it is no draped."""


class WaitTimeout(DrapedError, TimeoutError):
    """A job took longer than it was waited for; it goes on."""


def _problem(status: int, document: Any, url: str) -> DrapedError:
    kind = {401: AccessRefused, 403: AccessRefused, 413: TooLarge}.get(status, DrapedError)
    return kind(status, document if isinstance(document, dict) else {}, url)


def _refusal(error: urllib.error.HTTPError, url: str) -> DrapedError:
    try:
        document = json.loads(error.read())
    except (ValueError, OSError, http.client.HTTPException):
        document = {}
    return _problem(error.code, document, url)


def _into(path: Union[str, os.PathLike]) -> Take:
    """Takes an answer into a file, which appears when it is complete, or not at all; its headers."""
    unfinished = f"{os.fspath(path)}.part"

    def take(answer: http.client.HTTPResponse) -> Any:
        try:
            with open(unfinished, "wb") as file:
                shutil.copyfileobj(answer, file, 1 << 20)
            if answer.length:  # reading by parts does not tell
                raise http.client.IncompleteRead(b"", answer.length)
            os.replace(unfinished, path)
        finally:
            if os.path.exists(unfinished):
                os.remove(unfinished)
        return answer.headers

    return take


def _media_type(path: Union[str, os.PathLike], format: Optional[str] = None) -> str:
    ending = os.path.splitext(os.fspath(path))[1].lstrip(".").lower()
    name = format or ENDINGS.get(ending, ending)
    if name not in FILE_FORMATS:
        raise ValueError(f"{os.fspath(path)}: {name!r} is no format of files; there are {', '.join(FILE_FORMATS)}")
    return FILE_FORMATS[name]


def _ignore(answer: http.client.HTTPResponse) -> None:
    """Takes nothing of an answer that has nothing."""


def _column(values: list[Any]) -> Any:
    return numpy.array(values) if numpy is not None else values


def _table(columns: Mapping[str, list[Any]]) -> Json:
    return {name: _column(values) for name, values in columns.items()}


class _Bar:
    """A line on a terminal that says how far a drape is; silent elsewhere."""

    WIDTH = 30

    def __init__(self, stream: IO[str]) -> None:
        self.stream = stream
        self.shown = stream.isatty()

    def show(self, status: Json) -> None:
        if not self.shown:
            return
        done = round(self.WIDTH * float(status["progress"]))
        bar = "#" * done + "-" * (self.WIDTH - done)
        text = f"\r[{bar}] {100 * float(status['progress']):3.0f} % {status['status']:<10}"
        self.stream.write(text)
        self.stream.flush()

    def close(self) -> None:
        if self.shown:
            self.stream.write("\n")
            self.stream.flush()


class Client:
    """Calls one service. `token` is sent as a bearer token; `timeout` (seconds) bounds how long the
    service may be silent."""

    def __init__(self, url: str = "http://127.0.0.1:8080", token: Optional[str] = None,
                 timeout: float = 120) -> None:
        self.url = url.rstrip("/")
        self.token = token
        self.timeout = timeout

    # ---- calls ----

    def _call(self, take: Take, method: str, path: str, body: Optional[bytes] = None,
              headers: Optional[Mapping[str, str]] = None, **query: Any) -> Any:
        """What `take` makes of the answer to one call that may be repeated safely: again when the service is not
        there, breaks off or asks to come later."""
        given = {name: value for name, value in query.items() if value is not None}
        address = self.url + path + ("?" + urllib.parse.urlencode(given) if given else "")
        request = urllib.request.Request(address, data=body, method=method,
                                         headers=dict(headers or {}))
        if self.token:
            request.add_header("Authorization", f"Bearer {self.token}")
        for attempt in range(RETRIES + 1):
            pause = 0.25 * 2**attempt
            try:
                with urllib.request.urlopen(request, timeout=self.timeout) as answer:
                    return take(answer)
            except urllib.error.HTTPError as error:
                if error.code not in (429, 503) or attempt == RETRIES:
                    raise _refusal(error, self.url) from None
                asked = error.headers.get("Retry-After", "")
                pause = min(float(asked), 60) if asked.isdigit() else pause
            except (urllib.error.URLError, ConnectionError, TimeoutError, http.client.HTTPException) as error:
                why = getattr(error, "reason", error)
                late = isinstance(why, TimeoutError)
                if late or attempt == RETRIES:
                    raise self._unreachable(f"no answer within {self.timeout:g} s" if late else why) from error
            time.sleep(pause)
        raise AssertionError("unreachable")

    def _unreachable(self, why: Any) -> Unreachable:
        return Unreachable(0, {"type": "/problems/unreachable", "detail": f"the service cannot be reached: {why}",
                               "remedy": "Check the address, and that draped runs there."}, self.url)

    def _json(self, method: str, path: str, body: Optional[bytes] = None,
              headers: Optional[Mapping[str, str]] = None, **query: Any) -> Json:
        return self._call(json.load, method, path, body, headers, **query)

    def version(self) -> str:
        """The service's version; raises OtherVersion when its calls may differ from those known here."""
        try:
            known = self._json("GET", "/version")
            name, version = known["name"], str(known["version"])
        except (ValueError, KeyError, TypeError):
            name, version = "no draped", ""
        except DrapedError as error:
            if error.status != 404:
                raise
            name, version = "no draped", ""
        if name == "draped" and version.split(".")[:2] == __version__.split(".")[:2]:
            return version
        wanted = f"Use the draped.py of draped {version}." if name == "draped" else "Check the address."
        found = f"the service is {name} {version}".rstrip()
        raise OtherVersion(0, {"type": "/problems/other-version", "remedy": wanted,
                               "detail": f"{found}, this client is for draped {__version__}"}, self.url)

    # ---- surfaces ----

    def upload(self, surface: Union[str, os.PathLike, Mapping[str, Any]], unit: Optional[str] = None,
               format: Optional[str] = None) -> Json:
        """Stores a surface: a file of CAD (STEP, IGES) or a mesh (STL, OBJ, or shells of Nastran, Abaqus, LS-DYNA,
        Gmsh, a universal file, VTU), the format of FILE_FORMATS by its name's ending unless given, or a dict. What the
        service knows of it: `id`, and of a file `faces`, `edges`, `length_unit` and `notes`. `unit` (m, mm, cm,
        um, in, ft) is for files that state none."""
        if isinstance(surface, Mapping):
            body = json.dumps(surface, allow_nan=False).encode()
            return self._json("POST", "/v1/surfaces", body, {"Content-Type": "application/json"})
        if format is None and os.fspath(surface).lower().endswith(".json"):
            with open(surface, "rb") as file:
                return self.upload(json.load(file))
        headers = {"Content-Type": _media_type(surface, format)}
        with open(surface, "rb") as file:
            return self._json("POST", "/v1/surfaces", file.read(), headers, unit=unit)

    def surface(self, surface: str) -> Json:
        """The definition of a stored surface."""
        return self._json("GET", f"/v1/surfaces/{surface}")

    def delete_surface(self, surface: str) -> None:
        """Removes it; not while a drape needs it."""
        self._call(_ignore, "DELETE", f"/v1/surfaces/{surface}")

    def _stored(self, request: Mapping[str, Any], folder: Union[str, os.PathLike]) -> Json:
        """The request with the id of its surface, which is uploaded, in place of its file."""
        if "drape" in request:
            return {**request, "drape": self._stored(request["drape"], folder)}
        surface = request.get("surface")
        if not isinstance(surface, Mapping) or "file" not in surface:
            return dict(request)
        unit = surface.get("unit", request.get("length_unit"))
        stored = self.upload(os.path.join(folder, surface["file"]), unit)
        chosen = {key: value for key, value in surface.items() if key not in ("file", "unit")}
        return {**request, "surface": {"id": stored["id"], **chosen}}

    # ---- drapes ----

    def submit(self, request: Mapping[str, Any], folder: Union[str, os.PathLike] = "") -> str:
        """Queues a drape request (a dict as in the service's openapi.yaml); its id. A request that
        is repeated because the connection broke is not done twice. Its surface may be a file,
        {"file": "PART.step", "unit": "mm", "grow_from": 3}, relative to `folder`, which is uploaded."""
        return self._submit("drapes", request, folder)

    def _submit(self, collection: str, request: Mapping[str, Any],
                folder: Union[str, os.PathLike] = "") -> str:
        request = self._stored(request, folder)
        headers = {"Content-Type": "application/json", "Idempotency-Key": str(uuid.uuid4())}
        body = json.dumps(request, allow_nan=False).encode()
        return self._json("POST", f"/v1/{collection}", body, headers)["id"]

    def status(self, drape: str, wait: int = 0) -> Json:
        """The status document; with `wait` (seconds, at most 60) once the drape ends or they are
        over."""
        return self._json("GET", f"/v1/drapes/{drape}", wait=wait or None)

    def wait(self, drape: str, timeout: float = HOUR,
             progress: Optional[Callable[[Json], None]] = None) -> Json:
        """Waits until the drape has succeeded; its status document. `progress` is called with every
        status; without it there is a bar on standard error when that is a terminal.

        Raises DrapedError when the drape failed or was cancelled, WaitTimeout after `timeout`
        seconds."""
        return self._wait("drapes", drape, timeout, progress)

    def _wait(self, collection: str, job: str, timeout: float,
              progress: Optional[Callable[[Json], None]]) -> Json:
        until = time.monotonic() + timeout
        bar = _Bar(sys.stderr)
        try:
            while True:
                status = self._json("GET", f"/v1/{collection}/{job}", wait=1)
                (progress or bar.show)(status)
                if status["status"] not in ("queued", "running"):
                    break
                if time.monotonic() > until:
                    raise WaitTimeout(0, {"type": "/problems/wait-timeout", "detail": f"{collection}/{job} is still "
                                          f"{status['status']} after {timeout:g} s; it goes on"}, self.url)
        finally:
            if progress is None:
                bar.close()
        if status["status"] == "succeeded":
            return status
        problem = status.get("error") or {"type": "/problems/cancelled", "detail": "cancelled"}
        raise _problem(int(problem.get("status", 409)), problem, self.url)

    def cancel(self, drape: str) -> Json:
        """Stops it; the status document."""
        return self._json("POST", f"/v1/drapes/{drape}/cancel", b"")

    def delete(self, drape: str) -> None:
        """Removes the drape and its result."""
        self._call(_ignore, "DELETE", f"/v1/drapes/{drape}")

    # ---- laminates ----

    def submit_laminate(self, request: Mapping[str, Any]) -> str:
        """Queues a laminate (a dict with `surface` and `plies`); its id."""
        return self._submit("laminates", request)

    def laminate(self, laminate: str, wait: int = 0) -> Json:
        """The status document, whose `plies` have the ids of their drapes; `wait` as of a drape."""
        return self._json("GET", f"/v1/laminates/{laminate}", wait=wait or None)

    def laminate_report(self, laminate: str) -> Json:
        """What became of the plies: `plies`, each with its coverage, shear and area, pieces, seams and courses."""
        return self._json("GET", f"/v1/laminates/{laminate}/report", format="json")

    def save_patterns(self, laminate: str, path: Union[str, os.PathLike],
                      width: Optional[float] = None) -> None:
        """Saves the cut patterns of all plies on a roll of this width, svg, dxf, astm or hpgl by
        the name's ending, or as html the ply book."""
        name = os.path.splitext(os.fspath(path))[1].lstrip(".").lower()
        what = "report" if name in REPORT_FORMATS else "patterns"
        self._call(_into(path), "GET", f"/v1/laminates/{laminate}/{what}", format=name, width=width)

    def save_laser(self, laminate: str, path: Union[str, os.PathLike], format: str = "laser",
                   tolerance: Optional[float] = None) -> None:
        """Saves what laser projectors draw for every layer: `laser` (JSON), `laser-csv` or
        `virtek`."""
        self._call(_into(path), "GET", f"/v1/laminates/{laminate}/laser", format=format,
                   tolerance=tolerance)

    def save_bundle(self, laminate: str, path: Union[str, os.PathLike], **options: Any) -> None:
        """Saves all that leaves the house as a zip; `options` as in the service's openapi.yaml:
        width, gap, turn, tolerance, partial."""
        self._call(_into(path), "GET", f"/v1/laminates/{laminate}/bundle.zip", **options)

    def map_laminate(self, laminate: str, mesh: Mesh, **options: Any) -> Json:
        """The stack on a mesh, as `map` of a drape; `plies` has a row for every element and ply."""
        document = self._map(json.load, laminate, mesh, "json", options, "laminates")
        tables = {table: _table(document[table]) for table in ("cells", "plies") if table in document}
        return {**document, **tables}

    def save_laminate_map(self, laminate: str, mesh: Mesh, path: Union[str, os.PathLike],
                          format: Optional[str] = None, **options: Any) -> Optional[str]:
        """Saves it to a file, as `save_map` that of a drape."""
        return self._save_map(laminate, mesh, path, format, options, "laminates")

    # ---- studies ----

    def study(self, request: Mapping[str, Any], timeout: float = HOUR,
              progress: Optional[Callable[[Json], None]] = None) -> Json:
        """Does a study, many variants of a drape (a dict as in the service's openapi.yaml), and waits
        for it as `wait` does. Its result: `id`, `summary`, `best` (the index of the best variant for
        each objective) and the table `variants`, columns as arrays where NumPy is installed."""
        study = self._submit("studies", request)
        self._wait("studies", study, timeout, progress)
        document = self._json("GET", f"/v1/studies/{study}/result")
        return {**document, "variants": _table(document["variants"])}

    def variant(self, study: str, index: int) -> Json:
        """The drape request of one variant of a study, to be submitted as it is."""
        return self._json("GET", f"/v1/studies/{study}/variants/{int(index)}/request")

    def sample(self, study: str, index: int) -> Json:
        """The result of the drape of one variant, as `result`; it is draped for this call."""
        document = self._json("GET", f"/v1/studies/{study}/result", sample=int(index))
        return {**document, **{t: _table(document.get(t, {})) for t in RESULT_TABLES}}

    def map_sample(self, study: str, index: int, mesh: Mesh, **options: Any) -> Json:
        """The fields of the drape of one variant on a mesh, as `map` of a drape."""
        options["sample"] = int(index)
        document = self._map(json.load, study, mesh, "json", options, "studies")
        return {**document, "cells": _table(document["cells"])}

    def cancel_study(self, study: str) -> Json:
        """Stops it; the status document."""
        return self._json("POST", f"/v1/studies/{study}/cancel", b"")

    def delete_study(self, study: str) -> None:
        """Removes the study and its result."""
        self._call(_ignore, "DELETE", f"/v1/studies/{study}")

    # ---- materials ----

    def materials(self) -> list[Json]:
        """What a request may name as `fabric.material`: the library, then what was kept, newest first."""
        found, query = [], ""
        while True:
            page = self._json("GET", "/v1/materials" + query)
            found += page["materials"]
            if not page["next"]:
                return found
            query = f"?cursor={page['next']}"

    def material(self, name: str) -> Json:
        """A material with its figures."""
        return self._json("GET", f"/v1/materials/{urllib.parse.quote(name, safe='')}")

    def keep_material(self, material: Mapping[str, Any]) -> Json:
        """Keeps a material, for requests to name it; what became of earlier requests stays as it is."""
        return self._json("POST", "/v1/materials", json.dumps(material).encode(),
                          {"Content-Type": "application/json"})

    def delete_material(self, name: str) -> None:
        """Removes it, under whose name another may be kept then."""
        self._call(_ignore, "DELETE", f"/v1/materials/{urllib.parse.quote(name, safe='')}")

    # ---- results ----

    def result(self, drape: str, fields: Optional[list[str]] = None) -> Json:
        """The result of a drape that has succeeded: `summary`, `grid`, and the tables `nodes`,
        `cells`, `front`, `rim` and `cuts` (empty without cuts) as dicts of columns, NumPy arrays where
        NumPy is installed, else lists.
        `fields` (["nodes.x", "cells.k1"]) asks for these columns alone."""
        path = f"/v1/drapes/{drape}/result"
        chosen = None if fields is None else ",".join(fields)
        if numpy is None or (fields and any(name.startswith(("front.", "cuts.")) for name in fields)):
            document = self._json("GET", path, fields=chosen)
            return {**document, **{t: _table(document.get(t, {})) for t in RESULT_TABLES}}
        # NumPy's own format is many times faster to read; it has no names, and no summary.
        small = "front.i,front.j,front.reason"
        document = self._json("GET", path, fields=small)
        tables: dict[str, Json] = {table: {} for table in RESULT_TABLES}
        content = self._call(lambda answer: answer.read(), "GET", path, format="npz", fields=chosen)
        with numpy.load(io.BytesIO(content)) as arrays:
            for name in arrays.files:
                table, _, column = name.partition(".")
                tables[table][column] = arrays[name]
        tables["front"] = _table(document["front"]) if fields is None else {}
        if tables["cuts"]:
            named = self._json("GET", path, fields="cuts.name")
            tables["cuts"]["name"] = _column(named["cuts"]["name"])
        return {**document, **tables}

    def save(self, drape: str, path: Union[str, os.PathLike], format: Optional[str] = None,
             **options: Any) -> None:
        """Saves the result (json, csv, vtp, glb, npz), the flat cut pattern (svg, dxf, astm,
        hpgl) or a report to print (html) to a file; the format by its name's ending unless given. `options` are the
        query parameters `table`, `fields` and `precision`, or `allowance`, `part` and `ply`."""
        name = format or os.path.splitext(os.fspath(path))[1].lstrip(".").lower()
        documents = {"result": RESULT_FORMATS, "pattern": PATTERN_FORMATS, "report": REPORT_FORMATS}
        what = next((key for key, names in documents.items() if name in names), None)
        if what is None:
            known = ", ".join(sum(documents.values(), ()))
            raise ValueError(f"{name!r} is no format; there are {known}")
        self._call(_into(path), "GET", f"/v1/drapes/{drape}/{what}", format=name, **options)

    # ---- the fields on a mesh ----

    def _map(self, take: Take, job: str, mesh: Mesh, format: str, options: Mapping[str, Any],
             kind: str = "drapes") -> Any:
        path, query = f"/v1/{kind}/{job}/map", dict(options)
        for gate in ("inlet", "outlet", "edge_channel"):
            if gate in query and not isinstance(query[gate], str):
                query[gate] = ",".join(map(str, query[gate]))
        inlet = query.pop("inlet_elements", None)
        if isinstance(mesh, Mapping):
            document = dict(mesh) if inlet is None else {**mesh, "inlet_elements": list(inlet)}
            body, media_type = json.dumps(document, allow_nan=False).encode(), "application/json"
        else:
            media_type = _media_type(mesh)
            with open(mesh, "rb") as file:
                body = file.read()
            if inlet is not None:
                query["inlet_elements"] = ",".join(str(int(element)) for element in inlet)
        return self._call(take, "POST", path, body, {"Content-Type": media_type}, format=format, **query)

    def map(self, drape: str, mesh: Mesh, **options: Any) -> Json:
        """The drape's fields on a mesh: the name of a file of shells (Nastran, Abaqus, LS-DYNA, Gmsh, a universal
        file, VTU, STL or OBJ, by its ending), or a dict {"points": [[x, y, z], ...]} or
        {"mesh": {"vertices", "triangles"}}. The answer's `cells` has one value a column for each element or
        point, arrays where NumPy is installed; `warnings` tells of a mesh that lies elsewhere. `options`:
        `fields`, `precision`, `reference` (the direction that angles of plies run from, (x, y, z)), `within` (of
        decks), and for lcmsim `inlet` and `outlet`, lists of the file's ids (of a dict's mesh of indices),
        "pid:3", "set:NAME" and "sphere:x:y:z:radius", `edge_channel`, (width, permeability in m^2), `lcmsim_version` and
        `at_most_fiber_volume_fraction`; `cavity_height`, a number or "pid:3:0.002,pid:4:0.003", and `punch`,
        "pid:7"."""
        document = self._map(json.load, drape, mesh, "json", options)
        return {**document, "cells": _table(document["cells"])}

    def map_meshio(self, job: str, mesh: Mesh, kind: str = "drapes", **options: Any) -> Any:
        """The mesh with the fields of a drape, or a laminate (`kind="laminates"`), as its `cell_data`: a
        `meshio.Mesh`, which meshio writes in its formats. `options` as of `map`; points are no mesh."""
        import meshio  # not needed elsewhere

        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "map.vtu")
            self._save_map(job, mesh, path, "vtu", options, kind)
            read = meshio.read(path)
        for values in read.cell_data.values():  # a column that meshio takes for a table of one
            values[:] = [block[:, 0] if block.ndim == 2 and block.shape[1] == 1 else block for block in values]
        return read

    def save_map(self, drape: str, mesh: Mesh, path: Union[str, os.PathLike],
                 format: Optional[str] = None, **options: Any) -> Optional[str]:
        """Saves them to a file: json, csv, vtu, gmsh, unv, lcmsim (a zip), or a solver's deck (nastran,
        optistruct, radioss, lsdyna, abaqus, calculix), abd or acp; the format by its name's ending
        unless given, the options as above. For lcmsim: what the binning costs, as the service tells
        it in the header Draped-Binning."""
        return self._save_map(drape, mesh, path, format, options, "drapes")

    def _save_map(self, job: str, mesh: Mesh, path: Union[str, os.PathLike], format: Optional[str],
                  options: Mapping[str, Any], kind: str) -> Optional[str]:
        ending = os.path.splitext(os.fspath(path))[1].lstrip(".").lower()
        name = format or ENDINGS.get(ending, ending)
        return self._map(_into(path), job, mesh, name, options, kind).get("Draped-Binning")


def main() -> int:
    """Drapes a request from a file and saves the result."""
    parser = argparse.ArgumentParser(description="Drape a request and save the result.")
    parser.add_argument("request", help="a drape request, JSON; - for the standard input. Its "
                        "surface may be a file, by its path from there")
    parser.add_argument("-o", "--output", required=True,
                        help="json, csv, vtp, glb, npz, svg, dxf, astm, hpgl or html, by its "
                        "ending")
    parser.add_argument("--url", default=os.environ.get("DRAPED_URL", "http://127.0.0.1:8080"))
    parser.add_argument("--token", default=os.environ.get("DRAPED_TOKEN"))
    arguments = parser.parse_args()
    client = Client(arguments.url, arguments.token)
    try:
        client.version()
        with open(0 if arguments.request == "-" else arguments.request, encoding="utf-8") as file:
            drape = client.submit(json.load(file), os.path.dirname(arguments.request))
        status = client.wait(drape)
        client.save(drape, arguments.output)
    except (DrapedError, OSError, ValueError) as error:
        print(f"draped: {error}", file=sys.stderr)
        return 1
    summary = status["summary"]
    print(f"{drape}: {summary['outcome']}, {summary['nodes']} nodes, "
          f"shear up to {summary['max_shear_deg']:.2f} deg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
