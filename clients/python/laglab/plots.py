"""Plots of tables of points, with matplotlib."""

from __future__ import annotations

from typing import Any


def _axes(axes: Any) -> Any:
    if axes is not None:
        return axes
    import matplotlib.pyplot

    return matplotlib.pyplot.subplots(layout="constrained")[1]


def _interval(frame: Any, metric: str) -> Any:
    low, high = f"{metric}.ci95_low", f"{metric}.ci95_high"
    if low not in frame or high not in frame:
        return None
    return [(frame[metric] - frame[low]).clip(lower=0), (frame[high] - frame[metric]).clip(lower=0)]


def against(frame: Any, axis: str, metric: str, *, by: str | None = None, axes: Any = None) -> Any:
    """A metric along a parameter, with 95 % intervals; `by` is a parameter of which each value is a line."""
    axes = _axes(axes)
    groups = [(None, frame)] if by is None else list(frame.groupby(by, sort=False))
    for name, rows in groups:
        rows = rows.sort_values(axis)
        axes.errorbar(rows[axis], rows[metric], yerr=_interval(rows, metric), marker="o", capsize=3, label=name)
    axes.set_xlabel(axis)
    axes.set_ylabel(metric)
    if by is not None:
        axes.legend(title=by)
    return axes


def tradeoff(frame: Any, cost: str, error: str, *, label: str | None = None, axes: Any = None) -> Any:
    """Error against cost, with 95 % intervals, and the front: the points than which no other has less of both."""
    axes = _axes(axes)
    axes.errorbar(
        frame[cost], frame[error], xerr=_interval(frame, cost), yerr=_interval(frame, error), fmt="o", capsize=3
    )
    front = frame.sort_values([cost, error])
    front = front[front[error] < front[error].cummin().shift(fill_value=float("inf"))]
    axes.step(front[cost], front[error], where="post", linestyle="--", color="grey")
    for _, row in frame.iterrows() if label else ():
        axes.annotate(str(row[label]), (row[cost], row[error]), textcoords="offset points", xytext=(5, 5))
    axes.set_xlabel(cost)
    axes.set_ylabel(error)
    return axes
