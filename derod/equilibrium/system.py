"""A scene made ready for the kernels: constants, mesh, room to work in, and questions about a state.

Inside, the bending stiffness is 1: forces and energies are divided by the scene's ``rod.bending`` here
and multiplied back when a frame is made.
"""

from __future__ import annotations

import numpy as np

from derod.algebra.bordered import new_factor, solve, solve_refined
from derod.equilibrium import lengths, limits, linear
from derod.equilibrium.energies import Energies, by_part
from derod.rod import assembly, band
from derod.rod.arrays import new_room
from derod.rod.grid import lay_grid
from derod.rod.mesh import mesh_of
from derod.rod.physics import physics_of
from derod.rod.residual import excess
from derod.rod.state import State
from derod.rod.terms.wall import wall_gap
from derod.rod.unknowns import BORDER, F_A
from derod.scene import Scene

PROJECTION = 1.0  # K0/D^4, the shift at which a projection's metric is tried first
PROJECTIONS = 100  # damped steps toward the constraints, at most
DAMPINGS = 10  # halvings of such a step


class System:
    """The discrete rod of one scene."""

    def __init__(self, scene: Scene) -> None:
        unit = scene.rod.bending
        self.scene = scene
        self.bending = unit
        self.dimension = scene.model.dimension
        self.edges = scene.mesh.edges
        self.tolerance = scene.relax.tolerance
        self.physics = physics_of(scene)
        self.mesh = mesh_of(scene)
        self.room = new_room(self.mesh, self.physics)
        matrix = self.room.linear
        rows, stride = matrix.band.shape
        self.factor = new_factor(rows, stride, matrix.border.shape[1])

    @property
    def width(self) -> int:
        """Return w, the unknowns of a row of q."""
        return len(self.physics.row)

    def rest_lengths(self, state: State) -> np.ndarray:
        """Return the rest lengths l_j, (N,), D."""
        lay_grid(self.mesh, self.physics.length, state.b, self.room.kin)
        return self.room.kin.rest[1:-1].copy()

    def arc_length(self, state: State) -> np.ndarray:
        """Return the arc length of the nodes, (N+1,), D."""
        lay_grid(self.mesh, self.physics.length, state.b, self.room.kin)
        return self.measured_arc_length()

    def measured_arc_length(self) -> np.ndarray:
        """Return the arc length of the nodes at the state last measured, (N+1,), D."""
        out = np.zeros(self.edges + 1)
        np.cumsum(self.room.kin.rest[1:-1], out=out[1:])
        return out

    def gradient(self, state: State) -> bool:
        """Fill the room with the residual at the state and follow the holonomy; False if not finite."""
        state.holonomy, sound = assembly.gradient(
            state.physics, self.mesh, state.q, state.b, state.holonomy, self.room
        )
        return bool(sound)

    def end_column(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual's derivative by z_N, (N, w) and like the border; its own row is zero.

        Minus that is the change as the end clamp moves inward. The Hessian must have been filled.
        """
        self.factor.rhs[:] = 0.0
        band.fill_end_column(state.physics, self.room, self.factor.rhs, self.factor.rhs_border)
        column = self.factor.rhs[: self.edges * self.width].reshape(self.edges, self.width).copy()
        column[-1, self.dimension - 1] = 0.0
        return column, self.factor.rhs_border.copy()

    def empty_column(self) -> tuple[np.ndarray, np.ndarray]:
        """Return zeros in the shape of a right side: the rows of nodes 1 ... N, and the border."""
        return np.zeros((self.edges, self.width)), np.zeros_like(self.factor.rhs_border)

    def excess(self, state: State, tolerance: float) -> tuple[float, float]:
        """Return how far the residual last taken is above its tolerance, and its largest force.

        ``state`` is the one it was taken at.
        """
        room = self.room
        return excess(state.physics, room.r, room.rb, room.kin, tolerance)

    def trouble(self, state: State) -> str:
        """Return where a state that is not sound went wrong."""
        for name, rows in (("state", state.q), ("force", self.room.r)):
            bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
            if bad.size:
                return f"the {name} is not a number at node {bad[0]}"
        if not (np.isfinite(state.b).all() and np.isfinite(self.room.rb).all()):
            return "the drop or a meniscus is not a number"
        return "an edge has no length or cannot get its own, or a node is outside the wall"

    def energies(self, state: State) -> Energies:
        """Return the energy's parts at a state."""
        return by_part(
            assembly.measured_energies(
                state.physics, self.mesh, state.q, state.b, state.holonomy, self.room
            )
        )

    def energy_hat(self, state: State) -> float:
        """Return E_hat = E_tot + f_gamma (delta + 1)."""
        shift = state.physics.capillary_force * (state.end_shortening + 1)
        return self.energies(state).total + float(shift)

    def end_tension(self, state: State) -> float:
        """Return t, the axial force on the end clamp, at the state whose gradient was taken last."""
        return float(self.room.r[-1, self.dimension - 1] + state.physics.end_tension)

    def outer_length(self, state: State) -> float:
        """Return the shorter length outside the drop, D; without a drop, the whole rod's."""
        s_a, s_b = state.menisci
        return min(s_a, self.physics.length - s_b) if self.physics.drop else self.physics.length

    def wall_gap(self, state: State) -> float:
        """Return the least 1 + rho - 2 r of the wetted nodes, D."""
        return float(wall_gap(state.physics, self.room.kin, state.q, state.b))

    def linearise(self, state: State, shift: float = 0.0) -> int:
        """Factor the Hessian at a state and return how many unstable modes it has.

        ``shift`` (K0/D^4) raises all eigenvalues on the constraints, in the metric of ``inertia``.
        """
        return int(
            linear.linearise(
                state.physics, self.mesh, state.holonomy, self.room, self.factor, state.q, state.b,
                shift,
            )
        )  # fmt: skip

    def project(self, state: State, shift: float = PROJECTION) -> bool:
        """Move a state onto its constraints by the least energy; return False where that fails.

        Near them at once, from afar by damped steps. ``shift`` (K0/D^4) makes the energy convex, or is raised
        until it does. The gradient there is in the room. On failure the state is where the attempt ended.
        """
        if self.gradient(state) and lengths.is_restored(self.physics, self.room):
            return True
        for _ in range(PROJECTIONS):
            while self.linearise(state, shift) != 0:
                shift *= linear.RAISE
                if shift > linear.LARGEST_SHIFT:
                    return False
            near = state.copy()
            near.holonomy, sound, _ = lengths.restore(
                near.physics, self.mesh, near.holonomy, self.room, self.factor, near.q, near.b
            )
            if sound:
                state.take(near)
                return True
            if not self.step_toward_lengths(state):
                return False
        return False

    def step_toward_lengths(self, state: State) -> bool:
        """Take one damped step toward the constraints, with the factor at hand; False if none helps."""
        d = self.dimension
        if not self.gradient(state):
            return False
        right, border = np.zeros((self.edges, self.width)), np.zeros_like(self.factor.rhs_border)
        right[:, d] = -self.room.r[1:, d]
        border[F_A + d : BORDER + d] = -self.room.rb[F_A + d :]
        step, border_step = self.solve(right, border)
        before, gap = self.violation(), self.wall_gap(state)
        turned = np.linalg.norm(np.diff(step[:, :d], axis=0, prepend=0.0), axis=1)
        fraction = float(min(1.0, limits.MOST_ROTATION / np.max(turned / self.room.kin.rest[1:-1])))
        for _ in range(DAMPINGS):
            moved = state.copy()
            moved.q[1:, : self.width] += fraction * step
            moved.b += fraction * border_step[: state.b.size]
            inside = self.wall_gap(moved) > (1 - limits.MOST_GAP_USED) * gap
            if inside and self.gradient(moved) and self.violation() < (1 - 0.1 * fraction) * before:
                state.take(moved)
                return True
            fraction *= 0.5
        return False

    def violation(self) -> float:
        """Return the sum of the violations of all constraints, D, from the gradient last taken."""
        d = self.dimension
        return float(np.abs(self.room.r[1:, d]).sum() + np.abs(self.room.rb[F_A + d :]).sum())

    def solve(
        self, right: np.ndarray, right_border: np.ndarray, *, refine: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Solve with the Hessian that was factored last, with a step of iterative refinement or without.

        ``right`` has a row for each of the nodes 1 ... N, like the unknowns of ``q[1:]``;
        ``right_border`` one for each border row. Returns the solution in the same shapes.
        """
        own = self.factor.rhs[: right.size]
        self.factor.rhs[:] = 0.0
        own[:] = right.ravel()
        self.factor.rhs_border[:] = right_border
        if refine:
            solve_refined(self.room.linear, self.factor)
        else:
            solve(self.factor, self.factor.rhs, self.factor.rhs_border)
        return own.reshape(right.shape).copy(), self.factor.rhs_border.copy()
