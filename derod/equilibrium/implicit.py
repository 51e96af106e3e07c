"""Implicit relaxation: Newton's steps along a branch, damped steps downhill (``newton``, ``descending``)."""

from __future__ import annotations

from derod.equilibrium.descending import descend_step
from derod.equilibrium.loop import Report
from derod.equilibrium.newton import begin_following, follow
from derod.equilibrium.steps import ACCEPTED, PLAIN, STRAYED, UNSOUND, Rules, Work, new_work
from derod.equilibrium.system import System
from derod.rod.state import State

NOMINAL_KICK = 1e-3  # D, that tells a saddle where no kick is wanted
CURVED_STEPS = 10  # through negative curvature, after which its lowest mode is looked at
SADDLE_STEPS = 30  # of Newton's, to a saddle that shall not be left


class Implicit:
    """Newton's method along a branch, pseudo-transient continuation downhill."""

    most, longest = 100, 4000  # steps along a branch, and in a descent
    limit = most
    easy, hard = 2, 5  # of Newton's steps; chord steps are not counted
    finest = 0.0
    tolerance = 0.0
    stepwise = False
    work: Work | None = None

    def begin(
        self, system: System, state: State, tolerance: float, *, descend: bool, kick: float = 0.0
    ) -> Report:
        """Take the residual of the state; to go downhill, put it onto its constraints first."""
        self.system, self.state, self.kick = system, state, kick
        self.tolerance = tolerance
        self.rules = Rules(tolerance, descend, kick if kick > 0 else NOMINAL_KICK)
        self.shift, self.coming = 0.0, PLAIN
        self.curved = 0  # steps through negative curvature, in a row
        self.limit = self.longest if descend else self.most
        if not descend:
            return self.begin_following()
        sound = system.gradient(state) and system.wall_gap(state) > 0 and system.project(state)
        self.work = new_work(state.q, state.b)
        return Report(0, *system.excess(state, tolerance), alive=True, sound=sound, descending=True)

    def begin_following(self) -> Report:
        """Take the residual of a predicted state, round which steps are trusted."""
        system, state = self.system, self.state
        if self.work is None or self.work.dq.shape != state.q.shape:
            self.work = new_work(state.q, state.b)
        outcome, state.holonomy, excess, residual = begin_following(
            state.physics, system.mesh, self.tolerance, state.holonomy,
            system.room, state.q, state.b, self.work,
        )  # fmt: skip
        return Report(0, excess, residual, alive=True, sound=outcome != UNSOUND)

    def advance(self) -> Report:
        """Take one step, or along a branch all there are where nobody watches."""
        if self.rules.descend:
            return self.descend()
        return self.follow(1 if self.stepwise else self.limit)

    def follow(self, most: int) -> Report:
        """Take at most that many steps along the branch."""
        system, state = self.system, self.state
        outcome, steps, self.coming, state.holonomy, excess, residual = follow(
            state.physics, system.mesh, self.rules, most, self.coming, state.holonomy,
            system.room, system.factor, state.q, state.b, self.work,
        )  # fmt: skip
        alive, strayed = outcome == ACCEPTED, outcome == STRAYED
        return Report(steps, excess, residual, alive=alive, sound=True, strayed=strayed)

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
        self.coming = PLAIN
        self.work = new_work(state.q, state.b)
        for steps in range(1, SADDLE_STEPS):
            report = self.follow(1)
            if report.excess <= 1 and system.energies(state).potential <= energy:
                return report._replace(iterations=steps, descending=True)
            if report.excess <= 1 or not report.alive:
                break
        state.take(before)
        system.gradient(state)
        return None
