"""``derod branch`` and ``derod compare``: arguments, messages and exit codes."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

GOOD, EXCEEDED, BAD_INPUT, NOT_FOUND = 0, 1, 2, 3


def add_branch_parser(subparsers: Any) -> argparse.ArgumentParser:
    """``derod branch SCENE -o FILE [--paths Ax,3D,L2]`` and ``derod branch FILE --export auto``."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "branch",
        help="compute the solution branches of the paper's boundary-value problem",
        description="Compute the solution branches of the paper's boundary-value problem by "
        "pseudo-arclength continuation and write them to a branch file; or export such a file.",
    )
    parser.add_argument("scene", help="scene file (*.toml), or a branch file with --export")
    parser.add_argument("-o", "--output", help="branch file (*.h5) to write, or the text exported")
    parser.add_argument(
        "--paths", help="names separated by commas: Ax,3D,L2,3D-L2,Pt,Tri1 (default: all)"
    )
    parser.add_argument(
        "--tolerance", type=float, default=1e-10, help="largest residual of any equation (1e-10)"
    )
    parser.add_argument(
        "--max-step", type=float, default=0.22, help="largest step of arclength (0.22)"
    )
    parser.add_argument(
        "--accuracy",
        type=float,
        default=1e-8,
        help="mesh-halving error allowed in a stored point (1e-8)",
    )
    parser.add_argument("--no-stability", action="store_true", help="do not count unstable modes")
    parser.add_argument(
        "--export",
        choices=["auto"],
        help="write a branch file as a table of AUTO's b.-file columns",
    )
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.set_defaults(command=run_branch, writes=True)
    return parser


def run_branch(args: argparse.Namespace) -> int:
    """Carry out ``derod branch``; returns the exit code."""
    for name in ("tolerance", "max_step", "accuracy"):
        value = getattr(args, name)
        if not 0.0 < value < 1.0:
            return _complain(f"--{name.replace('_', '-')} = {value:g}: allowed: between 0 and 1")
    return _export(args) if args.export else _compute(args)


def _compute(args: argparse.Namespace) -> int:
    from derod.branches.arc import Control
    from derod.branches.compute import compute_branches
    from derod.branches.parameters import Parameters
    from derod.branches.record import write_branches
    from derod.errors import DerodError
    from derod.scene import load_scene

    if args.output is None:
        return _complain("-o FILE is missing: where the branches shall be written")
    if not Path(args.output).parent.is_dir():
        return _complain(
            f"-o = {args.output}: no such folder; allowed: a file in an existing folder"
        )
    try:
        scene = load_scene(args.scene)
        parameters = Parameters.from_scene(scene)
    except DerodError as error:
        return _complain(str(error))
    control = Control(tolerance=args.tolerance, largest_step=args.max_step, accuracy=args.accuracy)
    names = None
    if args.paths is not None:
        names = [name.strip() for name in args.paths.split(",") if name.strip()]
        if not names:
            return _complain(f"--paths = {args.paths!r}: no name in it")
    say = (lambda line: None) if args.quiet else (lambda line: print(line, flush=True))
    try:
        branches, complaints = compute_branches(
            parameters, names, control, not args.no_stability, say
        )
    except ValueError as error:
        return _complain(f"--{error}")
    try:
        write_branches(args.output, parameters, branches, scene.text)
    except OSError as error:
        return _complain(f"-o = {args.output}: cannot be written: {error}")
    say(f"{args.output}: {len(branches)} branches, {sum(len(b.points) for b in branches)} points")
    for line in complaints:
        print(f"derod branch: {line}", file=sys.stderr)
    return NOT_FOUND if complaints else GOOD


def _export(args: argparse.Namespace) -> int:
    from derod.branches.export import auto_table
    from derod.branches.record import open_branches
    from derod.errors import DerodError

    try:
        with open_branches(args.scene) as file:
            text = auto_table(file)
    except DerodError as error:
        return _complain(str(error))
    if args.output is None:
        sys.stdout.write(text)
        return GOOD
    try:
        Path(args.output).write_text(text, encoding="utf-8")
    except OSError as error:
        return _complain(f"-o = {args.output}: cannot be written: {error}")
    return GOOD


def _complain(message: str) -> int:
    print(f"derod: error: {message}", file=sys.stderr)
    return BAD_INPUT


def add_compare_parser(subparsers: Any) -> argparse.ArgumentParser:
    """``derod compare RUN BRANCHES [--tolerance X]``."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "compare",
        help="hold a push run against the branches",
        description="For each row of a run: the branch it lies on, and the errors of tension, "
        "energy, wetted length and shape. Exit code 1 where an error exceeds the tolerance.",
    )
    parser.add_argument("run", help="run file (*.h5) of derod push")
    parser.add_argument("branches", help="branch file (*.h5) of derod branch")
    parser.add_argument(
        "--tolerance",
        type=float,
        default=5e-4,
        help="largest relative error of t and E_hat allowed (5e-4); wetted length and "
        "shape: twice that, in D",
    )
    parser.add_argument("--every", type=int, default=1, help="compare every n-th row (1)")
    parser.add_argument("--quiet", action="store_true", help="print the worst of each only")
    parser.set_defaults(command=run_compare, writes=True)
    return parser


def run_compare(args: argparse.Namespace) -> int:
    """Carry out ``derod compare``; returns the exit code."""
    from derod.branches.compare import compare_files

    return compare_files(args)
