"""Rows as a table: a DataFrame where pandas is installed."""

from __future__ import annotations

from typing import Any, Iterable, Mapping

from .specification import Settings


class Table(list):
    """Rows as dictionaries, where pandas is not installed."""

    @property
    def columns(self) -> list[str]:
        return list(self[0]) if self else []

    def column(self, name: str) -> list[Any]:
        return [row[name] for row in self]


def _with_names(row: dict[str, Any], named: Mapping[str, Settings]) -> dict[str, Any]:
    """The row with a column for each named axis, before the first of its paths."""
    found = {
        next(iter(next(iter(settings.values())))): (
            name,
            next((one for one, values in settings.items() if all(row.get(path) == value for path, value in values.items())), None),
        )
        for name, settings in named.items()
    }
    made: dict[str, Any] = {}
    for column, value in row.items():
        if column in found:
            name, setting = found[column]
            made[name] = setting
        made[column] = value
    return made


def table(rows: Iterable[dict[str, Any]], named: Mapping[str, Settings] | None = None) -> Any:
    """A DataFrame, or a Table without pandas. A metric that was not counted is NaN, or None in a Table. Settings
    that were `named` have a column."""
    listed = [_with_names(row, named) for row in rows] if named else list(rows)
    try:
        import pandas
    except ImportError:
        return Table(listed)
    frame = pandas.DataFrame(listed)
    for name in frame.columns:  # a column of numbers with gaps is one of numbers
        if frame[name].dtype == object and frame[name].map(lambda x: x is None or isinstance(x, (int, float)) and not isinstance(x, bool)).all():
            frame[name] = pandas.to_numeric(frame[name])
    return frame
