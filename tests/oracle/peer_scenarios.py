"""What random scenarios of deterministic lockstep and rollback have beside the common rows."""

SYNCS = ("deterministic", "rollback")

DELAYS, ROLLBACKS, SYNC_TESTS = (0, 0, 1, 2, 3, 6, 9, 16), (0, 2, 8, 8, 16), (0, 0, 0, 1, 8)


def enrich(r, scenario):
    """A scenario that has the rows of every sync gets those of these two."""
    scenario["duration_s"] = r.choice([2, 4, 6, 10])
    scenario["server"].update(max_rollback_ticks=r.choice(ROLLBACKS), sync_test_ticks=r.choice(SYNC_TESTS), timeout_s=r.choice([0, 0, 5]))
    for player in scenario["players"]:
        enrich_player(r, player)
    if r.random() < 0.3:
        scenario["timeline"] = timeline(r, scenario)
    if r.random() < 0.25:
        drop(r, scenario)
    return scenario


def drop(r, scenario):
    """Somebody is silent for so long that it is dropped, on one side or on both, and joins again."""
    scenario["duration_s"] = r.choice([6, 10])
    scenario["server"]["timeout_s"] = r.choice([0.7, 1, 1.5])
    link, ways = r.choice(scenario["players"]).setdefault("link", {}), r.choice((["up"], ["down"], ["up", "down"]))
    at, length = r.choice([0, 700, 1777, 2500]), r.choice([900, 1600, 2700, 4000])
    for way in ways:
        link.setdefault(way, {}).update(blackout_at_ms=at, blackout_length_ms=length)


def enrich_player(r, row):
    row["input_delay_ticks"] = r.choice(DELAYS)
    if r.random() < 0.15:
        row["lag_ms"] = r.choice([450, 700])
    if r.random() < 0.4:
        row["lane"] = 0  # together with others
    if r.random() < 0.3:
        row["timer_jitter_ms"] = r.choice([1, 10, 30, 50])
    if r.random() < 0.3:
        row["send_hz"] = r.choice([10, 30])  # does nothing
    if r.random() < 0.2:
        way = row.setdefault("link", {}).setdefault(r.choice(["up", "down"]), {})
        way.update(blackout_at_ms=r.choice([0, 900, 2100]), blackout_length_ms=r.choice([100, 700, 2500]))


def timeline(r, scenario):
    """Changes while it runs."""
    out, p = [], r.randrange(len(scenario["players"]))
    for at_s in sorted(r.uniform(0, scenario["duration_s"]) for _ in range(3)):
        path, values = r.choice((("server.max_rollback_ticks", ROLLBACKS), ("server.sync_test_ticks", SYNC_TESTS),
                                 (f"players.{p}.input_delay_ticks", DELAYS), (f"players.{p}.lag_ms", (0, 40, 120, 250))))
        out.append({"at_s": at_s, "set": {path: r.choice(values)}})
    return out
