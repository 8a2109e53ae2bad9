#!/usr/bin/env python3
"""Measures every ready mechanism and makes the page: results/work_precision/index.html.

    python3 bench/work_precision/run.py                          # all, most of an hour on an idle machine
    python3 bench/work_precision/run.py --quick                  # seconds: does everything work?
    python3 bench/work_precision/run.py --peers results/peers/peers.csv -- --problems 'chain-*' --repeats 9

What follows -- goes to gudgeon_work_precision. Standard library only.
"""
import argparse
import os
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def commit():
    """Of the sources, with a + where they are changed; empty without git."""
    def git(*words):
        return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=True).stdout
    try:
        return git("rev-parse", "--short", "HEAD").strip() + ("+" if git("status", "--porcelain", "-uno") else "")
    except (OSError, subprocess.CalledProcessError):
        return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/bin/gudgeon_work_precision")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "results/work_precision")
    parser.add_argument("--peers", action="append", default=[], help="table of other programs for the page")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("rest", nargs="*", help="options of the program, after --")
    options = parser.parse_args()
    measure = [options.program, "--out", options.out, *(["--quick"] if options.quick else []), *options.rest]
    page = [sys.executable, HERE / "page.py", options.out]
    for table in options.peers:
        page += ["--peers", table]
    for command, environment in ((measure, os.environ | {"GUDGEON_COMMIT": commit()}), (page, os.environ)):
        try:
            done = subprocess.run([str(word) for word in command], env=environment, check=False)
        except OSError as error:
            print(f"{command[0]}: {error.strerror}; build it with cmake --build --preset release", file=sys.stderr)
            return 2
        if done.returncode != 0:
            return done.returncode
    return 0


if __name__ == "__main__":
    sys.exit(main())
