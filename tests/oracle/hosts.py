"""A server on a player's machine, with `free`: docs/netgame.md, the section of that name."""

import heapq
import math

from draws import SECOND, tick_time
from server import LOOK, Seat, State
from simulation import Simulation, distance

ROUTE_BYTES, NEWS_BYTES, RETRY = 16, 32, SECOND // 2
HAS_HOST = ("playing", "synchronising", "resynchronising")


def newest_first(a):
    return -a[0], a[1]


def nearest_first(a):
    return a[1], -a[0]


ORDERS = {"lowest_index": None, "newest_state": newest_first, "best_connection": nearest_first}


class View:
    """What one machine knows of who hosts."""

    def __init__(self, target):
        self.target, self.lost = target, None
        self.since = self.asked = None
        self.tried, self.heard, self.of = set(), set(), {}
        self.again, self.departed = False, set()  # all have been asked; hosts that it lost before
        self.promises, self.bound = False, -math.inf
        self.told = None  # the state that a host has left
        self.without = None
        self.without_sum = self.without_max = 0
        self.set_back = 0.0


class HostedSimulation(Simulation):
    def __init__(self, scenario):
        super().__init__(scenario)
        n = len(self.players)
        rows = self.rules = scenario["hosting"]
        self.order = ORDERS[rows["election"]]
        self.patience = int(rows["patience_s"] * SECOND)
        self.host, self.host_since, self.stopped = rows["host"], -math.inf, None
        self.leaves = int(rows["leaves_s"] * SECOND) if rows["leaves_s"] > 0 else math.inf
        self.views = [View(self.host) for _ in range(n)]
        self.votes = [{} for _ in range(n)]  # of who is asked: player: (until, request)
        self.leases = [math.inf] * n
        self.known_leases = set()
        self.gone = set()
        self.looped = [[] for _ in range(n)]
        self.changes = self.step_downs = self.lost_ticks = self.again_ticks = self.nobody = 0
        self.hosted = [0] * n
        self.host_from = [None] * n
        self.host_from[self.host] = 0

    @property
    def timeout(self):
        return int(self.timeout_s * SECOND)

    # ---- two links ----

    def send_up(self, index, now, kind, body, size):
        if kind == "connect":
            self.asks(index, now, body, size)
        else:
            self.route(now, index, self.views[index].target, "server", kind, body, size)

    def send_down(self, index, now, kind, body, size):
        self.route(now, self.host, index, "client", kind, body, size)

    def route(self, now, a, b, side, kind, body, size):
        message = (a, b, side, kind, body)
        if side == "player":
            self.clients[a].connection.sent = now
        if a == b:
            self.sends += 1
            heapq.heappush(self.looped[a], (now, self.sends, message))
            return
        if self.counts:
            key = (b, "down", kind) if side == "client" else (a, "up", "ping" if side == "player" else kind)
            count, total = self.sent.get(key, (0, 0))
            self.sent[key] = (count + 1, total + size + ROUTE_BYTES)
        self.put(0, a, now, message, size + ROUTE_BYTES)

    def put(self, way, index, now, message, size):
        player, link, name = self.players[index], (self.ups, self.downs)[way][index], ("up", "down")[way]
        for due in link.send(player["link"][name], player["lag_ms"], now, size):
            self.sends += 1
            heapq.heappush(self.flying[way][index], (due, self.sends, size, message))

    def comes(self, way, index, now):
        _, _, size, message = heapq.heappop(self.flying[way][index])
        if way == 0:
            self.put(1, message[1], now, message, size)
        else:
            self.arrives(now, index, message)

    def arrives(self, now, me, message):
        a, _, side, kind, body = message
        if me in self.gone:
            return
        if side == "player":
            self.hears(now, me, a, kind, body)
        elif side == "client":
            if self.views[me].target == a:
                joins = self.clients[me].joins
                self.clients[me].receive(now, kind, body)
                if self.clients[me].joins > joins:
                    self.joins_host(now, me)
        elif self.host == me:
            self.takes_lease(now, a, kind, body)
            self.server.receive(now, a, kind, body)
        elif kind == "connect":
            self.takes_vote(now, me, a, body)

    # ---- events ----

    def server_events(self):
        for event in super().server_events():
            if self.host is not None or event[1] == 5:
                yield event

    def next_event(self):
        best = min((*event, 0) for event in self.server_events())
        for i, client in enumerate(self.clients):
            best = min([best] + [(self.flying[way][i][0][0], way, i) for way in (0, 1) if self.flying[way][i]])
            if self.looped[i]:
                best = min(best, (self.looped[i][0][0], 2, i))
            if i not in self.gone:
                best = min(best, (client.next_time(), 6, i))
        return best

    def handle(self, event):
        now, rank, i = event
        self.now = now
        if rank == 2:
            self.arrives(now, i, heapq.heappop(self.looped[i])[2])
        elif rank == 5 and not self.checks(now):
            self.server.look_at += LOOK
        else:
            super().handle(event)

    # ---- who has lost its host ----

    def newest(self, i):
        client, told = self.clients[i], self.views[i].told
        state = client.arrived if client.kept else self.first_state
        return told if told is not None and told.step > state.step else state

    def loses(self, now, i):
        v, c = self.views[i], self.clients[i].connection
        v.lost, v.since, v.asked, v.tried, v.again = v.target, now, None, set(), False
        v.heard.add(i)
        v.of[i] = (self.newest(i).step, c.longest())
        c.samples, c.taken = [], 0

    def heard_all(self, i):
        v = self.views[i]
        return self.eligible(v) <= v.heard

    def eligible(self, v):
        return set(range(len(self.players))) - {v.lost} - v.departed

    def choose(self, i):
        v = self.views[i]
        known = v.heard | {v.lost} if self.order else set(range(len(self.players)))
        among = known - v.tried if v.again else (known & self.eligible(v)) - v.tried
        if not among:
            v.tried, v.again, among = set(), True, known
        best = min(among, key=lambda p: (*(self.order(v.of.get(p, (0, 0))) if self.order else ()), p))
        v.tried.add(best)
        return best

    def finds(self, now, i):
        v, c = self.views[i], self.clients[i].connection
        if v.asked is None and self.order and not self.heard_all(i) and now - v.since < RETRY:
            return False
        if v.asked is not None and now - v.asked < self.patience:
            return True
        if now < v.bound:
            return False
        if v.asked is not None:
            c.attempt += 1
        v.target, v.asked, v.promises, v.bound = self.choose(i), now, True, now + self.patience
        return True

    def asks(self, i, now, body, size):
        v, c = self.views[i], self.clients[i].connection
        until = now
        if c.ever_played and (v.lost is not None or now - c.heard >= self.timeout):
            if v.lost is None:
                self.loses(now, i)
            if self.order:
                for other in range(len(self.players)):
                    if other != i:
                        self.route(now, i, other, "player", "candidacy", v.of[i], NEWS_BYTES)
            if not self.finds(now, i):
                return
            if v.promises:
                until = now + (v.asked + self.patience - now) // 1000 * 1000
            body = {**body, "attempt": c.attempt}
        self.route(now, i, v.target, "server", "connect", {**body, "until": until}, size)

    def asks_now(self, now, i):
        client = self.clients[i]
        if client.connection.state not in ("connecting", "disconnected"):
            client.loses_connection(now)
        client.connection.next_request = now

    def hears(self, now, me, a, kind, body):
        v, c = self.views[me], self.clients[me].connection
        if kind == "candidacy":
            v.of[a] = body
            v.heard.add(a)
            v.departed.discard(a)
            if v.lost is not None and v.asked is None and self.heard_all(me):
                self.asks_now(now, me)
        elif kind == "farewell":
            if v.target == a and v.lost is None:
                v.told = body
                self.loses(now, me)
                self.asks_now(now, me)
        elif c.state not in HAS_HOST and body != me and (v.lost is not None or body == a):
            if v.lost is not None and v.asked is not None and v.target == body:
                return
            if v.lost is None:
                self.loses(now, me)
            c.attempt += 1
            v.target, v.asked, v.promises = body, now, False
            self.asks_now(now, me)

    def joins_host(self, now, i):
        v = self.views[i]
        if v.lost is not None:
            v.departed.add(v.lost)
        v.departed.discard(v.target)
        v.lost = v.asked = None
        v.tried, v.heard, v.again = set(), set(), False
        if v.promises:
            v.bound = -math.inf
        v.promises = False
        if v.without is not None:
            v.without_sum += now - v.without
            v.without_max = max(v.without_max, now - v.without)
            v.without = None

    # ---- who hosts ----

    def takes_vote(self, now, me, a, body):
        if self.clients[me].connection.state in HAS_HOST and self.views[me].target != me:
            self.votes[me].pop(a, None)
            self.route(now, me, a, "player", "host", self.views[me].target, NEWS_BYTES)
            return
        self.votes[me][a] = (body["until"], body)
        good = {p for p, (until, _) in self.votes[me].items() if until > now + LOOK}
        if me in good and 2 * len(good) > len(self.players):
            self.takes_over(now, me)

    def lease(self, until, now):
        return min(until, now + self.timeout)

    def renews(self, a, until):
        self.leases[a] = until if self.leases[a] == math.inf else max(self.leases[a], until)

    def takes_lease(self, now, a, kind, body):
        if kind not in ("ping", "connect"):
            return
        if body["answer"] is not None and body["answer"] >= self.host_since:
            self.renews(a, body["answer"] + self.timeout)
        if body.get("until", now) > now and kind == "connect":
            self.renews(a, self.lease(body["until"], now))

    def holds(self, at):
        return 2 * (1 + sum(self.leases[p] > at for p in range(len(self.players)) if p != self.host)) > len(self.players)

    def checks(self, now):
        """Before the server's look: false, if nobody hosts."""
        if self.host is not None and now >= 0:
            if now >= self.leaves:
                self.leave(now)
            elif not self.holds(now + LOOK):
                self.step_downs += 1
                self.stops(now)
        return self.host is not None

    def stops(self, now):
        self.hosted[self.host] += now - max(self.host_since, 0)
        self.host, self.stopped = None, now
        for p, v in enumerate(self.views):
            if v.without is None and p not in self.gone:
                v.without = now

    def leave(self, now):
        host = self.host
        if self.rules["leaving"] == "announced":
            world = State(self.server.step, self.server.times[self.server.step], self.server.world)
            for other in range(len(self.players)):
                if other != host:
                    self.route(now, host, other, "player", "farewell", world, NEWS_BYTES + self.state_bytes - 48)
        self.gone.add(host)
        self.leaves = math.inf
        self.stops(now)
        self.clients[host].loses_connection(now)

    def takes_over(self, now, j):
        assert self.host is None
        server, state, votes = self.server, self.newest(j), dict(self.votes[j])
        before, step = server.world, server.step
        self.lost_ticks += max(0, step - state.step)
        while tick_time(self.step_hz, server.step + 1) < now:
            server.step += 1
            server.times[server.step], server.history[server.step] = tick_time(self.step_hz, server.step), before
        self.sets_world(j, state, step)
        for p, v in enumerate(self.views):
            v.set_back += distance(before[p], server.world[p])
        self.begins_server(now)
        for index in range(len(self.players)):
            self.waiting[index] = [p for p in self.waiting[index] if p.own_step <= step or p.own_step > server.step]
        self.host, self.host_since = j, now
        self.changes += 1
        self.nobody += now - self.stopped
        self.leaves = now + int(self.rules["every_s"] * SECOND) if self.rules["every_s"] > 0 else math.inf
        self.host_from[j] = now
        self.leases = [self.lease(votes[p][0], now) if p in votes else 0 for p in range(len(self.players))]
        self.votes[j] = {}
        for p in range(len(self.players)):
            if p in votes and votes[p][0] > now:
                server.receive(now, p, "connect", votes[p][1])
            elif p != j:
                self.route(now, j, p, "player", "host", j, NEWS_BYTES)

    def sets_world(self, j, state, step):
        server = self.server
        server.world = state.world
        if self.rules["meanwhile"] == "run_on":
            client = self.clients[j]
            axes = list(state.axes or [0.0] * len(self.players))
            axes[j] = client.axes_kept.get(client.number, 0.0)
            for k in range(state.step + 1, server.step + 1):
                server.world = self.game.step(self.params, server.world, axes, self.h, tick_time(self.step_hz, k) / 1e9)
                if k > step:
                    server.history[k] = server.world
            self.again_ticks += server.step - state.step
        elif server.step > step:
            server.history[server.step] = server.world

    def begins_server(self, now):
        """It knows nobody."""
        server = self.server
        server.epoch += 1
        server.updates = 0
        while tick_time(self.update_hz, server.updates + 1) < now:
            server.updates += 1
        server.stepped_at = tick_time(self.step_hz, server.step)
        server.times[server.step] = server.stepped_at
        for k, old in enumerate(server.seats):
            seat = server.seats[k] = Seat(server.world)
            for name in ("accepted", "duplicate", "late", "starved", "refused", "drops"):
                setattr(seat, name, getattr(old, name))
            seat.known_answer = seat.known_at = seat.sent = now

    # ---- metrics ----

    def hosting_numbers(self):
        yield "host", self.host
        yield "changes", self.changes
        yield "step_downs", self.step_downs
        yield "without_s", (self.nobody + (self.now - self.stopped if self.host is None else 0)) / 1e9
        yield "lost_ticks", self.lost_ticks
        yield "again_ticks", self.again_ticks

    def more_numbers(self, index):
        v = self.views[index]
        now = 0 if v.without is None else self.now - v.without
        hosts = self.now - max(self.host_since, 0) if self.host == index else 0
        since = self.host_from[index]
        return [("hosting.gone", index in self.gone), ("hosting.hosted_s", (self.hosted[index] + hosts) / 1e9),
                ("hosting.host_from_s", None if since is None else since / 1e9), ("hosting.without_s", (v.without_sum + now) / 1e9),
                ("hosting.without_max_s", max(v.without_max, now) / 1e9), ("hosting.set_back_m", v.set_back)]
