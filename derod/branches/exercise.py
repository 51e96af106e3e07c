"""A path that calls all kernels of the branches: for compiling before it is needed."""

from __future__ import annotations


def trace_a_path() -> None:
    """Trace the planar path of the paper's rod in long steps, and count its unstable modes."""
    from derod.branches.half_rod.parameters import Parameters
    from derod.branches.paths.arc import Control
    from derod.branches.paths.compute import compute_branches

    control = Control(tolerance=1e-8, largest_step=1.0, accuracy=1e-3)
    compute_branches(Parameters(), ["Ax"], control)
