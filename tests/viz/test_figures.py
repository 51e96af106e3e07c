"""Figures by their data: axes, lines, labels."""

from __future__ import annotations

import numpy as np
import pytest

from tests.viz.conftest import VIZ


def lines(axes, start):
    return [line for line in axes.get_lines() if (line.get_gid() or "").startswith(start)]


@pytest.fixture(params=["light", "dark"])
def theme(request):
    from derod.views.plots.style import THEMES

    return THEMES[request.param]


def test_diagram(run, branches, theme):
    import diagram

    made = diagram.figure([run], [branches], theme, marks=True)
    tension, energy = made.axes
    assert tension.get_ylabel() == r"tension  $t$   ($K_0/D^2$)"
    assert energy.get_ylabel() == r"energy  $\hat{E}$   ($K_0/D$)"
    assert energy.get_xlabel() == r"end-shortening  $\delta/\pi$   ($D$)"
    stable, unstable = lines(tension, "branch Ax stable"), lines(tension, "branch Ax unstable")
    assert stable[0].get_linestyle() == "-"
    assert unstable[0].get_linestyle() == "--"
    assert stable[0].get_xdata()[-1] == unstable[0].get_xdata()[0] == pytest.approx(0.4)
    assert lines(energy, "branch Ax unstable")[0].get_ydata()[-1] == pytest.approx(np.pi**2)
    pitchforks = lines(tension, "specials pitchfork")[0]
    assert pitchforks.get_xdata() == pytest.approx([0.4])  # the one without partner is left out
    assert lines(tension, "specials fold")[0].get_ydata() == pytest.approx([6.0])
    points = lines(tension, "run")[0]
    assert points.get_xdata() == pytest.approx(run.table["end_shortening"] / np.pi)
    assert points.get_ydata() == pytest.approx(run.table["end_tension"])
    assert lines(tension, "plateau")[0].get_ydata()[0] == 18
    marks = lines(tension, "mark")
    assert [mark.get_marker() for mark in marks] == ["o", "o"]
    assert marks[0].get_xdata() == pytest.approx([0.5])
    labels = [text.get_text() for text in made.legends[0].get_texts()]
    assert {"3D", r"$Ax$", "pitchfork", "fold", "derod push", "unstable"} <= set(labels)


def test_diagram_of_branches_that_nobody_counted(branches):
    import diagram

    from derod.views.plots.style import LIGHT

    for branch in branches.values():
        branch.table["unstable_modes"] = -1
    axes = diagram.figure([], [branches], LIGHT, ["end_tension"]).axes[0]
    assert lines(axes, "branch Ax planar")[0].get_linestyle() == "--"
    assert lines(axes, "branch 3D space")[0].get_linestyle() == "-"


def test_colours_of_a_theme_differ(theme):
    assert len(set(theme.paths.values())) == len(theme.paths)
    assert len(set(theme.parts)) == len(theme.parts)


def test_shapes(run, branches, theme):
    import shapes

    from derod.views.plots.reading import branch_shape, run_shape

    states = [run_shape(run, 2.0), branch_shape(branches["3D"], 2.0)]
    assert states[0].end_shortening == pytest.approx(2.0)
    assert states[1].name == "3D"
    assert np.diff(states[1].menisci) == pytest.approx([2.0])
    made = shapes.figure(states, theme)
    assert len(made.axes) == 4  # two views each
    for axes in made.axes:
        gids = [patch.get_gid() for patch in axes.patches]
        assert gids.count("drop") == 1
        assert gids.count("meniscus") == 2
        assert axes.collections[0].get_gid() == "tube"
        assert axes.get_aspect() == 1
    titles = [axes.get_title() for axes in made.axes if axes.get_title()]
    assert titles[0].startswith(r"$\delta$ = 0.6366$\,\pi$")
    assert titles[1].startswith("3D:")


def test_the_tube_is_painted_back_to_front(run):
    import shapes

    from derod.views.plots.painter import finer, tube_in_view, turned
    from derod.views.plots.reading import run_shape
    from derod.views.plots.style import LIGHT

    shape = run_shape(run, 2.0)
    eye = turned(0.7)
    assert eye.axes @ eye.axes.T == pytest.approx(np.eye(3))
    assert np.linalg.det(eye.axes) == pytest.approx(1)
    points, s = finer(shape.positions, shape.arc_length)
    assert np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 0.013
    tube = tube_in_view(eye.see(points), s, 0.02)
    assert np.all(tube.normals[:, 2] > -0.05)  # the half that faces the eye
    made = shapes.figure([shape], LIGHT)
    colors = made.axes[0].collections[0].get_facecolor()
    assert np.all((colors >= 0) & (colors <= 1))


def test_clamps_are_drawn_where_the_rod_ends_in_view(run):
    import cover

    from derod.views.plots.style import DARK

    made = cover.figure(run, 3.0, DARK)
    assert "clamp" not in [patch.get_gid() for patch in made.axes[0].patches]
    curve = made.axes[1]
    done, whole = lines(curve, "done")[0], lines(curve, "whole")[0]
    assert len(done.get_xdata()) == len(whole.get_xdata()) == 30
    assert lines(curve, "here")[0].get_xdata() == pytest.approx([3 / np.pi])


def test_energies_add_up(run, theme):
    import energies

    from derod.views.plots.energies import parts

    assert sum(parts(run).values()) == pytest.approx(run.table["energy_hat"])
    axes = energies.figure(run, theme).axes[0]
    assert [c.get_label() for c in axes.collections][:3] == ["bending", "twist", "soft wall"]
    assert lines(axes, "event")[0].get_xdata()[0] == pytest.approx(1.1 / np.pi)


def test_kymograph(run, theme):
    import kymograph

    from derod.views.plots.kymograph import PIXELS, images

    s, kappa, tension = images(run, 3.0)
    assert kappa.shape == tension.shape == (PIXELS, 30)
    assert abs(s).max() == 3.0
    assert tension[s.searchsorted(0), 5] == -5
    assert tension[0, 5] == 15
    made = kymograph.figure(run, theme)
    top = made.axes[0]
    assert top.get_ylabel() == r"arc length from the middle  $s$   ($D$)"
    meniscus = lines(top, "meniscus_b")[0]
    assert meniscus.get_ydata() == pytest.approx(run.table["meniscus_b"] - 5)


def test_error_panels(theme):
    import error

    rows = np.zeros(4, [("end_shortening", "f8"), *((name, "f8") for name in error.PANELS)])
    rows["end_shortening"] = np.pi * np.arange(4)
    rows["tension_error"] = 1e-5
    made = error.figure([("300 edges", rows), ("600 edges", rows)], theme)
    assert len(made.axes) == 3
    first = made.axes[0]
    assert first.get_yscale() == "log"
    assert len(lines(first, "error")) == 2
    assert lines(first, "error")[0].get_ydata() == pytest.approx(np.full(4, 1e-5))
    assert lines(first, "goal")[0].get_ydata()[0] == 5e-4


def test_planar_intervals_and_the_diagram_of_the_longer_rod(run):
    import longer

    from derod.views.plots.reading import planar_intervals
    from derod.views.plots.style import LIGHT

    spans = planar_intervals(run)
    assert spans == [pytest.approx((0.1, 1.0))]
    axes = longer.figure([run, run], LIGHT).axes[0]
    assert lines(axes, "run 0")[0].get_linestyle() == "-"
    assert lines(axes, "run 1")[0].get_linestyle() == "--"
    bars = [patch for patch in axes.patches if patch.get_gid() == "planar 0"]
    assert bars[0].get_x() == pytest.approx(0.1 / np.pi)


def test_stretches_change_at_neutral_points_and_share_them():
    from derod.views.plots.reading import stretches

    assert stretches([True, True, False, False, True]) == [(0, 1, True), (1, 4, False)]
    for at_the_point in (True, False):
        flags = [True, True, at_the_point, False, False]
        assert stretches(flags, [2]) == [(0, 2, True), (2, 4, False)]
    assert stretches([True]) == []


def test_files_are_written_as_vectors_and_pixels(run, tmp_path):
    import energies
    from style import save

    from derod.views.plots.style import LIGHT

    save(energies.figure(run, LIGHT), [tmp_path / "a.pdf", tmp_path / "b" / "a.png"])
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "b" / "a.png").read_bytes().startswith(b"\x89PNG")


def test_figures_are_outputs_like_any_other(run, tmp_path):
    import energies
    from style import save

    from derod.files.outputs import OutputError
    from derod.views.plots.style import LIGHT

    path = tmp_path / "a.png"
    path.write_text("precious")
    with pytest.raises(OutputError, match="exists already"):
        save(energies.figure(run, LIGHT), [path])
    assert path.read_text() == "precious"
    save(energies.figure(run, LIGHT), [path], force=True)
    assert path.read_bytes().startswith(b"\x89PNG") and list(tmp_path.iterdir()) == [path]
    for words in ([str(path), "-o", str(path), "--force"], ["x.h5", "-o", str(path)]):
        with pytest.raises(OutputError):
            energies.main(words)


def test_what_was_interrupted_is_not_taken_for_finished(tmp_path):
    import paper

    from derod.pushing.frames import Ending, Outcome
    from derod.record import RunWriter
    from tests.synthetic import make_frame, small_scene

    path = tmp_path / "run.h5"
    words = ["push", "scene.toml", "--quiet"]
    assert paper.state_of(path) == paper.MISSING
    assert paper.command(path, words) == [*words, "-o", str(path), "--force"]
    for outcome, state in [
        (Outcome.INTERRUPTED, paper.INTERRUPTED),
        (Outcome.RECORD_FAILED, paper.INTERRUPTED),
        (Outcome.COMPLETED, paper.FINISHED),
        (Outcome.NOT_CONVERGED, paper.FINISHED),
    ]:
        writer = RunWriter(path, overwrite=True)
        writer.start(small_scene(), 0)
        writer.frame(make_frame(0, 24))
        writer.finish(Ending(outcome, "", 0.1))
        assert paper.state_of(path) == state
    path.write_text("no run")
    assert paper.state_of(path) == paper.MISSING


def test_every_script_says_what_it_does():
    for script in sorted(VIZ.glob("*.py")):
        head = script.read_text(encoding="utf-8").lstrip().splitlines()[0]
        assert head.startswith('"""'), script.name


def test_paper_knows_what_to_compute(tmp_path):
    import paper

    jobs = paper.jobs(tmp_path)
    assert len(jobs) == 7
    assert all(words[0] in ("push", "branch") for words in jobs.values())
    scenes = {words[1] for words in jobs.values()}
    from pathlib import Path

    assert all(Path(scene).is_file() for scene in scenes)


def test_sketch_names_the_parts(theme):
    import sketch

    import derod

    run = derod.push(derod.Scene("quick", sketch.CHANGES))
    (axes,) = sketch.figure(run, theme).axes
    names = {text.get_text() for text in axes.texts}
    assert {"start clamp", "end clamp", "drop", r"$A$", r"$B$", r"$\delta$", r"$t$"} <= names
    assert len([patch for patch in axes.patches if patch.get_gid() == "meniscus"]) == 2
    assert len([patch for patch in axes.patches if patch.get_gid() == "clamp"]) == 2


def test_the_viewers_bar_is_cut_off():
    from io import BytesIO

    import rerun_picture
    from PIL import Image

    out = BytesIO()
    Image.new("RGB", (1000, 600)).save(out, "PNG")
    cut = Image.open(BytesIO(rerun_picture.without_bar(out.getvalue())))
    assert cut.size == (1000, 600 - round(1000 * rerun_picture.BAR))
