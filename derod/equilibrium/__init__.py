"""Relaxation: bring a state to equilibrium, measure it, and tell whether it is stable."""
