"""The game `swarm` (docs/netgame.md, "The swarm"). A world is a list of [x, y, vx, 0, vy]: players, then bodies. Two axes are one complex number."""

import math

from draws import single, unit
from race import idle, purpose, slot_of

BODY_BYTES = 16, 56  # of a state: once, and for each entity
PLACES = 0x737761726D


def start(params, players):
    side, out = params["field_m"], []
    for i in range(len(players) + params["bodies"]):
        out.append([side * unit(PLACES, 0, i), side * unit(PLACES, 1, i), 0.0, 0.0, 0.0])
        if i >= len(players):
            speed, way = params["body_speed_mps"] * (0.5 + 0.5 * unit(PLACES, 2, i)), 2 * math.pi * unit(PLACES, 3, i)
            out[i][2], out[i][4] = speed * math.cos(way), speed * math.sin(way)
    return out


def motion(one):
    """Pose and its rates."""
    return (one[0], one[1], 0.0), (one[2], one[4], 0.0)


def moved(one, pose, rate):
    return [*pose[:2], rate[0], one[3], rate[1]]


def flags(_one):
    return 0


def tail(_world):
    return []


def speed(one):
    return math.hypot(one[2], one[4])


def drive(params, one, axes, h):
    side, vx, vy = params["field_m"], axes.real * params["speed_mps"], axes.imag * params["speed_mps"]
    return [min(max(vx * h + one[0], 0), side), min(max(vy * h + one[1], 0), side), vx, 0.0, vy]


def circle(one, w, h):
    x, y, vx, _, vy = one
    c, s = math.cos(w * h), math.sin(w * h)
    wx, wy = c * vx - s * vy, s * vx + c * vy
    return [x + (wy - vy) / w, y - (wx - vx) / w, wx, 0.0, wy]


def step_alone(params, world, me, axes, h, _at_s):
    out = [list(one) for one in world]
    out[me] = drive(params, world[me], axes, h)
    return out


def step(params, world, inputs, h, _at_s):
    n, turn = len(inputs), params["turn_radps"]
    bodies = [circle(one, -turn if (n + i) % 2 else turn, h) for i, one in enumerate(world[n:])]
    return [drive(params, one, axes, h) for one, axes in zip(world, inputs)] + bodies


# ---- scripts (docs/concepts.md, "Scripts") ----


def varied(seed, player, t, own, params):
    k, _ = slot_of(seed, player, 0, t, 2 * 10**9, 500 * 10**6)
    dx, dy = (params["field_m"] * unit(seed, 0x7363726970740000 + 16 * player + 3, 2 * k + n) - own[n] for n in (0, 1))
    length = math.sqrt(dx * dx + dy * dy)
    return complex(dx / length, dy / length) if length > 0.5 else 0.0


def steady(_seed, player, t, _own, _params):
    return 1.0 if (t + player * 700 * 10**6) % (4 * 10**9) < 2 * 10**9 else -1.0


SCRIPTS = {"varied": varied, "steady": steady, "idle": idle}
