#!/usr/bin/env python3
"""Random scenarios through laglab and through the oracle: traces tick by tick, and metrics.

  run.py --laglab build/laglab --count 200 --seed 1 [--kind free]... [--one SCENARIO.json]

Prints a table by kind: sync, or what the sync `free` is with; of the first disagreement of each scenario the tick and column. Exits 1 on any.
"""

import argparse
import json
import os
import random
import sys
import time

from compare import differences
from generate import KINDS, MORE, SYNCS, kind_of, scenario
from scenario import Filler, schema_of


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--laglab", default=os.environ.get("LAGLAB_BIN", "build/laglab"))
    parser.add_argument("--count", type=int, default=30, help="scenarios in all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", action="append", choices=KINDS)
    parser.add_argument("--more", action="store_true", help="dead reckoning, partial snapshots and transports in place of the syncs")
    parser.add_argument("--one", help="a scenario file in place of random ones")
    return parser.parse_args()


def main():
    options = arguments()
    filler = Filler(schema_of(options.laglab))
    kinds = options.kind or list(MORE if options.more else SYNCS)
    table = {kind: [0, 0, 0, 0, 0] for kind in (KINDS if options.one else kinds)}  # agreed, run, refused, cells, numbers
    began, wrong = time.monotonic(), 0
    for k in range(options.count):
        if options.one:
            with open(options.one, encoding="utf-8") as file:
                given = json.load(file)
            kind, name = kind_of(given), options.one
        else:
            kind = kinds[k % len(kinds)]
            name = f"{options.seed}/{kind}/{k // len(kinds)}"
            given = scenario(random.Random(name), kind)
        line = table[kind]
        try:
            columns, numbers, found = differences(options.laglab, filler, given)
        except ValueError as refused:  # laglab refuses it, which it says in a sentence
            line[2] += 1
            if "must" not in str(refused):
                raise
            continue
        line[1] += 1
        line[3] += columns * int(given["duration_s"] * given["tick_hz"])
        line[4] += numbers
        if found:
            wrong += 1
            print(f"scenario {name}:", *found[:4], sep="\n  ")
            print(" ", json.dumps(given))
        else:
            line[0] += 1
        if options.one:
            break
    print(f"{'kind':20} {'agree':>6} {'run':>6} {'refused':>8} {'cells of traces':>16} {'metrics':>8}")
    for kind, (agreed, run, refused, cells, numbers) in table.items():
        print(f"{kind:20} {agreed:6} {run:6} {refused:8} {cells:16} {numbers:8}")
    print(f"{time.monotonic() - began:.1f} s")
    return 1 if wrong or not any(line[1] for line in table.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
