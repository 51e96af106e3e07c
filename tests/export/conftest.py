"""The runs and branches of the pictures' tests."""

from tests.plots.conftest import ax, ax_file, branches, run, run_file

__all__ = ["ax", "ax_file", "branches", "run", "run_file"]
