#!/usr/bin/env python3
"""Tests of peers.py; with GUDGEON and GUDGEON_SIMBODY (paths in the environment) those of the runners too."""
import copy
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import problems
import runners
import tables
import truths

HERE = pathlib.Path(__file__).resolve().parent
GUDGEON, SIMBODY = os.environ.get("GUDGEON"), os.environ.get("GUDGEON_SIMBODY")
STATED = {"factor": 1.5, "rows": [{"program": "other", "mechanism": "chain", "error": 1e-3, "sizes": [4, 16],
                                   "cpu_s": [0.1, 0.4]}]}


def point(program, tolerance, error, cpu_s, status="ok", size=4, method="m", formulation="", floor=0.0):
    return tables.Point(program, "chain", size, method, formulation, tolerance, status, error, cpu_s, floor=floor)


class EqualError(unittest.TestCase):
    def test_a_power_law_is_met_between_its_points(self):
        curve = [point("a", e, e, 2 * e ** -0.25) for e in (1e-2, 1e-4, 1e-6)]
        for target in (1e-3, 1e-4, 3e-6):
            self.assertAlmostEqual(tables.seconds_at(curve, target), 2 * target ** -0.25, places=9)

    def test_outside_the_curve(self):
        curve = [point("a", 1e-3, 1e-4, 1.0), point("a", 1e-5, 1e-6, 5.0)]
        self.assertEqual(tables.seconds_at(curve, 1e-2), 1.0)  # every run is better: the cheapest of them
        self.assertIsNone(tables.seconds_at(curve, 1e-7))

    def test_the_tightest_piece_counts_where_errors_are_not_monotone(self):
        curve = [point("a", 1e-2, 1e-6, 1.0), point("a", 1e-3, 1e-2, 2.0), point("a", 1e-4, 1e-4, 8.0)]
        self.assertAlmostEqual(tables.seconds_at(curve, 1e-3), 4.0)

    def test_a_tight_run_that_goes_astray_leaves_the_looser_ones(self):
        curve = [point("a", 1e-4, 1e-2, 1.0), point("a", 1e-6, 1e-4, 4.0), point("a", 1e-8, 1.9, 9.0, "astray")]
        self.assertAlmostEqual(tables.seconds_at(curve, 1e-3), 2.0)

    def test_nothing_below_the_floor(self):
        curve = [point("a", 1e-3, 1e-4, 1.0, floor=1e-5),
                 point("a", 1e-5, None, 10.0, "below-floor", floor=1e-5)]
        self.assertIsNone(tables.seconds_at(curve, 1e-6))
        self.assertAlmostEqual(tables.seconds_at(curve, 1e-5), 10.0)  # no better than the floor

    def test_runs_that_stopped_do_not_count(self):
        curve = [point("a", 1e-3, 1e-4, 1.0), point("a", 1e-5, None, None, "failed"),
                 point("a", 1e-7, None, None, "limit")]
        self.assertEqual(tables.seconds_at(curve, 1e-3), 1.0)
        self.assertIsNone(tables.seconds_at(curve, 1e-5))

    def test_best_method_and_ratio(self):
        points = [point("gudgeon", 1e-3, 1e-3, 0.2, method="gear"), point("gudgeon", 1e-3, 1e-3, 0.1, method="radau"),
                  point("other", 1e-3, 1e-3, 0.3)]
        lines = {(x["program"], x["method"]): x for x in tables.equal_error(points, STATED, (1e-3,))}
        self.assertEqual(lines["gudgeon", "radau"]["best"], "best")
        self.assertEqual(lines["gudgeon", "gear"]["best"], "")
        self.assertAlmostEqual(lines["other", "m"]["over_gudgeon"], 3)
        self.assertAlmostEqual(lines["gudgeon", "gear"]["over_gudgeon"], 2)


class Stated(unittest.TestCase):
    def lines(self, seconds, rows=None):
        stated = copy.deepcopy(STATED)
        stated["rows"] = rows or stated["rows"]
        points = [point("gudgeon", 1e-3, 1e-3, 0.01), point("other", 1e-3, 1e-3, seconds, formulation="best"),
                  point("other", 1e-3, 1e-3, 2 * seconds, formulation="plain")]
        lines = tables.equal_error(points, stated, (1e-3,))
        return lines, tables.report(lines, stated)

    def test_reproduced(self):
        _, text = self.lines(0.13)
        self.assertIn("other 1.30 of stated: reproduced", text)
        self.assertIn(" 13 ", text)  # the ratio

    def test_slower_than_stated_gives_no_ratio(self):
        _, text = self.lines(0.16)
        self.assertIn("NOT reproduced", text)
        self.assertIn("not stated", text)

    def test_faster_than_stated_gives_a_ratio(self):
        _, text = self.lines(0.05)
        self.assertIn("faster", text)
        self.assertNotIn("not stated", text)

    def test_the_row_may_name_its_formulation(self):
        rows = [STATED["rows"][0] | {"formulation": "plain"}]
        lines, text = self.lines(0.06, rows)
        self.assertIn("other (plain) 1.20 of stated: reproduced", text)
        self.assertEqual([x["formulation"] for x in lines if x.get("over_stated")], ["plain"])

    def test_the_file(self):
        stated = json.loads((HERE / "stated.json").read_text())
        for row in stated["rows"]:
            self.assertEqual(len(row["sizes"]), len(row["cpu_s"]), row)
            self.assertIn(row["mechanism"], problems.MECHANISMS)


class Problems(unittest.TestCase):
    def test_error_is_the_largest_distance(self):
        problem = problems.chain(4)
        zero = {c: [0.0] * 11 for c in problem.channels}
        moved = {"tip.x": [0.0] * 10 + [3e-3], "tip.z": [1e-3] + [0.0] * 9 + [-4e-3]}
        self.assertAlmostEqual(problems.error(problem, moved, zero), 5e-3)
        moved["tip.x"][4] = math.nan
        self.assertEqual(problems.error(problem, moved, zero), math.inf)

    def test_small_swings_of_the_cranks(self):
        # a'' = f sin a with f < 0 swings as a pendulum: small angles by sine
        times = [0.0, 0.5, 1.0]
        for angle, time in zip(problems.pendulum_angles(-4.0, 0.0, 1e-4, times, 1e-3), times):
            self.assertAlmostEqual(angle, 0.5e-4 * math.sin(2 * time), delta=1e-12)

    def test_energy_of_the_cranks(self):
        # 1/2 (da/dt)^2 + f cos a is constant: time from angle 0 to pi/2 by quadrature
        f, n = 9.81 * 12 / 10, 20000
        quarter = sum((math.pi / 2 / n) / math.sqrt(1 + 2 * f * (1 - math.cos((i + 0.5) * math.pi / 2 / n)))
                      for i in range(n))
        self.assertAlmostEqual(problems.pendulum_angles(f, 0.0, 1.0, [0.0, quarter], 1e-4)[1], math.pi / 2, delta=1e-8)

    def test_tables_have_the_rows(self):
        for problem in (problems.chain(4), problems.chain(16), problems.suspension_chain(1),
                        problems.suspension_chain(4)):
            truth = problems.known_truth(problem)
            self.assertEqual(set(truth.columns), set(problem.channels))
            self.assertEqual({len(c) for c in truth.columns.values()}, {len(problem.times)})
        self.assertIsNone(problems.known_truth(problems.chain(64)))

    def test_no_program_is_its_own_judge(self):
        problem = problems.suspension_chain(64)
        runs = {"gudgeon": {"a": 1}, "simbody": {"a": 2}}
        self.assertEqual(truths.best("simbody", None, runs, 1e-9).columns, {"a": 1})
        self.assertEqual(truths.best("gudgeon", None, runs, 1e-9).columns, {"a": 2})
        self.assertIsNone(truths.best("gudgeon", None, {"gudgeon": {}}, None))
        known = problems.Truth({}, 1e-10, "table")
        self.assertIs(truths.best("gudgeon", known, runs, 1e-9), known)
        self.assertEqual(truths.best("gudgeon", known, runs, 1e-11).known, 1e-11)
        self.assertEqual(problem.size, 64)


class Configuration(unittest.TestCase):
    entry = {"name": "p", "command": ["{python}", "-c", "pass"], "figures": {"cpu_s": "cpu"},
             "tolerances": {"*": [1e-3]}, "methods": [{"method": "m"}]}

    def program(self, **changes):
        return runners.Program(self.entry | changes, {"python": sys.executable})

    def run_script(self, script, limit=None, **changes):
        program = self.program(command=["{python}", "-c", script, "{out}"], **changes)
        with tempfile.TemporaryDirectory() as folder:
            return program.run(problems.chain(4), pathlib.Path("none.json"), {"method": "m"}, 1e-3,
                               pathlib.Path(folder) / "run", limit)

    def test_unknown_words_are_refused(self):
        with self.assertRaisesRegex(runners.ConfigError, "unknown key tolerence; missing key tolerances"):
            runners.Program({k: v for k, v in self.entry.items() if k != "tolerances"} | {"tolerence": {}}, {})
        with self.assertRaisesRegex(runners.ConfigError, "placeholder 'modell'"):
            self.program(command=["{modell}"]).command(problems.chain(4), "m.json", {"method": "m"}, 1e-3, "out")

    def test_placeholders(self):
        program = self.program(command=["{mechanism}", "{size}", "{end}", "{every}", "{channels}", "{tolerance}"])
        self.assertEqual(program.command(problems.chain(4), "m.json", {"method": "m", "arguments": ["--x"]}, 1e-3, "o"),
                         ["chain", "4", "1", "0.1", "tip.x,tip.z", "0.001", "--x"])

    def test_a_program_that_refuses_the_model_is_told(self):
        with self.assertRaisesRegex(runners.ConfigError, "no such joint"):
            self.run_script("import sys; print('no such joint', file=sys.stderr); sys.exit(2)")

    def test_a_program_that_fails_has_no_results(self):
        run = self.run_script("import sys; print('singular', file=sys.stderr); sys.exit(4)")
        self.assertEqual((run.status, run.columns), ("failed", {}))
        self.assertIn("singular", run.message)

    def test_a_program_is_stopped(self):
        self.assertEqual(self.run_script("while True: pass", limit=0.2).status, "limit")

    def test_a_missing_channel_is_told(self):
        script = ("import json, sys; open(sys.argv[1] + '/results.csv', 'w').write('t,tip.x\\n0,1\\n'); "
                  "json.dump(dict(cpu=1), open(sys.argv[1] + '/report.json', 'w'))")
        with self.assertRaisesRegex(runners.ConfigError, "no column or row"):
            self.run_script(script)
        with self.assertRaisesRegex(runners.ConfigError, "tells no CPU time"):
            self.run_script(script, figures={"cpu_s": "time"})


def export(folder, mechanism, *parameters):
    file = pathlib.Path(folder) / "model.json"
    words = [word for parameter in parameters for word in ("--param", parameter)]
    file.write_text(subprocess.run([GUDGEON, "export", mechanism, *words], capture_output=True, text=True,
                                   check=True).stdout)
    return file


@unittest.skipUnless(GUDGEON, "no program to export models")
class WholeRun(unittest.TestCase):
    def test_another_program_needs_only_an_entry(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-B", HERE / "peers.py", "--gudgeon", GUDGEON, "--out", folder, "--programs",
                            HERE / "programs.json", "--programs", HERE / "example/programs.json", "--executable",
                            "simbody=/nowhere", "--methods", "gudgeon=radau", "--mechanisms", "four-bar=2", "--repeats",
                            "1"], check=True, stdout=subprocess.DEVNULL)
            with open(pathlib.Path(folder) / "peers.csv") as file:
                rows = [row for row in csv.DictReader(file) if row["program"] == "parallel-cranks"]
        self.assertEqual([float(row["tolerance"]) for row in rows], [1e-2, 1e-3, 1e-4])
        errors = [float(row["error"]) for row in rows]
        for loose, tight in zip(errors, errors[1:]):
            self.assertAlmostEqual(math.log10(loose / tight), 2, delta=0.3)  # second order
        self.assertEqual([float(row["steps"]) for row in rows], [1e3, 1e4, 1e5])


@unittest.skipUnless(GUDGEON and SIMBODY, "no runner of Simbody")
class Simbody(unittest.TestCase):
    def run_model(self, problem, model, *options, integrator="runge-kutta-merson"):
        out = model.parent / "out"
        subprocess.run([SIMBODY, model, "--integrator", integrator, "--end", str(problem.end), "--every",
                        str(problem.every), "--channels", ",".join(problem.channels), "--out", out, *options],
                       check=True, capture_output=True)
        report = json.loads((out / "summary.json").read_text())
        return runners.at_times(problem, problems.read_table(out / "trajectory.csv"), "simbody"), report

    def error(self, problem, *options, **method):
        with tempfile.TemporaryDirectory() as folder:
            model = export(folder, problem.mechanism, *(f"{k}={v}" for k, v in problem.parameters))
            columns, report = self.run_model(problem, model, *options, **method)
            return problems.error(problem, columns, problems.known_truth(problem).columns), report

    def test_chain_against_its_table(self):
        error, report = self.error(problems.chain(4), "--accuracy", "1e-11")
        self.assertLess(error, 1e-11)
        self.assertEqual((report["speeds"], report["constraints"]), (4, 0))
        self.assertLess(self.error(problems.chain(16), "--accuracy", "1e-10", "--interpolate")[0], 1e-5)

    def test_suspension_against_its_table(self):
        error, report = self.error(problems.suspension_chain(1), "--accuracy", "1e-6")
        self.assertLess(error, 2e-8)  # the table is good to 1e-8
        self.assertEqual(report["speeds"], 30)  # a free chassis, two corners of a free upright and two balls
        other = self.error(problems.suspension_chain(1), "--accuracy", "1e-5", "--euler-angles", "--library-forces")[0]
        self.assertLess(other, 1e-7)  # the other law of the library's bushings differs by 5e-8

    def test_loops_against_their_solution(self):
        two = self.error(problems.four_bar(2), "--accuracy", "1e-6", "--constraint-tolerance", "1e-13")
        self.assertLess(two[0], 1e-3)
        self.assertEqual(two[1]["constraints"], 4)
        five = self.error(problems.four_bar(2), "--accuracy", "1e-6", "--constraint-tolerance", "1e-12", "--full-loops")
        self.assertLess(five[0], 1e-3)
        self.assertEqual(five[1]["constraints"], 10)

    def test_perfect_joints_as_in_gudgeon(self):
        problem = problems.suspension_chain(2)
        with tempfile.TemporaryDirectory() as folder:
            model = export(folder, "suspension-chain", "units=2", "joints=perfect")
            ours, report = self.run_model(problem, model, "--accuracy", "1e-8")
            subprocess.run([GUDGEON, "run", model, "--integrator", "radau", "--rtol", "1e-9", "--end", "5", "--every",
                            "0.05", "--channels", "chassis*.z", "--quiet", "--out", f"{folder}/g"], check=True)
            theirs = problems.read_table(pathlib.Path(folder) / "g/trajectory.csv")
        self.assertLess(problems.error(problem, ours, theirs), 1e-7)
        self.assertEqual(report["constraints"], 16)  # 4 corners of a ball (3) and a rod (1)

    def test_bushings_springs_and_tyres_at_large_turns_as_in_gudgeon(self):
        model = {"gudgeon": 1, "name": "mount", "bodies": [
            {"name": "a", "mass": 2, "inertia": [0.1, 0.2, 0.25], "position": [0.1, 0.2, 0.3],
             "orientation": [0.9, 0.1, 0.3, -0.3], "velocity": [0.5, -1, 0.3], "angular_velocity": [4, 2, -3]},
            {"name": "b", "mass": 1, "inertia": [[0.05, 0.01, 0], [0.01, 0.06, 0.02], [0, 0.02, 0.07]],
             "position": [0.6, 0.1, 0.2]}],
            "joints": [{"name": "M", "kind": "rigid", "bodies": ["ground", "a"], "point": [0, 0.1, 0.2],
                        "fidelity": "bushing", "bushing": {"stiffness": [400, 500, 600, 1, 1.5, 2],
                                                           "damping": [1, 2, 3, 0.02, 0.03, 0.04]}},
                       {"name": "N", "kind": "revolute", "bodies": ["a", "b"], "point": [0.3, 0.1, 0.2],
                        "axis": [1, 2, 2], "fidelity": "bushing",
                        "bushing": {"stiffness": [300, 300, 200, 2, 1, 0.5], "damping": [2, 2, 2, 0.02, 0.02, 0.02],
                                    "preload": [1, -2, 3, 0.1, 0.2, -0.1]}}],
            "forces": [{"name": "S", "kind": "spring-damper", "bodies": ["a", "b"],
                        "points": [[0.1, 0.3, 0.3], [0.7, 0.3, 0.1]], "stiffness": 30, "damping": 0.5,
                        "free_length": 0.4},
                       {"name": "T", "kind": "tyre", "body": "b", "point": [0.8, 0.1, 0.1], "stiffness": 50,
                        "damping": 1, "preload": 10, "road": {"kind": "harmonic", "amplitude": 0.1, "frequency": 1}}],
            "markers": [{"name": "tip", "body": "b", "point": [1.1, 0.1, 0.2]}]}
        problem = problems.Problem("mount", 1, (), 1, 0.1, (("a.x", "a.y", "a.z"), ("tip.x", "tip.y", "tip.z")))
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "model.json"
            file.write_text(json.dumps(model))
            ours, _ = self.run_model(problem, file, "--accuracy", "1e-10")
            subprocess.run([GUDGEON, "run", file, "--integrator", "radau", "--rtol", "1e-11", "--end", "1", "--every",
                            "0.1", "--channels", "a.?,tip.?,M.a?", "--quiet", "--out", f"{folder}/g"], check=True)
            theirs = problems.read_table(pathlib.Path(folder) / "g/trajectory.csv")
        turn = max(math.hypot(*row) for row in zip(theirs["M.ax"], theirs["M.ay"], theirs["M.az"]))
        self.assertGreater(turn, 1)
        self.assertLess(turn, 3)
        self.assertLess(problems.error(problem, ours, theirs), 1e-8)

    def test_what_it_does_not_know_is_refused(self):
        cases = {"bouncing-journal": "/joints/0: joint .*fidelity is not known", "stick-slip": "/joints/0: joint .*",
                 "slider-crank": "this kind is not known", "heavy-top": None}
        for mechanism, message in cases.items():
            with tempfile.TemporaryDirectory() as folder:
                done = subprocess.run([SIMBODY, export(folder, mechanism), "--end", "0.1", "--out", f"{folder}/out"],
                                      capture_output=True, text=True, check=False)
            if message is None:
                self.assertEqual((done.returncode, done.stderr), (0, ""), mechanism)
            else:
                self.assertEqual(done.returncode, 2, mechanism)
                self.assertRegex(done.stderr, message)

    def test_channels_that_do_not_exist_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([SIMBODY, export(folder, "chain"), "--channels", "tip.x,tap.x", "--out", folder],
                                  capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("no channel fits tap.x", done.stderr)


if __name__ == "__main__":
    unittest.main()
