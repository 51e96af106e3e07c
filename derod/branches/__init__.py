"""The paper's boundary-value problem and its solution branches; shares no code with the discrete
rod.

Three rooms, each using the ones before it: ``half_rod``, ``paths``, ``files``. What is for others
is named here, and imported when it is asked for (kernels take a second to load).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from derod.branches.files.checking import is_branch_file as is_branch_file
    from derod.branches.files.cli import add_branch_parser as add_branch_parser
    from derod.branches.files.cli import add_compare_parser as add_compare_parser
    from derod.branches.files.compare import compare as compare
    from derod.branches.files.export import auto_table as auto_table
    from derod.branches.files.record import BranchFile as BranchFile
    from derod.branches.files.record import open_branches as open_branches
    from derod.branches.files.stored import StoredBranch as StoredBranch
    from derod.branches.files.writing import write_branches as write_branches
    from derod.branches.half_rod.center_line import center_line as center_line
    from derod.branches.half_rod.parameters import Parameters as Parameters
    from derod.branches.paths.compute import compute_branches as compute_branches
    from derod.branches.paths.heavy import HeavyState as HeavyState
    from derod.branches.paths.heavy import heavy_states as heavy_states
    from derod.branches.paths.landing import Landing as Landing
    from derod.branches.paths.landing import LandingError as LandingError

PUBLIC = {
    "BranchFile": "files.record",
    "HeavyState": "paths.heavy",
    "Landing": "paths.landing",
    "LandingError": "paths.landing",
    "Parameters": "half_rod.parameters",
    "StoredBranch": "files.stored",
    "add_branch_parser": "files.cli",
    "add_compare_parser": "files.cli",
    "auto_table": "files.export",
    "center_line": "half_rod.center_line",
    "compare": "files.compare",
    "compute_branches": "paths.compute",
    "heavy_states": "paths.heavy",
    "is_branch_file": "files.checking",
    "open_branches": "files.record",
    "write_branches": "files.writing",
}
"""Names for others, and the module that has them."""


def __getattr__(name: str) -> Any:
    """A public name, from its module."""
    if name in PUBLIC:
        return getattr(import_module(f"derod.branches.{PUBLIC[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
