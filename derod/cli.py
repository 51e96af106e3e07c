"""The command ``derod``: its parser, and what the exit codes mean.

Nothing heavy is imported here, so that ``derod --help`` answers at once; the commands import what
they need when they run.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from derod import __version__
from derod.errors import DerodError, RecordError
from derod.exits import BAD_INPUT, DONE, INTERRUPTED, NOT_REACHED

METHODS = ("implicit", "elliptic", "fire", "kinetic")

COMMANDS: tuple[str, ...] = (
    "derod.branches.cli:add_branch_parser",
    "derod.branches.cli:add_compare_parser",
    "derod.stream.cli:add_view_parser",
    "derod.plots.cli:add_plot_parser",
    "derod.plots.cli:add_movie_parser",
    "derod.export.cli:add_export_parser",
)
"""More commands, as "module:function"; the function is given the sub-parsers to add itself to."""

PUSH_WATCHERS: tuple[str, ...] = ("derod.stream.cli",)
"""Modules that add options to ``derod push`` and observers to the push.

Each has ``add_push_options(parser)`` and ``make_observers(args, scene) -> list[Observer]``.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    0 the push reached its stop, 2 bad input, 3 it did not reach it or could not be recorded,
    130 interrupted.
    """
    args = build_parser().parse_args(arguments)
    try:
        return int(args.command(args))
    except BrokenPipeError:  # the reader of our output has had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except DerodError as error:
        print(f"derod: {error}", file=sys.stderr)
        return NOT_REACHED if args.writes and isinstance(error, RecordError) else BAD_INPUT
    except KeyboardInterrupt:
        print("derod: interrupted", file=sys.stderr)
        return INTERRUPTED


def build_parser() -> argparse.ArgumentParser:
    """The parser of all commands; ``args.command(args)`` runs the one that was given."""
    parser = argparse.ArgumentParser(
        prog="derod", description="Push an elastic rod into a liquid drop and watch it coil."
    )
    parser.add_argument("--version", action="version", version=f"derod {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    _add_push(commands)
    _add_check(commands)
    _add_info(commands)
    for place in COMMANDS:
        module, _, function = place.partition(":")
        getattr(import_module(module), function)(commands)
    return parser


def _add_push(commands: Any) -> None:
    parser = commands.add_parser(
        "push",
        help="push the rod of a scene and record every settled increment",
        description="Push the rod of SCENE and record every settled increment in FILE.",
        epilog="Exit codes: 0 reached the stop, 2 bad input, 3 did not reach it, 130 interrupted.",
    )
    parser.add_argument("scene", nargs="?", metavar="SCENE", help="scene file (TOML)")
    parser.add_argument("-o", "--output", metavar="FILE", help="run file to write (HDF5)")
    parser.add_argument("--force", action="store_true", help="replace FILE if it exists")
    parser.add_argument("--resume", metavar="FILE", help="go on with a run that has ended")
    parser.add_argument("--method", metavar="M", help=f"relaxation: {', '.join(METHODS)}")
    parser.add_argument("--edges", type=int, metavar="N", help="edges of the discrete rod")
    parser.add_argument(
        "--stop",
        metavar="X",
        help="end-shortening to stop at, e.g. '2.8 pi', or turning points '2 pi, 1 pi'",
    )
    parser.add_argument(
        "--extrapolate",
        action="store_true",
        help="push once more on half the edges: better values, and estimated errors",
    )
    parser.add_argument("--quiet", action="store_true", help="show nothing but errors")
    for module in PUSH_WATCHERS:
        import_module(module).add_push_options(parser)
    parser.set_defaults(command=_run("push"), writes=True, watchers=PUSH_WATCHERS)


def _add_check(commands: Any) -> None:
    parser = commands.add_parser("check", help="check a scene and print its dimensionless groups")
    parser.add_argument("scene", metavar="SCENE", help="scene file (TOML)")
    parser.set_defaults(command=_run("check"), writes=False)


def _add_info(commands: Any) -> None:
    parser = commands.add_parser("info", help="say what a run did: landings, events, outcome")
    parser.add_argument("file", metavar="FILE", help="run file, finished or not")
    parser.set_defaults(command=_run("info"), writes=False)


def _run(name: str) -> Any:
    """The command ``name`` of ``derod.commands``, imported when it is called."""
    return lambda args: getattr(import_module("derod.commands"), name)(args)


if __name__ == "__main__":
    sys.exit(main())
