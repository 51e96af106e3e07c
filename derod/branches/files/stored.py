"""A branch read from a file: its table, its states, and landings on it."""

from __future__ import annotations

import h5py

from derod.branches.half_rod.parameters import Parameters
from derod.branches.half_rod.state import HalfRod
from derod.branches.paths.interval import solved
from derod.branches.paths.landing import Landing, states_at
from derod.branches.paths.tabulated import Tabulated


class StoredBranch(Tabulated):
    """One branch of a file. ``table``: structured array (POINT). ``bifurcations``:
    (BIFURCATION). ``begins``, ``ends``: why; ``remarks``: sign changes that were no zeros."""

    begins: str
    ends: str
    remarks: list[str]

    def __init__(self, name: str, group: h5py.Group, parameters: Parameters) -> None:
        super().__init__(
            name,
            parameters,
            group["table"][:],
            group["bifurcations"][:],
            str(group.attrs["mirror"]),
            group["nodes"][:],
            group["eta"][:],
        )
        self.begins = str(group.attrs["begins"])
        self.ends = str(group.attrs["ends"])
        self.remarks = str(group.attrs["remarks"]).splitlines()

    def at(self, end_shortening: float) -> tuple[Landing, ...]:
        """The branch's states at an end-shortening (D), solved there, on all its sheets.

        In the order of the branch's points; values in D and K0. Raises LandingError where the
        branch has no state there, or one cannot be solved.
        """
        return states_at(self, float(end_shortening))

    def solved(self, i: int) -> HalfRod:
        """The state of point i, solved again from what is stored. Raises NotConverged."""
        return solved(self, range(len(self))[i]).state
