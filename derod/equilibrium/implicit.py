"""Implicit relaxation: Newton's steps along a branch, damped steps downhill (``newton``, ``descending``)."""

from __future__ import annotations

from derod.equilibrium.descending import descend_step
from derod.equilibrium.loop import Report
from derod.equilibrium.newton import follow_step
from derod.equilibrium.steps import ACCEPTED, STRAYED, Rules, new_work
from derod.equilibrium.system import System
from derod.rod.state import State

NOMINAL_KICK = 1e-3  # D, that tells a saddle where no kick is wanted
CURVED_STEPS = 10  # through negative curvature, after which its lowest mode is looked at
SADDLE_STEPS = 30  # of Newton's, to a saddle that shall not be left


class Implicit:
    """Newton's method along a branch, pseudo-transient continuation downhill."""

    most, longest = 100, 4000  # steps along a branch, and in a descent
    limit = most
    easy, hard = 4, 10
    finest = 0.0
    tolerance = 0.0

    def begin(
        self, system: System, state: State, tolerance: float, *, descend: bool, kick: float = 0.0
    ) -> Report:
        """Take the residual of the state; to go downhill, put it onto its constraints first."""
        self.system, self.state, self.kick = system, state, kick
        self.tolerance = tolerance
        self.rules = Rules(tolerance, descend, kick if kick > 0 else NOMINAL_KICK)
        self.shift = 0.0
        self.curved = 0  # steps through negative curvature, in a row
        self.limit = self.longest if descend else self.most
        sound = system.gradient(state) and system.wall_gap(state) > 0
        if sound and descend:
            sound = system.project(state)
        self.work = new_work(state.q, state.b)
        return Report(
            0, *system.excess(state, tolerance), alive=True, sound=sound, descending=descend
        )

    def advance(self) -> Report:
        """Take one step."""
        return self.descend() if self.rules.descend else self.follow()

    def follow(self) -> Report:
        """Take one Newton step."""
        system, state = self.system, self.state
        outcome, state.holonomy, excess, residual = follow_step(
            state.physics, system.mesh, self.rules, state.holonomy,
            system.room, system.factor, state.q, state.b, self.work,
        )  # fmt: skip
        alive, strayed = outcome == ACCEPTED, outcome == STRAYED
        return Report(1, excess, residual, alive=alive, sound=True, strayed=strayed)

    def descend(self) -> Report:
        """Take one step downhill; a saddle is reported or, where no kick is wanted, gone to."""
        system, state = self.system, self.state
        outcome, self.shift, state.holonomy, excess, residual, curved, saddle = descend_step(
            state.physics, system.mesh, self.rules, self.shift,
            state.holonomy, system.room, system.factor, state.q, state.b, self.work,
        )  # fmt: skip
        self.curved = self.curved + 1 if curved else 0
        saddle |= self.curved >= CURVED_STEPS
        if saddle and self.kick == 0:
            self.curved, saddle = 0, False
            reached = self.reach_saddle()
            if reached is not None:
                return reached
        alive = outcome == ACCEPTED
        return Report(1, excess, residual, alive, sound=True, descending=True, saddle=saddle)

    def reach_saddle(self) -> Report | None:
        """Go to a saddle near by with Newton's steps; return None, the state as it was, if there is none."""
        system, state = self.system, self.state
        before, energy = state.copy(), system.energies(state).potential
        self.work = new_work(state.q, state.b)
        for steps in range(1, SADDLE_STEPS):
            report = self.follow()
            if report.excess <= 1 and system.energies(state).potential <= energy:
                return report._replace(iterations=steps, descending=True)
            if report.excess <= 1 or not report.alive:
                break
        state.take(before)
        system.gradient(state)
        return None
