"""Inconsistency (against the server), smoothness and fairness of the views, as in docs/concepts.md."""

import math

EXCURSION_M, EXCURSION_NS = 0.1, 100 * 10**6
HITCH = 2


def share(a, b):
    return a / b if b else None


class Track:
    """The pictures of one entity on one screen."""

    def __init__(self):
        self.samples = self.frames = self.moving = self.frozen = self.reversals = self.hitches = self.still = 0
        self.accelerations, self.jerks, self.true_steps = [], [], []
        self.seconds = self.longest = 0.0
        self.at = self.truth = self.moved = (0.0, 0.0)
        self.step = self.v = self.a = (0.0, 0.0)

    def add(self, drawn, truth, dt):
        step = (drawn[0] - self.at[0], drawn[1] - self.at[1])
        v = (step[0] / dt, step[1] / dt)
        a = ((v[0] - self.v[0]) / dt, (v[1] - self.v[1]) / dt)
        self.count_still(step == (0.0, 0.0), truth)
        self.samples += 1
        if self.samples > 3:
            jerk = ((a[0] - self.a[0]) / dt, (a[1] - self.a[1]) / dt)
            self.frames += 1
            self.accelerations.append(a[0] * a[0] + a[1] * a[1])
            self.jerks.append(jerk[0] * jerk[0] + jerk[1] * jerk[1])
            self.seconds += dt
            self.longest = max(self.longest, math.hypot(*step))
            way = math.hypot(truth[0] - self.truth[0], truth[1] - self.truth[1])
            self.true_steps.append(way)
            self.moving += way > 0
            self.frozen += way > 0 and step == (0.0, 0.0)
            self.reversals += step[0] * self.step[0] + step[1] * self.step[1] < 0
        self.at, self.truth, self.step, self.v, self.a = drawn, truth, step, v, a

    def count_still(self, stood, truth):
        if not stood or self.samples == 0:
            self.moved, self.still = truth, 0
            return
        if truth != self.moved:
            self.still += 1
            self.hitches += self.still == HITCH + 1


def smoothness(tracks):
    """(path, value) of all entities together."""
    def total(name):
        return sum(getattr(t, name) for t in tracks)

    frames, moving = total("frames"), total("moving")
    longest = max((t.longest for t in tracks), default=0.0)
    accelerations = [x for t in tracks for x in t.accelerations]
    jerks = [x for t in tracks for x in t.jerks]
    yield "acceleration_rms_mps2", math.sqrt(math.fsum(accelerations) / frames) if frames else None
    yield "jerk_rms_mps3", math.sqrt(math.fsum(jerks) / frames) if frames else None
    yield "freeze_ratio", share(total("frozen"), moving)
    yield "reversals_per_s", share(total("reversals"), total("seconds"))
    yield "hitches", total("hitches")
    yield "step_max_m", longest if frames else None
    mean = share(math.fsum(x for t in tracks for x in t.true_steps), moving)
    yield "step_max_over_mean", share(longest, mean) if mean else None


class Episodes:
    """Of one entity."""

    def __init__(self):
        self.sum, self.time, self.count = 0.0, 0, 0
        self.open_sum, self.open_time = 0.0, 0

    def add(self, distance, elapsed):
        if distance <= EXCURSION_M:
            self.open_sum, self.open_time = 0.0, 0
            return
        counted = self.open_time >= EXCURSION_NS
        part = distance * (elapsed / 1e9)
        self.open_sum += part
        self.open_time += elapsed
        if self.open_time >= EXCURSION_NS:
            self.sum += part if counted else self.open_sum
            self.time += elapsed if counted else self.open_time
            self.count += not counted


class Screen:
    """All that one player saw."""

    def __init__(self, players, me):
        self.me = me
        self.tracks = [Track() for _ in range(players)]
        self.episodes = [Episodes() for _ in range(players)]
        self.measured = 0

    def add(self, picture, truth, elapsed):
        self.measured += elapsed
        for i, true in enumerate(truth):
            drawn = picture.own if i == self.me else picture.others.get(i)
            if drawn is None:
                continue
            self.episodes[i].add(math.hypot(drawn[0] - true[0], drawn[1] - true[1]), elapsed)
            if i != self.me:
                self.tracks[i].add(tuple(drawn), (true[0], true[1]), elapsed / 1e9)

    def numbers(self):
        others = [t for i, t in enumerate(self.tracks) if i != self.me]
        for path, value in smoothness(others):
            yield f"smoothness.{path}", value
        seconds, n = self.measured / 1e9, len(self.episodes)
        yield "inconsistency.server.sum_m_s_per_min", share(sum(e.sum for e in self.episodes) / n, seconds / 60)
        yield "inconsistency.server.time_ratio", share(sum(e.time for e in self.episodes) / 1e9 / n, seconds)
        yield "inconsistency.server.episodes", sum(e.count for e in self.episodes)


# ---- fairness ----


def fairness(measures, round_trips):
    """`measures`: a value a player or None by name."""
    for name, values in measures.items():
        pairs = [(x, y) for x, y in zip(values, round_trips) if x is not None and y is not None]
        several = len(pairs) > 1
        xs, ys = [x for x, _ in pairs], [y for _, y in pairs]
        squares = sum(x * x for x in xs)
        yield f"{name}.spread", max(xs) - min(xs) if several else None
        yield f"{name}.jain", (sum(xs) ** 2 / (len(xs) * squares) if squares else 1) if several else None
        slope = None
        if several:
            mx, my = sum(xs) / len(xs), sum(ys) / len(ys)
            spread = sum((y - my) ** 2 for y in ys)
            if spread * len(ys) > 1e-9 * len(ys) * sum(y * y for y in ys):
                slope = sum((x - mx) * (y - my) for x, y in pairs) / spread
        yield f"{name}.per_ms_of_round_trip", slope
