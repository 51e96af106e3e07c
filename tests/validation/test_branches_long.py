"""l = 20: the loops come and go around delta = 2 j pi (end rotation 0), (2 j - 1) pi (2 pi)."""

import numpy as np
import pytest

from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.compute import compute_branches

pytestmark = pytest.mark.validation


def intervals(rotation, strength):
    own = Parameters(length=20.0, end_rotation=rotation, wall_strength=strength)
    branches, complaints = compute_branches(own, ["3D", "L"])
    assert not complaints
    out = {}
    for branch in branches:
        if branch.name.startswith("L"):
            joints = [b.index for b in branch.bifurcations if b.partner.startswith("3D")]
            out[branch.name] = [branch.points[i].values["end_shortening"] / np.pi for i in joints]
            if len(joints) == 2:
                inside = branch.points[joints[0] + 1 : joints[1]]
                assert {p.unstable_modes for p in inside} == {0}, branch.name
    return out


def test_no_end_rotation_figures():
    found = intervals(0.0, 2e-2)
    assert list(found) == ["L2", "L4", "L6"]
    assert found["L2"] == pytest.approx([1.925381, 2.140649], abs=1e-5)
    assert found["L4"] == pytest.approx([4.022712, 4.174790], abs=1e-5)
    assert found["L6"] == pytest.approx([6.011952], abs=1e-5)


def test_no_end_rotation_text():
    """With v0 = 2e-4 the outer rod runs out (6.05 pi) before L6 is met."""
    found = intervals(0.0, 2e-4)
    assert list(found) == ["L2", "L4"]
    assert found["L4"] == pytest.approx([4.302446, 4.409073], abs=1e-5)


@pytest.mark.parametrize("strength", [2e-4, 2e-2])
def test_full_turn(strength):
    found = intervals(2.0 * np.pi, strength)
    assert list(found) == ["L1", "L3", "L5"]
    for name, joints in found.items():
        odd = int(name[1:])
        assert all(abs(d - odd) < 0.6 for d in joints)
