"""laglab from Python: runs and sweeps on this machine, live sessions and experiments on a daemon.

    import laglab

    result = laglab.run("race", duration_s=10, set={"players.0.lag_ms": 200})
    result["players.0.remote_error_m.mean"]

    frame = laglab.sweep("race", axes={"players.0.lag_ms": [0, 100, 200]}, repeats=10,
                         metrics=["players.0.remote_error_m.mean"])

    lab = laglab.connect("http://127.0.0.1:8080")
    with lab.session("race") as session:
        session.step(60)
        session.metrics()["players"][0]["remote_error_m"]["mean"]

Only the standard library is needed. Tables are DataFrames where pandas is installed, and plots need matplotlib.
"""

from .daemon import Daemon, Experiment, Session, connect
from .errors import LaglabError
from .local import run, scenarios, sweep
from .result import Result
from .specification import specification
from .table import Table

__version__ = "0.2.0"

__all__ = [
    "Daemon",
    "Experiment",
    "LaglabError",
    "Result",
    "Session",
    "Table",
    "connect",
    "run",
    "scenarios",
    "specification",
    "sweep",
]
