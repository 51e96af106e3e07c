"""PyElastica on our two problems, set up as well as we know how to.

A Cosserat rod: it bends, twists, and, unlike ours, stretches and shears; both are made stiff
(``Settings.stiffness``), which is what limits its time step. Its inertia is fictitious, so that rotation,
shear and stretch allow the same step. What is done for it:

- The clamps lie at the middles of the end elements (one element more than the rod has, half of it
  beyond each clamp): a clamp at a node's end would make every answer of first order.
- The drop's forces are one jitted call, the exact gradient of a C1 energy (``forcing``); the drop itself
  follows the force on it.
- Damping is uniform and analytical; the push rises as a smooth step and holds. Both times, the damping
  and the stiffness are tuned (``python runs/peers.py tune``).
"""

from __future__ import annotations

from typing import NamedTuple

import elastica as ea
import numpy as np

from bench.forcing import drop_forces

MOBILITY = 0.05  # of the drop, D per unit of force and time


class Settings(NamedTuple):
    """What is tuned."""

    elements: int
    rise: float  # time of the push, sqrt(m D^4 / K) with the rod's mass 1 per length D
    hold: float  # time to settle afterwards
    damping: float  # 1/time
    stiffness: float = 1e5  # K/D^2, against stretch and shear: tensions of 20 strain it by 2e-4

    def __str__(self) -> str:
        return (
            f"push {self.rise:g}, hold {self.hold:g}, damping {self.damping:g}, "
            f"stiffness {self.stiffness:.0e}"
        )


COMPILE = Settings(25, 1e-3, 0.0, 1.0)  # a few steps, so that no compilation is timed


class Problem(NamedTuple):
    """A rod of bending stiffness 1, pushed to ``shortening``."""

    length: float
    twisting: float
    shortening: float
    drop: tuple[float, float, float] | None = None  # v0, rho, f_gamma
    kick: float = 1e-3  # D, out of the plane
    planar: bool = False
    courant: float = 0.7  # time step, of h / sqrt(stiffness); the largest that stays stable


class Answer(NamedTuple):
    """What it settled into, and what that took."""

    steps: int
    tension: float  # pull on the end clamp
    energy: float  # E_tot
    height: float  # of the middle, from the clamps' axis
    speed: float  # of the fastest node, at the end


class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):
    """What PyElastica asks its users to put together."""


class Clamps(ea.ConstraintBase):
    """Both end elements held, the last one pushed inward along z by a smooth step."""

    def __init__(self, shortening: float, rise: float, **kwargs) -> None:
        super().__init__(**kwargs)
        self.shortening, self.rise = shortening, rise
        self.place = None

    def constrain_values(self, system, time) -> None:
        """Place the end nodes."""
        x, frames = system.position_collection, system.director_collection
        if self.place is None:
            self.place = x[:, [0, 1, -2, -1]].copy()
            self.frames = frames[..., [0, -1]].copy()
        part = min(time / self.rise, 1.0)
        x[:, [0, 1, -2, -1]] = self.place
        x[2, -2:] -= self.shortening * part * part * (3 - 2 * part)
        frames[..., [0, -1]] = self.frames

    def constrain_rates(self, system, time) -> None:
        """Stop the end nodes."""
        system.velocity_collection[:, [0, 1, -2, -1]] = 0.0
        system.omega_collection[:, [0, -1]] = 0.0


class Droplet:
    """The drop's place, and room for its forces on ``nodes`` nodes."""

    def __init__(self, problem: Problem, h: float, dt: float, nodes: int) -> None:
        self.parameters, self.h, self.dt = problem.drop, h, dt
        self.centre = np.array([0.0, 0.0, 0.5 * problem.length])
        self.distance, self.force, self.pull = np.zeros(nodes), np.zeros((3, nodes)), np.zeros(3)
        self.energies = 0.0, 0.0


class Drop(ea.NoForces):
    """The drop, whose centre drifts with the force on it."""

    def __init__(self, droplet: Droplet) -> None:
        super().__init__()
        self.droplet = droplet

    def apply_forces(self, system, time=0.0) -> None:
        """Add the drop's forces, and move it."""
        own = self.droplet
        place = system.position_collection, own.centre, own.h
        own.energies = drop_forces(*place, *own.parameters, own.distance, own.force, own.pull)[:2]
        system.external_forces += own.force
        own.centre += MOBILITY * own.dt * own.pull


def build(problem: Problem, settings: Settings):
    """Return (simulator, rod, droplet or None, time step)."""
    n = settings.elements
    h = problem.length / n
    simulator = Simulator()
    radius = 0.01
    rod = ea.CosseratRod.straight_rod(
        n + 1,
        start=np.array([0.0, 0.0, -0.5 * h]),
        direction=np.array([0.0, 0.0, 1.0]),
        normal=np.array([1.0, 0.0, 0.0]),
        base_length=problem.length + h,
        base_radius=radius,
        density=1 / (np.pi * radius**2),
        youngs_modulus=1.0,
        shear_modulus=1.0,
    )
    rod.shear_matrix[:] = settings.stiffness * np.eye(3)[:, :, None]
    rod.bend_matrix[:] = np.diag([1.0, 1.0, problem.twisting])[:, :, None]
    inertia = 0.5 * h**2 * h
    rod.mass_second_moment_of_inertia[:] = inertia * np.eye(3)[:, :, None]
    rod.inv_mass_second_moment_of_inertia[:] = np.eye(3)[:, :, None] / inertia
    s = (np.arange(n + 2) - 0.5) * h
    bump = np.exp(-(((s - 0.5 * problem.length) / 0.3) ** 2)) * np.sin(np.pi * s / problem.length)
    rod.position_collection[1, 2:-2] += 10 * problem.kick * bump[2:-2]
    if not problem.planar:
        odd = bump * (s - 0.5 * problem.length)
        rod.position_collection[0, 2:-2] += problem.kick * odd[2:-2]
    simulator.append(rod)
    dt = problem.courant * h / np.sqrt(settings.stiffness)
    simulator.constrain(rod).using(Clamps, shortening=problem.shortening, rise=settings.rise)
    simulator.dampen(rod).using(
        ea.AnalyticalLinearDamper, uniform_damping_constant=settings.damping, time_step=dt
    )
    drop = None
    if problem.drop is not None:
        drop = Droplet(problem, h, dt, n + 2)
        simulator.add_forcing_to(rod).using(Drop, drop)
    simulator.finalize()
    return simulator, rod, drop, dt


def solve(problem: Problem, settings: Settings) -> Answer:
    """Push and settle."""
    simulator, rod, drop, dt = build(problem, settings)
    stepper = ea.PositionVerlet()
    steps = round((settings.rise + settings.hold) / dt)
    time = np.float64(0.0)
    for _ in range(steps):
        time = stepper.step(simulator, time, dt)
    return Answer(steps, *observe(problem, rod, drop))


def observe(problem: Problem, rod, drop) -> tuple[float, float, float, float]:
    """Return (tension, energy, mid-height, speed)."""
    stress = rod.director_collection[..., -2].T @ rod.internal_stress[..., -2]
    energy = rod.compute_bending_energy() + rod.compute_shear_energy()
    if drop is not None:
        energy += sum(drop.energies)
    middle = rod.position_collection[:2]
    height = float(np.sqrt((middle**2).sum(axis=0)).max())
    speed = float(np.abs(rod.velocity_collection).max())
    return float(stress[2]), float(energy), height, speed


def time_per_step(problem: Problem, elements: int, batches: int = 12, steps: int = 400) -> float:
    """Return the best time per step over batches, s."""
    from time import perf_counter

    settings = Settings(elements, 1.0, 0.0, 1.0)
    simulator, _, _, dt = build(problem, settings)
    stepper = ea.PositionVerlet()
    best, time = np.inf, np.float64(0.0)
    for _ in range(batches):
        clock = perf_counter()
        for _ in range(steps):
            time = stepper.step(simulator, time, dt)
        best = min(best, (perf_counter() - clock) / steps)
    return float(best)
