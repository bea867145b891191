"""Rows as a table: a DataFrame where pandas is installed."""

from __future__ import annotations

from typing import Any, Iterable


class Table(list):
    """Rows as dictionaries, where pandas is not installed."""

    @property
    def columns(self) -> list[str]:
        return list(self[0]) if self else []

    def column(self, name: str) -> list[Any]:
        return [row[name] for row in self]


def table(rows: Iterable[dict[str, Any]]) -> Any:
    """A DataFrame, or a Table without pandas. A metric that was not counted is NaN, or None in a Table."""
    listed = list(rows)
    try:
        import pandas
    except ImportError:
        return Table(listed)
    frame = pandas.DataFrame(listed)
    for name in frame.columns:  # a column of numbers with gaps is one of numbers
        if frame[name].dtype == object and frame[name].map(lambda x: x is None or isinstance(x, (int, float)) and not isinstance(x, bool)).all():
            frame[name] = pandas.to_numeric(frame[name])
    return frame
