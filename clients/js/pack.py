#!/usr/bin/env python3
"""Packs the client for npm, with the standard library alone: pack.py FOLDER [TYPES]

A package is a compressed tar archive. In it the files stand as in the source tree, so that the modules that the client
shares with the page are found. TYPES is the folder that types.mjs wrote; without it the package has no types. The same
sources give the same bytes."""

from __future__ import annotations

import gzip
import io
import json
import pathlib
import sys
import tarfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SHARED = ("decode", "records", "names")  # of www/js/stream
EARLIEST = 315532800  # 1980: npm's own packages have a constant time too


def files(types: pathlib.Path | None) -> dict[str, bytes]:
    project = json.loads((HERE / "package.json").read_text())
    project["exports"]["."] = {
        kind: f"./clients/js/{path[2:]}" for kind, path in project["exports"]["."].items() if types or kind != "types"
    }
    mine = [*HERE.glob("*.js"), *(ROOT / f"www/js/stream/{name}.js" for name in SHARED)]
    places = {str(path.relative_to(ROOT)): path for path in mine}
    for path in types.glob("**/*.d.ts") if types else ():
        places[f"clients/js/types/{path.relative_to(types)}"] = path
    return {
        "package.json": (json.dumps(project, indent=2) + "\n").encode(),
        "README.md": (HERE / "README.md").read_bytes(),
        "LICENSE": (ROOT / "LICENSE").read_bytes(),
        **{name: places[name].read_bytes() for name in sorted(places)},
    }


def build(folder: pathlib.Path, types: pathlib.Path | None) -> pathlib.Path:
    made = folder / f"laglab-{json.loads((HERE / 'package.json').read_text())['version']}.tgz"
    packed = io.BytesIO()
    with tarfile.open(fileobj=packed, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for name, data in files(types).items():
            entry = tarfile.TarInfo(f"package/{name}")
            entry.size, entry.mode, entry.mtime = len(data), 0o644, EARLIEST
            archive.addfile(entry, io.BytesIO(data))
    made.write_bytes(gzip.compress(packed.getvalue(), mtime=0))
    return made


if __name__ == "__main__":
    target = pathlib.Path(sys.argv[1])
    target.mkdir(parents=True, exist_ok=True)
    print(build(target, pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None))
