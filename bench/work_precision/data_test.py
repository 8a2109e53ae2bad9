#!/usr/bin/env python3
"""References against what they claim, and against solutions from elsewhere: data_test.py PROGRAM ROOT."""
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

PROGRAM, ROOT = sys.argv.pop(1), pathlib.Path(sys.argv.pop(1))
DATA, TABLES = ROOT / "bench/data", ROOT / "tests/data/reference"
LEAST_USEFUL = 1e-8  # m; ten times that is the least error that the tables of equal error ask for


def read(path):
    """(comments, {column: values})"""
    lines = path.read_text(encoding="utf-8").splitlines()
    comments = " ".join(line[1:] for line in lines if line.startswith("#"))
    rows = [line.split(",") for line in lines if line and not line.startswith("#")]
    return comments, {name: [float(row[i]) for row in rows[1:]] for i, name in enumerate(rows[0])}


def difference(one, other, names):
    return max(abs(a - b) for name in names for a, b in zip(one[name], other[name], strict=True))


class Converged(unittest.TestCase):
    def test_two_methods_differ_by_what_the_heads_say(self):
        pairs = {}
        for path in DATA.glob("*.*.csv"):
            problem, method, _ = path.name.split(".")
            pairs.setdefault(problem, {})[method] = read(path)
        self.assertGreater(len(pairs), 10)
        for problem, pair in pairs.items():
            with self.subTest(problem):
                self.assertEqual(len(pair), 2)
                self.assertIn("radau", pair)
                (first, one), (second, other) = pair.values()
                self.assertEqual(one.keys(), other.keys())
                self.assertEqual(one["t"], other["t"])
                found = difference(one, other, one.keys())
                self.assertLess(found, LEAST_USEFUL)
                self.assertGreater(found, 0)  # not the same run twice
                for comments in (first, second):
                    believed = float(re.search(r"believed to (\S+)", comments)[1])
                    self.assertAlmostEqual(found / believed, 1, delta=0.1)

    def test_suspension_chains_against_another_program(self):
        for units in (1, 4):
            _, truth = read(TABLES / f"suspension_chain_N{units}.csv")
            for method in ("rk4", "radau"):
                _, ours = read(DATA / f"suspension-chain-{units}.{method}.csv")
                at = [truth["t"].index(t) for t in (min(truth["t"], key=lambda v, t=t: abs(v - t)) for t in ours["t"])]
                worst = max(abs(ours[name][k] - truth[name][i]) for name in truth if name != "t"
                            for k, i in enumerate(at))
                self.assertLess(worst, 1e-8)


class Exact(unittest.TestCase):
    """Angles that the program integrates against closed forms and quadrature."""
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([PROGRAM, "problems", "--problems", "pendulum,four-bar-*", "--out", folder], check=True)
            cls.tables = {path.stem: read(path)[1] for path in pathlib.Path(folder).glob("*.csv")
                          if path.stem != "problems"}

    def test_pendulum_by_elliptic_functions(self):
        table = self.tables["pendulum"]
        for t, x, z in ((1, 0.98629175113187532, -0.16501085312554117), (10, -0.27508746257611686, -0.96141920509912506)):
            k = table["t"].index(t)
            self.assertAlmostEqual(table["bob.x"][k], x, delta=1e-14)
            self.assertAlmostEqual(table["bob.z"][k], z, delta=1e-14)

    def test_four_bar_by_quadrature_of_the_energy(self):
        """a'^2 = 1 + 2 k (1 - cos a): the time until an angle, by Simpson's rule."""
        for loops in (1, 10):
            table = self.tables[f"four-bar-{loops}"]
            k = 9.81 * (9 * loops + 3) / (8 * loops + 2)
            angle, last = 0.0, 0.0
            for t, x, z in zip(table["t"], table["top0.x"], table["top0.z"]):
                now = math.atan2(x, z)
                angle += (now - last) % (2 * math.pi)  # it only turns forward, less than once a sample
                last = now
                if t in (1, 3, 10):
                    steps = 40000
                    h = angle / steps
                    slow = [1 / math.sqrt(1 + 2 * k * (1 - math.cos(i * h))) for i in range(steps + 1)]
                    time = h / 3 * (slow[0] + slow[-1] + 4 * sum(slow[1:-1:2]) + 2 * sum(slow[2:-1:2]))
                    self.assertAlmostEqual(time, t, delta=1e-11)


if __name__ == "__main__":
    unittest.main()
