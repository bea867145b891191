"""All of it: links, server, clients and the order of events (docs/netgame.md)."""

import heapq
import math
from dataclasses import replace

import demo
import race
import reckoning
import selection
import swarm
import transports
from client import Client
from draws import SECOND, distance, last_tick_at, millihertz, ns, tick_time
from links import Link
from scenario import change
from server import Server, State
from views import Screen

LOBBY = 10 * SECOND
PLACES = 256  # for pictures of steps to come, by step
GAMES = {"race": race, "gambetta": demo, "swarm": swarm}



def signed(a, b):
    """How far apart two places are, with the sign of their difference in x."""
    return math.copysign(distance(a, b), a[0] - b[0])


class Simulation:
    client_type, server_type = Client, Server

    def __init__(self, scenario):
        self.scenario = scenario
        self.players = scenario["players"]
        self.seed = scenario["seed"]
        self.game, self.params = GAMES[scenario["game"]], scenario["params"]
        self.sync = scenario["server"]["sync"]
        self.reckons = scenario["reckoning"]["model"] != "none"
        self.selects = scenario["server"]["snapshot_encoding"] in selection.ENCODINGS
        self.lockstep = self.sync in ("lockstep", "lockstep_pipelined")
        self.buckets = self.sync == "bucket"
        self.by_updates = self.lockstep or self.buckets
        self.step_hz = scenario["server"]["update_hz"] if self.by_updates else scenario["tick_hz"]
        self.h = 1000.0 / millihertz(self.step_hz)
        self.now = -LOBBY
        self.first_state = State(0, 0, self.game.start(self.params, self.players))
        once, each = self.game.BODY_BYTES
        self.state_bytes = 48 + once + each * len(self.first_state.world)
        places = [int(1.3 * scenario["tick_hz"]) + 32, 156]
        self.ups = [Link(self.seed, i, 0, places[0]) for i in range(len(self.players))]
        self.downs = [Link(self.seed, i, 1, places[1]) for i in range(len(self.players))]
        for links, way in ((self.ups, "up"), (self.downs, "down")):
            for link, player in zip(links, self.players):
                name = player["link"][way]["profile"]
                link.ecn = name != "none" and scenario["profiles"][int(name[-1])].get("ecn", False)
        self.flying = [[[] for _ in self.players], [[] for _ in self.players]]
        self.sends = 0
        self.sent = {}
        self.ends = transports.pairs(self) if scenario["server"]["transport"] != "udp" else ()
        self.clients = [self.client_type(self, i) for i in range(len(self.players))]
        self.server = self.server_type(self)
        self.rows = []
        self.pictures = [None] * len(self.players)
        self.waiting = [[] for _ in self.players]  # pictures whose step the server has not made
        self.drawn = [[] for _ in self.players]  # every picture that counts
        self.comparisons = [[] for _ in self.players]
        self.screens = [Screen(len(self.first_state.world), i) for i in range(len(self.players))]
        self.errors = [([], []) for _ in self.players]  # as drawn, of the near and of the far
        self.displayed = [c.phase - tick_time(c.display_hz, 1) for c in self.clients]  # when each drew last
        self.compared = [(0.0, 0.0)] * len(self.players)  # own timeline error and lead, as last known

    @property
    def counts(self):
        """Whether metrics count yet."""
        return self.now >= self.scenario["warmup_s"] * SECOND

    @property
    def update_hz(self):
        return self.scenario["server"]["update_hz"]

    @property
    def timeout_s(self):
        return self.scenario["server"]["timeout_s"]

    # ---- packets ----

    def send_up(self, index, now, kind, body, size):
        self.sends_on(0, "up", index, now, kind, body, size)

    def send_down(self, index, now, kind, body, size):
        self.sends_on(1, "down", index, now, kind, body, size)

    def sends_on(self, way, name, index, now, kind, body, size):
        key = (index, name, kind)
        if self.counts:
            count, total = self.sent.get(key, (0, 0))
            self.sent[key] = (count + 1, total + size)
        if self.ends:
            self.ends[way][index].send(now, kind, body, size)
        else:
            self.put_on_link(way, index, now, kind, body, size)

    def put_on_link(self, way, index, now, kind, body, size):
        player, link, name = self.players[index], (self.ups, self.downs)[way][index], ("up", "down")[way]
        dues = link.send(player["link"][name], player["lag_ms"], now, size)
        for due, marked in zip(dues, link.marks):
            self.sends += 1
            heapq.heappush(self.flying[way][index], (due, self.sends, kind, replace(body, marked=True) if marked and self.ends else body))

    def comes(self, way, index, now):
        """What the link brings."""
        _, _, kind, body = heapq.heappop(self.flying[way][index])
        if self.ends:
            self.ends[1 - way][index].receive(now, body)
        else:
            self.deliver(way, index, now, kind, body)

    def deliver(self, way, index, now, kind, body):
        if way == 0:
            self.server.receive(now, index, kind, body)
        else:
            self.clients[index].receive(now, kind, body)

    # ---- events ----

    def server_events(self):
        """(time, rank) of what the server does next."""
        yield self.server.look_at, 5
        if self.buckets:
            delay = ns(self.scenario["bucket_delay_ms"])
            yield tick_time(self.step_hz, self.server.step + 1) + delay - tick_time(self.step_hz, last_tick_at(self.step_hz, delay)), 3
        elif not self.lockstep:
            yield tick_time(self.step_hz, self.server.step + 1), 3
            yield tick_time(self.update_hz, self.server.updates + 1), 4
        elif self.server.lockstep_due() is not None:
            yield self.server.lockstep_due(), 3

    def next_event(self):
        """(time, rank, player) of what comes next."""
        best = min((*event, 0) for event in self.server_events())
        for i, client in enumerate(self.clients):
            for way in (0, 1):
                if self.flying[way][i]:
                    best = min(best, (self.flying[way][i][0][0], way, i))
            for ends in self.ends:
                if ends[i].next_time() is not None:
                    best = min(best, (ends[i].next_time(), 2, i))
            best = min(best, (client.next_time(), 6, i))
        return best

    def handle(self, event):
        now, rank, i = event
        self.now = now
        if rank <= 1:
            self.comes(rank, i, now)
        elif rank == 2:
            for ends in self.ends:
                ends[i].wake(now)
                ends[i].settle(now)
        elif rank == 3:
            self.server.make_step(now)
            if self.by_updates:
                self.server.update(now)
        elif rank == 4:
            self.server.update(now)
        elif rank == 5:
            self.server.look(now)
        else:
            self.clients[i].wake(now)

    def run(self):
        ticks = int(self.scenario["duration_s"] * self.scenario["tick_hz"])
        timeline = list(self.scenario["timeline"] or [])
        hz = self.scenario["tick_hz"]
        while self.next_event()[0] < 0:
            self.handle(self.next_event())
        self.server.begin()
        for client in self.clients:
            client.game_begins(self.server.epoch)
        for k in range(ticks + 1):
            end = tick_time(hz, k)
            while True:
                event = self.next_event()
                if event[0] > end:
                    break
                self.handle(event)
            self.now = end
            while timeline and timeline[0]["at_s"] * hz <= k:
                for path, value in timeline.pop(0)["set"].items():
                    change(self.scenario, path, value)
            self.row(k, end)
        return self

    # ---- what one sync tells beside the common metrics ----

    def more_distributions(self, index):
        if self.ends:
            return transports.distributions(self, index)
        return reckoning.distributions(self, index) if self.reckons else {}

    def more_numbers(self, index):
        if self.ends:
            return transports.numbers(self, index)
        if self.selects:
            return selection.numbers(self, index)
        return reckoning.numbers(self, index) if self.reckons else ()

    def server_numbers(self):
        return ()

    # ---- the game ----

    def predict(self, world, me, axis, step):
        return self.game.step_alone(self.params, world, me, axis, self.h, step * self.h)

    # ---- what the observer sees ----

    def observe(self, index, picture):
        self.pictures[index] = picture
        truth = self.server.world
        picture.times = picture.times or dict.fromkeys(picture.others, picture.others_time)
        picture.lead = signed(picture.own, truth[index])
        picture.remote = {i: signed(p, truth[i]) for i, p in picture.others.items()}
        elapsed, self.displayed[index] = picture.at - self.displayed[index], picture.at
        if self.counts:
            self.drawn[index].append(picture)
            self.screens[index].add(picture, truth, elapsed)
            for i, error in picture.remote.items() if self.selects else ():
                far = distance(truth[i], truth[index]) > self.scenario["server"]["interest_radius_m"] / 4
                self.errors[index][far].append(abs(error))
        self.observed(index, picture)

    def observed(self, index, picture):
        """The own entity against the truth at the picture's step, as soon as that is known."""
        self.waiting[index] = [p for p in self.waiting[index] if (p.own_step - picture.own_step) % PLACES] + [picture]
        self.compare(index)

    def joined(self, index):
        """A player was let in again: pictures of steps to come are void."""
        self.waiting[index] = []

    def server_stepped(self, now):
        for i in range(len(self.players)):
            self.compare(i)

    def compare(self, index):
        left = []
        for p in self.waiting[index]:
            if p.own_step > self.server.step:
                left.append(p)
                continue
            at = self.server.times[p.own_step]
            error, lead = (distance(p.own, self.server.history[p.own_step][index]), (at - p.at) / 1e6)
            self.compared[index] = (error, lead)
            if p.at >= self.scenario["warmup_s"] * SECOND:
                self.comparisons[index].append((error, lead))
        self.waiting[index] = left

    def row(self, k, t):
        row = {"time_s": t / 1e9, "tick": k, "server_step": self.server.step}
        for i, car in enumerate(self.server.world[:len(self.players)]):
            row[f"server_{i}_x_m"], row[f"server_{i}_y_m"], row[f"server_{i}_vx_mps"] = car[0], car[1], car[2]
        for i, p in enumerate(self.pictures):
            name = f"player_{i}_"
            car = self.first_state.world[i]
            row[name + "own_x_m"], row[name + "own_y_m"] = p.own if p else (car[0], car[1])
            row[name + "own_timeline_error_m"], row[name + "own_lead_ms"] = self.compared[i]
            row[name + "own_lead_m"] = p.lead if p else 0
            row[name + "remote_error_m"] = max(reversed(list(p.remote.values())), key=abs) if p and p.remote else 0
            row[name + "view_age_ms"] = max(0, *(p.at - t for t in p.times.values())) / 1e6 if p and p.remote else 0
            row[name + "age_of_information_ms"] = (p.at - p.newest_time) / 1e6 if p else 0
            row[name + "buffer_ms"] = p.buffer / 1e6 if p else 0
            row[name + "unacked"] = self.clients[i].unacknowledged
            row[name + "corrections"] = self.clients[i].corrections
            row[name + "lag_ms"] = self.players[i]["lag_ms"]
        self.rows.append(row)
