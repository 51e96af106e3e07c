"""Where kernels are kept: only where nobody else can have put any, and damaged ones are not run."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

from derod.algebra import cache as _cache
from derod.algebra.cache import is_private

ROOT = Path(__file__).parent.parent
KERNEL = """
import sys
sys.path.insert(0, {folder!r})
from derod.algebra.cache import point_numba_at_own_cache
point_numba_at_own_cache()
import os, stat
import kernels
print(kernels.twice(21), os.environ["NUMBA_CACHE_DIR"])
print(sum(kernels.twice.stats.cache_hits.values()))
"""


def run(tmp_path: Path, **environment: str) -> tuple[int, Path, int]:
    """The answer of a small kernel in a process of its own, its folder, and how often it was cached."""
    (tmp_path / "kernels.py").write_text(
        "from numba import njit\n\n\n@njit(cache=True)\ndef twice(x):\n    return 2 * x\n"
    )
    kept = {name: value for name, value in os.environ.items() if not name.endswith("CACHE_DIR")}
    for name in ("HOME", "XDG_CACHE_HOME", "TMPDIR"):
        kept.pop(name, None)
    done = subprocess.run(
        [sys.executable, "-c", KERNEL.format(folder=str(tmp_path))],
        cwd=ROOT,
        env=kept | environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    answer, folder, hits = done.stdout.split()
    return int(answer), Path(folder), int(hits)


def test_kernels_are_kept_in_the_users_cache(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir(mode=0o755)
    answer, folder, hits = run(tmp_path, HOME=str(home), TMPDIR=str(tmp_path))
    assert (answer, hits) == (42, 0) and folder.parent == home / ".cache" / "derod"
    assert folder.stat().st_mode & 0o777 == folder.parent.stat().st_mode & 0o777 == 0o700
    assert run(tmp_path, HOME=str(home), TMPDIR=str(tmp_path)) == (42, folder, 1)


class Planted:
    """Unpickled, it leaves a file behind."""

    def __init__(self, proof: Path) -> None:
        self.proof = proof

    def __reduce__(self) -> tuple[object, ...]:
        return (os.mkdir, (str(self.proof),))


def plant(folder: Path, proof: Path, name: str) -> None:
    """Put an index that runs code where a kernel's would be looked for."""
    place = folder / name
    place.mkdir(parents=True, exist_ok=True)
    for line in range(1, 12):
        index = place / f"kernels.twice-{line}.py{sys.version_info[0]}{sys.version_info[1]}.nbi"
        index.write_bytes(pickle.dumps(Planted(proof)))


@pytest.mark.parametrize("kind", ["writable by all", "a link", "a file", "under a shared folder"])
def test_nothing_is_run_that_others_could_have_put_there(tmp_path: Path, kind: str) -> None:
    home, tmp, proof = tmp_path / "home", tmp_path / "tmp", tmp_path / "proof"
    home.mkdir()
    home.chmod(0o777 if kind == "under a shared folder" else 0o755)
    (home / ".cache").mkdir()
    tmp.mkdir(mode=0o700)
    _, right, _ = run(tmp_path, HOME=str(tmp_path / "other"), TMPDIR=str(tmp))
    # numba keeps kernels in a folder named after that of their source, within ours
    (inside,) = {path.parent.relative_to(right) for path in right.rglob("*.nbi")}
    for root in (home / ".cache" / "derod", tmp / f"derod-{os.getuid()}" / "derod"):
        elsewhere = tmp_path / "elsewhere" / root.parent.name
        target = elsewhere if kind == "a link" else root
        root.parent.mkdir(parents=True, exist_ok=True)
        if kind == "a file":
            root.write_text("")
            continue
        plant(target / right.name / inside, proof, ".")
        if kind == "a link":
            root.symlink_to(target)
        elif kind == "writable by all":
            root.chmod(0o777)
    if kind == "under a shared folder":
        (tmp / f"derod-{os.getuid()}").chmod(0o777)
    answer, folder, hits = run(tmp_path, HOME=str(home), TMPDIR=str(tmp))
    assert (answer, hits) == (42, 0) and not proof.exists()
    assert not folder.is_relative_to(home) and not folder.exists(), "a fresh one, gone by now"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root makes another user's folder")
def test_a_foreign_home(tmp_path: Path) -> None:
    home = tmp_path / "home"
    home.mkdir()
    os.chown(home, 12345, 12345)
    answer, folder, _ = run(tmp_path, HOME=str(home), TMPDIR=str(tmp_path))
    assert answer == 42 and not folder.is_relative_to(home)


def test_no_home_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(_cache.Path, "home", none)
    monkeypatch.setattr(_cache.tempfile, "gettempdir", lambda: str(tmp_path))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    folder = _cache._made_folder("numba-0")
    assert folder == tmp_path / f"derod-{os.getuid()}" / "derod" / "numba-0"
    assert is_private(folder)


@pytest.mark.parametrize("damage", ["index cut", "index flipped", "data cut", "data flipped"])
def test_what_is_damaged_is_compiled_again(tmp_path: Path, damage: str) -> None:
    home = tmp_path / "home"
    home.mkdir()
    _, folder, _ = run(tmp_path, HOME=str(home))
    (path,) = folder.rglob("*.nbi" if damage.startswith("index") else "*.nbc")
    data = path.read_bytes()
    middle = len(data) // 2
    if damage.endswith("cut"):
        path.write_bytes(data[:middle])
    else:
        path.write_bytes(data[:middle] + bytes([data[middle] ^ 4]) + data[middle + 1 :])
    assert run(tmp_path, HOME=str(home)) == (42, folder, 0), "compiled, not loaded"
    assert run(tmp_path, HOME=str(home)) == (42, folder, 1), "and kept"
