"""What random scenarios of deterministic lockstep and rollback have beside the common rows."""

SYNCS = ("deterministic", "rollback")


def server(r):
    return {"max_rollback_ticks": r.choice([0, 2, 8, 8, 16]), "sync_test_ticks": r.choice([0, 0, 0, 1, 8])}


def player(r):
    row = {"input_delay_ticks": r.choice([0, 0, 1, 2, 3, 6, 9, 16])}
    if r.random() < 0.3:
        row["timer_jitter_ms"] = r.choice([1, 10, 30, 50])
    if r.random() < 0.3:
        row["send_hz"] = r.choice([10, 30])  # does nothing
    return row
