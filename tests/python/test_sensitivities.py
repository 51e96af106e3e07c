"""Derivatives of runs: in the units of files, by every key of the scene, and where there are none."""

from __future__ import annotations

import numpy as np
import pytest

import derod
from derod.record import BaseRun
from derod.record.sensitivities import QUANTITIES, SensitivityError, slopes
from tests.scenes import coil

STIFF = {"rod.bending": 1.3}


@pytest.fixture(scope="module")
def stiff() -> BaseRun:
    """A rod that is not the unit of stiffness."""
    return derod.push(coil(edges=40, stop='"0.3 pi"', rotation=1.0).replace(STIFF))


def test_pushes_of_other_scenes_show_the_same_slopes(stiff: BaseRun) -> None:
    """dt/dp and dE_hat/dp against whole pushes; the mesh's layer follows f_gamma and K, and is left out."""
    found = stiff.sensitivities(-1)
    for key, name, step in (
        ("rod.twisting", "twisting", 1e-2), ("clamps.end_rotation", "end_rotation", 1e-2),
        ("drop.wall_strength", "wall_strength", 2e-6), ("drop.wall_softness", "wall_softness", 1e-4),
        ("rod.length", "length", 1e-2),
    ):  # fmt: skip
        table, keys = key.split(".")
        value = getattr(getattr(stiff.scene, table), keys)
        ends = [derod.push(stiff.scene.replace({key: value + s * step})).table[-1] for s in (1, -1)]
        row = found[name]
        for column in ("end_tension", "energy_hat", "meniscus_a"):
            slope = (ends[0][column] - ends[1][column]) / (2 * step)
            mine = row["menisci"][0] if column == "meniscus_a" else row[column]
            assert mine == pytest.approx(slope, rel=2e-3, abs=1e-5), (name, column)


def test_the_bending_stiffness_is_the_unit(stiff: BaseRun) -> None:
    """Scaling K, k3 and all forces scales forces and energies and leaves the shape."""
    found = stiff.sensitivities(-1)
    rod, drop = stiff.scene.rod, stiff.scene.drop
    values = {
        "bending": rod.bending, "twisting": rod.twisting,
        "capillary_force": drop.capillary_force, "wall_strength": drop.wall_strength,
    }  # fmt: skip
    for quantity, power in QUANTITIES.items():
        total = sum(value * found[name][quantity] for name, value in values.items())
        wanted = {
            "end_tension": stiff[-1].end_tension, "energy_hat": stiff[-1].energy_hat,
            "twisting_moment": stiff[-1].twisting_moment, "edge_tension": stiff.edge_tension(-1),
            "forces": np.array([stiff[-1].force_a, stiff[-1].force_b]),
        }.get(quantity, 0.0)  # fmt: skip
        scale = max(np.abs(value * found[name][quantity]).max() for name, value in values.items())
        assert np.abs(total - power * np.asarray(wanted)).max() <= 1e-9 * scale


def test_the_end_shortening_is_the_slope_along_the_push(stiff: BaseRun) -> None:
    """dE_hat/ddelta = f_gamma - t, and dt/ddelta between neighbouring rows."""
    found = stiff.sensitivities(-1)["end_shortening"]
    assert found["energy_hat"] == pytest.approx(20.0 - stiff[-1].end_tension, rel=1e-12)
    assert found["end_shortening"] == 1.0
    assert found["positions"][-1] == pytest.approx([0, 0, -1.0])


def test_one_of_everything(stiff: BaseRun) -> None:
    found = stiff[-1].sensitivities()
    count, nodes = len(found.parameters), len(stiff.positions(-1))
    assert found.positions.shape == (count, nodes, 3) and found.menisci.shape == (count, 2)
    assert found.values[found.parameters.index("bending")] == 1.3
    assert found.values[found.parameters.index("capillary_force")] == pytest.approx(20.0)
    assert not found.unbounded.any() and found.eigenvalue == pytest.approx(
        stiff.modes(-1, 1).eigenvalues[0]
    )
    assert "dt/dp" in repr(found)
    with pytest.raises(KeyError, match="'gravity'; allowed: end_shortening, length"):
        found["gravity"]


def test_rows_of_a_push(stiff: BaseRun) -> None:
    names = ("bending", "end_shortening")
    rows = [1, 5, len(stiff) - 1]
    found = slopes(stiff, names, increments=rows)
    assert found.shape == (3, 2)
    for row, i in zip(found, rows, strict=True):
        one = stiff.sensitivities(i)
        assert row == pytest.approx([one[name]["end_tension"] for name in names], rel=1e-12)
    assert slopes(stiff, ["length"], "positions", [2]).shape == (1, 1, 41, 3)
    with pytest.raises(SensitivityError, match="parameter = 'gravity': allowed: end_shortening"):
        slopes(stiff, ["gravity"])
    with pytest.raises(SensitivityError, match="quantity = 'mass': allowed: end_tension"):
        slopes(stiff, names, "mass")


def test_unbounded_near_a_fold() -> None:
    """The planar rod's fold under a dead load: at the maximum of t, and nowhere else."""
    run = derod.push(coil(edges=40, stop='"0.8 pi"', dimension=2))
    tension = run.table["end_tension"]
    assert not run.sensitivities(len(run) // 2).unbounded.any()
    from derod.record.modes import state_of
    from derod.record.sensitivities import sensitivities_at

    top = int(tension.argmax())
    assert 0 < top < len(run) - 1
    near = derod.push(run.scene.replace({"push.stop": float(run.table["end_shortening"][top])}))
    flat = None
    for _ in range(6):  # Newton steps to dt/ddelta = 0
        system, state = state_of(near, -1)
        here = sensitivities_at(system, state, ["end_shortening"], bounds=False)
        slope = float(here.end_tension[0])
        flat = slope if flat is None else flat
        if abs(slope) < 1e-6:
            break
        delta = float(near[-1].end_shortening)
        other = derod.push(near.scene.replace({"push.stop": delta + 1e-4}))
        curve = (slopes(other, ["end_shortening"], increments=[-1])[0, 0] - slope) / 1e-4
        near = derod.push(near.scene.replace({"push.stop": delta - slope / curve}))
    state.physics = state.physics._replace(slides=True, end_tension=float(near[-1].end_tension))
    found = sensitivities_at(system, state)
    loaded = [name != "end_rotation" for name in found.parameters]
    assert abs(found.eigenvalue) < 1e-4 and found.unbounded[loaded].all()


def test_a_weight_turns_a_coil_at_once() -> None:
    """A coil that lies on its side rolls about the axis as soon as the drop has any weight."""
    run = derod.push(coil(edges=40, stop='"0.3 pi"', noise=0.0))
    found = run.sensitivities(-1)
    assert not found.unbounded[found.parameters.index("weight")], "it hangs as it is"
    from derod.record.modes import state_of
    from derod.record.sensitivities import sensitivities_at

    system, state = state_of(run, -1)
    for rows in (state.q[:, :2], state.b[2:4].reshape(1, 2)):
        rows[:] = rows @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    turned = sensitivities_at(system, state)
    assert turned.unbounded[turned.parameters.index("weight")]
    assert np.count_nonzero(turned.unbounded) == 1
