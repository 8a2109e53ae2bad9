"""The problems of peers.py: models, what is compared, and solutions known from elsewhere."""
import csv
import dataclasses
import math
import pathlib

TABLES = pathlib.Path(__file__).resolve().parents[2] / "tests/data/reference"
GRAVITY = 9.81


@dataclasses.dataclass(frozen=True)
class Problem:
    """points: the channels that make up each compared point; the error is the largest distance of a point."""
    mechanism: str
    size: int
    parameters: tuple  # of the ready mechanism
    end: float
    every: float
    points: tuple

    @property
    def name(self):
        return f"{self.mechanism}-{self.size}"

    @property
    def channels(self):
        return [channel for point in self.points for channel in point]

    @property
    def times(self):
        return [min(k * self.every, self.end) for k in range(round(self.end / self.every) + 1)]


@dataclasses.dataclass(frozen=True)
class Truth:
    """columns: channel -> values at the problem's times, known to `known` metres by `source`."""
    columns: dict
    known: float
    source: str

    @property
    def floor(self):
        """The least error that may be stated."""
        return 10 * self.known


def chain(size):
    return Problem("chain", size, (("links", size), ("thin", 1)), 1, 0.1, (("tip.x", "tip.z"),))


def four_bar(size):
    points = tuple((f"top{k}.x", f"top{k}.z") for k in range(size + 1))
    return Problem("four-bar", size, (("loops", size),), 10, 0.1, points)


def suspension_chain(size):
    return Problem("suspension-chain", size, (("units", size),), 5, 0.05,
                   tuple((f"chassis{k}.z",) for k in range(size)))


MECHANISMS = {"chain": (chain, (4, 16, 64, 256, 1024)), "four-bar": (four_bar, (1, 10, 40, 100)),
              "suspension-chain": (suspension_chain, (1, 4, 16, 64, 256))}


def known_truth(problem, tables=TABLES):
    """Exact or tabulated solution; None where there is neither."""
    if problem.mechanism == "four-bar":
        return crank_tops(problem)
    if problem.mechanism == "chain":
        return table(problem, tables / f"r5_chain_N{problem.size}.csv", {"tip.x": "tip_x", "tip.z": "tip_z"}, 1e-12)
    return table(problem, tables / f"suspension_chain_N{problem.size}.csv", {}, 1e-8)


def table(problem, path, names, known):
    """Columns of a reference file by channel; names: where they are called otherwise."""
    if not path.exists():
        return None
    columns = read_table(path)
    rows = [nearest(columns["t"], time) for time in problem.times]
    return Truth({channel: [columns[names.get(channel, channel)][row] for row in rows]
                  for channel in problem.channels}, known, path.name)


def nearest(times, time):
    for row, other in enumerate(times):
        if abs(other - time) < 1e-9:
            return row
    raise ValueError(f"no row for t = {time:g}")


def read_table(path):
    """CSV with a header; lines with # are comments. {column: numbers}"""
    with open(path, newline="") as lines:
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    return {name.strip(): [float(row[i]) for row in rows[1:]] for i, name in enumerate(rows[0])}


def crank_tops(problem, step=1e-4):
    """All cranks stay parallel: a'' = g (9 N + 3)/(8 N + 2) sin a from a = 0, a' = 1; the tops at (k + sin a, cos a)."""
    n = problem.size
    factor = GRAVITY * (9 * n + 3) / (8 * n + 2)
    angles = pendulum_angles(factor, 0.0, 1.0, problem.times, step)
    columns = {}
    for k in range(n + 1):
        columns[f"top{k}.x"] = [k + math.sin(a) for a in angles]
        columns[f"top{k}.z"] = [math.cos(a) for a in angles]
    return Truth(columns, 1e-10, "equation of motion of parallel cranks")


def pendulum_angles(factor, angle, rate, times, step):
    """a'' = factor sin a by the classical Runge-Kutta method; step 1e-4: good to 3e-11 over 10 s, by round-off."""
    angles = [angle]
    for begin, end in zip(times, times[1:]):
        count = max(1, round((end - begin) / step))
        h = (end - begin) / count
        for _ in range(count):
            k1 = factor * math.sin(angle)
            k2 = factor * math.sin(angle + h / 2 * rate)
            k3 = factor * math.sin(angle + h / 2 * (rate + h / 2 * k1))
            k4 = factor * math.sin(angle + h * (rate + h / 2 * k2))
            angle += h * (rate + h / 6 * (k1 + k2 + k3))
            rate += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        angles.append(angle)
    return angles


def error(problem, columns, truth):
    """Largest distance of a compared point over the samples, m."""
    worst = 0.0
    for row in range(len(problem.times)):
        for point in problem.points:
            distance = math.hypot(*(columns[c][row] - truth[c][row] for c in point))
            worst = max(worst, distance) if distance == distance else math.inf
    return worst
