"""What is written and what is refused: the command line, the files, the movie."""

from __future__ import annotations

import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest

from derod.cli import main
from derod.exits import UsageError


def test_default_name_beside_the_file_and_no_overwriting(run_file, capsys):
    made = run_file.with_name("coil-energies.png")
    assert main(["plot", str(run_file), "--kind", "energies", "--dpi", "60"]) == 0
    assert capsys.readouterr().out.strip() == str(made)
    from PIL import Image

    with Image.open(made) as image:
        assert image.size == (420, 276)  # 7 x 4.6 inches
        assert len(image.convert("RGB").getcolors(100000)) > 20
    before = made.read_bytes()
    assert main(["plot", str(run_file), "--kind", "kymograph", "-o", str(made)]) == 2
    assert "exists already; --force replaces it" in capsys.readouterr().err
    assert made.read_bytes() == before
    assert main(["plot", str(run_file), "-k", "path", "-o", str(made), "--force"]) == 0
    assert made.read_bytes() != before
    assert sorted(path.name for path in run_file.parent.iterdir()) == [
        "coil-energies.png",
        "coil.h5",
    ]


@pytest.mark.parametrize(
    ("ending", "head"), [("pdf", b"%PDF"), ("svg", b"<?xml"), ("png", b"\x89PNG")]
)
def test_endings(run, tmp_path, ending, head):
    out = tmp_path / f"a.{ending}"
    run.plot("energies", output=out)
    assert out.read_bytes().startswith(head)
    again = tmp_path / f"b.{ending}"
    run.plot("energies", output=again)
    assert out.read_bytes() == again.read_bytes()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["plot", "RUN", "-k", "nothing"], "--kind = nothing: allowed: path, shapes"),
        (["plot", "RUN", "-o", "DIR/a.jpg"], "DIR/a.jpg: allowed: a name that ends in .png"),
        (["plot", "RUN", "-o", "DIR/no/a.png"], "no such folder"),
        (["plot", "RUN", "--at", "0.6x"], "--at = '0.6x': is not understood as a number"),
        (["plot", "RUN", "--at", "4 pi"], "RUN: --at = 12.5664 D (4 pi): has no state there"),
        (["plot", "RUN", "--paths", "Ax"], "no branch file is given"),
        (["plot", "AX", "--paths", "Q"], "AX: --paths = Q: is not in it; allowed: Ax"),
        (["plot", "AX", "-k", "energies"], "AX: is a branch file; allowed for energies: one run"),
        (["plot", "RUN", "-k", "compare"], "compare: a branch file (derod branch) is missing"),
        (["plot", "RUN", "RUN", "-k", "kymograph"], "RUN: is a run file too many"),
        (["plot", "RUN", "--every", "0"], "--every = 0: allowed: 1, 2"),
        (["plot", "RUN", "--style", "blue"], "--style = 'blue': allowed: light, dark"),
        (["plot", "DIR/none.h5"], "none.h5: there is no such file"),
        (["movie", "AX"], "AX: is a branch file"),
        (["movie", "RUN", "-o", "DIR/a.avi"], "allowed: a name that ends in .gif or .mp4"),
        (["movie", "RUN", "--frames", "1"], "--frames = 1: allowed: 2 to"),
    ],
)
def test_refusals(words, said, run_file, ax_file, capsys):
    names = {"RUN": str(run_file), "AX": str(ax_file), "DIR": str(run_file.parent)}

    def filled(text):
        for key, value in names.items():
            text = text.replace(key, value)
        return text

    before = sorted(run_file.parent.iterdir())
    assert main([filled(word) for word in words]) == 2
    error = capsys.readouterr().err
    assert error.startswith("derod: error: ") and error.count("\n") == 1
    assert filled(said) in error
    assert sorted(run_file.parent.iterdir()) == before


def test_a_notebook_gets_a_picture_and_settings_stay(run):
    before = dict(mpl.rcParams)
    picture = run.plot("energies")
    assert picture._repr_png_().startswith(b"\x89PNG")
    assert dict(mpl.rcParams) == before


def test_show_opens_the_picture_that_was_drawn(run, monkeypatch):
    import matplotlib.pyplot as plt

    from derod.views.plots import picture

    shown = []
    monkeypatch.setattr(picture, "NO_WINDOWS", set())
    monkeypatch.setattr(plt, "show", lambda: shown.append(plt.gcf()))
    made = run.plot("energies", show=True)
    assert shown == [made]
    plt.close(made)


def test_show_without_a_screen_is_refused(run):
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    with pytest.raises(UsageError, match="opens no windows"):
        run.plot("energies", show=True)


def test_without_matplotlib_the_package_is_named(run_file):
    code = (
        "import sys\nsys.modules['matplotlib'] = None\n"
        "import importlib.util as u\nfind = u.find_spec\n"
        "u.find_spec = lambda name, *a: None if name == 'matplotlib' else find(name, *a)\n"
        f"from derod.cli import main\nsys.exit(main(['plot', {str(run_file)!r}]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert "matplotlib, which is not installed: pip install matplotlib" in done.stderr


def test_drawing_needs_neither_rerun_nor_compiled_kernels(run_file):
    code = (
        f"import sys\nfrom derod.cli import main\nmain(['plot', {str(run_file)!r}, '-k', 'energies'])\n"
        "print(sorted({'rerun', 'pyarrow', 'numba'} & set(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and done.stderr.strip() == "[]"


def test_movie(run_file, capsys):
    from PIL import Image

    words = ["movie", str(run_file), "--frames", "5", "--width", "320", "--quiet"]
    assert main(words) == 0
    made = run_file.with_name("coil-movie.gif")
    assert capsys.readouterr().out.strip() == str(made)
    with Image.open(made) as image:
        assert (image.n_frames, image.size, image.info["duration"]) == (5, (320, 148), 50)
        first = np.asarray(image.convert("RGB")).copy()
        image.seek(4)
        assert not np.array_equal(first, np.asarray(image.convert("RGB")))
    assert main(words) == 2
    assert "exists" in capsys.readouterr().err


def test_moments_go_evenly_along_the_way_and_hold_the_end(run):
    from derod.views.plots.movie import moments

    shown = moments(run, 50)
    assert shown[0] == 0 and (shown[-6:] == 29).all()
    assert (np.diff(shown) >= 0).all() and np.diff(shown).max() == 1
    table = run.table.copy()  # there and back again
    table["end_shortening"][15:] = table["end_shortening"][15:0:-1]
    run._table = table
    assert sorted(set(moments(run, 60))) == list(range(30))


def test_an_mp4_needs_ffmpeg(run, tmp_path, monkeypatch):
    from derod.views.plots import movie

    monkeypatch.setattr(movie.shutil, "which", lambda name: None)
    with pytest.raises(UsageError, match="no ffmpeg"):
        movie.movie(run, tmp_path / "a.mp4", frames=2)
    assert not list(tmp_path.glob("*.mp4"))
