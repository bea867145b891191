"""Experiments as arguments."""

from __future__ import annotations

from typing import Any, Mapping, Sequence, Union

Scenario = Union[str, Mapping[str, Any]]
Settings = Mapping[str, Mapping[str, Any]]
Axes = Union[Mapping[Any, Union[Sequence[Any], Settings]], Sequence[Mapping[str, Any]]]


def _named(name: str, settings: Settings) -> dict[str, Any]:
    """An axis of settings that have names. Each gives values to the same paths, and no two are equal."""
    given = list(settings.values())
    paths = list(given[0]) if given else []
    if not paths or any(set(one) != set(paths) for one in given):
        raise ValueError(f"axes: each setting of {name} must have values for the same paths")
    if any(dict(one) == dict(other) for i, one in enumerate(given) for other in given[:i]):
        raise ValueError(f"axes: two settings of {name} are equal")
    return {"zip": [{"path": path, "values": [one[path] for one in given]} for path in paths]}


def named(axes: Axes | None) -> dict[str, Settings]:
    """Those of the axes whose values are settings with names."""
    return {name: given for name, given in axes.items() if isinstance(given, Mapping)} if isinstance(axes, Mapping) else {}


def _axis(path: Any, values: Any) -> dict[str, Any]:
    if isinstance(values, Mapping):
        return _named(path, values)
    if isinstance(path, tuple):
        columns = list(zip(*values))
        if any(len(row) != len(path) for row in values):
            raise ValueError(f"axes: each value of {path} must have {len(path)} parts")
        return {"zip": [{"path": one, "values": list(column)} for one, column in zip(path, columns)]}
    return {"path": path, "values": list(values)}


def specification(
    scenario: Scenario | None = None,
    *,
    axes: Axes | None = None,
    metrics: Sequence[str] | None = None,
    repeats: int | None = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002: the experiment's own word
    **more: Any,
) -> dict[str, Any]:
    """An experiment as laglab reads it. `axes` maps paths to values; a tuple of paths to tuples of values varies them
    together: {("players.0.prediction", "players.0.reconciliation"): [(False, False), (True, True)]}. A name maps to
    settings with names, {"technique": {"none": {"players.0.prediction": False}, ...}}: tables then have a column of
    that name. A list is taken as in the experiment's format. Other members of an experiment (`sample`, `until`, `stop`,
    `front`, `title`, ...) are given by their names."""
    made: dict[str, Any] = {} if scenario is None else {"scenario": scenario}
    if axes is not None:
        made["axes"] = [_axis(path, values) for path, values in axes.items()] if isinstance(axes, Mapping) else list(axes)
    for name, value in (("metrics", metrics), ("repeats", repeats), ("set", set)):
        if value is not None:
            made[name] = list(value) if name == "metrics" else dict(value) if name == "set" else value
    return {**made, **more}
