#!/usr/bin/env python3
"""Every kernel, made to do 10 % more work than it should, fails the check and is named: slower_test.py PROGRAM."""
import argparse
import pathlib
import subprocess
import sys
import tempfile

import regression

SCRIPT = pathlib.Path(__file__).with_name("regression.py")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--valgrind", default="valgrind")
    options = parser.parse_args()
    faults = []

    as_it_is = regression.count(options.program, options.valgrind)
    slowed = regression.count(options.program, options.valgrind, arguments=["--slower", "*=10"])
    verdict, report = regression.compare(slowed, as_it_is)
    kernels = [name for name in as_it_is["kernels"] if name != regression.CALIBRATION]
    named = {line.split()[1].rstrip(":"): line.split()[2] for line in report if line.startswith("SLOWER ")}
    faults += [f"all kernels slowed: exit status {verdict}"] if verdict != 1 else []
    faults += [f"{name} slowed by 10 %: {named.get(name, 'not noticed')}" for name in kernels
               if not 9.5 < float(named.get(name, "0").rstrip("%")) < 10.5]

    with tempfile.TemporaryDirectory() as folder:  # one kernel alone, by the command
        record = pathlib.Path(folder) / "record.json"
        regression.write_record(as_it_is, record)
        victim = kernels[0]
        command = [sys.executable, SCRIPT, options.program, "--valgrind", options.valgrind, "--record", record]
        group = ["--only", victim.rsplit("/", 1)[0] + "/*"]
        for more, status in (([], 0), (["--slower", f"{victim}=10"], 1)):
            done = subprocess.run([*command, *group, *more], capture_output=True, text=True, check=False)
            slower = [line for line in done.stdout.splitlines() if line.startswith("SLOWER")]
            if done.returncode != status or [victim in line for line in slower] != [True] * status:
                faults.append(f"{[*group, *more]}: exit status {done.returncode}\n{done.stdout}{done.stderr}")

    print("\n".join(faults) or f"{len(kernels)} kernels slowed by 10 %: each is named")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
