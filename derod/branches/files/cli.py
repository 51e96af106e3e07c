"""``derod branch`` and ``derod compare``: arguments, messages and exit codes."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from derod import terminal
from derod.errors import RecordError, SceneError
from derod.files import lock, outputs
from derod.scene import load_scene
from derod.scene.quantities import read_quantity

if TYPE_CHECKING:
    from derod.branches.files.writing import BranchWriter, Settings
    from derod.branches.half_rod.parameters import Parameters

say, say_done, show = terminal.say, terminal.say_done, terminal.show
GOOD, EXCEEDED, BAD_INPUT, NOT_FOUND = 0, 1, 2, 3


def add_branch_parser(subparsers: Any) -> argparse.ArgumentParser:
    """``derod branch SCENE -o FILE [--paths Ax,3D,L2]`` and ``derod branch FILE --export auto``."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "branch",
        help="compute the solution branches of the paper's boundary-value problem",
        description="Compute the solution branches of the paper's boundary-value problem by "
        "pseudo-arclength continuation and write them to a branch file; or export such a file.",
    )
    parser.add_argument(
        "scene", nargs="?", help="scene file (*.toml), or a branch file with --export"
    )
    parser.add_argument("-o", "--output", help="branch file (*.h5) to write, or the text exported")
    parser.add_argument(
        "--paths", help="names separated by commas: Ax,3D,L2,3D-L2,Pt,Tri1 (default: all)"
    )
    parser.add_argument(
        "--director",
        help="alpha_0, the angle of d_1 to e_x at the clamps of a rod with two bending stiffnesses: "
        "0, or 'pi/2' to bend easily in the other plane (that of clamps.directors, or 0)",
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
    parser.add_argument("--force", action="store_true", help="replace the output if it exists")
    parser.add_argument(
        "--resume", metavar="FILE", help="compute the branches that are missing in FILE"
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
    try:
        return _export(args) if args.export else _compute(args)
    except outputs.RefusedError as error:
        return _complain(f"-o = {error}")
    except SceneError as error:
        return _complain(str(error))


def _compute(args: argparse.Namespace) -> int:
    from derod.branches.files.writing import BranchWriter, Settings
    from derod.branches.half_rod.parameters import Parameters
    from derod.branches.paths.compute import family

    if args.resume is not None:
        return _resume(args)
    if args.scene is None:
        return _complain("SCENE is missing: what the branches are of; or give --resume FILE")
    if args.output is None:
        return _complain("-o FILE is missing: where the branches shall be written")
    names = None
    if args.paths is not None:
        names = tuple(name.strip() for name in args.paths.split(",") if name.strip())
        if not names:
            return _complain(f"--paths = {args.paths!r}: no name in it")
        try:
            _ = [family(name) for name in names]
        except ValueError as error:
            return _complain(f"--{error}")
    outputs.check_output(args.output, force=args.force, inputs=[args.scene], make_folders=False)
    scene = load_scene(args.scene)
    try:
        director = None if args.director is None else read_quantity(args.director)
    except ValueError as error:
        return _complain(
            f"--director = {args.director!r} {error}; allowed: an angle such as 'pi/2'"
        )
    parameters = Parameters.from_scene(scene, director)
    settings = Settings(names, args.tolerance, args.max_step, args.accuracy, not args.no_stability)
    with BranchWriter(
        args.output, parameters, scene.text, settings, overwrite=args.force
    ) as writer:
        return _run(writer, parameters, settings, args.quiet, {})


def _resume(args: argparse.Namespace) -> int:
    """Go on with a branch file that is not complete."""
    from derod.branches.files.record import open_branches
    from derod.branches.files.writing import BranchWriter, Settings

    if args.scene is not None or args.output is not None or args.paths is not None:
        return _complain("--resume FILE goes on in FILE: give no SCENE, no -o and no --paths")
    outputs.check_output(args.resume, force=True)
    with lock.Lock.take(args.resume), open_branches(args.resume) as file:
        if file.complete:
            say_done(f"{args.resume}: is complete: {', '.join(file.names) or 'no branches'}")
            return GOOD
        have = {branch.name: len(branch) for branch in file.values()}
        parameters, text = file.parameters, file.scene_text
        settings = Settings.load(file.settings, args.resume)
    with BranchWriter(args.resume, parameters, text, settings, resume=True) as writer:
        return _run(writer, parameters, settings, args.quiet, have)


def _run(
    writer: BranchWriter,
    parameters: Parameters,
    settings: Settings,
    quiet: bool,
    have: dict[str, int],
) -> int:
    """Compute what is missing and write it, branch by branch; ``have`` counts points by name."""
    from derod.branches.paths.arc import Control
    from derod.branches.paths.compute import compute_branches

    control = Control(
        tolerance=settings.tolerance,
        largest_step=settings.max_step,
        accuracy=settings.accuracy,
    )
    tell = (lambda line: None) if quiet else say_done
    branches, complaints = compute_branches(
        parameters, settings.paths, control, settings.count_modes, tell, writer.put, have
    )
    writer.put(complete=True)
    points = sum(have.values()) + sum(len(branch.points) for branch in branches)
    tell(f"{writer.path}: {len(have) + len(branches)} branches, {points} points")
    for line in complaints:
        say(f"derod branch: {line}")
    return NOT_FOUND if complaints else GOOD


def _export(args: argparse.Namespace) -> int:
    from derod.branches.files.export import auto_table
    from derod.branches.files.record import open_branches

    if args.scene is None:
        return _complain("FILE is missing: the branch file to export")
    if args.output is not None:
        outputs.check_output(args.output, force=args.force, inputs=[args.scene])
    try:
        with open_branches(args.scene) as file:
            text = auto_table(file)
    except RecordError as error:
        return _complain(str(error))
    if args.output is None:
        show(text.removesuffix("\n"))
        return GOOD
    with outputs.replacing(args.output, force=args.force) as passing:
        passing.write_text(text, encoding="utf-8")
    return GOOD


def _complain(message: str) -> int:
    say(f"derod: error: {message}")
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
    parser.set_defaults(command=run_compare, writes=False)
    return parser


def run_compare(args: argparse.Namespace) -> int:
    """Carry out ``derod compare``; returns the exit code."""
    from derod.branches.files.report import compare_files

    return compare_files(args)
