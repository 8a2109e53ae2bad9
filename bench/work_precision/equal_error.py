"""Tables of runs, and what runs of a given error cost: interpolation between neighbouring tolerances."""
import collections
import csv
import math

# The columns that tables of every program have; any more may follow.
COLUMNS = ("program,mechanism,size,method,formulation,tolerance,status,error,cpu_s,steps,evaluations,"
           "factorisations").split(",")
NUMBERS = {"size", "tolerance", "error", "cpu_s", "steps", "evaluations", "factorisations", "refactorisations", "sweeps",
           "rejected_error", "rejected_newton", "rejected_contact", "cpu_median_s", "repeats", "setup_s", "bodies",
           "unknowns", "reference_believed"}
ERRORS = (1e-3, 1e-5, 1e-7)
CERTAIN = 10  # errors below so many uncertainties of the reference are not stated

Curve = collections.namedtuple("Curve", "program method formulation")
Cost = collections.namedtuple("Cost", "seconds at_most")  # at_most: even the loosest run is better than the error


def read_runs(path):
    """Rows of a table as dictionaries; numbers are numbers, None where a cell is empty or no finite number."""
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.DictReader(line for line in file if not line.startswith("#"))
        missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
        if missing:
            raise ValueError(f"{path}: no column {', '.join(missing)}")
        return [{name: number(value) if name in NUMBERS else value for name, value in row.items()} for row in reader]


def number(text):
    try:
        value = float(text)
    except (TypeError, ValueError):
        return None
    if not math.isfinite(value):
        return None
    return int(value) if value.is_integer() and abs(value) < 1e15 and "." not in text and "e" not in text else value


def problems_of(runs):
    """(mechanism, size) in the order of the table."""
    return list(dict.fromkeys((run["mechanism"], run["size"]) for run in runs))


def curve_of(run):
    return Curve(run["program"], run["method"], run["formulation"] or "")


def curves_of(runs):
    """{curve: its runs, the loosest first}"""
    curves = collections.defaultdict(list)
    for run in runs:
        curves[curve_of(run)].append(run)
    for rows in curves.values():
        rows.sort(key=lambda run: -(run["tolerance"] or 0))
    return dict(curves)


def points_of(rows):
    """(error, seconds) of the runs that count. Where the error is below the reference's digits, it is taken as the
    largest that it can be, so that no time is stated that is too good."""
    points = []
    for run in rows:
        if not run["cpu_s"]:
            continue
        if run["status"] == "ok" and run["error"]:
            points.append((run["error"], run["cpu_s"]))
        elif run["status"] == "below-reference" and run.get("reference_believed"):
            points.append((CERTAIN * run["reference_believed"], run["cpu_s"]))
    return points


def cost_at(points, error):
    """What a run of this error costs, between the logarithms of the tightest two neighbours that embrace it. All
    below it: the cost of the loosest; the tightest above it: None. points: the loosest first."""
    tighter = None
    for point in reversed(points):
        if point[0] > error:
            if tighter is None:
                return None
            share = math.log(error / tighter[0]) / math.log(point[0] / tighter[0])
            return Cost(tighter[1] * (point[1] / tighter[1]) ** share, False)
        tighter = point
    return Cost(tighter[1], True) if tighter else None


def costs(runs, error):
    """{curve: Cost} of one problem's runs; curves that do not reach the error are left out."""
    found = {curve: cost_at(points_of(rows), error) for curve, rows in curves_of(runs).items()}
    return {curve: cost for curve, cost in found.items() if cost}


def write_table(runs, path, errors=ERRORS):
    """equal_error.csv: every problem, error and curve with its time over the best."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow("mechanism size error program method formulation cpu_s at_most over_best".split())
        for problem in problems_of(runs):
            of_problem = [run for run in runs if (run["mechanism"], run["size"]) == problem]
            for error in errors:
                table = costs(of_problem, error)
                best = min((cost.seconds for cost in table.values()), default=None)
                for curve, cost in table.items():
                    writer.writerow([*problem, f"{error:g}", *curve, f"{cost.seconds:.4g}", int(cost.at_most),
                                     f"{cost.seconds / best:.3g}"])
