"""Snapshots of some of the entities: docs/netgame.md, the section of that name."""

import math
from dataclasses import dataclass, field

from draws import SECOND, distance, nearest, single
from encoding import cell, exact, message, number, words

ENCODINGS = ("partial", "partial_delta", "interest")
MOST, FLIGHT, UPDATES, DELTA_UPDATES, TOLD = 255, 64, 31, 30, 32
GONE = "gone"


def steps(row):
    """Of the grid, as they travel."""
    names = ("quantum_m", "quantum_m", "quantum_rad", "quantum_mps", "quantum_mps", "quantum_radps")
    return [single(row[name]) for name in names]


def cell_of(game, row, one, flags):
    pose, rate = game.motion(one)
    return (*(nearest(value / step) for value, step in zip((*pose, *rate), steps(row))), flags)


def value_of(game, row, told, one):
    """The entity as a client has it."""
    values = [n * step for n, step in zip(told, steps(row))]
    return game.moved(one, values[:3], values[3:])


@dataclass(eq=False)
class Snapshot:
    """That was sent."""
    update: int
    step: int
    tail: list
    states: dict = field(default_factory=dict)  # entity: cell or GONE
    gathered: dict = field(default_factory=dict)  # what each entity had accumulated
    void: bool = False  # its step was sent again


@dataclass(eq=False)
class Entity:
    """What the server keeps of one entity for one client."""
    sent: object = None  # the state that it sent last
    sent_state: object = None  # the same, even if it was lost
    sent_step: int = 0
    known: object = None  # the newest acknowledged
    known_in: Snapshot = None
    gathered: float = 0.0
    in_scope: bool = False
    may_have: bool = False  # the client


@dataclass(eq=False)
class Account:
    """Of one client."""
    entities: list
    flight: list = field(default_factory=list)  # snapshots without a verdict
    step: int = None  # of the snapshot before
    last: int = -1  # the entity that was sent last
    named: int = 0  # the newest snapshot that the client has named
    counts: bool = False
    lost: int = 0
    count: int = 0
    choked: int = 0
    in_scope: int = 0
    intervals: list = field(default_factory=list)  # in steps


class Selection:
    """The server's side."""

    def __init__(self, sim):
        self.sim, self.row = sim, sim.scenario["server"]
        self.accounts = [Account([Entity() for _ in sim.first_state.world]) for _ in sim.players]
        self.update, self.step = 0, None  # updates of different steps
        self.tails = {}  # of the updates

    @property
    def radius(self):
        return self.row["interest_radius_m"]

    def begins(self, index):
        """A new epoch."""
        account = self.accounts[index]
        account.entities = [Entity(may_have=e.may_have) for e in account.entities]
        account.flight, account.named, account.step = [], 0, None

    # ---- what is due ----

    def scope(self, entity, far):
        if self.row["snapshot_encoding"] != "interest" or self.radius <= 0:
            return True
        return far <= self.radius + (self.row["interest_margin_m"] if entity.in_scope else 0)

    def due(self, entity, now):
        if now == GONE and not entity.may_have:
            return False
        held = entity.sent if entity.sent is not None else entity.known
        return held is None or held != now

    def priority(self, far):
        near = self.radius / 4
        return 1.0 if near == 0 or far <= near else near / far

    def present_states(self, index):
        """Of the others: a cell, or GONE."""
        server, account, out = self.sim.server, self.accounts[index], {}
        for i, (entity, one) in enumerate(zip(account.entities, server.world)):
            if i == index:
                continue
            far = distance(one, server.world[index])
            entity.in_scope = self.scope(entity, far)
            out[i] = cell_of(self.sim.game, self.row, one, server.flags(i)) if entity.in_scope else GONE
        return out

    def candidates(self, index, present):
        """Those that are due, the first first."""
        account, out, n = self.accounts[index], [], len(self.sim.server.world)
        for i, state in present.items():
            entity = account.entities[i]
            if self.due(entity, state):
                entity.gathered += self.priority(distance(self.sim.server.world[i], self.sim.server.world[index]))
                out.append(i)
            elif state != GONE or entity.may_have:
                entity.gathered = 0.0
        return sorted(out, key=lambda i: (-account.entities[i].gathered, (i - account.last - 1) % n))

    def select(self, index):
        """(states of this snapshot by entity, its size)."""
        server, account = self.sim.server, self.accounts[index]
        if self.step != server.step:
            self.update, self.step = self.update + 1, server.step
            self.tails[self.update] = server.step, self.sim.game.tail(server.world)
        account.counts = server.times[server.step] >= self.sim.scenario["warmup_s"] * SECOND
        present = self.present_states(index)
        snapshot, order = Snapshot(self.update, server.step, self.sim.game.tail(server.world)), []
        again, account.step = account.step == server.step, server.step
        if again and account.flight and account.flight[-1].step == server.step:
            self.lose(account, account.flight[-1])
            account.flight[-1].void = True
        elif again:
            pass  # it is acknowledged already
        else:
            if len(account.flight) == FLIGHT:
                self.lose(account, account.flight.pop(0))
            account.flight.append(snapshot)
            order = self.candidates(index, present)
        bits = self.fill(index, account, snapshot, order, present)
        if account.counts and not again:
            account.count += 1
            account.choked += len(snapshot.states) < len(order)
            account.in_scope += sum(state != GONE for state in present.values())
        return snapshot.states, message(bits)

    def base(self, account):
        """(the newest snapshot that the client has named is still known here, its tail)."""
        for update in range(max(2, self.update - UPDATES), self.update + 1):
            step, tail = self.tails[update]
            if step == account.named > 0:
                return True, tail
        return False, None

    def fill(self, index, account, snapshot, order, present):
        server, game = self.sim.server, self.sim.game
        known, tail = self.base(account)
        bits = exact(game, server.world[index], server.flags(index)) + (1 if known else 129)
        more = 1 + (0 if known and tail == snapshot.tail else words(snapshot.tail))
        once, each = game.BODY_BYTES
        most = 8 * (once + each * len(server.world))
        limit = min(8 * self.row["snapshot_bytes"] or most, most) - 2  # a bit for the tail, one for the end
        before = None  # step of the baseline of the entity before
        for i in order[:MOST]:
            entity = account.entities[i]
            part, base = self.entity_bits(entity, present[i], snapshot, before)
            if bits + part > limit:
                break
            bits, before = bits + part, base
            self.sends(account, i, present[i], snapshot)
        return bits + more + 1

    def sends(self, account, i, state, snapshot):
        entity = account.entities[i]
        snapshot.states[i], snapshot.gathered[i] = state, entity.gathered
        if account.counts and entity.sent_step > 0 and GONE not in (state, entity.sent_state):
            account.intervals.append(snapshot.step - entity.sent_step)
        entity.sent = entity.sent_state = state
        entity.sent_step, entity.gathered = snapshot.step, 0.0
        entity.may_have |= state != GONE
        account.last = i

    def entity_bits(self, entity, state, snapshot, before):
        bits = 1 + max(1, (len(self.sim.server.world) - 1).bit_length()) + 1
        if state == GONE:
            return bits, before
        bits += 2
        deltas = self.row["snapshot_encoding"] != "partial" and entity.known not in (None, GONE)
        if deltas and snapshot.update - entity.known_in.update <= DELTA_UPDATES:
            step = entity.known_in.step
            bits += 1 + (0 if step == before else number(snapshot.step - step))
            return bits + cell(state, entity.known), step
        return bits + cell(state, (0,) * 7), before

    # ---- acknowledgements ----

    def acknowledged(self, index, named, has):
        """A packet names the snapshot of step `named`, and says which of those before the client has."""
        account = self.accounts[index]
        account.named = max(account.named, named)
        while account.flight and account.flight[0].step <= named:
            snapshot = account.flight.pop(0)
            came = snapshot.step == named or snapshot.step in has
            if came and 1 < snapshot.update >= self.update - UPDATES:
                self.keep(account, snapshot)
            else:
                self.lose(account, snapshot)

    def keep(self, account, snapshot):
        for i, state in snapshot.states.items():
            entity = account.entities[i]
            if not snapshot.void:
                entity.known, entity.known_in = state, snapshot
                entity.may_have &= state != GONE or entity.sent_step != snapshot.step

    def lose(self, account, snapshot):
        if snapshot.void:
            return
        account.lost += account.counts
        for i, gathered in snapshot.gathered.items():
            entity = account.entities[i]
            entity.gathered += gathered
            if entity.sent_step == snapshot.step:
                entity.sent = None


class Held:
    """The client's side."""

    def __init__(self, sim, index):
        self.sim, self.index = sim, index
        self.fresh = True  # nothing has come
        self.steps = []  # of the snapshots that it has

    def take(self, before, state):
        """The world of this snapshot, and who is missing in it."""
        world, missing = [list(one) for one in before.world], set(before.missing or ())
        if self.fresh:  # it has nobody else
            missing = set(range(len(world))) - {self.index}
            self.fresh = False
        for i, one in enumerate(world):
            one[3] = state.world[i][3]
        world[self.index] = list(state.world[self.index])
        for i, told in state.told.items():
            if told == GONE:
                missing.add(i)
                continue
            missing.discard(i)
            world[i] = value_of(self.sim.game, self.sim.scenario["server"], told, state.world[i])
        self.steps = [*self.steps[-TOLD:], state.step]
        return world, missing

    def has(self, newest):
        return {step for step in self.steps if newest - TOLD <= step < newest}


def numbers(sim, i):
    account = sim.server.selection.accounts[i]
    n = account.count
    yield "selection.snapshots", n
    yield "selection.lost_ratio", account.lost / n if n else None
    yield "selection.choked_ratio", account.choked / n if n else None
    yield "selection.in_scope", account.in_scope / n if n else None
    intervals, ms = account.intervals, 1000 / sim.step_hz
    yield "selection.update_interval_ms", sum(intervals) / len(intervals) * ms if intervals else None
    yield "selection.update_interval_max_ms", max(intervals) * ms if intervals else None
    for name, errors in zip(("near", "far"), sim.errors[i]):
        yield f"selection.{name}_error_m", math.fsum(errors) / len(errors) if errors else None
