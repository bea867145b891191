"""Deterministic lockstep and rollback: docs/netgame.md, the section of that name.

Clients have worlds of their own; the server relays inputs and steps a world that is the truth.
"""

import math

from client import Client, Drawn
from connection import PLAYS
from draws import SECOND, millihertz, ns, single, tick_time, unit
from peer_metrics import peer_distributions, peer_numbers, server_numbers
from server import CONNECT_AGE, LOOK, PONG_BYTES, QUIET, Seat, Server, State
from simulation import Simulation

PACKET_BYTES, RELAY_BYTES, PART_BYTES, HEARD_BYTES, RUN_BYTES, HASH_BYTES = 32, 32, 16, 8, 16, 4
RUNS = 32  # in a packet, of one player
TAKEN = 16  # new inputs that the server takes of a packet
KEPT = 56  # ticks behind the confirmed one of which a client takes inputs
WORLDS = 64  # that a client keeps, and hashes that the server does
HASHES, HASHES_EVERY = 64, 4
WORLD_BYTES, PLAYER_BYTES, OWN_BYTES = 24, 64, 8
STATES = ("connecting", "synchronising", "playing", "stalled", "resynchronising", "disconnected")
PACE_EVERY, PACE_MOST, PACE_MANY = 10, 9, 16
ROUNDING = 1e-12  # in m: two places are as far off, but that two programs round differently
GAP, HOLD_EVERY = 60 * 10**6, 5 * SECOND


def runs(axes):
    """How many runs of equal inputs there are, and how many inputs the first RUNS of them hold."""
    count = 0
    for n, axis in enumerate(axes):
        if n == 0 or axis != axes[n - 1]:
            if count == RUNS:
                return count, n
            count += 1
    return count, len(axes)


class Change:
    """Of a player's controls: by the input for `tick`."""

    def __init__(self, tick, made, lost):
        self.tick, self.made, self.lost = tick, made, lost
        self.applied = False
        self.felt = self.sure = None
        self.seen = {}  # other player: when


class Desync:
    """The first confirmed world that differs from the server's, and how far they are apart from then on."""

    def __init__(self):
        self.tick = self.entity = -1
        self.error = self.most = 0.0

    def compare(self, tick, world, truth):
        if self.tick < 0:
            if world == truth:
                return
            self.tick = tick
            self.entity = next(i for i, car in enumerate(world) if car != truth[i])
        self.error = max(math.hypot(a[0] - b[0], a[1] - b[1]) for a, b in zip(world, truth))
        self.most = max(self.most, self.error)


class Pace:
    """How far one is ahead of another player: by what one hears of it, and by what it hears of one."""

    def __init__(self):
        self.at = None  # its tick, when it was last told
        self.heard = 0
        self.ahead = self.behind = 0.0

    def hear(self, tick, at, told):
        if at is None or (self.at is not None and at <= self.at):
            return
        self.heard = min(self.heard + 1, PACE_MANY)
        share = 1 / self.heard
        self.ahead += share * (tick - at - self.ahead)
        self.behind += share * (told - self.behind)
        self.at = at


class PeerClient(Client):
    def __init__(self, sim, index):
        super().__init__(sim, index)
        n = len(sim.players)
        self.k = 0  # its tick
        self.confirmed = 0
        self.worlds = {0: sim.first_state.world}
        self.known = [0] * n
        self.axes = [{} for _ in range(n)]  # of each player by tick, guesses too
        self.wrong = None  # the first tick that a wrong guess went into
        self.pace = [Pace() for _ in range(n)]
        self.rest = 0
        self.start = self.base = 0  # the world that it began with; own inputs are for the ticks behind `base`
        self.made_at = {}  # tick: when the own input for it was made
        self.open = set()  # ticks of own inputs that have no result
        self.results = {"made": 0, "applied": 0, "lost": 0}
        self.controls = 0.0
        self.changes = []
        self.pictures_void = 0
        self.hashed = 0  # the server has the hashes up to here
        self.server_step = 0  # as relays tell
        self.waiting = False
        self.stalls = self.stalled = self.rested = 0
        self.waited = [0] * n
        self.rollbacks = []  # ticks that each made again
        self.sync_tests = 0
        self.compared = 0  # the newest tick whose world was held against the server's
        self.desync = Desync()
        self.late_tick = None  # with timer_jitter_ms, when the next tick is
        self.round_trips = []
        self.relayed = None  # when the last relay came
        self.gap = False  # relays had stopped, and the server does not know it
        self.hold, self.resume = 0, 0
        self.paced = 0  # looks at the pace are those of ticks so many after a multiple of 10
        self.stepped_at = self.apart_until = 0
        self.begins_round()
        self.newest = State(0, 0, sim.first_state.world)  # `last` is what the server has of the own inputs

    @property
    def unacknowledged(self):
        return self.number - self.newest.last

    @property
    def guesses(self):
        return self.sim.scenario["server"]["max_rollback_ticks"] if self.sync == "rollback" else 0

    def starts_anew(self, now):
        """The world that comes with the accept says with what it begins: `join`."""

    # ---- what comes ----

    def state_comes(self, now, state):
        raise AssertionError("nobody sends states here")

    def receive(self, now, kind, body):
        c, joins = self.connection, self.joins
        if kind == "relay":
            c.hear(now)
            if body["epoch"] == c.epoch:
                self.take_relay(now, body)
        elif kind == "keep":
            self.take_notice(now, body)
        else:
            super().receive(now, kind, body)
            if self.joins > joins and "world" in body:
                self.join(body)

    def take_notice(self, now, body):
        """A keep-alive, or word that one is not connected: an answer that tells nothing of the clock."""
        c = self.connection
        c.hear(now)
        news = c.newest_answer is None or body["answered"] > c.newest_answer
        if news:
            c.newest_answer = body["answered"]
        if c.state in ("connecting", "disconnected"):
            if not body["connected"]:
                c.next_request = now
        elif news and not body["connected"]:
            self.loses_connection(now)

    def loses_connection(self, now):
        super().loses_connection(now)
        self.newest.last = self.number
        self.made_at = {}

    def join(self, body):
        """The game is under way: it begins with the world that the accept has brought."""
        self.start = self.k = self.confirmed = self.hashed = self.compared = body["step"]
        self.desync = Desync()
        self.base = body["first"]
        self.worlds = {self.start: body["world"]}
        self.known = [self.start] * len(self.known)
        self.known[self.index] = self.base
        earlier = self.axes[self.index]
        self.axes = [{} for _ in self.known]
        self.axes[self.index] = {tick: earlier[tick] if tick <= body["own"] else 0.0 for tick in range(self.start + 1, self.base + 1)}
        self.pace = [Pace() for _ in self.known]
        self.stepped_at = self.apart_until = 0
        self.begins_round()
        self.wrong, self.rest, self.waiting = None, 0, False
        self.relayed, self.gap, self.hold, self.resume, self.paced = None, False, 0, 0, 0
        self.number = self.newest.last = 0
        self.controls = 0.0
        for change in self.changes:
            if change.tick in self.open:
                change.lost = True
        self.results["lost"] += len(self.open)
        self.open = set()
        self.made_at = {}
        self.sim.meets(self.index)

    def take_relay(self, now, body):
        self.newest.last = max(self.newest.last, body["has"])
        self.hashed = max(self.hashed, body["hashed"])
        for tick in range(self.server_step + 1, body["step"] + 1):
            if self.sim.counts and tick in self.made_at and tick in self.sim.server.seats[self.index].real:
                self.round_trips.append(now - self.made_at[tick])
        self.server_step = max(self.server_step, body["step"])
        self.hear_hold(now, body)
        for part in body["parts"]:
            other = part["player"]
            self.pace[other].hear(self.k, part["at"], part["ahead"])
            for n, axis in enumerate(part["axes"]):
                self.take_input(other, part["first"] + n, axis)

    def hear_hold(self, now, body):
        before = self.connection.half_trip() if self.relayed is None else self.relayed
        update = int(1e9 / self.sim.update_hz)
        self.gap |= now - before > update + tick_time(self.tick_hz, 1) + max(update, GAP)
        self.relayed = now
        if body["hold"]:
            news = (body["hold"], body["resume"])
            if body["hold"] >= self.known[self.index] and news > (self.hold, self.resume):
                self.hold, self.resume = news
                self.gap = self.hold_is_over(now)

    def hold_is_over(self, now):
        until = tick_time(self.tick_hz, self.resume) - 1000
        return self.resume != 0 and self.connection.shown(now) + self.connection.offset >= until

    def end_hold(self, now):
        if not self.hold_is_over(now):
            return
        self.begins_round()
        self.hold = self.resume = 0
        self.paced = self.ticks - 1
        self.rest = 0
        self.pace = [Pace() for _ in self.pace]

    def begins_round(self):
        self.began, self.round_since, self.apart = self.k, None, 0

    def time_round(self, now):
        """The ticks of a second round are as far apart as the first one was long, by how many they are."""
        many = self.guesses + self.player["input_delay_ticks"] + 1
        if self.round_since is None:
            self.round_since = now
        others = [known for p, known in enumerate(self.known) if p != self.index]
        if self.apart == 0 and many > 1 and others and min(others) > self.began:
            took = now - self.round_since + (tick_time(self.tick_hz, 1) if self.guesses else 0)
            self.apart = min(took, SECOND) // many
            self.apart_until = self.began + 2 * many

    def take_input(self, other, tick, axis):
        if tick != self.known[other] + 1 or tick >= self.confirmed + KEPT:
            return
        if tick <= self.k and self.axes[other][tick] != axis and (self.wrong is None or tick < self.wrong):
            self.wrong = tick
        self.axes[other][tick] = axis
        self.known[other] = tick

    # ---- a tick of its machine ----

    def game_begins(self, epoch):
        if self.connection.state not in ("connecting", "disconnected"):
            self.connection.epoch = epoch

    def next_tick(self):
        return super().next_tick() if self.late_tick is None else self.late_tick

    def set_timer(self, now):
        late = self.player["timer_jitter_ms"]
        self.late_tick = None
        if late > 0:
            share = unit(self.sim.seed, 0x74696D6572 + self.index, (self.connection.epoch << 32) + self.ticks)
            self.late_tick = now + tick_time(self.tick_hz, 1) + ns(late * share)
            while self.machine_time(self.tick_hz, self.ticks + 1) <= self.late_tick:
                self.ticks += 1

    def tick(self, now):
        self.ticks += 1
        if self.connection.state in PLAYS:
            self.play(now)
        else:
            self.miss(now)
        for tick in range(self.compared + 1, min(self.confirmed, self.sim.server.step) + 1):
            self.compared = tick
            kept = self.desync.tick >= 0 or tick > self.sim.server.step - WORLDS
            if kept and tick > self.k - WORLDS + 1:
                self.desync.compare(tick, self.worlds[tick], self.sim.server.history[tick])
        self.set_timer(now)

    def script(self, at, world):
        return single(self.sim.game.SCRIPTS[self.player["script"]](self.sim.seed, self.index, at, world[self.index], self.sim.params))

    def note_controls(self, now, axis, tick):
        """A change is noted; `tick` is None where no input is made."""
        if abs(axis - self.controls) > 1e-6 and self.sim.counts:
            self.changes.append(Change(tick, now, lost=tick is None))
        self.controls = axis

    def miss(self, now):
        self.note_controls(now, self.script(now, self.worlds[self.k]), None)

    def play(self, now):
        delay = self.player["input_delay_ticks"]
        self.roll_back()
        self.end_hold(now)
        self.make_inputs(now, self.k + 1 + delay)
        self.time_round(now)
        if self.may_step(now):
            self.stepped_at = now
            self.make_tick(self.k + 1)
            self.k += 1
            if not self.guesses:
                self.make_inputs(now, self.k + 1 + delay)
            if self.hold:
                self.make_inputs(now, self.k + 1 + delay)
                self.hasten(now)
        self.confirmed = max(self.confirmed, min([self.k] + self.known))
        back = self.sim.scenario["server"]["sync_test_ticks"]
        self.sync_tests += 0 < back <= self.k - self.start and self.sim.counts
        if self.sim.counts:
            self.unacked.append(self.number - self.newest.last)
        self.send_packet(now)

    def hasten(self, now):
        """To a hold, all ticks that it may make at once."""
        while self.k < self.hold and all(known + self.guesses > self.k for known in self.known):
            self.make_tick(self.k + 1)
            self.k += 1
            self.make_inputs(now, self.k + 1 + self.player["input_delay_ticks"])

    def roll_back(self):
        if self.wrong is None:
            return
        before = self.worlds[self.k][self.index]
        for tick in range(self.wrong, self.k + 1):
            self.make_tick(tick)
        if self.sim.counts:
            self.rollbacks.append(self.k - self.wrong + 1)
            moved = abs(self.worlds[self.k][self.index][0] - before[0])
            if moved > 0:
                self.corrections += 1
                self.correction_sizes.append(moved)
        self.wrong = None

    def make_tick(self, tick):
        for axes, known in zip(self.axes, self.known):
            if tick > known:
                axes[tick] = axes.get(known, 0.0)
        self.worlds[tick] = self.sim.step_world(self.worlds[tick - 1], [axes[tick] for axes in self.axes], tick)

    def make_inputs(self, now, upto):
        upto = min(upto, self.hold) if self.hold else upto
        delay = self.player["input_delay_ticks"]
        for tick in range(self.known[self.index] + 1, upto + 1):
            axis = 0.0
            if tick > self.start + delay:
                axis = self.script(tick_time(self.tick_hz, tick), self.worlds[max(self.start, tick - 1 - delay - self.guesses)])
            self.number += 1
            self.results["made"] += 1
            self.open.add(tick)
            self.axes[self.index][tick] = axis
            self.known[self.index] = tick
            self.made_at[tick] = now
            self.note_controls(now, axis, tick)

    def may_step(self, now):
        if self.hold and self.k >= self.hold:
            self.waiting = False
            self.rested += self.sim.counts
            return False
        missing = [p for p, known in enumerate(self.known) if known + self.guesses <= self.k]
        if missing and self.sim.counts:
            self.stalls += not self.waiting
            self.stalled += 1
            for p in missing:
                self.waited[p] += 1
        self.waiting = bool(missing)
        if missing:
            return False
        if self.hold:
            return True
        if self.k <= self.apart_until and now < self.stepped_at + self.apart - tick_time(self.tick_hz, 1) // 2:
            self.rested += self.sim.counts
            return False
        if (self.ticks - self.paced) % PACE_EVERY == 0:
            leads = [(p.ahead - p.behind) / 2 for p in self.pace if p.at is not None]
            self.rest = min(PACE_MOST, int(max(leads + [0.0])))
        if self.rest == 0:
            return True
        self.rest -= 1
        for pace in self.pace:
            pace.ahead -= 1
        self.rested += self.sim.counts
        return False

    def send_packet(self, now):
        first = self.base + self.newest.last + 1
        axes = [self.axes[self.index][tick] for tick in range(first, self.known[self.index] + 1)]
        count, held = runs(axes)
        hashes = []
        if self.ticks % HASHES_EVERY == 0:
            ticks = range(max(self.hashed + 1, self.confirmed - HASHES + 1), self.confirmed + 1)
            hashes = [(tick, self.worlds[tick]) for tick in ticks]  # no two worlds have one hash
        heard = [(known, 0 if pace.at is None else self.k - pace.at) for known, pace in zip(self.known, self.pace)]
        size = PACKET_BYTES + HEARD_BYTES * len(heard) + RUN_BYTES * count + HASH_BYTES * len(hashes)
        self.send(now, "inputs", {"first": first, "axes": axes[:held], "heard": heard, "at": self.k, "hashes": hashes,
                                 "way": self.connection.half_trip() // 1000 + 1, "gap": self.gap}, size)

    # ---- pictures ----

    def display(self, now):
        if not self.with_ticks:
            self.displays += 1
        server, world = self.sim.server, self.worlds[self.k]
        sure = server.times[self.confirmed] if self.confirmed <= server.step else now
        picture = Drawn(now, own=tuple(world[self.index][:2]), own_step=self.k, newest_time=sure)
        picture.others = {i: tuple(car[:2]) for i, car in enumerate(world) if i != self.index}
        picture.others_time = server.times[self.k] if self.k <= server.step else now
        picture.buffer, picture.interpolated = 0, False
        self.sim.observe(self.index, picture)


class PeerSeat(Seat):
    def __init__(self, world, players):
        super().__init__(world)
        self.known = 0  # its inputs have come up to here
        self.at = None
        self.heard = [0] * players  # by it of every player
        self.told = [0] * players  # how far it sees itself ahead
        self.hashed = 0
        self.axes = {}
        self.base = 0  # its inputs are for the ticks behind
        self.real = set()  # ticks of which its own input has come
        self.attempt = 0
        self.answer = None  # the newest that it told of, and when
        self.told_at = 0
        self.drops = 0
        self.reported = -1  # the first tick whose hash was another
        self.packet_at = 0  # when the last packet came
        self.way = None  # in ns, as the last packet told
        self.relayed = 0  # known when relays left last: nobody knows of more


class Referee(Server):
    def __init__(self, sim):
        super().__init__(sim)
        self.seats = [PeerSeat(sim.first_state.world, len(sim.players)) for _ in sim.players]
        self.stalled = 0
        self.begun = False
        self.epoch = 1  # the last that was given out
        self.uneven = False  # a hold is to follow
        self.no_hold_before = 0
        self.hold, self.resume = 0, 0

    def begin(self):
        """The game begins, in a new epoch for all."""
        if not self.begun:
            self.begun = True
            self.epoch += 1
            for seat in self.seats:
                seat.epoch = self.epoch

    def receive(self, now, index, kind, body):
        seat = self.seats[index]
        if kind == "connect":
            again = seat.connected and seat.attempt == body["attempt"]
            fresh = body["answer"] is not None and now - body["answer"] <= CONNECT_AGE
            lets_in = fresh and not again and body["attempt"] >= seat.attempt
            if lets_in:
                self.opens(now, seat, body)
            self.reply(now, index, "accept" if again or lets_in else "pong", body)
        elif kind == "ping":
            if body["answer"] is not None and (seat.answer is None or body["answer"] > seat.answer):
                seat.answer, seat.told_at = body["answer"], now
            self.reply(now, index, "pong", body)
        elif not seat.connected:
            if now - seat.sent >= QUIET:
                self.notice(now, index)
        elif body["epoch"] == seat.epoch:
            self.take(now, seat, body)
            self.follow(now, seat, body)

    def opens(self, now, seat, body):
        """Where inputs stood in for the player its own come behind them."""
        self.epoch += 1
        seat.connected, seat.epoch, seat.attempt = True, self.epoch, body["attempt"]
        seat.answer, seat.told_at = now, now + (now - body["answer"])
        seat.base = seat.known = max(seat.known, self.step)
        seat.heard, seat.hashed = [self.step] * len(self.seats), self.step
        seat.at, seat.told = None, [0] * len(self.seats)
        seat.last_slack, seat.reported = None, -1
        seat.packet_at, seat.way = max(now, 0), None
        seat.relayed = seat.known
        if now >= 0:
            self.uneven, self.no_hold_before = True, now
            self.look_at_hold(now, seat)

    def notice(self, now, index):
        self.send(now, index, "keep", {"answered": now, "connected": self.seats[index].connected}, PONG_BYTES)

    def reply(self, now, index, kind, body):
        seat, size = self.seats[index], PONG_BYTES
        answer = {"asked": body["asked"], "answered": now, "attempt": body.get("attempt"), "connected": seat.connected}
        if kind == "accept" and now >= 0:  # the game is under way
            own = max((tick for tick in range(self.step + 1, seat.base + 1) if tick in seat.real), default=self.step)
            answer.update(step=self.step, first=seat.base, own=own, world=self.world)
            size += WORLD_BYTES + PLAYER_BYTES * len(self.seats) + (OWN_BYTES if own > self.step else 0)
        self.send(now, index, kind, answer, size)

    def look(self, now):
        self.look_at += LOOK
        if self.look_at == 0:  # the game's clocks begin at 0, but with tick 1
            self.look_at += LOOK
        timeout = int(self.sim.timeout_s * SECOND)
        for index, seat in enumerate(self.seats):
            if seat.connected and now - seat.sent >= QUIET:
                self.notice(now, index)
            if seat.connected and 0 < timeout < now - seat.told_at:
                seat.connected = False
                seat.drops += 1
                self.stand_in()

    def take(self, now, seat, body):
        waits = self.resume and body["first"] + len(body["axes"]) - 1 <= self.hold
        for p, (known, ahead) in enumerate(body["heard"]):
            seat.heard[p] = max(seat.heard[p], known)
            if not waits and (seat.at is None or body["at"] >= seat.at):
                seat.told[p] = ahead
        if not waits:
            seat.at = body["at"] if seat.at is None else max(seat.at, body["at"])
        for tick, world in body["hashes"]:
            if seat.hashed < tick <= self.step:
                seat.hashed = tick
                if seat.reported < 0 and tick > self.step - WORLDS and world != self.history[tick]:
                    seat.reported = tick
        before = seat.known
        for n, axis in enumerate(body["axes"]):
            tick = body["first"] + n
            if tick <= before:
                seat.duplicate += 1
            elif tick == seat.known + 1 and tick <= before + TAKEN:
                seat.accepted += 1
                seat.known, seat.axes[tick], seat.last_slack = tick, axis, tick - self.step - 1
                seat.real.add(tick)
        self.stand_in()

    # ---- holds ----

    def follow(self, now, seat, body):
        """What a packet says of a hold."""
        way = body["way"] * 1000
        stopped = now - seat.packet_at - (way if seat.way is None else 0) > 2 * tick_time(self.sim.step_hz, 1) + GAP
        if not (self.resume and body["first"] + len(body["axes"]) - 1 <= self.hold):
            self.uneven |= body["gap"] or stopped
        seat.packet_at, seat.way = now, way
        self.look_at_hold(now, None)

    def look_at_hold(self, now, newcomer):
        there = [s for s in self.seats if s.connected]
        if self.resume:
            if newcomer or all(s.known > self.hold for s in there):
                self.hold = self.resume = 0
            if not newcomer:
                return
        if not self.hold and not (self.uneven and now >= self.no_hold_before):
            return
        self.uneven = False
        if len(there) < 2:
            self.hold = 0
            return
        if self.hold == 0 or any(s.known > self.hold for s in there):
            self.hold = max(self.reach(s, s is newcomer) for s in there)
        elif newcomer:
            self.hold = max(self.hold, self.reach(newcomer, True))
        if all(s.at is not None and s.known == self.hold for s in there):
            self.decide(there)

    def reach(self, seat, new):
        others = min(seat.heard[p] if new else max(s.relayed, seat.heard[p]) for p, s in enumerate(self.seats) if s is not seat)
        delay = seat.known - seat.at if seat.at is not None and seat.known > seat.at else 1
        guesses = self.sim.scenario["server"]["max_rollback_ticks"] if self.sim.sync == "rollback" else 0
        return max(seat.known, others + guesses + delay)

    def decide(self, there):
        hz, updates = self.sim.step_hz, self.sim.update_hz
        told = tick_time(updates, self.updates + 1) + max(s.way + (tick_time(hz, 1) if s.at < self.hold else 0) for s in there)
        tick = 0
        while tick_time(hz, tick) <= told:
            tick += 1
        meets = [k for k in range(tick, tick + 1024) if k * millihertz(updates) % millihertz(hz) == 0]
        self.resume = meets[0] if meets else tick
        self.no_hold_before = tick_time(hz, self.resume) + HOLD_EVERY
        for seat in self.seats:
            seat.at, seat.told = None, [0] * len(self.seats)

    def stand_in(self):
        """For who is not connected."""
        newest = max([self.step] + [seat.known for seat in self.seats if seat.connected])
        for seat in self.seats:
            while not seat.connected and seat.known < newest:
                seat.known += 1
                seat.axes[seat.known] = 0.0

    def has_all(self):
        return all(seat.known > self.step for seat in self.seats)

    def make_step(self, now):
        self.stalled += max(0, now - self.stepped_at - tick_time(self.sim.step_hz, 1))
        self.step += 1
        self.stepped_at = self.times[self.step] = now
        self.world = self.sim.step_world(self.world, [seat.axes[self.step] for seat in self.seats], self.step)
        self.history[self.step] = self.world
        self.sim.server_stepped(now)

    def update(self, now):
        self.updates += 1
        for index, seat in enumerate(self.seats):
            if seat.connected:
                parts = [self.part(seat, index, other) for other in range(len(self.seats)) if other != index]
                size = RELAY_BYTES + sum(PART_BYTES + RUN_BYTES * part["runs"] for part in parts)
                self.send(now, index, "relay", {"step": self.step, "has": seat.known - seat.base, "hashed": seat.hashed, "parts": parts,
                                               "hold": self.hold, "resume": self.resume}, size)

    def part(self, seat, index, other):
        of = self.seats[other]
        first = seat.heard[other] + 1
        axes = [of.axes[tick] for tick in range(first, of.known + 1)]
        count, held = runs(axes)
        of.relayed = of.known
        return {"player": other, "first": first, "axes": axes[:held], "runs": count, "at": of.at, "ahead": of.told[index]}


class PeerSimulation(Simulation):
    def __init__(self, scenario):
        super().__init__(scenario)
        n = len(self.players)
        self.step_hz = scenario["tick_hz"]
        self.h = 1.0 / self.step_hz
        self.clients = [PeerClient(self, i) for i in range(n)]
        self.server = Referee(self)
        self.awaited = [[None] * n for _ in range(n)]  # (tick, place) that a player's screen showed ahead of the server
        self.timeline_errors = [[] for _ in range(n)]

    def step_world(self, world, axes, tick):
        return self.game.step(self.params, world, axes, self.h, tick_time(self.step_hz, tick) / 1e9)

    def next_event(self):
        """(time, rank, player) of what comes next."""
        events = [(self.server.look_at, 5, 0), (tick_time(self.update_hz, self.server.updates + 1), 4, 0)]
        if self.server.has_all():
            events.append((self.now, 3, 0))
        for i, client in enumerate(self.clients):
            events += [(self.flying[way][i][0][0], way, i) for way in (0, 1) if self.flying[way][i]]
            events.append((client.next_time(), 6, i))
        return min(events)

    def handle(self, event):
        if event[0] >= 0 and not self.server.begun:
            self.server.begin()
            for client in self.clients:
                client.game_begins(self.server.epoch)
        if event[1] == 3:
            self.now = event[0]
            self.server.make_step(self.now)
        else:
            super().handle(event)

    def observe(self, index, picture):
        super().observe(index, picture)
        self.note_latencies(index, picture.own_step)
        for other, place in picture.others.items():
            self.note_timeline(index, other, picture.own_step, place[0])

    def note_timeline(self, index, other, tick, x):
        """The others as drawn against the truth of that tick, when it is made; one place at a time."""
        if not self.counts:
            return
        made, errors = self.server.step, self.timeline_errors[index]
        waiting = self.awaited[index][other]
        if waiting is not None and waiting[0] <= made:
            errors.append(abs(waiting[1] - self.server.history[waiting[0]][other][0]))
            waiting = None
        if tick <= made:
            errors.append(abs(x - self.server.history[tick][other][0]))
        elif waiting is None:
            waiting = (tick, x)
        self.awaited[index][other] = waiting

    def note_latencies(self, index, drawn):
        client = self.clients[index]
        for change in client.changes:
            if change.lost:
                continue
            if change.felt is None and change.tick <= drawn:
                change.felt = self.now
            if change.sure is None and change.tick <= min(drawn, client.confirmed):
                change.sure = self.now
        for other, who in enumerate(self.clients):
            heard = min(drawn, client.known[other])
            for change in who.changes:
                there = not change.lost and change.tick in self.server.seats[other].real
                if other != index and there and change.tick <= heard:
                    change.seen.setdefault(index, self.now)

    def server_stepped(self, now):
        super().server_stepped(now)
        step = self.server.step
        for client, seat in zip(self.clients, self.server.seats):
            over = {tick for tick in client.open if tick <= step}  # more than one, where one is made for a step that is over
            client.open -= over
            for tick in over:
                client.results["applied" if tick in seat.real else "lost"] += 1
            for change in client.changes:
                if change.tick in over and not change.lost:
                    change.applied = change.tick in seat.real
                    change.lost = not change.applied

    def meets(self, index):
        """The player begins anew: what its pictures waited for does not come."""
        since = self.scenario["warmup_s"] * SECOND
        self.clients[index].pictures_void += sum(p.at >= since for p in self.waiting[index])
        self.waiting[index] = []
        self.awaited[index] = [None] * len(self.clients)

    def more_distributions(self, index):
        return peer_distributions(self, index)

    def more_numbers(self, index):
        return peer_numbers(self, index)

    def server_numbers(self):
        return server_numbers(self)

    def row(self, k, t):
        super().row(k, t)
        row = self.rows[-1]
        for i, client in enumerate(self.clients):
            name = f"player_{i}_"
            row[name + "remote_error_m"] = self.largest(self.pictures[i])
            row[name + "unacked"] = client.number - client.newest.last
            row[name + "compared_step"], row[name + "desync_m"] = client.compared, client.desync.error
            row[name + "connection"] = STATES.index(client.connection.state)
            row[name + "connected"] = self.server.seats[i].connected

    @staticmethod
    def largest(picture):
        """Of errors that are equal but for rounding either may be told."""
        errors = picture.remote.values() if picture else ()
        most = max(map(abs, errors), default=0)
        return tuple(e for e in errors if abs(e) >= most - ROUNDING) or 0
