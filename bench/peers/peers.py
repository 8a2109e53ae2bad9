#!/usr/bin/env python3
"""Times other programs beside Gudgeon on the same models, in the same run: error against CPU time, one thread.

    bench/peers/peers.py --gudgeon build/release/bin/gudgeon --out results/peers
    bench/peers/peers.py --gudgeon ... --out /tmp/quick --quick               # seconds: does everything work?
    bench/peers/peers.py --gudgeon ... --out ... --programs my_programs.json  # any other program (README.md)

--out gets peers.csv (one line per setting, the median of its runs), equal_error.csv and peers.txt. Exit status: 0;
1 where a quick run did not reach 1e-3 m; 2 usage, configuration, or a program that refuses the model.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys

import problems
import runners
import tables
import truths

HERE = pathlib.Path(__file__).resolve().parent
QUICK = {"sizes": {"chain": (4,), "four-bar": (1,), "suspension-chain": (1,)}, "tolerances": (1e-3, 1e-6),
         "methods": 2, "targets": (1e-3,)}


class Setting:
    """A program, method and tolerance on one problem, and its runs."""

    def __init__(self, program, method, tolerance, problem):
        self.program, self.method, self.tolerance, self.problem = program, method, tolerance, problem
        self.seconds, self.last, self.status = [], None, None

    @property
    def key(self):
        """What is skipped together once it takes too long."""
        return (self.program.name, self.problem.mechanism, self.method["method"], self.method.get("formulation"))

    def wants(self, repeats, budget):
        """Another run: short ones are repeated, long ones as far as the budget goes."""
        if self.status or len(self.seconds) >= repeats:
            return False
        return not self.seconds or sum(self.seconds) * (1 + 1 / len(self.seconds)) <= budget

    def take(self, model, out, limit):
        run = self.program.run(self.problem, model, self.method, self.tolerance, out, limit)
        if self.last is None or run.status == "ok":
            self.last = run
        if run.status == "ok":
            self.seconds.append(run.figures["cpu_s"])
        else:
            self.status = run.status
        return run

    def point(self, truth):
        point = tables.Point(self.program.name, self.problem.mechanism, self.problem.size, self.method["method"],
                             self.method.get("formulation", ""), self.tolerance, self.status or "ok", floor=truth.floor)
        if self.last is not None:
            for figure in runners.FIGURES:
                setattr(point, figure, self.last.figures.get(figure))
        if self.seconds:
            point.cpu_s = statistics.median(self.seconds)
        if point.status == "ok":
            error = problems.error(self.problem, self.last.columns, truth.columns)
            point.error = error if error >= truth.floor else None
            point.status = "below-floor" if error < truth.floor else runners.ASTRAY if not error < 1 else "ok"
        return point


class Session:
    def __init__(self, options, programs):
        self.options, self.programs = options, [p for p in programs if p.present]
        self.out = options.out.resolve()
        references = (options.references or self.out / "references").resolve()
        for folder in (self.out / "models", references):
            folder.mkdir(parents=True, exist_ok=True)
        self.truths = truths.Truths(self.programs, references, options.reference_limit, not options.quick, say)
        self.stated = json.loads((HERE / "stated.json").read_text())
        self.points, self.blocked, self.spent = [], {}, {}
        self.machine = [machine(), f"load {os.getloadavg()[0]:.1f} when it began"]
        for program in programs:
            if not program.present:
                say(f"{program.name} is left out: there is no {program.executable}")

    def model(self, problem):
        """The ready mechanism as a model file."""
        file = self.out / "models" / f"{problem.name}.json"
        words = [word for name, value in problem.parameters for word in ("--param", f"{name}={value}")]
        done = subprocess.run([self.options.gudgeon, "export", problem.mechanism, *words], capture_output=True,
                              text=True, check=False)
        if done.returncode:
            raise runners.ConfigError(f"{self.options.gudgeon} export: {done.stderr.strip()}")
        file.write_text(done.stdout)
        return file

    def settings(self, problem, truth):
        made = []
        for program in self.programs:
            if truth[program.name] is None:
                say(f"  {problem.name}: {program.name} is left out: there is no solution to compare it with")
                continue
            methods = [m for m in program.methods if problem.mechanism in m.get("mechanisms", [problem.mechanism])
                       and self.options.methods.get(program.name, m["method"]) == m["method"]]
            for method in methods[:QUICK["methods"] if self.options.quick else None]:
                for tolerance in program.tolerances(problem.mechanism, method):
                    if not self.options.quick or tolerance in QUICK["tolerances"]:
                        made.append(Setting(program, method, tolerance, problem))
        return sorted(made, key=lambda s: -s.tolerance)

    def too_long(self, setting):
        """Where a smaller size or a looser tolerance took too long, or the next smaller one says it will."""
        if setting.tolerance <= self.blocked.get(setting.key, 0):
            return True
        size, seconds = self.spent.get((setting.key, setting.tolerance), (setting.problem.size, 0))
        return seconds * setting.problem.size / size > self.options.limit

    def block(self, setting, status):
        setting.status = status
        self.blocked[setting.key] = max(setting.tolerance, self.blocked.get(setting.key, 0))

    def measure(self, problem):
        say(problem.name)
        model = self.model(problem)
        truth = self.truths.of(problem, model)
        settings = self.settings(problem, truth)
        for repeat in range(self.options.repeats):
            for setting in settings:
                if repeat == 0 and self.too_long(setting):
                    self.block(setting, "skipped")
                if not setting.wants(self.options.repeats, self.options.budget):
                    continue
                run = setting.take(model, self.out / "run", self.options.limit)
                if run.status == runners.LIMIT:
                    self.block(setting, run.status)
        for setting in settings:
            point = setting.point(truth[setting.program.name])
            if point.cpu_s:
                self.spent[setting.key, setting.tolerance] = problem.size, point.cpu_s
            self.points.append(point)
            if setting.status == runners.FAILED:
                message = " ".join(setting.last.message.split()) or "failed"
                say(f"  {setting.program.name} {setting.method['method']} {setting.tolerance:g}: {message[:300]}")

    def write(self):
        tables.write_points(self.points, self.out / "peers.csv")
        lines = tables.equal_error(self.points, self.stated)
        tables.write_equal_error(lines, self.out / "equal_error.csv")
        text = "\n".join(self.machine + [f"load {os.getloadavg()[0]:.1f} at the end", ""])
        text += tables.report(lines, self.stated) if lines else "nothing measured"
        (self.out / "peers.txt").write_text(text + "\n")
        return lines, text


def unreached(session, lines):
    """Quick runs: problems where a program was measured and reached one of the errors by no method."""
    wanted = {(p.program, p.mechanism, p.size, target) for p in session.points for target in QUICK["targets"]}
    return wanted - {(x["program"], x["mechanism"], x["size"], x["error"]) for x in lines}


def machine():
    """Processors of this machine; figures of another one cannot be compared but as ratios."""
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return f"{names[0] if names else 'unknown processor'}, {os.cpu_count()} threads"


def say(text):
    print(text, flush=True)


def sizes_of(options):
    """{mechanism: sizes} as asked: chain, chain=4,16."""
    chosen = {}
    for item in options.mechanisms or list(problems.MECHANISMS):
        name, _, sizes = item.partition("=")
        if name not in problems.MECHANISMS:
            raise runners.ConfigError(f"no mechanism {name}; there are {', '.join(problems.MECHANISMS)}")
        chosen[name] = [int(size) for size in sizes.split(",")] if sizes else problems.MECHANISMS[name][1]
        if options.quick and not sizes:
            chosen[name] = QUICK["sizes"][name]
    return chosen


def pairs(items, what):
    for item in items:
        if "=" not in item:
            raise runners.ConfigError(f"{what} {item}: NAME=VALUE is meant")
    return dict(item.split("=", 1) for item in items)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gudgeon", required=True, help="the command, which also exports the models")
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--programs", type=pathlib.Path, action="append", help="configuration, may be repeated "
                        "(programs.json)")
    parser.add_argument("--executable", action="append", default=[], metavar="NAME=PATH", help="of another program")
    parser.add_argument("--methods", action="append", default=[], metavar="NAME=METHOD", help="only this one of a program")
    parser.add_argument("--mechanisms", nargs="+", metavar="NAME[=SIZES]", help="chain, four-bar, suspension-chain=1,4")
    parser.add_argument("--repeats", type=int, default=5, help="runs of every setting (%(default)s)")
    parser.add_argument("--budget", type=float, default=20, help="CPU seconds for the repeats of one setting (%(default)s)")
    parser.add_argument("--limit", type=float, default=120, help="CPU seconds of one run (%(default)s)")
    parser.add_argument("--reference-limit", type=float, default=3600, help="the same for the reference runs")
    parser.add_argument("--references", type=pathlib.Path, help="folder where they are kept (OUT/references)")
    parser.add_argument("--quick", action="store_true", help="least sizes, one run of few settings, no reference runs")
    options = parser.parse_args()
    if options.quick:
        options.repeats = 1
    return options


def main():
    options = arguments()
    try:
        options.methods = pairs(options.methods, "--methods")
        executables = pairs(options.executable, "--executable") | {tables.OWN: options.gudgeon}
        build = pathlib.Path(options.gudgeon).resolve().parent
        programs = [program for path in options.programs or [HERE / "programs.json"]
                    for program in runners.load_programs(path, build, executables)]
        sizes = sizes_of(options)
        session = Session(options, programs)
        lines, text = [], ""
        for mechanism, chosen in sizes.items():
            for size in chosen:
                session.measure(problems.MECHANISMS[mechanism][0](size))
                lines, text = session.write()
    except (runners.ConfigError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    say("\n" + text)
    missed = unreached(session, lines) if options.quick else ()
    for program, mechanism, size, error in sorted(missed):
        print(f"{program} did not reach an error of {error:g} m: {mechanism} {size}", file=sys.stderr)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
