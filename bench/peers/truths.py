"""Solutions that runs are compared with, never made by the program that is measured alone (README.md)."""
import dataclasses
import hashlib
import json
import pathlib
import tempfile

import problems

GOOD_ENOUGH = 1e-9  # m: a solution known so well needs no other


@dataclasses.dataclass
class Truths:
    """Tabulated or exact solution and the tightest runs of the programs, cached in a folder."""
    programs: list
    folder: pathlib.Path
    limit: float
    cross: bool = True
    say: object = print

    def of(self, problem, model):
        """{program: Truth}: for each the best known solution that is not its own; None where there is none."""
        known = problems.known_truth(problem)
        runs = {}
        if self.cross and (known is None or known.known > GOOD_ENOUGH):
            runs = {p.name: run for p in self.programs if p.present and (run := self.reference(p, problem, model))}
        if known and runs:
            for name, run in runs.items():
                self.say(f"  {problem.name}: reference run of {name} differs by "
                         f"{problems.error(problem, run, known.columns):.1e} m from {known.source}")
        difference = largest_difference(problem, list(runs.values()))
        if difference is not None:
            self.say(f"  {problem.name}: reference runs of {' and '.join(runs)} differ by {difference:.1e} m")
        return {p.name: best(p.name, known, runs, difference) for p in self.programs}

    def reference(self, program, problem, model):
        """Columns of the program's tightest run that got to its end, or None."""
        key = hashlib.sha256(model.read_bytes() + repr(problem).encode()).hexdigest()[:12]
        for method, tolerance in program.references(problem.mechanism):
            file = self.folder / f"{problem.name}-{program.name}-{method['method']}-{tolerance:g}-{key}.json"
            if file.exists():
                return json.loads(file.read_text())
            with tempfile.TemporaryDirectory() as out:  # several sessions may share the folder
                run = program.run(problem, model, method, tolerance, pathlib.Path(out) / "run", self.limit)
            name = f"  {problem.name}: reference run of {program.name} {method['method']} {tolerance:g}"
            if run.status == "ok":
                self.say(f"{name} took {run.figures['cpu_s']:.3g} s")
                file.write_text(json.dumps(run.columns))
                return run.columns
            self.say(f"{name}: {run.status} {run.message}")
        return None


def largest_difference(problem, runs):
    pairs = [(a, b) for i, a in enumerate(runs) for b in runs[:i]]
    return max((problems.error(problem, a, b) for a, b in pairs), default=None)


def best(name, known, runs, difference):
    """The run of another program, trusted as far as the runs agree, or what is known, whichever is better."""
    other = next((other for other in runs if other != name), None)
    if difference is None or other is None or (known and known.known <= difference):
        return known
    return problems.Truth(runs[other], difference, f"run of {other}")
