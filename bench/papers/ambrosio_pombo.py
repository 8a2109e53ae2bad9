"""Figures 8-13 and 16-18 of Ambrosio & Pombo (2018) by ready mechanisms, and a table of what the paper says
in words against what is found."""

import json
import subprocess

from runs import REFERENCE, np, parser, run_all, table, write_table
import matplotlib.pyplot as plt

CLEARANCES = ["0", "1e-6", "1e-4", "1e-3"]
STEEL = {"young": 2.07e11, "poisson": 0.3}


def label(clearance):
    return f"{float(clearance) * 1e3:g} mm"


def exported(options, clearance, restitution):
    """slider-crank joint=revolute with the cylinder law (AP 44) of steel;
    the end faces keep Lankarani-Nikravesh."""
    text = subprocess.run([str(options.gudgeon.resolve()), "export", "slider-crank", "--param", "joint=revolute",
                           "--param", f"clearance={clearance}"], capture_output=True, text=True, check=True).stdout
    model = json.loads(text)
    bearing = next(joint for joint in model["joints"] if joint["name"] == "A")["clearance"]
    bearing["axial_law"] = bearing["law"]
    bearing["law"] = {"kind": "cylinder", "materials": [STEEL, STEEL], "restitution": restitution}
    path = options.out / f"cylinder-{clearance}-{restitution}.json"
    path.write_text(json.dumps(model))
    return path


def cases(options):
    crank = ["--integrator", "radau", "--rtol", options.rtol, "--end", 5, "--every", 5e-4, "--contacts", "--channels",
             "slider.x,slider.vx,crank.e?,A.f?,B.f?,energy.*"]
    pendulum = ["--integrator", "radau", "--rtol", options.rtol, "--every", 1e-3, "--contacts", "--channels",
                "body1.w?,J?.slide,J?.angle,J?.penetration,J?.normal_force,energy.*"]
    result = {"perfect": ("slider-crank", crank)}
    for joint in ["spherical", "revolute"]:
        for clearance in CLEARANCES:
            params = ["--param", f"joint={joint}", "--param", f"clearance={clearance}"]
            result[f"{joint}-{clearance}"] = ("slider-crank", params + crank)
    free = ["--param", "joint=revolute", "--param", "clearance=0", "--param", "restitution=1"]
    touching = crank[:-1] + [crank[-1] + ",A.penetration"]
    result["revolute-0-elastic"] = ("slider-crank", free + touching)
    for clearance in ["1e-4", "1e-3"]:
        result[f"cylinder-{clearance}"] = (exported(options, clearance, 0.75), crank)
    longer = ["--param", "joint=spherical", "--param", "clearance=1e-4"] + crank
    longer[longer.index("--end") + 1] = 20
    result["spherical-1e-4-long"] = ("slider-crank", longer)
    for law in ["lankarani-nikravesh", "kelvin-voigt"]:
        result[law] = ("triple-pendulum", ["--param", f"law={law}", "--end", 4] + pendulum)
    result["kelvin-voigt-long"] = ("triple-pendulum", ["--param", "law=kelvin-voigt", "--end", options.long] + pendulum)
    return result


def crank_angle(c):
    """theta = atan2(-zeta_y, zeta_z) of the crank, unwrapped."""
    e0, e1, e2, e3 = (c[f"crank.e{k}"] for k in range(4))
    return np.unwrap(np.arctan2(2 * (e0 * e1 - e2 * e3), e0**2 - e1**2 - e2**2 + e3**2))


def oscillation(force, window=41):
    """What running means over 20 ms, taken twice, leave of a force (N)."""
    for _ in range(2):
        force = force - np.convolve(np.pad(force, window // 2, mode="edge"), np.ones(window) / window, "valid")
    return force


def stroke_ends(c, count):
    """Times of the first ends of the stroke (slider speed zero)."""
    v, t = c["slider.vx"], c["t"]
    k = np.nonzero(v[:-1] * v[1:] < 0)[0][:count]
    return t[k] - v[k] * (t[k + 1] - t[k]) / (v[k + 1] - v[k])


def last_full_turn(t, theta):
    """Time at which the angle is largest: later the crank only swings."""
    k = int(np.argmax(theta))
    return t[k], theta[k] / (2 * np.pi)


class Plots:
    def __init__(self, options, runs):
        self.out, self.kind, self.runs = options.out, options.format, runs
        self.data = {name: run.columns() for name, run in runs.items() if run.ok}
        for c in self.data.values():
            if "crank.e0" in c:
                c["theta"] = crank_angle(c)

    def save(self, name, panels):
        """panels: (title, y label, [(run, column, label)], end of the axis or None)."""
        figure, axes = plt.subplots(len(panels), 1, figsize=(9, 3.1 * len(panels)), squeeze=False)
        for axis, (title, unit, curves, end) in zip(axes[:, 0], panels):
            for run, column, text in curves:
                if run in self.data:
                    axis.plot(self.data[run]["t"], self.data[run][column], lw=0.8, label=text)
            axis.set(title=title, xlabel="t [s]", ylabel=unit, xlim=(0, end))
            axis.legend(fontsize=7)
        figure.tight_layout()
        figure.savefig(self.out / f"{name}.{self.kind}", dpi=120)
        plt.close(figure)

    def clearances(self, joint, column, which):
        return [("perfect", column, "perfect joints")] + [(f"{joint}-{c}", column, label(c)) for c in which]

    def slider_crank(self):
        for name, column, unit in [("figure08", "slider.x", "slider x [m]"), ("figure09", "theta", "crank angle [rad]"),
                                   ("figure10", "B.fx", "reaction at B, X [N]")]:
            self.save(name, [(f"({p}) {what} spherical clearances", unit, self.clearances("spherical", column, w), 5)
                             for p, what, w in [("a", "null or small", CLEARANCES[:2]), ("b", "large", CLEARANCES[2:])]])
        elastic = [("revolute-0-elastic", "0 mm, no damping")]
        cylinder = [("cylinder-1e-4", "0.1 mm, AP 44"), ("cylinder-1e-3", "1 mm, AP 44")]
        for name, panels in [("figure11", [("slider.x", "slider x [m]"), ("theta", "crank angle [rad]")]),
                             ("figure12", [("A.fx", "reaction at A, X [N]"), ("A.fz", "reaction at A, Z [N]")])]:
            self.save(name, [("revolute clearance", unit, self.clearances("revolute", column, CLEARANCES)
                              + [(run, column, text) for run, text in elastic[:name == "figure11"] + cylinder], 5)
                             for column, unit in panels])
        self.save("figure13", [("null clearance, revolute", unit, self.clearances("revolute", column, ["0"])
                                + [(elastic[0][0], column, elastic[0][1])], 5)
                               for column, unit in [("A.fx", "reaction at A, X [N]"), ("A.fz", "reaction at A, Z [N]")]])

    def pendulum(self):
        parts = [("J2.slide", "translation [m]"), ("J2.normal_force", "stop force [N]"), ("J3.angle", "rotation [rad]"),
                 ("J3.normal_force", "stop moment [N m]")]
        for name, run in [("figure16", "lankarani-nikravesh"), ("figure17", "kelvin-voigt")]:
            self.save(name, [(run, unit, [(run, column, column)], 4) for column, unit in parts])
        run = "kelvin-voigt-long"
        self.save("figure18", [(run, unit, [(run, column, column)], None) for column, unit in
                               [("body1.wy", "speed of body 1 [rad/s]"), parts[0], parts[2]]])


class Findings:
    """Rows: part of the paper, what it says, what is found, agreement."""

    def __init__(self, plots):
        self.runs, self.data, self.rows = plots.runs, plots.data, []

    def add(self, where, says, found, agrees):
        word = agrees if isinstance(agrees, str) else "yes" if agrees else "no"
        self.rows.append([where, says, found, word])

    def need(self, *names):
        return all(name in self.data for name in names)

    def lost(self, name):
        return float(self.data[name]["energy.dissipated"][-1])

    def perfect(self):
        c = self.data["perfect"]
        ends = stroke_ends(c, 200)
        x = np.interp(ends, c["t"], c["slider.x"])
        spread = max(np.ptp(x[::2]), np.ptp(x[1::2]))
        text = f"ends of the stroke agree to {spread:.1e} m"
        reference = REFERENCE / "r1_slider_crank_ideal.csv"
        if reference.exists():
            r = table(reference)
            text += f"; theta to {np.abs(np.interp(r['t'], c['t'], c['theta']) - r['theta']).max():.1e} rad of the reference"
        self.add("Fig. 8", "perfect joints: constant amplitude, as the benchmark", text, spread < 1e-5)
        f, v = np.abs(c["B.fx"]), np.abs(c["slider.vx"])
        peaks = f > 0.9 * f.max()
        slow = v[peaks].max() / v.max()
        self.add("Fig. 10", "largest reactions where the slider turns round", f"above 90 % of {f.max():.1f} N the slider "
                 f"has at most {100 * slow:.0f} % of its highest speed", slow < 0.5)

    def delay(self, where, joint, name):
        names = ["perfect"] + [f"{joint}-{c}" for c in CLEARANCES if f"{joint}-{c}" in self.data]
        angle = [self.data[n]["theta"][-1] for n in names]
        lost = [self.lost(n) for n in names]
        text = "; ".join(f"{n.split('-', 1)[-1]}: {a:.2f} rad, {e:.3f} J" for n, a, e in zip(names, angle, lost))
        late = all(a <= angle[0] + 1e-3 for a in angle[1:])
        ordered = late and all(a >= b for a, b in zip(angle[1:], angle[2:]))
        self.add(where, f"{name}: the delay grows with the clearance, by dissipation", "theta(5 s), lost: " + text,
                 True if ordered else "late, but not in the order of the clearances" if late else False)
        ends = [stroke_ends(self.data[n], 2) for n in names]
        text = ", ".join(f"{n.split('-', 1)[-1]} {e[1]:.4f}" for n, e in zip(names, ends) if len(e) > 1)
        times = [e[1] for e in ends if len(e) > 1]
        self.add(where, f"{name}: later ends of the stroke", f"second end, s: {text}",
                 True if all(b >= a - 1e-6 for a, b in zip(times, times[1:])) else "not in the order of the clearances")

    def forces(self, where, joint, channel):
        names = ["perfect"] + [f"{joint}-{c}" for c in CLEARANCES if f"{joint}-{c}" in self.data]
        rms, shares = [], []
        for n in names:
            c = self.data[n]
            rest = oscillation(c[channel])
            rms.append(float(np.sqrt(np.mean(rest**2))))
            v = np.abs(c["slider.vx"])
            middle = v > 0.5 * v.max()
            inside, outside = np.sqrt(np.mean(rest[middle]**2)), np.sqrt(np.mean(rest[~middle]**2))
            shares.append(inside / outside)
        text = ", ".join(f"{n.split('-', 1)[-1]} {r:.2f}" for n, r in zip(names, rms))
        self.add(where, f"{channel}: no oscillation with null clearance", f"rms of what means over 20 ms leave, N: {text}",
                 rms[1] < 1.5 * rms[0] if names[1].endswith("-0") else "not run")
        sized = [r for n, r in zip(names, rms) if not n.endswith("-0") and n != "perfect"]
        self.add(where, f"{channel}: oscillation grows with the clearance", f"the same, N: {text}",
                 all(b > a for a, b in zip(sized, sized[1:])))
        text = ", ".join(f"{n.split('-', 1)[-1]} {s:.2f}" for n, s in zip(names, shares))
        self.add(where, f"{channel}: oscillation mostly in mid-stroke", f"rms in mid-stroke over rms near its ends: {text}",
                 all(s > 1 for s in shares[2:]))

    def turning(self):
        if self.need("spherical-1e-4-long"):
            c = self.data["spherical-1e-4-long"]
            t, turns = last_full_turn(c["t"], c["theta"])
            self.add("Fig. 9", "in longer runs the crank stops turning and swings", f"0.1 mm: largest angle {turns:.2f} turns "
                     f"at {t:.2f} s of {c['t'][-1]:g} s", t < 0.95 * c["t"][-1])
        for name, law in [("revolute-1e-3", "Lankarani-Nikravesh"), ("cylinder-1e-3", "AP 44, steel"),
                          ("cylinder-1e-4", "0.1 mm, AP 44, steel")]:
            if self.need(name):
                c = self.data[name]
                t, turns = last_full_turn(c["t"], c["theta"])
                says = "1 mm: at most two turns, then the crank swings" if name.endswith("1e-3") else "-"
                self.add("Fig. 11", says, f"{law}: {turns:.2f} turns at {t:.2f} s; lost {self.lost(name):.3f} J",
                         turns < 2 if says != "-" else "-")

    def damping(self):
        if not self.need("revolute-0", "revolute-0-elastic"):
            return
        with_it, without = self.data["revolute-0"], self.data["revolute-0-elastic"]
        late = with_it["theta"][-1] < without["theta"][-1]
        self.add("Fig. 11", "null clearance: damping alone delays", f"theta(5 s) {with_it['theta'][-1]:.2f} with, "
                 f"{without['theta'][-1]:.2f} without, {self.data['perfect']['theta'][-1]:.2f} rad perfect; lost "
                 f"{self.lost('revolute-0'):.3f} J", late)
        for channel in ["A.fx", "A.fz"]:
            a, b, p = (float(np.sqrt(np.mean(oscillation(d[channel])**2))) for d in (with_it, without, self.data["perfect"]))
            self.add("Fig. 13", f"{channel}, null clearance: oscillation without damping, none with it",
                     f"rms of what means over 20 ms leave, N: {b:.2f} without, {a:.2f} with, {p:.2f} perfect",
                     True if b > 3 * a and a < 1.5 * p else "less, not gone" if a < b else False)
        share = float(np.mean(without["A.penetration"] > 0))
        self.add("Fig. 13", "null clearance without damping: flight and contact alternate",
                 f"in contact {100 * share:.1f} % of the time", share < 0.99)
        gap = np.abs(with_it["slider.x"] - self.data["perfect"]["slider.x"])[with_it["t"] <= 1].max()
        self.add("Sec. 6", "null clearance moves as perfect joints do", f"slider within {gap * 1e3:.2f} mm over 1 s", gap < 2e-3)

    def cost(self):
        times = {n: self.runs[n].summary["cpu_seconds"] for n in self.data if "-long" not in n}
        base = times["perfect"]
        text = ", ".join(f"{n} {t:.2f}" for n, t in times.items() if n == "perfect" or n.startswith(("sph", "rev", "cyl")))
        self.add("Sec. 6", "no evidence that clearance costs more time than perfect joints", f"CPU s: {text}",
                 all(times[n] < 1.2 * base for n in times if n.startswith(("sph", "rev", "cyl"))))

    def stops(self):
        ln, kv = self.data["lankarani-nikravesh"], self.data["kelvin-voigt"]
        share = {n: self.runs[n].summary["contacts"]["J2"]["share"] for n in ["lankarani-nikravesh", "kelvin-voigt"]}
        longest = {n: longest_contact(self.runs[n].events(), "J2", 4) for n in share}
        self.add("Fig. 16", "Lankarani-Nikravesh: bodies rebound, no residual deformation",
                 f"longest contact of J2 {longest['lankarani-nikravesh'] * 1e3:.1f} ms", longest["lankarani-nikravesh"] < 0.05)
        sides = stop_sides(ln)
        self.add("Fig. 16", "soon after, the other side is hit", "sides hit in turn: J2 " + sides["J2.slide"] + ", J3 "
                 + sides["J3.angle"], "+-" in sides["J2.slide"] or "-+" in sides["J2.slide"])
        self.add("Fig. 17", "Kelvin-Voigt dissipates more", f"4 s: {self.lost('kelvin-voigt'):.3f} against "
                 f"{self.lost('lankarani-nikravesh'):.3f} J", self.lost("kelvin-voigt") > self.lost("lankarani-nikravesh"))
        self.add("Fig. 17", "Kelvin-Voigt: the deformation of the translation stop becomes permanent", f"J2 in contact "
                 f"{100 * share['kelvin-voigt']:.0f} % of 4 s (other law {100 * share['lankarani-nikravesh']:.0f} %), longest "
                 f"{longest['kelvin-voigt']:.2f} s, but it leaves the stop again", "in part")
        swings = {n: np.abs(self.data[n]["body1.wy"]) for n in share}
        late = {n: w[len(w) // 2:].max() / w[:len(w) // 2].max() for n, w in swings.items()}
        self.add("Figs. 16, 17", "swings decrease slightly / very quickly", "largest speed of body 1 in the second half over "
                 f"the first: {late['lankarani-nikravesh']:.2f} / {late['kelvin-voigt']:.2f}; mechanical energy lost "
                 f"{self.lost('lankarani-nikravesh'):.3f} / {self.lost('kelvin-voigt'):.3f} J",
                 late["kelvin-voigt"] < late["lankarani-nikravesh"])
        if self.need("kelvin-voigt-long"):
            self.long_run()

    def long_run(self):
        c, run = self.data["kelvin-voigt-long"], self.runs["kelvin-voigt-long"]
        log = run.events()
        starts = {j: [e[0] for e in log if e[3] == "start" and e[4] == j] for j in ("J2", "J3")}
        end = c["t"][-1]
        late = float(c["energy.dissipated"][-1] - np.interp(0.8 * end, c["t"], c["energy.dissipated"]))
        last = max(starts["J2"][-1], starts["J3"][-1])
        state = f"J2 rests on its stop, {c['J2.penetration'][-1]:.1e} m deep" if c["J2.penetration"][-1] > 0 else "J2 is off its stop"
        self.add("Fig. 18", "long run: no more contacts with any stop, constant amplitude", f"{end:g} s: last start J2 "
                 f"{starts['J2'][-1]:.1f} s, J3 {starts['J3'][-1]:.1f} s; at the end {state}; lost in the last fifth "
                 f"{late:.1e} J of {self.lost('kelvin-voigt-long'):.3f} J", last < 0.8 * end and late < 1e-3)


def longest_contact(log, joint, end):
    open_since, longest = None, 0.0
    for t, _, _, event, name, _ in log:
        if name == joint and event == "start":
            open_since = t
        elif name == joint and event == "end" and open_since is not None:
            longest, open_since = max(longest, t - open_since), None
    return max(longest, end - open_since) if open_since is not None else longest


def stop_sides(c):
    """Sides of the stops in the order they are hit, such as -++-."""
    result = {}
    for column, pen in [("J2.slide", "J2.penetration"), ("J3.angle", "J3.penetration")]:
        touching = c[pen] > 0
        first = np.nonzero(touching[1:] & ~touching[:-1])[0] + 1
        result[column] = "".join("+" if c[column][k] > 0 else "-" for k in first)
    return result


def main():
    p = parser(__doc__, "results/ambrosio-pombo")
    p.add_argument("--rtol", default="1e-6", help="tolerance of all runs")
    p.add_argument("--long", default=400, type=float, help="s, length of the run of Figure 18")
    p.add_argument("--format", default="png", choices=["png", "svg"], help="of the figures")
    options = p.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    plots = Plots(options, run_all(options, cases(options)))
    plots.slider_crank()
    plots.pendulum()
    f = Findings(plots)
    f.perfect()
    f.delay("Figs. 8, 9", "spherical", "spherical clearance")
    f.forces("Fig. 10", "spherical", "B.fx")
    f.delay("Fig. 11", "revolute", "revolute clearance")
    f.turning()
    f.damping()
    f.forces("Fig. 12", "revolute", "A.fx")
    f.forces("Fig. 12", "revolute", "A.fz")
    f.cost()
    f.stops()
    write_table(options.out / "findings", ["paper", "says", "found", "agrees"], f.rows)
    missing = [name for name, run in plots.runs.items() if not run.ok]
    if missing:
        print("without result:", ", ".join(missing))


if __name__ == "__main__":
    main()
