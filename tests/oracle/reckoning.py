"""Dead reckoning with send thresholds: docs/netgame.md, "Dead reckoning"."""

import math
from dataclasses import dataclass

from draws import SECOND
from encoding import exact, message, words
from metrics import Distribution

POSE, ZERO = range(3), (0.0, 0.0, 0.0)


@dataclass
class Told:
    """A state of an entity as it was sent."""
    pose: tuple  # x, y, angle
    rate: tuple
    acceleration: tuple  # of x and y
    flags: int
    time: int  # of its step


# ---- models: the pose and its rate so many seconds after the state's step ----


def static(told, _s):
    return told.pose, ZERO


def velocity(told, s):
    (x, y, angle), (vx, vy, _) = told.pose, told.rate
    return (x + vx * s, y + vy * s, angle), (vx, vy, 0.0)


def velocity_spin(told, s):
    pose, (vx, vy, _) = velocity(told, s)
    return (*pose[:2], pose[2] + told.rate[2] * s), (vx, vy, told.rate[2])


def acceleration(told, s):
    (x, y, angle), (vx, vy, spin), (ax, ay) = told.pose, told.rate, told.acceleration
    return (x + (vx + ax * s / 2) * s, y + (vy + ay * s / 2) * s, angle + spin * s), (vx + ax * s, vy + ay * s, spin)


MODELS = {"static": static, "velocity": velocity, "velocity_spin": velocity_spin, "acceleration": acceleration}


# ---- convergence: a deviation and its rate after t of tau seconds ----


def snap(_e, _u, _t, _tau):
    return 0.0, 0.0


def linear(e, _u, t, tau):
    return e * (1 - t / tau), -e / tau


def cubic(e, u, t, tau):
    s = t / tau
    r = 1 - s
    return e * r * r * (1 + 2 * s) + u * tau * s * r * r, -6 * e * s * r / tau + u * r * (1 - 3 * s)


def projective(e, u, t, tau):
    r = 1 - t / tau
    return r * (e + r * u * t), -(e + r * u * t) / tau + r * (u * (1 - 2 * t / tau))


CONVERGENCE = {"snap": snap, "linear": linear, "cubic": cubic, "projective": projective}


class Copy:
    """An entity as one client has it."""

    def __init__(self, told, at):
        self.told, self.at = told, at
        self.error = self.rate = ZERO

    def model(self, row, time):
        return MODELS[row["model"]](self.told, (time - self.told.time) / SECOND)

    def drawn(self, row, time):
        """Pose and rate at a time of the server's clock."""
        pose, rate = self.model(row, time)
        t, tau = (time - self.at) / SECOND, row["tau_s"]
        if not 0 <= t / tau < 1:
            return pose, rate
        off = [CONVERGENCE[row["convergence"]](e, u, t, tau) for e, u in zip(self.error, self.rate)]
        return tuple(pose[k] + off[k][0] for k in POSE), tuple(rate[k] + off[k][1] for k in POSE)

    def take(self, row, told, time):
        before, before_rate = self.drawn(row, time)
        same = told.flags == self.told.flags
        self.told, self.at = told, time
        pose, rate = self.model(row, time)
        self.error = tuple(before[k] - pose[k] for k in POSE) if same else ZERO
        self.rate = tuple(before_rate[k] - rate[k] for k in POSE) if same else ZERO


class Others:
    """What a client knows of all."""

    def __init__(self, sim):
        self.sim, self.row, self.copies = sim, sim.scenario["reckoning"], {}

    def take(self, time, state):
        """The world of a snapshot as the client has it, at the snapshot's step."""
        for i, told in state.told.items():
            if i in self.copies:
                self.copies[i].take(self.row, told, time)
            else:
                self.copies[i] = Copy(told, time)
        world = [list(one) for one in state.world]
        for i, copy in self.copies.items():
            pose, rate = copy.model(self.row, state.time)
            world[i] = self.sim.game.moved(world[i], pose, rate)
        return world

    def places(self, world, time):
        return [self.copies[i].drawn(self.row, time)[0][:2] if i in self.copies else tuple(one[:2]) for i, one in enumerate(world)]


class Account:
    """What the server sent to one player."""

    def __init__(self):
        self.told = {}  # by entity, the last that was sent
        self.first = 0  # the step at which it was let in
        self.acknowledged = False  # a snapshot of this epoch
        self.updates = self.by_threshold = self.by_heartbeat = self.suppressed = 0
        self.off = []


class Sender:
    """The server's side."""

    def __init__(self, sim):
        self.sim, self.row = sim, sim.scenario["reckoning"]
        self.accounts = [Account() for _ in sim.players]
        self.step = None  # of the update before
        self.flags = []  # at the first update of that step
        self.accelerations = [(0.0, 0.0)] * len(sim.first_state.world)

    def begins(self, index):
        """A new epoch."""
        account = self.accounts[index]
        account.first, account.acknowledged = self.sim.server.step, False

    def heard(self, index, step):
        """The player has the snapshot of this step."""
        account = self.accounts[index]
        account.acknowledged |= step > account.first

    def update(self):
        """At each update, before it is sent to anybody."""
        server = self.sim.server
        if self.step is not None and self.step != server.step:
            seconds = (server.times[server.step] - server.times[self.step]) / SECOND
            rates = [[self.sim.game.motion(one)[1] for one in server.history[step]] for step in (self.step, server.step)]
            self.accelerations = [((b[0] - a[0]) / seconds, (b[1] - a[1]) / seconds) for a, b in zip(*rates)]
        if self.step != server.step:
            self.flags = [server.flags(i) for i in range(len(server.world))]
        self.step = server.step

    def why(self, before, now, flags):
        row = self.row
        if before is None:
            return "new", None
        pose, _ = MODELS[row["model"]](before, (now.time - before.time) / SECOND)
        off = math.hypot(now.pose[0] - pose[0], now.pose[1] - pose[1])
        turned = abs(now.pose[2] - pose[2])
        if before.flags != flags:
            return "new", None
        if off > row["threshold_m"] or turned > row["threshold_deg"] * math.pi / 180:
            return "by_threshold", off
        if row["heartbeat_s"] > 0 and (now.time - before.time) / SECOND >= row["heartbeat_s"]:
            return "by_heartbeat", off
        return None, off

    def select(self, index):
        """The states of others that go to this player now."""
        server, account, out = self.sim.server, self.accounts[index], {}
        if not account.acknowledged:
            account.told = {}
        for i, one in enumerate(server.world):
            if i == index:
                continue
            pose, rate = self.sim.game.motion(one)
            told = Told(pose, rate, self.accelerations[i], self.flags[i], server.times[server.step])
            reason, off = self.why(account.told.get(i), told, server.flags(i))
            self.count(account, reason, off)
            if reason:
                out[i] = account.told[i] = told
        return out

    def count(self, account, reason, off):
        if self.sim.server.times[self.sim.server.step] < self.sim.scenario["warmup_s"] * SECOND:
            return
        if off is not None:
            account.off.append(off)
        if reason is None:
            account.suppressed += 1
            return
        account.updates += 1
        account.by_threshold += reason == "by_threshold"
        account.by_heartbeat += reason == "by_heartbeat"

    # ---- sizes ----

    def size(self, index, told):
        """Of a snapshot: the own entity, the others, and the game's tail."""
        game, server = self.sim.game, self.sim.server
        bits = exact(game, server.world[index], server.flags(index)) + len(server.world) - 1 + words(game.tail(server.world))
        for i in told:
            bits += exact(game, server.world[i], self.flags[i]) + 128 * (self.row["model"] == "acceleration")
        return message(bits)


def distributions(sim, i):
    return {"reckoning.model_error_m": Distribution(sim.server.reckoning.accounts[i].off, "m")}


def numbers(sim, i):
    account, span = sim.server.reckoning.accounts[i], sim.now / SECOND - sim.scenario["warmup_s"]
    for name in ("updates", "by_threshold", "by_heartbeat", "suppressed"):
        yield f"reckoning.{name}", getattr(account, name)
    others = len(sim.server.world) - 1
    if span > 0:
        yield "reckoning.updates_per_s", account.updates / span / others if others else None
