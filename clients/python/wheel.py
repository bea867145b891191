#!/usr/bin/env python3
"""Builds the wheel of the package, with the standard library alone: wheel.py FOLDER

A wheel of plain Python is a zip archive of the package and of three files about it (PEP 427). The same sources give
the same bytes."""

from __future__ import annotations

import base64
import hashlib
import pathlib
import re
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
EARLIEST = (1980, 1, 1, 0, 0, 0)  # that a zip archive can state


def metadata(version: str) -> str:
    project = (HERE / "pyproject.toml").read_text()
    summary = re.search(r'^description = "(.*)"$', project, re.M)[1]
    python = re.search(r'^requires-python = "(.*)"$', project, re.M)[1]
    extras = re.findall(r'^(\w+) = \["(\w+)"\]$', project.partition("[project.optional-dependencies]")[2].partition("\n[")[0], re.M)
    lines = ["Metadata-Version: 2.1", "Name: laglab", f"Version: {version}", f"Summary: {summary}", "License: MIT", f"Requires-Python: {python}"]
    for extra, needs in extras:
        lines += [f"Provides-Extra: {extra}", f'Requires-Dist: {needs} ; extra == "{extra}"']
    return "\n".join([*lines, "Description-Content-Type: text/markdown", "", (HERE / "README.md").read_text()])


def record_line(name: str, data: bytes) -> str:
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}"


def build(folder: pathlib.Path) -> pathlib.Path:
    version = re.search(r'^__version__ = "(.*)"$', (HERE / "laglab/__init__.py").read_text(), re.M)[1]
    about = f"laglab-{version}.dist-info"
    files = {f"laglab/{path.name}": path.read_bytes() for path in sorted((HERE / "laglab").iterdir()) if path.suffix in (".py", ".typed")}
    files[f"{about}/METADATA"] = metadata(version).encode()
    files[f"{about}/WHEEL"] = b"Wheel-Version: 1.0\nGenerator: laglab\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    record = [record_line(name, data) for name, data in files.items()] + [f"{about}/RECORD,,"]
    files[f"{about}/RECORD"] = ("\n".join(record) + "\n").encode()
    made = folder / f"laglab-{version}-py3-none-any.whl"
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, EARLIEST)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data)
    return made


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    target.mkdir(parents=True, exist_ok=True)
    print(build(target))
