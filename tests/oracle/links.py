"""One direction of a player's link: docs/links.md, stage by stage."""

import math

from draws import normal, ns, phi, quantile, unit

LOSS, DUPLICATE, DELAY, REORDER, CORRUPT, TRANSITION = 0, 1, 2, 4, 5, 6
FRAGMENT_HEADER = 4
NEVER = -(10**18)


def open_window(row, name, now):
    length = ns(row[name + "_length_ms"])
    if length <= 0:
        return False
    since = now - ns(row[name + "_at_ms"])
    if since < 0:
        return False
    every = ns(row[name + "_every_ms"])
    if every > 0:
        since %= every
    return since < length


def pareto(u):
    return ((1 - 0.999 * u) ** (-1 / 3) - 55 / 37) / 0.702182759825220524


def cut_normal(u):
    a = 3.16712418331199e-5
    return quantile(a + u * (1 - 2 * a)) / 0.999464501807080


VARIATES = {
    "uniform": lambda u: 2 * u - 1,
    "normal": cut_normal,
    "pareto": pareto,
    "paretonormal": lambda u: (cut_normal(u) + 3 * pareto(u)) / (4 * 0.957961055882941),
}

CORRELATIONS = {
    "uniform": lambda c: 2 * math.sin(math.pi * c / 6),
    "normal": lambda c: c,
    "pareto": lambda c: c * (1.63449 + c * (-1.24896 + c * (1.10949 + c * (-0.678146 + 0.183126 * c)))),
    "paretonormal": lambda c: c * (1.3142 + c * (-0.4234 + c * (0.140642 - 0.031442 * c))),
}


class Chain:
    """Something that happens to `pct` of the packets, correlated by `corr_pct`."""

    def __init__(self):
        self.of = None  # the last packet that drew, and whether it happened
        self.happened = False

    def asks(self, k, pct, corr_pct, u, copy):
        before = k if copy else k - 1
        p = pct * (1 - corr_pct / 100) + (corr_pct if self.of == before and self.happened else 0)
        result = 100 * u < p
        if not copy:
            self.of, self.happened = k, result
        return result


class LossState:
    """The states of the three loss models."""

    def __init__(self):
        self.of, self.model, self.state = None, None, None

    def lost(self, row, k, u, t, copy):
        model = row["loss_model"]
        before = k if copy else k - 1
        state = self.state if (self.of, self.model) == (before, model) else None
        lost, state = MODELS[model](row, state, u, t)
        if not copy:
            self.of, self.model, self.state = k, model, state
        return lost


def loss_random(row, state, u, _t):
    p = row["loss_pct"] * (1 - row["loss_corr_pct"] / 100) + (row["loss_corr_pct"] if state else 0)
    lost = 100 * u < p
    return lost, lost


def loss_gemodel(row, state, u, t):
    state = state or "good"
    lost = 100 * u < (row["ge_1k_pct"] if state == "good" else row["ge_1h_pct"])
    if 100 * t < (row["ge_p_pct"] if state == "good" else row["ge_r_pct"]):
        state = "bad" if state == "good" else "good"
    return lost, state


def loss_state(row, state, _u, t):
    state, x = state or 1, 100 * t
    if state == 1:
        new = 4 if x < row["p14_pct"] else 3 if x < row["p14_pct"] + row["p13_pct"] else 1
    elif state == 2:
        new = 3 if x < row["p23_pct"] else 2
    elif state == 3:
        new = 2 if x < row["p32_pct"] else 1 if x < row["p32_pct"] + row["p31_pct"] else 3
    else:
        new = 1
    return new in (3, 4), new


MODELS = {"random": loss_random, "gemodel": loss_gemodel, "state": loss_state}


class Link:
    def __init__(self, seed, player, direction, places):
        self.seed, self.base, self.places = seed, 8 * (2 * player + direction), places
        self.messages = self.packets = 0
        self.duplicates, self.corruptions, self.reorders = Chain(), Chain(), Chain()
        self.losses = LossState()
        self.z_of, self.z = None, 0.0
        self.since_ahead = 0
        self.queue_free = NEVER  # X
        self.rate_through = NEVER  # E
        self.rate_taken = []  # E of every packet that the rate took
        self.latest_due = None  # L
        self.held = []  # when what takes a place comes
        self.lobby = True
        self.ecn = False  # its profile marks what the loss model would drop
        self.marks = []  # of what the last message brings: whether it is marked
        self.clear()

    def clear(self):
        """What the metrics tell counts from time 0."""
        self.stats = dict.fromkeys(
            ("sent", "lost", "lost_in_blackouts", "duplicated", "rescued", "corrupted", "overflowed", "queue_drops", "reordered_ahead",
             "messages", "messages_lost", "marked", "split", "split_lost", "fragments", "fragments_lost", "loss_draws", "loss_hits", "bursts",
             "burst_packets"), 0)
        self.delays = []
        self.queue_waits = []

    def unit(self, stage, counter):
        return unit(self.seed, self.base + stage, counter)

    def send(self, row, lag_ms, now, size):
        """The times at which the message comes, in the order of the packets."""
        m = self.messages
        self.messages += 1
        if self.lobby and now >= 0:
            self.lobby = False
            self.clear()
        self.stats["messages"] += 1
        mtu = row["mtu_bytes"]
        if not mtu or size <= mtu:
            due, self.marks = self.packet(row, lag_ms, now, size, m, [True])
            if not due:
                self.stats["messages_lost"] += 1
            return due
        n = -(-size // mtu)
        self.stats["split"] += 1
        self.stats["fragments"] += n
        firsts, marked = [], False
        room = [True]
        for f in range(n):
            part = mtu if f < n - 1 else size - mtu * (n - 1)
            due, marks = self.packet(row, lag_ms, now, part + FRAGMENT_HEADER, m + (f << 40), room)
            if due:
                firsts.append(min(due))
                marked |= any(marks)
            else:
                self.stats["fragments_lost"] += 1
        if len(firsts) < n:
            self.stats["messages_lost"] += 1
            self.stats["split_lost"] += 1
            return []
        self.marks = [marked]
        return [max(firsts)]

    def packet(self, row, lag_ms, now, size, counter, _room):
        """One packet and perhaps its copy: the times at which they come, and whether they are marked."""
        k = self.packets
        self.packets += 1
        self.stats["sent"] += 1
        two = False  # of the packet, from here on
        if row["duplicate_pct"] > 0:
            two = self.duplicates.asks(k, row["duplicate_pct"], row["duplicate_corr_pct"], self.unit(DUPLICATE, counter), False)
        self.stats["duplicated"] += two
        lost, dark = self.loses(row, now, k, counter, False)
        lost, mark = self.marked_or(lost, dark)
        if two and lost and not dark:
            self.stats["rescued"] += 1
            self.stats["lost"] += 1
            lost, two = False, False
        due = self.travels(row, lag_ms, now, size, k, counter, False, lost)
        marks = [mark] * len(due)
        if two:
            other = MASK64 - counter
            lost_too, mark = self.marked_or(*self.loses(row, now, k, other, True))
            more = self.travels(row, lag_ms, now, size, k, other, True, lost_too)
            due, marks = due + more, marks + [mark] * len(more)
        return due, marks

    def marked_or(self, lost, dark):
        """(lost, marked): a loss may be a mark, but for a blackout's."""
        if not self.ecn or dark or not lost:
            return lost, False
        self.stats["marked"] += 1
        return False, True

    def loses(self, row, now, k, counter, copy):
        if row["loss_model"] == "random" and row["loss_pct"] <= 0 and row["blackout_length_ms"] <= 0:
            return False, False
        u, t = self.unit(LOSS, counter), self.unit(TRANSITION, counter)
        lost = self.losses.lost(row, k, u, t, copy)
        dark = open_window(row, "blackout", now)
        self.stats["loss_draws"] += 1
        self.stats["loss_hits"] += lost or dark
        return lost or dark, dark

    def travels(self, row, lag_ms, now, size, k, counter, copy, lost):
        damaged = False
        if row["corrupt_pct"] > 0:
            damaged = self.corruptions.asks(k, row["corrupt_pct"], row["corrupt_corr_pct"], self.unit(CORRUPT, counter), copy)
        if lost:
            self.stats["lost"] += 1
        rate = row["rate_kbps"]
        transmit_ms = 8 * (size + row["packet_overhead_bytes"]) / rate if rate > 0 else 0.0
        transmit = ns(transmit_ms)
        dropped = lost
        if rate > 0 and not dropped:
            wait = max(self.rate_through, now) - now + transmit
            queued = sum(1 for e in self.rate_taken if e > now)
            if transmit_ms > row["limit_ms"] or wait > ns(row["limit_ms"]) or queued >= row["limit_packets"]:
                self.stats["queue_drops"] += 1
                dropped = True
        delay_ms = lag_ms + row["delay_ms"]
        if row["jitter_ms"] > 0:
            delay_ms = delay_ms + row["jitter_ms"] * VARIATES[row["distribution"]](self.uniform_of_delay(row, k, counter, copy))
            delay_ms = max(delay_ms, 0.0)
        if open_window(row, "spike", now):
            delay_ms = delay_ms + row["spike_add_ms"]
        ahead = False
        if row["reorder_pct"] > 0:
            ahead = self.goes_ahead(row, k, counter, copy)
        if dropped:
            return []
        if ahead:
            self.stats["reordered_ahead"] += 1
            delay_ms = lag_ms
        due = now + ns(delay_ms)
        if rate > 0 and not ahead:
            arrived = due
            due = self.queue_free = max(self.queue_free, due) + transmit
            self.rate_through = max(self.rate_through, now) + transmit
            self.rate_taken.append(self.rate_through)
            self.queue_waits.append(due - arrived)
        if damaged:
            self.stats["corrupted"] += 1
            return []
        if row["order"] == "fifo" and self.latest_due is not None:
            due = max(due, self.latest_due)
        self.latest_due = due if self.latest_due is None else max(due, self.latest_due)
        self.delays.append(delay_ms if due == now + ns(delay_ms) else (due - now) / 1e6)
        return [due]

    def uniform_of_delay(self, row, k, counter, copy):
        if row["delay_corr_pct"] <= 0:
            return self.unit(DELAY, counter)
        fresh = normal(self.seed, self.base + DELAY, counter)
        z = fresh
        if self.z_of == (k if copy else k - 1):
            r = CORRELATIONS[row["distribution"]](row["delay_corr_pct"] / 100)
            z = r * self.z + math.sqrt(1 - r * r) * fresh
        if not copy:
            self.z_of, self.z = k, z
        return phi(z)

    def goes_ahead(self, row, k, counter, copy):
        happens = self.reorders.asks(k, row["reorder_pct"], row["reorder_corr_pct"], self.unit(REORDER, counter), copy)
        ahead = happens and self.since_ahead >= row["reorder_gap"] - 1
        if not copy:
            self.since_ahead = 0 if ahead else self.since_ahead + 1
        return ahead


MASK64 = 2**64 - 1
