"""Pictures of the softest modes, of a real push: the artists' numbers against the run's."""

from __future__ import annotations

import numpy as np
import pytest

import derod
from derod.cli import main
from derod.exits import UsageError
from derod.views.plots import plot
from derod.views.plots.options import read_options
from tests.scenes import coil

DIRECTIONS = ("the coil's thinnest direction", "across it", "along the clamps' axis")


@pytest.fixture(scope="module")
def planar():
    """Without noise: unstable from 0.243 pi on."""
    return derod.push(coil(edges=60, noise=0.0, stop='"0.4 pi"', at='["0.2 pi"]'))


def lines(axes, gid):
    return [line for line in axes.get_lines() if line.get_gid() == gid]


def test_modes_shows_every_mode_of_every_state(planar):
    picture = planar.plot("modes", at="0.2 pi, 0.4 pi", modes=2)
    curves = [axes for axes in picture.axes if axes.get_xlabel()]
    assert len(curves) == 4 and len(picture.axes) == 12
    for number, i in enumerate((planar.at("0.2 pi").index, planar.at("0.4 pi").index)):
        found = planar.modes(i, 2)
        for k in range(2):
            axes = curves[2 * number + k]
            parts = np.stack(
                [lines(axes, f"component {name}")[0].get_ydata() for name in DIRECTIONS]
            )
            shape = found.shapes[k]
            assert abs(parts).max() == pytest.approx(1)
            far = np.linalg.norm(shape, axis=1)
            scale = np.linalg.norm(parts, axis=0).max() / far.max()
            assert np.linalg.norm(parts, axis=0) == pytest.approx(scale * far)
            assert parts[2] == pytest.approx(scale * shape[:, 2])
            middle = 0.5 * planar.scene.rod.length
            x = lines(axes, f"component {DIRECTIONS[0]}")[0].get_xdata()
            assert x == pytest.approx(planar.arc_length(i) - middle)
    heads = [text.get_text() for text in picture.texts]
    assert heads[0].endswith(" stable") and heads[1].endswith("1 unstable mode")


def test_the_unstable_mode_of_a_planar_coil_leaves_its_plane(planar):
    axes = next(axes for axes in planar.plot("modes", modes=1).axes if axes.get_xlabel())
    out, across, along = (lines(axes, f"component {name}")[0].get_ydata() for name in DIRECTIONS)
    assert abs(out).max() == pytest.approx(1) and max(abs(across).max(), abs(along).max()) < 1e-3


def test_a_mode_takes_the_rod_to_both_sides(planar):
    picture = planar.plot("modes", modes=1)
    shown = picture.axes[0]
    (one,), (other,) = lines(shown, "moved +1"), lines(shown, "moved -1")
    assert len(one.get_xdata()) == len(other.get_xdata())
    assert not np.allclose(one.get_xydata(), other.get_xydata(), atol=0.02)


def test_eigenvalues_are_those_of_the_run(planar):
    (axes,) = planar.plot("eigenvalues", every=4, modes=2, at="0.2 pi").axes
    increments = [*range(0, len(planar), 4)]
    if increments[-1] != len(planar) - 1:
        increments.append(len(planar) - 1)
    for k in range(2):
        (line,) = lines(axes, f"eigenvalue {k}")
        assert line.get_xdata() == pytest.approx(planar.table["end_shortening"][increments] / np.pi)
        expected = [planar.modes(i, 2).eigenvalues[k] for i in increments]
        assert line.get_ydata() == pytest.approx(expected)
    assert any(patch.get_gid() == "unstable" for patch in axes.patches)
    (states,) = lines(axes, "states")
    assert states.get_ydata() == pytest.approx(
        [planar.modes(planar.at("0.2 pi").index, 1).eigenvalues[0]]
    )
    assert axes.get_ylabel().endswith("($K_0/D^4$)")


def test_a_stable_push_has_no_unstable_half():
    run = derod.push(coil(edges=40, stop='"0.1 pi"', at="[]"))
    (axes,) = run.plot("eigenvalues").axes
    assert not [patch for patch in axes.patches if patch.get_gid() == "unstable"]
    assert axes.get_ylim()[0] == 0


def test_a_rod_without_a_drop_has_modes_too():
    scene = derod.Scene(
        rod={"length": 10, "bending": 1, "twisting": 0.9},
        push={"start": "0.001 pi", "stop": "0.1 pi", "at": []},
        mesh={"edges": 40},
        model={"drop": False},
    )
    picture = derod.push(scene).plot("modes", modes=1)
    assert len(picture.axes) == 3


def test_options_are_checked_by_name(planar):
    with pytest.raises(TypeError, match="plot has no option 'mode'; allowed: at, dpi, every"):
        planar.plot("modes", mode=2)
    with pytest.raises(UsageError, match="modes = 0: allowed: 1, 2, 3"):
        plot("modes", [planar], modes=0)
    shown, sheet = read_options({"at": "1, 2", "dpi": 90, "output": "a.png"})
    assert shown.at == (1.0, 2.0) and shown.every == 1 and shown.modes == 3
    assert sheet.dpi == 90 and str(sheet.output) == "a.png" and not sheet.force


def test_from_the_command_line(tmp_path, capsys):
    file = tmp_path / "coil.h5"
    derod.push(coil(edges=40, stop='"0.1 pi"', at="[]"), str(file)).close()
    assert main(["plot", str(file), "-k", "modes", "--modes", "2"]) == 0
    assert (tmp_path / "coil-modes.png").read_bytes().startswith(b"\x89PNG")
    assert main(["plot", str(file), "-k", "eigenvalues", "--every", "9"]) == 0
    capsys.readouterr()
    assert main(["plot", str(file), "-k", "modes", "--modes", "0", "--force"]) == 2
    assert "--modes = 0: allowed: 1, 2, 3" in capsys.readouterr().err
    assert main(["plot", str(file), "-k", "modes", "--modes", "9999", "--force"]) == 2
    assert "k = 9999: allowed: 1 to" in capsys.readouterr().err
