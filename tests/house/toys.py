"""A toy term, control, column and view, added through the public lists as CONTRIBUTING.md says.

Run with NUMBA_DISABLE_JIT=1 in a folder of its own; prints what was seen as JSON.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

TERM = '''
"""A spring that holds the drop's centre to the clamp axis: S (x_C^2 + y_C^2) / 2."""

from derod.algebra.jit import inlined
from derod.rod.unknowns import X_C


@inlined
def energy(physics, kin, q, b, psi):
    """Return its energy, K/D."""
    total = 0.0
    for k in range(len(physics.axis) - 1):
        total += 0.5 * physics.spring * b[X_C + k] ** 2
    return total


@inlined
def add_gradient(physics, kin, q, b, psi, tension, grad):
    """Add the force on the drop's centre."""
    for k in range(len(physics.axis) - 1):
        grad.border[X_C + k] += physics.spring * b[X_C + k]


@inlined
def add_hessian(physics, kin, q, b, psi, tension, hess):
    """Add the spring's stiffness."""
    for k in range(len(physics.axis) - 1):
        hess.border[X_C + k, X_C + k] += physics.spring
'''
CONTROL = '''
"""The spring's stiffness S as what pushes. Its conjugate is (x_C^2 + y_C^2) / 2."""

from derod.equilibrium.control import Constant
from derod.rod.unknowns import X_C


class Spring(Constant):
    """A stiffer spring."""

    name = "spring"
    symbol = "S"
    unit = "K0 D-3"
    power = 1
    conjugate_symbol = "x_C^2/2"

    def conjugate(self, here):
        """Return half the squared distance of the drop from the axis."""
        return here.energies.parts["spring"] / here.state.physics.spring

    def column(self, system, state):
        """Return minus the spring's force over S."""
        column, border = system.empty_column()
        d = system.dimension
        border[X_C : X_C + d - 1] = -state.b[X_C : X_C + d - 1]
        return column, border
'''
VIEW = '''
"""The drop's tilt against what pushes."""


def draw(figure, runs, branches, theme, options):
    """One panel."""
    axes = figure.subplots()
    axes.plot(runs[0].table["spring"], runs[0].table["drop_tilt"], gid="tilt")
    axes.set_xlabel("S")
    axes.set_ylabel("tilt, rad")
'''


def main(folder: Path) -> None:
    for name, text in (("toy_term", TERM), ("toy_control", CONTROL), ("toy_view", VIEW)):
        (folder / f"{name}.py").write_text(text)
    sys.path.insert(0, str(folder))

    # a term: one file, and one entry in the list
    from derod.rod.terms import writing
    from derod.rod.terms.term import Term

    spring = Term("toy_term", part="spring", needs="drop", constants={"spring": lambda scene: 2.0})
    writing.add(spring, folder)

    # a control: one file, one line, and its key in the scene
    from toy_control import Spring

    from derod.pushing.controls import CONTROLS
    from derod.scene.controls import HELD, Held

    CONTROLS["spring"] = Spring()
    HELD["spring"] = Held("drop", "spring", lambda x: x > 0, "a number above 0", lambda scene: 0.5)

    # a column: one line
    import numpy as np

    from derod.pushing.columns import COLUMNS, Column

    COLUMNS.append(
        Column("drop_tilt", lambda here, _: np.arctan2(*here.state.drop_center[:2][::-1]), "rad")
    )

    # a view: one file, one line
    from derod.views.plots.kinds import KINDS, Kind

    KINDS["tilt"] = Kind("toy_view", "the drop's tilt", (1, 1), (0, 0), "one run file")

    print(json.dumps(look(folder)))


def look(folder: Path) -> dict[str, object]:
    """What the toys did to a push, its derivatives, its file and its picture."""
    import h5py
    import numpy as np

    import derod
    from derod.equilibrium.system import System
    from derod.pushing.guess import bent_guess
    from derod.rod.unknowns import X_C
    from tests.scenes import coil

    scene = coil(edges=20, stop="0.1", dimension=2).replace({"noise.amplitude": 0})
    system = System(scene)
    state = bent_guess(system, system.physics, 0.1)
    state.b[X_C] += 0.2
    system.gradient(state)
    energies, residual = system.energies(state), system.room.rb.copy()
    system.linearise(state)
    corner = float(system.room.linear.corner[X_C, X_C])
    h, sides = 1e-5, []
    for step in (h, -h):
        moved = state.copy()
        moved.b[X_C] += step
        system.gradient(moved)
        sides.append((system.energies(moved).potential, system.room.rb[X_C], moved))
    fixed = 0.0  # the constraints' share of the Lagrangian's derivative: f_A, f_B
    for node, force in (
        (system.room.kin.node_a, state.forces[0]),
        (system.room.kin.node_b, state.forces[1]),
    ):
        fixed -= 2 * force * (state.q[node, 0] - state.b[X_C])
    run = derod.push(
        scene.replace(
            {
                "push.control": "spring",
                "clamps.end_shortening": 0.06,
                "push.start": 2.0,
                "push.stop": 4.0,
                "push.at": [],
                "push.max_step": 0.5,
            }
        ),
        folder / "toy.h5",
    )
    table = run.table
    picture = run.plot("tilt", output=folder / "tilt.png")
    with h5py.File(folder / "toy.h5") as file:
        stored = file["observables/push/value"]
        units = {
            name: stored.attrs[f"unit {name}"].decode()
            for name in ("spring", "drop_tilt", "energy_spring")
        }
    conjugate = table["energy_spring"] / table["spring"]
    work = np.sum(0.5 * (conjugate[1:] + conjugate[:-1]) * np.diff(table["spring"]))
    return {
        "energy": energies.parts["spring"],
        "expected": float(0.5 * 2.0 * state.b[X_C] ** 2),
        "merit": energies.potential - sum(v for k, v in energies.parts.items() if k != "spring"),
        "gradient": float(residual[X_C]) - fixed,
        "gradient_differences": (sides[0][0] - sides[1][0]) / (2 * h),
        "hessian": corner,
        "hessian_differences": float((sides[0][1] - sides[1][1]) / (2 * h)),
        "outcome": str(run.outcome),
        "springs": [float(table["spring"][0]), float(table["spring"][-1])],
        "gained": float(table["energy_total"][-1] - table["energy_total"][0]),
        "work": float(work),
        "tilts": float(np.abs(np.abs(table["drop_tilt"]) - np.pi / 2).max()),
        "units": units,
        "labels": [axes.get_ylabel() for axes in picture.axes],
        "picture": (folder / "tilt.png").stat().st_size,
    }


if __name__ == "__main__":
    main(Path(sys.argv[1]))
