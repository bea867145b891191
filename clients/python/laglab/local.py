"""Runs and sweeps by the program on this machine."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from typing import Any, Mapping, Sequence

from .errors import LaglabError
from .result import Result
from .specification import Axes, Scenario, named, specification
from .table import table


def _program(program: str | os.PathLike[str] | None) -> str:
    found = os.fspath(program) if program else os.environ.get("LAGLAB_BIN") or shutil.which("laglab")
    if not found:
        raise LaglabError("the program laglab is not found: install it, or name it by program= or the variable LAGLAB_BIN")
    return found


def _call(arguments: list[str], text: str | None = None) -> str:
    done = subprocess.run(arguments, input=text, capture_output=True, text=True, encoding="utf-8", check=False)
    if done.returncode == 0:
        return done.stdout
    sentence = done.stderr.strip().removeprefix("laglab: ") or f"laglab ended with {done.returncode}"
    field, colon, _ = sentence.partition(": ")
    raise LaglabError(sentence, fields={field: sentence} if colon and " " not in field else None)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def run(
    scenario: Scenario,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002: as --set
    seed: int | None = None,
    duration_s: float | None = None,
    metrics: Sequence[str] | None = None,
    program: str | os.PathLike[str] | None = None,
) -> Result:
    """Runs a scenario, an id of the library or a dictionary, at full speed. `metrics` are the only ones that are
    measured then, which is faster. LaglabError has the sentence of a refusal."""
    arguments = [_program(program), "run", scenario if isinstance(scenario, str) else "-"]
    for path, value in (set or {}).items():
        arguments += ["--set", f"{path}={_text(value)}"]
    if seed is not None:
        arguments += ["--seed", str(seed)]
    if duration_s is not None:
        arguments += ["--duration", repr(duration_s)]
    if metrics:
        arguments += ["--metrics", ",".join(metrics)]
    return Result(json.loads(_call(arguments, None if isinstance(scenario, str) else json.dumps(scenario))))


def sweep(
    scenario: Scenario | None = None,
    *,
    axes: Axes | None = None,
    metrics: Sequence[str] | None = None,
    repeats: int | None = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002: the experiment's own word
    points: bool = False,
    compare: str | None = None,
    jobs: int | None = None,
    program: str | os.PathLike[str] | None = None,
    **more: Any,
) -> Any:
    """Runs an experiment: a DataFrame (without pandas a Table) with a row for each run, or with `points` for each
    point, with means and 95 % intervals. The arguments are those of `specification`; `laglab.sweep(experiment=ID)`
    runs one of the library, and a file."""
    given = more.pop("experiment", None)
    if given is None:
        given = specification(scenario, axes=axes, metrics=metrics, repeats=repeats, set=set, **more)
    elif scenario is not None or axes is not None or metrics is not None or repeats is not None or set is not None or more:
        raise TypeError("sweep: an experiment of its own takes no scenario, axes, metrics, repeats, set or other members")
    is_name = isinstance(given, (str, os.PathLike))
    arguments = [_program(program), "sweep", os.fspath(given) if is_name else "-", "--format", "json"]
    if points:
        arguments.append("--points")
    if compare is not None:
        arguments += ["--compare", compare]
    if jobs is not None:
        arguments += ["--jobs", str(jobs)]
    return table(json.loads(_call(arguments, None if is_name else json.dumps(given))), named(axes))


def scenarios(*, program: str | os.PathLike[str] | None = None) -> list[str]:
    """The ids of the library."""
    return [line.split()[0] for line in _call([_program(program), "scenarios"]).splitlines() if line.strip()]

