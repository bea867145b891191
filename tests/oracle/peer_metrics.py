"""Metrics of deterministic lockstep and rollback beside the common ones (docs/concepts.md, "Metrics")."""

import math

from draws import tick_time
from metrics import Distribution


def peer_distributions(sim, i):
    changes = sim.clients[i].changes
    decided = [c for c in changes if c[0] <= sim.server.step]  # and applied: nothing is late or lost here
    return {
        "input_latency_ms": Distribution([(c[2] - c[1]) / 1e6 for c in decided if c[2] is not None], "ms"),
        "confirmed_latency_ms": Distribution([(c[3] - c[1]) / 1e6 for c in decided if c[3] is not None], "ms"),
        "seen_latency_ms": Distribution([(at - c[1]) / 1e6 for c in changes for at in c[4].values()], "ms"),
        "ack_rtt_ms": Distribution([t / 1e6 for t in sim.clients[i].round_trips], "ms"),
        "timeline_error_m": Distribution(sim.timeline_errors[i], "m"),
    }


def peer_numbers(sim, i):
    client, seat, leads = sim.clients[i], sim.server.seats[i], [lead for _, lead in sim.comparisons[i]]
    frame_s, span = 1 / sim.step_hz, sim.now / 1e9 - sim.scenario["warmup_s"]
    yield "stalls.count", client.stalls
    yield "stalls.stalled_s", client.stalled * frame_s
    yield "stalls.rested_s", client.rested * frame_s
    for p, frames in enumerate(client.waited):
        yield f"stalls.waited_s.{p}", frames * frame_s
    ticks = client.rollbacks
    for name, value in (("count", len(ticks)), ("ticks", sum(ticks))):
        yield f"rollback.{name}", value
        yield f"rollback.{name}_per_s", value / span if span > 0 else None
    yield "rollback.ticks_max", max(ticks, default=0)
    yield "sync_test.count", client.sync_tests
    yield "sync_test.mismatches", 0
    for name, value in (("tick", -1), ("reported_tick", -1), ("entity", -1), ("error_max_m", 0)):
        yield f"desync.{name}", value
    yield "own_lead_ms.count", len(leads)
    yield "own_lead_ms.mean", math.fsum(leads) / len(leads) if leads else None
    yield "own_lead_ms.min", min(leads, default=None)
    yield "own_lead_ms.max", max(leads, default=None)
    yield "own_pictures_void", 0
    applied = min(client.number, sim.server.step)
    for name, value in (("made", client.number), ("applied", applied), ("open", client.number - applied), ("refused", 0), ("late", 0), ("lost", 0)):
        yield f"inputs.verdicts.{name}", value
    yield "inputs.slack_ticks", seat.last_slack if seat.accepted else None
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
