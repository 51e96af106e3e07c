"""Other rods and drops: everything is found with nothing tuned to them."""

import numpy as np
import pytest

from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.compute import compute_branches

pytestmark = pytest.mark.validation


@pytest.mark.parametrize(
    ("force", "length", "twisting", "softness", "strength"),
    [
        (15.0, 8.0, 0.7, 0.05, 2e-4),
        (15.0, 12.0, 1.0, 0.2, 2e-2),
        (25.0, 8.0, 1.0, 0.1, 2e-2),
        (25.0, 11.0, 0.75, 0.07, 5e-4),
        (30.0, 12.0, 0.7, 0.2, 2e-2),
    ],
)
def test_all_paths_are_found(force, length, twisting, softness, strength):
    own = Parameters(length, twisting, force, strength, softness)
    branches, complaints = compute_branches(own, count_modes=False)
    assert not complaints
    by_name = {branch.name: branch for branch in branches}
    assert {"Ax", "3D", "L2", "3D-L2", "Pt", "Tri1"} <= set(by_name)
    assert [b.partner for b in by_name["3D"].bifurcations][-1] == "L2"
    for name in ("3D", "L2", "3D-L2", "Pt"):
        assert max(p.error for p in by_name[name].points) <= 1e-8, name
    assert np.nanmax([p.error for p in by_name["Ax"].points]) <= 1e-5


def test_other_end_rotations_have_a_space_path():
    """R = 1: no plane to meet, one space path from the twisted straight rod."""
    branches, complaints = compute_branches(Parameters(end_rotation=1.0), ["3D"])
    assert not complaints
    assert [b.name for b in branches] == ["3D"]
    assert branches[0].ends == "the outer rod ran out"
    assert {p.unstable_modes for p in branches[0].points[:20]} == {0}
