"""Metrics of deterministic lockstep and rollback beside the common ones (docs/concepts.md, "Metrics")."""

import math

from draws import tick_time
from metrics import Distribution


class Latencies(Distribution):
    """What does not come about is infinite, what is not decided counts nowhere."""

    def __init__(self, values, unit):
        super().__init__([v for v in values if v is not None], unit)

    def facts(self):
        finite = Distribution([], "ms")
        finite.values = [v for v in self.values if v < math.inf]
        told = {name: (value, off) for name, value, off in finite.facts()}
        told["count"] = len(self.values), 0
        for name, q in (("p50", 0.5), ("p95", 0.95), ("p99", 0.99)):
            if self.values:
                x = self.quantile(q)
                told[name] = (None, None) if x == math.inf else (x, max(self.unit / 2, abs(x) / 63 if x > 32 * self.unit else 0))
        lost = len(self.values) - len(finite.values)
        told["lost_ratio"] = (lost / len(self.values) if self.values else None), None
        for name, (value, off) in told.items():
            yield name, value, off


def until(change, shown):
    if change.lost:
        return math.inf
    return None if shown is None else (shown - change.made) / 1e6


def peer_distributions(sim, i):
    changes = sim.clients[i].changes
    decided, others = [c for c in changes if c.applied or c.lost], len(sim.players) - 1
    seen = [(at - c.made) / 1e6 for c in changes for at in c.seen.values()]
    return {
        "input_latency_ms": Latencies([until(c, c.felt) for c in decided], "ms"),
        "confirmed_latency_ms": Latencies([until(c, c.sure) for c in decided], "ms"),
        "seen_latency_ms": Latencies(seen + [math.inf for c in changes if c.lost for _ in range(others - len(c.seen))], "ms"),
        "ack_rtt_ms": Distribution([t / 1e6 for t in sim.clients[i].round_trips], "ms"),
        "timeline_error_m": Distribution(sim.timeline_errors[i], "m"),
    }


def peer_numbers(sim, i):
    client, seat, leads = sim.clients[i], sim.server.seats[i], [lead for _, lead in sim.comparisons[i]]
    frame_s, span = 1 / sim.step_hz, sim.now / 1e9 - sim.scenario["warmup_s"]
    yield "stalls.count", client.stalls
    yield "stalls.stalled_s", client.stalled * frame_s
    yield "stalls.time_sync_wait_s", client.rested * frame_s
    for p, frames in enumerate(client.waited):
        yield f"stalls.waited_s.{p}", frames * frame_s
    ticks = client.rollbacks
    for name, value in (("count", len(ticks)), ("ticks", sum(ticks))):
        yield f"rollback.{name}", value
        yield f"rollback.{name}_per_s", value / span if span > 0 else None
    yield "rollback.ticks_max", max(ticks, default=0)
    yield "sync_test.count", client.sync_tests
    yield "sync_test.mismatches", 0
    desync = client.desync
    for name, value in (("tick", desync.tick), ("reported_tick", seat.reported), ("entity", desync.entity), ("error_m", desync.error), ("error_max_m", desync.most)):
        yield f"desync.{name}", value
    yield "own_lead_ms.count", len(leads)
    yield "own_lead_ms.mean", math.fsum(leads) / len(leads) if leads else None
    yield "own_lead_ms.min", min(leads, default=None)
    yield "own_lead_ms.max", max(leads, default=None)
    yield "own_displays_void", client.pictures_void
    for name, value in (*client.results.items(), ("open", len(client.open)), ("refused", 0), ("late", 0)):
        yield f"inputs.results.{name}", value
    yield "inputs.slack_ticks", seat.last_slack
    yield "connection.drops", seat.drops
    for cause in ("refused", "late", "loss", "contact", "other"):
        yield f"corrections_by_cause.{cause}.count", client.corrections if cause == "contact" else 0
    for name in ("relay", "state", "refusal"):
        count, size = sim.sent.get((i, "down", name), (0, 0))
        yield f"bandwidth.{name}.messages_per_s", count / span if span > 0 else None
        yield f"bandwidth.{name}.payload_bytes_per_s", size / span if span > 0 else None


def server_numbers(sim):
    server = sim.server
    waiting = max(0, sim.now - server.stepped_at - tick_time(sim.step_hz, 1))
    yield "steps", server.step
    yield "steps_per_s", server.step / (sim.now / 1e9)
    yield "stalled_s", (server.stalled + waiting) / 1e9
    waited = [sum(client.waited[p] for client in sim.clients) / sim.step_hz for p in range(len(sim.players))]
    yield "slowest_player", waited.index(max(waited)) if max(waited) > 0 else -1
    yield "slowest_waited_s", max(waited)
