"""Sizes of encoded states: docs/netgame.md, "Encodings"."""

import math

HEADER = 48  # of a snapshot


def number(n):
    """Bits: groups of three, each with one that says whether more follow."""
    return 4 * max(1, -(-n.bit_length() // 3))


def signed(n):
    return number(2 * n if n >= 0 else -2 * n - 1)


def words(values):
    return sum(65 if value or math.copysign(1, value) < 0 else 1 for value in values)


def exact(game, one, flags):
    """An entity to the bit: six words and the flags."""
    pose, rate = game.motion(one)
    return words((*pose, *rate)) + number(flags)


def cell(now, before):
    """A state on the grid as its differences from another; (x, y, angle, vx, vy, spin, flags)."""
    bits = sum(signed(a - b) for a, b in zip(now[:3], before[:3])) + 1
    if any(now[3:6]):
        bits += sum(signed(a - b) for a, b in zip(now[3:6], before[3:6]))
    return bits + 1 + (number(now[6]) if now[6] != before[6] else 0)


def message(bits):
    return HEADER + -(-bits // 8)
