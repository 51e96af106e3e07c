"""The phase diagram of the paper's rod, l = 10: capillary force against end-shortening, branches on top.

python runs/phase_diagram.py                 # out/f_gamma-delta.h5, branches, docs/images/phase.png
python runs/phase_diagram.py -o my.png

It runs ``derod sweep runs/sweeps/f_gamma-delta.toml``, follows Ax, 3D and L2 at some forces, and draws
both by ``derod plot -k phase``: the project's own commands. Two minutes of CPU time, most of it for the
branches.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import derod

HERE = Path(__file__).parent
FORCES = (10.0, 12.0, 15.0, 18.0, 22.0, 26.0, 30.0, 35.0, 40.0)
DEROD = [sys.executable, "-m", "derod"]


def main() -> None:
    """Make the sweep and the branches that are not there yet, and the picture."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument(
        "-o", "--output", default=str(HERE.parent / "docs" / "images" / "phase.png")
    )
    parser.add_argument("--folder", default="out", help="for the sweep and the branches (out)")
    parser.add_argument("--dpi", default="110")
    args = parser.parse_args()
    folder = Path(args.folder)
    folder.mkdir(exist_ok=True)
    sweep = folder / "f_gamma-delta.h5"
    if not sweep.exists():
        subprocess.run(
            [*DEROD, "sweep", str(HERE / "sweeps/f_gamma-delta.toml"), "-o", str(sweep)], check=True
        )
    files = []
    for force in FORCES:
        file = folder / f"f_gamma-{force:g}.branches.h5"
        if not file.exists():
            scene = derod.Scene("paper-text", {"drop.capillary_force": force})
            derod.branch(scene, file, paths=["Ax", "3D", "L2"], stability=False)
        files.append(str(file))
    picture = ["-o", args.output, "--force", "--dpi", args.dpi]
    subprocess.run([*DEROD, "plot", str(sweep), *files, "-k", "phase", *picture], check=True)


if __name__ == "__main__":
    main()
