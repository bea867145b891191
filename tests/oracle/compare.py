"""Both programs on one scenario: where they first differ."""

import csv
import json
import math
import subprocess
import tempfile
from pathlib import Path

from gambetta import DemoSimulation
from metrics import at_path, distributions, numbers, server_numbers
from peers import PeerSimulation
from simulation import Simulation

RELATIVE = 1e-9
SIMULATIONS = {"deterministic": PeerSimulation, "gambetta": DemoSimulation, "rollback": PeerSimulation}


def close(told, own):
    """Equal up to 1e-9, and in traces to half of the ninth digit that is printed."""
    if told is None or own is None:
        return told is None and own is None
    return math.isclose(told, own, rel_tol=RELATIVE, abs_tol=1e-9)


def printed_close(text, own):
    """A trace prints nine digits."""
    if isinstance(own, tuple):  # equal ones up to rounding, of which either is told
        return any(printed_close(text, one) for one in own)
    told = float(text)
    half = 0.5 * 10.0 ** (math.floor(math.log10(abs(told))) - 8) if told else 0.0
    return abs(told - own) <= half * (1 + 1e-6) + RELATIVE * max(abs(told), 1.0)


def laglab_says(laglab, scenario):
    with tempfile.TemporaryDirectory() as folder:
        path, trace = Path(folder, "scenario.json"), Path(folder, "trace.csv")
        path.write_text(json.dumps(scenario))
        run = subprocess.run([laglab, "run", str(path), "--trace", str(trace)], capture_output=True, text=True)
        if run.returncode:
            raise ValueError(run.stderr.strip())
        return json.loads(run.stdout), list(csv.DictReader(trace.open()))


def differences(laglab, filler, scenario):
    """(columns compared, numbers compared, list of differences), the first tick first."""
    told, rows = laglab_says(laglab, scenario)
    kind = SIMULATIONS.get(scenario["server"]["sync"], Simulation)
    sim = kind(filler.fill(scenario)).run()
    out = []
    if len(rows) != len(sim.rows):
        return 0, 0, [f"{len(rows)} rows and not {len(sim.rows)}"]
    columns = [c for c in rows[0] if c in sim.rows[0]]
    for theirs, mine in zip(rows, sim.rows):
        out += [f"tick {theirs['tick']}: {c} {theirs[c]}, oracle {mine[c]!r}" for c in columns if not printed_close(theirs[c], mine[c])]
        if out:
            return len(columns), 0, out
    count = 0
    for i in range(len(sim.players)):
        node = told["metrics"]["players"][i]
        for name, distribution in {**distributions(sim, i), **sim.more_distributions(i)}.items():
            for fact, value, off in distribution.facts():
                count += 1
                theirs = at_path(node, name)[fact]
                same = close(theirs, value) if off is None or value is None else abs(theirs - value) <= off * (1 + 1e-9) + 1e-9
                if not same:
                    out.append(f"player {i}: {name}.{fact} {theirs}, oracle {value}")
        for path, value in (*numbers(sim, i), *sim.more_numbers(i)):
            count += 1
            if not close(at_path(node, path), value):
                out.append(f"player {i}: {path} {at_path(node, path)}, oracle {value}")
    for path, value in [*server_numbers(sim), *sim.server_numbers()]:
        count += 1
        if not close(at_path(told["metrics"]["server"], path), value):
            out.append(f"server: {path} {at_path(told['metrics']['server'], path)}, oracle {value}")
    return len(columns), count, out
