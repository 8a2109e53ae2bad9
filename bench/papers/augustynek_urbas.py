"""Section 5 of Augustynek & Urbas (2018) by the ready mechanism rsup: figures 8-10, a table of what the paper says in words
against what is found, contact figures of all combinations, and the cost of the paper's fixed step."""

import itertools

from runs import np, parser, run_all, write_table
import matplotlib.pyplot as plt

JOURNAL, CLEARANCE = 0.004, 0.001  # m, radius and radial clearance (AU Table 1)
STEP = 5e-6                        # s, of the paper
COMBINATIONS = list(itertools.product(["rigid", "flexible"], ["planar", "spatial"], ["0", "1"]))
MOTION = "slider.x,slider.vx,slider.ax,crank.wx"
JOINT = ",U2.dx,U2.dy,U2.az,U2.penetration,U2.normal_force,U2.friction_force,U2.dissipated"


def parameters(coupler, joint, friction="0"):
    return ["--param", f"coupler={coupler}", "--param", f"joint={joint}", "--param", f"friction={friction}"]


def name_of(coupler, joint, friction):
    return f"{coupler}-{joint}-{'lugre' if friction == '1' else 'smooth'}"


def cases(options):
    common = ["--integrator", "radau", "--rtol", options.rtol, "--end", options.end, "--contacts"]
    result = {f"{c}-perfect": ("rsup", parameters(c, "perfect") + common + ["--every", 1e-4, "--channels", MOTION])
              for c in ["rigid", "flexible"]}
    for c, j, f in COMBINATIONS:
        result[name_of(c, j, f)] = ("rsup", parameters(c, j, f) + common + ["--every", options.every, "--channels", MOTION + JOINT])
    return result


class Joint:
    """What a run tells of its clearance; forces in N, energies in J."""

    def __init__(self, run):
        self.run, c = run, run.columns()
        self.c, self.t = c, c["t"]
        d = np.array([c["U2.dx"], c["U2.dy"]])
        self.eccentricity = np.hypot(*d)
        n = d / np.maximum(self.eccentricity, 1e-12)
        rate = np.gradient(d, self.t, axis=1)
        slip = -n[1] * rate[0] + n[0] * rate[1] + JOURNAL * np.gradient(np.unwrap(c["U2.az"]), self.t)
        power = np.abs(c["U2.friction_force"] * slip)
        self.lost = float(c["U2.dissipated"][-1])
        self.by_friction = float(np.sum(0.5 * (power[1:] + power[:-1]) * np.diff(self.t)))
        self.by_impact = self.lost - self.by_friction
        self.contact = run.summary["contacts"]["U2"]

    def peaks(self, above=5.0):
        f = self.c["U2.normal_force"]
        return int(np.sum((f[1:-1] > f[:-2]) & (f[1:-1] >= f[2:]) & (f[1:-1] > above)))


def velocity_peaks(c, start, acceleration):
    """Bursts after a time in which the slider's acceleration exceeds a value."""
    beyond = np.abs(c["slider.ax"][c["t"] > start]) > acceleration
    return int(np.sum(beyond[1:] & ~beyond[:-1]))


class Figures:
    def __init__(self, options, runs):
        self.out, self.kind = options.out, options.format
        self.runs = {name: run for name, run in runs.items() if run.ok}
        self.ideal = self.runs["rigid-perfect"].columns()
        self.joints = {name: Joint(run) for name, run in self.runs.items() if not name.endswith("perfect")}
        self.window = (options.end - 1.5, options.end)

    def save(self, figure, name):
        figure.tight_layout()
        figure.savefig(self.out / f"{name}.{self.kind}", dpi=120)
        plt.close(figure)

    def slider(self):
        figure, axes = plt.subplots(3, 1, figsize=(9, 9))
        shown = [(f"{c} coupler", self.joints[f"{c}-planar-lugre"].c) for c in ["rigid", "flexible"]
                 if f"{c}-planar-lugre" in self.joints] + [("ideal joint", self.ideal)]
        for axis, (column, unit) in zip(axes, [("slider.x", "x [m]"), ("slider.vx", "v [m/s]"), ("slider.ax", "a [m/s2]")]):
            for label, c in shown:
                axis.plot(c["t"], c[column], lw=0.7, label=label)
            axis.set(xlabel="t [s]", ylabel=unit, xlim=self.window)
            axis.legend(fontsize=7)
        self.save(figure, "figure08")

    def forces(self):
        figure, axes = plt.subplots(2, 1, figsize=(9, 6), sharey=True)
        for axis, coupler in zip(axes, ["rigid", "flexible"]):
            j = self.joints[f"{coupler}-planar-lugre"]
            axis.plot(j.t, j.c["U2.normal_force"], lw=0.6)
            axis.set(title=f"{coupler} coupler", xlabel="t [s]", ylabel="normal force [N]", xlim=self.window)
        self.save(figure, "figure09")

    def paths(self):
        figure, axes = plt.subplots(1, 2, figsize=(9, 4.6))
        circle = np.linspace(0, 2 * np.pi, 400)
        for axis, coupler in zip(axes, ["rigid", "flexible"]):
            j = self.joints[f"{coupler}-planar-lugre"]
            late = j.t > self.window[0]
            axis.plot(1e3 * j.c["U2.dx"][late], 1e3 * j.c["U2.dy"][late], lw=0.4)
            axis.plot(1e3 * CLEARANCE * np.cos(circle), 1e3 * CLEARANCE * np.sin(circle), "k:", lw=1)
            axis.set(title=f"{coupler} coupler", xlabel="mm", ylabel="mm", aspect="equal")
        self.save(figure, "figure10")

    def findings(self):
        rows, steady = [], 2.0
        rigid, flexible = (self.joints[f"{c}-planar-lugre"] for c in ["rigid", "flexible"])
        most = np.abs(self.ideal["slider.ax"]).max()
        counts = [velocity_peaks(j.c, steady, 3 * most) for j in (rigid, flexible)]
        away = [np.abs(j.c["slider.vx"] - np.interp(j.t, self.ideal["t"], self.ideal["slider.vx"])).max() for j in (rigid, flexible)]
        rows.append(["slight peaks in the slider's velocity", f"accelerations beyond 3 times the ideal's after {steady:g} s: rigid "
                     f"{counts[0]}, flexible {counts[1]}; at most {away[0]:.3f} and {away[1]:.3f} m/s from the ideal, which has "
                     f"{np.abs(self.ideal['slider.vx']).max():.3f}", min(counts) > 0 and max(away) < 0.5 * np.abs(self.ideal["slider.vx"]).max()])
        ratio = [np.abs(j.c["slider.ax"]).max() / most for j in (rigid, flexible)]
        rows.append(["accelerations significantly larger than with the ideal joint", f"largest: ideal {most:.1f} m/s2, rigid "
                     f"{ratio[0]:.0f}, flexible {ratio[1]:.0f} times that", all(r > 5 for r in ratio)])
        impacts = [j.contact["impacts"] for j in (rigid, flexible)]
        rows.append(["more peaks of the contact force with the flexible coupler", f"impacts {impacts[0]} rigid, {impacts[1]} flexible; "
                     f"peaks above 5 N: {rigid.peaks()}, {flexible.peaks()}", impacts[1] > impacts[0] and flexible.peaks() > rigid.peaks()])
        deepest = [1e3 * j.eccentricity.max() for j in (rigid, flexible)]
        share = [np.mean(j.eccentricity > CLEARANCE) for j in (rigid, flexible)]
        rows.append(["the journal's path crosses the circle of 1 mm at every contact", f"eccentricity at most {deepest[0]:.4f} / "
                     f"{deepest[1]:.4f} mm; outside the circle {100 * share[0]:.0f} / {100 * share[1]:.0f} % of the time",
                     all(1 < d < 1.1 for d in deepest)])
        x = [np.abs(j.c["slider.x"] - np.interp(j.t, self.ideal["t"], self.ideal["slider.x"])).max() for j in (rigid, flexible)]
        rows.append(["flexibility has no great influence on the motion", f"slider at most {1e3 * x[0]:.2f} (rigid) and {1e3 * x[1]:.2f} mm "
                     "(flexible) from the ideal", abs(x[0] - x[1]) < 0.5 * max(x)])
        return [[says, found, "yes" if agrees else "no"] for says, found, agrees in rows]

    def combinations(self):
        rows = []
        for c, j, f in COMBINATIONS:
            if (name := name_of(c, j, f)) not in self.joints:
                continue
            x = self.joints[name]
            late = x.t > x.t[-1] - 4 * np.pi / 9  # two turns
            rows.append([c, j, "LuGre" if f == "1" else "none", x.contact["impacts"], f"{x.contact['peak_force']:.0f}",
                         f"{1e6 * x.contact['deepest']:.1f}", f"{100 * x.contact['share']:.0f}", f"{x.by_impact:.3f}",
                         f"{x.by_friction:.3f}", f"{np.mean(x.c['crank.wx'][late]):.3f}"])
        return rows


def cost_cases(options, model):
    common = ["--end", options.cost_end, "--every", 1e-3, "--channels", "slider.x,slider.vx,U2.dx,U2.dy"]
    result = {"cost-reference": ("rsup", model + ["--integrator", "radau", "--rtol", 1e-11] + common),
              "cost-check": ("rsup", model + ["--integrator", "radau", "--rtol", 1e-10] + common)}
    for factor in [1, 2, 4]:
        result[f"cost-rk4-{factor}"] = ("rsup", model + ["--integrator", "rk4", "--step", factor * STEP] + common)
    for integrator in ["radau", "gear"]:
        for rtol in ["1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9"]:
            result[f"cost-{integrator}-{rtol}"] = ("rsup", model + ["--integrator", integrator, "--rtol", rtol] + common)
    return result


def cost(options):
    """CPU seconds and errors over the first part of the motion, before impacts make every error grow."""
    model = parameters("flexible", "planar", "1")
    runs = run_all(options, cost_cases(options, model))
    truth = runs.pop("cost-reference").columns()
    found = {}
    for name, run in runs.items():
        if not run.ok:
            continue
        c = run.columns()
        error = max(np.abs(c[k] - truth[k]).max() for k in ["slider.x", "U2.dx", "U2.dy"])
        found[name[5:]] = (error, run.summary["cpu_seconds"], run.summary["steps"])
    paper = found.get("rk4-1")
    rows = []
    for name, (error, cpu, steps) in found.items():
        if name == "check":
            continue
        equal = "" if paper is None or error > paper[0] else f"{paper[1] / cpu:.1f}"
        rows.append([name, f"{error:.1e}", steps, f"{cpu:.2f}", equal])
    rows.append(["reference against itself at 1e-10", f"{found['check'][0]:.1e}", "", "", ""])
    return rows


def main():
    p = parser(__doc__, "results/augustynek-urbas")
    p.add_argument("--rtol", default="1e-6", help="tolerance of the runs of the figures")
    p.add_argument("--end", default=5, type=float, help="s, their length")
    p.add_argument("--every", default=2e-5, type=float, help="s, output of the runs with clearance: friction is integrated from it")
    p.add_argument("--cost-end", default=0.3, type=float, help="s, length of the runs that compare costs")
    p.add_argument("--format", default="png", choices=["png", "svg"], help="of the figures")
    p.set_defaults(limit=300)
    options = p.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    figures = Figures(options, run_all(options, cases(options)))
    figures.slider()
    figures.forces()
    figures.paths()
    write_table(options.out / "findings", ["says", "found", "agrees"], figures.findings())
    write_table(options.out / "combinations", ["coupler", "clearance", "friction", "impacts", "peak force N", "deepest um", "in contact %",
                                               "lost by impact J", "by friction J", "crank rad/s"], figures.combinations())
    write_table(options.out / "cost", ["run", "error m", "steps", "CPU s", "CPU s of the paper's step over these, at no larger error"],
                cost(options))


if __name__ == "__main__":
    main()
