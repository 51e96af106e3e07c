"""``derod trace`` and ``derod explore`` as the command line offers them."""

from __future__ import annotations

import argparse
from importlib import import_module
from typing import Any

from derod.exits import MEANINGS


def add_trace_parser(commands: Any) -> None:
    """``derod trace FILE [--at X] [--control C] [--to A,B]``."""
    parser = commands.add_parser(
        "trace",
        help="follow equilibria, stable or not, through folds and bifurcations",
        description="Follow a path of equilibria of the discrete rod by pseudo-arclength: from the straight "
        "rod of a scene, where it buckles; from an increment of a run; or from a state of a branch file. "
        "Folds, branch points and joints are located, and unstable modes counted at every point.",
        epilog=MEANINGS,
    )
    parser.add_argument(
        "file", metavar="FILE", help="scene (a file or a shipped one), run or branch file"
    )
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="diagram file to write (SCENE-trace.h5)"
    )
    parser.add_argument(
        "--mode", type=int, default=1, metavar="K", help="buckling mode of the straight rod (1)"
    )
    parser.add_argument(
        "--at",
        metavar="X",
        help="end-shortening of the run's or branch's state to start from, e.g. '1.5 pi'",
    )
    parser.add_argument(
        "--path", metavar="NAME", help="branch of a branch file to start from, e.g. Pt"
    )
    parser.add_argument(
        "--control",
        default="end_shortening",
        metavar="C",
        help="what changes along the path (end_shortening)",
    )
    parser.add_argument(
        "--to", metavar="A,B", help="range of the control to stay within, e.g. '0, 2.5 pi'"
    )
    parser.add_argument(
        "--switch", action="store_true", help="follow what meets the path at its branch points, too"
    )
    parser.add_argument(
        "--edges",
        type=int,
        metavar="N",
        help="edges of the discrete rod (of a scene or branch file)",
    )
    parser.set_defaults(command=_run("trace"), writes=True)
    _add_common(parser, energy=None, points=1000)


def add_explore_parser(commands: Any) -> None:
    """``derod explore SCENE``."""
    parser = commands.add_parser(
        "explore",
        help="find all paths of equilibria of a scene within limits",
        description="Start at the straight rod, switch at every bifurcation, keep each path once up to the "
        "symmetries of the scene, and look for disconnected paths under a stronger capillary force.",
        epilog=MEANINGS,
    )
    parser.add_argument(
        "scene", nargs="?", metavar="SCENE", help="scene file (TOML), or a shipped one"
    )
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="diagram file to write (SCENE-diagram.h5)"
    )
    parser.add_argument(
        "--resume", metavar="FILE", help="go on with an exploration that was stopped"
    )
    parser.add_argument("--to", metavar="A,B", help="range of the end-shortening, e.g. '0, 2.5 pi'")
    parser.add_argument("--paths", type=int, default=60, metavar="N", help="paths at most (60)")
    parser.add_argument(
        "--modes", type=int, default=3, metavar="K", help="buckling modes of the straight rod (3)"
    )
    parser.add_argument(
        "--strong", type=float, default=6.0, metavar="X",
        help="times the capillary force, to find disconnected paths; 0: do not look (6)",
    )  # fmt: skip
    parser.add_argument(
        "--at",
        metavar="X",
        help="also list the states at an end-shortening, by energy, with barriers",
    )
    parser.add_argument("--edges", type=int, metavar="N", help="edges of the discrete rod")
    parser.set_defaults(command=_run("explore"), writes=True)
    _add_common(parser, energy=40.0, points=400)


def _add_common(parser: argparse.ArgumentParser, energy: float | None, points: int) -> None:
    words = "no limit" if energy is None else f"{energy:g}"
    parser.add_argument(
        "--energy", type=float, default=energy, metavar="E", help=f"E_hat at most, K0/D ({words})"
    )
    parser.add_argument(
        "--points",
        type=int,
        default=points,
        metavar="N",
        help=f"points of a path at most ({points})",
    )
    parser.add_argument("--force", action="store_true", help="replace the output if it exists")
    parser.add_argument("--quiet", action="store_true", help="show nothing but errors")


def _run(name: str) -> Any:
    """The command ``name``, imported when it is called."""
    return lambda args: getattr(import_module("derod.cli.tracing_work"), name)(args)
