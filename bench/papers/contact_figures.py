"""Tables of contact: speed against error, energy balance, steps after an onset, cost of clearance in a large model."""

import statistics

from runs import REFERENCE, np, parser, run, table, write_table

TOLERANCES = ["1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9"]
REVOLUTE = ["--param", "joint=revolute"]
# name -> mechanism, arguments (the cases of tests/data/reference)
CASES = {
    "r2": ("slider-crank", ["--param", "joint=spherical", "--end", 5]),
    "r3": ("triple-pendulum", ["--end", 4]),
    "r4": ("bouncing-journal", ["--end", 1]),
    "r4c": ("bouncing-journal", ["--param", "law=cylinder", "--end", 1]),
    "r9a": ("tilted-journal", ["--end", 0.2]),
    "r9d": ("tilted-journal", ["--param", "restitution=1", "--end", 0.2]),
    "r10": ("slider-crank", [*REVOLUTE, "--end", 0.5]),
}


def counts(summary):
    return [summary[key] for key in ("steps", "rejected_error", "rejected_newton", "rejected_contact")]


def brief(text):
    """First sentence of why a run stopped."""
    return text.split(";")[0][:70]


def speed_and_error(options):
    """Slider-crank, ball with 0.1 mm: largest error over 5 s against the reference solution."""
    reference = table(REFERENCE / "r2_spherical_c100um.csv")
    rows = []
    for method in ["gear", "radau", "ida"]:
        for onset in ["threshold", "root", "ignored"]:
            for rtol in TOLERANCES:
                done = run(options, f"speed-{method}-{onset}-{rtol}", "slider-crank",
                           ["--param", "joint=spherical", "--param", "clearance=1e-4", "--integrator", method,
                            "--onset", onset, "--rtol", rtol, "--contacts", "--every", 0.01,
                            "--channels", "A.angle,slider.x,energy.*"])
                if not done.ok:
                    rows.append([method, onset, rtol, brief(str(done.summary.get("reason", done.summary["status"])))] + ["-"] * 9)
                    continue
                c = done.columns()
                n = min(len(c["t"]), len(reference["t"]))
                errors = [np.abs(c[a][:n] - reference[b][:n]).max() for a, b in [("A.angle", "theta"), ("slider.x", "x")]]
                starts = [e for e in done.events() if e[3] == "start"]
                depth = max((e[1] for e in starts), default=0.0)
                rows.append([method, onset, rtol, "ok", *[f"{e:.1e}" for e in errors],
                             f"{done.summary['cpu_seconds']:.3f}", *counts(done.summary), len(starts), f"{depth:.0e}"])
    write_table(options.out / "speed_error", ["method", "onset", "rtol", "status", "theta, rad", "x, m", "CPU s", "steps",
                                              "rejected: error", "Newton", "contact", "starts", "deepest start, m"], rows)


def energy(options):
    """Largest |balance| over the samples against what was dissipated (elastic: against the greatest kinetic energy)."""
    rows = []
    for name, (model, arguments) in CASES.items():
        for method in ["gear", "radau"]:
            for rtol in ["1e-6", "1e-8"]:
                done = run(options, f"energy-{name}-{method}-{rtol}", model,
                           [*arguments, "--integrator", method, "--rtol", rtol, "--channels", "energy.*"])
                if not done.ok:
                    rows.append([name, method, rtol, brief(str(done.summary.get("reason", done.summary["status"])))] + ["-"] * 2)
                    continue
                c = done.columns()
                lost, balance = float(c["energy.dissipated"][-1]), float(np.abs(c["energy.balance"]).max())
                scale, word = (lost, "dissipated") if lost > 1e-12 else (float(c["energy.kinetic"].max()), "greatest kinetic")
                rows.append([name, method, rtol, f"{scale:.6g} ({word})", f"{balance:.1e}", f"{balance / scale:.1e}"])
    write_table(options.out / "energy", ["case", "method", "rtol", "energy, J", "balance, J", "ratio"], rows)


def recovery(done):
    """Accepted steps after each start of contact, two counts: until a step is as long as the median of the ten before the
    start (None: the next start or end comes first); until one is half as long as the longest of the next hundred, or of
    those before the next start or end, which compares within the contact."""
    end, length, accepted = done.steps()
    end, length = end[accepted], length[accepted]
    log = done.events()
    times = sorted({e[0] for e in log if e[3] in ("start", "end")})
    as_before, within = [], []
    for start in sorted({e[0] for e in log if e[3] == "start"}):
        k = int(np.searchsorted(end, start - 1e-13))
        limit = next((t for t in times if t > start + 1e-12), np.inf)
        stop = int(np.searchsorted(end, limit, side="right"))
        later = length[k + 1:min(stop, k + 101)]
        if len(later):
            within.append(int(np.argmax(later >= 0.5 * later.max())) + 1)
        if k >= 10:
            back = np.flatnonzero(length[k + 1:] >= np.median(length[k - 10:k]))
            if len(back):
                as_before.append(int(back[0]) + 1 if k + 1 + back[0] < stop else None)
    return as_before, within


def onsets(options):
    rows = []
    cases = {**CASES, "suspension-chain, clearance": ("suspension-chain", ["--param", "joints=clearance", "--end", 1])}
    for name, (model, arguments) in cases.items():
        for method in ["gear", "radau"]:
            for rtol in ["1e-4", "1e-6", "1e-8"]:
                done = run(options, f"onset-{name.split(',')[0]}-{method}-{rtol}", model,
                           [*arguments, "--integrator", method, "--rtol", rtol, "--steps", "--contacts",
                            "--channels", "energy.*"])
                if not done.ok:
                    rows.append([name, method, rtol] + ["failed"] + ["-"] * 5)
                    continue
                as_before, within = recovery(done)
                back = [n for n in as_before if n is not None]
                rows.append([name, method, rtol, *counts(done.summary)[:2], len(as_before), len(as_before) - len(back),
                             statistics.median(back) if back else "-", statistics.median(within) if within else "-"])
    write_table(options.out / "onsets", ["case", "method", "rtol", "steps", "rejected: error", "onsets", "next event first",
                                         "median until as before", "median within the contact"], rows)


def large_model(options):
    rows = []
    for method in ["radau", "gear"]:
        for joints in ["perfect", "bushing", "clearance"]:
            for threads in [1, 2] if joints == "clearance" else [1]:
                done = run(options, f"large-{method}-{joints}-{threads}", "suspension-chain",
                           ["--param", f"units={options.units}", "--param", f"joints={joints}", "--integrator", method,
                            "--rtol", "1e-4", "--end", options.end, "--every", options.end, "--threads", threads,
                            "--channels", "energy.*"])
                s = done.summary
                if not done.ok:
                    rows.append([method, joints, threads, brief(str(s.get("reason", s["status"])))] + ["-"] * 6)
                    continue
                starts = sum(joint["impacts"] for joint in s["contacts"].values())
                phases = s["cpu_seconds_by_phase"]
                top = ", ".join(f"{k} {v:.2f}" for k, v in sorted(phases.items(), key=lambda kv: -kv[1])[:3])
                rows.append([method, joints, threads, f"{s['cpu_seconds'] / s['reached']:.2f}", *counts(s), starts, top])
    write_table(options.out / "large_model", ["method", "joints", "threads", "CPU s per s", "steps", "rejected: error", "Newton",
                                              "contact", "starts", "largest phases, CPU s"], rows)


def main():
    parts = {"speed": speed_and_error, "energy": energy, "onsets": onsets, "large": large_model}
    p = parser(__doc__, "results/contact")
    p.add_argument("parts", nargs="*", default=list(parts), help="of " + ", ".join(parts))
    p.add_argument("--units", default=100, type=int, help="of suspension-chain")
    p.add_argument("--end", default=0.2, type=float, help="s, run of suspension-chain")
    options = p.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for part in options.parts:
        if part not in parts:
            p.error(f"{part}: none of {', '.join(parts)}")
        parts[part](options)


if __name__ == "__main__":
    main()
