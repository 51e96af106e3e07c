"""Both l = 10 scenes against the bifurcation points found by two other solvers (DESIGN.md)."""

from pathlib import Path

import numpy as np
import pytest

from derod.branches.half_rod.parameters import Parameters
from derod.branches.paths.arc import Control
from derod.branches.paths.catalogue import Catalogue
from derod.branches.paths.compute import compute_branches
from derod.scene import load_scene

pytestmark = pytest.mark.validation
RUNS = Path(__file__).parents[2] / "runs"
FORKS = {
    "paper-text": (0.243045, 2.056822, 2.256610),
    "paper-figures": (0.237782, 1.918325, 2.146372),
}


@pytest.fixture(scope="module", params=FORKS)
def scene(request):
    own = Parameters.from_scene(load_scene(RUNS / f"{request.param}.toml"))
    branches, complaints = compute_branches(own)
    assert not complaints
    return request.param, {branch.name: branch for branch in branches}


def places(branch, kind):
    return [
        branch.points[b.index].values["end_shortening"] / np.pi
        for b in branch.bifurcations
        if b.kind == kind
    ]


def test_pitchforks(scene):
    name, branches = scene
    found = [*places(branches["3D"], "pitchfork"), places(branches["3D-L2"], "pitchfork")[0]]
    assert found == pytest.approx(FORKS[name], abs=1e-6)


def test_folds_of_ax_make_three_sheets(scene):
    _, branches = scene
    folds = places(branches["Ax"], "fold")
    assert len(folds) == 2
    delta = np.array([p.values["end_shortening"] for p in branches["Ax"].points])
    inside = np.pi * 0.5 * sum(folds)
    assert np.count_nonzero((delta[:-1] - inside) * (delta[1:] - inside) < 0) == 3


def test_pt(scene):
    """Fold at 0.13862 pi, plateau t = 18.30 (17.83, DESIGN.md), no pitchfork beyond the fold."""
    name, branches = scene
    pt = branches["Pt"]
    fold = next(b for b in pt.bifurcations if b.kind == "fold")
    at = pt.points[fold.index].values["end_shortening"] / np.pi
    assert at == pytest.approx(0.13862 if name == "paper-text" else 0.13934, abs=1e-5)
    assert not [b for b in pt.bifurcations if b.kind == "pitchfork" and b.index > fold.index]
    tension = np.array([p.values["end_tension"] for p in pt.points[fold.index :]])
    delta = np.array([p.values["end_shortening"] for p in pt.points[fold.index :]])
    plateau = np.interp(1.5 * np.pi, delta, tension)
    assert plateau == pytest.approx(18.30 if name == "paper-text" else 17.83, abs=0.15)


def test_accuracy_of_every_stored_point(scene):
    _, branches = scene
    for branch in branches.values():
        assert max(p.error for p in branch.points) <= 2e-8, branch.name


def test_order_by_energy(scene):
    """The succession Ax-3D-L2-3D has the lowest energy of all paths at every end-shortening."""
    _, branches = scene

    def lowest(names, delta):
        out = []
        for name in names:
            d = np.array([p.values["end_shortening"] for p in branches[name].points])
            e = np.array([p.values["energy_hat"] for p in branches[name].points])
            for i in np.flatnonzero((d[:-1] - delta) * (d[1:] - delta) <= 0):
                x = (delta - d[i]) / (d[i + 1] - d[i])
                out.append((1 - x) * e[i] + x * e[i + 1])
        return min(out, default=np.inf)

    for delta in np.pi * np.linspace(0.3, 2.8, 26):
        others = lowest(["Pt", *(n for n in branches if n.startswith("Tri"))], delta)
        assert lowest(["Ax", "3D", "L2", "3D-L2"], delta) < others


@pytest.mark.parametrize("tolerance", [1e-7, 1e-10])
@pytest.mark.parametrize("step", [0.05, 0.8])
def test_settings_do_not_matter(tolerance, step):
    """The corners of the robustness table of ``runs/branch_figures.py``."""
    catalogue = Catalogue(Parameters(), Control(tolerance=tolerance, largest_step=step))
    path = catalogue.ax()
    forks = [
        s.point.state.end_shortening / np.pi for _, s in path.specials if s.kind == "pitchfork"
    ]
    fold = next(s for _, s in path.specials if s.kind == "fold").point.state.end_shortening / np.pi
    assert forks == pytest.approx([0.2430455, 0.9060533, 0.8082380], abs=1e-6)
    assert fold == pytest.approx(1.3311944, abs=1e-6)


def test_where_the_paths_are_stable(scene):
    """The succession throughout; with v0 = 2e-2 also a space path of higher energy, Tri1."""
    name, branches = scene
    for path in ("3D", "3D-L2"):
        assert {p.unstable_modes for p in branches[path].points[2:-2]} == {0}
    stable = [p.values for p in branches["Tri1"].points if p.unstable_modes == 0]
    if name == "paper-text":
        assert not stable
    else:
        delta = [v["end_shortening"] / np.pi for v in stable]
        assert min(delta) == pytest.approx(1.254, abs=0.03)
        assert max(delta) == pytest.approx(2.752, abs=0.03)
        assert min(v["energy_hat"] for v in stable) > 15.0
