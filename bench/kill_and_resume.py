#!/usr/bin/env python3
"""Kills runs at random times (SIGKILL) and goes on with `gudgeon resume` until they are done; counts the bits in
which the files differ from those of the run that nobody killed.

    bench/kill_and_resume.py build/release/bin/gudgeon [--kills 100] [--seed 1]

Compared: trajectory.csv, trajectory.h5, steps.csv, contacts.csv byte for byte, summary.json without times and the options
as typed. Exit 1 if a bit differs.
"""
import argparse
import json
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

CASES = [  # arguments of the run, simulated time between checkpoints
    (["slider-crank", "--param", "joint=spherical", "--integrator", "gear", "--end", "5"], 0.02),
    (["slider-crank", "--param", "joint=revolute", "--integrator", "radau", "--end", "1"], 0.01),
    (["slider-crank", "--param", "joint=spherical", "--integrator", "rk4", "--step", "2e-5", "--end", "0.3"], 0.01),
    (["suspension-chain", "--param", "units=4", "--param", "joints=mixed", "--end", "0.4"], 0.02),
    (["stick-slip", "--integrator", "gear", "--rtol", "1e-8", "--end", "300"], 2),
    (["suspension-chain", "--param", "units=20", "--integrator", "auto", "--channels", "*.z,energy.*", "--end", "2"],
     0.1),
    (["four-bar", "--param", "loops=10", "--integrator", "gear", "--channels", "crank*", "--end", "10"], 0.1),
]
TIMES = ("cpu_seconds", "cpu_seconds_by_phase", "wall_seconds", "settings")


def differing_bits(a, b):
    shorter = min(len(a), len(b))
    bits = 8 * abs(len(a) - len(b))
    if a[:shorter] != b[:shorter]:
        x = int.from_bytes(a[:shorter], "little") ^ int.from_bytes(b[:shorter], "little")
        bits += bin(x).count("1")
    return bits


def summary(folder):
    content = json.loads((folder / "summary.json").read_text())
    return json.dumps({k: v for k, v in content.items() if k not in TIMES}).encode()


def compare(straight, resumed):
    bits = differing_bits(summary(straight), summary(resumed))
    for name in ("trajectory.csv", "trajectory.h5", "steps.csv", "contacts.csv"):
        bits += differing_bits((straight / name).read_bytes(), (resumed / name).read_bytes())
    return bits


def kill_until_done(gudgeon, case, checkpoint, folder, longest, most_kills):
    """Returns the number of kills that met a running program, and of runs without a checkpoint yet."""
    kills = fresh = 0
    while True:
        begun = (folder / "checkpoint.gudgeon").exists()
        command = [gudgeon, "resume", str(folder)] if begun else [
            gudgeon, "run", *case, "--steps", "--contacts", "--checkpoint", str(checkpoint), "--out", str(folder)]
        fresh += not begun
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if kills < most_kills:
            time.sleep(random.uniform(0, longest))
            process.send_signal(signal.SIGKILL)
        message = process.communicate()[1]
        if process.returncode == -signal.SIGKILL:
            kills += 1
        elif process.returncode == 0:
            return kills, fresh
        else:
            sys.exit(f"{command}: exit {process.returncode}: {message}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("gudgeon")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    random.seed(arguments.seed)
    total = bits = 0
    with tempfile.TemporaryDirectory() as temporary:
        for i, (case, checkpoint) in enumerate(CASES):
            straight = pathlib.Path(temporary) / f"straight{i}"
            begin = time.time()
            subprocess.run([arguments.gudgeon, "run", *case, "--steps", "--contacts", "--quiet", "--out", straight],
                           check=True)
            wall = time.time() - begin
            kills = runs = differ = 0
            wanted = arguments.kills * (i + 1) // len(CASES) - arguments.kills * i // len(CASES)
            while kills < wanted:
                resumed = pathlib.Path(temporary) / f"resumed{i}"
                shutil.rmtree(resumed, ignore_errors=True)
                done, _ = kill_until_done(arguments.gudgeon, case, checkpoint, resumed, 0.7 * wall, wanted - kills)
                kills += done
                runs += 1
                differ += compare(straight, resumed)
            print(f"{' '.join(case)}: {kills} kills in {runs} runs of {wall:.2f} s, {differ} bits differ", flush=True)
            total += kills
            bits += differ
    print(f"{total} kills, {bits} bits differ")
    return 1 if bits else 0


if __name__ == "__main__":
    sys.exit(main())
