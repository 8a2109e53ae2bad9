"""Programs of programs.json and their runs."""
import dataclasses
import json
import os
import pathlib
import shutil
import subprocess
import sys
import time

import problems

ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS")}
FAILED, LIMIT, ASTRAY = "failed", "limit", "astray"  # status besides ok
FIGURES = ("cpu_s", "steps", "evaluations", "factorisations")
KEYS = {"name", "executable", "command", "results", "report", "figures", "tolerances", "methods", "reference"}
METHOD_KEYS = {"method", "formulation", "arguments", "tolerances", "mechanisms"}


class ConfigError(Exception):
    pass


@dataclasses.dataclass
class Run:
    status: str
    figures: dict  # of FIGURES, what the program tells
    columns: dict  # channel -> values at the problem's times; empty where it did not get so far
    message: str = ""


class Program:
    def __init__(self, entry, folders, executable=None):
        unknown = set(entry) - KEYS
        for method in entry.get("methods", []):
            unknown |= set(method) - METHOD_KEYS
        missing = {"name", "command", "figures", "methods", "tolerances"} - set(entry)
        if unknown or missing:
            raise ConfigError(f"program {entry.get('name', '?')}: " +
                              "; ".join([f"unknown key {k}" for k in sorted(unknown)] +
                                        [f"missing key {k}" for k in sorted(missing)]))
        self.entry, self.name, self.methods = entry, entry["name"], entry["methods"]
        self.folders = folders
        self.executable = str(executable or fill(entry.get("executable", ""), folders, self.name))

    @property
    def present(self):
        return not self.executable or shutil.which(self.executable) is not None

    def tolerances(self, mechanism, method):
        return pick(method.get("tolerances", self.entry["tolerances"]), mechanism)

    def references(self, mechanism):
        """Method and tolerances of its most exact run, the first that gets to its end counts."""
        reference = self.entry.get("reference")
        if not reference:
            return []
        method = {key: value for key, value in reference.items() if key != "tolerances"}
        return [(method, tolerance) for tolerance in pick(reference["tolerances"], mechanism)]

    def command(self, problem, model, method, tolerance, out):
        values = self.folders | {
            "executable": self.executable, "model": str(model), "mechanism": problem.mechanism,
            "size": str(problem.size), "end": repr(problem.end), "every": repr(problem.every),
            "channels": ",".join(problem.channels), "method": method["method"],
            "formulation": method.get("formulation", ""), "tolerance": repr(tolerance), "out": str(out)}
        return [fill(word, values, self.name) for word in self.entry["command"] + method.get("arguments", [])]

    def run(self, problem, model, method, tolerance, out, limit=None):
        """One run in an empty folder, at most `limit` seconds of CPU time."""
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        command = self.command(problem, model, method, tolerance, out)
        try:
            code, message = watched(command, out / "stderr.txt", limit)
        except OSError as error:
            raise ConfigError(f"{self.name}: {command[0]}: {error.strerror}") from error
        if code is None:
            return Run(LIMIT, {}, {}, f"more than {limit:g} s")
        if code == 2:  # the model or the command line is refused: an error of the configuration
            raise ConfigError(f"{self.name}: {' '.join(command)}\n{message}")
        try:
            report = json.loads((out / self.entry.get("report", "report.json")).read_text())
            columns = problems.read_table(out / self.entry.get("results", "results.csv"))
            figures = self.figures(report)
        except (OSError, ValueError, IndexError) as error:
            return Run(FAILED, {}, {}, f"{message or 'no results'} ({error})")
        if code != 0:
            return Run(FAILED, figures, {}, message)
        return Run("ok", figures, at_times(problem, columns, self.name))

    def figures(self, report):
        """Every figure is the sum of the named numbers of the report."""
        found = {}
        for figure, names in self.entry["figures"].items():
            if figure not in FIGURES:
                raise ConfigError(f"{self.name}: unknown figure {figure}; allowed: {', '.join(FIGURES)}")
            values = [lookup(report, name) for name in ([names] if isinstance(names, str) else names)]
            if None not in values:
                found[figure] = sum(values)
        if "cpu_s" not in found:
            raise ConfigError(f"{self.name}: its report tells no CPU time ({self.entry['figures'].get('cpu_s')})")
        return found


def watched(command, log, limit):
    """(exit status, what it printed as errors); status None: killed after `limit` seconds of CPU time. Its clock is only
    read: a limit of the kernel would coarsen it to whole ticks of some ms."""
    with open(log, "wb") as errors:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors, env=os.environ | ONE_THREAD)
    clock = (~process.pid << 3) | 2  # clock_getcpuclockid(3) of Linux
    while True:
        try:
            return process.wait(timeout=0.5), log.read_text(errors="replace").strip()
        except subprocess.TimeoutExpired:
            if limit and time.clock_gettime(clock) > limit:
                process.kill()
                process.wait()
                return None, ""
        except BaseException:
            process.kill()
            raise


def at_times(problem, columns, name):
    """The rows at the problem's times, of a table that may have more."""
    try:
        rows = [problems.nearest(columns["t"], time) for time in problem.times]
        return {channel: [columns[channel][row] for row in rows] for channel in problem.channels}
    except (KeyError, ValueError) as error:
        raise ConfigError(f"{name}: its results have no column or row {error}") from error


def lookup(report, name):
    """Number by name, members of members divided by dots."""
    for part in name.split("."):
        if not isinstance(report, dict) or part not in report:
            return None
        report = report[part]
    return report


def pick(by_mechanism, mechanism):
    return by_mechanism.get(mechanism, by_mechanism.get("*", []))


def fill(text, values, name):
    try:
        return text.format_map(values)
    except (KeyError, ValueError, IndexError) as error:
        raise ConfigError(f"program {name}: placeholder {error} in \"{text}\" is not known") from error


def load_programs(path, build, executables=None):
    """Programs of a configuration; executables: paths by name that replace those of the file."""
    folders = {"build": str(build), "here": str(pathlib.Path(path).resolve().parent), "python": sys.executable}
    try:
        entries = json.loads(pathlib.Path(path).read_text())["programs"]
    except (OSError, ValueError, KeyError) as error:
        raise ConfigError(f"{path}: {error}") from error
    return [Program(entry, folders, (executables or {}).get(entry.get("name"))) for entry in entries]
