"""The command: exit codes, messages, and what it imports."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

from derod import cli, open_run
from derod.pushing.frames import Outcome
from tests.scenes import coil

SCENE = coil(stop='"0.05 pi"', at='["0.02 pi"]').text
LIGHT = {"numba", "h5py", "rerun", "numpy", "scipy", "matplotlib", "tqdm"}
Captured = pytest.CaptureFixture[str]


@pytest.fixture
def scene(tmp_path: Path) -> str:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return str(path)


@pytest.fixture
def out(tmp_path: Path) -> str:
    return str(tmp_path / "run.h5")


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\nfrom derod.cli import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit as end:\n    assert not end.code\n"
        f"print(sorted({LIGHT!r} & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and done.stderr.strip() == "[]"
    for command in ("push", "check", "info"):
        assert f"    {command}" in done.stdout


def test_a_push_that_gets_there(scene: str, out: str, capsys: Captured) -> None:
    assert cli.main(["push", scene, "-o", out]) == 0
    said = capsys.readouterr()
    assert "completed: reached end-shortening" in said.out and out in said.out
    assert " of 0.1571 D (0.05 pi)  t = " in said.err
    assert "reached end-shortening 0.15708 D (0.05 pi)" in said.out
    assert said.out.endswith(f"next: derod info {out}, derod plot {out}, derod view {out}\n")
    with open_run(out) as run:
        assert run.outcome is Outcome.COMPLETED
        assert run.table["end_shortening"][-1] == 0.05 * math.pi
    assert cli.main(["push", "--resume", out, "--stop", "0.06 pi", "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")
    with open_run(out) as run:
        assert run.table["end_shortening"][-1] == 0.06 * math.pi
    assert cli.main(["push", "--resume", out, "--stop", "0.03 pi"]) == 2
    error = capsys.readouterr().err
    assert "\nderod: error: --stop = '0.03 pi' = 0.0942478 D (0.03 pi) has been passed" in error, (
        error
    )
    assert "at least 0.188496 D (0.06 pi)" in error


def test_what_the_command_line_changes(scene: str, out: str) -> None:
    changes = ["--edges", "48", "--stop", "0.03 pi, 0.02 pi", "--method", "fire", "--quiet"]
    args = cli.build_parser().parse_args(["push", scene, "-o", out, *changes])
    from derod.cli.commands import _scene_to_push

    changed = _scene_to_push(args)
    assert changed.mesh.edges == 48 and changed.relax.method == "fire"
    assert changed.push.stop == (0.03 * math.pi, 0.02 * math.pi)
    assert (
        cli.main(["push", scene, "-o", out, "--edges", "48", "--stop", "0.01 pi", "--quiet"]) == 0
    )
    with open_run(out) as run:
        assert run.scene.mesh.edges == 48 and run.positions(-1).shape == (49, 3)
        assert run.table["end_shortening"][-1] == 0.01 * math.pi


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (["--edges", "3"], "--edges = 3 is out of range"),
        (["--method", "newton"], "--method = 'newton' is no"),
        (["--stop", "3 pi"], "--stop = '3 pi' = 9.42478 D (3 pi) is a push past"),
        (["--stop", "nonsense"], "--stop = 'nonsense' is not understood"),
        (["--stop", "0.03 pi,"], "--stop = '0.03 pi, ': part 2, '', is not understood"),
        (["--stop", "1, 1"], "--stop = '1, 1': part 2, '1', = 1 D (0.31831 pi) does not move"),
    ],
)
def test_changes_that_are_wrong(
    scene: str, out: str, change: list[str], words: str, capsys: Captured
) -> None:
    assert cli.main(["push", scene, "-o", out, *change]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"derod: error: {words}") and "; allowed: " in error
    assert scene not in error, "the command line is to blame"
    assert error.count("\n") == 1 and not Path(out).exists()


def test_a_bad_scene(tmp_path: Path, out: str, capsys: Captured) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text(SCENE.replace("wall_softness", "wall_softnes"))
    for command in (["check", str(bad)], ["push", str(bad), "-o", out]):
        assert cli.main(command) == 2
        error = capsys.readouterr().err
        assert (
            error.startswith(f"derod: error: {bad}: drop.wall_softnes is unknown")
            and "did you mean" in error
        )
    assert not Path(out).exists()


def test_files_that_are_not_there(scene: str, tmp_path: Path, out: str, capsys: Captured) -> None:
    none = str(tmp_path / "none")
    for command in (
        ["check", none],
        ["info", none],
        ["push", none, "-o", out],
        ["push", "--resume", none],
        ["info", scene],
    ):
        assert cli.main(command) == 2, command
        error = capsys.readouterr().err
        assert (
            error.startswith("derod: error: ") and command[-1 if command[-1] != out else 1] in error
        )


def test_arguments_that_make_no_sense(scene: str, out: str, capsys: Captured) -> None:
    for command in (
        ["push"],
        ["push", scene, "--resume", out],
        ["push", "--resume", out, "--edges", "50"],
        ["push", "--resume", out, "--force"],
    ):
        assert cli.main(command) == 2, command
        assert capsys.readouterr().err.startswith("derod: error: ")
    for command in (["nonsense"], ["push", scene, "-o", out, "--edges", "many"]):
        with pytest.raises(SystemExit) as end:
            cli.main(command)
        assert end.value.code == 2
        assert "\nderod: error: " in capsys.readouterr().err


def test_derod_alone_prints_help(capsys: Captured) -> None:
    assert cli.main([]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("usage: derod") and not said.err
    done = subprocess.run([sys.executable, "-m", "derod"], capture_output=True, text=True)
    assert (done.returncode, done.stdout[:12], done.stderr) == (0, "usage: derod", "")


def test_an_existing_file_is_kept(scene: str, out: str, capsys: Captured) -> None:
    Path(out).write_text("precious")
    assert cli.main(["push", scene, "-o", out]) == 2
    assert "--force" in capsys.readouterr().err and Path(out).read_text() == "precious"
    assert cli.main(["push", scene, "-o", out, "--force", "--quiet", "--stop", "0.01 pi"]) == 0
    with open_run(out) as run:
        assert run.outcome is Outcome.COMPLETED


def test_a_rod_that_runs_out(tmp_path: Path, out: str, capsys: Captured) -> None:
    short = tmp_path / "short.toml"
    short.write_text(
        coil(stop="0.25", noise=0.0).replace({"rod.length": 1.2, "push.max_step": 0.02}).text
    )
    assert cli.main(["push", str(short), "-o", out, "--quiet"]) == 3
    assert "rod ran out: the outer rod ran out at 0." in capsys.readouterr().err
    with open_run(out) as run:
        assert run.outcome is Outcome.ROD_RAN_OUT and len(run) > 3


def test_a_file_that_cannot_be_written(scene: str, capsys: Captured) -> None:
    assert cli.main(["push", scene, "-o", f"{scene}/run.h5", "--quiet"]) == 3
    assert "cannot be written" in capsys.readouterr().err


def test_check(scene: str, capsys: Captured) -> None:
    assert cli.main(["check", scene]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{scene}: a scene that can be pushed"
    values = {line[2:20].strip(): float(line[20:34]) for line in lines[1:]}
    assert values["l"] == 10 and values["k3/K"] == 0.9 and values["f_gamma D^2/K"] == 20
    assert values["L_EC/D"] == pytest.approx(0.2236068, rel=1e-5)
    assert values["delta_max/pi"] == 0.05


def test_info(scene: str, out: str, capsys: Captured) -> None:
    assert cli.main(["push", scene, "-o", out, "--quiet"]) == 0
    assert cli.main(["info", out]) == 0
    text = capsys.readouterr().out
    with open_run(out) as run:
        assert text.startswith(f"{out}: {len(run)} increments, completed: reached")
        landed = run.table[run.table["landing"]]
    head = text.index("landings")
    rows = [line.split() for line in text[head:].splitlines()[2 : 2 + len(landed)]]
    assert [float(row[2]) for row in rows] == [0.001, 0.02, 0.05]
    assert [float(row[1]) for row in rows] == [0.00314, 0.06283, 0.15708]
    assert float(rows[-1][3]) == pytest.approx(landed["end_tension"][-1], abs=1e-5)
    for words in ("l = 10", "60 edges, implicit", "seed 1", "events", "worst residual"):
        assert words in text
    assert "from end-shortening 0.00314159 D (0.001 pi): end-shortening to 0.15708 D (0.05" in text


def test_the_tolerance_that_info_tells_is_the_kernels(out: str, capsys: Captured) -> None:
    """Worst ratio of a residual to what it is held to: by the kernel, and between info's two ends."""
    from derod import push
    from derod.cli.summary import EPS, ROUNDING
    from derod.equilibrium.system import System
    from derod.pushing.encode import decode

    scene = coil(stop='"0.05 pi"')
    run = push(scene)
    system = System(scene)
    state = decode(system, run.frame_at(-1), slides=False)
    assert system.gradient(state)
    lengths = system.rest_lengths(state)
    outer = min(lengths[:5].min(), lengths[-5:].min())  # no wall there
    node = 2
    h = min(lengths[node - 1], lengths[node])
    allowed = scene.relax.tolerance + EPS * scene.rod.length * ROUNDING / h**3
    room = system.room
    before, _ = system.excess(state, scene.relax.tolerance)
    room.r[node, 0] = 10 * allowed
    ratio, force = system.excess(state, scene.relax.tolerance)
    assert before < 1 and ratio == pytest.approx(10.0) and force == 10 * allowed and outer > 0
