"""A client: its machine, its inputs, what it takes in and what it draws."""

from dataclasses import dataclass, field, replace

from connection import AGAIN, ANSWERS, PLAYS, Connection
from draws import SECOND, distance, first_tick_from, last_tick_at, millihertz, ns, single, tick_time, trunc, unit
from reckoning import Others
from selection import Held
from interpolation import KEPT, DrawnTime, Reference, between, delay_ns

SNAP = 100 * 10**6
INPUTS = 512  # that a client keeps
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
    times: dict = None  # of each, where they differ
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
        self.inputs, self.made = [], []
        self.axes_kept = {}  # of the inputs that it still has, by number
        self.closed_unsent = []  # inputs whose step was over before a packet left
        self.again_at = None  # stop-and-wait: when the input is sent again
        self.answers_at = None  # and when a newer state has come
        self.taken_at = 0  # when the newest state came
        self.unsent = 0
        self.run = 1  # inputs from this one on have a number for every step
        self.acked = 0
        self.snapped = 0  # steps that the clock has left out since the last frame
        self.begins = False  # the prediction begins anew with the next look
        self.unacked = []  # of every frame that counts
        self.pending = 0
        self.settle = 0
        self.window_at = None
        self.least = None
        self.kept = []
        self.others = Others(sim) if sim.reckons else None
        self.held = Held(sim, index) if sim.selects else None
        self.reference = Reference()
        self.drawn_time = DrawnTime()
        self.world = [list(c) for c in self.newest.world]  # the prediction
        self.world_step = 0
        self.guessed = [0.0] * len(sim.players)  # the others' controls in the prediction
        self.chosen = {index}  # who is predicted
        self.felt = 0  # without reconciliation: the newest input in the prediction
        self.corrections = 0
        self.correction_sizes = []
        self.stale_states = 0
        self.joins = self.time_outs = 0
        self.seen = self.newest.world[index]  # the own entity as the script sees it

    @property
    def player(self):
        return self.sim.players[self.index]

    def server_time(self, now):
        """The server's present as far as it knows."""
        return self.connection.shown(now) + self.connection.offset

    @property
    def plays(self):
        return self.connection.state in PLAYS

    @property
    def unacknowledged(self):
        return self.number - self.acked

    # ---- the machine ----

    def machine_time(self, rate, k):
        t = tick_time(rate, k)
        return self.phase + t - trunc(t * self.connection.drift)

    def next_tick(self):
        return self.machine_time(self.tick_hz, self.ticks)

    def next_display(self):
        return self.next_tick() if self.with_ticks else self.machine_time(self.display_hz, self.displays)

    def next_time(self):
        if self.answers_at is not None:
            return self.sim.now
        again = self.again_at if self.again_at is not None else self.next_tick()
        return min(self.next_tick(), self.next_display(), again, max(self.connection.due(self.sim.timeout_s)[0], self.sim.now))

    def wake(self, now):
        if self.answers_at == now:
            self.answers(now)
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
                self.time_outs += 1
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
        self.inputs, self.made, self.closed_unsent = [], [], []
        self.acked = self.number

    def send(self, now, kind, body, size):
        self.connection.sent = now
        if kind == "inputs":
            body |= {"wants": self.player["ack"] == "per_input", "known": self.arrived.step if self.kept else 0,
                     "has": self.held.has(self.arrived.step) if self.held else (),
                     "named": bool(self.kept) and self.arrived.step < body["inputs"][0].step, "wants_axes": self.predicts_others}
        if self.held and body.get("named"):
                size += 4
        self.sim.send_up(self.index, now, kind, {"epoch": self.connection.epoch, **body}, size)

    # ---- what comes ----

    def receive(self, now, kind, body):
        c = self.connection
        self.begin_if_playing(now)
        c.hear(now)
        if kind in ("accept", "pong", "keep"):
            self.answer_comes(now, kind, body)
        elif kind == "state" and body["epoch"] == c.epoch:
            self.state_comes(now, body["state"])

    def answer_comes(self, now, kind, body):
        c = self.connection
        asks = c.state in ("connecting", "disconnected")
        news = c.newest_answer is None or body["answered"] > c.newest_answer
        if news:
            c.newest_answer = body["answered"]
        if kind == "accept":
            if asks and body["attempt"] == c.attempt:
                c.epoch = body["epoch"]
                self.joins += 1
                c.enter("resynchronising" if c.ever_played else "synchronising", now)
                self.starts_anew(now)
        elif asks and not body["connected"]:
            c.next_request = now
        elif not asks and news and (not body["connected"] or body["epoch"] > c.epoch):
            self.loses_connection(now)
        if body["asked"] is None:
            return
        c.answer(now, body["asked"], body["answered"], self.player["clock_filter"])
        c.answers += 1
        if c.state in ("synchronising", "resynchronising") and c.answers >= ANSWERS:
            self.begins_to_play(now)

    def game_begins(self, epoch):
        """At time 0, in a new epoch for all who are connected."""
        if self.connection.state not in ("connecting", "disconnected"):
            self.connection.epoch = epoch

    def starts_anew(self, now):
        """The server has let it in: its inputs begin anew."""
        self.number = self.unsent = self.acked = self.felt = self.settle = self.pending = 0
        self.run = 1
        self.axes_kept = {}
        self.inputs, self.made, self.closed_unsent = [], [], []
        self.window_at = None
        self.begins = self.begun
        self.reference.begins()
        self.sim.joined(self.index)

    def begins_to_play(self, now):
        self.connection.enter("playing", now)
        if self.begun:
            self.compare_begin()
        self.begin_if_playing(now)

    def state_comes(self, now, state):
        if self.kept and state.step <= self.arrived.step:
            self.stale_states += 1
            return
        if self.held:
            world, missing = self.held.take(self.arrived, state)
            state = replace(state, world=world, missing=missing)
        if self.others:
            state = replace(state, world=self.others.take(self.server_time(now), state))
        self.arrived = state
        self.taken_at = now
        self.read_slack(now, state)
        self.kept.append(state)
        del self.kept[:-KEPT]
        self.reference.add(now, state.time - now)
        if self.sync == "lockstep":
            self.answers_at = now

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

    def answers(self, now):
        """Stop-and-wait: a newer state has come, with all else that comes at this instant."""
        self.answers_at = None
        if self.plays and self.begun and self.arrived.step >= self.number:
            self.take(now)
            self.answer_state(now)
        elif self.number:  # the state of step 0, which the server sends only on demand
            self.send_again(now)

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
        if self.sim.by_updates:
            self.next_step, self.begins = 1, self.sim.buckets
            return
        self.next_step = self.first_step()
        self.begins = True

    def tick(self, now):
        self.begin_if_playing(now)
        if self.sim.buckets and self.begun and self.connection.state in PLAYS:
            self.into_bucket(now)
        self.take(now)
        player, plays = self.player, self.connection.state in PLAYS
        self.ticks += 1
        if not self.begun:
            return
        if self.sync == "lockstep":
            if plays and self.number == self.newest.step == 0:
                self.answer_state(now)
            return
        if not plays:
            self.next_step += not self.sim.buckets
            return
        if self.sync == "lockstep_pipelined":
            self.pipelined(now)
            return
        count = 1
        if self.pending > 0:
            count, self.pending = 2, self.pending - 1
        elif self.pending < 0:
            count, self.pending = 0, self.pending + 1
        for _ in range(count):
            self.make(now)
        self.predict_on()
        self.count_unacked()
        rate, hz = millihertz(self.tick_hz), millihertz(player["send_hz"])
        if hz == 0 or self.ticks * hz // rate != (self.ticks - 1) * hz // rate:
            self.send_inputs(now)

    def into_bucket(self, now):
        """The next input is for the step of the present bucket, or there is none."""
        hz, delay = self.sim.step_hz, ns(self.sim.scenario["bucket_delay_ms"])
        by = last_tick_at(hz, max(0, self.connection.shown(now))) + 1 + last_tick_at(hz, delay) - self.next_step
        if by > 0:
            self.snap(by)
        self.pending = min(0, by)

    def compare_begin(self):
        """It has been away: is the step of its next input still the one to begin with?"""
        if self.sync != "free":
            return
        by = self.first_step() - self.next_step
        if abs(by) * tick_time(self.sim.step_hz, 1) < SNAP:
            return
        if by > 0 or self.number == 0:
            self.snap(by)
            return
        self.pending = by
        if by < 0:
            self.settle, self.window_at = self.number + 1, None

    def snap(self, by):
        if self.number:
            self.number += by
            self.snapped += by
        self.next_step += by
        self.settle = self.run = self.number + 1
        self.unsent = self.pending = 0

    def make(self, now):
        self.number += 1
        self.inputs.append(Input(self.number, self.next_step, self.script(now), now))
        self.axes_kept[self.number] = self.inputs[-1].axis
        self.axes_kept.pop(self.number - INPUTS, None)
        self.next_step += 1
        self.unsent += 1
        if self.number - self.acked > INPUTS:
            self.acked = self.number - INPUTS
            self.inputs = [i for i in self.inputs if i.number > self.acked]

    def script(self, now):
        return single(self.sim.game.SCRIPTS[self.player["script"]](self.sim.seed, self.index, now, self.seen, self.sim.params))

    def count_unacked(self):
        if self.sim.counts:
            self.unacked.append(self.unacknowledged)

    def send_inputs(self, now):
        fresh = self.number - self.unsent
        count = min(self.unsent + self.player["redundancy"], 16)
        # By numbers, and none from before a snap.
        open_or_fresh = self.closed_unsent + self.inputs
        chosen = [i for i in open_or_fresh if i.number > max(self.number - count, min(self.acked, fresh), self.run - 1)]
        self.closed_unsent = []
        self.unsent = 0
        if chosen and fresh < self.number:
            self.send(now, "inputs", {"inputs": chosen, "fresh": fresh}, INPUTS_HEADER + INPUT_BYTES * len(chosen))

    # ---- what is taken in ----

    def take(self, now):
        if self.arrived is not self.newest:
            state, before = self.arrived, self.newest
            self.newest = state
            sent = self.number - self.unsent
            self.acked = max(self.acked, min(state.last, self.number))
            self.closed_unsent = [i for i in self.closed_unsent + self.inputs if sent < i.number <= state.last]
            self.inputs = [i for i in self.inputs if i.number > self.acked]
            if not self.begins:
                self.reconcile(state, before)
        if self.begins:
            self.begins = False
            self.begin_again()

    def begin_again(self):
        """The prediction begins anew, with what the client has."""
        self.world, self.world_step = [list(c) for c in self.newest.world], self.newest.step
        self.felt = self.newest_felt()
        self.choose(self.newest)
        if self.player["prediction"]:
            self.coast(self.next_step - 1 - (self.number - self.felt))

    def read_slack(self, now, state):
        if self.player["time_dilation"] or state.slack is None or state.slack_number < self.settle:
            return
        s, want, window = state.slack, self.player["slack_ticks"], WINDOW
        if self.sync in ("lockstep", "bucket"):
            return
        if self.sync == "lockstep_pipelined":
            want, window = 0, WINDOW // 4  # it has no slack to keep: nothing is ever made beyond one a tick
            s = max(s, 0)
        if self.window_at is None:
            self.window_at, self.least = now, s
        self.least = min(self.least, s)
        most = (128 if self.sim.scenario["tick_hz"] <= 64 else 256) - 8 - want  # the server refuses what is earlier
        if s < want or (self.sync == "free" and s >= most):
            self.change(min(want - s, most))
        elif now - self.window_at >= window:
            if self.least > want + 1:
                self.change(want + self.sim.lockstep - self.least)
            else:
                self.window_at = None

    def change(self, by):
        self.window_at = None
        if by > 0 and by * tick_time(self.sim.step_hz, 1) >= SNAP:
            self.snap(by)
        else:
            self.pending = by
            self.settle = self.number + 2 * max(by, 0) + 1

    # ---- prediction ----

    @property
    def predicts_others(self):
        return self.player["prediction"] and self.player["prediction_scope"] != "own"

    def choose(self, state):
        """What is predicted from this state on, and what others are guessed to do."""
        if not self.predicts_others:
            return
        if state.axes is not None:
            self.guessed = list(state.axes)
        horizon = (self.next_step - state.step) * self.sim.h + (1 / single(self.sim.update_hz) if self.kept else 0)
        everybody = set(range(len(state.world)))
        self.chosen = everybody if self.player["prediction_scope"] == "all" else self.sim.game.reach(self.sim.params, state.world, self.index, horizon)

    def step_world(self, world, axis, step):
        if not self.predicts_others:
            return self.sim.predict(world, self.index, axis, step)
        axes = list(self.guessed)
        axes[self.index] = axis
        return self.sim.game.step(self.sim.params, world, axes, self.sim.h, step * self.sim.h, self.chosen)

    def target_step(self):
        if not self.inputs:
            return self.newest.step
        return max(self.inputs[-1].step - self.input_delay(), self.inputs[0].step - 1, self.newest.step)

    def own_input(self, step):
        for i in reversed(self.inputs):
            if i.step == step:
                return i.axis
        return 0.0

    def newest_felt(self):
        """By number; a snap has left some numbers without an input."""
        return max(self.number - self.input_delay(), self.acked)

    def predict_on(self):
        self.snapped = 0
        if not self.player["prediction"]:
            return
        if not self.player["reconciliation"]:
            by_number = {i.number: i.axis for i in self.inputs}
            while self.felt < self.newest_felt():
                self.felt += 1
                self.world_step += 1
                self.world = self.step_world(self.world, by_number.get(self.felt, 0.0), self.world_step)
            return
        while self.world_step < self.target_step():
            self.world_step += 1
            self.world = self.step_world(self.world, self.own_input(self.world_step), self.world_step)

    def coast(self, step):
        while self.world_step < step:
            self.world_step += 1
            self.world = self.step_world(self.world, 0.0, self.world_step)

    def stands(self, state, before):
        """Whether the prediction from the snapshot before, with the inputs that the client still has, is the newest one."""
        world, guessed, chosen = [list(c) for c in before.world], list(self.guessed), set(self.chosen)
        for step in range(before.step + 1, state.step + 1):
            world = self.step_world(world, self.axes_kept.get(self.number - (self.next_step - 1 - step), 0.0), step)
        self.choose(state)
        alike = (guessed, chosen) == (list(self.guessed), set(self.chosen))
        return alike and all(list(world[i]) == list(state.world[i]) for i in chosen)

    def reconcile(self, state, before):
        if not self.player["prediction"]:
            self.world, self.world_step = [list(c) for c in state.world], state.step
            return
        if self.player["reconciliation"]:
            for _ in range(self.snapped):  # to the step before that of the next input
                self.world_step += 1
                self.world = self.step_world(self.world, self.own_input(self.world_step), self.world_step)
            self.snapped = 0
        if self.player["reconciliation"] and self.number - state.last > INPUTS and self.stands(state, before):
            for i in set(range(len(state.world))) - self.chosen:  # it keeps inputs that the client no longer has
                self.world[i] = list(state.world[i])
            return
        before, before_step = self.world[self.index], self.world_step
        world, step = [list(c) for c in state.world], state.step
        self.choose(state)
        if self.player["reconciliation"]:
            while step < before_step:
                step += 1
                world = self.step_world(world, self.own_input(step), step)
        self.world, self.world_step, self.felt = world, step, self.newest_felt()
        moved = distance(world[self.index], before)
        if moved > 0 and (before_step >= state.step or not self.player["reconciliation"]):
            if self.sim.counts:
                self.corrections += 1
                self.correction_sizes.append(moved)

    # ---- pictures ----

    def absent(self, t):
        """Whom the client does not have at the drawn time."""
        if not self.held or not self.kept:
            return ()
        return ([s for s in self.kept if s.time <= t] or self.kept[:1])[-1].missing

    def draw_predicted(self, picture):
        """Others that are predicted, at the tick of the own entity."""
        if self.predicts_others:
            picture.times = dict.fromkeys(picture.others, picture.others_time)
            for i in self.chosen - {self.index}:
                picture.others[i] = tuple(self.world[i][:2])
                picture.times[i] = tick_time(self.sim.step_hz, self.world_step)

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
        if self.others:
            t = self.server_time(now) if self.kept else t
            places = self.others.places(self.newest.world, t)
        elif player["interpolation"] and self.reference.quarters:
            target = now + self.reference.value() - delay_ns(player, self.sim.update_hz)
            t = self.drawn_time.advance(now, target, self.newest.time, extrapolation)
            places, t = between(self.kept, t), max(t, self.kept[0].time)
        elif extrapolation > 0 and self.reference.quarters:
            c = self.connection
            present = self.server_time(now) if player["extrapolation_clock"] == "measured" else now + self.reference.value()
            t = self.drawn_time.advance(now, present, self.newest.time, extrapolation)
            places, t = between(self.kept, t), max(t, self.kept[0].time)
        picture.buffer = 0 if self.others else self.newest.time - t
        picture.interpolated = bool(not self.others and player["interpolation"] and self.reference.quarters)
        absent = self.absent(t)
        picture.others = {i: p for i, p in enumerate(places) if i != me and i not in absent}
        picture.others_time = t
        self.draw_predicted(picture)
        self.seen = list(self.world[me] if player["prediction"] else self.newest.world[me])
        self.seen[3] = (self.world if self.predicts_others else self.newest.world)[me][3]
        self.sim.observe(self.index, picture)
