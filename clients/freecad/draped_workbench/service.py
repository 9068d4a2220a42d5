# SPDX-License-Identifier: MIT
"""Who drapes: the program `drape` on this machine, or a daemon. Both take a request and a part as STEP, and give
the result as JSON has it, within a time limit; what does not succeed is a `Failure` that says what to do."""
from __future__ import annotations

import json
import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Mapping, Protocol

import draped

Json = dict[str, Any]


class Failure(Exception):
    """`reason` is a word for programs (the service's slug, or no-program, time-limit, other-version, unreachable,
    drape-failed, other-faces), the text a sentence with the remedy."""

    def __init__(self, reason: str, text: str) -> None:
        super().__init__(text)
        self.reason = reason


class Service(Protocol):
    def drape(self, request: Mapping[str, Any], part: str, chosen: Mapping[str, Any]) -> tuple[Json, str]:
        """The result of a request without `surface`, which is the file `part` with the keys `chosen` (faces, or
        grow_from and up_to_deg); and its flat pattern as SVG."""


class Program:
    """The command `drape`, which needs `drape-import` beside it."""

    def __init__(self, program: str = "drape", limit: float = 60) -> None:
        self.program, self.limit = program, limit

    def drape(self, request: Mapping[str, Any], part: str, chosen: Mapping[str, Any]) -> tuple[Json, str]:
        said = self._run(["--version"], "")[0].partition("\n")[0]
        if _series(said) != _series(f"drape {draped.__version__}"):
            raise Failure("other-version", f"{self.program} is {said or 'no drape'}, this workbench is for drape "
                          f"{draped.__version__}: install the same version of both.")
        text = json.dumps({**request, "surface": {"file": part, **chosen}})
        result, pattern = self._run(["-"], text, ["--format", "svg", "-"])
        return json.loads(result), pattern

    def _run(self, words: list[str], text: str, *others: list[str]) -> list[str]:
        """What the program says with each of these words and the same input, run beside each other."""
        runs = []
        try:
            for each in (words, *others):
                runs.append(subprocess.Popen([self.program, *each], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                             stderr=subprocess.PIPE, text=True))
            with ThreadPoolExecutor(len(runs)) as pool:
                said = list(pool.map(lambda run: run.communicate(text, self.limit), runs))
        except (FileNotFoundError, PermissionError) as error:
            raise Failure("no-program", f"There is no program {self.program}: install draped, give the program's path "
                          "in the preferences, or the address of a daemon.") from error
        except subprocess.TimeoutExpired as error:
            raise Failure("time-limit", f"{self.program} has not ended within {self.limit:g} s: choose a larger "
                          "spacing, fewer faces or a longer limit.") from error
        finally:
            for run in runs:
                if run.poll() is None:
                    run.kill()
                    run.wait()
        for run, (_, errors) in zip(runs, said):
            if run.returncode != 0:
                raise _failure(errors)
        return [answer for answer, _ in said]


class Daemon:
    """A daemon at an address; parts and drapes stay there as long as it keeps them."""

    def __init__(self, url: str, token: str = "", limit: float = 60) -> None:
        self.client = draped.Client(url, token or None, limit)
        self.limit = limit

    def drape(self, request: Mapping[str, Any], part: str, chosen: Mapping[str, Any]) -> tuple[Json, str]:
        try:
            self.client.version()
            stored = self.client.upload(part)
            drape = self.client.submit({**request, "surface": {"id": stored["id"], **chosen}})
            self.client.wait(drape, self.limit, lambda status: None)
            with tempfile.TemporaryDirectory() as folder:
                path = os.path.join(folder, "pattern.svg")
                self.client.save(drape, path)
                with open(path, encoding="utf-8") as file:
                    return self.client.result(drape), file.read()
        except draped.WaitTimeout as error:
            raise Failure("time-limit", f"{error}: choose a larger spacing, fewer faces or a longer limit.") from error
        except draped.DrapedError as error:
            raise Failure(error.slug, str(error)) from error


def service(address: str, program: str = "drape", token: str = "", limit: float = 60) -> Service:
    """A daemon at `address`; without one the program."""
    return Daemon(address, token, limit) if address else Program(os.path.expanduser(program), limit)


def _series(version: str) -> list[str]:
    return version.split(".")[:2]


def _failure(errors: str) -> Failure:
    """By what the programs say on standard error, without what they say of parts that are right."""
    lines = errors.strip().splitlines()
    wrong = [line for line in lines if not line.startswith(("drape-import: ", "drape: warning: "))]
    problem = next((line for line in wrong if line.startswith("drape: ")), "")
    slug = problem[len("drape: "):].partition(":")[0] or "drape-failed"
    return Failure(slug, "\n".join(wrong or lines) or "drape failed without a word.")
