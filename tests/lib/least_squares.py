"""The model of clients/r/techniques.R by numpy and scipy: least_squares.py RUNS.csv

An intercept and a slope for each technique by least squares, with 95 % intervals, as JSON."""

import json
import sys

import numpy
import pandas
from scipy import stats

NAMES = ["none", "prediction", "+ reconciliation", "+ interpolation"]

runs = pandas.read_csv(sys.argv[1])
level = sum(runs[f"players.0.{switch}"].astype(str).str.lower() == "true" for switch in ("prediction", "reconciliation", "interpolation"))
lag, error = runs["players.0.lag_ms"].to_numpy(float), runs["players.0.remote_error_m.mean"].to_numpy(float)
is_level = numpy.stack([(level == i).to_numpy(float) for i in range(len(NAMES))], axis=1)
design = numpy.hstack([is_level, is_level * lag[:, None]])
estimate = numpy.linalg.lstsq(design, error, rcond=None)[0]
freedom = len(error) - design.shape[1]
variance = ((error - design @ estimate) ** 2).sum() / freedom
half = stats.t.ppf(0.975, freedom) * numpy.sqrt(variance * numpy.diag(numpy.linalg.inv(design.T @ design)))
terms = [f"technique{name}" for name in NAMES] + [f"technique{name}:lag_ms" for name in NAMES]
print(json.dumps({"runs": len(error), "rows": [[term, a, a - b, a + b] for term, a, b in zip(terms, estimate, half)]}))
