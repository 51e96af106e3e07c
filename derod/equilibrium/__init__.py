"""Relaxation: bring a state to equilibrium. Methods differ only in their step; the loop is one."""

from derod.equilibrium.loop import Outcome, Relaxer, Report, Solution, relax
from derod.equilibrium.methods import make_relaxer

__all__ = ["Outcome", "Relaxer", "Report", "Solution", "make_relaxer", "relax"]
