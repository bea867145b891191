"""Runs and sweeps by the program that LAGLAB_BIN names."""

import json
import math
import os
import subprocess
import sys
import unittest

import laglab
from laglab.table import Table

PROGRAM = os.environ["LAGLAB_BIN"]
RACE = {"players.0.lag_ms": 170, "players.0.prediction": True}
ERROR = "players.1.remote_error_m.mean"


def printed(*arguments):
    return json.loads(subprocess.run([PROGRAM, *arguments], check=True, capture_output=True, text=True).stdout)


class Run(unittest.TestCase):
    def test_it_is_that_of_the_command_line(self):
        result = laglab.run("race", duration_s=7, seed=5, set=RACE)
        told = printed("run", "race", "--duration", "7", "--seed", "5", "--set", "players.0.lag_ms=170", "--set", "players.0.prediction=true")
        self.assertEqual(result.hash, told["hash"])
        self.assertEqual(result[ERROR], told["metrics"]["players"][1]["remote_error_m"]["mean"])
        self.assertEqual((result.seed, result.duration_s), (5, 7))
        self.assertGreater(result[ERROR], 0)

    def test_every_metric_has_a_path(self):
        result = laglab.run("race", duration_s=3)
        self.assertEqual(len(result), len(list(result)))
        self.assertIn(ERROR, result)
        for path in result:
            result[path]  # raises where a path leads nowhere

    def test_a_scenario_of_its_own(self):
        fall = {"kind": "motion", "problem": "free_fall", "methods": [{"method": "semi_implicit_euler"}], "duration_s": 2}
        self.assertEqual(laglab.run(fall).duration_s, 2)

    def test_only_what_is_asked_for_is_measured(self):
        few, all_ = laglab.run("race", duration_s=4, metrics=[ERROR]), laglab.run("race", duration_s=4)
        self.assertEqual(few[ERROR], all_[ERROR])
        self.assertEqual(few.hash, all_.hash)
        self.assertLess(len(few), len(all_))

    def test_a_refusal_names_the_field_and_the_range(self):
        with self.assertRaises(laglab.LaglabError) as caught:
            laglab.run("race", duration_s=-3)
        self.assertIn("duration_s", caught.exception.fields)
        self.assertRegex(str(caught.exception), r"must be .* got -3")

    def test_an_unknown_metric_says_what_there_is(self):
        with self.assertRaises(KeyError) as caught:
            laglab.run("race", duration_s=1)["players.0.remote_eror_m"]
        self.assertIn("remote_error_m", str(caught.exception))

    def test_a_program_that_is_not_there(self):
        with self.assertRaises(FileNotFoundError):
            laglab.run("race", program="/nowhere/laglab")

    def test_the_library(self):
        self.assertIn("race", laglab.scenarios())


class Sweep(unittest.TestCase):
    ORDER = {"axes": {"players.0.lag_ms": [30, 220]}, "repeats": 3, "metrics": [ERROR], "set": {"duration_s": 3}}

    def rows(self, made):
        return made.to_dict("records") if hasattr(made, "to_dict") else list(made)

    def test_rows_are_those_of_runs(self):
        rows = self.rows(laglab.sweep("race", **self.ORDER))
        self.assertEqual(len(rows), 6)
        for row in rows:
            alone = laglab.run("race", duration_s=3, seed=int(row["seed"]), set={"players.0.lag_ms": row["players.0.lag_ms"]})
            self.assertEqual(row["hash"], alone.hash)
            self.assertTrue(math.isclose(row[ERROR], alone[ERROR], rel_tol=1e-15), row)  # printed with 15 to 17 digits

    def test_points_have_intervals(self):
        rows = self.rows(laglab.sweep("race", points=True, **{**self.ORDER, "interval": "t"}))
        self.assertEqual([row["players.0.lag_ms"] for row in rows], [30, 220])
        for row in rows:
            self.assertLessEqual(row[f"{ERROR}.ci95_low"], row[ERROR])
            self.assertLessEqual(row[ERROR], row[f"{ERROR}.ci95_high"])

    def test_what_goes_together_varies_together(self):
        pair = ("players.0.prediction", "players.0.reconciliation")
        order = laglab.specification("race", axes={pair: [(False, False), (True, True)]}, metrics=[ERROR])
        self.assertEqual(
            order["axes"],
            [{"zip": [{"path": pair[0], "values": [False, True]}, {"path": pair[1], "values": [False, True]}]}],
        )
        with self.assertRaises(ValueError):
            laglab.specification("race", axes={pair: [(True,)]})

    def test_settings_with_names_are_a_column(self):
        techniques = {"none": {"players.0.prediction": False, "players.0.lag_ms": 90}, "both": {"players.0.prediction": True, "players.0.lag_ms": 10}}
        rows = self.rows(laglab.sweep("race", axes={"technique": techniques}, repeats=2, metrics=[ERROR], set={"duration_s": 1}))
        self.assertEqual([row["technique"] for row in rows], ["none", "none", "both", "both"])
        for row in rows:
            self.assertEqual({path: row[path] for path in techniques["none"]}, techniques[row["technique"]])
        columns = list(rows[0])
        self.assertEqual(columns.index("technique") + 1, columns.index("players.0.prediction"))

    def test_settings_with_names_must_be_of_the_same_paths_and_differ(self):
        for settings in ({}, {"a": {}}, {"a": {"x": 1}, "b": {"y": 1}}, {"a": {"x": 1}, "b": {"x": 1}}):
            with self.assertRaises(ValueError):
                laglab.specification("race", axes={"technique": settings})

    def test_an_experiment_of_the_library_takes_nothing_else(self):
        with self.assertRaises(TypeError):
            laglab.sweep("race", experiment="experiments/lag_techniques")

    def test_without_pandas_rows_are_dictionaries(self):
        code = (
            "import sys; sys.modules['pandas'] = None; import laglab; "
            "made = laglab.sweep('race', axes={'players.0.lag_ms': [10]}, metrics=['players.0.remote_error_m.mean'], set={'duration_s': 1}); "
            "assert type(made) is laglab.Table and made.columns[0] == 'run' and len(made.column('hash')) == 1, made"
        )
        subprocess.run([sys.executable, "-c", code], check=True)
        self.assertEqual(Table().columns, [])


if __name__ == "__main__":
    unittest.main()
