"""A client: its machine, its inputs, what it takes in and what it draws."""

from dataclasses import dataclass, field

from connection import AGAIN, ANSWERS, PLAYS, Connection
from draws import SECOND, first_tick_from, last_tick_at, millihertz, ns, single, tick_time, trunc, unit
from interpolation import KEPT, DrawnTime, Reference, between, delay_ns

SNAP = 100 * 10**6
ROUNDING = 1e-12  # in m: less is no correction, but that two programs round differently
WINDOW = 2 * SECOND
CONNECT_BYTES, PING_BYTES, INPUTS_HEADER, INPUT_BYTES = 24, 24, 16, 16


@dataclass
class Input:
    number: int
    step: int
    axis: float
    made: int
    acked: bool = False


@dataclass
class Drawn:
    """One picture."""
    at: int
    own: tuple = (0.0, 0.0)
    own_step: int = 0
    others: dict = field(default_factory=dict)
    others_time: int = 0
    newest_time: int = 0


class Client:
    def __init__(self, sim, index):
        self.sim, self.index = sim, index
        player = sim.players[index]
        phase = player["clock_phase"]
        if phase < 0:
            phase = unit(sim.seed, 0x7068617365 + index, 0)
        self.connection = Connection(-10 * SECOND, player["drift_ppm"])
        self.tick_hz = sim.step_hz
        self.phase = trunc(phase * tick_time(self.tick_hz, 1))
        display_hz = player["display_hz"] or sim.scenario["tick_hz"]
        self.display_hz = display_hz
        self.sync = sim.sync
        self.with_ticks = sim.sync != "lockstep" and player["display_hz"] == 0 and self.tick_hz == sim.scenario["tick_hz"]
        self.ticks = 0  # that have been
        self.displays = 0
        self.newest = sim.first_state  # that was taken
        self.arrived = sim.first_state  # the newest that came
        self.begun = False
        self.number = 0
        self.next_step = 0
        self.inputs = []
        self.closed_unsent = []  # inputs whose step was over before a packet left
        self.again_at = None  # stop-and-wait: when the input is sent again
        self.taken_at = 0  # when the newest state came
        self.unsent = 0
        self.unacked = []  # of every frame that counts
        self.pending = 0
        self.settle = 0
        self.window_at = None
        self.least = None
        self.kept = []
        self.reference = Reference()
        self.drawn_time = DrawnTime()
        self.world = [list(c) for c in self.newest.world]  # the prediction
        self.world_step = 0
        self.corrections = 0
        self.correction_sizes = []
        self.stale_states = 0
        self.joins = 0
        self.accepted_at = 0
        self.check_begin = False
        self.seen_finish = False  # what the script has seen

    @property
    def player(self):
        return self.sim.players[self.index]

    # ---- the machine ----

    def machine_time(self, rate, k):
        t = tick_time(rate, k)
        return self.phase + t - trunc(t * self.connection.drift)

    def next_tick(self):
        return self.machine_time(self.tick_hz, self.ticks)

    def next_display(self):
        return self.next_tick() if self.with_ticks else self.machine_time(self.display_hz, self.displays)

    def next_time(self):
        again = self.again_at if self.again_at is not None else self.next_tick()
        return min(self.next_tick(), self.next_display(), again, max(self.connection.due(self.sim.timeout_s)[0], self.sim.now))

    def wake(self, now):
        if self.next_tick() == now:
            if self.with_ticks:
                self.tick(now)
                self.display(now)
            else:
                shows = self.next_display() == now
                self.tick(now)
                if shows:
                    self.display(now)
        elif self.next_display() == now:
            self.display(now)
        if self.again_at is not None and self.again_at <= now:
            self.send_again(now)
        self.connection_events(now)

    def connection_events(self, now):
        c = self.connection
        while True:
            at, what = c.due(self.sim.timeout_s)
            if at > now:
                return
            if what == "stall":
                c.enter("stalled", now)
            elif what == "timeout":
                self.loses_connection(now)
            else:
                c.next_request = now + AGAIN[c.state]
                self.send(now, what, {"asked": c.shown(now), "answer": c.newest_answer, "attempt": c.attempt, "offset": self.offset(now)},
                          PING_BYTES)

    def offset(self, now):
        """How many whole intervals after the game began its first input would come."""
        tick = self.connection.shown(self.next_tick()) + self.connection.offset
        if now < 0 or tick < 0:
            return 0
        within = tick - tick_time(self.tick_hz, last_tick_at(self.tick_hz, tick))
        return min(255, last_tick_at(self.tick_hz, within + self.connection.half_trip()))

    def loses_connection(self, now):
        c = self.connection
        c.enter("disconnected" if c.ever_played else "connecting", now)
        self.inputs = []
        self.closed_unsent = []  # inputs whose step was over before a packet left

    def send(self, now, kind, body, size):
        self.connection.sent = now
        self.sim.send_up(self.index, now, kind, {"epoch": self.connection.epoch, **body}, size)

    # ---- what comes ----

    def receive(self, now, kind, body):
        c = self.connection
        self.begin_if_playing(now)
        if kind in ("accept", "pong"):
            if kind == "accept" and body["attempt"] != c.attempt:
                return
            if kind == "accept" and c.state in ("connecting", "disconnected"):
                c.epoch = body["epoch"]
                self.joins += 1
                self.accepted_at = body["answered"]  # by the server's clock
                c.enter("resynchronising" if c.ever_played else "synchronising", now)
            c.hear(now)
            c.answer(now, body["asked"], body["answered"], self.player["clock_filter"])
            if c.state in ("connecting", "disconnected"):
                if not body["connected"]:
                    c.next_request = now
            elif not body["connected"] and body["answered"] > self.accepted_at:
                self.loses_connection(now)
            elif c.state in ("synchronising", "resynchronising"):
                c.answers += 1
                if c.answers >= ANSWERS:
                    self.begins_to_play(now)
            return
        if body["epoch"] != c.epoch:
            return
        c.hear(now)
        if kind == "state":
            self.state_comes(now, body["state"])

    def begins_to_play(self, now):
        self.connection.enter("playing", now)
        if self.begun:
            self.check_begin = True
        self.begin_if_playing(now)

    def state_comes(self, now, state):
        if self.kept and state.step <= self.arrived.step:
            self.stale_states += 1
            return
        self.arrived = state
        self.taken_at = now
        self.read_slack(now, state)
        self.kept.append(state)
        del self.kept[:-KEPT]
        self.reference.add(now, state.time - now)
        if self.sync == "lockstep" and self.connection.state in PLAYS and self.begun and state.step >= self.number:
            self.take(now)
            self.answer_state(now)
        elif self.sync == "lockstep" and self.number:  # the state of step 0, which the server sends only on demand
            self.send_again(now)

    # ---- inputs ----

    def first_step(self):
        c = self.connection
        t = c.shown(self.next_tick())
        step = first_tick_from(self.sim.step_hz, t + c.offset + c.half_trip())
        return max(step, self.newest.step + 1) + self.player["slack_ticks"]

    def input_delay(self):
        """Without prediction an input waits for its effect anyway."""
        return self.player["input_delay_ticks"] if self.player["prediction"] else 0

    # ---- locksteps ----

    def pipelined(self, now):
        interval = tick_time(self.tick_hz, 1)
        ahead = self.number + 1 - self.newest.step
        late = now - self.taken_at > 4 * interval
        longest = max(trip for trip, _ in self.connection.samples)
        if self.pending < 0:
            self.pending += 1
        elif ahead <= (127 if self.sim.scenario["tick_hz"] <= 64 else 255) and not (late and ahead > longest // interval + 4):
            self.make(now)
        self.count_unacked()
        self.send_open(now)

    def send_open(self, now):
        o = [i for i in self.inputs if i.number > self.newest.last]
        chosen = o[-16:]
        n = self.ticks
        overdue = o and now - o[0].made > self.connection.longest() + 4 * tick_time(self.tick_hz, 1)
        if len(o) > 16 and n % 2 and overdue:
            first = 16 * ((n // 2) % ((len(o) - 1) // 16))
            chosen = o[first:first + 16]
        fresh = self.number - self.unsent
        if not chosen or chosen[-1].number == self.number:
            self.unsent = 0
        if chosen:
            self.send(now, "inputs", {"inputs": chosen, "fresh": fresh}, INPUTS_HEADER + INPUT_BYTES * len(chosen))

    def answer_state(self, now):
        """Stop-and-wait: the next input, as soon as the state of the one before has come."""
        self.make(now)
        self.send_again(now)

    def send_again(self, now):
        self.count_unacked()
        self.send_open(now)
        self.again_at = now + 200 * 10**6 + 2 * self.connection.longest()

    def begin_if_playing(self, now):
        """At time 0, or as soon as it plays."""
        if now >= 0 and not self.begun and self.connection.state in PLAYS:
            self.begin()

    def begin(self):
        self.begun = True
        if self.sim.lockstep:
            self.next_step = 1
            return
        self.next_step = self.first_step()

    def tick(self, now):
        self.take(now)
        player, plays = self.player, self.connection.state in PLAYS
        self.begin_if_playing(now)
        self.ticks += 1
        if not self.begun:
            return
        if self.sync == "lockstep":
            if plays and self.number == self.newest.step == 0:
                self.answer_state(now)
            return
        if not plays:
            self.next_step += 1
            return
        if self.sync == "lockstep_pipelined":
            self.pipelined(now)
            return
        if self.check_begin:
            self.check_begin = False
            self.compare_begin()
        count = 1
        if self.pending > 0:
            count, self.pending = 2, self.pending - 1
        elif self.pending < 0:
            count, self.pending = 0, self.pending + 1
        for _ in range(count):
            self.make(now)
        self.predict_on(count)
        self.count_unacked()
        rate, hz = millihertz(self.tick_hz), millihertz(player["send_hz"])
        if hz == 0 or self.ticks * hz // rate != (self.ticks - 1) * hz // rate:
            self.send_inputs(now)

    def compare_begin(self):
        pass

    def make(self, now):
        self.number += 1
        self.inputs.append(Input(self.number, self.next_step, self.script(now), now))
        self.next_step += 1
        self.unsent += 1

    def script(self, now):
        return single(self.sim.game.SCRIPTS[self.player["script"]](self.sim.seed, self.index, now, self.seen_finish))

    def count_unacked(self):
        if self.sim.counts:
            self.unacked.append(max(0, self.number - self.newest.last))

    def send_inputs(self, now):
        fresh = self.number - self.unsent
        count = min(self.unsent + self.player["redundancy"], 16)
        # By numbers: those that a snap has left out count too.
        open_or_fresh = self.closed_unsent + self.inputs
        chosen = [i for i in open_or_fresh if i.number > max(self.number - count, min(self.newest.last, fresh))]
        self.closed_unsent = []
        self.unsent = 0
        if chosen and fresh < self.number:
            self.send(now, "inputs", {"inputs": chosen, "fresh": fresh}, INPUTS_HEADER + INPUT_BYTES * len(chosen))

    # ---- what is taken in ----

    def take(self, now):
        if self.arrived is self.newest:
            return
        state = self.newest = self.arrived
        sent = self.number - self.unsent
        self.closed_unsent = [i for i in self.closed_unsent + self.inputs if sent < i.number <= state.last]
        self.inputs = [i for i in self.inputs if i.number > state.last]
        self.reconcile(state)

    def read_slack(self, now, state):
        if self.player["time_dilation"] or state.slack is None or state.slack_number < self.settle:
            return
        s, want, window = state.slack, self.player["slack_ticks"], WINDOW
        if self.sync == "lockstep":
            return
        if self.sync == "lockstep_pipelined":
            want, window = 0, WINDOW // 4  # it has no slack to keep: nothing is ever made beyond one a tick
            s = max(s, 0)
        if self.window_at is None:
            self.window_at, self.least = now, s
        self.least = min(self.least, s)
        if s < want:
            self.change(want - s)
        elif now - self.window_at >= window:
            if self.least > want + 1:
                self.change(want + self.sim.lockstep - self.least)
            else:
                self.window_at = None

    def change(self, by):
        self.window_at = None
        if by > 0 and by * tick_time(self.sim.step_hz, 1) >= SNAP:
            self.number += by
            self.next_step += by
            self.settle = self.number + 1
        else:
            self.pending = by
            self.settle = self.number + 2 * max(by, 0) + 1

    # ---- prediction ----

    def target_step(self):
        if not self.inputs:
            return self.newest.step
        return max(self.inputs[-1].step - self.input_delay(), self.inputs[0].step - 1, self.newest.step)

    def own_input(self, step):
        for i in reversed(self.inputs):
            if i.step == step:
                return i.axis
        return 0.0

    def predict_on(self, made):
        if not self.player["prediction"]:
            return
        if not self.player["reconciliation"]:
            if self.inputs and self.inputs[0].number == 1 and self.newest is self.sim.first_state:
                self.coast(self.inputs[0].step - 1)
            for i in range(len(self.inputs) - made, len(self.inputs)):
                felt = i - self.input_delay()
                if felt >= 0 and self.world_step < self.inputs[felt].step:
                    self.world_step += 1
                    self.world = self.sim.predict(self.world, self.index, self.inputs[felt].axis, self.world_step)
            return
        while self.world_step < self.target_step():
            self.world_step += 1
            self.world = self.sim.predict(self.world, self.index, self.own_input(self.world_step), self.world_step)

    def coast(self, step):
        while self.world_step < step:
            self.world_step += 1
            self.world = self.sim.predict(self.world, self.index, 0.0, self.world_step)

    def reconcile(self, state):
        if not self.player["prediction"]:
            self.world, self.world_step = [list(c) for c in state.world], state.step
            return
        before, before_step = self.world[self.index][0], self.world_step
        world, step = [list(c) for c in state.world], state.step
        if self.player["reconciliation"]:
            while step < before_step:
                step += 1
                world = self.sim.predict(world, self.index, self.own_input(step), step)
        self.world, self.world_step = world, step
        moved = abs(world[self.index][0] - before)
        if moved > ROUNDING and (before_step >= state.step or not self.player["reconciliation"]):
            if self.sim.counts:
                self.corrections += 1
                self.correction_sizes.append(moved)

    # ---- pictures ----

    def display(self, now):
        if not self.with_ticks:
            self.displays += 1
        self.take(now)
        player, me = self.player, self.index
        picture = Drawn(now, newest_time=self.newest.time)
        if player["prediction"]:
            picture.own, picture.own_step = tuple(self.world[me][:2]), self.world_step
        else:
            picture.own, picture.own_step = tuple(self.newest.world[me][:2]), self.newest.step
        t, places = self.newest.time, [(c[0], c[1]) for c in self.newest.world]
        extrapolation = ns(player["extrapolation_ms"])
        if player["interpolation"] and self.reference.quarters:
            target = now + self.reference.value() - delay_ns(player, self.sim.update_hz)
            t = self.drawn_time.advance(now, target, self.newest.time, extrapolation)
            places = between(self.kept, t)
            if t < self.kept[0].time:
                t = self.kept[0].time
        elif extrapolation > 0 and self.reference.quarters:
            c = self.connection
            present = c.shown(now) + c.offset if player["extrapolation_clock"] == "measured" else now + self.reference.value()
            t = self.drawn_time.advance(now, present, self.newest.time, extrapolation)
            places = between(self.kept, t)
        picture.buffer = self.newest.time - t
        picture.interpolated = bool(player["interpolation"] and self.reference.quarters)
        picture.others = {i: p for i, p in enumerate(places) if i != me}
        picture.others_time = t
        self.seen_finish = self.newest.world[me][3] > 0
        self.sim.observe(self.index, picture)
