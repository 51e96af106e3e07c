"""States of recorded rods, bands of uncertain values, and pictures of sweeps."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import derod
from derod.branches.files.layout import BIFURCATION
from derod.cli import main
from derod.errors import SceneError
from derod.exits import UsageError
from derod.sweeps.files import Sweep
from derod.sweeps.plan import make_plan
from derod.sweeps.running import Means, run_sweep
from derod.sweeps.states import FLAT, IN_SPACE, configuration, words
from derod.sweeps.uncertainty import bands, uncertain_keys
from derod.views.plots.phase import borders, lines, nearest
from tests.scenes import coil

FORCE = "drop.capillary_force"


def turned(positions: np.ndarray, angle: float) -> np.ndarray:
    """The rod turned about the clamp axis, its start clamp put elsewhere."""
    c, s = np.cos(angle), np.sin(angle)
    return positions @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + [0.3, -0.2, 0.1]


def planar(loops: int, count: int = 400) -> np.ndarray:
    """A planar curve whose tangent, along e_z at both ends, turns ``loops`` times."""
    share = np.linspace(0.0, 1.0, count)
    angle = 2.0 * np.pi * loops * share**2 * (3.0 - 2.0 * share) + np.sin(2.0 * np.pi * share)
    steps = np.stack([np.sin(angle), np.zeros(count), np.cos(angle)], axis=1) / count
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


@pytest.mark.parametrize("loops", [0, 1, 2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_loops_of_planar_curves_are_counted_in_any_plane(loops: int, seed: int) -> None:
    angle = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi)
    found = configuration(turned(planar(loops), angle))
    assert found.loops == loops and found.out_of_plane < 1e-9
    assert found.coils >= loops and words(loops).startswith("planar")


def test_a_helix_is_in_space_with_its_turns() -> None:
    """A steep helix of three turns between straight clamps: 3 coils and a little for its ends."""
    angle = np.linspace(0.0, 6.0 * np.pi, 2000)
    pitch = 0.02
    points = np.stack([np.cos(angle), np.sin(angle), pitch * angle], axis=1)
    found = configuration(points)
    assert found.loops == IN_SPACE and found.out_of_plane > FLAT
    per_turn = 1.0 / np.sqrt(1.0 + pitch**2)
    ends = 2.0 * np.arccos(pitch * per_turn) / (2.0 * np.pi)
    assert found.coils == pytest.approx(3.0 * per_turn + ends, abs=2e-3)


def test_a_push_goes_from_the_plane_into_space() -> None:
    run = derod.push(coil(edges=60, stop='"0.4 pi"', at='["0.2 pi"]'))
    states = [configuration(run.positions(i)).loops for i in range(len(run))]
    ends = run["end_shortening"]
    assert {s for s, x in zip(states, ends, strict=True) if x < 0.23 * np.pi} == {0}
    assert {s for s, x in zip(states, ends, strict=True) if x > 0.27 * np.pi} == {IN_SPACE}


@pytest.fixture(scope="module")
def phases(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four forces, to 0.4 pi, every landing kept."""
    path = tmp_path_factory.mktemp("phases") / "s.h5"
    scene = coil(edges=40, stop='"0.4 pi"', at='["0.1 pi", "0.2 pi", "0.3 pi"]')
    plan = make_plan(scene, {FORCE: {"from": 15, "to": 30, "count": 4}}, rows="landings")
    run_sweep(plan, path, Means())
    return path


def test_the_phase_diagram_has_the_states_of_the_rows(phases: Path) -> None:
    sweep = Sweep(phases)
    figure = sweep.plot()
    cells = figure.axes[0].collections[0]
    painted = cells.get_array().reshape(5, 4)
    assert [list(row) for row in painted] == [
        list(sweep.rows["loops"].reshape(4, 5)[:, k]) for k in range(5)
    ]
    assert painted[0, 0] == 0 and painted[-1, -1] == IN_SPACE
    tension = figure.axes[2].collections[0].get_array().reshape(5, 4)
    assert np.array_equal(tension.T, sweep["end_tension"].reshape(4, 5))


class Branches(dict[str, SimpleNamespace]):
    """A branch file, as far as a diagram looks at it: 3D leaves Ax, which has two folds."""

    def __init__(self, force: float) -> None:
        self.path, self.parameters = f"{force:g}.h5", SimpleNamespace(capillary_force=force)
        joint, folds = 8.0 / force, (0.6 + 0.01 * force, 3.0 + 0.1 * force)
        rows = np.zeros(4, BIFURCATION)
        for row, kind, place, partner in zip(
            rows, ("pitchfork", "fold", "fold", "pitchfork"), (joint, *folds, 0.9),
            ("3D", "", "", ""), strict=True,
        ):  # fmt: skip
            row["kind"], row["end_shortening"], row["partner"] = kind, np.pi * place, partner
        back = rows[:1].copy()
        back["partner"] = "Ax"
        table = np.array([(0.1,), (1.0,)], [("end_shortening", "f8")])
        super().__init__(
            {
                "Ax": SimpleNamespace(bifurcations=rows, table=table),
                "3D": SimpleNamespace(bifurcations=back, table=table),
            }
        )


def test_lines_of_branches_pass_through_their_special_points(phases: Path) -> None:
    files = [Branches(force) for force in (30.0, 16.0, 22.0)]
    drawn = dict(lines(files, FORCE, "end_shortening", 0.3))
    joints = [(16.0, 8.0 / 16.0), (22.0, 8.0 / 22.0), (30.0, 8.0 / 30.0)]
    assert np.array(drawn["pitchfork"]) == pytest.approx(np.array([joints[:2], joints[1:]]))
    low = [segment for segment in drawn["fold"] if segment[0, 1] < 2.0]
    assert [list(segment[:, 0]) for segment in low] == [[16.0, 22.0], [22.0, 30.0]]
    assert len(drawn["fold"]) == 2  # the others lie too far apart to be one line
    sweep = Sweep(phases)
    figure = sweep.plot("phase", *files)
    assert {line.get_gid() for line in figure.axes[0].get_lines()} >= {"pitchfork"}
    with pytest.raises(UsageError, match="branches lie over the end-shortening and a key"):
        sweep.plot("phase", *files, keys=["end_tension", "coils"])


def test_cells_lie_about_their_points() -> None:
    assert list(borders(np.array([1.0, 2.0, 4.0]))) == [0.5, 1.5, 3.0, 5.0]
    assert nearest([1.0, 5.0], 2.9) == 1.0


def test_what_cannot_be_drawn_is_named(phases: Path, tmp_path: Path) -> None:
    sweep = Sweep(phases)
    with pytest.raises(UsageError, match="keys = nothing: is no column of numbers"):
        sweep.plot(keys=["nothing", FORCE])
    with pytest.raises(UsageError, match="is a sweep; allowed for path"):
        sweep.plot("path")
    with pytest.raises(UsageError, match=r"is a run file; allowed for phase: one sweep"):
        derod.push(coil(edges=40, stop='"0.02 pi"')).plot("phase")
    with pytest.raises(UsageError, match=r"keys = end_tension: names keys, and no sweep is given"):
        derod.push(coil(edges=40, stop='"0.02 pi"')).plot("path", keys=["end_tension"])


def test_the_command_line_tells_draws_and_exports_a_sweep(
    phases: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["info", str(phases), "--verify"]) == 0
    told = capsys.readouterr().out
    assert "a sweep of 4 points (grid), complete" in told and "fit their checksums" in told
    assert main(["plot", str(phases), "-k", "phase", "-o", str(tmp_path / "p.svg")]) == 0
    assert main(["export", str(phases), "-o", str(tmp_path / "rows.csv")]) == 0
    header, first, *_ = (tmp_path / "rows.csv").read_text().splitlines()
    assert header.startswith("point,drop.capillary_force,increment,end_shortening [D]")
    assert first.startswith("0,15.0,0,") and first.endswith(",completed")
    table = Sweep(phases).to_pandas()
    assert len(table) == 20 and table.attrs["units"]["end_tension"] == "K0 D-2"


def test_the_command_sweeps_lists_failures_and_resumes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "rod.toml").write_text(coil(edges=40, stop='"0.1 pi"').text)
    file, out = tmp_path / "s.toml", tmp_path / "s.h5"
    file.write_text('scene = "rod.toml"\n[keys]\n"rod.length" = [8, 1.05]\n')
    words = ["sweep", str(file), "--workers", "1", "--keep-runs", str(tmp_path / "runs")]
    assert main([*words, "--quiet"]) == 3
    told = capsys.readouterr().err
    assert "1 of 2 points did not complete" in told and "rod.length = 1.05): not allowed" in told
    with derod.open_run(tmp_path / "runs" / "000000.h5") as run:
        assert run.scene.rod.length == 8.0 and len(run) > 3
    assert main(words) == 2 and "exists already; --force replaces it" in capsys.readouterr().err
    assert (
        main(["sweep", "--resume", str(out)]) == 3
        and "no sweep was begun" in capsys.readouterr().err
    )
    assert main(["sweep", str(file), "--workers", "0"]) == 2
    assert main(["sweep", str(tmp_path / "rod.toml")]) == 2
    assert "is a scene (TOML); allowed for SWEEP" in capsys.readouterr().err


def test_a_sweep_from_python_in_memory() -> None:
    scene = coil(edges=40, stop='"0.1 pi"')
    sweep = derod.sweep(scene, {FORCE: [15.0, 30.0]}, workers=1, rows="all")
    tables = [derod.push(scene.replace({FORCE: force})).table for force in (15.0, 30.0)]
    assert len(sweep.rows) == sum(map(len, tables)) and not sweep.failures().size
    assert list(sweep["end_tension"]) == [t for table in tables for t in table["end_tension"]]


@pytest.fixture(scope="module")
def fibre() -> derod.Scene:
    changes = {"mesh.edges": 40, "push.stop": "0.1 pi", "push.max_step": "0.02 pi"}
    scene = derod.Scene("tpu-fibre", changes)
    return scene.replace({"push.at": ["0.05 pi"], "material.diameter": "5.6 +- 0.01 um"})


def test_bands_by_samples_and_by_differences_agree(fibre: derod.Scene) -> None:
    """A small uncertainty is linear: both give du = dt/dd u_d, and samples their gaussian quantiles."""
    samples = derod.sweep(fibre, "uncertain", design="sobol", points=32, rows="landings", workers=1)
    slopes = derod.sweep(fibre, "uncertain", design="differences", rows="landings", workers=1)
    assert uncertain_keys(fibre).keys() == {"material.diameter"}
    drawn, linear = bands(samples), bands(slopes)
    assert len(drawn) == len(linear) == 3 and len(slopes) == 3
    assert drawn["deviation"] == pytest.approx(linear["deviation"], rel=0.1)
    assert drawn["middle"] == pytest.approx(linear["middle"], rel=1e-3)
    width = drawn["high_68"] - drawn["low_68"]
    assert width == pytest.approx(2.0 * linear["deviation"], rel=0.15)
    assert samples.plot("bands").axes[0].get_lines()[0].get_gid() == "middle"
    assert slopes.plot("bands").axes[0].get_title().startswith("3 pushes over material.diam")


def test_a_scene_without_uncertainties_is_named() -> None:
    with pytest.raises(SceneError, match="has no value with an uncertainty"):
        make_plan(coil(), "uncertain", design="differences")
