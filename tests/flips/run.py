#!/usr/bin/env python3
"""Breaks the physics one sign or factor at a time and checks that a test fails each time.

    python3 tests/flips/run.py [--build DIR] [--only TEXT] [--jobs N]

Works on a copy of the sources in DIR (default build/flips), never on the tree itself. flips.txt has one flip a
line: file | old | new, where old occurs exactly once in the file. Ends with "N passed, N failed": a flip that
no test notices is a failure. Exit status 0 only when all were noticed.
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["app", "bench", "cmake", "contact", "core", "models", "solvers", "tests"]


def read_flips(only):
    flips = []
    for line in (ROOT / "tests/flips/flips.txt").read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            name, old, new = (part.strip() for part in line.split(" | "))
            if only in line:
                flips.append((name, old, new))
    return flips


def copy_sources(target):
    """Copies what changed, so that a second run builds little."""
    files = [f for folder in FOLDERS for f in (ROOT / folder).rglob("*") if f.is_file()] + [ROOT / "CMakeLists.txt"]
    for file in files:
        copy = target / file.relative_to(ROOT)
        if not copy.exists() or copy.read_bytes() != file.read_bytes():
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, copy)  # a new time: a flip left by a killed run is built again
    wanted = {target / file.relative_to(ROOT) for file in files}
    for copy in target.rglob("*"):
        if copy.is_file() and copy not in wanted:
            copy.unlink()


def run(command, log):
    with open(log, "w") as out:
        return subprocess.run(command, stdout=out, stderr=subprocess.STDOUT).returncode


def first_failure(log):
    for line in log.read_text(errors="replace").splitlines():
        if "[  FAILED  ]" in line:
            return line.split("]", 1)[1].split("(")[0].strip()
    return "the test program ended early"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=ROOT / "build/flips", type=pathlib.Path)
    parser.add_argument("--only", default="", help="flips whose line contains this text")
    parser.add_argument("--jobs", default="2")
    parser.add_argument("--filter", default="-*Slow*:*CommandLine*:*BadInputs*", help="gtest filter")
    options = parser.parse_args()
    os.environ["OMP_WAIT_POLICY"] = "passive"  # waiting threads must not fight the builds for the cores
    source, build = options.build / "source", options.build / "build"
    source.mkdir(parents=True, exist_ok=True)
    copy_sources(source)
    configure = ["cmake", "-S", source, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                 "-DCMAKE_CXX_FLAGS_RELEASE=-O1", "-DGUDGEON_BENCH=OFF", "-DGUDGEON_WERROR=OFF"]
    make = ["cmake", "--build", build, "-j", options.jobs, "--target", "gudgeon_tests"]
    test = [build / "bin/gudgeon_tests", f"--gtest_filter={options.filter}", "--gtest_fail_fast"]
    log = options.build / "log.txt"
    if run(configure, log) or run(make, log) or run(test, log):
        sys.exit(f"the unbroken sources do not build and pass: see {log}")
    passed, failed = 0, 0
    for name, old, new in read_flips(options.only):
        path = source / name
        text = path.read_text()
        if text.count(old) != 1:
            print(f"FAILED  {name}: '{old}' occurs {text.count(old)} times", flush=True)
            failed += 1
            continue
        path.write_text(text.replace(old, new))
        if run(make, log):
            verdict, failed = "FAILED  does not compile", failed + 1
        elif run(["timeout", "600", *test], log):
            verdict, passed = f"noticed by {first_failure(log)}", passed + 1
        else:
            verdict, failed = "FAILED  no test noticed", failed + 1
        print(f"{name}: '{old}' -> '{new}': {verdict}", flush=True)
        path.write_text(text)
    print(f"{passed} passed, {failed} failed")
    sys.exit(failed != 0)


if __name__ == "__main__":
    main()
