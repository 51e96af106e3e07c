"""Relaxation: bring a state to equilibrium. Methods differ only in their step; the loop is one."""

from derod.relax.loop import Outcome, Relaxer, Report, Solution, relax
from derod.relax.methods import make_relaxer

__all__ = ["Outcome", "Relaxer", "Report", "Solution", "make_relaxer", "relax"]
