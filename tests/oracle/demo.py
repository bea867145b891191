"""The game `gambetta` (docs/netgame.md, "The demo's game"). A world is a list of [x, y, v, 0], one a player."""

from race import idle, purpose, slot_of

SLOT, SPREAD = 4 * 10**9, 400 * 10**6

BODY_BYTES = 16, 56  # of a state: once, and for each player


def start(params, players):
    width = params["width_m"]
    lanes = [p["lane"] if p["lane"] >= 0 else i for i, p in enumerate(players)]
    return [[width * (0.4 + 0.2 * (i % 2)), float(lane), 0.0, 0.0] for i, lane in enumerate(lanes)]


def step_alone(params, world, me, axis, h, _at_s):
    out = [list(one) for one in world]
    out[me][2] = axis * params["speed_mps"]
    out[me][0] = out[me][2] * h + out[me][0]
    return out


def apply(params, world, me, axis, h):
    return step_alone(params, world, me, axis, h, 0)


def step(params, world, inputs, h, at_s):
    for i, axis in enumerate(inputs):
        world = step_alone(params, world, i, axis, h, at_s)
    return world


def speed(one):
    return one[2]


# ---- scripts (docs/concepts.md, "Scripts") ----


def varied(seed, player, t, _own, _params):
    k, since = slot_of(seed, player, 0, t, SLOT, SPREAD)
    side = 1.0 if purpose(seed, player, 3, k) % 2 else -1.0
    out = 1200 * 10**6 + purpose(seed, player, 4, k) % (400 * 10**6)
    there = 100 * 10**6 + purpose(seed, player, 5, k) % (300 * 10**6)
    if since < out:
        return side
    return -side if out + there <= since < 2 * out + there else 0.0


def steady(_seed, player, t, _own, _params):
    return 1.0 if (t + player * 700 * 10**6) % (4 * 10**9) < 2 * 10**9 else -1.0


SCRIPTS = {"varied": varied, "steady": steady, "idle": idle}
