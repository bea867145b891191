"""Random scenarios: what the oracle knows of, crossed at random."""

import peer_scenarios as peers

SYNCS = ("free", "lockstep", "lockstep_pipelined", "gambetta", "deterministic", "rollback", "bucket")


def maybe(r, share, values, otherwise=None):
    return r.choice(values) if r.random() < share else otherwise


def without_none(row):
    return {k: v for k, v in row.items() if v is not None}


def direction(r):
    row = {}
    if r.random() < 0.6:
        row["distribution"] = r.choice(["uniform", "normal", "pareto", "paretonormal"])
        row["jitter_ms"] = r.choice([1, 5, 10, 20] + ([40] if row["distribution"] == "uniform" else []))
        if r.random() < 0.2:
            row["delay_corr_pct"] = r.choice([20, 60])
    if r.random() < 0.3:
        row["delay_ms"] = r.choice([5, 20])
    if r.random() < 0.2:
        row["order"] = "fifo"
    loss = r.random()
    if loss < 0.3:
        row["loss_pct"] = r.choice([1, 5, 20])
        row["loss_corr_pct"] = r.choice([0, 0, 30])
    elif loss < 0.4:
        row.update(loss_model="gemodel", ge_p_pct=3, ge_r_pct=30, ge_1h_pct=60, ge_1k_pct=1)
    elif loss < 0.5:
        row.update(loss_model="state", p13_pct=3, p31_pct=40, p32_pct=20, p23_pct=50, p14_pct=2)
    if r.random() < 0.3:
        row["duplicate_pct"] = r.choice([1, 5, 20])
        row["duplicate_corr_pct"] = r.choice([0, 40])
    if r.random() < 0.15:
        row.update(corrupt_pct=3, corrupt_corr_pct=r.choice([0, 30]))
    if r.random() < 0.2:
        row["mtu_bytes"] = r.choice([64, 100, 150])
    if r.random() < 0.15:
        row.update(spike_at_ms=700, spike_every_ms=900, spike_length_ms=100, spike_add_ms=60)
    if r.random() < 0.15 and "order" not in row and row.get("delay_ms"):
        row.update(reorder_pct=10, reorder_gap=r.choice([1, 3]))
    return row


def player(r, sync, rough, tick_hz):
    row = {
        "lag_ms": r.choice([0, 10, 33, 80, 150, r.randrange(300)]),
        "script": r.choice(["varied", "varied", "varied", "steady", "idle"]),
        "clock_phase": r.choice([-1, 0, 0.5, r.random()]),
        "drift_ppm": r.choice([0, 0, 500, -500, r.randrange(-500, 500)]),
        "clock_filter": maybe(r, 0.5, ["median", "min_rtt", "mean"]),
        "display_hz": maybe(r, 0.4, [60, 75, 144, 30, 10]),
        "lane": maybe(r, 0.5, [0, 0, 1]),
    }
    if rough:
        row["link"] = {"up": direction(r), "down": direction(r)}
    if sync == "free":
        row.update(
            send_hz=maybe(r, 0.4, [10, 20, 25, 30] if tick_hz <= 64 else [30, 60]), redundancy=maybe(r, 0.5, [0, 1, 5]), slack_ticks=maybe(r, 0.5, [0, 2, 4]),
            prediction=r.random() < 0.7, interpolation=r.random() < 0.6, extrapolation_ms=maybe(r, 0.3, [50, 100, 300]),
            extrapolation_clock=maybe(r, 0.3, ["arrival"]))
        row["reconciliation"] = row["prediction"] and r.random() < 0.7
        if r.random() < 0.2:
            row.update(input_delay_ticks=1, slack_ticks=r.choice([1, 2]))
    if sync == "bucket":
        row.update(redundancy=maybe(r, 0.7, [0, 0, 1, 5]), prediction=r.random() < 0.5, interpolation=r.random() < 0.6)
        row["reconciliation"] = row["prediction"] and r.random() < 0.7
    if sync == "gambetta":
        row.update(
            send_hz=maybe(r, 0.4, [10, 20, 25, 30] if tick_hz <= 64 else [30, 60]), redundancy=maybe(r, 0.7, [0, 0, 1, 5]),
            prediction=r.random() < 0.75, interpolation=r.random() < 0.6, timer_jitter_ms=maybe(r, 0.3, [2, 8, 20, 40]))
        row["reconciliation"] = row["prediction"] and r.random() < 0.7
    return without_none(row)


PARAMS = {
    "race": lambda r: {"laps": r.choice([0.05, 0.1, 0.2, 6]), "drag_per_s": r.choice([0.05, 0.3]), "restitution": r.choice([0, 0.3, 1]),
                       "top_speed_mps": r.choice([6, 16])},
    "gambetta": lambda r: {"speed_mps": r.choice([2, 0.7, 5]), "width_m": r.choice([10, 7])},
}


def scenario(r, kind):
    """Of a sync, or of one of the kinds of `free`."""
    given = common(r, "free" if kind in MORE else kind)
    if kind in MORE:
        MORE[kind](r, given)
    return given


def kind_of(given):
    if "reckoning" in given:
        return "reckoning"
    if "transport" in given["server"]:
        return given["server"]["transport"]
    return "partial" if "snapshot_encoding" in given["server"] else given["server"]["sync"]


def common(r, sync):
    tick_hz = r.choice([60, 60, 60, 50, 30, 20, 64, 33.3, 128])
    update_hz = r.choice([5, 10, 20, 25, 30, 30, 47.5, 60])
    rough = r.random() < 0.7
    game = r.choice(["gambetta", "gambetta", "race"]) if sync == "gambetta" else "race"
    given = {
        "kind": "netgame", "game": game, "duration_s": r.choice([2, 3, 4, 6]), "seed": r.randrange(10**6), "tick_hz": tick_hz,
        "warmup_s": r.choice([0, 1, 2]),
        "params": PARAMS[game](r),
        "server": {"sync": sync, "update_hz": min(update_hz, tick_hz) if sync.startswith("lockstep") or sync == "bucket" else update_hz,
                   "starved": r.choice(["decay", "decay", "repeat", "repeat_n", "neutral"])},
        "players": [player(r, sync, rough, tick_hz) for _ in range(r.choice([1, 2, 2, 3, 4]))],
    }
    if sync in peers.SYNCS:
        return peers.enrich(r, given)
    if sync == "bucket":
        given["bucket_delay_ms"] = r.choice([0, 40, 100, 133.7, 250])
    if r.random() < 0.3:
        outages(r, given, sync)
    for one in given["players"]:
        if r.random() < 0.4:
            one["ack"] = "per_input"
        if sync == "free" and one["prediction"] and r.random() < 0.4:
            one["prediction_scope"] = r.choice(["contacts", "all"])
    return given


def reckoning(r, given):
    """Dead reckoning, of a race or of a few bodies."""
    if r.random() < 0.5:
        swarm(r, given, [0, 1, 3, 6])
    given["reckoning"] = {
        "model": r.choice(["static", "velocity", "velocity_spin", "acceleration"]), "threshold_m": r.choice([0, 0.05, 0.3, 1]),
        "heartbeat_s": r.choice([0, 0.25, 1, 5]), "convergence": r.choice(["snap", "linear", "cubic", "projective"]), "tau_s": r.choice([0.01, 0.1, 0.3, 1])}


def swarm(r, given, bodies):
    """Players among bodies, of whom none touches another."""
    given["game"] = "swarm"
    given["params"] = {"bodies": r.choice(bodies), "field_m": r.choice([10, 40]), "speed_mps": r.choice([2, 8]), "body_speed_mps": r.choice([0, 2, 8]),
                       "turn_radps": r.choice([0.5, 3])}
    for one in given["players"]:
        one.pop("prediction_scope", None)


def partial(r, given):
    """Snapshots of some of the entities."""
    sizes = [0, 45, 60]
    if r.random() < 0.8:
        sizes = [0, 60, 100, 150]
        swarm(r, given, [3, 8, 20])
    for one in given["players"]:
        one.pop("prediction_scope", None)  # others on a grid
    given["server"].update(
        snapshot_encoding=r.choice(["partial", "partial_delta", "interest", "interest"]), snapshot_bytes=r.choice(sizes),
        interest_radius_m=r.choice([0, 5, 12, 30]), interest_margin_m=r.choice([0, 2]), quantum_m=r.choice([0.002, 0.05, 0.5]), quantum_mps=r.choice([0.02, 0.5]))


def transport(kind):
    def enrich(r, given):
        given["server"].update(transport=kind, congestion=r.choice(["reno", "reno", "cubic"]), timeout_s=0,
                               validation=False)  # a stream that was down brings more at once than it lets
        if kind == "tcp":
            given["server"]["nagle"] = r.random() < 0.2
        else:
            given["server"]["delivery"] = r.choice(["usual", "unreliable", "sequenced", "reliable_unordered", "reliable_ordered_by_type", "reliable_ordered"])
        if r.random() < 0.3:
            swarm(r, given, [3, 25])
        for row in (way for one in given["players"] for way in one.get("link", {}).values()):
            if row.get("loss_pct", 0) > 5:
                row["loss_pct"] = 5  # in 10 s of lobby all connect
        if r.random() < 0.4:
            marks(r, given)

    return enrich


def marks(r, given):
    """Some links mark what they would drop."""
    given["profiles"] = [{"ecn": True}]
    for one in given["players"]:
        link = one.setdefault("link", {"up": {}, "down": {}})
        for way in r.choice([["up"], ["down"], ["up", "down"]]):
            link[way]["profile"] = "profile_0"
            link[way].setdefault("loss_pct", 5)


MORE = {"reckoning": reckoning, "partial": partial, "tcp": transport("tcp"), "quic": transport("quic"), "webrtc": transport("webrtc")}
KINDS = (*SYNCS, *MORE)


def outages(r, given, sync):
    """The network of some is down for a while, one way or both."""
    given["server"]["timeout_s"] = r.choice([0, 5]) if sync.startswith("lockstep") else r.choice([0, 0.7, 1.2, 2, 5])
    given["duration_s"] = r.choice([4, 6])
    for one in r.sample(given["players"], r.randrange(1, len(given["players"]) + 1)):
        link = one.setdefault("link", {"up": {}, "down": {}})
        row = {"blackout_at_ms": r.randrange(200, 2500), "blackout_length_ms": r.choice([100, 400, 700, 1500, r.randrange(2500)]),
               "blackout_every_ms": r.choice([0, 0, 3000])}
        for way in r.choice([["up"], ["down"], ["up", "down"]]):
            link[way].update(row)
