#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the bill of materials of the two programs, CycloneDX 1.5 as JSON, on standard output.

What they load comes from ldd and dpkg: the package of each shared library with its version, its
source and the licences that its copyright file names; so do the archives that are linked in. Packages of npm come from the lock files;
those of tests/ are excluded from what runs, and those of clients/ are of other programs. Usage: deploy/sbom.py VERSION PROGRAM...
"""
import hashlib
import json
import os
import re
import subprocess
import sys

FIELDS = "${Package}\t${Version}\t${Architecture}\t${source:Package}\t${source:Version}"
# As in the Makefile: HDF5_LIBS.
ARCHIVES = ["libhdf5_serial.a", "libsz.a", "libaec.a"]
HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def said(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def libraries(programs):
    """Files that the loader maps, their symbolic links followed."""
    found = set()
    for program in programs:
        for path in re.findall(r"(/\S+) \(0x", said("ldd", program)):
            found.add(os.path.realpath(path))
    return sorted(found)


def archives():
    """Those in the compiler's folders, their symbolic links followed."""
    return [os.path.realpath(said("gcc", f"-print-file-name={name}").strip()) for name in ARCHIVES]


def package_of(library):
    """dpkg knows a file by the name it was installed under: with or without /usr."""
    for name in (library, library.removeprefix("/usr")):
        answer = subprocess.run(["dpkg", "-S", name], capture_output=True, text=True)
        if answer.returncode == 0:
            return answer.stdout.split(": ")[0].split(",")[0]
    raise SystemExit(f"{sys.argv[0]}: {library} belongs to no package")


def licences(package):
    """Names in a machine-readable copyright file; none where it is prose."""
    path = f"/usr/share/doc/{package.split(':')[0]}/copyright"
    with open(path, encoding="utf-8", errors="replace") as file:
        text = file.read()
    if "copyright-format/1" not in text:
        return []
    names = re.findall(r"^License:[ \t]*(\S.*)$", text, re.MULTILINE)
    return [{"license": {"name": name.strip()}} for name in sorted(set(names))]


def debian_component(package, files):
    name, version, architecture, source, source_version = said(
        "dpkg-query", "-W", "-f", FIELDS, package).split("\t")
    quoted = version.replace("+", "%2B").replace(":", "%3A").replace("~", "~")
    purl = f"pkg:deb/debian/{name}@{quoted}?arch={architecture}&distro=debian-12"
    return {
        "type": "library", "bom-ref": purl, "name": name, "version": version, "purl": purl,
        "scope": "required", "licenses": licences(package),
        "properties": [{"name": "debian:source", "value": f"{source} {source_version}"}]
        + [{"name": "file", "value": file} for file in files],
    }


def npm_components(lock):
    scope = "excluded" if os.path.relpath(lock, HERE).startswith("tests/") else "required"
    with open(lock, encoding="utf-8") as file:
        packages = json.load(file)["packages"]
    for path, package in packages.items():
        if not path:
            continue
        name = path.split("node_modules/")[-1]
        purl = f"pkg:npm/{name.replace('@', '%40')}@{package['version']}"
        component = {"type": "library", "bom-ref": purl, "name": name,
                     "version": package["version"], "purl": purl, "scope": scope}
        if "license" in package:
            component["licenses"] = [{"expression": package["license"]}]
        yield component


def lock_files():
    for folder, folders, files in os.walk(HERE):
        folders[:] = sorted(name for name in folders
                            if name not in (".git", "node_modules", "clients") and not name.startswith("build"))
        if "package-lock.json" in files:
            yield os.path.join(folder, "package-lock.json")


def program_component(program):
    with open(program, "rb") as file:
        digest = hashlib.sha256(file.read()).hexdigest()
    return {"type": "file", "bom-ref": os.path.basename(program), "scope": "required",
            "name": os.path.basename(program), "hashes": [{"alg": "SHA-256", "content": digest}]}


def main():
    version, programs = sys.argv[1], sys.argv[2:]
    files = {}
    for library in libraries(programs) + archives():
        files.setdefault(package_of(library), []).append(library)
    debian = [debian_component(package, files[package]) for package in sorted(files)]
    npm = {each["bom-ref"]: each for lock in lock_files() for each in npm_components(lock)}
    own = [program_component(program) for program in programs]
    root = f"pkg:generic/draped@{version}"
    needed = [each["bom-ref"] for each in own + debian + list(npm.values())
              if each["scope"] == "required"]
    json.dump({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {"component": {"type": "application", "bom-ref": root, "name": "draped",
                                   "version": version, "purl": root,
                                   "licenses": [{"license": {"id": "MIT"}}]}},
        "components": own + debian + list(npm.values()),
        "dependencies": [{"ref": root, "dependsOn": needed}],
    }, sys.stdout, indent=1)
    print()


main()
