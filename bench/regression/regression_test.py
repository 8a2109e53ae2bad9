#!/usr/bin/env python3
"""The comparison of regression.py with made-up counts."""
import copy
import json
import pathlib
import tempfile
import unittest

import regression

RECORD = {
    "environment": {"compiler": "GNU 12.2.0", "glibc": "2.36"},
    "kernels": {
        "calibration": {"instructions": 1000000, "note": ""},
        "joint/revolute": {"instructions": 400000, "note": ""},
        "step/gear": {"instructions": 5000000, "note": "10 steps, 20 sweeps"},
    },
}


def scaled(factors, environment=None):
    """The record with the instructions of some kernels times a factor."""
    counts = copy.deepcopy(RECORD)
    for name, factor in factors.items():
        counts["kernels"][name]["instructions"] = round(factor * counts["kernels"][name]["instructions"])
    counts["environment"].update(environment or {})
    return counts


class Comparison(unittest.TestCase):
    def judge(self, counts, **options):
        verdict, report = regression.compare(counts, RECORD, **options)
        return verdict, "\n".join(report)

    def test_the_same_counts_pass(self):
        self.assertEqual(self.judge(RECORD), (0, "2 kernels compared, limit 5%: 0 slower, 0 faster"))

    def test_ten_percent_slower_fails_with_kernel_and_amount(self):
        verdict, report = self.judge(scaled({"joint/revolute": 1.1}))
        self.assertEqual(verdict, 1)
        self.assertIn("SLOWER joint/revolute: 10.0% slower\n", report)
        self.assertNotIn("step/gear", report)

    def test_the_limit(self):
        self.assertEqual(self.judge(scaled({"step/gear": 1.049}))[0], 0)
        self.assertEqual(self.judge(scaled({"step/gear": 1.051}))[0], 1)
        self.assertEqual(self.judge(scaled({"step/gear": 1.051}), limit=0.06)[0], 0)

    def test_faster_passes_and_asks_for_renewal(self):
        verdict, report = self.judge(scaled({"joint/revolute": 0.9}))
        self.assertEqual(verdict, 0)
        self.assertIn("faster joint/revolute: 10.0% faster", report)
        self.assertIn("renewed", report)

    def test_the_worst_is_named_first(self):
        _, report = self.judge(scaled({"joint/revolute": 1.2, "step/gear": 1.5}))
        self.assertLess(report.index("step/gear: 50.0%"), report.index("joint/revolute: 20.0%"))

    def test_ratios_count_not_instructions(self):
        everything = dict.fromkeys(RECORD["kernels"], 1.3)
        self.assertEqual(self.judge(scaled(everything))[0], 0)
        self.assertEqual(self.judge(scaled(everything | {"step/gear": 1.43}))[0], 1)
        self.assertEqual(self.judge(scaled({"calibration": 1 / 1.1}))[0], 1)

    def test_what_the_kernel_says_is_told_where_it_changed(self):
        counts = scaled({"step/gear": 1.2})
        counts["kernels"]["step/gear"]["note"] = "10 steps, 25 sweeps"
        self.assertIn("(10 steps, 25 sweeps; in the record 10 steps, 20 sweeps)", self.judge(counts)[1])

    def test_other_tools_skip_with_their_names(self):
        verdict, report = self.judge(scaled({"step/gear": 1.3}, {"compiler": "GNU 14.1.0"}))
        self.assertEqual(verdict, 77)
        self.assertIn("compiler: GNU 14.1.0, in the record GNU 12.2.0", report)
        self.assertNotIn("glibc:", report)

    def test_other_tools_excuse_no_slow_down_beyond_the_wide_limit(self):
        self.assertEqual(self.judge(scaled({"step/gear": 1.6}, {"compiler": "GNU 14.1.0"}))[0], 1)

    def test_an_item_of_the_environment_that_came_or_went(self):
        report = self.judge(scaled({}, {"suitesparse": "7.0"}))[1]
        self.assertIn("suitesparse: 7.0, in the record none", report)

    def test_kernels_and_record_must_be_the_same(self):
        counts = scaled({})
        counts["kernels"]["strips"] = counts["kernels"].pop("joint/revolute")
        verdict, report = self.judge(counts)
        self.assertEqual(verdict, 1)
        self.assertIn("NOT IN THE RECORD: strips", report)
        self.assertIn("ONLY IN THE RECORD: joint/revolute", report)

    def test_a_part_of_the_kernels_may_be_asked_for(self):
        counts = scaled({})
        del counts["kernels"]["joint/revolute"]
        self.assertEqual(self.judge(counts, partial=True)[0], 0)


class Files(unittest.TestCase):
    def test_a_renewed_record_is_read_as_it_was_counted(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "record.json"
            regression.write_record(RECORD, path)
            first = path.read_text()
            record = json.loads(first)
            regression.write_record(record, path)
            self.assertEqual(path.read_text(), first)
        self.assertEqual(regression.compare(RECORD, record)[0], 0)
        self.assertEqual(record["environment"], RECORD["environment"])
        self.assertEqual(record["kernels"]["joint/revolute"]["ratio"], 0.4)

    def test_lines_of_the_program(self):
        text = "environment\tcompiler\tGNU 12.2.0\nother words\nkernel\tstep/gear\t10\t3 steps\nkernel\ta\t11\t\n"
        self.assertEqual(regression.parse_output(text), ({"compiler": "GNU 12.2.0"}, {"step/gear": "3 steps", "a": ""}))

    def test_files_of_callgrind(self):
        dump = ("version: 1\ndesc: Trigger: Client Request: klu/solve\nevents: Ir\nsummary: {}\n\n"
                "fn=(1) main\n0 5\ntotals: {}\n")
        self.assertEqual(regression.parse_dump(dump.format(123, 123)), ("klu/solve", 123))
        self.assertIsNone(regression.parse_dump("desc: Trigger: Program termination\nsummary: 7\ntotals: 7\n"))
        with self.assertRaises(regression.CountError):
            regression.parse_dump(dump.format(123, 124))


if __name__ == "__main__":
    unittest.main()
