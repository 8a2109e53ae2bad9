#!/usr/bin/env python3
"""Makes one page of the runs of gudgeon_work_precision, and of other programs' where they are given.

    page.py results/work_precision                    # reads work_precision.csv and .json, peers.csv where present
    page.py results/work_precision --peers simbody.csv --out page.html

Writes index.html (one file that needs nothing else) and equal_error.csv into the folder. Standard library only.
"""
import argparse
import html
import json
import math
import pathlib
import sys

import equal_error

TEMPLATE = pathlib.Path(__file__).with_name("page.html")
GROUPS = (("Rigid joints", ("pendulum", "chain", "four-bar", "slider-crank", "heavy-top", "triple-pendulum free")),
          ("Springs and bushings", ("suspension-chain", "suspension-chain perfect", "hmmwv-corner",
                                    "hmmwv-corner perfect")))
REST = "Clearance, stops and friction"
OWN = "gudgeon"
SIZES = {"chain": "link", "four-bar": "loop", "suspension-chain": "unit"}
# what a reader of the page may weigh instead of time
WORK = {"cpu_s": "CPU time (s)", "sweeps": "Newton sweeps", "evaluations": "evaluations of the forces",
        "lu": "factorisations", "steps": "steps"}
STATUS = {"lost": "error above 1 m", "not-run": "too long", "refused": "no start",
          "below-reference": "closer than the reference is certain"}


def group_of(mechanism):
    return next((group for group, members in GROUPS if mechanism in members), REST)


def title_of(mechanism, size, sized):
    if not sized:
        return mechanism
    unit = SIZES.get(mechanism.split()[0], "")
    return f"{mechanism}, {size:g} {unit}{'' if size == 1 or not unit else 's'}".rstrip()


SHORT = {"saddle-point": "", "auto": "", "augmented-lagrangian": "augmented"}
VARIANTS = ("saddle-point-klu", "augmented-lagrangian")


def columns_of(runs):
    """Columns of the summary: each curve of our own, and for every other program the best of its curves."""
    own = list(dict.fromkeys(c for c in map(equal_error.curve_of, runs) if c.program == OWN))
    own.sort(key=lambda c: c.formulation in VARIANTS)  # the variants last
    others = list(dict.fromkeys(run["program"] for run in runs if run["program"] != OWN))
    return own, others


def name_of(curve):
    short = SHORT.get(curve.formulation, curve.formulation)
    name = f"{curve.method}, {short}" if short else curve.method
    return name if curve.program == OWN else f"{curve.program} {name}"


def seconds(value):
    """Three digits with a unit a person reads."""
    for limit, factor, unit in ((1e-3, 1e6, "µs"), (1, 1e3, "ms"), (math.inf, 1, "s")):
        if value < limit * 0.9995:
            scaled = float(f"{value * factor:.3g}")
            return f"{scaled:.{max(0, 2 - math.floor(math.log10(scaled)))}f} {unit}"
    return ""


def summary(runs, error):
    """HTML table of one error: a row per problem, the best marked."""
    own, others = columns_of(runs)
    head = "".join(f'<th scope="col">{html.escape(name_of(c))}</th>' for c in own)
    head += "".join(f'<th scope="col">{html.escape(p)}</th>' for p in others)
    body, ratios = [], {c: [] for c in [*own, *others]}
    group = None
    for problem in equal_error.problems_of(runs):
        of_problem = [run for run in runs if (run["mechanism"], run["size"]) == problem]
        costs = equal_error.costs(of_problem, error)
        row = {c: (costs.get(c), "") for c in own}
        for program in others:
            mine = {c: cost for c, cost in costs.items() if c.program == program}
            best = min(mine, key=lambda c: mine[c].seconds) if mine else None
            row[program] = (mine.get(best), best.method if best else "")
        if group_of(problem[0]) != group:
            group = group_of(problem[0])
            body.append(f'<tr class="group"><th colspan="{len(row) + 1}" scope="rowgroup">{group}</th></tr>')
        body.append(summary_row(problem, runs, row, ratios))
    body.append(mean_row(ratios))
    return (f'<table><thead><tr><th scope="col">mechanism</th>{head}</tr></thead>'
            f'<tbody>{"".join(body)}</tbody></table>')


def summary_row(problem, runs, row, ratios):
    times = [cost.seconds for cost, _ in row.values() if cost]
    best = min(times, default=None)
    cells = []
    for column, (cost, by) in row.items():
        if not cost:
            cells.append('<td class="none">–</td>')
            continue
        ratio = cost.seconds / best
        ratios[column].append(ratio)
        mark = ' class="best"' if ratio == 1 else ""
        note = "best" if ratio == 1 else f"{ratio:.1f}×" if ratio < 9.95 else f"{ratio:.0f}×"
        by = f"<i>{html.escape(by)}</i>" if by else ""
        cells.append(f'<td{mark}>{"≤ " if cost.at_most else ""}{seconds(cost.seconds)}<small>{note}{by}</small></td>')
    anchor = anchor_of(*problem)
    title = html.escape(title_of(*problem, is_sized(problem, runs)))
    return f'<tr><th scope="row"><a href="#{anchor}">{title}</a></th>{"".join(cells)}</tr>'


def mean_row(ratios):
    cells = []
    for values in ratios.values():
        mean = math.exp(sum(map(math.log, values)) / len(values)) if values else None
        cells.append(f"<td>{mean:.1f}×<small>{len(values)} rows</small></td>" if values else '<td class="none">–</td>')
    return f'<tr class="mean"><th scope="row">over the best, geometric mean</th>{"".join(cells)}</tr>'


def anchor_of(mechanism, size):
    return f"{mechanism.replace(' ', '-')}-{size:g}"


def is_sized(problem, runs):
    sizes = {run["size"] for run in runs if run["mechanism"] == problem[0]}
    return len(sizes) > 1


def chart_data(runs, described):
    """What the charts draw, one entry per problem."""
    charts = []
    for problem in equal_error.problems_of(runs):
        of_problem = [run for run in runs if (run["mechanism"], run["size"]) == problem]
        about = described.get(problem, {})
        believed = next((run["reference_believed"] for run in of_problem if run.get("reference_believed")), None)
        curves = []
        for curve, rows in equal_error.curves_of(of_problem).items():
            points = [point_of(run) for run in rows if run["status"] == "ok" and run["error"] and run["cpu_s"]]
            curves.append({"program": curve.program, "method": curve.method, "formulation": curve.formulation,
                           "name": name_of(curve), "points": points, "missing": missing_of(rows)})
        charts.append({"id": anchor_of(*problem), "group": group_of(problem[0]),
                       "title": title_of(*problem, is_sized(problem, runs)), "curves": curves,
                       "bodies": next((r["bodies"] for r in of_problem if r.get("bodies")), None),
                       "end": about.get("end"), "channels": channels_of(about), "believed": believed,
                       "reference": next((r["reference"] for r in of_problem if r.get("reference")), "")})
    return charts


def point_of(run):
    point = {name: run.get(name) for name in ("error", "cpu_s", "sweeps", "evaluations", "steps", "factorisations",
                                              "refactorisations", "tolerance")}
    counts = [run.get(name) for name in ("factorisations", "refactorisations") if run.get(name) is not None]
    return point | {"lu": sum(counts) if counts else None}


def missing_of(rows):
    """Runs without a point, such as '1e-02, 1e-03: error above 1 m'."""
    reasons = {}
    for run in rows:
        if run["status"] != "ok":
            reasons.setdefault(STATUS.get(run["status"], f"stopped ({run['status']})"), []).append(
                f"{run['tolerance']:.3g}" if run["tolerance"] else "?")
    return [f"{', '.join(tolerances)}: {reason}" for reason, tolerances in reasons.items()]


def channels_of(about):
    channels = about.get("channels", [])
    shown = ", ".join(channels[:4])
    return f"{shown} … {channels[-1]}" if len(channels) > 5 else ", ".join(channels)


def machine_lines(machine, peers):
    names = (("processor", "Processor"), ("cores", "Cores"), ("compiler", "Compiler"), ("build", "Build"),
             ("version", "Version"), ("commit", "Commit"), ("date", "Measured"), ("load", "Load at the start"), ("load_end", "Load at the end"))
    rows = [(label, machine[key]) for key, label in names if machine.get(key) not in (None, "")]
    rows += [("Other programs", ", ".join(peers))] if peers else []
    return "".join(f"<dt>{label}</dt><dd>{html.escape(str(value))}</dd>" for label, value in rows)


def make_page(runs, record):
    described = {(p["mechanism"], p["size"]): p for p in record.get("problems", [])}
    peers = [program for program in dict.fromkeys(run["program"] for run in runs) if program != OWN]
    tables = "".join(f'<div class="sheet" data-error="{error:g}">{summary(runs, error)}</div>'
                     for error in equal_error.ERRORS)
    buttons = "".join(f'<button type="button" data-error="{error:g}">10<sup>{round(math.log10(error))}</sup></button>'
                      for error in equal_error.ERRORS)
    data = {"charts": chart_data(runs, described), "work": WORK, "own": OWN}
    text = TEMPLATE.read_text(encoding="utf-8")
    for name, value in {"MACHINE": machine_lines(record.get("machine", {}), peers), "TABLES": tables,
                        "ERRORS": buttons, "COUNT": str(len(data["charts"])), "RUNS": str(len(runs)),
                        "PEERS": peers_text(peers),
                        "DATA": json.dumps(data, separators=(",", ":")).replace("</", "<\\/")}.items():
        text = text.replace(f"@{name}@", value)
    return text


def peers_text(peers):
    if not peers:
        return ""
    names = html.escape(" and ".join(peers))
    return (f"<p>{names} ran the same models on the same machine in the same session; the summary shows the best of "
            "each program's methods at that error.</p>")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="with work_precision.csv and .json")
    parser.add_argument("--peers", type=pathlib.Path, action="append", help="tables of other programs (peers.csv)")
    parser.add_argument("--out", type=pathlib.Path, help="the page (folder/index.html)")
    options = parser.parse_args()
    peers = options.peers or [file for file in [options.folder / "peers.csv"] if file.exists()]
    try:
        runs = equal_error.read_runs(options.folder / "work_precision.csv")
        for file in peers:
            runs += equal_error.read_runs(file)
        record = json.loads((options.folder / "work_precision.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 2
    equal_error.write_table(runs, options.folder / "equal_error.csv")
    page = options.out or options.folder / "index.html"
    page.write_text(make_page(runs, record), encoding="utf-8")
    print(page)
    return 0


if __name__ == "__main__":
    sys.exit(main())
