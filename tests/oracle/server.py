"""The server: its connections, its inputs and its steps."""

from dataclasses import dataclass, replace

from reckoning import Sender
from selection import Selection
from draws import SECOND, last_tick_at, single, tick_time

PONG_BYTES, STATE_HEADER = 40, 48
CONNECT_AGE = 3 * SECOND
QUIET = 100 * 10**6
LOOK = 100 * 10**6
WORDS = 16  # of 32 inputs each, with `per_input`
LATE, RHYTHM = 60 * 10**6, 4 * SECOND


@dataclass
class State:
    step: int
    time: int
    world: list
    last: int = 0
    applied: int = 0
    slack: int = None
    slack_number: int = 0
    done: frozenset = None  # with `per_input`: the numbers that were applied; None: it does not tell
    decided: int = 0
    told: dict = None  # of some of the entities: the others that are in it
    missing: set = None  # and whom the client does not have
    axes: tuple = None  # of all in the last step, where the client asks for it


class Seat:
    """What the server knows of one player."""

    def __init__(self, world):
        self.connected = False
        self.epoch = 0
        self.attempt = 0
        self.known_answer = self.known_at = 0  # the newest answer that it is known to have, and since when
        self.sent = None
        self.inputs = {}  # step: input
        self.came = {}  # step: when its input came
        self.idle = False  # a packet has brought nothing new since the last state
        self.last_state = State(0, 0, world)
        self.numbers = set()  # that have come in this epoch
        self.last_axis = 0.0
        self.starved_for = 0
        self.slack, self.slack_number = None, 0
        self.last_slack = 0
        self.joined_again = False  # since the game began
        self.offset = 0  # of its inputs in whole intervals, as its pings tell
        self.ahead = None  # step - number of every input of this epoch
        self.last = self.applied = self.decided = 0
        self.wants = self.wants_axes = False  # a bit for each input; what others do
        self.known = 0  # the newest state that the client is known to have
        self.done = set()
        self.accepted = self.duplicate = self.late = self.starved = self.refused = self.drops = 0


class Server:
    def __init__(self, sim):
        self.sim = sim
        self.seats = [Seat(sim.first_state.world) for _ in sim.players]
        self.world = sim.first_state.world
        self.step = 0
        self.updates = 0
        self.axes = [0.0] * len(sim.players)  # in the last step
        self.epoch = 1  # the last that was given out
        self.look_at = -100 * LOOK
        self.history = {0: self.world}
        self.times = {0: 0}
        self.stepped_at = 0
        self.rhythm_until = 0
        self.reckoning = Sender(sim) if sim.reckons else None
        self.selection = Selection(sim) if sim.selects else None

    # ---- connections ----

    def receive(self, now, index, kind, body):
        seat = self.seats[index]
        if kind == "connect":
            known = seat.connected and seat.attempt == body["attempt"]
            answer = body["answer"]
            if not known and body["attempt"] >= seat.attempt and answer is not None and now - answer <= CONNECT_AGE:
                self.let_in(now, seat, answer)
                seat.attempt = body["attempt"]
                known = True
            self.reply(now, index, "accept" if known else "pong", body)
        elif kind == "ping":
            seat.offset = body["offset"]
            if body["answer"] is not None and body["answer"] > seat.known_answer:
                seat.known_answer, seat.known_at = body["answer"], now
            self.reply(now, index, "pong", body)
        elif kind == "inputs" and not seat.connected:
            if now - seat.sent >= QUIET:
                self.reply(now, index, "pong", {"asked": None})
        elif kind == "inputs" and body["epoch"] == seat.epoch:
            before = seat.accepted
            seat.wants, seat.wants_axes = body["wants"], body["wants_axes"]
            if body["named"]:
                seat.known = max(seat.known, body["known"])
                self.acknowledged(index, body)
            for one in body["inputs"]:
                self.input_comes(now, seat, one, one.number > body["fresh"])
            if seat.accepted == before:
                seat.idle = True

    def let_in(self, now, seat, answer):
        seat.connected = True
        seat.joined_again = now > 0
        self.epoch += 1
        seat.epoch = self.epoch
        self.axes[self.seats.index(seat)] = 0.0
        seat.last_axis = 0.0
        seat.known_answer, seat.known_at = now, 2 * now - answer
        seat.inputs, seat.numbers, seat.came = {}, set(), {}
        seat.slack = None
        seat.ahead, seat.last, seat.applied, seat.decided = None, 0, 0, 0
        seat.wants, seat.wants_axes, seat.known, seat.done = False, False, 0, set()
        self.begins_epoch(self.seats.index(seat))

    def begins_epoch(self, index):
        if self.reckoning:
            self.reckoning.begins(index)
        if self.selection:
            self.selection.begins(index)

    def acknowledged(self, index, body):
        """A packet names a snapshot."""
        if self.selection and body["known"] > 0:
            self.selection.acknowledged(index, body["known"], body["has"])
        if self.reckoning:
            self.reckoning.heard(index, body["known"])

    def flags(self, i):
        """Of an entity: 128 is a player who is not connected."""
        away = i < len(self.seats) and not self.seats[i].connected
        return self.sim.game.flags(self.world[i]) + 128 * away

    def begin(self):
        """The game begins, in a new epoch for all."""
        self.epoch += 1
        for seat in self.seats:
            seat.epoch = self.epoch

    def reply(self, now, index, kind, body):
        self.send(now, index, kind, {"asked": body["asked"], "answered": now, "attempt": body.get("attempt"), "connected": self.seats[index].connected}, PONG_BYTES)

    def send(self, now, index, kind, body, size):
        seat = self.seats[index]
        seat.sent = now
        self.sim.send_down(index, now, kind, {"epoch": seat.epoch, **body}, size)

    def look(self, now):
        self.look_at += LOOK
        if self.look_at == 0:  # the game's clocks begin at 0, but with tick 1
            self.look_at += LOOK
        timeout = self.sim.timeout_s
        for index, seat in enumerate(self.seats):
            if not seat.connected:
                continue
            if self.sim.lockstep and seat.idle:
                again = replace(seat.last_state, slack=seat.slack, slack_number=seat.slack_number)
                seat.slack, seat.idle = None, False
                self.send(now, index, "state", {"state": again}, self.sim.state_bytes + self.parts_bytes(seat))
            elif now - seat.sent >= QUIET:
                self.reply(now, index, "keep", {"asked": None})
            if timeout > 0 and now - seat.known_at > int(timeout * SECOND):
                seat.connected = False
                seat.last_axis = 0.0
                seat.drops += 1

    # ---- inputs ----

    def input_comes(self, now, seat, one, fresh):
        if one.number in seat.numbers:
            seat.duplicate += 1
            return
        seat.numbers.add(one.number)
        seat.ahead = one.step - one.number
        slack = one.step - self.step - 1
        if fresh and (seat.slack is None or slack < seat.slack):
            seat.slack, seat.slack_number = slack, one.number
        seat.last_slack = slack
        if one.step <= self.step:
            seat.late += 1
            return
        seat.accepted += 1
        seat.came[one.step] = now
        seat.inputs[one.step] = one

    def axis_for(self, seat, step):
        row = self.sim.scenario["server"]
        one = seat.inputs.pop(step, None)
        if one is not None:
            seat.last_axis, seat.starved_for = one.axis, 0
            seat.applied = max(seat.applied, one.number)
            seat.done.add(one.number)
            return one.axis
        if not seat.connected or seat.ahead is None or step <= seat.ahead:
            return 0.0
        seat.starved += 1
        seat.starved_for += 1
        return single(STARVED[row["starved"]](row, seat.last_axis, seat.starved_for, self.sim.h))

    # ---- locksteps ----

    def lockstep_due(self):
        """When the next step is made, as far as is known."""
        interval = tick_time(self.sim.step_hz, 1)
        came = [seat.came.get(self.step + 1) for seat in self.seats if seat.connected]
        if not came or None in came:
            return None
        due = max(came) + interval
        if self.sim.sync == "lockstep_pipelined" and self.stepped_at < due < self.rhythm_until:
            due = self.in_rhythm(due, interval)
        return max(due, self.sim.now, self.stepped_at + interval // 4 if self.step else 0)

    def in_rhythm(self, due, interval):
        """A step that is due waits for the instant at which the inputs of the farthest would have it made."""
        there = [seat for seat in self.seats if seat.connected and seat.came]
        far = max(there, key=self.farness)
        if far.came[self.step + 1] + interval == due:
            return due
        behind = (due - far.came[max(far.came)]) % interval
        if behind > interval // 256:
            behind -= interval
        return due + max(0, interval // 256 // 2 - behind)

    def farness(self, seat):
        came, hz = max(0, seat.came[max(seat.came)]), self.sim.step_hz
        return came - tick_time(hz, last_tick_at(hz, came)) + tick_time(hz, seat.offset)

    def came_late(self, seat, step):
        interval = tick_time(self.sim.step_hz, 1)
        came, before = seat.came[step], seat.came.get(step - 1)
        many = min(4, -(-LATE // interval))
        if seat.came.get(step + many) == came or (before is None and seat.joined_again):
            return True
        return before is not None and came - before > interval + LATE

    def make_step(self, now):
        self.step += 1
        interval = tick_time(self.sim.step_hz, 1)
        waited = now - self.stepped_at > interval + interval // 256
        if self.sim.sync == "lockstep_pipelined" and waited and any(self.came_late(seat, self.step) for seat in self.seats if seat.connected):
            self.rhythm_until = now + RHYTHM
        self.stepped_at = now
        self.times[self.step] = now
        axes = self.axes = [self.axis_for(seat, self.step) for seat in self.seats]
        self.world = self.sim.game.step(self.sim.params, self.world, axes, self.sim.h, now / 1e9)
        self.history[self.step] = self.world
        for seat in self.seats:
            seat.last = 0 if seat.ahead is None else max(0, self.step - seat.ahead)
        self.sim.server_stepped(now)

    def update(self, now):
        self.updates += 1
        if self.reckoning:
            self.reckoning.update()
        for index, seat in enumerate(self.seats):
            if not seat.connected:
                continue
            state = State(self.step, self.times[self.step], self.world, seat.last, seat.applied, seat.slack, seat.slack_number)
            if seat.wants:
                state.done, state.decided = frozenset(seat.done), self.decided(seat)
            if seat.wants_axes:
                state.axes = tuple(self.axes)
            size = self.sim.state_bytes
            if self.reckoning:
                state.told = self.reckoning.select(index)
                size = self.reckoning.size(index, state.told)
            if self.selection:
                state.told, size = self.selection.select(index)
            seat.slack, seat.idle, seat.last_state = None, False, state
            self.send(now, index, "state", {"state": state}, size + self.parts_bytes(seat))

    def decided(self, seat):
        return seat.last

    def told_since(self, seat):
        """So many inputs at most are told of."""
        return self.step - seat.known if seat.known else WORDS * 32

    def parts_bytes(self, seat):
        axes = 8 * (len(self.seats) - 1) if seat.wants_axes else 0
        if not seat.wants:
            return axes
        told = min(self.decided(seat), self.told_since(seat))
        return axes + 8 + 4 * min(WORDS, -(-told // 32))


def decay(row, axis, n, h):
    left = max(0.0, 1 - n * h / (row["starved_tau_ms"] / 1000))
    if isinstance(axis, complex):  # by parts, which keeps the sign of 0
        return complex(axis.real * left, axis.imag * left)
    return axis * left


STARVED = {
    "decay": decay,
    "repeat": lambda row, axis, n, h: axis,
    "repeat_n": lambda row, axis, n, h: axis if n <= row["starved_ticks"] else 0.0,
    "neutral": lambda row, axis, n, h: 0.0,
}
