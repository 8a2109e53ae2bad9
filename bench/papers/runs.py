"""Runs of the command `gudgeon` and their results; what the scripts of this folder share."""

import argparse
import json
import pathlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

try:
    import matplotlib
    import numpy as np
except ImportError as missing:
    sys.exit(f"{missing}: apt-get install python3-matplotlib, and run with /usr/bin/python3")
matplotlib.use("Agg")
ROOT = pathlib.Path(__file__).resolve().parents[2]
REFERENCE = ROOT / "tests" / "data" / "reference"


def parser(doc, out):
    """Options that every script has."""
    p = argparse.ArgumentParser(description=doc, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    p.add_argument("--gudgeon", default=ROOT / "build/release/bin/gudgeon", type=pathlib.Path, help="the program")
    p.add_argument("--out", default=pathlib.Path(out), type=pathlib.Path, help="folder of the results")
    p.add_argument("--jobs", default=1, type=int, help="runs at a time")
    p.add_argument("--limit", default=120, type=float, help="s, each run")
    p.add_argument("--reuse", action="store_true", help="take runs that are there already")
    return p


def table(path):
    """Columns of a CSV file by name; lines starting with # are skipped."""
    with open(path) as lines:
        rows = [line.strip() for line in lines if not line.startswith("#")]
    values = [[float(x) if x else np.nan for x in row.split(",")] for row in rows[1:]]
    return dict(zip(rows[0].split(","), np.array(values).T))


def events(path):
    """contacts.csv: list of (time, depth, speed, event, joint, contact)."""
    rows = path.read_text().splitlines()[1:]
    return [(float(a), float(b), float(c), d, e, f) for a, b, c, d, e, f in (row.split(",") for row in rows)]


class Run:
    """One finished run; `ok` tells whether it reached its end."""

    def __init__(self, folder, command):
        self.folder, self.command = folder, command
        path = folder / "summary.json"
        self.summary = json.loads(path.read_text()) if path.exists() else {"status": "no result within the limit"}
        self.ok = self.summary["status"] == "ok"

    def columns(self):
        return table(self.folder / "trajectory.csv")

    def events(self):
        return events(self.folder / "contacts.csv")

    def steps(self):
        """End, length, accepted (bool) of every attempt."""
        rows = [row.split(",") for row in (self.folder / "steps.csv").read_text().splitlines()[1:]]
        return (np.array([float(r[0]) for r in rows]), np.array([float(r[1]) for r in rows]),
                np.array([r[-1] == "accepted" for r in rows]))


def run(options, name, model, arguments):
    """Runs a model (mechanism or file) into OUT/runs/NAME."""
    folder = (options.out / "runs" / name).resolve()
    command = ["run", str(model), *map(str, arguments)]
    if not (options.reuse and (folder / "summary.json").exists()):
        if (folder / "summary.json").exists():
            (folder / "summary.json").unlink()
        folder.mkdir(parents=True, exist_ok=True)
        try:
            done = subprocess.run([str(options.gudgeon.resolve()), *command, "--quiet", "--out", str(folder)],
                                  capture_output=True, text=True, timeout=options.limit)
            if done.returncode:
                print(name, done.stderr.strip(), file=sys.stderr)
        except subprocess.TimeoutExpired:
            print(f"{name}: stopped after {options.limit} s", file=sys.stderr)
    return Run(folder, "gudgeon " + " ".join(command))


def run_all(options, cases):
    """{name: (model, arguments)} -> {name: Run}."""
    with ThreadPoolExecutor(options.jobs) as pool:
        futures = {name: pool.submit(run, options, name, *case) for name, case in cases.items()}
        return {name: future.result() for name, future in futures.items()}


def write_table(path, head, rows):
    """PATH.md and PATH.csv."""
    cells = [[str(cell) for cell in row] for row in rows]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(cell.replace("|", "/") for cell in row) + " |" for row in cells]
    path.with_suffix(".md").write_text("\n".join(lines) + "\n")
    quoted = [",".join('"' + cell.replace('"', '""') + '"' for cell in row) for row in [head, *cells]]
    path.with_suffix(".csv").write_text("\n".join(quoted) + "\n")
    print("\n".join(lines), "\n")
