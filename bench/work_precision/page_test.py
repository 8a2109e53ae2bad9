#!/usr/bin/env python3
"""The page and its interpolation: page_test.py PROGRAM FOLDER, the folder of a quick run of PROGRAM."""
import csv
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import equal_error
import page

HERE = pathlib.Path(__file__).resolve().parent
PROGRAM, FOLDER = sys.argv.pop(1), pathlib.Path(sys.argv.pop(1))


def run(**changes):
    row = {"program": "gudgeon", "mechanism": "chain", "size": 4, "method": "gear", "formulation": "saddle-point",
           "tolerance": 1e-3, "status": "ok", "error": 1e-3, "cpu_s": 1e-2, "steps": 10, "evaluations": 30,
           "factorisations": 2, "refactorisations": 5, "sweeps": 20, "bodies": 4, "reference": "exact",
           "reference_believed": 1e-12}
    return row | changes


class Interpolation(unittest.TestCase):
    def test_a_power_law_is_met_exactly(self):
        points = [(10.0 ** -k, 3e-3 * 10 ** (k / 5)) for k in range(1, 8)]  # order 5
        for error in (1e-2, 3.7e-4, 1e-5):
            cost = equal_error.cost_at(points, error)
            self.assertAlmostEqual(cost.seconds, 3e-3 * error ** -0.2, delta=1e-12)
            self.assertFalse(cost.at_most)

    def test_the_tightest_crossing_counts(self):
        lucky = [(1e-6, 1.0), (1e-3, 2.0), (1e-7, 4.0)]  # the loosest tolerance met 1e-5 by chance
        self.assertAlmostEqual(equal_error.cost_at(lucky, 1e-5).seconds, 2 * math.sqrt(2))

    def test_ends(self):
        points = [(1e-2, 1.0), (1e-4, 2.0)]
        self.assertIsNone(equal_error.cost_at(points, 1e-5))
        self.assertEqual(equal_error.cost_at(points, 1e-1), equal_error.Cost(1.0, True))
        self.assertIsNone(equal_error.cost_at([], 1e-3))

    def test_below_the_reference(self):
        rows = [run(error=1e-5, cpu_s=1.0), run(tolerance=1e-4, status="below-reference", error=None, cpu_s=4.0,
                                                reference_believed=1e-8)]
        self.assertAlmostEqual(equal_error.cost_at(equal_error.points_of(rows), 1e-6).seconds, 2.0)
        self.assertIsNone(equal_error.cost_at(equal_error.points_of(rows), 9e-8))

    def test_runs_without_a_result_do_not_count(self):
        rows = [run(status=status, error=None) for status in ("lost", "not-run", "refused", "newton")]
        self.assertEqual(equal_error.points_of(rows), [])

    def test_curves_go_from_loose_to_tight(self):
        rows = [run(tolerance=1e-5), run(tolerance=1e-2), run(tolerance=1e-4, method="ida", formulation="")]
        curves = equal_error.curves_of(rows)
        self.assertEqual([row["tolerance"] for row in curves[("gudgeon", "gear", "saddle-point")]], [1e-2, 1e-5])
        self.assertEqual(len(curves), 2)


class Page(unittest.TestCase):
    RUNS = [run(tolerance=10.0 ** -k, error=10.0 ** -k, cpu_s=1e-3 * k) for k in range(2, 8)]
    RUNS += [run(method="radau", tolerance=10.0 ** -k, error=10.0 ** -k, cpu_s=4e-3 * k) for k in range(2, 8)]

    def test_the_best_is_marked_and_others_have_ratios(self):
        table = page.summary(self.RUNS, 1e-3)
        self.assertEqual(table.count('class="best"'), 1)
        self.assertRegex(table, r'class="best">3\.00 ms')
        self.assertIn("4.0×", table)

    def test_other_programs_show_their_best_method(self):
        peers = [run(program="Other", method=method, formulation="", error=1e-3, cpu_s=cpu)
                 for method, cpu in (("slow", 1.0), ("quick", 1e-3))]
        table = page.summary(self.RUNS + peers, 1e-3)
        self.assertIn("<i>quick</i>", table)
        self.assertNotIn("<i>slow</i>", table)
        text = page.make_page(self.RUNS + peers, {})
        self.assertIn("Other slow", text)

    def test_units(self):
        self.assertEqual([page.seconds(s) for s in (2.345e-5, 9.996e-4, 0.0456, 0.9999, 12.34, 345.6)],
                         ["23.4 µs", "1.00 ms", "45.6 ms", "1.00 s", "12.3 s", "346 s"])

    def test_nothing_in_a_table_can_break_out(self):
        text = page.make_page([run(program="</script><b>", error=1e-3)], {})
        self.assertEqual(text.count("</script>"), 2)


class WholeRun(unittest.TestCase):
    """A quick run of the program."""
    @classmethod
    def setUpClass(cls):
        cls.ids = subprocess.run([PROGRAM, "list", "--quick"], capture_output=True, text=True, check=True).stdout.split()
        with tempfile.TemporaryDirectory() as scratch:
            out = pathlib.Path(scratch) / "page.html"
            subprocess.run([sys.executable, "-B", HERE / "page.py", FOLDER, "--out", out], check=True,
                           capture_output=True)
            cls.text = out.read_text(encoding="utf-8")
        cls.runs = equal_error.read_runs(FOLDER / "work_precision.csv")
        cls.record = json.loads((FOLDER / "work_precision.json").read_text(encoding="utf-8"))

    def test_the_page_has_every_problem(self):
        self.assertEqual([p["id"] for p in self.record["problems"]], self.ids)
        data = json.loads(re.search(r'type="application/json">(.*?)</script>', self.text, re.DOTALL)[1])
        self.assertEqual([c["title"] for c in data["charts"]],
                         [page.title_of(*p, page.is_sized(p, self.runs)) for p in equal_error.problems_of(self.runs)])
        self.assertEqual(len(data["charts"]), len(self.ids))
        for chart in data["charts"]:
            self.assertIn(f'href="#{chart["id"]}"', self.text)
            self.assertTrue(any(curve["points"] for curve in chart["curves"]), chart["title"])
        self.assertIsNone(re.search(r"@[A-Z]+@", self.text))

    def test_the_page_needs_nothing_else(self):
        outside = set(re.findall(r"(?:https?:)?//[\w.]+\.\w+", self.text)) - {"http://www.w3.org"}
        self.assertEqual(outside, set())
        self.assertIsNone(re.search(r"<link|@import|\ssrc=", self.text))

    def test_both_forms_of_the_table_agree(self):
        with open(FOLDER / "work_precision.csv", newline="", encoding="utf-8") as file:
            header = next(csv.reader(file))
        self.assertEqual(header[:len(equal_error.COLUMNS)], equal_error.COLUMNS)
        self.assertEqual(len(self.runs), len(self.record["runs"]))
        for line, row in zip(self.runs, self.record["runs"]):
            self.assertEqual(line["error"], row["error"])

    def test_every_integrator_takes_part(self):
        methods = {run["method"] for run in self.runs if run["status"] in ("ok", "below-reference")}
        self.assertEqual(methods, {"gear", "radau", "auto", "erk", "ida", "rk4", "bayo"})
        for method in ("gear", "radau"):
            self.assertEqual({run["formulation"] for run in self.runs if run["method"] == method},
                             {"saddle-point", "augmented-lagrangian"})

    def test_no_error_is_stated_below_the_reference(self):
        for row in self.runs:
            if row["status"] == "ok":
                self.assertGreaterEqual(row["error"], 0.999 * equal_error.CERTAIN * row["reference_believed"])
            else:
                self.assertIsNone(row["error"])


if __name__ == "__main__":
    unittest.main()
