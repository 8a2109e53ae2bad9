"""Errors of beams by the rigid finite element method against beam theory, for a number of elements each: deflection and
large deflection of a cantilever, frequencies clamped-free and hinged at both ends."""

import json
import pathlib
import subprocess

from runs import np, parser, write_table
from scipy.optimize import brentq
from scipy.special import ellipeinc, ellipkinc

YOUNG, NU, DENSITY, HEIGHT = 2.1e11, 0.3, 7850, 1e-3  # 1 m long, 2 mm wide and 1 mm high: shear and rotary inertia do not count
WIDTH = 2 * HEIGHT
AREA, IY, IZ = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12, HEIGHT * WIDTH**3 / 12


def torsion_constant():
    n = np.arange(1, 200, 2)
    return WIDTH * HEIGHT**3 / 3 * (1 - 192 * HEIGHT / (np.pi**5 * WIDTH) * np.sum(np.tanh(n * np.pi * WIDTH / 2 / HEIGHT) / n**5))


def elastica(load):
    """Tip (along, across) over the length of an inextensible cantilever, load = P L^2 / (E I)."""
    def part(integral, tip):
        m = (1 + np.sin(tip)) / 2
        return integral(np.pi / 2, m) - integral(np.arcsin(1 / np.sqrt(2 * m)), m)
    tip = brentq(lambda a: part(ellipkinc, a) - np.sqrt(load), 1e-9, np.pi / 2 - 1e-12, xtol=1e-15)
    return np.sqrt(2 * np.sin(tip) / load), 1 - 2 * part(ellipeinc, tip) / np.sqrt(load)


def beam_model(elements, stretch, joints, forces=()):
    beam = {"name": "rod", "points": [[0, 0, 0], [1, 0, 0]], "direction": [0, 1, 0], "elements": elements, "stretch": stretch,
            "section": {"rectangle": {"width": WIDTH, "height": HEIGHT}},
            "material": {"young": YOUNG, "poisson": NU, "density": DENSITY}}
    return {"gudgeon": 1, "name": "beam", "gravity": [0, 0, 0], "beams": [beam], "joints": list(joints), "forces": list(forces)}


CLAMPED = [{"name": "A", "kind": "rigid", "bodies": ["ground", "rod.start"], "point": [0, 0, 0]}]
HINGED = [{"name": "A", "kind": "revolute", "bodies": ["ground", "rod.start"], "point": [0, 0, 0], "axis": [0, 1, 0]},
          {"name": "B", "kind": "point-on-axis", "bodies": ["ground", "rod.end"], "point": [1, 0, 0], "axis": [1, 0, 0]}]


def load(kind, vector):
    force = {"name": "load", "kind": kind, "body": "rod.end", "vector": vector}
    return [force if kind == "torque" else dict(force, point=[1, 0, 0])]


class Program:
    def __init__(self, options):
        self.options = options

    def call(self, command, model, *arguments):
        folder = self.options.out / "beam"
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "model.json"
        path.write_text(json.dumps(model))
        subprocess.run([str(self.options.gudgeon.resolve()), command, str(path), *arguments, "--quiet", "--out", str(folder)],
                       check=True, timeout=self.options.limit)
        return json.loads((folder / f"{command}.json").read_text())

    def tip(self, elements, stretch, kind, vector):
        """Displacement of the end of the cantilever at rest."""
        bodies = self.call("statics", beam_model(elements, stretch, CLAMPED, load(kind, vector)))["bodies"]
        last = bodies[f"rod.{elements + 1}"]
        e0, e1, e2, e3 = last["orientation"]
        axis = np.array([e0**2 + e1**2 - e2**2 - e3**2, 2 * (e1 * e2 + e0 * e3), 2 * (e1 * e3 - e0 * e2)])
        return np.array(last["position"]) + axis * (1 / elements / 4) - [1, 0, 0]

    def omegas(self, elements, stretch, joints, bending):
        """Frequencies (rad/s) of bending across the height, or of torsion."""
        modes = self.call("modes", beam_model(elements, stretch, joints), "--count", "40")["modes"]
        out = []
        for mode in modes:
            share = np.zeros(4)
            for shape in mode["shape"].values():
                share[:3] += np.square(shape["translation"]["re"]) + np.square(shape["translation"]["im"])
                share[3] += HEIGHT**2 * (shape["rotation"]["re"][0] ** 2 + shape["rotation"]["im"][0] ** 2)
            if mode["kind"] != "neutral" and np.argmax(share) == (2 if bending else 3):
                out.append(mode["omega"])
        return sorted(out)


def errors(program, n, stretch):
    """Relative errors in the order of the columns; NaN where the division has no such mode (or one of shear in its
    place)."""
    def error(values, truths):
        return [values[i] / t - 1 if i < len(values) and values[i] < 5 * t else np.nan for i, t in enumerate(truths)]
    scale = np.sqrt(YOUNG * IY / (DENSITY * AREA))
    clamped = program.omegas(n, stretch, CLAMPED, True)
    result = error(clamped, scale * np.square([1.875104068711961, 4.694091132974175, 7.854757438237613]))
    wave = np.square(np.pi * np.arange(1, 4))
    result += error(program.omegas(n, stretch, HINGED, True), scale * wave / np.sqrt(1 + wave * IY / AREA))  # Rayleigh
    twist = np.pi / 2 * np.sqrt(YOUNG / 2 / (1 + NU) * torsion_constant() / DENSITY / (IY + IZ))
    result += error(program.omegas(n, stretch, CLAMPED, False), [twist])
    small = 1e-4 * YOUNG * IY
    result += error([program.tip(n, stretch, "force", [0, 0, small])[2]], [small / (3 * YOUNG * IY)])
    result += error([program.tip(n, stretch, "torque", [0, -small, 0])[2]], [small / (2 * YOUNG * IY)])
    for alpha in (1, 10):
        along, across = elastica(alpha)
        shift = program.tip(n, stretch, "force", [0, 0, alpha * YOUNG * IY])
        result.append(np.hypot(shift[0] + 1 - along, shift[2] - across))
    bend = 0.75 * np.pi
    shift = program.tip(n, stretch, "torque", [0, -bend * YOUNG * IY, 0])
    result.append(np.hypot(shift[0] + 1 - np.sin(bend) / bend, shift[2] - (1 - np.cos(bend)) / bend))
    return result


HEAD = ["clamped-free 1", "2", "3", "hinged 1", "2", "3", "torsion 1", "tip force", "tip moment", "elastica P L2/EI = 1", "10",
        "rolled by 135 deg"]


def main():
    p = parser(__doc__, "results/beam")
    p.add_argument("--elements", default="1,2,5,10,20", help="numbers of elements")
    options = p.parse_args()
    options.out = pathlib.Path(options.out)
    numbers = [int(n) for n in options.elements.split(",")]
    program = Program(options)
    for stretch in (False, True):
        found = np.array([errors(program, n, stretch) for n in numbers])
        rows = [[n] + ["-" if np.isnan(e) else f"{e:.1e}" for e in row] for n, row in zip(numbers, found)]
        last, before = found[-1], found[-2]
        ratio = np.log(numbers[-1] / numbers[-2])
        with np.errstate(divide="ignore", invalid="ignore"):
            order = np.log(np.abs(before / last)) / ratio
        rows.append(["order"] + [f"{o:.2f}" if abs(e) > 1e-8 else "exact" for o, e in zip(order, last)])
        write_table(options.out / ("stretch" if stretch else "rotations"), ["n"] + HEAD, rows)


if __name__ == "__main__":
    main()
