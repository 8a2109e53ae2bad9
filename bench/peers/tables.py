"""From runs to tables: time at equal error, ratios, the check against stated times."""
import csv
import dataclasses
import math
from typing import Optional

COLUMNS = ("program", "mechanism", "size", "method", "formulation", "tolerance", "status", "error", "cpu_s", "steps",
           "evaluations", "factorisations")
EQUAL_COLUMNS = ("mechanism", "size", "error", "program", "method", "formulation", "cpu_s", "best", "over_gudgeon",
                 "stated_cpu_s", "over_stated")
TARGETS = (1e-3, 1e-5, 1e-7, 1e-8)
OWN = "gudgeon"


@dataclasses.dataclass
class Point:
    """A setting and the median of its runs. error: None where it was not measured, or lies below the floor."""
    program: str
    mechanism: str
    size: int
    method: str
    formulation: str
    tolerance: float
    status: str
    error: Optional[float] = None
    cpu_s: Optional[float] = None
    steps: Optional[float] = None
    evaluations: Optional[float] = None
    factorisations: Optional[float] = None
    floor: float = 0.0  # least error that may be stated

    @property
    def curve(self):
        return self.program, self.mechanism, self.size, self.method, self.formulation


def cell(value):
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def write_points(points, path):
    with open(path, "w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(COLUMNS)
        for point in points:
            writer.writerow([cell(getattr(point, column)) for column in COLUMNS])


def seconds_at(points, target):
    """CPU time of one curve at an error, interpolated between the logarithms of neighbouring tolerances: from the
    tightest run that is exact enough to the next looser one that is not. None where no run is; where every looser run
    is exact enough too, the time of the loosest."""
    tighter = None
    for point in sorted(points, key=lambda p: p.tolerance):
        if point.cpu_s is None or point.status not in ("ok", "below-floor", "astray"):
            continue
        if target < point.floor:
            return None
        error = point.floor if point.error is None else point.error
        if error <= target:
            tighter = error, point.cpu_s
        elif tighter:
            share = math.log(target / tighter[0]) / math.log(error / tighter[0]) if 0 < tighter[0] < target else 0
            return tighter[1] * (point.cpu_s / tighter[1]) ** share
    return tighter and tighter[1]


def equal_error(points, stated, targets=TARGETS):
    """One line (dict of EQUAL_COLUMNS) for every curve and error it reaches; the best of a program is marked."""
    curves = {}
    for point in points:
        curves.setdefault(point.curve, []).append(point)
    lines = []
    cases = dict.fromkeys((p.mechanism, p.size) for p in points)
    for mechanism, size in cases:
        for target in with_stated(targets, stated, mechanism):
            here = []
            for (program, m, n, method, formulation), curve in curves.items():
                if (m, n) == (mechanism, size) and (seconds := seconds_at(curve, target)):
                    here.append(dict(mechanism=m, size=n, error=target, program=program, method=method,
                                     formulation=formulation, cpu_s=seconds, best="", over_gudgeon=None))
            lines += marked(here, stated)
    return lines


def with_stated(targets, stated, mechanism):
    """The errors at which something is stated belong to the table."""
    extra = {row["error"] for row in stated["rows"] if row["mechanism"] == mechanism}
    return sorted(extra | set(targets), reverse=True)


def marked(lines, stated):
    """Best method of every program, its time over that of Gudgeon's best; times over the stated ones."""
    best = {}
    for line in lines:
        if line["program"] not in best or line["cpu_s"] < best[line["program"]]["cpu_s"]:
            best[line["program"]] = line
    own = best.get(OWN)
    for line in best.values():
        line["best"] = "best"
    for line in lines:
        if own and line is not own:
            line["over_gudgeon"] = line["cpu_s"] / own["cpu_s"]
    for row in stated["rows"]:
        compare_with_stated(lines, row)
    return lines


def compare_with_stated(lines, row):
    """The fastest line of the row's program, of its method and formulation where the row names them."""
    fits = [line for line in lines if line["size"] in row["sizes"] and all(
        line[key] == row[key] for key in ("program", "mechanism", "error", "method", "formulation") if key in row)]
    if fits:
        line = min(fits, key=lambda x: x["cpu_s"])
        line["stated_cpu_s"] = row["cpu_s"][row["sizes"].index(line["size"])]
        line["over_stated"] = line["cpu_s"] / line["stated_cpu_s"]


def reproduced(line, factor):
    """None where nothing is stated."""
    ratio = line.get("over_stated")
    return None if ratio is None else 1 / factor <= ratio <= factor


def write_equal_error(lines, path):
    with open(path, "w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(EQUAL_COLUMNS)
        for line in lines:
            writer.writerow([cell(line.get(column)) for column in EQUAL_COLUMNS])


def figure(value):
    return "-" if value is None else f"{value:.3g}"


def report(lines, stated):
    """Readable table: the best of every program at equal error, with the check of what is stated."""
    factor = stated["factor"]
    names = sorted({line["program"] for line in lines}, key=lambda name: (name != OWN, name))
    others = [name for name in names if name != OWN]
    header = ["mechanism", "size", "error"]
    for name in names:
        header += [f"{name} s", "method"]
    header += [f"{name}/{OWN}" for name in others] + ["fastest stated s", "by", f"stated/{OWN}", "check"]
    rows = [header]
    for mechanism, size, error in dict.fromkeys((x["mechanism"], x["size"], x["error"]) for x in lines):
        here = [x for x in lines if (x["mechanism"], x["size"], x["error"]) == (mechanism, size, error)]
        best = {x["program"]: x for x in here if x["best"]}
        checked = {x["program"]: x for x in here if x.get("over_stated")}
        row = [mechanism, str(size), f"{error:g}"]
        for name in names:
            row += [figure(best[name]["cpu_s"]), best[name]["method"]] if name in best else ["-", "-"]
        row += [ratio_cell(best.get(name), checked.get(name), factor) for name in others]
        seconds, program = fastest_stated(stated, mechanism, size, error)
        own = best.get(OWN)
        row += [figure(seconds), program or "-", figure(seconds / own["cpu_s"] if seconds and own else None)]
        row.append("; ".join(check_cell(line, factor) for line in checked.values()) or "-")
        rows.append(row)
    widths = [max(len(row[i]) for row in rows) for i in range(len(header))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(row, widths)).rstrip() for row in rows)


def ratio_cell(best, checked, factor):
    """No ratio to a program that needs longer here than stated."""
    if best is None or best["over_gudgeon"] is None:
        return "-"
    if checked and checked["over_stated"] > factor:
        return "not stated"
    return figure(best["over_gudgeon"])


def check_cell(line, factor):
    ratio = line["over_stated"]
    verdict = "reproduced" if reproduced(line, factor) else "faster than stated" if ratio < 1 else "NOT reproduced"
    kind = f" ({line['formulation']})" if line["best"] == "" else ""
    return f"{line['program']}{kind} {ratio:.2f} of stated: {verdict}"


def fastest_stated(stated, mechanism, size, error):
    found = [(row["cpu_s"][row["sizes"].index(size)], row["program"]) for row in stated["rows"]
             if row["mechanism"] == mechanism and row["error"] == error and size in row["sizes"]]
    return min(found) if found else (None, None)
