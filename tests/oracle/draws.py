"""Random numbers (docs/links.md, "Random numbers") and clocks (docs/netgame.md, "Order of events")."""

import math
import struct
from statistics import NormalDist

MASK = 2**64 - 1
NORMAL = NormalDist()
SECOND = 10**9


def draw(seed, stream, counter):
    x = (seed + (stream + 1) * 0xD1E8D69EC377210F) & MASK
    x ^= x >> 32
    x = (x * 0xD60927FC6F0DE0D1) & MASK
    x ^= x >> 29
    x = (x + counter * 0x9E3779B97F4A7C15) & MASK
    x ^= x >> 33
    x = (x * 0xAA78F731403321BB) & MASK
    x ^= x >> 26
    x = (x * 0xEE9DAF582AEC48AD) & MASK
    x ^= x >> 30
    return x


def unit(seed, stream, counter):
    return (draw(seed, stream, counter) >> 11) * 2.0**-53


def quantile(p):
    return NORMAL.inv_cdf(p)


def phi(z):
    return 0.5 * math.erfc(-z / math.sqrt(2.0))


def normal(seed, stream, counter):
    return quantile(((draw(seed, stream, counter) >> 12) + 0.5) * 2.0**-52)


def nearest(x):
    """To the nearest whole number, halves away from zero."""
    return int(math.floor(x + 0.5)) if x >= 0 else -int(math.floor(-x + 0.5))


def ns(milliseconds):
    return nearest(milliseconds * 1e6)


def millihertz(rate):
    return nearest(rate * 1000)


def tick_time(rate, k):
    """Tick k of a clock of `rate` Hz that began at 0."""
    return k * 10**12 // millihertz(rate)


def last_tick_at(rate, t):
    """The last tick that is not after t."""
    k = t * millihertz(rate) // 10**12
    return k + 1 if tick_time(rate, k + 1) <= t else k


def first_tick_from(rate, t):
    """The first tick that is not before t."""
    k = max(0, t * millihertz(rate) // 10**12)
    while tick_time(rate, k) < t:
        k += 1
    while k > 0 and tick_time(rate, k - 1) >= t:
        k -= 1
    return k


def trunc(x):
    return math.trunc(x)


def trunc_div(a, b):
    """a / b of whole numbers, towards zero."""
    return -((-a) // b) if a < 0 else a // b


def distance(a, b):
    return math.hypot(a[0] - b[0], a[1] - b[1])


def single(x):
    """As it travels: in single precision; two axes are a complex number."""
    if isinstance(x, complex):
        return complex(single(x.real), single(x.imag))
    return struct.unpack("f", struct.pack("f", x))[0]
