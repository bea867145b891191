"""Sessions, streams and experiments on a daemon of its own."""

import os
import re
import subprocess
import tempfile
import unittest

import laglab

PROGRAM = os.environ["LAGLAB_BIN"]
ERROR = "players.1.remote_error_m.mean"


def column(table, name):
    return list(table[name]) if hasattr(table, "to_dict") else table.column(name)


class WithDaemon(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.process = subprocess.Popen(
            [PROGRAM, "serve", "--listen", "127.0.0.1:0", "--data", cls.folder.name], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )
        for line in cls.process.stdout:
            found = re.search(r"http://127\.0\.0\.1:\d+", line)
            if found:
                cls.lab = laglab.connect(found[0])
                return
        raise AssertionError("the daemon has ended")

    @classmethod
    def tearDownClass(cls):
        cls.process.terminate()
        cls.process.wait(20)
        cls.process.stdout.close()
        cls.folder.cleanup()

    def test_a_session_that_is_stepped_is_a_run(self):
        with self.lab.session("race", seed=8, set={"players.0.lag_ms": 40, "duration_s": 3}) as session:
            position = session.step(180)
            self.assertEqual(position["tick"], 180)
            alone = laglab.run("race", seed=8, duration_s=3, set={"players.0.lag_ms": 40})
            self.assertEqual(position["hash"], alone.hash)
            self.assertEqual(session.metric(ERROR), alone[ERROR])
            self.assertEqual(session.state()["tick"], 180)
            self.assertEqual(column(session.trace(), "tick"), list(range(181)))
            self.assertEqual(set(column(session.trace("entities", from_s=1, to_s=1), "session_tick")), {60})
            self.assertIn("state", set(column(session.trace("packets"), "type")))
            written = session.trace_file(os.path.join(self.folder.name, "drawn.sqlite"), "entities")
            self.assertEqual(written.read_bytes()[:15], b"SQLite format 3")
            self.assertEqual(session.step(-60)["tick"], 120)
        with self.assertRaises(laglab.LaglabError) as caught:
            session.info()
        self.assertEqual(caught.exception.status, 404)

    def test_changes_and_what_is_refused(self):
        with self.lab.session("race") as session:
            session.set({"players.1.lag_ms": 333})
            self.assertEqual(session.info()["params"]["players"][1]["lag_ms"], 333)
            with self.assertRaises(laglab.LaglabError) as caught:
                session.set({"players.1.lag_ms": -4})
            self.assertEqual(caught.exception.status, 400)
            self.assertIn("players.1.lag_ms", caught.exception.fields)
            watched = self.lab.attach(session.id)
            with self.assertRaises(laglab.LaglabError) as caught:
                watched.pause()
            self.assertIn(caught.exception.status, (401, 403))

    def test_a_persons_input(self):
        with self.lab.session("race", set={"players.0.control": "person"}) as session:
            session.input(0, axes=(1, 0))
            session.step(90)
            self.assertGreater(session.state()["state"]["server"]["entities"][0]["vx"], 1)

    def test_frames_come_while_it_plays(self):
        with self.lab.session("race", playing=True) as session:
            ticks = []
            for frame in session.stream(scene=30, session=30):
                ticks.append(frame["tick"])
                if len(ticks) == 20:
                    break
            self.assertEqual(ticks, sorted(ticks))
            self.assertGreater(ticks[-1], ticks[0])
            self.assertEqual(len(frame["entities"]), 6, "two cars as the server and two clients see them")

    def test_a_stream_of_nothing(self):
        with self.assertRaises(laglab.LaglabError) as caught:
            next(laglab.Session(self.lab, "a" * 26, None).stream())
        self.assertEqual(caught.exception.status, 404)

    def test_an_experiment_is_a_sweep(self):
        order = {"axes": {"players.0.lag_ms": [20, 180]}, "repeats": 4, "metrics": [ERROR], "set": {"duration_s": 3}}
        told = []
        made = self.lab.experiment("race", **order).wait(told.append, timeout_s=60)
        self.assertEqual(told[0]["type"], "hello")
        rows, local = made.table(), laglab.sweep("race", **order)
        self.assertEqual(column(rows, "hash"), column(local, "hash"))
        self.assertEqual(len(made.table(points=True)), 2)
        self.assertIn("point-data", made.report())
        with made.open(3) as session:
            self.assertEqual(session.info()["tick"], 0)
        made.delete()

    def test_an_experiment_that_is_cancelled(self):
        made = self.lab.experiment("race", axes={"players.0.lag_ms": [1, 2]}, repeats=2000, metrics=[ERROR], set={"duration_s": 600})
        with self.assertRaises(TimeoutError):
            made.wait(timeout_s=1)
        made.control("cancel")
        with self.assertRaises(laglab.LaglabError) as caught:
            made.wait()
        self.assertIn("cancelled", str(caught.exception))
        made.delete()

    def test_no_daemon(self):
        with self.assertRaises(laglab.LaglabError) as caught:
            laglab.connect("http://127.0.0.1:9")
        self.assertIn("127.0.0.1:9", str(caught.exception))

    def test_the_library(self):
        self.assertIn("race", [one["id"] for one in self.lab.scenarios()])
        changed = {**self.lab.scenario("race"), "duration_s": 1}
        self.assertEqual(laglab.run(changed).duration_s, 1)


if __name__ == "__main__":
    unittest.main()
