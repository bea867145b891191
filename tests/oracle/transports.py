"""Transports beside udp: docs/transports.md. Two ends, each the sender of one direction and the receiver of the other."""

import math
from dataclasses import dataclass, field

from draws import SECOND, trunc_div
from metrics import Distribution

MS = SECOND // 1000
PACKET, IP, FRAGMENT, COUNT = 1200, 28, 4, 4
TYPES = {"keep": "pong"}
WAIT = {"tcp": 40 * MS, "quic": 25 * MS, "webrtc": 200 * MS}
HEADER = {"tcp": 24, "quic": 22, "webrtc": 41}
CHUNK = {"tcp": 2, "quic": 8, "webrtc": 16}
ACK = {"tcp": 4, "quic": 10, "webrtc": 16}
GAP = {"tcp": 8, "quic": 4, "webrtc": 4}
GAPS = {"tcp": 3, "quic": 7, "webrtc": 8}
MSS = {kind: PACKET - HEADER[kind] - ACK[kind] - GAP[kind] * GAPS[kind] - CHUNK[kind] for kind in HEADER}
RTO = {"tcp": (200 * MS, SECOND), "webrtc": (400 * MS, SECOND // 2), "quic": (0, 3 * 333 * MS + 25 * MS)}  # least, first
RTO_MOST, PROBE_MORE, HELD_UNIT, HELD_MOST = 60 * SECOND, 25 * MS, 8000, 25 * MS
USUAL = {"tcp": "reliable_ordered", "quic": "reliable_ordered_by_type", "webrtc": "unreliable"}
NEVER = math.inf


@dataclass(eq=False)
class Message:
    kind: str
    body: dict
    sent: int
    stream: str
    order: int  # in its stream
    first: int  # number of its first chunk
    chunks: int
    came: set = field(default_factory=set)
    again: bool = False  # a chunk of it was sent more than once
    complete: int = None
    over: bool = False  # handed over, or passed over


@dataclass(eq=False)
class Chunk:
    number: int
    message: Message
    size: int
    state: str = "queued"  # flying, done
    times: int = 0  # that it was sent
    sent: int = 0  # when it was last
    packet: int = 0  # that last held it
    misses: int = 0  # acknowledgements of later packets


@dataclass(eq=False)
class Packet:
    number: int
    chunks: list
    ack: object
    kept: int
    reduced: bool = False  # tcp: CWR
    marked: bool = False  # by a link


@dataclass(eq=False)
class Ack:
    """What one end has: all chunks before `next` and some beyond; with quic packets."""
    next: int
    beyond: frozenset
    largest: int = -1
    held: int = 0
    marks: int = 0  # tcp: ECE; quic: how many marked packets have come


def runs(numbers):
    """Neighbours among them, as (first, last), ascending."""
    out = []
    for n in sorted(numbers):
        if out and out[-1][1] == n - 1:
            out[-1] = (out[-1][0], n)
        else:
            out.append((n, n))
    return out


class Receiver:
    """Of chunks; with quic of packets too."""

    def __init__(self, kind):
        self.kind = kind
        self.next = 0  # chunks before it have come, or were given up
        self.chunks = set()
        self.floor = 0  # messages before it are void
        self.packets = []  # runs of packets, the newest first
        self.largest_at = 0
        self.marks = 0

    def note_packet(self, number, now):
        """(new, does not follow the newest)."""
        if self.kind != "quic":
            return True, False
        had = {n for first, last in self.packets for n in range(first, last + 1)}
        gap = bool(self.packets) and number != self.packets[0][1] + 1
        if not self.packets or number > self.packets[0][1]:
            self.largest_at = now
        if number in had or (len(self.packets) == 1 + GAPS["quic"] and number < self.packets[-1][0]):
            return False, gap
        self.packets = runs(had | {number})[::-1][:1 + GAPS["quic"]]
        return True, gap

    def settle(self, before):
        """The sender is done with the messages before this chunk."""
        self.floor = max(self.floor, before)
        self.next = max(self.next, before)
        self.advance()

    def advance(self):
        while self.next in self.chunks:
            self.next += 1

    def take(self, chunk):
        """Whether it is new."""
        if chunk.number < self.floor or chunk.number in self.chunks:
            return False
        self.chunks.add(chunk.number)
        self.advance()
        return True

    def note_marks(self, packet):
        """Of a packet with chunks."""
        if self.kind == "tcp":
            self.marks = 1 if packet.marked else 0 if packet.reduced else self.marks
        elif self.kind == "quic":
            self.marks += packet.marked

    def misses(self):
        return self.next <= max(self.chunks, default=-1)

    def tell(self, now):
        """(acknowledgement, its bytes)."""
        if self.kind == "quic":
            have = frozenset(n for first, last in self.packets for n in range(first, last + 1))
            held = (now - self.largest_at) // HELD_UNIT * HELD_UNIT
            size = ACK["quic"] + GAP["quic"] * (len(self.packets) - 1) + (COUNT if self.marks else 0)
            return Ack(0, have, self.packets[0][1], held, self.marks), size
        blocks = runs(n for n in self.chunks if n > self.next)[-GAPS[self.kind]:]
        size = ACK[self.kind] + GAP[self.kind] * len(blocks) if blocks or self.kind != "tcp" else 0
        return Ack(self.next, frozenset(n for first, last in blocks for n in range(first, last + 1)), marks=self.marks), size


class Trip:
    """Round trips (RFC 6298), in whole ns."""

    def __init__(self):
        self.smooth = self.deviation = self.latest = self.least = None

    def add(self, sample, held):
        self.latest = sample
        self.least = sample if self.least is None else min(self.least, sample)
        if sample - held >= self.least:
            sample -= held
        if self.smooth is None:
            self.smooth, self.deviation = sample, sample // 2
            return
        self.deviation += trunc_div(abs(sample - self.smooth) - self.deviation, 4)
        self.smooth += trunc_div(sample - self.smooth, 8)


class Window:
    """Congestion control."""

    def __init__(self, kind, mss):
        self.kind, self.mss = kind, mss
        self.bytes, self.threshold = 10.0 * mss, NEVER
        self.most, self.root, self.since = 0.0, 0.0, None

    def grow(self, size, trip, now):
        if self.bytes < self.threshold:
            self.bytes += size
        elif self.kind == "reno":
            self.bytes += self.mss * size / self.bytes
        else:
            self.cubic(size, (trip or 0) / SECOND, now)

    def cubic(self, size, trip, now):
        w = self.bytes / self.mss
        if self.since is None:
            self.since, self.most = now, max(self.most, w)
            self.root = ((self.most - w) / 0.4) ** (1 / 3)
        t = (now - self.since) / SECOND
        target = min(0.4 * (t + trip - self.root) ** 3 + self.most, 1.5 * w)
        if target > w:
            w += (target - w) / w * (size / self.mss)
        reno = self.most * 0.7 + (3 * 0.3 / 1.7 * t / trip if trip > 0 else 0)
        self.bytes = max(w, reno) * self.mss

    def reduce(self):
        if self.kind == "cubic":
            self.most, self.since = self.bytes / self.mss, None
        self.threshold = max(self.bytes * (0.5 if self.kind == "reno" else 0.7), 2.0 * self.mss)


class End:
    """One end of a connection."""

    def __init__(self, sim, player, way):
        self.sim, self.player, self.way = sim, player, way  # 0: the client, which sends up
        server = sim.scenario["server"]
        self.kind = server["transport"]
        self.mode = USUAL[self.kind] if self.kind == "tcp" or server["delivery"] == "usual" else server["delivery"]
        self.nagle = server["nagle"] and self.kind == "tcp"
        self.reliable = self.mode.startswith("reliable")
        self.mss = MSS[self.kind]
        self.piece = self.mss // 8 * 8
        self.chunks, self.packets = [], 0
        self.base = self.kept = 0  # chunks that are not done, and their message, begin here
        self.orders = {}
        self.window, self.trip = Window(server["congestion"], self.mss), Trip()
        self.limited = False  # the window has held something back since the last acknowledgement
        self.recovery = 0  # losses of packets from this one on reduce the window
        self.largest = -1  # quic: the newest packet that is known to have come
        self.marks = 0  # quic: that the other end has told of
        self.answers = False  # tcp: the next new chunks say that the window is smaller
        self.backoff, self.expires, self.last_sent, self.loss_at = 0, NEVER, 0, NEVER
        self.got, self.unacked, self.ack_at = Receiver(self.kind), 0, NEVER
        self.incoming, self.turns = [], {}
        self.other = None
        self.stats = dict.fromkeys(("messages", "delivered", "lost", "packets", "ack_packets", "retransmissions", "retransmitted_chunks", "timeouts",
                                    "wire", "payload", "delayed"), 0)
        self.latencies, self.blocked, self.windows = [], [], []

    def count(self, name, by=1):
        if self.sim.counts:
            self.stats[name] += by

    # ---- sending ----

    def send(self, now, kind, body, size):
        stream = TYPES.get(kind, kind)
        order = self.orders[stream] = self.orders.get(stream, -1) + 1
        message = Message(kind, body, now, stream, order, len(self.chunks), -(-size // self.piece))
        self.count("messages")
        for at in range(0, size, self.piece):
            self.chunks.append(Chunk(len(self.chunks), message, min(self.piece, size - at)))
        self.pump(now)

    def queued(self):
        return [c for c in self.chunks[self.base:] if c.state == "queued"]

    def flying(self):
        return [c for c in self.chunks[self.base:] if c.state == "flying"]

    def flight(self):
        return sum(c.size for c in self.flying())

    def waits(self, queue):
        """Nagle's algorithm."""
        return self.nagle and self.flying() and not any(c.times for c in queue) and sum(c.size for c in queue) < self.mss

    def pump(self, now, probe=False):
        """Sends what the window lets, by numbers, whether for the first time or again."""
        while True:
            queue, flight = self.queued(), self.flight()
            if not queue or self.waits(queue):
                return
            anyway, idle = probe or not self.flying(), not self.flying()
            if not anyway and flight + queue[0].size > self.window.bytes:
                self.limited = True
                return
            ack, used = self.tell(now)
            size, chunks = HEADER[self.kind] + used, []
            for c in queue:
                fits = (anyway and not chunks) or flight + c.size <= self.window.bytes
                apart = self.kind == "tcp" and chunks and c.number != chunks[-1].number + 1
                if size + CHUNK[self.kind] + c.size > PACKET or not fits or apart:
                    break
                size, flight = size + CHUNK[self.kind] + c.size, flight + c.size
                chunks.append(c)
            self.send_packet(now, chunks, ack, size)
            self.last_sent = now
            if idle or self.kind == "quic":
                self.start_timer(now, now)
            probe = False

    def tell(self, now):
        """The acknowledgement that goes with a packet, if any."""
        if not self.unacked and self.kind != "tcp":
            return None, 0
        self.unacked, self.ack_at = 0, NEVER
        return self.got.tell(now)

    def send_packet(self, now, chunks, ack, size):
        packet = Packet(self.packets, chunks, ack, self.kept)
        again = sum(c.times > 0 for c in chunks)
        for c in chunks:
            c.times, c.sent, c.packet, c.state, c.misses = c.times + 1, now, self.packets, "flying", 0
            c.message.again |= c.times > 1
        if self.answers and chunks and not again:
            packet.reduced, self.answers = True, False
        self.packets += 1
        mtu = self.sim.players[self.player]["link"][("up", "down")[self.way]]["mtu_bytes"]
        parts = -(-size // mtu) if mtu and size > mtu else 1
        self.count("packets")
        self.count("ack_packets", not chunks)
        self.count("retransmissions", again > 0)
        self.count("retransmitted_chunks", again)
        self.count("wire", size + IP * parts + (FRAGMENT * parts if parts > 1 else 0))
        self.count("payload", sum(c.size for c in chunks))
        if self.sim.counts:
            self.windows.append(self.window.bytes)
        self.sim.put_on_link(self.way, self.player, now, "packet", packet, size)

    def send_ack(self, now):
        ack, used = self.tell(now)
        self.send_packet(now, [], ack, HEADER[self.kind] + used)

    # ---- timers ----

    def start_timer(self, since, now):
        least, first = RTO[self.kind]
        more = PROBE_MORE if self.kind == "quic" else 0
        trip = self.trip
        rto = first if trip.smooth is None else max(least, trip.smooth + max(4 * trip.deviation, MS) + more)
        self.expires = max(since + min(rto << self.backoff, RTO_MOST), now)

    def next_time(self):
        at = min(self.ack_at, self.loss_at, self.expires if self.flying() else NEVER)
        return None if at == NEVER else at

    def wake(self, now):
        if self.loss_at <= now:
            self.find_losses(now)
            self.pump(now)
        elif self.flying() and self.expires <= now:
            self.count("timeouts")
            self.times_out(now)

    def times_out(self, now):
        flying = self.flying()
        if self.kind != "quic":
            self.collapse(self.backoff == 0)
        else:
            oldest, spared, self.recovery = min(c.packet for c in flying), self.recovery, NEVER
            flying = [c for c in flying if c.packet == oldest or not self.reliable]
        for c in flying:
            self.lose(c, now)
        if self.kind == "quic":
            self.recovery = spared
        self.backoff += 1
        if self.kind == "quic" and self.backoff == 3:
            self.collapse(False)
        self.start_timer(now, now)
        self.pump(now, probe=True)

    def collapse(self, reduces):
        if reduces:
            self.window.reduce()
        self.recovery, self.window.bytes = self.packets, float(self.mss)

    def settle(self, now):
        if self.ack_at <= now:
            self.send_ack(now)

    # ---- what the other end has ----

    def take_ack(self, now, ack):
        full = self.limited or self.flight() + self.mss > self.window.bytes
        open_chunks = [c for c in self.chunks[self.base:] if c.state != "done"]
        if self.kind == "quic":
            fresh = [c for c in open_chunks if c.state == "flying" and c.packet in ack.beyond]
            sent = next((c.sent for c in fresh if c.packet == ack.largest), None)
            self.largest = max(self.largest, ack.largest)
        else:
            before = [c for c in self.chunks[self.base:] if c.number < ack.next]
            fresh = [c for c in open_chunks if c.number < ack.next or c.number in ack.beyond]
            once = [c.sent for c in fresh if c.times == 1]
            sent = max(once) if once and not any(c.times > 1 for c in before) else None
        size = sum(c.size for c in fresh if c.state == "flying" and c.packet >= self.recovery)
        for c in fresh:
            c.state = "done"
        if sent is not None:
            self.trip.add(now - sent, min(ack.held, HELD_MOST))
        if sent is not None if self.kind != "quic" else fresh:
            self.backoff = 0
        if fresh:
            self.advance(now, size, full)
        if self.kind == "quic":
            self.find_losses(now)
            if ack.marks > self.marks:
                self.marks = ack.marks
                self.reduces(ack.largest)
        elif fresh:
            newest = max(c.packet for c in fresh)
            for c in self.flying():
                c.misses += c.packet < newest
                if c.misses >= 3 and c.state == "flying":
                    self.lose(c, now)
            if self.kind == "tcp" and ack.marks and self.reduces(newest):
                self.answers = True

    def reduces(self, newest):
        """By a mark: once a round trip, as by a loss."""
        if newest < self.recovery:
            return False
        self.window.reduce()
        self.window.bytes, self.recovery = self.window.threshold, self.packets
        return True

    def advance(self, now, size, full):
        base = self.base
        self.advance_base()
        if self.kind == "quic":
            self.start_timer(self.last_sent, now)
        elif self.base > base:
            self.start_timer(now, now)
        if size > 0 and full:
            self.window.grow(size, self.trip.smooth, now)
        self.limited = False

    def advance_base(self):
        while self.base < len(self.chunks) and self.chunks[self.base].state == "done":
            message = self.chunks[self.base].message
            self.base += 1
            if self.base == message.first + message.chunks:
                self.kept = self.base

    def find_losses(self, now):
        if self.kind != "quic":
            return
        trip = max(self.trip.smooth or 0, self.trip.latest or 0)
        late, self.loss_at = max(trip + trip // 8, MS), NEVER
        for c in self.flying():
            if c.state != "flying" or c.packet > self.largest:
                continue
            if c.packet <= self.largest - 3 or c.sent + late <= now:
                self.lose(c, now)
            else:
                self.loss_at = min(self.loss_at, c.sent + late)

    def lose(self, chunk, now):
        if chunk.state != "flying":
            return
        if chunk.packet >= self.recovery:
            self.window.reduce()
            self.window.bytes, self.recovery = self.window.threshold, self.packets
        if self.reliable:
            chunk.state = "queued"
            return
        self.count("lost")
        for c in self.chunks[chunk.message.first:chunk.message.first + chunk.message.chunks]:
            c.state = "done"
        self.advance_base()

    # ---- receiving ----

    def receive(self, now, packet):
        new, gap = self.got.note_packet(packet.number, now)
        if not new:
            return
        if packet.ack is not None:
            self.take_ack(now, packet.ack)
        self.got.settle(packet.kept)
        if packet.chunks:
            for chunk in packet.chunks:
                gap |= not self.takes(now, chunk)
            gap |= self.kind != "quic" and self.got.misses()
            self.got.note_marks(packet)
            self.unacked += 1
            if gap or self.unacked >= 2:
                self.ack_at = now
            elif self.ack_at == NEVER:
                self.ack_at = now + WAIT[self.kind]
        self.pump(now)
        self.hand_over(now)
        self.settle(now)

    def takes(self, now, chunk):
        if not self.got.take(chunk):
            return False
        message = chunk.message
        if message not in self.incoming:
            self.incoming.append(message)
            self.incoming.sort(key=lambda m: m.first)
        message.came.add(chunk.number)
        if len(message.came) == message.chunks:
            message.complete = now
        return True

    def next_message(self):
        """Whose turn it is, of those that have come whole."""
        self.incoming = [m for m in self.incoming if m.first >= self.got.floor and not m.over]
        for message in self.incoming:
            if self.mode == "reliable_ordered" and message.first != self.turns.get("all", 0):
                return None
            if message.complete is None:
                if self.mode == "reliable_ordered":
                    return None
                continue
            turn = self.turns.get(message.stream, 0)
            if self.mode == "sequenced" and message.order < turn:
                message.over = True
            elif self.mode != "reliable_ordered_by_type" or message.order == turn:
                return message
        return None

    def hand_over(self, now):
        while (message := self.next_message()) is not None:
            message.over = True
            self.turns[message.stream] = message.order + 1
            self.turns["all"] = message.first + message.chunks
            sender = self.other
            sender.count("delivered")
            sender.count("delayed", message.again or message.complete < now)
            if self.sim.counts:
                sender.latencies.append((now - message.sent) / 1e6)
                sender.blocked.append((now - message.complete) / 1e6)
            self.sim.deliver(1 - self.way, self.player, now, message.kind, message.body)


def pairs(sim):
    """The ends of the clients, and those of the server."""
    out = [[End(sim, i, way) for i in range(len(sim.players))] for way in (0, 1)]
    for one, other in zip(*out):
        one.other, other.other = other, one
    return out


def distributions(sim, i):
    out = {}
    for name, ends in zip(("up", "down"), sim.ends):
        out[f"transport_{name}.latency_ms"] = Distribution(ends[i].latencies, "ms")
        out[f"transport_{name}.blocked_ms"] = Distribution(ends[i].blocked, "ms")
    return out


def numbers(sim, i):
    span = sim.now / SECOND - sim.scenario["warmup_s"]
    for name, ends in zip(("up", "down"), sim.ends):
        end = ends[i]
        s = end.stats
        for count in ("messages", "delivered", "lost", "packets", "ack_packets", "retransmissions", "retransmitted_chunks", "timeouts"):
            yield f"transport_{name}.{count}", s[count]
        yield f"transport_{name}.delayed_ratio", s["delayed"] / s["delivered"] if s["delivered"] else None
        if span > 0:
            yield f"transport_{name}.wire_bytes_per_s", s["wire"] / span
            yield f"transport_{name}.header_bytes_per_s", (s["wire"] - s["payload"]) / span
        for fact, of in (("mean", lambda v: math.fsum(v) / len(v)), ("min", min), ("max", max)):
            yield f"transport_{name}.window_bytes.{fact}", of(end.windows) if end.windows else None
