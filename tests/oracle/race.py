"""The race (docs/netgame.md, "The race"): cars on lanes. A world is a list of cars [x, y, v, finish_s]; finish_s is 0 until the car is through."""

import math
from functools import cache

from draws import draw

BODY_BYTES = 24, 64  # of a state: once, and for each player


def start(params, players):
    cars, in_lane = [], {}
    for i, player in enumerate(players):
        lane = player["lane"] if player["lane"] >= 0 else i
        n = in_lane.get(lane, 0)
        in_lane[lane] = n + 1
        cars.append([-n * (params["car_length_m"] + 1.0), lane * params["lane_width_m"], 0.0, 0.0])
    return cars


LN2_HIGH, LN2_LOW = float.fromhex("0x1.62e42feep-1"), float.fromhex("0x1.a39ef35793c76p-33")


def exp(x):
    """As the docs have it, to the bit."""
    k = round(x * (1 / 0.6931471805599453))
    r = (x - k * LN2_HIGH) - k * LN2_LOW
    total = 1.0 / math.factorial(14)
    for n in range(13, 1, -1):
        total = total * r + 1.0 / math.factorial(n)
    return math.ldexp(1 + (r + r * r * total), k)


@cache
def drag_over(c, h):
    """What is left of a speed after h seconds, and the ways per speed and per acceleration."""
    z = c * h
    e = exp(-z)
    if z > 1:
        f = (1 - e) / c
        return e, f, (h - f) / c
    f = g = 0.0
    for n in range(22, 0, -1):
        f = 1 - f * z / (n + 1)
        g = 1 - g * z / (n + 2)
    return e, h * f, h * h / 2 * g


def drive(params, x, v, axis, h):
    """One car for h seconds: v' = a - drag v."""
    top = params["top_speed_mps"]
    e, f, g = drag_over(params["drag_per_s"], h)
    a = axis * params["acceleration_mps2"] if axis > 0 else axis * params["brake_mps2"] if v > 0 else 0.0
    x1, v1 = x + (v * f + a * g), v * e + a * f
    if v1 > top:
        return x + h * (v + top) / 2, top
    if v1 < 0:
        return x + v * v / (2 * -a) if v > 0 else x, 0.0
    return x1, v1


def step(params, cars, inputs, h, at_s, chosen=None):
    """The world after a step of h seconds of all, or of those who are chosen; inputs holds an axis per car."""
    out = [list(car) for car in cars]
    moved = [i for i in range(len(cars)) if chosen is None or i in chosen]
    for i in moved:
        out[i][0], out[i][2] = drive(params, cars[i][0], cars[i][2], inputs[i], h)
    touch(params, [out[i] for i in moved])
    finish(params, [out[i] for i in moved], at_s)
    return out


def reach(params, cars, me, horizon):
    """Whoever may touch `me` so soon, directly or through others."""
    far = 2 * params["car_length_m"] + params["top_speed_mps"] * horizon
    found = {me}
    while True:
        more = {j for j in range(len(cars)) for i in found if cars[i][1] == cars[j][1] and abs(cars[j][0] - cars[i][0]) < far}
        if more <= found:
            return found
        found |= more


def step_alone(params, cars, me, axis, h, at_s):
    """The world when only one car moves: the others stand still and are not touched."""
    out = [list(car) for car in cars]
    out[me][0], out[me][2] = drive(params, cars[me][0], cars[me][2], axis, h)
    finish(params, [out[me]], at_s)
    return out


def apply(params, cars, me, axis, h):
    """The same where an input counts as it comes: nobody finishes."""
    out = [list(car) for car in cars]
    out[me][0], out[me][2] = drive(params, cars[me][0], cars[me][2], axis, h)
    return out


def finish(params, cars, at_s):
    line = params["laps"] * params["lap_m"]
    for car in cars:
        if car[3] == 0.0 and car[0] >= line:
            car[3] = at_s - (car[0] - line) / car[2]


def touch(params, cars):
    length, e = params["car_length_m"], params["restitution"]
    for i in range(len(cars)):
        for j in range(i + 1, len(cars)):
            if cars[i][1] != cars[j][1] or abs(cars[j][0] - cars[i][0]) >= length:
                continue
            back, front = (cars[i], cars[j]) if cars[j][0] - cars[i][0] >= 0 else (cars[j], cars[i])
            missing = length - (front[0] - back[0])
            back[0] -= missing / 2
            front[0] += missing / 2
            closing = back[2] - front[2]
            if closing > 0:
                change = (1 + e) / 2 * closing
                back[2] -= change
                front[2] += change


def motion(car):
    """Pose and its rates."""
    return (car[0], car[1], 0.0), (car[2], 0.0, 0.0)


def moved(car, pose, rate):
    """The car at another place, at another speed."""
    return [*pose[:2], rate[0], car[3]]


def flags(car):
    return int(car[3] > 0)


def tail(cars):
    """Of a state, in words."""
    finishes = [car[3] for car in cars]
    return [sum(at > 0 for at in finishes), *finishes]


def speed(car):
    return car[2]


# ---- scripts (docs/concepts.md, "Scripts") ----


def purpose(seed, player, q, n):
    return draw(seed, 0x7363726970740000 + 16 * player + q, n)


def slot_of(seed, player, q, t, mean, spread):
    """The slot of `mean` +- `spread` that holds t, and for how long it has lasted."""
    at = t + purpose(seed, player, q, 0) % mean

    def begin(k):
        return 0 if k == 0 else k * mean + purpose(seed, player, q, k) % spread

    k = max(0, at // mean - 2)
    while begin(k + 1) <= at:
        k += 1
    return k, at - begin(k)


def varied(seed, player, t, _own, _params):
    if t < 2 * 10**9:
        return 1.0
    k, _ = slot_of(seed, player, 0, t, 750 * 10**6, 500 * 10**6)
    return (1.0, 1.0, 0.8, 0.6, 0.3, -0.4)[purpose(seed, player, 3, k) % 6]


def steady(_seed, _player, _t, own, _params):
    return -1.0 if own[3] > 0 else 1.0


def idle(_seed, _player, _t, _own, _params):
    return 0.0


SCRIPTS = {"varied": varied, "steady": steady, "idle": idle}
