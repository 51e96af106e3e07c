"""The first minutes in a fresh environment: the wheel, `derod push quick`, `derod plot quick.h5`.

    python runs/fresh.py [--wheel dist/derod-...whl]

Builds a wheel without kernels (or takes one), installs it into a new environment in a temporary folder, and
runs the commands there, outside the repository and with an empty cache: once as they come, which compiles,
and once more. Seconds without compilation are those of the second round; with a wheel of
``runs/build_wheel.py`` the first round compiles nothing either. Then the slim environment of
requirements-core.txt: its size, and a push, a resume, branches and a comparison in it. Exit code 1 where a
command fails, a round without compilation takes more than 60 s, or the slim environment is over 550 MB.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path

ROOT = Path(__file__).parents[1]
MOST_SECONDS = 60.0
MOST_SIZE = 550e6
FIRST = ("push quick", "plot quick.h5")
SLIM = (
    "push quick",
    "push --resume quick.h5 --stop 0.7pi",
    "branch quick --paths Ax,3D",
    "compare quick.h5 quick-branches.h5 --tolerance 5e-4",
)


class Place:
    """An environment, and a folder to work in with a home and a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.work = folder / "work"
        self.work.mkdir(parents=True)
        venv.create(folder / "env", with_pip=True)
        kept = {
            name: value
            for name, value in os.environ.items()
            if not name.endswith("CACHE_DIR") and name not in ("PYTHONPATH", "VIRTUAL_ENV")
        }
        self.environment = kept | {
            "HOME": str(folder),
            "XDG_CACHE_HOME": str(folder / "cache"),
            "MPLBACKEND": "agg",
        }

    def pip(self, *words: str) -> None:
        """Install."""
        subprocess.run(
            [self.folder / "env" / "bin" / "python", "-m", "pip", "install", "-q", *words],
            check=True,
            env=os.environ,
            stderr=subprocess.DEVNULL,
        )

    def size(self) -> float:
        """Bytes of the environment, pip's own included, as ``du`` counts them."""
        done = subprocess.run(
            ["du", "-sk", self.folder / "env"], check=True, capture_output=True, text=True
        )
        return 1024.0 * int(done.stdout.split()[0])

    def derod(self, words: str) -> float:
        """Run a command in the work folder, print what it says, and return its seconds."""
        print(f"$ derod {words}", flush=True)
        began = time.perf_counter()
        done = subprocess.run(
            [self.folder / "env" / "bin" / "derod", *words.split()],
            cwd=self.work, env=self.environment, capture_output=True, text=True,
        )  # fmt: skip
        took = time.perf_counter() - began
        lines = (done.stderr + done.stdout).splitlines()
        shown = lines if len(lines) <= 6 else [*lines[:3], "...", *lines[-2:]]
        print("\n".join(f"    {line}" for line in shown))
        if done.returncode:
            raise SystemExit(f"derod {words}: exit code {done.returncode}")
        return took


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--wheel", help="a wheel; one without kernels is built if not given")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="derod-fresh-") as name:
        folder = Path(name)
        wheel = Path(args.wheel).resolve() if args.wheel else build_wheel(folder)
        full = Place(folder / "full")
        began = time.perf_counter()
        full.pip(str(wheel))
        installing, size = time.perf_counter() - began, full.size()
        first = [full.derod(words) for words in FIRST]
        for made in full.work.iterdir():
            made.unlink()
        second = [full.derod(words) for words in FIRST]
        assert (full.work / "quick-path.png").stat().st_size > 10_000
        slim = Place(folder / "slim")
        slim.pip("-r", str(ROOT / "requirements-core.txt"))
        slim.pip("--no-deps", str(wheel))
        slim_size = slim.size()
        shutil.copytree(full.folder / "cache", slim.folder / "cache")
        for words in SLIM:
            slim.derod(words)
    print(f"pip install of the wheel   {installing:7.1f} s, {size / 1e6:.0f} MB")
    for what, took in (("first", first), ("again", second)):
        print(
            f"{what:8} push quick {took[0]:5.1f} s, plot quick.h5 {took[1]:5.1f} s, both {sum(took):5.1f} s"
        )
    print(f"slim environment           {slim_size / 1e6:7.0f} MB")
    return int(sum(second) > MOST_SECONDS or slim_size > MOST_SIZE)


def build_wheel(folder: Path) -> Path:
    """A wheel of the sources, by pip."""
    subprocess.run(
        [
            sys.executable,
            "-m",
            "pip",
            "wheel",
            "-q",
            "--no-deps",
            "-w",
            str(folder / "dist"),
            str(ROOT),
        ],
        check=True,
        stderr=subprocess.DEVNULL,
    )
    (wheel,) = (folder / "dist").glob("*.whl")
    return wheel


if __name__ == "__main__":
    sys.exit(main())
