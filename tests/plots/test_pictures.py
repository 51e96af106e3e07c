"""Pictures by what they hold: the artists' numbers against the file's, labels, units, legends."""

from __future__ import annotations

import numpy as np
import pytest

from derod.pushing.frames import Event


def lines(axes, start):
    return [line for line in axes.get_lines() if (line.get_gid() or "").startswith(start)]


def joined(parts):
    """The points of several lines, one after another, neighbours' shared points once: (k, 2)."""
    points = np.concatenate([np.stack(part.get_data(), axis=-1) for part in parts])
    return points[np.append(True, np.any(np.diff(points, axis=0) != 0, axis=1))]


def texts(picture):
    return [text.get_text() for legend in picture.legends for text in legend.get_texts()]


@pytest.mark.parametrize("style", ["light", "dark"])
def test_path_of_a_run(run, style):
    picture = run.plot("path", at="1 , 0.5 pi", style=style)
    table = run.table
    for axes, name in zip(picture.axes, ("end_tension", "energy_hat"), strict=True):
        (line,) = lines(axes, "run 0 stable")
        assert line.get_xdata() == pytest.approx(table["end_shortening"] / np.pi)
        assert line.get_ydata() == pytest.approx(table[name])
        (states,) = lines(axes, "states")
        assert states.get_xdata() == pytest.approx([1 / np.pi, 0.5], abs=0.05 / np.pi)
        assert states.get_ydata() == pytest.approx(table[name][[9, 15]])
        (kick,) = lines(axes, "event instability")
        assert kick.get_xdata() == pytest.approx([1.1 / np.pi])
        low, high = axes.get_ylim()
        assert low <= table[name].min() and table[name].max() <= high
    assert [axes.get_ylabel() for axes in picture.axes] == [
        r"tension  $t$   ($K_0/D^2$)",
        r"energy  $\hat{E}$   ($K_0/D$)",
    ]
    assert "kick off an unstable state" in texts(picture)


def test_unstable_and_sliding_increments_are_dashed(run):
    table = run.table.copy()
    table["unstable_modes"][10:15] = 1
    table["slides"][20:25] = True
    run._table = table
    axes = run.plot().axes[0]
    dashed = lines(axes, "run 0 unstable")
    assert len(dashed) == 2
    assert all(line.get_linestyle() == "--" for line in dashed)
    ends = [(line.get_xdata()[0], line.get_xdata()[-1]) for line in dashed]
    delta = table["end_shortening"] / np.pi
    assert ends == [(delta[9], delta[15]), (delta[19], delta[25])]


def test_snaps_and_turns(run):
    delta = run.table["end_shortening"] / np.pi
    run.event(Event(20, "snap", 2.1, 5.0, 4.0, "over a fold"))
    run.event(Event(25, "turn", 2.5, np.nan, np.nan, "turns"))
    run.event(Event(26, "halving", 2.5, np.nan, np.nan, "halved"))
    axes = run.plot().axes[1]
    assert lines(axes, "event snap")[0].get_xdata() == pytest.approx([delta[20]])
    assert lines(axes, "jump")[0].get_xdata() == pytest.approx(delta[[19, 20]])
    assert lines(axes, "event turn")[0].get_xdata() == pytest.approx([delta[24]])
    assert not lines(axes, "event halving")


def test_path_of_branches_with_a_run(ax, along_ax):
    picture = ax.plot("path", along_ax)
    table, special = ax["Ax"].table, ax["Ax"].bifurcations
    for axes, name in zip(picture.axes, ("end_tension", "energy_hat"), strict=True):
        parts = sorted(lines(axes, "branch Ax"), key=lambda line: axes.get_lines().index(line))
        points = joined(parts)
        assert points[:, 0] == pytest.approx(table["end_shortening"] / np.pi)
        assert points[:, 1] == pytest.approx(table[name])
        (dots,) = lines(axes, "run 0")
        assert dots.get_linestyle() == "None"
        assert dots.get_ydata() == pytest.approx(along_ax.table[name])
        folds = special[special["kind"] == b"fold"]
        assert lines(axes, "specials fold")[0].get_ydata() == pytest.approx(folds[name])
    stable = table["unstable_modes"] == 0
    first = lines(picture.axes[0], "branch Ax stable")[0].get_xdata()
    assert first[-1] == pytest.approx(special["end_shortening"][0] / np.pi)
    assert stable[: len(first) - 1].all() and not stable[len(first)]


def test_pitchforks_are_no_circles_and_drawn_without_their_partner(branches, run):
    from derod.views.plots import plot

    axes = plot("path", [run, branches]).axes[0]
    (joint,) = lines(axes, "specials pitchfork")
    (alone,) = lines(axes, "specials partner missing")
    assert joint.get_xdata() == pytest.approx([0.4])
    assert alone.get_xdata() == pytest.approx([0.7])
    (dots,) = lines(axes, "run 0")
    assert len({joint.get_marker(), dots.get_marker(), "o"}) == 3
    assert joint.get_markerfacecolor() != alone.get_markerfacecolor()
    only = plot("path", [branches], paths=["Ax"]).axes[0]
    assert lines(only, "specials partner missing")[0].get_xdata() == pytest.approx([0.4, 0.7])
    assert not lines(only, "branch 3D")


def test_limits_leave_out_only_what_is_unstable_and_far(branches, run):
    from derod.views.plots.path import limits

    low, high = limits([run], [branches], "end_tension")
    seen = np.concatenate([run.table["end_tension"], branches["3D"].table["end_tension"]])
    assert low <= seen.min() and seen.max() <= high
    branches["Ax"].table["end_tension"][-1] = 1e4  # an unstable state
    assert limits([run], [branches], "end_tension")[1] < 100
    branches["3D"].table["end_tension"][-1] = 1e3  # a stable one
    assert limits([run], [branches], "end_tension")[1] > 1e3


def test_shapes_of_a_run(run):
    picture = run.plot("shapes", at=["0.5 pi", 2.0])
    assert len(picture.axes) == 4
    for axes in picture.axes:
        gids = [patch.get_gid() for patch in axes.patches]
        assert gids.count("drop") == gids.count("wall") == 1 and gids.count("meniscus") == 2
        wall = next(patch for patch in axes.patches if patch.get_gid() == "wall")
        assert wall.get_radius() == pytest.approx(0.55)
        assert axes.collections[0].get_gid() == "tube"
    titles = [axes.get_title() for axes in picture.axes if axes.get_title()]
    row = run.table[15]
    assert rf"= {row['end_shortening']:.4g}$\,D$" in titles[0]
    assert rf"$t = {row['end_tension']:.2f}\,K_0/D^2$" in titles[0]


def test_shapes_of_a_branch_are_solved_there(ax):
    from derod.views.plots.shapes import branch_states

    delta = 0.7 * np.pi
    found = branch_states(ax, [delta], ["Ax"])
    assert len(found) == 3  # Ax has three sheets there
    for shape, landing in zip(found, ax["Ax"].at(delta), strict=True):
        assert shape.end_shortening == pytest.approx(delta, abs=1e-12)
        assert shape.end_tension == landing.values["end_tension"]
        assert shape.positions[-1] == pytest.approx([0, 0, 10 - delta], abs=1e-8)
        at_menisci = [np.interp(shape.menisci, shape.arc_length, x) for x in shape.positions.T]
        radii = np.linalg.norm(np.array(at_menisci).T - shape.drop_center, axis=1)
        assert radii == pytest.approx([0.5, 0.5], abs=1e-3)
    (lowest,) = branch_states(ax, [delta], [])
    assert lowest.energy_hat == min(shape.energy_hat for shape in found)


def test_energies_stack_to_the_total(run):
    picture = run.plot("energies")
    axes = picture.axes[0]
    x, total = lines(axes, "energy_hat")[0].get_data()
    assert x == pytest.approx(run.table["end_shortening"] / np.pi)
    assert total == pytest.approx(run.table["energy_hat"])
    bands = {band.get_gid(): band.get_paths()[0].vertices for band in axes.collections}
    assert list(bands) == ["part bend", "part twist", "part wall", "part capillary"]
    at_the_end = {name: y[np.isclose(y[:, 0], x[-1]), 1] for name, y in bands.items()}
    assert np.ptp(at_the_end["part bend"]) == pytest.approx(run.table["energy_bend"][-1])
    assert at_the_end["part capillary"].max() == pytest.approx(total[-1])


def test_kymograph_holds_curvature_and_tension(run):
    from derod.record.profiles import curvature

    picture = run.plot("kymograph")
    kappa, tension = (axes.collections[0] for axes in picture.axes[:2])
    assert (kappa.get_gid(), tension.get_gid()) == ("curvature", "edge_tension")
    image = np.asarray(kappa.get_array())
    own = curvature(run.positions(20), run.arc_length(20))
    assert image[len(image) // 2, 20] == pytest.approx(own[40], rel=0.02)
    assert set(np.unique(np.asarray(tension.get_array())[[0, 250]])) == {-5.0, 15.0}
    meniscus = lines(picture.axes[0], "meniscus_a")[0]
    assert meniscus.get_ydata() == pytest.approx(run.table["meniscus_a"] - 5)
    assert [axes.get_ylabel() for axes in picture.axes[2:]] == [
        r"curvature  $\kappa$   ($1/D$)",
        r"tension  $\mathbf{n}\cdot\mathbf{d}_3$   ($K_0/D^2$)",
    ]


def test_a_push_that_turns_back_is_drawn_against_increments(run):
    table = run.table.copy()
    table["end_shortening"][20:] = table["end_shortening"][19:9:-1]
    run._table = table
    for kind in ("energies", "kymograph"):
        bottom = run.plot(kind).axes[0 if kind == "energies" else 1]
        assert bottom.get_xlabel().startswith("increment")
        assert bottom.get_xlim()[1] == 29


def test_a_rod_without_a_drop(run):
    import derod
    from tests.scenes import coil

    scene = coil().text
    start, stop = scene.index("[drop]"), scene.index("[clamps]")
    run._scene = derod.parse_scene(
        scene[:start] + scene[stop:].replace("drop = true", "drop = false")
    )
    for frame in run._frames:
        frame.drop_center[:] = np.nan
    assert [c.get_gid() for c in run.plot("energies").axes[0].collections] == [
        "part bend",
        "part twist",
    ]
    shapes = run.plot("shapes", at=[2.0])
    assert not [patch for patch in shapes.axes[0].patches if patch.get_gid() == "drop"]
    high = shapes.axes[0].get_xlim()[1]
    assert high > 0.5 * (10 - 2)  # both clamps are in view
    assert not lines(run.plot("kymograph").axes[0], "meniscus_a")


def test_compare_shows_the_errors_of_every_increment(ax, along_ax):
    from derod.branches.files.compare import compare

    picture = along_ax.plot("compare", ax)
    rows = compare(along_ax, ax)
    assert rows["tension_error"][2] == pytest.approx(0.01, rel=0.02)  # as it was made
    for axes, name in zip(
        picture.axes, ("tension_error", "energy_error", "wetted_error", "shape_error"), strict=True
    ):
        (dots,) = lines(axes, "rows Ax")
        assert dots.get_xdata() == pytest.approx(along_ax.table["end_shortening"] / np.pi)
        assert dots.get_ydata() == pytest.approx(np.maximum(rows[name], 1e-12))
        assert axes.get_yscale() == "log"
    assert lines(picture.axes[0], "tolerance")[0].get_ydata()[0] == 5e-4
    assert lines(picture.axes[3], "tolerance")[0].get_ydata()[0] == 1e-3


def test_rows_on_no_branch_are_crosses(ax, along_ax):
    table = along_ax.table.copy()
    table["end_tension"][1] *= 1.06
    along_ax._table = table
    (cross,) = lines(along_ax.plot("compare", ax).axes[0], "rows ")[1:2]
    assert cross.get_marker() == "x"
    assert cross.get_xdata() == pytest.approx([table["end_shortening"][1] / np.pi])


@pytest.mark.parametrize("kind", ["path", "energies", "kymograph", "compare"])
def test_legends_cover_no_panel(kind, run, ax, along_ax):
    picture = along_ax.plot(kind, ax) if kind == "compare" else run.plot(kind)
    picture.draw_without_rendering()
    for legend in picture.legends:
        box = legend.get_window_extent()
        assert box.x0 >= -1 and box.x1 <= picture.bbox.width + 1
        assert not any(box.overlaps(axes.get_window_extent()) for axes in picture.axes)
