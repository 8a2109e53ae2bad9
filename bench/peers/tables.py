"""From runs to tables: time at equal error, ratios, the check against stated times."""
import csv
import dataclasses
import math

COLUMNS = ("program", "mechanism", "size", "method", "formulation", "tolerance", "status", "error", "cpu_s", "steps",
           "evaluations", "factorisations")
EQUAL_COLUMNS = ("mechanism", "size", "error", "program", "method", "formulation", "cpu_s", "best", "over_gudgeon",
                 "stated_cpu_s", "over_stated")
TARGETS = (1e-3, 1e-5, 1e-7)
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
    error: float | None = None
    cpu_s: float | None = None
    steps: float | None = None
    evaluations: float | None = None
    factorisations: float | None = None
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
    """CPU time of one curve at an error, interpolated between the logarithms of neighbouring tolerances. None where no
    run is that exact; where all are, the time of the loosest."""
    tighter = None
    for point in sorted(points, key=lambda p: p.tolerance):
        if point.cpu_s is None or point.status not in ("ok", "below-floor", "astray"):
            continue
        if target < point.floor:
            return None
        error = point.floor if point.error is None else point.error
        if error > target:
            if tighter is None:
                return None
            if tighter[0] <= 0:
                return tighter[1]
            share = math.log(target / tighter[0]) / math.log(error / tighter[0])
            return tighter[1] * (point.cpu_s / tighter[1]) ** share
        tighter = error, point.cpu_s
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
    """Best method of every program, its time over that of Gudgeon's best and over the stated one."""
    best = {}
    for line in lines:
        if line["program"] not in best or line["cpu_s"] < best[line["program"]]["cpu_s"]:
            best[line["program"]] = line
    for line in best.values():
        line["best"] = "best"
        line["stated_cpu_s"] = stated_seconds(stated, line)
        if line["stated_cpu_s"]:
            line["over_stated"] = line["cpu_s"] / line["stated_cpu_s"]
    own = best.get(OWN)
    for line in lines:
        if own and line is not own:
            line["over_gudgeon"] = line["cpu_s"] / own["cpu_s"]
    return lines


def stated_seconds(stated, line):
    for row in stated["rows"]:
        if (row["program"], row["mechanism"], row["error"]) == (line["program"], line["mechanism"], line["error"]):
            if line["size"] in row["sizes"]:
                return row["cpu_s"][row["sizes"].index(line["size"])]
    return None


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
    names = list(dict.fromkeys(line["program"] for line in lines))
    others = [name for name in names if name != OWN]
    header = ["mechanism", "size", "error"]
    for name in names:
        header += [f"{name} s", "method"]
    header += [f"{name}/{OWN}" for name in others] + ["fastest stated s", "by", f"stated/{OWN}", "check"]
    rows = [header]
    for mechanism, size, error in dict.fromkeys((x["mechanism"], x["size"], x["error"]) for x in lines):
        best = {x["program"]: x for x in lines
                if (x["mechanism"], x["size"], x["error"]) == (mechanism, size, error) and x["best"]}
        row = [mechanism, str(size), f"{error:g}"]
        for name in names:
            row += [figure(best[name]["cpu_s"]), best[name]["method"]] if name in best else ["-", "-"]
        row += [ratio_cell(best.get(name), factor) for name in others]
        seconds, program = fastest_stated(stated, mechanism, size, error)
        own = best.get(OWN)
        row += [figure(seconds), program or "-", figure(seconds / own["cpu_s"] if seconds and own else None)]
        row.append("; ".join(check_cell(best[name], factor) for name in others if name in best
                             and "over_stated" in best[name]) or "-")
        rows.append(row)
    widths = [max(len(row[i]) for row in rows) for i in range(len(header))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(row, widths)).rstrip() for row in rows)


def ratio_cell(line, factor):
    """No ratio to a program whose stated time is not reproduced, unless it was faster here than stated."""
    if line is None or line["over_gudgeon"] is None:
        return "-"
    if line.get("over_stated", 0) > factor:
        return "not stated"
    return figure(line["over_gudgeon"])


def check_cell(line, factor):
    ratio = line["over_stated"]
    verdict = "reproduced" if reproduced(line, factor) else "FASTER than stated" if ratio < 1 else "NOT reproduced"
    return f"{line['program']} {ratio:.2f} of stated: {verdict}"


def fastest_stated(stated, mechanism, size, error):
    found = [(row["cpu_s"][row["sizes"].index(size)], row["program"]) for row in stated["rows"]
             if row["mechanism"] == mechanism and row["error"] == error and size in row["sizes"]]
    return min(found) if found else (None, None)
