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
    client.save_map(drape, "mould.bdf", "case.zip", format="lcmsim")

    part = client.upload("PART.step")              # {"id", "faces": [...], "length_unit", "notes", ...}
    client.submit({"surface": {"id": part["id"], "grow_from": 3}, "fabric": {"spacing": 4}})
    client.submit({"surface": {"file": "PART.stl", "unit": "mm"}, ...})  # both in one

    study = client.study({"drape": ..., "vary": {"start": {"grid": 50}}, "objectives": ["max_shear_deg"]})
    request = client.variant(study["id"], study["best"]["max_shear_deg"])  # to be submitted

Every error of the service is a `DrapedError` with the service's own words. As a program:

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

__all__ = ["Client", "DrapedError"]
__version__ = "0.10.0"  # of the daemon that it was made with

Json = dict[str, Any]
Mesh = Union[str, os.PathLike, Mapping[str, Any]]

SURFACE_FORMATS = {"step": "step", "stp": "step", "iges": "iges", "igs": "iges", "stl": "stl",
                   "obj": "obj", "bdf": "nastran", "nas": "nastran"}  # by the name's ending
RESULT_FORMATS = ("json", "csv", "vtp", "glb", "npz")
PATTERN_FORMATS = ("svg", "dxf", "astm", "hpgl")
REPORT_FORMATS = ("html",)
RESULT_TABLES = ("nodes", "cells", "front", "rim", "cuts")
RETRIES = 4  # after a connection that failed, or an answer that asks to come later


class DrapedError(Exception):
    """What the service answered (RFC 9457), or a drape that did not succeed.

    `slug` names the kind of problem ("invalid-request"), `status` is the HTTP status, `detail` a
    sentence, `errors` the places in the request: [{"pointer", "detail"}]. `request_id` is what to
    look for in the service's log.
    """

    def __init__(self, status: int, problem: Mapping[str, Any]) -> None:
        self.status = status
        self.slug = str(problem.get("type", "")).rpartition("/")[2] or "unknown"
        self.detail = str(problem.get("detail") or problem.get("title") or f"HTTP {status}")
        self.pointer: Optional[str] = problem.get("pointer")
        self.errors: list[Json] = list(problem.get("errors", []))
        self.request_id: Optional[str] = problem.get("request_id")
        places = "".join(f"\n  {e.get('pointer', '')}: {e.get('detail', '')}" for e in self.errors)
        super().__init__(f"{self.slug}: {self.detail}{places}")


def _problem(error: urllib.error.HTTPError) -> DrapedError:
    try:
        document = json.loads(error.read())
    except ValueError:
        document = {}
    return DrapedError(error.code, document if isinstance(document, dict) else {})


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

    def _open(self, method: str, path: str, body: Optional[bytes] = None,
              headers: Optional[Mapping[str, str]] = None, **query: Any) -> http.client.HTTPResponse:
        """One call that may be repeated safely; tries again when the service is not there or asks
        to come later."""
        given = {name: value for name, value in query.items() if value is not None}
        address = self.url + path + ("?" + urllib.parse.urlencode(given) if given else "")
        request = urllib.request.Request(address, data=body, method=method,
                                         headers=dict(headers or {}))
        if self.token:
            request.add_header("Authorization", f"Bearer {self.token}")
        for attempt in range(RETRIES + 1):
            pause = 0.25 * 2**attempt
            try:
                return urllib.request.urlopen(request, timeout=self.timeout)
            except urllib.error.HTTPError as error:
                if error.code not in (429, 503) or attempt == RETRIES:
                    raise _problem(error) from None
                asked = error.headers.get("Retry-After", "")
                pause = min(float(asked), 60) if asked.isdigit() else pause
            except (urllib.error.URLError, ConnectionError, http.client.HTTPException):
                if attempt == RETRIES:
                    raise
            time.sleep(pause)
        raise AssertionError("unreachable")

    def _json(self, method: str, path: str, body: Optional[bytes] = None,
              headers: Optional[Mapping[str, str]] = None, **query: Any) -> Json:
        with self._open(method, path, body, headers, **query) as answer:
            return json.load(answer)

    def _write(self, answer: http.client.HTTPResponse, path: Union[str, os.PathLike]) -> None:
        """The file appears when it is complete, or not at all."""
        unfinished = f"{os.fspath(path)}.part"
        try:
            with answer, open(unfinished, "wb") as file:
                shutil.copyfileobj(answer, file, 1 << 20)
            os.replace(unfinished, path)
        finally:
            if os.path.exists(unfinished):
                os.remove(unfinished)

    # ---- surfaces ----

    def upload(self, surface: Union[str, os.PathLike, Mapping[str, Any]], unit: Optional[str] = None,
               format: Optional[str] = None) -> Json:
        """Stores a surface: a STEP, IGES, STL, OBJ or Nastran file, the format by its name's ending
        unless given, or a dict. What the service knows of it: `id`, and of a file `faces`, `edges`,
        `length_unit` and `notes`. `unit` (m, mm, cm, um, in, ft) is for files that state none."""
        if isinstance(surface, Mapping):
            body = json.dumps(surface, allow_nan=False).encode()
            return self._json("POST", "/v1/surfaces", body, {"Content-Type": "application/json"})
        ending = os.path.splitext(os.fspath(surface))[1].lstrip(".").lower()
        name = format or SURFACE_FORMATS.get(ending)
        if name is None and ending != "json":
            known = ", ".join(SURFACE_FORMATS)
            raise ValueError(f"{os.fspath(surface)}: {ending!r} is no format of surfaces; there are {known}")
        with open(surface, "rb") as file:
            if name is None:
                return self.upload(json.load(file))
            return self._json("POST", "/v1/surfaces", file.read(),
                              {"Content-Type": "application/octet-stream"}, format=name, unit=unit)

    def surface(self, surface: str) -> Json:
        """The definition of a stored surface."""
        return self._json("GET", f"/v1/surfaces/{surface}")

    def delete_surface(self, surface: str) -> None:
        """Removes it; not while a drape needs it."""
        self._open("DELETE", f"/v1/surfaces/{surface}").close()

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

    def wait(self, drape: str, timeout: Optional[float] = None,
             progress: Optional[Callable[[Json], None]] = None) -> Json:
        """Waits until the drape has succeeded; its status document. `progress` is called with every
        status; without it there is a bar on standard error when that is a terminal.

        Raises DrapedError when the drape failed or was cancelled, TimeoutError after `timeout`
        seconds."""
        return self._wait("drapes", drape, timeout, progress)

    def _wait(self, collection: str, job: str, timeout: Optional[float],
              progress: Optional[Callable[[Json], None]]) -> Json:
        until = None if timeout is None else time.monotonic() + timeout
        bar = _Bar(sys.stderr)
        try:
            while True:
                status = self._json("GET", f"/v1/{collection}/{job}", wait=1)
                (progress or bar.show)(status)
                if status["status"] not in ("queued", "running"):
                    break
                if until is not None and time.monotonic() > until:
                    raise TimeoutError(f"{collection}/{job} is still {status['status']}")
        finally:
            if progress is None:
                bar.close()
        if status["status"] == "succeeded":
            return status
        problem = status.get("error") or {"type": "/problems/cancelled", "detail": "cancelled"}
        raise DrapedError(int(problem.get("status", 409)), problem)

    def cancel(self, drape: str) -> Json:
        """Stops it; the status document."""
        return self._json("POST", f"/v1/drapes/{drape}/cancel", b"")

    def delete(self, drape: str) -> None:
        """Removes the drape and its result."""
        self._open("DELETE", f"/v1/drapes/{drape}").close()

    # ---- laminates ----

    def submit_laminate(self, request: Mapping[str, Any]) -> str:
        """Queues a laminate (a dict with `surface` and `plies`); its id."""
        return self._submit("laminates", request)

    def laminate(self, laminate: str, wait: int = 0) -> Json:
        """The status document, whose `plies` have the ids of their drapes; `wait` as of a drape."""
        return self._json("GET", f"/v1/laminates/{laminate}", wait=wait or None)

    def save_patterns(self, laminate: str, path: Union[str, os.PathLike],
                      width: Optional[float] = None) -> None:
        """Saves the cut patterns of all plies on a roll of this width, svg, dxf, astm or hpgl by
        the name's ending, or as html the ply book."""
        name = os.path.splitext(os.fspath(path))[1].lstrip(".").lower()
        what = "report" if name in REPORT_FORMATS else "patterns"
        self._write(self._open("GET", f"/v1/laminates/{laminate}/{what}", format=name,
                               width=width), path)

    def map_laminate(self, laminate: str, mesh: Mesh, **options: Any) -> Json:
        """The stack on a mesh, as `map` of a drape; `plies` has a row for every element and ply."""
        with self._open_map(laminate, mesh, "json", options, "laminates") as answer:
            document = json.load(answer)
        tables = {table: _table(document[table]) for table in ("cells", "plies") if table in document}
        return {**document, **tables}

    def save_laminate_map(self, laminate: str, mesh: Mesh, path: Union[str, os.PathLike],
                          format: Optional[str] = None, **options: Any) -> Optional[str]:
        """Saves it to a file, as `save_map` that of a drape."""
        return self._save_map(laminate, mesh, path, format, options, "laminates")

    # ---- studies ----

    def study(self, request: Mapping[str, Any], timeout: Optional[float] = None,
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
        with self._open_map(study, mesh, "json", options, "studies") as answer:
            document = json.load(answer)
        return {**document, "cells": _table(document["cells"])}

    def cancel_study(self, study: str) -> Json:
        """Stops it; the status document."""
        return self._json("POST", f"/v1/studies/{study}/cancel", b"")

    def delete_study(self, study: str) -> None:
        """Removes the study and its result."""
        self._open("DELETE", f"/v1/studies/{study}").close()

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
        self._open("DELETE", f"/v1/materials/{urllib.parse.quote(name, safe='')}").close()

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
        with self._open("GET", path, format="npz", fields=chosen) as answer:
            with numpy.load(io.BytesIO(answer.read())) as arrays:
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
        self._write(self._open("GET", f"/v1/drapes/{drape}/{what}", format=name, **options), path)

    # ---- the fields on a mesh ----

    def _open_map(self, job: str, mesh: Mesh, format: str, options: Mapping[str, Any],
                  kind: str = "drapes") -> http.client.HTTPResponse:
        path, query = f"/v1/{kind}/{job}/map", dict(options)
        for gate in ("inlet", "outlet", "edge_channel"):
            if gate in query and not isinstance(query[gate], str):
                query[gate] = ",".join(map(str, query[gate]))
        inlet = query.pop("inlet_elements", None)
        if isinstance(mesh, Mapping):
            document = dict(mesh) if inlet is None else {**mesh, "inlet_elements": list(inlet)}
            body = json.dumps(document, allow_nan=False).encode()
            return self._open("POST", path, body, {"Content-Type": "application/json"},
                              format=format, **query)
        if inlet is not None:
            query["inlet_elements"] = ",".join(str(int(element)) for element in inlet)
        with open(mesh, "rb") as file:
            return self._open("POST", path, file.read(), {"Content-Type": "text/x-nastran"},
                              format=format, **query)

    def map(self, drape: str, mesh: Mesh, **options: Any) -> Json:
        """The drape's fields on a mesh: the name of a Nastran bulk-data file, or a dict
        {"points": [[x, y, z], ...]} or {"mesh": {"vertices", "triangles"}}. The answer's `cells` has
        one value a column for each element or point, arrays where NumPy is installed; `warnings`
        tells of a mesh that lies elsewhere. `options`: `fields`, `precision`, `reference` (the
        direction that angles of plies run from, (x, y, z)), `within` (of decks), and for lcmsim `inlet`
        and `outlet`, lists of the file's ids (of a dict's mesh of indices), "pid:3" and
        "sphere:x:y:z:radius", `edge_channel`, (width, permeability in m^2), `lcmsim_version` and
        `at_most_fiber_volume_fraction`; `cavity_height`, a number or "pid:3:0.002,pid:4:0.003", and
        `punch`, "pid:7"."""
        with self._open_map(drape, mesh, "json", options) as answer:
            document = json.load(answer)
        return {**document, "cells": _table(document["cells"])}

    def save_map(self, drape: str, mesh: Mesh, path: Union[str, os.PathLike],
                 format: Optional[str] = None, **options: Any) -> Optional[str]:
        """Saves them to a file: json, csv, vtu, lcmsim (a zip), or a solver's deck (nastran,
        optistruct, radioss, lsdyna, abaqus, calculix), abd or acp; the format by its name's ending
        unless given, the options as above. For lcmsim: what the binning costs, as the service tells
        it in the header Draped-Binning."""
        return self._save_map(drape, mesh, path, format, options, "drapes")

    def _save_map(self, job: str, mesh: Mesh, path: Union[str, os.PathLike], format: Optional[str],
                  options: Mapping[str, Any], kind: str) -> Optional[str]:
        name = format or os.path.splitext(os.fspath(path))[1].lstrip(".").lower()
        answer = self._open_map(job, mesh, name, options, kind)
        binning = answer.headers.get("Draped-Binning")
        self._write(answer, path)
        return binning


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
