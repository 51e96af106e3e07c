"""Pushes of other controls, as runs are read, told and resumed."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import derod
import derod.record
from derod import cli
from derod.cli.summary import summary_lines
from tests.scenes import coil

STEPS = [{"control": "end_rotation", "stop": "0.2 pi", "max_step": "0.05 pi"}]


@pytest.fixture(scope="module")
def run() -> derod.record.BaseRun:
    scene = coil(stop='"0.1 pi"').replace({"steps": STEPS})
    return derod.push(scene)


def test_an_increment_tells_what_drove_it(run: derod.record.BaseRun) -> None:
    assert "end-shortening 0.314159 D (0.1 pi)" in repr(run.at("0.1 pi"))
    assert "end rotation 0.628319 rad (0.2 pi)" in repr(run[-1])
    assert run.at("0.1 pi", "end_rotation").end_rotation == pytest.approx(0.1 * math.pi, rel=0.3)
    with pytest.raises(ValueError, match="column = 'x': allowed: end_shortening, end_tension"):
        run.at(1.0, "x")
    assert len(run[-1].modes(2)) == 2


def test_faces_and_info(run: derod.record.BaseRun) -> None:
    assert repr(run).endswith("reached end rotation 0.628319 rad (0.2 pi)>"), repr(run)
    assert "end rotation (rad)" in run._repr_html_()
    assert "then end rotation to 0.628319 rad (0.2 pi)" in repr(run.scene)
    text = "\n".join(summary_lines(run))
    assert "end_rotation    0 rad (0 pi) to 0.628319 rad (0.2 pi)" in text
    landings = text[text.index("landings") :].splitlines()
    assert landings[1].endswith("R, rad") and landings[4].split()[-1] == "0.6283185"


def test_plots_and_exports_of_several_controls(run: derod.record.BaseRun, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from derod.views.export.series import times
    from derod.views.plots.movie import moments
    from derod.views.plots.reading import abscissa

    values, label = abscissa(run)
    assert label == "increment" and values[-1] == len(run) - 1 == times(run)[-1]
    assert moments(run, 20)[-1] == len(run) - 1


def test_a_dead_load(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = derod.Scene(
        coil(stop='"0.1 pi"'),
        push={"control": "end_tension", "start": 4.0, "stop": 5.0, "max_step": 0.25, "at": []},
    )
    file = tmp_path / "load.toml"
    file.write_text(scene.text)
    out = str(tmp_path / "load.h5")
    code = cli.main(["push", str(file)])
    said = capsys.readouterr()
    assert code == 0, said.err
    assert "reached end tension 5 K0/D^2" in said.out and "t = 5 K0/D^2 of 5 K0/D^2" in said.err
    with derod.open_run(out) as run:
        values, label = __import__("derod.views.plots.reading", fromlist=["abscissa"]).abscissa(run)
        assert values[-1] == 5.0 and label == "end tension   (K0/D^2)"
        assert run.at(4.5).end_tension == pytest.approx(4.5, abs=0.2)
        assert run.modes(-1, 1).eigenvalues[0] > 0 and run.modes(-1, 1).shapes[0, -1, 2] != 0
    assert cli.main(["push", "--resume", out, "--stop", "4.5"]) == 2
    error = capsys.readouterr().err
    assert "\nderod: error: --stop = '4.5' = 4.5 K0/D^2 has been passed" in error, error
    assert "at least 5 K0/D^2, where the run is" in error
    assert cli.main(["push", "--resume", out, "--stop", "5.5", "--quiet"]) == 0


def test_what_a_resumed_push_in_steps_may_change(tmp_path: Path) -> None:
    base = coil(stop='"0.1 pi"').replace({"steps": STEPS})
    path = tmp_path / "steps.h5"
    derod.push(base, path).close()

    def again(*steps: dict) -> derod.Scene:
        return base.replace({"steps": [{**STEPS[0], **step} for step in steps]})

    for scene, words in (
        (
            again({"stop": "0.1 pi"}),
            r"steps\[0\].stop = .* has been passed; allowed: at least 0.628",
        ),
        (again({"control": "end_tension", "stop": 5.0}), r"steps\[0\].stop differs in a leg"),
        (
            base.replace({"push.stop": "0.12 pi"}),
            "push.stop differs in a leg|differs in a leg that",
        ),
        (base.replace({"push.start": "0.002 pi"}), "push.start differs from the run"),
        (again({"stop": "0.3 pi", "at": ["0.1 pi"]}), r"steps\[0\].at = .* has been passed"),
    ):
        with pytest.raises(derod.SceneError, match=words):
            derod.push(scene, resume=path)
    on = derod.push(again({"stop": "0.25 pi", "at": ["0.22 pi"]}), resume=path)
    assert on[-1].end_rotation == 0.25 * math.pi and on.at("0.22 pi", "end_rotation").landing
    more = again(
        {"stop": "0.25 pi", "at": ["0.22 pi"]}, {"control": "end_shortening", "stop": 0.35}
    )
    assert derod.push(more, resume=path)[-1].end_shortening == 0.35
