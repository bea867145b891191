"""The sync `gambetta`: docs/netgame.md, "gambetta", and docs/concepts.md."""

from dataclasses import dataclass

from client import Client, Drawn, Input
from draws import SECOND, millihertz, ns, single, tick_time, trunc, unit
from interpolation import KEPT
from server import WORDS, Server, State
from simulation import Simulation

PICTURES = 256
PRESS_S = 1 / 40
OVERTAKEN = 64


@dataclass
class Shown:
    """A state that came, and the display that was the first to have it."""
    state: State
    at: int = None


class DemoClient(Client):
    def __init__(self, sim, index):
        super().__init__(sim, index)
        self.came = self.taken = 0  # states
        self.played = 0  # the newest input in the prediction
        self.begins = True  # the prediction begins with the next look
        self.given_up = set()  # no longer waited for
        self.interval = tick_time(self.tick_hz, 1)
        self.tick_due = self.machine_time(self.tick_hz, 0)
        self.ticked = self.tick_due - self.interval
        self.drawn_others = [(c[0], c[1]) for c in self.newest.world]
        self.drawn_at = 0

    # ---- the machine ----

    def next_tick(self):
        return self.tick_due

    def set_timer(self, now):
        late = self.player["timer_jitter_ms"]
        if late == 0:
            self.tick_due = self.machine_time(self.tick_hz, self.ticks)
            return
        counter = (self.connection.epoch << 32) + self.ticks
        self.tick_due = now + self.interval + ns(late * unit(self.sim.seed, 0x74696D6572 + self.index, counter))
        while self.machine_time(self.tick_hz, self.ticks + 1) <= self.tick_due:
            self.ticks += 1

    def starts_anew(self, now):
        super().starts_anew(now)
        self.played = 0
        self.begins = True
        self.given_up = set()

    # ---- what comes ----

    def state_comes(self, now, state):
        self.came += 1
        self.arrived = state
        self.kept.append(Shown(state))
        del self.kept[:-KEPT]

    def take(self, now):
        if self.came > self.taken:
            self.taken = self.came
            self.newest = self.arrived
            if self.player["ack"] == "per_input":
                self.take_bits(self.newest)
            else:
                self.acked = min(self.newest.last, self.number)
                self.inputs = [i for i in self.inputs if i.number > self.acked]
            if not self.begins or not self.player["prediction"]:
                self.reconcile(self.newest)
        if self.begins:
            self.begins = False
            self.play_again(self.newest)

    def take_bits(self, state):
        """What the state does not include is open, unless it is overtaken by 64."""
        newest = min(state.decided if state.done is not None else state.applied, self.number)
        first = max(1, newest - OVERTAKEN + 1)
        for number in range(self.acked + 1, first):
            self.given_up.add(number)
        self.acked = first - 1
        self.inputs = [i for i in self.made if i.number >= first and i.number not in self.given_up and not self.includes(state, i.number)]
        open_ones = {i.number for i in self.inputs}
        while self.acked < self.number and self.acked + 1 not in open_ones:
            self.acked += 1

    def includes(self, state, number):
        return number <= state.applied if state.done is None else number in state.done

    # ---- inputs ----

    def begin(self):
        self.begun = True

    def tick(self, now):
        elapsed, self.ticked = now - self.ticked, now
        self.take(now)
        self.begin_if_playing(now)
        self.ticks += 1
        if self.begun and self.plays:
            axis = self.script(now)
            if self.player["timer_jitter_ms"] > 0:
                axis = single(axis * (elapsed / self.interval))
            if axis != 0:
                self.make_axis(now, axis)
            if self.sim.counts:
                self.unacked.append(self.unacknowledged)
            self.send_inputs(now)
        self.set_timer(now)

    def make_axis(self, now, axis):
        self.number += 1
        self.unsent += 1
        one = Input(self.number, self.number, axis, now)
        self.made.append(one)
        self.inputs.append(one)
        if self.player["prediction"]:
            self.apply(one)
            self.played = self.number

    def send_inputs(self, now):
        rate, hz = millihertz(self.tick_hz), millihertz(self.player["send_hz"])
        leaves = hz == 0 or hz >= rate or self.ticks * hz // rate != (self.ticks - 1) * hz // rate
        if self.unsent == 0 or not leaves:
            return
        open_ones = max(self.number - self.acked, self.unsent)
        count = min(self.unsent + self.player["redundancy"], open_ones, 16)
        fresh, self.unsent = self.number - self.unsent, 0
        del self.made[:-512]
        self.send(now, "inputs", {"inputs": self.made[-count:], "fresh": fresh}, 16 + 16 * count)

    # ---- prediction ----

    def apply(self, one):
        self.world = self.sim.game.apply(self.sim.params, self.world, self.index, one.axis, self.sim.h)

    def play_again(self, state):
        self.world = [list(c) for c in state.world]
        if not self.player["prediction"]:
            return
        for one in self.inputs if self.player["reconciliation"] else []:
            self.apply(one)
        self.played = max(self.number, self.acked)

    def reconcile(self, state):
        before = self.world[self.index][0]
        self.play_again(state)
        moved = abs(self.world[self.index][0] - before)
        if moved != 0 and self.player["prediction"] and self.sim.counts:
            self.corrections += 1
            self.correction_sizes.append(moved)

    # ---- pictures ----

    def display(self, now):
        if not self.with_ticks:
            self.displays += 1
        self.take(now)
        player, me = self.player, self.index
        picture = Drawn(now, newest_time=self.newest.time)
        picture.predicted = bool(player["prediction"])
        own = self.world if picture.predicted else self.newest.world
        picture.own = tuple(own[me][:2])
        picture.own_step = self.played if picture.predicted else self.newest.step
        picture.buffer = 0
        picture.interpolated = bool(player["interpolation"] and self.kept)
        if picture.interpolated:
            self.interpolate(now, picture)
        else:
            self.drawn_others, self.drawn_at = [(c[0], c[1]) for c in self.newest.world], self.newest.time
        picture.others = {i: p for i, p in enumerate(self.drawn_others) if i != me}
        picture.others_time = self.drawn_at
        self.sim.observe(me, picture)

    def interpolate(self, now, picture):
        for shown in self.kept:
            shown.at = now if shown.at is None else shown.at
        render = now - trunc(1e9 / single(self.sim.update_hz))
        picture.buffer = self.kept[-1].at - render
        behind = [k for k, shown in enumerate(self.kept) if shown.at <= render]
        if not behind or behind[-1] == len(self.kept) - 1:
            return  # they stay where they were drawn
        a, b = self.kept[behind[-1]], self.kept[behind[-1] + 1]
        f = (render - a.at) / (b.at - a.at)
        self.drawn_others = [(p[0] + f * (q[0] - p[0]), p[1] + f * (q[1] - p[1])) for p, q in zip(a.state.world, b.state.world)]
        self.drawn_at = a.state.time + trunc(f * (b.state.time - a.state.time))


class DemoServer(Server):
    def input_comes(self, now, seat, one, fresh):
        if one.number in seat.numbers:
            seat.duplicate += 1
            return
        longest = max(1.0, PRESS_S * millihertz(self.sim.scenario["tick_hz"]) / 1000)  # in ticks
        if abs(single(one.axis / longest)) > 1 and self.sim.scenario["server"]["validation"]:
            seat.refused += 1
            return
        seat.numbers.add(one.number)
        seat.accepted += 1
        seat.inputs[one.number] = one

    def make_step(self, now):
        self.step += 1
        self.times[self.step] = now
        for index, seat in enumerate(self.seats):
            for number in sorted(seat.inputs):
                one = seat.inputs.pop(number)
                self.world = self.sim.game.apply(self.sim.params, self.world, index, one.axis, self.sim.h)
                seat.last, seat.applied = number, max(seat.applied, number)
                seat.done.add(number)
        self.history[self.step] = self.world
        self.sim.server_stepped(now)
        self.update(now)

    def decided(self, seat):
        return seat.applied

    def told_since(self, _seat):
        return WORDS * 32


class DemoSimulation(Simulation):
    client_type, server_type = DemoClient, DemoServer

    def __init__(self, scenario):
        super().__init__(scenario)
        self.kept = [{} for _ in self.players]  # pictures that are ahead of the server, by number modulo the ring

    def server_events(self):
        yield self.server.look_at, 5
        yield tick_time(self.update_hz, self.server.step + 1), 3

    def more_numbers(self, index):
        yield "inputs.refused.magnitude", self.server.seats[index].refused

    def observed(self, index, picture):
        """Pictures of the own entity: by the newest input in them, where they are predicted."""
        server, seat = self.server, self.server.seats[index]
        if not picture.predicted:
            where, at = server.history[picture.own_step][index][0], server.times[picture.own_step]
            self.note(index, picture, where, at)
        elif picture.own_step == seat.last:
            self.note(index, picture, server.world[index][0], server.times[server.step])
        elif picture.own_step > seat.last:
            self.kept[index][picture.own_step % PICTURES] = picture

    def server_stepped(self, now):
        for index, seat in enumerate(self.server.seats):
            kept, number = self.kept[index], seat.last
            p = kept.get(number % PICTURES)
            if p and number and p.own_step == number:
                del kept[number % PICTURES]
                self.note(index, p, self.server.world[index][0], now)
            self.kept[index] = {k: p for k, p in kept.items() if p.own_step >= number}

    def joined(self, index):
        self.kept[index] = {}

    def note(self, index, picture, where, at):
        error, lead = abs(picture.own[0] - where), (at - picture.at) / 1e6
        self.compared[index] = (error, lead)
        if picture.at >= self.scenario["warmup_s"] * SECOND:
            self.comparisons[index].append((error, lead))
