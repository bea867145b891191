"""Spectators of deterministic lockstep and rollback: docs/netgame.md, "Spectators"."""

import heapq

from connection import PLAYS
from draws import tick_time
from links import Link
from metrics import Distribution

FEED_BYTES, PLAYER_BYTES, RUN_BYTES, ACK_BYTES, HEADER = 20, 4, 16, 16, 28
RUNS, KEPT, WORLDS, ASKS = 32, 128, 64, 15
SERVER = -1


def held(axes):
    """How many inputs RUNS runs of equal ones hold, and how many runs there are in that."""
    runs = 0
    for n, axis in enumerate(axes):
        if n == 0 or axis != axes[n - 1]:
            if runs == RUNS:
                return n, runs
            runs += 1
    return len(axes), runs


class Feed:
    """What the sender has of the game for one spectator."""

    def __init__(self):
        self.begun = self.newest = self.settled = self.acked = 0
        self.joins = None
        self.request = self.answered = 0
        self.axes = {}  # tick: of all players

    def follow_client(self, client):
        if self.joins != client.joins:
            self.joins = client.joins
            self.begun = self.newest = self.settled = client.start
        for tick in range(self.newest + 1, client.confirmed + 1):
            self.axes[tick] = [axes[tick] for axes in client.axes]
        self.newest = max(self.newest, client.confirmed)
        self.settled = max(self.settled, min(self.newest, client.base + client.newest.last))

    def follow_server(self, server):
        self.begun = max(self.begun, server.step - KEPT) if server.step - self.newest > KEPT else self.begun
        for tick in range(max(self.newest, self.begun) + 1, server.step + 1):
            self.axes[tick] = [seat.axes[tick] for seat in server.seats]
        self.newest = self.settled = server.step

    def hear(self, known, request):
        self.acked = max(self.acked, known)
        if request and request >= self.answered:
            self.request = request

    def message(self, world, world_bytes):
        """What is to be sent and its size; None: nothing. `world` is None where there is none any more."""
        if self.request and world is not None:
            if self.request != self.answered:
                self.acked = self.settled
            self.answered, self.request = self.request, 0
            return {"world": world, "tick": self.settled}, FEED_BYTES + world_bytes
        first = max(self.acked, self.newest - KEPT, self.begun) + 1
        if first > self.settled:
            return None
        players = list(zip(*(self.axes[tick] for tick in range(first, self.settled + 1))))
        ticks = min(held(axes)[0] for axes in players)
        size = FEED_BYTES + sum(PLAYER_BYTES + RUN_BYTES * held(axes[:ticks])[1] for axes in players)
        return {"first": first, "axes": [self.axes[first + n] for n in range(ticks)]}, size


class Spectator:
    def __init__(self, sim, index, params):
        self.sim, self.params = sim, params
        self.links = [Link(sim.seed, 512 + index, way, 0) for way in (0, 1)]
        self.flying = [[], []]
        self.sends = 0
        self.feed = Feed()
        self.number = self.tick = self.known = 0
        self.asked = None
        self.out = self.heard = self.spoiled = False
        self.axes = {}
        self.world = sim.first_state.world
        self.made, self.made_upto, self.shown = {0: 0}, 0, 0
        self.ages, self.behind = [], []
        self.ticks = self.catch_up = self.waits = self.out_ticks = self.falls = self.all_falls = 0
        self.sent = [[0, 0], [0, 0]]  # messages and bytes

    def next_time(self):
        return tick_time(self.sim.step_hz, self.number + 1)

    def send(self, way, now, body, size):
        if self.sim.counts:
            self.sent[way][0] += 1
            self.sent[way][1] += size + HEADER
        if self.params["player"] != SERVER:
            self.sim.note_sent(self.params["player"], ("down", "relay") if way == 0 else ("up", "inputs"), size)
        for due in self.links[way].send(self.params["link"][("up", "down")[way]], self.params["lag_ms"], now, size):
            self.sends += 1
            heapq.heappush(self.flying[way], (due, self.sends, body))

    def arrived(self, way, now):
        while self.flying[way] and self.flying[way][0][0] <= now:
            yield heapq.heappop(self.flying[way])[2]

    # ---- the sender ----

    def feeds(self, now, sender):
        for body in self.arrived(0, now):
            self.feed.hear(*body)
        if sender == SERVER:
            server = self.sim.server
            self.feed.follow_server(server)
            self.note_made(server.step, server.times)
            world = server.world
        else:
            client = self.sim.clients[sender]
            self.feed.follow_client(client)
            self.note_made(client.k, None)
            settled = self.feed.settled
            world = client.worlds[settled] if settled >= client.start and settled > client.k - WORLDS else None
        message = self.feed.message(world, 24 + 64 * len(self.sim.players))
        if message:
            self.send(1, now, *message)

    def note_made(self, tick, times):
        for made in range(self.made_upto + 1, tick + 1):
            self.made[made] = times[made] if times else self.sim.now
        self.made_upto = max(self.made_upto, tick)

    # ---- the spectator ----

    def receive(self, body):
        self.heard = True
        if "world" in body:
            if self.out and body["tick"] >= self.tick:
                self.world, self.tick, self.known, self.out = body["world"], body["tick"], body["tick"], False
            return
        last = body["first"] + len(body["axes"]) - 1
        if self.out or last <= self.known:
            return
        if body["first"] > self.known + 1 or last - self.tick > self.params["buffer_ticks"]:
            self.out, self.asked = True, None
            self.all_falls += 1
            self.falls += self.sim.counts
            return
        self.axes.update((body["first"] + n, axes) for n, axes in enumerate(body["axes"]))
        self.known = last

    def wake(self, now):
        before = self.tick
        for body in self.arrived(1, now):
            self.receive(body)
        self.number += 1
        ahead = self.known - self.tick
        ticks = 0 if self.out else 2 if ahead > max(1, self.params["behind_ticks"]) else min(1, ahead)
        for _ in range(ticks):
            self.tick += 1
            self.world = self.sim.step_world(self.world, self.axes.pop(self.tick), self.tick)
        self.spoiled |= any(client.desync.tick >= 0 for client in self.sim.clients)  # by arithmetic, or by inputs from before it joined
        if not self.spoiled and self.world != self.sim.server.history.get(self.tick, self.sim.first_state.world):
            raise AssertionError(f"a spectator shows another world at tick {self.tick}")
        if self.tick != before:
            self.shown = self.made[self.tick]
        if self.sim.counts:
            self.ticks += ticks
            self.catch_up += ticks == 2
            self.waits += ticks == 0 and not self.out
            self.out_ticks += self.out
            self.ages.append((now - self.shown) / 1e6)
            self.behind.append(self.known - self.tick)
        self.answer(now)

    def answer(self, now):
        asks = self.out and (self.asked is None or self.number - self.asked >= ASKS)
        if asks or (self.heard and not self.out):
            self.heard = False
            self.asked = self.number if asks else self.asked
            self.send(0, now, (self.known, self.all_falls if asks else 0), ACK_BYTES)

    # ---- metrics ----

    def distributions(self):
        return {"age_ms": Distribution(self.ages, "ms")}

    def numbers(self):
        span, tick_s = self.sim.now / 1e9 - self.sim.scenario["warmup_s"], 1 / self.sim.step_hz
        for name, value in (("tick", self.tick), ("out", self.out), ("ticks", self.ticks), ("catch_up_ticks", self.catch_up),
                            ("waited_s", self.waits * tick_s), ("fell_out", self.falls), ("out_s", self.out_ticks * tick_s)):
            yield name, value
        yield "behind_ticks.count", len(self.behind)
        yield "behind_ticks.mean", sum(self.behind) / len(self.behind) if self.behind else None
        yield "behind_ticks.max", max(self.behind, default=None)
        yield "messages_per_s", self.sent[1][0] / span if span > 0 else None
        yield "wire_bytes_per_s", self.sent[1][1] / span if span > 0 else None
        yield "ack_bytes_per_s", self.sent[0][1] / span if span > 0 else None


def feed(sim, now, sender):
    """After a tick of a client, or an update of the server (SERVER)."""
    if now < 0 or (sender != SERVER and sim.clients[sender].connection.state not in PLAYS):
        return
    for one in sim.spectators:
        if one.params["player"] == sender:
            one.feeds(now, sender)
