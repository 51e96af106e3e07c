"""AUTO-07p on the branches Ax and 3D: built from bifpy's sources, run as its own program.

The sources come with the sdist of bifpy on the package index; its makefile has no optimisation, so they
are built here with -O3. AUTO is given the Jacobian in closed form (half_rod.f90) and a buckled state of
derod's to start from. Ax is followed through its fold with all pitchforks detected (ISP = 2), then 3D is
branched off and followed to where it joins L2.
"""

from __future__ import annotations

import re
import resource
import subprocess
import sys
import tarfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

SDIST = "bifpy==0.3.0"
MODULES = (  # in the order in which they are compiled
    "auto_constants", "nompi", "f2003", "mesh", "support", "io", "ae", "interfaces", "toolboxae",
    "equilibrium", "solvebv", "bvp", "toolboxbv", "homcont", "maps", "floquet", "periodic",
    "optimization", "parabolic", "timeint", "user_c", "utility",
)  # fmt: skip
HERE = Path(__file__).parent
FLAGS = ["-O3", "-march=native", "-w"]


class Settings(NamedTuple):
    """What is scanned."""

    intervals: int  # NTST
    tolerance: float  # EPSL = EPSU; EPSS is ten times that
    step: float  # DSMAX
    collocation: int = 4  # NCOL

    def __str__(self) -> str:
        return f"NTST {self.intervals}, NCOL {self.collocation}, EPS {self.tolerance:.0e}, DSMAX {self.step}"


class Special(NamedTuple):
    """A point that AUTO marked."""

    kind: str  # "BP", "LP", "EP", "UZ"
    delta: float  # D
    tension: float  # K0/D^2


class Answer(NamedTuple):
    """What was found, and the CPU that AUTO took."""

    ax: list[Special]
    three: list[Special]
    cpu: float
    wall: float
    points: int


def build(folder: Path) -> Path:
    """Build AUTO with the half rod into ``folder``; return the program. Raises RuntimeError."""
    program = folder / "half_rod"
    if program.exists() and program.stat().st_mtime > (HERE / "half_rod.f90").stat().st_mtime:
        return program
    folder.mkdir(parents=True, exist_ok=True)
    if not list(folder.glob("bifpy-*.tar.gz")):
        command = ["-m", "pip", "download", "-q", "--no-deps", "--no-build-isolation"]
        run([sys.executable, *command, "--no-binary", ":all:", "-d", ".", SDIST], folder)
    with tarfile.open(next(folder.glob("bifpy-*.tar.gz"))) as archive:
        archive.extractall(folder, filter="data")
    root = next(folder.glob("bifpy-*/auto")).resolve()
    sources = [root / "src" / f"{name}.f90" for name in MODULES]
    sources += sorted(set((root / "src").glob("*.f90")) - set(sources))
    sources += sorted((root / "depends").glob("*.f"))
    sources += [root / "native" / "main.f90", HERE / "half_rod.f90"]
    objects = []
    for source in sources:
        target = f"{source.stem}.o"
        run(
            ["gfortran", *FLAGS, "-I", str(root / "include"), "-c", str(source), "-o", target],
            folder,
        )
        objects.append(target)
    own = ["main.o", "half_rod.o"]  # AUTO has idle ones of all that a user need not write
    run(["ar", "rcs", "libauto.a", *(name for name in objects if name not in own)], folder)
    run(["gfortran", *own, "libauto.a", "-o", program.name], folder)
    return program


def run(command: list[str], folder: Path) -> None:
    """Run a command there; raise RuntimeError with its last words where it fails."""
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    except FileNotFoundError as error:
        raise RuntimeError(f"{command[0]} is not installed") from error
    if done.returncode:
        raise RuntimeError(f"{command[0]}: {(done.stderr or done.stdout).strip()[-300:]}")


def start_text(state, parameters) -> str:
    """Return a half-rod state of ``derod.branches`` as AUTO's start reads it."""
    inner, eta, nodes = state.inner, state.eta, state.nodes
    inside = np.concatenate([[0.0], np.cumsum(eta[:inner])])
    outside = np.concatenate([[0.0], np.cumsum(eta[inner:])])
    t = np.union1d(inside, outside)
    wet = np.array([np.interp(t, inside, nodes[: inner + 1, k]) for k in range(10)])
    dry = np.array([np.interp(t, outside, nodes[inner + 1 :, k]) for k in range(7)])
    cx, cz, u3, sigma, delta = state.scalars[:5]
    p = parameters
    head = [
        cx, cz, u3, sigma, delta, nodes[-1, 7], nodes[-1, 9], p.wall_strength, p.wall_softness,
        p.twisting, p.length, p.capillary_force,
    ]  # fmt: skip
    rows = np.column_stack([t, wet.T, dry.T])
    lines = [" ".join(map(repr, map(float, head))), str(len(rows))]
    return "\n".join([*lines, *(" ".join(map(repr, map(float, row))) for row in rows)]) + "\n"


def constants(settings: Settings, **more: object) -> str:
    """Return AUTO's constants of one continuation, in its own format."""
    values = {
        "NDIM": 17, "IPS": 4, "IRS": 0, "ILP": 1, "ICP": [5, 1, 2, 3, 4, 6, 7],
        "NTST": settings.intervals, "NCOL": settings.collocation, "IAD": 3, "ISP": 2, "ISW": 1,
        "IPLT": 0, "NBC": 23, "NINT": 0, "NMX": 3000, "RL0": -10.0, "RL1": 20.0, "A0": -1e9, "A1": 1e9,
        "NPR": 100000, "MXBF": 0, "IID": 0, "ITMX": 9, "ITNW": 7, "NWTN": 3, "JAC": 1,
        "EPSL": settings.tolerance, "EPSU": settings.tolerance, "EPSS": 10 * settings.tolerance,
        "DS": 0.01, "DSMIN": 1e-5, "DSMAX": settings.step, "IADS": 1, "NPAR": 12, "THL": {}, "THU": {},
    } | more  # fmt: skip
    return "".join(f"{key} = {value!r}\n".replace("e-", "E-") for key, value in values.items())


def specials(text: str) -> tuple[list[Special], int]:
    """Return the marked points of a fort.7, and how many points it has."""
    kinds = {1: "BP", 3: "BP", 6: "BP", 2: "LP", 5: "LP", 4: "UZ", -4: "UZ", 9: "EP", -9: "MX"}
    rows = [line.split() for line in text.splitlines() if re.match(r"\s+[1-9-]", line)]
    found = []
    for row in rows:
        code = int(row[2])
        if code:
            # branch, point, type, label, delta, norm, then c_x ... T
            found.append(Special(kinds.get(code, str(code)), float(row[4]), float(row[-1])))
    return found, len(rows)


def solve(program: Path, start: str, settings: Settings, fold: float) -> Answer:
    """Follow Ax past its fold near delta = ``fold`` (D), then 3D off its first pitchfork."""
    folder = program.parent
    (folder / "start.txt").write_text(start)
    cpu, wall, points = 0.0, 0.0, 0
    turn = ["LP1"]
    ax, spent, number = once(program, constants(settings, SP=turn, RL1=1.05 * fold))
    cpu, wall, points = cpu + spent[0], wall + spent[1], points + number
    (folder / "fort.3").write_text((folder / "fort.8").read_text())
    label = first_label(folder / "fort.8", "BP")
    three: list[Special] = []
    if label:
        text = constants(settings, IRS=label, ISW=-1, SP=["BP1"], RL1=8.0)
        three, spent, number = once(program, text)
        cpu, wall, points = cpu + spent[0], wall + spent[1], points + number
    return Answer(ax, three, cpu, wall, points)


def first_label(solutions: Path, kind: str) -> int | None:
    """Return the label of the first solution of a kind in a fort.8."""
    codes = {"BP": (1, 6)}[kind]
    lines = solutions.read_text().splitlines()
    at = 0
    while at < len(lines):
        head = lines[at].split()
        if int(head[2]) in codes:
            return int(head[3])
        at += int(head[8]) + 1
    return None


def once(program: Path, text: str) -> tuple[list[Special], tuple[float, float], int]:
    """Run AUTO once; return its marked points, (CPU, wall), and how many points it took."""
    folder = program.parent
    (folder / "fort.2").write_text(text)
    for name in ("fort.7", "fort.8", "fort.9"):
        (folder / name).unlink(missing_ok=True)
    before, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(
        [str(program.resolve())], cwd=folder, capture_output=True, timeout=300, check=False
    )
    wall = time.perf_counter() - clock
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    found, number = specials((folder / "fort.7").read_text())
    return (
        found,
        (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall),
        number,
    )
