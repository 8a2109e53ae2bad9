#!/usr/bin/env python3
"""Counts the instructions of every kernel under callgrind and compares them with a committed record.

    regression.py PROGRAM --record record.json             # judges
    regression.py PROGRAM --record record.json --renew     # writes the record anew
    regression.py PROGRAM --record record.json --only 'klu/*'

PROGRAM is made of counted.hpp. Counts are compared as ratios to the program's calibration kernel, counted in the
same run. Exit status: 0 no kernel is slower; 1 a kernel is slower by more than the limit, or the record does not
have the same kernels; 2 nothing could be counted; 77 (skipped) the record was made by other tools: then only what
is slower by more than the wide limit fails. See README.md.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

# Slower by more: fails; faster by more: the record should be renewed. Counts repeat to 2 % at worst, where the heap
# changes, so that a slow-down of 10 % is seen and nothing that is none.
LIMIT = 0.05
WIDE_LIMIT = 0.5  # where compiler or libraries are not those of the record
SKIPPED = 77
CALIBRATION = "calibration"

# glibc has its mathematics and string functions once for each family of processors, which take different numbers
# of instructions (up to a fifth of a kernel): those of the first x86-64 run everywhere. Nothing else of the user's
# environment passes.
FEATURES = ("AVX512F AVX512VL AVX2 AVX FMA FMA4 BMI1 BMI2 LZCNT MOVBE POPCNT SSE4_1 SSE4_2 SSSE3 ERMS FSRM RTM "
            "AVX_Fast_Unaligned_Load Fast_Unaligned_Copy").split()
ENVIRONMENT = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=" + ",".join("-" + feature for feature in FEATURES),
    "LC_ALL": "C",
    "LD_BIND_NOW": "1",
    "OMP_NUM_THREADS": "1",
    "OMP_DYNAMIC": "false",
    "PATH": "/usr/bin:/bin",
}


class CountError(Exception):
    pass


def parse_output(text):
    """The program's lines: (environment, {kernel: note}), kernels in their order."""
    environment, notes = {}, {}
    for line in text.splitlines():
        fields = line.split("\t")
        if fields[0] == "environment" and len(fields) == 3:
            environment[fields[1]] = fields[2]
        elif fields[0] == "kernel" and len(fields) == 4:
            notes[fields[1]] = fields[3]
    return environment, notes


def parse_dump(text):
    """(kernel, instructions) of one file of callgrind; None for a file of no kernel."""
    trigger = re.search(r"^desc: Trigger: Client Request: (.*)$", text, re.MULTILINE)
    if not trigger:
        return None
    sums = {int(total) for total in re.findall(r"^(?:summary|totals): (\d+)", text, re.MULTILINE)}
    if len(sums) != 1:
        raise CountError(f"callgrind contradicts itself on {trigger[1]}: {sorted(sums)}")
    return trigger[1], sums.pop()


def count(program, valgrind="valgrind", keep=None, arguments=()):
    """Runs the program under callgrind: {"environment": ..., "kernels": {name: {"instructions", "note"}}}."""
    program = pathlib.Path(program).resolve()
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(keep or scratch)
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.glob("callgrind.out*"):
            old.unlink()
        command = [valgrind, "--tool=callgrind", "--instr-atstart=no", "--quiet",
                   f"--callgrind-out-file={folder}/callgrind.out", str(program), *arguments]
        try:
            done = subprocess.run(command, capture_output=True, text=True, env=passed_on(), check=False)
            version = subprocess.run([valgrind, "--version"], capture_output=True, text=True, check=False)
        except OSError as error:
            raise CountError(f"{valgrind}: {error.strerror}") from error
        if done.returncode != 0:
            raise CountError(f"{program.name} ended with status {done.returncode} under {valgrind}\n{done.stderr}")
        environment, notes = parse_output(done.stdout)
        environment["valgrind"] = version.stdout.strip().removeprefix("valgrind-")
        counts = dict(filter(None, (parse_dump(file.read_text()) for file in folder.glob("callgrind.out*"))))
    missing = [name for name in notes if counts.get(name, 0) == 0]
    if missing or CALIBRATION not in notes:
        raise CountError(f"no counts of {', '.join(missing) or CALIBRATION}")
    kernels = {name: {"instructions": counts[name], "note": note} for name, note in notes.items()}
    return {"environment": environment, "kernels": kernels}


def passed_on():
    kept = {name: os.environ[name] for name in ("LD_LIBRARY_PATH", "VALGRIND_LIB") if name in os.environ}
    return ENVIRONMENT | kept


def ratio(counts, name):
    return counts["kernels"][name]["instructions"] / counts["kernels"][CALIBRATION]["instructions"]


def compare(now, record, limit=LIMIT, wide_limit=WIDE_LIMIT, partial=False):
    """(exit status, lines of the report). partial: kernels that were not counted are not missed."""
    other = differences(now["environment"], record["environment"])
    bound = wide_limit if other else limit
    report, slower, faster = [], [], []
    names = [name for name in now["kernels"] if name != CALIBRATION]
    for name in names:
        if name not in record["kernels"]:
            report.append(f"NOT IN THE RECORD: {name}")
            continue
        change = ratio(now, name) / ratio(record, name) - 1
        line = f"{name}: {abs(change):.1%} {'slower' if change > 0 else 'faster'}" + notes(name, now, record)
        if change > bound:
            slower.append((change, f"SLOWER {line}"))
        elif change < -bound:
            faster.append((change, f"faster {line}"))
    gone = [name for name in record["kernels"] if name not in now["kernels"]]
    report += [] if partial else [f"ONLY IN THE RECORD: {name}" for name in gone]
    failed = bool(slower or report)
    report += [line for _, line in sorted(slower, reverse=True)] + [line for _, line in sorted(faster)]
    if faster and not other:
        report.append("The record should be renewed, else what became faster may become slower again unseen.")
    if other:
        report += ["The record was made by other tools, which moves counts without any change of the sources:", *other,
                   f"Only what is slower by more than {bound:.0%} fails. "
                   "Renew the record with the tools you mean to keep."]
    verdict = 1 if failed else SKIPPED if other else 0
    report.append(f"{len(names)} kernels compared, limit {bound:.0%}: {len(slower)} slower, {len(faster)} faster")
    return verdict, report


def differences(now, then):
    """Lines that say what is not as in the record."""
    return [f"  {item}: {now.get(item, 'none')}, in the record {then.get(item, 'none')}"
            for item in sorted(now.keys() | then.keys()) if now.get(item) != then.get(item)]


def notes(name, now, record):
    """What the program says about its work, where that changed too."""
    new, old = now["kernels"][name]["note"], record["kernels"][name]["note"]
    return f" ({new}; in the record {old})" if new != old else ""


def write_record(counts, path):
    """One line per kernel, so that a renewal reads well in a diff; ratios are for the reader alone."""
    lines = [f"    {json.dumps(name)}: " + json.dumps(kernel | {"ratio": float(f"{ratio(counts, name):.5g}")})
             for name, kernel in counts["kernels"].items()]
    environment = json.dumps(dict(sorted(counts["environment"].items())), indent=4).replace("\n}", "\n  }")
    path.write_text(f'{{\n  "environment": {environment},\n  "kernels": {{\n' + ",\n".join(lines) + "\n  }\n}\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--record", type=pathlib.Path, required=True)
    parser.add_argument("--renew", action="store_true", help="write the record anew")
    parser.add_argument("--only", metavar="GLOB", help="kernels whose name fits")
    parser.add_argument("--slower", metavar="GLOB=PERCENT",
                        help="do so much more work in these kernels: a trial of the check")
    parser.add_argument("--limit", type=float, default=LIMIT,
                        help="share of more instructions that fails (%(default)s)")
    parser.add_argument("--keep", type=pathlib.Path, metavar="FOLDER",
                        help="leave callgrind's files there, for callgrind_annotate")
    parser.add_argument("--report", type=pathlib.Path, metavar="FILE", help="write there what is printed, too")
    parser.add_argument("--valgrind", default="valgrind")
    options = parser.parse_args()
    if options.renew and (options.only or options.slower):
        parser.error("--renew wants every kernel as it is")

    if options.report:
        options.report.unlink(missing_ok=True)
    arguments = []
    for name in ("only", "slower"):
        if value := getattr(options, name):
            arguments += [f"--{name}", value]
    try:
        counts = count(options.program, options.valgrind, options.keep, arguments)
        if options.renew:
            write_record(counts, options.record)
            print(f"{options.record}: {len(counts['kernels'])} kernels")
            return 0
        record = json.loads(options.record.read_text())
    except (CountError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 2
    verdict, report = compare(counts, record, limit=options.limit, partial=options.only is not None)
    print("\n".join(report))
    if options.report:
        options.report.write_text("\n".join(report) + "\n")
    return verdict


if __name__ == "__main__":
    sys.exit(main())
