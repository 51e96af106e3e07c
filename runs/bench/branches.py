"""The branches that runs are held against, computed once."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

RUNS = Path(__file__).parents[1]


def branches_of(scene: str) -> Path:
    """Return the branch file of a scene, computed if it is not there."""
    path = RUNS / "out" / f"{scene}-branches.h5"
    if not path.exists():
        path.parent.mkdir(exist_ok=True)
        command = [sys.executable, "-m", "derod", "branch", str(RUNS / f"{scene}.toml")]
        paths = ["--paths", "Ax,3D,L2,3D-L2", "--no-stability", "--quiet"]
        subprocess.run([*command, "-o", str(path), *paths], check=True)
    return path
