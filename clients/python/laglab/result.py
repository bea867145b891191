"""The result of one run."""

from __future__ import annotations

from typing import Any, Iterator, Mapping


def _parts(at: Any) -> str:
    if isinstance(at, Mapping):
        return ", ".join(at)
    return f"{len(at)} elements" if isinstance(at, list) else "no parts"


def value_at(tree: Any, path: str) -> Any:
    """The value at a dotted path, such as `players.0.remote_error_m.mean`. KeyError: there is none; the error
    names the first part that is missing and what is there instead."""
    if isinstance(tree, Mapping) and path in tree:  # of a run that measured only some
        return tree[path]
    at = tree
    for depth, part in enumerate(path.split(".")):
        if isinstance(at, list) and part.isdecimal() and int(part) < len(at):
            at = at[int(part)]
        elif isinstance(at, Mapping) and part in at:
            at = at[part]
        else:
            before = ".".join(path.split(".")[:depth]) or "the whole"
            raise KeyError(f"{path}: {before} has {_parts(at)}")
    return at


def leaves(tree: Any, before: str = "") -> Iterator[tuple[str, Any]]:
    """Every value of a tree with its dotted path."""
    if isinstance(tree, Mapping):
        pairs: Any = tree.items()
    elif isinstance(tree, list):
        pairs = enumerate(tree)
    else:
        yield before, tree
        return
    for name, value in pairs:
        yield from leaves(value, f"{before}.{name}" if before else str(name))


class Result(Mapping[str, Any]):
    """What `laglab run` prints. `metrics` is the tree of all metrics; `result[PATH]` is one of them. A metric that
    was not counted in the run is None. `hash` is that of the whole simulated state at the end: equal scenario, seed
    and inputs give equal hashes on every machine."""

    def __init__(self, report: dict[str, Any]) -> None:
        self.report = report
        self.metrics: dict[str, Any] = report["metrics"]
        self.hash: str = report["hash"]
        self.seed: int = report["seed"]
        self.duration_s: float = report["duration_s"]

    def __getitem__(self, path: str) -> Any:
        return value_at(self.metrics, path)

    def __iter__(self) -> Iterator[str]:
        return (path for path, _ in leaves(self.metrics))

    def __len__(self) -> int:
        return sum(1 for _ in leaves(self.metrics))

    def __repr__(self) -> str:
        return f"<laglab.Result {self.report.get('scenario')}, seed {self.seed}, {self.duration_s} s, hash {self.hash}>"
