"""Live sessions and experiments on a daemon, over its HTTP API."""

from __future__ import annotations

import json
import os
import pathlib
import time
from types import TracebackType
from typing import Any, Callable, Iterator, Mapping, Sequence
from urllib.error import HTTPError, URLError
from urllib.parse import quote, urlencode
from urllib.request import Request, urlopen

from .errors import LaglabError
from .result import value_at
from .specification import Axes, Scenario, Settings, named, specification
from .table import table
from .websocket import WebSocket

_JSON = "application/json"


def _refusal(error: HTTPError) -> LaglabError:
    try:
        problem = json.loads(error.read())
        sentence = problem["detail"]
        fields = {one["field"]: one["detail"] for one in problem.get("errors", [])}
    except (ValueError, KeyError, TypeError):
        sentence, fields = f"the daemon answers {error.code} {error.reason}", {}
    wait = error.headers.get("Retry-After")
    return LaglabError(
        sentence, status=error.code, fields=fields, retry_after_s=float(wait) if wait and wait.isdecimal() else None
    )


class Daemon:
    """A daemon at `url`. `key` is its class key or operator's key, where creation needs one."""

    def __init__(self, url: str = "http://127.0.0.1:8080", *, key: str | None = None, timeout_s: float = 60) -> None:
        self.url = url.rstrip("/")
        self._key = key
        self._timeout_s = timeout_s

    def request(
        self,
        method: str,
        path: str,
        body: Any = None,
        *,
        key: str | None = None,
        query: Mapping[str, Any] | None = None,
        accept: str = _JSON,
    ) -> bytes:
        """Any operation of the API: docs/api.md. LaglabError has the daemon's sentence."""
        asked = {name: json.dumps(value) if isinstance(value, bool) else value for name, value in (query or {}).items() if value is not None}
        headers = {"Accept": accept}
        if body is not None:
            headers["Content-Type"] = _JSON
        if key or self._key:
            headers["Authorization"] = f"Bearer {key or self._key}"
        address = f"{self.url}/api/v1/{path}" + (f"?{urlencode(asked)}" if asked else "")
        data = None if body is None else json.dumps(body).encode()
        try:
            with urlopen(Request(address, data, headers, method=method), timeout=self._timeout_s) as answer:
                return answer.read()
        except HTTPError as error:
            raise _refusal(error) from None
        except URLError as error:
            raise LaglabError(f"no daemon answers at {self.url}: {error.reason}") from None

    def json(self, method: str, path: str, body: Any = None, **more: Any) -> Any:
        answer = self.request(method, path, body, **more)
        return json.loads(answer) if answer else None

    def scenarios(self) -> list[dict[str, Any]]:
        """The library: of each scenario its id, kind and title."""
        return self.json("GET", "scenarios", query={"brief": True})["scenarios"]

    def scenario(self, name: str) -> dict[str, Any]:
        """A scenario of the library, to be changed and run."""
        return self.json("GET", f"scenarios/{quote(name)}")

    def session(
        self,
        scenario: Scenario,
        *,
        set: Mapping[str, Any] | None = None,  # noqa: A002: the API's own word
        seed: int | None = None,
        playing: bool = False,
        speed: float | None = None,
    ) -> "Session":
        """Creates a session. It is paused at tick 0 unless `playing`, so that a program decides when it moves."""
        wish: dict[str, Any] = {"scenario": scenario, "paused": not playing}
        for name, value in (("set", dict(set) if set else None), ("seed", seed), ("speed", speed)):
            if value is not None:
                wish[name] = value
        made = self.json("POST", "sessions", wish)
        return Session(self, made["id"], made["owner_key"], code=made["code"], player_keys=made["player_keys"])

    def attach(self, session: str, key: str | None = None) -> "Session":
        """An existing session by its id; without its key it can only be watched."""
        self.json("GET", f"sessions/{session}")
        return Session(self, session, key)

    def experiment(
        self,
        scenario: Scenario | None = None,
        *,
        axes: Axes | None = None,
        metrics: Sequence[str] | None = None,
        repeats: int | None = None,
        set: Mapping[str, Any] | None = None,  # noqa: A002: the experiment's own word
        experiment: Mapping[str, Any] | None = None,
        **more: Any,
    ) -> "Experiment":
        """Starts an experiment. Its arguments are those of `laglab.specification`, or `experiment` is a whole one."""
        order = experiment or specification(scenario, axes=axes, metrics=metrics, repeats=repeats, set=set, **more)
        made = self.json("POST", "experiments", order)
        return Experiment(self, made["id"], made["owner_key"], named=named(axes) if experiment is None else None)

    def __repr__(self) -> str:
        return f"<laglab.Daemon {self.url}>"


def connect(url: str = "http://127.0.0.1:8080", *, key: str | None = None, timeout_s: float = 60) -> Daemon:
    """The daemon at `url`. LaglabError: none answers there."""
    daemon = Daemon(url, key=key, timeout_s=timeout_s)
    daemon.json("GET", "creation")
    return daemon


class Session:
    """A session of a daemon. As a context it is deleted at the end."""

    def __init__(
        self, daemon: Daemon, id: str, key: str | None, *, code: str | None = None, player_keys: Sequence[str] = ()
    ) -> None:
        self.daemon, self.id, self.key, self.code = daemon, id, key, code
        self.player_keys = list(player_keys)

    def _json(self, method: str, path: str, body: Any = None, **more: Any) -> Any:
        return self.daemon.json(method, f"sessions/{self.id}{path}", body, key=self.key, **more)

    def info(self) -> dict[str, Any]:
        """Its state of play, parameters and cost."""
        return self._json("GET", "")

    def control(self, op: str, **more: Any) -> dict[str, Any]:
        """`play`, `pause`, `step`, `seek`, `speed` or `restart`; the answer has the position."""
        return self._json("POST", "/control", {"op": op, **more})

    def play(self, speed: float | None = None) -> dict[str, Any]:
        if speed is not None:
            self.control("speed", speed=speed)
        return self.control("play")

    def pause(self) -> dict[str, Any]:
        return self.control("pause")

    def step(self, ticks: int = 1) -> dict[str, Any]:
        """Moves by ticks, back with a negative number, and pauses there."""
        return self.control("step", ticks=ticks)

    def seek(self, time_s: float) -> dict[str, Any]:
        return self.control("seek", time_s=time_s)

    def restart(self, *, reset: bool = False) -> dict[str, Any]:
        return self.control("restart", reset=reset)

    def set(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Changes live parameters by their paths, all or nothing."""
        return self._json("PATCH", "/params", dict(values))

    def input(self, player: int, axes: Sequence[float] = (0, 0), buttons: int = 0) -> dict[str, Any]:
        """A person's controls, held until the next call; the player's `control` must be `person`."""
        return self._json("POST", "/input", {"player": player, "axes": list(axes), "buttons": buttons})

    def state(self, tick: int | None = None) -> dict[str, Any]:
        """The whole simulated state, now or at an earlier tick."""
        return self._json("GET", "/state", query={"tick": tick})

    def metrics(self) -> dict[str, Any]:
        """The metrics from tick 0 to now."""
        return self._json("GET", "/metrics")["metrics"]

    def metric(self, path: str) -> Any:
        """One of them, such as `players.0.remote_error_m.mean`."""
        return value_at(self.metrics(), path)

    def trace(self, of: str = "ticks", *, from_s: float | None = None, to_s: float | None = None) -> Any:
        """What happened, from tick 0 to now, as a DataFrame, without pandas a Table: a row for each tick. Of `entities`,
        or another record of the stream, the rows at every tick; of `packets`, `corrections` or `events` each once."""
        return table(self._json("GET", "/trace", query={"of": of, "from_s": from_s, "to_s": to_s}))

    def trace_file(
        self, path: str | os.PathLike[str], of: str = "ticks", *, from_s: float | None = None, to_s: float | None = None
    ) -> pathlib.Path:
        """The same as a file, whose format is its ending: csv, ndjson, json or sqlite."""
        target = pathlib.Path(path)
        query = {"of": of, "from_s": from_s, "to_s": to_s, "format": target.suffix[1:]}
        target.write_bytes(self.daemon.request("GET", f"sessions/{self.id}/trace", key=self.key, query=query, accept="*/*"))
        return target

    def log(self) -> str:
        """The log, which `laglab replay` runs again."""
        return self.daemon.request("GET", f"sessions/{self.id}/log", key=self.key, accept="*/*").decode()

    def fork(self, **more: Any) -> "Session":
        """A separate session from the log up to now."""
        made = self._json("POST", "/fork", more)
        return Session(self.daemon, made["id"], made["owner_key"], code=made.get("code"), player_keys=made.get("player_keys", ()))

    def stream(self, *, timeout_s: float = 60, **channels: float) -> Iterator[dict[str, Any]]:
        """Frames while they come, as dictionaries: `for frame in session.stream(scene=30): ...`. Channels and their
        rates in Hz are those of api/asyncapi.yaml; by default the drawn ones at 10 Hz. Each frame is acknowledged when
        the next one is asked for, so that a slow program skips frames instead of falling behind. Ends with the
        session; `break` ends it earlier. LaglabError: the daemon has ended it for another reason."""
        socket = WebSocket(f"{self.daemon.url}/api/v1/sessions/{self.id}/stream", "laglab.v2.json", timeout_s)
        try:
            if channels:
                socket.send(json.dumps({"subscribe": channels}))
            while (text := socket.receive()) is not None:
                message = json.loads(text)
                if message["type"] == "frame":
                    yield message
                    socket.send(json.dumps({"ack": message["seq"]}))
                elif message["type"] == "error":
                    raise LaglabError(message["problem"]["detail"], status=message["problem"]["status"])
            if socket.close_code not in (1000, 1001, 4404):
                raise LaglabError(f"the stream has ended: {socket.close_reason or socket.close_code}")
        finally:
            socket.close()

    def delete(self) -> None:
        self._json("DELETE", "")

    def __enter__(self) -> "Session":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        try:
            self.delete()
        except LaglabError:
            if error is None:
                raise

    def __repr__(self) -> str:
        return f"<laglab.Session {self.id} at {self.daemon.url}>"


class Experiment:
    """An experiment on a daemon. It goes on when this program ends, unless it is deleted."""

    def __init__(self, daemon: Daemon, id: str, key: str | None = None, *, named: Mapping[str, Settings] | None = None) -> None:
        self.daemon, self.id, self.key, self._named = daemon, id, key, named

    def info(self) -> dict[str, Any]:
        """Its specification, state, and how many runs are done."""
        return self.daemon.json("GET", f"experiments/{self.id}")

    def control(self, op: str) -> Any:
        """`pause`, `resume` or `cancel`."""
        return self.daemon.json("POST", f"experiments/{self.id}/control", {"op": op}, key=self.key)

    def wait(self, progress: Callable[[dict[str, Any]], None] | None = None, *, timeout_s: float | None = None) -> "Experiment":
        """Returns when it is done. `progress` gets each message of its stream: runs, done, left_s. LaglabError: it has
        failed or was cancelled. TimeoutError: after `timeout_s` it is not done; it goes on."""
        end = None if timeout_s is None else time.monotonic() + timeout_s
        left = 60.0 if end is None else min(60.0, timeout_s or 0.001)
        socket = WebSocket(f"{self.daemon.url}/api/v1/experiments/{self.id}/stream", "laglab.v2.json", left)
        try:
            while (text := socket.receive()) is not None:
                message = json.loads(text)
                if progress is not None and message["type"] in ("hello", "progress"):
                    progress(message)
                if end is not None and time.monotonic() > end:
                    raise TimeoutError(f"the experiment is not done after {timeout_s} s")
        finally:
            socket.close()
        state = self.info()["state"]
        if state != "done":
            raise LaglabError(f"the experiment is {state}")
        return self

    def table(self, *, points: bool = False, compare: str | None = None, sensitivity: bool = False) -> Any:
        """The present rows: a DataFrame, without pandas a Table. With `points` means and 95 % intervals."""
        query = {"format": "json", "points": points or None, "compare": compare, "sensitivity": sensitivity or None}
        return table(self.daemon.json("GET", f"experiments/{self.id}/results", query=query), self._named)

    def report(self) -> str:
        """A standalone page with plots and tables."""
        return self.daemon.request("GET", f"experiments/{self.id}/report", accept="text/html").decode()

    def open(self, run: int) -> Session:
        """One run as a live session, paused at its start."""
        return self.daemon.session(self.daemon.json("GET", f"experiments/{self.id}/runs/{run}"))

    def delete(self) -> None:
        self.daemon.json("DELETE", f"experiments/{self.id}", key=self.key)

    def __repr__(self) -> str:
        return f"<laglab.Experiment {self.id} at {self.daemon.url}>"
