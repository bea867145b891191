"""The metrics of docs/concepts.md that both tell: what the oracle says of each, by its path in players[i]."""

import math

from views import fairness

LAST_BUCKET = 2**18 - 2**12  # in units: from there on all values are alike
UNITS = {"ms": 0.1, "m": 0.001, "1": 1.0}


class Distribution:
    def __init__(self, values, unit):
        self.values, self.unit = sorted(values), UNITS[unit]

    def quantile(self, q):
        return self.values[math.ceil(q * len(self.values)) - 1]

    def facts(self):
        """(name, value, how far off the other may be)."""
        v, n = self.values, len(self.values)
        yield "count", n, 0
        if not n:
            for name in ("mean", "rms", "max", "p50", "p95", "p99"):
                yield name, None, 0
            return
        yield "mean", math.fsum(v) / n, None
        yield "rms", math.sqrt(math.fsum(x * x for x in v) / n), None
        yield "max", v[-1], None
        for name, q in (("p50", 0.5), ("p95", 0.95), ("p99", 0.99)):
            x = self.quantile(q)
            if x > LAST_BUCKET * self.unit:
                yield name, x, math.inf
                continue
            yield name, x, max(self.unit / 2, abs(x) / 63 if x > 32 * self.unit else 0)


def at_path(tree, path):
    for part in path.split("."):
        tree = tree[int(part)] if isinstance(tree, list) else tree[part]
    return tree


def distributions(sim, i):
    client, pictures = sim.clients[i], sim.drawn[i]
    player = sim.players[i]
    out = {
        "age_of_information_ms": Distribution([(p.at - p.newest_time) / 1e6 for p in pictures], "ms"),
        "view_age_ms": Distribution([max(0, p.at - t) / 1e6 for p in pictures for t in p.times.values()], "ms"),
        "own_lead_m": Distribution([abs(p.lead) for p in pictures], "m"),
        "remote_error_m": Distribution([abs(e) for p in pictures for e in p.remote.values()], "m"),
        "own_timeline_error_m": Distribution([e for e, _ in sim.comparisons[i]], "m"),
        "unacked": Distribution(client.unacked, "1"),
        "correction_m": Distribution(client.correction_sizes, "m"),
    }
    if player["interpolation"] and not sim.reckons and sim.sync in ("free", "gambetta") and client.kept and len(sim.players) > 1:
        out["buffer_ms"] = Distribution([max(0, p.buffer) / 1e6 for p in pictures if p.interpolated], "ms")
    out.update(sim.more_distributions(i))
    return out


LINK_COUNTS = ("sent", "lost", "rescued", "messages", "messages_lost", "split", "split_lost", "fragments", "fragments_lost", "duplicated",
               "corrupted", "reordered_ahead", "queue_drops", "marked")


def numbers(sim, i):
    """Single numbers by path: (path, value)."""
    client, seat = sim.clients[i], sim.server.seats[i]
    yield "corrections", client.corrections
    yield "inputs.accepted", seat.accepted
    yield "inputs.duplicate", seat.duplicate
    yield "inputs.starved_steps", seat.starved
    yield "buffer.stale_states", client.stale_states
    yield "connection.joins", client.joins
    yield "connection.time_outs", client.time_outs
    yield "connection.drops", seat.drops
    for state, ns in client.connection.told(sim.now).items():
        yield f"connection.seconds.{state}", ns / 1e9
    yield "connection.round_trip_ms", 2 * client.connection.longest() / 2e6
    for name, link in (("link_up", sim.ups[i]), ("link_down", sim.downs[i])):
        for count in LINK_COUNTS:
            yield f"{name}.{count}", link.stats[count]
        if link.delays:
            yield f"{name}.delay_mean_ms", math.fsum(link.delays) / len(link.delays)
            yield f"{name}.delay_min_ms", min(link.delays)
            yield f"{name}.delay_max_ms", max(link.delays)
    span = sim.now / 1e9 - sim.scenario["warmup_s"]
    if span > 0:
        for kind, parts in KINDS.items():
            sent = [sim.sent.get((i, way, part), (0, 0)) for way, part in parts]
            yield f"bandwidth.{kind}.messages_per_s", sum(c for c, _ in sent) / span
            yield f"bandwidth.{kind}.payload_bytes_per_s", sum(b for _, b in sent) / span
    yield "game.speed_mps", sim.game.speed(sim.server.world[i])
    if sim.scenario["game"] == "race":
        yield "game.finish_s", sim.server.world[i][3]
    yield from sim.screens[i].numbers()
    yield from sim.more_numbers(i)


def mean(values):
    return math.fsum(values) / len(values) if values else None


def rms(values):
    return math.sqrt(math.fsum(x * x for x in values) / len(values)) if values else None


def server_numbers(sim):
    """The same of metrics.server."""
    every = [distributions(sim, i) for i in range(len(sim.players))]
    measures = {name: [mean(d[name].values) for d in every] for name in ("view_age_ms", "age_of_information_ms")}
    measures |= {name: [rms(d[name].values) for d in every] for name in ("own_timeline_error_m", "remote_error_m")}
    measures["inconsistency_m_s_per_min"] = [dict(s.numbers())["inconsistency.server.sum_m_s_per_min"] for s in sim.screens]
    trips = [mean(up.delays) + mean(down.delays) if up.delays and down.delays else None for up, down in zip(sim.ups, sim.downs)]
    for path, value in fairness(measures, trips):
        yield f"fairness.{path}", value


KINDS = {
    "input": [("up", "inputs")], "connect": [("up", "connect")], "ping": [("up", "ping")],
    "state": [("down", "state")], "accept": [("down", "accept")], "pong": [("down", "pong"), ("down", "keep")],
}
