"""The branches that runs are held against, computed once."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

RUNS = Path(__file__).parents[1]


def branches_of(scene: str, paths: str = "Ax,3D,L2,3D-L2") -> Path:
    """Return the branch file of a scene, computed if it is not there."""
    path = RUNS / "out" / f"{scene}-{paths.replace(',', '-')}.h5"
    if not path.exists():
        path.parent.mkdir(exist_ok=True)
        command = [sys.executable, "-m", "derod", "branch", str(RUNS / f"{scene}.toml")]
        subprocess.run(
            [*command, "-o", str(path), "--paths", paths, "--no-stability", "--quiet"], check=True
        )
    return path
