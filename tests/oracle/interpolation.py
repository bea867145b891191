"""The time at which the others are drawn: docs/netgame.md, "Interpolation"."""

from draws import nearest, trunc_div

QUARTER = 250 * 10**6
QUARTERS = 8
KEPT = 64


class Reference:
    """The largest (server time - arrival) of the last eight quarters of a second."""

    def __init__(self):
        self.quarters = None
        self.at = 0

    def begins(self):
        """All quarters have the sample that comes next."""
        self.at = -QUARTERS

    def add(self, arrived, sample):
        q = arrived // QUARTER
        if self.quarters is None or q - self.at >= QUARTERS:
            self.quarters = [sample] * QUARTERS
        else:
            for k in range(self.at + 1, q + 1):
                self.quarters[k % QUARTERS] = sample
            self.quarters[q % QUARTERS] = max(self.quarters[q % QUARTERS], sample)
        self.at = q

    def value(self):
        return max(self.quarters)


def delay_ns(player, update_hz):
    return int(player["interpolation_ratio"] / update_hz * 1e9) + nearest(player["jitter_margin_ms"] * 1e6)


class DrawnTime:
    def __init__(self):
        self.time = None
        self.at = None
        self.scale = None
        self.jumps = 0

    def advance(self, now, target, newest, extrapolation):
        if self.time is None:
            self.time = target
        else:
            elapsed = now - self.at
            e = target - (self.time + elapsed)
            if e > 250 * 10**6:
                self.time = target
                self.jumps += 1
            elif e <= -250 * 10**6:
                pass
            else:
                most = elapsed // 10
                self.time += elapsed + max(-most, min(most, e))
        self.time = min(self.time, newest + extrapolation)
        self.at = now
        return self.time


def between(states, t):
    """The places of all at time t, on the straight line between the two states around it."""
    if t <= states[0].time:
        return [(c[0], c[1]) for c in states[0].world]
    for a, b in zip(states, states[1:]):
        if a.time <= t <= b.time:
            f = (t - a.time) / (b.time - a.time)
            return [(p[0] + (q[0] - p[0]) * f, p[1] + (q[1] - p[1]) * f) for p, q in zip(a.world, b.world)]
    last = states[-1]
    ahead = (t - last.time) / 1e9
    return [(c[0] + c[2] * ahead, c[1] + (c[4] * ahead if len(c) > 4 else 0)) for c in last.world]
