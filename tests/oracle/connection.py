"""The client's connection and its clock of the server: docs/netgame.md, "Connection" and "Machines"."""

from draws import SECOND, trunc, trunc_div

AGAIN = {"connecting": SECOND // 2, "disconnected": SECOND // 2, "synchronising": 50 * 10**6, "resynchronising": 50 * 10**6,
         "playing": 250 * 10**6, "stalled": 250 * 10**6}
SILENCE = 100 * 10**6
STALL = SECOND // 2
ANSWERS = 5
RING = 8
ORDER = ("timeout", "stall", "connect", "ping")  # at one instant
PLAYS = ("playing", "stalled", "resynchronising")


class Connection:
    def __init__(self, start, drift_ppm):
        self.drift = drift_ppm * 1e-6
        self.state = "connecting"
        self.ever_played = False
        self.entered = self.since = start
        self.seconds = {}
        self.next_request = start  # when the next connect or ping is sent, as decided when the last was
        self.sent = start
        self.heard = start
        self.epoch = 0
        self.attempt = 1  # to connect; a new one begins with each disconnection
        self.answers = 0
        self.newest_answer = None  # the server's time of the newest answer that came
        self.samples = []  # (round trip, offset), a ring
        self.taken = 0  # samples in all
        self.offset = 0
        self.sampled_at = None

    def shown(self, t):
        """What this machine's clock shows at time t."""
        return t + trunc(t * self.drift)

    # ---- what is due ----

    def due(self, timeout_s):
        """When something happens by itself, and what."""
        events = [(self.next_request, "connect" if self.state in ("connecting", "disconnected") else "ping")]
        if self.state in PLAYS:
            events.append((self.sent + SILENCE, "ping"))
        if self.state == "playing":
            events.append((self.heard + STALL, "stall"))
        if timeout_s > 0 and self.state not in ("connecting", "disconnected"):
            events.append((self.heard + int(timeout_s * SECOND), "timeout"))
        return min(events, key=lambda event: (event[0], ORDER.index(event[1])))

    def enter(self, state, now):
        if state == "playing":
            self.ever_played = True
        if state in ("connecting", "disconnected", "synchronising", "resynchronising"):
            self.next_request = now
            self.answers = 0
        if state in ("connecting", "disconnected"):
            self.attempt += 1
        self.seconds[self.state] = self.seconds.get(self.state, 0) + now - self.since
        self.since = now
        self.state, self.entered = state, now

    # ---- what comes ----

    def hear(self, now):
        """Any packet of the server."""
        self.heard = now
        if self.state == "stalled":
            self.enter("resynchronising", now)

    def answer(self, now, asked_at, answered_at, clock_filter):
        """Accept or pong: a sample of the server's clock."""
        shown = self.shown(now)
        trip = shown - asked_at
        sample = (trip, answered_at - asked_at - trip // 2)
        if len(self.samples) < RING:
            self.samples.append(sample)
        else:
            self.samples[self.taken % RING] = sample
        self.taken += 1
        wanted = FILTERS[clock_filter](self.samples)
        if self.state == "playing":
            off = wanted - self.offset
            if abs(off) >= 100 * 10**6:
                self.offset = wanted
            else:
                most = (shown - self.sampled_at) // 20
                self.offset += max(-most, min(most, off))
        else:
            self.offset = wanted
        self.sampled_at = shown

    def longest(self):
        """Round trip of the last eight."""
        return max((trip for trip, _ in self.samples), default=0)

    def half_trip(self):
        return -(-self.longest() // 2)

    def told(self, now):
        """How long it was in each state."""
        out = dict(self.seconds)
        out[self.state] = out.get(self.state, 0) + now - self.since
        return out


def by_median(samples):
    ordered = sorted(offset for _, offset in samples)
    return ordered[(len(ordered) - 1) // 2]


def by_trip(samples):
    return min(samples, key=lambda s: s[0])[1]


def by_mean(samples):
    first = samples[0][1]
    return first + trunc_div(sum(offset - first for _, offset in samples), len(samples))


FILTERS = {"median": by_median, "min_rtt": by_trip, "mean": by_mean}
